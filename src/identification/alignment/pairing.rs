//! A log and several programs → the program that was run.
//!
//! Each program either refuses the log for a measured reason or covers a part of it. The program that covers
//! clearly more than any other, or equally much at a clearly smaller distance, is the one that was run;
//! programs that differ by less cannot be distinguished by the log.

use crate::identification::alignment::{Alignment, AlignmentError, align_log};
use crate::identification::recording::Log;
use crate::machine::Machine;
use crate::simulation::toolpath::Toolpath;

/// Cover of a program, as a part of the largest cover, below which the program is excluded.
const MIN_COVER_RATIO: f64 = 0.9;
/// Distance from the path, as a multiple of the least distance, above which a program is excluded.
const MAX_DISTANCE_RATIO: f64 = 2.0;

/// The program of a log.
#[derive(Clone, Debug, PartialEq)]
pub enum Pairing {
    /// This program, by index.
    Of(usize),
    /// One of these programs, which the log cannot distinguish.
    OneOf(Vec<usize>),
    /// No program, with the error of each.
    None(Vec<AlignmentError>),
}

/// Returns the program that a log was recorded from.
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
    fitting.retain(|(_, alignment)| MIN_COVER_RATIO * farthest <= explained(alignment));
    let closest = fitting.iter().filter_map(|(_, alignment)| alignment.spread).fold(f64::INFINITY, f64::min);
    fitting.retain(|(_, alignment)| {
        alignment.spread.is_none_or(|spread| spread <= MAX_DISTANCE_RATIO * closest)
    });
    match fitting.as_slice() {
        [] => Pairing::None(refusals),
        [(index, _)] => Pairing::Of(*index),
        several => Pairing::OneOf(several.iter().map(|(index, _)| *index).collect()),
    }
}

/// Returns the part of program and recording that belong together, 0 to 1.
fn explained(alignment: &Alignment) -> f64 {
    let covered = alignment.covered.end - alignment.covered.start;
    alignment.fit * covered / alignment.length.max(1e-9)
}
