//! What reading has to say about a program.

use crate::simulation::gcode::{Remark, Severity, counted};
use thiserror::Error;

/// Something in the text that was not read as a block of words.
#[derive(Clone, Debug, PartialEq, Error)]
pub(super) enum Unread {
    /// `#`, `[` and what belongs to them.
    #[error("variables and expressions are not evaluated yet: block not run")]
    Expression,
    /// Jumps, loops, subroutines.
    #[error("program flow (`{text}`) is not followed yet: block not run")]
    Flow {
        /// The word that says so.
        text: String,
    },
    /// Letters or signs that are no word.
    #[error("`{text}` is not understood: block not run")]
    Text {
        /// As written.
        text: String,
    },
    /// A letter alone.
    #[error("{letter} has no number: left out, the rest of the block is run")]
    MissingNumber {
        /// The letter, upper case.
        letter: char,
    },
    /// Two points, a sign within, and the like.
    #[error("`{text}` is not a number: left out, the rest of the block is run")]
    MalformedNumber {
        /// As written.
        text: String,
    },
    /// Beyond what a number can hold.
    #[error("`{text}` is too large: left out, the rest of the block is run")]
    HugeNumber {
        /// As written.
        text: String,
    },
    /// `(` without `)`.
    #[error("comment is not closed: the rest of the line is taken as comment")]
    OpenComment,
    /// Lines before the opening `%`.
    #[error("what stands before this % is taken as leader ({}): not run", counted(*.blocks, "block"))]
    Leader {
        /// How many of them could have been run.
        blocks: usize,
    },
    /// Lines after the closing `%`.
    #[error("the program ends at the % above: from here on nothing is read")]
    Trailer,
    /// Lines that begin with `/`, run.
    #[error("{} with / from here on: run, as with the block delete switch off", counted(*.blocks, "block"))]
    OptionalRun {
        /// How many.
        blocks: usize,
    },
    /// Lines that begin with `/`, not run.
    #[error("{} with / from here on: not run, as with the block delete switch on", counted(*.blocks, "block"))]
    OptionalSkipped {
        /// How many.
        blocks: usize,
    },
}

impl Remark for Unread {
    fn severity(&self) -> Severity {
        match self {
            Unread::Expression
            | Unread::Flow { .. }
            | Unread::Text { .. }
            | Unread::MissingNumber { .. }
            | Unread::MalformedNumber { .. }
            | Unread::HugeNumber { .. } => Severity::Error,
            Unread::OpenComment | Unread::Leader { .. } => Severity::Warning,
            Unread::Trailer | Unread::OptionalRun { .. } | Unread::OptionalSkipped { .. } => Severity::Info,
        }
    }
}
