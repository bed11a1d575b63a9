//! The next cause, and the acceptance tests that it must pass.
//!
//! The values of each hypothesis are searched over its trials, then by least squares together with all causes named
//! before; the best hypotheses are compared at the noise that the best of them leaves. As long as no cause is named,
//! pairs of them are fitted as well, since two causes may hide each other behind a third that alone is better than
//! either, and both causes of the best pair are named if the second passes beside the first; and stops at the ends of blocks are tried together with the wait for position that only such stops bring
//! about. Of the best hypotheses, by cost and price, the first that passes every acceptance test is the next cause:
//!
//! | acceptance test | what must hold |
//! |---|---|
//! | likelihood | the cost falls by more than `MIN_COST_REDUCTION` + k ln n, n sections of the path, not samples |
//! | held out | with the values that the others give a section is better, in most sections where it acts |
//! | place | where it explains little of all, it fits where it is better than anywhere else it is shifted to |
//! | feedrate | feedrates differ hardly more with it than without it, all in all and where it acts; a halt changes none |
//! | chance | a wait at a word is longer or shorter than the cycles of a PLC make it from run to run |
//! | size | it explains more than `MIN_EXPLAINED_SHARE` of the cycle time, `MIN_LOST_TIME_S` s, and `MAX_REMAINING_PART` of the time explained |
//!
//! A clock error is the only cause or no cause: the error that the law of another cause leaves grows with time as well.
//!
//! Causes that these runs cannot separate from the next cause are alike to it: other effects, or the same effect of
//! another axis, that fit as well, except perhaps at one place.

use std::collections::BTreeSet;

use crate::identification::diagnosis::cause::{AcceptedCause, UNSURE, candidates, odds};
use crate::identification::diagnosis::evidence::{assumed, with_all};
use crate::identification::diagnosis::gates::{HeldOut, MIN_COST_REDUCTION};
use crate::identification::diagnosis::speeds::Speeds;
use crate::identification::diagnosis::verdict::MAX_REMAINING_PART;
use crate::identification::diagnosis::{
    Candidate, Evidence, MIN_LOST_TIME_S, gates, places, regions, rests, standing,
};
use crate::identification::effects::{
    FEED_HOLD, FEED_OVERRIDE, Hypothesis, MIN_EXPLAINED_SHARE, Nature, RECORDER_CLOCK, Trace,
    UNEQUAL_FILTERS, awaited_stops,
};
use crate::identification::fit::{Run, VariationScale};
use crate::machine::Machine;
use crate::simulation::ordered::sort_by_number;

/// Largest part of the time that the earlier causes explain which a further cause may cancel.
const MAX_CANCELLED_PART: f64 = 0.5;
/// Weight of the time that a cause adds in some places and saves in others, against its net time.
const NETTED: f64 = 0.2;
/// Least gain, as a part of the remaining cost, from which on a cause needs no shift test.
const MIN_GAIN_WITHOUT_SHIFT_TEST: f64 = 0.5;
/// Largest cost above that of the best candidate at which another is alike to it, in multiples of the dispersion: the
/// ratio by which the residuals vary more than independent ones.
const MAX_ALIKE_COST: f64 = 6.0;
/// Least part of the gain of the better of two candidates that is outside a single place, if that place alone is not to
/// separate them.
const MIN_GAIN_SHARE_ELSEWHERE: f64 = 0.5;
/// Largest part of the difference of their costs that then remains outside that place.
const MAX_DIFFERENCE_SHARE_ELSEWHERE: f64 = 0.1;
/// Largest difference, as a ratio, between a setting and the believed one at which the setting counts as unchanged.
/// Overrides and the clock ratio need no such range: their believed value is exactly 1.
const MAX_UNCHANGED_RATIO: f64 = 6e-3;
/// Half of the smallest step of an override switch, as a ratio.
const HALF_A_STEP: f64 = 5e-3;
/// Largest ratio of the cost with another cause to that with the named one at which the other replaces it: of two that
/// are nearly as good, either may be right.
const MAX_REPLACING_COST_RATIO: f64 = 0.5;
/// Most candidates that are refined by least squares.
const REFINED: usize = 5;

