//! Programs with the recordings of their runs.

use std::path::{Path, PathBuf};

use truefeed::identification::fit::{Recorded, RecordedError};
use truefeed::machine::Machine;
use truefeed::project::Refusal as Reason;

use crate::command::{Refusal, bytes_of, toolpath_of, value};

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

    /// The name of the recording for people.
    pub fn name(&self) -> String {
        let name = self.recording.file_name().unwrap_or(self.recording.as_os_str());
        name.to_string_lossy().into_owned()
    }

    /// The recording on the program; the inner error where the files can be read but not be compared.
    pub fn read(&self, machine: &Machine) -> Result<Result<Recorded, RecordedError>, Refusal> {
        let toolpath = toolpath_of(&self.program, None, machine)?;
        Ok(Recorded::new(toolpath, &bytes_of(&self.recording)?, machine))
    }
}

/// One line that says why a recording cannot be compared, and what to do.
pub fn refusal(recording: &Path, error: &RecordedError) -> Refusal {
    format!("{}: {}", recording.display(), Reason::from(error))
}
