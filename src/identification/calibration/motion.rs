//! The parameters of motion that a calibration frees, by the family of the control.
//!
//! | family | parameters |
//! |---|---|
//! | filters | time constants, contour tolerance, and of the laws taken in theirs |
//! | acceleration blends | accelerations of axes, velocities of those that were held back, contour tolerance |
//! | junction deviations | accelerations of axes, velocities of those that were held back, the deviation |
//! | square-corner velocities | accelerations and velocities of the path and Z, the velocity at corners, minimum cruise ratio |
//! | steps of velocity | the step, slowing angle, wait for position, path acceleration |
//!
//! Planners without filters also free the jerks of axes, and all families the jerk along the path, the centripetal
//! acceleration and the parameters of rapids, unless these have their neutral values. A velocity that limits feed and rapids of an axis alike is one parameter, the rapid rate.
//! The value before the calibration is infinite if the machine had no such limit.

use crate::identification::calibration::Estimate;
use crate::identification::calibration::rapids::{RapidPlateaus, is_limited_as_rapids};
use crate::identification::effects::parameters::{self, Adjustable};
use crate::identification::fit::{FreeParameter, Run};
use crate::machine::{FREE_BLEND_MM, Machine, TimeConstants};

/// Largest relative standard deviation of an acceleration that a machine file states: with a larger one the value is unknown.
const MAX_DEVIATION_RATIO: f64 = 1.0;

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
    // From what the guess has under this key; a limit that is none, and a time of 0, is not there.
    let limit = |parameter: Adjustable| {
        let of = |machine: &Machine| parameter.handle().get(machine).filter(|value| 0.0 < *value);
        Some((parameter.calibrated(of(guess)?), of(before).unwrap_or(f64::INFINITY)))
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
        for (axis, parameter) in parameters::AXIS_ACCELERATION.into_iter().enumerate() {
            let [own, start] = [before, guess].map(|machine| machine.axes[axis].acceleration);
            let usual = if own.is_finite() { own } else { start };
            if start.is_finite() {
                all.push((parameter.calibrated_around(start, usual), own));
            }
        }
        all.extend(parameters::AXIS_JERK.into_iter().filter_map(limit));
        let own = (0..3).filter(|axis| !is_limited_as_rapids(guess, *axis, plateaus));
        all.extend(own.filter_map(|axis| limit(parameters::AXIS_VELOCITY[axis])));
        all.extend(limit(parameters::PATH_VELOCITY));
    } else if let Some((own, start)) = constant(constants).zip(constant(&guess.interpolator.time_constants)) {
        all.push((parameters::TIME_CONSTANT.calibrated(start), own * as_order));
    }
    let junctions =
        [parameters::AXIS_VELOCITY_STEP, parameters::JUNCTION_DEVIATION, parameters::SQUARE_CORNER_VELOCITY];
    all.extend(junctions.into_iter().filter_map(limit));
    all.extend(cruise_ratio(before, guess));
    let is_blended = guess.interpolator.junction.blends_in_time();
    if has_filters || is_blended {
        let tolerance = limit(parameters::CONTOUR_TOLERANCE);
        // What holds where a program sets none is another thing to a planner that blends freely then.
        let is_other = is_blended && !before.interpolator.junction.blends_in_time();
        all.extend(tolerance.map(|(freed, own)| (freed, if is_other { FREE_BLEND_MM } else { own })));
    }
    all.extend(limit(parameters::SLOWING_ANGLE));
    if !has_filters {
        all.extend(limit(parameters::IN_POSITION_WAIT));
    }
    all.extend(limit(parameters::CENTRIPETAL_ACCELERATION).or_else(|| limit(parameters::ARC_TOLERANCE)));
    let has_rapid = runs.iter().any(Run::has_rapid);
    // Along the path filters hide an acceleration but in rapids.
    if has_rapid || !has_filters {
        all.extend(limit(parameters::PATH_ACCELERATION));
    }
    all.extend(limit(parameters::PATH_JERK));
    if has_rapid {
        all.extend(rapid_rates(before, guess, plateaus.filter(|_| !has_filters)));
        let own = before.rapid.time_constants.as_ref().unwrap_or(constants);
        let start = guess.rapid.time_constants.as_ref().and_then(constant);
        if let Some((own, start)) = constant(own).zip(start).filter(|_| has_filters) {
            all.push((parameters::RAPID_TIME_CONSTANT.calibrated(start), own * as_order));
        }
        all.extend(limit(parameters::POSITIONING_JERK));
    }
    all
}

