//! O words of LinuxCNC: loops, branches and subroutines by number or name.
//!
//! ```text
//! o100 sub … [return [value]] … endsub [value]     o100 call [argument] …
//! o1 if [c] … o1 elseif [c] … o1 else … o1 endif
//! o2 while [c] … o2 endwhile     o3 do … o3 while [c]     o4 repeat [n] … o4 endrepeat
//! o2 break     o2 continue
//! ```
//!
//! `O<BRACKET>` alone is the name of a program on Fanuc 30i and later; calls by such a name are not read.
//!
//! Source: LinuxCNC 2.9, G-code → O codes.

use crate::simulation::gcode::expression::{Notation, Place as Parameter};
use crate::simulation::gcode::line::{Line, code_end, excerpt};
use crate::simulation::gcode::number::{number, skip_blanks, whole_number};
use crate::simulation::gcode::reader::{Reader, Refusal};
use crate::simulation::gcode::remark::Unread;
use crate::simulation::gcode::structure::Kind;
use crate::simulation::gcode::{Action, Destination, Dialect, Direction, Label, LabelKind, Target, When};

const KEYWORDS: [&str; 14] = [
    "SUB",
    "ENDSUB",
    "CALL",
    "RETURN",
    "IF",
    "ELSEIF",
    "ELSE",
    "ENDIF",
    "WHILE",
    "ENDWHILE",
    "DO",
    "REPEAT",
    "ENDREPEAT",
    "BREAK",
];

/// Bit of the keys of named O words, which separates them from those of numbered ones.
const NAMED_KEY_BIT: u32 = 1 << 31;

const LOOPS: &[Kind] = &[Kind::While, Kind::Do, Kind::Repeat];

/// The structure that a word opens or closes, with the columns of that word.
#[derive(Clone, Copy)]
struct Opening {
    key: u32,
    columns: (u32, u32),
}

