//! The same program in every form a file can have: line ends, marks, code pages, blanks, case,
//! numbers, and lines as long as nobody writes them.
//!
//! The law: a form that the dialect allows gives the same moves and stops, bit for bit and line for
//! line; one that it does not allow gives a remark and no panic. No clocks: a line of a million
//! characters would need 10¹² steps of a reader that goes over it again for each character, and
//! what comes out is bounded by what went in.

use crate::shared::case_count;
use truefeed::machine::Machine;
use truefeed::simulation::gcode::{self, Dialect, Options, Severity};
use truefeed::simulation::interpreter;
use truefeed::simulation::toolpath::{Segments, Stop, Toolpath};

/// The dialects whose words are letters with numbers, white space or not.
const WORDS: [Dialect; 5] = [Dialect::Iso, Dialect::LinuxCnc, Dialect::Grbl, Dialect::Mach, Dialect::Okuma];

/// A program that all of them read alike.
const PLAIN: &str = "\
N10 G21 G17 G90 G94
N20 T1 M6
N30 S1000 M3
N40 G0 X-1.5 Y0.5 Z2.0
N50 G1 Z-0.5 F200.0 (in)
N60 X10.0 F600.0
N70 G3 X10.0 Y10.5 I0.0 J5.0

N80 G1 X-1.5
N90 G9 Y0.5
N100 G0 Z2.0 M5
N110 M30
";

fn trace(bytes: &[u8], dialect: Dialect) -> Toolpath {
    let options = Options { dialect: Some(dialect), ..Options::default() };
    interpreter::trace(&gcode::read_with(bytes, &options), &Machine::default())
}

/// What the machine is told, line by line.
fn run(bytes: &[u8], dialect: Dialect) -> (Segments, Vec<Stop>) {
    let toolpath = trace(bytes, dialect);
    (toolpath.segments, toolpath.stops)
}

#[track_caller]
fn check_same(bytes: &[u8], name: &str) {
    for dialect in WORDS {
        check_same_in(bytes, PLAIN, dialect, name);
    }
}

#[track_caller]
fn check_same_in(bytes: &[u8], plain: &str, dialect: Dialect, name: &str) {
    let expected = run(plain.as_bytes(), dialect);
    assert!(5 < expected.0.len(), "{dialect:?}: the plain program moves");
    assert_eq!(run(bytes, dialect), expected, "{name}, {dialect:?}");
}

/// What SINUMERIK reads of it: no comments in parentheses.
fn siemens() -> String {
    PLAIN.replace("(in)", "; in")
}

#[test]
fn lines_end_in_any_way() {
    let ends = |end: &str| PLAIN.replace('\n', end);
    let mixed: String =
        PLAIN.lines().zip(["\r\n", "\n", "\r"].iter().cycle()).flat_map(|(line, end)| [line, *end]).collect();
    let forms = [
        ("no final newline", PLAIN.trim_end().to_string()),
        ("CR LF", ends("\r\n")),
        ("CR LF without the last", ends("\r\n").trim_end().to_string()),
        ("CR", ends("\r")),
        ("mixed", mixed.replace("\r\n\n", "\r\n\r\n")),
        ("blanks before the end", ends(" \t \r\n")),
        ("semicolon at the end", ends(" ;\n")),
        ("checksums", PLAIN.replace("\nN", "*71\nN")),
    ];
    for (name, form) in &forms {
        check_same(form.as_bytes(), name);
    }
    for (name, form) in &forms[..7] {
        check_same_in(form.replace("(in)", "; in").as_bytes(), &siemens(), Dialect::Siemens, name);
    }
}

#[test]
fn marks_and_code_pages_change_nothing() {
    let bytes = PLAIN.as_bytes();
    check_same(&[b"\xef\xbb\xbf", bytes].concat(), "UTF-8 mark");
    for comment in ["(in \u{fffd})", "(in Öl)", "(in 油)"] {
        check_same(PLAIN.replace("(in)", comment).as_bytes(), comment);
    }
    let latin = |byte: u8| if byte == b'i' { 0xd6 } else { byte };
    let latin: Vec<u8> = PLAIN.replace("(in)", "(iiiii)").bytes().map(latin).collect();
    check_same(&latin, "Latin-1");
    let nul = |byte: u8| if byte == b' ' { 0 } else { byte };
    check_same(&bytes.iter().map(|byte| nul(*byte)).collect::<Vec<u8>>(), "NUL for blanks");
    check_same(&[&[0; 50], bytes, &[0; 50]].concat(), "NUL as leader and trailer of a tape");
}

