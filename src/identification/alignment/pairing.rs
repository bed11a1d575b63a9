//! A log and several programs → the program that was run.
//!
//! Each program either refuses the log for a measured reason or covers a part of it. The one that covers clearly more
//! than any other, or lies clearly closer where they cover the same, is the one that was run; between siblings that
//! differ by less the log cannot tell.

use crate::identification::alignment::{Alignment, AlignmentError, align_log};
use crate::identification::recording::Log;
use crate::machine::Machine;
use crate::simulation::toolpath::Toolpath;

/// A program that covers less than this part of what another does is not the one that was run.
const CLEARLY_LESS: f64 = 0.9;
/// A program from which the tool is so many times as far is not the one that was run.
const CLEARLY_FARTHER: f64 = 2.0;

/// Which program a log is of.
#[derive(Clone, Debug, PartialEq)]
pub enum Pairing {
    /// This one, by index.
    Of(usize),
    /// One of these, which the log cannot tell apart.
    OneOf(Vec<usize>),
    /// None of them: why, program by program.
    None(Vec<AlignmentError>),
}

/// The program that a log was recorded from.
pub fn pair(log: &Log, programs: &[&Toolpath], machine: &Machine) -> Pairing {
    let aligned =
        programs.iter().map(|program| align_log(log, program, machine).map(|(_, alignment)| alignment));
    let (mut fitting, mut refusals) = (Vec::new(), Vec::new());
    for (index, outcome) in aligned.enumerate() {
        match outcome {
            Ok(alignment) => fitting.push((index, alignment)),
            Err(refusal) => refusals.push(refusal),
        }
    }
    let farthest = fitting.iter().map(|(_, alignment)| explained(alignment)).fold(0.0, f64::max);
    fitting.retain(|(_, alignment)| CLEARLY_LESS * farthest <= explained(alignment));
    let closest = fitting.iter().filter_map(|(_, alignment)| alignment.spread).fold(f64::INFINITY, f64::min);
    fitting
        .retain(|(_, alignment)| alignment.spread.is_none_or(|spread| spread <= CLEARLY_FARTHER * closest));
    match fitting.as_slice() {
        [] => Pairing::None(refusals),
        [(index, _)] => Pairing::Of(*index),
        several => Pairing::OneOf(several.iter().map(|(index, _)| *index).collect()),
    }
}

/// How much of program and recording belongs together, 0 to 1.
fn explained(alignment: &Alignment) -> f64 {
    let covered = alignment.covered.end - alignment.covered.start;
    alignment.fit * covered / alignment.length.max(1e-9)
}
