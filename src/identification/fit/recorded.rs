//! A recording's bytes on a toolpath → [`Recorded`]: read, aligned, and ready to be fitted to.

use thiserror::Error;

use crate::identification::alignment::{Alignment, AlignmentError, align_log};
use crate::identification::fit::Run;
use crate::identification::recording::{Log, Options, RecordingError, Switches, read_with};
use crate::machine::Machine;
use crate::simulation::toolpath::Toolpath;

/// A program with a recording of one of its runs.
#[derive(Clone, Debug)]
pub struct Recorded {
    /// The program.
    pub toolpath: Toolpath,
    /// All that the file says.
    pub log: Log,
    /// The recording on the program.
    pub alignment: Alignment,
    /// The override switches that it shows.
    pub switches: Switches,
}

/// Why a recording cannot be compared with a program.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum RecordedError {
    /// It cannot be read.
    #[error("{0}")]
    Recording(#[from] RecordingError),
    /// It is not of this program.
    #[error("{0}")]
    Alignment(#[from] AlignmentError),
}

impl Recorded {
    /// Reads a recording and lays it on the program.
    pub fn new(toolpath: Toolpath, recording: &[u8], machine: &Machine) -> Result<Recorded, RecordedError> {
        Recorded::with(toolpath, recording, &Options::default(), machine)
    }

    /// Reads a recording with what its file leaves open, and lays it on the program.
    pub fn with(
        toolpath: Toolpath,
        recording: &[u8],
        options: &Options,
        machine: &Machine,
    ) -> Result<Recorded, RecordedError> {
        let log = read_with(recording, options)?;
        let (index, alignment) = align_log(&log, &toolpath, machine)?;
        let switches = log.recordings[index].switches(&alignment.run);
        Ok(Recorded { toolpath, log, alignment, switches })
    }

    /// The run, with the override switches where they were recorded.
    pub fn run(&self) -> Run<'_> {
        let overrides = (self.switches.feed, self.switches.rapid);
        Run { overrides, ..self.unswitched() }
    }

    /// The run as if no switch had been recorded.
    pub fn unswitched(&self) -> Run<'_> {
        Run { toolpath: &self.toolpath, alignment: &self.alignment, overrides: (None, None) }
    }
}
