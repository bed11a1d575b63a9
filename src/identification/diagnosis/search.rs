//! The next cause, and whether it stands.
//!
//! Of each hypothesis the values are searched over its trials, then by least squares with all that was named
//! before; the best are compared at the noise that the best of them leaves. Where nothing is named yet, pairs of
//! them are fitted as well: two causes may hide each other behind a third, which alone is better than either; and stops at the
//! ends of blocks are tried with the wait for position that only they bring about. The
//! first of the best, by cost and price, that passes every gate is the next cause:
//!
//! | gate | what must hold |
//! |---|---|
//! | likelihood | the cost falls by more than `GAIN` + k ln n, n sections of the path, not samples |
//! | held out | with the values that the others give a section is better, in most sections where it acts |
//! | place | where it explains little of all, it fits where it is better than anywhere else it is shifted to |
//! | feedrate | feedrates differ hardly more with it than without it, all in all and where it acts |
//! | chance | a wait at a word is longer or shorter than the cycles of a PLC make it from run to run |
//! | size | it explains more than `SIZE` of the cycle time, than `LEAST` s, and than `BESIDE` of what is explained |
//!
//! A clock is the only cause or none: what the law of another leaves grows with the time as well.
//!
//! Others that cannot be told from it on these runs are alike: those that fit as well, be it but for one place.

use std::collections::BTreeSet;

use crate::identification::diagnosis::cause::{AcceptedCause, UNSURE, candidates, odds};
use crate::identification::diagnosis::evidence::{assumed, with_all};
use crate::identification::diagnosis::gates::{GAIN, HeldOut};
use crate::identification::diagnosis::speeds::Speeds;
use crate::identification::diagnosis::verdict::BESIDE;
use crate::identification::diagnosis::{Candidate, Evidence, LEAST, gates, places, regions, rests};
use crate::identification::effects::{
    FEED_HOLD, FEED_OVERRIDE, Hypothesis, Nature, RECORDER_CLOCK, SPINDLE_WAIT, Trace, UNEQUAL_FILTERS,
    UNMODELLED_WAIT, awaited_stops,
};
use crate::identification::fit::{Run, VariationScale};
use crate::machine::Machine;
use crate::simulation::ordered::sort_by_number;

/// What a cause must explain, as a part of the cycle time.
pub const SIZE: f64 = 3e-4;
/// A further cause may take back at most this part of what the causes before it explain.
const MAX_CANCELLED_PART: f64 = 0.5;
/// What a cause moves back and forth counts by this part.
const NETTED: f64 = 0.2;
/// A gain of this part of what is left needs no test of its place.
const LARGE: f64 = 0.5;
/// Candidates whose cost is no farther above the best's cannot be told from it, over how much more than independent
/// ones the residuals vary.
const SAME: f64 = 6.0;
/// A single place does not tell two apart where this part of what the better one gains is elsewhere, and no more than
/// this part of what sets them apart.
const ELSEWHERE: f64 = 0.5;
const IN_PLACE: f64 = 0.1;
/// A setting this close to the believed one, as a ratio, is that one; what an operator or a clock does is
/// known to be exactly 1.
const BELIEVED: f64 = 6e-3;
/// Half of the smallest step of an override switch.
const HALF_A_STEP: f64 = 5e-3;
/// A cause gives way to another where that leaves less than this part of the cost: what is nearly as good may be
/// either.
const GIVES_WAY: f64 = 0.5;
/// Candidates that are refined by least squares.
const REFINED: usize = 5;

/// Where causes are looked for.
pub struct Looked<'a> {
    /// The runs, or excerpts of them.
    pub runs: &'a [Run<'a>],
    /// The runs.
    pub whole: &'a [Run<'a>],
    /// Whether they are excerpts.
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

/// What was named with the next cause after it, all fitted again; none where nothing passes the gates.
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
    if named.is_empty() {
        put_best_of_pairs_first(base, &fine, &mut refined);
    }
    progress(0.95);
    if named.is_empty()
        && let Some(both) = awaited_stops_first(base, looked, &fine, refined.first().map(|(best, _)| best))
    {
        return Some(both);
    }
    let (found, others) = refined.iter().enumerate().find_map(|(at, (candidate, others))| {
        passed(base, &before, looked, &fine, (candidate, others), &refined[at + 1..])
    })?;
    let refitted = named.iter().zip(others);
    let mut all: Vec<AcceptedCause> =
        refitted.map(|(named, candidate)| AcceptedCause { candidate, ..named.clone() }).collect();
    all.push(found);
    Some(all)
}

