//! Toolpath and machine → [`FeedPlan`]: the entry point of the simulation.
//!
//! The command is planned as in [`feed`](crate::simulation::feed), corrected until its path keeps the contour
//! tolerance if the corner mode requires that, and scaled in time if acceleration limits act behind the
//! filters. A plan from this module is complete: its times are the machine's.

use crate::machine::{CornerMode, Machine};
use crate::simulation::contour::{ContourErrors, contour_errors, guaranteed};
use crate::simulation::feed::{CornerPolicy, FeedPlan, Tolerances, command};
use crate::simulation::profile::{Profile, time_scaled};
use crate::simulation::toolpath::Toolpath;

/// Returns the plan of a program on a machine, at the program's tolerances, or at the machine's where the
/// program sets none.
///
/// # Examples
///
/// ```
/// use truefeed::machine::Machine;
/// use truefeed::simulation::{gcode::read, simulate, interpreter::trace};
///
/// let mut machine = Machine::default();
/// let toolpath = trace(&read(b"G21 G90 G1 X40 F3000\nY40\nX0"), &machine);
/// let corners_at_full_feed = 120.0 / 50.0;
/// let precise = simulate(&toolpath, &machine).cycle_time();
/// machine.interpolator.contour_tolerance = 0.1;
/// let quick = simulate(&toolpath, &machine).cycle_time();
/// assert!(corners_at_full_feed < quick && quick < precise, "s");
/// ```
pub fn simulate(toolpath: &Toolpath, machine: &Machine) -> FeedPlan {
    planned(toolpath, machine, Tolerances::Programmed, &mut |_| {}).0
}

/// Returns the plan of a toolpath for a contour tolerance (mm), or for the tolerances of the program, in the
/// machine's corner mode, with the contour errors of its profile. Calls `progress` with the completed
/// fraction, which stays below 1.
pub fn within(
    toolpath: &Toolpath,
    machine: &Machine,
    tolerances: impl Into<Tolerances>,
    progress: &mut dyn FnMut(f64),
) -> (FeedPlan, ContourErrors) {
    let (plan, errors) = planned(toolpath, machine, tolerances.into(), progress);
    // Time scaling keeps the path.
    let errors = errors.unwrap_or_else(|| contour_errors(toolpath, &plan, &Profile::new(toolpath, &plan)));
    (plan, errors)
}

/// Returns the cycle time (s) of [`within`]; does not measure contour errors unless the corner mode needs
/// them.
pub fn cycle_time_within(
    toolpath: &Toolpath,
    machine: &Machine,
    tolerances: impl Into<Tolerances>,
    progress: &mut dyn FnMut(f64),
) -> f64 {
    planned(toolpath, machine, tolerances.into(), progress).0.cycle_time()
}

/// Returns the plan of a toolpath whose corners and arcs follow a policy, whatever the corner mode.
pub fn with_policy(toolpath: &Toolpath, machine: &Machine, policy: CornerPolicy) -> FeedPlan {
    time_scaled(toolpath, machine, command(toolpath, machine, policy))
}

/// Returns the plan in the machine's corner mode, with the contour errors if the mode measures them.
fn planned(
    toolpath: &Toolpath,
    machine: &Machine,
    tolerances: Tolerances,
    progress: &mut dyn FnMut(f64),
) -> (FeedPlan, Option<ContourErrors>) {
    let isolated = command(toolpath, machine, tolerances.into());
    let (plan, errors) = match machine.interpolator.corner_mode {
        // Blends are within the tolerance by themselves, and a slower one is no smaller.
        CornerMode::Guaranteed if !machine.interpolator.junction.blends_in_time() => {
            let (plan, errors) = guaranteed(toolpath, machine, tolerances, isolated, progress);
            (plan, Some(errors))
        }
        _ => (isolated, None),
    };
    (time_scaled(toolpath, machine, plan), errors)
}
