//! The commands, one module each, and their common parts: input files ([`input`]), output files ([`output`]),
//! refusals in one line.

mod archive;
mod archive_file;
mod calibrate;
mod cutting;
mod diagnose;
pub mod help;
mod input;
mod job;
mod output;
mod predict;
mod probe;
mod programs;
mod runs;

pub use calibrate::calibrate;
pub use diagnose::diagnose;
pub use job::job;
pub use predict::predict;
pub use probe::probe;

use std::ffi::OsString;
use std::io::Write;
use std::path::PathBuf;

use truefeed::simulation::gcode::{ArcCenters, Diagnostic, Dialect};
use truefeed::simulation::toolpath::Toolpath;

/// The reason why a request fails, in one line.
pub type CommandError = String;

/// Returns the value of the last option.
pub fn value(parser: &mut lexopt::Parser) -> Result<OsString, CommandError> {
    parser.value().map_err(|error| error.to_string())
}

/// Sets an option that can be given once.
pub fn once(slot: &mut Option<PathBuf>, value: OsString, what: &str) -> Result<(), CommandError> {
    match slot.replace(value.into()) {
        None => Ok(()),
        Some(_) => Err(format!("{what} is given twice")),
    }
}

/// Returns the value of `--dialect`.
pub fn dialect(parser: &mut lexopt::Parser) -> Result<Dialect, CommandError> {
    let word = value(parser)?.to_string_lossy().into_owned();
    let known = Dialect::WORDS.map(|(word, ..)| word).join(", ");
    Dialect::from_word(&word).ok_or_else(|| format!("--dialect {word}: expected one of {known}"))
}

/// Returns the value of `--arc-centres`.
pub fn arc_centers(parser: &mut lexopt::Parser) -> Result<ArcCenters, CommandError> {
    let word = value(parser)?.to_string_lossy().into_owned();
    let known = ArcCenters::WORDS.map(|(word, ..)| word).join(" or ");
    ArcCenters::from_word(&word).ok_or_else(|| format!("--arc-centres {word}: expected {known}"))
}

/// Returns the reason why a program cannot be quoted, with the line that causes it; `None` if it can be
/// quoted.
pub fn declined(toolpath: &Toolpath) -> Option<CommandError> {
    let Diagnostic { line, message, .. } = toolpath.declined.as_ref()?;
    Some(format!("line {}: {message}", line.0))
}

/// Prints a text; a closed standard output is not an error.
pub fn print(text: &str) -> Result<(), CommandError> {
    match writeln!(std::io::stdout(), "{text}") {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => Err(error.to_string()),
        _ => Ok(()),
    }
}
