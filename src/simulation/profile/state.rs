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
//! over angles so small that its error is below the rounding. Crowds of short pulses count as a whole.
//!
//! Only ages enter, never the time since the start: a program of any length keeps all its digits.
//!
//! ```text
//!    command      pulse i−2   pulse i−1    pulse i
//!              |-----------|------------|------.······
//!                   |<-------- D -------------->|
//!                   window                      now: elapsed since pulse i began
//! ```

use crate::simulation::filter::{Expansion, FilterChain};
use crate::simulation::profile::Motion;
use crate::simulation::profile::crowds::Crowd;
use crate::simulation::profile::slice::{Slice, quadrature};
use crate::simulation::toolpath::{Curve, Point, Vector};

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

/// What has arrived of the distance, from the youngest part of the window on.
#[derive(Default)]
struct Progress {
    /// mm.
    distance: f64,
    /// How fast it arrives, mm/s.
    feedrate: f64,
    /// V and S at the age where the last slice begins, where the next one ends; 0 where nothing has arrived yet of what
    /// is sent now.
    younger: (f64, f64),
}

impl Progress {
    /// Adds a slice; what has arrived of it (mm) and how fast it arrives (mm/s).
    #[inline(always)]
    fn add(&mut self, slice: &Slice, filter: &FilterChain) -> (f64, f64) {
        let slope = slice.slope();
        if self.younger.1 == 0.0 {
            self.younger = filter.step_and_displacement(slice.younger);
        }
        let (v_younger, s_younger) = self.younger;
        let (v_older, s_older) = filter.step_and_displacement(slice.older);
        let mut arrived = slice.first * s_older - slice.last * s_younger;
        let mut arrives = slice.first * v_older - slice.last * v_younger;
        if slope != 0.0 {
            let q = filter.ramp_displacement(slice.older) - filter.ramp_displacement(slice.younger);
            arrived += slope * q;
            arrives += slope * (s_older - s_younger);
        }
        self.distance += arrived;
        self.feedrate += arrives;
        self.younger = (v_older, s_older);
        (arrived, arrives)
    }

    fn add_crowd(&mut self, crowd: &Crowd, filter: &Expansion) {
        let (arrived, arrives) = crowd.progress(filter);
        self.distance += arrived;
        self.feedrate += arrives;
        self.younger = (0.0, 0.0);
    }
}

