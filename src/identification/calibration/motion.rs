//! The parameters of motion that a calibration frees, by the family of the control.
//!
//! | family | parameters |
//! |---|---|
//! | filters | time constants, contour tolerance, and of the laws taken in theirs |
//! | acceleration blends | accelerations of axes, contour tolerance |
//! | steps of velocity | the step, slowing angle, wait for position, path acceleration |
//!
//! Jerk along the path, centripetal acceleration and what rapids are run by are freed in all of them, where they are not
//! neutral. What the machine had before is infinite where it had no such limit.

use crate::identification::calibration::laws::has_filters;
use crate::identification::fit::{Freed, Run, Scale};
use crate::machine::{Junction, Machine, TimeConstants};

/// The key of the acceleration of each axis.
const ACCELERATIONS: [&str; 3] =
    ["axis.x.acceleration_mm_s2", "axis.y.acceleration_mm_s2", "axis.z.acceleration_mm_s2"];

/// How far, as a ratio, they may be from what they are in the machine file, or are guessed to be.
const AXIS_BOUNDS: (f64, f64) = (0.05, 20.0);
/// Least and largest time constant, s, and tolerance, mm.
const CONSTANT_BOUNDS: (f64, f64) = (5e-4, 0.5);
const TOLERANCE_BOUNDS: (f64, f64) = (2e-4, 1.0);
/// Least and largest jerk of positioning and along the path, mm/s³, and acceleration, mm/s².
const POSITIONING_BOUNDS: (f64, f64) = (5e3, 5e6);
const JERK_BOUNDS: (f64, f64) = (1e3, 1e6);
const ACCELERATION_BOUNDS: (f64, f64) = (10.0, 1e5);
/// Least and largest step of velocity, mm/s, slowing angle, rad, and wait for position, s.
const STEP_BOUNDS: (f64, f64) = (0.1, 1e3);
const ANGLE_BOUNDS: (f64, f64) = (0.05, 3.0);
const POSITION_BOUNDS: (f64, f64) = (1e-4, 0.5);

/// The parameters of motion of the family of `guess`, each with the value it has `before`.
pub fn motion(before: &Machine, guess: &Machine, order: usize, runs: &[Run]) -> Vec<(Freed, f64)> {
    let mut all = Vec::new();
    let mut add = |key: &'static str, before: f64, start: f64, bounds: (f64, f64)| {
        all.extend(Freed::number(key, start, bounds, Scale::Ratio).map(|freed| (freed, before)));
    };
    let has_filters = has_filters(guess);
    let (own, start) = (&before.interpolator, &guess.interpolator);
    let constant = |of: &TimeConstants| match of {
        TimeConstants::Equal(constant) => Some(*constant),
        _ => None,
    };
    // The same delay in all with another order.
    let as_order = own.filters as f64 / order as f64;
    if !has_filters {
        for (key, (own, start)) in ACCELERATIONS.into_iter().zip(before.axes.iter().zip(&guess.axes)) {
            let (own, start) = (own.acceleration, start.acceleration);
            let usual = if own.is_finite() { own } else { start };
            if start.is_finite() {
                add(key, own, start, (AXIS_BOUNDS.0 * usual, AXIS_BOUNDS.1 * usual));
            }
        }
    } else if let Some((own, start)) = constant(&own.time_constants).zip(constant(&start.time_constants)) {
        add("interpolator.time_constant_s", own * as_order, start, CONSTANT_BOUNDS);
    }
    if let Junction::AxisStep(start) = start.junction {
        let own = match own.junction {
            Junction::AxisStep(own) => own,
            _ => f64::INFINITY,
        };
        add("interpolator.axis_velocity_step_mm_min", own, start, STEP_BOUNDS);
    }
    if has_filters || start.junction == Junction::AccelerationBlend {
        let key = "interpolator.contour_tolerance_mm";
        add(key, own.contour_tolerance, start.contour_tolerance, TOLERANCE_BOUNDS);
    }
    if start.slowing_angle.is_finite() {
        add("interpolator.slowing_angle_deg", own.slowing_angle, start.slowing_angle, ANGLE_BOUNDS);
    }
    if 0.0 < guess.halts.in_position && !has_filters {
        let own = if 0.0 < before.halts.in_position { before.halts.in_position } else { f64::INFINITY };
        add("halts.in_position_s", own, guess.halts.in_position, POSITION_BOUNDS);
    }
    if guess.path.centripetal_acceleration.is_finite() {
        let (own, start) = (before.path.centripetal_acceleration, guess.path.centripetal_acceleration);
        add("path.centripetal_acceleration_mm_s2", own, start, ACCELERATION_BOUNDS);
    } else if let Some(start) = start.arc_tolerance {
        let own = own.arc_tolerance.unwrap_or(f64::INFINITY);
        add("interpolator.arc_tolerance_mm", own, start, TOLERANCE_BOUNDS);
    }
    let has_rapid = runs.iter().any(Run::has_rapid);
    // Along the path filters hide an acceleration but in rapids.
    if guess.path.acceleration.is_finite() && (has_rapid || !has_filters) {
        let (own, start) = (before.path.acceleration, guess.path.acceleration);
        add("path.acceleration_mm_s2", own, start, ACCELERATION_BOUNDS);
    }
    if guess.path.jerk.is_finite() {
        add("path.jerk_mm_s3", before.path.jerk, guess.path.jerk, JERK_BOUNDS);
    }
    if has_rapid {
        let (own, start) = (before.rapid.feedrate, guess.rapid.feedrate);
        add("rapid.feed_mm_min", own, start, (0.02 * own, 10.0 * own));
        let own = before.rapid.time_constants.as_ref().unwrap_or(&before.interpolator.time_constants);
        let start = guess.rapid.time_constants.as_ref().and_then(constant);
        if let Some((own, start)) = constant(own).zip(start).filter(|_| has_filters) {
            add("rapid.time_constant_s", own * as_order, start, CONSTANT_BOUNDS);
        }
        if guess.rapid.positioning_jerk.is_finite() {
            let (own, start) = (before.rapid.positioning_jerk, guess.rapid.positioning_jerk);
            add("rapid.positioning_jerk_mm_s3", own, start, POSITIONING_BOUNDS);
        }
    }
    all
}

/// The ramp of a spindle that words wait for, with the value it has before.
pub fn spindle_ramp(before: &Machine, guess: &Machine) -> Option<(Freed, f64)> {
    let (own, start) = (before.times.spindle.ramp, guess.times.spindle.ramp);
    let awaited = before.times.spindle_awaited_by.is_empty() && !guess.times.spindle_awaited_by.is_empty();
    let ramp = awaited
        .then(|| Freed::number("times.spindle_s_per_1000_rpm", start, (0.0, 0.1), Scale::Difference))?;
    ramp.map(|freed| (freed.linear(), own))
}
