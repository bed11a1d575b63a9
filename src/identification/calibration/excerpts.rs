//! Excerpts of long runs. A calibration chooses the model of the control by them, and a diagnosis looks for causes in them.
//!
//! The time of a simulation grows with the length of the program, and both need hundreds of simulations. Of a run longer
//! than [`LONG_RUN_S`] or [`LONG_RUN_SEGMENTS`] they therefore see only windows of [`WINDOW`] s, evenly spread and
//! [`CALIBRATION_WINDOWS_S`] or [`DIAGNOSIS_WINDOWS_S`] long in all, and windows of a few marks around [`STOPS_PER_KIND`] stops
//! of each kind. Each window becomes a separate program with the marks in it. Up to [`MARGIN_SEGMENTS`] moves before and after
//! the window are simulated and not compared, as the motion depends on nothing farther away than a filter delay, a ramp
//! or a full stop. The model is then fitted to the whole run, and the causes are judged on it.
//!
//! Limits: a look-ahead that is longer than the margin sees less far; an event that happens once, outside of all
//! windows and at no stop, is found only as a rest.

use std::ops::Range;

use crate::identification::alignment::{Alignment, Fix, Mark, ProgramPlace};
use crate::identification::effects::StopKind;
use crate::identification::fit::Run;
use crate::simulation::ordered::sort_by_number;
use crate::simulation::toolpath::{Motion, PathMode, Segment, Stop, Toolpath};

/// Duration above which a run is long, s.
const LONG_RUN_S: f64 = 300.0;
/// Number of segments above which a run is long.
const LONG_RUN_SEGMENTS: usize = 8_000;
/// Duration of the evenly spread windows of all runs together that a calibration sees, s: single operations of 20 to 110 s show
/// the model of a control.
pub const CALIBRATION_WINDOWS_S: f64 = 90.0;
/// Duration of those that a diagnosis sees, s: a cause may act at a few places only.
pub const DIAGNOSIS_WINDOWS_S: f64 = 180.0;
/// Length of a window, s.
const WINDOW: f64 = 7.5;
/// Maximum number of segments of the margin before and after a window.
const MARGIN_SEGMENTS: usize = 40;
/// Time of programmed feed moves after which a margin is long enough, s.
const MARGIN_S: f64 = 2.0;
/// Maximum number of stops of a kind that get a window.
const STOPS_PER_KIND: usize = 4;
/// Number of marks before and after a stop that belong to its window.
const MARKS_AROUND_STOP: usize = 6;
/// Least number of marks of a window.
const MIN_WINDOW_MARKS: usize = 4;

/// A part of a run.
pub struct Excerpt {
    toolpath: Toolpath,
    alignment: Alignment,
    overrides: (Option<f64>, Option<f64>),
}

impl Excerpt {
    /// Returns the excerpt as a run.
    pub fn run(&self) -> Run<'_> {
        Run { toolpath: &self.toolpath, alignment: &self.alignment, overrides: self.overrides }
    }

    /// Returns the time of the excerpt, s from the start of the recording.
    pub fn time(&self) -> &Range<f64> {
        &self.alignment.run
    }
}

/// Returns the excerpts of each run, with evenly spread windows of `windows_s` seconds in all; `None` if no run is long.
pub fn excerpts(runs: &[Run], windows_s: f64) -> Option<Vec<Vec<Excerpt>>> {
    let is_long = |run: &Run| {
        LONG_RUN_S < duration(&run.alignment.marks) || LONG_RUN_SEGMENTS < run.toolpath.segments.len()
    };
    runs.iter()
        .any(is_long)
        .then(|| runs.iter().map(|run| of_run(run, windows_s / runs.len() as f64)).collect())
}

fn duration(marks: &[Mark]) -> f64 {
    marks.first().zip(marks.last()).map_or(0.0, |(first, last)| last.time - first.time)
}

