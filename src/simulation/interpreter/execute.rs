//! Effect of the axis words of a block: by a word that uses them, or by the motion in force.

use crate::simulation::interpreter::block::{AXIS_WORDS, Block, CENTER_WORDS, POLAR_WORDS, bits};
use crate::simulation::interpreter::code::Code;
use crate::simulation::interpreter::remark::TraceRemark;
use crate::simulation::interpreter::state::Interpreter;
use crate::simulation::interpreter::words::{Mode, Special};

impl Interpreter<'_> {
    /// Runs a word that uses the axis words of its block.
    pub(crate) fn special(&mut self, block: Block, special: Special, code: Code) {
        match special {
            Special::Dwell => self.dwell(block, code),
            Special::Reference => self.uncompensated(|interpreter| interpreter.reference(block, code)),
            Special::MachineCoordinates => {
                self.uncompensated(|interpreter| interpreter.machine_coordinates(block))
            }
            Special::Probe => self.probe(block, code),
            Special::Thread { is_tapping } => self.thread(block, code, is_tapping),
            Special::Vendor(word) => self.vendor_word(block, word, code),
            Special::NurbsEnd => (self.rare.end_nurbs)(self, block, code),
            _ => self.change_frame(block, special, code),
        }
    }

    /// Runs the move of a block, if it has one.
    pub(crate) fn motion(&mut self, block: Block, has_motion_word: bool) {
        let has_axis_words = self.given.has(AXIS_WORDS | POLAR_WORDS);
        if self.cycle.is_active() {
            self.hole(block);
            return;
        }
        let is_arc = matches!(self.modal.mode, Some(Mode::Arc(_)));
        let is_circle =
            is_arc && (self.given.has(CENTER_WORDS) || (has_motion_word && self.given.has(bits(b"R"))));
        let is_spline = matches!(self.modal.mode, Some(Mode::Spline(_)));
        let is_bare_spline = is_spline && has_motion_word;
        if !(has_axis_words || is_circle || is_bare_spline) {
            return;
        }
        let Some(target) = self.target(block) else { return };
        if !is_arc && !is_spline && self.given.has(CENTER_WORDS) {
            self.remarks.add(block.place(), TraceRemark::UnusedCenter);
        }
        match self.modal.mode {
            None => {
                self.remarks.add(block.place(), TraceRemark::NoMotionWord);
                self.modal.mode = Some(Mode::Rapid);
                self.rapid_to(block, target);
            }
            Some(Mode::Rapid) => self.rapid_to(block, target),
            Some(Mode::Straight) => self.feed_to(block, target),
            Some(Mode::Arc(turn)) => self.arc_to(block, target, turn),
            Some(Mode::Spline(spline)) => (self.rare.spline_to)(self, block, spline, target),
        }
    }
}
