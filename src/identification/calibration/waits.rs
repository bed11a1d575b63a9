//! What of a machine's waits a recording shows: one parameter for each kind of stop it ran through.
//!
//! The first guess of each is the median, over its visits, of what the visit took longer than the motion
//! in it; the fit then takes all of them together with the motion.

use std::collections::BTreeMap;

use crate::identification::alignment::median;
use crate::identification::comparison::Comparison;
use crate::identification::effects::{Kind, LONGEST_WAIT_S};
use crate::machine::Machine;
use crate::simulation::toolpath::{Stop, StopCause, Toolpath};

/// The kinds of stops in what was recorded, with a first guess of each (s) and how often it came.
pub fn guesses(machine: &Machine, compared: &[(&Toolpath, &Comparison)]) -> Vec<(Kind, f64, usize)> {
    let mut samples: BTreeMap<Kind, Vec<f64>> = BTreeMap::new();
    let changes = |toolpath: &Toolpath| {
        let is_change = |stop: &Stop| matches!(stop.cause, StopCause::ToolChange { .. });
        let all: Vec<usize> =
            (0..toolpath.stops.len()).filter(|at| is_change(&toolpath.stops[*at])).collect();
        all
    };
    // Of programs with one change each, first and others are the same.
    let has_others = compared.iter().any(|(toolpath, _)| 1 < changes(toolpath).len());
    for (toolpath, comparison) in compared {
        let first = changes(toolpath).first().copied().filter(|_| has_others);
        for visit in comparison.lost.iter().filter(|visit| visit.waits()) {
            let kind = |at: usize| match Kind::of(&toolpath.stops[at].cause) {
                Some(Kind::ToolChange) if first == Some(at) => Some(Kind::FirstToolChange),
                kind => kind,
            };
            let kinds: Vec<Kind> = visit.stops.clone().filter_map(kind).collect();
            for kind in &kinds {
                // What several stops of one line took cannot be told apart there: each gets its part.
                let seconds = kind.value(machine) + visit.seconds() / kinds.len() as f64;
                samples.entry(*kind).or_default().push(seconds);
            }
        }
    }
    let guess = |(kind, mut seconds): (Kind, Vec<f64>)| {
        let count = seconds.len();
        (kind, median(&mut seconds).clamp(0.0, LONGEST_WAIT_S), count)
    };
    samples.into_iter().map(guess).collect()
}

/// By how much longer than simulated the time from the start of a program to its first block is, s.
pub fn start_guess(compared: &[(&Toolpath, &Comparison)]) -> f64 {
    let first = compared.iter().filter_map(|(_, comparison)| comparison.residuals.get(1).copied());
    let mut seconds: Vec<f64> = first.collect();
    median(&mut seconds).clamp(-LONGEST_WAIT_S, LONGEST_WAIT_S)
}
