//! Conversion between segments in space and curves in the plane of compensation.
//!
//! The plane (a, b) has the normal c. A planar curve has no c; a segment drawn along a curve runs evenly from its
//! start height c to its end height.

use crate::simulation::toolpath::compensation::geometry::{
    PlanarCurve, PlanarShape, Point2, ROUNDING_MM, angle, cross, left_of,
};
use crate::simulation::toolpath::plane::Plane;
use crate::simulation::toolpath::{Arc, Curve, Point, Segment, Vector};
use std::f64::consts::TAU;

/// Smaller radii are no circle, mm.
const MIN_RADIUS_MM: f64 = 1e-6;

/// Returns the projection of a point into the plane, mm.
pub(super) fn planar_point(plane: Plane, point: Point) -> Point2 {
    let [a, b, _] = plane.axes();
    Point2::new(point[a], point[b])
}

/// Returns the height of a point above the plane, mm.
pub(super) fn height(plane: Plane, point: Point) -> f64 {
    point[plane.axes()[2]]
}

/// Returns the point at `height` (mm) above a point of the plane, mm.
pub(super) fn space_point(plane: Plane, planar_point: Point2, height: f64) -> Point {
    Point::from(plane.vector([planar_point.x, planar_point.y, height]))
}

/// Returns the segment projected into the plane, or `None` if it is at a right angle to it.
pub(super) fn planar_curve(plane: Plane, segment: &Segment) -> Option<PlanarCurve> {
    let (start, end) = (planar_point(plane, segment.start), planar_point(plane, segment.end));
    match &segment.curve {
        Curve::Line => PlanarCurve::line(start, end),
        Curve::Arc(arc) => {
            let center = planar_point(plane, arc.center);
            let in_plane = |vector: Vector| planar_point(plane, Point::from(vector)).coords;
            let turn = cross(in_plane(arc.e1), in_plane(arc.e2)).signum();
            let shape = PlanarShape::Circle { center, radius: arc.end_radius, turn };
            Some(PlanarCurve { start, end, shape, sweep: arc.sweep })
        }
    }
}

/// Returns the segment from `start` along `shape` to `end_height` above `end`, with the feedrate and line of
/// `like`. An arc sweeps about `sweep`, rad; it becomes a line if the ends are not on a common circle. Returns
/// `None` if the segment has no length.
pub(super) fn draw(
    plane: Plane,
    like: &Segment,
    start: Point,
    (shape, sweep): (&PlanarShape, f64),
    (end, end_height): (Point2, f64),
) -> Option<Segment> {
    let end = space_point(plane, end, end_height);
    if let PlanarShape::Circle { center, turn, .. } = *shape
        && let Some(arc) = arc(plane, (start, end), (center, turn), sweep)
    {
        let length = arc.length();
        return Some(Segment { start, end, curve: Curve::Arc(arc.into()), length, ..like.clone() });
    }
    let length = (end - start).norm();
    (ROUNDING_MM <= length).then(|| Segment { start, end, curve: Curve::Line, length, ..like.clone() })
}

/// Returns the arc between two points about a centre with the sweep nearest to `sweep`, rad, or `None` if it is
/// too small for a circle.
fn arc(plane: Plane, (start, end): (Point, Point), (center, turn): (Point2, f64), sweep: f64) -> Option<Arc> {
    let (from, to) = (planar_point(plane, start) - center, planar_point(plane, end) - center);
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
        center: space_point(plane, center, height(plane, start)),
        e1: plane.vector([e1.x, e1.y, 0.0]),
        e2: plane.vector([e2.x, e2.y, 0.0]),
        start_radius,
        end_radius,
        sweep,
        rise: plane.vector([0.0, 0.0, rise]),
    })
}
