//! A recording's bytes on a toolpath → [`AlignedRun`]: read, aligned, and ready for a fit.

use thiserror::Error;

use crate::identification::alignment::{Alignment, AlignmentError, align_log};
use crate::identification::fit::Run;
use crate::identification::recording::{Log, OverrideSwitches, ReadingOptions, RecordingError, read_with};
use crate::machine::Machine;
use crate::simulation::toolpath::Toolpath;

/// A program with a recording of one of its runs.
#[derive(Clone, Debug)]
pub struct AlignedRun {
    /// Program.
    pub toolpath: Toolpath,
    /// Content of the file.
    pub log: Log,
    /// Alignment of the recording with the program.
    pub alignment: Alignment,
    /// Override switches in the recording.
    pub switches: OverrideSwitches,
}

/// The reason why a recording cannot be compared with a program.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum AlignedRunError {
    /// The recording cannot be read.
    #[error("{0}")]
    Recording(#[from] RecordingError),
    /// The recording does not belong to this program.
    #[error("{0}")]
    Alignment(#[from] AlignmentError),
}

impl AlignedRun {
    /// Reads a recording and aligns it with the program.
    ///
    /// # Errors
    ///
    /// Returns an error if the recording cannot be read, or does not belong to this program.
    pub fn new(
        toolpath: Toolpath,
        recording: &[u8],
        machine: &Machine,
    ) -> Result<AlignedRun, AlignedRunError> {
        AlignedRun::with(toolpath, recording, &ReadingOptions::default(), machine)
    }

    /// Reads a recording with options for gaps in its file, and aligns it with the program.
    ///
    /// # Errors
    ///
    /// Returns an error if the recording cannot be read, or does not belong to this program.
    pub fn with(
        toolpath: Toolpath,
        recording: &[u8],
        options: &ReadingOptions,
        machine: &Machine,
    ) -> Result<AlignedRun, AlignedRunError> {
        let log = read_with(recording, options)?;
        let (index, alignment) = align_log(&log, &toolpath, machine)?;
        let switches = log.recordings[index].switches(&alignment.run);
        Ok(AlignedRun { toolpath, log, alignment, switches })
    }

    /// Returns the run with the recorded override switches.
    pub fn run(&self) -> Run<'_> {
        let overrides = (self.switches.feed, self.switches.rapid);
        Run { overrides, ..self.run_ignoring_overrides() }
    }

    /// Returns the run ignoring recorded override switches.
    pub fn run_ignoring_overrides(&self) -> Run<'_> {
        Run { toolpath: &self.toolpath, alignment: &self.alignment, overrides: (None, None) }
    }
}
