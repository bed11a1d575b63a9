//! Laws of tracing.

use super::*;
use crate::simulation::gcode::{Options, Severity, read, read_with};
use crate::simulation::toolpath::random::Random;
use crate::simulation::toolpath::{Curve, Motion, Point, Segment};
use crate::simulation::toolpath::{Stop, StopCause};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

fn run(text: &str) -> Toolpath {
    run_bytes(text.as_bytes())
}

fn run_bytes(text: &[u8]) -> Toolpath {
    let toolpath = trace(&read(text), &Machine::default());
    check_laws(&toolpath, text);
    toolpath
}

/// What holds of every toolpath.
fn check_laws(toolpath: &Toolpath, text: &[u8]) {
    let name = String::from_utf8_lossy(text);
    for segment in &toolpath.segments {
        assert!(0.0 < segment.length && segment.length.is_finite(), "{name}");
        if let Motion::Feed { feedrate } = segment.motion {
            assert!(0.0 < feedrate && feedrate.is_finite(), "{name}");
        }
        let size = size(&segment);
        assert!((segment.point(0.0) - segment.start).norm() <= 1e-9 * size, "{name}");
        assert!((segment.point(segment.length) - segment.end).norm() <= 1e-9 * size, "{name}");
    }
    assert!(toolpath.stops.is_sorted_by_key(|stop| stop.after), "{name}");
    assert!(toolpath.diagnostics.is_sorted_by_key(|diagnostic| diagnostic.line), "{name}");
}

fn size(segment: &Segment) -> f64 {
    let radius = match &segment.curve {
        Curve::Line => 0.0,
        Curve::Arc(arc) => arc.start_radius.max(arc.end_radius),
    };
    1.0 + radius + segment.start.coords.norm() + segment.end.coords.norm()
}

/// Both toolpaths are the same but for `tolerance`, mm.
#[track_caller]
fn assert_same(one: &Toolpath, other: &Toolpath, tolerance: f64) {
    assert_eq!(one.segments.len(), other.segments.len());
    for (a, b) in one.segments.iter().zip(&other.segments) {
        for fraction in [0.0, 0.3, 0.7, 1.0] {
            let apart = a.point(fraction * a.length) - b.point(fraction * b.length);
            assert!(apart.norm() <= tolerance, "{a:?}\n{b:?}");
        }
        let feedrate = |segment: &Segment| match segment.motion {
            Motion::Rapid { .. } => 0.0,
            Motion::Feed { feedrate } => feedrate,
        };
        assert!((feedrate(&a) - feedrate(&b)).abs() <= 1e-9 * feedrate(&a), "{a:?}\n{b:?}");
    }
}

#[track_caller]
fn sweeps(text: &str) -> Vec<f64> {
    let toolpath = run(text);
    let arcs = toolpath.segments.iter().filter_map(|segment| match segment.curve {
        Curve::Arc(arc) => Some(arc.sweep),
        Curve::Line => None,
    });
    arcs.collect()
}

#[track_caller]
fn messages(text: &str) -> Vec<(u32, Severity, String)> {
    let diagnostics = run(text).diagnostics;
    diagnostics.into_iter().map(|found| (found.line.0, found.severity, found.message)).collect()
}

impl Random {
    /// Uniform in −50 to 50 with three decimals.
    fn coordinate(&mut self) -> f64 {
        (self.below(100_001) as f64 - 50_000.0) / 1000.0
    }
}

#[test]
fn any_bytes_run() {
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    for _ in 0..20_000 {
        let length = random.below(120);
        let bytes: Vec<u8> = (0..length).map(|_| random.below(256) as u8).collect();
        run_bytes(&bytes);
    }
}

/// Programs of true words in any order reach deeper than random bytes.
#[test]
fn any_words_run() {
    let letters = b"GGGGGGMXYZXYZIJKRFPTLSABNO/%#[]<>=*+(;\n\n\n\n";
    let codes = [
        "0", "1", "2", "3", "17", "18", "19", "20", "90", "91", "90.1", "28", "53", "92", "52", "81", "80",
        "4", "68", "69", "51", "51.1", "50", "50.1", "16", "15", "10", "54", "55", "54.1", "93", "94", "95",
        "43.1", "92.1", "92.2", "92.3",
    ];
    let mut random = Random(0x2545_f491_4f6c_dd1d);
    for _ in 0..20_000 {
        let mut text = String::from("G1 F100\n");
        for _ in 0..random.below(60) {
            let letter = letters[random.below(letters.len())];
            text.push(letter as char);
            match random.below(8) {
                _ if letter == b'G' => text.push_str(codes[random.below(codes.len())]),
                0 => text.push_str(&"9".repeat(random.below(30))),
                1 => text.push('0'),
                2 => text.push_str("-.00001"),
                _ => text.push_str(&random.coordinate().to_string()),
            }
        }
        run(&text);
    }
}

