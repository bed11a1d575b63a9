//! The acceptance tests that a candidate must pass to be named as a cause.
//!
//! | acceptance test | what must hold |
//! |---|---|
//! | likelihood | the cost falls by more than `MIN_COST_REDUCTION` + k ln n, n sections of the path, not samples |
//! | own share | the candidate still lowers the cost by that much after the assumed values fitted beside it are set without it |
//! | held out | with the values that the others give a section is better, in most sections where it acts |
//! | place | where it explains little of all, it fits where it is better than anywhere else it is shifted to |
//! | feedrate | feedrates differ hardly more with it than without it, all in all and where it acts; a halt changes none |
//! | chance | a wait at a word is longer or shorter than the cycles of a PLC make it from run to run |
//! | sense | a limit that is lower than before costs time |
//! | size | it explains more than `MIN_EXPLAINED_SHARE` of the cycle time, `MIN_LOST_TIME_S` s, and `MAX_REMAINING_PART` of the time explained |
//!
//! Causes that these runs cannot separate from the next cause are alike to it: other effects, or the same effect of
//! another axis, that fit as well, except perhaps at one place; or that fit nearly as well and have closer feedrates. A
//! velocity limit that acts in rapids alone is also alike to an override of rapids, if no rapid rate is known.

use crate::identification::diagnosis::cause::{AcceptedCause, UNSURE, odds};
use crate::identification::diagnosis::evidence::{Looked, assumed, with_all};
use crate::identification::diagnosis::gates::{self, HeldOut};
use crate::identification::diagnosis::speeds::Speeds;
use crate::identification::diagnosis::verdict::MAX_REMAINING_PART;
use crate::identification::diagnosis::{Candidate, Evidence, MIN_LOST_TIME_S, regions, standing};
use crate::identification::effects::{
    AXIS_VELOCITY_LIMIT, FEED_HOLD, FILTER_TIME_CONSTANT, Hypothesis, MIN_EXPLAINED_SHARE, Nature,
    RAPID_OVERRIDE, UNEQUAL_FILTERS, UNMODELLED_WAIT,
};
use crate::identification::fit::{FreeParameter, Run, VariationScale};
use crate::machine::Machine;
use crate::simulation::feed::LINUXCNC_SERVO_PERIOD_S;
use crate::simulation::feed::limits::requested_feedrate;
use crate::simulation::toolpath::Segment;

/// Largest part of the time that the earlier causes explain which a further cause may cancel.
const MAX_CANCELLED_PART: f64 = 0.5;
/// Weight of the time that a cause adds in some places and saves in others, against its net time.
const NETTED: f64 = 0.2;
/// Least gain, as a part of the remaining cost, from which on a cause needs no shift test.
const MIN_GAIN_WITHOUT_SHIFT_TEST: f64 = 0.5;
/// Largest difference between the costs of two candidates that these runs cannot separate, in multiples of the
/// dispersion of the residuals.
const MAX_ALIKE_COST: f64 = 6.0;
/// Least part of the gain of the better of two candidates that is outside a single place, if that place alone is not to
/// separate them.
const MIN_GAIN_SHARE_ELSEWHERE: f64 = 0.5;
/// Largest part of the difference of their costs that then remains outside that place.
const MAX_DIFFERENCE_SHARE_ELSEWHERE: f64 = 0.1;
/// Largest difference of their costs, as a part of the gain of the better one, that feedrates which are closer with the
/// other outweigh.
const MAX_CONTRADICTED_SHARE: f64 = 0.1;
/// Least gain of a feed hold, as a part of the gain of a wait at the same place, at which the runs cannot separate them on a
/// control that blends corners. Such a control brakes less hard than the simulated hold.
const MIN_HOLD_GAIN_SHARE: f64 = 0.5;
/// Largest difference, as a ratio, between a setting and the believed one at which the setting counts as unchanged.
/// Overrides and the clock ratio need no such range: their believed value is exactly 1.
const MAX_UNCHANGED_RATIO: f64 = 6e-3;
/// Half of the smallest step of an override switch, as a ratio.
const HALF_A_STEP: f64 = 5e-3;

/// Returns the cost of causes that were fitted together, plus their price.
pub fn priced(runs: &[Run], together: &[&Candidate]) -> f64 {
    together.first().map_or(0.0, |first| first.cost) + prices(runs, together.iter().copied())
}

