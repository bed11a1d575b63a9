//! Is a cause better where it was not fitted, and nowhere else?
//!
//! The path is cut into contiguous sections. A cause is held against each section with the values that the
//! other sections give ([`left_out`]); it holds if it is better, all sections together, and in most of those in
//! which it makes a difference at all. A cause that acts in one section alone, a wait, has no other section to be
//! tried in, and this gate says nothing of it; but no wait at a word repeats exactly ([`is_beyond_chance`]).

use std::ops::Range;

use crate::identification::diagnosis::evidence::{Candidate, Evidence};
use crate::identification::fit::{Run, cost, held_out_blocks};
use crate::machine::Machine;

/// By how much the cost must fall, beside ln n a parameter.
pub const GAIN: f64 = 12.0;
/// Sections of a run.
const SECTIONS: usize = 8;
/// A section in which the cost changes by less than this tells nothing.
const TELLS: f64 = 1.0;
/// A cause acts where this part of the information on it lies.
const ACTS: f64 = 1e-3;
/// In so many of the sections that tell it must be better.
const MOSTLY: f64 = 0.6;

/// How a cause did in sections that it was not fitted to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeldOut {
    /// Sections in which it was better.
    pub better: usize,
    /// Sections in which it was worse.
    pub worse: usize,
    /// By how much the cost fell, all sections together.
    pub gain: f64,
}

impl HeldOut {
    /// Whether it is better where it was not fitted.
    pub fn holds(&self) -> bool {
        0.0 < self.gain && MOSTLY <= self.share()
    }

    /// The part of the sections that tell in which it is better.
    pub fn share(&self) -> f64 {
        self.better as f64 / (self.better + self.worse).max(1) as f64
    }
}

/// Sections of each of so many runs: many short ones, as excerpts are, are sections themselves.
fn sections_of_each(runs: usize) -> usize {
    if SECTIONS < runs { 1 } else { SECTIONS }
}

/// How many sections there are in all.
fn sections(runs: &[Run]) -> usize {
    sections_of_each(runs.len()) * runs.len()
}

/// By how much the cost must fall for a cause of so many parameters.
pub fn price(runs: &[Run], parameters: usize) -> f64 {
    GAIN + parameters as f64 * (sections(runs) as f64).ln()
}

/// Contiguous parts of so many residuals, about as many as `sections`.
fn cut(count: usize, sections: usize) -> Vec<Range<usize>> {
    let length = count.div_ceil(sections).max(1);
    (0..count).step_by(length).map(|first| first..(first + length).min(count)).collect()
}

/// How causes do against those before, section by section, both with the values that the other sections give; none
/// where the first of them, the new one, acts in one section alone.
pub fn held_out(
    evidence: &Evidence,
    base: &Machine,
    before: &[Candidate],
    after: &[Candidate],
) -> Option<HeldOut> {
    let sections = sections_of_each(evidence.runs.len());
    let left_out = |all: &[Candidate]| {
        let (base, freed) = evidence.freed(base, all);
        held_out_blocks(&base, evidence.runs, &freed, &evidence.whitenings, |count| cut(count, sections))
    };
    let own =
        after.first().filter(|cause| cause.hypothesis.is_continuous).map_or(0, |cause| cause.values.len());
    let mut held = HeldOut { better: 0, worse: 0, gain: 0.0 };
    for (before, after) in left_out(before).iter().zip(&left_out(after)) {
        let acts = own == 0 || after.shares[..own].iter().any(|share| ACTS < *share);
        if !acts || !(0..own).all(|value| after.is_known(value)) {
            continue;
        }
        let gain = cost(&before.whitened) - cost(&after.whitened);
        held.gain += gain;
        if TELLS < gain {
            held.better += 1;
        } else if gain < -TELLS {
            held.worse += 1;
        }
    }
    (1 < held.better + held.worse).then_some(held)
}

