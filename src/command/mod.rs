//! The commands, one module each, and what all of them do: read files ([`input`]), write files ([`output`]), refuse in
//! one line.

mod archive;
mod archive_file;
mod calibrate;
mod cutting;
mod diagnose;
mod input;
mod output;
mod predict;
mod probe;
mod programs;
mod runs;

pub use calibrate::calibrate;
pub use diagnose::diagnose;
pub use predict::predict;
pub use probe::probe;

use std::ffi::OsString;
use std::io::Write;
use std::path::PathBuf;

use truefeed::simulation::gcode::{ArcCenters, Diagnostic, Dialect};
use truefeed::simulation::toolpath::Toolpath;

/// What is wrong with a request, in one line.
pub type Refusal = String;

/// The value of the option that was read last.
pub fn value(parser: &mut lexopt::Parser) -> Result<OsString, Refusal> {
    parser.value().map_err(|error| error.to_string())
}

/// Fills a slot that can be given once.
pub fn once(slot: &mut Option<PathBuf>, value: OsString, what: &str) -> Result<(), Refusal> {
    match slot.replace(value.into()) {
        None => Ok(()),
        Some(_) => Err(format!("{what} is given twice")),
    }
}

/// The value of `--dialect`.
pub fn dialect(parser: &mut lexopt::Parser) -> Result<Dialect, Refusal> {
    let word = value(parser)?.to_string_lossy().into_owned();
    let known = Dialect::WORDS.map(|(word, ..)| word).join(", ");
    Dialect::from_word(&word).ok_or_else(|| format!("--dialect {word}: expected one of {known}"))
}

/// The value of `--arc-centres`.
pub fn arc_centers(parser: &mut lexopt::Parser) -> Result<ArcCenters, Refusal> {
    let word = value(parser)?.to_string_lossy().into_owned();
    let known = ArcCenters::WORDS.map(|(word, ..)| word).join(" or ");
    ArcCenters::from_word(&word).ok_or_else(|| format!("--arc-centres {word}: expected {known}"))
}

/// Returns why nothing of a program is quoted, with the line that shows it.
pub fn declined(toolpath: &Toolpath) -> Option<Refusal> {
    let Diagnostic { line, message, .. } = toolpath.declined.as_ref()?;
    Some(format!("line {}: {message}", line.0))
}

/// Prints a text; a reader that went away is not our error.
pub fn print(text: &str) -> Result<(), Refusal> {
    match writeln!(std::io::stdout(), "{text}") {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => Err(error.to_string()),
        _ => Ok(()),
    }
}
