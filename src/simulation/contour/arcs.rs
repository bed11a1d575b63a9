//! Contour errors along an arc.
//!
//! A command at the feedrate v along an arc of radius r turns by the angle θ(t) with |θ̇| ≤ v/r. As long as the window of
//! the filters lies within the arc, the filtered path is the mean of points of a circle, and nearer to its center by
//!
//! ```text
//! e = r (1 − |E exp(iθ)|) ≤ r/2 Var(θ) ≤ v² Σ Ti²/(24 r)        variance of the filters: Σ Ti²/12
//! ```
//!
//! At a constant feedrate e is nearly this bound, if the filters turn by a small angle only. So one point at the highest feedrate
//! is often enough: if its error is the bound, no other point of the arc has a larger one.

use std::cmp::Ordering;
use std::ops::Range;

use crate::simulation::contour::nearest::{distance_from_segment, nearest};
use crate::simulation::feed::{Pulse, Pulses, RestToRest};
use crate::simulation::ordered::sort_by_number;
use crate::simulation::profile::{MotionState, RememberedSteps};
use crate::simulation::toolpath::{Arc, Point, Segment, Toolpath};

/// Points measured along an arc within one filter delay. With them an independent search along ten thousand random
/// paths finds an error beyond the tolerance on one at most, by less than 1 % of it (`tests/laws/guaranteed.rs`).
pub(super) const POINTS_PER_DELAY: f64 = 24.0;

/// Most points measured on one pulse of an arc.
const MAX_POINTS_PER_PULSE: f64 = 192.0;

/// Part of the largest possible error along an arc that may be missed: as much as the points may miss.
const NEGLIGIBLE_ERROR_PART: f64 = 0.01;

/// A programmed point on an arc.
pub(super) struct ArcPoint {
    /// Time at which it was commanded, s since the beginning of the motion.
    pub(super) commanded: f64,
    /// Distance along the arc, mm.
    offset: f64,
    point: Point,
    /// The filtered motion half a delay later.
    state: MotionState,
    /// Distance between the point and that state, mm: an upper bound of the error.
    at_most: f64,
    /// Square of the error if the filtered path were straight there, mm².
    likely: f64,
}

/// An arc in a motion.
pub(super) struct MeasuredArc<'a> {
    pub(super) toolpath: &'a Toolpath,
    pub(super) rest_to_rest: &'a RestToRest,
    /// Index of the segment.
    pub(super) number: usize,
    pub(super) segment: &'a Segment,
    pub(super) arc: &'a Arc,
    pub(super) pulses: &'a Pulses,
    /// Indices of the pulses along the arc.
    pub(super) own: Range<usize>,
}

