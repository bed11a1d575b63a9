//! What a stage has to say about a program, without stopping.

use crate::simulation::gcode::LineNumber;

/// How much a diagnostic matters to the quote.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// Read as meant; the user may want to know.
    Info,
    /// Something was left out or assumed; the time may be off.
    Warning,
    /// The block could not be read or run as written.
    Error,
}

/// One remark about one line of the program.
#[derive(Clone, Debug, PartialEq)]
pub struct Diagnostic {
    /// Line of the program.
    pub line: LineNumber,
    /// Columns it concerns, 1-based, first and one past the last; equal where the whole line is meant.
    pub columns: (u32, u32),
    /// How much it matters.
    pub severity: Severity,
    /// What is wrong and what was done instead, one sentence.
    pub message: String,
}
