//! Cutter compensation and corner treatments as programs ask for them.
//!
//! Words: G41 and G42 with D, the number of a tool, whose diameter the program, the machine's table
//! or a comment tells; without D the tool in
//! the spindle, or, in a program with a `%` line or an O number, the tool of the last D. G41.1 and G42.1 with D, a diameter in the unit of length in force; without D as
//! G41. G40 ends both. The words act on the move of their own block. A negative diameter changes
//! the side; a diameter of 0 leaves the path as programmed.
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
