//! The shape of a segment as a function of the distance s along it.
//!
//! ```text
//! line    P(s) = P0 + s u
//! helix   P(s) = C + (r0 + (r1 − r0) σ)(e1 cos φσ + e2 sin φσ) + σ w,   σ = s / L
//! ```
//!
//! C is the centre of the start circle (mm), r0 and r1 are the radii at both ends (mm; equal but for the rounding
//! of programmed numbers), φ > 0 is the sweep (rad), e1 and e2 are orthonormal in the plane of the circle with e1
//! towards the start and e2 along the motion, and w is the rise (mm) along the axis. An arc is a helix with w = 0.
//! If r0 ≠ r1 the speed is uniform in σ, not exactly in arc length; the difference is of the order |r1 − r0| / r0.

use crate::simulation::toolpath::{Point, Segment, Vector};
use std::f64::consts::TAU;

/// Line or helix.
#[derive(Clone, Debug, PartialEq)]
pub enum Curve {
    /// Straight from start to end.
    Line,
    /// Circular arc, full circle or helix; copies share it.
    Arc(std::sync::Arc<Arc>),
}

/// A circular or helical arc.
#[derive(Clone, Debug, PartialEq)]
pub struct Arc {
    /// Centre of the circle in the plane of the start point, mm.
    pub center: Point,
    /// Unit vector from the centre to the start.
    pub e1: Vector,
    /// Unit vector of the motion at the start, in the plane of the circle.
    pub e2: Vector,
    /// Radius at the start, mm.
    pub start_radius: f64,
    /// Radius at the end, mm.
    pub end_radius: f64,
    /// Angle of the arc, rad; positive, more than 2π for several turns.
    pub sweep: f64,
    /// Displacement along the axis over the whole arc, mm.
    pub rise: Vector,
}

impl Arc {
    /// Returns the arc from `start` through `middle` to `end`, or `None` if the points are on one line.
    pub(crate) fn through(start: Point, middle: Point, end: Point) -> Option<Arc> {
        let (to_middle, to_end) = (middle - start, end - start);
        let normal = to_middle.cross(&to_end);
        let doubled = 2.0 * normal.norm_squared();
        // Three points on one line, by the rounding of programmed numbers, have no circle.
        if doubled <= 1e-18 * to_middle.norm_squared() * to_end.norm_squared() || doubled == 0.0 {
            return None;
        }
        let toward =
            (to_middle.norm_squared() * to_end - to_end.norm_squared() * to_middle).cross(&normal) / -doubled;
        let center = start - toward;
        let (radius, e1) = (toward.norm(), toward.normalize());
        let e2 = normal.normalize().cross(&e1);
        let across = end - center;
        let angle = across.dot(&e2).atan2(across.dot(&e1));
        let sweep = if angle <= 0.0 { angle + TAU } else { angle };
        Some(Arc { center, e1, e2, start_radius: radius, end_radius: radius, sweep, rise: Vector::zeros() })
    }

    /// Returns the arc that leaves `start` along `direction` and ends at `end`, in the plane with this `normal`
    /// axis, rising along it; `None` if it would be a line.
    pub(crate) fn along(start: Point, direction: Vector, end: Point, normal: usize) -> Option<Arc> {
        let mut rise = Vector::zeros();
        rise[normal] = end[normal] - start[normal];
        let chord = end - start - rise;
        let mut heading = direction;
        heading[normal] = 0.0;
        let heading = heading.try_normalize(1e-9)?;
        let aside = chord - heading * chord.dot(&heading);
        let side = aside.try_normalize(1e-9 * chord.norm().max(1e-6))?;
        let radius = chord.norm_squared() / (2.0 * chord.dot(&side));
        let center = start + radius * side;
        let angle = 2.0 * chord.dot(&side).atan2(chord.dot(&heading));
        Some(Arc {
            center,
            e1: -side,
            e2: heading,
            start_radius: radius,
            end_radius: radius,
            sweep: angle,
            rise,
        })
    }

    /// Returns the length along the helix at the mean radius, mm.
    pub fn length(&self) -> f64 {
        (self.sweep * self.mean_radius()).hypot(self.rise.norm())
    }

    /// Returns the mean of the radii at both ends, mm.
    pub fn mean_radius(&self) -> f64 {
        0.5 * (self.start_radius + self.end_radius)
    }

    /// Returns the radius at the fraction σ of the arc, mm.
    pub fn radius(&self, sigma: f64) -> f64 {
        self.start_radius + (self.end_radius - self.start_radius) * sigma
    }

    /// Returns the position at the fraction σ of the arc, mm.
    fn point(&self, sigma: f64) -> Point {
        let (sin, cos) = (self.sweep * sigma).sin_cos();
        let radius = self.radius(sigma);
        self.center + radius * (cos * self.e1 + sin * self.e2) + sigma * self.rise
    }

    /// Returns the components along e1 and e2 of the derivative of the position by σ, mm, given sine and cosine of
    /// the angle turned so far. The component along the rise is 1.
    pub fn derivative_in_plane(&self, sigma: f64, sin: f64, cos: f64) -> [f64; 2] {
        let widening = self.end_radius - self.start_radius;
        let turning = self.radius(sigma) * self.sweep;
        [widening * cos - turning * sin, turning * cos + widening * sin]
    }

