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

mod words;

use crate::simulation::interpreter::block::bits;
use crate::simulation::toolpath::Vector;

/// The rotary axes, in the order of their limits.
pub(super) const ROTARY_AXES: [char; 3] = ['A', 'B', 'C'];

pub(super) const ROTARY_WORDS: u64 = bits(b"ABC");

/// The rotary axes as they stand.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Rotary {
    /// Machine coordinates, rad.
    pub(super) position: Vector,
    /// How far the block being run still has to turn, rad, or `None` if it says nothing of rotary axes.
    ahead: Option<Vector>,
}

impl Rotary {
    /// The next move turns them along.
    pub(super) fn turn_along(&self) -> bool {
        self.ahead.is_some()
    }
}
