//! Curves in the plane of compensation, their parallels and the points where those meet.
//!
//! ```text
//! line     P(s) = P0 + s t
//! circle   |P − C| = R, passed counter-clockwise (κ = +1) or clockwise (κ = −1)
//! ```
//!
//! The parallel at the distance d to the left of the motion is the line through P0 + d n, with n the left normal
//! of t, or the circle of radius R − κ d around the same centre. Two parallels meet in at most two points. These
//! are mirror images in a line through a centre: the line to the other centre, or the normal to the straight
//! parallel. The point that belongs to a corner is on the corner's side of that line for every d, so it is the
//! nearer one.
//!
//! Lengths in mm, angles in rad. Sources: elementary.

use std::f64::consts::{PI, TAU};

/// A position in the plane, mm.
pub(super) type Point2 = nalgebra::Point2<f64>;
/// A displacement in the plane, mm, or a direction.
pub(super) type Vector2 = nalgebra::Vector2<f64>;

/// Smaller lengths are rounding errors, mm.
pub(super) const ROUNDING_MM: f64 = 1e-9;

/// Angle by which a trimmed arc may be longer than before, rad: it begins or ends slightly beside its circle if
/// the turn is too small for a corner.
const TRIM_SLACK_RAD: f64 = 0.5 * PI;

/// The endless line or whole circle that a curve is a part of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum PlanarShape {
    /// An endless line.
    Line {
        /// A point of it, mm.
        through: Point2,
        /// Unit vector of the motion.
        along: Vector2,
    },
    /// A whole circle.
    Circle {
        /// Its centre, mm.
        center: Point2,
        /// Its radius, mm.
        radius: f64,
        /// 1 counter-clockwise, −1 clockwise.
        turn: f64,
    },
}

/// One move, projected into the plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PlanarCurve {
    pub(super) start: Point2,
    pub(super) end: Point2,
    pub(super) shape: PlanarShape,
    /// Angle passed on an arc, rad; 0 for a line.
    pub(super) sweep: f64,
}

pub(super) fn left_of(way: Vector2) -> Vector2 {
    Vector2::new(-way.y, way.x)
}

pub(super) fn cross(a: Vector2, b: Vector2) -> f64 {
    a.x * b.y - a.y * b.x
}

/// Returns the angle from one direction to another, rad, counter-clockwise, from −π to π.
pub(super) fn angle(from: Vector2, to: Vector2) -> f64 {
    cross(from, to).atan2(from.dot(&to))
}

impl PlanarShape {
    /// Returns the unit vector of the motion at a point of the shape.
    pub(super) fn direction(&self, at: Point2) -> Vector2 {
        match *self {
            PlanarShape::Line { along, .. } => along,
            PlanarShape::Circle { center, turn, .. } => {
                left_of(at - center).try_normalize(0.0).unwrap_or(Vector2::x()) * turn
            }
        }
    }

    /// Returns the point of the shape nearest to `point`, or `None` for the centre of a circle.
    pub(super) fn foot(&self, point: Point2) -> Option<Point2> {
        match *self {
            PlanarShape::Line { through, along } => Some(through + along * (point - through).dot(&along)),
            PlanarShape::Circle { center, radius, .. } => {
                Some(center + (point - center).try_normalize(ROUNDING_MM)? * radius)
            }
        }
    }

    /// Returns the points where two shapes meet, mm.
    fn meetings(&self, other: &PlanarShape) -> [Option<Point2>; 2] {
        match (*self, *other) {
            (PlanarShape::Line { through: p, along: t }, PlanarShape::Line { through: q, along: u }) => {
                let sine = cross(t, u);
                let meeting = (1e-9 < sine.abs()).then(|| p + t * (cross(q - p, u) / sine));
                [meeting, None]
            }
            (PlanarShape::Line { through, along }, PlanarShape::Circle { center, radius, .. })
            | (PlanarShape::Circle { center, radius, .. }, PlanarShape::Line { through, along }) => {
                let foot = through + along * (center - through).dot(&along);
                mirrored(foot, along, (radius - (center - foot).norm()) * (radius + (center - foot).norm()))
            }
            (
                PlanarShape::Circle { center, radius, .. },
                PlanarShape::Circle { center: other_center, radius: other_radius, .. },
            ) => {
                let between = other_center - center;
                let distance = between.norm();
                if distance < ROUNDING_MM {
                    return [None, None];
                }
                let along = between / distance;
                let to_foot = 0.5 * (distance + (radius - other_radius) * (radius + other_radius) / distance);
                let height_squared = (radius - to_foot) * (radius + to_foot);
                mirrored(center + along * to_foot, left_of(along), height_squared)
            }
        }
    }

