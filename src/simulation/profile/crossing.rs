//! The times at which the tool crosses given distances along the path.
//!
//! Within a rest-to-rest motion the distance s(t) of [`MotionCursor::progress`] never falls, and its slope v(t) is
//! known, so that
//!
//! ```text
//! s(t) = d     by Newton's method, t ← t − (s(t) − d) / v(t), inside a bracket that only shrinks
//! ```
//!
//! Distances are requested in ascending order, so that each bracket begins where the last one ended and a
//! crossing costs a few evaluations. At a full stop a distance is crossed when the next motion begins.

use crate::simulation::feed::Phase;
use crate::simulation::profile::{MotionCursor, Profile};

/// Most Newton steps, or halvings of the bracket.
const MAX_STEPS: usize = 60;

/// Accuracy of a crossing, s: far below the resolution of any recorder.
const CROSSING_TIME_ACCURACY_S: f64 = 1e-9;

impl Profile<'_> {
    /// Returns the times (s) at which the tool has run each of `distances` (mm, ascending) along the
    /// programmed path: each is the last moment at which it has not run more.
    pub fn crossing_times(&self, distances: &[f64]) -> Vec<f64> {
        let mut times = Vec::with_capacity(distances.len());
        let mut wanted = distances.iter().copied().peekable();
        for (phase, start) in self.plan.phases.iter().zip(&self.phase_starts) {
            let Phase::Motion(rest_to_rest) = phase else { continue };
            let mut cursor = MotionCursor::of(self.motion(rest_to_rest));
            let from = cursor.distances.before(rest_to_rest.segments.start);
            let to = cursor.distances.before(rest_to_rest.segments.end);
            let mut pulse = rest_to_rest.pulses.start;
            let mut low = 0.0;
            while let Some(distance) = wanted.next_if(|distance| *distance < to) {
                let within =
                    if distance < from { 0.0 } else { cursor.crossing(distance, &mut low, &mut pulse) };
                times.push(start + cursor.motion.true_time(within));
            }
        }
        let end = self.cycle_time();
        times.extend(wanted.map(|_| end));
        times
    }
}

impl MotionCursor<'_> {
    /// Returns the time at which the tool has run `distance` (mm from the beginning of the program), s since
    /// the beginning of the motion. `low` is a time no later than the result, and `pulse` the index of a
    /// pulse that begins no later; both are advanced.
    fn crossing(&mut self, distance: f64, low: &mut f64, pulse: &mut usize) -> f64 {
        let motion = self.motion;
        let mut sent_before = |pulse: usize| {
            let pulse = motion.pulses.at(pulse);
            self.distances.before(pulse.segment as usize) + pulse.offset
        };
        while *pulse + 1 < motion.end_pulse && sent_before(*pulse + 1) <= distance {
            *pulse += 1;
        }
        // Motion that arrives now was commanded at most one delay ago, and is never ahead of the command.
        let delay = motion.filter.delay();
        let command = self.starts.before(*pulse);
        let mut before = low.max(command);
        let mut after = (command + motion.pulses.duration(*pulse) + delay).min(motion.duration());
        let mut time = (command + 0.5 * delay).clamp(before, after);
        for _ in 0..MAX_STEPS {
            let moment = self.moment_from(*pulse, time);
            let (arrived, feedrate) = self.progress(moment);
            let ahead = arrived - distance;
            if ahead <= 0.0 {
                before = time
            } else {
                after = time
            }
            let step = time - ahead / feedrate;
            let next = if before < step && step < after { step } else { 0.5 * (before + after) };
            if (next - time).abs() <= CROSSING_TIME_ACCURACY_S || after - before <= CROSSING_TIME_ACCURACY_S {
                time = next;
                break;
            }
            time = next;
        }
        *low = before;
        time
    }
}

#[cfg(test)]
mod tests {
    use crate::machine::Machine;
    use crate::simulation::feed::{CornerPolicy, command};
    use crate::simulation::gcode::read;
    use crate::simulation::interpreter::trace;
    use crate::simulation::profile::Profile;

    #[test]
    fn crossings_are_those_of_a_search_by_halving() {
        let program = b"G1 X10 F3000\nY0.3\nX10.2 Y0.5\nG4 P0.5\nG2 X20 Y5 R9\nG0 Z10\nG1 X0 F800\n";
        let machine = Machine::default();
        let toolpath = trace(&read(program), &machine);
        let plan = command(&toolpath, &machine, CornerPolicy::Isolated(0.01));
        let profile = Profile::new(&toolpath, &plan);
        let wanted: Vec<f64> = (1..200).map(|i| profile.length() * f64::from(i) / 200.0).collect();
        for (time, distance) in profile.crossing_times(&wanted).into_iter().zip(wanted) {
            let searched = profile.time_at_distance(distance);
            assert!((time - searched).abs() < 1e-7, "{distance} mm: {time} s, by halving {searched} s");
        }
    }

    #[test]
    fn a_distance_at_a_stop_is_crossed_when_it_is_over() {
        let machine = Machine::default();
        let toolpath = trace(&read(b"G1 X10 F600\nG4 P2\nX20\n"), &machine);
        let plan = command(&toolpath, &machine, CornerPolicy::Isolated(0.01));
        let profile = Profile::new(&toolpath, &plan);
        let [before, at, end] = profile.crossing_times(&[9.999, 10.0, 20.0])[..] else { panic!("three") };
        assert!(2.0 < at - before, "{before} s, {at} s");
        assert_eq!(end, profile.cycle_time());
    }
}
