//! Profile → contour error: the distance between the programmed path and the filtered one.
//!
//! The error at a programmed point X is its distance from the filtered path nearby,
//!
//! ```text
//! e(X) = min over t of ‖P(t) − X‖
//! ```
//!
//! The error is measured where it is largest: at every corner, and along arcs at points no more than a 24th
//! of the filter delay apart, there also from the filtered path to the programmed one. Between corners a line
//! is nearer to the filtered path than at its ends. At an isolated corner e is the tolerance for which the
//! corner law was computed; if several corners lie within one filter delay, e may be larger or smaller.
//!
//! The search begins half a filter delay after X was commanded. Its first step leads to where the distance
//! would be least if the path continued straight, each further step to where it would be least if the path
//! bent as between the last two steps. Once a step passes the nearest moment, regula falsi narrows the
//! bracket around it. The search stays within the delay, so that it cannot find another pass over the same
//! place.

mod sparse;
mod guaranteed;
mod regions;
mod off_path;

pub(crate) use guaranteed::guaranteed;
pub use regions::{ErrorRegion, regions_beyond};
pub use sparse::SparseColumn;

use std::cmp::Ordering;
use std::ops::Range;

use crate::simulation::feed::{FeedPlan, Pulses, RestToRest, ToleranceBound};
use crate::simulation::profile::{MotionState, Profile, RememberedSteps};
use crate::simulation::toolpath::{Curve, Point, Segment, Toolpath};

/// Contour errors along a program.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ContourErrors {
    /// At the corner that ends the segment and on arcs within half a filter delay of it, mm; 0 at a full
    /// stop. One entry per segment.
    pub corner: Vec<f64>,
    /// At the corner alone, mm, where that is less than `corner`: a corner between two tolerances has the
    /// smaller one, and an arc keeps its own.
    pub point: SparseColumn,
    /// Largest along the rest of an arc, mm.
    pub arc: SparseColumn,
}

impl ContourErrors {
    /// Returns the largest error, mm; 0 for a program without corners and arcs.
    pub fn largest(&self) -> f64 {
        self.corner.iter().chain(self.arc.values()).copied().fold(0.0, f64::max)
    }

    /// Returns the error at the corner that ends a segment, mm.
    fn at_point(&self, segment: usize) -> f64 {
        self.point.get(segment).unwrap_or(self.corner[segment])
    }

    /// Returns the largest error along a segment between its corners, mm; 0 along a line.
    fn along(&self, segment: usize) -> f64 {
        self.arc.get(segment).unwrap_or(0.0)
    }

    /// Returns the indices of the segments with an error above `ratio` times its bound, ascending.
    pub fn beyond(
        &self,
        bounds: impl Iterator<Item = ToleranceBound>,
        ratio: f64,
    ) -> impl Iterator<Item = usize> {
        bounds.enumerate().filter_map(move |(k, bound)| {
            let is_beyond = ratio * bound.corner < self.at_point(k)
                || ratio * bound.near < self.corner[k]
                || ratio * bound.along < self.along(k);
            is_beyond.then_some(k)
        })
    }
}

/// Points measured along an arc within one filter delay. With them an independent search along ten thousand random
/// paths finds an error beyond the tolerance on one at most, by less than 1 % of it (`tests/laws/guaranteed.rs`).
const POINTS_PER_DELAY: f64 = 24.0;

/// Most points measured on one pulse of an arc.
const MAX_POINTS_PER_PULSE: f64 = 192.0;

/// The search for the nearest moment ends when a step gains no more than this part of the square of the
/// distance.
const MIN_SEARCH_GAIN: f64 = 1e-9;
/// Most steps of that search.
const MAX_SEARCH_STEPS: usize = 30;

/// Returns the contour errors of a profile at all corners and arcs.
///
/// # Examples
///
/// ```
/// use truefeed::machine::Machine;
/// use truefeed::simulation::{contour::contour_errors, gcode::read, profile::Profile, simulate, interpreter::trace};
///
/// let machine = Machine::default();
/// let toolpath = trace(&read(b"G21 G90 G1 X40 F3000\nY40"), &machine);
/// let plan = simulate(&toolpath, &machine);
/// let errors = contour_errors(&toolpath, &plan, &Profile::new(&toolpath, &plan));
/// assert_eq!(errors.corner.len(), 2, "one per segment");
/// assert!((errors.corner[0] / machine.interpolator.contour_tolerance - 1.0).abs() < 1e-6, "the corner uses the whole tolerance");
/// assert_eq!(errors.corner[1], 0.0, "at the end the machine stops");
/// ```
pub fn contour_errors(toolpath: &Toolpath, plan: &FeedPlan, profile: &Profile) -> ContourErrors {
    let mut errors = ContourErrors::none(toolpath.segments.len());
    measure(toolpath, plan, profile, |_| true, |number, segment| errors.add(number, &segment));
    errors
}

/// The errors measured on one segment, mm.
#[derive(Clone, Copy, Debug, Default)]
struct SegmentErrors {
    /// At the corner that ends the segment.
    end: f64,
    /// Along an arc, within half a filter delay of the corner that begins it.
    near_start: f64,
    /// Along an arc, within half a filter delay of the corner that ends it.
    near_end: f64,
    /// Along the rest of an arc.
    between: f64,
}

