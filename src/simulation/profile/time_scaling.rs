//! Acceleration limits behind the filters: filtered motion, run no faster than axes and path can follow.
//!
//! The filtered motion P(τ) has the feedrate w = ‖P′‖, the direction u = P′/w and the curvature
//! N = (P″ − (P″·u) u)/w². Run at v ≤ w along the same path, the machine accelerates by
//!
//! ```text
//! P̈ = v̇ u + v² N,        |P̈_k| ≤ A_k  for each axis k,     |v̇| ≤ A along the path
//! ```
//!
//! Two passes over the squared feedrate, one forward from each stop and one backward, find the fastest such
//! motion: from one sample to the next, Δσ (mm) apart,
//!
//! ```text
//! Δ(v²) ≤ 2 Δσ (A_k − v² |N_k|)/|u_k|
//! ```
//!
//! must hold at both samples. At the second it is solved for v², which stays below A_k/|N_k|, where turning
//! uses the whole acceleration of an axis. A ramp therefore begins as round as the filters make it, continues
//! straight, and ends where it meets the filtered motion; without filters it would be a trapezoid. The filters
//! alone decide the path, and with it the contour error.
//!
//! Samples lie a 48th of the filter delay apart, closer where one of the filters is short, while the filtered
//! motion changes, and nowhere else. Where the filtered motion is constant the ramps are straight, and their
//! ends are inserted exactly; where it only follows a slope of the command a few samples suffice. The work is
//! linear in the number of pulses. Limits: the magnitude of N is used, so that the machine is a little too
//! slow where turning and braking push an axis in opposite directions; rotary axes are ignored.
//!
//! Plans of controls that plan their ramps before any filter, as in [`crate::simulation::feed::block`], do
//! not change.

use crate::machine::Machine;
use crate::simulation::feed::{FeedPlan, Knot, RestToRest, TimeScaling, time_scaling};
use crate::simulation::profile::{Dynamics, FilteredMotion, Moment, MotionCursor, MotionState, Profile};
use crate::simulation::running_sum::running_sum;
use crate::simulation::toolpath::{Curve, Toolpath, Vector};

/// Samples within one filter delay.
const SAMPLES_PER_DELAY: f64 = 48.0;
/// Most samples within one filter delay, if one of the filters is short.
const MAX_SAMPLES_PER_DELAY: f64 = 480.0;

/// Samples within the shortest filter.
const SAMPLES_PER_FILTER: f64 = 12.0;

/// Samples within a pulse whose command rises or falls, where the filters only follow it.
const SAMPLES_PER_SLOPE: f64 = 16.0;

/// Largest angle turned on an arc between two samples, rad.
const MAX_SAMPLE_ANGLE_RAD: f64 = 0.02;

/// Cosine of the angle between the directions at two samples below which the motion has turned back.
const REVERSAL_COSINE: f64 = -0.99;

/// A feedrate less than this part below the filtered one counts as equal to it.
const FREE_FEEDRATE_RATIO: f64 = 1e-12;

/// Returns the plan with the time that acceleration limits cost behind the filters.
pub(crate) fn time_scaled(toolpath: &Toolpath, machine: &Machine, plan: FeedPlan) -> FeedPlan {
    let limits = AccelerationLimits::of(machine);
    if machine.limits_command() || !limits.are_finite() {
        return plan;
    }
    let mut scaling = TimeScaling::default();
    {
        let profile = Profile::new(toolpath, &plan);
        for rest_to_rest in plan.rest_to_rest_motions() {
            limits.slow_down(&profile.motion(rest_to_rest), rest_to_rest, &mut scaling);
        }
    }
    FeedPlan { time_scaling: (!scaling.is_empty()).then_some(scaling), ..plan }
}

/// A sample of the filtered motion.
#[derive(Clone, Copy)]
struct MotionSample {
    /// Filtered time since the beginning of the motion, s.
    time: f64,
    /// Index of the segment.
    segment: usize,
    /// Filtered feedrate, mm/s.
    filtered: f64,
    /// |u|.
    share: Vector,
    /// |N|, 1/mm.
    curvature: Vector,
    /// v², mm²/s².
    square: f64,
}

