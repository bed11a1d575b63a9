//! Calls of subprograms.
//!
//! ```text
//! L100 P3     NAME     NAME(1, 2)     CALL "NAME"     EXTCALL "NAME.SPF"     PROC NAME(REAL A, INT B=1)
//! ```
//!
//! Arguments are passed in parameters beyond all R numbers, together with a bit set of the given ones; `PROC`
//! assigns them, or their defaults, to its own names:
//!
//! ```text
//! a = g argument + (1 - g) default,  g = (given DIV 2^k) MOD 2
//! ```
//!
//! A program called by its file name is searched in this file. `MCALL` of a subprogram is not run.

use crate::simulation::gcode::expression::{Notation, identifier};
use crate::simulation::gcode::line::{Line, excerpt, semicolon};
use crate::simulation::gcode::number::skip_blanks;
use crate::simulation::gcode::reader::{Reader, Refusal};
use crate::simulation::gcode::remark::Unread;
use crate::simulation::gcode::{
    Action, Columns, Destination, Direction, Formula, Keyword, Label, LabelKind, Operator, Statement, Step,
    Target,
};

/// Number of the parameter with the bit set of the arguments given in the last call.
const GIVEN_ARGUMENTS: u32 = 3_000_000_001;

/// Number of the parameter with the first argument of a call: beyond all R numbers.
const FIRST_ARGUMENT: u32 = 3_000_000_002;

/// Most arguments of a PROC.
const MAX_ARGUMENTS: usize = 50;

