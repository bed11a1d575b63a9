//! A motion along which one goes from moment to moment.
//!
//! When pulses begin, and how far along the path segments do, is kept at checkpoints only, as in `sums`. Who asks for
//! moments near one another has what lies between these worked out once.

use crate::simulation::feed::Pulses;
use crate::simulation::profile::sums::Sums;
use crate::simulation::profile::{Moment, Motion, State};
use crate::simulation::toolpath::Segments;

/// A motion with the sums around the moments that were asked for last.
pub struct Walk<'a> {
    /// The motion.
    pub motion: Motion<'a>,
    /// When pulses begin, s since the beginning of the stretch.
    pub(super) starts: Sums<'a, Pulses>,
    /// Length of the programmed path before segments, mm.
    pub(super) distances: Sums<'a, Segments>,
}

impl<'a> Walk<'a> {
    /// Nothing was asked for yet.
    pub fn of(motion: Motion<'a>) -> Walk<'a> {
        let all_segments = 0..motion.segments.len() + 1;
        let distances = Sums::of(motion.distances, motion.segments, all_segments);
        Walk { motion, starts: motion.starts(), distances }
    }

    /// When a pulse of the plan begins, s since the beginning of the stretch.
    pub fn pulse_start(&mut self, pulse: usize) -> f64 {
        self.starts.before(pulse)
    }

    /// The moment so long (s) after the beginning of the stretch.
    pub fn moment(&mut self, time: f64) -> Moment {
        self.moment_from(self.motion.first_pulse, time)
    }

    /// The same where the pulse `from` begins no later, and not long before.
    pub fn moment_from(&mut self, from: usize, time: f64) -> Moment {
        self.starts.moment(from, time)
    }

    /// Where the tool is and how fast it moves: what [`Motion::state`] tells.
    pub fn state(&mut self, moment: Moment) -> State {
        self.motion.state_along(moment, &mut |segment| self.distances.before(segment))
    }

    /// The distance along the programmed path (mm) and how fast it grows (mm/s): the sum of the
    /// filtered feed command, which at a corner is more than the feedrate of the tool.
    pub(super) fn progress(&mut self, moment: Moment) -> (f64, f64) {
        self.motion.progress_along(moment, &mut |segment| self.distances.before(segment))
    }
}
