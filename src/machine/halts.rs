//! Halts that the program does not request: waits at lines, feed holds, and in-position waits.
//!
//! - A wait comes before everything else that the control does for a line: at the line's first function if
//!   that comes before its first move, else at a full stop before that move.
//! - A feed hold interrupts the command somewhere in the middle of a line's path for a time; the filters run
//!   empty meanwhile, as far as the time allows.
//! - An in-position wait occurs at each full stop of the motion until the axes are within their windows.
//!   Functions and dwells wait for the motion anyway, and have no in-position wait.
//!
//! A halt occurs each time its line is run. Limits: a wait at a line without moves and functions has no
//! effect; all in-position waits last equally long.

use std::collections::BTreeMap;

use crate::machine::keyword::keyword_of;

/// Halts that the program does not request; none when neutral.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Halts {
    /// Wait before each line, s, by line of the program.
    pub waits: BTreeMap<u32, f64>,
    /// Duration of the feed hold within each line, s, by line of the program.
    pub feed_holds: BTreeMap<u32, f64>,
    /// Part of the line's path before its feed hold, 0 to 1, by line; half if not given.
    pub feed_hold_places: BTreeMap<u32, f64>,
    /// In-position wait at a full stop, s; neutral 0.
    pub in_position: f64,
    /// Stops with an in-position wait.
    pub in_position_at: InPosition,
}

/// Full stops at which the control waits for the axes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum InPosition {
    /// The end of each rapid move, which is a full stop if the wait is not neutral.
    RapidEnds,
    /// Exact stops: of the program, and at corners sharper than the exact-stop angle.
    ExactStops,
    /// Both.
    #[default]
    Both,
}

impl InPosition {
    /// All variants with their keywords.
    pub const WORDS: [(&'static str, InPosition); 3] = [
        ("both", InPosition::Both),
        ("rapid ends", InPosition::RapidEnds),
        ("exact stops", InPosition::ExactStops),
    ];

    /// Returns the keyword in a machine file.
    pub fn word(self) -> &'static str {
        keyword_of(&InPosition::WORDS, self)
    }

    /// Returns `true` if the axes wait to be in position at the end of a rapid move.
    pub fn has_rapid_ends(self) -> bool {
        self != InPosition::ExactStops
    }

    /// Returns `true` if the axes wait to be in position at an exact stop.
    pub fn has_exact_stops(self) -> bool {
        self != InPosition::RapidEnds
    }
}

impl Halts {
    /// Returns the part of a line's path before its feed hold, 0 to 1.
    pub fn place(&self, line: u32) -> f64 {
        self.feed_hold_places.get(&line).copied().unwrap_or(0.5)
    }
}
