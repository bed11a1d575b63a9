//! From which segment to which a doubt reaches: a missing axis word up to where the axis is given again, a missing feed up
//! to the next F, a missing motion word up to the next one.

mod reach;

use crate::simulation::gcode::{Letters, Word};

/// Doubts that reach on.
#[derive(Default)]
pub(super) struct OpenDoubts {
    /// How many doubts are looked at.
    seen: usize,
    /// Each by its index, and the letters that end it.
    open: Vec<(usize, Letters)>,
}

impl OpenDoubts {
    /// No doubt reaches on.
    pub(super) fn is_empty(&self) -> bool {
        self.open.is_empty()
    }
}

/// The letters of words; a G word counts where it is a motion word or calls a cycle, which is one too.
pub(super) fn letters(words: &[Word]) -> Letters {
    words.iter().fold(Letters::default(), |letters, word| {
        letters.with(match word.letter {
            b'G' if (73.0..90.0).contains(&word.value) => Letters::MOTION.with(Letters::CYCLE),
            b'G' if !(0.0..4.0).contains(&word.value) => Letters::default(),
            letter => Letters::of(&[letter]),
        })
    })
}
