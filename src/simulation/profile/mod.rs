//! Feed plan → profile: the motion that leaves the filters, at any time or distance.
//!
//! The profile is not a table: [`Profile::at_time`] computes the motion at any moment exactly from the plan.
//! [`Profile::samples`] makes tables for charts and files, dense where the feedrate bends.
//!
//! If acceleration limits act behind the filters, the machine runs the filtered motion more slowly, as in
//! `time_scaling`: times of [`Profile`] and its tables are true times, times of [`FilteredMotion`] are
//! filtered times.
//!
//! Distance is measured along the programmed path, as the integral of the filtered feed command. It never
//! decreases and ends at the programmed length, although the tool cuts corners; the feedrate is the speed
//! of the tool, ‖Ṗ‖, which dips at corners.

mod crossing;
mod moments;
mod time_scaling;
mod samples;
mod slice;
mod state;
mod steps;
mod prefix_sums;
mod cursor;

pub use cursor::MotionCursor;
pub use samples::{FeedCurve, Resolution, Samples};
pub use state::{Dynamics, Moment, MotionState};
pub use steps::RememberedSteps;
pub(crate) use time_scaling::time_scaled;

use crate::simulation::feed::{
    CornerCurve, FeedPlan, Knot, MergedPath, Phase, Pulses, RestToRest, time_scaling::lost_time,
};
use crate::simulation::filter::FilterChain;
use crate::simulation::profile::moments::MomentTree;
use crate::simulation::profile::prefix_sums::{PrefixSums, SumCheckpoints};
use crate::simulation::running_sum::running_sum;
use crate::simulation::toolpath::{Point, Segments, Toolpath};

/// The filtered motion of a whole program.
pub struct Profile<'a> {
    toolpath: &'a Toolpath,
    plan: &'a FeedPlan,
    /// Distance before each segment, and at the end, mm.
    distances: SumCheckpoints,
    /// Time at which each phase begins, and the last ends, s.
    phase_starts: Vec<f64>,
    /// Time at which each pulse begins, since the beginning of its motion, s.
    pulse_starts: SumCheckpoints,
    clusters: MomentTree,
}

/// One rest-to-rest motion as it leaves the filters; its times are filtered times.
#[derive(Clone, Copy)]
pub struct FilteredMotion<'a> {
    segments: &'a Segments,
    pulses: &'a Pulses,
    filter: &'a FilterChain,
    distances: &'a SumCheckpoints,
    pulse_starts: &'a SumCheckpoints,
    clusters: &'a MomentTree,
    corner_curves: &'a [CornerCurve],
    merged_path: Option<&'a MergedPath>,
    first_pulse: usize,
    /// One past the last pulse.
    end_pulse: usize,
    /// Knots of the time scaling; empty if the machine follows the filtered motion.
    knots: &'a [Knot],
}

