//! Profile → contour error: how far the filtered path leaves the programmed one.
//!
//! The error at a programmed point X is its distance from the filtered path nearby,
//!
//! ```text
//! e(X) = min over t of ‖P(t) − X‖
//! ```
//!
//! It is measured where it is largest: at every corner, and along arcs at a quarter of the filter
//! delay or closer. Between corners a line is nearer to the filtered path than at its ends. At an isolated
//! corner e is the tolerance that the corner law was asked to keep; where several corners lie
//! under one filter delay, it is what the isolated law cannot know.
//!
//! The search begins half a filter delay after X was commanded and follows the gradient (Newton's
//! method without the curvature term); it stays within the delay, so it cannot stray to another
//! pass over the same place.

mod guaranteed;

pub use guaranteed::plan_within;

use crate::simulation::feed::{FeedPlan, Phase};
use crate::simulation::profile::{Motion, Profile};
use crate::simulation::toolpath::{Curve, Point, Toolpath};

/// Contour errors along a program, as columns of equal length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ContourErrors {
    /// Distance of the programmed point along the path, mm.
    pub distance: Vec<f64>,
    /// Distance of the filtered path from it, mm.
    pub error: Vec<f64>,
    /// Index of the segment that ends at the corner, or of the arc.
    pub segment: Vec<u32>,
    /// Whether the point lies along an arc; otherwise it is a corner.
    pub on_arc: Vec<bool>,
}

impl ContourErrors {
    /// The largest error, mm; 0 for a program without corners and arcs.
    pub fn largest(&self) -> f64 {
        self.error.iter().copied().fold(0.0, f64::max)
    }
}

/// Most points measured on one arc.
const POINTS_ON_ARC: f64 = 64.0;

/// Measures the contour error of a profile at all corners and arcs.
pub fn contour_errors(toolpath: &Toolpath, plan: &FeedPlan, profile: &Profile) -> ContourErrors {
    let mut errors = ContourErrors::default();
    for phase in &plan.phases {
        let Phase::Motion(stretch) = phase else { continue };
        let motion = profile.motion(stretch);
        let mut commanded = 0.0;
        for index in stretch.pulses.clone() {
            let pulse = &plan.pulses[index];
            let segment = &toolpath.segments[pulse.segment as usize];
            let mut measure = |point: Point, time: f64, offset: f64, on_arc: bool| {
                errors.distance.push(profile.distance_before(pulse.segment as usize) + offset);
                errors.error.push(distance_from_path(&motion, point, time));
                errors.segment.push(pulse.segment);
                errors.on_arc.push(on_arc);
            };
            if let Curve::Arc(_) = segment.curve {
                let points = (4.0 * pulse.duration / motion.filter().delay()).ceil().min(POINTS_ON_ARC);
                for i in 0..points as usize {
                    let elapsed = (i as f64 + 0.5) / points * pulse.duration;
                    let slope = (pulse.feedrate[1] - pulse.feedrate[0]) / pulse.duration;
                    let offset = pulse.offset + elapsed * (pulse.feedrate[0] + 0.5 * slope * elapsed);
                    measure(segment.point(offset), commanded + elapsed, offset, true);
                }
            }
            commanded += pulse.duration;
            let ends = plan.pulses.get(index + 1).is_some_and(|next| next.segment != pulse.segment);
            if ends && index + 1 < stretch.pulses.end {
                measure(segment.end, commanded, segment.length, false);
            }
        }
    }
    errors
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
