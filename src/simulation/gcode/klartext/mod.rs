//! Lines of Heidenhain conversational programs.
//!
//! ```text
//! line      = [ number ] [ "/" ] ( statement | "* -" heading ) [ ";" comment ] [ "~" ]
//! statement = path { word }  |  Q "=" expression  |  "FN" n ":" …  |  "LBL" label  |  "CALL" …
//!           | "TOOL CALL" …  |  "CYCL DEF" …  |  …
//! word      = [ "I" ] address value
//! value     = number  |  [ "+" | "-" ] Q
//! ```
//!
//! A statement of a path becomes a [`KlartextStatement`], followed by its words. `R0`, `RL`, `RR` and `FMAX` are
//! words with longer addresses. A comma between digits is a decimal point.
//!
//! The lines of a cycle are separate blocks: `CYCL DEF 200`, and then `Q200=2` sets the parameter, which the
//! interpreter also keeps for the cycle. Cycles of the older kind (`CYCL DEF 7.1 X+10`) are read by their numbers,
//! since their texts are in the language of the control.
//!
//! `LBL 0` ends a subprogram; `CALL LBL 1 REP 5` jumps back to the label five times; `CALL PGM` calls a program in
//! the same file. FN 18 reads the position; every other value is taken as 0, with a remark.
//!
//! Source: TNC 640, Klartext Programming, 2018; cycles by TNC 640, Cycle Programming, 2018.

mod cycle;
mod functions;
mod heidenhain_iso;
mod names;
mod statement;
mod words;

pub use names::POSITION_PARAMETERS;
pub use statement::{ContourWay, KlartextStatement, Transformation};

use crate::simulation::gcode::klartext::names::{PATHS, WHOLE_LINES};
use crate::simulation::gcode::line::{Line, character_length, excerpt, semicolon};
use crate::simulation::gcode::number::skip_blanks;
use crate::simulation::gcode::reader::{Reader, Refusal};
use crate::simulation::gcode::remark::Unread;
use crate::simulation::gcode::{Action, Keyword, LabelKind};

