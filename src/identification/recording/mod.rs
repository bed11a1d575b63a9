//! Bytes of a machine log → [`Recording`]: what the control did, over time, in core units.
//!
//! ```text
//! bytes ── text ──▶ characters ── sniffed by content ──▶ reader of one format ──▶ signals ── assemble ──▶ Log
//! ```
//!
//! Formats, each documented at the head of its module:
//!
//! | content | module |
//! |---|---|
//! | rows of numbers with a row of names: CSV of any separator, Heidenhain `scope2csv` | `table` |
//! | rows of numbers without names: LinuxCNC `halsampler` | `nameless` |
//! | `time\|item\|value…`: SHDR of MTConnect adapters; the same as a long table | `events` |
//! | MTConnect streams XML | `mtconnect` |
//! | SINUMERIK trace XML | `siemens_trace` |
//! | SINUMERIK data recorder JSON | `siemens_recorder` |
//! | Beckhoff TwinCAT Scope CSV | `beckhoff` |
//!
//! A log is what it says: nothing is resampled, interpolated or smoothed. Every channel has its own
//! stamps (see [`Channel`]), so a table at 1 kHz and an event log that names the line five times a
//! second are the same type. One file may hold several recordings (their clocks do not compare) and
//! a recording several runs of programs (ranges of one clock); both are kept apart, never merged.
//!
//! Units stated in the file are converted. Where none is stated the values stay as they are and
//! name their candidates; [`closure`] settles which, against the length of the path. Cost is linear
//! in the size of the file.
//!
//! A log may be packed by gzip, or as the only file of a ZIP archive.
//!
//! Not read: zlib streams (Klipper's motan logs), archives of several files, binary files, rotary axes, loads; thousands separators in numbers; logs across midnight stamped with the
//! time of day alone.

mod assemble;
mod beckhoff;
mod channel;
mod clock;
mod closure;
mod columns;
mod diagnostic;
mod events;
mod field;
mod layout;
mod mtconnect;
mod nameless;
mod packed;
mod runs;
mod siemens_recorder;
mod siemens_trace;
mod sniff;
mod switches;
mod table;
#[cfg(test)]
mod tests;
mod text;
pub mod unit;

use std::ops::Range;

pub use channel::{Channel, Sampling, Scale};
pub use closure::{Closure, ClosureError, Measure, TOLERANCE, closure, closure_of, closure_on, path_length};
pub use diagnostic::{RecordingError, Remark, Remarks, Severity};
pub use field::Side;
pub use packed::is_packed_log;
pub use sniff::{SNIFFED_BYTES, is_recording};
pub use switches::Switches;

use crate::identification::recording::unit::Unit;

/// What a file may leave open.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Options {
    /// Time between rows of a table without a time column, s.
    pub interval: Option<f64>,
    /// Unit of a time column that states none.
    pub time_unit: Option<Unit>,
    /// Names of the columns of a table without names.
    pub columns: Option<Vec<String>>,
}

/// A file, read.
#[derive(Clone, Debug, PartialEq)]
pub struct Log {
    /// What kind of file it is, for people.
    pub format: &'static str,
    /// Recordings in the order of the file; at least one. Time starts again in each.
    pub recordings: Vec<Recording>,
    /// What was repaired, assumed or left out.
    pub remarks: Remarks,
}

/// X, Y and Z; an axis that was not recorded is none.
pub type Axes = [Option<Channel<f64>>; 3];

/// One stretch of recording under one clock.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Recording {
    /// When it began, ns since 1970 (UTC where the file says so), if stamps are dates.
    pub started: Option<i64>,
    /// Time from the first stamp to the last, s.
    pub duration: f64,
    /// Positions the drives were told, mm.
    pub commanded: Axes,
    /// Positions the axes had, mm; also those of which the file does not say which they are.
    pub actual: Axes,
    /// Whether `actual` says by name that it is measured.
    pub actual_is_stated: bool,
    /// Speed along the path, mm/s.
    pub feed: Option<Channel<f64>>,
    /// Speed along the path as commanded, mm/s.
    pub commanded_feed: Option<Channel<f64>>,
    /// Line or block number as the control counts them.
    pub line: Option<Channel<u32>>,
    /// Text of the block.
    pub block: Option<Channel<String>>,
    /// Part of the programmed feed, 1 at 100 %.
    pub feed_override: Option<Channel<f64>>,
    /// Part of the rapid feed, 1 at 100 %.
    pub rapid_override: Option<Channel<f64>>,
    /// What the control was doing.
    pub status: Option<Channel<Status>>,
    /// Name of the program.
    pub program: Option<Channel<String>>,
    /// Number or name of the tool.
    pub tool: Option<Channel<String>>,
    /// Speed of the spindle, rad/s.
    pub spindle_speed: Option<Channel<f64>>,
    /// Runs of programs found in it, in order of time; at least one.
    pub runs: Vec<Run>,
}