/// What of the library is not named yet, with what the residual says where to place.
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

/// The best of the hypotheses at the best of their trials, by cost at the noise that the best of them leaves.
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

/// The good ones by least squares together with what was named, by what they are worth; of two that are as good
/// the one with fewer parameters comes first.
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
    let is_as_close = |candidate: &Candidate, others: &[Candidate]| {
        speeds.are_kept(&with_all(base, &together(candidate, others)))
    };
    let mut refined: Vec<_> = good.iter().map(|candidate| fine.refined(base, candidate, named)).collect();
    refined.retain(|(candidate, others)| {
        let is_possible = !is_as_believed(candidate, base) && !is_at_bound(candidate);
        is_possible && !is_looser_than_assumed(candidate, base) && is_as_close(candidate, others)
    });
    refined.sort_by(|a, b| priced(fine.runs, &[&a.0]).total_cmp(&priced(fine.runs, &[&b.0])));
    refined
}

/// The cost of causes that were fitted together, with their price.
fn priced(runs: &[Run], together: &[&Candidate]) -> f64 {
    together.first().map_or(0.0, |first| first.cost) + prices(runs, together.iter().copied())
}

/// The price of all parameters of these causes.
fn prices<'a>(runs: &[Run], causes: impl Iterator<Item = &'a Candidate>) -> f64 {
    causes.map(|candidate| price(runs, candidate)).sum()
}

/// The price of a cause: of its parameters, and of how rare it is.
fn price(runs: &[Run], candidate: &Candidate) -> f64 {
    gates::price(runs, candidate.values.len()) + candidate.hypothesis.effect.rarity
}

/// Of the pair that is best, and better than the best alone, the better one comes first.
fn put_best_of_pairs_first(base: &Machine, fine: &Evidence, refined: &mut Vec<(Candidate, Vec<Candidate>)>) {
    let Some((alone, _)) = refined.first() else { return };
    let mut best = (0, priced(fine.runs, &[alone]));
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
            let (first, others) = fine.refined(base, first, std::slice::from_ref(second));
            let cost = priced(fine.runs, &[&first, &others[0]]);
            if cost < best.1 {
                best = (at, cost);
            }
        }
    }
    let first = refined.remove(best.0);
    refined.insert(0, first);
}

/// Stops at the ends of blocks with the wait for position at them, where the two are worth more than the best alone and pass the
/// gates together.
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

/// A candidate with those named before, if it passes every gate. `rest` are those that are not as good.
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
    if weight(current, &with, runs) < LEAST.max(SIZE * whole).max(BESIDE * explained.abs()) {
        return None;
    }
    let further = regions::moved(current, &with, runs).0;
    if [SPINDLE_WAIT, UNMODELLED_WAIT].contains(&candidate.hypothesis.effect) {
        let believed = candidate.hypothesis.freed[0].handle.get(current).unwrap_or(0.0);
        if !gates::is_beyond_chance(candidate.values[0] - believed, further) {
            return None;
        }
    }
    // Two that nearly cancel are one that was fitted to what the law of the other gets wrong.
    if further * explained < 0.0 && MAX_CANCELLED_PART * explained.abs() < further.abs() {
        return None;
    }
    if gain < LARGE * candidate.cost && !gates::stays_in_place(&last, current, &with) {
        return None;
    }
    let newest_first: Vec<Candidate> = [&candidate].into_iter().chain(&others).cloned().collect();
    let held_out = gates::held_out(&last, base, before, &newest_first);
    if held_out.as_ref().is_some_and(|held_out| !held_out.holds()) {
        return None;
    }
    // The last digits of the others are those of the first guess, too.
    let dispersion = last.dispersion(&with);
    let is_alike = |(other, others): &&(Candidate, Vec<Candidate>)| {
        let (other, others) = last.refined(base, other, others);
        let apart = other.cost - candidate.cost;
        if apart < SAME * dispersion {
            return true;
        }
        // What tells two apart in a single place is how their laws begin or end there, which no model knows so well.
        let rest = gates::without_worst(&last, &with, &with_all(base, &together(&other, &others)));
        let cost = rest.cost(&with);
        let acts_elsewhere = || ELSEWHERE * gain < rest.cost(current) - cost;
        let still_apart = || rest.refined(base, &other, &others).0.cost - cost;
        acts_elsewhere() && still_apart() < (SAME * dispersion).min(IN_PLACE * apart)
    };
    let alike: BTreeSet<String> = rest
        .iter()
        .filter(|(other, _)| other.hypothesis.effect != candidate.hypothesis.effect)
        .filter(is_alike)
        .map(|(other, _)| other.hypothesis.effect.id.to_string())
        .collect();
    let confidence = held_out.as_ref().map_or(1.0, HeldOut::share) / (1.0 + alike.len() as f64);
    let found = AcceptedCause { candidate, alike: alike.into_iter().collect(), held_out, confidence };
    (UNSURE <= confidence * odds(gain / dispersion, price)).then_some((found, others))
}