    /// Returns the components of the second derivative of the position by σ, mm, along e1, e2 and the rise, as
    /// [`derivative_in_plane`](Arc::derivative_in_plane) does. It neglects the change of the radius, as the curvature does.
    pub fn second_derivative_in_plane(&self, sigma: f64, sin: f64, cos: f64) -> [f64; 3] {
        let radius = self.radius(sigma);
        let towards_centre = -radius * self.sweep * self.sweep;
        [towards_centre * cos, towards_centre * sin, 0.0]
    }

    /// Returns the derivative of the position by σ, mm.
    fn derivative(&self, sigma: f64) -> Vector {
        let (sin, cos) = (self.sweep * sigma).sin_cos();
        let widening = self.end_radius - self.start_radius;
        let radius = self.radius(sigma);
        radius * self.sweep * (cos * self.e2 - sin * self.e1)
            + widening * (cos * self.e1 + sin * self.e2)
            + self.rise
    }
}

impl Arc {
    /// Returns the part of the arc between two fractions σ.
    fn part(&self, from: f64, to: f64) -> Arc {
        let (sin, cos) = (self.sweep * from).sin_cos();
        let radius = |sigma: f64| self.start_radius + (self.end_radius - self.start_radius) * sigma;
        Arc {
            center: self.center + from * self.rise,
            e1: cos * self.e1 + sin * self.e2,
            e2: cos * self.e2 - sin * self.e1,
            start_radius: radius(from),
            end_radius: radius(to),
            sweep: self.sweep * (to - from),
            rise: self.rise * (to - from),
        }
    }

    /// Returns the second and third derivative of the position by σ, mm. Both neglect the change of the radius, as
    /// the curvature does.
    fn higher_derivatives(&self, sigma: f64) -> [Vector; 2] {
        let (sin, cos) = (self.sweep * sigma).sin_cos();
        let radius = self.radius(sigma);
        [
            -radius * self.sweep.powi(2) * (cos * self.e1 + sin * self.e2),
            radius * self.sweep.powi(3) * (sin * self.e1 - cos * self.e2),
        ]
    }
}

/// Returns the angle between two unit vectors, rad, from 0 to π. It is computed from its half: acos loses digits for small
/// angles.
pub fn angle_between(first: &Vector, second: &Vector) -> f64 {
    2.0 * (second - first).norm().atan2((second + first).norm())
}

/// Returns the distance of a point from a chord, mm, both given from the start of the chord; beyond an end it is the
/// distance from that end.
pub fn distance_from_chord(point: Vector, chord: Vector) -> f64 {
    let along = (point.dot(&chord) / chord.norm_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    (point - along * chord).norm()
}

impl Curve {
    /// Returns the position at the fraction σ of the way from `start` to `end`, mm.
    #[inline]
    pub(crate) fn point(&self, start: Point, end: Point, sigma: f64) -> Point {
        match self {
            Curve::Line => start + (end - start) * sigma,
            Curve::Arc(arc) => arc.point(sigma),
        }
    }
}

impl Segment {
    /// Returns the first, second and third derivative of the position by the distance at `s`: without unit, 1/mm
    /// and 1/mm².
    pub fn derivatives(&self, s: f64) -> [Vector; 3] {
        match &self.curve {
            Curve::Line => [self.tangent(s), Vector::zeros(), Vector::zeros()],
            Curve::Arc(arc) => {
                let [second, third] = arc.higher_derivatives(s / self.length);
                [self.tangent(s), second / self.length.powi(2), third / self.length.powi(3)]
            }
        }
    }

    /// Returns the position at distance `s` from the start, mm.
    #[inline]
    pub fn point(&self, s: f64) -> Point {
        self.curve.point(self.start, self.end, s / self.length)
    }

    /// Returns the derivative of the position by the distance at `s`: the unit tangent.
    #[inline]
    pub fn tangent(&self, s: f64) -> Vector {
        match &self.curve {
            Curve::Line => (self.end - self.start) / self.length,
            Curve::Arc(arc) => arc.derivative(s / self.length) / self.length,
        }
    }

    /// Returns the part of the segment between two distances from its start, mm. An exact stop belongs to its end.
    pub fn part(&self, from: f64, to: f64) -> Segment {
        let (is_first, is_last) = (from <= 0.0, self.length <= to);
        let share = (to - from) / self.length;
        Segment {
            start: if is_first { self.start } else { self.point(from) },
            end: if is_last { self.end } else { self.point(to) },
            curve: match &self.curve {
                Curve::Line => Curve::Line,
                Curve::Arc(arc) => Curve::Arc(arc.part(from / self.length, to / self.length).into()),
            },
            length: to - from,
            rotation: (*self.rotation * share).into(),
            exact_stop: is_last && self.exact_stop,
            ..*self
        }
    }

    /// Returns the unit tangents at both ends.
    pub fn tangents(&self) -> [Vector; 2] {
        let first = self.tangent(0.0);
        match self.curve {
            Curve::Line => [first, first],
            Curve::Arc(_) => [first, self.tangent(self.length)],
        }
    }
}
