//! Effects at places: full stops and waits.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::identification::calibration::Kind;
use crate::identification::fit::{Freed, Run, Scale};
use crate::identification::hypotheses::{Hypothesis, Report, Reported, Trace, ratios};
use crate::machine::{InPosition, Machine};
use crate::simulation::toolpath::Motion;

/// Angles tried first as the least that stops, °.
const ANGLES: [f64; 13] = [0.0, 2.0, 5.0, 10.0, 15.0, 20.0, 30.0, 40.0, 50.0, 60.0, 80.0, 100.0, 130.0];

pub fn hypotheses(machine: &Machine, runs: &[Run]) -> Vec<Hypothesis> {
    let report: Report = Arc::new(|values| vec![("angle_deg", Reported::Number(values[0].to_degrees()))]);
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
            trials: ANGLES.iter().map(|angle| vec![f64::to_radians(*angle)]).collect(),
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
    all.extend(lines.into_iter().map(|(kind, lines)| wait(kind, kind.value(machine), lines[0])));
    all
}

/// Waits for position at the full stops that there are, and at the ends of rapid moves, which it makes some.
fn in_position(machine: &Machine, runs: &[Run]) -> Vec<Hypothesis> {
    let mut all = Vec::new();
    let has_rapid =
        runs.iter().any(|run| run.toolpath.segments.iter().any(|segment| segment.motion == Motion::Rapid));
    let has_stops = machine.interpolator.exact_stop_angle < std::f64::consts::PI
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

/// Longer or shorter waits at one kind of stop.
fn wait(kind: Kind, believed: f64, line: u32) -> Hypothesis {
    let report: Report = Arc::new(move |values| {
        vec![
            ("line", Reported::Number(f64::from(line))),
            ("code", Reported::Word(kind.word())),
            ("seconds", Reported::Number(values[0] - believed)),
        ]
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
