//! Alignment and plan → [`Comparison`]: the time that the recorded machine lost against the simulated one, by
//! place.
//!
//! The residual at a mark is the delay of the recorded machine (s),
//!
//! ```text
//! r(s) = (T_recorded(s) − T_recorded(first)) − (T_simulated(s) − T_simulated(first))
//! ```
//!
//! and the lost time of a visit is the difference of r between its ends. The lost times add up to the
//! difference of the cycle times exactly, whatever the start offset. A stop is waiting; if its line also
//! moves, the lost time of the whole visit counts as waiting.
//!
//! Feedrates are compared over distance, on feed moves only, as the RMS weighted by distance; feedrates
//! of a polled log of lines as means over some polls, because the log resolves no shorter distance. Positions are
//! compared at equal places: the time of the simulated position is shifted by r, averaged over a quarter of a
//! second on either side, so that the difference is the deviation of the path without the time lost.

mod lost_time;
mod contour_deviation;
mod measures;
mod pointwise;
mod ramp_shape;

pub use contour_deviation::{ContourDeviation, TYPICAL_PARTS};
pub use lost_time::{LostTimeCurve, lost_time_curve};
pub use measures::{FeedError, Feedrates, PooledFeedError, PositionError};
pub use pointwise::{Pointwise, pointwise};
pub use ramp_shape::{RampMisfit, ramp_windows};

use std::ops::Range;

use crate::identification::alignment::{Alignment, Method, ProgramPlace, Visit, times, visits};
use crate::simulation::feed::FeedPlan;
use crate::simulation::gcode::LineNumber;
use crate::simulation::toolpath::Toolpath;

/// The time lost in one visit of a line.
#[derive(Clone, Debug, PartialEq)]
pub struct VisitTimes {
    /// Line.
    pub line: LineNumber,
    /// Distance along the path, mm.
    pub distance: Range<f64>,
    /// Time in the recording, s from its start.
    pub recorded: Range<f64>,
    /// Time in the simulation, s.
    pub simulated: Range<f64>,
    /// Indices of its stops in the toolpath.
    pub stops: Range<usize>,
}

impl VisitTimes {
    /// Returns `true` if the visit contains a stop.
    pub fn waits(&self) -> bool {
        !self.stops.is_empty()
    }

    /// Returns the lost time, s.
    pub fn seconds(&self) -> f64 {
        (self.recorded.end - self.recorded.start) - (self.simulated.end - self.simulated.start)
    }
}

/// Times between the first and the last mark, s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Durations {
    /// Of the recorded machine.
    pub recorded: f64,
    /// Of the simulated machine.
    pub simulated: f64,
}

impl Durations {
    /// Returns simulated less recorded time, as a part of the recorded one.
    pub fn relative_error(self) -> f64 {
        self.simulated / self.recorded - 1.0
    }
}

/// A recording compared with a simulation of the same program.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// Delay of the recorded machine at each mark, s; 0 at the first.
    pub residuals: Vec<f64>,
    /// Time of the simulated machine at each mark, s.
    pub simulated: Vec<f64>,
    /// Lost time of each visit, in program order; adds up to the last residual.
    pub lost: Vec<VisitTimes>,
    /// Times of the whole run, including waits.
    pub whole: Durations,
    /// Times of the motion without waits.
    pub motion: Durations,
    /// Difference of feedrates; `None` if no feed move was recorded.
    pub feed: Option<FeedError>,
    /// Difference of positions; `None` if none were recorded.
    pub position: Option<PositionError>,
}

/// Compares a recording with a plan for the same toolpath.
///
/// # Examples
///
/// ```
/// use truefeed::identification::{comparison::compare, fit::AlignedRun};
/// use truefeed::machine::Machine;
/// use truefeed::simulation::{gcode, profile::Profile, simulate, interpreter::trace};
///
/// let mut machine = Machine::default();
/// let toolpath = trace(&gcode::read(b"G21 G90 G1 X40 F3000\nY30\nX5 Y10\nX0"), &machine);
/// // The operator has it run at half the feedrate.
/// machine.overrides.feed = 0.5;
/// let slow = simulate(&toolpath, &machine);
/// let profile = Profile::new(&toolpath, &slow);
/// let rows = (0..=(100.0 * profile.cycle_time()) as usize).map(|row| {
///     let at = profile.at_time(0.01 * row as f64).position;
///     format!("{:.2},{:.4},{:.4},{:.4}\n", 0.01 * row as f64, at.x, at.y, at.z)
/// });
/// let csv = "t_s,x_mm,y_mm,z_mm\n".to_string() + &rows.collect::<String>();
/// machine.overrides.feed = 1.0;
/// let recorded = AlignedRun::new(toolpath, csv.as_bytes(), &machine).expect("it is of this program");
/// let plan = simulate(&recorded.toolpath, &machine);
/// let comparison = compare(&recorded.toolpath, &plan, &recorded.alignment);
/// assert!((comparison.motion.recorded / comparison.motion.simulated - 2.0).abs() < 0.2);
/// ```
pub fn compare(toolpath: &Toolpath, plan: &FeedPlan, alignment: &Alignment) -> Comparison {
    let (simulated, residuals) = times_and_residuals(toolpath, plan, alignment);
    let lost = lost_by_visit(toolpath, plan, alignment, &simulated, &residuals);
    let mut motion = Durations::default();
    for visit in lost.iter().filter(|visit| !visit.waits()) {
        motion.recorded += visit.recorded.end - visit.recorded.start;
        motion.simulated += visit.simulated.end - visit.simulated.start;
    }
    let between = |first: Option<f64>, last: Option<f64>| last.zip(first).map_or(0.0, |(b, a)| b - a);
    let marks = &alignment.marks;
    let whole = Durations {
        recorded: between(marks.first().map(|m| m.time), marks.last().map(|m| m.time)),
        simulated: between(simulated.first().copied(), simulated.last().copied()),
    };
    let feed = Feedrates::of(toolpath, plan, alignment, &lost).error(&|_| true);
    let position = measures::position_error(toolpath, plan, alignment, &simulated, &residuals);
    Comparison { residuals, simulated, lost, whole, motion, feed, position }
}