/// Returns the rates of rapids, along the path or of axes; if there are `plateaus`, only those that they show.
fn rapid_rates(
    before: &Machine,
    guess: &Machine,
    plateaus: Option<RapidPlateaus>,
) -> Vec<(FreeParameter, f64)> {
    let mut all = Vec::new();
    if guess.rapid.feedrate.is_finite() && plateaus.is_none_or(|seen| seen.rates(guess).path.is_some()) {
        let own = before.fastest_rapid();
        all.push((parameters::RAPID_FEEDRATE.calibrated_around(guess.rapid.feedrate, own), own));
    }
    for (axis, parameter) in parameters::AXIS_RAPID.into_iter().enumerate() {
        let start = guess.axes[axis].rapid;
        if start.is_finite() && plateaus.is_none_or(|seen| seen.rates(guess).axes[axis].is_some()) {
            // A machine file that has no rapids of axes has that of all of them.
            let own = before.axes[axis].rapid.min(before.rapid.feedrate);
            let mut rapid = parameter.calibrated_around(start, own);
            if is_limited_as_rapids(guess, axis, plateaus) {
                rapid = rapid.also(move |machine| machine.axes[axis].velocity = machine.axes[axis].rapid);
            }
            all.push((rapid, own));
        }
    }
    all
}

/// Returns the minimum cruise ratio, with its value in `before`; `None` if the family has none.
fn cruise_ratio(before: &Machine, guess: &Machine) -> Option<(FreeParameter, f64)> {
    let (own, start) = (before.interpolator.minimum_cruise_ratio, guess.interpolator.minimum_cruise_ratio);
    (0.0 < start).then(|| (parameters::MINIMUM_CRUISE_RATIO.calibrated(start), own))
}

/// Returns the ramp of a spindle that words wait for, with its value in `before`; `None` unless such words are in
/// `guess` and not in `before`.
pub fn spindle_ramp(before: &Machine, guess: &Machine) -> Option<(FreeParameter, f64)> {
    let (own, start) = (before.times.spindle.ramp, guess.times.spindle.ramp);
    let awaited = before.times.spindle_awaited_by.is_empty() && !guess.times.spindle_awaited_by.is_empty();
    awaited.then(|| (parameters::SPINDLE_RAMP.calibrated(start).linear(), own))
}

/// Returns the axis whose acceleration the parameter is; `None` for any other parameter.
pub fn axis_of(freed: &FreeParameter) -> Option<usize> {
    axis_among(parameters::AXIS_ACCELERATION, freed)
}

/// Returns the relative standard deviations of the accelerations of X, Y and Z, at most [`MAX_DEVIATION_RATIO`]: 0 for an unknown
/// one, `None` if all are unknown. The deviation along the path replaces the missing one of an axis.
pub fn acceleration_deviations(estimates: &[Estimate]) -> Option<[f64; 3]> {
    let of = |parameter: Adjustable| {
        let estimate = estimates.iter().find(|estimate| estimate.key == parameter.key)?;
        estimate.deviation.map(|deviation| (deviation / estimate.value).min(MAX_DEVIATION_RATIO))
    };
    let along_path = of(parameters::PATH_ACCELERATION);
    let of_axes = parameters::AXIS_ACCELERATION.map(|parameter| of(parameter).or(along_path));
    of_axes.iter().any(Option::is_some).then(|| of_axes.map(Option::unwrap_or_default))
}

/// Returns the axis whose rapid rate the parameter is; `None` for any other parameter.
pub fn rapid_axis_of(freed: &FreeParameter) -> Option<usize> {
    axis_among(parameters::AXIS_RAPID, freed)
}

/// Returns the axis whose limit among these the parameter is; `None` for any other parameter.
pub fn axis_among(parameters: [Adjustable; 3], freed: &FreeParameter) -> Option<usize> {
    let key = freed.handle.key();
    parameters.iter().position(|own| own.key == key)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identification::calibration::ParameterVerdict;

    /// A planner whose ramps a jerk limits reaches its acceleration nowhere, so a fit hardly depends on that.
    #[test]
    fn a_machine_file_states_no_deviation_above_the_acceleration() {
        let along_path = |deviation: f64| Estimate {
            key: parameters::PATH_ACCELERATION.key.to_string(),
            before: f64::INFINITY,
            value: 900.0,
            deviation: Some(deviation),
            verdict: ParameterVerdict::Fitted,
        };
        assert_eq!(acceleration_deviations(&[along_path(9.0)]), Some([0.01; 3]));
        assert_eq!(acceleration_deviations(&[along_path(1.3e6)]), Some([1.0; 3]));
    }
}
