//! A pulse within the window of the filters, and integrals over it where it runs along an arc.
//!
//! Where a pulse along an arc has an even command and fills the whole window, the integrals have a closed form. With the
//! position as a complex number in the plane of the arc, z = r e^(iθ), the moving averages of lengths T_k turn a motion with
//! the rate of turning ω and the radius r + ρ t into
//!
//! ```text
//! z̄ = (r G − i ρ G′) e^(iθ),      G(ω) = Π sinc(ω T_k/2),      r and θ half the filter delay ago
//! ```
//!
//! since their impulse response is symmetric about half the delay.

use std::ops::Range;

use crate::simulation::feed::Pulse;
use crate::simulation::filter::FilterChain;
use crate::simulation::toolpath::{Arc, Vector};

/// A pulse within the window: from the older age to the younger one.
#[derive(Clone, Copy)]
pub(super) struct PulseSlice {
    /// Index of the segment.
    pub(super) segment: usize,
    /// Age of the beginning, s; at most D.
    pub(super) older: f64,
    /// Age of the end, s; 0 while the pulse lasts.
    pub(super) younger: f64,
    /// Command at the beginning, mm/s.
    pub(super) first: f64,
    /// Command at the end, mm/s.
    pub(super) last: f64,
    /// Distance along the segment at the beginning, mm.
    pub(super) offset: f64,
}

impl PulseSlice {
    /// Returns a whole pulse that has just ended.
    pub(super) fn of_whole(pulse: &Pulse) -> PulseSlice {
        let (segment, [first, last]) = (pulse.segment as usize, pulse.feedrate);
        PulseSlice { segment, older: pulse.duration, younger: 0.0, first, last, offset: pulse.offset }
    }

    /// Returns the part within the window: the beginning is cut at the age `delay` (s), and the end at the
    /// age 0. Ends that are not cut keep their values bit for bit.
    pub(super) fn within(self, delay: f64) -> PulseSlice {
        let (begin, end) = (self.older.min(delay), self.younger.max(0.0));
        let (first, offset) =
            if begin == self.older { (self.first, self.offset) } else { self.at(begin.max(self.younger)) };
        let last = if end == self.younger { self.last } else { self.at(end).0 };
        PulseSlice { older: begin, younger: end, first, last, offset, ..self }
    }

    /// Returns the displacement of the slice along an arc of `length` (mm) that has arrived (mm), and its
    /// rate (mm/s). It is not inlined, because the sum over the window nearly always consists of lines and
    /// needs all registers.
    #[inline(never)]
    pub(super) fn along_arc(&self, arc: &Arc, length: f64, filter: &FilterChain) -> (Vector, Vector) {
        if let Some(even) = self.even_turning(arc, length, filter) {
            return (even.arrived(arc).over(arc, 1.0), even.velocity().over(arc, 1.0));
        }
        let (mut arrived, mut arrives) = (ArcFrameVector::default(), ArcFrameVector::default());
        for span in filter.spans(self.younger, self.older) {
            quadrature(self, arc, length, span.begin..span.end, |node| {
                arrived.add(node.weight * span.step(node.age), &node);
                arrives.add(node.weight * span.impulse(node.age), &node);
            });
        }
        (arrived.over(arc, length), arrives.over(arc, length))
    }

    /// Returns the acceleration that the slice along an arc of `length` (mm) contributes, mm/s²: the change of its
    /// command, and the steps of the command at its ends.
    #[inline(never)]
    pub(super) fn acceleration_along_arc(&self, arc: &Arc, length: f64, filter: &FilterChain) -> Vector {
        let (slope, per_length) = (self.slope(), 1.0 / length);
        let mut sum = ArcFrameVector::default();
        if let Some(even) = self.even_turning(arc, length, filter) {
            sum.add_scaled(length, even.acceleration());
        } else {
            for span in filter.spans(self.younger, self.older) {
                quadrature(self, arc, length, span.begin..span.end, |node| {
                    let impulse = node.weight * span.impulse(node.age);
                    let square = node.feedrate * node.feedrate * per_length;
                    sum.add_scaled(impulse * slope, node.first);
                    sum.add_scaled(
                        impulse * square,
                        arc.second_derivative_in_plane(node.sigma, node.sin, node.cos),
                    );
                });
            }
        }
        for (age, sign) in [(self.older, 1.0), (self.younger, -1.0)] {
            let impulse = filter.impulse(age);
            if impulse != 0.0 {
                let (feedrate, s) = self.at(age);
                let sigma = s * per_length;
                let (sin, cos) = (arc.sweep * sigma).sin_cos();
                let [first, second] = arc.derivative_in_plane(sigma, sin, cos);
                sum.add_scaled(sign * impulse * feedrate, [first, second, 1.0]);
            }
        }
        sum.over(arc, length)
    }

