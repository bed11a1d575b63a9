//! Step segments: the short times of constant feedrate in which a step timer runs the ramps of a block.
//!
//! The planner of grbl gives each block a trapezoid of the feedrate v(t), but the step timer runs it in segments of a
//! fixed time τ (s), each at the mean of v over it:
//!
//! ```text
//! v_k = 1/τ ∫ v dt   from (k − 1) τ to k τ, the time counted from the beginning of the block (mm/s)
//! ```
//!
//! The last segment of a block ends with it and may be shorter. Blocks last as long as without segments, and their ends are
//! passed at the same times; in between the tool is off by up to a τ²/8 (a: acceleration, mm/s²), 0.02 mm at 1500 mm/s²
//! and 10 ms. A corner is entered and left at the mean feedrates of its two segments, faster than the planner's.
//!
//! The timer counts one cycle more than it was set to. With the frequency f of the timer (Hz), and the number of steps
//! n (1/mm) that the axis with the most steps takes for a distance along the path, a segment lasts longer by the factor
//!
//! ```text
//! 1 + m n v / f        m = 1, 2, 4, 8 ticks for each step from 0, 2000, 4000, 8000 cycles f / (n v) on
//! ```
//!
//! which is 0.05 to 0.1 % at 250 steps/mm and 16 MHz up to 64 mm/s.
//!
//! Source: grbl 1.1, stepper.c, `st_prep_buffer`: `DT_SEGMENT` (10 ms), adaptive multi-axis step smoothing, and the compare
//! register of a timer that is cleared on a match. Limits: a ramp longer than [`MAX_SEGMENTS`] segments has longer ones.

use crate::machine::Machine;
use crate::simulation::feed::block::BlockPart;
use crate::simulation::toolpath::Vector;

/// Most segments of one ramp.
const MAX_SEGMENTS: f64 = 1000.0;
/// Cycles between two steps from which on the timer ticks several times for each, and the number of ticks.
const SMOOTHING_LEVELS: [(f64, f64); 3] = [(8000.0, 8.0), (4000.0, 4.0), (2000.0, 2.0)];

/// The step timer of a control on one block.
#[derive(Clone, Copy)]
pub struct StepTimer {
    /// Time of a segment, s; positive.
    segment: f64,
    /// Time of one cycle for each step along the path: n / f, s/mm; 0 for an exact timer.
    cycle_per_distance: f64,
}

/// A segment that has begun: the time (s) and the distance (mm) that it has so far.
#[derive(Clone, Copy, Default)]
struct OpenSegment {
    duration: f64,
    distance: f64,
}

impl StepTimer {
    /// Returns the timer of a machine on a block in a direction, a unit vector; `None` if ramps are continuous.
    pub fn of(machine: &Machine, direction: impl FnOnce() -> Vector) -> Option<StepTimer> {
        let segment = machine.interpolator.step_segment;
        if segment == 0.0 {
            return None;
        }
        let frequency = machine.interpolator.step_timer;
        let steps_per_mm = |direction: Vector| {
            let of_axis = |axis: usize| match machine.axes[axis].step {
                0.0 => 0.0,
                step => direction[axis].abs() / step,
            };
            (0..3).map(of_axis).fold(0.0, f64::max)
        };
        Some(StepTimer { segment, cycle_per_distance: steps_per_mm(direction()) / frequency })
    }

    /// Returns the parts of the block in segments.
    pub fn run(self, parts: impl IntoIterator<Item = BlockPart>) -> Vec<BlockPart> {
        let mut segments = Vec::new();
        let mut open = OpenSegment::default();
        for part in parts.into_iter().filter(|(duration, ..)| 0.0 < *duration) {
            self.run_part(part, &mut open, &mut segments);
        }
        self.end(&mut open, &mut segments);
        segments
    }

    /// Runs a part of a block: adds the segments that end in it, and leaves the last one open.
    fn run_part(
        self,
        (duration, first, last): BlockPart,
        open: &mut OpenSegment,
        segments: &mut Vec<BlockPart>,
    ) {
        let slope = (last - first) / duration;
        let is_ramp = slope != 0.0;
        let segment = if is_ramp { self.segment.max(duration / MAX_SEGMENTS) } else { self.segment };
        let distance = |from: f64, to: f64| (to - from) * (first + 0.5 * slope * (from + to));
        let mut run = 0.0;
        while run < duration {
            let whole = duration - (duration - run) % segment;
            // Whole segments of one feedrate are as good as one.
            let until = if is_ramp || 0.0 < open.duration {
                (run + segment - open.duration).clamp(run, duration)
            } else if run < whole {
                whole
            } else {
                duration
            };
            open.duration += until - run;
            open.distance += distance(run, until);
            run = until;
            if segment * (1.0 - 1e-9) <= open.duration {
                self.end(open, segments);
            }
        }
    }

