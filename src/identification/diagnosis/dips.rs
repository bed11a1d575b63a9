//! Dips: the recorded machine loses time at one place without coming to rest.
//!
//! ```text
//! feedrate
//!    ──────╮          ╭──────   a hold hardly longer than the machine needs to stop: it never stands
//!           ╲        ╱          still, or so briefly that no samples show it
//!            ╲__  __╱
//!               ╲╱
//!          |←stops→|
//! ```
//!
//! A window begins at each fix of a recording and lasts twice as long as the machine needs to stop. A window is a dip if
//! it loses at least [`MIN_DIP_S`] s and [`MIN_RATIO_TO_OTHERS`] times as much as any window that does not touch it.
//! Limits and rules act in many places and leave no dip. A window with a stop of the program in it or near it does not
//! count: there a machine waits.
//!
//! Limits: the search finds one dip per run, the largest, and needs recorded positions. A single corner that the
//! machine takes more slowly than its file says is a dip too; the other causes that explain it distinguish it from a
//! hold.

use crate::identification::alignment::Method;
use crate::identification::diagnosis;
use crate::identification::diagnosis::rests::{Rest, lost_between, rest_at, stopping_time, stops_within};
use crate::identification::fit::Run;
use crate::machine::Machine;
use crate::simulation::profile::Profile;

/// Least lost time of a dip, s: each half of it, which determines the place, is as much as a cause must explain.
const MIN_DIP_S: f64 = 2.0 * diagnosis::MIN_LOST_TIME_S;
/// Distance before and after a window within which a stop counts as in it, mm.
const STOP_NEAR: f64 = 0.1;
/// Least ratio of the lost time of a dip to that of any window that does not touch it.
const MIN_RATIO_TO_OTHERS: f64 = 4.0;

/// Returns the dip of a recorded run that a machine does not have; `None` without a dip or without positions.
pub fn dip(machine: &Machine, run: &Run) -> Option<Rest> {
    let fixes = &run.alignment.fixes;
    if run.alignment.method != Method::Positions {
        return None;
    }
    let machine = run.machine(machine);
    let plan = run.plan(&machine);
    let profile = Profile::new(run.toolpath, &plan);
    let lost_between = lost_between(run, &machine, &profile);
    let window = 2.0 * stopping_time(run, &machine, &plan);
    let end = |from: usize| fixes.partition_point(|fix| fix.time <= fixes[from].time + window) - 1;
    // Over a stop the tool stands at one distance for a while, and which of its samples is later there noise decides.
    let has_stop = |from: usize| {
        let part = fixes[from].distance - STOP_NEAR..=fixes[end(from)].distance + STOP_NEAR;
        !stops_within(run, &profile, part).is_empty()
    };
    let loss = |from: usize| if has_stop(from) { 0.0 } else { lost_between(from, end(from)) };
    let losses: Vec<f64> = (0..fixes.len()).map(loss).collect();
    let from = (0..fixes.len()).max_by(|a, b| losses[*a].total_cmp(&losses[*b]))?;
    let (to, lost) = (end(from), losses[from]);
    let before = fixes.partition_point(|fix| fix.time < fixes[from].time - window);
    let others = losses[..before].iter().chain(losses.get(to + 1..).unwrap_or_default());
    let most = others.fold(0.0, |most: f64, loss| most.max(loss.abs()));
    if lost < MIN_DIP_S.max(MIN_RATIO_TO_OTHERS * most) {
        return None;
    }
    // The tool is slowest about where the command was taken away: there half is lost.
    let so_far: Vec<f64> = (from..=to).map(|at| lost_between(from, at)).collect();
    let half = so_far.partition_point(|so_far| *so_far < 0.5 * lost);
    let at = fixes[(from + half).min(to)].distance;
    let near = 0.5 * (fixes[to].distance - fixes[from].distance);
    rest_at(run, &profile, at, near, lost).filter(|rest| rest.place.is_some())
}
