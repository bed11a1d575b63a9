//! The reader: one pass over the bytes, line by line.

use crate::simulation::gcode::expression::{Expressions, Fault, Names, Place as Parameter};
use crate::simulation::gcode::line::{
    CommentEnd, Line, character_length, code_end, comment_end, excerpt, is_checksum, is_continuation, lines,
    split_line,
};
use crate::simulation::gcode::number::{is_blank, number, skip_blanks};
use crate::simulation::gcode::remark::Unread;
use crate::simulation::gcode::{Block, Formula, LineNumber, Place, Program, Remarks, Target, Word};

/// What the operator sets at the control before the program runs.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Options {
    /// The block delete switch: blocks that begin with `/` are left out. Off by default.
    pub block_delete: bool,
}

/// Reads a program with the switches of the control at rest.
pub fn read(bytes: &[u8]) -> Program {
    read_with(bytes, &Options::default())
}

/// Reads a program.
pub fn read_with(bytes: &[u8], options: &Options) -> Program {
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let mut reader = Reader::new(options);
    let mut rest = text;
    while let Some((line, after)) = split_line(rest) {
        reader.line.0 = reader.line.0.saturating_add(1);
        rest = after;
        if line.get(skip_blanks(line, 0)) != Some(&b'%') {
            reader.block(line);
        } else if reader.percent_closes(rest) {
            reader.trailer(rest);
            break;
        }
    }
    reader.finish()
}

/// The words that begin or end jumps, loops and subroutines, on Fanuc controls and LinuxCNC.
const FLOW: [&str; 20] = [
    "IF",
    "THEN",
    "ELSE",
    "ELSEIF",
    "ENDIF",
    "GOTO",
    "WHILE",
    "WH",
    "ENDWHILE",
    "DO",
    "END",
    "REPEAT",
    "ENDREPEAT",
    "BREAK",
    "CONTINUE",
    "SUB",
    "ENDSUB",
    "CALL",
    "RETURN",
    "ENDDO",
];

/// Why a block is not run, and the columns it concerns.
type Refusal = (Unread, (u32, u32));

struct Reader<'a> {
    options: &'a Options,
    line: LineNumber,
    program: Program,
    names: Names,
    remarks: Remarks<Unread>,
    /// How many blocks began with `/`, and the first of them.
    optional: usize,
    first_optional: LineNumber,
    /// A `%` line was seen.
    opened: bool,
}

