//! The path of a program that came whole.

use crate::machine::Machine;
use crate::simulation::gcode::{Dialect, Options, read_with};
use crate::simulation::toolpath::{Toolpath, trace};

/// The path on a machine, of a program read in the dialect of this word or else in the one that it shows.
pub fn toolpath(program: &[u8], dialect: Option<String>, machine: &Machine) -> Toolpath {
    let dialect = dialect.as_deref().and_then(Dialect::from_word);
    trace(&read_with(program, &Options { dialect, ..Options::default() }), machine)
}