impl ContourErrors {
    /// Returns errors of 0 for `segments` segments.
    fn none(segments: usize) -> ContourErrors {
        ContourErrors { corner: vec![0.0; segments], ..ContourErrors::default() }
    }

    /// Returns the errors by corner, each from the errors measured on both sides of the corner.
    fn by_corner(measured: &[SegmentErrors]) -> ContourErrors {
        let mut errors = ContourErrors::none(measured.len());
        measured.iter().enumerate().for_each(|(number, segment)| errors.add(number, segment));
        errors
    }

    /// Appends the errors of a segment.
    fn add(&mut self, number: usize, segment: &SegmentErrors) {
        if let Some(before) = number.checked_sub(1) {
            self.raise(before, segment.near_start);
        }
        self.corner[number] = segment.end.max(0.0);
        self.raise(number, segment.near_end);
        if 0.0 < segment.between {
            self.arc.add(number, segment.between);
        }
    }

    /// Counts an error (mm) near the corner that ends a segment as an error of that corner.
    fn raise(&mut self, number: usize, near: f64) {
        let at_corner = self.corner[number];
        if at_corner < near {
            self.point.add(number, at_corner);
            self.corner[number] = near;
        }
    }
}

/// Measures the segments for which `wanted` returns `true`, and passes each result to `found`.
fn measure(
    toolpath: &Toolpath,
    plan: &FeedPlan,
    profile: &Profile,
    wanted: impl Fn(usize) -> bool,
    mut found: impl FnMut(usize, SegmentErrors),
) {
    for rest_to_rest in plan.rest_to_rest_motions() {
        let mut steps = RememberedSteps::of(profile.motion(rest_to_rest));
        for own in plan.pulses.by_segment(rest_to_rest.pulses.clone()) {
            let number = plan.pulses.segment(own.start);
            if wanted(number) {
                found(number, segment_errors(toolpath, rest_to_rest, &mut steps, &plan.pulses, own));
            }
        }
    }
}

/// Measures one segment, whose pulses have the indices `own`.
fn segment_errors(
    toolpath: &Toolpath,
    rest_to_rest: &RestToRest,
    steps: &mut RememberedSteps,
    pulses: &Pulses,
    own: Range<usize>,
) -> SegmentErrors {
    let (first, last) = (own.start, own.end - 1);
    let number = pulses.segment(first);
    let segment = toolpath.segments.at(number);
    let delay = steps.cursor.motion.filter().delay();
    let (start, end) =
        (steps.cursor.pulse_start(first), steps.cursor.pulse_start(last) + pulses.duration(last));
    let (begins_at_corner, ends_at_corner) =
        (rest_to_rest.segments.start < number, number + 1 < rest_to_rest.segments.end);
    let mut errors = SegmentErrors::default();
    if ends_at_corner {
        errors.end = distance_from_path(steps, segment.end, end, last);
    }
    if segment.curve == Curve::Line {
        return errors;
    }
    let mut points = Vec::new();
    for (pulse, index) in pulses.range(own).zip(first..) {
        let count = (POINTS_PER_DELAY * pulse.duration / delay).ceil().clamp(3.0, MAX_POINTS_PER_PULSE);
        // If the command is even for a whole delay, all points have the same error: the first and the last
        // are enough.
        let is_even = pulse.feedrate[0] == pulse.feedrate[1];
        let settled = |i: f64| {
            let elapsed = (i + 0.5) / count * pulse.duration;
            is_even && 0.5 * delay <= elapsed && elapsed + 0.5 * delay <= pulse.duration
        };
        for i in (0..count as usize).map(|i| i as f64) {
            if settled(i - 1.0) && settled(i) && settled(i + 1.0) {
                continue;
            }
            let elapsed = (i + 0.5) / count * pulse.duration;
            let commanded = steps.cursor.pulse_start(index) + elapsed;
            let offset = pulse.offset_after(elapsed);
            let point = segment.point(offset);
            let moment = steps.cursor.moment_from(index, commanded + 0.5 * delay);
            let state = steps.state(moment);
            let away = state.position - point;
            let along = away.dot(&state.velocity) / state.velocity.norm();
            let likely = away.norm_squared() - along * along;
            points.push(ArcPoint { commanded, offset, point, state, at_most: away.norm(), likely });
        }
    }
    // Only the largest errors count, so the likeliest points come first, and few of the others are searched.
    points.sort_unstable_by(|a, b| b.likely.total_cmp(&a.likely));
    for ArcPoint { commanded, offset, point, state, at_most, .. } in points {
        let (since_start, to_end) = (commanded - start, end - commanded);
        let place =
            if begins_at_corner && since_start < 0.5 * delay && (since_start <= to_end || !ends_at_corner) {
                &mut errors.near_start
            } else if ends_at_corner && to_end < 0.5 * delay {
                &mut errors.near_end
            } else {
                &mut errors.between
            };
        if at_most <= *place {
            continue;
        }
        *place = place.max(nearest(steps, point, commanded, first, state, *place));
        if *place < at_most {
            let away = distance_from_programmed(toolpath, rest_to_rest, number, offset, state.position);
            *place = place.max(away);
        }
    }
    errors
}