#[test]
fn damaged_programs_run() {
    let program = "%\nO1(A)\nG20 G17 G90\nT1 M6\nG0 X1. Y-2.5 S1000 M3\nG43 Z.1 H1\nG1 Z-.1 F10.\nG2 X3. Y-2.5 I1. J0 Z-.2\n\
                   G3 X1. R1.\nG81 X1 Y1 Z-1 R.1\nX2\nG80\nG91 G28 Z0\nG4 P500\nG92 X0\nG41 D1\nM30\n%\n";
    let mut random = Random(0xd1b5_4a32_d192_ed03);
    for _ in 0..20_000 {
        let mut bytes = program.as_bytes().to_vec();
        for _ in 0..1 + random.below(6) {
            let at = random.below(bytes.len());
            match random.below(3) {
                0 => bytes[at] = random.below(256) as u8,
                1 => drop(bytes.remove(at)),
                _ => bytes.insert(at, b"0123456789.-GXYZ\n#[]<>=*/"[random.below(25)]),
            }
        }
        run_bytes(&bytes);
    }
}

#[test]
fn increments_give_the_path_of_their_sums() {
    let mut random = Random(7);
    let (mut absolute, mut incremental) = (String::from("F100 G1\n"), String::from("F100 G91 G1\n"));
    let mut at = [0.0; 3];
    for _ in 0..500 {
        let step = [random.coordinate(), random.coordinate(), random.coordinate()];
        (0..3).for_each(|axis| at[axis] += step[axis]);
        absolute += &format!("X{} Y{} Z{}\n", at[0], at[1], at[2]);
        incremental += &format!("X{} Y{} Z{}\n", step[0], step[1], step[2]);
    }
    assert_same(&run(&absolute), &run(&incremental), 1e-9);
}

#[test]
fn inches_are_millimetres_times_25_4() {
    let program = |unit: &str, scale: f64| {
        let mut random = Random(99);
        let mut text = format!("{unit} G1 F{}\n", 20.0 * scale);
        for _ in 0..200 {
            let mut next = || random.coordinate() * scale;
            text += &format!("G1 X{} Y{} Z{}\n", next(), next(), next());
            text += &format!("G91 G2 X{} I{} G90\n", 4.0 * scale, 2.0 * scale);
            text += &format!("G91 G3 Y{} R{} G90\n", 3.0 * scale, 2.5 * scale);
        }
        run(&text)
    };
    assert_same(&program("G20", 1.0), &program("G21", MM_PER_INCH), 1e-6);
}

/// An arc by its centre, incremental or absolute, and by its radius, in each plane.
#[test]
fn the_forms_of_an_arc_agree() {
    let mut random = Random(31);
    let planes = [("G17", "XY", "IJ"), ("G18", "ZX", "KI"), ("G19", "YZ", "JK")];
    for case in 0..600 {
        let (plane, axes, centers) = planes[case % 3];
        let [a, b] = [0, 1].map(|index| (axes.as_bytes()[index] as char, centers.as_bytes()[index] as char));
        let radius = 1.0 + random.below(40_000) as f64 / 1000.0;
        let from = random.below(360) as f64 * PI / 180.0;
        let sweep = (5 + random.below(350)) as f64 * PI / 180.0;
        if (sweep - PI).abs() < 0.05 {
            continue;
        }
        let turn = if case % 2 == 0 { 3 } else { 2 };
        let to = if turn == 3 { from + sweep } else { from - sweep };
        let center = [random.coordinate(), random.coordinate()];
        let start = [center[0] + radius * from.cos(), center[1] + radius * from.sin()];
        let end = [center[0] + radius * to.cos(), center[1] + radius * to.sin()];
        let head = format!("{plane} F100 G0 {}{} {}{}\n", a.0, start[0], b.0, start[1]);
        let end = format!("G{turn} {}{} {}{}", a.0, end[0], b.0, end[1]);
        let incremental = format!("{end} {}{} {}{}", a.1, center[0] - start[0], b.1, center[1] - start[1]);
        let absolute = format!("G90.1 {end} {}{} {}{}", a.1, center[0], b.1, center[1]);
        let by_radius = format!("{end} R{}", if PI < sweep { -radius } else { radius });
        let expected = run(&format!("{head}{incremental}"));
        assert!(expected.diagnostics.is_empty(), "{:?}", expected.diagnostics);
        assert!((expected.segments.length(1) - radius * sweep).abs() < 1e-9, "{incremental}");
        assert_same(&expected, &run(&format!("{head}{absolute}")), 1e-9);
        assert_same(&expected, &run(&format!("{head}{by_radius}")), 1e-6);
    }
}

