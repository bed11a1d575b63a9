//! Effects of the filter chain: its time constants and the number of its filters.

use crate::identification::effects::effect::{Context, Effect, Hypothesis};
use crate::identification::effects::parameters;
use crate::identification::effects::report::{FILTERS, Reported, TIME_CONSTANT, TIME_CONSTANTS};
use crate::machine::TimeConstants;

/// Returns the number and the time constant (s) of the filters; `None` unless the machine gives them one time
/// constant.
fn equal(context: &Context) -> Option<(usize, f64)> {
    let interpolator = &context.machine.interpolator;
    match interpolator.time_constants {
        TimeConstants::Equal(constant) => Some((interpolator.filters, constant)),
        _ => None,
    }
}

pub fn time_constants(effect: Effect, context: &Context) -> Vec<Hypothesis> {
    let of = |(_, constant): (usize, f64)| {
        let freed = parameters::TIME_CONSTANT.tried();
        let ratios = [0.3, 0.5, 0.7, 0.85, 0.95, 1.05, 1.15, 1.3, 1.6, 2.0, 3.0];
        let trials = ratios.iter().map(|ratio| ratio * constant).collect();
        Hypothesis::single(effect, freed, trials, |value| vec![TIME_CONSTANT.number(value)])
    };
    equal(context).map(of).into_iter().collect()
}

/// Returns the hypotheses of more or fewer filters: each as long as before, or with the same total delay.
pub fn orders(effect: Effect, context: &Context) -> Vec<Hypothesis> {
    let Some((order, constant)) = equal(context) else { return Vec::new() };
    let of = |keeps_delay: bool| {
        let freed = parameters::FILTERS.tried().with(move |machine, value| {
            let other = value.round();
            machine.interpolator.filters = other as usize;
            if keeps_delay {
                let delay = constant * order as f64;
                machine.interpolator.time_constants = TimeConstants::Equal(delay / other);
            }
        });
        let orders = parameters::FILTERS.guesses.iter().copied();
        let trials = orders.filter(|other| *other != order as f64).collect();
        let report = |value: f64| vec![FILTERS.number(value.round())];
        let variant = if keeps_delay { "" } else { "each as long" };
        Hypothesis::single(effect, freed, trials, report).variant(variant).at_trials_only()
    };
    vec![of(false), of(true)]
}

/// Returns the hypothesis of one longer filter and shorter others, with the same total delay.
pub fn unequal(effect: Effect, context: &Context) -> Vec<Hypothesis> {
    let Some((order, constant)) = equal(context).filter(|(order, _)| 1 < *order) else { return Vec::new() };
    let split = move |spread: f64| {
        let rest = order as f64 - 1.0;
        let longest = constant * (1.0 + rest * spread);
        let mut constants = vec![longest];
        constants.resize(order, constant * (1.0 - spread));
        constants
    };
    let freed = parameters::FILTER_SPREAD.tried().with(move |machine, spread| {
        machine.interpolator.time_constants = TimeConstants::Unequal(split(spread));
    });
    let trials = vec![0.04, 0.08, 0.15, 0.3, 0.45, 0.6, 0.8];
    let report = move |spread| vec![(TIME_CONSTANTS, Reported::List(split(spread)))];
    vec![Hypothesis::single(effect, freed, trials, report)]
}
