//! Lines of SINUMERIK programs.
//!
//! ```text
//! line       = [ "/" ] [ N number ] [ label ":" ] { item } [ ";" comment ]
//! item       = word | assignment | statement | flow
//! word       = letter number  |  address "=" value
//! value      = expression  |  ( "AC" | "IC" | "DC" | "ACP" | "ACN" ) "(" expression ")"  |  text
//! assignment = ( "R" number | name ) "=" expression
//! statement  = keyword [ "(" [ value ] { "," [ value ] } ")" ]
//! ```
//!
//! A statement (`SUPA`, `CYCLE81(10, 0, 2)`, `TRANS`) becomes a [`Statement`](crate::simulation::gcode::Statement) with
//! its arguments. `MCALL` before it is a separate statement. Any other name calls a subprogram. `DEF` assigns a
//! value to a variable; variables of the types AXIS and FRAME are ignored.
//!
//! Source: SINUMERIK 840D sl, Programming Manual Fundamentals and Job Planning, 2013.

mod calls;
mod flow;
mod frames;
mod keywords;
mod names;
mod statement;
mod values;
mod variables;

pub use keywords::SiemensKeyword;
pub use statement::{
    DrillingCycle, DrillingKind, FrameChange, HolePattern, PatternShape, SiemensStatement, ThreadPitch,
    Unmodelled,
};

use crate::simulation::gcode::expression::{Notation, identifier};
use crate::simulation::gcode::line::{Line, character_length, excerpt};
use crate::simulation::gcode::number::{is_blank, number, skip_blanks};
use crate::simulation::gcode::reader::{MAX_COMMENTS, Reader, Refusal};
use crate::simulation::gcode::remark::Unread;
use crate::simulation::gcode::siemens::keywords::{keyword, known};
use crate::simulation::gcode::siemens::names::IGNORED;
use crate::simulation::gcode::{Action, Comment, LabelKind, Target};