impl<'a> Profile<'a> {
    /// Returns the profile of a plan for a toolpath.
    ///
    /// # Examples
    ///
    /// ```
    /// use truefeed::machine::Machine;
    /// use truefeed::simulation::{gcode::read, profile::Profile, simulate, interpreter::trace};
    ///
    /// let machine = Machine::default();
    /// let toolpath = trace(&read(b"G21 G90 G1 X100 F6000"), &machine);
    /// let plan = simulate(&toolpath, &machine);
    /// let profile = Profile::new(&toolpath, &plan);
    /// let middle = profile.at_time(0.5 * profile.cycle_time());
    /// assert!((middle.position.x - 50.0).abs() < 1e-9, "mm: it ends as it begins");
    /// assert!((middle.velocity.x - 100.0).abs() < 1e-9, "mm/s");
    /// ```
    pub fn new(toolpath: &'a Toolpath, plan: &'a FeedPlan) -> Profile<'a> {
        let segments = &toolpath.segments;
        let mut distances = SumCheckpoints::with_room(segments.len());
        distances.add_run((0..segments.len()).map(|segment| segments.length(segment)));
        let mut pulse_starts = SumCheckpoints::with_room(plan.pulses.len());
        for rest_to_rest in plan.rest_to_rest_motions() {
            pulse_starts.add_run(rest_to_rest.pulses.clone().map(|pulse| plan.pulses.duration(pulse)));
        }
        let clusters = MomentTree::of(plan, segments);
        let mut profile =
            Profile { toolpath, plan, distances, phase_starts: Vec::new(), pulse_starts, clusters };
        let durations: Vec<f64> = plan.phases.iter().map(|phase| profile.phase_duration(phase)).collect();
        let first = [plan.start].into_iter();
        profile.phase_starts = running_sum(first.chain(durations)).collect();
        profile
    }

    /// Returns the cycle time, s.
    pub fn cycle_time(&self) -> f64 {
        self.phase_starts.last().copied().unwrap_or(0.0)
    }

    /// Returns the length of the programmed path, mm.
    pub fn length(&self) -> f64 {
        self.distance_before(self.toolpath.segments.len())
    }

    /// Returns the motion at a time since the start (s); at rest before the start and after the end.
    pub fn at_time(&self, time: f64) -> MotionState {
        let Some(index) = self.phase_at(time) else {
            return self.standing(0);
        };
        match &self.plan.phases[index] {
            Phase::Wait(_) => self.standing(self.segments_before(index)),
            Phase::Motion(rest_to_rest) => {
                MotionCursor::of(self.motion(rest_to_rest)).state_at(time - self.phase_starts[index])
            }
        }
    }

    /// Returns acceleration and jerk at a time since the start (s); `None` while the machine is at rest.
    pub fn dynamics_at_time(&self, time: f64) -> Option<Dynamics> {
        let index = self.phase_at(time)?;
        let Phase::Motion(rest_to_rest) = &self.plan.phases[index] else { return None };
        let motion = self.motion(rest_to_rest);
        Some(motion.dynamics_at(time - self.phase_starts[index]))
    }

    /// Returns the time at which the tool has run `distance` (mm) of the programmed path, s: the last moment
    /// at which it has not run more.
    pub fn time_at_distance(&self, distance: f64) -> f64 {
        let (mut low, mut high) = (0.0, self.cycle_time());
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if middle <= low || high <= middle {
                break;
            }
            if self.at_time(middle).distance <= distance { low = middle } else { high = middle }
        }
        low
    }

    /// Returns the times at which a phase of the plan begins and ends, s.
    pub fn phase_time(&self, phase: usize) -> std::ops::Range<f64> {
        self.phase_starts[phase]..self.phase_starts[phase + 1]
    }

    /// Returns the filtered motion of a rest-to-rest motion.
    pub fn motion(&self, rest_to_rest: &RestToRest) -> FilteredMotion<'_> {
        FilteredMotion {
            segments: &self.toolpath.segments,
            pulses: &self.plan.pulses,
            filter: &self.plan.filters[rest_to_rest.filter],
            distances: &self.distances,
            pulse_starts: &self.pulse_starts,
            clusters: &self.clusters,
            corner_curves: &self.plan.corner_curves,
            merged_path: self.plan.merged_path.as_ref(),
            first_pulse: rest_to_rest.pulses.start,
            end_pulse: rest_to_rest.pulses.end,
            knots: self.plan.knots(rest_to_rest),
        }
    }

    /// Returns the length of the programmed path before a segment, mm.
    pub fn distance_before(&self, segment: usize) -> f64 {
        self.distances.before(&self.toolpath.segments, 0, segment)
    }

    fn phase_duration(&self, phase: &Phase) -> f64 {
        match phase {
            Phase::Wait(wait) => wait.duration,
            Phase::Motion(rest_to_rest) => {
                let motion = self.motion(rest_to_rest);
                motion.duration() + lost_time(motion.knots)
            }
        }
    }

    fn phase_at(&self, time: f64) -> Option<usize> {
        let begun = self.phase_starts.partition_point(|&start| start <= time);
        (begun.min(self.plan.phases.len())).checked_sub(1)
    }

    /// Returns the number of segments before a phase.
    fn segments_before(&self, phase: usize) -> usize {
        let rest_to_rest = self.plan.phases[..phase].iter().rev().find_map(|phase| match phase {
            Phase::Motion(rest_to_rest) => Some(rest_to_rest.segments.end),
            Phase::Wait(_) => None,
        });
        rest_to_rest.unwrap_or(0)
    }

    /// Returns the state of the machine at rest after `segments` segments.
    fn standing(&self, segments: usize) -> MotionState {
        let all = &self.toolpath.segments;
        let position = match segments.checked_sub(1) {
            Some(last) => all.at(last).end,
            None => all.first().map_or(Point::origin(), |first| first.start),
        };
        MotionState { distance: self.distance_before(segments), position, velocity: Default::default() }
    }
}

