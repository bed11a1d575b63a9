//! Other families of controls: planners that ramp in trapezoids, for recordings that filters cannot explain.
//!
//! Filters ramp in a constant time, whatever the step; planners that are limited in acceleration ramp in Δv/a. Each
//! family of [`Planner`] has a separate law of corners ([`crate::simulation::feed::junction`]). The guess of a
//! family is the nearest of a grid: first of accelerations, the same for all axes, with rapids limited by each axis
//! or along the path, then of the value of its law of corners. Rapids are as fast as their plateaus (`rapids`).

use crate::identification::calibration::nearest;
use crate::identification::calibration::rapids::{RapidPlateaus, limit_feed_as_rapids};
use crate::identification::effects::parameters::{
    JUNCTION_RATIOS, MAX_OVERRIDE, PATH_JERK, PLANNER_ACCELERATION,
};
use crate::identification::fit::{Run, Whitening};
use crate::machine::{
    GRBL_STEP_SEGMENT_S, GRBL_STEP_TIMER_HZ, Junction, KLIPPER_MIN_CRUISE_RATIO, Machine, Planner,
};

/// Initial values of the minimum cruise ratio in fits: Klipper's default, and a small value, because a fit does not free a
/// ratio of 0.
const INITIAL_CRUISE_RATIOS: [f64; 2] = [KLIPPER_MIN_CRUISE_RATIO, 0.1];
/// Factors for the fitted accelerations in a restart. They take the fit out of a local minimum.
const RESTART_ACCELERATION_RATIOS: [f64; 3] = [0.6, 1.0, 1.6];
/// Factors for the fitted value of the junction law in a restart.
const RESTART_JUNCTION_RATIOS: [f64; 3] = [0.4, 1.0, 2.5];
/// Factors for the fitted accelerations of a planner that gets a jerk limit.
const JERK_LIMIT_ACCELERATION_RATIOS: [f64; 3] = [1.0, 2.0, 4.0];
/// Accelerations of all axes tried beside each jerk limit, mm/s²; the highest limits no ramp.
const JERK_ACCELERATIONS_MM_S2: [f64; 3] = [1e4, 1500.0, 500.0];
/// Factors for the distance between arcs and their chords beside a jerk limit: 0.002, 0.01 and 0.05 mm with grbl's
/// default.
const JERK_CHORD_ERROR_RATIOS: [f64; 3] = [1.0, 5.0, 25.0];

/// Largest relative difference of the steps of two recordings of one machine.
const MAX_STEP_DIFFERENCE_RATIO: f64 = 1e-3;

/// A family of planners as a calibration tries it.
#[derive(Clone, Copy)]
struct CandidateFamily {
    planner: Planner,
    /// `true` if the machine file's contour tolerance bounds the blends; `false` if nothing does. A fit cannot change from
    /// one to the other.
    keeps_tolerance: bool,
    /// `true` if its axes, or the path on a control that limits that instead, are limited to the velocities that they
    /// reached again and again.
    is_limited: bool,
    /// Minimum cruise ratio, 0 if the family has none.
    cruise_ratio: f64,
}

