//! Effects of limits on velocity, acceleration and jerk, tried below the values that the programs demand.
//!
//! In a machine file that was fitted without a jerk limit, other values compensate for its absence: the filters are
//! as long as the mean ramp, and the rapids correspondingly slow. The hypotheses of a jerk limit therefore free
//! these values as well.

use crate::identification::effects::effect::{Context, Effect, Hypothesis, ratios};
use crate::identification::effects::report::{
    ACCELERATION, AT, AXIS, CONTOUR_TOLERANCE, JERK, PLANNER, RAPID, Reported, TIME_CONSTANT, VELOCITY,
};
use crate::identification::fit::{FreeParameter, Run, VariationScale};
use crate::machine::{AXES, Handle, Junction, Machine, Planner, TimeConstants};
use crate::units::mm_per_min;

/// Jerk limits along the path tried first, mm/s³.
const JERKS_MM_S3: [f64; 5] = [5e3, 1e4, 2e4, 4e4, 1e5];
/// Time constants tried with each of these jerks, as ratios to that of the machine. The contour tolerance has the
/// same ratio, so that corners stay as fast.
const SHORTER_FILTERS: [f64; 2] = [1.0, 0.6];
/// Jerk limits of rapids from standstill to standstill tried first, mm/s³.
pub const POSITIONING_JERKS_MM_S3: [f64; 4] = [2e4, 5e4, 1e5, 3e5];
/// Rapid feedrates tried with each of these jerks, as ratios to that of the machine.
const FASTER_RAPIDS: [f64; 2] = [1.0, 2.0];

/// Returns the handle of a number of an axis in the table of parameters.
pub fn axis_handle(axis: usize, number: &str) -> Handle {
    Handle::number(&format!("axis.{}.{number}", AXES[axis].to_ascii_lowercase()))
}

/// Returns the axes that the programs move.
fn moved(context: &Context) -> impl Iterator<Item = usize> {
    (0..3).filter(|axis| 0.0 < context.axis_feedrate[*axis])
}

/// Returns the hypotheses of an acceleration limit of each axis that moves and, if the tolerance limits the
/// feedrate at corners, of a planner, a control of another family that ramps by one acceleration of all axes.
pub fn axis_accelerations(effect: Effect, context: &Context) -> Vec<Hypothesis> {
    let of_axis = |axis: usize| {
        accelerations(effect, axis_handle(axis, "acceleration_mm_s2"), Some(AXES[axis].to_string()))
    };
    let mut all: Vec<Hypothesis> = moved(context).flat_map(of_axis).collect();
    if context.machine.interpolator.junction == Junction::Tolerance {
        all.extend([planner(effect, true), planner(effect, false)]);
    }
    all
}

/// Returns the hypothesis of a control of another family, without filters, which ramps in trapezoids within the
/// acceleration of the axes. Rapids are limited by each axis with `by_axis`, else along the path.
fn planner(effect: Effect, by_axis: bool) -> Hypothesis {
    let handle = Handle::row("interpolator.junction_rule");
    let freed =
        FreeParameter::new(handle, 500.0, (10.0, 1e5), VariationScale::Ratio).with(move |machine, value| {
            machine.become_planner(Planner::AccelerationBlend, value);
            if by_axis {
                machine.axes.iter_mut().for_each(|axis| axis.rapid = axis.rapid.min(machine.rapid.feedrate));
                machine.rapid.feedrate = f64::INFINITY;
            }
        });
    let variant =
        if by_axis { "planner of trapezoids" } else { "planner of trapezoids, rapid along the path" };
    let report = |value| {
        vec![
            (AXIS, Reported::word("XYZ")),
            (ACCELERATION, Reported::Number(value)),
            (PLANNER, Reported::word("acceleration_blend")),
        ]
    };
    Hypothesis::single(effect, freed, ratios(50.0, 2e4, 14), report).variant(variant)
}

pub fn path_acceleration(effect: Effect, _: &Context) -> Vec<Hypothesis> {
    accelerations(effect, Handle::number("path.acceleration_mm_s2"), None)
}

/// Returns two hypotheses of an acceleration limit: on the motion that leaves the filters, and on the command
/// before them.
fn accelerations(effect: Effect, handle: Handle, axis: Option<String>) -> Vec<Hypothesis> {
    let of = |is_before: bool| {
        let freed = FreeParameter::new(handle, 1e3, (10.0, 2e5), VariationScale::Ratio)
            .also(move |machine| machine.path.limits_command |= is_before);
        let word = axis.clone().map(|axis| (AXIS, Reported::Word(axis)));
        let place = is_before.then(|| (AT, Reported::word("command")));
        let report = move |value| {
            let limit = (ACCELERATION, Reported::Number(value));
            word.iter().cloned().chain([limit]).chain(place.clone()).collect()
        };
        let before = is_before.then(|| "before the filters".to_string());
        let variant: Vec<String> = axis.iter().cloned().chain(before).collect();
        Hypothesis::single(effect, freed, ratios(50.0, 2e4, 10), report).variant(variant.join(", "))
    };
    vec![of(false), of(true)]
}

/// Axes of a limit of the velocity along the path, whatever the direction.
pub const ALONG_PATH: &str = "XYZ";
/// Rarity of a limit along the path, which an operator sets: one for every twenty changes of an override (2 ln 20).
const OF_PATH_LIMITS: f64 = 6.0;

