//! What is exactly 1 unless someone changed it: override switches and the recorder's clock.

use crate::identification::effects::effect::{Context, Effect, Hypothesis};
use crate::identification::effects::report::{Quantity, RATIO, Reported};
use crate::identification::fit::{FreeParameter, VariationScale};
use crate::machine::Handle;

/// How far a recorder's clock may be off: quartz is to 2e-4, and a row that counts ticks of a timer is off by its
/// rounding, 16 ms for the 15.625 ms of Windows being the worst in use.
const CLOCK_BOUNDS: (f64, f64) = (0.97, 1.03);

fn ratio(value: f64) -> Vec<(Quantity, Reported)> {
    vec![(RATIO, Reported::Number(value))]
}

/// A switch that a machine has at `own`, tried at parts of that.
fn switch(effect: Effect, key: &str, own: f64, parts: &[f64]) -> Hypothesis {
    let freed = FreeParameter::new(Handle::number(key), own, (0.01, 2.0), VariationScale::Ratio).exact();
    Hypothesis::single(effect, freed, parts.iter().map(|part| part * own).collect(), ratio)
}

pub fn feed(effect: Effect, context: &Context) -> Vec<Hypothesis> {
    let parts = [0.2, 0.4, 0.6, 0.75, 0.9, 0.97, 0.99, 1.01, 1.03, 1.1, 1.25, 1.5];
    vec![switch(effect, "override.feed", context.machine.overrides.feed, &parts)]
}

pub fn rapid(effect: Effect, context: &Context) -> Vec<Hypothesis> {
    let parts = [0.05, 0.1, 0.2, 0.35, 0.5, 0.65, 0.8, 0.9, 1.1, 1.3];
    let of = || switch(effect, "override.rapid", context.machine.overrides.rapid, &parts);
    context.has_rapid.then(of).into_iter().collect()
}

pub fn recorder_clock(effect: Effect, _: &Context) -> Vec<Hypothesis> {
    let freed =
        FreeParameter::new(Handle::number("recorder.clock_ratio"), 1.0, CLOCK_BOUNDS, VariationScale::Ratio)
            .exact();
    vec![Hypothesis::single(effect, freed, vec![0.972, 0.98, 0.99, 1.01, 1.02, 1.028], ratio)]
}
