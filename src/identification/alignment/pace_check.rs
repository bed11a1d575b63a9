//! Plausibility of the pace along the path.
//!
//! Two paces are impossible under any overrides, limits and waits. Half of a program a hundred times as fast
//! or as slow as simulated means a wrong unit of time, as units differ by a factor of a thousand. Cutting in
//! less than half of the programmed time, length over F, means a wrong program, as dials of the feed override
//! end at 200 %.
//!
//! A tool that cuts corners travels less than the programmed length; if positions were recorded, the
//! travelled length replaces it. A blend runs at the feedrate of its faster leg; it takes half of the other leg at most,
//! or any part of it if the control blends as widely as its speed requires.
//!
//! Times are known only to within a poll, so that the compared places are at least [`RESOLVED_POLLS`] polls
//! of programmed time apart. Rapids, dwells and M-words are ignored.

use crate::identification::alignment::place::{ProgramPlace, times};
use crate::identification::alignment::{Alignment, AlignmentError};
use crate::machine::Machine;
use crate::simulation::ordered::weighted_median;
use crate::simulation::simulate;
use crate::simulation::toolpath::{Motion, Point, Toolpath};

/// Largest ratio of recorded to simulated time, and of its inverse, with the right unit of time.
const MAX_TIME_RATIO: f64 = 100.0;
/// Highest feed override of any dial.
const MAX_FEED_OVERRIDE: f64 = 2.0;
/// Least programmed time of a part that is timed, in polls.
const RESOLVED_POLLS: f64 = 4.0;
/// Largest part of marks with a wrong stamp in a log of the right program; one wrong mark is always allowed.
/// Of the 6,900 parts of the logs available, one is too fast.
const MAX_WRONG_MARKS_RATIO: f64 = 0.01;

/// Returns the alignment if its times are possible.
///
/// # Errors
///
/// Returns [`AlignmentError::TimeUnit`] if times are in another unit than seconds, and
/// [`AlignmentError::TooFast`] if the program cannot be cut that fast.
pub fn checked_pace(
    alignment: Alignment,
    toolpath: &Toolpath,
    machine: &Machine,
) -> Result<Alignment, AlignmentError> {
    checked_unit(&alignment, toolpath, machine)?;
    checked_feed(&alignment, toolpath)?;
    Ok(alignment)
}

fn checked_unit(alignment: &Alignment, toolpath: &Toolpath, machine: &Machine) -> Result<(), AlignmentError> {
    let marks = &alignment.marks;
    let places: Vec<ProgramPlace> = marks.iter().map(|mark| mark.place).collect();
    let simulated = times(toolpath, &simulate(toolpath, machine), &places);
    let pairs = marks.windows(2).zip(simulated.windows(2));
    let spans = pairs.map(|(marks, times)| (marks[1].time - marks[0].time, times[1] - times[0]));
    let timed = spans.filter(|(_, simulated)| 0.0 < *simulated);
    let ratios = timed.map(|(recorded, simulated)| (recorded / simulated, simulated));
    let ratio = weighted_median(ratios.collect()).unwrap_or(1.0);
    let (Some((first, last)), Some((begin, end))) =
        (marks.first().zip(marks.last()), simulated.first().zip(simulated.last()))
    else {
        return Ok(());
    };
    // A wrong unit scales the median and the sum of the spans. A long wait at another mark scales only the
    // median.
    let (recorded, simulated) = (last.time - first.time, end - begin);
    let is_impossible = |ratio: f64| !(1.0 / MAX_TIME_RATIO..MAX_TIME_RATIO).contains(&ratio);
    match is_impossible(ratio) && is_impossible(recorded / simulated) {
        true => Err(AlignmentError::TimeUnit { recorded, simulated }),
        false => Ok(()),
    }
}

fn checked_feed(alignment: &Alignment, toolpath: &Toolpath) -> Result<(), AlignmentError> {
    let interval = alignment.track.as_ref().map_or(0.0, |track| track.interval);
    let poll = alignment.poll.unwrap_or(interval);
    let clock = CuttingClock::new(toolpath, alignment.blends_widely);
    let odometer = Odometer::new(alignment);
    let (mut timed, mut too_fast) = (0.0, 0.0);
    let (mut stretches, mut contradictions) = (0, 0);
    let mut worst: Option<TooFast> = None;
    let mut anchor: Option<(ClockReading, f64)> = None;
    for mark in &alignment.marks {
        let reading = clock.at(mark.place);
        let Some((from, began)) = anchor.filter(|(from, _)| from.pause == reading.pause) else {
            anchor = Some((reading, mark.time));
            continue;
        };
        let length = reading.distance - from.distance;
        let part = odometer.between(began, mark.time).map_or(1.0, |way| (way / length).min(1.0));
        let programmed = part * (reading.seconds - from.seconds);
        if programmed < RESOLVED_POLLS * poll {
            continue;
        }
        anchor = Some((reading, mark.time));
        timed += programmed;
        stretches += 1;
        let recorded = mark.time - began;
        if MAX_FEED_OVERRIDE * (recorded + poll) < programmed {
            too_fast += programmed;
            contradictions += 1;
            if worst.is_none_or(|worst| worst.programmed < programmed) {
                worst = Some(TooFast { line: reading.line, recorded, programmed });
            }
        }
    }
    match worst {
        Some(worst) if 1.0 + MAX_WRONG_MARKS_RATIO * f64::from(stretches) < f64::from(contradictions) => {
            Err(AlignmentError::TooFast { part: too_fast / timed, worst })
        }
        _ => Ok(()),
    }
}