#[test]
fn arcs_sweep_what_their_ends_say() {
    let near = |text: &str, expected: &[f64]| {
        let found = sweeps(text);
        assert_eq!(found.len(), expected.len(), "{text}");
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9), "{text}: {found:?}");
    };
    near("F1 G3 X10 Y10 I0 J10", &[FRAC_PI_2]);
    near("F1 G2 X10 Y10 I0 J10", &[3.0 * FRAC_PI_2]);
    near("F1 G2 I5", &[TAU]);
    near("F1 G2 X0 Y0 Z5 I5", &[TAU]);
    near("F1 G3 X10 I5 P4", &[3.0 * TAU + PI]);
    // Sums of increments come back to their start but for rounding: a full circle all the same.
    near("F1 G91 G1 X.1\nX.2\nG90 G3 X.3 I5", &[TAU]);
    near("F1 G91 G1 X.1\nX.2\nG90 G2 X.3 I5", &[TAU]);
}

/// The position stays right where an arc cannot be run.
#[test]
fn impossible_arcs_become_straight_lines() {
    for text in ["G2 X10 Y5", "G2 X10 Y5 R1", "G3 X10 Y5 I0 J0", "G17 G3 X10 Y5 K3"] {
        let toolpath = run(&format!("F100\n{text}\nG1 X20 Y5"));
        assert_eq!(toolpath.segments.at(0).curve, Curve::Line, "{text}");
        assert_eq!(toolpath.segments.at(0).end, Point::new(10.0, 5.0, 0.0), "{text}");
        assert_eq!(toolpath.diagnostics.len(), 1, "{text}");
        assert_eq!(toolpath.diagnostics[0].severity, Severity::Error, "{text}");
    }
    assert!(messages("F1 G2 X10.01 Y0 R5").is_empty(), "rounding of R is taken as it is");
    let spiral = messages("F1 G2 X10.5 Y0 I5");
    assert_eq!(spiral[0].1, Severity::Warning);
    assert!(spiral[0].2.contains("5.0000") && spiral[0].2.contains("5.5000"), "{spiral:?}");
}

#[test]
fn shifts_of_coordinates_move_nothing() {
    let end = |text: &str| run(text).segments.last().expect("a move").end;
    assert_eq!(end("G0 X10 Y5\nG92 X0\nG0 X1"), Point::new(11.0, 5.0, 0.0));
    assert_eq!(end("G0 X10 Y5\nG92 X0\nG92.2\nG0 X1"), Point::new(1.0, 5.0, 0.0));
    assert_eq!(end("G0 X10 Y5\nG92 X0\nG92.2\nG92.3\nG0 X1"), Point::new(11.0, 5.0, 0.0));
    assert_eq!(end("G0 X10\nG52 X3\nG0 X1"), Point::new(4.0, 0.0, 0.0));
    assert_eq!(end("G0 X10\nG52 X3\nG92 X0\nG0 X1"), Point::new(11.0, 0.0, 0.0));
    assert_eq!(end("G0 X10\nG52 X3\nG52 X0\nG0 X1"), Point::new(1.0, 0.0, 0.0));
    assert_eq!(run("G0 X10\nG92 X0\nG52 X3").segments.len(), 1);
}

