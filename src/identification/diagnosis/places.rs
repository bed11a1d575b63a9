//! Hypotheses of causes that act in one part of the program only, placed where the residual says.
//!
//! The override of feed moves from one line to another: with g the change of the residual between marks by
//! an override on all lines, and δ that which is observed, β = Σ δ g / Σ g² over a range explains
//! (Σ δ g)² / Σ g² of Σ δ². The range that explains most is found from prefix sums over at most
//! [`BINS`] parts.
//!
//! Waits before lines: where the recorded machine rests between two long blocks, the longest ones. A feed hold: where it
//! dips.

use crate::identification::alignment::Place;
use crate::identification::diagnosis::dips::dip;
use crate::identification::diagnosis::evidence::Evidence;
use crate::identification::diagnosis::gates::GAIN;
use crate::identification::diagnosis::rests::{Rest, rests};
use crate::identification::effects::{FEED_OVERRIDE, FROM_LINE, Hypothesis, RATIO, Reported, TO_LINE};
use crate::identification::fit::{Freed, Run, Scale, golden_section};
use crate::machine::{Handle, Machine};

/// Parts of a run between which a range may begin and end.
const BINS: usize = 300;
/// The override that is tried to see what one does.
const TRIED: f64 = 0.97;
/// Golden sections in the search of the ratio of an override.
const RATIO_SECTIONS: usize = 14;
/// Waits before lines that are tried.
const WAITS: usize = 3;
/// A range that explains less than this part more than the whole program is the whole program.
const WORTH_A_RANGE: f64 = 1.1;

/// The shortest override, s: nobody turns a switch to another rate and back in less.
const SHORTEST_OVERRIDE: f64 = 0.5;

/// Hypotheses placed by the residuals of the first run; those of an override only if that is open.
pub fn hypotheses(machine: &Machine, runs: &[Run], evidence: &Evidence, is_open: bool) -> Vec<Hypothesis> {
    let Some(run) = runs.first() else { return Vec::new() };
    let range = if is_open { override_range(machine, run, evidence) } else { None };
    let mut all: Vec<Hypothesis> = range.into_iter().collect();
    let mut waits = rests(machine, run);
    waits.retain(|rest| rest.place.is_none() && !machine.halts.waits.contains_key(&rest.line));
    waits.sort_by(|a, b| b.seconds.total_cmp(&a.seconds));
    all.extend(waits.into_iter().take(WAITS).map(Rest::hypothesis));
    let dip = dip(machine, run).filter(|dip| !machine.halts.feed_holds.contains_key(&dip.line));
    all.extend(dip.map(Rest::hypothesis));
    all
}

/// The override of feed moves on a range of lines.
fn override_range(machine: &Machine, run: &Run, evidence: &Evidence) -> Option<Hypothesis> {
    let mut other = machine.clone();
    other.overrides.feed *= TRIED;
    let whitening = evidence.whitenings.first()?;
    let now = run.residuals(machine);
    let changed = run.residuals(&other);
    let observed = whitening.apply(&now);
    // What an override of 1 % more time would lose, whitened.
    let change: Vec<f64> =
        now.iter().zip(&changed).map(|(now, changed)| (now - changed) / (1.0 / TRIED - 1.0)).collect();
    let change = whitening.apply(&change);
    let part = observed.len().div_ceil(BINS).max(1);
    let mut sums = vec![(0.0, 0.0)];
    for (observed, change) in observed.chunks(part).zip(change.chunks(part)) {
        let (mut both, mut own) = sums[sums.len() - 1];
        for (observed, change) in observed.iter().zip(change) {
            both += observed.clamp(-20.0, 20.0) * change;
            own += change * change;
        }
        sums.push((both, own));
    }
    let explained = |from: usize, to: usize| {
        let (both, own) = (sums[to].0 - sums[from].0, sums[to].1 - sums[from].1);
        if 0.0 < own { both * both / own } else { 0.0 }
    };
    let bins = sums.len() - 1;
    let mut best = (0, bins, explained(0, bins));
    let whole = best.2;
    for from in 0..bins {
        for to in from + 3..=bins {
            let found = explained(from, to);
            if best.2 < found {
                best = (from, to, found);
            }
        }
    }
    // The best of so many ranges explains 2 ln of their number by chance.
    let by_chance = 2.0 * (0.5 * (bins * bins) as f64).max(1.0).ln();
    if best.2 < WORTH_A_RANGE * whole || best.2 - whole < GAIN + by_chance {
        return None;
    }
    let (from, to) = (best.0, best.1);
    let mark = |bin: usize| run.alignment.marks[(bin * part).min(run.alignment.marks.len() - 1)];
    if mark(to).time - mark(from).time < SHORTEST_OVERRIDE {
        return None;
    }
    let slope = (sums[to].0 - sums[from].0) / (sums[to].1 - sums[from].1);
    let ratio = (1.0 / (1.0 + slope)).clamp(0.05, 2.0) * machine.overrides.feed;
    let line_of = |bin: usize| line_at(run, mark(bin).place);
    let first = if from == 0 { 0 } else { line_of(from) };
    let last = if to == bins { u32::MAX } else { line_of(to) };
    // Ratio and edges lean on each other: one after the other, a few times.
    let guess = ratio;
    let (mut first, mut last, mut ratio) = (first, last, ratio);
    for _ in 0..3 {
        (first, last) = edges(machine, run, evidence, ratio, (first, last));
        ratio = best_ratio(machine, evidence, ratio, (first, last));
    }
    let freed = Freed::new(Handle::number("override.feed"), guess, (0.01, 2.0), Scale::Ratio)
        .exact()
        .also(move |machine| machine.overrides.lines = (first, last));
    let report = move |ratio| {
        let mut reported =
            vec![(RATIO, Reported::Number(ratio)), (FROM_LINE, Reported::Number(f64::from(first)))];
        if last < u32::MAX {
            reported.push((TO_LINE, Reported::Number(f64::from(last))));
        }
        reported
    };
    let trials = [0.9, 0.97, 1.0, 1.03, 1.1].iter().map(|part| part * ratio).collect();
    Some(Hypothesis::single(FEED_OVERRIDE, freed, trials, report).variant("on some lines"))
}

