//! Effects of limits on velocity, acceleration and jerk, tried below the values that the programs demand.
//!
//! In a machine file that was fitted without a jerk limit, other values compensate for its absence: the filters are
//! as long as the mean ramp, and the rapids correspondingly slow. The hypotheses of a jerk limit therefore free
//! these values as well.

use crate::identification::effects::effect::{Context, Effect, Hypothesis, ratios};
use crate::identification::effects::parameters::{self, Adjustable};
use crate::identification::effects::report::{
    ACCELERATION, AT, AXIS, CONTOUR_TOLERANCE, JERK, PLANNER, RAPID, TIME_CONSTANT, VELOCITY,
};
use crate::identification::fit::Run;
use crate::machine::{AXES, Junction, Machine, Planner, TimeConstants};
use crate::units::mm_per_min;

/// Jerk limits along the path tried first, mm/s³.
const JERKS_MM_S3: [f64; 5] = [5e3, 1e4, 2e4, 4e4, 1e5];
/// Time constants tried with each of these jerks, as ratios to that of the machine. The contour tolerance has the
/// same ratio, so that corners stay as fast.
const SHORTER_FILTERS: [f64; 2] = [1.0, 0.6];
/// Rapid feedrates tried with each jerk limit of rapids, as ratios to the rapid feedrate of the machine.
const FASTER_RAPIDS: [f64; 2] = [1.0, 2.0];

/// Axes of a limit of all of them, or along the path.
pub const ALL_AXES: &str = "XYZ";
/// Rarity of a velocity limit along the path: an operator sets one for every twenty changes of an override (2 ln 20).
const PATH_VELOCITY_RARITY: f64 = 6.0;

/// Returns the axes that the programs move and that the control limits each: Klipper limits the path, and of the axes only
/// Z (max_velocity, max_z_velocity, max_accel, max_z_accel).
fn limited(context: &Context) -> impl Iterator<Item = usize> {
    let first = match context.machine.interpolator.junction {
        Junction::SquareCorner(_) => 2,
        _ => 0,
    };
    (first..3).filter(|axis| 0.0 < context.axis_feedrate[*axis])
}

/// Returns the hypotheses of an acceleration limit of each axis that moves and, if the tolerance limits the
/// feedrate at corners, of a planner, a control of another family that ramps by one acceleration of all axes.
pub fn axis_accelerations(effect: Effect, context: &Context) -> Vec<Hypothesis> {
    let of_axis = |axis: usize| accelerations(effect, parameters::AXIS_ACCELERATION[axis], Some(AXES[axis]));
    let mut all: Vec<Hypothesis> = limited(context).flat_map(of_axis).collect();
    if context.machine.interpolator.junction == Junction::Tolerance {
        all.extend([planner(effect, true), planner(effect, false)]);
    }
    all
}

/// Returns the hypothesis of a control of another family, without filters, which ramps in trapezoids within the
/// acceleration of the axes. Rapids are limited by each axis with `by_axis`, else along the path.
fn planner(effect: Effect, by_axis: bool) -> Hypothesis {
    let freed = parameters::PLANNER_ACCELERATION.tried().with(move |machine, value| {
        machine.become_planner(Planner::AccelerationBlend, value);
        if by_axis {
            machine.axes.iter_mut().for_each(|axis| axis.rapid = axis.rapid.min(machine.rapid.feedrate));
            machine.rapid.feedrate = f64::INFINITY;
        }
    });
    let variant =
        if by_axis { "planner of trapezoids" } else { "planner of trapezoids, rapid along the path" };
    let report =
        |value| vec![AXIS.word(ALL_AXES), ACCELERATION.number(value), PLANNER.word("acceleration_blend")];
    Hypothesis::single(effect, freed, ratios(50.0, 2e4, 14), report).variant(variant)
}

pub fn path_acceleration(effect: Effect, _: &Context) -> Vec<Hypothesis> {
    accelerations(effect, parameters::PATH_ACCELERATION, None)
}

/// Returns two hypotheses of an acceleration limit: on the motion that leaves the filters, and on the command
/// before them.
fn accelerations(effect: Effect, parameter: Adjustable, axis: Option<char>) -> Vec<Hypothesis> {
    let of = |is_before: bool| {
        let freed = parameter.tried().also(move |machine| machine.path.limits_command |= is_before);
        let report = move |value| {
            let place = is_before.then(|| AT.word("command"));
            [axis.map(|axis| AXIS.word(axis)), Some(ACCELERATION.number(value)), place]
                .into_iter()
                .flatten()
                .collect()
        };
        let before = is_before.then(|| "before the filters".to_string());
        let variant: Vec<String> = axis.map(String::from).into_iter().chain(before).collect();
        Hypothesis::single(effect, freed, ratios(50.0, 2e4, 10), report).variant(variant.join(", "))
    };
    vec![of(false), of(true)]
}

/// Returns the hypotheses of a velocity limit of each axis that moves, and of one along the path.
pub fn axis_velocities(effect: Effect, context: &Context) -> Vec<Hypothesis> {
    let of = |parameter: Adjustable, fastest: f64, axes: &str| {
        let freed = parameter.tried_around(fastest);
        let word = AXIS.word(axes);
        let report = move |value| vec![word.clone(), VELOCITY.number(mm_per_min(value))];
        Hypothesis::single(effect, freed, ratios(0.02 * fastest, 0.97 * fastest, 14), report).variant(axes)
    };
    let of_axis = |axis: usize| {
        of(parameters::AXIS_VELOCITY[axis], context.axis_feedrate[axis], &AXES[axis].to_string())
    };
    let along_path = of(parameters::PATH_VELOCITY, context.feedrate, ALL_AXES);
    limited(context).map(of_axis).chain([along_path.with_rarity(PATH_VELOCITY_RARITY)]).collect()
}