/// Returns the machine of each family that is nearest to the runs, before any fit. `machine` is the machine before
/// the calibration; `fitted` has the waits and the rapid feed that filters need. Acceleration blends are guessed
/// with a contour tolerance, as the control may be started with one, and without.
pub fn guesses(
    machine: &Machine,
    fitted: &Machine,
    runs: &[Run],
    whitenings: &[Whitening],
    plateaus: Option<RapidPlateaus>,
) -> Vec<Machine> {
    let mut plain = fitted.clone();
    plain.interpolator.contour_tolerance = machine.interpolator.contour_tolerance;
    let guess = |candidate: CandidateFamily| {
        let CandidateFamily { planner, keeps_tolerance, is_limited, cruise_ratio } = candidate;
        let at = |acceleration: &f64| {
            let mut of = plain.clone();
            of.become_planner(planner, *acceleration);
            of.interpolator.minimum_cruise_ratio = cruise_ratio;
            if let Some(seen) = plateaus {
                seen.limit_feed(planner, &mut of);
                of = seen.limited_to_fastest(planner, &of).filter(|_| is_limited).unwrap_or(of);
            }
            if planner == Planner::AccelerationBlend && keeps_tolerance {
                of.interpolator.contour_tolerance = plain.interpolator.contour_tolerance;
            }
            of
        };
        let ramps = PLANNER_ACCELERATION.guesses.iter().map(at);
        let grid: Vec<Vec<Machine>> =
            ramps.map(|of| with_rapids(planner, &of, machine, fitted, plateaus)).collect();
        let scaled = |of: &Machine| JUNCTION_RATIOS.map(|ratio| of.with_scaled_junction(ratio));
        let nearest_ramps = nearest(grid.iter().flatten().cloned(), runs, whitenings);
        let is_free = planner == Planner::AccelerationBlend && !keeps_tolerance;
        // A blend that nothing bounds has no tolerance to scale.
        let by_ramps = nearest_ramps
            .and_then(|of| if is_free { Some(of) } else { nearest(scaled(&of), runs, whitenings) });
        match planner {
            Planner::AccelerationBlend => {
                let of = |found: Machine| nearest(with_circles(&found), runs, whitenings);
                by_ramps.and_then(of).into_iter().collect()
            }
            // Slow corners make up for steep ramps, so every second guess of both is also tried together.
            _ => {
                let corners = |of: &Machine| scaled(of).into_iter().step_by(2);
                let together = nearest(grid.iter().step_by(2).flatten().flat_map(corners), runs, whitenings);
                let other = together.filter(|other| Some(other) != by_ramps.as_ref());
                let at_steps = |of: Machine| with_and_without_steps(&of, runs);
                by_ramps.into_iter().chain(other).flat_map(at_steps).collect::<Vec<_>>()
            }
        }
    };
    candidates(&plain, plateaus).into_iter().flat_map(guess).collect()
}

/// Returns the families to be tried: blends with a contour tolerance and without, square corners with each cruise
/// ratio, and all also with limits of velocity if a limit may have held them back.
fn candidates(plain: &Machine, plateaus: Option<RapidPlateaus>) -> Vec<CandidateFamily> {
    let mut candidates = Vec::new();
    for planner in Planner::ALL {
        let is_limited = plateaus.is_some_and(|seen| seen.limited_to_fastest(planner, plain).is_some());
        let limits: &[bool] = if is_limited { &[false, true] } else { &[false] };
        let (tolerances, ratios): (&[bool], &[f64]) = match planner {
            Planner::AccelerationBlend => (&[false, true], &[0.0]),
            Planner::JunctionDeviation => (&[false], &[0.0]),
            Planner::SquareCorner => (&[false], &INITIAL_CRUISE_RATIOS),
        };
        for &is_limited in limits {
            for &keeps_tolerance in tolerances {
                let of = |&cruise_ratio: &f64| CandidateFamily {
                    planner,
                    keeps_tolerance,
                    is_limited,
                    cruise_ratio,
                };
                candidates.extend(ratios.iter().map(of));
            }
        }
    }
    candidates
}

/// Returns the nearest of a fitted planner with scaled corners, accelerations and cruise ratios; `None` if that is
/// the planner itself or its family blends corners in time, whose ways [`chosen_again`] tries.
pub fn beside_minimum(machine: &Machine, runs: &[Run], whitenings: &[Whitening]) -> Option<Machine> {
    if !has_junction_law(machine) {
        return None;
    }
    let junction = machine.interpolator.junction;
    let own = machine.interpolator.minimum_cruise_ratio;
    let others = if matches!(junction, Junction::SquareCorner(_)) { &INITIAL_CRUISE_RATIOS[..] } else { &[] };
    let ratios = [own].into_iter().chain(others.iter().copied());
    let with_ratio = ratios.map(|ratio| {
        let mut of = machine.clone();
        of.interpolator.minimum_cruise_ratio = ratio;
        of
    });
    let accelerated = with_ratio
        .flat_map(|of| RESTART_ACCELERATION_RATIOS.map(|ratio| of.with_scaled_accelerations(ratio)));
    let scaled =
        accelerated.flat_map(|of| RESTART_JUNCTION_RATIOS.map(|ratio| of.with_scaled_junction(ratio)));
    nearest([machine.clone()].into_iter().chain(scaled), runs, whitenings).filter(|other| other != machine)
}

