//! Machine coordinates and reference points: G28, G30 and G53.

use crate::machine::AXES;
use crate::simulation::gcode::Dialect;
use crate::simulation::interpreter::block::{AXIS_WORDS, Block};
use crate::simulation::interpreter::code::Code;
use crate::simulation::interpreter::remark::TraceRemark;
use crate::simulation::interpreter::rotary::ROTARY_WORDS;
use crate::simulation::interpreter::state::Interpreter;
use crate::simulation::interpreter::words::Mode;

impl Interpreter<'_> {
    /// Runs G28 and G30: through the programmed point to the reference point, in the axes with words, or in all if
    /// there are none. Both have one reference point, unless G28.1 or G30.1 stored others.
    pub(crate) fn reference(&mut self, block: Block, code: Code) {
        // The axis words of G74 and G75 name axes, not a point.
        if self.dialect != Dialect::Siemens {
            let Some(over) = self.target(block) else { return };
            self.read_rotary_words(block);
            self.rapid_to(block, over);
            self.turn_alone(block, true);
        }
        let goes = |letter: char| {
            !self.given.has(AXIS_WORDS | ROTARY_WORDS) || self.given.get(letter as u8).is_some()
        };
        let axes = AXES.map(goes);
        let mut home = self.canonical.position;
        for (axis, _) in axes.into_iter().enumerate().filter(|(_, goes)| *goes) {
            home[axis] = self.reference_point(block, axis, code).unwrap_or(home[axis]);
        }
        self.turn_home(!self.given.has(AXIS_WORDS | ROTARY_WORDS));
        self.rapid_to(block, home);
        self.turn_alone(block, true);
    }

    /// Runs G53: absolute machine coordinates, at the feedrate under G1 and in rapid otherwise.
    pub(crate) fn machine_coordinates(&mut self, block: Block) {
        let mut target = self.canonical.position;
        for (axis, letter) in AXES.into_iter().enumerate() {
            let Some(value) = self.given.get(letter as u8) else { continue };
            let Some(home) = self.home(block, axis) else { continue };
            target[axis] = home + value * self.modal.unit;
            if !self.is_within_reach(block, letter, target[axis]) {
                return;
            }
        }
        self.read_machine_rotary_words(block);
        match self.modal.mode {
            Some(Mode::Straight) => self.feed_to(block, target),
            _ => self.rapid_to(block, target),
        }
        self.turn_remaining(block);
    }

    /// Returns the reference point of an axis, mm, or remarks that it is unknown.
    pub(crate) fn home(&mut self, block: Block, axis: usize) -> Option<f64> {
        let home = self.machine.axes[axis].home;
        if home.is_none() {
            let (axis, key) = (AXES[axis], AXES[axis].to_ascii_lowercase());
            self.remarks.add(block.place(), TraceRemark::UnknownHome { axis, key });
        }
        home
    }

    /// Returns the reference point of G28 or G30 on an axis, mm: the stored one, or else the machine's.
    pub(crate) fn reference_point(&mut self, block: Block, axis: usize, code: Code) -> Option<f64> {
        let kept = self.vendor.kept[usize::from(code.value > 29.0)];
        kept.map(|point| point[axis]).or_else(|| self.home(block, axis))
    }
}
