//! Meaning of F.
//!
//! | mode | F                                   | feedrate of a move of length L, mm/s          |
//! |------|-------------------------------------|-----------------------------------------------|
//! | G93  | 1/min, for its own block alone      | L F / 60: the block lasts 1/F min             |
//! | G94  | mm/min, inch/min; deg/min of a turn | F / 60                                        |
//! | G95  | mm or inch per revolution           | F S / 60, S in rev/min                        |
//!
//! Each mode keeps its own F, but a word that changes to another mode than G93 forgets it: controls refuse a feed
//! move until there is a new F, LinuxCNC even if the mode was in force already. Truefeed remarks on such a move,
//! and runs it at the former feedrate. Under G96 S is a surface speed, which needs the diameter at which the tool
//! cuts; it is left out, and G95 keeps the last S in rev/min.
//!
//! Source: NIST RS274/NGC, Sect. 3.5.19; LinuxCNC, G93, G94, G95.

mod feedrate;

use crate::simulation::interpreter::code::Code;

/// The quantity that F gives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum FeedMode {
    /// G93.
    InverseTime,
    /// G94.
    PerMinute,
    /// G95.
    PerRevolution,
}

/// The mode, and F in each mode.
#[derive(Clone, Copy, Debug)]
pub(super) struct Feed {
    pub(super) mode: FeedMode,
    /// G93, 1/min.
    inverse_time: Option<f64>,
    /// G94 as written, in units of length or degrees per minute.
    pub(super) per_minute: Option<f64>,
    /// G95, mm.
    per_revolution: Option<f64>,
    /// The G word that forgot the last F, until there is a new one.
    pub(super) forgotten_by: Option<Code>,
}

impl Default for Feed {
    fn default() -> Feed {
        let mode = FeedMode::PerMinute;
        Feed { mode, inverse_time: None, per_minute: None, per_revolution: None, forgotten_by: None }
    }
}
