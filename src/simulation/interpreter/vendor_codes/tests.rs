//! Laws of words of single families: the same moves as written out in words of all.

use crate::machine::Machine;
use crate::simulation::gcode::{self, Dialect, Options};
use crate::simulation::interpreter::trace;
use crate::simulation::toolpath::{Segment, StopCause, Toolpath};

fn run_on(machine: &Machine, text: &str, dialect: Dialect) -> Toolpath {
    let options = Options { dialect: Some(dialect), ..Options::default() };
    trace(&gcode::read_with(text.as_bytes(), &options), machine)
}

fn run(text: &str, dialect: Dialect) -> Toolpath {
    run_on(&Machine::default(), text, dialect)
}

#[track_caller]
fn check_alike(found: &Toolpath, expected: &Toolpath) {
    let moves = |toolpath: &Toolpath| -> Vec<(Segment, f64)> {
        toolpath.segments.iter().map(|segment| (segment.clone(), segment.length)).collect()
    };
    let (found, expected) = (moves(found), moves(expected));
    assert_eq!(found.len(), expected.len(), "{found:?}\n{expected:?}");
    for ((found, length), (expected, expected_length)) in found.iter().zip(&expected) {
        assert!((found.end - expected.end).norm() < 1e-9, "{} instead of {}", found.end, expected.end);
        assert!((length - expected_length).abs() < 1e-9);
        assert_eq!(found.motion, expected.motion);
    }
}

const CYCLE: &str = "O1\nG0 X10. Y5. Z20.\nG99 G81 Z-5. R2. F100 L0\n";

#[test]
fn patterns_are_holes_at_their_places() {
    let half = 10.0 * std::f64::consts::FRAC_1_SQRT_2;
    let patterns: [(&str, &[[f64; 2]]); 5] = [
        ("G70 I10. J0 L4", &[[20.0, 5.0], [10.0, 15.0], [0.0, 5.0], [10.0, -5.0]]),
        ("G70 I-10. J90. L4", &[[10.0, 15.0], [20.0, 5.0], [10.0, -5.0], [0.0, 5.0]]),
        ("G70 X0 Y0 I10. J0 L2", &[[10.0, 0.0], [-10.0, 0.0]]),
        ("G71 I10. J0 K45. L2", &[[20.0, 5.0], [10.0 + half, 5.0 + half]]),
        ("G72 I10. J90. L3", &[[10.0, 5.0], [10.0, 15.0], [10.0, 25.0]]),
    ];
    for (word, places) in patterns {
        let places: String = places.iter().map(|[x, y]| format!("X{x:.17} Y{y:.17}\n")).collect();
        let found = run(&format!("{CYCLE}{word}\n"), Dialect::Iso);
        check_alike(&found, &run(&format!("{CYCLE}{places}"), Dialect::Iso));
        assert!(found.diagnostics.is_empty(), "{word}: {:?}", found.diagnostics);
        // Turned, the whole pattern turns.
        let turned = CYCLE.replace("O1\n", "O1\nG68 X0 Y0 R30.\n");
        check_alike(
            &run(&format!("{turned}{word}\n"), Dialect::Iso),
            &run(&format!("{turned}{places}"), Dialect::Iso),
        );
    }
    for word in
        ["G70 I10. J0 L0", "G70 I10. J0 L1000000000", "G71 I10. L4", "G70 I10. J0", "G80\nG70 I10. L4"]
    {
        let nothing = run(&format!("{CYCLE}{word}\n"), Dialect::Iso);
        assert_eq!(nothing.segments.len(), 1, "{word}");
        assert!(!nothing.diagnostics.is_empty(), "{word}");
    }
}

