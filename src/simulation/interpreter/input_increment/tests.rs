//! Laws of lengths without a decimal point.

use crate::machine::Machine;
use crate::simulation::gcode::{self, Dialect, Options};
use crate::simulation::interpreter::trace;
use crate::simulation::toolpath::Toolpath;

fn run(text: &str, dialect: Dialect, increment: Option<f64>) -> Toolpath {
    let mut machine = Machine::default();
    machine.program.increment = increment;
    let options = Options { dialect: Some(dialect), ..Options::default() };
    trace(&gcode::read_with(text.as_bytes(), &options), &machine)
}

const THOUSANDTHS: Option<f64> = Some(0.001);

/// The same program with points and in increments.
#[test]
fn increments_are_lengths_with_a_point() {
    let pairs = [
        ("G0 X10.5 Y-2. Z0.001", "G0 X10500 Y-2000 Z1"),
        ("G1 X10. F100\nG2 X20. I5. J0.", "G1 X10000 F100\nG2 X20000 I5000 J0"),
        ("G2 X20. R10. F500", "G2 X20000 R10000 F500"),
        ("O1\nG83 X1. Z-10. R2. Q3. F100", "O1\nG83 X1000 Z-10000 R2000 Q3000 F100"),
        ("G20\nG0 X1. Y-0.5", "G20\nG0 X10000 Y-5000"),
        ("G20 G0 X1.", "G20 G0 X10000"),
        ("G52 X1.\nG0 X0.", "G52 X1000\nG0 X0"),
        ("G10 L2 P1 X5.\nG0 X1.", "G10 L2 P1 X5000\nG0 X1000"),
        ("#1=5.\nG0 X#1 Y[#1*2] Z1.", "#1=5\nG0 X#1 Y[#1*2] Z1000"),
        ("#1=#0\nG0 X#1 Y2. Z1.", "#1=#0\nG0 X#1 Y2000 Z1000"),
        ("G4 X1.\nG0 X1.", "G4 X1000\nG0 X1000"),
        ("O1\nG4 X200.\nG0 X1.", "O1\nG4 X200000\nG0 X1000"),
        ("G20\nG4 U200.\nG0 X1.", "G20\nG4 U200000\nG0 X10000"),
    ];
    for (with_points, in_increments) in pairs {
        let [expected, found] = [with_points, in_increments].map(|text| run(text, Dialect::Iso, THOUSANDTHS));
        assert!(!expected.segments.is_empty(), "{with_points}");
        assert_eq!(found.segments.len(), expected.segments.len(), "{in_increments}");
        for (found, expected) in found.segments.iter().zip(&expected.segments) {
            assert!(
                (found.end - expected.end).norm() < 1e-9,
                "{in_increments}: {} {}",
                found.end,
                expected.end
            );
            assert!((found.length - expected.length).abs() < 1e-9, "{in_increments}");
        }
        assert_eq!(found.stops, expected.stops, "{in_increments}");
    }
}

/// Words that are no lengths, numbers with a point, and other dialects are as written.
#[test]
fn all_else_stays_as_written() {
    let text = "G1 X10. F500 S1000 M3\nA90\nG4 P500\nG5.1 Q1 R5\nG65 P9000 X1000 R2000\nM98 P9001 Q1\nG0 Z5.\nM30\nO9000\nG0 X#24 Y#18\nM99\nO9001\nM99\n";
    let [expected, found] = [None, THOUSANDTHS].map(|increment| run(text, Dialect::Iso, increment));
    assert_eq!((&found.segments, &found.stops), (&expected.segments, &expected.stops));
    for dialect in [Dialect::LinuxCnc, Dialect::Grbl, Dialect::Mach, Dialect::Siemens] {
        let [expected, found] =
            [None, THOUSANDTHS].map(|increment| run("G0 X1000\nG1 Y5.5 F10", dialect, increment));
        assert_eq!(found, expected, "{dialect:?}");
    }
}

#[test]
fn a_large_number_without_a_point_is_told_once() {
    let told = |text: &str, increment| {
        let toolpath = run(text, Dialect::Iso, increment);
        let told: Vec<_> = toolpath
            .diagnostics
            .iter()
            .filter(|told| told.message.contains("program.increment_mm"))
            .collect();
        told.iter().map(|told| (told.line.0, told.columns)).collect::<Vec<_>>()
    };
    assert_eq!(told("G0 X1.5\nY10000\nX-20000", None), [(2, (1, 7))]);
    assert_eq!(told("G0 X1.5\nY10000\nX-20000", THOUSANDTHS), []);
    assert_eq!(told("G0 X15\nY4000", None), [], "no word has a point");
    assert_eq!(told("G0 X1.5\nY100\nF2000 S8000", None), [], "no length is large");
    assert_eq!(told("G0 X1.5\nG65 P1 X10000", None), [], "an argument is no length");
    assert_eq!(told("G0 X1.5\nG4 X10000", None), [], "a time is no length");
    let linuxcnc = run("G0 X1.5\nY10000", Dialect::LinuxCnc, None);
    assert!(linuxcnc.diagnostics.is_empty(), "{:?}", linuxcnc.diagnostics);
}

/// Where no length has a point, only a path that no machine travels looks like increments.
#[test]
fn a_long_path_without_points_is_told() {
    let told = |text: &str, dialect, increment| {
        let toolpath = run(text, dialect, increment);
        let mut told =
            toolpath.diagnostics.iter().filter(|told| told.message.contains("program.increment_mm"));
        let first = told.next().map(|told| told.line.0);
        assert_eq!(told.next(), None, "{text}");
        first
    };
    let iso = Dialect::Iso;
    assert_eq!(told("G0 X100\nG1 Y60000 F500\nX-90000", iso, None), Some(2));
    assert_eq!(told("G0 X3000\nX-1900\nX-2100", iso, None), Some(3), "none of them is far from the origin");
    assert_eq!(told("G20\nG0 X200", iso, None), Some(2));
    assert_eq!(told("G0 X5000\nG1 Y-5000 F500", iso, None), None);
    assert_eq!(told("G0 X100.\nG1 Y60000. F500", iso, None), None);
    assert_eq!(told("G0 X100\nG1 Y60000 F500", iso, THOUSANDTHS), None);
    assert_eq!(told("G0 X100\nG1 Y60000 F500", Dialect::Okuma, None), Some(2));
    for dialect in [Dialect::LinuxCnc, Dialect::Grbl, Dialect::Mach, Dialect::Siemens] {
        assert_eq!(told("G0 X100\nG1 Y60000 F500", dialect, None), None, "{dialect:?}");
    }
}
