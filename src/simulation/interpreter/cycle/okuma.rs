//! Additions of Okuma controls to cycles: NCYL, and the height to which M52 to M54 return.

use crate::simulation::gcode::{Dialect, address};
use crate::simulation::interpreter::block::{Block, bits};
use crate::simulation::interpreter::remark::TraceRemark;
use crate::simulation::interpreter::state::Interpreter;

impl Interpreter<'_> {
    /// Runs NCYL, a move to the place of the hole without a hole; returns `true` if the block has it.
    pub(crate) fn is_without_hole(&mut self, block: Block) -> bool {
        let is_without_hole = self.dialect == Dialect::Okuma && self.given.has(bits(&[address::NO_CYCLE]));
        if is_without_hole && let Some(mut target) = self.target(block) {
            let normal = self.canonical.plane.axes()[2];
            target[normal] = self.canonical.position[normal];
            self.rapid_to(block, target);
        }
        is_without_hole
    }

    /// Returns the height to which cycles return by G71 and the M words of Okuma, mm along the axis of the holes;
    /// `None` if G98 and G99 hold.
    pub(crate) fn return_by_m_word(&mut self, block: Block, normal: usize, reference: f64) -> Option<f64> {
        if self.dialect != Dialect::Okuma {
            return None;
        }
        let remark = |what| TraceRemark::Statement { name: "M52, M53, M54", what };
        let height = match self.vendor.returns_by {
            Some(54) => return Some(reference),
            Some(53) => self.vendor.return_level,
            Some(_) => self.machine.axes[normal].home,
            None => None,
        };
        if height.is_none() {
            let what = "the height to which cycles return is unknown (G71 Z with M53, or M54): they return to their starting height";
            self.remarks.add(block.place(), remark(what));
        }
        height.map(|height| height.max(reference))
    }
}
