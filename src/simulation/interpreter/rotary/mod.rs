//! Rotary axes A, B and C: positions in degrees, absolute or incremental, as programmed. They turn neither by the
//! shortest way nor modulo 360, unless the word says so (DC, ACP and ACN on SINUMERIK).
//!
//! - Beside a move in X, Y or Z they turn during it. F holds for the length in X, Y, Z (RS274/NGC, Sect. 2.1.2.5);
//!   on Fanuc controls for √(x² + y² + z² + a² + b² + c²), where a degree counts as a unit of length.
//!
//! Limits: the part does not turn with its axes: the path in X, Y, Z follows the words. With tool centre point
//! control (G43.4, M128, TRAORI) words and F are those of the tool tip, as programmed; the motion of the machine's
//! axes for it is not computed. G28 and G30 turn to 0.

mod words;

use crate::simulation::interpreter::block::bits;
use crate::simulation::toolpath::Vector;

/// The rotary axes, in the order of their limits.
pub(super) const ROTARY_AXES: [char; 3] = ['A', 'B', 'C'];

pub(super) const ROTARY_WORDS: u64 = bits(b"ABC");

/// The state of the rotary axes.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Rotary {
    /// Machine coordinates, rad.
    pub(super) position: Vector,
    /// Angles that the block being run still has to turn, rad, or `None` if it has no words of rotary axes.
    ahead: Option<Vector>,
}

impl Rotary {
    /// Returns `true` if the next move turns them.
    pub(super) fn turn_along(&self) -> bool {
        self.ahead.is_some()
    }
}