fn of_run(run: &Run, budget: f64) -> Vec<Excerpt> {
    let marks = &run.alignment.marks;
    let Some(first) = marks.first() else { return Vec::new() };
    let whole = duration(marks);
    let count = (budget / WINDOW).ceil().max(1.0);
    let at = |time: f64| marks.partition_point(|mark| mark.time < time);
    let mut windows: Vec<Range<usize>> = Vec::new();
    for window in 0..count as usize {
        let middle = first.time + whole * (window as f64 + 0.5) / count;
        let half = 0.5 * WINDOW.min(whole / count);
        windows.push(at(middle - half)..at(middle + half));
    }
    let Toolpath { stops, .. } = run.toolpath;
    let mut kinds: Vec<(Option<StopKind>, Vec<usize>)> = Vec::new();
    for (stop, kind) in stops.iter().map(|stop| StopKind::of(&stop.cause)).enumerate() {
        match kinds.iter_mut().find(|(own, _)| *own == kind) {
            Some((_, all)) => all.push(stop),
            None => kinds.push((kind, vec![stop])),
        }
    }
    let distances = run.toolpath.distances();
    let distance = |place: ProgramPlace| place.distance(run.toolpath, &distances);
    for (_, all) in &kinds {
        for stop in all.iter().step_by(all.len().div_ceil(STOPS_PER_KIND)) {
            let there = distance(ProgramPlace::Stop(*stop));
            // A recording of positions has no mark at the stop itself.
            let index = marks.partition_point(|mark| distance(mark.place) < there);
            let first = index.saturating_sub(MARKS_AROUND_STOP);
            windows.push(first..(index + MARKS_AROUND_STOP).min(marks.len()));
        }
    }
    sort_by_number(&mut windows, |window| window.start as f64);
    let mut merged: Vec<Range<usize>> = Vec::new();
    for window in windows {
        match merged.last_mut() {
            Some(last) if window.start <= last.end => last.end = last.end.max(window.end),
            _ => merged.push(window),
        }
    }
    merged
        .into_iter()
        .filter(|window| MIN_WINDOW_MARKS <= window.len())
        .filter_map(|window| cut(run, &distances, window))
        .collect()
}

/// Returns the number of these segments, counted from a window outwards, that make a margin.
fn enough(segments: impl Iterator<Item = Segment>) -> usize {
    let mut seconds = 0.0;
    let mut is_missing = |segment: &Segment| {
        let is_near = seconds < MARGIN_S;
        if let Motion::Feed { feedrate } = segment.motion {
            seconds += segment.length / feedrate;
        }
        is_near
    };
    segments.take(MARGIN_SEGMENTS).take_while(|segment| is_missing(segment)).count()
}

