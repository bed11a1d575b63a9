//! Other families of controls: planners of trapezoids, where filters cannot tell what was recorded.
//!
//! Filters ramp in a constant time, whatever the step; planners that are limited in acceleration ramp in Δv/a. Each
//! family of [`Planner`] has its own law of corners ([`crate::simulation::feed::junction`]). The guess of a family is the
//! nearest of a grid: first of accelerations, the same for all axes, with rapids limited by each axis or along the path,
//! then of the value of its law of corners. Rapids are as fast as their plateaus (`rapids`).

use crate::identification::calibration::nearest;
use crate::identification::calibration::rapids::RapidPlateaus;
use crate::identification::fit::{Run, Whitening};
use crate::machine::{Machine, Planner};

/// Accelerations tried first, mm/s².
const ACCELERATIONS: [f64; 10] = [50.0, 100.0, 200.0, 350.0, 500.0, 800.0, 1300.0, 2500.0, 5000.0, 10_000.0];
/// Values of the law of corners tried first, as ratios of the usual one.
const CORNER_RATIOS: [f64; 7] = [0.05, 0.15, 0.4, 1.0, 2.5, 6.0, 20.0];
/// A contour tolerance that no blend reaches, mm.
const FREE_BLEND: f64 = 10.0;

/// The machine of each family that is nearest to the runs, before any fit. `machine` is as it was, `fitted` has the waits
/// and the rapid feed that filters need.
pub fn guesses(
    machine: &Machine,
    fitted: &Machine,
    runs: &[Run],
    whitenings: &[Whitening],
    plateaus: Option<RapidPlateaus>,
) -> Vec<Machine> {
    let mut plain = fitted.clone();
    plain.interpolator.contour_tolerance = machine.interpolator.contour_tolerance;
    let guess = |planner: Planner| {
        let at = |acceleration: f64| {
            let mut of = plain.clone();
            of.become_planner(planner, acceleration);
            // A blend without a tolerance is one that is wide enough.
            let free = (planner == Planner::AccelerationBlend).then(|| {
                let mut free = of.clone();
                free.interpolator.contour_tolerance = FREE_BLEND;
                free
            });
            [of].into_iter().chain(free)
        };
        let ramps = ACCELERATIONS.into_iter().flat_map(at);
        let grid = ramps.flat_map(|of| with_rapids(&of, machine, fitted, plateaus));
        let nearest_ramps = nearest(grid, runs, whitenings)?;
        let corners = CORNER_RATIOS.map(|ratio| nearest_ramps.with_scaled_junction(ratio));
        nearest(corners, runs, whitenings)
    };
    Planner::ALL.into_iter().filter_map(guess).collect()
}

/// Ways in which rapids may be limited: by each axis or along the path, as fast as they were recorded; where no positions
/// were recorded, as fast as the machine file and the filters say.
fn with_rapids(
    planner: &Machine,
    machine: &Machine,
    fitted: &Machine,
    seen: Option<RapidPlateaus>,
) -> Vec<Machine> {
    let rates = [machine.fastest_rapid(), fitted.fastest_rapid()];
    let told = rates.map(|rate| RapidPlateaus { path: Some(rate), axes: [Some(rate); 3] });
    let plateaus = seen.map_or(told.to_vec(), |seen| vec![seen]);
    plateaus.iter().flat_map(|seen| seen.given(planner, machine)).collect()
}
