//! Effects at corners and arcs: tolerances, junction laws, and the smoothing of lines and corners.

use crate::identification::effects::effect::{Context, Effect, Hypothesis, ratios};
use crate::identification::effects::parameters::{self, Adjustable, WIDEST_JOINT_MM};
use crate::identification::effects::report::{ARC_TOLERANCE, AT, CONTOUR_TOLERANCE, RULE, TOLERANCE, VALUE};
use crate::identification::fit::Run;
use crate::machine::{Junction, Machine};
use crate::simulation::feed::rounding;
use crate::simulation::toolpath::{Curve, Segment};
use crate::units::mm_per_min;

/// Variant of a tolerance that also merges lines.
pub const CORNERS_AND_LINES: &str = "corners and merged lines";

pub fn tolerances(effect: Effect, context: &Context) -> Vec<Hypothesis> {
    let machine = context.machine;
    let own = machine.interpolator.contour_tolerance;
    // Where the program sets the tolerance, the control may hold another one.
    let (parameter, trials) = match context.has_tolerance {
        true => (parameters::TOLERANCE_OVERRIDE, ratios(5e-4, 0.5, 12)),
        // One that blends freely has none to begin from.
        false if machine.interpolator.junction.blends_in_time() => {
            (parameters::CONTOUR_TOLERANCE, ratios(5e-4, 0.5, 12))
        }
        false => {
            let parts = [0.05, 0.15, 0.3, 0.5, 0.75, 0.9, 1.1, 1.3, 2.0, 3.5, 8.0];
            (parameters::CONTOUR_TOLERANCE, parts.iter().map(|ratio| ratio * own).collect())
        }
    };
    let report = |value| vec![CONTOUR_TOLERANCE.number(value)];
    let mut all = vec![Hypothesis::single(effect, parameter.tried(), trials, report)];
    if !context.has_tolerance && machine.interpolator.junction.blends_in_time() {
        // LinuxCNC's G64 P sets both the tolerance of corners and that within which lines are merged.
        let freed = parameters::CONTOUR_TOLERANCE.tried().also(|machine| {
            machine.interpolator.path_smoothing = Some(machine.interpolator.contour_tolerance)
        });
        let trials = ratios(1e-3, 0.5, 24);
        let report = |value| vec![AT.word(CORNERS_AND_LINES), CONTOUR_TOLERANCE.number(value)];
        all.push(Hypothesis::single(effect, freed, trials, report).variant(CORNERS_AND_LINES));
    }
    all.extend(arcs(effect, machine).filter(|_| context.has_arc));
    all
}

/// Returns the hypothesis that the contour tolerance does not slow arcs, as on controls that apply it only at
/// corners; `None` if corners follow another law or the machine has an arc tolerance already. A slightly wider
/// tolerance of arcs is not offered, as it would absorb time that other causes lose.
fn arcs(effect: Effect, machine: &Machine) -> Option<Hypothesis> {
    let own = machine.interpolator.contour_tolerance;
    let held = machine.interpolator.arc_tolerance;
    if machine.interpolator.junction != Junction::Tolerance || held.is_some() {
        return None;
    }
    let freed = parameters::ARC_TOLERANCE.tried_around(own);
    let trials = [10.0, 30.0, 100.0].iter().map(|ratio| ratio * own).collect();
    let report = |value| vec![AT.word("arcs"), ARC_TOLERANCE.number(value)];
    Some(Hypothesis::single(effect, freed, trials, report).variant("arcs"))
}

/// Returns the hypotheses of another junction law, or of another value of the machine's. No control changes its law, so a machine
/// with a law is offered no other, except for the two ways in which LinuxCNC blends corners.
pub fn junctions(effect: Effect, context: &Context) -> Vec<Hypothesis> {
    let machine = context.machine;
    let rule = |word: &'static str, parameter: Adjustable, trials: Vec<f64>, unit: fn(f64) -> f64| {
        let report = move |value| vec![RULE.word(word), VALUE.number(unit(value))];
        Hypothesis::single(effect, parameter.tried(), trials, report).variant(word.replace('_', " "))
    };
    let deviation =
        || rule("junction_deviation", parameters::JUNCTION_DEVIATION, ratios(1e-3, 0.3, 8), |value| value);
    let square_corner = || {
        let trials = ratios(0.3, 60.0, 8);
        rule("square_corner_velocity", parameters::SQUARE_CORNER_VELOCITY, trials, mm_per_min)
    };
    let step = || {
        let trials = ratios(0.3, 60.0, 10);
        rule("axis_velocity_step", parameters::AXIS_VELOCITY_STEP, trials, mm_per_min)
    };
    // Two of these laws are laws of an acceleration, and mean nothing without one.
    let is_accelerated = machine.path.acceleration.is_finite()
        || machine.axes.iter().any(|axis| axis.acceleration.is_finite());
    match machine.interpolator.junction {
        Junction::Tolerance if is_accelerated => vec![deviation(), square_corner(), step()],
        Junction::Tolerance | Junction::AxisStep(_) => vec![step()],
        Junction::Deviation(_) => vec![deviation()],
        Junction::SquareCorner(_) => vec![square_corner()],
        Junction::AccelerationBlend | Junction::ParabolicBlend | Junction::ExactPath => {
            parabolas(effect, machine).into_iter().collect()
        }
    }
}