/// A part of the cut that is faster than possible.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TooFast {
    /// Line at its end.
    pub line: u32,
    /// Recorded duration, s.
    pub recorded: f64,
    /// Length over programmed feed, s.
    pub programmed: f64,
}

/// The travelled length of the recorded tool over time.
struct Odometer {
    /// Time (s) and travelled length (mm); empty without recorded positions.
    readings: Vec<(f64, f64)>,
}

impl Odometer {
    fn new(alignment: &Alignment) -> Odometer {
        let Some(track) = &alignment.track else { return Odometer { readings: Vec::new() } };
        let mut gone = 0.0;
        let mut last: Option<Point> = None;
        let moved = alignment.fixes.iter().filter_map(|fix| Some((fix.time, track.position[fix.sample?])));
        let readings = moved.map(|(time, position)| {
            gone += last.map_or(0.0, |last| (position - last).norm());
            last = Some(position);
            (time, gone)
        });
        Odometer { readings: readings.collect() }
    }

    /// Returns the travelled length between two times, mm; `None` without positions.
    fn between(&self, from: f64, to: f64) -> Option<f64> {
        let at = |time: f64| -> Option<f64> {
            let next = self.readings.partition_point(|reading| reading.0 < time);
            let last = self.readings.len().checked_sub(1)?;
            Some(self.readings[next.min(last)].1)
        };
        Some(at(to)? - at(from)?)
    }
}

/// Programmed time of cutting along the path.
struct CuttingClock<'a> {
    toolpath: &'a Toolpath,
    /// Distance at the beginning of each segment, and at the end, mm.
    distances: Vec<f64>,
    /// Cutting time before each segment, s, and the number of rapids and stops before it.
    before: Vec<(f64, usize)>,
    /// `true` if the control blends as widely as its speed requires.
    blends_widely: bool,
}

/// The values of a [`CuttingClock`] at a place.
#[derive(Clone, Copy)]
struct ClockReading {
    seconds: f64,
    /// Distance along the path, mm.
    distance: f64,
    /// Number of rapids and stops so far: two places with equal numbers have only cutting between them.
    pause: usize,
    line: u32,
}

/// Returns the largest mean feedrate of a segment that is cut, mm/s, or of any part of it if the control blends as widely
/// as its speed requires.
fn fastest(toolpath: &Toolpath, index: usize, blends_widely: bool) -> f64 {
    let asked = |index: usize| match toolpath.segments.motion(index) {
        Motion::Feed { feedrate } => feedrate,
        Motion::Rapid { .. } => 0.0,
    };
    let own = asked(index);
    let before = index.checked_sub(1).map_or(own, |before| own.max(asked(before)));
    let after = if index + 1 < toolpath.segments.len() { own.max(asked(index + 1)) } else { own };
    if blends_widely { before.max(after) } else { 2.0 / (1.0 / before + 1.0 / after) }
}

impl<'a> CuttingClock<'a> {
    fn new(toolpath: &'a Toolpath, blends_widely: bool) -> CuttingClock<'a> {
        let (mut seconds, mut pause, mut stop) = (0.0, 0, 0);
        let mut before = Vec::with_capacity(toolpath.segments.len() + 1);
        for (index, segment) in toolpath.segments.iter().enumerate() {
            while toolpath.stops.get(stop).is_some_and(|next| next.after <= index) {
                (stop, pause) = (stop + 1, pause + 1);
            }
            before.push((seconds, pause));
            match segment.motion {
                Motion::Feed { .. } => seconds += segment.length / fastest(toolpath, index, blends_widely),
                // Places on a rapid and behind it are not comparable either.
                Motion::Rapid { .. } => pause += 2,
            }
        }
        before.push((seconds, pause + toolpath.stops.len() - stop));
        CuttingClock { toolpath, distances: toolpath.distances(), before, blends_widely }
    }

    fn at(&self, place: ProgramPlace) -> ClockReading {
        let distance = place.distance(self.toolpath, &self.distances);
        let last = self.toolpath.segments.len() - 1;
        let index = self.distances.partition_point(|at| *at <= distance).saturating_sub(1).min(last);
        let segment = self.toolpath.segments.at(index);
        let (seconds, pause) = self.before[index];
        let line = segment.line.0;
        match (segment.motion, place) {
            (Motion::Feed { .. }, _) => ClockReading {
                seconds: seconds
                    + (distance - self.distances[index]) / fastest(self.toolpath, index, self.blends_widely),
                distance,
                pause,
                line,
            },
            // A rapid is not timed; cutting ends where it begins.
            (Motion::Rapid { .. }, _) if distance <= self.distances[index] => {
                ClockReading { seconds, distance, pause, line }
            }
            (Motion::Rapid { .. }, _) => ClockReading { seconds, distance, pause: pause + 1, line },
        }
    }
}
