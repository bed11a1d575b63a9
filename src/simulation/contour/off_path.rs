//! Profile → off-path spans: places where the filtered path strays from the programmed one between its
//! corners.
//!
//! Contour errors are measured from programmed points. If several corners lie within one filter delay D,
//! points of the filtered path between them may be farther from the programmed path than any corner is from
//! the filtered path:
//!
//! ```text
//!      +--------+      the filtered path passes near all four corners,
//!      |        |      and yet bulges out between two of them
//!   ---+        +---
//! ```
//!
//! The filtered path is therefore sampled every D/24. Each sample follows the segments commanded within the
//! last D; its distance is the distance from the nearest of them.
//!
//! Limits: between two samples the path may stray a little farther, by the height of an arc over D/24: on 2
//! of 40,000 hostile paths by more than 1 part in 10,000 of the tolerance, and on these by 5 parts.

use std::ops::Range;

use crate::simulation::contour::arcs::POINTS_PER_DELAY;
use crate::simulation::contour::nearest::distance_from_segment;
use crate::simulation::feed::FeedPlan;
use crate::simulation::profile::{Profile, RememberedSteps};
use crate::simulation::toolpath::{Curve, Toolpath};

/// A place where the filtered path strays.
pub(super) struct OffPathSpan {
    /// Indices of the segments that it follows there.
    pub segments: Range<usize>,
    /// Distance from these segments over the largest distance allowed on any of them; more than 1.
    pub ratio: f64,
}

/// Returns the places where the filtered path is farther from the programmed one than `allowed` (mm, one
/// entry per segment) on the segments that it follows.
pub(super) fn off_path_spans(
    toolpath: &Toolpath,
    plan: &FeedPlan,
    profile: &Profile,
    allowed: &[f64],
) -> Vec<OffPathSpan> {
    let mut found = Vec::new();
    for rest_to_rest in plan.rest_to_rest_motions().filter(|rest_to_rest| !rest_to_rest.pulses.is_empty()) {
        let mut steps = RememberedSteps::of(profile.motion(rest_to_rest));
        let delay = plan.filters[rest_to_rest.filter].delay();
        let (pulses, last) = (&plan.pulses, rest_to_rest.pulses.end - 1);
        // The pulses commanded now, half a delay ago and a delay ago.
        let [mut newest, mut middle, mut oldest] = [rest_to_rest.pulses.start; 3];
        let step = delay / POINTS_PER_DELAY;
        let mut time = 0.0;
        loop {
            let now = steps.cursor.moment_from(newest, time);
            newest = now.pulse;
            oldest = steps.cursor.moment_from(oldest, (time - delay).max(0.0)).pulse;
            let followed = pulses.segment(oldest)..pulses.segment(newest) + 1;
            let is_line = followed.len() == 1 && *toolpath.segments.curve(followed.start) == Curve::Line;
            if is_line || oldest == newest {
                // The filters do not shift the path along a line, and they shift it along an arc by as much
                // as at the measured points.
                if newest == last {
                    break;
                }
                time = steps.cursor.pulse_start(newest + 1).max(time + step);
                continue;
            }
            let point = steps.state(now).position;
            let half_ago = steps.cursor.moment_from(middle, (time - 0.5 * delay).max(0.0));
            middle = half_ago.pulse;
            let likely = pulses.segment(middle);
            let along = pulses.at(middle).offset_after(half_ago.elapsed);
            let distance = |number: usize| {
                let segment = toolpath.segments.at(number);
                let near = match number {
                    _ if number < likely => segment.length,
                    _ if likely < number => 0.0,
                    _ => along.clamp(0.0, segment.length),
                };
                distance_from_segment(&segment, near, point)
            };
            if allowed[likely] < distance(likely) {
                let nearest = followed.clone().map(distance).fold(f64::INFINITY, f64::min);
                let most = allowed[followed.clone()].iter().copied().fold(0.0, f64::max);
                // With an allowance of 0 the machine stops at every corner.
                if 0.0 < most && most < nearest {
                    found.push(OffPathSpan { segments: followed, ratio: nearest / most });
                }
            }
            time += step;
            // At very low feedrates a step may be less than the resolution of time.
            if time + step <= time {
                break;
            }
        }
    }
    found
}
