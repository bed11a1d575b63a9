//! Another family of controls: planners with steps of velocity at corners, for recordings that filters cannot
//! explain.
//!
//! Such a control has practically no filters. Its command ramps with an acceleration and a jerk along the path and
//! passes a corner with a step of the velocity of each axis. The sharper the corner, the slower the command, down
//! to a stop where it waits for position; arcs have a centripetal acceleration
//! ([`crate::simulation::feed::junction`]). The first guesses are the best of a grid of steps and jerks; the
//! filters are so short that they round nothing. Rapids keep the law that was found for them.
//!
//! Source: two recorded mills; the model predicts their runs of programs that were not fitted to it
//! (`docs/diagnosis.md`).

use crate::identification::calibration::nearest;
use crate::identification::fit::{Run, Whitening};
use crate::machine::{InPosition, Junction, Machine, PLANNER_FILTER_S, TimeConstants};

/// Steps of velocity tried first, mm/s.
const FIRST_VELOCITY_STEPS_MM_S: [f64; 4] = [1.0, 3.0, 8.0, 25.0];
/// Jerks along the path tried first, mm/s³.
const JERKS: [f64; 4] = [1e4, 3e4, 1e5, 3e5];
/// Accelerations along the path from which fits start, mm/s²: one that limits the motion and one that hardly does.
/// Time lost on ramps can be made up for at corners, so a fit may end at more than one place.
const ACCELERATIONS: [f64; 2] = [500.0, 5000.0];
/// Centripetal acceleration from which fits start, mm/s².
const FIRST_CENTRIPETAL_MM_S2: f64 = 600.0;
/// Turn from which on corners are stops, before it is fitted, rad.
const FIRST_STOP_TURN_RAD: f64 = 0.44;
/// Wait for position at these stops, before it is fitted, s.
const FIRST_POSITION_WAIT_S: f64 = 0.03;

/// Returns the planner of each acceleration that is nearest to the runs, before any fit; empty if the machine does
/// not have filters of one time constant. `machine` is the machine before the calibration; `fitted` has the values
/// that filters need.
pub fn guesses(machine: &Machine, fitted: &Machine, runs: &[Run], whitenings: &[Whitening]) -> Vec<Machine> {
    if !fitted.has_filters() || !matches!(fitted.interpolator.time_constants, TimeConstants::Equal(_)) {
        return Vec::new();
    }
    let mut plain = fitted.clone();
    let interpolator = &mut plain.interpolator;
    interpolator.time_constants = TimeConstants::Equal(PLANNER_FILTER_S / interpolator.filters as f64);
    interpolator.contour_tolerance = machine.interpolator.contour_tolerance;
    interpolator.arc_tolerance = None;
    interpolator.slowing_angle = interpolator.slowing_angle.min(FIRST_STOP_TURN_RAD);
    plain.path.centripetal_acceleration = plain.path.centripetal_acceleration.min(FIRST_CENTRIPETAL_MM_S2);
    plain.halts.in_position = plain.halts.in_position.max(FIRST_POSITION_WAIT_S);
    plain.halts.in_position_at = InPosition::ExactStops;
    let guess = |acceleration: f64| {
        let pairs = JERKS.iter().flat_map(|jerk| FIRST_VELOCITY_STEPS_MM_S.map(|step| (*jerk, step)));
        let planners = pairs.map(|(jerk, step)| {
            let mut planner = plain.clone();
            planner.interpolator.junction = Junction::AxisStep(step);
            (planner.path.acceleration, planner.path.jerk) = (acceleration, jerk);
            planner
        });
        nearest(planners, runs, whitenings)
    };
    ACCELERATIONS.into_iter().filter_map(guess).collect()
}
