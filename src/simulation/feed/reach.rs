//! The corners and feedrates of a rest-to-rest motion that a planner can run, given its look-ahead, the ramps
//! between neighbours and its minimum cruise ratio.
//!
//! The planner must be able to stop within the blocks that it knows. The last column names what this limits.
//!
//! | planner | law of a single corner | ramps | limited by the look-ahead |
//! |---|---|---|---|
//! | filters | tolerance | steps, smoothed by the filters | feedrates |
//! | filters after an acceleration | tolerance | constant acceleration | feedrates |
//! | grbl, Klipper, Marlin | junction law | constant acceleration | feedrates; corners, without the running block |
//! | any of these, with a jerk along the path | unchanged | constant jerk | unchanged, corners by these ramps |
//! | LinuxCNC | circle or parabola (`corner_blend`) | constant acceleration per piece | starts of lines and circles |
//!
//! Between neighbours v² changes by 2 a L at most over a segment of length L (mm) and acceleration a (mm/s²), so
//! that with N blocks of look-ahead, of which the first is run, a corner before block k is passed at
//!
//! ```text
//! v_k² ≤ Σ 2 a_j L_j      j = k … k + N − 2
//! ```
//!
//! With a jerk along the path each ramp ends within its block. v_k is then the feedrate from which such ramps stop
//! within blocks k to k + N − 2.
//!
//! Source: grbl 1.1, planner.c, which always plans a stop behind the last block it knows; derived for the others.

use crate::machine::Junction;
use crate::simulation::feed::ramp::Ramp;
use crate::simulation::feed::rest_to_rest::MotionPlanner;
use crate::simulation::feed::{cruise, junction, limits};
use crate::simulation::running_sum::running_sum;

