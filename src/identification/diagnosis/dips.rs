//! Dips: the recorded machine loses time at one place though it does not come to rest.
//!
//! ```text
//! feedrate
//!    ──────╮          ╭──────   a hold hardly longer than the filter delay: the filters never run
//!           ╲        ╱          empty, or so briefly that no samples stand still
//!            ╲__  __╱
//!               ╲╱
//!          |←delay→|
//! ```
//!
//! Along the fixes of a recording the time that is lost within twice the filter delay is looked at, window by window. One
//! window that loses [`LEAST`] s and [`ALONE`] times as much as any that does not touch it is a dip; of a limit or a
//! rule, which act in many places, there is none. No stop of the program may be near: there a machine waits.
//!
//! Limits: one dip a run, the largest, where positions were recorded; a corner that alone is taken more slowly
//! than the machine file says is one too, and is told apart by what else explains it.

use crate::identification::alignment::Method;
use crate::identification::diagnosis;
use crate::identification::diagnosis::rests::{Rest, lost_between, rest_at, stops_within};
use crate::identification::fit::Run;
use crate::machine::Machine;
use crate::simulation::profile::Profile;

/// The least that is lost in a dip, s: each half of it, by which its place is known, is as much as a cause must explain.
const LEAST: f64 = 2.0 * diagnosis::LEAST;
/// A stop is in a window, or so near to its ends, mm.
const STOP_NEAR: f64 = 0.1;
/// It loses so many times as much as any other window.
const ALONE: f64 = 4.0;

/// The dip of a run that a machine does not have.
pub fn dip(machine: &Machine, run: &Run) -> Option<Rest> {
    let fixes = &run.alignment.fixes;
    if run.alignment.method != Method::Positions {
        return None;
    }
    let machine = run.machine(machine);
    let plan = run.plan(&machine);
    let profile = Profile::new(run.toolpath, &plan);
    let lost_between = lost_between(run, &machine, &profile);
    let window = 2.0 * plan.longest_delay();
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
    if lost < LEAST.max(ALONE * most) {
        return None;
    }
    // The tool is slowest about where the command was taken away: there half is lost.
    let so_far: Vec<f64> = (from..=to).map(|at| lost_between(from, at)).collect();
    let half = so_far.partition_point(|so_far| *so_far < 0.5 * lost);
    let at = fixes[(from + half).min(to)].distance;
    let near = 0.5 * (fixes[to].distance - fixes[from].distance);
    rest_at(run, &profile, at, near, lost).filter(|rest| rest.place.is_some())
}