/// Runs in which causes are searched.
pub struct Looked<'a> {
    /// Whole runs, or excerpts of them.
    pub runs: &'a [Run<'a>],
    /// Whole runs.
    pub whole: &'a [Run<'a>],
    /// `true` if `runs` are excerpts.
    pub in_parts: bool,
}

impl<'a> Looked<'a> {
    fn evidence(&self, machine: &Machine) -> Evidence<'a> {
        match self.in_parts {
            true => Evidence::in_common(self.runs, machine),
            false => Evidence::of(self.runs, machine),
        }
    }
}

/// Returns the named causes followed by the next one, all fitted again. `None` if no candidate passes the acceptance
/// tests.
pub fn with_next(
    base: &Machine,
    looked: &Looked,
    library: &[Hypothesis],
    named: &[AcceptedCause],
    progress: &mut dyn FnMut(f64),
) -> Option<Vec<AcceptedCause>> {
    let before = candidates(named);
    let current = with_all(base, &before);
    let coarse = looked.evidence(&current);
    let hypotheses = open(&current, looked, &coarse, library, &before);
    let good = screened(&current, &coarse, &hypotheses, &mut |part| progress(0.7 * part));
    let best = good.first()?;
    // At the noise that the best leaves the good ones are told apart.
    let fine = looked.evidence(&best.hypothesis.machine(&current, &best.values));
    let mut refined = refined(base, &current, &fine, &good, &before);
    progress(0.85);
    let partner = if named.is_empty() { put_best_of_pairs_first(base, &fine, &mut refined) } else { None };
    progress(0.95);
    if named.is_empty()
        && let Some(both) = awaited_stops_first(base, looked, &fine, refined.first().map(|(best, _)| best))
    {
        return Some(both);
    }
    let (at, (found, others)) = refined.iter().enumerate().find_map(|(at, (candidate, others))| {
        Some((at, passed(base, &before, looked, &fine, (candidate, others), &refined[at + 1..])?))
    })?;
    let second = partner.filter(|_| at == 0).and_then(|(second, first)| {
        passed(base, std::slice::from_ref(&found.candidate), looked, &fine, (&second, &first), &[])
    });
    Some(match second {
        Some((second, first)) => with_refitted(&[found], first, second),
        None => with_refitted(named, others, found),
    })
}

/// Returns the named causes with the values fitted again, followed by the cause found.
fn with_refitted(
    named: &[AcceptedCause],
    refitted: Vec<Candidate>,
    found: AcceptedCause,
) -> Vec<AcceptedCause> {
    let refitted = named.iter().zip(refitted);
    refitted.map(|(named, candidate)| AcceptedCause { candidate, ..named.clone() }).chain([found]).collect()
}

/// Returns the hypotheses of time in the library that are not named yet, and those that the residual places.
fn open(
    current: &Machine,
    looked: &Looked,
    coarse: &Evidence,
    library: &[Hypothesis],
    named: &[Candidate],
) -> Vec<Hypothesis> {
    let is_named = |other: &Hypothesis| named.iter().any(|own| own.hypothesis.is_same_as(other));
    let in_time = library.iter().filter(|hypothesis| hypothesis.trace() == Trace::Time);
    let mut all: Vec<Hypothesis> = in_time
        .filter(|hypothesis| !is_named(hypothesis))
        .filter(|hypothesis| !named.iter().any(|named| hypothesis.is_fitted_beside(&named.hypothesis)))
        .filter(|hypothesis| named.is_empty() || hypothesis.effect != RECORDER_CLOCK)
        .cloned()
        .collect();
    let has_override = library.iter().any(|hypothesis| hypothesis.effect == FEED_OVERRIDE);
    let whole = if looked.in_parts { &Evidence::of(looked.whole, current) } else { coarse };
    all.extend(places::hypotheses(current, looked.whole, whole, has_override));
    all
}

