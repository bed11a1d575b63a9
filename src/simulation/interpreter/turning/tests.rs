//! Lathe programs are declined by their words, mills never are.

use crate::machine::Machine;
use crate::simulation::gcode::{Dialect, DoubtCause, Options, read_with};
use crate::simulation::interpreter::{trace, trace_text};
use crate::simulation::toolpath::Toolpath;

fn run(text: &str, dialect: Option<Dialect>) -> Toolpath {
    let (options, machine) = (Options { dialect, ..Options::default() }, Machine::default());
    let whole = trace(&read_with(text.as_bytes(), &options), &machine);
    assert_eq!(trace_text(text.as_bytes().to_vec(), &options, &machine), whole, "{text}");
    whole
}

/// The line and the message by which a program is declined.
fn declined(text: &str, dialect: Option<Dialect>) -> Option<(u32, String)> {
    let toolpath = run(text, dialect);
    let declined = toolpath.declined.clone()?;
    assert!(toolpath.segments.is_empty() && toolpath.stops.is_empty(), "{text}");
    assert_eq!(toolpath.diagnostics, std::slice::from_ref(&declined), "{text}");
    Some((declined.line.0, declined.message))
}

/// Asserts that a program is declined at a line, by words that the message names.
#[track_caller]
fn assert_declined(name: &str, text: &str, line: u32, words: &[&str]) {
    let (found, message) = declined(text, None).unwrap_or_else(|| panic!("{name} is quoted"));
    assert_eq!(found, line, "{name}: {message}");
    for word in words {
        assert!(message.contains(word), "{name}: {word} in {message}");
    }
}

#[test]
fn lathe_programs_are_declined_by_line_and_word() {
    for (name, text, line, words) in [
        (
            "Fanuc, roughing",
            "%\nO1\nG28 U0 W0\nT0101\nG50 S2500\nG96 S200 M3\nG0 X52. Z2.\nG71 U2. R1.\nG71 P10 Q20 U.4 W.1 F.25\nN10 G0 X20.\nG1 Z-30.\nN20 X52.\nG70 P10 Q20\nM30\n%",
            3,
            &[
                "U in line 3",
                "T0101 in line 4",
                "G50 S in line 5",
                "G96 in line 6",
                "G71 with P and Q in line 9",
            ][..],
        ),
        (
            "older Fanuc",
            "O2\nM3 S600 T0202\nG0 X40. Z1.\nG1 Z-20. F0.2\nU2.\nG0 X60. Z50.\nM30",
            2,
            &["T0202 in line 2", "F0.2"],
        ),
        (
            "G92 S and G96",
            "G92 S3000\nG96 S180 M4\nG0 X30 Z2\nG1 Z-10 F0.1\nM30",
            1,
            &["G92 S in line 1", "G96 in line 2"],
        ),
        (
            "contour cycle",
            "O3\nG0 X60. Z5.\nG73 U10. W5. R5\nG73 P1 Q2 U.5 W.1 F.2\nN1 G0 X20.\nN2 G1 Z-20.\nM30",
            3,
            &["G73 with P and Q in line 4"],
        ),
        (
            "threading",
            "O4\nT0303\nG97 S800 M3\nG0 X22. Z5.\nG76 P020060 Q100 R.05\nG76 X18.2 Z-20. P900 Q300 F1.5\nM30",
            2,
            &["G76 in line 5"],
        ),
        (
            "facing",
            "O5\nT0101 M3 S900\nG0 X52. Z2.\nG72 W2. R.5\nG72 P10 Q20 U.2 W.1 F.3\nN10 G0 Z-10.\nN20 G1 X20.\nM30",
            2,
            &["G72"],
        ),
        ("diameters", "N10 G18 G90 DIAMON\nG0 X60 Z2\nG1 Z-20 F100\nM30", 1, &["DIAMON in line 1"]),
    ] {
        assert_declined(name, text, line, words);
    }
}

#[test]
fn passes_of_turning_are_declined_by_line_and_word() {
    for (name, text, line, words) in [
        (
            "passes of turning",
            "O6\nM3 S600\nG0 X42. Z2.\nG90 X38. Z-30. F0.2\nX36.\nX34.\nG0 X60. Z50.\nM30",
            4,
            &["G90 with X and Z in line 4", "F0.2 in line 4"][..],
        ),
        (
            "passes of facing, with the feed before",
            "O7\nG99 F.15\nM3 S600\nG0 X42. Z2.\nG94 X0 Z-1.\nZ-2.\nM30",
            2,
            &["G99 in line 2 (feeds per revolution)", "F0.15", "G94 with X and Z in line 5"],
        ),
        (
            "passes of turning in inches",
            "O8\nG20\nG0 X1.6 Z.1\nG90 U-.2 W-1. F.008\nM30",
            4,
            &["G90 with X and Z in line 4", "U in line 4"],
        ),
        (
            "passes of a thread",
            "O9\nT0303\nM3 S500\nG0 X22. Z5.\nG92 X19.2 Z-20. F1.5\nX18.8\nM30",
            2,
            &["T0303", "G92 with X and Z in line 5 (a thread)"],
        ),
        ("feeds per revolution", "G99\nG0 X20. Z2.\nG1 Z-20. F0.2\nM30", 1, &["G99 in line 1", "F0.2"]),
    ] {
        assert_declined(name, text, line, words);
    }
}