/// With T it is Brother's; without, the end of Haas' mirror.
#[test]
fn a_one_touch_change_is_a_change_and_the_way_to_the_work() {
    let block = |word: &str| format!("O1\nG90 G0 X1. Y2. Z50.\n{word}\nG1 X60. F100.\n");
    let found = run(&block("G100 T5 X10. Y20. Z5. G43 H5 M3 S8000"), Dialect::Iso);
    let written_out = run(&block("T5 M6\nM3 S8000\nG0 X10. Y20.\nG43 H5 Z5."), Dialect::Iso);
    check_alike(&found, &written_out);
    let causes = |toolpath: &Toolpath| -> Vec<_> {
        toolpath.stops.iter().map(|stop| (stop.after, stop.cause)).collect()
    };
    assert_eq!(causes(&found), causes(&written_out));
    assert_eq!(found.spins, written_out.spins);
    let mirrored = run("G101 X0\nG100\nG0 X1.", Dialect::Iso);
    assert!(mirrored.stops.is_empty() && mirrored.segments.last().is_some_and(|last| last.end.x == 1.0));
}

#[test]
fn units_and_scales_of_mach() {
    let found = run("G71 G0 X10 Y10\nG70 X2\nG71\nG51 X2 Y.5\nG1 X40 Y8 F100\nG50\nX10\n", Dialect::Mach);
    let expected = "G21 G0 X10 Y10\nG20 X2\nG21\nG1 X80 Y4 F100\nX10\n";
    check_alike(&found, &run(expected, Dialect::Mach));
    assert!(found.diagnostics.is_empty(), "{:?}", found.diagnostics);
}

/// As slicers write them at the head of a file; a Fanuc control's M code behind its move stays one.
#[test]
fn settings_are_no_moves() {
    let settings = "M201 X500 Y500 Z100 E5000\nM203 X500 Y500\nM205 X8 Y8 E5\nM92 X80 E93\nM566 X480\n";
    for dialect in [Dialect::Iso, Dialect::LinuxCnc, Dialect::Grbl, Dialect::Mach] {
        let found = run(&format!("G1 X1. F100\n{settings}Y2.\n"), dialect);
        check_alike(&found, &run("G1 X1. F100\nY2.\n", dialect));
        let lines: Vec<u32> = found.diagnostics.iter().map(|told| told.line.0).collect();
        assert_eq!(lines, [2, 3, 4, 5, 6], "{dialect:?}: {:?}", found.diagnostics);
    }
    assert_eq!(run("G1 X1. F100\nX5. M203\nM203 G1 X7.", Dialect::Iso).segments.len(), 3);
}

#[test]
fn offsets_of_okuma_are_those_of_the_machine() {
    let mut machine = Machine::default();
    machine.work_offsets[0] = Some([100.0, 0.0, 0.0]);
    machine.work_offsets[1] = Some([0.0, 50.0, 0.0]);
    let okuma = "G15 H1\nG0 X1. Y1.\nG15 H2 X2.\nG16 H0 X3. Y3.\nX4.\nG15 H1 Y5.\n";
    let fanuc = "G54\nG0 X1. Y1.\nG55 X2.\nG10 L2 P6 X0 Y0 Z0\nG59 X3. Y3.\nG55 X4.\nG54 Y5.\n";
    check_alike(&run_on(&machine, okuma, Dialect::Okuma), &run_on(&machine, fanuc, Dialect::Iso));
    let without = run("G15\nG0 X1.\nG15 H1.5", Dialect::Okuma);
    assert_eq!(without.diagnostics.iter().filter(|told| told.message.contains("needs H")).count(), 2);
    // G56 is a tool length there, and no offset.
    let length = run_on(&machine, "G15 H1\nG56 H2\nG0 X1.\nG53\nX2.", Dialect::Okuma);
    assert_eq!(length.segments.last().expect("it moves").end.x, 102.0);
}

