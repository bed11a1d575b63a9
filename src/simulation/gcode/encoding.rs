//! How the bytes of a file stand for characters.
//!
//! Programs are ASCII; a comment may hold UTF-8 or an 8-bit code page, whose bytes are passed over
//! one by one, and shown as Latin-1. A UTF-8 mark at the beginning is dropped. UTF-16, which Windows editors write as
//! "Unicode", is told by its mark or, without one, by zero bytes beside the first two characters,
//! and turned into UTF-8.

use std::borrow::Cow;

/// The text of a file, and whether it was UTF-16.
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

/// A text in UTF-8, or else in Latin-1, as older controls, posts and recorders write it.
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
