//! Regions in which simulation and recording differ: visits that lost time, joined to ranges of lines.

use std::ops::Range;

use crate::identification::alignment::{Alignment, ProgramPlace, median, times, visits};
use crate::identification::comparison::Comparison;
use crate::identification::fit::Run;
use crate::machine::{Machine, Overrides};
use crate::simulation::ordered::sort_by_number;
use crate::simulation::toolpath::{Motion, Segment};

/// Least lost time of a visit that counts, in standard deviations of the times at its ends.
const MIN_LOST_DEVIATIONS: f64 = 5.0;
/// Least lost time of a visit that counts, s.
const MIN_LOST_S: f64 = 2e-3;
/// Largest distance, in visits, between visits that lost time and belong to one region.
const MAX_VISITS_APART: usize = 2;
/// Most regions in a list.
const MAX_REGIONS: usize = 100;
/// Least change of the time of a line on which a cause acts in any case, s.
const MIN_TIME_CHANGE_S: f64 = 5e-4;
/// Least part of the whole change of time by a cause that the lines on which it acts hold together.
const ACTS_ON_PART: f64 = 0.95;

/// Stretch of a program in which simulation and recording differ.
#[derive(Clone, Debug, PartialEq)]
pub struct Region {
    /// Index of the run.
    pub run: usize,
    /// First and last line.
    pub lines: (u32, u32),
    /// Stretch of the path, mm.
    pub distance: Range<f64>,
    /// Span of time in the recording, s.
    pub time: Range<f64>,
    /// Lost time, s: by how much longer than the simulated machine the recorded one took.
    pub seconds: f64,
}

/// Returns the median of the standard deviations of the times of the marks, s; at least 1e-4 s.
fn noise(alignment: &Alignment) -> f64 {
    median(&mut alignment.marks.iter().map(|mark| mark.deviation).collect::<Vec<f64>>()).max(1e-4)
}

/// Returns the regions of the comparison of one of the runs, sorted by the size of their lost time, the largest first;
/// at most `MAX_REGIONS`.
pub fn regions(comparison: &Comparison, alignment: &Alignment, run: usize) -> Vec<Region> {
    let mut regions = all_regions(comparison, alignment, run);
    sort_by_number(&mut regions, |region| -region.seconds.abs());
    regions.truncate(MAX_REGIONS);
    regions
}

/// Returns the sum of the sizes of the lost times of all regions of a comparison, and of the size of the time lost
/// outside of them, s.
pub fn sizes(comparison: &Comparison, alignment: &Alignment) -> f64 {
    let regions = all_regions(comparison, alignment, 0);
    let (net, sizes) = regions
        .iter()
        .fold((0.0, 0.0), |(net, sizes), region| (net + region.seconds, sizes + region.seconds.abs()));
    let whole = comparison.whole.recorded - comparison.whole.simulated;
    sizes + (whole - net).abs()
}

/// Returns all regions of the comparison of one of the runs, in the order of the program.
fn all_regions(comparison: &Comparison, alignment: &Alignment, run: usize) -> Vec<Region> {
    let noise = noise(alignment);
    // Close to a stop, where hardly anything moves, times are known less well.
    let marks = &alignment.marks;
    let deviation = |time: f64| {
        let after = marks.partition_point(|mark| mark.time < time).min(marks.len().saturating_sub(1));
        let beside = [marks.get(after.saturating_sub(1)), marks.get(after)];
        beside.into_iter().flatten().map(|mark| mark.deviation).fold(noise, f64::max)
    };
    // A visit that ends before it begins shows by how much its ends, and so those of its neighbours, are off.
    let lost = &comparison.lost;
    let backward = |at: usize| {
        let beside = &lost[at.saturating_sub(1)..(at + 2).min(lost.len())];
        beside.iter().map(|visit| visit.recorded.start - visit.recorded.end).fold(0.0, f64::max)
    };
    let mut found: Vec<(usize, usize)> = Vec::new();
    for (at, visit) in lost.iter().enumerate() {
        let noise = deviation(visit.recorded.start).max(deviation(visit.recorded.end)).max(backward(at));
        if visit.seconds().abs() < (MIN_LOST_DEVIATIONS * noise).max(MIN_LOST_S) {
            continue;
        }
        match found.last_mut() {
            Some(last) if at - last.1 <= MAX_VISITS_APART => last.1 = at,
            _ => found.push((at, at)),
        }
    }
    let region = |(first, last): (usize, usize)| {
        let visits = &comparison.lost[first..=last];
        let lines = visits.iter().map(|visit| visit.line.0);
        Region {
            run,
            lines: (lines.clone().min().unwrap_or(0), lines.max().unwrap_or(0)),
            distance: visits[0].distance.start..visits[visits.len() - 1].distance.end,
            time: visits[0].recorded.start..visits[visits.len() - 1].recorded.end,
            seconds: visits.iter().map(|visit| visit.seconds()).sum(),
        }
    };
    found.into_iter().map(region).collect()
}

