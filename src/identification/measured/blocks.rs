//! Chains of short blocks: the time of each block.

use crate::identification::measured::events::{LawEvent, LawEvents};
use crate::identification::measured::run_course::{MIN_REACHED_RATIO, RunCourse};
use crate::simulation::toolpath::{Curve, Motion};

/// Largest programmed time of a short block, s: its length over its feedrate.
const MAX_SHORT_BLOCK_S: f64 = 0.1;
/// Largest turn at either end of a block, rad: at a larger turn the corner instead of the block supply would
/// limit the motion.
const MAX_BLOCK_TURN_RAD: f64 = 15.0 * std::f64::consts::PI / 180.0;

/// Returns the short blocks that lie between short blocks and turn little at both ends.
pub fn blocks(course: &RunCourse) -> LawEvents {
    let mut found = LawEvents::default();
    let segments = &course.toolpath.segments;
    let is_short = |segment: usize| match segments.motion(segment) {
        Motion::Feed { feedrate } => {
            *segments.curve(segment) == Curve::Line && segments.length(segment) < MAX_SHORT_BLOCK_S * feedrate
        }
        Motion::Rapid { .. } => false,
    };
    let goes_on =
        |segment: usize| !course.stops_before(segment + 1) && course.turn(segment) < MAX_BLOCK_TURN_RAD;
    for segment in 1..segments.len().saturating_sub(1) {
        let is_in_chain = [segment - 1, segment, segment + 1].into_iter().all(is_short);
        if !is_in_chain || !goes_on(segment - 1) || !goes_on(segment) {
            continue;
        }
        found.places += 1;
        let (begin, end) = (course.distances[segment], course.distances[segment + 1]);
        let Some((from, to)) = course.passed(begin).zip(course.passed(end)) else { continue };
        let Some(told) = course.commanded(segment).filter(|_| from < to) else { continue };
        let is_at_feed = MIN_REACHED_RATIO * told * (to - from) <= end - begin;
        found.events.push(LawEvent::new("", end - begin, to - from, segment).at_feed(is_at_feed));
    }
    found
}
