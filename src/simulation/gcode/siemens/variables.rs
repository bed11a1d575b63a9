//! Variables of a program: `DEF`, and arrays.
//!
//! ```text
//! DEF REAL A, B=2, C[3], D[2,4]=SET(1,2,3)       C[I]=5       D[0,I]=SET(1,2)     DEF INT E[9]=REP(7)
//! ```
//!
//! A variable belongs to the program, between two `%_N_` lines, that defines it. The elements of an array are
//! parameters beyond all R numbers. Each array has a row of [`ARRAY_STRIDE`] of them; the first index counts steps
//! of [`INDEX_STRIDE`]. A STRING has the number of its text as its value. Variables of the types AXIS, CHAR and
//! FRAME are ignored.

use crate::simulation::gcode::expression::{Expressions, Fault, Notation, identifier};
use crate::simulation::gcode::line::{Line, excerpt, semicolon};
use crate::simulation::gcode::number::{number, skip_blanks};
use crate::simulation::gcode::reader::{Reader, Refusal};
use crate::simulation::gcode::remark::Unread;
use crate::simulation::gcode::{Formula, Operator, Step, Target};

/// Number of the first parameter of arrays: beyond R numbers and arguments.
const FIRST_ARRAY: f64 = 3_100_000_000.0;

/// Number of parameters of an array.
const ARRAY_STRIDE: f64 = 10_000.0;

/// Number of parameters between two values of the first of two indices.
const INDEX_STRIDE: f64 = 100.0;

/// Most elements that REP assigns a value to.
const MAX_REPEATED: usize = 1000;

impl Expressions<'_> {
    /// Reads `[I]` or `[I,J]` behind the name of an array; the steps leave the number of its parameter.
    pub(in crate::simulation::gcode) fn element(&mut self, name: &[u8]) -> Result<(), Fault> {
        let array = self.names.index(String::from_utf8_lossy(name).to_ascii_lowercase() + "[]");
        self.steps.push(Step::Number(FIRST_ARRAY + ARRAY_STRIDE * f64::from(array)));
        self.expect(b'[')?;
        self.expression(0)?;
        if self.text.get(skip_blanks(self.text, self.at)) == Some(&b',') {
            self.expect(b',')?;
            self.steps.extend([Step::Number(INDEX_STRIDE), Step::Operator(Operator::Times)]);
            self.expression(0)?;
            self.steps.push(Step::Operator(Operator::Plus));
        }
        self.expect(b']')?;
        self.steps.push(Step::Operator(Operator::Plus));
        Ok(())
    }
}

