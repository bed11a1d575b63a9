//! Bytes of a machine log → [`Recording`]: the recorded quantities over time, in core units.
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
//! | rows of numbers without names: LinuxCNC `halsampler` | `headerless` |
//! | `time\|item\|value…`: SHDR of MTConnect adapters; the same as a long table | `events` |
//! | MTConnect streams XML | `mtconnect` |
//! | SINUMERIK trace XML | `siemens_trace` |
//! | SINUMERIK data recorder JSON | `siemens_recorder` |
//! | Beckhoff TwinCAT Scope CSV | `beckhoff` |
//!
//! Reading does not resample, interpolate or smooth a log. Every channel has its own stamps (see
//! [`Channel`]), so that a table at 1 kHz and an event log that records the line five times a second have the
//! same type. One file may contain several recordings (their clocks are unrelated), and a recording several
//! runs of programs (ranges of one clock); all are kept separate.
//!
//! Stated units are converted. Without a stated unit the values remain as in the file, with a list of
//! possible units; [`check_unit`] selects one by the length of the path. The time is linear in the size of
//! the file.
//!
//! A log may be packed by gzip, or as the only file of a ZIP archive.
//!
//! Not read: zlib streams (Klipper's motan logs), archives of several files, binary files, rotary axes,
//! loads; thousands separators in numbers; logs across midnight with only the time of day.

mod assemble;
mod channel;
mod clock;
mod unit_check;
mod diagnostic;
mod field;
mod formats;
mod noise;
mod packed;
mod runs;
mod sniff;
mod overrides;
#[cfg(test)]
mod tests;
mod text;
pub mod unit;

use std::ops::Range;

pub use channel::{Channel, ChannelUnit, Sampling};
pub use diagnostic::{RecordingError, RecordingRemark, RecordingRemarks, RecordingSeverity};
pub use field::LoopSide;
pub use noise::noise;
pub use overrides::OverrideSwitches;
pub use packed::{archived, is_packed_log};
pub use sniff::{SNIFFED_BYTES, is_recording};
pub use unit_check::{
    MAX_LENGTH_DIFFERENCE_RATIO, Measure, UnitCheck, UnitCheckError, check_unit, check_unit_by,
    check_unit_on_lines, path_length,
};

use crate::identification::recording::unit::LogUnit;

/// Properties of a log that its file may not state.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReadingOptions {
    /// Time between rows of a table without a time column, s.
    pub interval: Option<f64>,
    /// Unit of a time column without a stated unit.
    pub time_unit: Option<LogUnit>,
    /// Names of the columns of a table without names.
    pub columns: Option<Vec<String>>,
}

impl ReadingOptions {
    /// Returns the options of a file with this time between rows, s; `None` if the file states its times.
    pub fn at_interval(interval: Option<f64>) -> ReadingOptions {
        ReadingOptions { interval, ..ReadingOptions::default() }
    }
}

/// The content of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Log {
    /// Kind of the file, for people.
    pub format: &'static str,
    /// Recordings in the order of the file; at least one. Time restarts in each.
    pub recordings: Vec<Recording>,
    /// Repairs, assumptions and omissions.
    pub remarks: RecordingRemarks,
}

/// X, Y and Z; `None` for an axis that was not recorded.
pub type Axes = [Option<Channel<f64>>; 3];

/// A part of a log under one clock.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Recording {
    /// Beginning of the recording, ns since 1970 (UTC if the file states so); `None` if stamps are not dates.
    pub started: Option<i64>,
    /// Time from the first stamp to the last, s.
    pub duration: f64,
    /// Commanded axis positions, mm.
    pub commanded: Axes,
    /// Measured axis positions, mm; also positions of unstated origin (see `actual_is_stated`).
    pub actual: Axes,
    /// `true` if the file states that `actual` is measured.
    pub actual_is_stated: bool,
    /// Speed along the path, mm/s.
    pub feed: Option<Channel<f64>>,
    /// Commanded speed along the path, mm/s.
    pub commanded_feed: Option<Channel<f64>>,
    /// Line or block number as the control counts them.
    pub line: Option<Channel<u32>>,
    /// Text of the block.
    pub block: Option<Channel<String>>,
    /// Part of the programmed feed, 1 at 100 %.
    pub feed_override: Option<Channel<f64>>,
    /// Part of the rapid feed, 1 at 100 %.
    pub rapid_override: Option<Channel<f64>>,
    /// State of the control.
    pub status: Option<Channel<Status>>,
    /// Name of the program.
    pub program: Option<Channel<String>>,
    /// Number or name of the tool.
    pub tool: Option<Channel<String>>,
    /// Speed of the spindle, rad/s.
    pub spindle_speed: Option<Channel<f64>>,
    /// Runs of programs, in order of time; at least one.
    pub runs: Vec<RecordingRun>,
}

