//! Time scaling: filtered motion run more slowly along the same path.
//!
//! The filters send the tool along its path with the feedrate w(τ) at the filtered time τ. If the machine
//! cannot follow, it runs the same path at v ≤ w, at the true time t:
//!
//! ```text
//! v dt = w dτ = dσ,      lost time = t − τ
//! ```
//!
//! Between two knots v is linear in t and w is linear in τ, both over the same distance σ, so that each time
//! follows from the other in closed form:
//!
//! ```text
//! σ = w0 y + ½ c y² = v0 x + ½ a x²,     y = τ − τ0,  x = t − t0
//! ```
//!
//! Between two knots with v = w no further time is lost. Units: mm, s.

use std::ops::Range;

use crate::simulation::feed::RestToRest;

/// The state of a motion at one moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Knot {
    /// Filtered time since the beginning of the motion, s.
    pub filtered: f64,
    /// Time lost since the beginning of the motion, s.
    pub lost: f64,
    /// Feedrate of the tool as it leaves the filters, mm/s.
    pub filtered_feedrate: f64,
    /// Feedrate of the tool, mm/s; never above the filtered one.
    pub feedrate: f64,
}

/// The filtered time at a true time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilteredTime {
    /// Filtered time since the beginning of the motion, s.
    pub filtered: f64,
    /// Feedrate of the tool (mm/s) and its slope (mm/s²); `None` if it is the filtered one.
    pub feedrate: Option<(f64, f64)>,
}

/// The lost time of a program.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TimeScaling {
    knots: Vec<Knot>,
    /// The first segment of each motion that loses time, and the indices of its knots.
    stretches: Vec<(usize, Range<usize>)>,
    /// Segments and the time lost on each, s, in order.
    segments: Vec<(usize, f64)>,
}

impl TimeScaling {
    /// Adds a motion that loses time: its knots from beginning to end, and the segments (ascending) with the
    /// time lost on each, s.
    pub fn push(&mut self, rest_to_rest: &RestToRest, knots: &[Knot], segments: &[(usize, f64)]) {
        let begin = self.knots.len();
        self.knots.extend_from_slice(knots);
        self.stretches.push((rest_to_rest.segments.start, begin..self.knots.len()));
        self.segments.extend_from_slice(segments);
    }

    /// Returns `true` if no time is lost.
    pub fn is_empty(&self) -> bool {
        self.stretches.is_empty()
    }

    /// Returns those of `segments` on which time is lost, with the lost time, s.
    pub fn lost_on(&self, segments: Range<usize>) -> &[(usize, f64)] {
        let before = |segment: usize| self.segments.partition_point(|(at, _)| *at < segment);
        &self.segments[before(segments.start)..before(segments.end)]
    }

    /// Returns the knots of a motion; empty if it loses no time.
    pub fn knots(&self, rest_to_rest: &RestToRest) -> &[Knot] {
        let found = self.stretches.binary_search_by_key(&rest_to_rest.segments.start, |(first, _)| *first);
        found.map_or(&[], |index| &self.knots[self.stretches[index].1.clone()])
    }
}

/// Returns the time lost in a motion with these knots, s.
pub fn lost_time(knots: &[Knot]) -> f64 {
    knots.last().map_or(0.0, |knot| knot.lost)
}

/// Returns the filtered time at a true time since the beginning of the motion, s.
pub fn filtered_time(knots: &[Knot], time: f64) -> FilteredTime {
    let after = knots.partition_point(|knot| knot.filtered + knot.lost <= time);
    let Some([from, to]) = between(knots, after) else {
        let lost = after.checked_sub(1).map_or(0.0, |last| knots[last].lost);
        return FilteredTime { filtered: time - lost, feedrate: None };
    };
    let (began, ends) = (from.filtered + from.lost, to.filtered + to.lost);
    let slope = (to.feedrate - from.feedrate) / (ends - began);
    let elapsed = time - began;
    let run = elapsed * (from.feedrate + 0.5 * slope * elapsed);
    let filtered = from.filtered
        + time_over(run, from.filtered_feedrate, to.filtered_feedrate, to.filtered - from.filtered);
    FilteredTime { filtered, feedrate: Some((from.feedrate + slope * elapsed, slope)) }
}

/// Returns the true time since the beginning of the motion at a filtered time, s.
pub fn true_time(knots: &[Knot], filtered: f64) -> f64 {
    let after = knots.partition_point(|knot| knot.filtered <= filtered);
    let Some([from, to]) = between(knots, after) else {
        return filtered + after.checked_sub(1).map_or(0.0, |last| knots[last].lost);
    };
    let lasts = to.filtered - from.filtered;
    let elapsed = filtered - from.filtered;
    let slope = (to.filtered_feedrate - from.filtered_feedrate) / lasts;
    let run = elapsed * (from.filtered_feedrate + 0.5 * slope * elapsed);
    from.filtered + from.lost + time_over(run, from.feedrate, to.feedrate, lasts + (to.lost - from.lost))
}

/// Returns the knots around a time at which the tool is slower than the filtered motion; `None` if it is not.
fn between(knots: &[Knot], after: usize) -> Option<[Knot; 2]> {
    let pair = [*knots.get(after.checked_sub(1)?)?, *knots.get(after)?];
    pair.iter().any(|knot| knot.feedrate < knot.filtered_feedrate).then_some(pair)
}

/// Returns the time over `distance` (mm) if the feedrate rises from `first` to `last` (mm/s) in `duration`,
/// s.
fn time_over(distance: f64, first: f64, last: f64, duration: f64) -> f64 {
    let slope = (last - first) / duration;
    let feedrate = (first * first + 2.0 * slope * distance).max(0.0).sqrt();
    let sum = first + feedrate;
    if sum == 0.0 { 0.0 } else { (2.0 * distance / sum).clamp(0.0, duration) }
}