    /// Returns the filtered motion in the plane of the arc; `None` unless the slice fills the window with an even command
    /// and turns little enough within each filter for the formula to keep its digits.
    fn even_turning(&self, arc: &Arc, length: f64, filter: &FilterChain) -> Option<EvenTurning> {
        let is_whole = self.younger == 0.0 && self.older == filter.delay();
        if !is_whole || self.first != self.last {
            return None;
        }
        let rate = self.first / length;
        let turning = arc.sweep * rate;
        let longest = filter.time_constants().iter().copied().fold(0.0, f64::max);
        if MAX_FILTERED_ANGLE_RAD < turning * longest {
            return None;
        }
        let (mut gain, mut relative_slope) = (1.0, 0.0);
        for time_constant in filter.time_constants() {
            let half = 0.5 * time_constant;
            let (sinc, slope) = sinc(turning * half);
            gain *= sinc;
            relative_slope += half * slope / sinc;
        }
        let at = |age: f64| (self.offset + self.first * (filter.delay() - age)) / length;
        let (sigma, oldest_sigma) = (at(filter.half_delay()), at(filter.delay()));
        let (sin, cos) = (arc.sweep * sigma).sin_cos();
        let widening = (arc.end_radius - arc.start_radius) * rate;
        Some(EvenTurning {
            rate,
            turning,
            radius: [arc.radius(sigma) * gain, -widening * gain * relative_slope],
            widening: widening * gain,
            direction: [cos, sin],
            sigmas: [oldest_sigma, sigma],
        })
    }

    /// Returns the slope of the command, mm/s².
    pub(super) fn slope(&self) -> f64 {
        let duration = self.older - self.younger;
        if self.first == self.last || duration <= 0.0 { 0.0 } else { (self.last - self.first) / duration }
    }

    /// Returns command (mm/s) and distance along the segment (mm) at an age (s).
    pub(super) fn at(&self, age: f64) -> (f64, f64) {
        let elapsed = self.older - age;
        let feedrate = self.first + self.slope() * elapsed;
        (feedrate, self.offset + 0.5 * (self.first + feedrate) * elapsed)
    }
}

/// Nodes and weights of the Gauss-Legendre rule with 6 points on −1 … 1; its error for a function
/// that turns by an angle β within the interval is below (β/4)^12 / 12!.
const GAUSS_LEGENDRE_6: [(f64, f64); 6] = [
    (-0.932_469_514_203_152, 0.171_324_492_379_170_4),
    (-0.661_209_386_466_264_5, 0.360_761_573_048_138_6),
    (-0.238_619_186_083_196_9, 0.467_913_934_572_691),
    (0.238_619_186_083_196_9, 0.467_913_934_572_691),
    (0.661_209_386_466_264_5, 0.360_761_573_048_138_6),
    (0.932_469_514_203_152, 0.171_324_492_379_170_4),
];

/// Largest angle turned within one interval of the quadrature, rad.
const MAX_QUADRATURE_ANGLE_RAD: f64 = 0.5;

/// Largest angle turned within the longest filter at which the closed form is used, rad; twice the range of [`sinc`].
const MAX_FILTERED_ANGLE_RAD: f64 = 2.0;

/// A filtered motion along an arc at an even command, in the plane of the arc: the position relative to the centre is
/// (`radius[0]` + i `radius[1]`) (`direction[0]` + i `direction[1]`).
struct EvenTurning {
    /// Rate of the fraction of the arc, 1/s.
    rate: f64,
    /// Rate of turning, rad/s.
    turning: f64,
    /// Filtered radius, complex, mm.
    radius: [f64; 2],
    /// Filtered rate of the radius, mm/s.
    widening: f64,
    /// Cosine and sine of the angle half the filter delay ago.
    direction: [f64; 2],
    /// Fraction of the arc one filter delay and half of it ago.
    sigmas: [f64; 2],
}

