//! Lines that hold plain words and nothing else, which is nearly every line of a long program.
//!
//! ```text
//! line   = { blank } { letter number { blank } }      no O word, nothing that calls or returns
//! number = [ "+" | "-" ] digits [ "." [ digits ] ]  |  [ "+" | "-" ] "." digits     without blanks, 15 digits at most
//! ```
//!
//! They are read as the rules for all lines read them, in one pass and without a look at what they cannot be.

use crate::simulation::gcode::iso::{CALLING_G, CALLING_M};
use crate::simulation::gcode::number::{is_blank, plain_number};
use crate::simulation::gcode::reader::Reader;
use crate::simulation::gcode::{Reference, Word};

impl Reader<'_> {
    /// Reads a line of plain words; false where it holds anything else, and then nothing of it is kept.
    pub(super) fn plain_line(&mut self, text: &[u8]) -> bool {
        let words = &mut self.program.words;
        let before = words.len();
        let mut at = 0;
        while let Some(&byte) = text.get(at) {
            if is_blank(byte) {
                at += 1;
                continue;
            }
            let letter = byte.to_ascii_uppercase();
            let number = if letter.is_ascii_uppercase() { plain_number(text, at + 1) } else { None };
            let Some(number) = number.filter(|number| match letter {
                b'O' => false,
                b'G' => !CALLING_G.contains(&number.value),
                b'M' => !CALLING_M.contains(&number.value),
                _ => true,
            }) else {
                words.truncate(before);
                return false;
            };
            if letter != b'N' {
                let columns = (at as u32 + 1, number.end as u32 + 1);
                let (value, has_point, reference) = (number.value, number.has_point, Reference::Modal);
                words.push(Word { value, columns: columns.into(), letter, has_point, reference });
            }
            at = number.end;
        }
        true
    }
}
