//! Laws of reading.

use super::*;
use crate::simulation::gcode::Severity;

/// Words of each block with its line, as text.
fn shown(program: &Program) -> Vec<(u32, String)> {
    let show = |block: &Block| {
        let words = program.words(block).iter().map(|word| format!("{}{}", word.letter as char, word.value));
        (block.line.0, words.collect::<Vec<_>>().join(" "))
    };
    program.blocks.iter().map(show).collect()
}

#[track_caller]
fn check(text: &str, expected: &[(u32, &str)]) {
    let found = shown(&read(text.as_bytes()));
    let expected: Vec<_> = expected.iter().map(|(line, words)| (*line, words.to_string())).collect();
    assert_eq!(found, expected, "{text:?}");
}

#[test]
fn white_space_and_case_mean_nothing() {
    let plain = shown(&read(b"G1X-10.5Y.25F600"));
    for text in ["g1 x-10.5 y.25 f600", " G 1\tX - 1 0 . 5Y .25   F6 00 ", "G1(a)X-10.5(b)Y.25F600;c"] {
        assert_eq!(shown(&read(text.as_bytes())), plain, "{text}");
    }
}

#[test]
fn lines_count_as_in_an_editor() {
    let expected: &[(u32, &str)] = &[(1, "G0"), (3, "G1"), (4, "G2")];
    check("G0\n\nG1\nG2", expected);
    check("G0\r\n\r\nG1\r\nG2\r\n", expected);
    check("G0\r\rG1\rG2\r", expected);
    check("G0\r\n\nG1\rG2", expected);
}

#[test]
fn numbers_names_and_checksums_are_dropped() {
    check("O0001 (NAME)\nN10 G0 X1 *71\n:1234\nO5 G1", &[(2, "G0 X1"), (3, ""), (4, ""), (4, "G1")]);
    check("X1E3", &[(1, "X1 E3")]);
    assert!(read(b":12\nG0").is_tape && read(b"o5\nG0").is_tape && read(b"%\nG0\n%").is_tape);
    assert!(!read(b"N10 G0 X1").is_tape);
}

#[test]
fn comments_hide_words() {
    check("G0 (X1 (X2) X3) Y1", &[(1, "G0 Y1")]);
    check("G0 ((X1) Y1", &[(1, "G0 Y1")]);
    check("G0 (() X1 (a) Y1", &[(1, "G0 X1 Y1")]);
    check("G0 (X1\nY1 ;X2", &[(1, "G0"), (2, "Y1")]);
    check("(;) G0 ;(X1", &[(1, "G0")]);
    assert_eq!(read(b"G0 (X1").diagnostics.len(), 1);
}

#[test]
fn comments_are_read_in_utf_8_or_latin_1() {
    let comment = |bytes: &[u8]| read(bytes).comments.first().map(|comment| comment.text.clone());
    assert_eq!(comment("(Nut 45° für Ø8)".as_bytes()).as_deref(), Some("Nut 45° für Ø8"));
    assert_eq!(comment(b"(Nut 45\xb0 f\xfcr \xd88)").as_deref(), Some("Nut 45° für Ø8"));
    let long = format!("(°{})", "°".repeat(2000));
    assert!(comment(long.as_bytes()).is_some_and(|text| text.chars().all(|character| character == '°')));
}

#[test]
fn percent_lines_frame_the_program() {
    let framed = [(2, "G0")];
    check("%\nG0\n%\nG1", &framed);
    check("%\nG0\n%\n%\nG1\n%", &framed);
    check("%\nG0", &framed);
    check("(x)\n%\nG0", &[(3, "G0")]);
    check("G9\n%\nG0\n%", &[(3, "G0")]);
    check("G0\nG1\n%\n", &[(1, "G0"), (2, "G1")]);
    check("#1=2\nG1\n%\n", &[(1, ""), (2, "G1")]);
    check("]1=2\nG1\n%\n", &[(2, "G1")]);
    assert!(read(b"%\nG0\n%\n \n%\n").diagnostics.is_empty());
    let trailer = read(b"%\nG0\n%\n\nG1").diagnostics;
    assert_eq!((trailer.len(), trailer[0].line, trailer[0].severity), (1, LineNumber(5), Severity::Info));
}

/// A program and its subprograms, each on a tape of its own; without a call it is another job.
#[test]
fn subprograms_follow_on_tapes_of_their_own() {
    let main = [(3, "G0"), (4, "M98 P7"), (5, "M30")];
    let with_subprogram = [&main[..], &[(7, ""), (8, "G1"), (9, "M99")]].concat();
    check("%\nO1\nG0\nM98 P7\nM30\n%\nO7\nG1\nM99\n%\n", &with_subprogram);
    check("\nO1\nG0\nM98 P7\nM30\n%\n:7\nG1\nM99\n%\n", &with_subprogram);
    check("%\nO1\nG0\nM98 P7\nM30\n%\nO7\nG1\nM99\n%\nG2\n%\n", &with_subprogram);
    check("%\nO1\nG0\nM98 P7\nM30\n%\nG1\nO7\n%\n", &main);
    check("%\nO1\nG0\nM30\n%\nO7\nG1\nM99\n%\n", &[(3, "G0"), (4, "M30")]);
    let apart = [(3, "G0"), (4, "M98 P7"), (5, "M30"), (9, ""), (10, "G1")];
    check("%\nO1\nG0\nM98 P7\nM30\n%\n\n%\nO7\nG1\n%\n", &apart);
}

