//! One block as the tracer takes it: its words, and their values by letter.

use crate::simulation::gcode::{LineNumber, Place, Word};

/// The block being run.
#[derive(Clone, Copy)]
pub(super) struct Block<'a> {
    pub(super) words: &'a [Word],
    pub(super) line: LineNumber,
}

impl Block<'_> {
    pub(super) fn place(self) -> Place {
        Place::line(self.line)
    }

    pub(super) fn place_of(self, word: &Word) -> Place {
        Place { line: self.line, columns: word.columns }
    }

    /// Where the last word with `letter` stands.
    pub(super) fn place_of_letter(self, letter: u8) -> Place {
        let word = self.words.iter().rfind(|word| word.letter == letter);
        word.map_or(self.place(), |word| self.place_of(word))
    }
}

/// The values of a block's words other than G and M, by letter.
#[derive(Default)]
pub(super) struct Given {
    /// One bit a letter.
    letters: u32,
    values: [f64; 26],
}

/// A set of letters, as one bit each.
pub(super) const fn bits(letters: &[u8]) -> u32 {
    let (mut bits, mut index) = (0, 0);
    while index < letters.len() {
        bits |= 1 << (letters[index] - b'A');
        index += 1;
    }
    bits
}

impl Given {
    /// Forgets all.
    pub(super) fn clear(&mut self) {
        self.letters = 0;
    }

    pub(super) fn set(&mut self, letter: u8, value: f64) {
        self.letters |= bits(&[letter]);
        self.values[usize::from(letter - b'A')] = value;
    }

    /// Its value; of a repeated letter the last one.
    pub(super) fn get(&self, letter: u8) -> Option<f64> {
        self.has(bits(&[letter])).then(|| self.values[usize::from(letter - b'A')])
    }

    /// Its value, which no other word of the block sees from here on.
    pub(super) fn take(&mut self, letter: u8) -> Option<f64> {
        let value = self.get(letter);
        self.letters &= !bits(&[letter]);
        value
    }

    /// Whether any of the letters is given.
    pub(super) fn has(&self, letters: u32) -> bool {
        self.letters & letters != 0
    }
}

pub(super) const AXIS_WORDS: u32 = bits(b"XYZ");
pub(super) const CENTER_WORDS: u32 = bits(b"IJK");
pub(super) const UNMODELLED_WORDS: u32 = bits(b"ABCEUVW");
