//! State of the reader of Heidenhain programs, in Klartext and in DIN/ISO.

use crate::simulation::gcode::Reference;

/// State of the reader of Heidenhain programs between lines.
#[derive(Default)]
pub(super) struct HeidenhainState {
    /// `true` if the line before continues in this one.
    pub(super) continued: bool,
    /// `true` if continued lines are ignored.
    pub(super) skips: bool,
    /// Modal words of DIN/ISO.
    pub(super) din: DinModal,
}

/// Words of DIN/ISO that remain in force from line to line.
#[derive(Default)]
pub(super) struct DinModal {
    /// The G word of the motion.
    pub(super) motion: u32,
    pub(super) is_incremental: bool,
}

impl DinModal {
    /// Returns the reference point of coordinates.
    pub(super) fn reference(&self) -> Reference {
        if self.is_incremental { Reference::Incremental } else { Reference::Modal }
    }
}
