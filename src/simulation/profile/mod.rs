//! Feed plan → profile: the motion that leaves the filters, at any time or distance.
//!
//! The profile is not a table: it is the plan, asked through [`Profile::at_time`] at any moment, exactly.
//! Tables for charts and files are made by [`Profile::samples`], dense where the feedrate bends.
//!
//! Where acceleration limits act behind the filters, the motion that leaves them is run more slowly, as in
//! `time_scaling`: [`Profile`] and its tables speak of the true time, a [`Motion`] of the filtered one.
//!
//! Distance is measured along the programmed path, as the integral of the filtered feed command.
//! It grows monotonically and ends at the programmed length, whatever the corners cut off; the
//! feedrate is that of the tool, ‖Ṗ‖, which dips at corners.

mod crossing;
mod crowds;
mod time_scaling;
mod samples;
mod slice;
mod state;
mod steps;
mod sums;
mod walk;

pub use samples::{FeedCurve, Resolution, Samples};
pub use state::{Dynamics, Moment, State};
pub use steps::Steps;
pub(crate) use time_scaling::time_scaled;
pub use walk::Walk;

use crate::simulation::feed::{FeedPlan, Knot, Phase, Pulses, Stretch, time_scaling::lost};
use crate::simulation::filter::FilterChain;
use crate::simulation::profile::crowds::Crowds;
use crate::simulation::profile::sums::{Checkpoints, Sums};
use crate::simulation::running_sum::running_sum;
use crate::simulation::toolpath::{Point, Segments, Toolpath};

/// The filtered motion of a whole program.
pub struct Profile<'a> {
    toolpath: &'a Toolpath,
    plan: &'a FeedPlan,
    /// Distance before each segment, and at the end, mm.
    distances: Checkpoints,
    /// When each phase begins, and the end, s.
    phase_starts: Vec<f64>,
    /// When each pulse begins, since the beginning of its stretch, s.
    pulse_starts: Checkpoints,
    crowds: Crowds,
}

/// One stretch of motion between two full stops as it leaves the filters: its times are filtered times.
#[derive(Clone, Copy)]
pub struct Motion<'a> {
    segments: &'a Segments,
    pulses: &'a Pulses,
    filter: &'a FilterChain,
    distances: &'a Checkpoints,
    pulse_starts: &'a Checkpoints,
    crowds: &'a Crowds,
    first_pulse: usize,
    /// One past the last pulse.
    end_pulse: usize,
    /// Where the machine is later than its filters.
    knots: &'a [Knot],
}

