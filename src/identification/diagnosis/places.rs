//! Hypotheses of causes that act in one part of the program only, placed by the residual.
//!
//! An override acts on the feed moves from one place of the path to another, wherever the operator turned the switch.
//! Let g be the change of the residual between marks by an override on all lines, and δ the observed change. Then
//! β = Σ δ g / Σ g² over a range explains (Σ δ g)² / Σ g² of Σ δ². The range that explains most is found from prefix
//! sums over at most [`BINS`] parts. Where other limits hold, g is not proportional to the lost time: an override of 97 % may change
//! nothing where one of 50 % halves the velocity. So g is that of each of several overrides ([`TRIED_RATIOS`]), and the one that explains
//! most counts. Edges and ratio are then fitted, and the override counts only if it lowers the cost by enough more than one
//! on all lines.
//!
//! Waits before lines are placed at the longest rests of the recorded machine between two long blocks, and a feed
//! hold at the dip of its feedrate.

use crate::identification::diagnosis::dips::dip;
use crate::identification::diagnosis::evidence::Evidence;
use crate::identification::diagnosis::gates::MIN_COST_REDUCTION;
use crate::identification::diagnosis::rests::{Rest, rests};
use crate::identification::effects::{
    FEED_OVERRIDE, FROM_DISTANCE, FROM_LINE, Hypothesis, RATIO, TO_DISTANCE, TO_LINE, free_feed_override,
};
use crate::identification::fit::{Run, golden_section};
use crate::machine::{Machine, Overrides};
use crate::simulation::ordered::sort_by_number;

/// Most parts of a run, between which a range may begin and end.
const BINS: usize = 300;
/// Override ratios that are simulated to obtain the effect of an override. Every ratio between two of them is within a quarter
/// of one.
const TRIED_RATIOS: [f64; 7] = [0.97, 0.75, 0.5, 0.33, 0.2, 1.3, 1.7];
/// Golden sections in the search of the ratio of an override.
const RATIO_SECTIONS: usize = 14;
/// Largest lost time of a part by an override, as a multiple of the simulated time: the override is 1/(1 + `MAX_SLOWING`).
/// A part that loses more contains a wait.
const MAX_SLOWING: f64 = 4.0;
/// Fewest parts of a run that an override lasts.
const MIN_PARTS: usize = 3;
/// Parts of a run on either side of an edge within which the edge is searched.
const PARTS_AROUND: usize = 2;
/// Golden sections in the search of an edge.
const EDGE_SECTIONS: usize = 12;
/// Rounds in which each edge and the ratio are searched in turn.
const EDGE_ROUNDS: usize = 3;
/// Most waits before lines that are tried.
const WAITS: usize = 3;
/// Least ratio of the lost time that a range explains to that which the whole program explains; below it, the range
/// counts as the whole program.
const WORTH_A_RANGE: f64 = 1.1;

/// Shortest override, s: no operator turns a switch to another rate and back in less.
const SHORTEST_OVERRIDE: f64 = 0.5;

/// Returns the hypotheses that the residuals of the first run place. An override is among them only if `is_open`, that
/// is, if no cause has settled the feed override yet.
pub fn hypotheses(machine: &Machine, runs: &[Run], evidence: &Evidence, is_open: bool) -> Vec<Hypothesis> {
    let Some(run) = runs.first() else { return Vec::new() };
    let range = if is_open { override_range(machine, run, evidence) } else { None };
    let mut all: Vec<Hypothesis> = range.into_iter().collect();
    let mut waits = rests(machine, run);
    waits.retain(|rest| rest.place.is_none() && !machine.halts.waits.contains_key(&rest.line));
    sort_by_number(&mut waits, |wait| -wait.seconds);
    all.extend(waits.into_iter().take(WAITS).flat_map(Rest::hypotheses));
    let dip = dip(machine, run).filter(|dip| !machine.halts.feed_holds.contains_key(&dip.line));
    all.extend(dip.map(Rest::hypothesis));
    all
}

