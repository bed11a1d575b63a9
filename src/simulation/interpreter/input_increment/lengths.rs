//! Words without a decimal point as lengths, and remarks on such words.

use crate::simulation::gcode::{
    self, Dialect, Doubt, DoubtCause, DoubtEffect, Letters, LineNumber, Place, Program, Word,
};
use crate::simulation::interpreter::block::{Block, is_dwell};
use crate::simulation::interpreter::input_increment::{has_lengths, is_length};
use crate::simulation::interpreter::remark::TraceRemark;
use crate::simulation::interpreter::state::{Family, Interpreter};
use crate::simulation::toolpath::Segment;
use crate::units::MM_PER_INCH;

/// Least number without a decimal point that is probably in increments, units of length.
const LARGE_NUMBER: f64 = 1000.0;

/// Larger travels in one axis are rare among machines, mm.
const MAX_TRAVEL_MM: f64 = 5000.0;

impl Interpreter<'_> {
    /// Returns the words of a block with lengths by increments, or `None` if they do not change. `read` are its
    /// words as read, in which words of formulas have no value.
    pub(crate) fn by_increments(&self, words: &[Word], read: &[Word]) -> Option<Vec<Word>> {
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
            // Words without a value are missing here, the others are in the same order.
            let as_read = read.find(|as_read| as_read.columns == word.columns);
            let is_written = as_read.is_some_and(|as_read| !as_read.value.is_nan());
            if is_written && !word.has_point && is_length(word) {
                word.value *= increment;
                word.has_point = true;
            }
        }
        Some(words)
    }

    /// Searches the blocks for large lengths without a decimal point and for lengths with one.
    pub(crate) fn look_for_points(&mut self, program: &Program) {
        if self.family != Family::Fanuc || self.machine.program.increment.is_some() {
            return;
        }
        let are_written = |word: &Word| word.has_point && is_length(word);
        self.points.are_written = self.points.are_written || program.words.iter().any(are_written);
        let is_large = |word: &&Word| !word.has_point && LARGE_NUMBER <= word.value.abs() && is_length(word);
        let is_missing = |block: &gcode::Block| {
            let words = program.words(block);
            let word = words.iter().find(is_large).filter(|_| has_lengths(words) && !is_dwell(words))?;
            let place = Block::of_words(words, block.line).place_of(word);
            let remark = TraceRemark::MissingPoint { letter: char::from(word.letter), value: word.value };
            Some((place, remark))
        };
        if self.points.missing.is_none() && program.words.iter().any(|word| is_large(&word)) {
            self.points.missing = program.blocks.iter().find_map(is_missing);
        }
    }

    /// Remarks on a large length without a decimal point in a program that has points, and on a long path in an
    /// ISO program without points.
    pub(crate) fn remark_on_missing_points(&mut self) {
        let may_count = matches!(self.dialect, Dialect::Iso | Dialect::Okuma);
        if may_count && self.machine.program.increment.is_none() && !self.points.are_written {
            if let Some(line) = self.longer_than_machines() {
                self.remarks.add(Place::line(line), TraceRemark::NoPoints);
            }
            return;
        }
        let missing = self.points.missing.take().filter(|_| self.points.are_written);
        if let Some((place, remark)) = missing {
            if let TraceRemark::MissingPoint { letter, .. } = remark {
                let doubt = self.doubt_of_missing_point(place.line, letter as u8);
                self.remarks.doubts.push(doubt);
            }
            self.remarks.add(place, remark);
        }
    }

    /// Returns the doubt about a length in `line` without its decimal point. It is noticed at the end of the
    /// program, and reaches from the first move of that line to the next one along the same axis.
    fn doubt_of_missing_point(&self, line: LineNumber, letter: u8) -> Doubt {
        let segments = &self.canonical.toolpath().segments;
        let cause = DoubtCause::MissingPoints;
        let Some(after) = segments.iter().position(|segment| segment.line == line) else {
            // It is a shift or a parameter, which may affect any move.
            let after = segments.len();
            return Doubt { line, cause, effect: DoubtEffect::Unbounded, after, until: after };
        };
        let effect = DoubtEffect::Words(Letters::of(&[letter]));
        let own = segments.iter().skip(after).take_while(|segment| segment.line == line).count();
        let behind = after + own;
        let axis = b"XYZ".iter().position(|axis| *axis == letter);
        let until = axis.map_or(behind, |axis| {
            let is_given_again = |segment: &Segment| segment.start[axis] != segment.end[axis];
            let again = segments.iter().skip(behind).position(|segment| is_given_again(&segment));
            again.map_or(segments.len(), |again| behind + again + 1)
        });
        Doubt { line, cause, effect, after, until }
    }

    /// Returns the line with which the path first extends further than machines travel.
    fn longer_than_machines(&self) -> Option<LineNumber> {
        let start = self.canonical.toolpath().segments.first()?.start.coords;
        let (mut least, mut most) = (start, start);
        let mut segments = self.canonical.toolpath().segments.iter();
        let beyond = segments.find(|segment| {
            (least, most) = (least.inf(&segment.end.coords), most.sup(&segment.end.coords));
            MAX_TRAVEL_MM < (most - least).amax()
        });
        beyond.map(|segment| segment.line)
    }
}