#[test]
fn utf_16_is_read_and_said() {
    let units = |text: &str| text.encode_utf16().collect::<Vec<u16>>();
    for end in ["\n", "\r\n"] {
        let text = PLAIN.replace('\n', end).replace("(in)", "(Öl 油)");
        for mark in ["", "\u{feff}"] {
            let units = units(&format!("{mark}{text}"));
            let little: Vec<u8> = units.iter().flat_map(|unit| unit.to_le_bytes()).collect();
            let big: Vec<u8> = units.iter().flat_map(|unit| unit.to_be_bytes()).collect();
            for bytes in [little, big] {
                check_same(&bytes, "UTF-16");
                let told = trace(&bytes, Dialect::Iso).diagnostics;
                assert!(told.iter().any(|told| told.message.contains("UTF-16")), "it is said");
                // Half a character at the end is dropped.
                trace(&bytes[..bytes.len() - 1], Dialect::Iso);
            }
        }
    }
    for bytes in [&b"\xff\xfe"[..], b"\xfe\xff", b"\xff\xfeG", b"\xff\xfe\x00\xd8", b"\xef\xbb\xbf"] {
        assert!(trace(bytes, Dialect::Iso).segments.is_empty());
    }
}

#[test]
fn blanks_case_and_numbers_are_free() {
    let spread = |text: &str| {
        let blanks = |character: char| match character {
            '(' | ')' | '\n' => format!("{character}"),
            character => format!(" {character}\t"),
        };
        text.chars().map(blanks).collect::<String>()
    };
    let forms = [
        ("lower case", PLAIN.to_lowercase()),
        ("tabs", PLAIN.replace(' ', "\t")),
        ("nothing between words", PLAIN.replace(' ', "")),
        ("blanks within words", spread(PLAIN)),
        ("G 01 X - 1.5", PLAIN.replace("N80 G1 X-1.5", "N80 G 01 X - 1.5")),
        ("1. and .5", PLAIN.replace(".0", ".").replace("Y0.5", "Y.5").replace("-0.5", "-.5")),
        ("+1", PLAIN.replace("X10", "X+10").replace("Y0.5", "Y+0.5")),
        ("leading zeros", PLAIN.replace('G', "G0").replace('X', "X00").replace("X00-", "X-00")),
        ("trailing zeros", PLAIN.replace("0.5", "0.500000000000000000000000")),
        ("no block numbers", PLAIN.lines().map(without_number).collect()),
    ];
    for (name, form) in &forms {
        check_same(form.as_bytes(), name);
    }
    for (name, form) in
        forms.iter().filter(|(name, _)| !name.contains("lanks within") && !name.contains(" - "))
    {
        check_same_in(form.replace("(in)", "; in").as_bytes(), &siemens(), Dialect::Siemens, name);
    }
}

fn without_number(line: &str) -> String {
    let words = line.split_once(' ').map_or(line, |(_, words)| words);
    format!("{words}\n")
}

/// Exponents are no part of a number: E is a word of its own, and says that it is not modelled.
#[test]
fn exponents_are_no_numbers() {
    for dialect in WORDS {
        let plain = trace(b"G1 F100 X1.", dialect);
        let written = trace(b"G1 F100 X1E3", dialect);
        assert_eq!(written.segments, plain.segments, "{dialect:?}");
        let told = |toolpath: &Toolpath, text: &str| {
            toolpath.diagnostics.iter().any(|told| told.message.contains(text))
        };
        assert!(told(&written, "E words are not modelled"), "{dialect:?}: {:?}", written.diagnostics);
    }
    for dialect in [Dialect::Siemens, Dialect::HeidenhainIso] {
        let written = trace(b"G1 F100 X1E3", dialect);
        assert!(!written.diagnostics.is_empty(), "{dialect:?}: something is said");
    }
}