impl MotionPlanner<'_> {
    /// Returns the feedrates at which the control supplies blocks, mm/s: each block is processed in time, and
    /// a stop fits within the look-ahead; `None` if blocks are always available.
    pub(super) fn supplied(&self) -> Option<Vec<f64>> {
        let interpolator = &self.machine.interpolator;
        // Blends are planned with the look-ahead, piece by piece.
        let is_blended = interpolator.junction.blends_in_time();
        let look_ahead = if is_blended { f64::INFINITY } else { interpolator.look_ahead };
        if interpolator.block_time == 0.0 && look_ahead == f64::INFINITY {
            return None;
        }
        let count = self.range.len();
        let mut travelled = vec![0.0];
        travelled.extend(running_sum((0..count).map(|i| self.length(i))));
        let braked = self.plans_trapezoids().then(|| self.braked());
        let supplied = |i: usize| {
            let processed = self.length(i) / interpolator.block_time;
            let seen = look_ahead.min(count as f64) as usize + i;
            // The end of the motion is a stop, so that a planner which sees it needs no limit.
            let Some(end) = travelled.get(seen).filter(|_| seen < count) else { return processed };
            let visible = end - travelled[i];
            let acceleration = match &braked {
                Some(braked) if braked[seen].is_finite() => 0.5 * (braked[seen] - braked[i]) / visible,
                _ => self.segment_limits.accelerations[i],
            };
            let stopping = limits::stopping_feedrate(visible, self.filter.half_delay(), acceleration);
            processed.min(stopping.hypot(self.at_rest(seen - 1, 1)))
        };
        Some((0..count).map(supplied).collect())
    }

    /// Returns `true` if a corner may be too fast for its neighbours.
    pub(super) fn has_reach(&self) -> bool {
        self.machine.limits_command() || self.machine.limits_jerk()
    }

    /// Returns `true` if the corner law belongs to a planner of trapezoids, which knows blocks one by one.
    fn plans_trapezoids(&self) -> bool {
        self.machine.interpolator.junction != Junction::Tolerance
            && !self.machine.interpolator.junction.blends_in_time()
    }

    /// Returns Σ 2 a L: the largest change of v² from the beginning of the motion up to each corner, mm²/s².
    fn braked(&self) -> Vec<f64> {
        let changes = (0..self.range.len()).map(|i| 2.0 * self.acceleration(i) * self.length(i));
        std::iter::once(0.0).chain(running_sum(changes)).collect()
    }

    /// Lowers the corners (mm/s) of a planner of trapezoids to those from which it can stop within the blocks
    /// that it knows at the corner: its look-ahead without the block that is run up to the corner.
    fn see_ahead(&self, corners: &mut [f64]) {
        let look_ahead = self.machine.interpolator.look_ahead;
        if look_ahead == f64::INFINITY || !self.plans_trapezoids() {
            return;
        }
        if self.machine.limits_jerk() {
            return self.see_ahead_with_jerk(corners, look_ahead as usize);
        }
        let braked = self.braked();
        for (i, corner) in corners.iter_mut().enumerate() {
            let seen = (i as f64 + look_ahead) as usize;
            if let Some(end) = braked.get(seen).filter(|end| seen < braked.len() - 1 && end.is_finite()) {
                let stopping = (end - braked[i + 1]).max(0.0).sqrt();
                *corner = corner.min(stopping.hypot(self.at_rest(seen - 1, 1)));
            }
        }
    }

    /// Returns the feedrate at which a segment can begin at a rest, or, with `end` 1, end at one, mm/s.
    fn at_rest(&self, i: usize, end: usize) -> f64 {
        junction::step_at_rest(self.machine).map_or(0.0, |step| step / self.tangents(i)[end].amax())
    }

    /// Lowers the corners (mm/s) as [`MotionPlanner::see_ahead`] does for a planner of ramps with constant jerk,
    /// which ends each ramp within a block.
    fn see_ahead_with_jerk(&self, corners: &mut [f64], look_ahead: usize) {
        let ramps: Vec<Option<(Ramp, f64)>> =
            (0..corners.len()).map(|i| Some((self.ramp(i)?, self.length(i)))).collect();
        for i in 0..corners.len() {
            let end = i + look_ahead;
            if ramps.len() <= end {
                break;
            }
            let most = corners[i];
            let stopping = ramps[i + 1..end].iter().rev().try_fold(0.0, |from, ramp| {
                let (ramp, length) = ramp.as_ref()?;
                let reached = ramp.reach(from, *length, most);
                (reached < most).then_some(reached)
            });
            corners[i] = stopping.unwrap_or(most);
        }
    }

    /// Lowers the feedrates and corners (mm/s) of short moves by the minimum cruise ratio; `limits` are the
    /// limits of the corners themselves (mm/s).
    fn cruise(&self, limits: &[f64], corners: &mut [f64], feedrates: &mut [f64]) {
        let left = 1.0 - self.machine.interpolator.minimum_cruise_ratio;
        let whole = self.machine.path.acceleration;
        let of = |i: usize| {
            let acceleration = self.acceleration(i);
            let of_peak =
                if whole.is_finite() { acceleration.min(left * whole) } else { left * acceleration };
            cruise::PlannedMove { length: self.length(i), acceleration, peak_acceleration: of_peak }
        };
        cruise::lower(of, limits, corners, feedrates);
        self.reach_neighbours(corners, feedrates);
    }

    /// Lowers corners and feedrates (mm/s) to those that the planner can run. Returns the feedrates at which the motion
    /// begins and ends at its rests, mm/s.
    pub(super) fn reach(&self, corners: &mut [f64], feedrates: &mut [f64]) -> [f64; 2] {
        if !self.has_reach() {
            return [0.0; 2];
        }
        self.see_ahead(corners);
        let cruises = self.machine.limits_command() && 0.0 < self.machine.interpolator.minimum_cruise_ratio;
        let limits = if cruises { self.slower_of_both(corners, feedrates) } else { Vec::new() };
        let at_rests = self.reach_neighbours(corners, feedrates);
        if cruises {
            self.cruise(&limits, corners, feedrates);
        }
        at_rests
    }

    /// Returns the corner after each segment (mm/s), limited to the feedrates of both sides.
    fn slower_of_both(&self, corners: &[f64], feedrates: &[f64]) -> Vec<f64> {
        let next = feedrates.iter().skip(1).copied().chain([0.0]);
        corners
            .iter()
            .zip(feedrates)
            .zip(next)
            .map(|((corner, own), next)| corner.min(*own).min(next))
            .collect()
    }

    /// Lowers the corners after each segment (mm/s) that their neighbours could not reach, or leave, within
    /// the acceleration limit: |c1² − c2²| ≤ 2 A L for every segment. Returns the feedrates at which the motion begins and
    /// ends at its rests, mm/s.
    fn reach_neighbours(&self, corners: &mut [f64], feedrates: &[f64]) -> [f64; 2] {
        let reach = |from: f64, to: f64, i: usize| match self.ramp(i) {
            Some(ramp) => ramp.reach(from, self.length(i), to),
            None => to.min((from * from + 2.0 * self.acceleration(i) * self.length(i)).sqrt()),
        };
        let last = corners.len() - 1;
        let begin = self.at_rest(0, 0).min(feedrates[0]);
        let mut before = begin;
        for (i, corner) in corners[..last].iter_mut().enumerate() {
            *corner = reach(before, corner.min(feedrates[i]).min(feedrates[i + 1]), i);
            before = *corner;
        }
        let end = reach(before, self.at_rest(last, 1).min(feedrates[last]), last);
        let mut after = end;
        for i in (1..=last).rev() {
            after = reach(after, corners[i - 1], i);
            corners[i - 1] = after;
        }
        [reach(after, begin, 0), end]
    }
}
