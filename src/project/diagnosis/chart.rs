//! Before and after on the same axes: the recorded feedrate, the simulated ones of the machine before and
//! of the machine with the causes, and the time lost against both, over the distance.

use crate::identification::comparison::{Comparison, course, pointwise};
use crate::identification::diagnosis::Diagnosis;
use crate::identification::fit::Run;
use crate::machine::Machine;
use crate::plot::{Curve, FeedChart, LostTime, Programmed};
use crate::simulation::profile::Profile;

/// The chart of a diagnosed run.
pub struct RunChart {
    /// It.
    pub chart: FeedChart,
    /// Time between the points of a simulated curve, s, where they are too few to follow it.
    pub(super) spacing: Option<f64>,
}

/// The chart of a diagnosed run, `index` of those that were diagnosed on the machine `before`; none where
/// there is no such run.
pub fn diagnosis_chart(
    diagnosis: &Diagnosis,
    before: &Machine,
    runs: &[Run],
    index: usize,
) -> Option<RunChart> {
    let run = runs.get(index)?;
    let plan = run.plan(before);
    let rows = pointwise(run.toolpath, &plan, run.alignment);
    let begin = run.alignment.marks.first().map_or(0.0, |mark| mark.time);
    let recorded = Curve {
        label: "recorded".to_string(),
        distance: rows.distance,
        feedrate: rows.recorded.into(),
        time: rows.recorded_time.into_iter().map(|time| time - begin).collect(),
        ..Curve::default()
    };
    let mut spacing: Option<f64> = None;
    let mut simulated = |label: &str, machine: &Machine| {
        let plan = run.plan(machine);
        let curve = Profile::new(run.toolpath, &plan).drawn();
        spacing = spacing.into_iter().chain(curve.spacing).reduce(f64::max);
        let (distance, feedrate, time) = (curve.distance, curve.feedrate.into(), curve.time);
        Curve { label: label.to_string(), distance, feedrate, time, ..Curve::default() }
    };
    let lost = |comparison: &Comparison| {
        let course = course(run.toolpath, run.alignment, comparison);
        LostTime { distance: course.distance, seconds: course.seconds.into() }
    };
    let chart = FeedChart {
        programmed: Programmed::of(run.toolpath, before),
        curves: vec![
            recorded,
            simulated("simulated before", before),
            simulated("simulated after", &diagnosis.machine),
        ],
        lost: diagnosis.before.get(index).map(lost),
        lost_after: diagnosis.after.get(index).map(lost),
        ..FeedChart::default()
    };
    Some(RunChart { chart, spacing })
}
