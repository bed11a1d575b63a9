//! The arcs that one may have been meant to be whose ends are not equally far from its centre.

use crate::simulation::toolpath::{Arc, Curve, Point, Segment, Vector};
use std::f64::consts::{FRAC_PI_2, TAU};

/// Two coordinates in the plane of an arc, mm.
type Pair = [f64; 2];

/// An arc in its plane: along its first radius and along its heading.
#[derive(Clone, Copy)]
struct Circle {
    start: Pair,
    end: Pair,
    center: Pair,
}

/// The lengths, mm, of the arcs that one coordinate of `segment` makes close where the others hold, with what that adds to
/// the moves before and after it; where none closes, of a full turn.
pub(super) fn lengths_that_close<'a>(
    segment: &'a Segment,
    arc: &'a Arc,
    before: Option<&'a Segment>,
    next: Option<&'a Segment>,
) -> impl Iterator<Item = f64> {
    // The axes that the words are along, as far as the plane of the arc is theirs.
    let normal = arc.e1.cross(&arc.e2);
    let axes = axes_across(&normal);
    let flat = |point: Point| axes.map(|axis: Vector| point.coords.dot(&axis));
    let circle = Circle { start: flat(segment.start), end: flat(segment.end), center: flat(arc.center) };
    let turns = 0.0_f64.max(((arc.sweep - 1e-9) / TAU).floor());
    let rise = arc.rise.norm();
    let sense = normal.dot(&axes[0].cross(&axes[1])).signum();
    let moved = |from: Pair, to: Pair, other: Option<Pair>| {
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

/// The length of half a circle between the ends of a straight segment, mm.
pub(super) fn half_circle(segment: &Segment) -> f64 {
    FRAC_PI_2 * segment.length
}

/// The two axes of the coordinate system that lie most across `normal`.
fn axes_across(normal: &Vector) -> [Vector; 2] {
    match normal.iamax() {
        0 => [Vector::y(), Vector::z()],
        1 => [Vector::z(), Vector::x()],
        _ => [Vector::x(), Vector::y()],
    }
}

/// The arcs that close with one coordinate of centre, end or start put elsewhere.
fn candidates(given: Circle) -> Vec<Circle> {
    let Circle { start, end, center } = given;
    let mut found = Vec::new();
    for axis in [0, 1] {
        let other = 1 - axis;
        // The centre is as far from both ends.
        let chord = end[axis] - start[axis];
        if 1e-9 < chord.abs() {
            let across = (end[other] - center[other]).powi(2) - (start[other] - center[other]).powi(2);
            let mut center = center;
            center[axis] = 0.5 * (start[axis] + end[axis]) + 0.5 * across / chord;
            found.push(Circle { center, ..given });
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
            // Or the start is elsewhere, and with it the centre, which is given from it.
            let shift = end[axis] + aside - center[axis];
            let mut shifted = given;
            shifted.start[axis] += shift;
            shifted.center[axis] += shift;
            found.push(shifted);
        }
    }
    found
}

/// The angle from start to end about the centre, rad: positive, and a full turn where they meet.
fn sweep(circle: Circle, sense: f64) -> f64 {
    let Circle { start, end, center } = circle;
    let from = [start[0] - center[0], start[1] - center[1]];
    let to = [end[0] - center[0], end[1] - center[1]];
    let angle = (sense * (from[0] * to[1] - from[1] * to[0])).atan2(from[0] * to[0] + from[1] * to[1]);
    if 1e-9 < angle { angle } else { angle + TAU }
}

fn distance(a: Pair, b: Pair) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}