/// What a control is doing, in the words of MTConnect's Execution.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// A program runs.
    Active,
    /// Somebody holds the feed, or the program is interrupted.
    Held,
    /// The program waits: M0, M1.
    Stopped,
    /// The program came to its end.
    Ended,
    /// No program runs.
    Idle,
}

/// One run of a program within a recording.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// From its start to its end, s from the start of the recording.
    pub time: Range<f64>,
    /// Name of the program, where it was recorded.
    pub program: Option<String>,
    /// What marks it off.
    pub found_by: RunMark,
    /// Whether its start was recorded.
    pub has_start: bool,
    /// Whether its end was recorded.
    pub has_end: bool,
}

/// What marks off a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RunMark {
    /// The control's status.
    Status,
    /// Another program's name.
    Program,
    /// The line number starts again.
    Line,
    /// Nothing: the run is all there is.
    Whole,
}

/// Reads a log with nothing known beside it.
pub fn read(bytes: &[u8]) -> Result<Log, RecordingError> {
    read_with(bytes, &Options::default())
}

/// Reads a log; the format is told by content, never by a file's name.
pub fn read_with(bytes: &[u8], options: &Options) -> Result<Log, RecordingError> {
    let text = text::decode(&packed::unpacked(bytes)?)?;
    let mut remarks = Remarks::default();
    let start = text.trim_start();
    let (format, captures) = if start.starts_with('<') && start.contains("MTConnectStreams") {
        ("MTConnect streams", mtconnect::read(&text, &mut remarks)?)
    } else if start.starts_with('<') {
        ("SINUMERIK trace", siemens_trace::read(&text, &mut remarks)?)
    } else if start.starts_with('{') {
        ("SINUMERIK data recorder", siemens_recorder::read(&text, &mut remarks)?)
    } else if events::is_shdr(&text) {
        ("SHDR event log", events::read(&text, &mut remarks)?)
    } else if beckhoff::is_scope(&text) {
        ("TwinCAT Scope export", beckhoff::read(&text, &mut remarks)?)
    } else {
        table::read(&text, options, &mut remarks)?
    };
    let recordings = assemble::recordings(captures, &mut remarks)?;
    Ok(Log { format, recordings, remarks: remarks.said_once() })
}

impl Recording {
    /// What was recorded in `range` (s); stamps keep their origin, runs outside are left out.
    pub fn during(&self, range: &Range<f64>) -> Recording {
        fn cut<V: Clone>(channel: &Option<Channel<V>>, range: &Range<f64>) -> Option<Channel<V>> {
            channel.as_ref().map(|channel| channel.during(range)).filter(|channel| !channel.values.is_empty())
        }
        let axes = |axes: &Axes| axes.each_ref().map(|axis| cut(axis, range));
        Recording {
            started: self.started,
            duration: self.duration,
            commanded: axes(&self.commanded),
            actual: axes(&self.actual),
            actual_is_stated: self.actual_is_stated,
            feed: cut(&self.feed, range),
            commanded_feed: cut(&self.commanded_feed, range),
            line: cut(&self.line, range),
            block: cut(&self.block, range),
            feed_override: cut(&self.feed_override, range),
            rapid_override: cut(&self.rapid_override, range),
            status: cut(&self.status, range),
            program: cut(&self.program, range),
            tool: cut(&self.tool, range),
            spindle_speed: cut(&self.spindle_speed, range),
            runs: self
                .runs
                .iter()
                .filter(|run| run.time.start < range.end && range.start < run.time.end)
                .cloned()
                .collect(),
        }
    }

    /// The recording with the unit that closes put on what the file states none for.
    pub fn settled(self, closure: &Closure) -> Recording {
        let unit = closure.unit;
        let settle = |channel: Option<Channel<f64>>| channel.map(|channel| channel.assuming(unit));
        match closure.measure {
            Measure::Feed => {
                Recording { feed: settle(self.feed), commanded_feed: settle(self.commanded_feed), ..self }
            }
            Measure::Positions => {
                Recording { commanded: self.commanded.map(settle), actual: self.actual.map(settle), ..self }
            }
        }
    }

    /// The positions to compare with a path: actual ones where recorded, else commanded ones.
    pub fn positions(&self) -> &Axes {
        if self.actual.iter().any(Option::is_some) { &self.actual } else { &self.commanded }
    }
}
