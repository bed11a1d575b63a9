//! A pulse within the window of the filters, and integrals over it where it runs along an arc.

use std::ops::Range;

use crate::simulation::feed::Pulse;
use crate::simulation::filter::FilterChain;
use crate::simulation::toolpath::{Arc, Vector};

/// A pulse within the window: from the older age to the younger one.
pub(super) struct Slice {
    /// Index of its segment.
    pub(super) segment: usize,
    /// Age of its beginning, s; at most D.
    pub(super) older: f64,
    /// Age of its end, s; 0 where it is still going on.
    pub(super) younger: f64,
    /// Command at its beginning, mm/s.
    pub(super) first: f64,
    /// Command at its end, mm/s.
    pub(super) last: f64,
    /// Distance along the segment where it begins, mm.
    pub(super) offset: f64,
}

impl Slice {
    /// A whole pulse that has just ended.
    pub(super) fn of_whole(pulse: &Pulse) -> Slice {
        let (segment, [first, last]) = (pulse.segment as usize, pulse.feedrate);
        Slice { segment, older: pulse.duration, younger: 0.0, first, last, offset: pulse.offset }
    }

    /// What of it lies within the window: from its beginning, or from the edge, to its end, or to now. Ends that are
    /// not cut keep their numbers bit for bit.
    pub(super) fn within(self, delay: f64) -> Slice {
        let (begin, end) = (self.older.min(delay), self.younger.max(0.0));
        let (first, offset) =
            if begin == self.older { (self.first, self.offset) } else { self.at(begin.max(self.younger)) };
        let last = if end == self.younger { self.last } else { self.at(end).0 };
        Slice { older: begin, younger: end, first, last, offset, ..self }
    }

    /// What has arrived of it along an arc of `length` mm (mm), and how fast it arrives (mm/s). Apart from the sum over the
    /// window, which nearly always is of lines and has no registers to spare.
    #[inline(never)]
    pub(super) fn along_arc(&self, arc: &Arc, length: f64, filter: &FilterChain) -> (Vector, Vector) {
        let (mut arrived, mut arrives) = (InPlane::default(), InPlane::default());
        for span in filter.spans(self.younger, self.older) {
            quadrature(self, arc, length, span.begin..span.end, |node| {
                arrived.add(node.weight * span.step(node.age), &node);
                arrives.add(node.weight * span.impulse(node.age), &node);
            });
        }
        (arrived.over(arc, length), arrives.over(arc, length))
    }

    /// Slope of the command, mm/s².
    pub(super) fn slope(&self) -> f64 {
        let duration = self.older - self.younger;
        if self.first == self.last || duration <= 0.0 { 0.0 } else { (self.last - self.first) / duration }
    }

    /// Command (mm/s) and distance along the segment (mm) at an age.
    pub(super) fn at(&self, age: f64) -> (f64, f64) {
        let elapsed = self.older - age;
        let feedrate = self.first + self.slope() * elapsed;
        (feedrate, self.offset + 0.5 * (self.first + feedrate) * elapsed)
    }
}

/// Nodes and weights of the Gauss-Legendre rule with 6 points on −1 … 1; its error for a function
/// that turns by an angle β within the interval is below (β/4)^12 / 12!.
const GAUSS: [(f64, f64); 6] = [
    (-0.932_469_514_203_152, 0.171_324_492_379_170_4),
    (-0.661_209_386_466_264_5, 0.360_761_573_048_138_6),
    (-0.238_619_186_083_196_9, 0.467_913_934_572_691),
    (0.238_619_186_083_196_9, 0.467_913_934_572_691),
    (0.661_209_386_466_264_5, 0.360_761_573_048_138_6),
    (0.932_469_514_203_152, 0.171_324_492_379_170_4),
];

/// Largest angle turned within one interval of the quadrature, rad.
const QUADRATURE_ANGLE: f64 = 0.5;

/// A moment within an arc at which an integral over it is taken.
pub(super) struct Node {
    /// Its age, s.
    pub age: f64,
    /// What it counts in the integral, s.
    pub weight: f64,
    /// Velocity over that of a segment of the length 1 mm, in the frame of the arc.
    velocity: InPlane,
}