/// Returns the nearest machines of a fitted planner with a jerk limit along the path; none if its family blends
/// corners in time or its jerk is already limited. A fitted acceleration without a jerk limit is the mean of a ramp,
/// so the first machine has steeper ramps in each axis, and the second one an acceleration of all axes; corners
/// remain as fast.
pub fn with_jerk_limits(machine: &Machine, runs: &[Run], whitenings: &[Whitening]) -> Vec<Machine> {
    if !has_junction_law(machine) || machine.path.jerk.is_finite() {
        return Vec::new();
    }
    let lowest = machine.axes.map(|axis| axis.acceleration).into_iter().fold(f64::INFINITY, f64::min);
    let with_acceleration = |acceleration: f64| {
        let mut of = machine.with_scaled_junction(lowest / acceleration);
        of.axes.iter_mut().for_each(|axis| axis.acceleration = acceleration);
        of
    };
    let steeper = JERK_LIMIT_ACCELERATION_RATIOS
        .map(|ratio| machine.with_scaled_accelerations(ratio).with_scaled_junction(1.0 / ratio));
    let alike = JERK_ACCELERATIONS_MM_S2.map(with_acceleration);
    let near = |of: [Machine; 3]| {
        let ramps = nearest(of.iter().flat_map(|of| PATH_JERK.guesses_on(of)), runs, whitenings)?;
        let corners = nearest(
            RESTART_JUNCTION_RATIOS.map(|ratio| ramps.with_scaled_junction(ratio)),
            runs,
            whitenings,
        )?;
        // Each chord has its own ramps.
        nearest(JERK_CHORD_ERROR_RATIOS.map(|ratio| corners.with_scaled_chords(ratio)), runs, whitenings)
    };
    [steeper, alike].into_iter().filter_map(near).collect()
}

/// Returns `true` if a planner passes corners at a feedrate that its law gives, as grbl and Klipper do.
fn has_junction_law(machine: &Machine) -> bool {
    matches!(machine.interpolator.junction, Junction::Deviation(_) | Junction::SquareCorner(_))
}

/// Returns the machine with another way to blend corners, or with other steps or step segments, if that is nearer to the runs;
/// `None` if none is nearer.
pub fn chosen_again(machine: &Machine, runs: &[Run], whitenings: &[Whitening]) -> Option<Machine> {
    let stepped = with_and_without_steps(machine, runs);
    let others =
        with_other_blends(machine).into_iter().chain(stepped.iter().flat_map(with_and_without_segments));
    let others: Vec<Machine> = others.filter(|other| other != machine).collect();
    if others.is_empty() {
        return None;
    }
    let ways = [machine.clone()].into_iter().chain(others);
    nearest(ways, runs, whitenings).filter(|other| other != machine)
}

/// Returns a planner with a junction deviation both with the steps of the recorded positions, which may be those of its
/// motors or the resolution of the recorder, and without steps; other planners are returned alone.
fn with_and_without_steps(machine: &Machine, runs: &[Run]) -> Vec<Machine> {
    if !plans_by_deviation(machine) {
        return vec![machine.clone()];
    }
    let recorded: Vec<[f64; 3]> =
        runs.iter().filter_map(|run| Some(run.alignment.track.as_ref()?.steps)).collect();
    let with_steps = |steps: [f64; 3]| {
        let mut machine = machine.clone();
        machine.axes.iter_mut().zip(steps).for_each(|(axis, step)| axis.step = step);
        machine
    };
    let common = |axis: usize| {
        let mut all = recorded.iter().map(|steps| steps[axis]);
        let first = all.next().unwrap_or(0.0);
        let is_same = |other: f64| (other - first).abs() < MAX_STEP_DIFFERENCE_RATIO * first;
        if all.all(is_same) { first } else { 0.0 }
    };
    let mut both = vec![with_steps([0, 1, 2].map(common)), with_steps([0.0; 3])];
    both.dedup();
    both
}