/// Returns the best of the hypotheses, each with the values that screening finds best, sorted by cost at the noise of
/// the current machine.
fn screened(
    current: &Machine,
    coarse: &Evidence,
    hypotheses: &[Hypothesis],
    progress: &mut dyn FnMut(f64),
) -> Vec<Candidate> {
    let mut candidates: Vec<Candidate> = Vec::new();
    for (at, hypothesis) in hypotheses.iter().enumerate() {
        progress(at as f64 / hypotheses.len() as f64);
        candidates.extend(coarse.screened(current, hypothesis));
    }
    sort_by_number(&mut candidates, |one| one.cost);
    candidates.truncate(3 * REFINED);
    candidates
}

/// Refines the good candidates by least squares together with the named causes. Returns the possible ones, each with
/// the named causes, sorted by cost and price; of two that fit as well the one with fewer parameters comes first.
fn refined(
    base: &Machine,
    current: &Machine,
    fine: &Evidence,
    good: &[Candidate],
    named: &[Candidate],
) -> Vec<(Candidate, Vec<Candidate>)> {
    let at_fine = |candidate: &Candidate| {
        let cost = fine.cost(&candidate.hypothesis.machine(current, &candidate.values));
        Candidate { cost, ..candidate.clone() }
    };
    let mut good: Vec<Candidate> = good.iter().map(at_fine).collect();
    sort_by_number(&mut good, |one| one.cost);
    good.truncate(REFINED);
    let speeds = Speeds::of(current, fine.runs);
    // A halt changes no feedrate; what was fitted beside it may.
    let is_as_close = |candidate: &Candidate, others: &[Candidate]| {
        candidate.hypothesis.effect.nature == Nature::Halt
            || speeds.are_kept(&with_all(base, &together(candidate, others)))
    };
    let mut refined: Vec<_> = good.iter().map(|candidate| fine.refined(base, candidate, named)).collect();
    refined.retain(|(candidate, others)| {
        let is_possible = !is_as_believed(candidate, base) && !is_at_bound(candidate);
        is_possible && !is_looser_than_calibrated(candidate, base) && is_as_close(candidate, others)
    });
    refined.sort_by(|a, b| priced(fine.runs, &[&a.0]).total_cmp(&priced(fine.runs, &[&b.0])));
    refined
}

/// Returns the cost of causes that were fitted together, plus their price.
fn priced(runs: &[Run], together: &[&Candidate]) -> f64 {
    together.first().map_or(0.0, |first| first.cost) + prices(runs, together.iter().copied())
}

/// Returns the sum of the prices of causes.
fn prices<'a>(runs: &[Run], causes: impl Iterator<Item = &'a Candidate>) -> f64 {
    causes.map(|candidate| price(runs, candidate)).sum()
}

/// Returns the price of a cause: that of its parameters and that of its rarity.
fn price(runs: &[Run], candidate: &Candidate) -> f64 {
    gates::price(runs, candidate.values.len()) + candidate.hypothesis.rarity
}

/// Moves the better cause of the best pair to the front, if that pair is better than the best cause alone, and returns
/// the other cause, fitted together with the better one, which follows it.
fn put_best_of_pairs_first(
    base: &Machine,
    fine: &Evidence,
    refined: &mut Vec<(Candidate, Vec<Candidate>)>,
) -> Option<(Candidate, Vec<Candidate>)> {
    let (alone, _) = refined.first()?;
    let (mut best, mut partner) = ((0, priced(fine.runs, &[alone])), None);
    for (at, (first, _)) in refined.iter().enumerate() {
        for (second, _) in &refined[at + 1..] {
            let (own, other) = (&first.hypothesis, &second.hypothesis);
            let has_clock = [own, other].iter().any(|one| one.effect == RECORDER_CLOCK);
            if own.effect == other.effect
                || own.is_fitted_beside(other)
                || other.is_fitted_beside(own)
                || has_clock
            {
                continue;
            }
            let (second, first) = fine.refined(base, second, std::slice::from_ref(first));
            let cost = priced(fine.runs, &[&second, &first[0]]);
            if cost < best.1 {
                (best, partner) = ((at, cost), Some((second, first)));
            }
        }
    }
    let first = refined.remove(best.0);
    refined.insert(0, first);
    partner
}