    /// Returns the point where two shapes meet at a corner: the nearer one.
    pub(super) fn meeting(&self, other: &PlanarShape, corner: Point2) -> Option<Point2> {
        match self.meetings(other) {
            [Some(one), Some(two)] if (two - corner).norm() < (one - corner).norm() => Some(two),
            [one, two] => one.or(two),
        }
    }

    /// Returns the point where two shapes meet at a corner that turns back. Both points are about as near; the one
    /// further in the direction `ahead` is chosen.
    pub(super) fn meeting_ahead(&self, other: &PlanarShape, ahead: Vector2) -> Option<Point2> {
        match self.meetings(other) {
            [Some(one), Some(two)] if 0.0 < (two - one).dot(&ahead) => Some(two),
            [one, two] => one.or(two),
        }
    }
}

/// Returns the points at the distance √`height_squared` (mm) on both sides of `foot`. A slightly negative square
/// is rounding: the shapes touch.
fn mirrored(foot: Point2, along: Vector2, height_squared: f64) -> [Option<Point2>; 2] {
    let rounding = 1e-9 * (1.0 + foot.coords.norm());
    if height_squared < -rounding {
        return [None, None];
    }
    let height = height_squared.max(0.0).sqrt();
    [Some(foot + along * height), Some(foot - along * height)]
}

impl PlanarCurve {
    /// Returns a straight curve, or `None` if it has no length.
    pub(super) fn line(start: Point2, end: Point2) -> Option<PlanarCurve> {
        let along = (end - start).try_normalize(ROUNDING_MM)?;
        Some(PlanarCurve { start, end, shape: PlanarShape::Line { through: start, along }, sweep: 0.0 })
    }

    pub(super) fn is_line(&self) -> bool {
        matches!(self.shape, PlanarShape::Line { .. })
    }

    /// Returns the unit vector of the motion at the start.
    pub(super) fn start_direction(&self) -> Vector2 {
        self.shape.direction(self.start)
    }

    /// Returns the unit vector of the motion at the end.
    pub(super) fn end_direction(&self) -> Vector2 {
        self.shape.direction(self.end)
    }

    /// Returns the curve offset by `distance` mm to the left; `None` if the radius of an arc would vanish.
    pub(super) fn parallel(&self, distance: f64) -> Option<PlanarCurve> {
        let beside = |at: Point2| at + left_of(self.shape.direction(at)) * distance;
        let (start, end) = (beside(self.start), beside(self.end));
        let shape = match self.shape {
            PlanarShape::Line { through, along } => PlanarShape::Line { through: beside(through), along },
            PlanarShape::Circle { center, radius, turn } => {
                let radius = radius - turn * distance;
                let least = (start - center).norm().min((end - center).norm());
                if radius.min(least) < 1e3 * ROUNDING_MM {
                    return None;
                }
                PlanarShape::Circle { center, radius, turn }
            }
        };
        Some(PlanarCurve { start, end, shape, ..*self })
    }

    /// Returns the length that remains between two points of the shape, mm for a line, rad for an arc. The first
    /// point is ahead of the start of the curve, the second behind its end; the length is negative if they are in
    /// the wrong order.
    pub(super) fn remaining_between(&self, start: Point2, end: Point2) -> f64 {
        match self.shape {
            PlanarShape::Line { along, .. } => (end - start).dot(&along),
            PlanarShape::Circle { center, turn, .. } => {
                let run = |from: Point2, to: Point2| turn * angle(from - center, to - center);
                let (ahead, behind) = (run(self.start, start), run(end, self.end));
                let unwrapped = |angle: f64| if angle < -TRIM_SLACK_RAD { angle + TAU } else { angle };
                self.sweep - unwrapped(ahead) - unwrapped(behind)
            }
        }
    }
}
