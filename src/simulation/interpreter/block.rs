//! One block as the interpreter takes it: its words, and their values by letter.

use crate::simulation::gcode::{Argument, LineNumber, Place, Reference, Statement, Word, address};
use std::f64::consts::{PI, TAU};
use std::ops::Range;

/// The block being run.
#[derive(Clone, Copy)]
pub(super) struct Block<'a> {
    pub(super) words: &'a [Word],
    pub(super) asked: &'a Asked<'a>,
    pub(super) line: LineNumber,
}

/// The statements of a block. Few blocks have any, and a block is handed on often: it holds one reference to both lists.
#[derive(Clone, Copy)]
pub(super) struct Asked<'a> {
    pub(super) statements: &'a [Statement],
    /// The arguments of all of them, with their values.
    pub(super) arguments: &'a [Argument],
}

impl<'a> Block<'a> {
    /// Returns a block of words.
    pub(super) fn of_words(words: &'a [Word], line: LineNumber) -> Block<'a> {
        Block { words, asked: &Asked { statements: &[], arguments: &[] }, line }
    }

    /// Returns the arguments of one of its statements.
    pub(super) fn arguments_of(self, statement: &Statement) -> &'a [Argument] {
        let before = self.asked.statements.first().map_or(0, |first| first.arguments.start);
        let Range { start, end } = statement.arguments;
        &self.asked.arguments[(start - before) as usize..(end - before) as usize]
    }

    pub(super) fn place(self) -> Place {
        Place::line(self.line)
    }

    pub(super) fn place_of(self, word: &Word) -> Place {
        Place { line: self.line, columns: word.columns.into() }
    }

    /// Where the last word with `letter` stands.
    pub(super) fn place_of_letter(self, letter: u8) -> Place {
        let word = self.words.iter().rfind(|word| word.letter == letter);
        word.map_or(self.place(), |word| self.place_of(word))
    }
}

/// The values of a block's words other than G and M, by address.
pub(super) struct BlockWords {
    /// One bit an address.
    addresses: u64,
    /// Those whose words say themselves what they count from.
    absolute: u64,
    incremental: u64,
    /// Of those that count from the origin, those that say which way a rotary axis turns.
    shortest: u64,
    onward: u64,
    backward: u64,
    values: [f64; 64],
}

/// A set of letters, as one bit each.
pub(super) const fn bits(letters: &[u8]) -> u64 {
    let (mut bits, mut index) = (0, 0);
    while index < letters.len() {
        bits |= 1 << slot(letters[index]);
        index += 1;
    }
    bits
}

/// Letters first, then the longer addresses.
const fn slot(address: u8) -> usize {
    (if address < address::FIRST { address - b'A' } else { address - address::FIRST + 26 }) as usize
}

impl BlockWords {
    /// Forgets all.
    pub(super) fn clear(&mut self) {
        (self.addresses, self.absolute, self.incremental) = (0, 0, 0);
        (self.shortest, self.onward, self.backward) = (0, 0, 0);
    }

    /// Takes in a word.
    pub(super) fn set(&mut self, address: u8, value: f64) {
        if slot(address) < self.values.len() {
            self.addresses |= bits(&[address]);
            self.values[slot(address)] = value;
        }
    }

    /// Its value; of a repeated address the last one.
    pub(super) fn get(&self, address: u8) -> Option<f64> {
        self.has(bits(&[address])).then(|| self.values[slot(address)])
    }

    /// Its value, which no other word of the block sees from here on.
    pub(super) fn take(&mut self, address: u8) -> Option<f64> {
        let value = self.get(address);
        self.addresses &= !bits(&[address]);
        value
    }

    /// Notes what the word of an address counts from.
    pub(super) fn refer(&mut self, address: u8, reference: Reference) {
        let own = bits(&[address]);
        match reference {
            Reference::Modal => return,
            Reference::Incremental => {
                self.incremental |= own;
                return;
            }
            Reference::Absolute => {}
            Reference::Shortest => self.shortest |= own,
            Reference::Onward => self.onward |= own,
            Reference::Backward => self.backward |= own,
        }
        self.absolute |= own;
    }

    /// The turn of a rotary axis, rad, by the way that its word says, given the plain difference.
    pub(super) fn turn(&self, address: u8, difference: f64) -> f64 {
        let own = bits(&[address]);
        let onward = difference.rem_euclid(TAU);
        if self.shortest & own != 0 {
            if PI < onward { onward - TAU } else { onward }
        } else if self.onward & own != 0 {
            onward
        } else if self.backward & own != 0 && 0.0 < onward {
            onward - TAU
        } else {
            difference
        }
    }

    /// Whether any word says itself what it counts from.
    pub(super) fn refers(&self) -> bool {
        self.absolute | self.incremental != 0
    }

    /// What its value counts from, where `is_incremental` is in force.
    pub(super) fn is_incremental(&self, address: u8, is_incremental: bool) -> bool {
        let own = bits(&[address]);
        (is_incremental || self.incremental & own != 0) && self.absolute & own == 0
    }

    /// Whether any of the addresses is given.
    pub(super) fn has(&self, addresses: u64) -> bool {
        self.addresses & addresses != 0
    }
}

impl Default for BlockWords {
    fn default() -> BlockWords {
        BlockWords {
            addresses: 0,
            absolute: 0,
            incremental: 0,
            shortest: 0,
            onward: 0,
            backward: 0,
            values: [0.0; 64],
        }
    }
}

pub(super) const AXIS_WORDS: u64 = bits(&[b'X', b'Y', b'Z', address::POLAR_RADIUS, address::POLAR_ANGLE]);
pub(super) const CENTER_WORDS: u64 = bits(b"IJK");
pub(super) const UNMODELLED_WORDS: u64 = bits(b"EUVW");
pub(super) const POLAR_WORDS: u64 = bits(&[address::POLAR_RADIUS, address::POLAR_ANGLE]);
