//! The filtered motion at one moment, exactly.
//!
//! What was commanded at the age a (seconds ago) has arrived by the share V(a). With the command
//! velocity v(a) over the window of one filter delay D,
//!
//! ```text
//! position      P = P(D) + ∫ v V da        P(D): commanded position, D ago
//! velocity      Ṗ =        ∫ v h da
//! acceleration  P̈ = [v h] + ∫ v̇ h da       and so on for the jerk
//! ```
//!
//! where [·] is the difference between the ends of each pulse. Along a line v is linear in time
//! and the integrals are differences of S, Q, V and h at the ends of each pulse. Along an arc v
//! also turns, and the integrals are taken by Gauss-Legendre quadrature between the knots of h,
//! over angles so small that its error is below the rounding.
//!
//! Only ages enter, never the time since the start: a program of any length keeps all its digits.
//!
//! ```text
//!    command      pulse i−2   pulse i−1    pulse i
//!              |-----------|------------|------.······
//!                   |<-------- D -------------->|
//!                   window                      now: elapsed since pulse i began
//! ```

use crate::simulation::filter::FilterChain;
use crate::simulation::profile::Motion;
use crate::simulation::toolpath::{Curve, Point, Segment, Vector};

/// A moment in a stretch: so long after a pulse began. After the last pulse the filters run empty,
/// and `elapsed` goes on beyond its duration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// Index of the pulse in the plan.
    pub pulse: usize,
    /// Time since the pulse began, s.
    pub elapsed: f64,
}

/// The filtered motion at one moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State {
    /// Distance along the programmed path, mm: the integral of the filtered feed command.
    pub distance: f64,
    /// Position of the tool, mm.
    pub position: Point,
    /// Velocity of each axis, mm/s; its norm is the feedrate.
    pub velocity: Vector,
}

/// Acceleration and jerk at one moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dynamics {
    /// Acceleration of each axis, mm/s².
    pub acceleration: Vector,
    /// Jerk of each axis, mm/s³; with a single filter its Dirac pulses are left out.
    pub jerk: Vector,
}

impl Dynamics {
    /// Acceleration (mm/s²) and jerk (mm/s³) along the path of a tool that moves at `velocity`
    /// (mm/s): the first and second derivative of the feedrate. None while it stands.
    pub fn along(&self, velocity: &Vector) -> Option<(f64, f64)> {
        let feedrate = velocity.norm();
        if feedrate == 0.0 {
            return None;
        }
        let tangent = velocity / feedrate;
        let acceleration = self.acceleration.dot(&tangent);
        let across = self.acceleration - acceleration * tangent;
        Some((acceleration, self.jerk.dot(&tangent) + across.norm_squared() / feedrate))
    }
}

/// A pulse within the window: from the older age to the younger one.
struct Slice<'a> {
    segment: &'a Segment,
    /// Age of its beginning, s; at most D.
    older: f64,
    /// Age of its end, s; 0 where it is still going on.
    younger: f64,
    /// Command at its beginning, mm/s.
    first: f64,
    /// Command at its end, mm/s.
    last: f64,
    /// Distance along the segment where it begins, mm.
    offset: f64,
}

impl Slice<'_> {
    /// Slope of the command, mm/s².
    fn slope(&self) -> f64 {
        let duration = self.older - self.younger;
        if self.first == self.last || duration <= 0.0 { 0.0 } else { (self.last - self.first) / duration }
    }

    /// Command (mm/s) and distance along the segment (mm) at an age.
    fn at(&self, age: f64) -> (f64, f64) {
        let elapsed = self.older - age;
        let feedrate = self.first + self.slope() * elapsed;
        (feedrate, self.offset + 0.5 * (self.first + feedrate) * elapsed)
    }
}

