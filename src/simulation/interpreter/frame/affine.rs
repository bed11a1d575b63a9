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

/// How far AᵀA may be from a multiple of 1, relative, for A to keep circles round.
const ROUNDING_RATIO: f64 = 1e-9;

/// An affine map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Affine {
    linear: Matrix3<f64>,
    /// Where it takes the origin, mm.
    offset: Vector,
}

impl Affine {
    pub(crate) fn identity() -> Affine {
        Affine { linear: Matrix3::identity(), offset: Vector::zeros() }
    }

    /// A shift, mm.
    pub(crate) fn shift(offset: Vector) -> Affine {
        Affine { linear: Matrix3::identity(), offset }
    }

    /// A rotation about `center` (mm) in a plane by `angle`, rad, counter-clockwise.
    pub(crate) fn rotation(plane: Plane, center: Point, angle: f64) -> Affine {
        let [a, b, _] = plane.axes();
        let (sin, cos) = exact_sin_cos(angle);
        let mut linear = Matrix3::identity();
        (linear[(a, a)], linear[(a, b)]) = (cos, -sin);
        (linear[(b, a)], linear[(b, b)]) = (sin, cos);
        Affine::about(center, linear)
    }

    /// A scaling about `center` (mm) by one factor for each axis; none is 0.
    pub(crate) fn scaling(center: Point, factors: [f64; 3]) -> Affine {
        Affine::about(center, Matrix3::from_diagonal(&Vector::from(factors)))
    }

    /// A mirror image in each axis for which the place of its mirror is given, mm.
    pub(crate) fn mirror(places: [Option<f64>; 3]) -> Affine {
        let center = Point::from(places.map(Option::unwrap_or_default));
        Affine::scaling(center, places.map(|place| if place.is_some() { -1.0 } else { 1.0 }))
    }

    fn about(center: Point, linear: Matrix3<f64>) -> Affine {
        Affine { linear, offset: center.coords - linear * center.coords }
    }

    /// The map that does `first` and then this one.
    pub(crate) fn after(&self, first: &Affine) -> Affine {
        Affine { linear: self.linear * first.linear, offset: self.linear * first.offset + self.offset }
    }

    /// The map that undoes this one, or `None` if it has no inverse.
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

    /// Its shift, mm, where it is nothing more than that.
    pub(super) fn as_shift(&self) -> Option<Vector> {
        (self.linear == Matrix3::identity()).then_some(self.offset)
    }

    /// The factor by which it scales all lengths, where there is one.
    pub(super) fn scale(&self) -> Option<f64> {
        let square = self.linear.transpose() * self.linear;
        let mean = square.trace() / 3.0;
        let apart = (square - Matrix3::from_diagonal_element(mean)).amax();
        (apart <= ROUNDING_RATIO * mean).then_some(mean.sqrt())
    }

    /// Whether lines along the normal of `plane` stay along it, and the plane so its own.
    pub(super) fn keeps(&self, plane: Plane) -> bool {
        let [a, b, normal] = plane.axes();
        let across = [(a, normal), (b, normal), (normal, a), (normal, b)];
        across.into_iter().all(|place| self.linear[place].abs() <= ROUNDING_RATIO * self.linear.amax())
    }

    /// Whether a turn in the plane becomes one in the other sense.
    pub(crate) fn flips(&self, plane: Plane) -> bool {
        let [a, b, _] = plane.axes();
        self.linear[(a, a)] * self.linear[(b, b)] < self.linear[(a, b)] * self.linear[(b, a)]
    }

    /// The largest factor by which it scales one of the two axes of a plane.
    pub(super) fn largest_scale(&self, plane: Plane) -> f64 {
        let [a, b, _] = plane.axes();
        self.linear.column(a).norm().max(self.linear.column(b).norm())
    }
}

/// Sine and cosine, without rounding at quarter turns: a part turned by 90° keeps its right angles.
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