/// Returns stops at the ends of blocks and the wait for position at them. `None` unless the two together are worth more
/// than the best candidate alone and pass the acceptance tests.
fn awaited_stops_first(
    base: &Machine,
    looked: &Looked,
    fine: &Evidence,
    best: Option<&Candidate>,
) -> Option<Vec<AcceptedCause>> {
    let [stop, wait] = awaited_stops(base, fine.runs)?;
    let stopping = stop.machine(base, &[0.0]);
    let stop = Candidate {
        cost: fine.cost(&stopping),
        hypothesis: stop,
        values: vec![0.0],
        deviations: Vec::new(),
        beside: Vec::new(),
    };
    let wait = fine.screened(&stopping, &wait)?;
    let (wait, others) = fine.refined(base, &wait, &[stop]);
    let worth = priced(fine.runs, &[&wait, others.first()?]);
    let is_best = best.is_none_or(|best| worth < priced(fine.runs, &[best]));
    let with = with_all(base, &together(&wait, &others));
    if !is_best || is_at_bound(&wait) || !Speeds::of(base, fine.runs).are_kept(&with) {
        return None;
    }
    let (found, others) = passed(base, &[], looked, fine, (&wait, &others), &[])?;
    let stop = AcceptedCause { candidate: others.into_iter().next()?, ..found.clone() };
    Some(vec![stop, found])
}

/// Returns a candidate as an accepted cause, with the causes named before it. `None` if it fails an acceptance test.
/// `rest` holds the candidates that are not as good.
fn passed(
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
    // The noise once more, that of the refined one; else its last digits are those of the first guess.
    let last = looked.evidence(&with_all(base, &together(candidate, others)));
    let (candidate, others) = last.refined(base, candidate, others);
    let gain = last.cost(current) - candidate.cost;
    if gain <= price {
        return None;
    }
    let with = with_all(base, &together(&candidate, &others));
    let whole: f64 = runs.iter().map(|run| run.plan(current).cycle_time()).sum();
    let explained = regions::moved(base, current, runs).0;
    if weight(current, &with, runs)
        < MIN_LOST_TIME_S.max(MIN_EXPLAINED_SHARE * whole).max(MAX_REMAINING_PART * explained.abs())
    {
        return None;
    }
    let further = regions::moved(current, &with, runs).0;
    let plc_words = candidate.hypothesis.plc_words;
    if 0 < plc_words {
        let believed = candidate.hypothesis.freed[0].handle.get(current).unwrap_or(0.0);
        if !gates::is_beyond_chance(candidate.values[0] - believed, further, plc_words) {
            return None;
        }
    }
    // Two that nearly cancel are one that was fitted to what the law of the other gets wrong.
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
    // The last digits of the others are those of the first guess, too.
    let dispersion = last.dispersion(&with);
    let is_alike = |(other, others): &&(Candidate, Vec<Candidate>)| {
        let (other, others) = last.refined(base, other, others);
        let apart = other.cost - candidate.cost;
        if apart < MAX_ALIKE_COST * dispersion {
            return true;
        }
        // What tells two apart in a single place is how their laws begin or end there, which no model knows so well.
        let rest = gates::without_worst(&last, &with, &with_all(base, &together(&other, &others)));
        let cost = rest.cost(&with);
        let acts_elsewhere = || MIN_GAIN_SHARE_ELSEWHERE * gain < rest.cost(current) - cost;
        let still_apart = || rest.refined(base, &other, &others).0.cost - cost;
        acts_elsewhere()
            && still_apart() < (MAX_ALIKE_COST * dispersion).min(MAX_DIFFERENCE_SHARE_ELSEWHERE * apart)
    };
    let alike: BTreeSet<String> = rest
        .iter()
        .filter(|(other, _)| other.hypothesis.is_rival_of(&candidate.hypothesis))
        .filter(is_alike)
        .map(|(other, _)| id_beside(&other.hypothesis, &candidate.hypothesis))
        .collect();
    let confidence = held_out.as_ref().map_or(1.0, HeldOut::share) / (1.0 + alike.len() as f64);
    let found = AcceptedCause { candidate, alike: alike.into_iter().collect(), held_out, confidence };
    (UNSURE <= confidence * odds(gain / dispersion, price)).then_some((found, others))
}

