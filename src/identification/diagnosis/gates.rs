//! Acceptance tests of a cause: does it lower the cost in sections to which it was not fitted, and only in its place?
//!
//! The path is cut into contiguous sections. Each section is compared with the simulation at the values that the other
//! sections give ([`held_out`]). A cause passes if it lowers the cost of all sections together, and of most of those in
//! which it makes a difference. An override on a part of the path is tested in sections of that part. The test does not
//! apply to a cause that acts in one section alone, such as a wait, as no other section shows it; but no wait at a word
//! repeats exactly ([`is_beyond_chance`]).

use std::ops::Range;

use crate::identification::alignment::Mark;
use crate::identification::diagnosis::evidence::{Candidate, Evidence};
use crate::identification::effects::FEED_OVERRIDE;
use crate::identification::fit::{Run, cost, held_out_blocks};
use crate::machine::Machine;

/// Least reduction of the cost by a cause; ln n is added for each parameter, where n is the number of sections.
pub const MIN_COST_REDUCTION: f64 = 12.0;
/// Number of sections of a run.
const SECTIONS: usize = 8;
/// Least change of the cost of a section that counts for or against a cause.
const MIN_COST_CHANGE: f64 = 1.0;
/// Share of the information on a value above which a cause acts in a section.
const MIN_INFORMATION_SHARE: f64 = 1e-3;
/// Least share of the sections that count in which a cause must be better.
const MOSTLY: f64 = 0.6;

/// The result of a cause in sections to which it was not fitted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeldOut {
    /// Number of sections that are better with the cause.
    pub better: usize,
    /// Number of sections that are worse with the cause.
    pub worse: usize,
    /// Reduction of the cost, all sections together.
    pub gain: f64,
}

impl HeldOut {
    /// Returns `true` if the cause is better in the sections to which it was not fitted.
    pub fn holds(&self) -> bool {
        0.0 < self.gain && MOSTLY <= self.share()
    }

    /// Returns the share of the sections that count in which the cause is better.
    pub fn share(&self) -> f64 {
        self.better as f64 / (self.better + self.worse).max(1) as f64
    }
}

/// Returns the number of sections of each of `runs` runs: many short ones, such as excerpts, are one section each.
fn sections_of_each(runs: usize) -> usize {
    if SECTIONS < runs { 1 } else { SECTIONS }
}

/// Returns the number of sections of all runs together.
fn sections(runs: &[Run]) -> usize {
    sections_of_each(runs.len()) * runs.len()
}

/// Returns the price of a cause with this number of parameters: the least reduction of the cost that it must bring.
pub fn price(runs: &[Run], parameters: usize) -> f64 {
    MIN_COST_REDUCTION + parameters as f64 * (sections(runs) as f64).ln()
}

/// Returns contiguous parts of a range of residuals, about as many as `sections`.
fn cut(residuals: Range<usize>, sections: usize) -> Vec<Range<usize>> {
    let length = residuals.len().div_ceil(sections).max(1);
    let end = residuals.end;
    residuals.step_by(length).map(|first| first..(first + length).min(end)).collect()
}

/// Returns the range of the marks of each run on the part of the path on which a cause is an override; `None` if it is not an
/// override on a part of the path.
fn marks_of_override(cause: &Candidate, base: &Machine, runs: &[Run]) -> Option<Vec<Range<usize>>> {
    let overrides = cause.hypothesis.machine(base, &cause.values).overrides;
    if cause.hypothesis.effect != FEED_OVERRIDE || !overrides.has_span() {
        return None;
    }
    let of_run = |run: &Run| {
        let distances = run.toolpath.distances();
        let distance = |mark: &Mark| run.toolpath.begins_at + mark.place.distance(run.toolpath, &distances);
        let before = |edge: f64| run.alignment.marks.partition_point(|mark| distance(mark) < edge);
        before(overrides.span.0)..before(overrides.span.1)
    };
    Some(runs.iter().map(of_run).collect())
}

/// Compares `cause` beside the causes `beside` with the causes `before` section by section, all at the values that the
/// other sections give. `beside` are the causes `before`, fitted together with the cause. An override on a part of the path is
/// compared in sections of that part if several of them determine it. `None` if the cause acts in one section alone, so that
/// fewer than two sections count.
pub fn held_out(
    evidence: &Evidence,
    base: &Machine,
    before: &[Candidate],
    causes: (&Candidate, &[Candidate]),
) -> Option<HeldOut> {
    let in_place = marks_of_override(causes.0, base, evidence.runs).and_then(|marks| {
        let shown = marks.iter().filter(|marks| !marks.is_empty()).count();
        held_out_of(evidence, base, before, causes, |run, count| {
            // After the last run comes a block with the deviations from expected values.
            let marks = marks.get(run).cloned().unwrap_or(0..count);
            cut(marks, sections_of_each(shown))
        })
    });
    let sections = sections_of_each(evidence.runs.len());
    in_place.or_else(|| held_out_of(evidence, base, before, causes, |_, count| cut(0..count, sections)))
}