/// Returns the sum of the prices of causes.
pub fn prices<'a>(runs: &[Run], causes: impl Iterator<Item = &'a Candidate>) -> f64 {
    causes.map(|candidate| price(runs, candidate)).sum()
}

/// Returns the price of a cause: that of its parameters and that of its rarity.
fn price(runs: &[Run], candidate: &Candidate) -> f64 {
    gates::price(runs, candidate.values.len()) + candidate.hypothesis.rarity
}

/// Returns a candidate as an accepted cause, with the causes named before it. `None` if it fails an acceptance test.
/// `rest` holds the candidates that are not as good.
pub fn passed(
    base: &Machine,
    before: &[Candidate],
    looked: &Looked,
    fine: &Evidence,
    (candidate, others): (&Candidate, &[Candidate]),
    rest: &[(Candidate, Vec<Candidate>)],
) -> Option<(AcceptedCause, Vec<Candidate>)> {
    let runs = looked.runs;
    let current = &with_all(base, before);
    let price = price(runs, candidate);
    if fine.cost(current) - candidate.cost <= price {
        return None;
    }
    // The noise that the refined candidate leaves decides the last digits of its values, so it is fitted once more.
    let last = looked.evidence(&with_all(base, &together(candidate, others)));
    let (candidate, others) = last.refined(base, candidate, others);
    let gain = last.cost(current) - candidate.cost;
    if gain <= price {
        return None;
    }
    let with = with_all(base, &together(&candidate, &others));
    if !explains_more_than_beside(&candidate, current, &last, price) {
        return None;
    }
    let whole: f64 = runs.iter().map(|run| run.plan(current).cycle_time()).sum();
    let explained = regions::moved(base, current, runs).0;
    if weight(current, &with, runs)
        < MIN_LOST_TIME_S.max(MIN_EXPLAINED_SHARE * whole).max(MAX_REMAINING_PART * explained.abs())
    {
        return None;
    }
    let further = regions::moved(current, &with, runs).0;
    if !is_beyond_plc(&candidate, current, further) || is_limit_that_saves(&candidate, current, further) {
        return None;
    }
    // A cause that nearly cancels the others was fitted to the error of their laws.
    if further * explained < 0.0 && MAX_CANCELLED_PART * explained.abs() < further.abs() {
        return None;
    }
    if gain < MIN_GAIN_WITHOUT_SHIFT_TEST * candidate.cost && !gates::stays_in_place(&last, current, &with) {
        return None;
    }
    let held_out = gates::held_out(&last, base, before, (&candidate, &others));
    if held_out.as_ref().is_some_and(|held_out| !held_out.holds()) {
        return None;
    }
    let dispersion = last.dispersion(&with);
    let alike = alike(&last, base, current, (&candidate, &with), (gain, dispersion), rest);
    let confidence = held_out.as_ref().map_or(1.0, HeldOut::share) / (1.0 + alike.len() as f64);
    let found = AcceptedCause { candidate, alike, held_out, confidence };
    (UNSURE <= confidence * odds(gain / dispersion, price)).then_some((found, others))
}

/// Returns the ids of the causes that the runs cannot separate from a candidate, which lowers the cost by `gain`: those of
/// `rest`, and an override of rapids. `with` is the machine with the candidate, and `dispersion` that of its residuals.
fn alike(
    last: &Evidence,
    base: &Machine,
    current: &Machine,
    (candidate, with): (&Candidate, &Machine),
    (gain, dispersion): (f64, f64),
    rest: &[(Candidate, Vec<Candidate>)],
) -> Vec<String> {
    // The noise decides the last digits of the others too, so they are fitted once more.
    let is_alike = |(other, others): &&(Candidate, Vec<Candidate>)| {
        let (other, others) = last.refined(base, other, others);
        let apart = other.cost - candidate.cost;
        if apart < MAX_ALIKE_COST * dispersion {
            return true;
        }
        // A simulated hold brakes with the whole acceleration where corners are blends. Beside a wait, that error decides.
        let effects = [&candidate.hypothesis, &other.hypothesis].map(|own| own.effect);
        if base.interpolator.junction.blends_in_time()
            && effects == [UNMODELLED_WAIT, FEED_HOLD]
            && apart < (1.0 - MIN_HOLD_GAIN_SHARE) * gain
        {
            return true;
        }
        let rival = with_all(base, &together(&other, &others));
        // Where the times prefer one and the feedrates the other, the error of the model decides.
        if apart < MAX_CONTRADICTED_SHARE * gain && !Speeds::of(&rival, last.runs).are_kept(with) {
            return true;
        }
        // What tells two apart in a single place is how their laws begin or end there, which no model knows so well.
        let rest = gates::without_worst(last, with, &rival);
        let cost = rest.cost(with);
        let acts_elsewhere = || MIN_GAIN_SHARE_ELSEWHERE * gain < rest.cost(current) - cost;
        let still_apart = || rest.refined(base, &other, &others).0.cost - cost;
        acts_elsewhere()
            && still_apart() < (MAX_ALIKE_COST * dispersion).min(MAX_DIFFERENCE_SHARE_ELSEWHERE * apart)
    };
    let rivals = rest.iter().filter(|(other, _)| other.hypothesis.is_rival_of(&candidate.hypothesis));
    let alike = rivals.filter(is_alike).map(|(other, _)| id_beside(&other.hypothesis, &candidate.hypothesis));
    let of_rapids =
        is_like_override_of_rapids(candidate, current, with, last.runs).then(|| RAPID_OVERRIDE.id_on(None));
    let mut alike: Vec<String> = alike.chain(of_rapids).collect();
    alike.sort();
    alike.dedup();
    alike
}