impl EvenTurning {
    /// Returns the displacement since the command one filter delay ago, mm.
    fn arrived(&self, arc: &Arc) -> ArcFrameVector {
        let [oldest, now] = self.sigmas;
        let (sin, cos) = (arc.sweep * oldest).sin_cos();
        let radius = arc.radius(oldest);
        let [first, second] = self.turned(self.radius);
        ArcFrameVector([first - radius * cos, second - radius * sin, now - oldest])
    }

    /// Returns the velocity, mm/s.
    fn velocity(&self) -> ArcFrameVector {
        let [real, imaginary] = self.radius.map(|part| self.turning * part);
        let [first, second] = self.turned([self.widening - imaginary, real]);
        ArcFrameVector([first, second, self.rate])
    }

    /// Returns the components of the acceleration along e1, e2 and the rise, mm/s². They neglect the change of the radius, as
    /// [`second_derivative_in_plane`](Arc::second_derivative_in_plane) does.
    fn acceleration(&self) -> [f64; 3] {
        let [first, second] = self.turned(self.radius.map(|part| -self.turning * self.turning * part));
        [first, second, 0.0]
    }

    /// Returns a complex number times the direction.
    fn turned(&self, [real, imaginary]: [f64; 2]) -> [f64; 2] {
        let [cos, sin] = self.direction;
        [real * cos - imaginary * sin, real * sin + imaginary * cos]
    }
}

/// Returns sinc(x) = sin(x)/x and its derivative by their series, for |x| ≤ 1, where the truncation error is below rounding.
fn sinc(x: f64) -> (f64, f64) {
    let of_sinc = [1.0 / 6.0, 1.0 / 20.0, 1.0 / 42.0, 1.0 / 72.0, 1.0 / 110.0, 1.0 / 156.0, 1.0 / 210.0];
    let of_slope = [1.0 / 10.0, 1.0 / 28.0, 1.0 / 54.0, 1.0 / 88.0, 1.0 / 130.0, 1.0 / 180.0, 1.0 / 238.0];
    (nested(x * x, of_sinc), -x / 3.0 * nested(x * x, of_slope))
}

/// A node of the quadrature: a moment within an arc.
pub(super) struct QuadratureNode {
    /// Age, s.
    pub age: f64,
    /// Weight in the integral, s.
    pub weight: f64,
    /// Feedrate of the command, mm/s.
    pub feedrate: f64,
    /// Fraction of the arc, and sine and cosine of the angle turned so far.
    pub sigma: f64,
    pub sin: f64,
    pub cos: f64,
    /// Derivative of the position by σ, mm, in the frame of the arc.
    pub first: [f64; 3],
}

/// A vector in the frame of an arc, as the parts along e1, e2 and the rise, mm²/s.
#[derive(Clone, Copy, Default)]
pub(super) struct ArcFrameVector([f64; 3]);

impl ArcFrameVector {
    /// Adds `factor` times the velocity at a node.
    pub(super) fn add(&mut self, factor: f64, node: &QuadratureNode) {
        self.add_scaled(factor, node.first.map(|part| node.feedrate * part));
    }

    fn add_scaled(&mut self, factor: f64, parts: [f64; 3]) {
        self.0.iter_mut().zip(parts).for_each(|(sum, part)| *sum += factor * part);
    }

    /// Returns the vector in space, for an arc of `length`, mm.
    pub(super) fn over(&self, arc: &Arc, length: f64) -> Vector {
        let per_length = 1.0 / length;
        let [first, second, rise] = self.0.map(|part| part * per_length);
        first * arc.e1 + second * arc.e2 + rise * arc.rise
    }
}

/// Returns sine and cosine of an angle, rad; by their series up to half of [`MAX_QUADRATURE_ANGLE_RAD`], where the
/// truncation error is below rounding.
fn turn(angle: f64) -> (f64, f64) {
    if 0.5 * MAX_QUADRATURE_ANGLE_RAD < angle.abs() {
        return angle.sin_cos();
    }
    let square = angle * angle;
    let sine = nested(square, [1.0 / 6.0, 1.0 / 20.0, 1.0 / 42.0, 1.0 / 72.0, 1.0 / 110.0]);
    let cosine = nested(square, [1.0 / 2.0, 1.0 / 12.0, 1.0 / 30.0, 1.0 / 56.0, 1.0 / 90.0, 1.0 / 132.0]);
    (angle * sine, cosine)
}