/// Returns the hypotheses of a velocity limit of each axis that moves, and of one along the path.
pub fn axis_velocities(effect: Effect, context: &Context) -> Vec<Hypothesis> {
    let of = |handle: Handle, fastest: f64, axes: String| {
        let bounds = (1e-3 * fastest, 2.0 * fastest);
        let freed = FreeParameter::new(handle, fastest, bounds, VariationScale::Ratio);
        let word = axes.clone();
        let report = move |value| {
            vec![(AXIS, Reported::Word(word.clone())), (VELOCITY, Reported::Number(mm_per_min(value)))]
        };
        Hypothesis::single(effect, freed, ratios(0.02 * fastest, 0.97 * fastest, 14), report).variant(axes)
    };
    let of_axis = |axis: usize| {
        of(axis_handle(axis, "velocity_mm_min"), context.axis_feedrate[axis], AXES[axis].to_string())
    };
    let along_path = of(Handle::number("path.velocity_mm_min"), context.feedrate, ALONG_PATH.to_string());
    moved(context).map(of_axis).chain([along_path.with_rarity(OF_PATH_LIMITS)]).collect()
}

pub fn centripetal_acceleration(effect: Effect, context: &Context) -> Vec<Hypothesis> {
    if !context.has_arc {
        return Vec::new();
    }
    let handle = Handle::number("path.centripetal_acceleration_mm_s2");
    let freed = FreeParameter::new(handle, 1e3, (1.0, 1e6), VariationScale::Ratio);
    // Arcs are as slow as their root: one that makes them 10 % slower must not lie between two that are worse than
    // none.
    let trials = ratios(10.0, 5e3, 32);
    vec![Hypothesis::single(effect, freed, trials, |value| vec![(ACCELERATION, Reported::Number(value))])]
}

/// Returns the hypotheses of a jerk limit from which the filters' time constants follow, of one along the path, and
/// of one on rapids from standstill to standstill.
pub fn jerks(effect: Effect, context: &Context) -> Vec<Hypothesis> {
    let machine = context.machine;
    let mut all: Vec<Hypothesis> = of_constants(effect, context).into_iter().collect();
    if !machine.interpolator.junction.blends_in_time() {
        all.extend(ramps(effect, machine));
        all.extend(context.runs.iter().any(Run::has_rapid).then(|| positioning(effect, machine)));
    }
    all
}

/// Returns the hypothesis of a jerk limit from which the time constants follow; `None` unless the machine gives all
/// filters one time constant.
fn of_constants(effect: Effect, context: &Context) -> Option<Hypothesis> {
    let TimeConstants::Equal(constant) = context.machine.interpolator.time_constants else { return None };
    let jerk = context.feedrate / (constant * constant);
    let handle = Handle::number("interpolator.max_jerk_mm_s3");
    let freed = FreeParameter::new(handle, jerk, (1e-3 * jerk, 1e3 * jerk), VariationScale::Ratio);
    let report = |value| vec![(JERK, Reported::Number(value))];
    Some(Hypothesis::single(effect, freed, ratios(0.1 * jerk, 10.0 * jerk, 9), report))
}

/// Returns the hypothesis of a jerk limit along the path, which fits the filters and the tolerance again; `None` if
/// the filters are unequal.
pub fn ramps(effect: Effect, machine: &Machine) -> Option<Hypothesis> {
    let TimeConstants::Equal(constant) = machine.interpolator.time_constants else { return None };
    let tolerance = machine.interpolator.contour_tolerance;
    let number = |key: &str, start: f64, bounds: (f64, f64)| {
        FreeParameter::new(Handle::number(key), start, bounds, VariationScale::Ratio)
    };
    let freed = vec![
        number("path.jerk_mm_s3", JERKS_MM_S3[2], (1e3, 1e6)),
        number("interpolator.time_constant_s", constant, (2e-4, 0.5)),
        number("interpolator.contour_tolerance_mm", tolerance, (1e-5, 5.0)),
    ];
    let trials = SHORTER_FILTERS
        .iter()
        .flat_map(|part| JERKS_MM_S3.map(|jerk| vec![jerk, part * constant, part * tolerance]))
        .collect();
    let report = |values: &[f64]| {
        vec![
            (JERK, Reported::Number(values[0])),
            (TIME_CONSTANT, Reported::Number(values[1])),
            (CONTOUR_TOLERANCE, Reported::Number(values[2])),
        ]
    };
    Some(Hypothesis::new(effect, freed, trials, report).variant("along the path"))
}

/// Returns the hypothesis of a jerk limit on rapids from standstill to standstill, which fits the rapid feedrate
/// again.
fn positioning(effect: Effect, machine: &Machine) -> Hypothesis {
    let rate = machine.fastest_rapid();
    let jerk = Handle::number("rapid.positioning_jerk_mm_s3");
    let freed = vec![
        FreeParameter::new(jerk, POSITIONING_JERKS_MM_S3[1], (5e3, 5e6), VariationScale::Ratio),
        FreeParameter::new(
            Handle::number("rapid.feed_mm_min"),
            rate,
            (0.02 * rate, 10.0 * rate),
            VariationScale::Ratio,
        ),
    ];
    let trials = FASTER_RAPIDS
        .iter()
        .flat_map(|part| POSITIONING_JERKS_MM_S3.map(|jerk| vec![jerk, part * rate]))
        .collect();
    let report = |values: &[f64]| {
        vec![
            (JERK, Reported::Number(values[0])),
            (AT, Reported::word("rapid")),
            (RAPID, Reported::Number(mm_per_min(values[1]))),
        ]
    };
    Hypothesis::new(effect, freed, trials, report).variant("rapid")
}
