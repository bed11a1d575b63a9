//! Character encodings of program files.
//!
//! Programs are ASCII; a comment may be in UTF-8 or in an 8-bit code page, whose bytes are read one by one and
//! shown as Latin-1. A UTF-8 mark at the beginning is dropped. UTF-16, which Windows editors write as "Unicode",
//! is recognised by its mark or, without one, by zero bytes beside the first two characters, and converted to
//! UTF-8. Text copied from a PDF or a word processor may contain dashes for minus signs, and non-breaking blanks:
//! a dash before a number, outside of comments, counts as a minus sign.

use crate::simulation::gcode::line::is_continuation;
use crate::simulation::gcode::{LineNumber, Place};
use std::borrow::Cow;

/// Dashes that look like a minus sign.
const DASHES: [&str; 6] = ["\u{2010}", "\u{2011}", "\u{2012}", "\u{2013}", "\u{2014}", "\u{2212}"];

/// Blanks other than the space.
const BLANKS: [&str; 4] = ["\u{a0}", "\u{2007}", "\u{2009}", "\u{202f}"];

/// Returns the text with plain minus signs and spaces, and the first dash with its place.
pub(super) fn in_plain_signs(text: Cow<'_, [u8]>) -> (Cow<'_, [u8]>, Option<(&'static str, Place)>) {
    let sign = |at: usize, signs: &[&'static str]| {
        signs.iter().copied().find(|sign| text[at..].starts_with(sign.as_bytes()))
    };
    let is_number = |at: usize| text.get(at).is_some_and(|byte| byte.is_ascii_digit() || *byte == b'.');
    let dash = |at: usize| sign(at, &DASHES).filter(|dash| is_number(at + dash.len()));
    // Only these bytes begin one of the signs.
    let mut suspects = memchr::memchr2_iter(0xc2, 0xe2, &text);
    if !suspects.any(|at| dash(at).is_some() || sign(at, &BLANKS).is_some()) {
        return (text, None);
    }
    let (mut plain, mut first) = (Vec::with_capacity(text.len()), None);
    let (mut line, mut column, mut depth, mut is_comment) = (1, 0, 0_usize, false);
    let mut at = 0;
    while let Some(&byte) = text.get(at) {
        column += u32::from(!is_continuation(byte));
        match byte {
            b'\n' => (line, column, depth, is_comment) = (line + 1, 0, 0, false),
            b'(' => depth += 1,
            b')' => depth = depth.saturating_sub(1),
            b';' => is_comment = true,
            _ => {}
        }
        let (replaced, length) = match (dash(at), sign(at, &BLANKS)) {
            (Some(dash), _) if depth == 0 && !is_comment => {
                let place = Place { line: LineNumber(line), columns: (column, column + 1) };
                first.get_or_insert((dash, place));
                (b'-', dash.len())
            }
            (_, Some(blank)) => (b' ', blank.len()),
            _ => (byte, 1),
        };
        plain.push(replaced);
        at += length;
    }
    (Cow::Owned(plain), first)
}

/// Returns the text of a file, and `true` if it was UTF-16.
pub(super) fn text(bytes: &[u8]) -> (Cow<'_, [u8]>, bool) {
    let unit: fn([u8; 2]) -> u16 = match bytes {
        [0xef, 0xbb, 0xbf, rest @ ..] => return (Cow::Borrowed(rest), false),
        [0xff, 0xfe, ..] | [1..=255, 0, 1..=255, 0, ..] => u16::from_le_bytes,
        [0xfe, 0xff, ..] | [0, 1..=255, 0, 1..=255, ..] => u16::from_be_bytes,
        _ => return (Cow::Borrowed(bytes), false),
    };
    let units = bytes.chunks_exact(2).map(|pair| unit([pair[0], pair[1]]));
    let characters = char::decode_utf16(units).map(|found| found.unwrap_or(char::REPLACEMENT_CHARACTER));
    let text: String = characters.skip_while(|character| *character == '\u{feff}').collect();
    (Cow::Owned(text.into_bytes()), true)
}

/// Returns a text in UTF-8, or else in Latin-1, as older controls, postprocessors and recorders write it.
pub fn characters(text: &[u8]) -> Cow<'_, str> {
    match std::str::from_utf8(text) {
        Ok(text) => Cow::Borrowed(text),
        // A cut in the middle of the last character is no reason to misread all the others.
        Err(cut) if cut.error_len().is_none() && 0 < cut.valid_up_to() => {
            String::from_utf8_lossy(&text[..cut.valid_up_to()])
        }
        Err(_) => text.iter().map(|byte| char::from(*byte)).collect(),
    }
}
