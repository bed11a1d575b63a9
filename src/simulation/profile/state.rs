//! The filtered motion at one moment, exactly.
//!
//! Of a command sent a seconds ago (its age) the share V(a) has arrived. With the command velocity v(a) over
//! the window of one filter delay D,
//!
//! ```text
//! position      P = P(D) + ∫ v V da        P(D): commanded position, D ago
//! velocity      Ṗ =        ∫ v h da
//! acceleration  P̈ = [v h] + ∫ v̇ h da       and so on for the jerk
//! ```
//!
//! where [·] is the difference between the ends of each pulse. Along a line v is linear in time and the
//! integrals are differences of S, Q, V and h at the ends of each pulse. Along an arc v also turns, and the
//! integrals are taken by Gauss-Legendre quadrature between the knots of h, over angles so small that its
//! error is below rounding. Clusters of short pulses are added as a whole.
//!
//! Where a curve replaces a corner ([`CornerCurve`](crate::simulation::feed::CornerCurve)), the tool is on the curve, and
//! where lines are merged ([`MergedPath`](crate::simulation::feed::MergedPath)), on the merged line, at the same distance
//! along the programmed path. The filters of such a control are so short that they change nothing there. Limits:
//! acceleration and jerk are those along the programmed path.
//!
//! The formulas contain ages and never the time since the start, so that a long program loses no digits.
//!
//! ```text
//!    command      pulse i−2   pulse i−1    pulse i
//!              |-----------|------------|------.······
//!                   |<-------- D -------------->|
//!                   window                      now: elapsed since pulse i began
//! ```

use crate::simulation::feed::on_curve;
use crate::simulation::filter::{Expansion, FilterChain};
use crate::simulation::profile::FilteredMotion;
use crate::simulation::profile::moments::PulseCluster;
use crate::simulation::profile::slice::{PulseSlice, quadrature};
use crate::simulation::toolpath::{Curve, Point, Vector};

/// A moment in a motion: the time since a pulse began. After the last pulse the filters run empty, and
/// `elapsed` continues beyond its duration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// Index of the pulse in the plan.
    pub pulse: usize,
    /// Time since the pulse began, s.
    pub elapsed: f64,
}

/// The filtered motion at one moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionState {
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
    /// Jerk of each axis, mm/s³; the Dirac pulses of a single filter are left out.
    pub jerk: Vector,
}

impl Dynamics {
    /// Returns acceleration (mm/s²) and jerk (mm/s³) along the path of a tool that moves at `velocity`
    /// (mm/s): the first and second derivative of the feedrate. `None` at rest.
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

/// The distance that has arrived, summed from the youngest part of the window on.
#[derive(Default)]
struct ArrivedDistance {
    /// Distance, mm.
    distance: f64,
    /// Rate of the distance, mm/s.
    feedrate: f64,
    /// V and S at the age where the last slice begins and the next one ends; 0 before the first.
    younger: (f64, f64),
}

impl ArrivedDistance {
    /// Adds a slice; returns its contribution to the distance (mm) and to the rate (mm/s).
    #[inline(always)]
    fn add(&mut self, slice: &PulseSlice, filter: &FilterChain) -> (f64, f64) {
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

    fn add_cluster(&mut self, cluster: &PulseCluster, filter: &Expansion) {
        let (arrived, arrives) = cluster.progress(filter);
        self.distance += arrived;
        self.feedrate += arrives;
        self.younger = (0.0, 0.0);
    }
}

impl FilteredMotion<'_> {
    /// Returns position and velocity of the tool.
    pub fn state(&self, moment: Moment) -> MotionState {
        self.state_along(moment, &mut |segment| self.distances.before(self.segments, 0, segment))
    }

