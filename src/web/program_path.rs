//! The path of a program that arrived whole.

use crate::machine::Machine;
use crate::simulation::gcode::{Options, read_with};
use crate::simulation::interpreter::trace;
use crate::simulation::toolpath::Toolpath;

/// Returns the path of a program on a machine, read by keywords (a dialect, arc centres), or as the program
/// shows.
pub fn toolpath(program: &[u8], dialect: Option<String>, machine: &Machine) -> Toolpath {
    trace(&read_with(program, &Options::from_words(&dialect.unwrap_or_default())), machine)
}
