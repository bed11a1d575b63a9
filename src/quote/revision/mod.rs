//! Two revisions of a program → their differences in lines, path and time.
//!
//! The time of a line is the time of its moves and stops; the times of all lines add up to the cycle time. The
//! filter delay of a rest-to-rest motion belongs half to its first line and half to its last. A line that
//! both revisions have may differ in time: because of a feedrate set before it, or on another machine.

mod lines;

use std::ops::Range;

use crate::quote::revision::lines::{LineRun, runs};
use crate::simulation::feed::{FeedPlan, Phase};
use crate::simulation::gcode::LineNumber;
use crate::simulation::toolpath::Toolpath;

/// One revision.
#[derive(Clone, Copy)]
pub struct Revision<'a> {
    /// Text of the program.
    pub text: &'a [u8],
    /// Its toolpath.
    pub toolpath: &'a Toolpath,
    /// Its plan.
    pub plan: &'a FeedPlan,
}

/// A run of lines that both revisions have, or that replace one another; the first revision comes first.
#[derive(Clone, Debug, PartialEq)]
pub struct RevisedLines {
    /// Line numbers, from 1; empty if a revision has none.
    pub lines: [Range<u32>; 2],
    /// `true` if both have the same lines.
    pub is_same: bool,
    /// Time of the lines, s.
    pub seconds: [f64; 2],
    /// Length of their moves, mm.
    pub length: [f64; 2],
    /// Distances of the second revision's lines along its path, mm; `None` if they do not move.
    pub distance: Option<(f64, f64)>,
}

/// The comparison of two revisions.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Revisions {
    /// All runs in order.
    pub runs: Vec<RevisedLines>,
    /// Distances along the path of the second, mm, ascending.
    pub distance: Vec<f64>,
    /// Delay of the second revision against the first at each distance, s.
    pub later: Vec<f64>,
}

/// Time and length of the lines of a program by number; index 0 is everything before the first line.
struct LineTotals {
    seconds: Vec<f64>,
    length: Vec<f64>,
}

impl LineTotals {
    fn of(revision: &Revision, lines: usize) -> LineTotals {
        let Revision { toolpath, plan, .. } = *revision;
        let segments = &toolpath.segments;
        let own: Vec<u32> = segments.iter().map(|segment| segment.line.0).collect();
        let mut by_line = LineTotals { seconds: vec![0.0; lines + 1], length: vec![0.0; lines + 1] };
        by_line.take(LineNumber(0), plan.start);
        for (index, line) in own.iter().enumerate() {
            if let Some(length) = by_line.length.get_mut(*line as usize) {
                *length += segments.length(index);
            }
        }
        for phase in &plan.phases {
            match phase {
                Phase::Wait(wait) => by_line.take(wait.line, wait.duration),
                Phase::Motion(rest_to_rest) => {
                    let half = plan.filters[rest_to_rest.filter].half_delay();
                    for end in [rest_to_rest.segments.start, rest_to_rest.segments.end - 1] {
                        by_line.take(LineNumber(own[end]), half);
                    }
                    for pulse in rest_to_rest.pulses.clone() {
                        by_line
                            .take(LineNumber(own[plan.pulses.segment(pulse)]), plan.pulses.duration(pulse));
                    }
                }
            }
        }
        let lost =
            plan.time_scaling.as_ref().map_or(&[][..], |time_scaling| time_scaling.lost_on(0..own.len()));
        for &(segment, lost) in lost {
            by_line.take(LineNumber(own[segment]), lost);
        }
        by_line
    }

    fn take(&mut self, LineNumber(line): LineNumber, seconds: f64) {
        if let Some(own) = self.seconds.get_mut(line as usize) {
            *own += seconds;
        }
    }

    fn seconds(&self, lines: &Range<u32>) -> f64 {
        sum(&self.seconds[lines.start as usize..lines.end as usize])
    }

    fn length(&self, lines: &Range<u32>) -> f64 {
        sum(&self.length[lines.start as usize..lines.end as usize])
    }
}

/// Returns the sum of values, +0 if there are none: an empty iterator sums to −0, which a table would show.
fn sum(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |sum, value| sum + value)
}

