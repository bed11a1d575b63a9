//! Effects at places: full stops and waits.

use std::collections::{BTreeMap, BTreeSet};

use crate::identification::alignment::Place;
use crate::identification::effects::effect::{Context, Effect, Hypothesis, ratios};
use crate::identification::effects::report::{ANGLE, AT, BETWEEN, CODE, LINE, OR_CODE, Reported, SECONDS};
use crate::identification::effects::waits::Kind;
use crate::identification::fit::{Freed, Run, Scale};
use crate::machine::{Handle, InPosition};
use crate::simulation::toolpath::Stop;

/// Angles between which no corner turns are one, where they are closer than this, rad.
const CLOSE: f64 = 0.01;
/// Least angles that stop, at most so many; the widest gaps between corners first.
const MOST_ANGLES: usize = 16;
/// Kinds of stops that are looked at beside one another, at most.
const MOST_BESIDE: usize = 8;
/// Longer waits tried first, s.
const LONGER_S: [f64; 6] = [0.0, 0.3, 1.0, 3.0, 8.0, 20.0];

pub fn exact_stops(effect: Effect, context: &Context) -> Vec<Hypothesis> {
    let gaps = gaps(context.runs);
    let trials = gaps.iter().map(|(low, high)| 0.5 * (low + high)).collect();
    let report = move |angle: f64| {
        let mut all = vec![(ANGLE, Reported::Number(angle.to_degrees()))];
        if let Some((low, high)) = gaps.iter().find(|(low, high)| *low <= angle && angle <= *high) {
            all.push((BETWEEN, Reported::List(vec![low.to_degrees(), high.to_degrees()])));
        }
        all
    };
    let never = std::f64::consts::PI;
    let handle = Handle::number("interpolator.exact_stop_angle_deg");
    let freed = Freed::new(handle, never, (0.0, never), Scale::Difference);
    vec![Hypothesis::single(effect, freed, trials, report).at_trials_only()]
}

/// Waits for position at the full stops that there are, and at the ends of rapid moves, which it makes some.
pub fn in_position_waits(effect: Effect, context: &Context) -> Vec<Hypothesis> {
    let Context { machine, runs, .. } = context;
    let has_rapid = runs.iter().any(Run::has_rapid);
    let has_stops = machine.interpolator.stopping_angle() < std::f64::consts::PI
        || runs.iter().any(|run| run.toolpath.segments.iter().any(|segment| segment.exact_stop));
    let of = |at: InPosition| {
        let freed = Freed::new(Handle::number("halts.in_position_s"), 0.05, (1e-4, 60.0), Scale::Ratio)
            .counted_in_cycles()
            .also(move |machine| machine.halts.in_position_at = at);
        let report = move |value| vec![(SECONDS, Reported::Number(value)), (AT, Reported::word(at.word()))];
        Hypothesis::single(effect, freed, ratios(2e-3, 2.0, 8), report).variant(at.word())
    };
    let kinds = [(InPosition::RapidEnds, has_rapid), (InPosition::ExactStops, has_stops)];
    kinds.into_iter().filter(|(_, is_offered)| *is_offered).map(|(at, _)| of(at)).collect()
}

/// Waits of the feed at S words in blocks of motion.
pub fn spindle_waits(effect: Effect, context: &Context) -> Vec<Hypothesis> {
    if context.runs.iter().all(|run| run.toolpath.speed_changes().next().is_none()) {
        return Vec::new();
    }
    let freed = Freed::new(Handle::number("times.spindle_change_s"), 1.0, (1e-3, 60.0), Scale::Ratio);
    let report = |value| vec![(SECONDS, Reported::Number(value)), (AT, Reported::word("S words"))];
    vec![Hypothesis::single(effect, freed.counted_in_cycles(), ratios(0.05, 10.0, 10), report)]
}

