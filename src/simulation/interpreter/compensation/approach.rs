//! Compensation that begins with the tool at its distance from the contour already, and ends where
//! the tool is: what approach and departure of Klartext need.

use crate::simulation::interpreter::block::Block;
use crate::simulation::interpreter::compensation::{Diameter, Side};
use crate::simulation::interpreter::state::Interpreter;
use crate::simulation::toolpath::Point;
use crate::simulation::toolpath::compensation::MAX_SIZE_MM;
use crate::simulation::toolpath::compensation::Setting;

/// Where a compensated tool is seen from the contour, in machine coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Beside {
    /// 1 on the left of the motion, −1 on the right.
    pub(crate) side: f64,
    /// Radius of the tool, mm; 0 where it is not known.
    pub(crate) radius: f64,
}

impl Interpreter<'_> {
    /// Where the tool is to be for this side and diameter; a remark where the diameter is unknown.
    pub(crate) fn beside(&mut self, block: Block, side: Side, diameter: Diameter) -> Beside {
        let diameter = self.diameter(block, diameter).unwrap_or(0.0);
        let left = (side == Side::Left) != self.is_mirrored();
        let side = if left { 1.0 } else { -1.0 } * if diameter < 0.0 { -1.0 } else { 1.0 };
        let radius = Some(0.5 * diameter.abs()).filter(|radius| *radius <= MAX_SIZE_MM).unwrap_or(0.0);
        Beside { side, radius }
    }

    /// Compensation from the next move on, with the tool at `at`, its distance away already.
    pub(crate) fn compensate_from(&mut self, beside: Beside, at: Point) {
        if 0.0 < beside.radius {
            let Beside { side, radius } = beside;
            let setting = Setting { plane: self.canonical.plane, side, radius };
            self.canonical.begin_beside(setting, at);
            self.tell_troubles();
        }
    }

    /// Ends compensation where the tool is: that becomes the position.
    pub(crate) fn stay_beside(&mut self) {
        self.canonical.stay_beside();
        self.tell_troubles();
    }
}
