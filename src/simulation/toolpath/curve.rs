//! The shape of a segment as a function of the distance s along it.
//!
//! ```text
//! line    P(s) = P0 + s u
//! helix   P(s) = C + (r0 + (r1 − r0) σ)(e1 cos φσ + e2 sin φσ) + σ w,   σ = s / L
//! ```
//!
//! C centre of the start circle (mm), r0 and r1 radius at both ends (mm; equal but for the
//! rounding of programmed numbers), φ > 0 the sweep (rad), e1 and e2 orthonormal in the plane
//! of the circle with e1 towards the start and e2 along the motion, w the rise (mm) along the
//! axis. An arc is a helix with w = 0. Where r0 ≠ r1 the speed is uniform in σ, not exactly in
//! arc length; the difference is of the order |r1 − r0| / r0.

use crate::simulation::toolpath::{Point, Segment, Vector};

/// Line or helix.
#[derive(Clone, Debug, PartialEq)]
pub enum Curve {
    /// Straight from start to end.
    Line,
    /// Circular arc, full circle or helix.
    Arc(Box<Arc>),
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
    /// Angle run through, rad; positive, more than 2π for several turns.
    pub sweep: f64,
    /// Displacement along the axis over the whole arc, mm.
    pub rise: Vector,
}

impl Arc {
    /// Length along the helix at the mean radius, mm.
    pub fn length(&self) -> f64 {
        (self.sweep * self.mean_radius()).hypot(self.rise.norm())
    }

    /// Mean of the radii at both ends, mm.
    pub fn mean_radius(&self) -> f64 {
        0.5 * (self.start_radius + self.end_radius)
    }

    /// Position at the fraction σ of the arc, mm.
    fn point(&self, sigma: f64) -> Point {
        let (sin, cos) = (self.sweep * sigma).sin_cos();
        let radius = self.start_radius + (self.end_radius - self.start_radius) * sigma;
        self.center + radius * (cos * self.e1 + sin * self.e2) + sigma * self.rise
    }

    /// Derivative of the position by σ, mm.
    fn derivative(&self, sigma: f64) -> Vector {
        let (sin, cos) = (self.sweep * sigma).sin_cos();
        let widening = self.end_radius - self.start_radius;
        let radius = self.start_radius + widening * sigma;
        radius * self.sweep * (cos * self.e2 - sin * self.e1)
            + widening * (cos * self.e1 + sin * self.e2)
            + self.rise
    }
}

impl Arc {
    /// Second and third derivative of the position by σ, mm; the widening of a rounded arc is
    /// left out, as it is in the curvature.
    fn higher_derivatives(&self, sigma: f64) -> [Vector; 2] {
        let (sin, cos) = (self.sweep * sigma).sin_cos();
        let radius = self.start_radius + (self.end_radius - self.start_radius) * sigma;
        [
            -radius * self.sweep.powi(2) * (cos * self.e1 + sin * self.e2),
            radius * self.sweep.powi(3) * (sin * self.e1 - cos * self.e2),
        ]
    }
}

impl Segment {
    /// First, second and third derivative of the position by the distance at `s`: without unit,
    /// 1/mm and 1/mm².
    pub fn derivatives(&self, s: f64) -> [Vector; 3] {
        match &self.curve {
            Curve::Line => [self.tangent(s), Vector::zeros(), Vector::zeros()],
            Curve::Arc(arc) => {
                let [second, third] = arc.higher_derivatives(s / self.length);
                [self.tangent(s), second / self.length.powi(2), third / self.length.powi(3)]
            }
        }
    }

    /// Position at distance `s` from the start, mm.
    pub fn point(&self, s: f64) -> Point {
        match &self.curve {
            Curve::Line => self.start + (self.end - self.start) * (s / self.length),
            Curve::Arc(arc) => arc.point(s / self.length),
        }
    }

    /// Derivative of the position by the distance at `s`: the unit tangent.
    pub fn tangent(&self, s: f64) -> Vector {
        match &self.curve {
            Curve::Line => (self.end - self.start) / self.length,
            Curve::Arc(arc) => arc.derivative(s / self.length) / self.length,
        }
    }
}