/// Acceleration limits, mm/s².
struct AccelerationLimits {
    axes: Vector,
    path: f64,
}

impl AccelerationLimits {
    fn of(machine: &Machine) -> AccelerationLimits {
        let axes = Vector::from_fn(|k, _| machine.axes[k].acceleration);
        AccelerationLimits { axes, path: machine.path.acceleration }
    }

    fn have_axes(&self) -> bool {
        self.axes.iter().any(|axis| axis.is_finite())
    }

    fn are_finite(&self) -> bool {
        self.path.is_finite() || self.have_axes()
    }

    /// Adds to `scaling` the time that the limits cost on a motion.
    fn slow_down(&self, motion: &FilteredMotion, rest_to_rest: &RestToRest, scaling: &mut TimeScaling) {
        let mut samples = self.samples(motion, rest_to_rest);
        // The forward pass bounds the growth of the speed by the limits, the backward pass its decrease.
        for i in 1..samples.len() {
            samples[i].square = samples[i].square.min(self.reach(&samples[i - 1], &samples[i]));
        }
        for i in (1..samples.len()).rev() {
            samples[i - 1].square = samples[i - 1].square.min(self.reach(&samples[i], &samples[i - 1]));
        }
        if samples.iter().all(MotionSample::is_free) {
            return;
        }
        let between = samples
            .windows(2)
            .flat_map(|pair| self.turning_points(&pair[0], &pair[1]).into_iter().flatten().chain([pair[1]]));
        let samples: Vec<MotionSample> = [samples[0]].into_iter().chain(between).collect();
        let losses: Vec<f64> = samples.windows(2).map(|pair| pair[0].lost_until(&pair[1])).collect();
        let of_segments = samples.iter().map(|sample| sample.segment).zip(losses.iter().copied());
        let slowed: Vec<(usize, f64)> = of_segments.filter(|(_, loss)| *loss != 0.0).collect();
        let sum = |own: &[(usize, f64)]| running_sum(own.iter().map(|(_, loss)| *loss)).last().unwrap_or(0.0);
        let by_segment = slowed.chunk_by(|a, b| a.0 == b.0);
        let segments: Vec<(usize, f64)> = by_segment.map(|own| (own[0].0, sum(own))).collect();
        let mut knots: Vec<Knot> = Vec::with_capacity(samples.len());
        let losts = [0.0].into_iter().chain(running_sum(losses.into_iter()));
        for (i, (sample, lost)) in samples.iter().zip(losts).enumerate() {
            let around = &samples[i.saturating_sub(1)..samples.len().min(i + 2)];
            // Only the ends of a part that follows the filters are kept.
            if around.len() < 3 || !around.iter().all(MotionSample::is_free) {
                knots.push(sample.knot(lost));
            }
        }
        scaling.push(rest_to_rest, &knots, &segments);
    }

    /// Returns samples of the filtered motion.
    fn samples(&self, motion: &FilteredMotion, rest_to_rest: &RestToRest) -> Vec<MotionSample> {
        let end = motion.duration();
        let mut samples: Vec<MotionSample> = Vec::new();
        let (mut time, mut segment) = (0.0, rest_to_rest.segments.start);
        let mut before = Vector::zeros();
        let mut cursor = MotionCursor::of(*motion);
        let mut moment = cursor.moment(time);
        loop {
            let state = cursor.state(moment);
            while segment + 1 < rest_to_rest.segments.end
                && cursor.distances.before(segment + 1) <= state.distance
            {
                segment += 1;
            }
            let filtered = state.velocity.norm();
            let (mut share, mut curvature) = (Vector::zeros(), Vector::zeros());
            if 0.0 < filtered {
                let tangent = state.velocity / filtered;
                share = tangent.abs();
                if self.have_axes() {
                    let acceleration = motion.acceleration(moment);
                    let across = acceleration - acceleration.dot(&tangent) * tangent;
                    curvature = across.abs() / (filtered * filtered);
                }
            }
            if before.dot(&state.velocity) < REVERSAL_COSINE * before.norm() * filtered
                && let Some(last) = samples.last()
            {
                // A motion that turns back is at rest there.
                let stand = last.time + (time - last.time) * before.norm() / (before.norm() + filtered);
                if last.time < stand && stand < time {
                    samples.push(MotionSample { time: stand, filtered: 0.0, square: 0.0, ..*last });
                }
            }
            before = state.velocity;
            let square = self.around_curves(&curvature).min(filtered * filtered);
            samples.push(MotionSample { time, segment, filtered, share, curvature, square });
            if end <= time {
                return samples;
            }
            time = next_time(&mut cursor, moment, time).min(end);
            moment = cursor.moment_from(moment.pulse, time);
        }
    }