/// Returns the hypothesis that LinuxCNC blends corners by parabolas instead of circles; `None` if the machine does
/// not blend by circles. Parabolas have no parameter. The hypothesis therefore frees the largest override, for
/// which circles are planned and which parabolas ignore.
fn parabolas(effect: Effect, machine: &Machine) -> Option<Hypothesis> {
    if machine.interpolator.junction != Junction::AccelerationBlend {
        return None;
    }
    let freed = parameters::MAX_OVERRIDE
        .tried()
        .also(|machine| machine.interpolator.junction = Junction::ParabolicBlend);
    let report = |_| vec![RULE.word("parabolic_blend")];
    Some(Hypothesis::single(effect, freed, vec![1.0], report).variant("parabolas").at_trials_only())
}

pub fn smoothings(effect: Effect, context: &Context) -> Vec<Hypothesis> {
    let Context { machine, runs, .. } = context;
    smoothing(effect, machine, runs).into_iter().chain(corner_smoothing(effect, machine, runs)).collect()
}

/// Returns the hypothesis that the control merges lines within a distance. Merging acts on whole lines, so values
/// between two trials may change nothing. Controls that are known to have LinuxCNC's junctions merge lines by
/// default; for them the hypothesis also tries 0, no merging. For the others it is `None` if no joint of lines is
/// within `WIDEST_JOINT_MM`.
fn smoothing(effect: Effect, machine: &Machine, runs: &[Run]) -> Option<Hypothesis> {
    let trials = match machine.interpolator.junction {
        Junction::AccelerationBlend | Junction::ParabolicBlend | Junction::ExactPath => {
            std::iter::once(0.0).chain(ratios(1e-3, 1.0, 31)).collect()
        }
        _ => {
            let least = least_joint(runs);
            if WIDEST_JOINT_MM < least {
                return None;
            }
            ratios(least.max(1e-3), WIDEST_JOINT_MM, 14)
        }
    };
    let report = |value| vec![TOLERANCE.number(value)];
    let freed = parameters::PATH_SMOOTHING.tried();
    Some(Hypothesis::single(effect, freed, trials, report).at_trials_only())
}

/// Returns the least non-zero distance (mm) of the joint of two feed moves along lines from their chord, the line
/// from the start of the first to the end of the second; infinity if there is none.
fn least_joint(runs: &[Run]) -> f64 {
    let pairs = runs.iter().flat_map(|run| run.toolpath.segments.pairs());
    let joints = pairs.filter_map(|(before, after)| {
        let is_cut = |segment: &Segment| segment.curve == Curve::Line && !segment.motion.is_rapid();
        if !is_cut(&before) || !is_cut(&after) || before.motion != after.motion || before.exact_stop {
            return None;
        }
        let (before, after) = (before.length * before.tangent(0.0), after.length * after.tangent(0.0));
        let past = before + after;
        Some(before.cross(&after).norm() / past.norm()).filter(|joint| 1e-6 < *joint)
    });
    joints.fold(f64::INFINITY, f64::min)
}

/// Number of equal groups of corners, in order of distance; each distance tried rounds one group more.
const CORNER_GROUPS: usize = 16;
/// Ratio of a distance tried to the largest distance of the corners that it rounds.
const TRIED_DISTANCE_RATIO: f64 = 1.08;

/// Returns the hypothesis that the control rounds corners within a distance, with trials that round more and more
/// corners; `None` if the control blends corners in time or no corner can be rounded.
fn corner_smoothing(effect: Effect, machine: &Machine, runs: &[Run]) -> Option<Hypothesis> {
    if machine.interpolator.junction.blends_in_time() {
        return None;
    }
    let corners = runs.iter().flat_map(|run| run.toolpath.segments.pairs());
    let mut distances: Vec<f64> = corners
        .filter_map(|(before, after)| rounding(&before, &after))
        .filter(|distance| (1e-4..WIDEST_JOINT_MM).contains(distance))
        .collect();
    distances.sort_by(f64::total_cmp);
    let last = distances.len().checked_sub(1)?;
    let mut trials: Vec<f64> = (0..=CORNER_GROUPS)
        .map(|part| TRIED_DISTANCE_RATIO * distances[last * part / CORNER_GROUPS])
        .collect();
    trials.dedup_by(|b, a| *b < 1.01 * *a);
    let freed = parameters::CORNER_SMOOTHING.tried();
    let report = |value| vec![TOLERANCE.number(value), AT.word("corners")];
    Some(Hypothesis::single(effect, freed, trials, report).variant("corners"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identification::effects::table::JUNCTION_RULE;

    #[test]
    fn a_control_with_a_junction_law_is_offered_no_other() {
        let rules = |junction: Junction| -> Vec<String> {
            let mut machine = Machine::default();
            machine.axes.iter_mut().for_each(|axis| axis.acceleration = 500.0);
            machine.interpolator.junction = junction;
            let all = junctions(JUNCTION_RULE, &Context::new(&machine, &[]));
            all.into_iter().map(|own| own.variant).collect()
        };
        let all = ["junction deviation", "square corner velocity", "axis velocity step"];
        assert_eq!(rules(Junction::Tolerance), all);
        assert_eq!(rules(Junction::Deviation(0.01)), all[..1]);
        assert_eq!(rules(Junction::SquareCorner(5.0)), all[1..2]);
        assert_eq!(rules(Junction::AxisStep(5.0)), all[2..]);
        assert_eq!(rules(Junction::AccelerationBlend), ["parabolas"]);
    }
}
