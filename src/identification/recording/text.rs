//! Bytes → text, and cells → numbers.
//!
//! Encodings: UTF-8, UTF-16 with a byte order mark, and otherwise Latin-1, in which every byte is a
//! character, so that decoding never fails. Numbers: decimal point or comma, exponent, blanks around; no
//! thousands separators, because `1,234` would be ambiguous.

use crate::identification::recording::RecordingError;
use crate::simulation::gcode::characters;

/// First bytes of files that users drop by mistake or have to unpack first, with a description.
const FOREIGN_BEGINNINGS: &[(&[u8], &str)] = &[
    (b"\x78\x9c", "zlib-compressed (Klipper's motan logs are); it is not read"),
    (b"\x78\xda", "zlib-compressed (Klipper's motan logs are); it is not read"),
    (b"\x78\x01", "zlib-compressed (Klipper's motan logs are); it is not read"),
    (b"%PDF", "a PDF document"),
    (b"\x89PNG", "a picture"),
    (b"\xff\xd8\xff", "a picture"),
    (b"\xd0\xcf\x11\xe0", "an old Excel workbook; save it as CSV"),
    (b"MATLAB 5.0", "a MATLAB file"),
    (b"\x89HDF", "an HDF5 file"),
];

/// Returns the text of a log.
pub(super) fn decode(bytes: &[u8]) -> Result<String, RecordingError> {
    if let Some((_, kind)) = FOREIGN_BEGINNINGS.iter().find(|(magic, _)| bytes.starts_with(magic)) {
        return Err(RecordingError::Binary(kind));
    }
    let text = match bytes {
        [0xff, 0xfe, rest @ ..] => utf16(rest, u16::from_le_bytes),
        [0xfe, 0xff, rest @ ..] => utf16(rest, u16::from_be_bytes),
        [0xef, 0xbb, 0xbf, rest @ ..] => characters(rest).into_owned(),
        _ => characters(bytes).into_owned(),
    };
    if text.trim().is_empty() {
        return Err(RecordingError::Empty);
    }
    // Old recorders end lines with `\r` alone; all readers expect `\n` or `\r\n`.
    let text = if text.contains('\n') { text } else { text.replace('\r', "\n") };
    let control =
        text.chars().filter(|c| c.is_control() && !matches!(c, '\n' | '\r' | '\t' | '\u{c}')).count();
    let nul = text.contains('\0');
    if nul || text.chars().count() / 50 < control {
        return Err(RecordingError::Binary("binary data"));
    }
    Ok(text)
}

fn utf16(bytes: &[u8], unit: fn([u8; 2]) -> u16) -> String {
    let units = bytes.chunks_exact(2).map(|pair| unit([pair[0], pair[1]]));
    char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER)).collect()
}

/// The content of a cell where a number is expected.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum CellContent {
    /// A finite number.
    Number(f64),
    /// Missing: empty, NaN, infinite or nearly so, UNAVAILABLE.
    Missing,
    /// Something else.
    Other,
}

/// Largest plausible number: larger than anything that a machine records, in any unit, and small enough for
/// every conversion.
const MAX_NUMBER: f64 = 1e30;

/// Returns `true` if `value` is small enough for a recorded number.
pub(super) fn is_plausible(value: f64) -> bool {
    value.abs() <= MAX_NUMBER
}

/// Words for an unknown value.
const MISSING_WORDS: &[&str] =
    &["nan", "-nan", "inf", "+inf", "-inf", "infinity", "unavailable", "null", "none", "n/a", "na", "-", "?"];

/// Returns `true` if `text` means that the value is unknown.
pub(super) fn is_missing(text: &str) -> bool {
    text.is_empty() || MISSING_WORDS.iter().any(|word| text.eq_ignore_ascii_case(word))
}

/// Returns the content of `text`. `comma` allows a decimal comma.
pub(super) fn number(text: &str, comma: bool) -> CellContent {
    let text = text.trim().trim_matches('"').trim();
    if is_missing(text) {
        return CellContent::Missing;
    }
    // `parse` also accepts words such as `infinity`, which are not numbers in a file.
    if !text.bytes().all(|b| b.is_ascii_digit() || matches!(b, b'+' | b'-' | b'.' | b',' | b'e' | b'E')) {
        return CellContent::Other;
    }
    let parsed = if comma && text.contains(',') && !text.contains('.') {
        text.replacen(',', ".", 1).parse::<f64>()
    } else {
        text.parse::<f64>()
    };
    match parsed {
        Ok(value) if is_plausible(value) => CellContent::Number(value),
        Ok(_) => CellContent::Missing,
        Err(_) => CellContent::Other,
    }
}
