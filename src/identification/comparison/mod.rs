//! Alignment and plan → [`Comparison`]: where the recorded machine lost time against the simulated one.
//!
//! At every mark the residual is how much later the recorded machine is,
//!
//! ```text
//! r(s) = (T_recorded(s) − T_recorded(first)) − (T_simulated(s) − T_simulated(first))
//! ```
//!
//! and what a visit of a line lost is the difference of r between its ends. The lost times add up to the
//! difference of the cycle times exactly, whatever the start offset. A stop is either waiting or, where
//! its line also moves, both; what a visit with a stop lost counts as waiting.
//!
//! The feedrates are compared over the distance, feed moves alone: root mean squares, weighted by
//! distance; of a log that names lines now and then as means over some polls, because a place is not known
//! better than that. Positions are compared at equal places: the simulated one at the time shifted by r,
//! which is taken as the mean of a quarter of a second around, so that what is left is the form of the
//! path and not the time lost.

mod course;
mod form;
mod measures;
mod pointwise;

pub use course::{Course, course};
pub use form::Form;
pub use measures::{FeedError, PositionError, feed_error_during};
pub use pointwise::{Pointwise, pointwise};

use std::ops::Range;

use crate::identification::alignment::{Alignment, Method, Place, Visit, times, visits};
use crate::simulation::feed::FeedPlan;
use crate::simulation::gcode::LineNumber;
use crate::simulation::toolpath::Toolpath;

/// What one visit of a line lost.
#[derive(Clone, Debug, PartialEq)]
pub struct Lost {
    /// The line.
    pub line: LineNumber,
    /// Where it lies along the path, mm.
    pub distance: Range<f64>,
    /// When it ran in the recording, s from the start of the recording.
    pub recorded: Range<f64>,
    /// When it ran in the simulation, s.
    pub simulated: Range<f64>,
    /// Its stops in the toolpath.
    pub stops: Range<usize>,
}

impl Lost {
    /// Whether the machine waits in it.
    pub fn waits(&self) -> bool {
        !self.stops.is_empty()
    }

    /// How much longer the recorded machine took, s.
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

/// A recording beside a simulation of the same program.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// By how much the recorded machine is later at each mark, s; 0 at the first.
    pub residuals: Vec<f64>,
    /// When the simulated machine is at each mark, s.
    pub simulated: Vec<f64>,
    /// What each visit lost, in program order; together the last residual.
    pub lost: Vec<Lost>,
    /// All of it.
    pub whole: Durations,
    /// What is motion.
    pub motion: Durations,
    /// How far feedrates differ; none where no feed move was recorded.
    pub feed: Option<FeedError>,
    /// How far positions differ; none where none were recorded.
    pub position: Option<PositionError>,
}

/// Compares a recording with a plan for the same toolpath.
pub fn compare(toolpath: &Toolpath, plan: &FeedPlan, alignment: &Alignment) -> Comparison {
    let places: Vec<Place> = alignment.marks.iter().map(|mark| mark.place).collect();
    let simulated = times(toolpath, plan, &places);
    let residuals = residuals(alignment, &simulated);
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
    let feed = measures::feed_error(toolpath, plan, alignment, &lost);
    let position = measures::position_error(toolpath, plan, alignment, &simulated, &residuals);
    Comparison { residuals, simulated, lost, whole, motion, feed, position }
}

/// By how much the recorded machine is later at each mark, s, given when the simulated one is there.
pub fn residuals(alignment: &Alignment, simulated: &[f64]) -> Vec<f64> {
    let Some((first, start)) = alignment.marks.first().zip(simulated.first()) else { return Vec::new() };
    let marks = alignment.marks.iter().zip(simulated);
    marks.map(|(mark, time)| (mark.time - first.time) - (time - start)).collect()
}

/// The order of places in a program: distance, stop, and whether it is over.
fn order(place: Place, toolpath: &Toolpath, distances: &[f64]) -> (f64, usize, bool) {
    let distance = place.distance(toolpath, distances);
    match place {
        Place::Start => (-1.0, 0, false),
        Place::Along(_) => (distance, usize::MAX, true),
        Place::Stop(stop) => (distance, stop, false),
        Place::After(stop) => (distance, stop, true),
    }
}

fn lost_by_visit(
    toolpath: &Toolpath,
    plan: &FeedPlan,
    alignment: &Alignment,
    simulated: &[f64],
    residuals: &[f64],
) -> Vec<Lost> {
    let distances = toolpath.distances();
    let visits = visits(toolpath);
    let begins: Vec<Place> = visits.iter().map(|visit| visit.begin).collect();
    let begin_times = times(toolpath, plan, &begins);
    let keys: Vec<_> = alignment.marks.iter().map(|mark| order(mark.place, toolpath, &distances)).collect();
    let (Some(first), Some(last)) = (keys.first(), keys.last()) else { return Vec::new() };
    let offset = alignment.marks[0].time - simulated[0];
    // The simulated time at the end of what was recorded, and the residual there.
    let end = (simulated[simulated.len() - 1], residuals[residuals.len() - 1]);
    let mut lost: Vec<Lost> = Vec::new();
    let mut open: Option<(usize, f64, f64)> = Some((0, simulated[0], 0.0));
    let mut mark = 0;
    let close = |from: &(usize, f64, f64), until: (f64, f64), lost: &mut Vec<Lost>| {
        let visit: &Visit = &visits[from.0];
        lost.push(Lost {
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

/// The residual at a place between the marks before and at `mark`.
#[expect(clippy::too_many_arguments, reason = "what is known of the two marks, taken apart")]
fn between(
    method: Method,
    place: Place,
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
        // Marks of positions lie on both sides of a stop, and what is lost between them is lost there.
        (Method::Positions, Place::Stop(_)) => before,
        (Method::Positions, Place::After(_)) => after,
        (Method::Positions, Place::Along(_)) => {
            let way = keys[mark].0 - keys[mark - 1].0;
            if 0.0 < way { along((distance - keys[mark - 1].0) / way) } else { after }
        }
        _ => {
            let span = simulated[mark] - simulated[mark - 1];
            if 0.0 < span { along((time - simulated[mark - 1]) / span) } else { after }
        }
    }
}
