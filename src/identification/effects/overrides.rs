//! Effects of values that are exactly 1 unless they were changed: override switches and the recorder's clock.

use crate::identification::effects::effect::{Context, Effect, Hypothesis};
use crate::identification::effects::parameters;
use crate::identification::effects::report::{Quantity, RATIO, Reported};
use crate::identification::fit::FreeParameter;
use crate::machine::Machine;

fn ratio(value: f64) -> Vec<(Quantity, Reported)> {
    vec![RATIO.number(value)]
}

/// Largest rapid override of a control, as a ratio: panels end at 100 %.
const MAX_RAPID_OVERRIDE_RATIO: f64 = 1.0;

/// Standard deviation of the feed override that a hypothesis expects, as a ratio. It is so large that every observation outweighs
/// it.
const FEED_OVERRIDE_DEVIATION_RATIO: f64 = 10.0;

pub fn feed(effect: Effect, context: &Context) -> Vec<Hypothesis> {
    let parts = [0.2, 0.4, 0.6, 0.75, 0.9, 0.97, 0.99, 1.01, 1.03, 1.1, 1.25, 1.5];
    let trials = parts.map(|part| part * context.machine.overrides.feed).to_vec();
    vec![Hypothesis::single(effect, free_feed_override(context.machine), trials, ratio)]
}

/// Returns the free feed override of a hypothesis, which expects the override of the machine. Where other limits hold, a larger
/// override changes nothing, and only this expectation keeps a fit from the largest one.
pub fn free_feed_override(machine: &Machine) -> FreeParameter {
    parameters::FEED_OVERRIDE.tried().expected(machine.overrides.feed, FEED_OVERRIDE_DEVIATION_RATIO)
}

pub fn rapid(effect: Effect, context: &Context) -> Vec<Hypothesis> {
    if !context.has_rapid {
        return Vec::new();
    }
    let own = context.machine.overrides.rapid;
    let largest = MAX_RAPID_OVERRIDE_RATIO.max(own);
    let trials = [0.05, 0.1, 0.2, 0.35, 0.5, 0.65, 0.8, 0.9, 1.1, 1.3].map(|part| part * own);
    let possible = trials.into_iter().filter(|trial| *trial <= largest).collect();
    let freed = parameters::RAPID_OVERRIDE.tried_around(largest);
    vec![Hypothesis::single(effect, freed, possible, ratio)]
}

pub fn recorder_clock(effect: Effect, _: &Context) -> Vec<Hypothesis> {
    let freed = parameters::CLOCK_RATIO.tried();
    vec![Hypothesis::single(effect, freed, vec![0.972, 0.98, 0.99, 1.01, 1.02, 1.028], ratio)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identification::effects::table::RAPID_OVERRIDE;

    #[test]
    fn rapids_are_overridden_downwards_only() {
        for (own, largest) in [(1.0, 1.0), (0.5, 1.0), (1.2, 1.2)] {
            let mut machine = Machine::default();
            machine.overrides.rapid = own;
            let context = Context { has_rapid: true, ..Context::new(&machine, &[]) };
            let [hypothesis] = &rapid(RAPID_OVERRIDE, &context)[..] else { panic!("one switch") };
            assert_eq!(hypothesis.freed[0].bounds.1, largest);
            assert!(hypothesis.trials.iter().all(|trial| trial[0] <= largest), "{:?}", hypothesis.trials);
        }
    }
}
