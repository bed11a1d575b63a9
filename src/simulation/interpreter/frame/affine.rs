//! Affine maps of space: p ↦ A p + b, with A without unit and b in mm.
//!
//! ```text
//! shift by v                p + v
//! rotation about c by θ     c + R(θ) (p − c),   R turns the first axis of the plane to its second
//! scaling about c by k      c + K (p − c),      K = diag(kx, ky, kz)
//! mirror at x = m           c + diag(−1, 1, 1) (p − c), c = (m, 0, 0); y and z alike
//! ```

use crate::simulation::toolpath::plane::Plane;
use crate::simulation::toolpath::{Point, Vector};
use nalgebra::Matrix3;

/// Largest difference of AᵀA to a multiple of 1, relative, with which A keeps circles round.
const ROUNDING_RATIO: f64 = 1e-9;

/// An affine map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Affine {
    linear: Matrix3<f64>,
    /// The image of the origin, mm.
    offset: Vector,
}

impl Affine {
    pub(crate) fn identity() -> Affine {
        Affine { linear: Matrix3::identity(), offset: Vector::zeros() }
    }

    /// Returns a shift, mm.
    pub(crate) fn shift(offset: Vector) -> Affine {
        Affine { linear: Matrix3::identity(), offset }
    }

    /// Returns a rotation about `center` (mm) in a plane by `angle`, rad, counter-clockwise.
    pub(crate) fn rotation(plane: Plane, center: Point, angle: f64) -> Affine {
        let [a, b, _] = plane.axes();
        let (sin, cos) = exact_sin_cos(angle);
        let mut linear = Matrix3::identity();
        (linear[(a, a)], linear[(a, b)]) = (cos, -sin);
        (linear[(b, a)], linear[(b, b)]) = (sin, cos);
        Affine::about(center, linear)
    }

    /// Returns a scaling about `center` (mm) by one factor for each axis; no factor is 0.
    pub(crate) fn scaling(center: Point, factors: [f64; 3]) -> Affine {
        Affine::about(center, Matrix3::from_diagonal(&Vector::from(factors)))
    }

    /// Returns a mirror image in each axis with a given coordinate of its mirror, mm.
    pub(crate) fn mirror(places: [Option<f64>; 3]) -> Affine {
        let center = Point::from(places.map(Option::unwrap_or_default));
        Affine::scaling(center, places.map(|place| if place.is_some() { -1.0 } else { 1.0 }))
    }

    fn about(center: Point, linear: Matrix3<f64>) -> Affine {
        Affine { linear, offset: center.coords - linear * center.coords }
    }

    /// Returns the map that applies `first` and then this one.
    pub(crate) fn after(&self, first: &Affine) -> Affine {
        Affine { linear: self.linear * first.linear, offset: self.linear * first.offset + self.offset }
    }

    /// Returns the inverse map, or `None` if there is none.
    pub(super) fn inverse(&self) -> Option<Affine> {
        let linear = self.linear.try_inverse()?;
        Some(Affine { linear, offset: -(linear * self.offset) })
    }

    pub(crate) fn point(&self, point: &Point) -> Point {
        Point::from(self.linear * point.coords + self.offset)
    }

    pub(crate) fn vector(&self, vector: &Vector) -> Vector {
        self.linear * vector
    }

    /// Returns the shift, mm, or `None` if the map is more than a shift.
    pub(super) fn as_shift(&self) -> Option<Vector> {
        (self.linear == Matrix3::identity()).then_some(self.offset)
    }

    /// Returns the factor by which the map scales all lengths, or `None` if there is no single one.
    pub(super) fn scale(&self) -> Option<f64> {
        let square = self.linear.transpose() * self.linear;
        let mean = square.trace() / 3.0;
        let apart = (square - Matrix3::from_diagonal_element(mean)).amax();
        (apart <= ROUNDING_RATIO * mean).then_some(mean.sqrt())
    }

    /// Returns `true` if lines along the normal of `plane` remain along it, and the plane remains parallel.
    pub(super) fn keeps(&self, plane: Plane) -> bool {
        let [a, b, normal] = plane.axes();
        let across = [(a, normal), (b, normal), (normal, a), (normal, b)];
        across.into_iter().all(|place| self.linear[place].abs() <= ROUNDING_RATIO * self.linear.amax())
    }

    /// Returns `true` if the map reverses the sense of rotation in the plane.
    pub(crate) fn flips(&self, plane: Plane) -> bool {
        let [a, b, _] = plane.axes();
        self.linear[(a, a)] * self.linear[(b, b)] < self.linear[(a, b)] * self.linear[(b, a)]
    }

    /// Returns the largest factor by which the map scales one of the two axes of a plane.
    pub(super) fn largest_scale(&self, plane: Plane) -> f64 {
        let [a, b, _] = plane.axes();
        self.linear.column(a).norm().max(self.linear.column(b).norm())
    }
}

/// Returns sine and cosine, exact at quarter turns: a part turned by 90° keeps its right angles.
fn exact_sin_cos(angle: f64) -> (f64, f64) {
    let quarters = angle / std::f64::consts::FRAC_PI_2;
    if quarters.fract() != 0.0 {
        return angle.sin_cos();
    }
    match quarters.rem_euclid(4.0) as u8 {
        0 => (0.0, 1.0),
        1 => (1.0, 0.0),
        2 => (0.0, -1.0),
        _ => (-1.0, 0.0),
    }
}
