//! The plane of arcs and its circles: from programmed words to [`Arc`].
//!
//! In the plane (a, b) with normal n, a right-handed frame, an arc runs from start S to end E around C,
//! counter-clockwise seen against n (G3) or clockwise (G2). Its sweep is the angle from S − C to E − C in the
//! sense of motion, in (0, 2π]; ends closer than the resolution of a control make a full circle. With a radius R
//! instead of C, the centre is on the perpendicular bisector of the chord d, at the distance √(R² − d²/4) from it:
//! for G3 on the left of the motion with R > 0 (sweep ≤ π), on the right with R < 0 (sweep ≥ π); for G2 mirrored.

use crate::simulation::toolpath::{Arc, Point, Vector};
use std::f64::consts::TAU;
use thiserror::Error;

/// Largest distance of the ends of a full circle, mm: below the resolution of any control, above the rounding of
/// sums of increments.
const MAX_CLOSURE_MM: f64 = 1e-6;

/// The plane that arcs lie in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Plane {
    /// G17.
    Xy,
    /// G18; its first axis is Z.
    Zx,
    /// G19.
    Yz,
}

/// The sense of rotation of an arc, seen against the normal of its plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Turn {
    /// G2.
    Clockwise,
    /// G3.
    Counterclockwise,
}

impl Turn {
    /// Returns the opposite sense.
    pub(crate) fn reversed(self) -> Turn {
        match self {
            Turn::Clockwise => Turn::Counterclockwise,
            Turn::Counterclockwise => Turn::Clockwise,
        }
    }
}

/// The reason why no circle passes through the programmed points.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub(crate) enum NoCircle {
    /// The centre is the start.
    #[error("the centre of the arc is its start")]
    NoRadius,
    /// R with start and end in one point.
    #[error("an arc by R needs an end that differs from its start")]
    NoChord,
    /// R is smaller than half the distance of the ends.
    #[error("radius {radius:.4} mm is too small for an arc between ends {chord:.4} mm apart")]
    ShortRadius {
        /// |R|, mm.
        radius: f64,
        /// Distance of start and end in the plane, mm.
        chord: f64,
    },
}

impl Plane {
    /// Returns the indices of first axis, second axis and normal.
    pub(crate) fn axes(self) -> [usize; 3] {
        match self {
            Plane::Xy => [0, 1, 2],
            Plane::Zx => [2, 0, 1],
            Plane::Yz => [1, 2, 0],
        }
    }

    /// Returns the vector with these components along first axis, second axis and normal.
    pub(crate) fn vector(self, components: [f64; 3]) -> Vector {
        let mut vector = Vector::zeros();
        for (index, component) in self.axes().into_iter().zip(components) {
            vector[index] = component;
        }
        vector
    }

    /// Returns the centre of the arc with the programmed radius `radius`, mm; a negative radius means the longer arc.
    ///
    /// # Errors
    ///
    /// If the ends coincide, or are further apart than twice the radius.
    pub(crate) fn center_of_radius(
        self,
        (start, end): (Point, Point),
        turn: Turn,
        radius: f64,
    ) -> Result<Point, NoCircle> {
        let [a, b, _] = self.axes();
        let (along, across) = (end[a] - start[a], end[b] - start[b]);
        let chord = along.hypot(across);
        if chord < MAX_CLOSURE_MM {
            return Err(NoCircle::NoChord);
        }
        if tolerated_difference(radius.abs()) < 0.5 * chord - radius.abs() {
            return Err(NoCircle::ShortRadius { radius: radius.abs(), chord });
        }
        // (R − d/2)(R + d/2) keeps its digits where R is close to d/2.
        let height = ((radius.abs() - 0.5 * chord) * (radius.abs() + 0.5 * chord)).max(0.0).sqrt();
        let side = if (turn == Turn::Counterclockwise) == (0.0 < radius) { height } else { -height };
        let (left_a, left_b) = (-across / chord, along / chord);
        Ok(start + self.vector([0.5 * along + side * left_a, 0.5 * across + side * left_b, 0.0]))
    }

    /// Returns the arc around `center`, with `turns` − 1 full turns more than the way to the end needs.
    ///
    /// # Errors
    ///
    /// If the centre is the start.
    pub(crate) fn arc(
        self,
        (start, end): (Point, Point),
        center: Point,
        turn: Turn,
        turns: u32,
    ) -> Result<Arc, NoCircle> {
        let [a, b, normal] = self.axes();
        let (from_a, from_b) = (start[a] - center[a], start[b] - center[b]);
        let (to_a, to_b) = (end[a] - center[a], end[b] - center[b]);
        let (start_radius, end_radius) = (from_a.hypot(from_b), to_a.hypot(to_b));
        if start_radius < MAX_CLOSURE_MM {
            return Err(NoCircle::NoRadius);
        }
        let (cos, sin) = (from_a / start_radius, from_b / start_radius);
        let sense = if turn == Turn::Counterclockwise { 1.0 } else { -1.0 };
        let angle = (sense * (from_a * to_b - from_b * to_a)).atan2(from_a * to_a + from_b * to_b);
        let is_full = (end[a] - start[a]).hypot(end[b] - start[b]) < MAX_CLOSURE_MM;
        let once = if is_full || angle <= 0.0 { angle + TAU } else { angle };
        let mut center = center;
        center[normal] = start[normal];
        Ok(Arc {
            center,
            e1: self.vector([cos, sin, 0.0]),
            e2: self.vector([-sense * sin, sense * cos, 0.0]),
            start_radius,
            end_radius,
            sweep: once + f64::from(turns.saturating_sub(1)) * TAU,
            rise: self.vector([0.0, 0.0, end[normal] - start[normal]]),
        })
    }
}

/// Returns the difference of two radii that rounding of the programmed numbers explains, mm.
pub(crate) fn tolerated_difference(radius: f64) -> f64 {
    (1e-3 * radius).max(0.01)
}
