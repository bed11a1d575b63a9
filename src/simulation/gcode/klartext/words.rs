//! The words of Klartext statements, and their values.

use crate::simulation::gcode::expression::{Notation, klartext_number};
use crate::simulation::gcode::klartext::begins;
use crate::simulation::gcode::klartext::names::{WORDS, Word as Kind, statement};
use crate::simulation::gcode::line::{Line, character_length, continuation, excerpt};
use crate::simulation::gcode::number::{Number, number, skip_blanks};
use crate::simulation::gcode::reader::{Reader, Refusal};
use crate::simulation::gcode::remark::Unread;
use crate::simulation::gcode::{Reference, Target, Word, address};

/// M functions whose further words are no words of the path.
const WITH_SETTINGS: &[f64] = &[112.0, 114.0, 118.0, 124.0, 150.0];

/// M functions whose F is not the feedrate of the path.
const WITH_FEED: &[f64] = &[103.0, 128.0, 140.0];

impl Reader<'_> {
    /// A statement with the words of a path.
    pub(super) fn klartext_path(
        &mut self,
        code: &[u8],
        (at, end): (usize, usize),
        name: &str,
        line: &mut Line,
    ) -> Result<(), Refusal> {
        self.push_word(address::STATEMENT, statement(name), line.columns(at, end.max(at + 1)));
        let takes_radius = matches!(name, "CR" | "RND") || name.ends_with("CT") && name != "CT";
        let takes_length = name == "CHF";
        let (mut next, mut has_radius, mut owns_feed) = (skip_blanks(code, end), !takes_radius, true);
        if takes_length
            && code
                .get(next)
                .is_some_and(|byte| !byte.is_ascii_alphabetic() || klartext_number(&code[next..]).is_some())
        {
            next = self.klartext_value(code, (next, next), address::CHAMFER_LEG, Reference::Modal, line)?;
        }
        if name == "RND" && code.get(next).is_some_and(|byte| byte.is_ascii_digit() || *byte == b'+') {
            next = self.klartext_value(code, (next, next), address::CIRCLE_RADIUS, Reference::Modal, line)?;
        }
        loop {
            next = skip_blanks(code, next);
            let Some(rest) = code.get(next..).filter(|rest| !rest.is_empty()) else { return Ok(()) };
            let found = WORDS.iter().find(|(word, _)| {
                rest.get(..word.len()).is_some_and(|head| head.eq_ignore_ascii_case(word.as_bytes()))
            });
            let Some((word, kind)) = found else {
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
                            return Err((
                                Unread::Expected { expected: "`+` or `-`", found: found_at(code, sign) },
                                columns,
                            ));
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
                Kind::Value(address::CIRCLE_RADIUS) if name == "CHF" => {
                    self.klartext_value(code, (next, past), address::CHAMFER_LEG, Reference::Modal, line)?
                }
                Kind::Value(b'F') if !owns_feed => {
                    owns_feed = true;
                    self.klartext_unneeded(code, past, line)?
                }
                Kind::Value(own) => {
                    has_radius |= own == address::CIRCLE_RADIUS;
                    if let (true, None) = (name.starts_with("TRANS MIRROR"), plain(code, past)) {
                        self.push_word(own, 1.0, columns);
                        past
                    } else {
                        self.klartext_value(code, (next, past), own, Reference::Modal, line)?
                    }
                }
                Kind::Increment(own) => {
                    self.klartext_value(code, (next, past), own, Reference::Incremental, line)?
                }
            };
            if let Some(word) = self.program.words.last().filter(|word| word.letter == b'M') {
                if WITH_SETTINGS.contains(&word.value) {
                    return Ok(());
                }
                owns_feed = !WITH_FEED.contains(&word.value);
            }
        }
    }

    /// Reads the value at `start` as a word that begins at `at`; returns where it ends.
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
        let target = Target::Word(self.program.words.len() as u32);
        let (end, columns) = self.formula(Notation::Klartext, code, (at, start), line, |expressions| {
            expressions.value()?;
            Ok(target)
        })?;
        self.program.words.push(Word {
            value: f64::NAN,
            columns: columns.into(),
            letter,
            has_point: false,
            reference,
        });
        Ok(end)
    }

    /// Passes over the value at `start`.
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

    /// `TOOL CALL 5 Z S3000 F500 DL+0.1 DR-0.1`, `TOOL CALL "MILL" Z`.
    pub(super) fn klartext_tool_call(
        &mut self,
        code: &[u8],
        (at, end): (usize, usize),
        line: &mut Line,
    ) -> Result<(), Refusal> {
        self.push_word(address::STATEMENT, statement("TOOL CALL"), line.columns(at, end));
        let mut next = skip_blanks(code, end);
        match code.get(next) {
            Some(b'"') => {
                let close = code[next + 1..].iter().position(|byte| *byte == b'"');
                let close = close.map_or(code.len(), |length| next + 1 + length);
                let index = self.text(String::from_utf8_lossy(&code[next + 1..close]).into_owned());
                self.name(index, false);
                self.push_word(address::TOOL_NAME, f64::from(index), line.columns(next, close));
                line.continuation += continuation(&code[next..close]);
                next = (close + 1).min(code.len());
            }
            Some(b'0'..=b'9' | b'+') => {
                next = self.klartext_value(code, (next, next), b'T', Reference::Modal, line)?
            }
            Some(b'Q' | b'q') if klartext_number(&code[next..]).is_some() => {
                next = self.klartext_value(code, (next, next), b'T', Reference::Modal, line)?;
            }
            Some(b'Q' | b'q') => {
                let index = self.text(String::new());
                self.push_word(address::TOOL_NAME, f64::from(index), line.columns(next, next + 2));
                next += code[next..].iter().take_while(|byte| byte.is_ascii_alphanumeric()).count();
            }
            _ => {}
        }
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
            if let Some((word, own)) = WORDS.iter().find(|(word, _)| starts(word)) {
                let past = next + word.len();
                next = match *own {
                    0 => self.klartext_unneeded(code, past, line)?,
                    own => self.klartext_value(code, (next, past), own, Reference::Modal, line)?,
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

    /// `TOOL DEF 5 L+10 R+5`.
    pub(super) fn klartext_tool_definition(
        &mut self,
        code: &[u8],
        (at, end): (usize, usize),
        line: &mut Line,
    ) -> Result<(), Refusal> {
        self.push_word(address::STATEMENT, statement("TOOL DEF"), line.columns(at, end));
        let mut next = skip_blanks(code, end);
        if code.get(next) == Some(&b'"') {
            return Ok(());
        }
        if next < code.len() {
            next = self.klartext_value(code, (next, next), address::ARGUMENT, Reference::Modal, line)?;
        }
        loop {
            next = skip_blanks(code, next);
            let own = match code.get(next).map(u8::to_ascii_uppercase) {
                None => return Ok(()),
                Some(b'L') => address::TOOL_LENGTH,
                Some(b'R') => address::TOOL_RADIUS,
                Some(_) => {
                    let shown = excerpt(&code[next..]);
                    return Err((Unread::Text { text: shown }, line.columns(next, next + 1)));
                }
            };
            next = self.klartext_value(code, (next, next + 1), own, Reference::Modal, line)?;
        }
    }
}

/// The plain number at `start`: a sign, blanks, digits without blanks between them.
pub(super) fn plain(code: &[u8], start: usize) -> Option<Number> {
    let at = skip_blanks(code, start);
    let is_signed = matches!(code.get(at), Some(b'+' | b'-'));
    let digits = skip_blanks(code, at + usize::from(is_signed));
    let length =
        code.get(digits..)?.iter().take_while(|byte| byte.is_ascii_digit() || **byte == b'.').count();
    let found = number(&code[..digits + length], at)?;
    (found.end == digits + length).then_some(found)
}

/// `R0`, and no more digits.
fn is_no_compensation(code: &[u8], at: usize) -> bool {
    code.get(at) == Some(&b'0')
        && !code.get(at + 1).is_some_and(|byte| byte.is_ascii_digit() || *byte == b'.')
}

/// What stands at `at`, to be said.
pub(super) fn found_at(code: &[u8], at: usize) -> String {
    match code.get(at..) {
        Some(rest) if !rest.is_empty() => format!("`{}`", excerpt(&rest[..character_length(rest)])),
        _ => "the end of the line".to_string(),
    }
}