    /// Returns the largest squared feedrate at which turning alone keeps each axis within its limit, mm²/s².
    fn around_curves(&self, curvature: &Vector) -> f64 {
        let of_axis = |k: usize| self.axes[k] / curvature[k];
        (0..3).filter(|&k| 0.0 < curvature[k]).map(of_axis).fold(f64::INFINITY, f64::min)
    }

    /// Returns the largest slope of the feedrate at a sample run at the squared feedrate `square`, mm/s².
    fn available(&self, sample: &MotionSample, square: f64) -> f64 {
        let of_axis = |k: usize| (self.axes[k] - square * sample.curvature[k]).max(0.0) / sample.share[k];
        (0..3).filter(|&k| 0.0 < sample.share[k]).map(of_axis).fold(self.path, f64::min)
    }

    /// Returns the largest squared feedrate at `to` that is reached from that at `from`, mm²/s².
    fn reach(&self, from: &MotionSample, to: &MotionSample) -> f64 {
        let doubled = 2.0 * from.distance(to);
        if doubled == 0.0 {
            return from.square;
        }
        let of_axis = |k: usize| {
            let (share, curvature) = (to.share[k], doubled * to.curvature[k]);
            (share * from.square + doubled * self.axes[k]) / (share + curvature)
        };
        let by_axes = (0..3).map(of_axis).fold(f64::INFINITY, f64::min);
        by_axes.min(from.square + doubled * self.available(from, from.square))
    }

    /// Returns the samples to insert between two samples of a constant filtered motion: where one ramp ends
    /// and the other begins, or where both meet.
    fn turning_points(&self, from: &MotionSample, to: &MotionSample) -> [Option<MotionSample>; 2] {
        let full = from.filtered * from.filtered;
        let is_constant = (to.filtered / from.filtered - 1.0).abs() <= 1e-9;
        if !is_constant || (from.is_free() && to.is_free()) {
            return [None; 2];
        }
        let doubled_slope = 2.0 * self.available(from, full).min(self.available(to, full));
        let length = from.distance(to);
        let at = |distance: f64, square: f64| {
            let is_inside = 0.0 < distance && distance < length;
            // By the share of the length, since the filtered feedrate is constant to some 10⁻⁹ only.
            let time = from.time + distance / length * (to.time - from.time);
            is_inside.then_some(MotionSample { time, square: square.min(full), ..*from })
        };
        let (rise, fall) = ((full - from.square) / doubled_slope, (full - to.square) / doubled_slope);
        if rise + fall < length {
            [at(rise, full), at(length - fall, full)]
        } else {
            let distance = 0.5 * (length + (to.square - from.square) / doubled_slope);
            [at(distance, from.square + doubled_slope * distance), None]
        }
    }
}

impl MotionSample {
    /// Returns `true` if the machine follows the filters at this sample.
    fn is_free(&self) -> bool {
        self.filtered * self.filtered * (1.0 - FREE_FEEDRATE_RATIO) <= self.square
    }

    fn feedrate(&self) -> f64 {
        if self.is_free() { self.filtered } else { self.square.sqrt() }
    }