impl Reader<'_> {
    /// Reads one line of a Klartext program.
    pub(super) fn klartext_line(&mut self, text: &[u8], line: &mut Line) -> Result<(), Refusal> {
        let with_points;
        let mut text = text;
        if text.contains(&b',') {
            with_points = decimal_points(text);
            text = &with_points;
        }
        let end = code_end(text);
        let comment = (end + 1, text.len());
        let continues_with = |part: &[u8]| part.trim_ascii_end().ends_with(b"~");
        let code_continues = continues_with(&text[..end]);
        let continues = code_continues || (end < text.len() && continues_with(&text[end..]));
        let code = text[..end].trim_ascii_end();
        let code = if code_continues { code[..code.len() - 1].trim_ascii_end() } else { code };
        let is_continued = std::mem::replace(&mut self.heidenhain.continued, continues);
        let mut at = self.klartext_number(code, line);
        if at == code.len() {
            if end < text.len() && !is_continued {
                line.comment = Some(comment);
            }
            return Ok(());
        }
        if is_continued && self.heidenhain.skips {
            return Ok(());
        }
        self.heidenhain.skips = false;
        if code[at] == b'/' {
            self.optional += 1;
            if self.optional == 1 {
                self.first_optional = self.line;
            }
            if self.options.block_delete {
                return Ok(());
            }
            at = skip_blanks(code, at + 1);
        }
        let rest = &code[at..];
        if rest.starts_with(b"*") {
            let title = at + rest.iter().take_while(|byte| matches!(byte, b'*' | b'-' | b' ')).count();
            line.comment = Some((title.min(text.len()), text.len()));
            return Ok(());
        }
        if end < text.len() && begins(code, at, &["TOOL", "CALL"]).is_some() {
            line.comment = Some(comment);
        }
        self.klartext_statement(code, at, line)
    }

    /// Returns the start of the code of a line, after the number of its block.
    fn klartext_number(&self, code: &[u8], line: &mut Line) -> usize {
        let start = skip_blanks(code, 0).min(code.len());
        let digits = code[start..].iter().take_while(|byte| byte.is_ascii_digit()).count();
        line.begun = true;
        if code.get(start + digits) == Some(&b'.') {
            return start;
        }
        skip_blanks(code, start + digits).min(code.len())
    }

    /// Reads the statement at `at`.
    fn klartext_statement(&mut self, code: &[u8], at: usize, line: &mut Line) -> Result<(), Refusal> {
        if code.len() <= at {
            return Ok(());
        }
        let found = PATHS.iter().find_map(|(words, name)| Some((begins(code, at, words)?, *name)));
        let whole = WHOLE_LINES.iter().find_map(|(words, name)| Some((begins(code, at, words)?, *name)));
        if let Some((end, statement)) =
            whole.filter(|_| found.is_none_or(|(_, known)| matches!(known, KlartextStatement::Transform(_))))
        {
            self.heidenhain.skips = true;
            if let Some(statement) = statement {
                self.push_klartext(statement, line.columns(at, end));
            }
            return Ok(());
        }
        if let Some((end, statement)) = found {
            return self.klartext_path(code, (at, end), statement, line);
        }
        match code[at].to_ascii_uppercase() {
            b'0'..=b'9' => return self.klartext_cycle(code, at, at, line),
            b'M' if code.get(at + 1).is_some_and(|byte| byte.is_ascii_digit() || *byte == b' ') => {
                return self.klartext_path(code, (at, at), KlartextStatement::Functions, line);
            }
            b'Q' => return self.klartext_parameter(code, at, line),
            _ => {}
        }
        if let Some(outcome) = self.klartext_other(code, at, line) {
            return outcome;
        }
        // `LX+10`, as older controls write it.
        let is_axis = |byte: &u8| matches!(byte.to_ascii_uppercase(), b'X'..=b'Z' | b'I');
        for statement in [KlartextStatement::CircleCenter, KlartextStatement::Line, KlartextStatement::Circle]
        {
            let (name, length) = (statement.name().as_bytes(), statement.name().len());
            let is_it = code[at..].get(..length).is_some_and(|head| head.eq_ignore_ascii_case(name));
            if is_it && code.get(at + length).is_some_and(is_axis) {
                return self.klartext_path(code, (at, at + length), statement, line);
            }
        }
        let length = code[at..].iter().take_while(|byte| byte.is_ascii_alphabetic()).count();
        let length = length.max(character_length(&code[at..]));
        Err((Unread::Text { text: excerpt(&code[at..at + length]) }, line.columns(at, at + length)))
    }

    /// Reads a statement that is not a path; returns `None` if the line begins with no such words.
    fn klartext_other(&mut self, code: &[u8], at: usize, line: &mut Line) -> Option<Result<(), Refusal>> {
        let ends = |words: &[&str]| begins(code, at, words);
        if let Some(end) = ends(&["BEGIN", "PGM"]) {
            self.klartext_begin(code, (at, end), line);
            return Some(Ok(()));
        }
        if ends(&["END", "PGM"]).is_some() {
            self.act(Action::Border);
            return Some(Ok(()));
        }
        Some(if let Some(end) = ends(&["TOOL", "CALL"]) {
            self.klartext_tool_call(code, (at, end), line)
        } else if let Some(end) = ends(&["TOOL", "DEF"]) {
            self.klartext_tool_definition(code, (at, end), line)
        } else if let Some(end) = ends(&["CYCL", "DEF"]).or(ends(&["CYCLE", "DEF"])) {
            self.klartext_cycle(code, at, end, line)
        } else if let Some(end) = ends(&["LBL"]) {
            self.klartext_label(code, end, line)
        } else if let Some(end) = ends(&["CALL", "LBL"]) {
            self.klartext_call(code, end, line)
        } else if let Some(end) = ends(&["CALL", "PGM"]) {
            self.klartext_call_program(code, end);
            Ok(())
        } else if let Some(end) = ends(&["IF"]) {
            self.klartext_if(code, (at, end), line)
        } else if let Some(end) = ends(&["FN"]) {
            self.klartext_function(code, (at, end), line)
        } else {
            return None;
        })
    }

    /// Reads the rest of `BEGIN PGM`.
    fn klartext_begin(&mut self, code: &[u8], (at, end): (usize, usize), line: &Line) {
        let rest = code[end..].trim_ascii();
        let (name, unit) = match rest.iter().rposition(|byte| *byte == b' ') {
            Some(blank) => (&rest[..blank], &rest[blank + 1..]),
            None => (rest, &b""[..]),
        };
        self.begin_program(name, unit.eq_ignore_ascii_case(b"INCH"), line.columns(at, end));
    }

    /// Begins a program; calls find it by its name.
    fn begin_program(&mut self, name: &[u8], is_inch: bool, columns: (u32, u32)) {
        if 0 < self.index() {
            self.act(Action::Border);
            self.end_block();
        }
        let id = self.names.index(program_name(name));
        self.label(LabelKind::Named, id);
        self.push_klartext(KlartextStatement::Unit { is_inch }, columns);
    }

    /// Adds a statement to the block being read.
    fn push_klartext(&mut self, statement: KlartextStatement, columns: (u32, u32)) {
        self.push_statement(Keyword::Klartext(statement), columns);
    }
}

/// Returns the name of a program as calls look it up: without folders and `.H`.
fn program_name(written: &[u8]) -> String {
    let written = String::from_utf8_lossy(written.trim_ascii()).to_ascii_lowercase();
    let name = written.trim_matches('"').rsplit(['\\', '/', ':']).next().unwrap_or_default();
    let name = name.strip_suffix(".h").or(name.strip_suffix(".i")).unwrap_or(name);
    format!("program {name}")
}

/// Returns the end of `words` if they are at `at` with blanks between them, as whole words; else `None`.
fn begins(code: &[u8], at: usize, words: &[&str]) -> Option<usize> {
    let mut end = at;
    for (index, word) in words.iter().enumerate() {
        let start = if index == 0 { end } else { skip_blanks(code, end) };
        let found = code.get(start..start + word.len())?;
        if !found.eq_ignore_ascii_case(word.as_bytes()) {
            return None;
        }
        end = start + word.len();
    }
    let is_whole = !code.get(end).is_some_and(u8::is_ascii_alphabetic);
    is_whole.then_some(end)
}

/// Returns the start of a comment, or the end of the line.
fn code_end(text: &[u8]) -> usize {
    let mut is_quoted = false;
    for (index, byte) in text.iter().enumerate() {
        match byte {
            b'"' => is_quoted = !is_quoted,
            b';' if !is_quoted => return index,
            _ => {}
        }
    }
    // A quotation mark without its partner does not begin a text.
    if is_quoted { semicolon(text, 0) } else { text.len() }
}

/// Returns the line with a point for each comma between digits.
fn decimal_points(text: &[u8]) -> Vec<u8> {
    let mut changed = text.to_vec();
    for index in 1..text.len() {
        let is_digit = |at: usize| text.get(at).is_some_and(u8::is_ascii_digit);
        if text[index] == b',' && is_digit(index - 1) && is_digit(index + 1) {
            changed[index] = b'.';
        }
    }
    changed
}
