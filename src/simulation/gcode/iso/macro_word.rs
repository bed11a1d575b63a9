//! Fanuc custom macro B: `IF […] GOTO n`, `IF […] THEN #1=…`, `GOTO n`, `WHILE […] DO m … END m`.
//!
//! A word may be cut to its first two letters. `DO m` without `WHILE` repeats until a GOTO leaves it. Okuma's `IF
//! […] N100` and `GOTO N100` are read too.
//!
//! Source: Fanuc Series 30i operator's manual B-63944EN, ch. 16.

use crate::simulation::gcode::expression::Notation;
use crate::simulation::gcode::line::Line;
use crate::simulation::gcode::number::{number, skip_blanks, whole_number};
use crate::simulation::gcode::reader::{Reader, Refusal};
use crate::simulation::gcode::remark::Unread;
use crate::simulation::gcode::structure::Kind;
use crate::simulation::gcode::{Action, Destination, Dialect, Direction, Label, LabelKind, Target, When};

/// A word of program flow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Keyword {
    If,
    Then,
    Goto,
    While,
    Do,
    End,
}

impl Keyword {
    /// Returns the keyword with these letters.
    pub(super) fn of(letters: &[u8]) -> Option<Keyword> {
        const KEYWORDS: [(&str, Keyword); 11] = [
            ("IF", Keyword::If),
            ("THEN", Keyword::Then),
            ("TH", Keyword::Then),
            ("GOTO", Keyword::Goto),
            ("GOTON", Keyword::Goto),
            ("GO", Keyword::Goto),
            ("WHILE", Keyword::While),
            ("WH", Keyword::While),
            ("DO", Keyword::Do),
            ("END", Keyword::End),
            ("EN", Keyword::End),
        ];
        let is_it = |(name, _): &&(&str, Keyword)| letters.eq_ignore_ascii_case(name.as_bytes());
        KEYWORDS.iter().find(is_it).map(|(_, keyword)| *keyword)
    }
}