impl<'a> Profile<'a> {
    /// The profile of a plan for a toolpath.
    pub fn new(toolpath: &'a Toolpath, plan: &'a FeedPlan) -> Profile<'a> {
        let segments = &toolpath.segments;
        let mut distances = Checkpoints::with_room(segments.len());
        distances.add_run((0..segments.len()).map(|segment| segments.length(segment)));
        let mut pulse_starts = Checkpoints::with_room(plan.pulses.len());
        for stretch in plan.stretches() {
            pulse_starts.add_run(stretch.pulses.clone().map(|pulse| plan.pulses.duration(pulse)));
        }
        let crowds = Crowds::of(plan, segments);
        let mut profile =
            Profile { toolpath, plan, distances, phase_starts: Vec::new(), pulse_starts, crowds };
        let durations: Vec<f64> = plan.phases.iter().map(|phase| profile.phase_duration(phase)).collect();
        let first = [plan.start].into_iter();
        profile.phase_starts = running_sum(first.chain(durations)).collect();
        profile
    }

    /// Cycle time, s.
    pub fn cycle_time(&self) -> f64 {
        self.phase_starts.last().copied().unwrap_or(0.0)
    }

    /// Length of the programmed path, mm.
    pub fn length(&self) -> f64 {
        self.distance_before(self.toolpath.segments.len())
    }

    /// The motion at a time since the start (s); before it and after the end the machine stands.
    pub fn at_time(&self, time: f64) -> State {
        let Some(index) = self.phase_at(time) else {
            return self.standing(0);
        };
        match &self.plan.phases[index] {
            Phase::Wait(_) => self.standing(self.segments_before(index)),
            Phase::Motion(stretch) => {
                Walk::of(self.motion(stretch)).state_at(time - self.phase_starts[index])
            }
        }
    }

    /// Acceleration and jerk at a time since the start (s); none while the machine stands.
    pub fn dynamics_at_time(&self, time: f64) -> Option<Dynamics> {
        let index = self.phase_at(time)?;
        let Phase::Motion(stretch) = &self.plan.phases[index] else { return None };
        let motion = self.motion(stretch);
        Some(motion.dynamics_at(time - self.phase_starts[index]))
    }

    /// When the tool has run `distance` (mm) of the programmed path, s: the last moment at which
    /// it has not run more.
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

    /// When a phase of the plan begins and ends, s.
    pub fn phase_time(&self, phase: usize) -> std::ops::Range<f64> {
        self.phase_starts[phase]..self.phase_starts[phase + 1]
    }

    /// The motion of a stretch.
    pub fn motion(&self, stretch: &Stretch) -> Motion<'_> {
        Motion {
            segments: &self.toolpath.segments,
            pulses: &self.plan.pulses,
            filter: &self.plan.filters[stretch.filter],
            distances: &self.distances,
            pulse_starts: &self.pulse_starts,
            crowds: &self.crowds,
            first_pulse: stretch.pulses.start,
            end_pulse: stretch.pulses.end,
            knots: self.plan.knots(stretch),
        }
    }

    /// Length of the programmed path before a segment, mm.
    pub fn distance_before(&self, segment: usize) -> f64 {
        self.distances.before(&self.toolpath.segments, 0, segment)
    }

    fn phase_duration(&self, phase: &Phase) -> f64 {
        match phase {
            Phase::Wait(wait) => wait.duration,
            Phase::Motion(stretch) => {
                let motion = self.motion(stretch);
                motion.duration() + lost(motion.knots)
            }
        }
    }

    fn phase_at(&self, time: f64) -> Option<usize> {
        let begun = self.phase_starts.partition_point(|&start| start <= time);
        (begun.min(self.plan.phases.len())).checked_sub(1)
    }

    /// How many segments lie before a phase.
    fn segments_before(&self, phase: usize) -> usize {
        let stretch = self.plan.phases[..phase].iter().rev().find_map(|phase| match phase {
            Phase::Motion(stretch) => Some(stretch.segments.end),
            Phase::Wait(_) => None,
        });
        stretch.unwrap_or(0)
    }

    /// The machine standing after so many segments.
    fn standing(&self, segments: usize) -> State {
        let all = &self.toolpath.segments;
        let position = match segments.checked_sub(1) {
            Some(last) => all.at(last).end,
            None => all.first().map_or(Point::origin(), |first| first.start),
        };
        State { distance: self.distance_before(segments), position, velocity: Default::default() }
    }
}

impl<'a> Motion<'a> {
    /// How long the command lasts, s.
    pub fn command_time(&self) -> f64 {
        let last = self.end_pulse - 1;
        self.pulse_start(last) + self.pulses.duration(last)
    }

    /// How long the motion lasts, s: the command and the filter delay.
    pub fn duration(&self) -> f64 {
        self.command_time() + self.filter.delay()
    }

    /// When a pulse of the plan begins, s since the beginning of the stretch.
    pub fn pulse_start(&self, pulse: usize) -> f64 {
        self.pulse_starts.before(self.pulses, self.first_pulse, pulse)
    }

    /// When its pulses begin, s since the beginning of the stretch.
    fn starts(&self) -> Sums<'a, Pulses> {
        Sums::of(self.pulse_starts, self.pulses, self.first_pulse..self.end_pulse)
    }

    /// The filters the motion runs through.
    pub fn filter(&self) -> &FilterChain {
        self.filter
    }

    /// The moment so long (s) after the beginning of the stretch.
    pub fn moment(&self, time: f64) -> Moment {
        self.starts().moment(self.first_pulse, time)
    }
}

impl Sums<'_, Pulses> {
    /// The moment so long (s) after the beginning of the stretch, if the pulse `from` begins no later or is the first.
    fn moment(&mut self, from: usize, time: f64) -> Moment {
        let pulse = self.first_above(from + 1, 0.0, time) - 1;
        Moment { pulse, elapsed: (time - self.before(pulse)).max(0.0) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::Machine;
    use crate::simulation::feed::{Rule, command};
    use crate::simulation::gcode::read;
    use crate::simulation::toolpath::trace;

    #[test]
    fn lists_of_a_long_program_have_no_more_room_than_they_need() {
        // More than a power of two of everything, so that lists that grow by doubling would be seen.
        let moves = (0..5000).map(|at| format!("X{}.{} Y{}\n", at / 4, 25 * (at % 4), at % 3));
        let text: String = ["G21 G90 G1 F6000\n".to_string()].into_iter().chain(moves).collect();
        let machine = Machine::default();
        let toolpath = trace(&read(text.as_bytes()), &machine);
        let plan = command(&toolpath, &machine, Rule::Isolated(0.01));
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