#[test]
fn lathe_programs_of_other_controls_are_declined() {
    for (name, dialect, text) in [
        ("diameters", Dialect::LinuxCnc, "G7 G18 G21\nG0 X20 Z2\nG1 Z-10 F100\nM2"),
        ("threading", Dialect::LinuxCnc, "G18\nG0 X10 Z2\nG76 P1 Z-20 I-1 J.2 K.9 R1.5 Q29.5 H2 E0 L0\nM2"),
        ("surface speed", Dialect::LinuxCnc, "G18 G95\nG96 D2500 S200 M3\nG0 X10 Z2\nG1 Z-20 F.2\nM2"),
        (
            "Siemens, diameters",
            Dialect::Siemens,
            "G18 G90 DIAMON\nG96 S200 LIMS=3000 M4\nG0 X60 Z2\nG1 Z-20 F0.2\nM30",
        ),
        (
            "Siemens, cycle",
            Dialect::Siemens,
            "G18 G54 G90\nG0 X60 Z2\nCYCLE95(\"K\",2,0,0,,0.2,0.2,0.2,9,0,0,0.5)\nM30",
        ),
        ("Okuma", Dialect::Okuma, "G50 S2500\nG96 S180 M3\nG0 X60 Z2 T0101\nG1 Z-20 F0.25\nM2"),
        (
            "Heidenhain",
            Dialect::Klartext,
            "0 BEGIN PGM A MM\n1 FUNCTION MODE TURN\n2 L X+50 Z+2 FMAX\n3 L Z-20 F0.2\n4 END PGM A MM\n",
        ),
    ] {
        assert!(declined(text, Some(dialect)).is_some(), "{name}");
    }
}

/// No control but Siemens' reads these words, and each control's lathe programs are declined by them.
#[test]
fn words_of_diameters_are_a_sign_in_every_dialect() {
    for (_, dialect, name) in Dialect::WORDS {
        for word in ["DIAMON", "G18 DIAM90 G90", "diamcyca", "DIAMONA[X]", "DIAMCYCOF"] {
            let text = format!("{word}\nG0 X20 Z2\nG1 Z-10 F100\nM30\n");
            let (line, message) =
                declined(&text, Some(dialect)).unwrap_or_else(|| panic!("{name}: {word} is quoted"));
            assert!(line == 1 && message.contains(" (X in diameters)"), "{name}: {message}");
        }
        for comment in ["; DIAMON", "(DIAMON)"] {
            let text = format!("{comment}\nG0 X20 Z2\nG1 Z-10 F100\nM30\n");
            assert_eq!(declined(&text, Some(dialect)), None, "{name}: {comment}");
        }
    }
    assert!(declined("DIAMON\nG0 X20 Z2\nG1 Z-10 F100\nM30\n", None).is_some());
    assert_eq!(declined("DIAMON\nG0 X20 Y5 Z2\nG1 Z-10 F100\nM30\n", None), None);
}

#[test]
fn a_sign_that_mills_hardly_have_leaves_the_time_in_doubt() {
    for (text, is_in_doubt) in [
        ("G50 S2500\nM3\nG0 X60 Z2\nG1 Z-20 F100\nM30", true),
        ("G92 S2500\nM3\nG0 X60 Z2\nG1 Z-20 F100\nM30", true),
        ("G0 X60. Z2.\nG1 Z-20. F0.25\nM30", true),
        ("G0 X22. Z5.\nG92 X19.2 Z-20. F1.5\nX18.8\nM30", true),
        ("G50 S2500\nM3\nG0 X60 Y0 Z2\nG1 Z-20 F100\nM30", false),
        ("G0 X60. Y0 Z2.\nG1 Z-20. F0.25\nM30", false),
        ("T0101\nG0 X60. Z2.\nG1 Z-20. F100.\nM30", false),
        ("G99\nG0 X60. Z2.\nG1 Z-20. F100.\nM30", false),
        ("G90 X60. Z2.\nG1 Z-20. F100.\nM30", false),
    ] {
        let toolpath = run(text, Some(Dialect::Iso));
        let doubts = toolpath.doubts.iter().filter(|doubt| doubt.cause == DoubtCause::PerhapsLathe).count();
        assert_eq!((toolpath.declined, doubts), (None, usize::from(is_in_doubt)), "{text}");
        let said =
            toolpath.diagnostics.iter().filter(|remark| remark.message.contains("may be a lathe program"));
        assert_eq!(said.count(), doubts, "{text}");
    }
}

