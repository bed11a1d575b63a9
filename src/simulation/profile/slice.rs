//! A pulse within the window of the filters, and integrals over it where it runs along an arc.

use std::ops::Range;

use crate::simulation::feed::Pulse;
use crate::simulation::filter::FilterChain;
use crate::simulation::toolpath::{Arc, Vector};

/// A pulse within the window: from the older age to the younger one.
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
        let (sin, cos) = (arc.sweep * (slice.at(middle).1 * per_length)).sin_cos();
        for k in 0..GAUSS_LEGENDRE_6.len() {
            let ((node, weight), (sin_node, cos_node)) = (GAUSS_LEGENDRE_6[k], turned[k]);
            let age = middle + node * half;
            let (feedrate, s) = slice.at(age);
            let sigma = s * per_length;
            // An older part was commanded before the middle of the arc.
            let (sin, cos) = if is_even {
                (sin * cos_node - cos * sin_node, cos * cos_node + sin * sin_node)
            } else {
                (arc.sweep * sigma).sin_cos()
            };
            let [first, second] = arc.derivative_in_plane(sigma, sin, cos);
            let first = [first, second, 1.0];
            visit(QuadratureNode { age, weight: weight * half, feedrate, sigma, sin, cos, first });
        }
    }
}
