//! Lines of Heidenhain DIN/ISO programs.

use crate::simulation::gcode::line::Line;
use crate::simulation::gcode::reader::{Reader, Refusal};

/// Modal words.
#[derive(Default)]
pub(super) struct Modal {}

impl Reader<'_> {
    pub(super) fn heidenhain_iso_line(&mut self, text: &[u8], line: &mut Line) -> Result<(), Refusal> {
        self.iso_line(text, line)
    }
}
