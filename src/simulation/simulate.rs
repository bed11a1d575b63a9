//! Toolpath and machine → [`FeedPlan`]: the front door of the simulation.
//!
//! The command is planned as in [`feed`](crate::simulation::feed), corrected until its path holds the contour
//! tolerance where the corner mode asks for that, and scaled in time where acceleration limits act behind the
//! filters. A plan that leaves this module is complete: nothing has to be added to it before its times are read.

use crate::machine::{CornerMode, Machine};
use crate::simulation::contour::{ContourErrors, contour_errors, guaranteed};
use crate::simulation::feed::{FeedPlan, Rule, Tolerances, command};
use crate::simulation::profile::{Profile, time_scaled};
use crate::simulation::toolpath::Toolpath;

/// The plan of a program on a machine, at the tolerances of the program or else the machine's.
pub fn simulate(toolpath: &Toolpath, machine: &Machine) -> FeedPlan {
    planned(toolpath, machine, Tolerances::Programmed, &mut |_| {}).0
}

/// The plan of a toolpath that holds a contour tolerance (mm), or the program's own, in the machine's corner
/// mode, with the contour errors of its profile. `progress` is called with the completed fraction, from 0 up to
/// but never reaching 1.
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

/// The cycle time (s) of [`within`], without the contour errors where the corner mode needs none.
pub fn cycle_time_within(
    toolpath: &Toolpath,
    machine: &Machine,
    tolerances: impl Into<Tolerances>,
    progress: &mut dyn FnMut(f64),
) -> f64 {
    planned(toolpath, machine, tolerances.into(), progress).0.cycle_time()
}

/// The plan of a toolpath whose corners and arcs are commanded by a rule, whatever the corner mode.
pub fn by_rule(toolpath: &Toolpath, machine: &Machine, rule: Rule) -> FeedPlan {
    time_scaled(toolpath, machine, command(toolpath, machine, rule))
}

/// The plan in the machine's corner mode, with the contour errors where the mode measures them.
fn planned(
    toolpath: &Toolpath,
    machine: &Machine,
    tolerances: Tolerances,
    progress: &mut dyn FnMut(f64),
) -> (FeedPlan, Option<ContourErrors>) {
    let isolated = command(toolpath, machine, tolerances.into());
    let (plan, errors) = match machine.interpolator.corner_mode {
        CornerMode::Paper => (isolated, None),
        CornerMode::Guaranteed => {
            let (plan, errors) = guaranteed(toolpath, machine, tolerances, isolated, progress);
            (plan, Some(errors))
        }
    };
    (time_scaled(toolpath, machine, plan), errors)
}
