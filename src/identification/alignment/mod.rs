//! Recording → [`Alignment`]: the place in the program at each moment of the recording.
//!
//! Three methods, the first that the recording allows:
//!
//! | recorded | way | module |
//! |---|---|---|
//! | axis positions | the cheapest way along the path, never back | `positions` |
//! | line numbers | the next visit of each line named | `lines` |
//! | feed alone | its integral, anchored at the stops of the program | `feed` |
//!
//! The result is a list of [`Mark`]s, places with the time at which the machine was there. Time is never
//! warped: a mark is a stamp of the recording with its uncertainty. A recording that cannot belong to this
//! program is refused; the error names a change that would make it fit if one is found: other units,
//! exchanged axes, a reversed path, another zero point.
//!
//! A recording may contain several passes of the program, and moves before, between and behind them: the
//! first whole pass is aligned, and the other passes are only counted. Limits: rotary axes are not compared.

mod simulated_recording;
mod feed;
mod hints;
mod line_matching;
mod log;
mod pace_check;
mod pairing;
mod path;
mod place;
mod map_matching;
mod registration;
mod feed_integration;
mod by_positions;
mod by_lines;
mod length_check;

use std::borrow::Cow;
use std::ops::Range;
use std::sync::Arc;
use thiserror::Error;

pub use crate::identification::alignment::log::align_log;
use crate::identification::alignment::map_matching::MIN_PASS_RATIO;
pub use crate::identification::alignment::map_matching::{Track, median};
pub use crate::identification::alignment::pace_check::TooFast;
pub use crate::identification::alignment::pairing::{Pairing, pair};
pub use crate::identification::alignment::place::{ProgramPlace, Visit, times, visits};
#[cfg(test)]
pub use crate::identification::alignment::simulated_recording::{
    RECORDED_ROW_S, recorded, recorded_positions,
};
pub use crate::identification::alignment::simulated_recording::{simulated_marks, times_at_marks};
use crate::identification::recording::{Channel, Recording, RunMark, UnitCheckError};
use crate::machine::Machine;
use crate::simulation::toolpath::{Toolpath, Vector};

/// Least part of a program's length in a comparison.
const MIN_COVERED_RATIO: f64 = 0.01;
/// Least number of marks in a comparison.
const MIN_MARKS: usize = 4;

/// A place with the time at which the recorded machine was there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mark {
    /// Place.
    pub place: ProgramPlace,
    /// Time, s from the start of the recording.
    pub time: f64,
    /// Standard deviation of the time, s.
    pub deviation: f64,
}

/// The distance of the recorded tool at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fix {
    /// Time, s from the start of the recording.
    pub time: f64,
    /// Distance along the programmed path, mm.
    pub distance: f64,
    /// Index of the sample of the track, if positions were recorded.
    pub sample: Option<usize>,
}

/// The method of an alignment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// By positions.
    Positions,
    /// By line numbers.
    Lines,
    /// By the integral of the feed.
    Feed,
}

impl Method {
    /// Returns the name of the method for people.
    pub fn name(self) -> &'static str {
        match self {
            Method::Positions => "axis positions",
            Method::Lines => "line numbers",
            Method::Feed => "the integral of the feed between stops",
        }
    }
}

/// A recording aligned with a program.
#[derive(Clone, Debug)]
pub struct Alignment {
    /// Method.
    pub method: Method,
    /// Run within the recording, s.
    pub run: Range<f64>,
    /// Places with their times, both ascending.
    pub marks: Vec<Mark>,
    /// Distances of the tool over time, ascending; finer than the marks.
    pub fixes: Vec<Fix>,
    /// Recorded part of the path, mm.
    pub covered: Range<f64>,
    /// Length of the path, mm.
    pub length: f64,
    /// Time between polls, s, if the control was polled and not recorded continuously.
    pub poll: Option<f64>,
    /// Quality of the fit, 0 to 1: the part of the recorded length on the path, of lines in order, or of
    /// stops found.
    pub fit: f64,
    /// RMS distance from the path, mm; `None` without positions.
    pub spread: Option<f64>,
    /// Recorded positions in the program's coordinates, if any.
    pub track: Option<Arc<Track>>,
    /// Recorded feed, if any and if its unit is known.
    pub feed: Option<Channel<f64>>,
    /// Assumptions and repairs, for people.
    pub remarks: Vec<String>,
    /// Recorded less programmed coordinates, mm.
    pub shift: Vector,
    /// Number of passes of the program in the recording.
    pub passes: usize,
    /// `true` if the control blends corners as widely as their speed requires, not within a tolerance.
    pub blends_widely: bool,
}

