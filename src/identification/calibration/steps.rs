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
use crate::identification::effects::parameters;
use crate::identification::fit::{Run, Whitening};
use crate::machine::{InPosition, Machine, PLANNER_FILTER_S, TimeConstants};

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
    interpolator.slowing_angle = interpolator.slowing_angle.min(parameters::SLOWING_ANGLE.guesses[0]);
    plain.path.centripetal_acceleration =
        plain.path.centripetal_acceleration.min(parameters::FIRST_CENTRIPETAL_MM_S2);
    plain.halts.in_position = plain.halts.in_position.max(parameters::IN_POSITION_WAIT.guesses[0]);
    plain.halts.in_position_at = InPosition::ExactStops;
    let guess = |planner: Machine| {
        let ramps = parameters::PATH_JERK.guesses_on(&planner);
        nearest(
            ramps.iter().flat_map(|ramps| parameters::AXIS_VELOCITY_STEP.guesses_on(ramps)),
            runs,
            whitenings,
        )
    };
    parameters::PATH_ACCELERATION.guesses_on(&plain).into_iter().filter_map(guess).collect()
}