/// A vector in the frame of an arc, as the parts along e1, e2 and the rise, mm²/s.
#[derive(Clone, Copy, Default)]
pub(super) struct InPlane([f64; 3]);

impl InPlane {
    /// Adds the velocity at a node so many times.
    pub(super) fn add(&mut self, factor: f64, node: &Node) {
        self.0.iter_mut().zip(node.velocity.0).for_each(|(sum, part)| *sum += factor * part);
    }

    /// In space, for an arc of `length`, mm.
    pub(super) fn over(&self, arc: &Arc, length: f64) -> Vector {
        let per_length = 1.0 / length;
        let [first, second, rise] = self.0.map(|part| part * per_length);
        first * arc.e1 + second * arc.e2 + rise * arc.rise
    }
}

/// Sine and cosine of an angle, rad; by their series up to half of [`QUADRATURE_ANGLE`], beyond which what is left out
/// is below the rounding.
fn turn(angle: f64) -> (f64, f64) {
    if 0.5 * QUADRATURE_ANGLE < angle.abs() {
        return angle.sin_cos();
    }
    let square = angle * angle;
    let sine = nested(square, [1.0 / 6.0, 1.0 / 20.0, 1.0 / 42.0, 1.0 / 72.0, 1.0 / 110.0]);
    let cosine = nested(square, [1.0 / 2.0, 1.0 / 12.0, 1.0 / 30.0, 1.0 / 56.0, 1.0 / 90.0, 1.0 / 132.0]);
    (angle * sine, cosine)
}

/// 1 − a x (1 − b x (1 − …)) with the terms a, b, … and x.
fn nested<const TERMS: usize>(x: f64, terms: [f64; TERMS]) -> f64 {
    terms.iter().rev().fold(1.0, |sum, term| 1.0 - x * term * sum)
}

/// Calls `visit(node)` so that Σ weight f(age) = ∫ f da over these ages (s) of a slice of an arc of `length` (mm), for
/// f smooth between them.
pub(super) fn quadrature(
    slice: &Slice,
    arc: &Arc,
    length: f64,
    ages: Range<f64>,
    mut visit: impl FnMut(Node),
) {
    let per_length = 1.0 / length;
    let turning = arc.sweep * per_length * slice.first.max(slice.last);
    let intervals = ((ages.end - ages.start) * turning / QUADRATURE_ANGLE).ceil().clamp(1.0, 1e4) as usize;
    let half = 0.5 * (ages.end - ages.start) / intervals as f64;
    let is_even = slice.first == slice.last;
    // At an even command each interval turns by the same angles around its middle.
    let mut turned = [(0.0, 1.0); GAUSS.len()];
    if is_even {
        for k in 0..GAUSS.len() / 2 {
            let (sin, cos) = turn(turning * GAUSS[k].0 * half);
            (turned[k], turned[GAUSS.len() - 1 - k]) = ((sin, cos), (-sin, cos));
        }
    }
    for interval in 0..intervals {
        let middle = ages.start + (2 * interval + 1) as f64 * half;
        let (sin, cos) = (arc.sweep * (slice.at(middle).1 * per_length)).sin_cos();
        for k in 0..GAUSS.len() {
            let ((node, weight), (sin_node, cos_node)) = (GAUSS[k], turned[k]);
            let age = middle + node * half;
            let (feedrate, s) = slice.at(age);
            let sigma = s * per_length;
            // What is older was commanded before the arc turned on to the middle.
            let (sin, cos) = if is_even {
                (sin * cos_node - cos * sin_node, cos * cos_node + sin * sin_node)
            } else {
                (arc.sweep * sigma).sin_cos()
            };
            let [first, second] = arc.derivative_in_plane(sigma, sin, cos);
            let velocity = InPlane([feedrate * first, feedrate * second, feedrate]);
            visit(Node { age, weight: weight * half, velocity });
        }
    }
}