impl Alignment {
    /// Returns an alignment that consists of marks and a `run` (s) and covers a path of `length` (mm): one
    /// pass in the program's coordinates.
    pub fn of_marks(method: Method, run: Range<f64>, marks: Vec<Mark>, length: f64) -> Alignment {
        Alignment {
            method,
            run,
            marks,
            fixes: Vec::new(),
            covered: 0.0..length,
            length,
            poll: None,
            fit: 1.0,
            spread: None,
            track: None,
            feed: None,
            remarks: Vec::new(),
            shift: Vector::zeros(),
            passes: 1,
            blends_widely: false,
        }
    }

    /// Returns the alignment with its stamps corrected for a recorder's clock that advances `ratio` seconds
    /// per second.
    pub fn by_right_clock(&self, ratio: f64) -> Cow<'_, Alignment> {
        if ratio == 1.0 {
            return Cow::Borrowed(self);
        }
        let mut own = self.clone();
        own.run = own.run.start / ratio..own.run.end / ratio;
        own.poll = own.poll.map(|poll| poll / ratio);
        own.fixes.iter_mut().for_each(|fix| fix.time /= ratio);
        for mark in &mut own.marks {
            mark.time /= ratio;
            mark.deviation /= ratio;
        }
        let right = |times: &[f64]| times.iter().map(|time| time / ratio).collect();
        own.track = own.track.map(|track| {
            let (time, interval) = (right(&track.time), track.interval / ratio);
            Arc::new(Track { time, interval, ..(*track).clone() })
        });
        own.feed = own.feed.map(|feed| {
            let time: Vec<f64> = right(&feed.time);
            Channel { time: time.into(), ..feed }
        });
        Cow::Owned(own)
    }
}

/// The reason why a recording cannot be aligned with a program.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum AlignmentError {
    /// The program has no path.
    #[error("the program contains no motion to compare with")]
    NoPath,
    /// The recording has neither positions, nor lines, nor feed.
    #[error("the recording has no positions, line numbers or feed; record one of them")]
    NothingToFollow,
    /// Hardly any motion.
    #[error("the machine does not move in the whole recording; record a run of the program")]
    StandsStill,
    /// No sample lies near the path.
    #[error(
        "no recorded position lies near the programmed path; it seems to be a recording of another program"
    )]
    NowhereNear,
    /// The path does not fit.
    #[error("{part:.0} % of the recorded path is off the programmed path{}", what_then(hint.as_deref()))]
    OffPath {
        /// Part off the path, %.
        part: f64,
        /// A change that would make the recording fit, as a clause.
        hint: Option<String>,
    },
    /// The travelled length does not fit.
    #[error(
        "the recorded path is {ratio:.2} times as long as the programmed path it was aligned with: this is a recording of another program"
    )]
    OtherWay {
        /// Recorded over programmed.
        ratio: f64,
    },
    /// Line numbers do not come in the order of the program.
    #[error("only {:.0} % of the recorded line numbers follow the order of the program; it is a recording of another program, or they are block numbers (N)", 100.0 * in_order)]
    LinesDoNotFit {
        /// Part in order.
        in_order: f64,
    },
    /// Stops are not where the program has them.
    #[error(
        "the machine did not stop where the program does, near {at:.1} mm along the path; it seems to be a recording of another program"
    )]
    StopsDoNotFit {
        /// Distance along the path, mm.
        at: f64,
    },
    /// Too little for a comparison.
    #[error("the recording covers only {covered:.1} mm of the path, too little to compare")]
    TooLittle {
        /// Length of the covered part, mm.
        covered: f64,
    },
    /// Times are in another unit than seconds.
    #[error(
        "the recording takes {} for what the simulation runs in {}: its time column states the wrong unit",
        seconds(*recorded), seconds(*simulated)
    )]
    TimeUnit {
        /// Duration of the recording, s.
        recorded: f64,
        /// Duration of the simulation, s.
        simulated: f64,
    },
    /// The program cannot be cut that fast.
    #[error(
        "{:.0} % of the cutting is faster than twice the programmed feed, for example up to line {}: recorded {}, programmed {}; this is a recording of another program",
        100.0 * part, worst.line, seconds(worst.recorded), seconds(worst.programmed)
    )]
    TooFast {
        /// Part of the programmed cutting time that is too fast.
        part: f64,
        /// The longest stretch that is too fast.
        worst: TooFast,
    },
    /// Recorded lengths of lines differ from the program's.
    #[error(
        "for {:.0} % of the cutting lines, recorded feed and time give another length than the program: this is a recording of another program", 100.0 * part
    )]
    WaysDoNotFit {
        /// Part of the compared length.
        part: f64,
    },
    /// Units fail the check.
    #[error("{0}")]
    Units(#[from] UnitCheckError),
}

/// Formats a duration with two significant digits.
fn seconds(value: f64) -> String {
    let decimals = (1.0 - value.abs().max(1e-12).log10().floor()).clamp(0.0, 12.0) as usize;
    format!("{value:.decimals$} s")
}

/// Returns the end of the sentence on the part off the path.
fn what_then(hint: Option<&str>) -> String {
    hint.map_or("; it seems to be a recording of another program".to_string(), |hint| format!(", but {hint}"))
}

