//! Words and variables with `=`.
//!
//! ```text
//! assignment = ( letter [ number ] | address ) "=" value   |   ( "R" number | name ) "=" expression
//!            | ( "R" | name ) "[" expression { "," expression } "]" "=" expression
//!            | "PO[" letter "]=" ( expression | "(" expression { "," expression } ")" )
//! ```
//!
//! An address without a model (`POS[A]=`, `OFFN=`, `A3=`) becomes a statement; a name that is not an address is a
//! variable.

use crate::simulation::gcode::expression::{Notation, identifier};
use crate::simulation::gcode::line::{Line, excerpt};
use crate::simulation::gcode::number::skip_blanks;
use crate::simulation::gcode::reader::{Reader, Refusal};
use crate::simulation::gcode::remark::Unread;
use crate::simulation::gcode::siemens::keywords::known;
use crate::simulation::gcode::siemens::names::{ADDRESSES, IGNORED, named_word};
use crate::simulation::gcode::siemens::{closing, quoted};
use crate::simulation::gcode::{Reference, Step, Target, address};

impl Reader<'_> {
    /// Reads `X=…`, `CR=…`, `R1=…`, `_DEPTH=…`, `T="MILL"` or `S1=…`; returns its end.
    pub(super) fn siemens_assignment(
        &mut self,
        text: &[u8],
        (at, end): (usize, usize),
        value: usize,
        line: &mut Line,
    ) -> Result<usize, Refusal> {
        let name = text[at..end].to_ascii_uppercase();
        match &name[..] {
            b"$P_PFRAME" => return self.siemens_frame_value(text, value, line),
            name if FRAMES.contains(&name) => return Ok(self.siemens_other_frame(text, at, line)),
            _ => {}
        }
        let address = match &name[..] {
            // `$` and `_` are names.
            [letter] if letter.is_ascii_alphabetic() => Some(*letter),
            // The number of a spindle, or of an axis.
            [letter @ (b'S' | b'M' | b'T'), digits @ ..] if digits.iter().all(u8::is_ascii_digit) => {
                Some(*letter)
            }
            [letter @ (b'A'..=b'C' | b'X'..=b'Z'), b'1'] => Some(*letter),
            _ => ADDRESSES.iter().find(|(known, _)| known.as_bytes() == name).map(|(_, address)| *address),
        };
        let start = skip_blanks(text, value);
        if text.get(start) == Some(&b'"') && address.is_some() {
            let end = quoted(text, start);
            let index =
                self.text(String::from_utf8_lossy(&text[start + 1..end.max(start + 2) - 1]).into_owned());
            let columns = line.columns(at, end);
            if address == Some(b'T') {
                self.name(index, false);
                self.push_word(address::TOOL_NAME, f64::from(index), columns);
            }
            return Ok(end);
        }
        let Some(address) = address else {
            let keyword = named_word(&name).filter(|_| !self.names.is_defined(&lower(&name)));
            let Some(keyword) = keyword else { return self.siemens_variable(text, (at, end), value, line) };
            self.push_statement(keyword, line.columns(at, end));
            return self.siemens_unused_value(text, value, line);
        };
        let (reference, start) = reference(text, start);
        let (end, columns) = self.formula_of_word(Notation::Siemens, text, (at, start), line)?;
        self.push_computed(address, reference, columns);
        if address == b'M' {
            line.has_call_words = false;
        }
        Ok(end)
    }

    /// Reads the assignment of an R parameter or a variable; returns its end.
    pub(super) fn siemens_variable(
        &mut self,
        text: &[u8],
        (at, end): (usize, usize),
        value: usize,
        line: &mut Line,
    ) -> Result<usize, Refusal> {
        let name = &text[at..end];
        let digits = &name[1..];
        let number = std::str::from_utf8(digits).ok().and_then(|digits| digits.parse::<u32>().ok());
        let is_parameter = name[0].eq_ignore_ascii_case(&b'R') && !digits.is_empty() && number.is_some();
        if is_parameter {
            self.program.steps.push(Step::Number(f64::from(number.unwrap_or(0))));
        }
        let index = if is_parameter { 0 } else { self.names.index(lower(name)) };
        let first_step = self.program.steps.len() - usize::from(is_parameter);
        let outcome = self.formula(Notation::Siemens, text, (at, value), line, |expressions| {
            expressions.expression(0)?;
            Ok(if is_parameter { Target::Numbered } else { Target::Named(index) })
        });
        let (end, _) = outcome?;
        if let Some(formula) = self.program.formulas.last_mut() {
            formula.steps.start = first_step as u32;
        }
        Ok(end)
    }

    /// Reads `R[R1+1]=…`, `_LIST[2]=…` or `$P_UIFR[1,X,TR]=…`; returns its end.
    pub(super) fn siemens_indexed(
        &mut self,
        text: &[u8],
        (at, end): (usize, usize),
        line: &mut Line,
    ) -> Result<usize, Refusal> {
        let name = &text[at..end];
        let close =
            text[end..].iter().position(|byte| *byte == b']').map_or(text.len(), |length| end + length + 1);
        let equals = skip_blanks(text, close);
        let columns = line.columns(at, close);
        if text.get(equals) != Some(&b'=') {
            // Settings of an axis such as ACC[X] or FGREF[A].
            return self.siemens_setting(name, columns, close);
        }
        if name.eq_ignore_ascii_case(b"R") {
            let (end, _) = self.formula(Notation::Siemens, text, (at, end + 1), line, |expressions| {
                expressions.expression(0)?;
                expressions.expect(b']')?;
                expressions.expect(b'=')?;
                expressions.expression(0)?;
                Ok(Target::Numbered)
            })?;
            return Ok(end);
        }
        if IGNORED.iter().any(|known| name.eq_ignore_ascii_case(known.as_bytes())) {
            return self.siemens_unused_value(text, equals + 1, line);
        }
        let name = name.to_ascii_uppercase();
        if let Some(keyword) = named_word(&name) {
            self.push_statement(keyword, columns);
            return self.siemens_unused_value(text, equals + 1, line);
        }
        if name == b"SPOS" {
            let (_, start) = reference(text, equals + 1);
            let (end, columns) = self.formula_of_word(Notation::Siemens, text, (at, start), line)?;
            self.push_word(address::SPINDLE_POSITION, f64::NAN, columns);
            return Ok(end);
        }
        if name == b"PO" {
            return self.siemens_polynomial(text, (at, end, close, equals), line);
        }
        if name[0] == b'$' {
            if FRAMES.iter().any(|frame| name.starts_with(frame)) {
                if !text[end..close].contains(&b',') {
                    return Ok(self.siemens_other_frame(text, at, line));
                }
                self.push_statement(known("$P_UIFR"), columns);
            }
            let index = self.names.index(lower(&text[at..close]));
            let (end, _) = self.formula(Notation::Siemens, text, (at, equals + 1), line, |expressions| {
                expressions.expression(0)?;
                Ok(Target::Named(index))
            })?;
            return Ok(end);
        }
        let (end, _) = self.formula(Notation::Siemens, text, (at, end), line, |expressions| {
            expressions.element(&name)?;
            expressions.expect(b'=')?;
            expressions.expression(0)?;
            Ok(Target::Numbered)
        })?;
        Ok(end)
    }

    /// Reads `PO[X]=(10, 0.2, 0.1)` as a word of the axis with the end of the polynomial; returns its end.
    fn siemens_polynomial(
        &mut self,
        text: &[u8],
        (at, open, close, equals): (usize, usize, usize, usize),
        line: &mut Line,
    ) -> Result<usize, Refusal> {
        let value = skip_blanks(text, equals + 1);
        let has_list = text.get(value) == Some(&b'(');
        let axis = text.get(open + 1..close.saturating_sub(1)).unwrap_or_default().trim_ascii();
        let [letter] = axis else {
            return Err((Unread::Text { text: excerpt(&text[at..]) }, line.columns(at, close)));
        };
        let letter = letter.to_ascii_uppercase();
        let start = value + usize::from(has_list);
        let (end, columns) = self.formula_of_word(Notation::Siemens, text, (at, start), line)?;
        if !letter.is_ascii_uppercase() {
            return Err((Unread::Text { text: excerpt(&text[at..]) }, line.columns(at, close)));
        }
        self.push_word(letter, f64::NAN, columns);
        Ok(if has_list { closing(text, value) } else { end })
    }

    /// Reads a value that has no effect; returns its end.
    fn siemens_unused_value(&mut self, text: &[u8], value: usize, line: &mut Line) -> Result<usize, Refusal> {
        let (_, start) = reference(text, skip_blanks(text, value));
        let (end, _) = self.formula(Notation::Siemens, text, (value, start), line, |expressions| {
            expressions.expression(0)?;
            Ok(Target::Result)
        })?;
        Ok(end)
    }

    /// Reads a setting without a value, such as `ACC[X]`; returns its end.
    fn siemens_setting(&mut self, name: &[u8], columns: (u32, u32), end: usize) -> Result<usize, Refusal> {
        if IGNORED.iter().any(|known| name.eq_ignore_ascii_case(known.as_bytes())) {
            return Ok(end);
        }
        Err((Unread::Text { text: excerpt(name) }, columns))
    }
}

/// System variables that are frames.
const FRAMES: [&[u8]; 5] = [b"$P_UIFR", b"$P_PFRAME", b"$P_IFRAME", b"$P_BFRAME", b"$P_CHBFR"];

/// Returns a name in lower case, without white space.
fn lower(name: &[u8]) -> String {
    String::from_utf8_lossy(name)
        .chars()
        .filter(|c| !c.is_whitespace())
        .collect::<String>()
        .to_ascii_lowercase()
}

/// Returns the reference point by `AC(`, `IC(` and the like before a value, and the start of the value.
fn reference(text: &[u8], at: usize) -> (Reference, usize) {
    let length = identifier(&text[at..]);
    if text.get(at + length) != Some(&b'(') {
        return (Reference::Modal, at);
    }
    let reference = match text[at..at + length].to_ascii_uppercase().as_slice() {
        b"AC" => Reference::Absolute,
        b"DC" => Reference::Shortest,
        b"ACP" => Reference::Onward,
        b"ACN" => Reference::Backward,
        b"IC" => Reference::Incremental,
        _ => return (Reference::Modal, at),
    };
    (reference, at + length)
}
