//! Lines of ISO programs: words, assignments and comments.

mod o_word;
mod okuma;
mod macro_word;
mod plain;

use crate::simulation::gcode::expression::{Expressions, Notation, Place as Parameter};
use crate::simulation::gcode::iso::macro_word::Keyword;
use crate::simulation::gcode::line::{
    CommentEnd, Line, character_length, code_end, comment_end, continuation, excerpt, is_checksum,
};
use crate::simulation::gcode::number::{is_blank, number, skip_blanks};
use crate::simulation::gcode::reader::{Reader, Refusal};
use crate::simulation::gcode::remark::Unread;
use crate::simulation::gcode::{Action, Dialect, Place, Reference, Target, address};

/// Values of the M words that call or return.
const CALLING_M: &[f64] = &[97.0, 98.0, 99.0, 198.0];

/// Values of the G words that call or return.
const CALLING_G: &[f64] = &[65.0, 66.0, 66.1, 67.0];

/// Words of custom macros that print or name variables; no word on their lines moves the machine.
const OUTPUT: &[&[u8]] = &[b"POPEN", b"PCLOS", b"DPRNT", b"BPRNT", b"SETVN"];

impl Reader<'_> {
    /// Reads one line of an ISO program with more than plain words.
    pub(super) fn iso_line(&mut self, text: &[u8], line: &mut Line) -> Result<(), Refusal> {
        if self.is_command_of_sender(text) {
            return Ok(());
        }
        let mut at = 0;
        while let Some(&byte) = text.get(at) {
            match byte {
                b'a'..=b'z' | b'A'..=b'Z' => at = self.word(text, at, line)?,
                byte if is_blank(byte) => at += 1,
                b'(' => at = self.comment(text, at, line),
                b';' => {
                    if at + 1 < text.len() {
                        line.comment.get_or_insert((at + 1, text.len()));
                    }
                    break;
                }
                b':' if !line.begun => {
                    let found = number(text, at + 1);
                    self.program.is_tape = true;
                    line.begun = true;
                    at = found.map_or(at + 1, |number| number.end);
                    self.program_number(found.map_or(0.0, |number| number.value));
                }
                b'/' if !line.begun || self.program.dialect == Dialect::Iso => {
                    self.optional += usize::from(!line.is_optional);
                    line.is_optional = true;
                    if self.optional == 1 {
                        self.first_optional = self.line;
                    }
                    if self.options.block_delete {
                        break;
                    }
                    line.begun = true;
                    at += 1 + usize::from(text.get(at + 1).is_some_and(u8::is_ascii_digit));
                }
                b'*' if is_checksum(&text[at + 1..]) => break,
                b'#' | b'@' | b'^' | b',' => at = (self.read_more)(self, text, at, line)?,
                _ => {
                    let text = excerpt(&text[at..at + character_length(&text[at..])]);
                    return Err((Unread::Text { text }, line.columns(at, at + 1)));
                }
            }
        }
        self.program.is_tape |= line.has_o_word;
        if line.has_call_words {
            self.names_sequence = true;
            self.calls = true;
            self.act(Action::Words);
        }
        Ok(())
    }

    /// Returns `true` for `$H`, `$110=500` and `!` alone: lines to a grbl control or in the file of an Okuma
    /// control, which are not run.
    fn is_command_of_sender(&mut self, text: &[u8]) -> bool {
        let start = skip_blanks(text, 0);
        if !matches!(text.get(start), Some(b'$' | b'~' | b'!' | b'?')) {
            return false;
        }
        let end = code_end(text, start);
        let is_grbl = self.program.dialect == Dialect::Grbl;
        let is_immediate = is_grbl && matches!(text.get(start..end), Some(b"~" | b"!" | b"?"));
        let is_command = is_immediate || text.get(start) == Some(&b'$');
        if is_command && is_grbl {
            let place = Place { line: self.line, columns: Line::default().columns(start, end) };
            self.remarks.add(place, Unread::Command { text: excerpt(&text[start..end]) });
        }
        is_command && matches!(self.program.dialect, Dialect::Grbl | Dialect::Okuma)
    }

    /// Reads the word with its letter at `at`; returns its end.
    fn word(&mut self, text: &[u8], at: usize, line: &mut Line) -> Result<usize, Refusal> {
        let letter = text[at].to_ascii_uppercase();
        let Some(found) = number(text, at + 1) else {
            return (self.read_more)(self, text, at, line);
        };
        let next = skip_blanks(text, found.end);
        if matches!(text.get(next), Some(b'.' | b'+' | b'-')) {
            return Ok(self.leave_out(text, at, line, |text| Unread::MalformedNumber { text }));
        }
        if !found.value.is_finite() {
            return Ok(self.leave_out(text, at, line, |text| Unread::HugeNumber { text }));
        }
        match letter {
            b'N' => return Ok(found.end),
            b'O' => {
                if self.o_word_keyword(text, found.end).is_some() {
                    return (self.read_more)(self, text, at, line);
                }
                line.has_o_word = true;
                self.program_number(found.value);
            }
            _ => {
                let calls = if letter == b'M' { CALLING_M } else { CALLING_G };
                line.has_call_words |= matches!(letter, b'G' | b'M') && calls.contains(&found.value);
                self.push_number(letter, found.value, found.has_point, line.columns(at, found.end));
            }
        }
        line.begun = true;
        Ok(found.end)
    }

    /// Reads an item that is more than a letter with its number; returns its end.
    pub(super) fn more(&mut self, text: &[u8], at: usize, line: &mut Line) -> Result<usize, Refusal> {
        match text[at] {
            b'#' => self.assignment(text, at, line),
            b'@' => self.long_word(text, at, address::POLAR_RADIUS, line),
            b'^' => self.long_word(text, at, address::POLAR_ANGLE, line),
            b',' => self.comma_word(text, at, line),
            b'o' | b'O' if number(text, at + 1).is_some() => self.o_word(text, at, line),
            _ => self.word_without_number(text, at, line),
        }
    }

    /// Reads a letter that no number follows: an expression, a name, or a typing error; returns the end.
    fn word_without_number(&mut self, text: &[u8], at: usize, line: &mut Line) -> Result<usize, Refusal> {
        let letter = text[at].to_ascii_uppercase();
        let length = text[at..].iter().take_while(|byte| byte.is_ascii_alphabetic()).count();
        let signs = |byte: &u8| matches!(byte, b'.' | b'+' | b'-') || is_blank(*byte);
        let next = at + 1 + text[at + 1..].iter().take_while(|byte| signs(byte)).count();
        if letter == b'O' && matches!(text.get(next), Some(b'<' | b'[' | b'#')) {
            return self.o_word(text, at, line);
        }
        if self.program.dialect == Dialect::Okuma
            && let Some(end) = self.okuma_item(text, at, line)?
        {
            return Ok(end);
        }
        if let Some(keyword) = Keyword::of(&text[at..at + length]) {
            return self.macro_word(text, (at, at + length), keyword, line);
        }
        if OUTPUT.iter().any(|name| text[at..at + length].eq_ignore_ascii_case(name)) {
            return Ok(text.len());
        }
        if letter != b'N' && Expressions::begin_at(text, at + 1) {
            return self.word_with_formula(text, at, line);
        }
        if 1 < length {
            let (name, columns) = (&text[at..at + length], line.columns(at, at + length));
            return Err((Unread::Text { text: excerpt(name) }, columns));
        }
        if matches!(text.get(next), Some(b'#' | b'[' | b'=')) {
            let end = code_end(text, at);
            return Err((Unread::Text { text: excerpt(&text[at..end]) }, line.columns(at, end)));
        }
        if text.get(next).is_some_and(u8::is_ascii_digit) {
            return Ok(self.leave_out(text, at, line, |text| Unread::MalformedNumber { text }));
        }
        let end = at + text[at..next].trim_ascii_end().len();
        let remark = Unread::MissingNumber { letter: letter as char };
        self.remarks.add(Place { line: self.line, columns: line.columns(at, end) }, remark);
        Ok(end)
    }

    /// Reads `,R5` and `,C2`, which round and chamfer the next corner; returns the end.
    fn comma_word(&mut self, text: &[u8], at: usize, line: &mut Line) -> Result<usize, Refusal> {
        let next = skip_blanks(text, at + 1);
        match text.get(next).map(u8::to_ascii_uppercase) {
            Some(b'R') => self.long_word(text, next, address::ROUNDING, line),
            Some(b'C') => self.long_word(text, next, address::CHAMFER_LEG, line),
            _ => Err((Unread::Text { text: ",".to_string() }, line.columns(at, at + 1))),
        }
    }

    /// Reads the value behind the sign at `at` as a word of the longer `address`; returns its end.
    fn long_word(&mut self, text: &[u8], at: usize, address: u8, line: &mut Line) -> Result<usize, Refusal> {
        let (end, columns) = self.formula_of_word(Notation::Iso, text, (at, at + 1), line)?;
        self.push_word(address, f64::NAN, columns);
        Ok(end)
    }

    /// Reads the word with its letter at `at` and a formula as its value; returns its end.
    fn word_with_formula(&mut self, text: &[u8], at: usize, line: &mut Line) -> Result<usize, Refusal> {
        let (end, columns) = self.formula_of_word(Notation::Iso, text, (at, at + 1), line)?;
        self.push_computed(text[at].to_ascii_uppercase(), Reference::Modal, columns);
        Ok(end)
    }

    /// Reads the assignment with its `#` at `at`; returns its end.
    fn assignment(&mut self, text: &[u8], at: usize, line: &mut Line) -> Result<usize, Refusal> {
        let (end, _) = self.formula(Notation::Iso, text, (at, at), line, |expressions| {
            Ok(match expressions.assignment()? {
                Parameter::Numbered => Target::Numbered,
                Parameter::Named(name) => Target::Named(name),
            })
        })?;
        Ok(end)
    }

    /// Leaves out the letter at `at` with its malformed number; returns the end.
    fn leave_out(&mut self, text: &[u8], at: usize, line: &Line, remark: fn(String) -> Unread) -> usize {
        let belongs = |byte: &u8| matches!(byte, b'0'..=b'9' | b'.' | b'+' | b'-') || is_blank(*byte);
        let length = text[at + 1..].iter().take_while(|byte| belongs(byte)).count();
        let end = at + 1 + text[at + 1..at + 1 + length].trim_ascii_end().len();
        let place = Place { line: self.line, columns: line.columns(at, end) };
        self.remarks.add(place, remark(excerpt(&text[at..end])));
        end
    }

    /// Skips the comment that opens at `at`; returns its end.
    fn comment(&mut self, text: &[u8], at: usize, line: &mut Line) -> usize {
        let end = match comment_end(&text[at..], line.is_unbalanced) {
            CommentEnd::Matching(length) => at + length,
            CommentEnd::First(length) => {
                line.is_unbalanced = true;
                at + length
            }
            CommentEnd::Missing => text.len(),
        };
        if at + 1 < end {
            let inner = if text[end - 1] == b')' { end - 1 } else { end };
            line.comment.get_or_insert((at + 1, inner.max(at + 1)));
        }
        let (first, _) = line.columns(at, at);
        line.continuation += continuation(&text[at..end]);
        if text[end - 1] != b')' {
            let (past, _) = line.columns(end, end);
            self.remarks.add(Place { line: self.line, columns: (first, past) }, Unread::OpenComment);
        }
        end
    }
}