/// Returns the times of each visit to a line, as [`compare`] does, without the other results of a comparison.
pub fn visit_times(toolpath: &Toolpath, plan: &FeedPlan, alignment: &Alignment) -> Vec<VisitTimes> {
    let (simulated, residuals) = times_and_residuals(toolpath, plan, alignment);
    lost_by_visit(toolpath, plan, alignment, &simulated, &residuals)
}

/// Returns the simulated time and the delay of the recorded machine at each mark, s.
fn times_and_residuals(toolpath: &Toolpath, plan: &FeedPlan, alignment: &Alignment) -> (Vec<f64>, Vec<f64>) {
    let places: Vec<ProgramPlace> = alignment.marks.iter().map(|mark| mark.place).collect();
    let simulated = times(toolpath, plan, &places);
    let residuals = residuals(alignment, &simulated);
    (simulated, residuals)
}

/// Returns the delay of the recorded machine at each mark, s, given the times of the simulated machine there
/// (s).
pub fn residuals(alignment: &Alignment, simulated: &[f64]) -> Vec<f64> {
    let Some((first, start)) = alignment.marks.first().zip(simulated.first()) else { return Vec::new() };
    let marks = alignment.marks.iter().zip(simulated);
    marks.map(|(mark, time)| (mark.time - first.time) - (time - start)).collect()
}

/// Returns a key that sorts places in program order: distance, index of the stop, and `true` at the end of
/// the stop.
fn order(place: ProgramPlace, toolpath: &Toolpath, distances: &[f64]) -> (f64, usize, bool) {
    let distance = place.distance(toolpath, distances);
    match place {
        ProgramPlace::Start => (-1.0, 0, false),
        ProgramPlace::Along(_) => (distance, usize::MAX, true),
        ProgramPlace::Stop(stop) => (distance, stop, false),
        ProgramPlace::After(stop) => (distance, stop, true),
    }
}
fn lost_by_visit(
    toolpath: &Toolpath,
    plan: &FeedPlan,
    alignment: &Alignment,
    simulated: &[f64],
    residuals: &[f64],
) -> Vec<VisitTimes> {
    let distances = toolpath.distances();
    let visits = visits(toolpath);
    let begins: Vec<ProgramPlace> = visits.iter().map(|visit| visit.begin).collect();
    let begin_times = times(toolpath, plan, &begins);
    let keys: Vec<_> = alignment.marks.iter().map(|mark| order(mark.place, toolpath, &distances)).collect();
    let (Some(first), Some(last)) = (keys.first(), keys.last()) else { return Vec::new() };
    let offset = alignment.marks[0].time - simulated[0];
    // Simulated time at the end of the recorded part, and the residual there.
    let end = (simulated[simulated.len() - 1], residuals[residuals.len() - 1]);
    let mut lost: Vec<VisitTimes> = Vec::new();
    let mut open: Option<(usize, f64, f64)> = Some((0, simulated[0], 0.0));
    let mut mark = 0;
    let close = |from: &(usize, f64, f64), until: (f64, f64), lost: &mut Vec<VisitTimes>| {
        let visit: &Visit = &visits[from.0];
        lost.push(VisitTimes {
            line: visit.line,
            distance: distances[visit.segments.start]..distances[visit.segments.end],
            recorded: offset + from.1 + from.2..offset + until.0 + until.1,
            simulated: from.1..until.0,
            stops: visit.stops.clone(),
        });
    };
    for (index, (begin, time)) in begins.iter().zip(&begin_times).enumerate() {
        let key = order(*begin, toolpath, &distances);
        if key <= *first {
            open = Some((index, simulated[0], 0.0));
            continue;
        }
        if *last <= key {
            break;
        }
        while keys[mark] < key {
            mark += 1;
        }
        let residual = between(alignment.method, *begin, key.0, mark, &keys, residuals, simulated, *time);
        if let Some(from) = open {
            close(&from, (*time, residual), &mut lost);
        }
        open = Some((index, *time, residual));
    }
    if let Some(from) = open {
        close(&from, end, &mut lost);
    }
    lost
}