impl Reader<'_> {
    /// Reads `L100 P3`; returns its end.
    pub(super) fn siemens_call_by_number(
        &mut self,
        text: &[u8],
        value: f64,
        end: usize,
        line: &mut Line,
    ) -> Result<usize, Refusal> {
        self.refuse_modal_call(format!("L{value}").as_bytes(), line.columns(end - 1, end))?;
        let end = self.siemens_times(text, end, line)?;
        let label = Label { kind: LabelKind::Numbered, id: value.abs().min(1e9) as u32 };
        let to = Destination::Label(label, Direction::Either);
        self.act(Action::Call { to, has_own_parameters: false });
        Ok(end)
    }

    /// Reads `P3` or `P=3` after a call; returns its end.
    fn siemens_times(&mut self, text: &[u8], end: usize, line: &mut Line) -> Result<usize, Refusal> {
        let start = skip_blanks(text, end);
        if !text.get(start).is_some_and(|byte| byte.eq_ignore_ascii_case(&b'P')) {
            return Ok(end);
        }
        let next = skip_blanks(text, start + 1);
        match text.get(next) {
            Some(b'=') => self.siemens_value(text, next + 1, line, Target::Count),
            Some(byte) if byte.is_ascii_digit() => self.siemens_value(text, next, line, Target::Count),
            _ => Ok(end),
        }
    }

    /// Calls a subprogram by its name.
    fn siemens_call_by_name(&mut self, name: &[u8]) {
        let to = Destination::Label(self.siemens_named_label(name), Direction::Either);
        self.act(Action::Call { to, has_own_parameters: false });
    }

    /// Reads `NAME` or `NAME(1, R2)`; returns its end.
    pub(super) fn siemens_call(
        &mut self,
        text: &[u8],
        (at, end): (usize, usize),
        line: &mut Line,
    ) -> Result<usize, Refusal> {
        let open = skip_blanks(text, end);
        // Columns before a text are computed before its bytes are counted.
        let (called, opened) = (line.columns(at, end), line.columns(open, open + 1));
        self.refuse_modal_call(&text[at..end], called)?;
        let (mut next, mut given) = (end, 0_u64);
        if text.get(open) == Some(&b'(') {
            next = open + 1;
            let mut argument = 0;
            loop {
                next = skip_blanks(text, next);
                match text.get(next) {
                    None => {
                        let found = "the end of the line".to_string();
                        return Err((Unread::Expected { expected: "`)`", found }, opened));
                    }
                    Some(b')') => break,
                    Some(b',') => {
                        argument += 1;
                        next += 1;
                    }
                    Some(_) => {
                        given |= 1_u64.checked_shl(argument).unwrap_or(0);
                        let number = FIRST_ARGUMENT + argument;
                        (next, _) =
                            self.formula(Notation::Siemens, text, (next, next), line, |expressions| {
                                expressions.steps.push(Step::Number(f64::from(number)));
                                expressions.expression(0)?;
                                Ok(Target::Numbered)
                            })?;
                    }
                }
            }
            next += 1;
        }
        self.assign_number(GIVEN_ARGUMENTS, given as f64, called);
        let next = self.siemens_times(text, next, line)?;
        self.siemens_call_by_name(&text[at..end]);
        Ok(next)
    }

    /// Reads `CALL "NAME"`, `EXTCALL "DIR/NAME.SPF"`, `EXTCALL("NAME")` or `CALL BLOCK A TO B`; returns its end.
    pub(super) fn siemens_call_by_text(
        &mut self,
        text: &[u8],
        at: usize,
        line: &mut Line,
    ) -> Result<usize, Refusal> {
        let start = skip_blanks(text, at);
        let word = &text[start..start + identifier(&text[start..])];
        if word.eq_ignore_ascii_case(b"BLOCK") {
            return self.siemens_call_section(text, start + word.len(), line);
        }
        let open = start + usize::from(text.get(start) == Some(&b'('));
        let open = skip_blanks(text, open);
        let open = open + usize::from(text.get(open) == Some(&b'"'));
        let past = text[open..].iter().position(|byte| matches!(byte, b'"' | b';' | b')'));
        let name = &text[open..past.map_or(text.len(), |length| open + length)];
        let file = name.rsplit(|byte| matches!(byte, b'/' | b'\\')).next().unwrap_or_default().trim_ascii();
        let file = file.strip_prefix(b"_N_").unwrap_or(file);
        let length = file.iter().position(|byte| *byte == b'.').unwrap_or(file.len());
        let lower = file[..length].to_ascii_lowercase();
        let name = lower.strip_suffix(b"_spf").or(lower.strip_suffix(b"_mpf")).unwrap_or(&lower);
        if name.is_empty() {
            let found = excerpt(&text[start..]);
            return Err((
                Unread::Expected { expected: "the name of a program", found },
                line.columns(at, at + 1),
            ));
        }
        self.siemens_call_by_name(name);
        Ok(semicolon(text, 0))
    }

    /// Reads `PROC NAME(REAL A, INT B=1)`: a label, and the assignment of the arguments to its own names.
    pub(super) fn siemens_proc(&mut self, text: &[u8], at: usize, line: &mut Line) -> Result<usize, Refusal> {
        let start = skip_blanks(text, at);
        let length = identifier(&text[start..]);
        self.siemens_label(&text[start..start + length]);
        let open = skip_blanks(text, start + length);
        if text.get(open) != Some(&b'(') {
            return Ok(text.len());
        }
        let mut next = open + 1;
        for argument in 0..MAX_ARGUMENTS {
            let kind = skip_blanks(text, next);
            let kind = kind + identifier(&text[kind..]);
            if text.get(kind) == Some(&b'[') {
                // The greatest length of a text is in brackets.
                next =
                    text[kind..].iter().position(|byte| *byte == b']').map_or(text.len(), |to| kind + to + 1);
            }
            let end = text[next..].iter().position(|byte| matches!(byte, b',' | b')' | b'=' | b'['));
            let end = end.map_or(text.len(), |length| next + length);
            let words = text[next..end].split(|byte| !byte.is_ascii_alphanumeric() && *byte != b'_');
            let name = words.rev().find(|word| !word.is_empty()).unwrap_or_default();
            let index = self.names.define(String::from_utf8_lossy(name).to_ascii_lowercase());
            let has_default = text.get(end) == Some(&b'=');
            let from = if has_default { end + 1 } else { end };
            (next, _) = self.formula(Notation::Siemens, text, (next, from), line, |expressions| {
                let weight = Step::Number(2_f64.powi(argument as i32));
                let is_given = [
                    Step::Number(f64::from(GIVEN_ARGUMENTS)),
                    Step::Numbered,
                    weight,
                    Step::Operator(Operator::Quotient),
                    Step::Number(2.0),
                    Step::Operator(Operator::Modulo),
                ];
                let number = Step::Number(f64::from(FIRST_ARGUMENT) + argument as f64);
                expressions.steps.extend(is_given);
                expressions.steps.extend([
                    number,
                    Step::Numbered,
                    Step::Operator(Operator::Times),
                    Step::Number(1.0),
                ]);
                expressions.steps.extend(is_given);
                expressions.steps.push(Step::Operator(Operator::Minus));
                if has_default {
                    expressions.expression(0)?;
                } else {
                    expressions.steps.push(Step::Number(0.0));
                }
                expressions.steps.extend([Step::Operator(Operator::Times), Step::Operator(Operator::Plus)]);
                Ok(Target::Named(index))
            })?;
            match text[next..].iter().position(|byte| matches!(byte, b',' | b')')) {
                Some(length) if text[next + length] == b',' => next += length + 1,
                _ => break,
            }
        }
        Ok(text.len())
    }

    /// Refuses `MCALL` before a subprogram, which would run after each move.
    ///
    /// # Errors
    ///
    /// If the block has `MCALL` directly before.
    fn refuse_modal_call(&self, name: &[u8], columns: (u32, u32)) -> Result<(), Refusal> {
        let block = self.index();
        let last = self.program.statements.last().filter(|statement| statement.block == block);
        let is_modal = |statement: &Statement| matches!(statement.keyword, Keyword::Siemens(known) if known.is_modal_call());
        let begin = |columns: Columns| <(u32, u32)>::from(columns).0;
        let is_behind = |statement: &Statement| {
            self.block_words().last().is_none_or(|word| begin(word.columns) < begin(statement.columns))
        };
        if last.is_some_and(|statement| is_modal(statement) && is_behind(statement)) {
            let word = format!("MCALL {}", String::from_utf8_lossy(name));
            return Err((Unread::ModalCall { word }, columns));
        }
        Ok(())
    }

    /// Assigns a number to a parameter.
    pub(super) fn assign_number(&mut self, parameter: u32, value: f64, columns: (u32, u32)) {
        let first = self.program.steps.len() as u32;
        self.program.steps.extend([Step::Number(f64::from(parameter)), Step::Number(value)]);
        let steps = first..self.program.steps.len() as u32;
        let block = self.index();
        self.program.formulas.push(Formula { block, target: Target::Numbered, steps, columns });
    }
}
