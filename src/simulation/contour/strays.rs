//! Profile → where the filtered path strays from the programmed one between its corners.
//!
//! Contour errors are those of programmed points. Where several corners lie under one filter delay D, points of the filtered
//! path between them may be farther from the path than every corner is from them:
//!
//! ```text
//!      +--------+      the filtered path passes near all four corners,
//!      |        |      and yet bulges out between two of them
//!   ---+        +---
//! ```
//!
//! So the filtered path is gone along, D/24 at a time. What it follows is what was commanded within the last D; its distance
//! from that is the distance from the nearest segment.
//!
//! Limits: between two moments it may stray a little farther, by what a bow of D/24 is high: on 2 of 40,000 hostile paths by
//! more than 1 part in 10,000 of the tolerance, and there by 5.

use std::ops::Range;

use crate::simulation::contour::{POINTS_PER_DELAY, distance_from_segment};
use crate::simulation::feed::FeedPlan;
use crate::simulation::profile::{Profile, Steps};
use crate::simulation::toolpath::{Curve, Toolpath};

/// A place where the filtered path strays.
pub(super) struct Stray {
    /// The segments that it follows there.
    pub segments: Range<usize>,
    /// How far from them it is, as a part of what is allowed on any of them; more than 1.
    pub ratio: f64,
}

/// Where the filtered path is farther from the programmed one than is allowed (mm) on the segments it follows, one entry a
/// segment.
pub(super) fn strays(toolpath: &Toolpath, plan: &FeedPlan, profile: &Profile, allowed: &[f64]) -> Vec<Stray> {
    let mut found = Vec::new();
    for stretch in plan.stretches().filter(|stretch| !stretch.pulses.is_empty()) {
        let mut steps = Steps::of(profile.motion(stretch));
        let delay = plan.filters[stretch.filter].delay();
        let (pulses, last) = (&plan.pulses, stretch.pulses.end - 1);
        // The pulses commanded now, half a delay ago and a delay ago.
        let [mut newest, mut middle, mut oldest] = [stretch.pulses.start; 3];
        let step = delay / POINTS_PER_DELAY;
        let mut time = 0.0;
        loop {
            let now = steps.walk.moment_from(newest, time);
            newest = now.pulse;
            oldest = steps.walk.moment_from(oldest, (time - delay).max(0.0)).pulse;
            let followed = pulses.segment(oldest)..pulses.segment(newest) + 1;
            let is_line = followed.len() == 1 && *toolpath.segments.curve(followed.start) == Curve::Line;
            if is_line || oldest == newest {
                // Nothing is cut short along a line, and as much of an arc everywhere as at the points measured on it.
                if newest == last {
                    break;
                }
                time = steps.walk.pulse_start(newest + 1).max(time + step);
                continue;
            }
            let point = steps.state(now).position;
            let half_ago = steps.walk.moment_from(middle, (time - 0.5 * delay).max(0.0));
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
                // Where nothing at all is allowed the machine stands at every corner.
                if 0.0 < most && most < nearest {
                    found.push(Stray { segments: followed, ratio: nearest / most });
                }
            }
            time += step;
            // At feedrates that take for ever a step is less than time can be told.
            if time + step <= time {
                break;
            }
        }
    }
    found
}