/// Returns the residual at a place between the marks before and at `mark`.
#[expect(clippy::too_many_arguments, reason = "what is known of the two marks, taken apart")]
fn between(
    method: Method,
    place: ProgramPlace,
    distance: f64,
    mark: usize,
    keys: &[(f64, usize, bool)],
    residuals: &[f64],
    simulated: &[f64],
    time: f64,
) -> f64 {
    let (before, after) = (residuals[mark - 1], residuals[mark]);
    let along = |share: f64| before + share.clamp(0.0, 1.0) * (after - before);
    match (method, place) {
        // Marks from positions lie on both sides of a stop, and time lost between them is lost at the stop.
        (Method::Positions, ProgramPlace::Stop(_)) => before,
        (Method::Positions, ProgramPlace::After(_)) => after,
        (Method::Positions, ProgramPlace::Along(_)) => {
            let way = keys[mark].0 - keys[mark - 1].0;
            if 0.0 < way { along((distance - keys[mark - 1].0) / way) } else { after }
        }
        _ => {
            let span = simulated[mark] - simulated[mark - 1];
            if 0.0 < span { along((time - simulated[mark - 1]) / span) } else { after }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identification::alignment::{align, recorded_positions};
    use crate::identification::recording::read;
    use crate::machine::Machine;
    use crate::simulation::simulate;

    /// A program, its plan on the default machine, and the alignment of a recording of `recorded`, every 10 ms.
    fn run(program: &str, recorded: &Machine) -> (Toolpath, FeedPlan, Alignment) {
        let machine = Machine::default();
        let (toolpath, csv) = recorded_positions(program, recorded, |_, at| at);
        let log = read(csv.as_bytes()).expect("a table");
        let alignment = align(&log.recordings[0], &toolpath, &machine).expect("it is of this program");
        let plan = simulate(&toolpath, &machine);
        (toolpath, plan, alignment)
    }

    const PROGRAM: &str = "G21 G90 G1 X40 F3000\nY30\nX5 Y10\nG4 P1\nX0\nG3 X20 Y20 I20 J0\nG1 X60";

    #[test]
    fn a_recording_of_the_simulated_machine_loses_nothing() {
        let (toolpath, plan, alignment) = run(PROGRAM, &Machine::default());
        let comparison = compare(&toolpath, &plan, &alignment);
        let largest =
            comparison.residuals.iter().fold(0.0f64, |largest, residual| largest.max(residual.abs()));
        assert!(largest < 0.01, "within a row of the recording: {largest} s");
        let position = comparison.position.expect("positions were recorded");
        assert!(position.rms < 0.01, "{} mm", position.rms);
        let feed = comparison.feed.expect("feed moves were recorded");
        assert!(feed.rms < 0.1 * feed.programmed, "{} of {} mm/s", feed.rms, feed.programmed);
    }

    #[test]
    fn the_lost_times_of_all_visits_are_the_last_residual() {
        let mut slow = Machine::default();
        slow.overrides.feed = 0.7;
        slow.times.m_code = 0.5;
        let (toolpath, plan, alignment) = run(PROGRAM, &slow);
        let comparison = compare(&toolpath, &plan, &alignment);
        let last = *comparison.residuals.last().expect("there are marks");
        let sum: f64 = comparison.lost.iter().map(VisitTimes::seconds).sum();
        assert!(0.5 < last, "the override costs time: {last} s");
        assert!((sum - last).abs() < 1e-9, "{sum} and {last} s");
        let whole = comparison.whole.recorded - comparison.whole.simulated;
        assert!((whole - last).abs() < 1e-9, "{whole} and {last} s");
    }

    #[test]
    fn a_wait_is_lost_at_its_stop_and_not_in_motion() {
        let longer = PROGRAM.replace("G4 P1", "G4 P3");
        let machine = Machine::default();
        let (toolpath, plan, mut alignment) = run(PROGRAM, &machine);
        let (.., recorded) = run(&longer, &machine);
        // The programs have one path, so that the places of the marks are those of both.
        alignment.marks = recorded.marks;
        let comparison = compare(&toolpath, &plan, &alignment);
        let waits: f64 = comparison.lost.iter().filter(|visit| visit.waits()).map(VisitTimes::seconds).sum();
        assert!((waits - 2.0).abs() < 0.05, "{waits} s");
        let motion = comparison.motion.recorded - comparison.motion.simulated;
        assert!(motion.abs() < 0.05, "{motion} s");
    }

    #[test]
    fn the_lost_time_curve_ascends_along_the_path_and_ends_with_the_last_residual() {
        let mut slow = Machine::default();
        slow.overrides.feed = 0.5;
        let (toolpath, plan, alignment) = run(PROGRAM, &slow);
        let comparison = compare(&toolpath, &plan, &alignment);
        let curve = lost_time_curve(&toolpath, &alignment, &comparison);
        assert_eq!(curve.seconds, comparison.residuals);
        assert!(curve.distance.is_sorted());
        let length = *toolpath.distances().last().expect("the path has a length");
        assert!(*curve.distance.last().expect("there are marks") <= length);
    }
}
