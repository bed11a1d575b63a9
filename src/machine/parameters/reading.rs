//! The row on the interpretation of programs.

use crate::machine::parameter::{Parameter, number};
use crate::units::Unit;

/// The row, which the form shows after the tolerance levels.
pub(super) const READING: [Parameter; 1] = [Parameter {
    key: "program.increment_mm",
    label: "Increment without a point",
    doc: "Unit of a length without a decimal point in ISO programs: with 0.001, X10000 is 10 mm, or 1 inch in inch programs. Empty: as written, 10000 mm.",
    access: number(Unit::Millimetre, (1e-6, 1.0), |m| m.program.increment, |m, v| m.program.increment = v),
}];