/// Returns the line of each visit of a run, and by how much longer the visit takes on the machine `with` than on
/// `without`, s.
fn differences(without: &Machine, with: &Machine, run: &Run) -> Vec<(u32, f64)> {
    let visits = visits(run.toolpath);
    let places: Vec<ProgramPlace> = visits.iter().map(|visit| visit.begin).collect();
    let ends = |machine: &Machine| {
        let plan = run.plan(machine);
        let mut times = times(run.toolpath, &plan, &places);
        times.push(plan.cycle_time());
        times.iter_mut().for_each(|time| *time *= machine.recorder.clock_ratio);
        times
    };
    let (before, after) = (ends(without), ends(with));
    let lost = |at: usize| (after[at + 1] - after[at]) - (before[at + 1] - before[at]);
    visits.iter().enumerate().map(|(at, visit)| (visit.line.0, lost(at))).collect()
}

/// Returns the ranges of lines on which one machine takes longer or shorter than another: the lines on which the
/// difference is large, or, if it is small everywhere, those that hold nearly all of it. An override acts on all lines
/// on which it is in force.
pub fn acts_on(without: &Machine, with: &Machine, runs: &[Run]) -> Vec<(u32, u32)> {
    let each: Vec<(u32, f64)> = runs.iter().flat_map(|run| differences(without, with, run)).collect();
    let mut sizes: Vec<f64> = each.iter().map(|(_, lost)| lost.abs()).collect();
    sort_by_number(&mut sizes, |size| -size);
    let nearly_all = ACTS_ON_PART * sizes.iter().sum::<f64>();
    let mut sum = 0.0;
    let least = sizes.into_iter().find(|size| {
        sum += size;
        nearly_all <= sum
    });
    let least = least.unwrap_or(0.0).min(MIN_TIME_CHANGE_S);
    let mut lines: Vec<u32> =
        each.iter().filter(|(_, lost)| *lost != 0.0 && least <= lost.abs()).map(|(line, _)| *line).collect();
    lines.extend(runs.iter().flat_map(|run| switched(without, with, run)));
    sort_by_number(&mut lines, |line| f64::from(*line));
    lines.dedup();
    ranges(lines.into_iter())
}

/// Returns the lines whose moves have different overrides on the two machines.
fn switched(without: &Machine, with: &Machine, run: &Run) -> Vec<u32> {
    let [before, after] = [without, with].map(|machine| run.machine(machine));
    if before.overrides == after.overrides {
        return Vec::new();
    }
    let distances = run.toolpath.distances_in_program();
    let of_feed = |overrides: &Overrides, at: usize, line: u32| {
        let (from, to) = overrides.span;
        if from < distances[at + 1] && distances[at] < to { overrides.of_feed(line) } else { 1.0 }
    };
    let in_force = |machine: &Machine, at: usize, segment: &Segment| {
        let (overrides, line) = (&machine.overrides, segment.line.0);
        let of_feed = of_feed(overrides, at, line);
        match segment.motion {
            Motion::Rapid { .. } => overrides.of_rapid(line) * machine.rapid_ratio_at(of_feed),
            Motion::Feed { .. } => of_feed,
        }
    };
    let differs =
        |(at, segment): &(usize, Segment)| in_force(&before, *at, segment) != in_force(&after, *at, segment);
    let segments = run.toolpath.segments.iter().enumerate().filter(differs);
    segments.map(|(_, segment)| segment.line.0).collect()
}

/// Returns by how much longer the machine `with` takes than `without`, and the sum of the sizes of the differences over
/// all visits, s.
pub fn moved(without: &Machine, with: &Machine, runs: &[Run]) -> (f64, f64) {
    let each = runs.iter().flat_map(|run| differences(without, with, run));
    each.fold((0.0, 0.0), |(net, all), (_, lost)| (net + lost, all + lost.abs()))
}

/// Returns the range from the first to the last line that moves or waits; empty if no line does.
pub fn all_lines(runs: &[Run]) -> Vec<(u32, u32)> {
    let lines = || runs.iter().flat_map(|run| visits(run.toolpath)).map(|visit| visit.line.0);
    lines().min().zip(lines().max()).into_iter().collect()
}

