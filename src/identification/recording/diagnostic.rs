//! What is said about a log: remarks on what was repaired or assumed, and reasons not to read it.
//!
//! A log is repaired where at most one sample in a hundred is concerned and the repair can be
//! named; anything beyond is refused, because a guess about the time axis looks plausible in every
//! later stage.

use std::collections::HashSet;
use thiserror::Error;

/// How much a remark matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// Something was found or assumed that changes nothing by itself.
    Info,
    /// Something was repaired or left out.
    Warning,
}

/// A remark on a log that was read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Remark {
    /// How much it matters.
    pub severity: Severity,
    /// Line of the file, counted from 1, where that means something.
    pub line: Option<usize>,
    /// Name of the column or item concerned, if it is one.
    pub column: Option<String>,
    /// What was found and what was made of it.
    pub message: String,
}

/// Remarks in the order they were made.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Remarks(pub Vec<Remark>);

impl Remarks {
    /// Says everything once: channels made of one column have the same to say.
    pub(super) fn said_once(mut self) -> Remarks {
        let mut said = HashSet::new();
        self.0.retain(|remark| said.insert((remark.line, remark.column.clone(), remark.message.clone())));
        self
    }

    /// Adds something found or assumed.
    pub(super) fn info(&mut self, column: Option<&str>, message: String) {
        self.0.push(Remark {
            severity: Severity::Info,
            line: None,
            column: column.map(str::to_owned),
            message: shown(&message),
        });
    }

    /// Adds something repaired or left out.
    pub(super) fn warn(&mut self, line: Option<usize>, column: Option<&str>, message: String) {
        let (column, message) = (column.map(str::to_owned), shown(&message));
        self.0.push(Remark { severity: Severity::Warning, line, column, message });
    }
}

/// Why a log cannot be read.
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
    #[error("no known kind of log: {0}")]
    UnknownFormat(&'static str),
    /// Columns or items, but none that tells of motion.
    #[error("no column tells positions, feed or program line; found: {}", listed(.found))]
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
    /// Stamps that could be in seconds as well as in milliseconds.
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
        "line {line}: time steps back or stands still {count} times in {of} samples; the order is not trusted"
    )]
    TimeDisorder {
        /// Line of the first such step.
        line: usize,
        /// How many there are.
        count: usize,
        /// Samples in the file.
        of: usize,
    },
    /// Too little to say anything.
    #[error("{}; at least {needed} are needed", samples(*.found))]
    TooFewSamples {
        /// Samples with a time.
        found: usize,
        /// The least that is read.
        needed: usize,
    },
    /// Positions and feed never change.
    #[error("nothing moves: {} constant throughout", listed(.constant))]
    NothingMoves {
        /// Names of the columns.
        constant: Vec<String>,
    },
    /// A cell that should be a number, in more rows than are repaired.
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
        /// How many cells of the column are not numbers.
        count: usize,
    },
    /// Rows of another width than the head, in more rows than are repaired.
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
        /// How many rows differ.
        count: usize,
    },
    /// A line that no row of a table is as long as.
    #[error("line {line} has {bytes} bytes where a row has {most} at most: is it a table without line ends?")]
    LongLine {
        /// Line counted from 1.
        line: usize,
        /// Its length.
        bytes: usize,
        /// The longest that is read.
        most: usize,
    },
    /// A stamp that is none, in more lines than are repaired.
    #[error("line {line}, column {column}: `{}` is not a time stamp, and {count} like it", shown(.text))]
    Stamp {
        /// Line counted from 1.
        line: usize,
        /// Field of the line counted from 1.
        column: usize,
        /// What stands there.
        text: String,
        /// How many there are.
        count: usize,
    },
    /// XML or JSON that is not well-formed, or lacks a part.
    #[error("line {line}, column {column}: {}", shown(.message))]
    Syntax {
        /// Line counted from 1.
        line: usize,
        /// Column counted from 1.
        column: usize,
        /// What is wrong.
        message: String,
    },
    /// A head without its data.
    #[error("{0}")]
    Missing(&'static str),
}

/// As much of a text from a file is shown in a message, characters.
const SHOWN: usize = 400;

/// What stands in a file, fit for one line: a control character would break a message apart.
fn shown(text: &str) -> String {
    let mut shown: String = text
        .chars()
        .take(SHOWN)
        .map(|c| if c.is_control() { char::REPLACEMENT_CHARACTER } else { c })
        .collect();
    if text.chars().nth(SHOWN).is_some() {
        shown.push('…');
    }
    shown
}

/// Names that are listed before the rest is counted.
const LISTED: usize = 12;

fn listed(names: &[String]) -> String {
    match names.len().saturating_sub(LISTED) {
        0 => shown(&names.join(", ")),
        more => format!("{} and {more} more", shown(&names[..LISTED].join(", "))),
    }
}

/// A number of samples, in words.
fn samples(found: usize) -> String {
    match found {
        0 => "no sample has a time and values".to_owned(),
        1 => "only 1 sample".to_owned(),
        found => format!("only {found} samples"),
    }
}

/// Whether `count` faults among `of` samples are few enough to repair: three, or one in a hundred.
pub(super) fn few(count: usize, of: usize) -> bool {
    count <= 3.max(of / 100) && count < of
}
