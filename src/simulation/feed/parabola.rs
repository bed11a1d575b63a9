//! The parabola of LinuxCNC-like planners at a corner.
//!
//! The second leg starts while the first still brakes to a stop, both with half of their accelerations, a1 and a2, from
//! the velocity b1 on:
//!
//! ```text
//! b1 = min(F1, √(a1 L1), a1 t, 2 √(a1 ε/(D/2)))        t = min(L1/v1, L2/v2, max(v1/a1, v2/a2)),  ε tolerance
//! ```
//!
//! where L is the length of a leg (mm), F its feedrate (mm/s), v the minimum of the first two terms for each leg, and D the
//! change of direction as in `corner_blend`. If the second leg is an arc of radius r, D is the change from u1 to the
//! direction of the acceleration, which is the sum of a2 u2 and (F2/2)²/r towards the centre
//! (`tcCircleStartAccelUnitVector`). Without circles a leg has half of its acceleration only if a parabola follows it, and
//! its whole acceleration if the parabola precedes it.
//!
//! The second leg starts at the beginning of the servo period h in which the first one falls below b1. If all corners
//! are parabolas, the first leg started so as well, at rest, and falls below b1 after the time t1 = L1/F1 + (F1 − b1)/a1:
//! the second leg has the head start e = t1 mod h. In any other motion it is h/2, the mean. The first leg must hold its
//! feedrate for so long, e ≤ L1/F1 − F1/a1: one that only peaks starts the second leg at the period's beginning or end,
//! whichever is nearer.
//!
//! The parabola lasts T = b1/a1 + e and takes b1 (b1/2a1 + e) of the first leg; the second speeds up by a2 to
//! w = min(a2 T, F2). Along the parabola the speed changes from b1 to w with one acceleration, over the length that takes
//! the time T.
//!
//! LinuxCNC compares the speed C (b1 + b2)/4 of a parabola with that of a circle. It computes b1 and b2 at the largest
//! override, and with a peak v ≤ √(a L/2), since the other ends of the legs are not planned yet.
//!
//! Limits: a leg that holds its feedrate for hardly a servo period may start the next one a period later.
//!
//! Source: LinuxCNC 2.9, src/emc/tp/tp.c (tpComputeBlendVelocity, estimateParabolicBlendPerformance, tpUpdateBlend), and
//! recordings of it.

use crate::machine::{Junction, Machine};
use crate::simulation::feed::blend::{Blend, Leg};
use crate::simulation::feed::junction;
use crate::simulation::feed::limits::{self, TANGENTIAL_ACCELERATION_SHARE};
use crate::simulation::toolpath::{Curve, Segment};

/// Servo period of LinuxCNC, h, s.
pub const LINUXCNC_SERVO_PERIOD_S: f64 = 1e-3;
/// Part of the acceleration of each leg that a parabola uses.
pub const PARABOLA_SHARE: f64 = 0.5;
/// Least acceleration along a parabola, as a part of the legs' acceleration.
const MIN_ACCELERATION_RATIO: f64 = 1e-3;

/// A segment on one side of a corner.
#[derive(Clone, Copy)]
pub struct CornerSide<'a> {
    /// The segment.
    pub segment: &'a Segment,
    /// Requested feedrate along it, mm/s.
    pub feedrate: f64,
    /// Acceleration along the segment within a parabola, mm/s²; `None`: half the acceleration of the segment.
    pub whole_acceleration: Option<f64>,
}

/// A leg that ramps from rest and to rest.
#[derive(Clone, Copy)]
struct RampedLeg {
    /// a, mm/s².
    acceleration: f64,
    /// v, mm/s.
    feedrate: f64,
    /// L, mm.
    length: f64,
}

/// Returns the parabola at a corner whose neighbouring blends leave these lengths (mm) of the legs.
pub fn blend(sides: [CornerSide; 2], machine: &Machine, tolerance: f64, lengths: [f64; 2]) -> Blend {
    let leg = |side: usize| {
        let CornerSide { segment, feedrate, whole_acceleration } = sides[side];
        let (acceleration, most) =
            whole_acceleration.map_or_else(|| halved(segment, machine), |whole| (whole, feedrate));
        let (requested, length) = (feedrate.min(most), lengths[side]);
        RampedLeg { acceleration, feedrate: requested.min((acceleration * length).sqrt()), length }
    };
    let legs = [leg(0), leg(1)];
    let [from, _] = reached(legs, sides, machine, tolerance);
    overlapped(legs, from, head_start(legs[0], from, machine), tolerance)
}

/// Returns b1 and b2 at the largest override, mm/s, at which the legs have the feedrates `overridden` (mm/s): LinuxCNC
/// compares a parabola and a circle at that override.
pub fn reached_at_override(
    sides: [CornerSide; 2],
    machine: &Machine,
    tolerance: f64,
    overridden: [f64; 2],
) -> [f64; 2] {
    let leg = |side: usize| {
        let segment = sides[side].segment;
        let (acceleration, _) = halved(segment, machine);
        let peak = (0.5 * acceleration * segment.length).sqrt();
        RampedLeg { acceleration, feedrate: overridden[side].min(peak), length: segment.length }
    };
    reached([leg(0), leg(1)], sides, machine, tolerance)
}

