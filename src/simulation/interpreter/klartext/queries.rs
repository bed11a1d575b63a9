//! Properties of a block and of the tool for the statements of Klartext.

use crate::simulation::gcode::{Place, address};
use crate::simulation::interpreter::block::{AXIS_WORDS, Block, POLAR_WORDS};
use crate::simulation::interpreter::compensation::Diameter;
use crate::simulation::interpreter::klartext::KlartextRemark;
use crate::simulation::interpreter::remark::TraceRemark;
use crate::simulation::interpreter::state::Interpreter;
use crate::simulation::interpreter::words::Mode;

impl Interpreter<'_> {
    /// Returns `true` for Heidenhain programs.
    pub(crate) fn is_heidenhain(&self) -> bool {
        self.heidenhain.is_some()
    }

    /// Adds a remark.
    pub(crate) fn remark(&mut self, place: Place, remark: KlartextRemark) {
        self.remarks.add(place, TraceRemark::Klartext(remark));
    }

    /// Returns `true` if the block has one of these M words.
    pub(crate) fn has_m(&self, block: Block, numbers: &[f64]) -> bool {
        block.words.iter().any(|word| word.letter == b'M' && numbers.contains(&word.value))
    }

    /// Returns `true` if the block has words of a position.
    pub(crate) fn moves_axes(&self) -> bool {
        self.given.has(AXIS_WORDS | POLAR_WORDS)
    }

    /// Returns the mode of motion by the words of the block.
    pub(crate) fn mode_of(&self) -> Mode {
        if self.given.get(address::RAPID).is_some() { Mode::Rapid } else { Mode::Straight }
    }

    /// Returns the radius of the tool in use, mm, if it is known.
    pub(crate) fn tool_radius(&self) -> Option<f64> {
        let tool = self.modal.tool?;
        let defined = self.klartext.radii.get(&tool).copied();
        let radius = defined.or(self.machine.tools.get(&tool).map(|tool| 0.5 * tool.diameter))?;
        Some(radius + self.klartext.radius_difference)
    }

    /// Returns the diameter of the tool in use.
    pub(crate) fn tool_diameter(&self) -> Diameter {
        self.tool_radius().map_or(Diameter::Spindle, |radius| Diameter::Given(2.0 * radius))
    }
}