#[test]
fn block_delete_follows_the_switch() {
    let text = b"G0\n/G1\n/2 G2\nN5/G3\nN6 /4 X1";
    assert_eq!(read(text).blocks.len(), 5);
    let switched = read_with(text, &Options { block_delete: true, ..Options::default() });
    assert_eq!(shown(&switched), [(1, "G0".to_string())]);
    for program in [read(text), switched] {
        assert_eq!(program.diagnostics.len(), 1);
        assert!(program.diagnostics[0].message.starts_with("4 blocks"));
    }
}

/// What follows the `/` within a block is left out with the switch on.
#[test]
fn block_delete_may_begin_within_a_block() {
    let text = b"G1 X1 /Y2\nG1 X3 /2 Y4\nX[6/2]";
    assert_eq!(read(text).words.len(), 7);
    let switched = read_with(text, &Options { block_delete: true, ..Options::default() });
    assert_eq!(shown(&switched)[..2], [(1, "G1 X1".to_string()), (2, "G1 X3".to_string())]);
    for program in [read(text), switched] {
        assert!(program.diagnostics[0].message.starts_with("2 blocks"), "{:?}", program.diagnostics);
        assert_eq!(program.diagnostics.len(), 1);
    }
}

/// As they are pasted from a PDF: the dash is said once, at its place, and counts in no comment.
#[test]
fn dashes_before_numbers_are_minus_signs() {
    let program =
        read("G0 X1 (5\u{2013}7)\nG1 X\u{2212}5. Y\u{2013}.5\nG1\u{a0}X\u{2014}3 ; 1\u{2013}2".as_bytes());
    let shown: Vec<String> = shown(&program).into_iter().map(|(_, words)| words).collect();
    assert_eq!(shown, ["G0 X1", "G1 X-5 Y-0.5", "G1 X-3"]);
    let told: Vec<_> = program.diagnostics.iter().map(|told| (told.line.0, told.columns)).collect();
    assert_eq!(told, [(2, (5, 6))], "{:?}", program.diagnostics);
    assert_eq!(read("G1 X\u{2212}#1 F9".as_bytes()).diagnostics[0].severity, Severity::Error);
    let klartext = "0 BEGIN PGM A MM\n1 L Z\u{2212}5 F100\n2 END PGM A MM\n";
    assert_eq!(read(klartext.as_bytes()).diagnostics[0].columns, (6, 7));
    assert_eq!(read(klartext.as_bytes()).diagnostics.len(), 1);
}

/// Every block that holds what is not understood says so once, and leaves no word behind.
#[test]
fn what_is_not_understood_is_said() {
    let cases: &[(&str, &str, (u32, u32))] = &[
        ("#1", "", (3, 4)),
        ("G1 X[1+] Y3", "", (8, 9)),
        ("G1 X-#5 Y-#", "", (12, 13)),
        ("N#5 G1", "", (1, 7)),
        ("IF [1 EQ 1] GO 5 X", "", (18, 19)),
        ("IF [1 EQ 1] X5", "", (12, 13)),
        ("GOTO", "", (5, 6)),
        ("WHILE [1] D1", "", (10, 11)),
        ("END 1", "", (1, 6)),
        ("o<drill> cal (x)", "", (1, 13)),
        ("o100 while [1", "", (14, 15)),
        ("o100 endwhile", "", (1, 14)),
        ("o100 while [1]", "", (1, 1)),
        ("G0 QUUX Z0", "", (4, 8)),
        ("G1 X1 , D2", "", (7, 8)),
        ("(\u{e4}\u{f6}) G0 \u{fc}", "", (9, 10)),
        ("G1 M. X2", "G1 X2", (4, 6)),
        ("G1 X1..2 Y3", "G1 Y3", (4, 9)),
        ("G1 X--2 Y3", "G1 Y3", (4, 8)),
        ("O5 DRILLING", "", (4, 12)),
        ("G1 X- Y3", "G1 Y3", (4, 6)),
    ];
    for (text, words, columns) in cases {
        let program = read(text.as_bytes());
        let found = shown(&program).pop().map(|(_, words)| words).unwrap_or_default();
        assert_eq!(found, *words, "{text}");
        assert_eq!(program.diagnostics.len(), 1, "{text}: {:?}", program.diagnostics);
        assert_eq!(program.diagnostics[0].columns, *columns, "{text}");
        assert_eq!(program.diagnostics[0].severity, Severity::Error, "{text}");
    }
    assert!(read(b"X\xff\xfe\xff").diagnostics.len() == 2, "invalid bytes are shown, not trusted");
}

/// A line of half-open comments must not be searched again for each of them.
#[test]
fn long_lines_are_read_in_linear_time() {
    let program = read(("(()".repeat(400_000) + "X1").as_bytes());
    assert_eq!((program.blocks.len(), program.words.len()), (1, 1));
    let program = read("(()X1".repeat(400_000).as_bytes());
    assert_eq!((program.blocks.len(), program.words.len()), (0, 0));
    assert!(program.diagnostics.iter().any(|found| found.message.starts_with("400000 words in one block")));
}

#[test]
fn a_million_faults_make_a_short_list() {
    let program = read("#1\nX1.2.3\n".repeat(50_000).as_bytes());
    assert_eq!(program.diagnostics.len(), 402);
    let counted =
        program.diagnostics.iter().filter(|diagnostic| diagnostic.message.starts_with("49800 more"));
    assert_eq!(counted.count(), 2);
}