impl Reader<'_> {
    /// Reads one line of a SINUMERIK program.
    pub(super) fn siemens_line(&mut self, text: &[u8], line: &mut Line) -> Result<(), Refusal> {
        if text.trim_ascii_start().starts_with(b"%") {
            self.siemens_program(text.trim_ascii());
            return Ok(());
        }
        let mut at = 0;
        while let Some(&byte) = text.get(at) {
            match byte {
                byte if is_blank(byte) => at += 1,
                b';' => {
                    if at + 1 < text.len() && !text[at..].starts_with(b";$PATH=") {
                        line.comment.get_or_insert((at + 1, text.len()));
                    }
                    break;
                }
                b'/' if !line.begun => {
                    self.optional += 1;
                    if self.optional == 1 {
                        self.first_optional = self.line;
                    }
                    if self.options.block_delete {
                        break;
                    }
                    at += 1 + usize::from(text.get(at + 1).is_some_and(u8::is_ascii_digit));
                }
                b':' if !line.begun => at = number(text, at + 1).map_or(at + 1, |found| found.end),
                b'a'..=b'z' | b'A'..=b'Z' | b'_' | b'$' => at = self.siemens_item(text, at, line)?,
                _ => {
                    let shown = excerpt(&text[at..at + character_length(&text[at..])]);
                    return Err((Unread::Text { text: shown }, line.columns(at, at + 1)));
                }
            }
        }
        Ok(())
    }

    /// Begins another program at `%_N_BORE_SPF`.
    fn siemens_program(&mut self, text: &[u8]) {
        let name = text.strip_prefix(b"%_N_").unwrap_or(text.strip_prefix(b"%").unwrap_or(text));
        let length = identifier(name);
        let name = String::from_utf8_lossy(&name[..length]).to_ascii_lowercase();
        let name = name.strip_suffix("_spf").or(name.strip_suffix("_mpf")).unwrap_or(&name);
        if 0 < self.index() {
            self.act(Action::Border);
            self.end_block();
        }
        self.names.next_program();
        self.siemens_label(name.as_bytes());
    }

    /// Labels the next block by a name; `L100` is also a number.
    fn siemens_label(&mut self, name: &[u8]) {
        let lower = String::from_utf8_lossy(name).to_ascii_lowercase();
        if let Some(number) = lower.strip_prefix('l').and_then(|digits| digits.parse().ok()) {
            self.label(LabelKind::Numbered, number);
        }
        let id = self.names.index(lower);
        self.label(LabelKind::Named, id);
    }

    /// Reads the item that begins with a letter at `at`; returns its end.
    fn siemens_item(&mut self, text: &[u8], at: usize, line: &mut Line) -> Result<usize, Refusal> {
        if is_run(&text[at..]) {
            return self.siemens_word(text, at, line);
        }
        let length = identifier(&text[at..]);
        let end = at + length;
        let name = &text[at..end];
        let next = skip_blanks(text, end);
        let is_assigned = text.get(next) == Some(&b'=') && text.get(next + 1) != Some(&b'=');
        if !line.begun && text.get(end) == Some(&b':') && text.get(end + 1) != Some(&b'=') {
            self.siemens_label(name);
            if matches!(text.get(skip_blanks(text, end + 1)), None | Some(b';')) {
                // A label alone is a separate block, which REPEAT can end with.
                self.push_statement(known("SBLOF"), line.columns(at, end + 1));
            }
            return Ok(end + 1);
        }
        // `S1=5` and `R1` are not words of a letter and a number.
        let digits = name[1..].iter().take_while(|byte| byte.is_ascii_digit()).count();
        let is_alone = 1 + digits == length;
        let is_word = name[0].is_ascii_alphabetic() && (0 < digits || is_alone);
        let is_other = is_alone && (is_assigned || text.get(end) == Some(&b'['));
        if is_word && !is_other && !name[0].eq_ignore_ascii_case(&b'R') {
            return self.siemens_word(text, at, line);
        }
        line.begun = true;
        if is_assigned {
            return self.siemens_assignment(text, (at, end), next + 1, line);
        }
        if text.get(end) == Some(&b'[') {
            return self.siemens_indexed(text, (at, end), line);
        }
        if let Some(end) = self.siemens_flow(text, (at, end), line)? {
            return Ok(end);
        }
        self.siemens_statement(text, (at, end), line)
    }

    /// Reads a letter and its number, such as `G1`, `X-10.5` or `L100`; returns the end.
    fn siemens_word(&mut self, text: &[u8], at: usize, line: &mut Line) -> Result<usize, Refusal> {
        let letter = text[at].to_ascii_uppercase();
        let Some(found) = number(text, at + 1) else {
            let columns = line.columns(at, at + 1);
            if letter == b'R' || identifier(&text[at..]) == 1 && matches!(text.get(at + 1), Some(b'(' | b'['))
            {
                return Err((Unread::Text { text: excerpt(&text[at..]) }, columns));
            }
            self.remarks.add(
                crate::simulation::gcode::Place { line: self.line, columns },
                Unread::MissingNumber { letter: char::from(letter) },
            );
            return Ok(at + 1);
        };
        let (value, end) = exponent(text, found.value, found.end);
        let columns = line.columns(at, end);
        // Exponents are written EX: `X1E3` would be X1 and an axis E.
        let has_plain_exponent = text.get(end).is_some_and(|byte| byte.eq_ignore_ascii_case(&b'E'))
            && text.get(end + 1).is_some_and(|byte| byte.is_ascii_digit() || matches!(byte, b'+' | b'-'));
        if has_plain_exponent {
            return Err((Unread::Text { text: excerpt(&text[at..]) }, columns));
        }
        if !value.is_finite() {
            return Err((Unread::HugeNumber { text: excerpt(&text[at..end]) }, columns));
        }
        match letter {
            b'N' if !line.begun => return Ok(end),
            b'L' => {
                line.begun = true;
                return self.siemens_call_by_number(text, value, end, line);
            }
            b'M' if value == 17.0 => {
                self.act(Action::Return);
            }
            _ => self.push_number(letter, value, found.has_point, columns),
        }
        line.begun = true;
        Ok(end)
    }

    /// Reads a keyword with its arguments, or the call of a subprogram; returns the end.
    fn siemens_statement(
        &mut self,
        text: &[u8],
        (at, end): (usize, usize),
        line: &mut Line,
    ) -> Result<usize, Refusal> {
        let name = text[at..end].to_ascii_uppercase();
        let columns = line.columns(at, end);
        let open = skip_blanks(text, end);
        let has_arguments = text.get(open) == Some(&b'(');
        if IGNORED.iter().any(|known| known.as_bytes() == name) {
            return Ok(if has_arguments { closing(text, open) } else { end });
        }
        let Some(keyword) = keyword(&name) else {
            return self.siemens_call(text, (at, end), line);
        };
        self.push_statement(keyword, columns);
        if !has_arguments {
            return Ok(end);
        }
        let mut argument = 0;
        let mut at = open + 1;
        loop {
            at = skip_blanks(text, at);
            match text.get(at) {
                None => {
                    return Err((
                        Unread::Expected { expected: "`)`", found: "the end of the line".into() },
                        columns,
                    ));
                }
                Some(b')') => return Ok(at + 1),
                Some(b',') => {
                    argument += 1;
                    at += 1;
                }
                Some(b'"') => {
                    let end = quoted(text, at);
                    let index =
                        self.text(String::from_utf8_lossy(&text[at + 1..end.max(at + 2) - 1]).into_owned());
                    self.siemens_argument(argument, f64::from(index));
                    if name == b"MSG" {
                        self.name(index, true);
                    }
                    at = end;
                }
                Some(_) => {
                    let target = Target::StatementArgument(self.program.arguments.len() as u32);
                    let (end, _) = self.formula(Notation::Siemens, text, (at, at), line, |expressions| {
                        expressions.expression(0)?;
                        Ok(target)
                    })?;
                    self.siemens_argument(argument, f64::NAN);
                    at = end;
                    if !matches!(text.get(skip_blanks(text, at)), Some(b',' | b')')) {
                        let found = excerpt(&text[at..]);
                        return Err((
                            Unread::Expected { expected: "`,` or `)`", found },
                            line.columns(at, at + 1),
                        ));
                    }
                }
            }
        }
    }

    /// Keeps a text as the name of an operation or of a tool.
    pub(super) fn name(&mut self, index: u32, is_alone: bool) {
        let text = self.program.texts.get(index as usize).cloned().unwrap_or_default();
        if self.program.comments.len() < MAX_COMMENTS && !text.trim().is_empty() {
            self.program.comments.push(Comment {
                line: self.line,
                text: text.chars().take(80).collect(),
                is_alone,
            });
        }
    }

    /// Adds an argument to the statement being read; arguments beyond the most are dropped with their formulas.
    fn siemens_argument(&mut self, position: usize, value: f64) {
        match u8::try_from(position) {
            Ok(position @ ..MAX_ARGUMENTS) => self.push_argument(position, value),
            _ => {
                let target = Target::StatementArgument(self.program.arguments.len() as u32);
                self.program.formulas.pop_if(|formula| formula.target == target);
            }
        }
    }
}

