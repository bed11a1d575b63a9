//! A cursor over a filtered motion that caches prefix sums near the last query.
//!
//! The times of pulses and the distances of segments are kept at checkpoints only, as in `prefix_sums`.
//! Queries near one another compute the sums between checkpoints once.

use crate::simulation::feed::Pulses;
use crate::simulation::profile::prefix_sums::PrefixSums;
use crate::simulation::profile::{FilteredMotion, Moment, MotionState};
use crate::simulation::toolpath::Segments;

/// A motion with the prefix sums near the last query.
pub struct MotionCursor<'a> {
    /// The motion.
    pub motion: FilteredMotion<'a>,
    /// Times at which pulses begin, s since the beginning of the motion.
    pub(super) starts: PrefixSums<'a, Pulses>,
    /// Length of the programmed path before each segment, mm.
    pub(super) distances: PrefixSums<'a, Segments>,
}

impl<'a> MotionCursor<'a> {
    /// Returns a cursor with nothing cached.
    pub fn of(motion: FilteredMotion<'a>) -> MotionCursor<'a> {
        let all_segments = 0..motion.segments.len() + 1;
        let distances = PrefixSums::of(motion.distances, motion.segments, all_segments);
        MotionCursor { motion, starts: motion.starts(), distances }
    }

    /// Returns the time at which a pulse of the plan begins, s since the beginning of the motion.
    pub fn pulse_start(&mut self, pulse: usize) -> f64 {
        self.starts.before(pulse)
    }

    /// Returns the moment `time` seconds after the beginning of the motion.
    pub fn moment(&mut self, time: f64) -> Moment {
        self.moment_from(self.motion.first_pulse, time)
    }

    /// Returns the moment `time` seconds after the beginning of the motion; the pulse `from` begins shortly
    /// before it.
    pub fn moment_from(&mut self, from: usize, time: f64) -> Moment {
        self.starts.moment(from, time)
    }

    /// Returns position and velocity of the tool, as [`FilteredMotion::state`] does.
    pub fn state(&mut self, moment: Moment) -> MotionState {
        self.motion.state_along(moment, &mut |segment| self.distances.before(segment))
    }

    /// Returns the distance along the programmed path (mm) and its rate (mm/s): the integral of the filtered
    /// feed command, whose rate at a corner exceeds the feedrate of the tool.
    pub(super) fn progress(&mut self, moment: Moment) -> (f64, f64) {
        self.motion.progress_along(moment, &mut |segment| self.distances.before(segment))
    }
}
