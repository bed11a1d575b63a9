//! Strokes in the plane of compensation, their parallels and where those meet.
//!
//! ```text
//! line     P(s) = P0 + s t
//! circle   |P − C| = R, run through counter-clockwise (κ = +1) or clockwise (κ = −1)
//! ```
//!
//! The parallel at the distance d to the left of the motion is the line through P0 + d n, with n
//! the left normal of t, or the circle of radius R − κ d around the same centre. Two parallels
//! meet in at most two points; those lie mirrored about the line through a centre (to the other
//! centre, or square to the line), and the one that belongs to a corner lies on the corner's side
//! of it, whatever d is: it is the nearer one.
//!
//! Lengths in mm, angles in rad. Sources: elementary.

use std::f64::consts::{PI, TAU};

/// A position in the plane, mm.
pub(super) type Point2 = nalgebra::Point2<f64>;
/// A displacement in the plane, mm, or a direction.
pub(super) type Way = nalgebra::Vector2<f64>;

/// Lengths below this are rounding, mm.
pub(super) const ROUNDING_MM: f64 = 1e-9;

/// Angles by which a trimmed arc may be longer than before, rad: it begins or ends a little
/// beside its circle where a turn is too slight to be a corner.
const TRIM_SLACK_RAD: f64 = 0.5 * PI;

/// What a stroke lies on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Shape {
    /// An endless line.
    Line {
        /// A point of it, mm.
        through: Point2,
        /// Unit vector of the motion.
        along: Way,
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

/// One move as seen in the plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PlanarCurve {
    pub(super) start: Point2,
    pub(super) end: Point2,
    pub(super) shape: Shape,
    /// Angle of an arc, rad; 0 for a line.
    pub(super) sweep: f64,
}

pub(super) fn left_of(way: Way) -> Way {
    Way::new(-way.y, way.x)
}

pub(super) fn cross(a: Way, b: Way) -> f64 {
    a.x * b.y - a.y * b.x
}

/// Angle from one direction to another, counter-clockwise, −π to π.
pub(super) fn angle(from: Way, to: Way) -> f64 {
    cross(from, to).atan2(from.dot(&to))
}

impl Shape {
    /// Direction of the motion at a point of the shape.
    pub(super) fn direction(&self, at: Point2) -> Way {
        match *self {
            Shape::Line { along, .. } => along,
            Shape::Circle { center, turn, .. } => {
                left_of(at - center).try_normalize(0.0).unwrap_or(Way::x()) * turn
            }
        }
    }

    /// Its point nearest to `spot`, or `None` from the centre of a circle.
    pub(super) fn foot(&self, spot: Point2) -> Option<Point2> {
        match *self {
            Shape::Line { through, along } => Some(through + along * (spot - through).dot(&along)),
            Shape::Circle { center, radius, .. } => {
                Some(center + (spot - center).try_normalize(ROUNDING_MM)? * radius)
            }
        }
    }

    /// Where it meets another, mm.
    fn meetings(&self, other: &Shape) -> [Option<Point2>; 2] {
        match (*self, *other) {
            (Shape::Line { through: p, along: t }, Shape::Line { through: q, along: u }) => {
                let sine = cross(t, u);
                let meeting = (1e-9 < sine.abs()).then(|| p + t * (cross(q - p, u) / sine));
                [meeting, None]
            }
            (Shape::Line { through, along }, Shape::Circle { center, radius, .. })
            | (Shape::Circle { center, radius, .. }, Shape::Line { through, along }) => {
                let foot = through + along * (center - through).dot(&along);
                mirrored(foot, along, (radius - (center - foot).norm()) * (radius + (center - foot).norm()))
            }
            (
                Shape::Circle { center, radius, .. },
                Shape::Circle { center: other_center, radius: other_radius, .. },
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

    /// Where it meets another at a corner: the nearer point.
    pub(super) fn meeting(&self, other: &Shape, corner: Point2) -> Option<Point2> {
        match self.meetings(other) {
            [Some(one), Some(two)] if (two - corner).norm() < (one - corner).norm() => Some(two),
            [one, two] => one.or(two),
        }
    }

    /// Where it meets another at a corner that turns back, so that both points are about as near:
    /// the one further in the direction `ahead`.
    pub(super) fn meeting_ahead(&self, other: &Shape, ahead: Way) -> Option<Point2> {
        match self.meetings(other) {
            [Some(one), Some(two)] if 0.0 < (two - one).dot(&ahead) => Some(two),
            [one, two] => one.or(two),
        }
    }
}

/// The points at √`height_squared` on both sides of `foot`; one where rounding hides that they
/// touch.
fn mirrored(foot: Point2, along: Way, height_squared: f64) -> [Option<Point2>; 2] {
    let reach = 1e-9 * (1.0 + foot.coords.norm());
    if height_squared < -reach {
        return [None, None];
    }
    let height = height_squared.max(0.0).sqrt();
    [Some(foot + along * height), Some(foot - along * height)]
}

impl PlanarCurve {
    /// A straight stroke, or `None` if it has no length.
    pub(super) fn line(start: Point2, end: Point2) -> Option<PlanarCurve> {
        let along = (end - start).try_normalize(ROUNDING_MM)?;
        Some(PlanarCurve { start, end, shape: Shape::Line { through: start, along }, sweep: 0.0 })
    }

    pub(super) fn is_line(&self) -> bool {
        matches!(self.shape, Shape::Line { .. })
    }

    /// Direction of the motion at its start.
    pub(super) fn way_in(&self) -> Way {
        self.shape.direction(self.start)
    }

    /// Direction of the motion at its end.
    pub(super) fn way_out(&self) -> Way {
        self.shape.direction(self.end)
    }

    /// Returns the stroke offset by `distance` mm to the left; `None` if the radius of an arc would vanish.
    pub(super) fn parallel(&self, distance: f64) -> Option<PlanarCurve> {
        let beside = |at: Point2| at + left_of(self.shape.direction(at)) * distance;
        let (start, end) = (beside(self.start), beside(self.end));
        let shape = match self.shape {
            Shape::Line { through, along } => Shape::Line { through: beside(through), along },
            Shape::Circle { center, radius, turn } => {
                let radius = radius - turn * distance;
                let least = (start - center).norm().min((end - center).norm());
                if radius.min(least) < 1e3 * ROUNDING_MM {
                    return None;
                }
                Shape::Circle { center, radius, turn }
            }
        };
        Some(PlanarCurve { start, end, shape, ..*self })
    }

    /// How much of it is left between two points of its shape, of which the first lies ahead of
    /// its start and the second behind its end: mm for a line, rad for an arc. Negative where
    /// they lie the wrong way round.
    pub(super) fn left_between(&self, start: Point2, end: Point2) -> f64 {
        match self.shape {
            Shape::Line { along, .. } => (end - start).dot(&along),
            Shape::Circle { center, turn, .. } => {
                let run = |from: Point2, to: Point2| turn * angle(from - center, to - center);
                let (ahead, behind) = (run(self.start, start), run(end, self.end));
                let wrapped = |angle: f64| if angle < -TRIM_SLACK_RAD { angle + TAU } else { angle };
                self.sweep - wrapped(ahead) - wrapped(behind)
            }
        }
    }
}
