//! The filtered motion along lines as a sum over the borders of pulses, for many moments near one another.
//!
//! Along lines an even command changes its velocity v only from one pulse to the next, by a step Δv. A step
//! of the age a has moved the tool by Δv S(a), and the command one filter delay D ago has arrived in full:
//!
//! ```text
//! position  P = P(D) + v(D) S(D) + Σ Δv S(a)        over the borders within one filter delay
//! velocity  Ṗ = v(D)             + Σ Δv V(a)
//! ```
//!
//! Except for rounding this equals the sum over pulses of `state`, but a step does not depend on the moment:
//! it is computed once for all moments in whose window it lies. If the window contains anything but lines at
//! an even command, or clusters, the sum of `state` is used instead.

use crate::simulation::profile::{FilteredMotion, Moment, MotionCursor, MotionState};
use crate::simulation::toolpath::Curve;

/// The velocity of each axis and the feedrate, mm/s.
type Rate = nalgebra::Vector4<f64>;

/// Most remembered steps: more than one filter delay contains in programs of ordinary blocks.
const MAX_REMEMBERED_STEPS: usize = 128;

/// Marks a border that was not computed.
const UNCOMPUTED_BORDER: Border = Border { pulse: usize::MAX, step: None, after: None };

/// A motion with remembered steps.
pub struct RememberedSteps<'a> {
    /// The motion with its cursor.
    pub cursor: MotionCursor<'a>,
    /// Remembered borders. Their number is a power of two, and the border of a pulse is at the remainder of
    /// the index of the pulse.
    known: Vec<Border>,
}

/// The end of one pulse and the beginning of the next.
#[derive(Clone, Copy)]
struct Border {
    /// Index of the pulse that begins there.
    pulse: usize,
    /// Change of the command; `None` unless both pulses are lines at an even command.
    step: Option<Rate>,
    /// Command of the pulse that begins there; `None` unless it is a line at an even command.
    after: Option<Rate>,
}

