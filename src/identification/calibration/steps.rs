//! Another family of controls: planners that change speed by a step at corners, where filters cannot tell what was recorded.
//!
//! Such a control has no filters worth the name. Its command ramps with an acceleration and a jerk along the path and
//! passes a corner with a step of the velocity of each axis, slower the sharper it is, down to a stop where it waits for
//! position; arcs have a centripetal acceleration ([`crate::simulation::feed::junction`]). The first guesses are the
//! best of a grid of steps and jerks; filters are left so short that they round nothing. Rapids keep the law that was
//! found for them.
//!
//! Source: two recorded mills, whose runs of programs that were not fitted to it predicts (`docs/diagnosis.md`).

use crate::identification::calibration::nearest;
use crate::identification::fit::{Run, Whitening};
use crate::machine::{InPosition, Junction, Machine, PLANNER_FILTER_S, TimeConstants};

/// Steps of velocity tried first, mm/s.
const STEPS: [f64; 4] = [1.0, 3.0, 8.0, 25.0];
/// Jerks tried first, mm/s³.
const JERKS: [f64; 4] = [1e4, 3e4, 1e5, 3e5];
/// Accelerations along the path that are fitted from, mm/s²: one that binds and one that hardly does. What a ramp loses
/// can be made up for at corners, so that there is more than one place where a fit may end.
const ACCELERATIONS: [f64; 2] = [500.0, 5000.0];
/// Centripetal acceleration, mm/s², turn from which on corners are stops, rad, and wait for position there, s, before
/// they are fitted.
const CENTRIPETAL: f64 = 600.0;
const ANGLE: f64 = 0.44;
const IN_POSITION: f64 = 0.03;

/// The planners of each acceleration that are nearest to the runs, before any fit; none where the machine is no machine
/// of filters. `machine` is as it was, `fitted` has what filters needed.
pub fn guesses(machine: &Machine, fitted: &Machine, runs: &[Run], whitenings: &[Whitening]) -> Vec<Machine> {
    if !fitted.has_filters() || !matches!(fitted.interpolator.time_constants, TimeConstants::Equal(_)) {
        return Vec::new();
    }
    let mut plain = fitted.clone();
    let interpolator = &mut plain.interpolator;
    interpolator.time_constants = TimeConstants::Equal(PLANNER_FILTER_S / interpolator.filters as f64);
    interpolator.contour_tolerance = machine.interpolator.contour_tolerance;
    interpolator.arc_tolerance = None;
    interpolator.slowing_angle = interpolator.slowing_angle.min(ANGLE);
    plain.path.centripetal_acceleration = plain.path.centripetal_acceleration.min(CENTRIPETAL);
    plain.halts.in_position = plain.halts.in_position.max(IN_POSITION);
    plain.halts.in_position_at = InPosition::ExactStops;
    let guess = |acceleration: f64| {
        let pairs = JERKS.iter().flat_map(|jerk| STEPS.map(|step| (*jerk, step)));
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
