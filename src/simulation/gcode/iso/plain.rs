//! Lines of plain words alone, which are nearly all lines of a long program.
//!
//! ```text
//! line   = { blank } { letter number { blank } }      no O word, no word that calls or returns
//! number = [ "+" | "-" ] digits [ "." [ digits ] ]  |  [ "+" | "-" ] "." digits     without blanks, and not long
//! ```
//!
//! The result equals that of the rules for all lines, but takes one pass with the end of the line, and no tests
//! for items that such a line cannot have.

use crate::simulation::gcode::iso::{CALLING_G, CALLING_M};
use crate::simulation::gcode::number::{is_blank, plain_number};
use crate::simulation::gcode::reader::Reader;
use crate::simulation::gcode::{Columns, Reference, Word};

impl Reader<'_> {
    /// Reads the line that `text` begins with, and returns the text behind it. Returns `None`, and keeps no word,
    /// if the line has other items than plain words.
    pub(in crate::simulation::gcode) fn plain_line<'a>(&mut self, text: &'a [u8]) -> Option<&'a [u8]> {
        let words = &mut self.program.words;
        let before = words.len();
        let mut at = 0;
        let end = loop {
            let letter = match text.get(at) {
                Some(byte) if !is_blank(*byte) => byte.to_ascii_uppercase(),
                None => break at,
                Some(b'\n') => break at + 1,
                Some(b'\r') => break at + 1 + usize::from(text.get(at + 1) == Some(&b'\n')),
                Some(_) => {
                    at += 1;
                    continue;
                }
            };
            let number = if letter.is_ascii_uppercase() { plain_number(text, at + 1) } else { None };
            let Some(number) = number.filter(|number| match letter {
                b'O' => false,
                b'G' => !CALLING_G.contains(&number.value),
                b'M' => !CALLING_M.contains(&number.value),
                _ => true,
            }) else {
                words.truncate(before);
                return None;
            };
            if letter != b'N' {
                let columns = Columns::of_width(at as u32 + 1, (number.end - at) as u8);
                let (value, has_point, reference) = (number.value, number.has_point, Reference::Modal);
                words.push(Word { value, columns, letter, has_point, reference });
            }
            at = number.end;
        };
        self.end_block_of_words();
        Some(&text[end..])
    }
}

#[cfg(test)]
mod tests {
    use crate::simulation::gcode::read;

    /// A comment makes a line go the long way, and changes nothing else.
    #[test]
    fn plain_lines_are_read_as_all_lines_are() {
        let pieces =
            "G1|X|Y|Z|g0|F|N10|5|-|+|.|0|12.345|1234567890123456| |  |\t|M98|O|T1|1.2.3|5-|X1 2|Z-.5";
        let pieces: Vec<&str> = pieces.split('|').collect();
        let mut state = 0x2545_f491_4f6c_dd1d_u64;
        for _ in 0..50_000 {
            let mut line = String::new();
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (0..state % 10).for_each(|k| line += pieces[(state >> (6 * k)) as usize % pieces.len()]);
            let (plain, long) = (read(line.as_bytes()), read(format!("{line}()").as_bytes()));
            assert_eq!((plain.words, plain.blocks), (long.words, long.blocks), "{line:?}");
            assert_eq!(plain.diagnostics.len(), long.diagnostics.len(), "{line:?}");
        }
    }
}
