//! The parameters of motion that a calibration frees, by the family of the control.
//!
//! | family | parameters |
//! |---|---|
//! | filters | time constants, contour tolerance, and of the laws taken in theirs |
//! | acceleration blends | accelerations of axes, velocities of those that were held back, contour tolerance |
//! | junction deviations | accelerations of axes, the deviation |
//! | square-corner velocities | accelerations of path and axes, the velocity, minimum cruise ratio |
//! | steps of velocity | the step, slowing angle, wait for position, path acceleration |
//!
//! All families free the jerk along the path, the centripetal acceleration and the parameters of rapids, unless these
//! have their neutral values. The value before the calibration is infinite if the machine had no such limit.

use crate::identification::calibration::rapids::RapidPlateaus;
use crate::identification::fit::{FreeParameter, Run, VariationScale};
use crate::machine::{FREE_BLEND_MM, Handle, Machine, TimeConstants};

/// Keys of the accelerations of the axes.
pub const ACCELERATIONS: [&str; 3] =
    ["axis.x.acceleration_mm_s2", "axis.y.acceleration_mm_s2", "axis.z.acceleration_mm_s2"];

/// Keys of the velocities of the axes.
const VELOCITIES: [&str; 3] = ["axis.x.velocity_mm_min", "axis.y.velocity_mm_min", "axis.z.velocity_mm_min"];

/// Keys of the rapid rates of the axes.
pub const RAPIDS: [&str; 3] = ["axis.x.rapid_mm_min", "axis.y.rapid_mm_min", "axis.z.rapid_mm_min"];

/// Bounds of a limit of an axis, as ratios to its value in the machine file or to its guess.
const AXIS_BOUNDS: (f64, f64) = (0.05, 20.0);
/// Bounds of a time constant, s.
const CONSTANT_BOUNDS: (f64, f64) = (5e-4, 0.5);
/// Bounds of a tolerance, mm.
const TOLERANCE_BOUNDS: (f64, f64) = (2e-4, 10.0);
/// Bounds of the jerk of positioning, mm/s³.
const POSITIONING_BOUNDS: (f64, f64) = (5e3, 5e6);
/// Bounds of the jerk along the path, mm/s³.
const JERK_BOUNDS: (f64, f64) = (1e3, 1e6);
/// Bounds of an acceleration, mm/s².
const ACCELERATION_BOUNDS: (f64, f64) = (10.0, 1e5);
/// Bounds of the junction deviation, mm.
const DEVIATION_BOUNDS: (f64, f64) = (1e-5, 5.0);
/// Bounds of the minimum cruise ratio.
const CRUISE_BOUNDS: (f64, f64) = (0.0, 0.95);
/// Bounds of a step of velocity, mm/s.
const STEP_BOUNDS: (f64, f64) = (0.1, 1e3);
/// Bounds of the slowing angle, rad.
const ANGLE_BOUNDS: (f64, f64) = (0.05, 3.0);
/// Bounds of the wait for position, s.
const POSITION_BOUNDS: (f64, f64) = (1e-4, 0.5);

