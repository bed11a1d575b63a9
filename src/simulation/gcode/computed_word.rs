//! Words whose value is a formula: `X[#1+2]`, `X=R1+2`, `XQ1`.
//!
//! The formula has the word as its target, and the word has no value (NaN) until the interpreter computes it.

use crate::simulation::gcode::expression::Notation;
use crate::simulation::gcode::line::Line;
use crate::simulation::gcode::reader::{Reader, Refusal};
use crate::simulation::gcode::{Reference, Target, Word};

impl Reader<'_> {
    /// Reads the value of the next word from the second of `starts` on, with columns from the first. Returns its end
    /// and its columns. In SINUMERIK programs a value is a whole expression, in others one operand.
    pub(super) fn formula_of_word(
        &mut self,
        notation: Notation,
        text: &[u8],
        starts: (usize, usize),
        line: &mut Line,
    ) -> Result<(usize, (u32, u32)), Refusal> {
        let target = Target::Word(self.program.words.len() as u32);
        self.formula(notation, text, starts, line, |expressions| {
            match notation {
                Notation::Siemens => expressions.expression(0)?,
                _ => expressions.value()?,
            }
            Ok(target)
        })
    }

    /// Adds the word of the formula read last.
    pub(super) fn push_computed(&mut self, letter: u8, reference: Reference, columns: (u32, u32)) {
        let word = Word { value: f64::NAN, columns: columns.into(), letter, has_point: false, reference };
        self.program.words.push(word);
    }
}
