//! Where the tool goes: lines, circular arcs in XY (with a helix in Z) and parabolic corner blends,
//! each by its arc length s in mm. A parabola has the control point C and legs of equal length d:
//!
//!     p(q) = (1−q)² P0 + 2 q (1−q) C + q² P2
//!
//! and its arc length is integrated numerically and inverted by Newton's method.

/// A point or direction in mm.
pub type Vector = [f64; 3];

/// a + k b
pub fn add(a: Vector, k: f64, b: Vector) -> Vector {
    [a[0] + k * b[0], a[1] + k * b[1], a[2] + k * b[2]]
}

/// b − a
pub fn between(a: Vector, b: Vector) -> Vector {
    add(b, -1.0, a)
}

/// Length of a vector.
pub fn norm(a: Vector) -> f64 {
    (a[0] * a[0] + a[1] * a[1] + a[2] * a[2]).sqrt()
}

fn scaled(a: Vector, k: f64) -> Vector {
    a.map(|x| k * x)
}

/// One piece of path.
#[derive(Clone, Debug)]
pub enum Shape {
    /// Straight from one point to another.
    Line { from: Vector, to: Vector },
    /// Around a centre; angles in rad, `sweep` positive counter-clockwise, `rise` along Z in mm.
    Arc { centre: Vector, radius: f64, start: f64, sweep: f64, rise: f64 },
    /// A corner blend.
    Parabola { ends: [Vector; 2], corner: Vector, length: f64 },
}

impl Shape {
    /// The parabola that rounds `corner`.
    pub fn parabola(from: Vector, corner: Vector, to: Vector) -> Shape {
        let ends = [from, to];
        Shape::Parabola { ends, corner, length: parabola_length(&ends, corner, 1.0) }
    }

    /// Arc length, mm.
    pub fn length(&self) -> f64 {
        match self {
            Shape::Line { from, to } => norm(between(*from, *to)),
            Shape::Arc { radius, sweep, rise, .. } => (radius * sweep).hypot(*rise),
            Shape::Parabola { length, .. } => *length,
        }
    }

    /// The point at arc length `s`.
    pub fn point(&self, s: f64) -> Vector {
        let share = (s / self.length().max(1e-12)).clamp(0.0, 1.0);
        match self {
            Shape::Line { from, to } => add(*from, share, between(*from, *to)),
            Shape::Arc { centre, radius, start, sweep, rise } => {
                let angle = start + share * sweep;
                add(*centre, 1.0, [radius * angle.cos(), radius * angle.sin(), share * rise])
            }
            Shape::Parabola { ends, corner, .. } => {
                let q = self.parameter(s);
                let inner = add(scaled(ends[0], (1.0 - q) * (1.0 - q)), 2.0 * q * (1.0 - q), *corner);
                add(inner, q * q, ends[1])
            }
        }
    }

    /// Unit tangent at arc length `s`.
    pub fn tangent(&self, s: f64) -> Vector {
        let direction = match self {
            Shape::Line { from, to } => between(*from, *to),
            Shape::Arc { radius, start, sweep, rise, .. } => {
                let angle = start + (s / self.length().max(1e-12)).clamp(0.0, 1.0) * sweep;
                [-radius * sweep * angle.sin(), radius * sweep * angle.cos(), *rise]
            }
            Shape::Parabola { ends, corner, .. } => parabola_speed(ends, *corner, self.parameter(s)),
        };
        scaled(direction, 1.0 / norm(direction).max(1e-12))
    }

    /// The largest curvature, 1/mm.
    pub fn curvature(&self) -> f64 {
        match self {
            Shape::Line { .. } => 0.0,
            Shape::Arc { radius, sweep, .. } => {
                let share = (radius * sweep).abs() / self.length().max(1e-12);
                share * share / radius
            }
            Shape::Parabola { ends, corner, .. } => {
                let (leg, chord) = (norm(between(ends[0], *corner)), norm(between(ends[0], ends[1])));
                let half_sum = (chord / (2.0 * leg)).max(1e-6);
                (1.0 - half_sum * half_sum).max(0.0).sqrt() / (leg * half_sum * half_sum)
            }
        }
    }

    /// The largest share of axis `k` in the unit tangent.
    pub fn share(&self, axis: usize) -> f64 {
        let length = self.length();
        let steps = if matches!(self, Shape::Line { .. }) { 0 } else { 32 };
        let at = |i: i32| self.tangent(length * f64::from(i) / 32.0)[axis].abs();
        (0..=steps).map(at).fold(0.0, f64::max)
    }

    fn parameter(&self, s: f64) -> f64 {
        let Shape::Parabola { ends, corner, length } = self else { return 0.0 };
        let mut q = (s / length.max(1e-12)).clamp(0.0, 1.0);
        for _ in 0..8 {
            let slope = norm(parabola_speed(ends, *corner, q)).max(1e-12);
            q = (q - (parabola_length(ends, *corner, q) - s) / slope).clamp(0.0, 1.0);
        }
        q
    }
}

fn parabola_speed(ends: &[Vector; 2], corner: Vector, q: f64) -> Vector {
    add(scaled(between(ends[0], corner), 2.0 * (1.0 - q)), 2.0 * q, between(corner, ends[1]))
}

/// Arc length from the start to parameter `q`, by Simpson's rule on 32 intervals.
fn parabola_length(ends: &[Vector; 2], corner: Vector, q: f64) -> f64 {
    let weight = |i: usize| {
        if i == 0 || i == 32 {
            1.0
        } else if i % 2 == 1 {
            4.0
        } else {
            2.0
        }
    };
    let at = |i: usize| weight(i) * norm(parabola_speed(ends, corner, q * i as f64 / 32.0));
    (0..=32).map(at).sum::<f64>() * q / 96.0
}