/// The evidence without the stretch, as long as a section, in which a machine is worst beside a better one.
pub fn without_worst<'a>(evidence: &Evidence<'a>, better: &Machine, worse: &Machine) -> Evidence<'a> {
    let sections = sections_of_each(evidence.runs.len());
    let (better, worse) = (evidence.whitened(better), evidence.whitened(worse));
    let of_run = |(run, (better, worse)): (usize, (&Vec<f64>, &Vec<f64>))| {
        let by = |at: usize| cost(&worse[at..=at]) - cost(&better[at..=at]);
        let length = worse.len().div_ceil(sections);
        let mut sum: f64 = (0..length).map(by).sum();
        let mut worst = (sum, run, 0..length);
        for next in length..worse.len() {
            sum += by(next) - by(next - length);
            if worst.0 < sum {
                worst = (sum, run, next + 1 - length..next + 1);
            }
        }
        worst
    };
    let worst = better.iter().zip(&worse).enumerate().map(of_run).max_by(|a, b| a.0.total_cmp(&b.0));
    let mut rest = evidence.clone();
    if let Some((_, run, stretch)) = worst {
        rest.whitenings[run].ignore(|mark| stretch.contains(&mark));
    }
    rest
}

/// The cycle of the PLC that answers words, s: that of LinuxCNC's iocontrol as it is recorded here; others take 10 to 20 ms.
const PLC_CYCLE_S: f64 = 0.02;
/// Standard deviations by which chance moves a wait at most.
const MAX_CHANCE: f64 = 3.0;

/// Whether waits at a word are longer or shorter, `each` by so much and all of the runs together by `all` (s), than chance makes
/// them. A word waits for the next cycle of the PLC, and its answer for one more, each anywhere within a cycle T: one
/// wait varies by T √(2/12), and the mean of n waits differs from the mean of as many that the machine file is from by
/// √(2/n) times that, T/√(3 n). With `all` = n `each` that is held against `each`.
pub fn is_beyond_chance(each: f64, all: f64) -> bool {
    MAX_CHANCE * PLC_CYCLE_S / 3f64.sqrt() < (each * all).abs().sqrt()
}

/// Shifts that are tried.
const SHIFTS: usize = 300;
/// By how much the fit in place must be better than the best of the shifted ones.
const IN_PLACE: f64 = 1.25;

/// Whether the trace of a cause fits the residuals where it is, and not as well where it is shifted to: a
/// residual that wanders by itself fits anything a little, anywhere.
pub fn stays_in_place(evidence: &Evidence, without: &Machine, with: &Machine) -> bool {
    let (before, after) = (evidence.whitened(without), evidence.whitened(with));
    let clamp = |value: f64| value.clamp(-5.0, 5.0);
    let observed: Vec<f64> = before.iter().flatten().map(|value| clamp(*value)).collect();
    let trace: Vec<f64> =
        before.iter().flatten().zip(after.iter().flatten()).map(|(b, a)| clamp(b - a)).collect();
    let count = observed.len();
    let fits = |shift: usize| -> f64 {
        let shifted = observed[shift..].iter().chain(&observed[..shift]);
        shifted.zip(&trace).map(|(observed, trace)| observed * trace).sum()
    };
    let step = (count / (SHIFTS + 1)).max(1);
    // Neighbours of the place itself are the place.
    let shifted = (10..=SHIFTS.saturating_sub(10)).map(|at| (at * step) % count.max(1)).map(fits);
    IN_PLACE * shifted.fold(0.0, f64::max) < fits(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_short_waits_are_beyond_chance_where_one_is_not() {
        // As long as a cycle for the word and one for its answer take at most.
        assert!(!is_beyond_chance(0.03, 0.03) && is_beyond_chance(0.04, 0.04));
        assert!(!is_beyond_chance(0.0235, 2.0 * 0.0235));
        assert!(is_beyond_chance(0.0235, 4.0 * 0.0235) && is_beyond_chance(-0.0235, -4.0 * 0.0235));
    }
}
