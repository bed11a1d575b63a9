//! Q parameters, FN functions, labels and calls.

use crate::simulation::gcode::expression::{Notation, klartext_number};
use crate::simulation::gcode::klartext::KlartextStatement::{self, Neutral, Unmodelled};
use crate::simulation::gcode::klartext::names::POSITION_PARAMETERS;
use crate::simulation::gcode::klartext::words::{found_at, plain};
use crate::simulation::gcode::klartext::{begins, program_name};
use crate::simulation::gcode::line::{Line, excerpt};
use crate::simulation::gcode::number::skip_blanks;
use crate::simulation::gcode::reader::{Reader, Refusal};
use crate::simulation::gcode::remark::Unread;
use crate::simulation::gcode::{Action, Destination, Direction, Label, LabelKind, Step, Target, When};

/// Values of a cycle's feed by its word.
const FEED_WORDS: &[(&str, f64)] =
    &[("FMAX", 99_999.0), ("FAUTO", -1.0), ("AUTO", -1.0), ("PREDEF", -2.0), ("MAX", 99_999.0)];

impl Reader<'_> {
    /// Reads `Q1 = Q2 + 3`, or the assignment of a text.
    pub(super) fn klartext_parameter(
        &mut self,
        code: &[u8],
        at: usize,
        line: &mut Line,
    ) -> Result<(), Refusal> {
        if begins(code, at, &["QS"]).is_some() {
            self.push_klartext(Unmodelled("QS"), line.columns(at, code.len()));
            return Ok(());
        }
        let mut next = self.klartext_assignment(code, at, line)?;
        // The lines of a cycle may hold several.
        while klartext_number(code.get(skip_blanks(code, next)..).unwrap_or_default()).is_some() {
            next = self.klartext_assignment(code, skip_blanks(code, next), line)?;
        }
        self.klartext_ends(code, next, line)
    }

    /// Checks that nothing follows from `at` on.
    ///
    /// # Errors
    ///
    /// If anything but blanks follows.
    pub(super) fn klartext_ends(&mut self, code: &[u8], at: usize, line: &Line) -> Result<(), Refusal> {
        let next = skip_blanks(code, at);
        match code.get(next..) {
            Some(rest) if !rest.is_empty() => {
                Err((Unread::Text { text: excerpt(rest) }, line.columns(next, code.len())))
            }
            _ => Ok(()),
        }
    }

    /// Reads `Q1 = value` at `at`; returns its end.
    pub(super) fn klartext_assignment(
        &mut self,
        code: &[u8],
        at: usize,
        line: &mut Line,
    ) -> Result<usize, Refusal> {
        let Some((number, length)) = klartext_number(&code[at..]) else {
            let columns = line.columns(at, at + 1);
            return Err((Unread::Expected { expected: "a Q parameter", found: found_at(code, at) }, columns));
        };
        let equals = skip_blanks(code, at + length);
        if code.get(equals) != Some(&b'=') {
            let found = found_at(code, equals);
            return Err((Unread::Expected { expected: "`=`", found }, line.columns(equals, equals + 1)));
        }
        let start = skip_blanks(code, equals + 1);
        let word = FEED_WORDS.iter().find_map(|(word, value)| Some((begins(code, start, &[word])?, *value)));
        let (end, _) = self.formula(Notation::Klartext, code, (at, start), line, |expressions| {
            expressions.steps.push(Step::Number(f64::from(number)));
            if let Some((end, value)) = word {
                expressions.steps.push(Step::Number(value));
                expressions.at = end;
            } else {
                expressions.expression(0)?;
            }
            Ok(Target::Numbered)
        })?;
        Ok(end)
    }

    /// Reads a function such as `FN 0: Q1 = 5`.
    pub(super) fn klartext_function(
        &mut self,
        code: &[u8],
        (at, end): (usize, usize),
        line: &mut Line,
    ) -> Result<(), Refusal> {
        let start = skip_blanks(code, end);
        let length = code[start.min(code.len())..].iter().take_while(|byte| byte.is_ascii_digit()).count();
        let number = std::str::from_utf8(&code[start.min(code.len())..start.min(code.len()) + length])
            .unwrap_or_default();
        let colon = skip_blanks(code, start + length);
        let next = skip_blanks(code, if code.get(colon) == Some(&b':') { colon + 1 } else { colon });
        let columns = line.columns(at, next);
        match number {
            "0" | "1" | "2" | "3" | "4" | "5" | "6" | "7" | "8" | "13" if next < code.len() => {
                return self.klartext_parameter(code, next, line);
            }
            "9" | "10" | "11" | "12" => match begins(code, next, &["IF"]) {
                Some(past) => return self.klartext_if(code, (next, past), line),
                None => {
                    let found = found_at(code, next);
                    return Err((Unread::Expected { expected: "IF", found }, columns));
                }
            },
            "18" => return self.klartext_system_read(code, next, columns, line),
            _ => {}
        }
        let statement = number.parse().ok().and_then(without_model);
        let Some(statement) = statement else {
            return Err((Unread::Text { text: excerpt(&code[at..]) }, columns));
        };
        self.heidenhain.skips = true;
        self.push_klartext(statement, columns);
        Ok(())
    }

    /// Reads `FN 18: SYSREAD Q1 = ID270 NR1 IDX1`.
    fn klartext_system_read(
        &mut self,
        code: &[u8],
        next: usize,
        columns: (u32, u32),
        line: &mut Line,
    ) -> Result<(), Refusal> {
        let at = skip_blanks(code, begins(code, next, &["SYSREAD"]).unwrap_or(next));
        let Some((number, length)) = code.get(at..).and_then(klartext_number) else {
            return Err((Unread::Expected { expected: "a Q parameter", found: found_at(code, at) }, columns));
        };
        let query: Vec<u8> =
            code[at + length..].iter().filter(|byte| !byte.is_ascii_whitespace()).copied().collect();
        self.klartext_read(number, &query, columns, line)
    }

    /// Assigns a value of the control to a parameter. Only the position is known; other values are taken as 0.
    pub(super) fn klartext_read(
        &mut self,
        number: u32,
        query: &[u8],
        columns: (u32, u32),
        line: &mut Line,
    ) -> Result<(), Refusal> {
        let position = [b"=ID270NR1IDX1", b"=ID270NR1IDX2", b"=ID270NR1IDX3"]
            .iter()
            .position(|known| query.eq_ignore_ascii_case(&known[..]));
        self.formula(Notation::Klartext, query, (0, query.len()), line, |expressions| {
            expressions.steps.push(Step::Number(f64::from(number)));
            match position {
                Some(axis) => expressions
                    .steps
                    .extend([Step::Number(f64::from(POSITION_PARAMETERS[axis])), Step::Numbered]),
                None => expressions.steps.push(Step::Number(0.0)),
            }
            Ok(Target::Numbered)
        })?;
        let name = if position.is_some() { "FN 18 POSITION" } else { "FN 18" };
        self.push_klartext(Unmodelled(name), columns);
        Ok(())
    }

    /// Reads `IF +Q1 EQU +Q2 GOTO LBL 5`.
    pub(super) fn klartext_if(
        &mut self,
        code: &[u8],
        (at, end): (usize, usize),
        line: &mut Line,
    ) -> Result<(), Refusal> {
        let goto = code[end..].windows(4).position(|four| four.eq_ignore_ascii_case(b"GOTO"));
        let has_word =
            |word: &[u8]| code[end..].windows(word.len()).any(|found| found.eq_ignore_ascii_case(word));
        if has_word(b"DEFINED") || has_word(b"QS") {
            self.push_klartext(Unmodelled("IS UNDEFINED"), line.columns(at, code.len()));
            return Ok(());
        }
        let (past, _) = self.formula(Notation::Klartext, code, (end, end), line, |expressions| {
            expressions.expression(0)?;
            Ok(Target::Condition)
        })?;
        let next = skip_blanks(code, past);
        if goto.map(|offset| end + offset) != Some(next) {
            let found = found_at(code, next);
            return Err((
                Unread::Expected { expected: "an operator or GOTO", found },
                line.columns(next, next + 1),
            ));
        }
        let label = skip_blanks(code, next + 4);
        let label = skip_blanks(code, begins(code, label, &["LBL"]).unwrap_or(label));
        let (to, end) = self.klartext_destination(code, label, line)?;
        self.act(Action::Jump { to, when: When::True });
        self.klartext_ends(code, end, line)
    }

    /// Reads the label of a jump or call at `at`; returns it as a destination, with its end.
    pub(super) fn klartext_destination(
        &mut self,
        code: &[u8],
        at: usize,
        line: &mut Line,
    ) -> Result<(Destination, usize), Refusal> {
        if klartext_number(code.get(at..).unwrap_or_default()).is_some() {
            let (end, _) = self.formula(Notation::Klartext, code, (at, at), line, |expressions| {
                expressions.value()?;
                Ok(Target::Destination)
            })?;
            return Ok((Destination::Computed(LabelKind::Numbered), end));
        }
        let (label, end) = self.klartext_name(code, at, line)?;
        Ok((Destination::Label(label, Direction::Either), end))
    }

    /// Reads a label such as `5` or `"NAME"`; returns it with its end.
    fn klartext_name(&mut self, code: &[u8], at: usize, line: &mut Line) -> Result<(Label, usize), Refusal> {
        if code.get(at) == Some(&b'"') {
            let close = code[at + 1..].iter().position(|byte| *byte == b'"');
            let close = close.map_or(code.len(), |length| at + 1 + length);
            let name = String::from_utf8_lossy(&code[at + 1..close]).to_ascii_lowercase();
            let id = self.names.index(name);
            return Ok((Label { kind: LabelKind::Named, id }, (close + 1).min(code.len())));
        }
        match plain(code, at) {
            Some(found) if (0.0..=1e9).contains(&found.value) && found.value.fract() == 0.0 => {
                Ok((Label { kind: LabelKind::Numbered, id: found.value as u32 }, found.end))
            }
            _ => {
                let columns = line.columns(at, at + 1);
                Err((Unread::Expected { expected: "a label", found: found_at(code, at) }, columns))
            }
        }
    }

    /// Reads `LBL 5`, `LBL "NAME"` or `LBL 0`.
    pub(super) fn klartext_label(&mut self, code: &[u8], end: usize, line: &mut Line) -> Result<(), Refusal> {
        let (label, end) = self.klartext_name(code, skip_blanks(code, end), line)?;
        if label == (Label { kind: LabelKind::Numbered, id: 0 }) {
            self.act(Action::SubprogramEnd);
        } else {
            self.label(label.kind, label.id);
        }
        self.klartext_ends(code, end, line)
    }

    /// Reads `CALL LBL 5` or `CALL LBL 5 REP 3/3`.
    pub(super) fn klartext_call(&mut self, code: &[u8], end: usize, line: &mut Line) -> Result<(), Refusal> {
        let (to, end) = self.klartext_destination(code, skip_blanks(code, end), line)?;
        let next = skip_blanks(code, end);
        let starts = |word: &[u8]| {
            code.get(next..next + word.len()).is_some_and(|found| found.eq_ignore_ascii_case(word))
        };
        if !starts(b"REP") {
            self.act(Action::Call { to, has_own_parameters: false });
            return self.klartext_ends(code, end, line);
        }
        let past = self.klartext_count(code, next + 3, line)?;
        self.act(Action::Again { to });
        // `5/3`: on its screen, the control shows the remaining repetitions after the slash.
        let slash = skip_blanks(code, past);
        let left = (code.get(slash) == Some(&b'/')).then(|| plain(code, slash + 1)).flatten();
        self.klartext_ends(code, left.map_or(past, |left| left.end), line)
    }

    /// Reads the number of repetitions of a call; returns its end.
    pub(super) fn klartext_count(
        &mut self,
        code: &[u8],
        start: usize,
        line: &mut Line,
    ) -> Result<usize, Refusal> {
        let (past, _) = match plain(code, start) {
            Some(found) => self.formula(Notation::Klartext, code, (start, start), line, |expressions| {
                expressions.steps.push(Step::Number(found.value));
                expressions.at = found.end;
                Ok(Target::Count)
            })?,
            None => self.formula(Notation::Klartext, code, (start, start), line, |expressions| {
                expressions.value()?;
                Ok(Target::Count)
            })?,
        };
        Ok(past)
    }

    /// Calls a program by `CALL PGM NAME.H`.
    pub(super) fn klartext_call_program(&mut self, code: &[u8], end: usize) {
        let id = self.names.index(program_name(&code[end..]));
        let to = Destination::Label(Label { kind: LabelKind::Named, id }, Direction::Either);
        self.act(Action::Call { to, has_own_parameters: false });
    }
}

/// Returns the statement of an FN function that has no model or changes neither path nor time; `None` for others.
pub(super) fn without_model(function: u32) -> Option<KlartextStatement> {
    Some(match function {
        14 => Unmodelled("FN 14"),
        // Printing and sending change neither path nor time.
        15..=17 | 38 => Neutral,
        19 => Unmodelled("FN 19"),
        20 => Unmodelled("FN 20"),
        26 => Unmodelled("FN 26"),
        27 => Unmodelled("FN 27"),
        28 => Unmodelled("FN 28"),
        29 => Unmodelled("FN 29"),
        37 => Unmodelled("FN 37"),
        _ => return None,
    })
}
