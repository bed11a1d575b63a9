//! The row on the interpretation of programs.

use crate::machine::parameter::{Parameter, row};

/// The row, which the form shows after the tolerance levels.
pub(super) const READING: [Parameter; 1] = [
    row!("program.increment_mm", "Increment without a point", optional Millimetre (1e-6, 1.0) [program.increment],
        "Unit of a length without a decimal point in ISO programs: with 0.001, X10000 is 10 mm, or 1 inch in inch programs. Empty: as written, 10000 mm."),
];
