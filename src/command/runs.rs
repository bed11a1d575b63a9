//! Programs with the recordings of their runs.

use std::path::{Path, PathBuf};

use truefeed::identification::fit::{Recorded, RecordedError};
use truefeed::identification::recording::Options;
use truefeed::machine::Machine;
use truefeed::project::Refusal as Reason;
use truefeed::simulation::gcode::Options as Reading;

use crate::command::input::{bytes_of, toolpath_of};
use crate::command::{Refusal, value};

/// A program and a recording, as named.
pub struct Pair {
    /// The program.
    pub program: PathBuf,
    /// The recording.
    pub recording: PathBuf,
}

impl Pair {
    /// The two values of `--run`.
    pub fn of_option(parser: &mut lexopt::Parser) -> Result<Pair, Refusal> {
        let both = "--run: expected a program and a recording";
        let mut next = || value(parser).map(PathBuf::from).map_err(|_| both.to_string());
        Ok(Pair { program: next()?, recording: next()? })
    }

    /// Returns both paths.
    pub fn paths(&self) -> [&Path; 2] {
        [&self.program, &self.recording]
    }

    /// The name of the recording for people.
    pub fn name(&self) -> String {
        let name = self.recording.file_name().unwrap_or(self.recording.as_os_str());
        name.to_string_lossy().into_owned()
    }

    /// The recording on the program; the inner error where the files can be read but not be compared.
    pub fn read(
        &self,
        machine: &Machine,
        options: &Options,
    ) -> Result<Result<Recorded, RecordedError>, Refusal> {
        let toolpath = toolpath_of(&self.program, &Reading::default(), machine)?;
        Ok(Recorded::with(toolpath, &bytes_of(&self.recording)?, options, machine))
    }
}

/// The option that states the time between rows of a recording without a column of time.
pub const INTERVAL: &str = "--interval-s";

/// What the options say of a recording.
pub fn options(interval: Option<PathBuf>) -> Result<Options, Refusal> {
    let Some(text) = interval else { return Ok(Options::default()) };
    let seconds = text.to_str().and_then(|text| text.parse::<f64>().ok());
    match seconds.filter(|seconds| seconds.is_finite() && 0.0 < *seconds) {
        Some(seconds) => Ok(Options { interval: Some(seconds), ..Options::default() }),
        None => {
            Err(format!("{INTERVAL} {}: expected a number of seconds above 0, such as 0.002", text.display()))
        }
    }
}

/// One line that says why a recording cannot be compared, and what to do.
pub fn refusal(recording: &Path, error: &RecordedError) -> Refusal {
    format!("{}: {}", recording.display(), Reason::from(error))
}
