//! The words of Klartext statements, and their values.

use crate::simulation::gcode::expression::{Notation, klartext_number};
use crate::simulation::gcode::klartext::begins;
use crate::simulation::gcode::klartext::names::{WORDS, Word as Kind};
use crate::simulation::gcode::klartext::{ContourWay, KlartextStatement, Transformation};
use crate::simulation::gcode::line::{Line, character_length, continuation, excerpt};
use crate::simulation::gcode::number::{Number, number, skip_blanks};
use crate::simulation::gcode::reader::{Reader, Refusal};
use crate::simulation::gcode::remark::Unread;
use crate::simulation::gcode::{Reference, Target, Word, address};

/// M functions behind which further words do not belong to the path.
pub(super) const WITH_SETTINGS: &[f64] = &[112.0, 114.0, 118.0, 124.0, 150.0];

/// M functions behind which F is not the feedrate of the path.
const WITH_FEED: &[f64] = &[103.0, 128.0, 140.0];

impl Reader<'_> {
    /// Reads a statement with the words of a path.
    pub(super) fn klartext_path(
        &mut self,
        code: &[u8],
        (at, end): (usize, usize),
        statement: KlartextStatement,
        line: &mut Line,
    ) -> Result<(), Refusal> {
        self.push_klartext(statement, line.columns(at, end.max(at + 1)));
        let takes_radius = takes_radius(statement);
        let mut next = self.klartext_bare_value(code, skip_blanks(code, end), statement, line)?;
        let (mut has_radius, mut is_path_feed) = (!takes_radius, true);
        loop {
            next = skip_blanks(code, next);
            let Some(rest) = code.get(next..).filter(|rest| !rest.is_empty()) else { return Ok(()) };
            let Some((word, kind)) = word_at(rest) else {
                let length = rest.iter().take_while(|byte| byte.is_ascii_alphanumeric()).count();
                let length = length.max(character_length(rest));
                let shown = excerpt(&rest[..length]);
                return Err((Unread::Text { text: shown }, line.columns(next, next + length)));
            };
            let past = next + word.len();
            let columns = line.columns(next, past);
            next = match *kind {
                Kind::Flag(address, value) => {
                    self.push_word(address, f64::from(value), columns);
                    past
                }
                Kind::Sense => {
                    let sign = skip_blanks(code, past);
                    let sense = match code.get(sign) {
                        Some(b'+') => 1.0,
                        Some(b'-') => -1.0,
                        _ => {
                            let found = found_at(code, sign);
                            return Err((Unread::Expected { expected: "`+` or `-`", found }, columns));
                        }
                    };
                    self.push_word(address::SENSE, sense, line.columns(next, sign + 1));
                    sign + 1
                }
                Kind::Unneeded => self.klartext_unneeded(code, past, line)?,
                Kind::Value(address::CIRCLE_RADIUS) if is_no_compensation(code, past) && has_radius => {
                    self.push_word(address::SIDE, 0.0, line.columns(next, past + 1));
                    past + 1
                }
                Kind::Value(address::CIRCLE_RADIUS) if statement == KlartextStatement::Chamfer => {
                    self.klartext_value(code, (next, past), address::CHAMFER_LEG, Reference::Modal, line)?
                }
                Kind::Value(b'F') if !is_path_feed => {
                    is_path_feed = true;
                    self.klartext_unneeded(code, past, line)?
                }
                Kind::Value(letter) => {
                    has_radius |= letter == address::CIRCLE_RADIUS;
                    if let (true, None) =
                        (statement == KlartextStatement::Transform(Transformation::Mirror), plain(code, past))
                    {
                        self.push_word(letter, 1.0, columns);
                        past
                    } else {
                        self.klartext_value(code, (next, past), letter, Reference::Modal, line)?
                    }
                }
                Kind::Increment(letter) => {
                    self.klartext_value(code, (next, past), letter, Reference::Incremental, line)?
                }
            };
            if let Some(word) = self.program.words.last().filter(|word| word.letter == b'M') {
                if WITH_SETTINGS.contains(&word.value) {
                    return Ok(());
                }
                is_path_feed = !WITH_FEED.contains(&word.value);
            }
        }
    }

    /// Reads the leg of a chamfer or the radius of a rounding at `at`, if it has no letter; returns its end.
    fn klartext_bare_value(
        &mut self,
        code: &[u8],
        at: usize,
        statement: KlartextStatement,
        line: &mut Line,
    ) -> Result<usize, Refusal> {
        let Some(first) = code.get(at) else { return Ok(at) };
        let has_leg = || !first.is_ascii_alphabetic() || klartext_number(&code[at..]).is_some();
        let letter = match statement {
            KlartextStatement::Chamfer if has_leg() => address::CHAMFER_LEG,
            KlartextStatement::Rounding if first.is_ascii_digit() || *first == b'+' => address::CIRCLE_RADIUS,
            _ => return Ok(at),
        };
        self.klartext_value(code, (at, at), letter, Reference::Modal, line)
    }

    /// Reads the value at `start` as a word that begins at `at`; returns its end.
    pub(super) fn klartext_value(
        &mut self,
        code: &[u8],
        (at, start): (usize, usize),
        letter: u8,
        reference: Reference,
        line: &mut Line,
    ) -> Result<usize, Refusal> {
        if let Some(Number { value, has_point, end }) = plain(code, start) {
            let columns = line.columns(at, end);
            if !value.is_finite() {
                return Err((Unread::HugeValue { text: excerpt(&code[start..end]) }, columns));
            }
            self.program.words.push(Word { value, columns: columns.into(), letter, has_point, reference });
            return Ok(end);
        }
        let (end, columns) = self.formula_of_word(Notation::Klartext, code, (at, start), line)?;
        self.push_computed(letter, reference, columns);
        Ok(end)
    }

    /// Skips the value at `start`; returns its end.
    fn klartext_unneeded(&mut self, code: &[u8], start: usize, line: &mut Line) -> Result<usize, Refusal> {
        if begins(code, skip_blanks(code, start), &["MAX"]).is_some() {
            return Ok(skip_blanks(code, start) + 3);
        }
        if let Some(found) = plain(code, start) {
            return Ok(found.end);
        }
        let (end, _) = self.formula(Notation::Klartext, code, (start, start), line, |expressions| {
            expressions.value()?;
            Ok(Target::Result)
        })?;
        Ok(end)
    }

    /// Reads `TOOL CALL 5 Z S3000 F500 DL+0.1 DR-0.1` or `TOOL CALL "MILL" Z`.
    pub(super) fn klartext_tool_call(
        &mut self,
        code: &[u8],
        (at, end): (usize, usize),
        line: &mut Line,
    ) -> Result<(), Refusal> {
        self.push_klartext(KlartextStatement::ToolCall, line.columns(at, end));
        let mut next = self.klartext_tool(code, skip_blanks(code, end), line)?;
        const WORDS: &[(&str, u8)] = &[
            ("DL", address::LENGTH_DIFFERENCE),
            ("DR2", 0),
            ("DR", address::RADIUS_DIFFERENCE),
            ("FU", address::FEED_PER_REVOLUTION),
            ("FZ", address::FEED_PER_TOOTH),
            ("F", b'F'),
            ("S", b'S'),
        ];
        loop {
            next = skip_blanks(code, next);
            let Some(rest) = code.get(next..).filter(|rest| !rest.is_empty()) else { return Ok(()) };
            let starts = |word: &str| {
                rest.get(..word.len()).is_some_and(|head| head.eq_ignore_ascii_case(word.as_bytes()))
            };
            if let Some((word, letter)) = WORDS.iter().find(|(word, _)| starts(word)) {
                let past = next + word.len();
                next = match *letter {
                    0 => self.klartext_unneeded(code, past, line)?,
                    letter => self.klartext_value(code, (next, past), letter, Reference::Modal, line)?,
                };
                continue;
            }
            match rest[0].to_ascii_uppercase() {
                letter @ b'X'..=b'Z' => {
                    let axis = f64::from(letter - b'X');
                    self.push_word(address::TOOL_AXIS, axis, line.columns(next, next + 1));
                    next += 1;
                }
                b'U'..=b'W' => next += 1,
                _ if starts("VC") => next = self.klartext_unneeded(code, next + 2, line)?,
                // Further settings (spindle of turning, limits) change neither path nor time.
                _ if rest[0].is_ascii_alphabetic() => {
                    next += rest.iter().take_while(|byte| **byte != b' ').count();
                }
                _ => return Err((Unread::Text { text: excerpt(rest) }, line.columns(next, next + 1))),
            }
        }
    }

    /// Reads the number or the name of a tool at `at`, if there is one; returns its end.
    pub(super) fn klartext_tool(
        &mut self,
        code: &[u8],
        at: usize,
        line: &mut Line,
    ) -> Result<usize, Refusal> {
        match code.get(at) {
            Some(b'"') => {
                let close = code[at + 1..].iter().position(|byte| *byte == b'"');
                let close = close.map_or(code.len(), |length| at + 1 + length);
                let index = self.text(String::from_utf8_lossy(&code[at + 1..close]).into_owned());
                self.name(index, false);
                self.push_word(address::TOOL_NAME, f64::from(index), line.columns(at, close));
                line.continuation += continuation(&code[at..close]);
                Ok((close + 1).min(code.len()))
            }
            Some(b'0'..=b'9' | b'+') => self.klartext_value(code, (at, at), b'T', Reference::Modal, line),
            Some(b'Q' | b'q') if klartext_number(&code[at..]).is_some() => {
                self.klartext_value(code, (at, at), b'T', Reference::Modal, line)
            }
            Some(b'Q' | b'q') => {
                let index = self.text(String::new());
                self.push_word(address::TOOL_NAME, f64::from(index), line.columns(at, at + 2));
                Ok(at + code[at..].iter().take_while(|byte| byte.is_ascii_alphanumeric()).count())
            }
            _ => Ok(at),
        }
    }

    /// Reads `TOOL DEF 5 L+10 R+5`.
    pub(super) fn klartext_tool_definition(
        &mut self,
        code: &[u8],
        (at, end): (usize, usize),
        line: &mut Line,
    ) -> Result<(), Refusal> {
        self.push_klartext(KlartextStatement::ToolDefinition, line.columns(at, end));
        let mut next = skip_blanks(code, end);
        if code.get(next) == Some(&b'"') {
            return Ok(());
        }
        if next < code.len() {
            next = self.klartext_value(code, (next, next), address::DEFINED_TOOL, Reference::Modal, line)?;
        }
        loop {
            next = skip_blanks(code, next);
            let letter = match code.get(next).map(u8::to_ascii_uppercase) {
                None => return Ok(()),
                Some(b'L') => address::TOOL_LENGTH,
                Some(b'R') => address::TOOL_RADIUS,
                Some(_) => {
                    let shown = excerpt(&code[next..]);
                    return Err((Unread::Text { text: shown }, line.columns(next, next + 1)));
                }
            };
            next = self.klartext_value(code, (next, next + 1), letter, Reference::Modal, line)?;
        }
    }
}

