//! Bytes of a file → what it is, by the first of them: so that the page takes what it knows and names what it does not.

use crate::identification::recording::{is_packed_log, is_recording};

/// What a file is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileKind {
    /// A program, or what cannot be told: its reader says what is wrong.
    Program,
    /// A machine log.
    Recording,
    /// Settings of the page.
    Settings,
    /// Nothing that can be used here, by its name.
    Other(&'static str),
}

/// How files begin that are often taken for programs.
const BEGINNINGS: [(&[u8], &str); 10] = [
    (b"PK\x03\x04", "a ZIP archive or an Office document"),
    (b"\xd0\xcf\x11\xe0", "an Office or CAD document"),
    (b"7z\xbc\xaf", "a compressed archive"),
    (b"Rar!", "a compressed archive"),
    (b"\x89PNG", "a picture"),
    (b"\xff\xd8\xff", "a picture"),
    (b"%PDF", "a PDF"),
    (b"ISO-10303-21", "a STEP model"),
    (b"solid ", "an STL model"),
    (b"<!doctype html", "a web page"),
];

/// What only the page's own documents in JSON say, which would be taken for logs.
const OWN: [(&str, FileKind); 3] = [
    ("\"truefeed\"", FileKind::Settings),
    ("\"addends\"", FileKind::Other("a quote of this page")),
    ("\"causes\"", FileKind::Other("a diagnosis of this page")),
];

/// What a file is, from its beginning.
pub fn file_kind(head: &[u8]) -> FileKind {
    if is_packed_log(head) {
        return FileKind::Recording;
    }
    if let Some((_, name)) = BEGINNINGS.iter().find(|(bytes, _)| head.starts_with(bytes)) {
        return FileKind::Other(name);
    }
    if is_recording(head) {
        let says = |key: &str| head.windows(key.len()).any(|bytes| bytes == key.as_bytes());
        return OWN.iter().find(|(key, _)| says(key)).map_or(FileKind::Recording, |(_, kind)| *kind);
    }
    if is_binary(head) { FileKind::Other("a binary file") } else { FileKind::Program }
}

/// Whether more than one byte of ten is of no text. A program off a tape has zeros before it, and in UTF-16 every other
/// byte is zero.
fn is_binary(head: &[u8]) -> bool {
    if matches!(
        head,
        [0xff, 0xfe, ..] | [0xfe, 0xff, ..] | [1..=255, 0, 1..=255, 0, ..] | [0, 1..=255, 0, 1..=255, ..]
    ) {
        return false;
    }
    let start = head.iter().take_while(|byte| **byte == 0).count();
    let is_text = |byte: &&u8| (b' ' <= **byte && **byte != 0x7f) || (b'\t'..=b'\r').contains(*byte);
    let texts = head[start..].iter().filter(is_text).count();
    10 * texts < 9 * (head.len() - start)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_named_by_what_stands_in_them() {
        let stl: Vec<u8> =
            [0.0f32, 1.0, -2.5, 3.25].iter().cycle().take(400).flat_map(|v| v.to_le_bytes()).collect();
        let stl = [[b' '; 80].as_slice(), &100u32.to_le_bytes(), &stl].concat();
        let files: [(&[u8], FileKind); 14] = [
            (b"PK\x03\x04\x14\0", FileKind::Other("a ZIP archive or an Office document")),
            (b"\x1f\x8b\x08\0", FileKind::Recording),
            (b"\x89PNG\r\n\x1a\n", FileKind::Other("a picture")),
            (b"%PDF-1.7\n", FileKind::Other("a PDF")),
            (b"ISO-10303-21;\nHEADER;\n", FileKind::Other("a STEP model")),
            (b"solid part\nfacet normal 0 0 1\n", FileKind::Other("an STL model")),
            (&stl, FileKind::Other("a binary file")),
            (b"<!doctype html>\n<html>", FileKind::Other("a web page")),
            (b"\n{\"truefeed\": 1, \"machine\": {}}", FileKind::Settings),
            (b"{\"Header\": [1, 2]}", FileKind::Recording),
            (b"t_s,x_mm\n0,1\n1,2\n", FileKind::Recording),
            (b"\0\0\0\0\0\0%\nO1\nG1 X1 F100\n%\n\0\0", FileKind::Program),
            (b"G\x001\0X\x001\0\n\0", FileKind::Program),
            (b"", FileKind::Program),
        ];
        for (head, kind) in files {
            assert_eq!(file_kind(head), kind, "{}", String::from_utf8_lossy(head));
        }
    }
}
