//! `CYCL DEF`: the number of a cycle, and its parameters.

use crate::simulation::gcode::expression::klartext_number;
use crate::simulation::gcode::klartext::KlartextStatement;
use crate::simulation::gcode::klartext::words::{found_at, plain};
use crate::simulation::gcode::line::{Line, continuation};
use crate::simulation::gcode::number::skip_blanks;
use crate::simulation::gcode::reader::{Reader, Refusal};
use crate::simulation::gcode::remark::Unread;
use crate::simulation::gcode::{Reference, address};

/// Cycles whose lines hold words of axes: datum shift, mirror image, working plane, scaling.
const WITH_AXES: &[u32] = &[7, 8, 19, 26];

impl Reader<'_> {
    /// Reads the number of a cycle at `start` and its parameters.
    pub(super) fn klartext_cycle(
        &mut self,
        code: &[u8],
        at: usize,
        start: usize,
        line: &mut Line,
    ) -> Result<(), Refusal> {
        let start = skip_blanks(code, start);
        let digits = |at: usize| code[at..].iter().take_while(|byte| byte.is_ascii_digit()).count();
        let length = if start < code.len() { digits(start) } else { 0 };
        if length == 0 {
            let columns = line.columns(at, code.len());
            return Err((
                Unread::Expected { expected: "the number of a cycle", found: found_at(code, start) },
                columns,
            ));
        }
        let value = |at: usize, length: usize| {
            std::str::from_utf8(&code[at..at + length]).ok().and_then(|digits| digits.parse::<u32>().ok())
        };
        let number = value(start, length).unwrap_or(u32::MAX);
        let mut next = start + length;
        let mut step = None;
        if code.get(next) == Some(&b'.') {
            let length = digits(next + 1);
            step = Some(value(next + 1, length).unwrap_or(0));
            next += 1 + length;
        }
        let columns = line.columns(at, next);
        self.push_klartext(KlartextStatement::CycleDefinition { number, step }, columns);
        let Some(step) = step else { return self.klartext_cycle_parameters(code, next, line) };
        match step {
            0 => Ok(()),
            _ if WITH_AXES.contains(&number) => self.klartext_cycle_axes(code, next, number == 8, line),
            // Names of programs.
            _ if number == 12 => Ok(()),
            _ => self.klartext_setting(code, next, line),
        }
    }

    /// Reads `Q200=2 Q201=-20` after the name of the cycle on the same line.
    pub(super) fn klartext_cycle_parameters(
        &mut self,
        code: &[u8],
        mut at: usize,
        line: &mut Line,
    ) -> Result<(), Refusal> {
        while at < code.len() {
            let is_word = at == 0 || !code[at - 1].is_ascii_alphanumeric();
            match klartext_number(&code[at..]).filter(|_| is_word) {
                Some((_, length)) if code.get(skip_blanks(code, at + length)) == Some(&b'=') => {
                    at = self.klartext_assignment(code, at, line)?;
                }
                _ => {
                    line.continuation += continuation(&code[at..at + 1]);
                    at += 1;
                }
            }
        }
        Ok(())
    }

    /// Reads `X+10 IY-5`, `X Y`, `A+0 B+45`, `X1.2 CCX+15`, `#5`.
    fn klartext_cycle_axes(
        &mut self,
        code: &[u8],
        mut next: usize,
        is_mirror: bool,
        line: &mut Line,
    ) -> Result<(), Refusal> {
        loop {
            next = skip_blanks(code, next);
            let Some(rest) = code.get(next..).filter(|rest| !rest.is_empty()) else { return Ok(()) };
            let letters = rest.iter().take_while(|byte| byte.is_ascii_alphabetic()).count();
            let word = rest[..letters].to_ascii_uppercase();
            let (axis, reference) = match &word[..] {
                [axis @ (b'A'..=b'C' | b'U'..=b'Z')] => (*axis, Reference::Modal),
                [b'I', axis @ (b'A'..=b'C' | b'U'..=b'Z')] => (*axis, Reference::Incremental),
                [b'C', b'C', axis @ b'X'..=b'Z'] => (b"IJK"[usize::from(axis - b'X')], Reference::Modal),
                _ if rest[0] == b'#' => {
                    next = self.klartext_value(
                        code,
                        (next, next + 1),
                        address::SETTING,
                        Reference::Modal,
                        line,
                    )?;
                    continue;
                }
                // Names in the language of the control (feedrate, set-up clearance).
                _ if 0 < letters => {
                    next += letters;
                    next += code[next..].iter().take_while(|byte| **byte != b' ').count();
                    continue;
                }
                _ => {
                    next += 1;
                    continue;
                }
            };
            if is_mirror {
                self.push_word(axis, 1.0, line.columns(next, next + letters));
                next += letters;
            } else {
                next = self.klartext_value(code, (next, next + letters), axis, reference, line)?;
            }
        }
    }

    /// Reads the value of a line such as `DEPTH-20`, `ZUSTLG -5`, `V.ZEIT5`, `IROT+30`, `HSC-MODE:1 TA5`: the
    /// first number that is not part of a word.
    pub(super) fn klartext_setting(
        &mut self,
        code: &[u8],
        start: usize,
        line: &mut Line,
    ) -> Result<(), Refusal> {
        let text = &code[start..];
        for at in 0..text.len() {
            let is_first_sign = |at: usize| {
                let next = text.get(skip_blanks(text, at + 1));
                matches!(text[at], b'+' | b'-')
                    && next.is_some_and(|byte| byte.is_ascii_digit() || matches!(byte, b'.' | b'Q' | b'q'))
            };
            let begins_parameter = || {
                let is_alone = at == 0 || !text[at - 1].is_ascii_alphabetic();
                is_alone && klartext_number(&text[at..]).is_some()
            };
            let begins_number = text[at].is_ascii_digit() && plain(text, at).is_some();
            if begins_number || is_first_sign(at) || begins_parameter() {
                let before = text[..at].trim_ascii();
                let is_incremental = before.eq_ignore_ascii_case(b"IROT");
                let reference = if is_incremental { Reference::Incremental } else { Reference::Modal };
                self.klartext_value(code, (start + at, start + at), address::SETTING, reference, line)?;
                return Ok(());
            }
        }
        line.continuation += continuation(text);
        Ok(())
    }
}
