//! What the reader keeps from line to line of Heidenhain programs, in Klartext and in DIN/ISO.

use crate::simulation::gcode::Reference;

/// What the reader keeps from line to line of Heidenhain programs.
#[derive(Default)]
pub(super) struct Heidenhain {
    /// The line before continues in this one.
    pub(super) continued: bool,
    /// The continued lines are not read.
    pub(super) skips: bool,
    /// Words of DIN/ISO that stay in force.
    pub(super) din: Modal,
}

/// Words of DIN/ISO that stay in force from line to line.
#[derive(Default)]
pub(super) struct Modal {
    /// The G word of the motion.
    pub(super) motion: u32,
    pub(super) is_incremental: bool,
}

impl Modal {
    /// Returns what coordinates count from.
    pub(super) fn reference(&self) -> Reference {
        if self.is_incremental { Reference::Incremental } else { Reference::Modal }
    }
}
