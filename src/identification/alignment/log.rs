//! A whole log on a program: the first of its recordings that fits.

use crate::identification::alignment::{Alignment, AlignmentError, align};
use crate::identification::recording::Log;
use crate::machine::Machine;
use crate::simulation::toolpath::Toolpath;

/// Lays a log on a program: which of its recordings fits and how, or why the first does not.
pub fn align_log(
    log: &Log,
    toolpath: &Toolpath,
    machine: &Machine,
) -> Result<(usize, Alignment), AlignmentError> {
    let mut refusal = None;
    for (index, recording) in log.recordings.iter().enumerate() {
        match align(recording, toolpath, machine) {
            Ok(mut alignment) => {
                if 1 < log.recordings.len() {
                    let of = log.recordings.len();
                    alignment
                        .remarks
                        .push(format!("recording {} of the {of} in the file is compared", index + 1));
                }
                return Ok((index, alignment));
            }
            Err(error) => refusal = refusal.or(Some(error)),
        }
    }
    Err(refusal.unwrap_or(AlignmentError::NothingToFollow))
}
