//! Flow of SINUMERIK programs.
//!
//! ```text
//! IF c … ELSE … ENDIF      IF c GOTOF label     GOTOF, GOTOB, GOTO, GOTOC label
//! WHILE c … ENDWHILE       FOR i = a TO b … ENDFOR       LOOP … ENDLOOP
//! REPEAT … UNTIL c         REPEAT label P=n     REPEAT from to P=n     REPEATB label P=n
//! CASE a OF 1 GOTOF label 2 GOTOB label DEFAULT GOTOF label       CALL BLOCK from TO to
//! ```
//!
//! REPEAT and CALL BLOCK run the blocks of both labels and those between them; REPEAT with one label runs the
//! blocks up to `ENDLABEL:`, or up to itself. CASE becomes one jump after the other, with its value in a parameter
//! beyond all R numbers.

use crate::simulation::gcode::expression::{Notation, identifier};
use crate::simulation::gcode::line::{Line, excerpt, semicolon};
use crate::simulation::gcode::number::skip_blanks;
use crate::simulation::gcode::reader::{Reader, Refusal};
use crate::simulation::gcode::remark::Unread;
use crate::simulation::gcode::siemens::keywords::known;
use crate::simulation::gcode::structure::{Counter, Kind};
use crate::simulation::gcode::{
    Action, Destination, Direction, Formula, Label, LabelKind, Operator, SectionEnd, Step, Target, When,
};

/// The key of all structures, which have no numbers.
const PLAIN: u32 = 0;

/// Number of the parameter with the value of a CASE: beyond all R numbers.
const CASE_VALUE: u32 = 3_000_000_000;

