//! Before and after on one chart: the recorded feedrate, those simulated for the machine before and for the
//! machine with its causes, and the time lost against both, over distance.

use crate::identification::comparison::{Comparison, lost_time_curve, pointwise};
use crate::identification::diagnosis::Diagnosis;
use crate::identification::fit::Run;
use crate::machine::Machine;
use crate::plot::{FeedChart, FeedrateCurve, LostTime, Programmed};
use crate::simulation::profile::Profile;

/// The chart of a diagnosed run.
pub struct RunChart {
    /// Chart.
    pub chart: FeedChart,
    /// Time between points of a simulated curve, s, if they are too few to follow it.
    pub(super) spacing: Option<f64>,
}

/// Returns the chart of the diagnosed run with this index on the machine `before`; `None` if there is no such
/// run.
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
    let recorded = FeedrateCurve {
        label: "recorded".to_string(),
        distance: rows.distance,
        feedrate: rows.recorded.into(),
        time: rows.recorded_time.into_iter().map(|time| time - begin).collect(),
        ..FeedrateCurve::default()
    };
    let mut spacing: Option<f64> = None;
    let mut simulated = |label: &str, machine: &Machine| {
        let plan = run.plan(machine);
        let curve = Profile::new(run.toolpath, &plan).drawn();
        spacing = spacing.into_iter().chain(curve.spacing).reduce(f64::max);
        let (distance, feedrate, time) = (curve.distance, curve.feedrate.into(), curve.time);
        FeedrateCurve { label: label.to_string(), distance, feedrate, time, ..FeedrateCurve::default() }
    };
    let lost = |comparison: &Comparison| {
        let lost_time_curve = lost_time_curve(run.toolpath, run.alignment, comparison);
        LostTime { distance: lost_time_curve.distance, seconds: lost_time_curve.seconds.into() }
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