/// Longer or shorter waits at each kind of stop.
pub fn waits(effect: Effect, context: &Context) -> Vec<Hypothesis> {
    let Context { machine, runs, .. } = context;
    let mut lines: BTreeMap<Kind, Vec<u32>> = BTreeMap::new();
    for stop in runs.iter().flat_map(|run| &run.toolpath.stops) {
        if let Some(kind) = Kind::of(&stop.cause) {
            lines.entry(kind).or_default().push(stop.line.0);
        }
    }
    // Of words that are not told apart all explain the same: those come first of which the machine file says nothing.
    let mut waits: Vec<(Kind, Vec<u32>)> = lines.into_iter().collect();
    waits.sort_by_key(|(kind, _)| 0.0 < kind.value(machine));
    let companions = companions(runs);
    let of = |(kind, lines): (Kind, Vec<u32>)| {
        let others =
            companions[&kind].iter().filter(|other| **other != kind && companions[other].contains(&kind));
        wait(effect, kind, kind.value(machine), lines[0], others.map(|other| other.word()).collect())
    };
    waits.into_iter().map(of).collect()
}

/// Angles (rad) between which no corner of the programs turns: any least angle in one of them stops at the
/// same corners.
fn gaps(runs: &[Run]) -> Vec<(f64, f64)> {
    let mut turns = vec![0.0];
    for run in runs {
        turns.extend(run.toolpath.segments.pairs().map(|(before, after)| {
            let (before, after) = (before.tangent(before.length), after.tangent(0.0));
            (before - after).norm().atan2((before + after).norm()) * 2.0
        }));
    }
    turns.sort_by(f64::total_cmp);
    let mut gaps: Vec<(f64, f64)> =
        turns.windows(2).map(|pair| (pair[0], pair[1])).filter(|(low, high)| CLOSE < high - low).collect();
    gaps.sort_by(|a, b| (b.1 - b.0).total_cmp(&(a.1 - a.0)));
    gaps.truncate(MOST_ANGLES);
    gaps.sort_by(|a, b| a.0.total_cmp(&b.0));
    // At all ends of blocks, even where nothing turns.
    gaps.insert(0, (0.0, 0.0));
    gaps
}

/// For each kind of stop those that come with each of its stops, without motion or a mark between them.
fn companions(runs: &[Run]) -> BTreeMap<Kind, BTreeSet<Kind>> {
    let mut all: BTreeMap<Kind, BTreeSet<Kind>> = BTreeMap::new();
    for run in runs {
        // The stops after which a mark tells them from the next one.
        let told: BTreeSet<usize> = (run.alignment.marks.iter())
            .filter_map(|mark| match mark.place {
                Place::After(stop) => Some(stop),
                Place::Stop(stop) => stop.checked_sub(1),
                Place::Start | Place::Along(_) => None,
            })
            .collect();
        let stops: Vec<(usize, &Stop)> = run.toolpath.stops.iter().enumerate().collect();
        for group in stops.chunk_by(|a, b| a.1.after == b.1.after && !told.contains(&a.0)) {
            let kinds: BTreeSet<Kind> = group.iter().filter_map(|(_, stop)| Kind::of(&stop.cause)).collect();
            for kind in &kinds {
                let beside = if kinds.len() <= MOST_BESIDE { kinds.clone() } else { [*kind].into() };
                all.entry(*kind).or_insert_with(|| beside.clone()).retain(|other| beside.contains(other));
            }
        }
    }
    all
}

/// Longer or shorter waits at one kind of stop, from which others are not told apart.
fn wait(effect: Effect, kind: Kind, believed: f64, line: u32, others: Vec<String>) -> Hypothesis {
    let report = move |value: f64| {
        let mut all = vec![
            (LINE, Reported::Number(f64::from(line))),
            (CODE, Reported::Word(kind.word())),
            (SECONDS, Reported::Number(value - believed)),
        ];
        if !others.is_empty() {
            all.push((OR_CODE, Reported::Word(others.join(", "))));
        }
        all
    };
    let trials = LONGER_S.iter().map(|seconds| believed + seconds).collect();
    Hypothesis::single(effect, kind.freed(believed), trials, report).variant(kind.word())
}