impl MeasuredArc<'_> {
    /// Returns the points to measure during some pulses, among those commanded at `wanted` moments (s since the beginning
    /// of the motion), the ones with the largest likely error first: only the largest errors count, so few of the
    /// others are searched.
    pub(super) fn points(
        &self,
        steps: &mut RememberedSteps,
        during: impl IntoIterator<Item = usize>,
        wanted: impl Fn(f64) -> bool,
    ) -> Vec<ArcPoint> {
        let delay = steps.cursor.motion.filter().delay();
        let mut points = Vec::new();
        for index in during {
            let pulse = self.pulses.at(index);
            let count = (POINTS_PER_DELAY * pulse.duration / delay).ceil().clamp(3.0, MAX_POINTS_PER_PULSE);
            let begins = steps.cursor.pulse_start(index);
            let elapsed = |i: f64| (i + 0.5) / count * pulse.duration;
            // Where the whole window lies within the pulse, the error is in proportion to v²/r. Both v² and r are
            // linear in the distance, so the error only grows or only falls: the first and the last point are enough.
            let settled = |i: f64| 0.5 * delay <= elapsed(i) && elapsed(i) + 0.5 * delay <= pulse.duration;
            for i in (0..count as usize).map(|i| i as f64) {
                let is_needed = !(settled(i - 1.0) && settled(i) && settled(i + 1.0));
                if is_needed && wanted(begins + elapsed(i)) {
                    points.push(self.point(steps, index, &pulse, elapsed(i)));
                }
            }
        }
        sort_by_number(&mut points, |point| -point.likely);
        points
    }

    /// Returns the error along the arc while the whole window lies within it, at moments in `inner` (s since the beginning
    /// of the motion), mm; if it is at most `enough`, `enough`.
    pub(super) fn error_within(&self, steps: &mut RememberedSteps, inner: &Range<f64>, enough: f64) -> f64 {
        let fastest = self.fastest(steps, inner);
        let error = fastest.map_or(enough, |point| self.error(steps, point, enough));
        let may_be_larger =
            |index: &usize| error < (1.0 - NEGLIGIBLE_ERROR_PART) * self.error_at_most(steps, *index);
        let pulses: Vec<usize> = self.own.clone().filter(may_be_larger).collect();
        let points = self.points(steps, pulses, |commanded| inner.contains(&commanded));
        points.into_iter().fold(error, |error, point| self.error(steps, point, error))
    }

    /// Returns the bound of the error during a pulse, mm: of the highest feedrate within half a delay of it, at the
    /// smallest radius.
    fn error_at_most(&self, steps: &RememberedSteps, index: usize) -> f64 {
        let filter = steps.cursor.motion.filter();
        let within = |number: usize, passed: &mut f64| {
            let is_within = *passed < filter.half_delay();
            *passed += self.pulses.duration(number);
            is_within.then(|| self.largest_feedrate(number))
        };
        let before = (self.own.start..index).rev().scan(0.0, |passed, number| within(number, passed));
        let after = (index + 1..self.own.end).scan(0.0, |passed, number| within(number, passed));
        let fastest = before.chain(after).fold(self.largest_feedrate(index), f64::max);
        let radius = self.arc.start_radius.min(self.arc.end_radius);
        fastest * fastest * filter.sum_of_squares() / (24.0 * radius)
    }

    /// Returns the point where the command is fastest among moments in `inner`; of the pulses as fast, in the longest,
    /// half a delay from its end if it is that long.
    fn fastest(&self, steps: &mut RememberedSteps, inner: &Range<f64>) -> Option<ArcPoint> {
        let half_delay = steps.cursor.motion.filter().half_delay();
        let elapsed = |index: usize| {
            let (duration, [first, last]) = (self.pulses.duration(index), self.pulses.feedrates(index));
            let margin = half_delay.min(0.5 * duration);
            if first < last { duration - margin } else { margin }
        };
        let order = |index: &usize| (self.largest_feedrate(*index), self.pulses.duration(*index));
        let inside = self
            .own
            .clone()
            .filter(|index| inner.contains(&(steps.cursor.pulse_start(*index) + elapsed(*index))));
        let fastest = inside.reduce(|one, other| if order(&one) < order(&other) { other } else { one })?;
        Some(self.point(steps, fastest, &self.pulses.at(fastest), elapsed(fastest)))
    }

    /// Returns the largest feedrate of a pulse, mm/s.
    fn largest_feedrate(&self, index: usize) -> f64 {
        let [first, last] = self.pulses.feedrates(index);
        first.max(last)
    }

    /// Returns the point commanded `elapsed` (s) after a pulse began.
    fn point(&self, steps: &mut RememberedSteps, index: usize, pulse: &Pulse, elapsed: f64) -> ArcPoint {
        let commanded = steps.cursor.pulse_start(index) + elapsed;
        let offset = pulse.offset_after(elapsed);
        let point = self.segment.point(offset);
        let half_delay = steps.cursor.motion.filter().half_delay();
        let moment = steps.cursor.moment_from(index, commanded + half_delay);
        let state = steps.state(moment);
        let away = state.position - point;
        let along = away.dot(&state.velocity) / state.velocity.norm();
        let likely = away.norm_squared() - along * along;
        ArcPoint { commanded, offset, point, state, at_most: away.norm(), likely }
    }

    /// Returns the error at a point, mm; if it is at most `enough`, `enough`.
    pub(super) fn error(&self, steps: &mut RememberedSteps, point: ArcPoint, enough: f64) -> f64 {
        let ArcPoint { commanded, offset, point, state, at_most, .. } = point;
        if at_most <= enough {
            return enough;
        }
        let error = enough.max(nearest(steps, point, commanded, self.own.start, state, enough));
        if at_most <= error {
            return error;
        }
        error.max(self.distance_from_programmed(offset, state.position))
    }

    /// Returns the distance (mm) of a filtered point from the programmed path near the distance `offset` (mm) on
    /// the arc: from the arc and its neighbours in the motion.
    fn distance_from_programmed(&self, offset: f64, point: Point) -> f64 {
        let Range { start, end } = self.rest_to_rest.segments;
        let neighbours = start.max(self.number.saturating_sub(1))..end.min(self.number + 2);
        let distances = neighbours.map(|near| {
            let segment = self.toolpath.segments.at(near);
            let near_there = match near.cmp(&self.number) {
                Ordering::Less => segment.length,
                Ordering::Equal => offset,
                Ordering::Greater => 0.0,
            };
            distance_from_segment(&segment, near_there, point)
        });
        distances.fold(f64::INFINITY, f64::min)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::{ArcChords, Machine, TimeConstants};
    use crate::simulation::contour::contour_errors;
    use crate::simulation::feed::{Tolerances, command};
    use crate::simulation::gcode::read;
    use crate::simulation::interpreter::trace;
    use crate::simulation::profile::Profile;
    use crate::simulation::toolpath::Curve;

    /// Two half circles run as chords, after lines along their tangents, and the machine.
    fn run(time_constant: f64) -> (Toolpath, Machine) {
        let mut machine = Machine::default();
        machine.interpolator.filters = 1;
        machine.interpolator.time_constants = TimeConstants::Equal(time_constant);
        machine.interpolator.contour_tolerance = 10.0;
        machine.interpolator.arc_chords = ArcChords::Long(0.2);
        machine.axes.iter_mut().for_each(|axis| axis.acceleration = 2000.0);
        let program = "G1 X20 F6000\nG3 X20 Y8 I0 J4\nG1 X10 F3000\nG2 X10 Y20 I0 J6\nG1 X40\n";
        (trace(&read(program.as_bytes()), &machine), machine)
    }

    /// The pulses of a chord are longer than a delay of 0.3 ms; 20 ms are several chords.
    #[test]
    fn the_largest_error_along_an_arc_is_that_of_a_dense_search() {
        for time_constant in [3e-4, 2e-3, 2e-2] {
            let (toolpath, machine) = run(time_constant);
            let plan = command(&toolpath, &machine, Tolerances::Programmed.into());
            let profile = Profile::new(&toolpath, &plan);
            let errors = contour_errors(&toolpath, &plan, &profile);
            let mut dense = vec![0.0f64; toolpath.segments.len()];
            for step in 0..200_000 {
                let state = profile.at_time(f64::from(step) / 200_000.0 * profile.cycle_time());
                for (number, segment) in toolpath.segments.iter().enumerate() {
                    let Curve::Arc(arc) = &segment.curve else { continue };
                    let away = state.position - arc.center;
                    let before = state.distance - profile.distance_before(number);
                    // At most 100 mm/s.
                    let half_delay = 0.5 * time_constant * 100.0;
                    if half_delay < before && before < segment.length - half_delay {
                        dense[number] = dense[number].max((arc.start_radius - away.norm()).abs());
                    }
                }
            }
            for number in [1, 3] {
                let error = errors.along(number);
                assert!(0.0 < error && dense[number] <= 1.01 * error, "{number}: {error} {}", dense[number]);
                assert!(error <= 1.001 * dense[number], "{number}: {error} {}", dense[number]);
            }
        }
    }
}
