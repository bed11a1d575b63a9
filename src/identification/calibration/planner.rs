//! Another family of controls: planners of trapezoids, where filters cannot tell what was recorded.
//!
//! Filters ramp in a constant time, whatever the step; planners that are limited in acceleration ramp in
//! Δv/a. If a fit of filters leaves much more than a planner that blends corners at the acceleration of its
//! axes ([`crate::simulation::feed::blend`]), the machine is one of these. The first guess is the best of a
//! few accelerations, the same for all axes; axes are as fast as the rapid feed, singly or along the path.

use crate::identification::calibration::nearest;
use crate::identification::fit::{Run, Whitening};
use crate::machine::Machine;

/// Accelerations tried first, mm/s².
const ACCELERATIONS: [f64; 10] = [50.0, 100.0, 200.0, 350.0, 500.0, 800.0, 1300.0, 2500.0, 5000.0, 10_000.0];

/// The planner that is nearest to the runs, before any fit. `machine` is as it was, `fitted` has the waits and
/// the rapid feed that filters need.
pub fn guess(machine: &Machine, fitted: &Machine, runs: &[Run], whitenings: &[Whitening]) -> Machine {
    let rapids = [machine.fastest_rapid(), fitted.fastest_rapid()];
    let mut all = Vec::new();
    for acceleration in ACCELERATIONS {
        for feedrate in rapids {
            for by_axis in [true, false] {
                let mut planner = fitted.clone();
                planner.interpolator.contour_tolerance = machine.interpolator.contour_tolerance;
                planner.rapid.feedrate = feedrate;
                planner.become_planner(acceleration, by_axis);
                all.push(planner);
            }
        }
    }
    nearest(all, runs, whitenings).unwrap_or_else(|| fitted.clone())
}
