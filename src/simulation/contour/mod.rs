//! Profile → contour error: how far the filtered path leaves the programmed one.
//!
//! The error at a programmed point X is its distance from the filtered path nearby,
//!
//! ```text
//! e(X) = min over t of ‖P(t) − X‖
//! ```
//!
//! It is measured where it is largest: at every corner, and along arcs at a quarter of the filter
//! delay or closer. Between corners a line is nearer to the filtered path than at its ends. At an
//! isolated corner e is the tolerance that the corner law was asked to keep; where several corners
//! lie under one filter delay, it is what the isolated law cannot know.
//!
//! The search begins half a filter delay after X was commanded and follows the gradient (Newton's
//! method without the curvature term); it stays within the delay, so it cannot stray to another
//! pass over the same place.

mod guaranteed;

pub use guaranteed::plan_within;

use crate::simulation::feed::{FeedPlan, Phase, Stretch};
use crate::simulation::profile::{Motion, Profile};
use crate::simulation::toolpath::{Curve, Point, Toolpath};

/// Contour errors along a program, one entry a segment.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ContourErrors {
    /// At the corner that ends the segment, mm; 0 at a full stop.
    pub corner: Vec<f64>,
    /// Largest along the segment where it is an arc, mm; 0 along a line.
    pub arc: Vec<f64>,
}

impl ContourErrors {
    /// The largest error, mm; 0 for a program without corners and arcs.
    pub fn largest(&self) -> f64 {
        self.corner.iter().chain(&self.arc).copied().fold(0.0, f64::max)
    }
}

/// Most points measured on one arc.
const POINTS_ON_ARC: f64 = 64.0;

/// Measures the contour error of a profile at all corners and arcs.
pub fn contour_errors(toolpath: &Toolpath, plan: &FeedPlan, profile: &Profile) -> ContourErrors {
    let count = toolpath.segments.len();
    let mut errors = ContourErrors { corner: vec![0.0; count], arc: vec![0.0; count] };
    measure(toolpath, plan, profile, &mut errors, |_| true);
    errors
}

/// Measures again the errors of the segments that `wanted` names.
fn measure(
    toolpath: &Toolpath,
    plan: &FeedPlan,
    profile: &Profile,
    errors: &mut ContourErrors,
    wanted: impl Fn(usize) -> bool,
) {
    for stretch in stretches(plan) {
        let motion = profile.motion(stretch);
        let delay = motion.filter().delay();
        for index in stretch.pulses.clone() {
            let pulse = &plan.pulses[index];
            let number = pulse.segment as usize;
            if !wanted(number) {
                continue;
            }
            let segment = &toolpath.segments[number];
            let commanded = motion.pulse_start(index);
            if pulse.offset == 0.0 {
                errors.arc[number] = 0.0;
            }
            if let Curve::Arc(_) = segment.curve {
                let points = (4.0 * pulse.duration / delay).ceil().min(POINTS_ON_ARC);
                for i in 0..points as usize {
                    let elapsed = (i as f64 + 0.5) / points * pulse.duration;
                    let slope = (pulse.feedrate[1] - pulse.feedrate[0]) / pulse.duration;
                    let offset = pulse.offset + elapsed * (pulse.feedrate[0] + 0.5 * slope * elapsed);
                    let error = distance_from_path(&motion, segment.point(offset), commanded + elapsed);
                    errors.arc[number] = errors.arc[number].max(error);
                }
            }
            let goes_on = index + 1 < stretch.pulses.end;
            if goes_on && plan.pulses[index + 1].segment != pulse.segment {
                errors.corner[number] = distance_from_path(&motion, segment.end, commanded + pulse.duration);
            }
        }
    }
}

/// Distance (mm) of the filtered path from a point that was commanded at `commanded` (s since the
/// beginning of the stretch).
pub fn distance_from_path(motion: &Motion, point: Point, commanded: f64) -> f64 {
    let delay = motion.filter().delay();
    let mut time = commanded + 0.5 * delay;
    let mut nearest = f64::INFINITY;
    for _ in 0..20 {
        let state = motion.state(motion.moment(time));
        let away = state.position - point;
        let distance = away.norm();
        let improved = distance < nearest * (1.0 - 1e-9);
        nearest = nearest.min(distance);
        let speed = state.velocity.norm_squared();
        if !improved || speed == 0.0 {
            break;
        }
        time = (time - away.dot(&state.velocity) / speed).clamp(commanded, commanded + delay);
    }
    nearest
}

/// The stretches of a plan in order.
fn stretches(plan: &FeedPlan) -> impl Iterator<Item = &Stretch> {
    plan.phases.iter().filter_map(|phase| match phase {
        Phase::Motion(stretch) => Some(stretch),
        Phase::Wait(_) => None,
    })
}