/// Returns `true` unless a candidate is a wait at words of a PLC that the cycles of the PLC may explain by chance; `seconds`
/// is the time that the candidate explains.
fn is_beyond_plc(candidate: &Candidate, current: &Machine, seconds: f64) -> bool {
    let plc_words = candidate.hypothesis.plc_words;
    let each = || {
        let believed = candidate.hypothesis.freed[0].handle.get(current).unwrap_or(0.0);
        candidate.hypothesis.wait_between(believed, candidate.values[0]).unwrap_or(0.0)
    };
    plc_words == 0 || gates::is_beyond_chance(each(), seconds, plc_words)
}

/// Returns `true` if a limit is lower than before and the motion yet takes less time: then the limit was fitted to
/// something else, because a lower limit makes no machine faster.
fn is_limit_that_saves(candidate: &Candidate, current: &Machine, seconds: f64) -> bool {
    let of = candidate.hypothesis.freed.iter().zip(&candidate.values);
    let is_lower =
        |(freed, value): (&FreeParameter, &f64)| *value < freed.handle.get(current).unwrap_or(f64::INFINITY);
    seconds < 0.0 && candidate.hypothesis.is_limit() && of.into_iter().all(is_lower)
}

/// Returns `true` if a candidate is a velocity limit that acts in rapids alone, on a machine whose calibration had to assume
/// the rapid rate of every axis: other rates with an override of rapids give the same motion.
fn is_like_override_of_rapids(
    candidate: &Candidate,
    current: &Machine,
    with: &Machine,
    runs: &[Run],
) -> bool {
    let is_as_fast = |segment: &Segment| {
        segment.motion.is_rapid() || requested_feedrate(segment, current) <= requested_feedrate(segment, with)
    };
    candidate.hypothesis.effect == AXIS_VELOCITY_LIMIT
        && current.calibrated_on.assumed_rapids == [true; 3]
        && runs.iter().all(|run| run.toolpath.segments.iter().all(|segment| is_as_fast(&segment)))
}

/// Returns `true` if a candidate lowers the cost by more than its price where the machine already has the assumed values that
/// were fitted beside it. Without such values the likelihood test has decided that.
fn explains_more_than_beside(
    candidate: &Candidate,
    current: &Machine,
    evidence: &Evidence,
    price: f64,
) -> bool {
    if candidate.beside.is_empty() {
        return true;
    }
    let mut without = current.clone();
    candidate.apply_beside(&mut without);
    price < evidence.cost(&without) - candidate.cost
}

/// Returns the id of a rival of `named`, with its axes if both are of the same effect.
pub fn id_beside(rival: &Hypothesis, named: &Hypothesis) -> String {
    rival.effect.id_on(rival.axes().as_deref().filter(|_| rival.effect == named.effect))
}

/// Returns the time that a cause explains, s: its net time, or [`NETTED`] of the sizes of all its changes if that is
/// more.
pub fn weight(without: &Machine, with: &Machine, runs: &[Run]) -> f64 {
    let (seconds, moved) = regions::moved(without, with, runs);
    seconds.abs().max(NETTED * moved)
}

