//! Compensation that begins with the tool at its distance from the contour already, and ends where
//! the tool is: what approach and departure of Klartext need.

use crate::simulation::toolpath::block::Block;
use crate::simulation::toolpath::compensation::queue::{Queue, Setting};
use crate::simulation::toolpath::compensation::words::LARGEST;
use crate::simulation::toolpath::compensation::{Diameter, Side};
use crate::simulation::toolpath::trace::Tracer;
use crate::simulation::toolpath::{Point, Toolpath};

/// Where a compensated tool is seen from the contour, in machine coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::simulation::toolpath) struct Beside {
    /// 1 on the left of the motion, −1 on the right.
    pub(in crate::simulation::toolpath) side: f64,
    /// Radius of the tool, mm; 0 where it is not known.
    pub(in crate::simulation::toolpath) radius: f64,
}

impl Queue {
    /// Puts compensation in force with the tool at its distance, at `at`.
    fn begin_beside(&mut self, setting: Setting, at: Point, out: &mut Toolpath) {
        self.set(Some(setting), out);
        self.has_entered = true;
        self.at = Some(at);
    }

    /// Where the tool is, if that is not the programmed position; it is so from here on.
    fn take_place(&mut self) -> Option<Point> {
        self.at.take()
    }
}

impl Tracer<'_> {
    /// Where the tool is to be for this side and diameter; a remark where the diameter is unknown.
    pub(in crate::simulation::toolpath) fn beside(
        &mut self,
        block: Block,
        side: Side,
        diameter: Diameter,
    ) -> Beside {
        let diameter = self.diameter(block, diameter).unwrap_or(0.0);
        let left = (side == Side::Left) != self.is_mirrored();
        let side = if left { 1.0 } else { -1.0 } * if diameter < 0.0 { -1.0 } else { 1.0 };
        let radius = Some(0.5 * diameter.abs()).filter(|radius| *radius <= LARGEST).unwrap_or(0.0);
        Beside { side, radius }
    }

    /// Compensation from the next move on, with the tool at `at`, its distance away already.
    pub(in crate::simulation::toolpath) fn compensate_from(&mut self, beside: Beside, at: Point) {
        if 0.0 < beside.radius {
            let Beside { side, radius } = beside;
            let setting = Setting { plane: self.modal.plane, side, radius };
            self.contour.release(&mut self.toolpath);
            self.contour.queue.begin_beside(setting, at, &mut self.toolpath);
            self.tell_troubles();
        }
    }

    /// Ends compensation where the tool is: that becomes the position.
    pub(in crate::simulation::toolpath) fn stay_beside(&mut self) {
        self.contour.set(None, &mut self.toolpath);
        if let Some(at) = self.contour.queue.take_place() {
            self.position = at;
        }
        self.tell_troubles();
    }
}
