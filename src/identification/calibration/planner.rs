//! Another family of controls: planners of trapezoids, where filters cannot tell what was recorded.
//!
//! Filters ramp in a constant time, whatever the step; planners that are limited in acceleration ramp in
//! Δv/a. If a fit of filters leaves much more than a planner that blends corners at the acceleration of its
//! axes ([`crate::simulation::feed::blend`]), the machine is one of these. The first guess is the best of a
//! few accelerations, the same for all axes; axes are as fast as the rapid feed, singly or along the path.

use crate::identification::calibration::nearest;
use crate::identification::fit::{Run, Whitening};
use crate::machine::{Junction, Machine, TimeConstants};

/// Accelerations tried first, mm/s².
const ACCELERATIONS: [f64; 10] = [50.0, 100.0, 200.0, 350.0, 500.0, 800.0, 1300.0, 2500.0, 5000.0, 10_000.0];
/// The filter that is left: half a servo period, which rounds nothing.
pub const CONSTANT: f64 = 5e-4;

/// The planner that is nearest to the runs, before any fit. `machine` is as it was, `fitted` has the waits and
/// the rapid feed that filters need.
pub fn guess(machine: &Machine, fitted: &Machine, runs: &[Run], whitenings: &[Whitening]) -> Machine {
    let rapids = [machine.rapid.feedrate, fitted.rapid.feedrate];
    let mut all = Vec::new();
    for acceleration in ACCELERATIONS {
        for feedrate in rapids {
            for by_axis in [true, false] {
                let mut planner = fitted.clone();
                planner.interpolator.contour_tolerance = machine.interpolator.contour_tolerance;
                planner.rapid.feedrate = feedrate;
                become_planner(&mut planner, acceleration, by_axis);
                all.push(planner);
            }
        }
    }
    nearest(all, runs, whitenings).unwrap_or_else(|| fitted.clone())
}

/// Makes a machine one of the family, all axes with this acceleration (mm/s²) or their own lower one; each
/// axis is as fast as the rapid feed `by_axis`, or else the path is.
pub fn become_planner(machine: &mut Machine, acceleration: f64, by_axis: bool) {
    machine.interpolator.junction = Junction::AccelerationBlend;
    machine.interpolator.filters = 1;
    machine.interpolator.time_constants = TimeConstants::Equal(CONSTANT);
    machine.rapid.time_constants = Some(TimeConstants::Equal(CONSTANT));
    for axis in &mut machine.axes {
        axis.acceleration = axis.acceleration.min(acceleration);
        if by_axis {
            axis.velocity = axis.velocity.min(machine.rapid.feedrate);
        }
    }
    if by_axis {
        machine.rapid.feedrate *= 3f64.sqrt();
    }
}