#[test]
fn a_line_may_be_very_long() {
    for length in [10_000, 1_000_000] {
        let blanks = " ".repeat(length);
        let comment = format!("(in{})", "x".repeat(length));
        let forms = [
            ("blanks", PLAIN.replace("N60 X", &format!("N60{blanks}X"))),
            ("blanks within a word", PLAIN.replace("N60 X", &format!("N60 X{blanks}"))),
            ("comment", PLAIN.replace("(in)", &comment)),
            ("zeros before", PLAIN.replace("N60 X", &format!("N60 X{}", "0".repeat(length)))),
            ("zeros behind", PLAIN.replace("N60 X10.0", &format!("N60 X10.{}", "0".repeat(length)))),
            ("blank lines", format!("{PLAIN}{}", "\n".repeat(length))),
        ];
        for (name, form) in &forms {
            for dialect in WORDS {
                check_same_in(form.as_bytes(), PLAIN, dialect, &format!("{name}, {length}"));
            }
        }
    }
}

/// Every dialect, and the choice of one, goes over a long line a bounded number of times, and what
/// it has to say about it is bounded.
#[test]
#[ignore = "full suite: reads lines of a million letters"]
fn no_line_takes_more_than_its_length() {
    let length = case_count(1_000_000);
    let parts = [
        "(",
        ")",
        "()",
        "((",
        "X",
        "X1",
        "X1 ",
        "X.",
        "X-",
        "1",
        "#",
        "#1=",
        "#1=1",
        "[",
        "[1+",
        "]",
        "/",
        "%",
        ";",
        "\"",
        "'",
        "=",
        ",R",
        ":",
        "*",
        "*1",
        "N1",
        "O1",
        "O<",
        "O1 IF ",
        "IF ",
        "IF[1]",
        "WHILE",
        "GOTO1",
        "M98",
        "G65P",
        "VC1=",
        "VC1=1 ",
        "V[",
        "VZOFZ[1]=",
        "CALL ",
        "CALL O1",
        "NCYL",
        "FA=",
        "MODIN",
        "$",
        "~",
        "R1=",
        "R1=R",
        "MCALL ",
        "CYCLE81(",
        "L X+1 ",
        "FN 0: Q1",
        "Q1 = ",
        "TOOL CALL ",
        "CYCL DEF ",
        "\0",
        "\t",
        "é",
        "\u{80}",
        "@1",
        "^1",
        "\\",
    ];
    let dialects = Dialect::WORDS.iter().map(|(_, dialect, _)| Some(*dialect)).chain([None]);
    for dialect in dialects {
        for part in parts {
            let text = part.repeat(length / part.len());
            let options = Options { dialect, ..Options::default() };
            let program = gcode::read_with(text.as_bytes(), &options);
            let sizes =
                [program.words.len(), program.steps.len(), program.formulas.len(), program.flow.len()];
            assert!(sizes.iter().all(|size| *size <= length), "{part}, {dialect:?}: {sizes:?}");
            assert!(program.blocks.len() <= length + 1, "{part}, {dialect:?}");
            let told = &program.diagnostics;
            assert!(told.len() <= 2_000, "{part}, {dialect:?}: {} remarks", told.len());
            let characters: usize = told.iter().map(|told| told.message.len()).sum();
            assert!(characters <= 500_000, "{part}, {dialect:?}: {characters} characters of remarks");
        }
    }
}

/// A file without a program in it says so, or says nothing and moves nothing.
#[test]
fn files_that_are_no_programs_do_no_harm() {
    let every: Vec<u8> = (0..=255).collect();
    for bytes in [&b""[..], b"\n", b"\0", b"%", b"%\n%", b";", b"(", b"\x1a", &every] {
        for (_, dialect, _) in Dialect::WORDS {
            let toolpath = trace(bytes, dialect);
            assert!(toolpath.segments.is_empty(), "{bytes:?}, {dialect:?}");
        }
    }
    let picture = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\x01\0\0\0\x01\0\x08\x06";
    let told = trace(picture, Dialect::Iso).diagnostics;
    assert!(told.iter().any(|told| told.severity == Severity::Error), "{told:?}");
}