impl Reader<'_> {
    /// Returns the keyword after an O number, in upper case, and its end.
    pub(super) fn o_word_keyword(&self, text: &[u8], at: usize) -> Option<(&'static str, usize)> {
        let start = skip_blanks(text, at);
        let letters = text[start..].iter().take_while(|byte| byte.is_ascii_alphabetic()).count();
        let word = &text[start..start + letters];
        let known =
            KEYWORDS.iter().chain(&["CONTINUE"]).find(|known| word.eq_ignore_ascii_case(known.as_bytes()));
        known.map(|known| (*known, start + letters))
    }

    /// Reads the O word at `at` with its arguments; returns the end.
    pub(super) fn o_word(&mut self, text: &[u8], at: usize, line: &mut Line) -> Result<usize, Refusal> {
        // The name may hold characters of several bytes, which are counted when it is read.
        let first = line.columns(at, at).0;
        let (destination, key, next) = self.o_name(text, at, line)?;
        let Some((keyword, next)) = self.o_word_keyword(text, next) else {
            // Fanuc 30i and later name programs as well: `O<BRACKET>`.
            if self.program.dialect == Dialect::Iso
                && let Destination::Label(label @ Label { kind: LabelKind::Named, .. }, _) = destination
            {
                self.program_border();
                self.label(label.kind, label.id);
                (line.has_o_word, line.begun) = (true, true);
                return Ok(next);
            }
            let end = code_end(text, at).max(at + 1);
            return Err((Unread::Text { text: excerpt(&text[at..end]) }, (first, line.columns(next, end).1)));
        };
        line.begun = true;
        let opening = Opening { key, columns: (first, line.columns(next, next).1) };
        let unopened = || (Unread::Unopened { word: excerpt(&text[at..next]) }, opening.columns);
        let index = self.index();
        match keyword {
            "SUB" => {
                let skip = self.program.jump_later(index, When::Always);
                self.open(Kind::Sub, key, opening.columns)?.exits.push(skip);
                self.end_block();
                if let Destination::Label(label, _) = destination {
                    self.label(label.kind, label.id);
                }
                Ok(next)
            }
            "ENDSUB" => {
                let open = self.close(&[Kind::Sub], key).ok_or_else(unopened)?;
                let next = self.o_value(text, next, line, Target::Result, false)?;
                self.act(Action::Return);
                self.end_block();
                self.program.complete(&open.exits, self.index());
                Ok(next)
            }
            "RETURN" => {
                let next = self.o_value(text, next, line, Target::Result, false)?;
                self.act(Action::Return);
                Ok(next)
            }
            "CALL" => {
                let mut next = next;
                let mut argument = 0;
                while text.get(skip_blanks(text, next)) == Some(&b'[') {
                    argument += 1;
                    next = self.o_value(text, next, line, Target::Argument(argument), true)?;
                }
                self.act(Action::Call { to: destination, has_own_parameters: true });
                Ok(next)
            }
            "IF" => {
                let next = self.o_value(text, next, line, Target::Condition, true)?;
                self.open_branch(key, opening.columns)?;
                Ok(next)
            }
            "ELSE" => {
                self.next_branch(key).ok_or_else(unopened)?;
                Ok(next)
            }
            "ELSEIF" => {
                self.next_branch(key).ok_or_else(unopened)?;
                let next = self.o_value(text, next, line, Target::Condition, true)?;
                let jump = self.program.jump_later(index + 1, When::False);
                if let Some(open) = self.structures.find(&[Kind::If], key) {
                    open.next = Some(jump);
                }
                Ok(next)
            }
            "ENDIF" => {
                self.close_branch(key).ok_or_else(unopened)?;
                Ok(next)
            }
            _ => self.o_loop(keyword, text, next, line, opening).and_then(|next| next.ok_or_else(unopened)),
        }
    }

    /// Reads the rest of the word of a loop from `next`; returns its end, or `None` if it closes or leaves a loop
    /// that is not open.
    fn o_loop(
        &mut self,
        keyword: &str,
        text: &[u8],
        next: usize,
        line: &mut Line,
        Opening { key, columns }: Opening,
    ) -> Result<Option<usize>, Refusal> {
        let index = self.index();
        match keyword {
            "WHILE" => {
                let next = self.o_value(text, next, line, Target::Condition, true)?;
                if self.structures.find(&[Kind::Do], key).is_none() {
                    self.open_while(key, columns)?;
                    return Ok(Some(next));
                }
                let Some(open) = self.close(&[Kind::Do], key) else { return Ok(None) };
                self.act(Action::Jump { to: Destination::Block(open.head), when: When::True });
                self.end_block();
                self.end_loop(&open.exits, &open.to_end, index);
                Ok(Some(next))
            }
            "DO" => {
                self.open(Kind::Do, key, columns)?;
                Ok(Some(next))
            }
            "REPEAT" => {
                let next = self.o_value(text, next, line, Target::Count, true)?;
                let repeat = self.act(Action::Repeat { end: u32::MAX });
                self.open(Kind::Repeat, key, columns)?.to_end.push(repeat);
                Ok(Some(next))
            }
            "ENDWHILE" | "ENDREPEAT" => {
                let kind = if keyword == "ENDWHILE" { Kind::While } else { Kind::Repeat };
                let Some(open) = self.close(&[kind], key) else { return Ok(None) };
                self.act(match kind {
                    Kind::While => Action::Jump { to: Destination::Block(open.head), when: When::Always },
                    _ => Action::Again { to: Destination::Block(open.head + 1) },
                });
                self.end_block();
                self.end_loop(&open.exits, &open.to_end, index);
                Ok(Some(next))
            }
            _ => {
                let jump = self.program.jump_later(index, When::Always);
                let Some(open) = self.structures.find(LOOPS, key) else { return Ok(None) };
                let jumps = if keyword == "BREAK" { &mut open.exits } else { &mut open.to_end };
                jumps.push(jump);
                Ok(Some(next))
            }
        }
    }

    /// Completes the jumps out of a loop, and the jumps to its closing word in the block `end`.
    fn end_loop(&mut self, exits: &[usize], to_end: &[usize], end: u32) {
        self.program.complete(exits, end + 1);
        self.program.complete(to_end, end);
    }

    /// Reads the name of an O word; returns its destination, its key and its end.
    fn o_name(
        &mut self,
        text: &[u8],
        at: usize,
        line: &mut Line,
    ) -> Result<(Destination, u32, usize), Refusal> {
        let start = skip_blanks(text, at + 1);
        let label = |kind, id| Destination::Label(Label { kind, id }, Direction::Either);
        if let Some(found) = number(text, start) {
            let id = whole_number(found.value).unwrap_or(u32::MAX >> 1);
            return Ok((label(LabelKind::Numbered, id), id, found.end));
        }
        if text.get(start) == Some(&b'<') {
            let mut name = None;
            let steps = self.program.steps.len();
            let mut expressions = crate::simulation::gcode::expression::Expressions::new(
                Notation::Iso,
                text,
                start,
                &mut self.program.steps,
                &mut self.names,
            );
            let outcome = expressions.place();
            let (end, continuation) = (expressions.at, expressions.continuation);
            line.continuation += continuation;
            self.program.steps.truncate(steps);
            match outcome {
                Ok(Parameter::Named(index)) => name = Some(index),
                Ok(Parameter::Numbered) => {}
                Err((remark, bytes)) => return Err((remark, line.columns(bytes.start, bytes.end))),
            }
            let id = name.unwrap_or(0);
            return Ok((label(LabelKind::Named, id), NAMED_KEY_BIT | id, end));
        }
        let next = self.o_value(text, start, line, Target::Destination, true)?;
        Ok((Destination::Computed(LabelKind::Numbered), u32::MAX, next))
    }

    /// Reads a value for `target`; returns its end.
    fn o_value(
        &mut self,
        text: &[u8],
        at: usize,
        line: &mut Line,
        target: Target,
        is_needed: bool,
    ) -> Result<usize, Refusal> {
        let start = skip_blanks(text, at);
        if !is_needed && text.get(start) != Some(&b'[') {
            return Ok(at);
        }
        let (end, _) = self.formula(Notation::Iso, text, (start, start), line, |expressions| {
            expressions.value()?;
            Ok(target)
        })?;
        Ok(end)
    }
}