/// Returns the hypothesis of a feed override along a part of the path. `None` if no range explains enough more than the
/// whole program, or if the best one is shorter than [`SHORTEST_OVERRIDE`].
fn override_range(machine: &Machine, run: &Run, evidence: &Evidence) -> Option<Hypothesis> {
    let now = run.residuals(machine);
    let marks = &run.alignment.marks;
    let part = now.len().div_ceil(BINS).max(1);
    let bins = now.len().div_ceil(part);
    let end = |bin: usize| (bin * part).min(marks.len() - 1);
    // Whitened residuals remember what was lost before, so they do not show where.
    let lost = |of: &[f64], bin: usize| of[end(bin + 1)] - of[end(bin)];
    let tried = TRIED_RATIOS.map(|ratio| {
        let changed =
            run.residuals(&overridden(machine, ratio * machine.overrides.feed, machine.overrides.span));
        // What an override that doubles the time would lose.
        let change = |bin: usize| (lost(&now, bin) - lost(&changed, bin)) / (1.0 / ratio - 1.0);
        Explained::of((0..bins).map(|bin| (lost(&now, bin), change(bin))))
    });
    let (whole, _) = with_most(tried.iter().map(|of| (of, (0, bins))))?;
    let (by_part, (from, to)) = with_most(tried.iter().map(|of| (of, of.best_range())))?;
    let is_worth_a_range = WORTH_A_RANGE * whole.part(0, bins) <= by_part.part(from, to);
    if !is_worth_a_range || marks[end(to)].time - marks[end(from)].time < SHORTEST_OVERRIDE {
        return None;
    }
    let guess = |of: &Explained, from: usize, to: usize| {
        (1.0 / (1.0 + of.slope(from, to))).clamp(0.05, 2.0) * machine.overrides.feed
    };
    let distances = run.toolpath.distances();
    let ends: Vec<f64> =
        (0..=bins).map(|bin| marks[end(bin)].place.distance(run.toolpath, &distances)).collect();
    let mut span = OverrideSpan { from: (from != 0).then(|| ends[from]), to: (to != bins).then(|| ends[to]) };
    let cost = |ratio: f64, span: (f64, f64)| evidence.cost(&overridden(machine, ratio, span));
    let (without, mut ratio) = (evidence.cost(machine), guess(by_part, from, to));
    if without <= cost(ratio, span.of_path()) {
        return None;
    }
    // Ratio and edges lean on each other: one after the other, a few times.
    for _ in 0..EDGE_ROUNDS {
        span = span.fitted(machine, evidence, ratio, &ends);
        ratio = best_ratio(machine, evidence, ratio, span.of_path());
    }
    let everywhere = best_ratio(machine, evidence, guess(whole, 0, bins), Overrides::WHOLE_PATH_BOUNDS_MM);
    let explained = |ratio: f64, span: (f64, f64)| without - cost(ratio, span);
    let (found, whole) =
        (explained(ratio, span.of_path()), explained(everywhere, Overrides::WHOLE_PATH_BOUNDS_MM).max(0.0));
    // By chance, the best of n ranges lowers the cost by 2 ln n.
    let by_chance = 2.0 * (0.5 * (bins * bins) as f64).max(1.0).ln();
    if found < (WORTH_A_RANGE * whole).max(whole + MIN_COST_REDUCTION + by_chance) {
        return None;
    }
    Some(overridden_between(machine, run, ratio, span.as_shown(run, &distances), &distances))
}