#[test]
fn mills_are_not_declined_for_words_that_lathes_share() {
    for (dialect, text) in [
        (Dialect::Iso, "G21 G90\nG0 X0 Y0\nG96 S200 M3\nG1 X10 Y5 F200\nM30"),
        (Dialect::Iso, "G17 G40 G49 G50 G80 G90 S1000 M3\nG0 X0 Z5\nG1 X10 F200\nM30"),
        (Dialect::Iso, "G0 X0 Y0 Z5\nG73 X1 Y1 Z-5 R1 Q1 F100\nG76 X2 Y2 Z-5 R1 Q.1 P200 F50\nG80\nM30"),
        (Dialect::Iso, "G0 X0 Z5\nG76 X2 Z-5 R1 Q.1 P200 F50\nG80\nM30"),
        (
            Dialect::Iso,
            "G0 X0 Y0 Z5\nG98 G81 Z-5 R1 F100 L0\nG70 I20 J0 L6\nG71 I20 J0 K30 L6\nG72 I10 J0 L4\nM30",
        ),
        (Dialect::Mach, "G71 G90\nG0 X0 Z5\nG1 X10 F200\nG70\nG1 X1\nM30"),
        (Dialect::Siemens, "G71 G90 DIAMOF\nG0 X0 Y0 Z5\nG1 X10 F200\nG96 S100\nM30"),
        (Dialect::Iso, "T0101 M6\nG0 X0 Z5\nG1 X10 F200\nM30"),
        (Dialect::Iso, "T1001\nG0 X0 Z5\nG1 X10 F200\nM30"),
        (Dialect::Iso, "G0 X0 Z5\nG1 X10 F200\nG0 W-100.\nM30"),
        (Dialect::Iso, "G0 X0 Y0 U0 V0\nG1 X10 U5 V5 F200\nM30"),
        (Dialect::Iso, "G0 X0 Z5\nG4 U0.5\nG1 X10 F200\nG4 F0.5\nM30"),
        (Dialect::LinuxCnc, "G7.1\nG18 G0 X0 Z5\nG1 X10 F200\nG33 Z-5 K1\nM2"),
        (Dialect::LinuxCnc, "G17 G0 X0 Y0 Z5\nG76 P1 Z-20 I-1 J.2 K.9 R1.5 Q29.5\nM2"),
        (Dialect::Iso, "G21 G90 G94\nG0 X0 Z5\nG90 G1 X10 Z-1 F0.5\nM30"),
        (Dialect::Iso, "G90 X10 Z5\nG1 X10 Z-1 F200\nG94 X20 Z2\nM30"),
        (Dialect::Iso, "G20\nG0 X1. Z.2\nG90 X2. Z-.1 F.5\nM30"),
        (Dialect::Iso, "G40 G49 G80 G99\nG0 X0 Z5\nG81 X5 Z-5 R1 F100\nG99 X9\nG80\nM30"),
        (Dialect::Iso, "G0 X0 Y0 Z5\nG90 X10. Z-1. F0.2\nG99\nM30"),
        (
            Dialect::HeidenhainIso,
            "%A G71 *\nN10 G00 G40 G90 X+0 Y+0*\nN20 G01 X+10 F200*\nN99999999 %A G71 *",
        ),
    ] {
        assert_eq!(declined(text, Some(dialect)), None, "{dialect:?}: {text}");
    }
}

/// All of these are programs of mills.
#[test]
fn no_program_of_the_repository_is_declined() {
    fn files(folder: &std::path::Path) -> Vec<std::path::PathBuf> {
        let entries = std::fs::read_dir(folder).expect("the programs of the repository are always there");
        let paths = entries.map(|entry| entry.expect("a readable folder").path());
        paths.flat_map(|path| if path.is_dir() { files(&path) } else { vec![path] }).collect()
    }
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/programs");
    // Beside the programs are their remarks.
    let is_program = |path: &std::path::PathBuf| path.extension().is_none_or(|kind| kind != "expected");
    let programs: Vec<_> = files(&folder).into_iter().filter(is_program).collect();
    assert!(30 < programs.len());
    for path in programs {
        let text = std::fs::read(&path).expect("a readable file");
        let toolpath = trace_text(text, &Options::default(), &Machine::default());
        assert_eq!(toolpath.declined, None, "{}", path.display());
    }
}