    /// Ends the segment, if one has begun.
    fn end(self, open: &mut OpenSegment, segments: &mut Vec<BlockPart>) {
        let OpenSegment { duration, distance } = std::mem::take(open);
        if 0.0 < duration {
            let duration = duration * self.duration_ratio(distance / duration);
            let mean = distance / duration;
            segments.push((duration, mean, mean));
        }
    }

    /// Returns the ratio of the duration of a segment to its planned duration; `feedrate` is its planned feedrate, mm/s.
    fn duration_ratio(self, feedrate: f64) -> f64 {
        let per_step = feedrate * self.cycle_per_distance;
        let ticks =
            SMOOTHING_LEVELS.iter().find(|(from, _)| from * per_step <= 1.0).map_or(1.0, |level| level.1);
        1.0 + ticks * per_step
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation::feed::block::{BlockEnd, parts};

    const TAU_S: f64 = 0.01;
    const EXACT: StepTimer = StepTimer { segment: TAU_S, cycle_per_distance: 0.0 };

    fn block(length: f64, feedrate: f64, first: f64, last: f64) -> Vec<BlockPart> {
        let end = |feedrate: f64| BlockEnd { feedrate, hold: 0.0 };
        parts(length, feedrate, 500.0, end(first), end(last)).to_vec()
    }

    fn totals(parts: &[BlockPart]) -> (f64, f64) {
        let time = parts.iter().map(|(duration, ..)| duration).sum();
        (time, parts.iter().map(|(duration, first, last)| 0.5 * duration * (first + last)).sum())
    }

    #[test]
    fn segments_take_the_time_and_the_way_of_their_block() {
        for (length, feedrate, first, last) in
            [(20.0, 50.0, 0.0, 0.0), (3.0, 50.0, 4.0, 11.0), (0.05, 30.0, 8.0, 8.5), (700.0, 5.0, 5.0, 0.0)]
        {
            let whole = block(length, feedrate, first, last);
            let segments = EXACT.run(whole.clone());
            let ((time, way), (own_time, own_way)) = (totals(&whole), totals(&segments));
            assert!((time - own_time).abs() < 1e-12 * time, "{length} mm: {own_time} s for {time} s");
            assert!((way - own_way).abs() < 1e-9 && (way - length).abs() < 1e-9, "{length} mm: {own_way} mm");
            assert!(segments.iter().all(|(_, from, to)| from == to), "each has one feedrate");
            let most = feedrate / 500.0 * 2.0 / TAU_S + 6.0;
            assert!((segments.len() as f64) < most, "{} segments: cruising has one", segments.len());
        }
    }

    #[test]
    fn each_segment_of_a_ramp_has_its_mean_feedrate() {
        // 0 to 12 mm/s at 500 mm/s² in 24 ms, then 12 mm/s.
        let segments = EXACT.run(block(2.0, 12.0, 0.0, 12.0));
        let feedrates: Vec<f64> = segments.iter().map(|(_, from, _)| *from).collect();
        // The third segment ramps for 4 ms from 10 to 12 mm/s and cruises for 6 ms.
        let expected = [2.5, 7.5, 0.4 * 11.0 + 0.6 * 12.0, 12.0];
        assert!(
            feedrates.iter().zip(expected).all(|(own, other)| (own - other).abs() < 1e-9),
            "{feedrates:?}"
        );
    }

    #[test]
    fn long_ramps_have_a_bounded_number_of_segments() {
        let slow = EXACT.run([(1e6, 0.0, 50.0)]);
        assert!(slow.len() as f64 <= MAX_SEGMENTS + 1.0, "{}", slow.len());
    }

    #[test]
    fn each_step_takes_one_cycle_more() {
        let mut machine = Machine::default();
        machine.interpolator.step_segment = TAU_S;
        machine.interpolator.step_timer = 16e6;
        machine.axes.iter_mut().for_each(|axis| axis.step = 0.004);
        let along = |direction: Vector| StepTimer::of(&machine, || direction).expect("it has segments");
        let timer = along(Vector::x());
        // 1000 steps in 4 mm at 50 mm/s: 1280 cycles of 62.5 ns between two steps, and then 1281.
        let (time, way) = totals(&timer.run([(0.08, 50.0, 50.0)]));
        assert!(
            (time - 1000.0 * 1281.0 / 16e6).abs() < 1e-12 && (way - 4.0).abs() < 1e-9,
            "{time} s, {way} mm"
        );
        // At 10 mm/s four ticks of 1600 cycles for each step.
        let (time, _) = totals(&timer.run([(0.4, 10.0, 10.0)]));
        assert!((time - 4000.0 * 1601.0 / 16e6).abs() < 1e-12, "{time} s");
        let diagonal = along(Vector::new(0.6, -0.8, 0.0));
        assert!((diagonal.duration_ratio(50.0) - (1.0 + 0.8 / 1280.0)).abs() < 1e-12);
        machine.axes.iter_mut().for_each(|axis| axis.step = 0.0);
        assert_eq!(StepTimer::of(&machine, Vector::x).map(|timer| timer.duration_ratio(50.0)), Some(1.0));
    }
}