#[test]
fn reference_points_are_reached_where_they_are_known() {
    let mut machine = Machine::default();
    machine.axes[2].home = Some(150.0);
    let ends = |text: &str| -> Vec<[f64; 3]> {
        let toolpath = trace(&read(text.as_bytes()), &machine);
        toolpath.segments.iter().map(|segment| segment.end.coords.into()).collect()
    };
    assert_eq!(ends("G0 Z5\nG91 G28 Z10"), [[0.0, 0.0, 5.0], [0.0, 0.0, 15.0], [0.0, 0.0, 150.0]]);
    assert_eq!(ends("G0 Z5\nG53 Z-20"), [[0.0, 0.0, 5.0], [0.0, 0.0, 130.0]]);
    assert_eq!(ends("G0 Z5\nG30 X7"), [[0.0, 0.0, 5.0], [7.0, 0.0, 5.0]]);
    let unknown = messages("G28 Z0\nG53 Z0\nG28 X0");
    assert_eq!(unknown.len(), 2);
    assert!(unknown[0].2.contains("axis.z.home_mm") && unknown[1].2.contains("axis.x.home_mm"));
}

#[test]
fn stops_stand_where_their_words_act() {
    let stops = |text: &str| -> Vec<(usize, StopCause)> {
        let spindle_by_word = |cause| match cause {
            StopCause::Spindle { code: Some(code), .. } => StopCause::MCode { code },
            other => other,
        };
        run(text).stops.iter().map(|stop| (stop.after, spindle_by_word(stop.cause))).collect()
    };
    let code = |code| StopCause::MCode { code };
    assert_eq!(stops("G0 X1 M3\nX2 M5\nX3 M8 M0"), [(0, code(3)), (2, code(5)), (2, code(8)), (3, code(0))]);
    assert_eq!(stops("T4\nG0 X1 M6"), [(0, StopCause::ToolChange { tool: Some(4) })]);
    assert_eq!(stops("G0 X1\nM30\nG0 X2\nM3"), [(1, code(30))]);
    assert_eq!(stops("T5 S1000 D1 H1"), []);
    let dwell = |seconds| StopCause::Dwell { seconds };
    assert_eq!(stops("G4 P2\nG4 P.5\nG4 X3"), [(0, dwell(2.0)), (0, dwell(0.5)), (0, dwell(3.0))]);
    assert_eq!(stops("O1\nG4 P2\nG4 P.5\nG4 X3."), [(0, dwell(0.002)), (0, dwell(0.5)), (0, dwell(3.0))]);
}

/// The waits of a program, s.
fn waits(text: &str, dialect: Option<Dialect>) -> Vec<f64> {
    let options = Options { dialect, ..Options::default() };
    let seconds = |stop: Stop| match stop.cause {
        StopCause::Dwell { seconds } => Some(seconds),
        _ => None,
    };
    let toolpath = trace(&read_with(text.as_bytes(), &options), &Machine::default());
    toolpath.stops.into_iter().filter_map(seconds).collect()
}

/// A time without a point counts milliseconds on Fanuc controls, by X and U as well as by P.
#[test]
fn times_without_a_point_are_milliseconds_on_a_tape() {
    assert_eq!(waits("O1\nG4 X1000\nG4 U500\nG4 X1000.\nG4 U0.5", None), [1.0, 0.5, 1000.0, 0.5]);
    assert_eq!(waits("O1\n#1=2\nG4 X#1\nG4 P#1", None), [2.0, 0.002], "a formula of X has a point");
    let said = run("O1\nG4 X1000\nG4 X2000").diagnostics;
    assert_eq!(said.len(), 1, "{said:?}");
    assert!(said[0].message.starts_with("a time without a decimal point is read as milliseconds"));
}

/// Of an unknown control, a number of seconds is hardly 100 or more; a chosen dialect keeps its own.
#[test]
fn long_times_without_a_point_are_milliseconds() {
    assert_eq!(waits("G4 P500\nG4 X100\nG4 U99\nG4 P500.\nG4 P2", None), [0.5, 0.1, 99.0, 500.0, 2.0]);
    let said = run("G4 P500\nG4 P700\nG4 X100").diagnostics;
    assert_eq!(said.len(), 1, "once: {said:?}");
    assert_eq!(said[0].severity, Severity::Warning);
    assert!(said[0].message.contains("write a point or choose the dialect"));
    for dialect in [Dialect::LinuxCnc, Dialect::Grbl, Dialect::Mach] {
        assert_eq!(waits("G4 P500", Some(dialect)), [500.0], "{dialect:?}");
    }
    assert_eq!(waits("G4 F500", Some(Dialect::Siemens)), [500.0]);
}

#[test]
fn exact_stops_hold_as_asked() {
    let toolpath = run("F1 G1 X1\nG9 X2\nX3\nG61\nX4\nX5\nG64 X6");
    let found: Vec<bool> = toolpath.segments.iter().map(|segment| segment.exact_stop).collect();
    assert_eq!(found, [false, true, false, true, true, false]);
}

