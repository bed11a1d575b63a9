//! Halts that the program does not ask for: waits at lines, feed holds, and waits for position.
//!
//! - A wait stands before everything else that the control does for a line: at the line's first function,
//!   where there is one before its first move, else at a full stop before that move.
//! - A feed hold takes the command away somewhere in the middle of a line's path and gives it back after so many seconds;
//!   the filters run empty meanwhile, as far as the time is enough for it.
//! - A wait for position is one at each full stop that motion makes by itself, until the axes are
//!   within their windows. Functions and dwells wait for the motion anyway and do not have it.
//!
//! Lines count as often as they are run. Limits: a wait at a line that neither moves nor does anything is
//! none; all waits for position last equally long.

use std::collections::BTreeMap;

use crate::machine::words::word_of;

/// Halts that the program does not ask for; neutral none.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Halts {
    /// How long the machine stands before a line, s, by line of the program.
    pub waits: BTreeMap<u32, f64>,
    /// How long the command is held within a line, s, by line of the program.
    pub feed_holds: BTreeMap<u32, f64>,
    /// Which part of the line's path is run before its feed hold, 0 to 1, by line; half where none is given.
    pub feed_hold_places: BTreeMap<u32, f64>,
    /// How long the axes need at a full stop to be in position, s; neutral 0.
    pub in_position: f64,
    /// At which stops they have to be.
    pub in_position_at: InPosition,
}

/// Stops at which the control waits for the axes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum InPosition {
    /// At the end of each rapid move, which is a full stop where the wait is not neutral.
    RapidEnds,
    /// At exact stops: of the program, and at corners sharper than the exact-stop angle.
    ExactStops,
    /// At both.
    #[default]
    Both,
}

impl InPosition {
    /// All with the word they are written with.
    pub const WORDS: [(&'static str, InPosition); 3] = [
        ("both", InPosition::Both),
        ("rapid ends", InPosition::RapidEnds),
        ("exact stops", InPosition::ExactStops),
    ];

    /// The word it is written with.
    pub fn word(self) -> &'static str {
        word_of(&InPosition::WORDS, self)
    }

    /// Whether rapid moves end in it.
    pub fn has_rapid_ends(self) -> bool {
        self != InPosition::ExactStops
    }

    /// Whether exact stops have it.
    pub fn has_exact_stops(self) -> bool {
        self != InPosition::RapidEnds
    }
}

impl Halts {
    /// Which part of a line's path is run before its feed hold.
    pub fn place(&self, line: u32) -> f64 {
        self.feed_hold_places.get(&line).copied().unwrap_or(0.5)
    }
}
