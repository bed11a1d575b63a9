//! Compensation for approach and departure in Klartext: it begins with the tool at its distance from the contour
//! already, and ends without a move.

use crate::simulation::interpreter::block::Block;
use crate::simulation::interpreter::compensation::{Diameter, Side};
use crate::simulation::interpreter::state::Interpreter;
use crate::simulation::toolpath::Point;
use crate::simulation::toolpath::compensation::MAX_SIZE_MM;
use crate::simulation::toolpath::compensation::Setting;

/// The position of a compensated tool relative to the contour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Beside {
    /// 1 on the left of the motion, −1 on the right.
    pub(crate) side: f64,
    /// Radius of the tool, mm; 0 if it is unknown.
    pub(crate) radius: f64,
}

impl Interpreter<'_> {
    /// Returns the position of the tool for this side and diameter, and remarks on an unknown diameter.
    pub(crate) fn beside(&mut self, block: Block, side: Side, diameter: Diameter) -> Beside {
        let diameter = self.diameter(block, diameter).unwrap_or(0.0);
        let left = (side == Side::Left) != self.is_mirrored();
        let side = if left { 1.0 } else { -1.0 } * if diameter < 0.0 { -1.0 } else { 1.0 };
        let radius = Some(0.5 * diameter.abs()).filter(|radius| *radius <= MAX_SIZE_MM).unwrap_or(0.0);
        Beside { side, radius }
    }

    /// Sets the compensation from the next move on; the tool is at its distance already, at `at`.
    pub(crate) fn compensate_from(&mut self, beside: Beside, at: Point) {
        if 0.0 < beside.radius {
            let Beside { side, radius } = beside;
            let setting = Setting { plane: self.canonical.plane, side, radius };
            self.canonical.begin_beside(setting, at);
            self.add_compensation_remarks();
        }
    }

    /// Ends the compensation without a move: the position of the tool becomes the programmed one.
    pub(crate) fn end_compensation_in_place(&mut self) {
        self.canonical.end_compensation_in_place();
        self.add_compensation_remarks();
    }
}
