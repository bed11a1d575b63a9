//! The parameters that say how the control reads a program.

use crate::machine::parameter::{Parameter, number};
use crate::units::Unit;

/// They stand between the levels of tolerance and the times.
pub(super) const READING: [Parameter; 1] = [Parameter {
    key: "program.increment_mm",
    label: "Increment without a point",
    doc: "What a length without a decimal point counts in ISO programs: 0.001 reads X10000 as 10 mm, or as 1 inch; empty: as written, 10000 mm.",
    access: number(Unit::Millimetre, (1e-6, 1.0), |m| m.program.increment, |m, v| m.program.increment = v),
}];
