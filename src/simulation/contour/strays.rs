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
use crate::simulation::feed::{FeedPlan, Pulses};
use crate::simulation::profile::{Moment, Profile, Steps};
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
        let at_rest = || Command {
            pulses: &plan.pulses,
            end: stretch.pulses.end,
            pulse: stretch.pulses.start,
            since: 0.0,
        };
        let (mut newest, mut middle, mut oldest) = (at_rest(), at_rest(), at_rest());
        let step = delay / POINTS_PER_DELAY;
        let mut time = 0.0;
        loop {
            newest.go_to(time);
            oldest.go_to(time - delay);
            let followed = oldest.segment()..newest.segment() + 1;
            let is_line = followed.len() == 1 && *toolpath.segments.curve(followed.start) == Curve::Line;
            if is_line || oldest.pulse == newest.pulse {
                // Nothing is cut short along a line, and as much of an arc everywhere as at the points measured on it.
                if newest.is_last() {
                    break;
                }
                time = newest.ends().max(time + step);
                continue;
            }
            middle.go_to(time - 0.5 * delay);
            let point = steps.state(Moment { pulse: newest.pulse, elapsed: time - newest.since }).position;
            let likely = middle.segment();
            let distance = |number: usize| {
                let segment = toolpath.segments.at(number);
                let near = match number {
                    _ if number < likely => segment.length,
                    _ if likely < number => 0.0,
                    _ => middle.offset(time - 0.5 * delay).clamp(0.0, segment.length),
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
            let is_over = oldest.is_last() && oldest.ends() <= time - delay;
            // At feedrates that take for ever a step is less than time can be told.
            if is_over || time + step <= time {
                break;
            }
        }
    }
    found
}

/// What is commanded at a moment of a stretch; the last pulse once that is over.
struct Command<'a> {
    pulses: &'a Pulses,
    /// One past the last pulse of the stretch.
    end: usize,
    pulse: usize,
    /// When it began, s since the beginning of the stretch.
    since: f64,
}

impl Command<'_> {
    /// Goes on to a later time (s).
    fn go_to(&mut self, time: f64) {
        while self.ends() <= time && !self.is_last() {
            self.since = self.ends();
            self.pulse += 1;
        }
    }

    fn ends(&self) -> f64 {
        self.since + self.pulses.duration(self.pulse)
    }

    fn is_last(&self) -> bool {
        self.pulse + 1 == self.end
    }

    fn segment(&self) -> usize {
        self.pulses.segment(self.pulse)
    }

    /// How far along its segment the command is at a time within the pulse (s), mm.
    fn offset(&self, time: f64) -> f64 {
        let [first, last] = self.pulses.at(self.pulse).feedrate;
        let elapsed = time - self.since;
        let part = elapsed / self.pulses.duration(self.pulse);
        self.pulses.offset(self.pulse) + elapsed * (first + 0.5 * part * (last - first))
    }
}
