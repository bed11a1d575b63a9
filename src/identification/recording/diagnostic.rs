//! Messages on a log: remarks on repairs and assumptions, and reasons to refuse it.
//!
//! A log is repaired if the fault concerns at most one sample in a hundred and a remark can name the repair;
//! other logs are refused, because a wrong guess about the time axis would look plausible in every later
//! stage.

use std::collections::HashSet;
use thiserror::Error;

/// The severity of a remark.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum RecordingSeverity {
    /// An observation or assumption that changes no value.
    Info,
    /// A repair or omission.
    Warning,
}

/// A remark on a log that was read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RecordingRemark {
    /// Severity.
    pub severity: RecordingSeverity,
    /// Line of the file, counted from 1; `None` if the remark has no line.
    pub line: Option<usize>,
    /// Name of the column or item, if the remark concerns one.
    pub column: Option<String>,
    /// Observation and consequence.
    pub message: String,
}

/// Remarks in the order they were made.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RecordingRemarks(pub Vec<RecordingRemark>);

impl RecordingRemarks {
    /// Removes repeated remarks: channels of one column have the same remarks.
    pub(super) fn deduplicated(mut self) -> RecordingRemarks {
        let mut said = HashSet::new();
        self.0.retain(|remark| said.insert((remark.line, remark.column.clone(), remark.message.clone())));
        self
    }

    /// Adds an observation or assumption.
    pub(super) fn info(&mut self, column: Option<&str>, message: String) {
        self.0.push(RecordingRemark {
            severity: RecordingSeverity::Info,
            line: None,
            column: column.map(str::to_owned),
            message: shown(&message),
        });
    }

    /// Adds a repair or omission.
    pub(super) fn warn(&mut self, line: Option<usize>, column: Option<&str>, message: String) {
        let (column, message) = (column.map(str::to_owned), shown(&message));
        self.0.push(RecordingRemark { severity: RecordingSeverity::Warning, line, column, message });
    }
}

/// The reason why a log cannot be read.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum RecordingError {
    /// Nothing but blanks.
    #[error("the file is empty")]
    Empty,
    /// Not text.
    #[error("the file is not text but {0}; export the recording as text (CSV, SHDR, XML or JSON)")]
    Binary(&'static str),
    /// An archive of none or several files.
    #[error("a ZIP archive of {} files: {}; unpack it and choose one, or save a workbook as CSV", .names.len(), listed(.names))]
    Archive {
        /// Names in the archive.
        names: Vec<String>,
    },
    /// Text of no known form.
    #[error("not a known kind of log: {0}")]
    UnknownFormat(&'static str),
    /// Columns or items, but none with motion.
    #[error("no column has positions, feed or program line; found: {}", listed(.found))]
    NothingKnown {
        /// Names in the file.
        found: Vec<String>,
    },
    /// No time, and no way to count it.
    #[error(
        "no time column; found: {}; name one (`t_s`, `time [ms]`) or give the sampling interval", listed(.found)
    )]
    NoTime {
        /// Names in the file.
        found: Vec<String>,
    },
    /// Stamps that could be in seconds or in milliseconds.
    #[error(
        "column `{}`: steps of {step} may be s, ms or µs; say which in its name, such as `t_s` or `t_ms`", shown(.name)
    )]
    TimeUnit {
        /// Name of the time column.
        name: String,
        /// Usual step between stamps, as in the file.
        step: f64,
    },
    /// Time that does not advance.
    #[error(
        "line {line}: time goes back or repeats {count} times in {of} samples, so the order of the rows is unreliable"
    )]
    TimeDisorder {
        /// Line of the first step back or repetition.
        line: usize,
        /// Number of steps back and repetitions.
        count: usize,
        /// Samples in the file.
        of: usize,
    },
    /// Too few samples.
    #[error("{}; at least {needed} are needed", samples(*.found))]
    TooFewSamples {
        /// Samples with a time.
        found: usize,
        /// Least number of samples.
        needed: usize,
    },
    /// Positions and feed never change.
    #[error("nothing moves: {} constant throughout", listed(.constant))]
    NothingMoves {
        /// Names of the columns.
        constant: Vec<String>,
    },
    /// A cell that should be a number, in more rows than can be repaired.
    #[error(
        "line {line}, column {column} (`{}`): `{}` is not a number, and {count} cells like it", shown(.name), shown(.text)
    )]
    NotNumber {
        /// Line counted from 1.
        line: usize,
        /// Field of the line counted from 1.
        column: usize,
        /// Name of the column.
        name: String,
        /// The cell.
        text: String,
        /// Number of such cells in the column.
        count: usize,
    },
    /// Rows of another width than the head, in more rows than can be repaired.
    #[error(
        "line {line}: {found} fields where the first row has {expected}, in {count} rows; a decimal comma needs \
         another separator than the comma"
    )]
    FieldCount {
        /// Line counted from 1.
        line: usize,
        /// Fields in that line.
        found: usize,
        /// Fields in the first row.
        expected: usize,
        /// Number of such rows.
        count: usize,
    },
    /// A line longer than any row of a table.
    #[error("line {line} has {bytes} bytes where a row has {most} at most: is it a table without line ends?")]
    LongLine {
        /// Line counted from 1.
        line: usize,
        /// Its length.
        bytes: usize,
        /// Longest line that is read.
        most: usize,
    },
    /// An invalid stamp, in more lines than can be repaired.
    #[error("line {line}, column {column}: `{}` is not a time stamp, and {count} like it", shown(.text))]
    Stamp {
        /// Line counted from 1.
        line: usize,
        /// Field of the line counted from 1.
        column: usize,
        /// The cell.
        text: String,
        /// Number of such stamps.
        count: usize,
    },
    /// XML or JSON that is not well-formed, or lacks a part.
    #[error("line {line}, column {column}: {}", shown(.message))]
    Syntax {
        /// Line counted from 1.
        line: usize,
        /// Column counted from 1.
        column: usize,
        /// Description of the fault.
        message: String,
    },
    /// A head without its data.
    #[error("{0}")]
    Missing(&'static str),
}

/// Most characters of a file that a message shows.
const MAX_SHOWN_CHARACTERS: usize = 400;

/// Returns a text of a file for one line: a control character would break a message.
fn shown(text: &str) -> String {
    let mut shown: String = text
        .chars()
        .take(MAX_SHOWN_CHARACTERS)
        .map(|c| if c.is_control() { char::REPLACEMENT_CHARACTER } else { c })
        .collect();
    if text.chars().nth(MAX_SHOWN_CHARACTERS).is_some() {
        shown.push('…');
    }
    shown
}

/// Most names that are listed; more are only counted.
const MAX_NAMES_LISTED: usize = 12;

fn listed(names: &[String]) -> String {
    match names.len().saturating_sub(MAX_NAMES_LISTED) {
        0 => shown(&names.join(", ")),
        more => format!("{} and {more} more", shown(&names[..MAX_NAMES_LISTED].join(", "))),
    }
}

/// Returns a number of samples in words.
fn samples(found: usize) -> String {
    match found {
        0 => "no sample has a time and values".to_owned(),
        1 => "only 1 sample".to_owned(),
        found => format!("only {found} samples"),
    }
}

/// Returns `true` if `count` faults among `of` samples can be repaired: three, or one in a hundred.
pub(super) fn is_tolerable(count: usize, of: usize) -> bool {
    count <= 3.max(of / 100) && count < of
}
