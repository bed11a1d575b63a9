//! What a control that is short of blocks plans its corners by.
//!
//! Block processing time and look-ahead limit the feedrate at which blocks are supplied. A control that knows of it in time
//! plans corners by that feedrate. One that runs dry has planned them by the feedrate requested, and runs what it has
//! planned more slowly: none of its corners is faster for that.

use crate::machine::parameter::{Access, Parameter, finite, number, whole};
use crate::machine::words::{choice_of, word_of};
use crate::units::Unit;

/// The feedrate by which corners between starved blocks are planned.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PlannedBy {
    /// That at which blocks are supplied.
    #[default]
    Supply,
    /// That which is requested.
    Request,
}

impl PlannedBy {
    /// Both with the word they are written with.
    pub const WORDS: [(&'static str, PlannedBy); 2] =
        [("supply", PlannedBy::Supply), ("request", PlannedBy::Request)];

    /// The word it is written with.
    pub fn word(self) -> &'static str {
        word_of(&PlannedBy::WORDS, self)
    }
}

/// The parameters of how blocks are supplied.
pub const SUPPLY: [Parameter; 3] = [
    Parameter {
        key: "interpolator.block_time_s",
        label: "Block processing time",
        doc: "No block is run in less time than this; 0: no such limit.",
        access: number(
            Unit::Second,
            (0.0, 1.0),
            |m| Some(m.interpolator.block_time),
            |m, v| m.interpolator.block_time = v.unwrap_or(0.0),
        ),
    },
    Parameter {
        key: "interpolator.look_ahead_blocks",
        label: "Look-ahead",
        doc: "Blocks the control sees ahead and must be able to stop within; empty: all.",
        access: whole(
            (1.0, 1e6),
            |m| finite(m.interpolator.look_ahead),
            |m, v| m.interpolator.look_ahead = v.unwrap_or(f64::INFINITY),
        ),
    },
    Parameter {
        key: "interpolator.corners_planned_by",
        label: "Corners are planned by",
        doc: "Where blocks are short: the feedrate of their supply, or the one requested.",
        access: Access::Choice {
            words: &[PlannedBy::WORDS[0].0, PlannedBy::WORDS[1].0],
            get: |m| m.interpolator.planned_by.word(),
            set: |m, v| {
                if let Some(by) = choice_of(&PlannedBy::WORDS, v) {
                    m.interpolator.planned_by = by;
                }
            },
        },
    },
];