/// Returns 1 − a x (1 − b x (1 − …)) for the terms a, b, … and x.
fn nested<const TERMS: usize>(x: f64, terms: [f64; TERMS]) -> f64 {
    terms.iter().rev().fold(1.0, |sum, term| 1.0 - x * term * sum)
}

/// Calls `visit(node)` so that Σ weight f(age) = ∫ f da over these ages (s) of a slice of an arc of `length`
/// (mm), for f smooth between them.
pub(super) fn quadrature(
    slice: &PulseSlice,
    arc: &Arc,
    length: f64,
    ages: Range<f64>,
    mut visit: impl FnMut(QuadratureNode),
) {
    let per_length = 1.0 / length;
    let turning = arc.sweep * per_length * slice.first.max(slice.last);
    let intervals =
        ((ages.end - ages.start) * turning / MAX_QUADRATURE_ANGLE_RAD).ceil().clamp(1.0, 1e4) as usize;
    let half = 0.5 * (ages.end - ages.start) / intervals as f64;
    let is_even = slice.first == slice.last;
    // At an even command each interval turns by the same angles around its middle.
    let mut turned = [(0.0, 1.0); GAUSS_LEGENDRE_6.len()];
    if is_even {
        for k in 0..GAUSS_LEGENDRE_6.len() / 2 {
            let (sin, cos) = turn(turning * GAUSS_LEGENDRE_6[k].0 * half);
            (turned[k], turned[GAUSS_LEGENDRE_6.len() - 1 - k]) = ((sin, cos), (-sin, cos));
        }
    }
    for interval in 0..intervals {
        let middle = ages.start + (2 * interval + 1) as f64 * half;
        let middle_s = slice.at(middle).1;
        let (sin, cos) = (arc.sweep * (middle_s * per_length)).sin_cos();
        for k in 0..GAUSS_LEGENDRE_6.len() {
            let (node, weight) = GAUSS_LEGENDRE_6[k];
            let age = middle + node * half;
            let (feedrate, s) = slice.at(age);
            let sigma = s * per_length;
            // An older part was commanded before the middle of the arc.
            let (sin_node, cos_node) =
                if is_even { turned[k] } else { turn(arc.sweep * ((middle_s - s) * per_length)) };
            let (sin, cos) = (sin * cos_node - cos * sin_node, cos * cos_node + sin * sin_node);
            let [first, second] = arc.derivative_in_plane(sigma, sin, cos);
            let first = [first, second, 1.0];
            visit(QuadratureNode { age, weight: weight * half, feedrate, sigma, sin, cos, first });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_window_on_an_arc_is_the_sum_of_its_halves() {
        let arc = Arc {
            center: [3.0, -2.0, 0.5].into(),
            e1: Vector::x(),
            e2: Vector::y(),
            start_radius: 7.0,
            end_radius: 7.2,
            sweep: 2.5,
            rise: Vector::new(0.0, 0.0, 4.0),
        };
        let length = arc.length();
        for filters in [vec![0.02, 0.02, 0.02], vec![0.05, 0.013], vec![0.04]] {
            let filter = FilterChain::new(&filters);
            let whole = PulseSlice {
                segment: 0,
                older: filter.delay(),
                younger: 0.0,
                first: 90.0,
                last: 90.0,
                offset: 2.0,
            };
            assert!(whole.even_turning(&arc, length, &filter).is_some());
            let middle = 0.37 * filter.delay();
            let (_, offset) = whole.at(middle);
            let halves =
                [PulseSlice { younger: middle, ..whole }, PulseSlice { older: middle, offset, ..whole }];
            let (arrived, arrives) = whole.along_arc(&arc, length, &filter);
            let each = halves.each_ref().map(|half| half.along_arc(&arc, length, &filter));
            assert!((arrived - each[0].0 - each[1].0).norm() < 1e-13 * length, "{filters:?}");
            assert!((arrives - each[0].1 - each[1].1).norm() < 1e-12 * whole.first, "{filters:?}");
            let acceleration = whole.acceleration_along_arc(&arc, length, &filter);
            let sum: Vector =
                halves.iter().map(|half| half.acceleration_along_arc(&arc, length, &filter)).sum();
            assert!((acceleration - sum).norm() < 1e-11 * acceleration.norm(), "{filters:?}");
        }
    }
}