/// Compares as [`held_out`] does; `sections` returns the sections of a run, from its index and the number of its residuals.
fn held_out_of(
    evidence: &Evidence,
    base: &Machine,
    before: &[Candidate],
    (cause, beside): (&Candidate, &[Candidate]),
    sections: impl Fn(usize, usize) -> Vec<Range<usize>>,
) -> Option<HeldOut> {
    let left_out = |all: &[Candidate]| {
        let (base, freed) = evidence.freed(base, all);
        held_out_blocks(&base, evidence.runs, &freed, &evidence.whitenings, &sections)
    };
    // The values of the cause come first.
    let own = if cause.hypothesis.is_continuous() { cause.values.len() } else { 0 };
    let after: Vec<Candidate> = [cause].into_iter().chain(beside).cloned().collect();
    let (before, after) = (left_out(before), left_out(&after));
    // What a neighbour knows of a cause that acts in one section is too little to hold the section against it.
    if 0 < own && after.iter().any(|section| (0..own).all(|value| !section.is_known(value))) {
        return None;
    }
    let mut held = HeldOut { better: 0, worse: 0, gain: 0.0 };
    for (before, after) in before.iter().zip(&after) {
        let acts = own == 0 || after.shares[..own].iter().any(|share| MIN_INFORMATION_SHARE < *share);
        if !acts || !(0..own).all(|value| after.is_known(value)) {
            continue;
        }
        let gain = cost(&before.whitened) - cost(&after.whitened);
        held.gain += gain;
        if MIN_COST_CHANGE < gain {
            held.better += 1;
        } else if gain < -MIN_COST_CHANGE {
            held.worse += 1;
        }
    }
    (1 < held.better + held.worse).then_some(held)
}

/// Returns the evidence without one stretch as long as a section: the one in which the cost of `worse` exceeds that of
/// `better` most.
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

/// Cycle of the PLC that answers words, s: the cycle of LinuxCNC's iocontrol in the recordings of this project; other
/// PLCs take 10 to 20 ms.
const PLC_CYCLE_S: f64 = 0.02;
/// Largest change of a wait by chance, in standard deviations: no PLC keeps its cycle exactly, and among 24 tool changes
/// of LinuxCNC (seeds 28864806 and 67560038) one wait changed by 3.2 of them.
const MAX_CHANCE: f64 = 4.0;

/// Returns `true` if waits at a word differ from the machine file by more than chance: each by `each`, all of the runs
/// together by `all` (s). A word waits for the next cycle of the PLC, and its answer for one more, each anywhere within
/// a cycle T: a wait for `words` words (w) has the standard deviation T √(2 w/12), and the mean of n waits differs from
/// the mean of the n waits behind the machine file by √(2/n) times that, T √(w/(3 n)). With `all` = n `each`, `each` is
/// compared with it.
pub fn is_beyond_chance(each: f64, all: f64, words: usize) -> bool {
    MAX_CHANCE * PLC_CYCLE_S * (words as f64 / 3.0).sqrt() < (each * all).abs().sqrt()
}

/// Number of shifts at which the trace of a cause is tried.
const SHIFTS: usize = 300;
/// Least ratio of the fit in place to the best shifted fit.
const MIN_PLACE_FIT_RATIO: f64 = 1.25;

/// Returns `true` if the trace of a cause fits the residuals in its place and less well at every shift: a residual that
/// wanders by itself fits any trace a little, anywhere.
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
    MIN_PLACE_FIT_RATIO * shifted.fold(0.0, f64::max) < fits(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_short_waits_are_beyond_chance_where_one_is_not() {
        // Hardly longer than a cycle for the word and one for its answer take at most.
        assert!(!is_beyond_chance(0.04, 0.04, 1) && is_beyond_chance(0.05, 0.05, 1));
        assert!(!is_beyond_chance(0.0235, 2.0 * 0.0235, 1));
        assert!(is_beyond_chance(0.0235, 4.0 * 0.0235, 1) && is_beyond_chance(-0.0235, -4.0 * 0.0235, 1));
        // T, M6 and M3 in a row.
        assert!(!is_beyond_chance(0.064, 0.064, 3) && is_beyond_chance(0.081, 0.081, 3));
    }
}