/// What a cause explains, s.
fn weight(without: &Machine, with: &Machine, runs: &[Run]) -> f64 {
    let (seconds, moved) = regions::moved(without, with, runs);
    seconds.abs().max(NETTED * moved)
}

fn together(candidate: &Candidate, others: &[Candidate]) -> Vec<Candidate> {
    others.iter().chain([candidate]).cloned().collect()
}

/// Whether a setting is found at the value that the machine file has, within what a calibration is sure of.
fn is_as_believed(candidate: &Candidate, machine: &Machine) -> bool {
    let hypothesis = &candidate.hypothesis;
    let [freed] = &hypothesis.freed[..] else { return false };
    // Filters of other lengths but the same delay are seen by the sum of their squares, which is that of a constant
    // longer by the square of the spread, as a part of it.
    if hypothesis.effect == UNEQUAL_FILTERS && candidate.values[0].powi(2) < BELIEVED {
        return true;
    }
    let believed = freed.handle.get(machine).filter(|value| 0.0 < *value);
    // Override switches have steps of a whole percent and more.
    if hypothesis.effect.is_by_operator() && hypothesis.effect.nature == Nature::Switch {
        return believed.is_some_and(|believed| (candidate.values[0] - believed).abs() < HALF_A_STEP);
    }
    hypothesis.effect.nature != Nature::Switch
        && hypothesis.is_continuous
        && believed.is_some_and(|believed| (candidate.values[0] / believed).ln().abs() < BELIEVED)
}

/// Whether a limit that the calibration had to assume is found to be looser: the machine file was off, and nothing changed.
fn is_looser_than_assumed(candidate: &Candidate, machine: &Machine) -> bool {
    let freed = candidate.hypothesis.freed.iter().zip(&candidate.values);
    let assumed = assumed(machine);
    freed.into_iter().any(|(freed, value)| {
        assumed.iter().any(|assumed| assumed.handle == freed.handle && assumed.start < *value)
    })
}

/// Whether a value went as far as it may go: what it is to explain is something else.
fn is_at_bound(candidate: &Candidate) -> bool {
    let of = candidate.hypothesis.freed.iter().zip(&candidate.values);
    candidate.hypothesis.is_continuous
        && of.filter(|(freed, _)| freed.scale == VariationScale::Ratio).any(|(freed, value)| {
            let (low, high) = freed.bounds;
            *value <= low * (1.0 + BELIEVED) || high * (1.0 - BELIEVED) <= *value
        })
}

/// The causes with one of them replaced where another, found beside the rest, is worth more: which came first was
/// settled when the others were not known. None where all stand.
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
        (worth(&other) < GIVES_WAY * worth(named)).then_some(other)
    })
}

/// Those of the causes found in excerpts that also hold on the whole, each with those before it.
pub fn held(base: &Machine, runs: &[Run], named: Vec<AcceptedCause>) -> Vec<AcceptedCause> {
    let whole = Evidence::of(runs, &with_all(base, &candidates(&named)));
    let mut kept: Vec<AcceptedCause> = Vec::new();
    let mut before = base.clone();
    for found in named {
        let after = found.candidate.hypothesis.machine(&before, &found.candidate.values);
        let gain = whole.cost(&before) - whole.cost(&after);
        if GAIN < gain && Speeds::of(&before, runs).are_kept(&after) {
            kept.push(found);
            before = after;
        }
    }
    kept
}

/// Takes back every cause that the others make unnecessary, or leave too little to.
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
            if hypothesis.effect == FEED_HOLD && values[0] < rests::LEAST {
                return true;
            }
            let mut others = all.clone();
            others.remove(at);
            weight(&with_all(base, &others), &with, looked.runs) < LEAST
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
        let cheapest = (0..all.len()).filter_map(without).min_by(|a, b| a.1.total_cmp(&b.1));
        let Some((at, _, others)) = cheapest.filter(|(_, rise, _)| *rise < GAIN) else { break };
        named.remove(at);
        named.iter_mut().zip(others).for_each(|(named, candidate)| named.candidate = candidate);
    }
    named
}