impl<'a> Reader<'a> {
    fn new(options: &'a Options) -> Reader<'a> {
        Reader {
            options,
            line: LineNumber(0),
            program: Program::default(),
            names: Names::default(),
            remarks: Remarks::default(),
            optional: 0,
            first_optional: LineNumber(0),
            opened: false,
        }
    }

    /// A `%` line: whether it ends the program. What was read before an opening one is leader.
    fn percent_closes(&mut self, rest: &[u8]) -> bool {
        self.program.is_tape = true;
        let another_follows = || lines(rest).any(|line| line.get(skip_blanks(line, 0)) == Some(&b'%'));
        let is_first = self.program.blocks.is_empty() && self.remarks.is_empty();
        if self.opened || (!is_first && !another_follows()) {
            return true;
        }
        self.opened = true;
        let blocks = self.program.blocks.len();
        self.program.blocks.clear();
        self.program.words.clear();
        self.program.formulas.clear();
        self.program.steps.clear();
        self.optional = 0;
        self.remarks = Remarks::default();
        if 0 < blocks {
            self.remarks.add(Place::line(self.line), Unread::Leader { blocks });
        }
        false
    }

    /// Whatever follows the closing `%` is not read, but said.
    fn trailer(&mut self, rest: &[u8]) {
        let is_empty = |line: &[u8]| line.iter().all(|byte| is_blank(*byte) || *byte == b'%');
        if let Some(offset) = lines(rest).position(|line| !is_empty(line)) {
            let line = LineNumber(self.line.0.saturating_add(offset as u32 + 1));
            self.remarks.add(Place::line(line), Unread::Trailer);
        }
    }

    fn finish(mut self) -> Program {
        if 0 < self.optional {
            let blocks = self.optional;
            let remark = match self.options.block_delete {
                true => Unread::OptionalSkipped { blocks },
                false => Unread::OptionalRun { blocks },
            };
            self.remarks.add(Place::line(self.first_optional), remark);
        }
        self.program.names = self.names.finish();
        self.program.diagnostics = self.remarks.finish();
        self.program
    }

    /// Reads one line; a block with a fault leaves nothing behind.
    fn block(&mut self, text: &[u8]) {
        let program = &self.program;
        let [words, formulas, steps] = [program.words.len(), program.formulas.len(), program.steps.len()];
        if let Err((remark, columns)) = self.words(text) {
            self.program.words.truncate(words);
            self.program.formulas.truncate(formulas);
            self.program.steps.truncate(steps);
            self.remarks.add(Place { line: self.line, columns }, remark);
        }
        if words < self.program.words.len() || formulas < self.program.formulas.len() {
            let words = words as u32..self.program.words.len() as u32;
            self.program.blocks.push(Block { line: self.line, words });
        }
    }

    fn words(&mut self, text: &[u8]) -> Result<(), Refusal> {
        let mut line = Line::default();
        let mut at = 0;
        while let Some(&byte) = text.get(at) {
            match byte {
                b'a'..=b'z' | b'A'..=b'Z' => at = self.word(text, at, &mut line)?,
                byte if is_blank(byte) => at += 1,
                b'(' => at = self.comment(text, at, &mut line),
                b';' => break,
                b':' if !line.begun => {
                    let end = number(text, at + 1).map_or(at + 1, |number| number.end);
                    self.program.is_tape = true;
                    line.begun = true;
                    at = end;
                }
                b'/' if !line.begun => {
                    self.optional += 1;
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
                b'#' => at = self.assignment(text, at, &mut line)?,
                _ => {
                    let text = excerpt(&text[at..at + character_length(&text[at..])]);
                    return Err((Unread::Text { text }, line.columns(at, at + 1)));
                }
            }
        }
        self.program.is_tape |= line.has_o_word;
        Ok(())
    }

    /// Reads the word whose letter stands at `at`; returns where it ends.
    fn word(&mut self, text: &[u8], at: usize, line: &mut Line) -> Result<usize, Refusal> {
        let letter = text[at].to_ascii_uppercase();
        let Some(found) = number(text, at + 1) else {
            return self.word_without_number(text, at, line);
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
            b'O' => line.has_o_word = true,
            _ => self.program.words.push(Word {
                value: found.value,
                columns: line.columns(at, found.end),
                letter,
                has_point: found.has_point,
            }),
        }
        line.begun = true;
        Ok(found.end)
    }

    /// A letter that no number follows: an expression, a name, or a slip of the pen.
    fn word_without_number(&mut self, text: &[u8], at: usize, line: &mut Line) -> Result<usize, Refusal> {
        let letter = text[at].to_ascii_uppercase();
        let length = text[at..].iter().take_while(|byte| byte.is_ascii_alphabetic()).count();
        let signs = |byte: &u8| matches!(byte, b'.' | b'+' | b'-') || is_blank(*byte);
        let next = at + 1 + text[at + 1..].iter().take_while(|byte| signs(byte)).count();
        if letter == b'O' && matches!(text.get(next), Some(b'<' | b'[' | b'#')) {
            let end = code_end(text, at);
            return Err((Unread::Flow { text: excerpt(&text[at..end]) }, line.columns(at, end)));
        }
        if letter != b'N' && Expressions::begin_at(text, at + 1) {
            return self.word_with_formula(text, at, line);
        }
        if 1 < length {
            let (name, columns) = (&text[at..at + length], line.columns(at, at + length));
            let text = excerpt(name);
            let is_flow = FLOW.iter().any(|keyword| name.eq_ignore_ascii_case(keyword.as_bytes()));
            return Err((if is_flow { Unread::Flow { text } } else { Unread::Text { text } }, columns));
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

    /// Reads the word whose letter stands at `at` and whose value is to be worked out.
    fn word_with_formula(&mut self, text: &[u8], at: usize, line: &mut Line) -> Result<usize, Refusal> {
        let target = Target::Word(self.program.words.len() as u32);
        let (end, columns) = self.formula(text, (at, at + 1), line, |expressions| {
            expressions.value()?;
            Ok(target)
        })?;
        let letter = text[at].to_ascii_uppercase();
        self.program.words.push(Word { value: f64::NAN, columns, letter, has_point: false });
        Ok(end)
    }

    /// Reads the assignment whose `#` stands at `at`; returns where it ends.
    fn assignment(&mut self, text: &[u8], at: usize, line: &mut Line) -> Result<usize, Refusal> {
        let (end, _) = self.formula(text, (at, at), line, |expressions| {
            Ok(match expressions.assignment()? {
                Parameter::Numbered => Target::Numbered,
                Parameter::Named(name) => Target::Named(name),
            })
        })?;
        Ok(end)
    }

    /// Keeps what `read` reads from the second of `starts` on as a formula whose columns begin at
    /// the first; returns where it ends, and its columns.
    fn formula(
        &mut self,
        text: &[u8],
        starts: (usize, usize),
        line: &mut Line,
        read: impl FnOnce(&mut Expressions) -> Result<Target, Fault>,
    ) -> Result<(usize, (u32, u32)), Refusal> {
        let first_step = self.program.steps.len() as u32;
        let (first, _) = line.columns(starts.0, starts.0);
        let mut expressions = Expressions::new(text, starts.1, &mut self.program.steps, &mut self.names);
        let outcome = read(&mut expressions);
        let end = expressions.at;
        line.continuation += expressions.continuation;
        line.begun = true;
        let target = outcome.map_err(|(remark, bytes)| (remark, line.columns(bytes.start, bytes.end)))?;
        let (past, _) = line.columns(end, end);
        let steps = first_step..self.program.steps.len() as u32;
        self.program.formulas.push(Formula { line: self.line, target, steps, columns: (first, past) });
        Ok((end, (first, past)))
    }

    /// Leaves out the letter at `at` with all that looks like its number; returns where it ends.
    fn leave_out(&mut self, text: &[u8], at: usize, line: &Line, remark: fn(String) -> Unread) -> usize {
        let belongs = |byte: &u8| matches!(byte, b'0'..=b'9' | b'.' | b'+' | b'-') || is_blank(*byte);
        let length = text[at + 1..].iter().take_while(|byte| belongs(byte)).count();
        let end = at + 1 + text[at + 1..at + 1 + length].trim_ascii_end().len();
        let place = Place { line: self.line, columns: line.columns(at, end) };
        self.remarks.add(place, remark(excerpt(&text[at..end])));
        end
    }

    /// Skips the comment that opens at `at`; returns where it ends.
    fn comment(&mut self, text: &[u8], at: usize, line: &mut Line) -> usize {
        let end = match comment_end(&text[at..], line.is_unbalanced) {
            CommentEnd::Matching(length) => at + length,
            CommentEnd::First(length) => {
                line.is_unbalanced = true;
                at + length
            }
            CommentEnd::Missing => text.len(),
        };
        let (first, _) = line.columns(at, at);
        line.continuation += text[at..end].iter().filter(|byte| is_continuation(**byte)).count();
        if text[end - 1] != b')' {
            let (past, _) = line.columns(end, end);
            self.remarks.add(Place { line: self.line, columns: (first, past) }, Unread::OpenComment);
        }
        end
    }
}

#[cfg(test)]
mod tests;
