//! Waits at functions, read off a polled log.
//!
//! A control that is asked for its line a few times a second says of each tool change, spindle start or coolant
//! word how long it stood there, and nothing else stands as long. What a visit took longer than the simulation is
//! the wait that was left out; of a kind of word it is the median over its visits. All kinds are taken in at
//! once: one after another they would use up the rounds in which the motion is looked at.
//!
//! Limits: an operator who waits at the same word every time is not told from a machine that does.

use crate::identification::alignment::Method;
use crate::identification::calibration::guesses;
use crate::identification::comparison::compare;
use crate::identification::diagnosis::evidence::{Candidate, Evidence, with_all};
use crate::identification::effects::{Hypothesis, Kind};
use crate::identification::fit::Run;
use crate::machine::Machine;

/// A wait that is off by less, s, is within what a poll shows.
const LEAST: f64 = 0.1;
/// By how much more than its price each must be worth it: a median of few visits is not one of the machine.
const SURE: f64 = 20.0;

/// The waits of polled runs that a machine has otherwise, all at once, each with what the cost falls by because
/// of it, where that is well more than the price.
pub fn at_functions(
    base: &Machine,
    runs: &[Run],
    library: &[Hypothesis],
    price: f64,
) -> Vec<(Candidate, f64)> {
    if runs.iter().any(|run| run.alignment.method != Method::Lines) {
        return Vec::new();
    }
    let compared: Vec<_> = runs
        .iter()
        .map(|run| (run.toolpath, compare(run.toolpath, &run.plan(base), run.alignment)))
        .collect();
    let pairs: Vec<_> = compared.iter().map(|(toolpath, comparison)| (*toolpath, comparison)).collect();
    let candidate = |(kind, seconds, _): (Kind, f64, usize)| {
        let of_kind =
            |own: &&Hypothesis| own.freed.first().is_some_and(|freed| freed.handle == kind.handle());
        let hypothesis = library.iter().find(of_kind)?.clone();
        let is_off = LEAST < (seconds - kind.value(base)).abs();
        let (values, deviations) = (vec![seconds], vec![f64::NAN]);
        is_off.then_some(Candidate { hypothesis, values, deviations, cost: f64::NAN, beside: Vec::new() })
    };
    let mut all: Vec<Candidate> = guesses(base, &pairs).into_iter().filter_map(candidate).collect();
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
