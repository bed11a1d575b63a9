//! The first bytes of a file → its kind.

use crate::identification::recording::{is_packed_log, is_recording};

/// The kind of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileKind {
    /// A program, or an unknown kind: the reader of programs reports its faults.
    Program,
    /// A machine log.
    Recording,
    /// Settings of the page.
    Settings,
    /// A job.
    Job,
    /// A ZIP archive of files of any kind.
    Archive,
    /// A file that cannot be used, with the name of its format.
    Other(&'static str),
}

/// Beginnings of files that are often mistaken for programs.
const FOREIGN_BEGINNINGS: [(&[u8], &str); 9] = [
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

/// Beginnings of the page's JSON documents, which would otherwise be mistaken for logs.
const OWN_BEGINNINGS: [(&str, FileKind); 4] = [
    ("\"truefeed_job\"", FileKind::Job),
    ("\"truefeed\"", FileKind::Settings),
    ("\"addends\"", FileKind::Other("a quote of this page")),
    ("\"causes\"", FileKind::Other("a diagnosis of this page")),
];

/// Beginning of a ZIP archive.
const ARCHIVE_BEGINNING: &[u8] = b"PK\x03\x04";
/// Names of the first file in the archive of an office document.
const DOCUMENT_FILES: [&[u8]; 2] = [b"[Content_Types].xml", b"mimetype"];
/// Offset of the name of the first file.
const FIRST_NAME_OFFSET: usize = 30;

/// Returns the kind of a file, from its beginning.
pub fn file_kind(head: &[u8]) -> FileKind {
    if head.starts_with(ARCHIVE_BEGINNING) {
        let name = head.get(FIRST_NAME_OFFSET..).unwrap_or_default();
        let is_document = DOCUMENT_FILES.iter().any(|first| name.starts_with(first));
        return if is_document { FileKind::Other("an Office document") } else { FileKind::Archive };
    }
    if is_packed_log(head) {
        return FileKind::Recording;
    }
    if let Some((_, name)) = FOREIGN_BEGINNINGS.iter().find(|(bytes, _)| head.starts_with(bytes)) {
        return FileKind::Other(name);
    }
    if is_recording(head) {
        let says = |key: &str| head.windows(key.len()).any(|bytes| bytes == key.as_bytes());
        return OWN_BEGINNINGS
            .iter()
            .find(|(key, _)| says(key))
            .map_or(FileKind::Recording, |(_, kind)| *kind);
    }
    if is_binary(head) { FileKind::Other("a binary file") } else { FileKind::Program }
}

/// Returns `true` if the beginning of a text that may be a program contains blocks: at least two lines, and
/// one in four, that are mostly words of a program. A read-me or a list of tools contains none.
pub fn holds_blocks(head: &[u8]) -> bool {
    let text = String::from_utf8_lossy(head).replace('\0', "").to_ascii_uppercase();
    let lines = text.lines().map(without_comments).filter(|line| !line.trim().is_empty());
    let (mut blocks, mut all) = (0, 0);
    for line in lines {
        all += 1;
        let tokens = || line.split_whitespace();
        let words = tokens().filter(|token| is_words(token)).count();
        let asks = tokens()
            .any(|token| token.starts_with(['G', 'X', 'Y', 'Z', 'M', 'L', 'C', 'N', 'O']) && is_words(token));
        blocks += usize::from(asks && tokens().count() < 2 * words);
    }
    MIN_BLOCKS <= blocks && all <= MAX_LINES_PER_BLOCK * blocks
}

/// Fewest lines of a program that are blocks, and most lines for each of them.
const MIN_BLOCKS: usize = 2;
const MAX_LINES_PER_BLOCK: usize = 4;

/// Returns a line without its parentheses and without the text after a semicolon.
fn without_comments(line: &str) -> String {
    let mut depth = 0;
    let code = line.chars().take_while(|letter| *letter != ';');
    code.filter(|letter| {
        depth += i32::from(*letter == '(');
        let is_code = depth <= 0;
        depth -= i32::from(*letter == ')');
        is_code
    })
    .collect()
}

/// Returns `true` if a token consists only of words of a program, such as `G1`, `X-1.5Y2` or `CC`, with or
/// without a number before them.
fn is_words(token: &str) -> bool {
    const KEYWORDS: [&str; 9] = ["L", "C", "CC", "CYCL", "DEF", "TOOL", "CALL", "FMAX", "%"];
    let mut has_number = false;
    let mut letters = 0;
    for letter in token.chars() {
        match letter {
            'A'..='Z' if letters < 2 => letters += 1,
            '0'..='9' => (has_number, letters) = (true, 0),
            '+' | '-' | '.' | '=' | '#' | ',' | '/' | '*' => {}
            _ => return false,
        }
    }
    KEYWORDS.contains(&token) || (has_number && letters == 0)
}

/// Returns `true` if more than one byte in ten is not text. A program from a tape begins with zeros, and in
/// UTF-16 every other byte is zero.
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
    fn a_read_me_and_a_list_of_tools_hold_no_blocks() {
        let programs = [
            "%\nO0001 (PART)\nG21 G90\nT1 M6 (FLAT D10)\nG0 X0 Y0\nG1 X10 F500\nM30\n%\n",
            "0 BEGIN PGM PLAN MM\n1 BLK FORM 0.1 Z X+0 Y+0 Z-20\n2 TOOL CALL 1 Z S2000\n3 L X+10 Y+5 R0 FMAX M3\n4 L Z-5 F200\n5 CC X+0 Y+0\n6 C X+10 Y+0 DR+\n",
            "; HEADER\nN10 G17 G54\nN20 TRANS X=10\nN30 G1X10Y-2.5F=R1\nN40 M30\n",
            "O1000\nM98 P2000\nM98 P2001\nM30\n",
        ];
        for program in programs {
            assert!(holds_blocks(program.as_bytes()), "{program}");
        }
        let texts = [
            "READ ME\nRun op10 first, then op20.\nUse T1 and T2. Clamp with M6 screws.\nZ0 is the top of the stock.\n",
            "Tool list\nT1 flat end mill D10\nT2 drill D5\nT3 tap M6\n",
            "",
            "Material: 6061\n25 parts\n",
        ];
        for text in texts {
            assert!(!holds_blocks(text.as_bytes()), "{text}");
        }
    }

    #[test]
    fn files_are_named_by_what_stands_in_them() {
        let stl: Vec<u8> =
            [0.0f32, 1.0, -2.5, 3.25].iter().cycle().take(400).flat_map(|v| v.to_le_bytes()).collect();
        let stl = [[b' '; 80].as_slice(), &100u32.to_le_bytes(), &stl].concat();
        let zip = |name: &str| [b"PK\x03\x04", &[0; 26][..], name.as_bytes(), b"..."].concat();
        let [programs, log, document] = ["op10.nc", "log.csv", "[Content_Types].xml"].map(zip);
        let files: [(&[u8], FileKind); 18] = [
            (b"PK\x03\x04\x14\0", FileKind::Archive),
            (&programs, FileKind::Archive),
            (&log, FileKind::Archive),
            (&document, FileKind::Other("an Office document")),
            (b"{\n \"truefeed_job\": 1, \"operations\": []}", FileKind::Job),
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