/// Aligns a recording with a program: returns the alignment of the first of its runs that covers about as
/// much as the one that covers most.
///
/// # Errors
///
/// Returns the error of the first run if none fits.
pub fn align(
    recording: &Recording,
    toolpath: &Toolpath,
    machine: &Machine,
) -> Result<Alignment, AlignmentError> {
    let runs = recording.runs.iter().filter(|run| run.time.start < run.time.end);
    let mut ranges: Vec<(Range<f64>, (bool, bool))> = runs
        .map(|run| {
            let by_status = run.found_by == RunMark::Status;
            (run.time.clone(), (by_status && run.has_start, by_status && run.has_end))
        })
        .collect();
    if ranges.is_empty() {
        ranges.push((0.0..recording.duration + 1.0, (false, false)));
    }
    let several = ranges.len();
    let aligned =
        ranges.into_iter().map(|(range, ends)| align_run(recording, range, ends, toolpath, machine));
    let (mut alignment, passes) = longest(aligned)?;
    alignment.passes = passes;
    if 1 < several {
        let Range { start, end } = alignment.run;
        let one =
            format!("the recording has {several} runs; this is the one from {start:.1} s to {end:.1} s");
        alignment.remarks.push(one);
    }
    Ok(alignment)
}

/// Most runs of one recording that are aligned; a log of a year has thousands.
const MAX_ALIGNMENTS: usize = 32;

/// Returns the first alignment that covers about as much as the longest, with the number of passes in all
/// alignments; the first error if there is no alignment.
fn longest(
    alignments: impl Iterator<Item = Result<Alignment, AlignmentError>>,
) -> Result<(Alignment, usize), AlignmentError> {
    let covered = |alignment: &Alignment| alignment.covered.end - alignment.covered.start;
    let mut best: Option<(Alignment, usize)> = None;
    let mut refusal = None;
    for outcome in alignments {
        match (outcome, &mut best) {
            (Err(error), _) => refusal = refusal.or(Some(error)),
            (Ok(other), Some((first, passes))) if MIN_PASS_RATIO * covered(&other) <= covered(first) => {
                if MIN_PASS_RATIO * covered(first) <= covered(&other) {
                    *passes += other.passes;
                }
                if MAX_ALIGNMENTS <= *passes {
                    break;
                }
            }
            (Ok(other), _) => {
                let passes = other.passes;
                best = Some((other, passes));
            }
        }
    }
    best.ok_or(refusal.unwrap_or(AlignmentError::NothingToFollow))
}

fn align_run(
    recording: &Recording,
    run: Range<f64>,
    ends: (bool, bool),
    toolpath: &Toolpath,
    machine: &Machine,
) -> Result<Alignment, AlignmentError> {
    if toolpath.segments.is_empty() {
        return Err(AlignmentError::NoPath);
    }
    let own = recording.during(&(run.start..run.end + 1e-9));
    let alignment = if own.positions().iter().any(Option::is_some) {
        by_positions::by_positions(&own, run, toolpath, machine)
    } else if own.line.as_ref().is_some_and(|line| 2 < line.values.len()) {
        by_lines::by_lines(&own, run, ends, toolpath, machine)
    } else if own.feed.is_some() {
        feed_integration::by_feed(&own, run, toolpath, machine)
    } else {
        Err(AlignmentError::NothingToFollow)
    };
    pace_check::checked_pace(alignment?, toolpath, machine)
}

fn is_of_units(error: &UnitCheckError) -> bool {
    matches!(error, UnitCheckError::WouldFit { .. })
}

/// Returns the place at the end of a program.
fn end_of(toolpath: &Toolpath) -> ProgramPlace {
    let last = toolpath.stops.len().checked_sub(1);
    match last.filter(|stop| toolpath.segments.len() <= toolpath.stops[*stop].after) {
        Some(stop) => ProgramPlace::After(stop),
        None => ProgramPlace::Along(
            toolpath.segments.iter().map(|segment| segment.length).sum::<f64>() * 1.000001,
        ),
    }
}

/// Refuses an alignment that is too short for a comparison.
fn checked(alignment: Alignment) -> Result<Alignment, AlignmentError> {
    let covered = alignment.covered.end - alignment.covered.start;
    if covered < MIN_COVERED_RATIO * alignment.length || alignment.marks.len() < MIN_MARKS {
        return Err(AlignmentError::TooLittle { covered });
    }
    let mut alignment = alignment;
    let (start, end) = (alignment.covered.start, alignment.length - alignment.covered.end);
    let part = 0.005 * alignment.length + 1.0;
    if part < start {
        alignment.remarks.push(format!("the recording misses the first {start:.1} mm of the path"));
    }
    if part < end {
        alignment.remarks.push(format!("the recording misses the last {end:.1} mm of the path"));
    }
    Ok(alignment)
}
