//! Does the machine go along the path as fast as it may?
//!
//! Two things no override, limit or wait does: to run half of a program a hundred times as fast or as slowly as it
//! is simulated, which is a wrong unit of time, units being a thousand apart; and to cut in less than half of the
//! programmed time, length over F, which is a wrong program: dials of the feed override end at 200 %.
//!
//! A tool that cuts corners goes a shorter way than the program; where positions were recorded it is timed by the way it went.
//!
//! Times are known to within a poll, so that places are taken so far apart that their programmed times are
//! [`RESOLVED_POLLS`] polls and more. Rapids, dwells and M-words say nothing here.

use crate::identification::alignment::place::{Place, times};
use crate::identification::alignment::{Alignment, AlignmentError};
use crate::machine::Machine;
use crate::simulation::simulate;
use crate::simulation::toolpath::{Motion, Point, Toolpath};

/// Recorded over simulated time, or the inverse, beyond which the unit of time is another.
const MAX_TIME_RATIO: f64 = 100.0;
/// The highest feed override of any dial.
const MAX_FEED_OVERRIDE: f64 = 2.0;
/// Programmed time of a stretch that is timed, in times between looks at the control.
const RESOLVED_POLLS: f64 = 4.0;
/// Of a right program no stretch is too fast but by a wrong stamp: a log may have one, and one in a hundred.
const MAX_WRONG_MARKS: f64 = 0.01;

/// The alignment, if its times are possible.
///
/// # Errors
/// [`AlignmentError::TimeUnit`] where times are in another unit than seconds, [`AlignmentError::TooFast`] where the
/// program cannot be cut as fast.
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
    let places: Vec<Place> = marks.iter().map(|mark| mark.place).collect();
    let simulated = times(toolpath, &simulate(toolpath, machine), &places);
    let pairs = marks.windows(2).zip(simulated.windows(2));
    let spans = pairs.map(|(marks, times)| (marks[1].time - marks[0].time, times[1] - times[0]));
    let ratio = median_ratio(spans.filter(|(_, simulated)| 0.0 < *simulated).collect());
    let (Some((first, last)), Some((begin, end))) =
        (marks.first().zip(marks.last()), simulated.first().zip(simulated.last()))
    else {
        return Ok(());
    };
    // A wrong unit scales the median and the sum of the spans. A long wait at another mark scales the median alone.
    let (recorded, simulated) = (last.time - first.time, end - begin);
    let is_impossible = |ratio: f64| !(1.0 / MAX_TIME_RATIO..MAX_TIME_RATIO).contains(&ratio);
    match is_impossible(ratio) && is_impossible(recorded / simulated) {
        true => Err(AlignmentError::TimeUnit { recorded, simulated }),
        false => Ok(()),
    }
}

/// The median of recorded over simulated time (s), weighted by the simulated one; 1 of none.
fn median_ratio(mut spans: Vec<(f64, f64)>) -> f64 {
    spans.sort_by(|a, b| (a.0 / a.1).total_cmp(&(b.0 / b.1)));
    let half = 0.5 * spans.iter().map(|(_, simulated)| simulated).sum::<f64>();
    let mut weight = 0.0;
    let middle = spans.into_iter().find(|(_, simulated)| {
        weight += simulated;
        half <= weight
    });
    middle.map_or(1.0, |(recorded, simulated)| recorded / simulated)
}

fn checked_feed(alignment: &Alignment, toolpath: &Toolpath) -> Result<(), AlignmentError> {
    let interval = alignment.track.as_ref().map_or(0.0, |track| track.interval);
    let poll = alignment.poll.unwrap_or(interval);
    let clock = CuttingClock::new(toolpath);
    let odometer = Odometer::new(alignment);
    let (mut timed, mut too_fast) = (0.0, 0.0);
    let (mut stretches, mut contradictions) = (0, 0);
    let mut worst: Option<TooFast> = None;
    let mut anchor: Option<(Reading, f64)> = None;
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
        Some(worst) if 1.0 + MAX_WRONG_MARKS * f64::from(stretches) < f64::from(contradictions) => {
            Err(AlignmentError::TooFast { part: too_fast / timed, worst })
        }
        _ => Ok(()),
    }
}

/// A stretch of cutting that is faster than it can be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TooFast {
    /// The line at its end.
    pub line: u32,
    /// How long it was recorded to take, s.
    pub recorded: f64,
    /// Length over programmed feed, s.
    pub programmed: f64,
}

/// The way that the recorded tool went, by time.
struct Odometer {
    /// When (s) it had gone how far (mm); empty where no positions were recorded.
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

    /// The way between two times, mm.
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
    /// Cutting time before each segment, s, and how many rapids and stops there were.
    before: Vec<(f64, usize)>,
}

/// What a [`CuttingClock`] says at a place.
#[derive(Clone, Copy)]
struct Reading {
    seconds: f64,
    /// Along the path, mm.
    distance: f64,
    /// Rapids and stops so far: between two places with as many there is nothing but cutting.
    pause: usize,
    line: u32,
}

impl<'a> CuttingClock<'a> {
    fn new(toolpath: &'a Toolpath) -> CuttingClock<'a> {
        let (mut seconds, mut pause, mut stop) = (0.0, 0, 0);
        let mut before = Vec::with_capacity(toolpath.segments.len() + 1);
        for (index, segment) in toolpath.segments.iter().enumerate() {
            while toolpath.stops.get(stop).is_some_and(|next| next.after <= index) {
                (stop, pause) = (stop + 1, pause + 1);
            }
            before.push((seconds, pause));
            match segment.motion {
                Motion::Feed { feedrate } => seconds += segment.length / feedrate,
                // A place on a rapid and one behind it are not to be compared either.
                Motion::Rapid => pause += 2,
            }
        }
        before.push((seconds, pause + toolpath.stops.len() - stop));
        CuttingClock { toolpath, distances: toolpath.distances(), before }
    }

    fn at(&self, place: Place) -> Reading {
        let distance = place.distance(self.toolpath, &self.distances);
        let last = self.toolpath.segments.len() - 1;
        let index = self.distances.partition_point(|at| *at <= distance).saturating_sub(1).min(last);
        let segment = self.toolpath.segments.at(index);
        let (seconds, pause) = self.before[index];
        let line = segment.line.0;
        match (segment.motion, place) {
            (Motion::Feed { feedrate }, _) => Reading {
                seconds: seconds + (distance - self.distances[index]) / feedrate,
                distance,
                pause,
                line,
            },
            // On a rapid nothing is timed; where one begins cutting is over.
            (Motion::Rapid, _) if distance <= self.distances[index] => {
                Reading { seconds, distance, pause, line }
            }
            (Motion::Rapid, _) => Reading { seconds, distance, pause: pause + 1, line },
        }
    }
}