impl<'a> RememberedSteps<'a> {
    /// Returns a motion without remembered steps.
    pub fn of(motion: FilteredMotion<'a>) -> RememberedSteps<'a> {
        let borders = motion.end_pulse - motion.first_pulse + 1;
        let remembered = borders.next_power_of_two().min(MAX_REMEMBERED_STEPS);
        RememberedSteps { cursor: MotionCursor::of(motion), known: vec![UNCOMPUTED_BORDER; remembered] }
    }

    /// Returns position and velocity of the tool, as [`FilteredMotion::state`] does.
    pub fn state(&mut self, moment: Moment) -> MotionState {
        self.sum(moment).unwrap_or_else(|| self.cursor.state(moment))
    }

    /// Returns the state by the sum over borders; `None` if that sum does not apply.
    fn sum(&mut self, moment: Moment) -> Option<MotionState> {
        let FilteredMotion { pulses, filter, first_pulse, end_pulse, clusters, .. } = self.cursor.motion;
        if !clusters.is_empty() {
            return None;
        }
        let since_end = moment.elapsed - pulses.duration(moment.pulse);
        let (mut border, mut age) =
            if 0.0 < since_end { (moment.pulse + 1, since_end) } else { (moment.pulse, moment.elapsed) };
        let (mut travel, mut rate) = (Rate::zeros(), Rate::zeros());
        while age < filter.delay() {
            let step = self.step(border)?;
            let (arrives, arrived) = filter.step_and_displacement(age);
            travel += arrived * step;
            rate += arrives * step;
            if border == first_pulse {
                return Some(self.state_from((first_pulse, 0.0), travel, rate, moment));
            }
            border -= 1;
            age += pulses.duration(border);
        }
        if border == end_pulse {
            return None;
        }
        let oldest = self.cursor.motion.even_rate(border)?;
        travel += filter.half_delay() * oldest;
        rate += oldest;
        Some(self.state_from((border, oldest.w * (age - filter.delay())), travel, rate, moment))
    }

    /// Returns the state at a moment of a tool that moves at `rate` and has travelled by `travel` (mm) since the command
    /// one filter delay ago, which was a way (mm) beyond the beginning of a pulse.
    fn state_from(
        &mut self,
        (pulse, way): (usize, f64),
        travel: Rate,
        rate: Rate,
        moment: Moment,
    ) -> MotionState {
        let MotionCursor { motion, distances, .. } = &mut self.cursor;
        let FilteredMotion { pulses, segments, .. } = *motion;
        let (segment, offset) = (pulses.segment(pulse), pulses.offset(pulse) + way);
        let state = MotionState {
            distance: distances.before(segment) + offset + travel.w,
            position: segments.point(segment, offset) + travel.xyz(),
            velocity: rate.xyz(),
        };
        motion.on_run_path(state, rate.w, moment, &mut |segment| distances.before(segment))
    }

    /// Returns the change of the command at a border; `None` unless both pulses are lines at an even command.
    fn step(&mut self, pulse: usize) -> Option<Rate> {
        let (motion, last) = (self.cursor.motion, self.known.len() - 1);
        if self.known[pulse & last].pulse != pulse {
            // A later moment sees a border beyond the last one.
            let known_before = self.known[pulse.wrapping_sub(1) & last];
            let before = match pulse.checked_sub(1).filter(|_| motion.first_pulse < pulse) {
                None => Some(Rate::zeros()),
                Some(before) if known_before.pulse == before => known_before.after,
                Some(before) => motion.even_rate(before),
            };
            let after = if pulse == motion.end_pulse { Some(Rate::zeros()) } else { motion.even_rate(pulse) };
            let step = before.zip(after).map(|(before, after)| after - before);
            self.known[pulse & last] = Border { pulse, step, after };
        }
        self.known[pulse & last].step
    }
}

impl FilteredMotion<'_> {
    /// Returns the command of a pulse that is even along a line; `None` for any other.
    fn even_rate(&self, pulse: usize) -> Option<Rate> {
        let (segment, [first, last]) = (self.pulses.segment(pulse), self.pulses.feedrates(pulse));
        (first == last && *self.segments.curve(segment) == Curve::Line)
            .then(|| first * self.segments.direction(segment).push(1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::Machine;
    use crate::simulation::feed::{CornerPolicy, command};
    use crate::simulation::gcode::read;
    use crate::simulation::interpreter::trace;
    use crate::simulation::profile::Profile;

    /// Lines of a tenth to a few millimetres, some of them after a dwell or an arc.
    const PROGRAM: &[u8] =
        b"G91 G1 F3000 X1\nX0.3 Y0.4\nX0.1 Z-0.2\nY2\nX-1\nX-3 Y0.1\nG4 P1\nX5 F6000\nY5\nX-0.2\n
        X-0.1 Y0.1\nX-0.1 Y0.2\nY0.3\nG2 X1 Y1 I1\nG1 Y4\nX0.1 Y0.1\nY0.2\nZ3\nX2";

    #[test]
    fn borders_and_pulses_have_the_same_sum() {
        let machine = Machine::default();
        let toolpath = trace(&read(PROGRAM), &machine);
        let plan = command(&toolpath, &machine, CornerPolicy::Isolated(0.01));
        let profile = Profile::new(&toolpath, &plan);
        let mut taken = 0;
        for rest_to_rest in plan.rest_to_rest_motions() {
            let motion = profile.motion(rest_to_rest);
            let mut steps = RememberedSteps::of(motion);
            for part in 0..=2000 {
                let moment = motion.moment(1.1 * motion.duration() * f64::from(part) / 2000.0);
                let (state, other) = (steps.state(moment), motion.state(moment));
                assert!((state.distance - other.distance).abs() < 1e-12, "{moment:?}");
                assert!((state.position - other.position).norm() < 1e-12, "{moment:?}");
                assert!((state.velocity - other.velocity).norm() < 1e-11, "{moment:?}");
                taken += usize::from(steps.sum(moment).is_some());
            }
        }
        assert!((2000..4002).contains(&taken), "both sums are taken: {taken}");
    }
}