/// Returns a leg of which a parabola takes a part: the leg has half of its acceleration throughout, and an
/// arc also the feedrate that this acceleration allows.
pub fn shared(segment: &Segment, leg: Leg, machine: &Machine) -> Leg {
    let (acceleration, feedrate) = halved(segment, machine);
    Leg { acceleration: leg.acceleration.min(acceleration), feedrate: leg.feedrate.min(feedrate), ..leg }
}

/// Returns the acceleration along an arc behind which no move is queued, mm/s²; half as much if a parabola takes a part.
pub fn unqueued_acceleration(segment: &Segment, has_parabola: bool, machine: &Machine) -> f64 {
    let part = if has_parabola { PARABOLA_SHARE } else { 1.0 };
    part * TANGENTIAL_ACCELERATION_SHARE * limits::blended_acceleration(segment, machine)
}

/// Returns half of the acceleration of a segment, mm/s², and the largest feedrate that this acceleration
/// allows, mm/s.
fn halved(segment: &Segment, machine: &Machine) -> (f64, f64) {
    let own = PARABOLA_SHARE * limits::blended_acceleration(segment, machine);
    (junction::acceleration(segment, own, machine), limits::blended_arc_feedrate(segment, own, machine))
}

/// Returns b1 and b2, mm/s.
fn reached(legs: [RampedLeg; 2], sides: [CornerSide; 2], machine: &Machine, tolerance: f64) -> [f64; 2] {
    let whole = legs.map(|leg| leg.length / leg.feedrate);
    let ramps = legs.map(|leg| leg.feedrate / leg.acceleration);
    let lasts = whole[0].min(whole[1]).min(ramps[0].max(ramps[1]));
    let by_tolerance = 2.0 * (legs[0].acceleration * tolerance / half_change(sides, machine)).sqrt();
    legs.map(|leg| leg.feedrate.min(lasts * leg.acceleration).min(by_tolerance))
}

/// Returns D/2: half the length of the change from the direction in which the first leg brakes to that in which the second
/// speeds up.
fn half_change([before, after]: [CornerSide; 2], machine: &Machine) -> f64 {
    let (u1, u2) = (before.segment.tangent(before.segment.length), after.segment.tangent(0.0));
    let Curve::Arc(arc) = &after.segment.curve else { return 0.5 * (u2 - u1).norm() };
    let along = PARABOLA_SHARE * limits::blended_acceleration(after.segment, machine);
    let towards_center = -arc.e1 * (0.5 * after.feedrate).powi(2) / arc.start_radius;
    0.5 * ((along * u2 + towards_center).normalize() - u1).norm()
}

/// Returns e, s: the second leg starts this long before the first one falls below the velocity `from`.
fn head_start(first: RampedLeg, from: f64, machine: &Machine) -> f64 {
    if from == 0.0 {
        return 0.0;
    }
    let RampedLeg { acceleration, feedrate, length } = first;
    let early = match machine.interpolator.junction {
        Junction::ParabolicBlend => {
            (length / feedrate + (feedrate - from) / acceleration).rem_euclid(LINUXCNC_SERVO_PERIOD_S)
        }
        _ => 0.5 * LINUXCNC_SERVO_PERIOD_S,
    };
    early.min((length / feedrate - feedrate / acceleration).max(0.0))
}

/// Returns the blend of two legs. The second leg starts `head_start` (s) before the first one brakes from the velocity
/// `from`.
fn overlapped([first, second]: [RampedLeg; 2], from: f64, head_start: f64, tolerance: f64) -> Blend {
    let (a1, a2) = (first.acceleration, second.acceleration);
    let lasts = from / a1 + head_start;
    let end = (a2 * lasts).min(second.feedrate);
    let distances = [from * (lasts - 0.5 * from / a1), 0.5 * end * (2.0 * lasts - end / a2)];
    let both = distances[0] + distances[1];
    if both == 0.0 {
        return Blend { parabola_within: Some(tolerance), ..Blend::none(0.0) };
    }
    let square = from * from + (end * end - from * from) * distances[0] / both;
    // A second leg that comes to its feedrate while the first still brakes makes both together faster than either.
    let shortening = 0.5 * (from + end) * lasts / both;
    Blend {
        feedrate: square.sqrt(),
        ends: [from, end],
        fastest: from.max(end),
        distances,
        shortening,
        // An acceleration of 0 would leave no room for rounding.
        acceleration: (0.5 * (end * end - from * from).abs() / (shortening * both))
            .max(MIN_ACCELERATION_RATIO * a1.min(a2)),
        taken: 0.0,
        parabola_within: Some(tolerance),
    }
}
