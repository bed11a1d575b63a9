//! G4: dwells, in the words and units of each control.

use crate::simulation::gcode::{Dialect, Word};
use crate::simulation::interpreter::block::{AXIS_WORDS, Block, bits};
use crate::simulation::interpreter::bounds::MAX_DWELL_S;
use crate::simulation::interpreter::code::Code;
use crate::simulation::interpreter::remark::TraceRemark;
use crate::simulation::interpreter::state::Interpreter;

/// Least time without a decimal point that is not in seconds in a program of an unknown control.
const MIN_TIME_IN_MS: f64 = 100.0;

/// The unit of a time.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum TimeUnit {
    Seconds,
    Milliseconds,
    /// Milliseconds, judged by the size of the number alone.
    Guessed,
}

impl TimeUnit {
    /// Returns a value in s.
    pub(super) fn seconds(self, value: f64) -> f64 {
        if self == TimeUnit::Seconds { value } else { value / 1000.0 }
    }
}

impl Interpreter<'_> {
    /// Runs G4.
    pub(crate) fn dwell(&mut self, block: Block, code: Code) {
        if has_dwell_by_feed(self.dialect) && !self.given.has(bits(b"P")) {
            return self.dwell_by_feed(block);
        }
        let given_as = |letter: u8| block.words.iter().rfind(|word| word.letter == letter);
        let Some(word) = given_as(b'P').or(given_as(b'X')).or(given_as(b'U')) else {
            self.remarks.add(block.place(), TraceRemark::NoDwellTime);
            return;
        };
        let (unit, place) = (self.unit_of_time(word), block.place_of(word));
        match unit {
            TimeUnit::Guessed => self.remarks.add(place, TraceRemark::GuessedTimeUnit),
            TimeUnit::Milliseconds => self.remarks.add(place, TraceRemark::TimeInMilliseconds),
            TimeUnit::Seconds if word.letter == b'P' => self.remarks.add(place, TraceRemark::DwellInSeconds),
            TimeUnit::Seconds => {}
        }
        let seconds = unit.seconds(word.value);
        if (0.0..=MAX_DWELL_S).contains(&seconds) {
            self.canonical.dwell(block.line, seconds);
        } else {
            self.remarks.add(block.place_of(word), TraceRemark::BadDwell { seconds });
        }
        let others = if word.letter == b'X' { bits(b"YZ") } else { AXIS_WORDS };
        if self.given.has(others) {
            self.remarks.add(block.place(), TraceRemark::UnusedAxisWords { code });
        }
    }

    /// Runs G4 F (s) and G4 S (revolutions of the spindle).
    pub(crate) fn dwell_by_feed(&mut self, block: Block) {
        let given_as =
            |letter: u8| block.words.iter().rfind(|word| word.letter == letter).map(|word| word.value);
        let seconds = match (given_as(b'F'), given_as(b'S')) {
            (Some(seconds), _) => seconds,
            (None, Some(turns)) => match self.functions.speed.filter(|speed| 0.0 < *speed) {
                Some(speed) => 60.0 * turns / speed,
                None => {
                    let what = "turns of a spindle whose speed is unknown: no dwell";
                    self.remarks.add(block.place(), TraceRemark::Statement { name: "G4 S", what });
                    return;
                }
            },
            (None, None) => {
                self.remarks.add(block.place(), TraceRemark::NoDwellTime);
                return;
            }
        };
        if (0.0..=MAX_DWELL_S).contains(&seconds) {
            self.canonical.dwell(block.line, seconds);
        } else {
            self.remarks.add(block.place(), TraceRemark::BadDwell { seconds });
        }
    }

    /// Returns the unit of the time of a dwell or a cycle. On Fanuc controls a time without a decimal point is in
    /// milliseconds, their least increment; RS274/NGC has seconds. A program that shows neither is more often for
    /// a Fanuc control, and hardly waits for minutes.
    pub(crate) fn unit_of_time(&self, word: &Word) -> TimeUnit {
        let is_guess = self.dialect == Dialect::Iso && MIN_TIME_IN_MS <= word.value;
        match () {
            () if word.has_point => TimeUnit::Seconds,
            () if self.is_tape => TimeUnit::Milliseconds,
            () if is_guess => TimeUnit::Guessed,
            () => TimeUnit::Seconds,
        }
    }
}

/// Returns `true` for controls on which F of G4 is a time.
pub(super) fn has_dwell_by_feed(dialect: Dialect) -> bool {
    matches!(dialect, Dialect::Siemens | Dialect::HeidenhainIso | Dialect::Okuma)
}