/// Returns the comparison of two revisions of a program.
pub fn revisions(first: &Revision, second: &Revision) -> Revisions {
    let (runs, counts) = runs(first.text, second.text);
    let [before, after] =
        [(first, counts[0]), (second, counts[1])].map(|(one, lines)| LineTotals::of(one, lines));
    let places = places(second.toolpath, counts[1]);
    let revised = |run: LineRun| {
        let [one, other] = run.lines.clone().map(with_start);
        let of_run = places[run.lines[1].start as usize..run.lines[1].end as usize].iter().flatten();
        let distance = of_run.copied().reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));
        RevisedLines {
            seconds: [before.seconds(&one), after.seconds(&other)],
            length: [before.length(&one), after.length(&other)],
            distance,
            is_same: run.is_same,
            lines: run.lines,
        }
    };
    let runs: Vec<RevisedLines> = runs.into_iter().map(revised).collect();
    let (distance, later) = delay_curve(second.toolpath, &runs, &before, &after);
    Revisions { runs, distance, later }
}

/// Extends a run that begins with the first line to everything before that line.
fn with_start(lines: Range<u32>) -> Range<u32> {
    if lines.start == 1 { 0..lines.end } else { lines }
}

/// Returns the first and last distance of each line on the path, mm.
fn places(toolpath: &Toolpath, lines: usize) -> Vec<Option<(f64, f64)>> {
    let mut places: Vec<Option<(f64, f64)>> = vec![None; lines + 1];
    let distances = toolpath.distances();
    for (segment, ends) in toolpath.segments.iter().zip(distances.windows(2)) {
        if let Some(place) = places.get_mut(segment.line.0 as usize) {
            *place = Some((place.map_or(ends[0], |(first, _)| first), ends[1]));
        }
    }
    places
}

/// Returns the delay of the second revision against the first along the path of the second: distances (mm)
/// and delays (s). The extra time of a line is spread over its moves, and the extra time of replaced lines over all
/// of their moves; the delay of lines without moves appears at the next move.
fn delay_curve(
    toolpath: &Toolpath,
    runs: &[RevisedLines],
    before: &LineTotals,
    after: &LineTotals,
) -> (Vec<f64>, Vec<f64>) {
    let lines = after.seconds.len();
    let (mut rates, mut steps) = (vec![0.0; lines], vec![0.0; lines]);
    for run in runs {
        let [first, second] = &run.lines;
        if run.is_same {
            for (one, other) in first.clone().zip(second.clone()) {
                let [one, other] = [one as usize, other as usize];
                spread(
                    &mut rates,
                    &mut steps,
                    other..other + 1,
                    after.seconds[other] - before.seconds[one],
                    after,
                );
            }
        } else {
            let own = second.start as usize..second.end as usize;
            let by = after.seconds(second) - before.seconds(first);
            spread(&mut rates, &mut steps, own, by, after);
        }
    }
    steps[0] += after.seconds[0] - before.seconds[0];
    let (mut distance, mut later) = (vec![0.0], vec![0.0]);
    let (mut travelled, mut behind, mut passed) = (0.0, 0.0, 0);
    for (segment, end) in toolpath.segments.iter().zip(toolpath.ends()) {
        let line = (segment.line.0 as usize).min(lines - 1);
        // A loop returns to lines that were run before.
        if passed <= line {
            behind += sum(&steps[passed..=line]);
            passed = line + 1;
        }
        travelled = end;
        behind += rates[line] * segment.length;
        distance.push(travelled);
        later.push(behind);
    }
    distance.push(travelled);
    later.push(behind + sum(&steps[passed.min(lines)..]));
    (distance, later)
}

/// Spreads a time over the moves of lines; without moves it becomes a step at the first line.
fn spread(rates: &mut [f64], steps: &mut [f64], lines: Range<usize>, seconds: f64, of: &LineTotals) {
    let length = sum(&of.length[lines.clone()]);
    if 0.0 < length {
        rates[lines].fill(seconds / length);
    } else if let Some(step) = steps.get_mut(lines.start.min(of.seconds.len() - 1)) {
        *step += seconds;
    }
}

#[cfg(test)]
mod tests;
