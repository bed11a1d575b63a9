//! Block supply: the feedrate by which a control plans its corners if blocks are too short.
//!
//! Block processing time and look-ahead limit the feedrate at which blocks are supplied. A control that knows
//! this limit in advance plans its corners by that feedrate. A control that runs out of blocks has planned
//! its corners by the requested feedrate and runs its plan more slowly: no corner becomes faster.

use crate::machine::keyword::keyword_of;
use crate::machine::parameter::{Parameter, finite, row, whole};

/// The feedrate by which corners between blocks limited by supply are planned.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CornerPlanning {
    /// The feedrate at which blocks are supplied.
    #[default]
    Supply,
    /// The requested feedrate.
    Request,
}

impl CornerPlanning {
    /// Both variants with their keywords.
    pub const WORDS: [(&'static str, CornerPlanning); 2] =
        [("supply", CornerPlanning::Supply), ("request", CornerPlanning::Request)];

    /// Returns the keyword.
    pub fn word(self) -> &'static str {
        keyword_of(&CornerPlanning::WORDS, self)
    }
}

/// The rows of block supply.
pub const BLOCK_SUPPLY: [Parameter; 5] = [
    row!("interpolator.block_time_s", "Block processing time", value Second (0.0, 1.0) [interpolator.block_time] or 0.0,
        "Shortest time of a block. 0: no such limit."),
    row!(
        "interpolator.look_ahead_blocks",
        "Look-ahead",
        whole(
            (1.0, 1e6),
            |m| finite(m.interpolator.look_ahead),
            |m, v| m.interpolator.look_ahead = v.unwrap_or(f64::INFINITY),
        ),
        "Number of blocks that the control sees ahead, and within which it must be able to stop. Empty: all."
    ),
    row!("interpolator.step_segment_s", "Step segment", value Second (0.0, 1.0) [interpolator.step_segment] or 0.0,
        "Time for which the step timer holds one feedrate within a block: ramps become stairs, and each block lasts as long as without; grbl: 0.01. 0: ramps are continuous."),
    row!("interpolator.step_timer_hz", "Step timer", limit Hertz (1e4, 1e10) [interpolator.step_timer],
        "Frequency of the timer that steps the motors in step segments: each tick takes one cycle more than planned, with axis.x.step_mm; grbl on an Arduino: 16000000. Empty: it is exact."),
    row!("interpolator.corners_planned_by", "Corners are planned by", choice CornerPlanning [interpolator.planned_by],
        "Feedrate by which the control plans corners of short blocks: the feedrate at which blocks arrive, or the programmed feedrate."),
];