/// Returns `true` if a junction deviation limits corners, as in grbl.
fn plans_by_deviation(machine: &Machine) -> bool {
    matches!(machine.interpolator.junction, Junction::Deviation(_))
}

/// Returns a planner with a junction deviation with the step segments and the timer of grbl, with an exact timer, and without
/// segments; other planners are returned alone.
fn with_and_without_segments(machine: &Machine) -> Vec<Machine> {
    if !plans_by_deviation(machine) {
        return vec![machine.clone()];
    }
    let with_timer = |(segment, frequency): (f64, f64)| {
        let mut machine = machine.clone();
        (machine.interpolator.step_segment, machine.interpolator.step_timer) = (segment, frequency);
        machine
    };
    let grbl = (GRBL_STEP_SEGMENT_S, GRBL_STEP_TIMER_HZ);
    [grbl, (GRBL_STEP_SEGMENT_S, f64::INFINITY), (0.0, f64::INFINITY)].map(with_timer).to_vec()
}

/// Returns the machine with each other way to blend corners; none if it does not blend corners in time.
pub fn with_other_blends(machine: &Machine) -> Vec<Machine> {
    if !machine.interpolator.junction.blends_in_time() {
        return Vec::new();
    }
    let ways = with_circles(machine).into_iter().chain([with_parabolas(machine)]);
    ways.filter(|other| other.interpolator != machine.interpolator).collect()
}

/// Returns the machine with circles at corners, for each largest override that a control may plan them for.
fn with_circles(planner: &Machine) -> Vec<Machine> {
    let mut machine = planner.clone();
    machine.interpolator.junction = Junction::AccelerationBlend;
    MAX_OVERRIDE.guesses_on(&machine)
}

/// Returns the machine with parabolas at corners.
fn with_parabolas(planner: &Machine) -> Machine {
    let mut machine = planner.clone();
    machine.interpolator.junction = Junction::ParabolicBlend;
    machine
}

/// Returns the planner with the rapids limited as its family limits them, by each axis or along the path. Rapids are
/// as fast as recorded or, if no positions were recorded, as fast as in the machine file and with the filters.
fn with_rapids(
    family: Planner,
    planner: &Machine,
    machine: &Machine,
    fitted: &Machine,
    seen: Option<RapidPlateaus>,
) -> Vec<Machine> {
    let rates = [machine.fastest_rapid(), fitted.fastest_rapid()];
    let told = rates.map(|rate| RapidPlateaus {
        path: Some(rate),
        axes: [Some(rate); 3],
        ..RapidPlateaus::default()
    });
    let plateaus = seen.map_or(told.to_vec(), |seen| vec![seen]);
    // Klipper's rapids are moves with a feedrate like any other; the others run each axis at its own rate.
    // Its minimum cruise ratio also holds the velocity of rapids that are too short for their rate.
    let of = |seen: &RapidPlateaus| match family {
        Planner::SquareCorner => {
            let unknown = RapidPlateaus { path: None, ..*seen };
            let all = [Some(*seen), seen.path.map(|_| unknown)];
            all.into_iter().flatten().map(|seen| seen.limited_along_path(planner, machine)).collect()
        }
        _ => vec![seen.limited_by_axis(planner, machine)],
    };
    let mut machines: Vec<Machine> = plateaus.iter().flat_map(of).collect();
    machines.iter_mut().for_each(|machine| limit_feed_as_rapids(machine, seen));
    machines
}
