//! Step segments: pieces of constant feedrate by which a control with a step timer runs the ramps of a block.
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
//! Source: grbl 1.1, stepper.c, `st_prep_buffer`, `DT_SEGMENT` (10 ms). Limits: a ramp longer than [`MAX_SEGMENTS`]
//! segments has longer ones.

use crate::simulation::feed::block::BlockPart;

/// Most segments of one ramp.
const MAX_SEGMENTS: f64 = 1000.0;

/// A segment that has begun: the time (s) and the distance (mm) that it has so far.
#[derive(Clone, Copy, Default)]
struct OpenSegment {
    duration: f64,
    distance: f64,
}

/// Returns the parts of one block in segments of `segment` seconds, which is positive.
pub fn in_segments(parts: impl IntoIterator<Item = BlockPart>, segment: f64) -> Vec<BlockPart> {
    let mut segments = Vec::new();
    let mut open = OpenSegment::default();
    for part in parts.into_iter().filter(|(duration, ..)| 0.0 < *duration) {
        open.run(part, segment, &mut segments);
    }
    open.end(&mut segments);
    segments
}

impl OpenSegment {
    /// Runs a part of a block: adds the segments that end in it, and leaves the one that goes on.
    fn run(&mut self, (duration, first, last): BlockPart, segment: f64, segments: &mut Vec<BlockPart>) {
        let slope = (last - first) / duration;
        let segment = segment.max(duration / MAX_SEGMENTS * f64::from(u8::from(slope != 0.0)));
        let distance = |from: f64, to: f64| (to - from) * (first + 0.5 * slope * (from + to));
        let mut run = 0.0;
        while run < duration {
            let mut until = (run + segment - self.duration).clamp(run, duration);
            // Segments of one feedrate are as good as one.
            if slope == 0.0 && self.duration == 0.0 {
                until = duration - (duration - run) % segment;
                if until <= run {
                    until = duration;
                }
            }
            self.duration += until - run;
            self.distance += distance(run, until);
            run = until;
            if segment * (1.0 - 1e-9) <= self.duration {
                self.end(segments);
            }
        }
    }

    /// Ends the segment, if one has begun.
    fn end(&mut self, segments: &mut Vec<BlockPart>) {
        let OpenSegment { duration, distance } = std::mem::take(self);
        if 0.0 < duration {
            let mean = distance / duration;
            segments.push((duration, mean, mean));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation::feed::block::{BlockEnd, parts};

    const TAU_S: f64 = 0.01;

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
            let segments = in_segments(whole.clone(), TAU_S);
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
        let segments = in_segments(block(2.0, 12.0, 0.0, 12.0), TAU_S);
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
        let slow = in_segments([(1e6, 0.0, 50.0)], TAU_S);
        assert!(slow.len() as f64 <= MAX_SEGMENTS + 1.0, "{}", slow.len());
    }
}