/// Most arguments of a statement.
const MAX_ARGUMENTS: u8 = 63;

/// Returns the end of the text that opens at `at`, past its closing quotation mark.
fn quoted(text: &[u8], at: usize) -> usize {
    text[at + 1..].iter().position(|byte| *byte == b'"').map_or(text.len(), |length| at + length + 2)
}

/// Returns the end of the parentheses that open at `at`, past the closing one.
fn closing(text: &[u8], at: usize) -> usize {
    let mut depth = 0;
    for (index, byte) in text.iter().enumerate().skip(at) {
        match byte {
            b'(' => depth += 1,
            b')' if depth == 1 => return index + 1,
            b')' => depth -= 1,
            b';' => return index,
            _ => {}
        }
    }
    text.len()
}

/// Returns a value with its exponent as in `1.5EX-3`, if there is one, and its end.
fn exponent(text: &[u8], value: f64, end: usize) -> (f64, usize) {
    let is_exponent = text.get(end..end + 2).is_some_and(|ex| ex.eq_ignore_ascii_case(b"EX"));
    match number(text, end + 2).filter(|_| is_exponent) {
        Some(found) if found.value.abs() <= 300.0 => (value * 10f64.powf(found.value), found.end),
        _ => (value, end),
    }
}

/// Returns `true` for words without blanks between them (`G1X10`): names begin with two letters, so this is not a
/// name.
fn is_run(text: &[u8]) -> bool {
    let digits = text[1..].iter().take_while(|byte| byte.is_ascii_digit()).count();
    let rest = &text[1 + digits..];
    let is_exponent = rest.len() > 1 && rest[..2].eq_ignore_ascii_case(b"EX");
    text[0].is_ascii_alphabetic()
        && !text[0].eq_ignore_ascii_case(&b'R')
        && 0 < digits
        && rest.first().is_some_and(u8::is_ascii_alphabetic)
        && !is_exponent
}
