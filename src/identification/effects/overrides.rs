//! Effects of values that are exactly 1 unless they were changed: override switches and the recorder's clock.

use crate::identification::effects::effect::{Context, Effect, Hypothesis};
use crate::identification::effects::parameters::{self, Adjustable};
use crate::identification::effects::report::{Quantity, RATIO, Reported};

fn ratio(value: f64) -> Vec<(Quantity, Reported)> {
    vec![RATIO.number(value)]
}

/// Returns the hypothesis of a switch that the machine has at `own`, tried at `parts` of that value.
fn switch(effect: Effect, switch: Adjustable, own: f64, parts: &[f64]) -> Hypothesis {
    Hypothesis::single(effect, switch.tried(), parts.iter().map(|part| part * own).collect(), ratio)
}

pub fn feed(effect: Effect, context: &Context) -> Vec<Hypothesis> {
    let parts = [0.2, 0.4, 0.6, 0.75, 0.9, 0.97, 0.99, 1.01, 1.03, 1.1, 1.25, 1.5];
    vec![switch(effect, parameters::FEED_OVERRIDE, context.machine.overrides.feed, &parts)]
}

pub fn rapid(effect: Effect, context: &Context) -> Vec<Hypothesis> {
    let parts = [0.05, 0.1, 0.2, 0.35, 0.5, 0.65, 0.8, 0.9, 1.1, 1.3];
    let of = || switch(effect, parameters::RAPID_OVERRIDE, context.machine.overrides.rapid, &parts);
    context.has_rapid.then(of).into_iter().collect()
}

pub fn recorder_clock(effect: Effect, _: &Context) -> Vec<Hypothesis> {
    let freed = parameters::CLOCK_RATIO.tried();
    vec![Hypothesis::single(effect, freed, vec![0.972, 0.98, 0.99, 1.01, 1.02, 1.028], ratio)]
}
