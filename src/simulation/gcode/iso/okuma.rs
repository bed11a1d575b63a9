//! Words of Okuma OSP controls that differ from ISO.
//!
//! ```text
//! variables    VC1=5     V1=2     DIA=10 (a name of the program)     X=VC1+2     X=[VC1*2]
//! flow         IF [VC1 EQ 2] N100     GOTO NEND     NEND     CALL O1000 Q3     RTS
//! ```
//!
//! `CALL O1000` may pass values by names of the subprogram (`CALL O1000 DIA=10`). NOEX, which hides a block on the
//! screen, has no effect. NCYL (no hole in this block) is a word for the interpreter. Diagnostics name MODIN and
//! MODOUT, calls after every move, system variables (`VZOFZ[1]=0`) and FA=, the feedrate out of a bore.
//!
//! Source: Okuma OSP-P300M programming manual, ch. 12 and 13.

use crate::simulation::gcode::expression::{Notation, identifier, okuma_number};
use crate::simulation::gcode::line::{Line, code_end, excerpt};
use crate::simulation::gcode::number::{number, skip_blanks};
use crate::simulation::gcode::reader::{Reader, Refusal};
use crate::simulation::gcode::remark::Unread;
use crate::simulation::gcode::{
    Action, Destination, Direction, Label, LabelKind, Place, Reference, Step, Target, address,
};

/// Longest name, bytes; with a bound, a line without blanks is not searched again from each of its words.
const MAX_NAME_LENGTH: usize = 64;

impl Reader<'_> {
    /// Reads an item at `at` that only Okuma controls have; returns its end, or `None` if there is none.
    pub(super) fn okuma_item(
        &mut self,
        text: &[u8],
        at: usize,
        line: &mut Line,
    ) -> Result<Option<usize>, Refusal> {
        let length = identifier(&text[at..text.len().min(at + MAX_NAME_LENGTH)]);
        let end = at + length;
        let name = text[at..end].to_ascii_uppercase();
        let equals = skip_blanks(text, end);
        if name.starts_with(b"V") && text.get(equals) == Some(&b'[') {
            let what = "system variables are not modelled: left out";
            return Ok(Some(self.okuma_left_out(text, (at, code_end(text, at)), what, line)));
        }
        if text.get(equals) == Some(&b'=') {
            if &name[..] == b"FA" {
                let what = "a feedrate out of the hole is not modelled: the tool leaves it at F";
                let past = number(text, equals + 1).map_or(equals + 1, |number| number.end);
                return Ok(Some(self.okuma_left_out(text, (at, past), what, line)));
            }
            return self.okuma_assignment(text, (at, end), equals + 1, line).map(Some);
        }
        match &name[..] {
            b"NOEX" => Ok(Some(end)),
            b"RTS" => {
                line.begun = true;
                self.act(Action::Return);
                Ok(Some(end))
            }
            b"NCYL" => {
                line.begun = true;
                self.push_word(address::NO_CYCLE, 1.0, line.columns(at, end));
                Ok(Some(end))
            }
            _ if !line.begun && self.okuma_name(text, at).is_some() => {
                let label = self.okuma_name(text, at).map(|(label, _)| label);
                label.into_iter().for_each(|label| self.label(label.kind, label.id));
                Ok(Some(end))
            }
            b"CALL" => self.okuma_call(text, end, line).map(Some),
            b"MODIN" | b"MODOUT" => {
                let word = String::from_utf8_lossy(&name).into_owned();
                Err((Unread::ModalCall { word }, line.columns(at, code_end(text, at))))
            }
            _ => Ok(None),
        }
    }

    /// Returns the name of a block (`NLOOP`) at `at` as a label, and its end; `None` if there is none.
    pub(super) fn okuma_name(&mut self, text: &[u8], at: usize) -> Option<(Label, usize)> {
        let length = identifier(&text[at..text.len().min(at + MAX_NAME_LENGTH)]);
        let name = &text[at..at + length];
        let is_name = name.first().is_some_and(|first| first.eq_ignore_ascii_case(&b'N'))
            && name.get(1).is_some_and(u8::is_ascii_alphabetic);
        let id = is_name.then(|| self.names.index(String::from_utf8_lossy(name).to_ascii_lowercase()))?;
        Some((Label { kind: LabelKind::Named, id }, at + length))
    }

    /// Leaves out the text between `ends` and remarks on it; returns its end.
    fn okuma_left_out(
        &mut self,
        text: &[u8],
        ends: (usize, usize),
        what: &'static str,
        line: &mut Line,
    ) -> usize {
        let (at, end) = ends;
        let place = Place { line: self.line, columns: line.columns(at, end) };
        self.remarks.add(place, Unread::Own { name: excerpt(&text[at..end]), what });
        line.begun = true;
        end
    }

    /// Reads `X=VC1+2`, which is a word, or `VC1=2` and `DIA=2`, which are variables; returns the end.
    fn okuma_assignment(
        &mut self,
        text: &[u8],
        (at, end): (usize, usize),
        value: usize,
        line: &mut Line,
    ) -> Result<usize, Refusal> {
        let name = &text[at..end];
        let index = self.program.words.len() as u32;
        let (target, number) = match okuma_number(name) {
            _ if name.len() == 1 => (Target::Word(index), None),
            Some(number) => (Target::Numbered, Some(number)),
            None => {
                let name = String::from_utf8_lossy(name).to_ascii_lowercase();
                (Target::Named(self.names.index(name)), None)
            }
        };
        let (end, columns) = self.formula(Notation::Okuma, text, (at, value), line, |expressions| {
            expressions.steps.extend(number.map(|number| Step::Number(f64::from(number))));
            expressions.expression(0)?;
            Ok(target)
        })?;
        if name.len() == 1 {
            self.push_computed(name[0].to_ascii_uppercase(), Reference::Modal, columns);
        }
        Ok(end)
    }

    /// Reads `CALL O1000 Q3 DIA=10`; returns the end of the count.
    fn okuma_call(&mut self, text: &[u8], at: usize, line: &mut Line) -> Result<usize, Refusal> {
        let start = skip_blanks(text, at);
        let length = identifier(&text[start..]);
        let name = text[start..start + length].to_ascii_uppercase();
        let Some(id) = name.strip_prefix(b"O") else {
            let found = excerpt(&text[start..]);
            let expected = "the O name of a program";
            return Err((Unread::Expected { expected, found }, line.columns(start, start + 1)));
        };
        let number: Option<u32> = std::str::from_utf8(id).ok().and_then(|digits| digits.parse().ok());
        let label = match number {
            Some(id) => Label { kind: LabelKind::Program, id },
            None => {
                let id = self.names.index(String::from_utf8_lossy(&name).to_ascii_lowercase());
                Label { kind: LabelKind::Named, id }
            }
        };
        line.begun = true;
        let mut end = start + length;
        let next = skip_blanks(text, end);
        let is_count = text.get(next).is_some_and(|byte| byte.eq_ignore_ascii_case(&b'Q'));
        if is_count && number_follows(text, next + 1) {
            (end, _) = self.formula(Notation::Okuma, text, (next, next + 1), line, |expressions| {
                expressions.value()?;
                Ok(Target::Count)
            })?;
        }
        let to = Destination::Label(label, Direction::Either);
        self.act(Action::Call { to, has_own_parameters: false });
        Ok(end)
    }
}

fn number_follows(text: &[u8], at: usize) -> bool {
    number(text, at).is_some()
}
