//! Frames as values.
//!
//! ```text
//! $P_PFRAME=CTRANS(X,10,Y,20):CROT(Z,90)      TRANS X10 Y20, then AROT Z90
//! $P_PFRAME=$P_PFRAME:CSCALE(X,2)             ASCALE X2
//! $P_PFRAME=CMIRROR(X)                        MIRROR X0
//! ```
//!
//! Each part becomes the equivalent statement in its own block. Other parts, and other frames (`$P_UIFR[1]`), have
//! no model; a remark names them.

use crate::simulation::gcode::expression::{Notation, identifier};
use crate::simulation::gcode::line::{Line, excerpt, semicolon};
use crate::simulation::gcode::number::skip_blanks;
use crate::simulation::gcode::reader::{Reader, Refusal};
use crate::simulation::gcode::remark::Unread;
use crate::simulation::gcode::siemens::keywords::known;

/// Parts of a frame, each with the statement that replaces the frame in force and the statement that adds to it.
const PARTS: [(&[u8], &str, &str); 4] = [
    (b"CTRANS", "TRANS", "ATRANS"),
    (b"CROT", "ROT", "AROT"),
    (b"CSCALE", "SCALE", "ASCALE"),
    (b"CMIRROR", "MIRROR", "AMIRROR"),
];

impl Reader<'_> {
    /// Reads the value of `$P_PFRAME`; returns its end.
    pub(super) fn siemens_frame_value(
        &mut self,
        text: &[u8],
        at: usize,
        line: &mut Line,
    ) -> Result<usize, Refusal> {
        let mut start = skip_blanks(text, at);
        let mut is_added = false;
        loop {
            let end = start + identifier(&text[start..]);
            let name = text[start..end].to_ascii_uppercase();
            let part = PARTS.iter().find(|(known, ..)| *known == name);
            let next = match part {
                Some((_, replacing, adding)) => {
                    self.end_block();
                    let is_mirror = name == b"CMIRROR";
                    let name = if is_added { adding } else { replacing };
                    self.push_statement(known(name), line.columns(start, end));
                    self.siemens_frame_axes(text, end, is_mirror, line)?
                }
                None if name == b"$P_PFRAME" && !is_added => end,
                None => return Ok(self.siemens_other_frame(text, start, line)),
            };
            is_added = true;
            let colon = skip_blanks(text, next);
            if text.get(colon) != Some(&b':') {
                return Ok(next);
            }
            start = skip_blanks(text, colon + 1);
        }
    }

    /// Reads a frame without a model, to the end of its line.
    pub(super) fn siemens_other_frame(&mut self, text: &[u8], at: usize, line: &Line) -> usize {
        let end = semicolon(text, at);
        self.push_statement(known("$P_UIFR"), line.columns(at, end));
        end
    }

    /// Reads `(X,10,Y,20)`, or `(X,Y)` for axes without values; returns the end.
    fn siemens_frame_axes(
        &mut self,
        text: &[u8],
        at: usize,
        is_mirror: bool,
        line: &mut Line,
    ) -> Result<usize, Refusal> {
        let mut next = skip_blanks(text, at);
        let missing = |expected, at: usize, line: &Line| {
            let found = excerpt(text.get(at..).unwrap_or_default());
            Err((Unread::Expected { expected, found }, line.columns(at, at + 1)))
        };
        if text.get(next) != Some(&b'(') {
            return missing("`(`", next, line);
        }
        loop {
            next = skip_blanks(text, next + 1);
            match text.get(next).map(u8::to_ascii_uppercase) {
                Some(b')') => return Ok(next + 1),
                Some(letter @ b'X'..=b'Z') if is_mirror => {
                    self.push_word(letter, 0.0, line.columns(next, next + 1));
                    next += 1;
                }
                Some(letter @ b'X'..=b'Z') => {
                    let comma = skip_blanks(text, next + 1);
                    if text.get(comma) != Some(&b',') {
                        return missing("`,`", comma, line);
                    }
                    let (end, columns) =
                        self.formula_of_word(Notation::Siemens, text, (next, comma + 1), line)?;
                    self.push_word(letter, f64::NAN, columns);
                    next = end;
                }
                _ => return missing("X, Y, Z or `)`", next, line),
            }
            next = skip_blanks(text, next);
            match text.get(next) {
                Some(b',') => {}
                Some(b')') => return Ok(next + 1),
                _ => return missing("`,` or `)`", next, line),
            }
        }
    }
}