impl Reader<'_> {
    /// Reads the rest of a statement of flow; returns its end, or `None` if its word is none of flow.
    pub(super) fn siemens_flow(
        &mut self,
        text: &[u8],
        (at, end): (usize, usize),
        line: &mut Line,
    ) -> Result<Option<usize>, Refusal> {
        let word = text[at..end].to_ascii_uppercase();
        let columns = line.columns(at, end);
        let unopened = || (Unread::Unopened { word: excerpt(&word) }, columns);
        let next = match &word[..] {
            b"IF" => {
                let end = self.siemens_condition(text, end, line)?;
                if let Some((direction, end)) = goto(text, end) {
                    self.siemens_goto(text, end, line, direction, When::True)?
                } else {
                    self.open_branch(PLAIN, columns)?;
                    end
                }
            }
            b"ELSE" => {
                self.next_branch(PLAIN).ok_or_else(unopened)?;
                end
            }
            b"ENDIF" => {
                self.close_branch(PLAIN).ok_or_else(unopened)?;
                end
            }
            b"WHILE" => {
                let end = self.siemens_condition(text, end, line)?;
                self.open_while(PLAIN, columns)?;
                end
            }
            b"LOOP" => {
                self.open(Kind::Do, PLAIN, columns)?;
                end
            }
            b"FOR" => self.siemens_for(text, end, line)?,
            b"ENDWHILE" | b"ENDLOOP" | b"ENDFOR" => {
                let kind = match &word[..] {
                    b"ENDWHILE" => Kind::While,
                    b"ENDLOOP" => Kind::Do,
                    _ => Kind::For,
                };
                let open = self.close(&[kind], PLAIN).ok_or_else(unopened)?;
                if let Some(counter) = open.counter {
                    self.count_up(counter, columns);
                }
                self.jump_back(&open);
                end
            }
            b"REPEAT" | b"REPEATB" => self.siemens_repeat(text, end, &word, line)?,
            b"UNTIL" => {
                let end = self.siemens_condition(text, end, line)?;
                let open = self.close(&[Kind::Repeat], PLAIN).ok_or_else(unopened)?;
                self.act(Action::Jump { to: Destination::Block(open.head), when: When::False });
                end
            }
            b"GOTOF" | b"GOTOB" | b"GOTO" | b"GOTOC" => {
                let (direction, end) = goto(text, at).ok_or_else(unopened)?;
                self.siemens_goto(text, end, line, direction, When::Always)?
            }
            b"RET" => {
                self.act(Action::Return);
                text.len()
            }
            b"PROC" => self.siemens_proc(text, end, line)?,
            b"DEF" => self.siemens_definition(text, end, line)?,
            b"WHEN" | b"WHENEVER" | b"EVERY" | b"DO" => {
                self.push_statement(known("WHEN"), columns);
                semicolon(text, 0)
            }
            b"EXTERN" => semicolon(text, 0),
            b"CALL" | b"EXTCALL" | b"PCALL" => self.siemens_call_by_text(text, end, line)?,
            b"CASE" => self.siemens_case(text, end, line)?,
            _ => return Ok(None),
        };
        Ok(Some(next))
    }

    /// Reads a condition; returns its end.
    fn siemens_condition(&mut self, text: &[u8], at: usize, line: &mut Line) -> Result<usize, Refusal> {
        self.siemens_value(text, at, line, Target::Condition)
    }

    /// Reads an expression for `target`; returns its end.
    pub(super) fn siemens_value(
        &mut self,
        text: &[u8],
        at: usize,
        line: &mut Line,
        target: Target,
    ) -> Result<usize, Refusal> {
        let (end, _) = self.formula(Notation::Siemens, text, (at, at), line, |expressions| {
            expressions.expression(0)?;
            Ok(target)
        })?;
        Ok(end)
    }

    /// Reads the label of a jump; returns its end.
    fn siemens_goto(
        &mut self,
        text: &[u8],
        at: usize,
        line: &Line,
        direction: Direction,
        when: When,
    ) -> Result<usize, Refusal> {
        let start = skip_blanks(text, at);
        let length = identifier(&text[start..]);
        if length == 0 {
            let found = excerpt(&text[start..]);
            return Err((Unread::Expected { expected: "a label", found }, line.columns(start, start + 1)));
        }
        let name = &text[start..start + length];
        let number = std::str::from_utf8(&name[1..]).ok().and_then(|digits| digits.parse().ok());
        let label = match number {
            Some(id) if name[0].eq_ignore_ascii_case(&b'N') => {
                self.names_sequence = true;
                Label { kind: LabelKind::Sequence, id }
            }
            _ => self.siemens_named_label(name),
        };
        self.act(Action::Jump { to: Destination::Label(label, direction), when });
        Ok(start + length)
    }

    /// Reads `FOR i = a TO b` as a block that sets the counter and one that tests it; returns the end.
    fn siemens_for(&mut self, text: &[u8], at: usize, line: &mut Line) -> Result<usize, Refusal> {
        let start = skip_blanks(text, at);
        let length = identifier(&text[start..]);
        let name = &text[start..start + length];
        let equals = skip_blanks(text, start + length);
        if length == 0 || text.get(equals) != Some(&b'=') {
            let found = excerpt(&text[start..]);
            return Err((
                Unread::Expected { expected: "a counter and `=`", found },
                line.columns(start, start + 1),
            ));
        }
        let counter = match std::str::from_utf8(&name[1..]).ok().and_then(|digits| digits.parse().ok()) {
            Some(number) if name[0].eq_ignore_ascii_case(&b'R') => Counter::Number(number),
            _ => Counter::Name(self.names.index(String::from_utf8_lossy(name).to_ascii_lowercase())),
        };
        let end = self.siemens_variable(text, (start, start + length), equals + 1, line)?;
        let to = skip_blanks(text, end);
        if !text.get(to..to + 2).is_some_and(|word| word.eq_ignore_ascii_case(b"TO")) {
            return Err((
                Unread::Expected { expected: "TO", found: excerpt(&text[to..]) },
                line.columns(to, to + 1),
            ));
        }
        self.end_block();
        let index = self.index();
        let (end, _) = self.formula(Notation::Siemens, text, (start, to + 2), line, |expressions| {
            counter.load(expressions.steps);
            expressions.expression(0)?;
            expressions.steps.push(Step::Operator(Operator::LessOrEqual));
            Ok(Target::Condition)
        })?;
        let exit = self.program.jump_later(index, When::False);
        let open = self.open(Kind::For, PLAIN, line.columns(start, end))?;
        open.exits.push(exit);
        open.counter = Some(counter);
        Ok(end)
    }

    /// Adds one to the counter of a FOR.
    fn count_up(&mut self, counter: Counter, columns: (u32, u32)) {
        let first = self.program.steps.len() as u32;
        let target = match counter {
            Counter::Number(number) => {
                self.program.steps.push(Step::Number(f64::from(number)));
                Target::Numbered
            }
            Counter::Name(index) => Target::Named(index),
        };
        counter.load(&mut self.program.steps);
        self.program.steps.extend([Step::Number(1.0), Step::Operator(Operator::Plus)]);
        let steps = first..self.program.steps.len() as u32;
        let block = self.index();
        self.program.formulas.push(Formula { block, target, steps, columns });
    }

    /// Reads `REPEAT`: alone it opens a loop; with labels it runs the blocks between them once more. Returns its
    /// end.
    fn siemens_repeat(
        &mut self,
        text: &[u8],
        at: usize,
        word: &[u8],
        line: &mut Line,
    ) -> Result<usize, Refusal> {
        let start = skip_blanks(text, at);
        let length = identifier(&text[start..]);
        if length == 0 {
            self.open(Kind::Repeat, PLAIN, line.columns(start, start + 1))?;
            return Ok(at);
        }
        let from = self.siemens_named_label(&text[start..start + length]);
        let mut end = start + length;
        let mut until = SectionEnd::LabelOrHere(self.siemens_named_label(b"ENDLABEL"));
        let second = skip_blanks(text, end);
        let length = identifier(&text[second..]);
        let is_count = text.get(second).is_some_and(|byte| byte.eq_ignore_ascii_case(&b'P'))
            && text
                .get(skip_blanks(text, second + 1))
                .is_some_and(|byte| *byte == b'=' || byte.is_ascii_digit());
        if word == b"REPEATB" {
            until = SectionEnd::Block;
        } else if 0 < length && !is_count {
            until = SectionEnd::Label(self.siemens_named_label(&text[second..second + length]));
            end = second + length;
        }
        let count = skip_blanks(text, end);
        if text.get(count).is_some_and(|byte| byte.eq_ignore_ascii_case(&b'P')) {
            let equals = skip_blanks(text, count + 1);
            let value = if text.get(equals) == Some(&b'=') { equals + 1 } else { count + 1 };
            end = self.siemens_value(text, value, line, Target::Count)?;
        }
        self.act(Action::Section { from, until });
        Ok(end)
    }

    /// Reads `CALL BLOCK A TO B`; returns its end.
    pub(super) fn siemens_call_section(
        &mut self,
        text: &[u8],
        at: usize,
        line: &mut Line,
    ) -> Result<usize, Refusal> {
        let start = skip_blanks(text, at);
        let length = identifier(&text[start..]);
        let from = self.siemens_named_label(&text[start..start + length]);
        let to = skip_blanks(text, start + length);
        if !text[to..].get(..2).is_some_and(|word| word.eq_ignore_ascii_case(b"TO")) {
            let found = excerpt(&text[to..]);
            return Err((Unread::Expected { expected: "TO", found }, line.columns(to, to + 1)));
        }
        let last = skip_blanks(text, to + 2);
        let length = identifier(&text[last..]);
        let until = SectionEnd::Label(self.siemens_named_label(&text[last..last + length]));
        self.act(Action::Section { from, until });
        Ok(last + length)
    }

    /// Reads `CASE a OF 1 GOTOF label … DEFAULT GOTOF label`; returns its end.
    fn siemens_case(&mut self, text: &[u8], at: usize, line: &mut Line) -> Result<usize, Refusal> {
        let (end, _) = self.formula(Notation::Siemens, text, (at, at), line, |expressions| {
            expressions.steps.push(Step::Number(f64::from(CASE_VALUE)));
            expressions.expression(0)?;
            Ok(Target::Numbered)
        })?;
        let mut next = skip_blanks(text, end);
        if !text[next..].get(..2).is_some_and(|word| word.eq_ignore_ascii_case(b"OF")) {
            let found = excerpt(&text[next..]);
            return Err((Unread::Expected { expected: "OF", found }, line.columns(next, next + 1)));
        }
        next = skip_blanks(text, next + 2);
        while !matches!(text.get(next), None | Some(b';')) {
            self.end_block();
            let word = &text[next..next + identifier(&text[next..])];
            let is_default = word.eq_ignore_ascii_case(b"DEFAULT");
            let end = if is_default {
                next + word.len()
            } else {
                let (end, _) = self.formula(Notation::Siemens, text, (next, next), line, |expressions| {
                    expressions.steps.extend([Step::Number(f64::from(CASE_VALUE)), Step::Numbered]);
                    expressions.value()?;
                    expressions.steps.push(Step::Operator(Operator::Equal));
                    Ok(Target::Condition)
                })?;
                end
            };
            let Some((direction, label)) = goto(text, end) else {
                let found = excerpt(&text[end..]);
                return Err((Unread::Expected { expected: "GOTOF", found }, line.columns(end, end + 1)));
            };
            let when = if is_default { When::Always } else { When::True };
            next = skip_blanks(text, self.siemens_goto(text, label, line, direction, when)?);
        }
        Ok(next)
    }

    /// Returns the label of this name.
    pub(super) fn siemens_named_label(&mut self, name: &[u8]) -> Label {
        let id = self.names.index(String::from_utf8_lossy(name).to_ascii_lowercase());
        Label { kind: LabelKind::Named, id }
    }
}

/// Returns the direction of a jump word at `at` and the end of the word; `None` if there is none.
fn goto(text: &[u8], at: usize) -> Option<(Direction, usize)> {
    let start = skip_blanks(text, at);
    let length = identifier(&text[start..]);
    let direction = match text[start..start + length].to_ascii_uppercase().as_slice() {
        b"GOTOF" => Direction::Forward,
        b"GOTOB" => Direction::Backward,
        b"GOTO" | b"GOTOC" => Direction::Either,
        _ => return None,
    };
    Some((direction, start + length))
}
