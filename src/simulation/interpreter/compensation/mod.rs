//! Cutter compensation and corner treatments by the words of programs.
//!
//! Words: G41 and G42 with D, the number of a tool, whose diameter comes from the program, the machine's table or a
//! comment. Without D they take the tool in the spindle, or, in a program with a `%` line or an O number, the tool of the
//! last D. G41.1 and G42.1 with D, a diameter in the unit of length in force; without D as G41. G40 ends both. Each word
//! acts on the move of its block. A negative diameter changes the side; with a diameter of 0 the path remains as
//! programmed.
//!
//! [`Contour`](crate::simulation::toolpath::compensation::Contour) does the geometry.

mod approach;
#[cfg(test)]
mod tests;
mod tool_diameters;
mod words;

pub(super) use approach::Beside;
pub(super) use tool_diameters::KnownDiameters;
pub(super) use words::{CompensationWord, CompensationWords, Diameter, Side};
