//! The filtered motion along lines as a sum over the borders of pulses, for many moments near one another.
//!
//! Along lines an even command changes its velocity v only from one pulse to the next, by a step Δv. A step sent the age a
//! ago has moved the tool by Δv S(a), and what was commanded one filter delay D ago has arrived in full:
//!
//! ```text
//! position  P = P(D) + v(D) S(D) + Σ Δv S(a)        over the borders within one filter delay
//! velocity  Ṗ = v(D)             + Σ Δv V(a)
//! ```
//!
//! That is the sum over pulses of `state`, in another order, and the same but for the rounding. But a step does
//! not depend on the moment: it is worked out once for all moments that see it. Where there is anything but lines at an even
//! command, and where crowds are seen as a whole, the other sum is taken.

use crate::simulation::profile::{Moment, Motion, State, Walk};
use crate::simulation::toolpath::Curve;

/// The velocity of each axis and the feedrate, mm/s.
type Rate = nalgebra::Vector4<f64>;

/// So many steps are remembered at most: more than one delay of ordinary blocks holds.
const MOST_REMEMBERED: usize = 128;

/// Nothing is known of any border.
const UNKNOWN: Border = Border { pulse: usize::MAX, step: None, after: None };

/// A motion whose steps are remembered.
pub struct Steps<'a> {
    /// The motion, from moment to moment.
    pub walk: Walk<'a>,
    /// What is remembered of borders. Their number is a power of two, and each is at its remainder.
    known: Vec<Border>,
}

/// Where one pulse ends and the next begins; none beside anything but a line at an even command.
#[derive(Clone, Copy)]
struct Border {
    /// The index of the pulse that begins there.
    pulse: usize,
    /// How the command changes there.
    step: Option<Rate>,
    /// The command of the pulse that begins there.
    after: Option<Rate>,
}

impl<'a> Steps<'a> {
    /// Nothing is known of the steps of a motion.
    pub fn of(motion: Motion<'a>) -> Steps<'a> {
        let borders = motion.end_pulse - motion.first_pulse + 1;
        let remembered = borders.next_power_of_two().min(MOST_REMEMBERED);
        Steps { walk: Walk::of(motion), known: vec![UNKNOWN; remembered] }
    }

    /// Where the tool is and how fast it moves: what [`Motion::state`] tells.
    pub fn state(&mut self, moment: Moment) -> State {
        self.sum(moment).unwrap_or_else(|| self.walk.state(moment))
    }

    /// The sum over borders; none where it is not taken.
    fn sum(&mut self, moment: Moment) -> Option<State> {
        let Motion { pulses, filter, first_pulse, end_pulse, crowds, .. } = self.walk.motion;
        if !crowds.is_empty() {
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
                return Some(self.state_from(first_pulse, 0.0, travel, rate));
            }
            border -= 1;
            age += pulses.duration(border);
        }
        if border == end_pulse {
            return None;
        }
        let oldest = self.walk.motion.even_rate(border)?;
        travel += filter.half_delay() * oldest;
        rate += oldest;
        Some(self.state_from(border, oldest.w * (age - filter.delay()), travel, rate))
    }

    /// The state where the command was so far (`way`, mm) beyond the beginning of a pulse one delay ago, and the tool has
    /// travelled on from there (mm), to this rate.
    fn state_from(&mut self, pulse: usize, way: f64, travel: Rate, rate: Rate) -> State {
        let Motion { pulses, segments, .. } = self.walk.motion;
        let (segment, offset) = (pulses.segment(pulse), pulses.offset(pulse) + way);
        State {
            distance: self.walk.distances.before(segment) + offset + travel.w,
            position: segments.point(segment, offset) + travel.xyz(),
            velocity: rate.xyz(),
        }
    }

    /// How the command changes at a border; none beside anything but a line at an even command.
    fn step(&mut self, pulse: usize) -> Option<Rate> {
        let (motion, last) = (self.walk.motion, self.known.len() - 1);
        if self.known[pulse & last].pulse != pulse {
            // A moment that comes later sees a border beyond the last one.
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

impl Motion<'_> {
    /// The command of a pulse that is even along a line.
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
    use crate::simulation::feed::{Rule, command};
    use crate::simulation::gcode::read;
    use crate::simulation::profile::Profile;
    use crate::simulation::toolpath::trace;

    /// Lines of a tenth to a few millimetres, some of them after a dwell or an arc.
    const PROGRAM: &[u8] =
        b"G91 G1 F3000 X1\nX0.3 Y0.4\nX0.1 Z-0.2\nY2\nX-1\nX-3 Y0.1\nG4 P1\nX5 F6000\nY5\nX-0.2\n
        X-0.1 Y0.1\nX-0.1 Y0.2\nY0.3\nG2 X1 Y1 I1\nG1 Y4\nX0.1 Y0.1\nY0.2\nZ3\nX2";

    #[test]
    fn borders_and_pulses_have_the_same_sum() {
        let machine = Machine::default();
        let toolpath = trace(&read(PROGRAM), &machine);
        let plan = command(&toolpath, &machine, Rule::Isolated(0.01));
        let profile = Profile::new(&toolpath, &plan);
        let mut taken = 0;
        for stretch in plan.stretches() {
            let motion = profile.motion(stretch);
            let mut steps = Steps::of(motion);
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