pub fn together(candidate: &Candidate, others: &[Candidate]) -> Vec<Candidate> {
    others.iter().chain([candidate]).cloned().collect()
}

/// Returns `true` if a setting has the value of the machine file, within the uncertainty of a calibration.
pub fn is_as_believed(candidate: &Candidate, machine: &Machine) -> bool {
    let hypothesis = &candidate.hypothesis;
    let [freed] = &hypothesis.freed[..] else { return false };
    // Filters of other lengths but the same delay are seen by the sum of their squares, which is that of a constant
    // longer by the square of the spread, as a part of it.
    if hypothesis.effect == UNEQUAL_FILTERS && candidate.values[0].powi(2) < MAX_UNCHANGED_RATIO {
        return true;
    }
    let believed = freed.handle.get(machine).filter(|value| 0.0 < *value);
    // Filters shorter than a cycle of the control shape no ramp.
    if hypothesis.effect == FILTER_TIME_CONSTANT
        && believed.is_some_and(|believed| believed.max(candidate.values[0]) < LINUXCNC_SERVO_PERIOD_S)
    {
        return true;
    }
    // Override switches have steps of a whole percent and more.
    if hypothesis.effect.is_by_operator() && hypothesis.effect.nature == Nature::Switch {
        return believed.is_some_and(|believed| (candidate.values[0] - believed).abs() < HALF_A_STEP);
    }
    hypothesis.effect.nature != Nature::Switch
        && hypothesis.is_continuous()
        && believed.is_some_and(|believed| (candidate.values[0] / believed).ln().abs() < MAX_UNCHANGED_RATIO)
}

/// Returns `true` if a limit is looser than the machine file says, and the file is more likely to be wrong than the machine
/// to have changed: the calibration had to assume the limit, or it saw only other programs.
pub fn is_looser_than_calibrated(candidate: &Candidate, machine: &Machine) -> bool {
    let assumed = assumed(machine);
    let is_every_limit = standing::is_elsewhere(machine) && candidate.hypothesis.is_limit();
    candidate.hypothesis.freed.iter().zip(&candidate.values).any(|(freed, value)| {
        let is_assumed = assumed.iter().any(|assumed| assumed.handle == freed.handle);
        let believed = freed.handle.get(machine).filter(|_| is_assumed || is_every_limit);
        believed.is_some_and(|believed| believed < *value)
    })
}

/// Returns `true` if a value reached a bound: then another effect causes the lost time.
pub fn is_at_bound(candidate: &Candidate) -> bool {
    let of = candidate.hypothesis.freed.iter().zip(&candidate.values);
    candidate.hypothesis.is_continuous()
        && of.filter(|(freed, _)| freed.scale == VariationScale::Ratio).any(|(freed, value)| {
            let (low, high) = freed.bounds;
            *value <= low * (1.0 + MAX_UNCHANGED_RATIO) || high * (1.0 - MAX_UNCHANGED_RATIO) <= *value
        })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identification::effects::library;
    use crate::machine::Planner;

    /// A planner has the shortest filters that a simulation can have.
    #[test]
    fn filters_shorter_than_a_cycle_are_no_cause_on_a_planner() {
        let mut machine = Machine::default();
        machine.become_planner(Planner::AccelerationBlend, 500.0);
        let hypotheses = library(&machine, &[]);
        let is_constant = |hypothesis: &Hypothesis| hypothesis.effect == FILTER_TIME_CONSTANT;
        let constant = hypotheses.into_iter().find(is_constant).expect("the library has it");
        let is_none =
            |seconds: f64| is_as_believed(&Candidate::read_off(constant.clone(), seconds, 1e-5), &machine);
        assert!(is_none(4e-4) && !is_none(8e-3));
    }

    #[test]
    fn a_lower_limit_that_saves_time_is_no_cause() {
        let machine = Machine::default();
        let hypotheses = library(&machine, &[]);
        let is_path = |hypothesis: &Hypothesis| hypothesis.effect.id_on(None) == "path_acceleration_limit";
        let along_path = hypotheses.into_iter().find(is_path).expect("the library has it");
        let candidate = Candidate::read_off(along_path, 500.0, 1.0);
        assert!(is_limit_that_saves(&candidate, &machine, -0.01));
        assert!(!is_limit_that_saves(&candidate, &machine, 0.01));
        let mut slower = machine.clone();
        slower.path.acceleration = 400.0;
        assert!(!is_limit_that_saves(&candidate, &slower, -0.01));
    }
}
