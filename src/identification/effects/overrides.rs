//! Effects of values that are exactly 1 unless they were changed: override switches and the recorder's clock.

use crate::identification::effects::effect::{Context, Effect, Hypothesis};
use crate::identification::effects::report::{Quantity, RATIO, Reported};
use crate::identification::fit::{FreeParameter, VariationScale};
use crate::machine::Handle;

/// Bounds of the rate of a recorder's clock, as a ratio to true time. Quartz is accurate to 2e-4. A row that counts
/// ticks of a timer is off by the rounding of the tick, at worst 16 ms for the 15.625 ms of Windows.
const CLOCK_BOUNDS: (f64, f64) = (0.97, 1.03);

fn ratio(value: f64) -> Vec<(Quantity, Reported)> {
    vec![(RATIO, Reported::Number(value))]
}

/// Returns the hypothesis of a switch that the machine has at `own`, tried at `parts` of that value.
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