/// The state of a control, in the words of MTConnect's Execution.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// A program runs.
    Active,
    /// The feed is held, or the program is interrupted.
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
pub struct RecordingRun {
    /// From its start to its end, s from the start of the recording.
    pub time: Range<f64>,
    /// Name of the program, if it was recorded.
    pub program: Option<String>,
    /// The mark that separates the run from others.
    pub found_by: RunMark,
    /// `true` if its start was recorded.
    pub has_start: bool,
    /// `true` if its end was recorded.
    pub has_end: bool,
}

/// The mark that separates a run from others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RunMark {
    /// The control's status.
    Status,
    /// Another program's name.
    Program,
    /// The line number starts again.
    Line,
    /// No mark: the run is the whole recording.
    Whole,
}

/// Reads the log of a machine, in the format that its content shows.
///
/// # Errors
///
/// Returns an error if the format is unknown, or if the log has more faults than can be repaired.
///
/// # Examples
///
/// ```
/// use truefeed::identification::recording::read;
///
/// let rows: String = (0..20).map(|row| format!("{},{}\n", 10 * row, 0.5 * f64::from(row))).collect();
/// let log = read(format!("t_ms,x_mm\n{rows}").as_bytes()).expect("a table");
/// let x = log.recordings[0].actual[0].as_ref().expect("positions of X");
/// assert_eq!(x.span(), Some((0.0, 0.19)), "s");
/// assert_eq!(x.held(0.1), Some(&5.0), "mm");
/// assert!(read(b"no table").is_err());
/// ```
pub fn read(bytes: &[u8]) -> Result<Log, RecordingError> {
    read_with(bytes, &ReadingOptions::default())
}

/// Reads a log as [`read`] does, given properties that its file does not state. The format is identified by
/// content, never by a file's name.
///
/// # Errors
///
/// Returns the errors of [`read`].
pub fn read_with(bytes: &[u8], options: &ReadingOptions) -> Result<Log, RecordingError> {
    let text = text::decode(&packed::unpacked(bytes)?)?;
    let mut remarks = RecordingRemarks::default();
    let start = text.trim_start();
    let (format, captures) = if start.starts_with('<') && start.contains("MTConnectStreams") {
        ("MTConnect streams", formats::mtconnect::read(&text, &mut remarks)?)
    } else if start.starts_with('<') {
        ("SINUMERIK trace", formats::siemens_trace::read(&text, &mut remarks)?)
    } else if start.starts_with('{') {
        ("SINUMERIK data recorder", formats::siemens_recorder::read(&text, &mut remarks)?)
    } else if formats::events::is_shdr(&text) {
        ("SHDR event log", formats::events::read(&text, &mut remarks)?)
    } else if formats::beckhoff::is_scope(&text) {
        ("TwinCAT Scope export", formats::beckhoff::read(&text, &mut remarks)?)
    } else {
        formats::table::read(&text, options, &mut remarks)?
    };
    let recordings = assemble::recordings(captures, &mut remarks)?;
    Ok(Log { format, recordings, remarks: remarks.deduplicated() })
}

impl Recording {
    /// Returns the part within `range` (s); stamps keep their origin, runs outside are left out.
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

    /// Returns the recording with its channels without a stated unit converted from the unit that passed the
    /// check.
    pub fn settled(self, check: &UnitCheck) -> Recording {
        let unit = check.unit;
        let settle = |channel: Option<Channel<f64>>| channel.map(|channel| channel.assuming(unit));
        match check.measure {
            Measure::Feed => {
                Recording { feed: settle(self.feed), commanded_feed: settle(self.commanded_feed), ..self }
            }
            Measure::Positions => {
                Recording { commanded: self.commanded.map(settle), actual: self.actual.map(settle), ..self }
            }
        }
    }

    /// Returns the positions to compare with a path: actual ones if recorded, else commanded ones.
    pub fn positions(&self) -> &Axes {
        if self.actual.iter().any(Option::is_some) { &self.actual } else { &self.commanded }
    }
}
