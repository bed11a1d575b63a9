//! The search for the next cause, and the review of those that were found before it.
//!
//! The values of each hypothesis are searched over its trials, then by least squares together with all causes named
//! before; the best hypotheses are compared at the noise that the best of them leaves. As long as no cause is named,
//! pairs of them are fitted as well, since two causes may hide each other behind a third that alone is better than
//! either, and both causes of the best pair are named if the second passes beside the first; and stops at the ends of blocks are
//! tried together with the wait for position that only such stops bring about. Of the best hypotheses, by cost and price, the first that passes every test of `acceptance` is the next cause.
//!
//! A clock error is the only cause or no cause: the error that the law of another cause leaves grows with time as well.

use crate::identification::diagnosis::acceptance::{
    is_as_believed, is_at_bound, is_looser_than_calibrated, passed, priced, prices, together, weight,
};
use crate::identification::diagnosis::cause::{AcceptedCause, candidates};
use crate::identification::diagnosis::evidence::{Looked, with_all};
use crate::identification::diagnosis::gates::MIN_COST_REDUCTION;
use crate::identification::diagnosis::speeds::Speeds;
use crate::identification::diagnosis::{Candidate, Evidence, MIN_LOST_TIME_S, gates, places, rests};
use crate::identification::effects::{
    FEED_HOLD, FEED_OVERRIDE, Hypothesis, Nature, RECORDER_CLOCK, Trace, awaited_stops,
};
use crate::identification::fit::Run;
use crate::machine::Machine;
use crate::side_by_side::side_by_side;
use crate::simulation::ordered::sort_by_number;

/// Largest ratio of the cost with another cause to that with the named one at which the other replaces it: of two that
/// are nearly as good, either may be right.
const MAX_REPLACING_COST_RATIO: f64 = 0.5;
/// Number of candidates, and of effects, that are refined by least squares.
const REFINED: usize = 5;

/// A function of the machine with the best candidate that returns `true` if the machine file has another family of controls
/// than its machine. It calls its second argument with the completed part, 0 to 1.
pub type FamilyCheck<'a> = dyn FnMut(&Machine, &mut dyn FnMut(f64)) -> bool + 'a;

/// Returns the named causes followed by the next one, all fitted again. `None` if no candidate passes the acceptance
/// tests, or if the machine file has the wrong family.
pub fn with_next(
    base: &Machine,
    looked: &Looked,
    library: &[Hypothesis],
    named: &[AcceptedCause],
    is_of_other_family: &mut FamilyCheck,
    progress: &mut dyn FnMut(f64),
) -> Option<Vec<AcceptedCause>> {
    let before = candidates(named);
    let Prospects { fine, mut refined } =
        Prospects::of(base, looked, library, &before, &mut |part| progress(0.4 * part))?;
    let mut of_check = |part: f64| progress(0.4 + 0.4 * part);
    if let Some((best, others)) = refined.first()
        && is_of_other_family(&with_all(base, &together(best, others)), &mut of_check)
    {
        return None;
    }
    progress(0.8);
    let mut of_pairs = |part: f64| progress(0.8 + 0.15 * part);
    let partner = match named {
        [] => put_best_of_pairs_first(base, &fine, &mut refined, &mut of_pairs),
        _ => None,
    };
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

/// Returns the named causes followed by the best one that passes every test beside them and is `believable` with them, all
/// fitted again. `None` if there is no such cause.
pub fn with_believable(
    base: &Machine,
    looked: &Looked,
    library: &[Hypothesis],
    named: &[AcceptedCause],
    believable: impl Fn(&[AcceptedCause]) -> bool,
) -> Option<Vec<AcceptedCause>> {
    let before = candidates(named);
    let Prospects { fine, refined } = Prospects::of(base, looked, library, &before, &mut |_| {})?;
    let mut passing = refined.iter().filter_map(|(candidate, others)| {
        let (found, others) = passed(base, &before, looked, &fine, (candidate, others), &[])?;
        Some(with_refitted(named, others, found))
    });
    passing.find(|all| believable(all))
}

/// The candidates from which the next cause is chosen.
struct Prospects<'a> {
    /// The evidence at the noise that the best candidate leaves, which tells the good ones apart.
    fine: Evidence<'a>,
    /// The good candidates, refined, each with the named causes beside it, as [`refined`] sorts them.
    refined: Vec<(Candidate, Vec<Candidate>)>,
}

impl<'a> Prospects<'a> {
    /// Returns the prospects of a library beside the named causes; `None` if no hypothesis has a trial.
    fn of(
        base: &Machine,
        looked: &Looked<'a>,
        library: &[Hypothesis],
        named: &[Candidate],
        progress: &mut dyn FnMut(f64),
    ) -> Option<Prospects<'a>> {
        let current = with_all(base, named);
        let coarse = looked.evidence(&current);
        let hypotheses = open(&current, looked, &coarse, library, named);
        let good = screened(&current, &coarse, &hypotheses, progress);
        let best = good.first()?;
        let fine = looked.evidence(&best.hypothesis.machine(&current, &best.values));
        let refined = refined(base, &current, &fine, &good, named);
        Some(Prospects { fine, refined })
    }
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
    let screened = |at: usize| coarse.screened(current, &hypotheses[at]);
    let mut candidates: Vec<Candidate> =
        side_by_side(hypotheses.len(), screened, progress).into_iter().flatten().collect();
    sort_by_number(&mut candidates, |one| one.cost);
    // On a planner, limits before the filters and limits after them make the same motion.
    candidates.dedup_by(|next, own| next.hypothesis.effect == own.hypothesis.effect && next.cost == own.cost);
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
    let good = best_effects(good);
    let speeds = Speeds::of(current, fine.runs);
    // A halt changes no feedrate; what was fitted beside it may.
    let is_as_close = |candidate: &Candidate, others: &[Candidate]| {
        candidate.hypothesis.effect.nature == Nature::Halt
            || speeds.are_kept(&with_all(base, &together(candidate, others)))
    };
    let refined = |at: usize| fine.refined(base, &good[at], named);
    let mut refined = side_by_side(good.len(), refined, &mut |_| {});
    refined.retain(|(candidate, others)| {
        let is_possible = !is_as_believed(candidate, base) && !is_at_bound(candidate);
        is_possible && !is_looser_than_calibrated(candidate, base) && is_as_close(candidate, others)
    });
    sort_by_number(&mut refined, |found| priced(fine.runs, &[&found.0]));
    refined
}

