//! Calibrations as text: from runs of programs, and from a single recorded move.

pub mod move_report;
pub mod report;