/// A programmed point on an arc.
struct ArcPoint {
    /// Time at which it was commanded, s since the beginning of the motion.
    commanded: f64,
    /// Distance along the arc, mm.
    offset: f64,
    point: Point,
    /// The filtered motion half a delay later.
    state: MotionState,
    /// Distance between the point and that state, mm: an upper bound of the error.
    at_most: f64,
    /// Square of the error if the filtered path were straight there, mm².
    likely: f64,
}

/// Returns the distance (mm) of the filtered path from a point that was commanded at `commanded` (s since the
/// beginning of the motion), no earlier than the pulse `pulse`.
fn distance_from_path(steps: &mut RememberedSteps, point: Point, commanded: f64, pulse: usize) -> f64 {
    let moment = steps.cursor.moment_from(pulse, commanded + 0.5 * steps.cursor.motion.filter().delay());
    let state = steps.state(moment);
    nearest(steps, point, commanded, pulse, state, 0.0)
}

/// Returns the distance (mm) of the filtered path from a point, given the state half a filter delay later; if
/// it is at most `enough`, any value up to that.
fn nearest(
    steps: &mut RememberedSteps,
    point: Point,
    commanded: f64,
    pulse: usize,
    mut state: MotionState,
    enough: f64,
) -> f64 {
    let delay = steps.cursor.motion.filter().delay();
    let mut time = commanded + 0.5 * delay;
    let mut nearest = f64::INFINITY;
    // Moments before and after the nearest one, with (P − X)·Ṗ once that is known.
    let (mut before, mut after) = ((commanded, f64::NAN), (commanded + delay, f64::NAN));
    let mut was_before = None;
    let mut last: Option<(f64, f64)> = None;
    for step in 1..=MAX_SEARCH_STEPS {
        let away = state.position - point;
        nearest = nearest.min(away.norm());
        if nearest <= enough || step == MAX_SEARCH_STEPS {
            break;
        }
        let receding = away.dot(&state.velocity);
        // The weight of an end that stays is halved, so that it does not stay forever.
        let is_before = receding < 0.0;
        let stays = was_before.replace(is_before) == Some(is_before);
        if is_before {
            before = (time, receding);
            after.1 *= if stays { 0.5 } else { 1.0 };
        } else {
            after = (time, receding);
            before.1 *= if stays { 0.5 } else { 1.0 };
        }
        let between = before.0 + (after.0 - before.0) * before.1 / (before.1 - after.1);
        // The slope of (P − X)·Ṗ: from the last step, or as if the path were straight.
        let grown = last.replace((time, receding)).map(|(then, was)| (receding - was) / (time - then));
        let slope = grown.filter(|slope| 0.0 < *slope).unwrap_or(state.velocity.norm_squared());
        let straight = time - receding / slope;
        let next = if between.is_nan() { straight } else { between }.clamp(before.0, after.0);
        // A step reduces the square of the distance by its length times its slope.
        let gain = (receding * (next - time)).abs();
        if gain.is_nan() || gain <= MIN_SEARCH_GAIN * nearest * nearest {
            break;
        }
        time = next;
        let moment = steps.cursor.moment_from(pulse, time);
        state = steps.state(moment);
    }
    nearest
}

/// Returns the distance (mm) of a filtered point from the programmed path near the distance `offset` (mm) on
/// the segment `number`: from that segment and its neighbours in the motion.
fn distance_from_programmed(
    toolpath: &Toolpath,
    rest_to_rest: &RestToRest,
    number: usize,
    offset: f64,
    point: Point,
) -> f64 {
    let Range { start, end } = rest_to_rest.segments;
    let neighbours = start.max(number.saturating_sub(1))..end.min(number + 2);
    let distances = neighbours.map(|near| {
        let segment = toolpath.segments.at(near);
        let near_there = match near.cmp(&number) {
            Ordering::Less => segment.length,
            Ordering::Equal => offset,
            Ordering::Greater => 0.0,
        };
        distance_from_segment(&segment, near_there, point)
    });
    distances.fold(f64::INFINITY, f64::min)
}

/// Returns the distance (mm) of a point from a segment near the distance `s` (mm) along it.
fn distance_from_segment(segment: &Segment, mut s: f64, point: Point) -> f64 {
    let mut away = segment.point(s) - point;
    // Newton's method for the foot of the perpendicular; on a line one step is exact. Where an arc bends more than
    // it is long, a step may lead away.
    for _ in 0..4 {
        let [tangent, curvature, _] = segment.derivatives(s);
        let change = tangent.norm_squared() + away.dot(&curvature);
        let next = (s - away.dot(&tangent) / change).clamp(0.0, segment.length);
        let next_away = segment.point(next) - point;
        let is_nearer = 0.0 < change && next_away.norm_squared() < away.norm_squared();
        if !is_nearer {
            break;
        }
        (s, away) = (next, next_away);
    }
    away.norm()
}