/// Cuts a window of marks with its margins out of a run. `distances` holds the distance along the path before each segment,
/// mm. Returns `None` if the window contains no marks or no segments.
fn cut(run: &Run, distances: &[f64], window: Range<usize>) -> Option<Excerpt> {
    let Run { toolpath, alignment, overrides } = run;
    let marks = &alignment.marks[window];
    let segment_of = |place: ProgramPlace| match place {
        ProgramPlace::Start => 0,
        ProgramPlace::Stop(stop) | ProgramPlace::After(stop) => toolpath.stops[stop].after,
        ProgramPlace::Along(distance) => {
            distances.partition_point(|begin| *begin <= distance).saturating_sub(1)
        }
    };
    let count = toolpath.segments.len();
    let first = segment_of(marks.first()?.place).min(count);
    let last = (segment_of(marks.last()?.place) + 1).min(count);
    let from = first - enough(toolpath.segments.range(0..first).rev());
    let to = last + enough(toolpath.segments.range(last..count));
    if to <= from {
        return None;
    }
    let is_in = |stop: &Stop| (from < stop.after || from == 0) && (stop.after < to || to == count);
    let before = toolpath.stops.iter().position(is_in).unwrap_or(toolpath.stops.len());
    let stops = toolpath.stops[before..].iter().take_while(|stop| is_in(stop));
    let stops: Vec<Stop> =
        stops.map(|stop| Stop { after: stop.after.saturating_sub(from), ..*stop }).collect();
    let moved = |place: ProgramPlace| match place {
        ProgramPlace::Start => (from == 0).then_some(place),
        ProgramPlace::Along(distance) => Some(ProgramPlace::Along(distance - distances[from])),
        ProgramPlace::Stop(stop) => {
            (before <= stop && stop < before + stops.len()).then(|| ProgramPlace::Stop(stop - before))
        }
        ProgramPlace::After(stop) => {
            (before <= stop && stop < before + stops.len()).then(|| ProgramPlace::After(stop - before))
        }
    };
    let marks: Vec<Mark> =
        marks.iter().filter_map(|mark| moved(mark.place).map(|place| Mark { place, ..*mark })).collect();
    let time = marks.first()?.time..marks.last()?.time;
    let fixes = alignment.fixes.iter().filter(|fix| time.contains(&fix.time));
    let fixes = fixes.map(|fix| Fix { distance: fix.distance - distances[from], ..*fix });
    let length = distances[to] - distances[from];
    let modes = toolpath.path_modes.partition_point(|mode| mode.from <= from).saturating_sub(1);
    let modes = toolpath.path_modes[modes..].iter().filter(|mode| mode.from < to);
    let modes = modes.map(|mode| PathMode { from: mode.from.saturating_sub(from), ..mode.clone() });
    let spins = toolpath.spins.partition_point(|(first, _)| *first <= from).saturating_sub(1);
    let spins = toolpath.spins[spins..].iter().filter(|(first, _)| *first < to);
    let spins = spins.map(|(first, spin)| (first.saturating_sub(from), *spin));
    let part = Toolpath {
        segments: toolpath.segments.range(from..to).collect(),
        begins_at: toolpath.begins_at + distances[from],
        dialect: toolpath.dialect,
        path_modes: modes.collect(),
        operations: Vec::new(),
        spins: spins.collect(),
        diagnostics: Vec::new(),
        declined: None,
        doubts: Vec::new(),
        stops,
    };
    let alignment = Alignment {
        method: alignment.method,
        run: time.clone(),
        fixes: fixes.collect(),
        covered: 0.0..length,
        length,
        poll: alignment.poll,
        fit: alignment.fit,
        spread: alignment.spread,
        track: alignment.track.clone(),
        feed: alignment.feed.as_ref().map(|feed| feed.during(&time)),
        remarks: Vec::new(),
        shift: alignment.shift,
        passes: alignment.passes,
        blends_widely: alignment.blends_widely,
        marks,
    };
    Some(Excerpt { toolpath: part, alignment, overrides: *overrides })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identification::alignment::Method;
    use crate::machine::Machine;
    use crate::simulation::gcode::read;
    use crate::simulation::interpreter::trace;

    /// A recording of positions has marks along the path alone; the tool change at 61 % of it lies between two evenly spread
    /// windows.
    #[test]
    fn a_stop_of_each_kind_has_a_window_in_a_recording_of_positions() {
        let legs = |count: usize| "X10\nX0\n".repeat(count);
        let program = format!("G1 F600\n{}T2 M6\n{}M30\n", legs(305), legs(195));
        let toolpath = trace(&read(program.as_bytes()), &Machine::default());
        let mark = |at: u32| Mark {
            place: ProgramPlace::Along(5.0 * f64::from(at)),
            time: 0.5 * f64::from(at),
            deviation: 1e-3,
        };
        let marks: Vec<Mark> = (0..2000).map(mark).collect();
        let alignment = Alignment::of_marks(Method::Positions, 0.0..1000.0, marks, 10_000.0);
        let run = Run { toolpath: &toolpath, alignment: &alignment, overrides: (None, None) };
        let found = excerpts(&[run], CALIBRATION_WINDOWS_S).expect("the run is long");
        let is_change = |stop: &Stop| StopKind::of(&stop.cause) == Some(StopKind::ToolChange);
        let with_change = found[0].iter().filter(|own| own.toolpath.stops.iter().any(is_change));
        let [excerpt] = &with_change.collect::<Vec<_>>()[..] else {
            panic!("one excerpt has the tool change")
        };
        assert!(excerpt.time().contains(&610.0), "{:?}", excerpt.time());
    }
}