impl Reader<'_> {
    /// Reads `DEF REAL A, B=2, C[3]` with the first values of the variables, by default 0 or the empty text;
    /// returns the end.
    pub(super) fn siemens_definition(
        &mut self,
        text: &[u8],
        at: usize,
        line: &mut Line,
    ) -> Result<usize, Refusal> {
        let mut next = skip_blanks(text, at);
        let mut length = identifier(&text[next..]);
        let mut kind = text[next..next + length].to_ascii_uppercase();
        while matches!(&kind[..], b"NCK" | b"CHAN" | b"SYNR" | b"SYNW" | b"SYNRW") {
            next = skip_blanks(text, next + length);
            length = identifier(&text[next..]);
            kind = text[next..next + length].to_ascii_uppercase();
        }
        let first_value = match &kind[..] {
            b"REAL" | b"INT" | b"BOOL" => Step::Number(0.0),
            b"STRING" => self.names.of_text(b""),
            _ => return Ok(semicolon(text, 0)),
        };
        next += length;
        if kind == b"STRING" && text.get(next) == Some(&b'[') {
            // The greatest length of its texts is in brackets.
            next = text[next..].iter().position(|byte| *byte == b']').map_or(text.len(), |to| next + to + 1);
        }
        loop {
            let start = skip_blanks(text, next);
            let length = identifier(&text[start..]);
            if length == 0 {
                let found = excerpt(&text[start..]);
                return Err((Unread::Expected { expected: "a name", found }, line.columns(start, start + 1)));
            }
            let end = start + length;
            let after = skip_blanks(text, end);
            let name = String::from_utf8_lossy(&text[start..end]).to_ascii_lowercase();
            next = match text.get(after) {
                Some(b'[') => {
                    self.names.define(name + "[]");
                    self.siemens_array(text, (start, end), after, line)?
                }
                Some(b'=') => {
                    self.names.define(name);
                    self.siemens_variable(text, (start, end), after + 1, line)?
                }
                _ => {
                    let index = self.names.define(name);
                    let first = self.program.steps.len() as u32;
                    self.program.steps.push(first_value);
                    let (block, columns) = (self.index(), line.columns(start, end));
                    let (target, steps) = (Target::Named(index), first..first + 1);
                    self.program.formulas.push(Formula { block, target, steps, columns });
                    end
                }
            };
            next = skip_blanks(text, next);
            if text.get(next) != Some(&b',') {
                return Ok(next);
            }
            next += 1;
        }
    }

    /// Reads an array from its `[` on, with the values of SET and REP; returns the end.
    fn siemens_array(
        &mut self,
        text: &[u8],
        (start, end): (usize, usize),
        open: usize,
        line: &mut Line,
    ) -> Result<usize, Refusal> {
        let close =
            text[open..].iter().position(|byte| *byte == b']').map_or(text.len(), |length| open + length);
        let sizes = text.get(open + 1..close).unwrap_or_default().split(|byte| *byte == b',');
        let sizes: Vec<usize> = sizes
            .map(|size| number(size, 0).map_or(1.0, |found| found.value.clamp(1.0, 1e4)) as usize)
            .collect();
        let equals = skip_blanks(text, (close + 1).min(text.len()));
        if text.get(equals) != Some(&b'=') {
            return Ok(equals);
        }
        let columns = sizes.get(1).copied().unwrap_or(usize::MAX);
        let array = self.names.index(String::from_utf8_lossy(&text[start..end]).to_ascii_lowercase() + "[]");
        let first = FIRST_ARRAY + ARRAY_STRIDE * f64::from(array);
        self.siemens_list(text, equals + 1, line, (first, columns, sizes.iter().product()))
    }

    /// Reads `SET(1,2,3)`, `(1,2,3)` or `REP(5)` into the parameters from `first` on; returns the end.
    fn siemens_list(
        &mut self,
        text: &[u8],
        at: usize,
        line: &mut Line,
        (first, columns, count): (f64, usize, usize),
    ) -> Result<usize, Refusal> {
        let start = skip_blanks(text, at);
        let word = &text[start..start + identifier(&text[start..])];
        let is_repeated = word.eq_ignore_ascii_case(b"REP");
        let element =
            |index: usize| first + INDEX_STRIDE * (index / columns) as f64 + (index % columns) as f64;
        let mut next = skip_blanks(text, start + word.len());
        let mut index = 0;
        if text.get(next) != Some(&b'(') {
            let found = excerpt(&text[next..]);
            return Err((Unread::Expected { expected: "`(`", found }, line.columns(next, next + 1)));
        }
        loop {
            next += 1;
            let value = skip_blanks(text, next);
            if !matches!(text.get(value), Some(b',' | b')')) {
                (next, _) = self.formula(Notation::Siemens, text, (value, value), line, |expressions| {
                    expressions.steps.push(Step::Number(element(index)));
                    expressions.expression(0)?;
                    Ok(Target::Numbered)
                })?;
                if is_repeated {
                    self.repeat_value(element, count.min(MAX_REPEATED));
                }
            } else {
                next = value;
            }
            index += 1;
            next = skip_blanks(text, next);
            match text.get(next) {
                Some(b',') => {}
                Some(b')') => return Ok(next + 1),
                _ => {
                    let found = excerpt(&text[next..]);
                    return Err((
                        Unread::Expected { expected: "`,` or `)`", found },
                        line.columns(next, next + 1),
                    ));
                }
            }
        }
    }

    /// Assigns the value of the first element to the others.
    fn repeat_value(&mut self, element: impl Fn(usize) -> f64, count: usize) {
        let (block, columns) =
            (self.index(), self.program.formulas.last().map_or((0, 0), |last| last.columns));
        for index in 1..count {
            let first = self.program.steps.len() as u32;
            self.program.steps.extend([
                Step::Number(element(index)),
                Step::Number(element(0)),
                Step::Numbered,
            ]);
            let steps = first..self.program.steps.len() as u32;
            self.program.formulas.push(Formula { block, target: Target::Numbered, steps, columns });
        }
    }
}
