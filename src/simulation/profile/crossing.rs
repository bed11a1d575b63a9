//! When the tool crosses given distances along the path.
//!
//! Within a stretch the distance s(t) of [`Walk::progress`] never falls, and its slope v(t) is known,
//! so that
//!
//! ```text
//! s(t) = d     by Newton's method, t ← t − (s(t) − d) / v(t), inside a bracket that only shrinks
//! ```
//!
//! Distances are asked for in ascending order, so that the brackets move along and a crossing costs
//! a few evaluations. At a full stop a distance is crossed when the next motion begins.

use crate::simulation::feed::Phase;
use crate::simulation::profile::{Profile, Walk};

/// Newton's steps, or halvings of the bracket, at most.
const MOST_STEPS: usize = 60;

/// A crossing is known this well, s: far below what any recorder resolves.
const CLOSE_ENOUGH: f64 = 1e-9;

impl Profile<'_> {
    /// When the tool has run each of `distances` (mm, ascending) of the programmed path, s: the last
    /// moment at which it has not run more.
    pub fn crossing_times(&self, distances: &[f64]) -> Vec<f64> {
        let mut times = Vec::with_capacity(distances.len());
        let mut wanted = distances.iter().copied().peekable();
        for (phase, start) in self.plan.phases.iter().zip(&self.phase_starts) {
            let Phase::Motion(stretch) = phase else { continue };
            let mut walk = Walk::of(self.motion(stretch));
            let from = walk.distances.before(stretch.segments.start);
            let to = walk.distances.before(stretch.segments.end);
            let mut pulse = stretch.pulses.start;
            let mut low = 0.0;
            while let Some(distance) = wanted.next_if(|distance| *distance < to) {
                let within =
                    if distance < from { 0.0 } else { walk.crossing(distance, &mut low, &mut pulse) };
                times.push(start + walk.motion.true_time(within));
            }
        }
        let end = self.cycle_time();
        times.extend(wanted.map(|_| end));
        times
    }
}

impl Walk<'_> {
    /// When the tool has run `distance` (mm from the beginning of the program), s since the beginning
    /// of the stretch. `low` is a time not later than that, and `pulse` one that has not sent it; both
    /// move up.
    fn crossing(&mut self, distance: f64, low: &mut f64, pulse: &mut usize) -> f64 {
        let motion = self.motion;
        let mut sent_before = |pulse: usize| {
            let pulse = motion.pulses.at(pulse);
            self.distances.before(pulse.segment as usize) + pulse.offset
        };
        while *pulse + 1 < motion.end_pulse && sent_before(*pulse + 1) <= distance {
            *pulse += 1;
        }
        // What has arrived was sent one delay ago at the earliest, and is not ahead of what is sent.
        let delay = motion.filter.delay();
        let command = self.starts.before(*pulse);
        let mut before = low.max(command);
        let mut after = (command + motion.pulses.duration(*pulse) + delay).min(motion.duration());
        let mut time = (command + 0.5 * delay).clamp(before, after);
        for _ in 0..MOST_STEPS {
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
            if (next - time).abs() <= CLOSE_ENOUGH || after - before <= CLOSE_ENOUGH {
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
    use crate::simulation::feed::{Rule, command};
    use crate::simulation::gcode::read;
    use crate::simulation::profile::Profile;
    use crate::simulation::toolpath::trace;

    #[test]
    fn crossings_are_those_of_a_search_by_halving() {
        let program = b"G1 X10 F3000\nY0.3\nX10.2 Y0.5\nG4 P0.5\nG2 X20 Y5 R9\nG0 Z10\nG1 X0 F800\n";
        let machine = Machine::default();
        let toolpath = trace(&read(program), &machine);
        let plan = command(&toolpath, &machine, Rule::Isolated(0.01));
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
        let plan = command(&toolpath, &machine, Rule::Isolated(0.01));
        let profile = Profile::new(&toolpath, &plan);
        let [before, at, end] = profile.crossing_times(&[9.999, 10.0, 20.0])[..] else { panic!("three") };
        assert!(2.0 < at - before, "{before} s, {at} s");
        assert_eq!(end, profile.cycle_time());
    }
}