#[test]
fn what_is_left_out_is_said() {
    let cases = [
        ("G5 X1", Severity::Error, "G5 "),
        ("G0 G1 F1 X1", Severity::Error, "exclude"),
        ("G93 G1 F2 X1\nX2", Severity::Error, "G93"),
        ("G93 F-2", Severity::Error, "F-2"),
        ("G95 F.1 G1 X1", Severity::Error, "G95"),
        ("G1 F9 Y1\nG96 S200", Severity::Warning, "G96"),
        ("S-5", Severity::Error, "S-5"),
        ("G43.4 H1", Severity::Warning, "G43.4 (tool centre point control)"),
        ("G43 H3", Severity::Info, "G43: the length"),
        ("G1 F1 X1 A1", Severity::Info, "a degree counts as a unit"),
        ("G0 A99999999", Severity::Error, "A99999999"),
        ("G68 X1", Severity::Error, "G68"),
        ("G51 X1", Severity::Error, "G51"),
        ("G54.1 X1", Severity::Error, "G54.1"),
        ("G51 I2 J1 K1\nG2 F1 X2 I1", Severity::Warning, "scale"),
        ("M98 P5", Severity::Error, "5 is not in this file"),
        ("F-1", Severity::Error, "F-1"),
        ("G1 X1", Severity::Error, "1000 mm/min"),
        ("G0 X1e9\nG0 X100000000", Severity::Warning, "E words"),
        ("G41 D1", Severity::Warning, "tools.1.diameter_mm"),
        ("G0 U5", Severity::Warning, "U words"),
        ("G81 X1 Y1 Z-1", Severity::Error, "G81: no R: hole not made"),
        ("G10 L3 P1 X0", Severity::Info, "G10"),
        ("G54\nG0 X1\nG54\nG58", Severity::Info, "G58"),
    ];
    for (text, severity, part) in cases {
        let found = messages(text);
        assert!(
            found.iter().any(|(_, is, message)| *is == severity && message.contains(part)),
            "{text}: {found:?}"
        );
    }
    for text in ["G0 G17 G21 G40 G49 G54 G64 G80 G90 G94 G98", "G43 H0 Z5 G0", "G0 X0 Y0", "S100 T1 D1"] {
        assert_eq!(messages(text), [], "{text}");
    }
}

#[test]
fn axis_words_of_others_move_nothing() {
    for text in [
        "G10 L2 P1 X5",
        "G68 X5 Y5 R45",
        "G51 X5 P2",
        "G51.1 X5",
        "G92 X5",
        "G52 X5",
        "G4 X5",
        "G22 X5 Z-5 I-5 K-9",
    ] {
        assert!(run(&format!("F1 G1\n{text}")).segments.is_empty(), "{text}");
    }
    // G5.1 names the axes that it smooths; the cylinder of G7.1 has the radius C.
    for text in ["G5.1 Q1 X0 Y0 Z0", "G5.1 Q0 X0 Y0 Z0", "G7.1 C25", "G107 C0"] {
        let found = run(&format!("%\nO1\nF1 G1 X5\n{text}\n"));
        assert_eq!((found.segments.len(), found.stops.len()), (1, 0), "{text}");
    }
}

#[test]
fn a_million_remarks_make_a_short_list() {
    let text = "G5 X1\nG0 U1 X1\nG41 D.5\n".repeat(20_000);
    assert_eq!(messages(&text).len(), 403);
}

#[test]
fn a_rapid_carries_the_feedrate_that_is_in_force() {
    let rapids = |text: &str| -> Vec<f64> {
        let toolpath = run(text);
        let modal = |segment: Segment| match segment.motion {
            Motion::Rapid { modal_feedrate } => Some(modal_feedrate),
            Motion::Feed { .. } => None,
        };
        toolpath.segments.iter().filter_map(modal).collect()
    };
    let none = f64::INFINITY;
    assert_eq!(rapids("G0 X1\nG1 X2 F600\nG0 X3\nX4\nX5 F1200\n"), [none, 10.0, 10.0, 20.0]);
    assert_eq!(rapids("G20 G1 X1 F60\nG0 X2\n"), [25.4]);
    // Neither the time of a move nor a feed of a revolution is a feedrate for a rapid.
    assert_eq!(rapids("G93 G1 X1 F2\nG0 X2\nG95 G1 X3 F0.1 S1000 M3\nG0 X4\n"), [none, none]);
}