/// Returns the id of a rival of `named`, with its axis if both are of the same effect.
fn id_beside(rival: &Hypothesis, named: &Hypothesis) -> String {
    rival.effect.id_on(rival.axis().filter(|_| rival.effect == named.effect))
}

/// Returns the time that a cause explains, s: its net time, or [`NETTED`] of the sizes of all its changes if that is
/// more.
fn weight(without: &Machine, with: &Machine, runs: &[Run]) -> f64 {
    let (seconds, moved) = regions::moved(without, with, runs);
    seconds.abs().max(NETTED * moved)
}

fn together(candidate: &Candidate, others: &[Candidate]) -> Vec<Candidate> {
    others.iter().chain([candidate]).cloned().collect()
}

/// Returns `true` if a setting has the value of the machine file, within the uncertainty of a calibration.
fn is_as_believed(candidate: &Candidate, machine: &Machine) -> bool {
    let hypothesis = &candidate.hypothesis;
    let [freed] = &hypothesis.freed[..] else { return false };
    // Filters of other lengths but the same delay are seen by the sum of their squares, which is that of a constant
    // longer by the square of the spread, as a part of it.
    if hypothesis.effect == UNEQUAL_FILTERS && candidate.values[0].powi(2) < MAX_UNCHANGED_RATIO {
        return true;
    }
    let believed = freed.handle.get(machine).filter(|value| 0.0 < *value);
    // Override switches have steps of a whole percent and more.
    if hypothesis.effect.is_by_operator() && hypothesis.effect.nature == Nature::Switch {
        return believed.is_some_and(|believed| (candidate.values[0] - believed).abs() < HALF_A_STEP);
    }
    hypothesis.effect.nature != Nature::Switch
        && hypothesis.is_continuous
        && believed.is_some_and(|believed| (candidate.values[0] / believed).ln().abs() < MAX_UNCHANGED_RATIO)
}

/// Returns `true` if a limit is looser than the machine file says, and the file is more likely to be wrong than the machine
/// to have changed: the calibration had to assume the limit, or it saw only other programs.
fn is_looser_than_calibrated(candidate: &Candidate, machine: &Machine) -> bool {
    let assumed = assumed(machine);
    let is_every_limit = standing::is_elsewhere(machine) && candidate.hypothesis.is_limit();
    candidate.hypothesis.freed.iter().zip(&candidate.values).any(|(freed, value)| {
        let is_assumed = assumed.iter().any(|assumed| assumed.handle == freed.handle);
        let believed = freed.handle.get(machine).filter(|_| is_assumed || is_every_limit);
        believed.is_some_and(|believed| believed < *value)
    })
}

/// Returns `true` if a value reached a bound: then another effect causes the lost time.
fn is_at_bound(candidate: &Candidate) -> bool {
    let of = candidate.hypothesis.freed.iter().zip(&candidate.values);
    candidate.hypothesis.is_continuous
        && of.filter(|(freed, _)| freed.scale == VariationScale::Ratio).any(|(freed, value)| {
            let (low, high) = freed.bounds;
            *value <= low * (1.0 + MAX_UNCHANGED_RATIO) || high * (1.0 - MAX_UNCHANGED_RATIO) <= *value
        })
}

