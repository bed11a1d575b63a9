//! Between segments in space and strokes in the plane of compensation.
//!
//! The plane (a, b) has the normal c; a stroke forgets c, and a segment drawn along a stroke runs
//! evenly from the height c it begins at to the one it is given.

use crate::simulation::toolpath::compensation::geometry::{
    PlanarCurve, Point2, ROUNDING_MM, Shape, angle, cross, left_of,
};
use crate::simulation::toolpath::plane::Plane;
use crate::simulation::toolpath::{Arc, Curve, Point, Segment, Vector};
use std::f64::consts::TAU;

/// Radii below this are no circle, mm.
const MIN_RADIUS_MM: f64 = 1e-6;

/// Where a point lies in the plane, mm.
pub(super) fn spot(plane: Plane, point: Point) -> Point2 {
    let [a, b, _] = plane.axes();
    Point2::new(point[a], point[b])
}

/// How high a point lies over the plane, mm.
pub(super) fn height(plane: Plane, point: Point) -> f64 {
    point[plane.axes()[2]]
}

/// The point above `spot`, mm.
pub(super) fn point(plane: Plane, spot: Point2, height: f64) -> Point {
    Point::from(plane.vector([spot.x, spot.y, height]))
}

/// The segment as seen in the plane, or `None` if it is square to it.
pub(super) fn stroke(plane: Plane, segment: &Segment) -> Option<PlanarCurve> {
    let (start, end) = (spot(plane, segment.start), spot(plane, segment.end));
    match &segment.curve {
        Curve::Line => PlanarCurve::line(start, end),
        Curve::Arc(arc) => {
            let center = spot(plane, arc.center);
            let in_plane = |vector: Vector| spot(plane, Point::from(vector)).coords;
            let turn = cross(in_plane(arc.e1), in_plane(arc.e2)).signum();
            let shape = Shape::Circle { center, radius: arc.end_radius, turn };
            Some(PlanarCurve { start, end, shape, sweep: arc.sweep })
        }
    }
}

/// The segment from `start` along `shape` to above `end`, with feedrate and line of `like`; an
/// arc sweeps about `sweep`, rad. None where it has no length; straight where the ends are on no
/// common circle.
pub(super) fn draw(
    plane: Plane,
    like: &Segment,
    start: Point,
    (shape, sweep): (&Shape, f64),
    (end, end_height): (Point2, f64),
) -> Option<Segment> {
    let end = point(plane, end, end_height);
    if let Shape::Circle { center, turn, .. } = *shape
        && let Some(arc) = arc(plane, (start, end), (center, turn), sweep)
    {
        let length = arc.length();
        return Some(Segment { start, end, curve: Curve::Arc(arc.into()), length, ..like.clone() });
    }
    let length = (end - start).norm();
    (ROUNDING_MM <= length).then(|| Segment { start, end, curve: Curve::Line, length, ..like.clone() })
}

fn arc(plane: Plane, (start, end): (Point, Point), (center, turn): (Point2, f64), sweep: f64) -> Option<Arc> {
    let (from, to) = (spot(plane, start) - center, spot(plane, end) - center);
    let (start_radius, end_radius) = (from.norm(), to.norm());
    let apart = turn * angle(from, to) - sweep;
    let sweep = sweep + apart - TAU * (apart / TAU).round();
    if start_radius.min(end_radius) < MIN_RADIUS_MM || sweep * start_radius < 1e3 * ROUNDING_MM {
        return None;
    }
    let e1 = from / start_radius;
    let e2 = left_of(e1) * turn;
    let rise = height(plane, end) - height(plane, start);
    Some(Arc {
        center: point(plane, center, height(plane, start)),
        e1: plane.vector([e1.x, e1.y, 0.0]),
        e2: plane.vector([e2.x, e2.y, 0.0]),
        start_radius,
        end_radius,
        sweep,
        rise: plane.vector([0.0, 0.0, rise]),
    })
}