impl Motion<'_> {
    /// Where the tool is and how fast it moves.
    pub fn state(&self, moment: Moment) -> State {
        self.state_along(moment, &mut |segment| self.distances.before(self.segments, 0, segment))
    }

    /// The same where `distance_before` tells how long the path is before a segment, mm.
    pub(super) fn state_along(&self, moment: Moment, distance_before: &mut dyn FnMut(usize) -> f64) -> State {
        let filter = self.filter;
        let (mut travel, mut velocity) = (Vector::zeros(), Vector::zeros());
        let mut sums = (Progress::default(), &mut travel, &mut velocity);
        let of_slice = |(progress, travel, velocity): &mut (Progress, &mut Vector, &mut Vector),
                        slice: Slice| {
            let (arrived, arrives) = progress.add(&slice, filter);
            match self.segments.curve(slice.segment) {
                Curve::Line => {
                    let direction = self.segments.direction(slice.segment);
                    **travel += arrived * direction;
                    **velocity += arrives * direction;
                }
                Curve::Arc(arc) => {
                    let (arrived, arrives) =
                        slice.along_arc(arc, self.segments.length(slice.segment), filter);
                    **travel += arrived;
                    **velocity += arrives;
                }
            }
        };
        let oldest = self.for_each_part(moment, &mut sums, of_slice, |sums, crowd, filter| {
            sums.0.add_crowd(crowd, filter);
            let (arrived, arrives) = crowd.travel(filter);
            *sums.1 += arrived;
            *sums.2 += arrives;
        });
        State {
            distance: distance_before(oldest.segment) + oldest.offset + sums.0.distance,
            position: self.segments.point(oldest.segment, oldest.offset) + travel,
            velocity,
        }
    }

    /// What [`Walk::progress`] tells, where `distance_before` tells how long the path is before a segment, mm.
    pub(super) fn progress_along(
        &self,
        moment: Moment,
        distance_before: &mut dyn FnMut(usize) -> f64,
    ) -> (f64, f64) {
        let mut sum = Progress::default();
        let of_slice = |sum: &mut Progress, slice: Slice| {
            sum.add(&slice, self.filter);
        };
        let oldest = self.for_each_part(moment, &mut sum, of_slice, Progress::add_crowd);
        (distance_before(oldest.segment) + oldest.offset + sum.distance, sum.feedrate)
    }

    /// How the velocity changes.
    pub fn dynamics(&self, moment: Moment) -> Dynamics {
        let filter = self.filter;
        let mut acceleration = Vector::zeros();
        let mut jerk = Vector::zeros();
        let of_slice = |(acceleration, jerk): &mut (&mut Vector, &mut Vector), slice: Slice| {
            let slope = slice.slope();
            let segment = self.segments.at(slice.segment);
            for (age, sign) in [(slice.older, 1.0), (slice.younger, -1.0)] {
                let (feedrate, s) = slice.at(age);
                let [first, second, _] = segment.derivatives(s);
                let commanded = feedrate * first;
                let change = slope * first + feedrate * feedrate * second;
                **acceleration += sign * filter.impulse(age) * commanded;
                **jerk += sign * (filter.impulse_slope(age) * commanded + filter.impulse(age) * change);
            }
            match &segment.curve {
                Curve::Line if slope == 0.0 => {}
                Curve::Line => {
                    let arrived = filter.step(slice.older) - filter.step(slice.younger);
                    **acceleration += slope * arrived * segment.tangent(0.0);
                }
                Curve::Arc(arc) => {
                    for span in filter.spans(slice.younger, slice.older) {
                        quadrature(&slice, arc, segment.length, span.begin..span.end, |node| {
                            let (feedrate, s) = slice.at(node.age);
                            let [first, second, third] = segment.derivatives(s);
                            let impulse = node.weight * span.impulse(node.age);
                            **acceleration += impulse * (slope * first + feedrate * feedrate * second);
                            **jerk += impulse * (3.0 * feedrate * slope * second + feedrate.powi(3) * third);
                        });
                    }
                }
            }
        };
        let mut sums = (&mut acceleration, &mut jerk);
        self.for_each_part(moment, &mut sums, of_slice, |sums, crowd, filter| {
            let (of_crowd, change) = crowd.dynamics(filter);
            *sums.0 += of_crowd;
            *sums.1 += change;
        });
        Dynamics { acceleration, jerk }
    }

    /// Adds everything in the window to `sum`, the youngest first, and returns where the command was one filter delay
    /// ago.
    fn for_each_part<T>(
        &self,
        moment: Moment,
        sum: &mut T,
        add_slice: impl Fn(&mut T, Slice),
        add_crowd: impl Fn(&mut T, &Crowd, &Expansion),
    ) -> Oldest {
        let delay = self.filter.delay();
        let mut younger = moment.elapsed - self.pulses.duration(moment.pulse);
        // One past the pulse that is next.
        let mut next = moment.pulse + 1;
        while self.first_pulse < next {
            if !self.crowds.is_empty()
                && let Some((crowd, filter)) = self.crowd_before(next, younger)
            {
                add_crowd(sum, crowd, &filter);
                younger += crowd.duration;
                next -= crowd.count;
                continue;
            }
            let index = next - 1;
            let pulse = self.pulses.at(index);
            let segment = pulse.segment as usize;
            let older = if index == moment.pulse { moment.elapsed } else { younger + pulse.duration };
            let [first, last] = pulse.feedrate;
            let whole = Slice { segment, older, younger, first, last, offset: pulse.offset };
            let is_inside = index != moment.pulse && older < delay;
            let slice = if is_inside { whole } else { whole.within(delay) };
            let offset = slice.offset;
            if slice.younger < slice.older {
                add_slice(sum, slice);
            }
            if delay <= older {
                return Oldest { segment, offset };
            }
            younger = older;
            next = index;
        }
        Oldest { segment: self.pulses.segment(self.first_pulse), offset: 0.0 }
    }

    /// How many pulses and crowds a state is made of.
    #[cfg(test)]
    pub(super) fn parts_in_window(&self, moment: Moment) -> usize {
        let mut count = 0;
        self.for_each_part(moment, &mut count, |count, _| *count += 1, |count, _, _| *count += 1);
        count
    }

    /// The largest crowd before the pulse `next` that lies within the window and between two knots of the filter,
    /// if it ended `younger` (s) ago.
    fn crowd_before(&self, next: usize, younger: f64) -> Option<(&Crowd, Expansion)> {
        self.crowds.ending_at(next).find_map(|crowd| {
            let filter = self.filter.expansion(younger, younger + crowd.duration)?;
            Some((crowd, filter))
        })
    }
}

/// Where the command was one filter delay ago.
struct Oldest {
    segment: usize,
    /// Distance from the start of the segment, mm.
    offset: f64,
}