/// Returns the causes with one of them replaced by another that was found beside the rest and is worth more: the order
/// of the causes was decided when the later ones were unknown. `None` if no cause is replaced.
pub fn reconsidered(
    base: &Machine,
    looked: &Looked,
    library: &[Hypothesis],
    named: &[AcceptedCause],
    progress: &mut dyn FnMut(f64),
) -> Option<Vec<AcceptedCause>> {
    // All others were known when the last one was found, and nothing else leaves the trace of a halt.
    let before_last = 0..named.len().saturating_sub(1);
    before_last.filter(|at| named[*at].candidate.hypothesis.effect.nature != Nature::Halt).find_map(|at| {
        let mut rest = named.to_vec();
        let former = rest.remove(at).candidate.hypothesis;
        let mut progress = |part| progress((at as f64 + part) / named.len() as f64);
        let other = with_next(base, looked, library, &rest, &mut progress)?;
        let latter = &other.last()?.candidate.hypothesis;
        if latter.is_same_as(&former) {
            return None;
        }
        let evidence = looked.evidence(&with_all(base, &candidates(&other)));
        let worth = |found: &[AcceptedCause]| {
            let causes = candidates(found);
            evidence.cost(&with_all(base, &causes)) + prices(looked.runs, causes.iter())
        };
        (worth(&other) < MAX_REPLACING_COST_RATIO * worth(named)).then_some(other)
    })
}

/// Returns the causes found in excerpts that also hold on the whole runs, each tested together with those before it.
pub fn held(base: &Machine, runs: &[Run], named: Vec<AcceptedCause>) -> Vec<AcceptedCause> {
    let whole = Evidence::of(runs, &with_all(base, &candidates(&named)));
    let mut kept: Vec<AcceptedCause> = Vec::new();
    let mut before = base.clone();
    for found in named {
        let after = found.candidate.hypothesis.machine(&before, &found.candidate.values);
        let gain = whole.cost(&before) - whole.cost(&after);
        if MIN_COST_REDUCTION < gain && Speeds::of(&before, runs).are_kept(&after) {
            kept.push(found);
            before = after;
        }
    }
    kept
}

/// Removes every cause that the others make unnecessary, to which they leave too little lost time, or beside which it no
/// longer holds in sections that it was not fitted to: a cause that was found first had them unexplained.
pub fn without_unnecessary(
    base: &Machine,
    looked: &Looked,
    mut named: Vec<AcceptedCause>,
) -> Vec<AcceptedCause> {
    while 1 < named.len() {
        let all = candidates(&named);
        let with = with_all(base, &all);
        let is_small = |at: usize| {
            let Candidate { hypothesis, values, .. } = &all[at];
            if hypothesis.effect == FEED_HOLD && values[0] < rests::MIN_REST_S {
                return true;
            }
            let mut others = all.clone();
            others.remove(at);
            weight(&with_all(base, &others), &with, looked.runs) < MIN_LOST_TIME_S
        };
        if let Some(small) = (0..all.len()).find(|at| is_small(*at)) {
            named.remove(small);
            continue;
        }
        let evidence = looked.evidence(&with);
        let cost = evidence.cost(&with);
        let without = |at: usize| {
            let mut others = all.clone();
            others.remove(at);
            let (last, rest) = others.split_last()?;
            let (last, mut others) = evidence.refined(base, last, rest);
            others.push(last);
            Some((at, evidence.cost(&with_all(base, &others)) - cost, others))
        };
        let holds = |at: usize, others: &[Candidate]| {
            gates::held_out(&evidence, base, others, (&all[at], others))
                .is_none_or(|held_out| held_out.holds())
        };
        let mut each: Vec<_> = (0..all.len()).filter_map(without).collect();
        sort_by_number(&mut each, |(_, rise, _)| *rise);
        let is_idle = |(at, rise, others): &(usize, f64, Vec<Candidate>)| {
            *rise < MIN_COST_REDUCTION || !holds(*at, others)
        };
        let Some((at, _, others)) = each.into_iter().find(is_idle) else { break };
        named.remove(at);
        named.iter_mut().zip(others).for_each(|(named, candidate)| named.candidate = candidate);
    }
    named
}