/// Returns the hypothesis that an override with this ratio acts along a span; `distances` are those of the toolpath, mm.
fn overridden_between(
    machine: &Machine,
    run: &Run,
    ratio: f64,
    span: OverrideSpan,
    distances: &[f64],
) -> Hypothesis {
    let of_path = span.of_path();
    let freed = free_feed_override(machine).also(move |machine| machine.overrides.span = of_path);
    let line_of = |distance: f64| f64::from(line_at(run, distance, distances));
    let edges = [(span.from, FROM_DISTANCE, FROM_LINE), (span.to, TO_DISTANCE, TO_LINE)];
    let known = edges.into_iter().filter_map(|(edge, distance, line)| {
        let at = edge?;
        Some([distance.number(at), line.number(line_of(at))])
    });
    let known: Vec<_> = known.flatten().collect();
    let report = move |ratio| [RATIO.number(ratio)].into_iter().chain(known.clone()).collect();
    let trials = [0.9, 0.97, 1.0, 1.03, 1.1].iter().map(|part| part * ratio).collect();
    Hypothesis::single(FEED_OVERRIDE, freed, trials, report).variant("on some lines")
}

/// Observed lost time that an override explains: prefix sums Σ δ g and Σ g² of observed changes δ and of changes g by
/// an override.
struct Explained {
    sums: Vec<(f64, f64)>,
}

impl Explained {
    /// Sums pairs (δ, g). The size of each δ counts up to [`MAX_SLOWING`] |g|.
    fn of(pairs: impl Iterator<Item = (f64, f64)>) -> Explained {
        let mut sums = vec![(0.0, 0.0)];
        for (observed, change) in pairs {
            let (both, own) = sums[sums.len() - 1];
            let most = MAX_SLOWING * change.abs();
            sums.push((both + observed.clamp(-most, most) * change, own + change * change));
        }
        Explained { sums }
    }

    fn between(&self, from: usize, to: usize) -> (f64, f64) {
        (self.sums[to].0 - self.sums[from].0, self.sums[to].1 - self.sums[from].1)
    }

    /// Returns (Σ δ g)²/Σ g² of the pairs `from..to`; 0 if Σ g² is 0.
    fn part(&self, from: usize, to: usize) -> f64 {
        let (both, own) = self.between(from, to);
        if 0.0 < own { both * both / own } else { 0.0 }
    }

    /// Returns β = Σ δ g/Σ g² of the pairs `from..to`; 0 if Σ g² is 0.
    fn slope(&self, from: usize, to: usize) -> f64 {
        let (both, own) = self.between(from, to);
        if 0.0 < own { both / own } else { 0.0 }
    }

    /// Returns the range of at least [`MIN_PARTS`] pairs that explains most.
    fn best_range(&self) -> (usize, usize) {
        let count = self.sums.len() - 1;
        let mut best = (0, count);
        let mut most = self.part(0, count);
        for from in 0..count {
            for to in from + MIN_PARTS..=count {
                let explained = self.part(from, to);
                if most < explained {
                    (best, most) = ((from, to), explained);
                }
            }
        }
        best
    }
}

/// Returns the override and the range that explain most; `None` if there is no override.
fn with_most<'a>(
    of: impl Iterator<Item = (&'a Explained, (usize, usize))>,
) -> Option<(&'a Explained, (usize, usize))> {
    let part = |(of, (from, to)): &(&Explained, (usize, usize))| of.part(*from, *to);
    of.reduce(|most, next| if part(&most) < part(&next) { next } else { most })
}

/// Distances along the path between which an override is in force, mm; an edge at an end of the program is `None`.
#[derive(Clone, Copy)]
struct OverrideSpan {
    from: Option<f64>,
    to: Option<f64>,
}

impl OverrideSpan {
    /// Returns the span without each edge beyond which the program has no feed move: nothing shows there whether the
    /// override is in force. `distances` are those of the toolpath, mm.
    fn as_shown(self, run: &Run, distances: &[f64]) -> OverrideSpan {
        let segments = &run.toolpath.segments;
        let is_feed = |segment: &usize| !segments.motion(*segment).is_rapid();
        let (first, last) = ((0..segments.len()).find(is_feed), (0..segments.len()).rfind(is_feed));
        OverrideSpan {
            from: self.from.filter(|from| first.is_some_and(|first| distances[first] < *from)),
            to: self.to.filter(|to| last.is_some_and(|last| *to < distances[last + 1])),
        }
    }

