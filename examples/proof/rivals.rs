//! What others would make of a recording, and what each says of another program.
//!
//! | rival | what it learns from the recording |
//! |---|---|
//! | believed | nothing |
//! | factor | cycle time recorded / cycle time simulated |
//! | refit | T1 and contour tolerance, by least squares |
//! | nearest | the time lost by the five blocks most alike: a model without physics |
//! | diagnosis | the causes, as the machine with them |
//!
//! All know that the second program runs at another tolerance, by its ratio to the first one's.

use std::ops::Range;

use serde_json::{Value, json};
use truefeed::identification::comparison::{Comparison, VisitTimes, compare};
use truefeed::identification::fit::{AlignedRun, FreeParameter, Run, VariationScale, Whitening, fit};
use truefeed::machine::{Handle, Machine};
use truefeed::simulation::simulate;
use truefeed::simulation::toolpath::{Curve, Motion, Toolpath};

/// Blocks that the model without physics takes the mean of.
const NEAREST: usize = 5;

/// What is known of a machine by one run.
pub struct Rivals<'a> {
    /// As one believes it to be.
    pub machine: &'a Machine,
    /// The run.
    pub run: &'a Run<'a>,
    /// With the causes that were named.
    pub diagnosed: &'a Machine,
    /// Tolerance of the second program, in multiples of the first one's.
    pub ratio: f64,
}

impl Rivals<'_> {
    /// The errors of each on another program of the machine: cycle time, s, and feedrate, mm/min.
    pub fn on(&self, other: &AlignedRun) -> Value {
        let here = compared(self.machine, self.run);
        let refitted = refit(self.machine, self.run);
        let there = other.run_ignoring_overrides();
        let of = |machine: &Machine| {
            let mut machine = machine.clone();
            machine.interpolator.contour_tolerance *= self.ratio;
            compared(&machine, &there)
        };
        let (believed, refitted, diagnosed) = (of(self.machine), of(&refitted), of(self.diagnosed));
        let recorded = believed.whole.recorded;
        let physical = |comparison: &Comparison| {
            json!({
                "cycle_time_error_s": comparison.whole.simulated - recorded,
                "feed_rmse_mm_min": comparison.feed.map(|feed| 60.0 * feed.rms),
            })
        };
        let timed =
            |seconds: f64| json!({"cycle_time_error_s": seconds - recorded, "feed_rmse_mm_min": null});
        let factor = here.whole.recorded / here.whole.simulated;
        let blocks = Blocks::of(self.run.toolpath, &here.lost);
        let lost = blocks.lost_by(&Blocks::of(there.toolpath, &believed.lost));
        json!({
            "recorded_s": recorded,
            "believed": physical(&believed),
            "factor": timed(factor * believed.whole.simulated),
            "refit": physical(&refitted),
            "nearest": timed(believed.whole.simulated + lost),
            "diagnosis": physical(&diagnosed),
        })
    }
}

fn compared(machine: &Machine, run: &Run) -> Comparison {
    compare(run.toolpath, &simulate(run.toolpath, machine), run.alignment)
}

/// The machine with T1 and tolerance as the run would have them.
fn refit(machine: &Machine, run: &Run) -> Machine {
    let runs = [run.clone()];
    let ratio = |key| {
        let handle = Handle::number(key);
        let start = handle.get(machine)?;
        Some(FreeParameter::new(handle, start, (0.1 * start, 10.0 * start), VariationScale::Ratio))
    };
    let freed: Vec<FreeParameter> = ["interpolator.time_constant_s", "interpolator.contour_tolerance_mm"]
        .into_iter()
        .filter_map(ratio)
        .collect();
    let whitening = Whitening::of(run.alignment, &run.residuals(machine));
    fit(machine, &runs, &freed, &[whitening], 1e-4, &mut |_| {}).machine
}

/// What a model without physics sees of the blocks of a program.
struct Blocks {
    /// What describes each block.
    features: Vec<[f64; 11]>,
    /// What each lost, s.
    lost: Vec<f64>,
}

impl Blocks {
    fn of(toolpath: &Toolpath, lost: &[VisitTimes]) -> Blocks {
        let mut ends = vec![0.0];
        for segment in &toolpath.segments {
            ends.push(ends[ends.len() - 1] + segment.length);
        }
        let features = lost.iter().map(|visit| features(toolpath, &ends, &visit.distance, visit)).collect();
        Blocks { features, lost: lost.iter().map(VisitTimes::seconds).collect() }
    }

    /// What the blocks of another program would lose together, s.
    fn lost_by(&self, others: &Blocks) -> f64 {
        let spread = |at: usize| {
            let mean = self.features.iter().map(|f| f[at]).sum::<f64>() / self.features.len() as f64;
            let squares = self.features.iter().map(|f| (f[at] - mean).powi(2)).sum::<f64>();
            (squares / self.features.len() as f64).sqrt().max(1e-6)
        };
        let spreads: [f64; 11] = std::array::from_fn(spread);
        let like = |block: &[f64; 11]| {
            let distance =
                |own: &[f64; 11]| (0..11).map(|k| ((own[k] - block[k]) / spreads[k]).powi(2)).sum::<f64>();
            let mut all: Vec<(f64, f64)> =
                self.features.iter().map(distance).zip(self.lost.iter().copied()).collect();
            let count = NEAREST.min(all.len());
            if count == 0 {
                return 0.0;
            }
            all.select_nth_unstable_by(count - 1, |a, b| a.0.total_cmp(&b.0));
            all[..count].iter().map(|(_, lost)| lost).sum::<f64>() / count as f64
        };
        others.features.iter().map(like).sum()
    }
}

/// Nominal time and length as logarithms, feedrate, angles turned at start and end, curvature, direction,
/// whether it is a rapid, whether the machine waits in it, and time simulated by nominal time.
fn features(toolpath: &Toolpath, ends: &[f64], range: &Range<f64>, visit: &VisitTimes) -> [f64; 11] {
    let length = range.end - range.start;
    let middle = 0.5 * (range.start + range.end);
    let at = ends.partition_point(|end| *end <= middle).clamp(1, toolpath.segments.len().max(1)) - 1;
    let simulated = visit.simulated.end - visit.simulated.start;
    let Some(segment) = toolpath.segments.get(at) else { return [0.0; 11] };
    let turn_after = |k: usize| {
        let Some((a, b)) = toolpath.segments.get(k).zip(toolpath.segments.get(k + 1)) else { return 0.0 };
        a.tangent(a.length).dot(&b.tangent(0.0)).clamp(-1.0, 1.0).acos()
    };
    let (rapid, feedrate) = match segment.motion {
        Motion::Feed { feedrate } => (0.0, feedrate),
        Motion::Rapid { .. } => (1.0, 0.0),
    };
    let nominal = if 0.0 < feedrate { length / feedrate } else { simulated };
    let curvature = match &segment.curve {
        Curve::Line => 0.0,
        Curve::Arc(_) => {
            let step = 1e-3 * segment.length;
            (segment.tangent(step) - segment.tangent(0.0)).norm() / step
        }
    };
    let direction = segment.tangent(0.5 * segment.length);
    [
        (nominal + 1e-4).ln(),
        (length + 1e-3).ln(),
        feedrate,
        at.checked_sub(1).map_or(0.0, turn_after),
        turn_after(at),
        curvature,
        direction.x.abs(),
        direction.y.abs(),
        rapid,
        f64::from(u8::from(visit.waits())),
        (simulated / nominal.max(1e-6)).min(10.0),
    ]
}