/// Returns the first [`REFINED`] of the sorted candidates, and the first candidate of each of the first `REFINED` effects. A fit
/// with the parameters beside it may put an effect before several axes of another one.
fn best_effects(sorted: Vec<Candidate>) -> Vec<Candidate> {
    let mut effects = Vec::new();
    let mut is_kept = |(place, candidate): &(usize, Candidate)| {
        let effect = candidate.hypothesis.effect;
        let is_first = !effects.contains(&effect) && effects.len() < REFINED;
        if is_first {
            effects.push(effect);
        }
        is_first || *place < REFINED
    };
    sorted.into_iter().enumerate().filter(|ranked| is_kept(ranked)).map(|(_, candidate)| candidate).collect()
}

/// Moves the better cause of the best pair to the front, if that pair is better than the best cause alone, and returns
/// the other cause, fitted together with the better one, which follows it.
fn put_best_of_pairs_first(
    base: &Machine,
    fine: &Evidence,
    refined: &mut Vec<(Candidate, Vec<Candidate>)>,
    progress: &mut dyn FnMut(f64),
) -> Option<(Candidate, Vec<Candidate>)> {
    let (alone, _) = refined.first()?;
    let is_pair = |[first, second]: &[usize; 2]| {
        let [own, other] = [&refined[*first].0.hypothesis, &refined[*second].0.hypothesis];
        let has_clock = [own, other].iter().any(|one| one.effect == RECORDER_CLOCK);
        own.effect != other.effect
            && !own.is_fitted_beside(other)
            && !other.is_fitted_beside(own)
            && !has_clock
    };
    let all = 0..refined.len();
    let pairs = all.clone().flat_map(|first| (first + 1..all.end).map(move |second| [first, second]));
    let pairs: Vec<[usize; 2]> = pairs.filter(is_pair).collect();
    let fitted = |at: usize| {
        let [first, second] = pairs[at].map(|at| &refined[at].0);
        fine.refined(base, second, std::slice::from_ref(first))
    };
    let fitted = side_by_side(pairs.len(), fitted, progress);
    let (mut best, mut partner) = ((0, priced(fine.runs, &[alone])), None);
    for ([at, _], (second, first)) in pairs.iter().zip(fitted) {
        let cost = priced(fine.runs, &[&second, &first[0]]);
        if cost < best.1 {
            (best, partner) = ((*at, cost), Some((second, first)));
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
        let other = with_next(base, looked, library, &rest, &mut |_, _| false, &mut progress)?;
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identification::alignment::recorded;
    use crate::identification::effects::{
        AXIS_ACCELERATION_LIMIT, AXIS_VELOCITY_LIMIT, PATH_ACCELERATION_LIMIT, library,
    };
    use crate::machine::Planner;

    #[test]
    fn axes_of_one_effect_do_not_hide_another_effect() {
        let machine = Machine::default();
        let all = library(&machine, &[]);
        let of = |effect| {
            let hypothesis = all.iter().find(|own| own.effect == effect).expect("the library has it").clone();
            Candidate::read_off(hypothesis, 1.0, f64::NAN)
        };
        let mut sorted = vec![of(AXIS_VELOCITY_LIMIT); REFINED];
        sorted.extend([PATH_ACCELERATION_LIMIT, AXIS_VELOCITY_LIMIT, FEED_OVERRIDE].map(of));
        let kept: Vec<_> = best_effects(sorted).iter().map(|own| own.hypothesis.effect).collect();
        assert_eq!(kept[..REFINED], [AXIS_VELOCITY_LIMIT; REFINED]);
        assert_eq!(kept[REFINED..], [PATH_ACCELERATION_LIMIT, FEED_OVERRIDE]);
    }

    /// Without filters, a limit before them is the limit after them.
    #[test]
    fn limits_that_make_the_same_motion_count_once() {
        let mut believed = Machine::default();
        believed.become_planner(Planner::JunctionDeviation, 900.0);
        let mut truth = believed.clone();
        truth.axes[0].acceleration = 600.0;
        let (toolpath, alignment) = recorded("G1 F6000\nX40\nX0\nX40\nX0\n", &truth, 1e-4);
        let runs = [Run { toolpath: &toolpath, alignment: &alignment, overrides: (None, None) }];
        let of_x = |own: &Hypothesis| {
            own.effect == AXIS_ACCELERATION_LIMIT && ["X", "X, before the filters"].contains(&&*own.variant)
        };
        let hypotheses: Vec<Hypothesis> = library(&believed, &runs).into_iter().filter(of_x).collect();
        assert_eq!(hypotheses.len(), 2);
        let found = screened(&believed, &Evidence::of(&runs, &believed), &hypotheses, &mut |_| {});
        assert_eq!(found.len(), 1);
    }
}
