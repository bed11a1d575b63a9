//! Arcs whose ends have different distances from the centre: the arcs that may have been meant.

use crate::simulation::toolpath::{Arc, Curve, Point, Segment, Vector};
use std::f64::consts::{FRAC_PI_2, TAU};

/// Two coordinates in the plane of an arc, mm.
type PlanePoint = [f64; 2];

/// An arc in its plane: along its first radius and along its heading.
#[derive(Clone, Copy)]
struct PlaneArc {
    start: PlanePoint,
    end: PlanePoint,
    center: PlanePoint,
}

/// Returns the lengths, mm, of the arcs that close if one coordinate of `segment` changes, including the
/// change of the moves before and after it; a full turn if none closes.
pub(super) fn lengths_that_close<'a>(
    segment: &'a Segment,
    arc: &'a Arc,
    before: Option<&'a Segment>,
    next: Option<&'a Segment>,
) -> impl Iterator<Item = f64> {
    // The coordinate axes of the words that lie best in the plane of the arc.
    let normal = arc.e1.cross(&arc.e2);
    let axes = axes_across(&normal);
    let flat = |point: Point| axes.map(|axis: Vector| point.coords.dot(&axis));
    let circle = PlaneArc { start: flat(segment.start), end: flat(segment.end), center: flat(arc.center) };
    let turns = 0.0_f64.max(((arc.sweep - 1e-9) / TAU).floor());
    let rise = arc.rise.norm();
    let sense = normal.dot(&axes[0].cross(&axes[1])).signum();
    let moved = |from: PlanePoint, to: PlanePoint, other: Option<PlanePoint>| {
        other.map_or(0.0, |other| distance(to, other) - distance(from, other))
    };
    let is_line = |segment: &&Segment| matches!(segment.curve, Curve::Line);
    let came_from = before.filter(is_line).map(|before| flat(before.start));
    let goes_to = next.filter(is_line).map(|next| flat(next.end));
    let candidates = candidates(circle);
    let none = candidates.is_empty();
    let lengths = candidates.into_iter().map(move |meant| {
        let radius = distance(meant.start, meant.center);
        let length = (radius * (sweep(meant, sense) + turns * TAU)).hypot(rise);
        length + moved(circle.start, meant.start, came_from) + moved(circle.end, meant.end, goes_to)
    });
    lengths.chain(none.then(|| arc.mean_radius() * TAU))
}

/// Returns the length of half a circle between the ends of a straight segment, mm.
pub(super) fn half_circle(segment: &Segment) -> f64 {
    FRAC_PI_2 * segment.length
}

/// Returns the two coordinate axes most perpendicular to `normal`.
fn axes_across(normal: &Vector) -> [Vector; 2] {
    match normal.iamax() {
        0 => [Vector::y(), Vector::z()],
        1 => [Vector::z(), Vector::x()],
        _ => [Vector::x(), Vector::y()],
    }
}

/// Returns the arcs that close with one coordinate of centre, end or start changed.
fn candidates(given: PlaneArc) -> Vec<PlaneArc> {
    let PlaneArc { start, end, center } = given;
    let mut found = Vec::new();
    for axis in [0, 1] {
        let other = 1 - axis;
        // The centre is equally far from both ends.
        let chord = end[axis] - start[axis];
        if 1e-9 < chord.abs() {
            let across = (end[other] - center[other]).powi(2) - (start[other] - center[other]).powi(2);
            let mut center = center;
            center[axis] = 0.5 * (start[axis] + end[axis]) + 0.5 * across / chord;
            found.push(PlaneArc { center, ..given });
        }
        // The end is as far from the centre as the start, on either side of it.
        let along = distance(start, center).powi(2) - (end[other] - center[other]).powi(2);
        if along < 0.0 {
            continue;
        }
        for aside in [-along.sqrt(), along.sqrt()] {
            let mut nearer = given;
            nearer.end[axis] = center[axis] + aside;
            found.push(nearer);
            // Or the start moves, and with it the centre, which is given relative to the start.
            let shift = end[axis] + aside - center[axis];
            let mut shifted = given;
            shifted.start[axis] += shift;
            shifted.center[axis] += shift;
            found.push(shifted);
        }
    }
    found
}

/// Returns the angle from start to end about the centre, rad: positive, and a full turn if they coincide.
fn sweep(circle: PlaneArc, sense: f64) -> f64 {
    let PlaneArc { start, end, center } = circle;
    let from = [start[0] - center[0], start[1] - center[1]];
    let to = [end[0] - center[0], end[1] - center[1]];
    let angle = (sense * (from[0] * to[1] - from[1] * to[0])).atan2(from[0] * to[0] + from[1] * to[1]);
    if 1e-9 < angle { angle } else { angle + TAU }
}

fn distance(a: PlanePoint, b: PlanePoint) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}
