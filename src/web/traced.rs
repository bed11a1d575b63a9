//! The path of a program that came whole.

use crate::machine::Machine;
use crate::simulation::gcode::{Options, read_with};
use crate::simulation::toolpath::{Toolpath, trace};

/// The path on a machine, of a program read as these words choose (a dialect, arc centres) or else as it shows.
pub fn toolpath(program: &[u8], dialect: Option<String>, machine: &Machine) -> Toolpath {
    trace(&read_with(program, &Options::from_words(&dialect.unwrap_or_default())), machine)
}