/// The override at which the cost is least, near where it was guessed.
fn best_ratio(machine: &Machine, evidence: &Evidence, guess: f64, lines: (u32, u32)) -> f64 {
    let cost = |ratio: f64| {
        let mut there = machine.clone();
        there.overrides.feed = ratio;
        there.overrides.lines = lines;
        evidence.cost(&there)
    };
    let (low, high) = golden_section((0.85 * guess, 1.18 * guess), RATIO_SECTIONS, cost);
    0.5 * (low + high)
}

/// The first and last line at which the cost is least, near where they were guessed.
fn edges(machine: &Machine, run: &Run, evidence: &Evidence, ratio: f64, guess: (u32, u32)) -> (u32, u32) {
    let mut lines: Vec<u32> = run.toolpath.segments.iter().map(|segment| segment.line.0).collect();
    lines.dedup();
    lines.sort_unstable();
    lines.dedup();
    let alone = Evidence { runs: evidence.runs, whitenings: evidence.whitenings.clone() };
    let cost = |first: u32, last: u32| {
        let mut there = machine.clone();
        there.overrides.feed = ratio;
        there.overrides.lines = (first, last);
        alone.cost(&there)
    };
    let place = |line: u32| lines.partition_point(|known| *known < line);
    let mut best = guess;
    let mut least = cost(best.0, best.1);
    for edge in 0..2 {
        let guessed = if edge == 0 { guess.0 } else { guess.1 };
        if guessed == 0 || guessed == u32::MAX {
            continue;
        }
        let mut reach = (lines.len() / BINS).max(4) as i64;
        while 0 < reach {
            let centre = place(if edge == 0 { best.0 } else { best.1 }) as i64;
            for step in [-2 * reach, -reach, reach, 2 * reach] {
                let Some(&line) = usize::try_from(centre + step).ok().and_then(|at| lines.get(at)) else {
                    continue;
                };
                let there = if edge == 0 { (line, best.1) } else { (best.0, line) };
                let found = cost(there.0, there.1);
                if found < least {
                    (best, least) = (there, found);
                }
            }
            reach /= 2;
        }
    }
    best
}

/// The line at a place.
fn line_at(run: &Run, place: Place) -> u32 {
    let segments = &run.toolpath.segments;
    match place {
        Place::Start => 0,
        Place::Stop(stop) | Place::After(stop) => run.toolpath.stops[stop].line.0,
        Place::Along(distance) => {
            let begun = run.toolpath.distances().partition_point(|begin| *begin <= distance);
            let last = segments.len().checked_sub(1);
            last.map_or(0, |last| segments.at(begun.saturating_sub(1).min(last)).line.0)
        }
    }
}
