//! Rotary axes A, B and C: positions in degrees, absolute or incremental, as programmed — neither
//! the shortest way nor modulo 360, but where the word says so (DC, ACP and ACN on SINUMERIK).
//!
//! - Beside a move in X, Y or Z they turn along with it. F holds for the length in X, Y, Z
//!   (RS274/NGC, Sect. 2.1.2.5); on Fanuc controls for √(x² + y² + z² + a² + b² + c²), a degree
//!   counting as a unit of length.
//! - Alone, F is in deg/min along √(a² + b² + c²), or 1/min under G93; a rapid lasts as long as the
//!   axis that needs longest. It has no length, and so is a stop of that time.
//!
//! Limits: the part does not turn with its axes: the path in X, Y, Z is that of the words. With tool
//! centre point control (G43.4, M128, TRAORI) words and F are those of the tool tip, as written;
//! what the machine's own axes do for it is not worked out. G28 and G30 turn to 0.

use crate::simulation::toolpath::block::{Block, bits};
use crate::simulation::toolpath::feed_mode::FeedMode;
use crate::simulation::toolpath::motion::SHORTEST;
use crate::simulation::toolpath::remark::Untraced;
use crate::simulation::toolpath::trace::{Family, Tracer};
use crate::simulation::toolpath::words::Mode;
use crate::simulation::toolpath::{StopCause, Vector};

/// The rotary axes, in the order of their limits.
pub(super) const ROTARY_AXES: [char; 3] = ['A', 'B', 'C'];

pub(super) const ROTARY_WORDS: u64 = bits(b"ABC");

/// Angles beyond this are slips of the pen, degrees.
const MOST_DEGREES: f64 = 1e7;

/// Turns smaller than this are rounding, rad.
const SMALLEST: f64 = 1e-12;

/// The rotary axes as they stand.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Rotary {
    /// Machine coordinates, rad.
    pub(super) position: Vector,
    /// How far the block being run still has to turn, rad; none where it says nothing of rotary axes.
    ahead: Option<Vector>,
}

impl Rotary {
    /// The next move turns them along.
    pub(super) fn turn_along(&self) -> bool {
        self.ahead.is_some()
    }
}

impl Tracer<'_> {
    /// Reads the rotary words of a block: its next move turns the axes along.
    pub(super) fn take_rotary(&mut self, block: Block) {
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

    /// Reads rotary words that count in machine coordinates (G53).
    pub(super) fn take_machine_rotary(&mut self, block: Block) {
        for (axis, letter) in ROTARY_AXES.into_iter().enumerate() {
            if let Some(degrees) = self.angle(block, letter) {
                self.turn_axis(axis, degrees.to_radians());
            }
        }
    }

    /// Turns the axes of the block's rotary words, or all, to their reference points (G28, G30).
    pub(super) fn turn_home(&mut self, all: bool) {
        for (axis, letter) in ROTARY_AXES.into_iter().enumerate() {
            if all || self.given.get(letter as u8).is_some() {
                self.turn_axis(axis, 0.0);
            }
        }
    }

    /// The word of a rotary axis, degrees.
    fn angle(&mut self, block: Block, letter: char) -> Option<f64> {
        let degrees = self.given.get(letter as u8)?;
        if degrees.abs() <= MOST_DEGREES {
            return Some(degrees);
        }
        self.remarks.add(block.place_of_letter(letter as u8), Untraced::BadAngle { letter, degrees });
        None
    }

    fn turn_axis(&mut self, axis: usize, target: f64) {
        self.rotary.ahead.get_or_insert_default()[axis] += target - self.rotary.position[axis];
        self.rotary.position[axis] = target;
    }

    /// The turn that the move being made takes along, rad.
    pub(super) fn turned_along(&mut self) -> Option<Vector> {
        self.rotary.ahead.take()
    }

    /// The feedrate along X, Y and Z of a feed move of `length` (mm) whose rotary axes turn along.
    pub(super) fn linear_share(&mut self, block: Block, length: f64, feedrate: f64) -> f64 {
        let ahead = self.rotary.ahead.filter(|ahead| *ahead != Vector::zeros());
        let Some(ahead) = ahead.filter(|_| self.modal.feed.mode != FeedMode::InverseTime) else {
            return feedrate;
        };
        let turn = ahead.map(f64::to_degrees).norm() * self.modal.unit;
        let is_combined = self.family == Family::Fanuc;
        self.remarks.add(block.place(), Untraced::RotaryFeed { is_combined });
        // Beside the contour a move without length may get one.
        if is_combined && SHORTEST <= length { feedrate * length / length.hypot(turn) } else { feedrate }
    }

    /// Turns what no move has taken along.
    pub(super) fn turn_alone(&mut self, block: Block, is_rapid: bool) {
        let Some(rotation) = self.turned_along().filter(|rotation| SMALLEST <= rotation.amax()) else {
            return;
        };
        let rate = (!is_rapid).then(|| self.rotary_feedrate(block, rotation.norm()));
        self.stop(block, StopCause::Rotary { rotation, rate });
    }

    /// Turns what the move of a block has left, at the feedrate or in rapid as the block is run.
    pub(super) fn turn_the_rest(&mut self, block: Block) {
        let is_rapid = self.cycle.is_active() || matches!(self.modal.mode, None | Some(Mode::Rapid));
        self.turn_alone(block, is_rapid);
    }
}
