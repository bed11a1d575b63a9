//! Waits at functions, read off a polled log.
//!
//! A control whose line is polled a few times a second shows for each tool change, spindle start or coolant word how
//! long it waited there, and no other block waits as long. The time by which a visit took longer than in the simulation
//! is the wait that was left out; the wait of a kind of word is the median over its visits. All kinds are accepted at
//! once: one after another they would use up the rounds in which the motion is examined.
//!
//! Limits: an operator who waits at the same word every time cannot be distinguished from a machine that does.

use crate::identification::alignment::Method;
use crate::identification::calibration::guesses;
use crate::identification::comparison::Comparison;
use crate::identification::diagnosis::evidence::{Candidate, Evidence, with_all};
use crate::identification::effects::{Hypothesis, StopKind};
use crate::identification::fit::Run;
use crate::machine::Machine;

/// Least difference of a wait from that of the machine file, s; a smaller one is within the resolution of a poll.
const MIN_WAIT_DIFFERENCE_S: f64 = 0.1;
/// Least gain of each wait beyond its price: a median of few visits is not a property of the machine.
const SURE: f64 = 20.0;

/// Returns the waits of polled runs that differ from those of a machine, all at once, each with its gain: by how much
/// the cost falls because of it. Only waits whose gain is well above the price count.
pub fn at_functions(
    base: &Machine,
    runs: &[Run],
    library: &[Hypothesis],
    price: f64,
) -> Vec<(Candidate, f64)> {
    if runs.iter().any(|run| run.alignment.method != Method::Lines) {
        return Vec::new();
    }
    let compared: Vec<Comparison> = runs.iter().map(|run| run.compared(base)).collect();
    let candidate = |(kind, seconds): (StopKind, f64)| {
        let of_kind =
            |own: &&Hypothesis| own.freed.first().is_some_and(|freed| freed.handle == kind.handle());
        let hypothesis = library.iter().find(of_kind)?.clone();
        let is_off = MIN_WAIT_DIFFERENCE_S < (seconds - kind.value(base)).abs();
        is_off.then(|| Candidate::read_off(hypothesis, seconds, f64::NAN))
    };
    let mut all: Vec<Candidate> = guesses(base, runs, &compared).into_iter().filter_map(candidate).collect();
    // What the others make unnecessary is not one of them; the least necessary goes first.
    loop {
        let gains = Evidence::of(runs, &with_all(base, &all)).gains(base, &all);
        let Some(least) = (0..all.len()).min_by(|a, b| gains[*a].total_cmp(&gains[*b])) else {
            return Vec::new();
        };
        if price + SURE < gains[least] {
            return all.into_iter().zip(gains).collect();
        }
        all.remove(least);
    }
}
