//! The words of a line of DIN/ISO.

use crate::simulation::gcode::line::excerpt;
use crate::simulation::gcode::number::{is_blank, number, skip_blanks};

/// The known G words apart from cycles from 200 on. G17 to G20, G40, G50 and G51 alone become no statement.
const KNOWN: &[u32] = &[
    0, 1, 2, 3, 4, 5, 6, 10, 11, 12, 13, 15, 16, 17, 18, 19, 20, 24, 25, 26, 27, 28, 30, 31, 38, 40, 41, 42,
    50, 51, 54, 62, 70, 71, 72, 73, 79, 90, 91, 98, 99,
];

/// One word: its letter in upper case, and its value as written.
pub(super) struct Word {
    pub(super) letter: char,
    pub(super) value: String,
}

impl Word {
    fn number(&self) -> Option<f64> {
        number(self.value.as_bytes(), 0).map(|found| found.value)
    }
}

/// Returns the words of a line.
///
/// # Errors
///
/// The text that is not a word.
fn words(code: &[u8]) -> Result<Vec<Word>, String> {
    let mut words = Vec::new();
    let mut at = 0;
    while at < code.len() {
        let letter = code[at].to_ascii_uppercase();
        if is_blank(letter) {
            at += 1;
            continue;
        }
        if !b"ABCFGHIJKLMPQRSTUVWXYZ".contains(&letter) {
            return Err(excerpt(&code[at..]));
        }
        let start = skip_blanks(code, at + 1);
        // A value ends at the next letter, except at a Q directly after the letter of the word, a sign or an `=`.
        let mut end = start;
        if code.get(start) == Some(&b'"') {
            // The name of a label.
            let length = code[start + 1..].iter().position(|byte| *byte == b'"');
            end = length.map_or(code.len(), |length| start + length + 2);
        }
        while end < code.len() {
            let byte = code[end].to_ascii_uppercase();
            let is_parameter =
                byte == b'Q' && code[start..end].iter().all(|byte| matches!(byte, b'+' | b'-' | b' ' | b'='));
            let follows_equals =
                letter == b'Q' && byte == b'Q' && code[start..end].trim_ascii_end().ends_with(b"=");
            if byte.is_ascii_alphabetic() && !is_parameter && !follows_equals {
                break;
            }
            end += 1;
        }
        let value = String::from_utf8_lossy(code[start..end].trim_ascii()).into_owned();
        words.push(Word { letter: char::from(letter), value });
        at = end;
    }
    Ok(words)
}

/// The words of a line, which may stand for several statements.
pub(super) struct Sentence {
    pub(super) words: Vec<Word>,
    /// The G words.
    pub(super) codes: Vec<u32>,
}

impl Sentence {
    /// Reads the words of a line.
    ///
    /// # Errors
    ///
    /// The text that is not a word, or the first unknown G word.
    pub(super) fn read(code: &[u8]) -> Result<Sentence, String> {
        let words = words(code)?;
        let codes: Vec<f64> =
            words.iter().filter(|word| word.letter == 'G').filter_map(Word::number).collect();
        let is_known = |code: &f64| KNOWN.iter().any(|known| f64::from(*known) == *code);
        if let Some(unknown) = codes.iter().find(|code| !is_known(code)) {
            return Err(format!("G{unknown}"));
        }
        Ok(Sentence { words, codes: codes.into_iter().map(|code| code as u32).collect() })
    }

    /// Returns `true` if the line has this G word.
    pub(super) fn has(&self, code: u32) -> bool {
        self.codes.contains(&code)
    }

    /// Returns the value of the last word with this letter, as written.
    pub(super) fn given(&self, letter: char) -> Option<&str> {
        self.words.iter().rfind(|word| word.letter == letter).map(|word| word.value.as_str())
    }

    /// Returns the value of F, unless it belongs to a tool.
    pub(super) fn feed(&self) -> Option<&str> {
        self.given('F').filter(|_| self.given('T').is_none())
    }
}
