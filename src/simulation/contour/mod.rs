//! Profile → contour error: the distance between the programmed path and the filtered one.
//!
//! The error at a programmed point X is its distance from the filtered path nearby,
//!
//! ```text
//! e(X) = min over t of ‖P(t) − X‖
//! ```
//!
//! The error is measured where it can be largest: at every corner, and along arcs at points no more than a 24th
//! of the filter delay apart, there also from the filtered path to the programmed one. Between corners a line
//! is nearer to the filtered path than at its ends. At an isolated corner e is the tolerance for which the
//! corner law was computed; if several corners lie within one filter delay, e may be larger or smaller.

mod sparse;
mod guaranteed;
mod regions;
mod off_path;
mod arcs;
mod nearest;

pub(crate) use guaranteed::guaranteed;
pub use regions::{ErrorRegion, regions_beyond};
pub use sparse::SparseColumn;

use std::ops::Range;

use crate::simulation::contour::arcs::MeasuredArc;
use crate::simulation::contour::nearest::distance_from_path;
use crate::simulation::feed::{FeedPlan, Pulses, RestToRest, ToleranceBound};
use crate::simulation::profile::{Profile, RememberedSteps};
use crate::simulation::toolpath::{Curve, Toolpath};

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
    let Curve::Arc(arc) = &segment.curve else { return errors };
    let arc = MeasuredArc { toolpath, rest_to_rest, number, segment: &segment, arc, pulses, own };
    // Moments at which the whole window lies within the arc.
    let inner = start + 0.5 * delay..end - 0.5 * delay;
    for point in arc.points(steps, arc.own.clone(), |commanded| !inner.contains(&commanded)) {
        let (since_start, to_end) = (point.commanded - start, end - point.commanded);
        let place =
            if begins_at_corner && since_start < 0.5 * delay && (since_start <= to_end || !ends_at_corner) {
                &mut errors.near_start
            } else if ends_at_corner && to_end < 0.5 * delay {
                &mut errors.near_end
            } else {
                &mut errors.between
            };
        *place = arc.error(steps, point, *place);
    }
    errors.between = arc.error_within(steps, &inner, errors.between);
    errors
}
