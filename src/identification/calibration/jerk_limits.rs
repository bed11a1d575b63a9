//! Planners with jerk limits, for recordings whose ramps no trapezoid has.
//!
//! The guesses begin with a fitted planner of trapezoids, whose accelerations are means over whole ramps. They raise these
//! accelerations, give all axes the same one, or give them one that no ramp reaches, as in TinyG; corners remain as fast.
//! A planner that limits the acceleration of each axis gets a jerk limit for each axis: the jerk that the ramps hold
//! ([`held_jerks`]) or, if they hold none, the nearest of a grid. A planner that limits the acceleration along the path gets
//! one jerk limit along the path.
//!
//! If no acceleration is reached, the jerk alone gives ramps their shape, whatever the corners and the chords of arcs are.
//! Ramps that hold no jerk then have that with which the shape is nearest to the recorded one. Times would mislead there: a
//! jerk that is a tenth off costs more than a wrong law.

use crate::identification::calibration::families::{
    has_junction_law, is_of_marlin, plans_by_deviation, with_junctions,
};
use crate::identification::calibration::held_jerks::held_jerks;
use crate::identification::calibration::nearest;
use crate::identification::fit::{Run, Whitening, golden_section, ramp_misfit};
use crate::machine::Machine;

/// Factors for the fitted value of the junction law.
const START_JUNCTION_RATIOS: [f64; 3] = [0.4, 1.0, 2.5];
/// Factors for the fitted accelerations.
const START_ACCELERATION_RATIOS: [f64; 3] = [1.0, 2.0, 4.0];
/// Accelerations that are tried in all axes, mm/s².
const START_ACCELERATIONS_MM_S2: [f64; 2] = [1500.0, 500.0];
/// Acceleration that no ramp reaches, mm/s².
const ACCELERATION_BEYOND_RAMPS_MM_S2: f64 = 1e4;
/// Jerks that are tried where ramps hold none, mm/s³: a ramp by one lasts 1.4 times as long as by the next.
const START_JERKS_MM_S3: [f64; 10] = [1e3, 2e3, 4e3, 8e3, 16e3, 32e3, 64e3, 128e3, 256e3, 512e3];
/// Ratio of the simulated to the recorded time above which a jerk is not tried: it would be too low, and take long to compute.
const MAX_TIME_RATIO: f64 = 2.0;
/// Golden sections between two of these jerks, which leave a hundredth of a jerk.
const SECTIONS_OF_JERK: usize = 9;
/// Factors for the distance between arcs and their chords: 0.002, 0.01 and 0.05 mm with grbl's default.
const START_CHORD_ERROR_RATIOS: [f64; 3] = [1.0, 5.0, 25.0];

/// Returns the nearest machines of a fitted planner with jerk limits; none if its family blends corners in time or its jerk
/// is already limited.
pub fn with_jerk_limits(machine: &Machine, runs: &[Run], whitenings: &[Whitening]) -> Vec<Machine> {
    if !has_junction_law(machine) || is_of_marlin(machine) || machine.limits_jerk() {
        return Vec::new();
    }
    let lowest = machine.axes.map(|axis| axis.acceleration).into_iter().fold(f64::INFINITY, f64::min);
    let with_acceleration = |acceleration: f64| {
        let mut of = machine.with_scaled_junction(lowest / acceleration);
        of.axes.iter_mut().for_each(|axis| axis.acceleration = acceleration);
        of
    };
    let steeper = START_ACCELERATION_RATIOS
        .map(|ratio| machine.with_scaled_accelerations(ratio).with_scaled_junction(1.0 / ratio));
    let alike = START_ACCELERATIONS_MM_S2.map(with_acceleration);
    let beyond = with_acceleration(ACCELERATION_BEYOND_RAMPS_MM_S2);
    let held = if plans_by_deviation(machine) { held_jerks(runs) } else { None };
    let nearest = |machines: Vec<Machine>| nearest(machines, runs, whitenings);
    let near = |of: &[Machine]| {
        let ramps = nearest(of.iter().flat_map(|of| at_jerks(of, held)).collect())?;
        let corners = nearest(START_JUNCTION_RATIOS.map(|ratio| ramps.with_scaled_junction(ratio)).to_vec())?;
        // Each chord has its own ramps.
        nearest(START_CHORD_ERROR_RATIOS.map(|ratio| corners.with_scaled_chords(ratio)).to_vec())
    };
    let of_shape = || plans_by_deviation(machine).then(|| jerk_of_shape(machine, &beyond, runs)).flatten();
    let idle = with_junctions(&beyond);
    let idle = match held.or_else(|| Some([of_shape()?; 3])) {
        Some(jerks) => {
            let with_chords = |of: &Machine| {
                let ramps = with_jerks(of, jerks);
                START_CHORD_ERROR_RATIOS.map(|ratio| ramps.with_scaled_chords(ratio))
            };
            nearest(idle.iter().flat_map(with_chords).collect())
        }
        None => near(&idle),
    };
    idle.into_iter().chain([&steeper[..], &alike].into_iter().filter_map(near)).collect()
}

