//! Turns of the rotary axes by the words of a block.

use crate::simulation::interpreter::block::Block;
use crate::simulation::interpreter::feed_mode::FeedMode;
use crate::simulation::interpreter::remark::TraceRemark;
use crate::simulation::interpreter::rotary::{ROTARY_AXES, ROTARY_WORDS};
use crate::simulation::interpreter::state::{Family, Interpreter};
use crate::simulation::interpreter::words::Mode;
use crate::simulation::toolpath::MIN_MOVE_MM;
use crate::simulation::toolpath::Vector;

/// Larger angles are typing errors, degrees.
const MAX_ANGLE_DEG: f64 = 1e7;

/// Smaller turns are rounding errors, rad.
const MIN_TURN_RAD: f64 = 1e-12;

impl Interpreter<'_> {
    /// Reads the rotary words of a block; its next move turns the axes.
    pub(crate) fn read_rotary_words(&mut self, block: Block) {
        if !self.given.has(ROTARY_WORDS) {
            return;
        }
        for (axis, letter) in ROTARY_AXES.into_iter().enumerate() {
            let Some(degrees) = self.angle(block, letter) else { continue };
            let from = self.rotary.position[axis];
            let target = match self.given.is_incremental(letter as u8, self.modal.is_incremental) {
                true => from + degrees.to_radians(),
                false => {
                    let target = self.frame.rotary_coordinate(axis, degrees.to_radians());
                    let turn = self.given.turn(letter as u8, target - from);
                    if turn == target - from { target } else { from + turn }
                }
            };
            self.turn_axis(axis, target);
        }
    }

    /// Reads rotary words in machine coordinates (G53).
    pub(crate) fn read_machine_rotary_words(&mut self, block: Block) {
        for (axis, letter) in ROTARY_AXES.into_iter().enumerate() {
            if let Some(degrees) = self.angle(block, letter) {
                self.turn_axis(axis, degrees.to_radians());
            }
        }
    }

    /// Turns the axes of the block's rotary words, or all, to their reference points (G28, G30).
    pub(crate) fn turn_home(&mut self, all: bool) {
        for (axis, letter) in ROTARY_AXES.into_iter().enumerate() {
            if all || self.given.get(letter as u8).is_some() {
                self.turn_axis(axis, 0.0);
            }
        }
    }

    /// Returns the word of a rotary axis, degrees; remarks on one that is too large.
    fn angle(&mut self, block: Block, letter: char) -> Option<f64> {
        let degrees = self.given.get(letter as u8)?;
        if degrees.abs() <= MAX_ANGLE_DEG {
            return Some(degrees);
        }
        self.remarks.add(block.place_of_letter(letter as u8), TraceRemark::BadAngle { letter, degrees });
        None
    }

    /// Adds a turn of an axis to its target, rad.
    fn turn_axis(&mut self, axis: usize, target: f64) {
        self.rotary.ahead.get_or_insert_default()[axis] += target - self.rotary.position[axis];
        self.rotary.position[axis] = target;
    }

    /// Takes the turn of the move being made, rad.
    pub(crate) fn turned_along(&mut self) -> Option<Vector> {
        self.rotary.ahead.take()
    }

    /// Returns the feedrate along X, Y and Z of a feed move of `length` (mm) that turns the rotary axes.
    pub(crate) fn linear_share(&mut self, block: Block, length: f64, feedrate: f64) -> f64 {
        let ahead = self.rotary.ahead.filter(|ahead| *ahead != Vector::zeros());
        let Some(ahead) = ahead.filter(|_| self.modal.feed.mode != FeedMode::InverseTime) else {
            return feedrate;
        };
        let turn = ahead.map(f64::to_degrees).norm() * self.modal.unit;
        let is_combined = self.family == Family::Fanuc;
        self.remarks.add(block.place(), TraceRemark::RotaryFeed { is_combined });
        // Beside the contour a move without length may get one.
        if is_combined && MIN_MOVE_MM <= length { feedrate * length / length.hypot(turn) } else { feedrate }
    }

    /// Turns the axes on their own, unless a move has turned them.
    pub(crate) fn turn_alone(&mut self, block: Block, is_rapid: bool) {
        let Some(rotation) = self.turned_along().filter(|rotation| MIN_TURN_RAD <= rotation.amax()) else {
            return;
        };
        let rate = (!is_rapid).then(|| self.rotary_feedrate(block, rotation.norm()));
        self.canonical.turn_rotary_axes(block.line, rotation, rate);
    }

    /// Turns the axes on their own after the move of a block, at the feedrate or in rapid by the mode of the
    /// block.
    pub(crate) fn turn_remaining(&mut self, block: Block) {
        let is_rapid = self.cycle.is_active() || matches!(self.modal.mode, None | Some(Mode::Rapid));
        self.turn_alone(block, is_rapid);
    }
}