    /// Returns Δσ, mm.
    fn distance(&self, to: &MotionSample) -> f64 {
        0.5 * (self.filtered + to.filtered) * (to.time - self.time).abs()
    }

    /// Returns the time that the limits cost from this sample to the next, s.
    fn lost_until(&self, next: &MotionSample) -> f64 {
        if self.is_free() && next.is_free() {
            return 0.0;
        }
        let sum = self.feedrate() + next.feedrate();
        if sum == 0.0 {
            return 0.0;
        }
        (next.time - self.time) * ((self.filtered + next.filtered) / sum - 1.0)
    }

    fn knot(&self, lost: f64) -> Knot {
        Knot { filtered: self.time, lost, filtered_feedrate: self.filtered, feedrate: self.feedrate() }
    }
}

impl FilteredMotion<'_> {
    /// Returns the true time at a filtered time, both since the beginning of the motion, s.
    pub(super) fn true_time(&self, filtered: f64) -> f64 {
        time_scaling::true_time(self.knots, filtered)
    }

    /// Returns acceleration and jerk at a true time since the beginning of the motion, s. On a path with the
    /// direction u and its derivatives N and N′ by length the acceleration is v̇ u + v² N, and the jerk its
    /// derivative.
    pub(super) fn dynamics_at(&self, time: f64) -> Dynamics {
        let pace = time_scaling::filtered_time(self.knots, time);
        let moment = self.moment(pace.filtered);
        let filtered = self.dynamics(moment);
        let Some((feedrate, slope)) = pace.feedrate else { return filtered };
        let velocity = self.state(moment).velocity;
        let speed = velocity.norm();
        if speed == 0.0 {
            return filtered;
        }
        let tangent = velocity / speed;
        let along = filtered.acceleration.dot(&tangent);
        let normal = (filtered.acceleration - along * tangent) / (speed * speed);
        let change = filtered.jerk.dot(&tangent) + speed.powi(3) * normal.norm_squared();
        let normal_change = (filtered.jerk - change * tangent - 3.0 * along * speed * normal) / speed.powi(3);
        Dynamics {
            acceleration: slope * tangent + feedrate * feedrate * normal,
            jerk: 3.0 * slope * feedrate * normal + feedrate.powi(3) * normal_change,
        }
    }
}

impl MotionCursor<'_> {
    /// Returns position and velocity of the tool at a true time since the beginning of the motion, s.
    pub(super) fn state_at(&mut self, time: f64) -> MotionState {
        let pace = time_scaling::filtered_time(self.motion.knots, time);
        let moment = self.moment(pace.filtered);
        let mut state = self.state(moment);
        let filtered = state.velocity.norm();
        if let Some((feedrate, _)) = pace.feedrate
            && 0.0 < filtered
        {
            state.velocity *= feedrate / filtered;
        }
        state
    }
}

/// Returns the time of the sample after the one at a moment, s.
fn next_time(cursor: &mut MotionCursor, moment: Moment, time: f64) -> f64 {
    let motion = cursor.motion;
    let delay = motion.filter.delay();
    let shortest = motion.filter.time_constants().iter().copied().fold(delay, f64::min);
    let (fewest, most) = (SAMPLES_PER_DELAY, MAX_SAMPLES_PER_DELAY);
    let step = time + (shortest / SAMPLES_PER_FILTER).clamp(delay / most, delay / fewest);
    let pulse = motion.pulses.at(moment.pulse);
    if moment.elapsed < delay {
        return step;
    }
    let segment = motion.segments.at(pulse.segment as usize);
    let [first, last] = pulse.feedrate;
    let widest = match &segment.curve {
        Curve::Line => f64::INFINITY,
        Curve::Arc(arc) => MAX_SAMPLE_ANGLE_RAD * segment.length / (arc.sweep * first.max(last)),
    };
    let widest = if first == last { widest } else { widest.min(pulse.duration / SAMPLES_PER_SLOPE) };
    step.max((cursor.pulse_start(moment.pulse) + pulse.duration).min(time + widest))
}
