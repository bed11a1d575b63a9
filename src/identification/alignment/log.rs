//! A whole log on a program: the recording in it that covers most.

use crate::identification::alignment::positions::WHOLE_PASS;
use crate::identification::alignment::{Alignment, AlignmentError, align};
use crate::identification::recording::Log;
use crate::machine::Machine;
use crate::simulation::toolpath::Toolpath;

/// Lays a log on a program: which of its recordings covers most of the program and how, or why the first does not fit.
pub fn align_log(
    log: &Log,
    toolpath: &Toolpath,
    machine: &Machine,
) -> Result<(usize, Alignment), AlignmentError> {
    let mut best: Option<(usize, Alignment)> = None;
    let mut refusal = None;
    let covered = |alignment: &Alignment| alignment.covered.end - alignment.covered.start;
    for (index, recording) in log.recordings.iter().enumerate() {
        match align(recording, toolpath, machine) {
            Ok(other)
                if best.as_ref().is_none_or(|(_, best)| covered(best) < WHOLE_PASS * covered(&other)) =>
            {
                best = Some((index, other));
            }
            Ok(_) => {}
            Err(error) => refusal = refusal.or(Some(error)),
        }
    }
    let (index, mut alignment) = best.ok_or(refusal.unwrap_or(AlignmentError::NothingToFollow))?;
    let of = log.recordings.len();
    if 1 < of {
        alignment.remarks.push(format!("recording {} of the {of} in the file is compared", index + 1));
    }
    Ok((index, alignment))
}