/// Returns the parameters of motion of the family of `guess`, each with its value in `before`. Planners have the
/// rates of rapids that `plateaus` show.
pub fn motion(
    before: &Machine,
    guess: &Machine,
    order: usize,
    runs: &[Run],
    plateaus: Option<RapidPlateaus>,
) -> Vec<(FreeParameter, f64)> {
    let mut all = Vec::new();
    let from = |key: &'static str, own: f64, start: f64, bounds: (f64, f64)| {
        (FreeParameter::new(Handle::number(key), start, bounds, VariationScale::Ratio), own)
    };
    // From what the guess has under this key; a limit that is none, and a time of 0, is not there.
    let limit = |key: &'static str, bounds: (f64, f64)| {
        let of = |machine: &Machine| Handle::number(key).get(machine).filter(|value| 0.0 < *value);
        Some(from(key, of(before).unwrap_or(f64::INFINITY), of(guess)?, bounds))
    };
    let has_filters = guess.has_filters();
    let constant = |of: &TimeConstants| match of {
        TimeConstants::Equal(constant) => Some(*constant),
        _ => None,
    };
    let constants = &before.interpolator.time_constants;
    // The same delay in all with another order.
    let as_order = before.interpolator.filters as f64 / order as f64;
    if !has_filters {
        for (key, (own, start)) in ACCELERATIONS.into_iter().zip(before.axes.iter().zip(&guess.axes)) {
            let (own, start) = (own.acceleration, start.acceleration);
            let usual = if own.is_finite() { own } else { start };
            all.extend(limit(key, (AXIS_BOUNDS.0 * usual, AXIS_BOUNDS.1 * usual)));
        }
        for (key, axis) in
            VELOCITIES.into_iter().zip(&guess.axes).filter(|(_, axis)| axis.velocity.is_finite())
        {
            all.extend(limit(key, (AXIS_BOUNDS.0 * axis.velocity, AXIS_BOUNDS.1 * axis.velocity)));
        }
    } else if let Some((own, start)) = constant(constants).zip(constant(&guess.interpolator.time_constants)) {
        all.push(from("interpolator.time_constant_s", own * as_order, start, CONSTANT_BOUNDS));
    }
    all.extend(limit("interpolator.axis_velocity_step_mm_min", STEP_BOUNDS));
    all.extend(limit("interpolator.junction_deviation_mm", DEVIATION_BOUNDS));
    all.extend(limit("interpolator.square_corner_velocity_mm_min", STEP_BOUNDS));
    all.extend(cruise_ratio(before, guess));
    let is_blended = guess.interpolator.junction.blends_in_time();
    if has_filters || is_blended {
        let tolerance = limit("interpolator.contour_tolerance_mm", TOLERANCE_BOUNDS);
        // What holds where a program sets none is another thing to a planner that blends freely then.
        let is_other = is_blended && !before.interpolator.junction.blends_in_time();
        all.extend(tolerance.map(|(freed, own)| (freed, if is_other { FREE_BLEND_MM } else { own })));
    }
    all.extend(limit("interpolator.slowing_angle_deg", ANGLE_BOUNDS));
    if !has_filters {
        let wait = limit("halts.in_position_s", POSITION_BOUNDS);
        all.extend(wait.map(|(freed, own)| (freed.counted_in_cycles(), own)));
    }
    let of_arcs = limit("path.centripetal_acceleration_mm_s2", ACCELERATION_BOUNDS);
    all.extend(of_arcs.or_else(|| limit("interpolator.arc_tolerance_mm", TOLERANCE_BOUNDS)));
    let has_rapid = runs.iter().any(Run::has_rapid);
    // Along the path filters hide an acceleration but in rapids.
    if has_rapid || !has_filters {
        all.extend(limit("path.acceleration_mm_s2", ACCELERATION_BOUNDS));
    }
    all.extend(limit("path.jerk_mm_s3", JERK_BOUNDS));
    if has_rapid {
        all.extend(rapid_rates(before, guess, plateaus.filter(|_| !has_filters)));
        let own = before.rapid.time_constants.as_ref().unwrap_or(constants);
        let start = guess.rapid.time_constants.as_ref().and_then(constant);
        if let Some((own, start)) = constant(own).zip(start).filter(|_| has_filters) {
            all.push(from("rapid.time_constant_s", own * as_order, start, CONSTANT_BOUNDS));
        }
        all.extend(limit("rapid.positioning_jerk_mm_s3", POSITIONING_BOUNDS));
    }
    all
}

/// Returns the rates of rapids, along the path or of axes; if there are `plateaus`, only those that they show.
fn rapid_rates(
    before: &Machine,
    guess: &Machine,
    plateaus: Option<RapidPlateaus>,
) -> Vec<(FreeParameter, f64)> {
    let from = |key: &str, own: f64, start: f64, bounds: (f64, f64)| {
        (FreeParameter::new(Handle::number(key), start, bounds, VariationScale::Ratio), own)
    };
    let mut all = Vec::new();
    if guess.rapid.feedrate.is_finite() && plateaus.is_none_or(|seen| seen.path.is_some()) {
        let own = before.fastest_rapid();
        all.push(from("rapid.feed_mm_min", own, guess.rapid.feedrate, (0.02 * own, 10.0 * own)));
    }
    for (axis, key) in RAPIDS.into_iter().enumerate() {
        let start = guess.axes[axis].rapid;
        if start.is_finite() && plateaus.is_none_or(|seen| seen.axes[axis].is_some()) {
            // A machine file that has no rapids of axes has that of all of them.
            let own = before.axes[axis].rapid.min(before.rapid.feedrate);
            all.push(from(key, own, start, (AXIS_BOUNDS.0 * own, AXIS_BOUNDS.1 * own)));
        }
    }
    all
}

/// Returns the minimum cruise ratio, with its value in `before`; `None` if the family has none.
fn cruise_ratio(before: &Machine, guess: &Machine) -> Option<(FreeParameter, f64)> {
    let (own, start) = (before.interpolator.minimum_cruise_ratio, guess.interpolator.minimum_cruise_ratio);
    let key = Handle::number("interpolator.minimum_cruise_ratio");
    (0.0 < start).then(|| (FreeParameter::new(key, start, CRUISE_BOUNDS, VariationScale::Difference), own))
}

/// Returns the ramp of a spindle that words wait for, with its value in `before`; `None` unless such words are in
/// `guess` and not in `before`.
pub fn spindle_ramp(before: &Machine, guess: &Machine) -> Option<(FreeParameter, f64)> {
    let (own, start) = (before.times.spindle.ramp, guess.times.spindle.ramp);
    let awaited = before.times.spindle_awaited_by.is_empty() && !guess.times.spindle_awaited_by.is_empty();
    let ramp = Handle::number("times.spindle_s_per_1000_rpm");
    awaited.then(|| (FreeParameter::wait(ramp, start, (0.0, 0.1)).linear(), own))
}

/// Returns the axis whose acceleration the parameter is; `None` for any other parameter.
pub fn axis_of(freed: &FreeParameter) -> Option<usize> {
    let key = freed.handle.key();
    ACCELERATIONS.iter().position(|own| *own == key)
}
