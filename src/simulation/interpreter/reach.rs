//! Coordinates that no machine reaches.

use crate::simulation::interpreter::block::Block;
use crate::simulation::interpreter::bounds::MAX_COORDINATE_MM;
use crate::simulation::interpreter::remark::TraceRemark;
use crate::simulation::interpreter::state::Interpreter;

impl Interpreter<'_> {
    /// Returns `true` if a coordinate (mm) is within reach, else remarks on it.
    pub(crate) fn is_within_reach(&mut self, block: Block, letter: char, coordinate: f64) -> bool {
        let is_within = coordinate.abs() <= MAX_COORDINATE_MM;
        if !is_within {
            self.remarks.add(block.place_of_letter(letter as u8), TraceRemark::OutOfReach { letter });
        }
        is_within
    }
}