impl<'a> FilteredMotion<'a> {
    /// Returns the duration of the command, s.
    pub fn command_time(&self) -> f64 {
        let last = self.end_pulse - 1;
        self.pulse_start(last) + self.pulses.duration(last)
    }

    /// Returns the duration of the motion, s: the command and the filter delay.
    pub fn duration(&self) -> f64 {
        self.command_time() + self.filter.delay()
    }

    /// Returns the time at which a pulse of the plan begins, s since the beginning of the motion.
    pub fn pulse_start(&self, pulse: usize) -> f64 {
        self.pulse_starts.before(self.pulses, self.first_pulse, pulse)
    }

    /// Returns the times at which the pulses begin, s since the beginning of the motion.
    fn starts(&self) -> PrefixSums<'a, Pulses> {
        PrefixSums::of(self.pulse_starts, self.pulses, self.first_pulse..self.end_pulse)
    }

    /// Returns the filters of the motion.
    pub fn filter(&self) -> &FilterChain {
        self.filter
    }

    /// Returns the moment `time` seconds after the beginning of the motion.
    pub fn moment(&self, time: f64) -> Moment {
        self.starts().moment(self.first_pulse, time)
    }
}

impl PrefixSums<'_, Pulses> {
    /// Returns the moment `time` seconds after the beginning of the motion; the pulse `from` begins no later
    /// or is the first.
    fn moment(&mut self, from: usize, time: f64) -> Moment {
        let pulse = self.first_above(from + 1, 0.0, time) - 1;
        Moment { pulse, elapsed: (time - self.before(pulse)).max(0.0) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::Machine;
    use crate::simulation::feed::{CornerPolicy, command};
    use crate::simulation::gcode::read;
    use crate::simulation::interpreter::trace;

    #[test]
    fn lists_of_a_long_program_have_no_more_room_than_they_need() {
        // More than a power of two of everything, so that lists that grow by doubling would be seen.
        let moves = (0..5000).map(|at| format!("X{}.{} Y{}\n", at / 4, 25 * (at % 4), at % 3));
        let text: String = ["G21 G90 G1 F6000\n".to_string()].into_iter().chain(moves).collect();
        let machine = Machine::default();
        let toolpath = trace(&read(text.as_bytes()), &machine);
        let plan = command(&toolpath, &machine, CornerPolicy::Isolated(0.01));
        let profile = Profile::new(&toolpath, &plan);
        let is_close = |room: usize, needed: usize| (needed..=needed + needed / 20).contains(&room);
        assert!(4800 < toolpath.segments.len());
        for (room, needed) in plan.pulses.room() {
            assert!(is_close(room, needed), "{room} for {needed}");
        }
        assert!(profile.pulse_starts.room() < plan.pulses.len() / 10);
        assert!(profile.distances.room() < toolpath.segments.len() / 10);
    }
}