/// Joins ascending lines to ranges of consecutive lines.
fn ranges(lines: impl Iterator<Item = u32>) -> Vec<(u32, u32)> {
    let mut ranges: Vec<(u32, u32)> = Vec::new();
    for line in lines {
        match ranges.last_mut() {
            Some(last) if line == last.1 + 1 => last.1 = line,
            _ => ranges.push((line, line)),
        }
    }
    ranges
}

/// Returns the region with at least half of the lost time of all runs (s); `None` if it is spread more widely.
pub fn with_most(regions: Vec<Region>, lost: f64) -> Option<Region> {
    let largest = regions.into_iter().max_by(|a, b| a.seconds.abs().total_cmp(&b.seconds.abs()))?;
    (0.5 * lost <= largest.seconds.abs()).then_some(largest)
}

/// Returns the lost time of all runs, s. For each run the largest of three values counts: the sum of the sizes of its
/// regions; the size of the change of the residual between the first and the last mark whose times are known well,
/// because they are not close to a stop; and that between the first and the last mark of all, less the uncertainty of
/// their times.
pub fn left(comparisons: &[Comparison], regions: &[Region], runs: &[Run]) -> f64 {
    let of_run = |(at, (comparison, run)): (usize, (&Comparison, &Run))| {
        let own = regions.iter().filter(|region| region.run == at);
        let located: f64 = own.map(|region| region.seconds.abs()).sum();
        let noise = noise(run.alignment);
        let known = run.alignment.marks.iter().zip(&comparison.residuals);
        let mut known = known.filter(|(mark, _)| mark.deviation <= noise).map(|(_, residual)| *residual);
        let first = known.next().unwrap_or(0.0);
        let wandered = (known.next_back().unwrap_or(first) - first).abs();
        let ends = [run.alignment.marks.first(), run.alignment.marks.last()];
        let unsure: f64 = ends.into_iter().flatten().map(|mark| MIN_LOST_DEVIATIONS * mark.deviation).sum();
        let whole =
            comparison.residuals.last().unwrap_or(&0.0) - comparison.residuals.first().unwrap_or(&0.0);
        located.max(wandered).max(whole.abs() - unsure)
    };
    comparisons.iter().zip(runs).enumerate().map(of_run).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identification::alignment::{Mark, Method};
    use crate::identification::comparison::{Durations, VisitTimes};
    use crate::simulation::gcode::LineNumber;

    /// Returns the lines of the regions of consecutive visits, each given by its begin and its end in the recording and
    /// its duration in the simulation, s.
    fn lines(visits: &[(f64, f64, f64)]) -> Vec<(u32, u32)> {
        let mark = |time: f64| Mark { place: ProgramPlace::Along(time), time, deviation: 1e-3 };
        let marks = (0..=100).map(|at| mark(0.1 * f64::from(at))).collect();
        let alignment = Alignment::of_marks(Method::Positions, 0.0..10.0, marks, 1.0);
        let lost = visits.iter().zip(1..).map(|((begin, end, takes), line)| VisitTimes {
            line: LineNumber(line),
            distance: 0.0..1.0,
            recorded: *begin..*end,
            simulated: 0.0..*takes,
            stops: 0..0,
        });
        let comparison = Comparison {
            residuals: Vec::new(),
            simulated: Vec::new(),
            lost: lost.collect(),
            whole: Durations::default(),
            motion: Durations::default(),
            feed: None,
            position: None,
        };
        regions(&comparison, &alignment, 0).into_iter().map(|region| region.lines).collect()
    }

    #[test]
    fn time_that_runs_backwards_is_not_lost() {
        assert_eq!(lines(&[(0.0, 1.0, 1.0), (1.0, 1.3, 0.2), (1.3, 2.3, 1.0)]), [(2, 2)]);
        let backward = [(0.0, 1.0, 1.0), (1.0, 2.3, 1.0), (2.3, 2.2, 0.2), (2.2, 3.2, 1.0)];
        assert_eq!(lines(&backward), []);
    }

    #[test]
    fn a_region_without_half_of_the_lost_time_has_not_most_of_it() {
        let region =
            |seconds: f64| Region { run: 0, lines: (1, 2), distance: 0.0..1.0, time: 0.0..1.0, seconds };
        let regions = || vec![region(0.1), region(-0.5), region(0.2)];
        assert_eq!(with_most(regions(), 0.9).map(|region| region.seconds), Some(-0.5));
        assert!(with_most(regions(), 1.1).is_none());
        assert!(with_most(Vec::new(), 0.1).is_none());
    }
}