#[test]
fn cycles_of_okuma_return_by_m_words() {
    let heights = |text: &str| -> Vec<f64> {
        let toolpath = run(&format!("G0 Z30.\n{text}"), Dialect::Okuma);
        toolpath.segments.iter().map(|segment| segment.end.z).collect()
    };
    assert_eq!(heights("G71 Z10.\nG81 X1. Z-5. R2. F9 M53"), [30.0, 30.0, 2.0, -5.0, 10.0]);
    assert_eq!(heights("G71 Z10.\nG81 X1. Z-5. R2. F9 M54"), [30.0, 30.0, 2.0, -5.0, 2.0]);
    let without = "G81 X1. Z-5. R2. F9 M53";
    assert_eq!(heights(without), [30.0, 30.0, 2.0, -5.0, 30.0]);
    assert!(!run(without, Dialect::Okuma).diagnostics.is_empty());
    let row = heights("G71 Z10.\nG81 X1. Z-5. R2. F9 M54\nNCYL X2.\nX3.");
    assert_eq!(row, [30.0, 30.0, 2.0, -5.0, 2.0, 2.0, 2.0, -5.0, 2.0]);
    // M53 and M54 make the machine wait for nothing.
    assert!(run("G71 Z10.\nG81 X1. Z-5. R2. F9 M53", Dialect::Okuma).stops.is_empty());
}

#[test]
fn dwells_of_okuma_are_seconds() {
    for (text, seconds) in [("G4 F2", 2.0), ("G4 F0.5", 0.5)] {
        let stops = run(text, Dialect::Okuma).stops;
        assert!(
            matches!(stops[..], [stop] if stop.cause == StopCause::Dwell { seconds }),
            "{text}: {stops:?}"
        );
    }
}

#[test]
fn a_kept_position_is_the_reference_point() {
    let text = "G21 G90\nG0 X1 Y2 Z3\nG28.1\nG0 X5 Y5 Z5\nG30.1\nG0 X9\nG28 Z6\nG0 Z9\nG30 X9\n";
    for dialect in [Dialect::Grbl, Dialect::LinuxCnc] {
        let toolpath = run(text, dialect);
        assert!(toolpath.diagnostics.is_empty(), "{:?}", toolpath.diagnostics);
        let ends: Vec<[f64; 3]> = toolpath.segments.iter().map(|segment| segment.end.coords.into()).collect();
        let expected: [[f64; 3]; 7] = [
            [1.0, 2.0, 3.0],
            [5.0, 5.0, 5.0],
            [9.0, 5.0, 5.0],
            [9.0, 5.0, 6.0],
            [9.0, 5.0, 3.0],
            [9.0, 5.0, 9.0],
            [5.0, 5.0, 9.0],
        ];
        assert_eq!(ends, expected, "{dialect:?}");
    }
}

/// Tool and mode do not change, and a remark names what is missing.
#[test]
fn words_that_are_not_run_say_what_is_missing() {
    let words = [
        (Dialect::Iso, "G31.1 Z-5.", "contact"),
        (Dialect::Mach, "G28.1 X0", "homing"),
        (Dialect::Mach, "G13 I5", "pocket"),
        (Dialect::Iso, "G12 I5. D1", "pocket"),
        (Dialect::Iso, "G47 X1. (ABC)", "engraving"),
        (Dialect::Mach, "G32 Z-5 K1", "threading"),
        (Dialect::Iso, "G37 Z-5.", "measuring"),
        (Dialect::LinuxCnc, "G7", "diameters"),
        (Dialect::Iso, "G5.4 X9.", "not understood"),
    ];
    for (dialect, word, what) in words {
        let text = |word: &str| format!("G0 X1. Y1.\n{word}\nX2.\n");
        let found = run(&text(word), dialect);
        check_alike(&found, &run(&text(""), dialect));
        assert!(
            found.diagnostics.iter().any(|told| told.message.contains(what)),
            "{word}: {:?}",
            found.diagnostics
        );
    }
    let again = run("G0 X1\nM47\nX2\n", Dialect::Mach);
    assert_eq!(again.segments.len(), 1, "one run is timed");
}