impl Motion<'_> {
    /// Where the tool is and how fast it moves.
    pub fn state(&self, moment: Moment) -> State {
        let filter = self.filter;
        let mut distance = 0.0;
        let mut travel = Vector::zeros();
        let mut velocity = Vector::zeros();
        // One slice ends where the next begins, and nothing has arrived of what is sent now.
        let (mut s_younger, mut v_younger) = (0.0, 0.0);
        let oldest = self.for_each_slice(moment, |slice| {
            let slope = slice.slope();
            if s_younger == 0.0 {
                (s_younger, v_younger) = (filter.displacement(slice.younger), filter.step(slice.younger));
            }
            let (s_older, v_older) = (filter.displacement(slice.older), filter.step(slice.older));
            let mut arrived = slice.first * s_older - slice.last * s_younger;
            if slope != 0.0 {
                let q = filter.ramp_displacement(slice.older) - filter.ramp_displacement(slice.younger);
                arrived += slope * q;
            }
            distance += arrived;
            match &slice.segment.curve {
                Curve::Line => {
                    let direction = slice.segment.tangent(0.0);
                    let mut feedrate = slice.first * v_older - slice.last * v_younger;
                    if slope != 0.0 {
                        feedrate += slope * (s_older - s_younger);
                    }
                    travel += arrived * direction;
                    velocity += feedrate * direction;
                }
                Curve::Arc(_) => quadrature(&slice, filter, |age, weight| {
                    let (feedrate, s) = slice.at(age);
                    let commanded = feedrate * slice.segment.tangent(s);
                    travel += weight * filter.step(age) * commanded;
                    velocity += weight * filter.impulse(age) * commanded;
                }),
            }
            (s_younger, v_younger) = (s_older, v_older);
        });
        State {
            distance: self.distances[oldest.segment] + oldest.offset + distance,
            position: self.segments[oldest.segment].point(oldest.offset) + travel,
            velocity,
        }
    }

    /// The distance along the programmed path (mm) and how fast it grows (mm/s): the sum of the
    /// filtered feed command, which at a corner is more than the feedrate of the tool.
    pub fn progress(&self, moment: Moment) -> (f64, f64) {
        let filter = self.filter;
        let (mut distance, mut feedrate) = (0.0, 0.0);
        let (mut s_younger, mut v_younger) = (0.0, 0.0);
        let oldest = self.for_each_slice(moment, |slice| {
            let slope = slice.slope();
            if s_younger == 0.0 {
                (s_younger, v_younger) = (filter.displacement(slice.younger), filter.step(slice.younger));
            }
            let (s_older, v_older) = (filter.displacement(slice.older), filter.step(slice.older));
            distance += slice.first * s_older - slice.last * s_younger;
            feedrate += slice.first * v_older - slice.last * v_younger;
            if slope != 0.0 {
                let q = filter.ramp_displacement(slice.older) - filter.ramp_displacement(slice.younger);
                distance += slope * q;
                feedrate += slope * (s_older - s_younger);
            }
            (s_younger, v_younger) = (s_older, v_older);
        });
        (self.distances[oldest.segment] + oldest.offset + distance, feedrate)
    }

    /// How the velocity changes.
    pub fn dynamics(&self, moment: Moment) -> Dynamics {
        let filter = self.filter;
        let mut acceleration = Vector::zeros();
        let mut jerk = Vector::zeros();
        self.for_each_slice(moment, |slice| {
            let slope = slice.slope();
            for (age, sign) in [(slice.older, 1.0), (slice.younger, -1.0)] {
                let (feedrate, s) = slice.at(age);
                let [first, second, _] = slice.segment.derivatives(s);
                let commanded = feedrate * first;
                let change = slope * first + feedrate * feedrate * second;
                acceleration += sign * filter.impulse(age) * commanded;
                jerk += sign * (filter.impulse_slope(age) * commanded + filter.impulse(age) * change);
            }
            match &slice.segment.curve {
                Curve::Line if slope == 0.0 => {}
                Curve::Line => {
                    let arrived = filter.step(slice.older) - filter.step(slice.younger);
                    acceleration += slope * arrived * slice.segment.tangent(0.0);
                }
                Curve::Arc(_) => quadrature(&slice, filter, |age, weight| {
                    let (feedrate, s) = slice.at(age);
                    let [first, second, third] = slice.segment.derivatives(s);
                    let impulse = weight * filter.impulse(age);
                    acceleration += impulse * (slope * first + feedrate * feedrate * second);
                    jerk += impulse * (3.0 * feedrate * slope * second + feedrate.powi(3) * third);
                }),
            }
        });
        Dynamics { acceleration, jerk }
    }

    /// Calls `visit` for every pulse in the window, the youngest first, and returns where the
    /// command was one filter delay ago.
    fn for_each_slice(&self, moment: Moment, mut visit: impl FnMut(Slice)) -> Oldest {
        let delay = self.filter.delay();
        let mut younger = moment.elapsed - self.pulses[moment.pulse].duration;
        for index in (self.first_pulse..=moment.pulse).rev() {
            let pulse = &self.pulses[index];
            let segment = pulse.segment as usize;
            let older = if index == moment.pulse { moment.elapsed } else { younger + pulse.duration };
            let whole = Slice {
                segment: &self.segments[segment],
                older,
                younger,
                first: pulse.feedrate[0],
                last: pulse.feedrate[1],
                offset: pulse.offset,
            };
            // A pulse counts from its beginning, or from the edge of the window, to its end, or
            // to now. Ends that are not cut keep their numbers bit for bit.
            let (begin, end) = (older.min(delay), whole.younger.max(0.0));
            let (first, offset) =
                if begin == older { (whole.first, whole.offset) } else { whole.at(begin.max(whole.younger)) };
            if end < begin {
                let last = if end == whole.younger { whole.last } else { whole.at(end).0 };
                visit(Slice { older: begin, younger: end, first, last, offset, ..whole });
            }
            if delay <= older {
                return Oldest { segment, offset };
            }
            younger = older;
        }
        Oldest { segment: self.pulses[self.first_pulse].segment as usize, offset: 0.0 }
    }
}

/// Where the command was one filter delay ago.
struct Oldest {
    segment: usize,
    /// Distance from the start of the segment, mm.
    offset: f64,
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

/// Calls `visit(age, weight)` so that Σ weight f(age) = ∫ f da over the slice, for f smooth
/// between the knots of the filter.
fn quadrature(slice: &Slice, filter: &FilterChain, mut visit: impl FnMut(f64, f64)) {
    let Curve::Arc(arc) = &slice.segment.curve else { return };
    let turning = arc.sweep / slice.segment.length * slice.first.max(slice.last);
    let mut begin = slice.younger;
    for knot in filter.knots().filter(|&knot| slice.younger < knot) {
        let end = knot.min(slice.older);
        if begin < end {
            let intervals = ((end - begin) * turning / QUADRATURE_ANGLE).ceil().clamp(1.0, 1e4) as usize;
            let half = 0.5 * (end - begin) / intervals as f64;
            for interval in 0..intervals {
                let middle = begin + (2 * interval + 1) as f64 * half;
                GAUSS.iter().for_each(|(node, weight)| visit(middle + node * half, weight * half));
            }
            begin = end;
        }
    }
}