/// Returns `true` if `R` of a statement is a radius, even if it is 0, and not the end of compensation.
fn takes_radius(statement: KlartextStatement) -> bool {
    use KlartextStatement::*;
    matches!(
        statement,
        CircleByRadius
            | Rounding
            | Approach(ContourWay::Arc | ContourWay::ArcAndLine)
            | Departure(ContourWay::Arc | ContourWay::ArcAndLine)
    )
}

/// Returns the plain number at `start`: a sign, blanks, digits without blanks between them; `None` if there is
/// none.
pub(super) fn plain(code: &[u8], start: usize) -> Option<Number> {
    let at = skip_blanks(code, start);
    let is_signed = matches!(code.get(at), Some(b'+' | b'-'));
    let digits = skip_blanks(code, at + usize::from(is_signed));
    let length =
        code.get(digits..)?.iter().take_while(|byte| byte.is_ascii_digit() || **byte == b'.').count();
    let found = number(&code[..digits + length], at)?;
    (found.end == digits + length).then_some(found)
}

/// Returns `true` behind the R of `R0` without more digits.
fn is_no_compensation(code: &[u8], at: usize) -> bool {
    code.get(at) == Some(&b'0')
        && !code.get(at + 1).is_some_and(|byte| byte.is_ascii_digit() || *byte == b'.')
}

/// Returns the word of a path that `code` begins with, and its kind.
fn word_at(code: &[u8]) -> Option<&'static (&'static str, Kind)> {
    let begins = |word: &[u8]| code.get(..word.len()).is_some_and(|head| head.eq_ignore_ascii_case(word));
    WORDS.iter().find(|(word, _)| begins(word.as_bytes()))
}

/// Returns the text at `at` as messages name it.
pub(super) fn found_at(code: &[u8], at: usize) -> String {
    match code.get(at..) {
        Some(rest) if !rest.is_empty() => format!("`{}`", excerpt(&rest[..character_length(rest)])),
        _ => "the end of the line".to_string(),
    }
}