pub fn centripetal_acceleration(effect: Effect, context: &Context) -> Vec<Hypothesis> {
    if !context.has_arc {
        return Vec::new();
    }
    let freed = parameters::CENTRIPETAL_ACCELERATION.tried();
    // Arcs are as slow as their root: one that makes them 10 % slower must not lie between two that are worse than
    // none.
    let trials = ratios(10.0, 5e3, 32);
    vec![Hypothesis::single(effect, freed, trials, |value| vec![ACCELERATION.number(value)])]
}

/// Returns the hypotheses of a jerk limit from which the filters' time constants follow, of one along the path, and
/// of one on rapids from standstill to standstill.
pub fn jerks(effect: Effect, context: &Context) -> Vec<Hypothesis> {
    let machine = context.machine;
    let mut all: Vec<Hypothesis> = of_constants(effect, context).into_iter().collect();
    if !machine.interpolator.junction.blends_in_time() {
        all.push(path_jerk(effect));
        all.extend(ramps(effect, machine));
        all.extend(context.runs.iter().any(Run::has_rapid).then(|| positioning(effect, machine)));
    }
    all
}

/// Returns the time constant of all filters, s; `None` if they are unequal or shape no ramps.
fn constant_of_filters(machine: &Machine) -> Option<f64> {
    match machine.interpolator.time_constants {
        TimeConstants::Equal(constant) if machine.has_filters() => Some(constant),
        _ => None,
    }
}

/// Returns the hypothesis of a jerk limit from which the time constants follow; `None` unless all filters have one time
/// constant.
fn of_constants(effect: Effect, context: &Context) -> Option<Hypothesis> {
    let constant = constant_of_filters(context.machine)?;
    let jerk = context.feedrate / (constant * constant);
    let freed = parameters::FILTER_JERK.tried_around(jerk);
    let report = |value| vec![JERK.number(value)];
    Some(Hypothesis::single(effect, freed, ratios(0.1 * jerk, 10.0 * jerk, 9), report))
}

/// Returns the hypothesis of a jerk limit along the path on a machine whose filters and tolerance are known.
fn path_jerk(effect: Effect) -> Hypothesis {
    let freed = parameters::PATH_JERK.tried();
    Hypothesis::single(effect, freed, ratios(3e3, 3e6, 10), |value| vec![JERK.number(value)])
        .variant("along the path, filters as known")
}

/// Returns the hypothesis of a jerk limit along the path, which fits the filters and the tolerance again; `None`
/// unless all filters have one time constant.
pub fn ramps(effect: Effect, machine: &Machine) -> Option<Hypothesis> {
    let constant = constant_of_filters(machine)?;
    let tolerance = machine.interpolator.contour_tolerance;
    let freed = [parameters::PATH_JERK, parameters::TIME_CONSTANT, parameters::CONTOUR_TOLERANCE];
    let trials = SHORTER_FILTERS
        .iter()
        .flat_map(|part| JERKS_MM_S3.map(|jerk| vec![jerk, part * constant, part * tolerance]))
        .collect();
    let report = |values: &[f64]| {
        vec![JERK.number(values[0]), TIME_CONSTANT.number(values[1]), CONTOUR_TOLERANCE.number(values[2])]
    };
    let freed = freed.map(|parameter| parameter.tried()).to_vec();
    Some(Hypothesis::new(effect, freed, trials, report).variant("along the path"))
}

/// Returns the hypothesis of a jerk limit on rapids from standstill to standstill, which fits the rapid feedrate
/// again.
fn positioning(effect: Effect, machine: &Machine) -> Hypothesis {
    let rate = machine.fastest_rapid();
    let freed = vec![parameters::POSITIONING_JERK.tried(), parameters::RAPID_FEEDRATE.tried_around(rate)];
    let jerks = parameters::POSITIONING_JERK.guesses;
    let trials = FASTER_RAPIDS
        .iter()
        .flat_map(|part| jerks.iter().map(move |jerk| vec![*jerk, part * rate]))
        .collect();
    let report =
        |values: &[f64]| vec![JERK.number(values[0]), AT.word("rapid"), RAPID.number(mm_per_min(values[1]))];
    Hypothesis::new(effect, freed, trials, report).variant("rapid")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identification::effects::table::JERK_LIMIT;

    #[test]
    fn a_jerk_limit_of_a_planner_fits_no_filters() {
        let mut machine = Machine::default();
        let offered = |machine: &Machine| -> Vec<usize> {
            let all = jerks(JERK_LIMIT, &Context::new(machine, &[]));
            all.iter().map(|hypothesis| hypothesis.freed.len()).collect()
        };
        // From the constants, along the path with filters as known, and with these fitted again.
        assert_eq!(offered(&machine), [1, 1, 3]);
        machine.become_planner(Planner::JunctionDeviation, 500.0);
        assert_eq!(offered(&machine), [1]);
        machine.become_planner(Planner::AccelerationBlend, 500.0);
        assert!(offered(&machine).is_empty());
    }
}
