//! Waits of a machine that a recording shows: one parameter for each kind of stop that it contains.
//!
//! The first guess of each is the median, over its visits, of the time by which a visit exceeds the motion in it;
//! the fit then determines all of them together with the motion.

use std::collections::BTreeMap;

use crate::identification::alignment::median;
use crate::identification::comparison::Comparison;
use crate::identification::effects::{LONGEST_WAIT_S, StopKind};
use crate::identification::fit::Run;
use crate::machine::Machine;
use crate::simulation::toolpath::{Stop, StopCause, Toolpath};

/// Returns the kinds of stops in the recordings, each with a first guess, s; `compared` are the comparisons of the runs
/// with the machine.
pub fn guesses(machine: &Machine, runs: &[Run], compared: &[Comparison]) -> Vec<(StopKind, f64)> {
    let mut samples: BTreeMap<StopKind, Vec<f64>> = BTreeMap::new();
    let changes = |toolpath: &Toolpath| {
        let is_change = |stop: &Stop| matches!(stop.cause, StopCause::ToolChange { .. });
        let all: Vec<usize> =
            (0..toolpath.stops.len()).filter(|at| is_change(&toolpath.stops[*at])).collect();
        all
    };
    // Of programs with one change each, first and others are the same.
    let has_others = runs.iter().any(|run| 1 < changes(run.toolpath).len());
    for (toolpath, comparison) in runs.iter().map(|run| run.toolpath).zip(compared) {
        let first = changes(toolpath).first().copied().filter(|_| has_others);
        for visit in comparison.lost.iter().filter(|visit| visit.waits()) {
            let kind = |at: usize| match StopKind::of(&toolpath.stops[at].cause) {
                Some(StopKind::ToolChange) if first == Some(at) => Some(StopKind::FirstToolChange),
                kind => kind,
            };
            let kinds: Vec<StopKind> = visit.stops.clone().filter_map(kind).collect();
            for kind in &kinds {
                // What several stops of one line took cannot be told apart there: each gets its part.
                let seconds = kind.value(machine) + visit.seconds() / kinds.len() as f64;
                samples.entry(*kind).or_default().push(seconds);
            }
        }
    }
    let guess = |mut seconds: Vec<f64>| median(&mut seconds).clamp(0.0, LONGEST_WAIT_S);
    samples.into_iter().map(|(kind, seconds)| (kind, guess(seconds))).collect()
}

/// Returns the time by which the recorded machine takes longer than the simulated one from the start of a program
/// to its first block, s; the median over the runs.
pub fn start_guess(compared: &[Comparison]) -> f64 {
    let first = compared.iter().filter_map(|comparison| comparison.residuals.get(1).copied());
    let mut seconds: Vec<f64> = first.collect();
    median(&mut seconds).clamp(-LONGEST_WAIT_S, LONGEST_WAIT_S)
}
