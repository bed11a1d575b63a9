//! Recording → [`Alignment`]: which moment of the recording belongs to which place in the program.
//!
//! Three ways, the first that the recording allows:
//!
//! | recorded | way | module |
//! |---|---|---|
//! | axis positions | the cheapest way along the path, never back | `positions` |
//! | line numbers | the next visit of each line named | `lines` |
//! | feed alone | its integral, anchored at the stops of the program | `feed` |
//!
//! The result is a list of [`Mark`]s, places with the time at which the machine was there. Time is
//! never warped: a mark is a stamp of the recording with its uncertainty. What cannot be from this
//! program is refused, with what would fit instead where that is known: other units, exchanged axes, a
//! path run backwards, another zero point.
//!
//! A recording may hold several passes of the program, and ways before, between and behind them: the first whole pass
//! is aligned, the others are counted. Limits: rotary axes are not compared.

mod driven;
mod feed;
mod hints;
mod lines;
mod log;
mod pace;
mod pairing;
mod path;
mod place;
mod positions;
mod registration;
mod stops;
mod travelled;
mod visited;
mod ways;

use std::borrow::Cow;
use std::ops::Range;
use std::sync::Arc;
use thiserror::Error;

pub use crate::identification::alignment::driven::times_at_marks;
pub use crate::identification::alignment::log::align_log;
pub use crate::identification::alignment::pace::TooFast;
pub use crate::identification::alignment::pairing::{Pairing, pair};
pub use crate::identification::alignment::place::{Place, Visit, times, visits};
use crate::identification::alignment::positions::WHOLE_PASS;
pub use crate::identification::alignment::positions::{Track, median};
use crate::identification::recording::{Channel, ClosureError, Recording, RunMark};
use crate::machine::Machine;
use crate::simulation::toolpath::{Toolpath, Vector};

/// The least of a program that is worth a comparison, as a part of its length and in marks.
const LEAST: (f64, usize) = (0.01, 4);

/// A place with the time at which the recorded machine was there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mark {
    /// The place.
    pub place: Place,
    /// When, s from the start of the recording.
    pub time: f64,
    /// Standard deviation of the time, s.
    pub deviation: f64,
}

/// Where the recorded tool was when.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fix {
    /// When, s from the start of the recording.
    pub time: f64,
    /// Distance along the programmed path, mm.
    pub distance: f64,
    /// The sample of the track it is from, where positions were recorded.
    pub sample: Option<usize>,
}

/// How a recording was aligned.
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
    /// What it goes by, for people.
    pub fn name(self) -> &'static str {
        match self {
            Method::Positions => "axis positions",
            Method::Lines => "line numbers",
            Method::Feed => "the integral of the feed between stops",
        }
    }
}

/// A recording on a program.
#[derive(Clone, Debug)]
pub struct Alignment {
    /// How.
    pub method: Method,
    /// The run within the recording, s.
    pub run: Range<f64>,
    /// Places with their times, ascending in both.
    pub marks: Vec<Mark>,
    /// Where the tool was when, ascending in time; finer than the marks.
    pub fixes: Vec<Fix>,
    /// What part of the path was recorded, mm along it.
    pub covered: Range<f64>,
    /// Length of the path, mm.
    pub length: f64,
    /// Time between looks at the control, s, where it was asked now and then and not recorded throughout.
    pub poll: Option<f64>,
    /// How well it fits, 0 to 1: the part of the recorded way on the path, of lines in order, or of
    /// stops found.
    pub fit: f64,
    /// Root mean square of the distance from the path, mm; none without positions.
    pub spread: Option<f64>,
    /// The recorded positions in the program's coordinates, where there are any.
    pub track: Option<Arc<Track>>,
    /// The feed that was recorded, where there is any and its unit is known.
    pub feed: Option<Channel<f64>>,
    /// What was assumed or repaired, for people.
    pub remarks: Vec<String>,
    /// Recorded less programmed coordinates, mm.
    pub shift: Vector,
    /// How often the program was run in the recording.
    pub passes: usize,
}

