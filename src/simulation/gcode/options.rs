//! The choices of a user on how to read a program.

use crate::simulation::gcode::{ArcCenters, Dialect};

/// Choices of the user on how to read a program.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Options {
    /// The block delete switch: it leaves out the text behind a `/` of each block. Off by default.
    pub block_delete: bool,
    /// The dialect; by default it is detected from the text.
    pub dialect: Option<Dialect>,
    /// The reference point of I, J and K of arcs if the program does not state it; by default the rule of the
    /// control, or the one that the arcs show.
    pub arc_centers: Option<ArcCenters>,
}

impl Options {
    /// Returns the options by the words of dialects and of arc centres, with blanks between them; other words have
    /// no effect.
    pub fn from_words(words: &str) -> Options {
        let words = || words.split_ascii_whitespace();
        Options {
            dialect: words().find_map(Dialect::from_word),
            arc_centers: words().find_map(ArcCenters::from_word),
            ..Options::default()
        }
    }
}