    /// Returns position and velocity of the tool; `distance_before` returns the length of the path before a
    /// segment, mm.
    pub(super) fn state_along(
        &self,
        moment: Moment,
        distance_before: &mut dyn FnMut(usize) -> f64,
    ) -> MotionState {
        let filter = self.filter;
        let (mut travel, mut velocity) = (Vector::zeros(), Vector::zeros());
        let mut sums = (ArrivedDistance::default(), &mut travel, &mut velocity);
        let of_slice = |(progress, travel, velocity): &mut (ArrivedDistance, &mut Vector, &mut Vector),
                        slice: PulseSlice| {
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
        let oldest = self.for_each_part(moment, &mut sums, of_slice, |sums, cluster, filter| {
            sums.0.add_cluster(cluster, filter);
            let (arrived, arrives) = cluster.travel(filter);
            *sums.1 += arrived;
            *sums.2 += arrives;
        });
        let feedrate = sums.0.feedrate;
        let state = MotionState {
            distance: distance_before(oldest.segment) + oldest.offset + sums.0.distance,
            position: self.segments.point(oldest.segment, oldest.offset) + travel,
            velocity,
        };
        self.on_run_path(state, feedrate, moment, distance_before)
    }

    /// Returns a state with the tool on the path that the control runs: on the curve in place of a corner or on a merged
    /// line, where there is one. `feedrate` is the rate of the distance (mm/s), at this moment.
    pub(super) fn on_run_path(
        &self,
        state: MotionState,
        feedrate: f64,
        moment: Moment,
        distance_before: &mut dyn FnMut(usize) -> f64,
    ) -> MotionState {
        let off = match self.merged_path {
            Some(merged) => Some(merged.at(state.distance, self.corner_curves)),
            None if self.corner_curves.is_empty() => None,
            None => {
                // The command has passed this distance on its way to the segment of the pulse.
                let mut segment = self.pulses.segment(moment.pulse);
                let mut offset = state.distance - distance_before(segment);
                while offset < 0.0 && 0 < segment {
                    segment -= 1;
                    offset = state.distance - distance_before(segment);
                }
                on_curve(self.corner_curves, segment, offset, self.segments)
            }
        };
        off.map_or(state, |(position, derivative)| MotionState {
            position,
            velocity: feedrate * derivative,
            ..state
        })
    }

    /// Returns the distance along the programmed path (mm) and its rate (mm/s); `distance_before` returns the
    /// length of the path before a segment, mm.
    pub(super) fn progress_along(
        &self,
        moment: Moment,
        distance_before: &mut dyn FnMut(usize) -> f64,
    ) -> (f64, f64) {
        let mut sum = ArrivedDistance::default();
        let of_slice = |sum: &mut ArrivedDistance, slice: PulseSlice| {
            sum.add(&slice, self.filter);
        };
        let oldest = self.for_each_part(moment, &mut sum, of_slice, ArrivedDistance::add_cluster);
        (distance_before(oldest.segment) + oldest.offset + sum.distance, sum.feedrate)
    }

    /// Returns the acceleration of the tool, mm/s².
    pub(super) fn acceleration(&self, moment: Moment) -> Vector {
        let filter = self.filter;
        let of_slice = |sum: &mut Vector, slice: PulseSlice| {
            let at_end = |age: f64| filter.impulse(age) * slice.at(age).0;
            match self.segments.curve(slice.segment) {
                Curve::Line => {
                    let mut along = at_end(slice.older) - at_end(slice.younger);
                    let slope = slice.slope();
                    if slope != 0.0 {
                        along += slope * (filter.step(slice.older) - filter.step(slice.younger));
                    }
                    *sum += along * self.segments.direction(slice.segment);
                }
                Curve::Arc(arc) => {
                    let length = self.segments.length(slice.segment);
                    *sum += slice.acceleration_along_arc(arc, length, filter);
                }
            }
        };
        let mut sum = Vector::zeros();
        self.for_each_part(moment, &mut sum, of_slice, |sum, cluster, filter| {
            *sum += cluster.dynamics(filter).0
        });
        sum
    }

    /// Returns acceleration and jerk of the tool.
    pub fn dynamics(&self, moment: Moment) -> Dynamics {
        let filter = self.filter;
        let of_slice = |jerk: &mut Vector, slice: PulseSlice| {
            let slope = slice.slope();
            let segment = self.segments.at(slice.segment);
            for (age, sign) in [(slice.older, 1.0), (slice.younger, -1.0)] {
                let (feedrate, s) = slice.at(age);
                let [first, second, _] = segment.derivatives(s);
                let change = slope * first + feedrate * feedrate * second;
                *jerk += sign * (filter.impulse_slope(age) * feedrate * first + filter.impulse(age) * change);
            }
            if let Curve::Arc(arc) = &segment.curve {
                for span in filter.spans(slice.younger, slice.older) {
                    quadrature(&slice, arc, segment.length, span.begin..span.end, |node| {
                        let (feedrate, s) = slice.at(node.age);
                        let [_, second, third] = segment.derivatives(s);
                        let impulse = node.weight * span.impulse(node.age);
                        *jerk += impulse * (3.0 * feedrate * slope * second + feedrate.powi(3) * third);
                    });
                }
            }
        };
        let mut jerk = Vector::zeros();
        self.for_each_part(moment, &mut jerk, of_slice, |jerk, cluster, filter| {
            *jerk += cluster.dynamics(filter).1
        });
        Dynamics { acceleration: self.acceleration(moment), jerk }
    }

    /// Adds all pulses and clusters in the window to `sum`, the youngest first; returns the command one
    /// filter delay ago.
    fn for_each_part<T>(
        &self,
        moment: Moment,
        sum: &mut T,
        add_slice: impl Fn(&mut T, PulseSlice),
        add_cluster: impl Fn(&mut T, &PulseCluster, &Expansion),
    ) -> DelayedCommand {
        let delay = self.filter.delay();
        let mut younger = moment.elapsed - self.pulses.duration(moment.pulse);
        // Index one past the pulse to be added next.
        let mut next = moment.pulse + 1;
        while self.first_pulse < next {
            if !self.clusters.is_empty()
                && let Some((cluster, filter)) = self.cluster_before(next, younger)
            {
                add_cluster(sum, cluster, &filter);
                younger += cluster.duration;
                next -= cluster.count;
                continue;
            }
            let index = next - 1;
            let pulse = self.pulses.at(index);
            let segment = pulse.segment as usize;
            let older = if index == moment.pulse { moment.elapsed } else { younger + pulse.duration };
            let [first, last] = pulse.feedrate;
            let whole = PulseSlice { segment, older, younger, first, last, offset: pulse.offset };
            let is_inside = index != moment.pulse && older < delay;
            let slice = if is_inside { whole } else { whole.within(delay) };
            let offset = slice.offset;
            if slice.younger < slice.older {
                add_slice(sum, slice);
            }
            if delay <= older {
                return DelayedCommand { segment, offset };
            }
            younger = older;
            next = index;
        }
        DelayedCommand { segment: self.pulses.segment(self.first_pulse), offset: 0.0 }
    }

    /// Returns the number of pulses and clusters in the sum of a state.
    #[cfg(test)]
    pub(super) fn parts_in_window(&self, moment: Moment) -> usize {
        let mut count = 0;
        self.for_each_part(moment, &mut count, |count, _| *count += 1, |count, _, _| *count += 1);
        count
    }

    /// Returns the largest cluster before the pulse `next` that lies within the window and between two knots
    /// of the filter; it ended `younger` (s) ago. `None` if there is no such cluster.
    fn cluster_before(&self, next: usize, younger: f64) -> Option<(&PulseCluster, Expansion)> {
        self.clusters.ending_at(next).find_map(|cluster| {
            let filter = self.filter.expansion(younger, younger + cluster.duration)?;
            Some((cluster, filter))
        })
    }
}

/// The command one filter delay ago.
struct DelayedCommand {
    segment: usize,
    /// Distance from the start of the segment, mm.
    offset: f64,
}