    fn of_path(self) -> (f64, f64) {
        (self.from.unwrap_or(0.0), self.to.unwrap_or(f64::INFINITY))
    }

    /// Returns the span with the edges of least cost at a given ratio, searched one after the other. `ends` are the
    /// distances at which the parts of the run begin and end, mm.
    fn fitted(mut self, machine: &Machine, evidence: &Evidence, ratio: f64, ends: &[f64]) -> OverrideSpan {
        let least = |at: f64, with: &dyn Fn(f64) -> OverrideSpan| {
            let cost = |at: f64| evidence.cost(&overridden(machine, ratio, with(at).of_path()));
            let (low, high) = golden_section(around(at, ends), EDGE_SECTIONS, cost);
            0.5 * (low + high)
        };
        if let Some(at) = self.from {
            self.from = Some(least(at, &|at| OverrideSpan { from: Some(at), ..self }));
        }
        if let Some(at) = self.to {
            self.to = Some(least(at, &|at| OverrideSpan { to: Some(at), ..self }));
        }
        self
    }
}

/// Returns the stretch of the path from [`PARTS_AROUND`] parts before a distance to as many after it, mm.
fn around(at: f64, ends: &[f64]) -> (f64, f64) {
    let next = ends.partition_point(|end| *end < at);
    (ends[next.saturating_sub(PARTS_AROUND)], ends[(next + PARTS_AROUND).min(ends.len() - 1)])
}

fn overridden(machine: &Machine, ratio: f64, span: (f64, f64)) -> Machine {
    let mut machine = machine.clone();
    (machine.overrides.feed, machine.overrides.span) = (ratio, span);
    machine
}

/// Returns the override ratio of least cost near a guess. Where other limits hold, a larger ratio changes nothing, so the
/// distance from the expected override decides.
fn best_ratio(machine: &Machine, evidence: &Evidence, guess: f64, span: (f64, f64)) -> f64 {
    let freed = free_feed_override(machine);
    let cost = |ratio: f64| {
        let apart = freed.from_expected(ratio).unwrap_or(0.0);
        evidence.cost(&overridden(machine, ratio, span)) + apart.powi(2)
    };
    let (low, high) = golden_section((0.85 * guess, 1.18 * guess), RATIO_SECTIONS, cost);
    0.5 * (low + high)
}

