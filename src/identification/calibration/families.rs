//! Other families of controls: planners of trapezoids, where filters cannot tell what was recorded.
//!
//! Filters ramp in a constant time, whatever the step; planners that are limited in acceleration ramp in Δv/a. Each
//! family of [`Planner`] has its own law of corners ([`crate::simulation::feed::junction`]). The guess of a family is the
//! nearest of a grid: first of accelerations, the same for all axes, with rapids limited by each axis or along the path,
//! then of the value of its law of corners. Rapids are as fast as their plateaus (`rapids`).

use crate::identification::calibration::nearest;
use crate::identification::calibration::rapids::RapidPlateaus;
use crate::identification::fit::{Run, Whitening};
use crate::machine::{Junction, Machine, Planner};

/// Accelerations tried first, mm/s².
const ACCELERATIONS: [f64; 10] = [50.0, 100.0, 200.0, 350.0, 500.0, 800.0, 1300.0, 2500.0, 5000.0, 10_000.0];
/// Values of the law of corners tried first, as ratios of the usual one.
const CORNER_RATIOS: [f64; 7] = [0.05, 0.15, 0.4, 1.0, 2.5, 6.0, 20.0];
/// Largest feed overrides that LinuxCNC is set up for.
const MAX_OVERRIDES: [f64; 4] = [1.0, 1.2, 1.5, 2.0];

/// The machine of each family that is nearest to the runs, before any fit. `machine` is as it was, `fitted` has the waits
/// and the rapid feed that filters need. Where axes were never faster than at a speed that they had again and again, blends are
/// guessed with that limit as well.
pub fn guesses(
    machine: &Machine,
    fitted: &Machine,
    runs: &[Run],
    whitenings: &[Whitening],
    plateaus: Option<RapidPlateaus>,
) -> Vec<Machine> {
    let mut plain = fitted.clone();
    plain.interpolator.contour_tolerance = machine.interpolator.contour_tolerance;
    let guess = |(planner, has_limited_axes): (Planner, bool)| {
        let at = |acceleration: f64| {
            let mut of = plain.clone();
            of.become_planner(planner, acceleration);
            if planner != Planner::AccelerationBlend {
                return vec![of];
            }
            if let Some(seen) = plateaus {
                seen.limit_feed(&mut of);
                of = seen.limited_to_fastest(&of).filter(|_| has_limited_axes).unwrap_or(of);
            }
            // A tolerance that the machine file has may be one that the control is started with.
            let mut given = of.clone();
            given.interpolator.contour_tolerance = machine.interpolator.contour_tolerance;
            vec![of, given]
        };
        let ramps = ACCELERATIONS.into_iter().flat_map(at);
        let grid = ramps.flat_map(|of| with_rapids(planner, &of, machine, fitted, plateaus));
        let nearest_ramps = nearest(grid, runs, whitenings)?;
        let corners = CORNER_RATIOS.map(|ratio| nearest_ramps.with_scaled_junction(ratio));
        let found = nearest(corners, runs, whitenings)?;
        match planner {
            Planner::AccelerationBlend => nearest(with_circles(&found), runs, whitenings),
            _ => Some(found),
        }
    };
    let limited = plateaus.and_then(|seen| seen.limited_to_fastest(&plain));
    let planners = Planner::ALL.map(|planner| (planner, false));
    let limited = limited.map(|_| (Planner::AccelerationBlend, true));
    planners.into_iter().chain(limited).filter_map(guess).collect()
}

/// The machine with another way to blend corners, where that is nearer to the runs.
pub fn chosen_again(machine: &Machine, runs: &[Run], whitenings: &[Whitening]) -> Option<Machine> {
    if !machine.interpolator.junction.blends_in_time() {
        return None;
    }
    let ways = with_circles(machine).into_iter().chain([with_parabolas(machine)]);
    nearest(ways, runs, whitenings).filter(|other| other.interpolator != machine.interpolator)
}

/// Circles at corners for the largest override that may be planned for.
fn with_circles(planner: &Machine) -> Vec<Machine> {
    let with = |ratio: f64| {
        let mut machine = planner.clone();
        machine.interpolator.junction = Junction::AccelerationBlend;
        machine.interpolator.max_override = ratio;
        machine
    };
    MAX_OVERRIDES.map(with).to_vec()
}

/// Parabolas at corners.
fn with_parabolas(planner: &Machine) -> Machine {
    let mut machine = planner.clone();
    machine.interpolator.junction = Junction::ParabolicBlend;
    machine
}

/// Ways in which the rapids of a family may be limited: by each axis or, where its control knows that, along the path; as fast as
/// they were recorded or, where no positions were recorded, as fast as the machine file and the filters say.
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
    let of = |seen: &RapidPlateaus| {
        let [by_axis, along_path] = seen.given(planner, machine);
        // Klipper's rapids are moves with a feedrate like any other; the others run each axis at its own rate.
        let is_free = family == Planner::SquareCorner;
        [by_axis].into_iter().chain(is_free.then_some(along_path)).collect::<Vec<_>>()
    };
    plateaus.iter().flat_map(of).collect()
}