impl Reader<'_> {
    /// Reads the rest of a statement whose keyword is between `ends`; returns its end.
    pub(super) fn macro_word(
        &mut self,
        text: &[u8],
        ends: (usize, usize),
        keyword: Keyword,
        line: &mut Line,
    ) -> Result<usize, Refusal> {
        let (at, end) = ends;
        line.begun = true;
        match keyword {
            Keyword::If => {
                let end = self.condition(text, end, line)?;
                match self.keyword_at(text, end) {
                    Some((Keyword::Goto, end)) => self.goto(text, end, line, When::True),
                    Some((Keyword::Then, end)) => {
                        line.skips = Some(self.program.jump_later(self.index(), When::False));
                        self.end_block();
                        Ok(end)
                    }
                    _ if text
                        .get(skip_blanks(text, end))
                        .is_some_and(|byte| byte.eq_ignore_ascii_case(&b'N')) =>
                    {
                        self.goto(text, end, line, When::True)
                    }
                    _ => Err(expected("GOTO or THEN", line, end)),
                }
            }
            Keyword::Goto => self.goto(text, end, line, When::Always),
            Keyword::While => {
                let end = self.condition(text, end, line)?;
                let Some((Keyword::Do, end)) = self.keyword_at(text, end) else {
                    return Err(expected("DO", line, end));
                };
                let (key, end) = self.loop_number(text, end, line)?;
                self.open_while(key, line.columns(at, end))?;
                Ok(end)
            }
            Keyword::Do => {
                let (key, end) = self.loop_number(text, end, line)?;
                self.open(Kind::Do, key, line.columns(at, end))?;
                Ok(end)
            }
            Keyword::End => {
                let (key, end) = self.loop_number(text, end, line)?;
                let Some(open) = self.close(&[Kind::While, Kind::Do], key) else {
                    return Err((Unread::Unopened { word: format!("END{key}") }, line.columns(at, end)));
                };
                self.jump_back(&open);
                Ok(end)
            }
            Keyword::Then => Err((Unread::Unopened { word: "THEN".to_string() }, line.columns(at, end))),
        }
    }

    /// Reads a condition in brackets; returns its end.
    fn condition(&mut self, text: &[u8], at: usize, line: &mut Line) -> Result<usize, Refusal> {
        let notation = match self.program.dialect {
            Dialect::Okuma => Notation::Okuma,
            _ => Notation::Iso,
        };
        let (end, _) = self.formula(notation, text, (at, at), line, |expressions| {
            expressions.value()?;
            Ok(Target::Condition)
        })?;
        Ok(end)
    }

    /// Returns the next keyword and its end; `None` if no keyword follows.
    fn keyword_at(&self, text: &[u8], at: usize) -> Option<(Keyword, usize)> {
        let start = skip_blanks(text, at);
        let letters = text[start..].iter().take_while(|byte| byte.is_ascii_alphabetic()).count();
        Some((Keyword::of(&text[start..start + letters])?, start + letters))
    }

    /// Reads the destination of a jump, which may have the N of Okuma controls before its number; returns its end.
    fn goto(&mut self, text: &[u8], at: usize, line: &mut Line, when: When) -> Result<usize, Refusal> {
        self.names_sequence = true;
        let mut start = skip_blanks(text, at);
        if self.program.dialect == Dialect::Okuma
            && let Some((label, end)) = self.okuma_name(text, start)
        {
            self.act(Action::Jump { to: Destination::Label(label, Direction::Either), when });
            return Ok(end);
        }
        if text.get(start).is_some_and(|byte| byte.eq_ignore_ascii_case(&b'N')) {
            start += 1;
        }
        if let Some(found) = number(text, start) {
            let Some(id) = whole_number(found.value) else {
                return Err(expected("a block number", line, start));
            };
            let label = Label { kind: LabelKind::Sequence, id };
            self.act(Action::Jump { to: Destination::Label(label, Direction::Either), when });
            return Ok(found.end);
        }
        let (end, _) = self.formula(Notation::Iso, text, (start, start), line, |expressions| {
            expressions.value()?;
            Ok(Target::Destination)
        })?;
        self.act(Action::Jump { to: Destination::Computed(LabelKind::Sequence), when });
        Ok(end)
    }

    /// Reads the number of a loop; returns it with its end.
    fn loop_number(&self, text: &[u8], at: usize, line: &Line) -> Result<(u32, usize), Refusal> {
        let found = number(text, at).and_then(|found| Some((whole_number(found.value)?, found.end)));
        found.ok_or_else(|| expected("the number of a loop", line, at))
    }

    /// Begins a program with a number; the text before belongs to another program.
    pub(super) fn program_number(&mut self, number: f64) {
        self.program_border();
        if let Some(id) = whole_number(number) {
            self.label(LabelKind::Program, id);
        }
    }

    /// Ends a program; another begins.
    pub(super) fn program_border(&mut self) {
        if 0 < self.index() {
            self.act(Action::Border);
            self.end_block();
        }
    }

    /// Labels the blocks with N numbers.
    pub(in crate::simulation::gcode) fn label_sequence(&mut self, text: &[u8]) {
        for (index, line) in crate::simulation::gcode::line::lines(text).enumerate() {
            let mut at = skip_blanks(line, 0);
            if line.get(at) == Some(&b'/') {
                at += 1 + usize::from(line.get(at + 1).is_some_and(u8::is_ascii_digit));
                at = skip_blanks(line, at);
            }
            let is_numbered = line.get(at).is_some_and(|byte| byte.eq_ignore_ascii_case(&b'N'));
            let Some(found) = is_numbered.then(|| number(line, at + 1)).flatten() else { continue };
            let line = index as u32 + 1;
            let block = self.program.blocks.partition_point(|block| block.line.0 < line);
            if let Some(id) = whole_number(found.value) {
                self.program.labels.push((Label { kind: LabelKind::Sequence, id }, block as u32));
            }
        }
    }
}

fn expected(expected: &'static str, line: &Line, at: usize) -> Refusal {
    (Unread::Expected { expected, found: "something else".to_string() }, line.columns(at, at + 1))
}
