//! Programs with the recordings of their runs.

use std::path::{Path, PathBuf};

use truefeed::identification::fit::{AlignedRun, AlignedRunError};
use truefeed::identification::recording::ReadingOptions;
use truefeed::machine::Machine;
use truefeed::project::ComparisonRefusal as Reason;
use truefeed::simulation::gcode::Options as Reading;

use crate::command::input::{bytes_of, toolpath_of};
use crate::command::{CommandError, value};

/// A program and a recording, by path.
pub struct ProgramRun {
    /// Path of the program.
    pub program: PathBuf,
    /// Path of the recording.
    pub recording: PathBuf,
}

impl ProgramRun {
    /// Reads the two values of `--run`.
    pub fn of_option(parser: &mut lexopt::Parser) -> Result<ProgramRun, CommandError> {
        let both = "--run: expected a program and a recording";
        let mut next = || value(parser).map(PathBuf::from).map_err(|_| both.to_string());
        Ok(ProgramRun { program: next()?, recording: next()? })
    }

    /// Returns both paths.
    pub fn paths(&self) -> [&Path; 2] {
        [&self.program, &self.recording]
    }

    /// Returns the name of the recording for people.
    pub fn name(&self) -> String {
        let name = self.recording.file_name().unwrap_or(self.recording.as_os_str());
        name.to_string_lossy().into_owned()
    }

    /// Aligns the recording with the program; the inner error means that the files were read but cannot be
    /// compared.
    pub fn read(
        &self,
        machine: &Machine,
        options: &ReadingOptions,
    ) -> Result<Result<AlignedRun, AlignedRunError>, CommandError> {
        let toolpath = toolpath_of(&self.program, &Reading::default(), machine)?;
        Ok(AlignedRun::with(toolpath, &bytes_of(&self.recording)?, options, machine))
    }
}

/// The option with the time between rows of a recording without a column of time.
pub const INTERVAL_OPTION: &str = "--interval-s";

/// Returns the reading options of a recording.
pub fn options(interval: Option<PathBuf>) -> Result<ReadingOptions, CommandError> {
    let Some(text) = interval else { return Ok(ReadingOptions::default()) };
    let seconds = text.to_str().and_then(|text| text.parse::<f64>().ok());
    match seconds.filter(|seconds| seconds.is_finite() && 0.0 < *seconds) {
        interval @ Some(_) => Ok(ReadingOptions::at_interval(interval)),
        None => Err(format!(
            "{INTERVAL_OPTION} {}: expected a number of seconds above 0, such as 0.002",
            text.display()
        )),
    }
}

/// Returns one line with the reason why a recording cannot be compared, and advice.
pub fn refusal(recording: &Path, error: &AlignedRunError) -> CommandError {
    let reason = Reason::from(error);
    let option =
        if reason.asks_interval() { format!(" The option is {INTERVAL_OPTION} S.") } else { String::new() };
    format!("{}: {reason}{option}", recording.display())
}