/// Returns the jerk with which the ramps of the planner `beyond`, which reaches no acceleration, have the shape nearest to the
/// recorded one, mm/s³; `None` if the runs show no ramps. `fitted` is the planner of trapezoids that takes the recorded time.
fn jerk_of_shape(fitted: &Machine, beyond: &Machine, runs: &[Run]) -> Option<f64> {
    let lasts = |machine: &Machine| runs.iter().map(|run| run.plan(machine).cycle_time()).sum::<f64>();
    let longest = MAX_TIME_RATIO * lasts(fitted);
    let misfit = |jerk: f64| {
        let ramps = with_jerks(beyond, [jerk; 3]);
        let misfit = (lasts(&ramps) < longest).then(|| ramp_misfit(&ramps, runs).of_path);
        misfit.flatten().unwrap_or(f64::INFINITY)
    };
    let misfits = START_JERKS_MM_S3.map(misfit);
    let nearest = (0..misfits.len()).min_by(|one, other| misfits[*one].total_cmp(&misfits[*other]))?;
    if misfits[nearest] == f64::INFINITY {
        return None;
    }
    let beside = [nearest.saturating_sub(1), (nearest + 1).min(misfits.len() - 1)];
    let [low, high] = beside.map(|at| START_JERKS_MM_S3[at].ln());
    let (low, high) = golden_section((low, high), SECTIONS_OF_JERK, |log| misfit(log.exp()));
    Some((0.5 * (low + high)).exp())
}

/// Returns a planner with the jerks that its axes hold (mm/s³) or, without them, with each jerk from which a fit begins.
fn at_jerks(planner: &Machine, held: Option<[f64; 3]>) -> Vec<Machine> {
    match held {
        Some(jerks) => vec![with_jerks(planner, jerks)],
        None => START_JERKS_MM_S3.iter().map(|jerk| with_jerks(planner, [*jerk; 3])).collect(),
    }
}

/// Returns a planner with jerk limits of its axes (mm/s³), or with the first of them along the path.
fn with_jerks(planner: &Machine, jerks: [f64; 3]) -> Machine {
    let mut planner = planner.clone();
    match plans_by_deviation(&planner) {
        true => planner.axes.iter_mut().zip(jerks).for_each(|(axis, jerk)| axis.jerk = jerk),
        false => planner.path.jerk = jerks[0],
    }
    planner
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identification::alignment::recorded;
    use crate::identification::calibration::whitened;
    use crate::machine::Planner;

    /// The trapezoids have the mean acceleration of the ramps.
    #[test]
    fn the_nearest_start_has_the_jerk_of_the_ramps() {
        let mut truth = Machine::default();
        truth.become_planner(Planner::JunctionDeviation, ACCELERATION_BEYOND_RAMPS_MM_S2);
        truth.axes.iter_mut().for_each(|axis| axis.jerk = 16e3);
        let truth = truth.with_scaled_junction(0.035);
        let program = format!("G1 F3000\n{}", "X20\nY20\nX0\nY0\n".repeat(6));
        let (toolpath, alignment) = recorded(&program, &truth, 1e-4);
        let runs = [Run { toolpath: &toolpath, alignment: &alignment, overrides: (None, None) }];
        let whitenings = whitened(&truth, &runs);
        let mut trapezoids = Machine::default();
        trapezoids.become_planner(Planner::JunctionDeviation, 350.0);
        let found = nearest(with_jerk_limits(&trapezoids, &runs, &whitenings), &runs, &whitenings);
        let found = found.expect("there are starts");
        assert_eq!(found.axes.map(|axis| axis.jerk), [16e3; 3]);
        // Below this acceleration the ramps would have a part of constant acceleration.
        assert!((50.0 * 16e3_f64).sqrt() < found.axes[0].acceleration);
        assert!(with_jerk_limits(&truth, &runs, &whitenings).is_empty());
        // A planner that limits the acceleration along the path has one jerk there.
        trapezoids.become_planner(Planner::SquareCorner, 350.0);
        let of_path = with_jerk_limits(&trapezoids, &runs, &whitenings);
        assert!(of_path.iter().all(|start| start.path.jerk.is_finite() && !start.limits_jerk_of_axes()));
    }

    #[test]
    fn held_jerks_replace_the_grid() {
        let mut planner = Machine::default();
        planner.become_planner(Planner::JunctionDeviation, 350.0);
        let held = at_jerks(&planner, Some([3e3, 2e3, 1e3]));
        assert_eq!(held.len(), 1);
        assert_eq!(held[0].axes.map(|axis| axis.jerk), [3e3, 2e3, 1e3]);
    }
}
