//! Other families of controls: planners that ramp in trapezoids, for recordings that filters cannot explain.
//!
//! Filters ramp in a constant time, whatever the step; planners that are limited in acceleration ramp in Δv/a. Each
//! family of [`Planner`] has a separate law of corners ([`crate::simulation::feed::junction`]). The guess of a
//! family is the nearest of a grid: first of accelerations, the same for all axes, with rapids limited by each axis
//! or along the path, then of the value of its law of corners. Rapids are as fast as their plateaus (`rapids`).

use crate::identification::calibration::nearest;
use crate::identification::calibration::rapids::{RapidPlateaus, limit_feed_as_rapids};
use crate::identification::effects::parameters::{JUNCTION_RATIOS, MAX_OVERRIDE, PLANNER_ACCELERATION};
use crate::identification::fit::{Run, Whitening};
use crate::machine::{Junction, Machine, Planner};

/// A family of planners as a calibration tries it.
#[derive(Clone, Copy)]
struct CandidateFamily {
    planner: Planner,
    /// `true` if the machine file's contour tolerance bounds the blends; `false` if nothing does. A fit cannot change from
    /// one to the other.
    keeps_tolerance: bool,
    /// `true` if its axes are limited to the velocities that they reached again and again.
    has_limited_axes: bool,
}

/// Returns the machine of each family that is nearest to the runs, before any fit. `machine` is the machine before
/// the calibration; `fitted` has the waits and the rapid feed that filters need. Acceleration blends are guessed
/// with a contour tolerance, as the control may be started with one, and without; and, if axes never exceeded a speed
/// that they reached again and again, also with this speed as their limit.
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
        let CandidateFamily { planner, keeps_tolerance, has_limited_axes } = candidate;
        let at = |acceleration: &f64| {
            let mut of = plain.clone();
            of.become_planner(planner, *acceleration);
            if planner == Planner::AccelerationBlend {
                if let Some(seen) = plateaus {
                    seen.limit_feed(&mut of);
                    of = seen.limited_to_fastest(&of).filter(|_| has_limited_axes).unwrap_or(of);
                }
                if keeps_tolerance {
                    of.interpolator.contour_tolerance = plain.interpolator.contour_tolerance;
                }
            }
            of
        };
        let ramps = PLANNER_ACCELERATION.guesses.iter().map(at);
        let grid = ramps.flat_map(|of| with_rapids(planner, &of, machine, fitted, plateaus));
        let nearest_ramps = nearest(grid, runs, whitenings)?;
        // A blend that nothing bounds has no tolerance to scale.
        let found = if planner == Planner::AccelerationBlend && !keeps_tolerance {
            nearest_ramps
        } else {
            nearest(JUNCTION_RATIOS.map(|ratio| nearest_ramps.with_scaled_junction(ratio)), runs, whitenings)?
        };
        match planner {
            Planner::AccelerationBlend => nearest(with_circles(&found), runs, whitenings),
            _ => Some(found),
        }
    };
    let is_limited = plateaus.is_some_and(|seen| seen.limited_to_fastest(&plain).is_some());
    let limits: &[bool] = if is_limited { &[false, true] } else { &[false] };
    let blends = limits.iter().flat_map(|&has_limited_axes| {
        let planner = Planner::AccelerationBlend;
        [false, true].map(|keeps_tolerance| CandidateFamily { planner, keeps_tolerance, has_limited_axes })
    });
    let others = Planner::ALL.into_iter().filter(|planner| *planner != Planner::AccelerationBlend);
    let plainly = |planner| CandidateFamily { planner, keeps_tolerance: false, has_limited_axes: false };
    blends.chain(others.map(plainly)).filter_map(guess).collect()
}

/// Returns the machine with another way to blend corners if that is nearer to the runs; `None` if none is nearer or
/// the machine does not blend corners in time.
pub fn chosen_again(machine: &Machine, runs: &[Run], whitenings: &[Whitening]) -> Option<Machine> {
    let others = with_other_blends(machine);
    if others.is_empty() {
        return None;
    }
    let ways = [machine.clone()].into_iter().chain(others);
    nearest(ways, runs, whitenings).filter(|other| other.interpolator != machine.interpolator)
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

/// Returns the planner with the rapids limited as its family limits them, by each axis or along the path. Rapids are as fast
/// as recorded or, if no positions were recorded, as fast as in the machine file and with the filters.
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
    let of = |seen: &RapidPlateaus| match family {
        Planner::SquareCorner => seen.limited_along_path(planner, machine),
        _ => seen.limited_by_axis(planner, machine),
    };
    let mut machines: Vec<Machine> = plateaus.iter().map(of).collect();
    machines.iter_mut().for_each(|machine| limit_feed_as_rapids(machine, seen));
    machines
}
