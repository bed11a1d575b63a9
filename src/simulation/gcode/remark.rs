//! Remarks of reading a program.

use crate::simulation::gcode::formula::MAX_NESTING;
use crate::simulation::gcode::line::MAX_WORDS;
use crate::simulation::gcode::structure::MAX_OPEN;
use crate::simulation::gcode::{DoubtCause, DoubtEffect, Letters, Remark, Severity, counted};
use thiserror::Error;

/// A part of the text that is not read as a block of words.
#[derive(Clone, Debug, PartialEq, Error)]
pub(super) enum Unread {
    /// An expression that breaks off or continues with a wrong sign.
    #[error("expected {expected}, found {found}: block not run")]
    Expected {
        /// The signs that are possible.
        expected: &'static str,
        /// The text found instead.
        found: String,
    },
    /// Letters in an expression that are no function.
    #[error("`{text}` is not a known function: block not run")]
    Function {
        /// As written.
        text: String,
    },
    /// `<` that does not begin the name of a parameter.
    #[error("`{text}` is not the name of a parameter: block not run")]
    Name {
        /// As written.
        text: String,
    },
    /// A number in an expression beyond what a number can hold.
    #[error("`{text}` is too large: block not run")]
    HugeValue {
        /// As written.
        text: String,
    },
    /// Brackets nested too deeply.
    #[error("brackets and # are nested deeper than {MAX_NESTING}: block not run")]
    Nesting,
    /// A word that ends or divides a structure that was never opened.
    #[error("`{word}` without its beginning: left out")]
    Unopened {
        /// The word.
        word: String,
    },
    /// A word that opens a structure that never ends.
    #[error("`{word}` has no end: the rest is run once")]
    Unclosed {
        /// The word.
        word: &'static str,
    },
    /// Loops and branches nested too deeply.
    #[error("loops and branches are nested deeper than {MAX_OPEN}: block not run")]
    DeepFlow,
    /// A line longer than controls accept, as in a file whose line ends were lost.
    #[error(
        "{words} words in one block, {MAX_WORDS} at most: block not run; are the line ends of the file missing?"
    )]
    LongBlock {
        /// Number of its words.
        words: usize,
    },
    /// A line for the control itself, not for the machine.
    #[error("`{text}` is a command to the control, not a move: left out")]
    Command {
        /// As written.
        text: String,
    },
    /// A file with two bytes a character.
    #[error("the file is in UTF-16 (\"Unicode\"), which controls do not read; Truefeed decoded it")]
    Utf16,
    /// A dash before a number.
    #[error("`{sign}` is no minus sign that a control reads: taken as one here and further on")]
    Dash {
        /// As written.
        sign: &'static str,
    },
    /// A call after every move.
    #[error("{word} (a call after every move) is not modelled: the subprogram is not run")]
    ModalCall {
        /// As written.
        word: String,
    },
    /// A word of the control that is known and has no effect in the simulation.
    #[error("{name}: {what}")]
    Own {
        /// The word.
        name: String,
        /// The part without a model.
        what: &'static str,
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
    /// A number with two points, an inner sign, and the like.
    #[error("`{text}` is not a number: left out, the rest of the block is run")]
    MalformedNumber {
        /// As written.
        text: String,
    },
    /// A number beyond f64.
    #[error("`{text}` is too large: left out, the rest of the block is run")]
    HugeNumber {
        /// As written.
        text: String,
    },
    /// `(` without `)`.
    #[error("comment is not closed: the rest of the line is taken as comment")]
    OpenComment,
    /// Lines before the opening `%`.
    #[error("the text before this % is taken as leader ({}): not run", counted(*.blocks, "block"))]
    Leader {
        /// Number of its blocks.
        blocks: usize,
    },
    /// Lines after the closing `%`.
    #[error("the program ends at the % above: the rest is not read")]
    Trailer,
    /// Lines that begin with `/`, run.
    #[error("{} with / from here on: run, as with the block delete switch off", counted(*.blocks, "block"))]
    OptionalRun {
        /// Number of these lines.
        blocks: usize,
    },
    /// Lines that begin with `/`, not run.
    #[error("{} with / from here on: not run, as with the block delete switch on", counted(*.blocks, "block"))]
    OptionalSkipped {
        /// Number of these lines.
        blocks: usize,
    },
}

impl Remark for Unread {
    fn severity(&self) -> Severity {
        match self {
            Unread::Expected { .. }
            | Unread::Function { .. }
            | Unread::Name { .. }
            | Unread::HugeValue { .. }
            | Unread::Nesting
            | Unread::Unopened { .. }
            | Unread::Unclosed { .. }
            | Unread::DeepFlow
            | Unread::LongBlock { .. }
            | Unread::ModalCall { .. }
            | Unread::Text { .. }
            | Unread::MissingNumber { .. }
            | Unread::MalformedNumber { .. }
            | Unread::HugeNumber { .. } => Severity::Error,
            Unread::OpenComment | Unread::Leader { .. } | Unread::Own { .. } | Unread::Dash { .. } => {
                Severity::Warning
            }
            Unread::Command { .. }
            | Unread::Utf16
            | Unread::Trailer
            | Unread::OptionalRun { .. }
            | Unread::OptionalSkipped { .. } => Severity::Info,
        }
    }

    fn doubt(&self) -> Option<(DoubtCause, DoubtEffect)> {
        let unread = |letter: u8| {
            Some((DoubtCause::UnreadWords, DoubtEffect::Words(Letters::of(&[letter.to_ascii_uppercase()]))))
        };
        match self {
            // An O that is no name is probably a zero of the word before, which may be any.
            Unread::MissingNumber { letter: 'O' | 'o' } => {
                Some((DoubtCause::UnreadWords, DoubtEffect::Words(Letters::AXES.with(Letters::of(b"F")))))
            }
            Unread::MissingNumber { letter } => unread(*letter as u8),
            Unread::MalformedNumber { text } | Unread::HugeNumber { text } => {
                unread(text.bytes().next().unwrap_or_default())
            }
            Unread::OpenComment => Some((DoubtCause::UnreadWords, DoubtEffect::Words(Letters::AXES))),
            Unread::Unopened { .. } | Unread::Unclosed { .. } | Unread::DeepFlow => {
                Some((DoubtCause::BrokenFlow, DoubtEffect::Unbounded))
            }
            Unread::Leader { .. } | Unread::LongBlock { .. } => {
                Some((DoubtCause::BlocksNotRun, DoubtEffect::Unbounded))
            }
            Unread::ModalCall { .. } => Some((DoubtCause::MissingSubprograms, DoubtEffect::Unbounded)),
            Unread::Own { .. } => Some((DoubtCause::UnmodelledFunctions, DoubtEffect::Unbounded)),
            // The words of a dropped block are known where the reader drops it.
            Unread::Expected { .. }
            | Unread::Function { .. }
            | Unread::Name { .. }
            | Unread::HugeValue { .. }
            | Unread::Nesting
            | Unread::Text { .. } => None,
            Unread::Command { .. }
            | Unread::Utf16
            | Unread::Dash { .. }
            | Unread::Trailer
            | Unread::OptionalRun { .. }
            | Unread::OptionalSkipped { .. } => None,
        }
    }
}
