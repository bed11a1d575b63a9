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
//! The second leg starts at the beginning of the servo period h in which the first one falls below b1. The last leg that
//! started at the beginning of a period did so at a full stop or at the parabola before; if the first leg falls below b1
//! the time t later, the period begins e = t mod h before that. In between, at circles and where legs go straight on, the
//! planner divides a period. A period counts only if the first leg is slower at its end than at its beginning. A leg that
//! holds its feedrate for the time d and brakes from it to b1 in the time r is slower if e ≤ r + (d + h)/2. Nor does a period
//! count in which the leg before the first one still runs: no three legs run at once. Then the second leg starts a period
//! later, with e − h.
//!
//! The first leg then brakes from b = b1 + a1 min(e, r), after it has held that velocity for c = max(e − r, 0). The parabola
//! lasts T = b/a1 + c and takes b (b/2a1 + c) of the first leg; the second speeds up by a2 to w = min(a2 T, F2). Along the
//! parabola the speed changes from b to w with one acceleration, over the length that takes the time T.
//!
//! LinuxCNC takes a parabola if C (b1 + b2)/4 exceeds the speed on the circle. It computes b1 and b2 at the largest
//! override, and with a peak v ≤ √(a L/2), since the other ends of the legs are not planned yet.
//!
//! Limits: in a chain of legs that only peak, nearly all of each leg is overlapped, and a corner is up to 0.3 ms off.
//!
//! Source: LinuxCNC 2.9, src/emc/tp/tp.c (tpComputeBlendVelocity, estimateParabolicBlendPerformance, tpUpdateBlend), and
//! recordings of it.

use crate::machine::Machine;
use crate::simulation::feed::Pulse;
use crate::simulation::feed::blend::{Blend, Leg, Parabola, blended_lengths};
use crate::simulation::feed::junction;
use crate::simulation::feed::limits::{self, TANGENTIAL_ACCELERATION_SHARE};
use crate::simulation::toolpath::{Curve, Segment};

/// Servo period of LinuxCNC, h, s.
pub const LINUXCNC_SERVO_PERIOD_S: f64 = 1e-3;
/// Part of the acceleration of each leg that a parabola uses.
pub const PARABOLA_SHARE: f64 = 0.5;
/// Largest rounding of the place where a pulse begins, mm.
const MAX_ROUNDING_MM: f64 = 1e-9;
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

/// Returns the parabola at a corner whose neighbouring blends leave these lengths (mm) of the legs, if the
/// servo period begins `early` (s) before the first leg falls below b1.
pub fn blend(
    sides: [CornerSide; 2],
    machine: &Machine,
    tolerance: f64,
    lengths: [f64; 2],
    early: f64,
) -> Blend {
    let leg = |side: usize| {
        let CornerSide { segment, feedrate, whole_acceleration } = sides[side];
        let (acceleration, most) =
            whole_acceleration.map_or_else(|| halved(segment, machine), |whole| (whole, feedrate));
        let (requested, length) = (feedrate.min(most), lengths[side]);
        RampedLeg { acceleration, feedrate: requested.min((acceleration * length).sqrt()), length }
    };
    let legs = [leg(0), leg(1)];
    let [from, _] = reached(legs, sides, machine, tolerance);
    overlapped(legs, from, early, tolerance)
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

/// Returns e, s, for each corner of a motion; 0 where there is no parabola. `pulses` and `speeds` (mm/s, at the corners) are
/// those of parabolas with e = 0; `first` is the index of the first leg in the toolpath, and `length` returns the length of
/// a leg, mm.
pub fn times_in_period(
    blends: &[Blend],
    pulses: &[Pulse],
    speeds: &[f64],
    first: usize,
    length: impl Fn(usize) -> f64,
) -> Vec<f64> {
    let mut pulses = pulses.iter().peekable();
    let mut time = 0.0;
    // When a leg last started at the beginning of a period, and how long the leg before it still ran.
    let (mut started, mut still_ran) = (0.0, 0.0);
    let mut in_period = vec![0.0; blends.len()];
    for corner in 1..blends.len() - 1 {
        let leg = corner - 1;
        let [_, end] = blended_lengths(length(leg), &blends[leg], &blends[corner]);
        let (begin, mut begins) = (length(leg) - end, None);
        while let Some(pulse) = pulses.next_if(|pulse| (pulse.segment as usize) < first + corner) {
            if begin <= pulse.offset + MAX_ROUNDING_MM {
                begins.get_or_insert(time);
            }
            time += pulse.duration;
        }
        if let Some(Parabola { holding, braking, stopping, .. }) = blends[corner].parabola {
            let falls_below = begins.unwrap_or(time);
            let lasted = falls_below - started;
            let early = lasted.rem_euclid(LINUXCNC_SERVO_PERIOD_S);
            let is_faster_at_its_end = braking + 0.5 * (holding + LINUXCNC_SERVO_PERIOD_S) < early;
            let would_be_third = lasted - early < still_ran;
            let counts = !is_faster_at_its_end && !would_be_third;
            in_period[corner] = if counts { early } else { early - LINUXCNC_SERVO_PERIOD_S };
            (started, still_ran) = (falls_below, stopping + in_period[corner]);
        } else if speeds[leg] == 0.0 {
            (started, still_ran) = (time, 0.0);
        }
    }
    in_period
}

/// Returns the blend of two legs. The second leg starts `early` (s) before the first one falls below the velocity `below`
/// (mm/s).
fn overlapped([first, second]: [RampedLeg; 2], below: f64, early: f64, tolerance: f64) -> Blend {
    let (a1, a2) = (first.acceleration, second.acceleration);
    let parabola = Parabola {
        tolerance,
        holding: (first.length / first.feedrate - first.feedrate / a1).max(0.0),
        braking: (first.feedrate - below) / a1,
        stopping: below / a1,
    };
    let from = if 0.0 < below { (below + a1 * early.min(parabola.braking)).max(0.0) } else { 0.0 };
    if from == 0.0 {
        return Blend { parabola: Some(parabola), ..Blend::none(0.0) };
    }
    let lasts = from / a1 + (early - parabola.braking).max(0.0);
    let end = (a2 * lasts).min(second.feedrate);
    let distances = [from * (lasts - 0.5 * from / a1), 0.5 * end * (2.0 * lasts - end / a2)];
    let both = distances[0] + distances[1];
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
        parabola: Some(parabola),
    }
}
