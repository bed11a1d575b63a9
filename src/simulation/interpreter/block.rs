//! One block for the interpreter: its words, and their values by letter.

use crate::simulation::gcode::{Argument, LineNumber, Place, Reference, Statement, Word, address};
use std::f64::consts::{PI, TAU};
use std::ops::Range;

/// The block being run.
#[derive(Clone, Copy)]
pub(super) struct Block<'a> {
    pub(super) words: &'a [Word],
    /// Its statements.
    pub(super) statements: &'a BlockStatements<'a>,
    pub(super) line: LineNumber,
}

/// The statements of a block with their arguments. Few blocks have any, and functions pass a block on often, so it
/// holds one reference to both lists.
#[derive(Clone, Copy)]
pub(super) struct BlockStatements<'a> {
    pub(super) list: &'a [Statement],
    /// The arguments of all of them, with their values.
    pub(super) arguments: &'a [Argument],
}

impl<'a> Block<'a> {
    /// Returns a block of words.
    pub(super) fn of_words(words: &'a [Word], line: LineNumber) -> Block<'a> {
        Block { words, statements: &BlockStatements { list: &[], arguments: &[] }, line }
    }

    /// Returns the arguments of one of its statements.
    pub(super) fn arguments_of(self, statement: &Statement) -> &'a [Argument] {
        let before = self.statements.list.first().map_or(0, |first| first.arguments.start);
        let Range { start, end } = statement.arguments;
        &self.statements.arguments[(start - before) as usize..(end - before) as usize]
    }

    /// Returns the place of the whole block.
    pub(super) fn place(self) -> Place {
        Place::line(self.line)
    }

    /// Returns the place of a word.
    pub(super) fn place_of(self, word: &Word) -> Place {
        Place { line: self.line, columns: word.columns.into() }
    }

    /// Returns the place of the last word with `letter`, or of the block without one.
    pub(super) fn place_of_letter(self, letter: u8) -> Place {
        let word = self.words.iter().rfind(|word| word.letter == letter);
        word.map_or(self.place(), |word| self.place_of(word))
    }
}

/// Returns `true` if a block has G4, whose X or U is a time.
pub(super) fn is_dwell(words: &[Word]) -> bool {
    words.iter().any(|word| word.letter == b'G' && word.value == 4.0)
}

/// The values of a block's words other than G and M, by address.
pub(super) struct BlockWords {
    /// The given addresses, one bit each.
    addresses: u64,
    /// Addresses whose words state that they count from the origin.
    absolute: u64,
    /// Addresses whose words state that they count from the position.
    incremental: u64,
    /// Rotary axes whose words state the direction of their turn, among those that count from the origin.
    shortest: u64,
    onward: u64,
    backward: u64,
    values: [f64; 64],
}

/// Returns a set of addresses, one bit each.
pub(super) const fn bits(letters: &[u8]) -> u64 {
    let (mut bits, mut index) = (0, 0);
    while index < letters.len() {
        bits |= 1 << slot(letters[index]);
        index += 1;
    }
    bits
}

/// Returns the bit of an address: letters first, then the longer addresses.
const fn slot(address: u8) -> usize {
    (if address < address::FIRST_NAMED_CODE {
        address - b'A'
    } else {
        address - address::FIRST_NAMED_CODE + 26
    }) as usize
}

impl BlockWords {
    /// Removes all words.
    pub(super) fn clear(&mut self) {
        (self.addresses, self.absolute, self.incremental) = (0, 0, 0);
        (self.shortest, self.onward, self.backward) = (0, 0, 0);
    }

    /// Adds a word.
    pub(super) fn set(&mut self, address: u8, value: f64) {
        if slot(address) < self.values.len() {
            self.addresses |= bits(&[address]);
            self.values[slot(address)] = value;
        }
    }

    /// Returns the value of an address; if it is repeated, the last one.
    pub(super) fn get(&self, address: u8) -> Option<f64> {
        self.has(bits(&[address])).then(|| self.values[slot(address)])
    }

    /// Returns the value of an address and removes it, so that no later rule of the block sees it.
    pub(super) fn take(&mut self, address: u8) -> Option<f64> {
        let value = self.get(address);
        self.addresses &= !bits(&[address]);
        value
    }

    /// Sets the reference point that the word of an address states.
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

    /// Returns the turn of a rotary axis, rad, in the direction that its word states, given the plain difference.
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

    /// Returns `true` if any word states its reference point.
    pub(super) fn refers(&self) -> bool {
        self.absolute | self.incremental != 0
    }

    /// Returns `true` if the value of an address counts from the position, given the distance mode in force.
    pub(super) fn is_incremental(&self, address: u8, is_incremental: bool) -> bool {
        let own = bits(&[address]);
        (is_incremental || self.incremental & own != 0) && self.absolute & own == 0
    }

    /// Returns `true` if any of the addresses is given.
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
