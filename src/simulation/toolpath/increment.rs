//! Lengths without a decimal point on controls that count them in their least input increment.
//!
//! Fanuc controls and their relatives, Okuma too, may be set to read `X10000` as 10000 increments of
//! 0.001 mm, that is 10 mm, while `X10.` is 10 mm. The machine file says so by its increment; in
//! inch one increment is a tenth of its number (0.0001 inch for 0.001 mm). It holds for X Y Z U V W
//! I J K R Q; not for rotary axes, nor for words that are no lengths: those of macro calls (G65,
//! G66), of M98, of look-ahead and contour modes (G5.1, G8, G187). Values of formulas count as
//! written with a point, as on Fanuc controls. X and U of G4 count the same
//! increments of a second, in inch too.
//!
//! LinuxCNC, grbl, Mach, SINUMERIK and Heidenhain controls read a number as it is written.
//!
//! Where the machine file gives no increment, words are taken as they are; a program that writes
//! points and has a large number without one is told of it once, and so is one that writes none and
//! whose path reaches farther than machines do.
//!
//! Source: Fanuc B-63944EN, decimal point programming.

use crate::simulation::gcode::{self, Dialect, LineNumber, Place, Program, Word};
use crate::simulation::toolpath::block::Block;
use crate::simulation::toolpath::remark::Untraced;
use crate::simulation::toolpath::trace::{Family, Tracer};
use crate::units::MM_PER_INCH;

/// G words in whose blocks these letters are no lengths.
const OTHER_G: [f64; 6] = [5.1, 8.0, 65.0, 66.0, 66.1, 187.0];

/// M words in whose blocks they are none.
const OTHER_M: [f64; 3] = [97.0, 98.0, 198.0];

/// A number without a point that is at least this looks like increments, units of length.
const LARGE: f64 = 1000.0;

/// What hardly a machine travels in one axis, mm.
const LONGEST_TRAVEL: f64 = 5000.0;

/// What a program shows of its decimal points.
#[derive(Default)]
pub(super) struct Points {
    /// Some length has one.
    are_written: bool,
    /// The first large length that has none.
    missing: Option<(Place, Untraced)>,
}

/// Whether the letter of a word is that of a length.
fn is_length(word: &Word) -> bool {
    matches!(word.letter, b'X' | b'Y' | b'Z' | b'U' | b'V' | b'W' | b'I' | b'J' | b'K' | b'R' | b'Q')
}

fn has_lengths(words: &[Word]) -> bool {
    !words.iter().any(|word| match word.letter {
        b'G' => OTHER_G.contains(&word.value),
        b'M' => OTHER_M.contains(&word.value),
        _ => false,
    })
}

/// Whether the X or U of a block is a time.
fn is_dwell(words: &[Word]) -> bool {
    words.iter().any(|word| word.letter == b'G' && word.value == 4.0)
}

impl Tracer<'_> {
    /// The words of a block with lengths by increments; none where they are as written. `read` are
    /// its words as they were read, where formulas have no value.
    pub(super) fn by_increments(&self, words: &[Word], read: &[Word]) -> Option<Vec<Word>> {
        let increment = self.machine.program.increment.filter(|_| self.family == Family::Fanuc)?;
        let unit_after = words.iter().rev().find_map(|word| match word {
            Word { letter: b'G', value: 20.0, .. } => Some(MM_PER_INCH),
            Word { letter: b'G', value: 21.0, .. } => Some(1.0),
            _ => None,
        });
        let is_inch = unit_after.unwrap_or(self.modal.unit) == MM_PER_INCH;
        let increment = if is_inch && !is_dwell(words) { increment / 10.0 } else { increment };
        if !has_lengths(words) {
            return None;
        }
        let mut read = read.iter();
        let mut words = words.to_vec();
        for word in &mut words {
            // Words without a value are missing here, the others stand in the same order.
            let as_read = read.find(|as_read| as_read.columns == word.columns);
            let is_written = as_read.is_some_and(|as_read| !as_read.value.is_nan());
            if is_written && !word.has_point && is_length(word) {
                word.value *= increment;
                word.has_point = true;
            }
        }
        Some(words)
    }

    /// Looks for large lengths without a point and for lengths with one in these blocks.
    pub(super) fn look_for_points(&mut self, program: &Program) {
        if self.family != Family::Fanuc || self.machine.program.increment.is_some() {
            return;
        }
        let are_written = |word: &Word| word.has_point && is_length(word);
        self.points.are_written = self.points.are_written || program.words.iter().any(are_written);
        let is_large = |word: &&Word| !word.has_point && LARGE <= word.value.abs() && is_length(word);
        let is_missing = |block: &gcode::Block| {
            let words = program.words(block);
            let word = words.iter().find(is_large).filter(|_| has_lengths(words) && !is_dwell(words))?;
            let place = Block { words, line: block.line }.place_of(word);
            let remark = Untraced::MissingPoint { letter: char::from(word.letter), value: word.value };
            Some((place, remark))
        };
        if self.points.missing.is_none() && program.words.iter().any(|word| is_large(&word)) {
            self.points.missing = program.blocks.iter().find_map(is_missing);
        }
    }

    /// Tells of a large length without a point in a program that writes points, and of a long path in an ISO
    /// program that writes none.
    pub(super) fn tell_missing_points(&mut self) {
        let may_count = matches!(self.dialect, Dialect::Iso | Dialect::Okuma);
        if may_count && self.machine.program.increment.is_none() && !self.points.are_written {
            if let Some(line) = self.longer_than_machines() {
                self.remarks.add(Place::line(line), Untraced::NoPoints);
            }
            return;
        }
        let missing = self.points.missing.take().filter(|_| self.points.are_written);
        if let Some((place, remark)) = missing {
            self.remarks.add(place, remark);
        }
    }

    /// The line with which the path first extends too far for a machine.
    fn longer_than_machines(&self) -> Option<LineNumber> {
        let start = self.toolpath.segments.first()?.start.coords;
        let (mut least, mut most) = (start, start);
        let mut segments = self.toolpath.segments.iter();
        let beyond = segments.find(|segment| {
            (least, most) = (least.inf(&segment.end.coords), most.sup(&segment.end.coords));
            LONGEST_TRAVEL < (most - least).amax()
        });
        beyond.map(|segment| segment.line)
    }
}

#[cfg(test)]
mod tests;
