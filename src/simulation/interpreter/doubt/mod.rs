//! Reach of doubts along the path: a missing axis word reaches to the next word of that axis, a missing feed to
//! the next F, a missing motion word to the next one.

mod reach;

use crate::simulation::gcode::{Letters, Word};

/// The doubts whose reach has not ended.
#[derive(Default)]
pub(super) struct OpenDoubts {
    /// Number of doubts that were read.
    read: usize,
    /// Each by its index, with the letters that end it.
    open: Vec<(usize, Letters)>,
}

impl OpenDoubts {
    /// Returns `true` if the reach of every doubt has ended.
    pub(super) fn is_empty(&self) -> bool {
        self.open.is_empty()
    }
}

/// Returns the letters of words. A G word counts if it is a motion word or calls a cycle, which counts as both.
pub(super) fn letters(words: &[Word]) -> Letters {
    words.iter().fold(Letters::default(), |letters, word| {
        letters.with(match word.letter {
            b'G' if (73.0..90.0).contains(&word.value) => Letters::MOTION.with(Letters::CYCLE),
            b'G' if !(0.0..4.0).contains(&word.value) => Letters::default(),
            letter => Letters::of(&[letter]),
        })
    })
}
