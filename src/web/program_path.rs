//! The path of a program that arrived in one piece.

use crate::machine::Machine;
use crate::simulation::gcode::{Options, read_with};
use crate::simulation::interpreter::trace;
use crate::simulation::toolpath::Toolpath;

/// Returns the path of a program on a machine, read in the given dialect and with the given arc centres
/// (keywords), or in those detected from the program.
pub fn toolpath(program: &[u8], dialect: Option<String>, machine: &Machine) -> Toolpath {
    trace(&read_with(program, &Options::from_words(&dialect.unwrap_or_default())), machine)
}