/// Returns the line at a distance along the path, mm; 0 if the program has no moves.
fn line_at(run: &Run, distance: f64, distances: &[f64]) -> u32 {
    let segments = &run.toolpath.segments;
    let begun = distances.partition_point(|begin| *begin <= distance);
    let last = segments.len().checked_sub(1);
    last.map_or(0, |last| segments.at(begun.saturating_sub(1).min(last)).line.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identification::alignment::recorded;
    use crate::identification::diagnosis::Candidate;
    use crate::identification::diagnosis::gates::{self, HeldOut};
    use crate::machine::Planner;

    /// Holes, each cut in many marks, as positions show them.
    fn drilling() -> String {
        let hole = |at: u32| {
            let depths: String =
                (1..=15).map(|part| format!("G1 Z-{} F210\n", 0.1 * f64::from(part))).collect();
            format!("G0 X{} Z2\n{depths}G0 Z11\n", 11 * at)
        };
        (0..12).map(hole).collect()
    }

    fn range_found(truth: impl Fn(&Machine) -> Machine) -> Option<Hypothesis> {
        let mut machine = Machine::default();
        machine.become_planner(Planner::SquareCorner, 1990.0);
        let (toolpath, alignment) = recorded(&drilling(), &truth(&machine), 1e-4);
        let runs = [Run { toolpath: &toolpath, alignment: &alignment, overrides: (None, None) }];
        override_range(&machine, &runs[0], &Evidence::of(&runs, &machine))
    }

    /// Most marks leave no process noise, so whitened residuals hardly forget what was lost.
    #[test]
    fn an_override_on_some_lines_is_found_where_most_marks_are_exact() {
        let found = range_found(|machine| overridden(machine, 0.53, (250.0, 300.0)));
        assert!(found.is_some());
    }

    /// Returns the result of an override on a part of the path in sections to which it was not fitted.
    fn held_out(truth: &Machine, span: OverrideSpan) -> HeldOut {
        let mut machine = Machine::default();
        machine.become_planner(Planner::SquareCorner, 1990.0);
        let (toolpath, alignment) = recorded(&drilling(), truth, 1e-4);
        let runs = [Run { toolpath: &toolpath, alignment: &alignment, overrides: (None, None) }];
        let evidence = Evidence::of(&runs, &machine);
        let found = overridden_between(&machine, &runs[0], 0.9, span, &toolpath.distances());
        let candidate = Candidate::read_off(found, 0.9, f64::NAN);
        let (cause, beside) = evidence.refined(&machine, &candidate, &[]);
        gates::held_out(&evidence, &machine, &[], (&cause, &beside)).expect("several sections show it")
    }

    /// The place found ends 10 mm behind the override, in the next section of the run.
    #[test]
    fn an_override_on_some_lines_is_tested_in_sections_of_them() {
        let mut machine = Machine::default();
        machine.become_planner(Planner::SquareCorner, 1990.0);
        let truth = overridden(&machine, 0.9, (100.0, 125.0));
        let found = held_out(&truth, OverrideSpan { from: Some(104.0), to: Some(135.0) });
        assert!(found.holds() && 4 <= found.better, "{found:?}");
    }

    /// The axis limit holds from a ratio of 1.5 on.
    #[test]
    fn of_overrides_that_change_nothing_more_the_least_is_found() {
        let mut machine = Machine::default();
        machine.become_planner(Planner::JunctionDeviation, 1990.0);
        machine.axes[2].velocity = 1.5 * 210.0 / 60.0;
        let span = (100.0, 300.0);
        let (toolpath, alignment) = recorded(&drilling(), &overridden(&machine, 1.9, span), 1e-4);
        let runs = [Run { toolpath: &toolpath, alignment: &alignment, overrides: (None, None) }];
        let found = best_ratio(&machine, &Evidence::of(&runs, &machine), 1.6, span);
        assert!((found / 1.5 - 1.0).abs() < 0.01, "{found}");
    }

    #[test]
    fn an_override_on_all_lines_is_none_on_some() {
        assert!(range_found(|machine| overridden(machine, 0.53, Overrides::WHOLE_PATH_BOUNDS_MM)).is_none());
        assert!(range_found(Machine::clone).is_none());
    }

    /// Short lines there and back, on which the machine never reaches the programmed feed, but for an override of half of it.
    #[test]
    fn an_override_is_found_where_a_small_one_changes_nothing() {
        let mut machine = Machine::default();
        machine.become_planner(Planner::JunctionDeviation, 200.0);
        let program = format!("G1 F1500\n{}", "X2\nX0\n".repeat(80));
        let span = (60.0, 180.0);
        let (toolpath, alignment) = recorded(&program, &overridden(&machine, 0.47, span), 1e-4);
        let runs = [Run { toolpath: &toolpath, alignment: &alignment, overrides: (None, None) }];
        let slightly = overridden(&machine, 0.97, Overrides::WHOLE_PATH_BOUNDS_MM);
        assert_eq!(runs[0].residuals(&slightly), runs[0].residuals(&machine));
        let evidence = Evidence::of(&runs, &machine);
        let found = override_range(&machine, &runs[0], &evidence).expect("there is an override");
        let mut with = machine.clone();
        found.freed[0].apply(&mut with, found.trials[2][0]);
        assert!((with.overrides.feed / 0.47 - 1.0).abs() < 0.01, "{}", with.overrides.feed);
        let (from, to) = with.overrides.span;
        assert!((from - span.0).abs() < 2.0 && (to - span.1).abs() < 2.0, "{from} to {to} mm");
    }
}
