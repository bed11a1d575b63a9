//! Effects at places: full stops and waits.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use crate::identification::alignment::Place;
use crate::identification::calibration::Kind;
use crate::identification::fit::{Freed, Run, Scale};
use crate::identification::hypotheses::{Hypothesis, Report, Reported, Trace, ratios};
use crate::machine::{InPosition, Machine};
use crate::simulation::toolpath::Stop;

/// Angles between which no corner turns are one, where they are closer than this, rad.
const CLOSE: f64 = 0.01;
/// Least angles that stop, at most so many; the widest gaps between corners first.
const MOST_ANGLES: usize = 16;

/// Kinds of stops that are looked at beside one another, at most.
const MOST_BESIDE: usize = 8;

pub fn hypotheses(machine: &Machine, runs: &[Run]) -> Vec<Hypothesis> {
    let gaps = gaps(runs);
    let trials = gaps.iter().map(|(low, high)| vec![0.5 * (low + high)]).collect();
    let report: Report = Arc::new(move |values| {
        let mut all = vec![("angle_deg", Reported::Number(values[0].to_degrees()))];
        if let Some((low, high)) = gaps.iter().find(|(low, high)| *low <= values[0] && values[0] <= *high) {
            all.push(("between_deg", Reported::List(vec![low.to_degrees(), high.to_degrees()])));
        }
        all
    });
    let angle = Freed::number(
        "interpolator.exact_stop_angle_deg",
        std::f64::consts::PI,
        (0.0, std::f64::consts::PI),
        Scale::Difference,
    );
    let mut all: Vec<Hypothesis> = angle
        .map(|angle| Hypothesis {
            id: "exact_stop",
            variant: String::new(),
            trace: Trace::Time,
            freed: vec![angle],
            trials,
            is_continuous: false,
            report,
        })
        .into_iter()
        .collect();
    all.extend(in_position(machine, runs));
    let mut lines: BTreeMap<Kind, Vec<u32>> = BTreeMap::new();
    for run in runs {
        for stop in &run.toolpath.stops {
            if let Some(kind) = Kind::of(&stop.cause) {
                lines.entry(kind).or_default().push(stop.line.0);
            }
        }
    }
    // Of words that are not told apart all explain the same: those come first of which the machine file says nothing.
    let mut waits: Vec<(Kind, Vec<u32>)> = lines.into_iter().collect();
    waits.sort_by_key(|(kind, _)| 0.0 < kind.value(machine));
    let companions = companions(runs);
    all.extend(waits.into_iter().map(|(kind, lines)| {
        let others =
            companions[&kind].iter().filter(|other| **other != kind && companions[other].contains(&kind));
        wait(kind, kind.value(machine), lines[0], others.map(|other| other.word()).collect())
    }));
    all
}

/// Waits for position at the full stops that there are, and at the ends of rapid moves, which it makes some.
fn in_position(machine: &Machine, runs: &[Run]) -> Vec<Hypothesis> {
    let mut all = Vec::new();
    let has_rapid = runs.iter().any(Run::has_rapid);
    let has_stops = machine.interpolator.stopping_angle() < std::f64::consts::PI
        || runs.iter().any(|run| run.toolpath.segments.iter().any(|segment| segment.exact_stop));
    for (at, is_offered) in [(InPosition::RapidEnds, has_rapid), (InPosition::ExactStops, has_stops)] {
        if !is_offered {
            continue;
        }
        let freed =
            Freed::new("halts.in_position_s", 0.05, (1e-4, 60.0), Scale::Ratio, move |machine, value| {
                machine.halts.in_position = value;
                machine.halts.in_position_at = at;
            });
        let report: Report = Arc::new(move |values| {
            vec![("seconds", Reported::Number(values[0])), ("at", Reported::Word(at.word().to_string()))]
        });
        all.push(Hypothesis {
            id: "in_position_wait",
            variant: at.word().to_string(),
            trace: Trace::Time,
            freed: vec![freed],
            trials: ratios(2e-3, 2.0, 8).into_iter().map(|seconds| vec![seconds]).collect(),
            is_continuous: true,
            report,
        });
    }
    all
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
fn wait(kind: Kind, believed: f64, line: u32, others: Vec<String>) -> Hypothesis {
    let report: Report = Arc::new(move |values| {
        let mut all = vec![
            ("line", Reported::Number(f64::from(line))),
            ("code", Reported::Word(kind.word())),
            ("seconds", Reported::Number(values[0] - believed)),
        ];
        if !others.is_empty() {
            all.push(("or_code", Reported::Word(others.join(", "))));
        }
        all
    });
    let trials = [0.0, 0.3, 1.0, 3.0, 8.0, 20.0];
    Hypothesis {
        id: "unmodelled_wait",
        variant: kind.word(),
        trace: Trace::Time,
        freed: vec![kind.freed(believed)],
        trials: trials.iter().map(|seconds| vec![believed + seconds]).collect(),
        is_continuous: true,
        report,
    }
}