impl Alignment {
    /// The same with the stamps of a clock that is right, where the recorder's says `ratio` seconds for each.
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

/// Why a recording cannot be laid on a program.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum AlignmentError {
    /// The program has no path.
    #[error("the program moves nothing, so that there is nothing to compare with")]
    NoPath,
    /// Neither positions, nor lines, nor feed.
    #[error("the recording has neither positions nor line numbers nor feed; record one of them")]
    NothingToFollow,
    /// Hardly a movement in it.
    #[error("the machine stands still in the whole recording; record a run of the program")]
    StandsStill,
    /// No sample lies near the path.
    #[error("no recorded position lies near the programmed path: is it a recording of another program?")]
    NowhereNear,
    /// The path does not fit.
    #[error("{part:.0} % of the recorded way is off the programmed path{}", what_then(hint.as_deref()))]
    OffPath {
        /// The part, %.
        part: f64,
        /// What would fit, as a clause.
        hint: Option<String>,
    },
    /// The way does not fit.
    #[error(
        "the recorded way is {ratio:.2} times as long as the path it was laid on: it is a recording of another program"
    )]
    OtherWay {
        /// Recorded over programmed.
        ratio: f64,
    },
    /// Line numbers do not come in the order of the program.
    #[error("only {:.0} % of the recorded line numbers come in the order of the program: is it a recording of another program, or are they block numbers (N)?", 100.0 * in_order)]
    LinesDoNotFit {
        /// The part in order.
        in_order: f64,
    },
    /// Stops do not come where the program has them.
    #[error(
        "the machine did not stop where the program does, near {at:.1} mm of the path: is it a recording of another program?"
    )]
    StopsDoNotFit {
        /// Distance along the path, mm.
        at: f64,
    },
    /// Too little to compare.
    #[error("only {covered:.1} mm of the path were recorded, too little to compare")]
    TooLittle {
        /// The part, mm.
        covered: f64,
    },
    /// Times are in another unit than seconds.
    #[error(
        "the recording runs in {} what the simulation runs in {}: its time is in another unit than its column says",
        seconds(*recorded), seconds(*simulated)
    )]
    TimeUnit {
        /// How long the recording takes, s.
        recorded: f64,
        /// How long the simulation takes for it, s.
        simulated: f64,
    },
    /// The program cannot be cut as fast.
    #[error(
        "{:.0} % of the cutting is faster than twice the programmed feed, as up to line {}: {} recorded where length \
         over feed makes {}; it is a recording of another program",
        100.0 * part, worst.line, seconds(worst.recorded), seconds(worst.programmed)
    )]
    TooFast {
        /// The part of the programmed cutting time.
        part: f64,
        /// The longest stretch.
        worst: TooFast,
    },
    /// Lines are of another length.
    #[error(
        "the machine went ways of another length than {:.0} % of the lines that cut, by its feed and line numbers: it \
         is a recording of another program", 100.0 * part
    )]
    WaysDoNotFit {
        /// The part of the way that was compared.
        part: f64,
    },
    /// Units do not close.
    #[error("{0}")]
    Units(#[from] ClosureError),
}

/// A duration with two digits that count.
fn seconds(value: f64) -> String {
    let decimals = (1.0 - value.abs().max(1e-12).log10().floor()).clamp(0.0, 12.0) as usize;
    format!("{value:.decimals$} s")
}

/// The end of the sentence that says how much is off the path.
fn what_then(hint: Option<&str>) -> String {
    hint.map_or(": is it a recording of another program?".to_string(), |hint| format!(", but {hint}"))
}

/// Lays a recording on a program: the first of its runs that are as long as any, or why none fits.
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
            format!("the recording has {several} runs; the one from {start:.1} s to {end:.1} s is compared");
        alignment.remarks.push(one);
    }
    Ok(alignment)
}

/// Whole alignments that are looked for; a log of a year has thousands.
const MAX_WHOLE: usize = 32;

/// The first alignment that covers about as much as any, and how many passes such alignments hold; the first refusal
/// where there is none.
fn longest(
    alignments: impl Iterator<Item = Result<Alignment, AlignmentError>>,
) -> Result<(Alignment, usize), AlignmentError> {
    let covered = |alignment: &Alignment| alignment.covered.end - alignment.covered.start;
    let mut best: Option<(Alignment, usize)> = None;
    let mut refusal = None;
    for outcome in alignments {
        match (outcome, &mut best) {
            (Err(error), _) => refusal = refusal.or(Some(error)),
            (Ok(other), Some((first, passes))) if WHOLE_PASS * covered(&other) <= covered(first) => {
                if WHOLE_PASS * covered(first) <= covered(&other) {
                    *passes += other.passes;
                }
                if MAX_WHOLE <= *passes {
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
        travelled::by_positions(&own, run, toolpath, machine)
    } else if own.line.as_ref().is_some_and(|line| 2 < line.values.len()) {
        visited::by_lines(&own, run, ends, toolpath, machine)
    } else if own.feed.is_some() {
        stops::by_feed(&own, run, toolpath, machine)
    } else {
        Err(AlignmentError::NothingToFollow)
    };
    pace::checked_pace(alignment?, toolpath, machine)
}

fn is_of_units(error: &ClosureError) -> bool {
    matches!(error, ClosureError::WouldFit { .. })
}

/// The place at which a program is over.
fn end_of(toolpath: &Toolpath) -> Place {
    let last = toolpath.stops.len().checked_sub(1);
    match last.filter(|stop| toolpath.segments.len() <= toolpath.stops[*stop].after) {
        Some(stop) => Place::After(stop),
        None => Place::Along(toolpath.segments.iter().map(|segment| segment.length).sum::<f64>() * 1.000001),
    }
}

/// Refuses what is too little to compare.
fn checked(alignment: Alignment) -> Result<Alignment, AlignmentError> {
    let covered = alignment.covered.end - alignment.covered.start;
    if covered < LEAST.0 * alignment.length || alignment.marks.len() < LEAST.1 {
        return Err(AlignmentError::TooLittle { covered });
    }
    let mut alignment = alignment;
    let (start, end) = (alignment.covered.start, alignment.length - alignment.covered.end);
    let part = 0.005 * alignment.length + 1.0;
    if part < start {
        alignment.remarks.push(format!("the first {start:.1} mm of the path were not recorded"));
    }
    if part < end {
        alignment.remarks.push(format!("the last {end:.1} mm of the path were not recorded"));
    }
    Ok(alignment)
}
