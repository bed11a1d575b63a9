//! Remarks name what a program loses and what is assumed for it, in every dialect.

use crate::machine::Machine;
use crate::simulation::gcode::{Dialect, Options, Severity, read_with};
use crate::simulation::interpreter::trace;
use crate::simulation::toolpath::{Curve, Motion, Toolpath};

fn run(dialect: Dialect, text: &str) -> Toolpath {
    let options = Options { dialect: Some(dialect), ..Options::default() };
    trace(&read_with(text.as_bytes(), &options), &Machine::default())
}

/// The lines of the errors and warnings that hold `part`.
fn lines_of(toolpath: &Toolpath, part: &str) -> Vec<u32> {
    let matters = toolpath.diagnostics.iter().filter(|diagnostic| diagnostic.severity != Severity::Info);
    matters
        .filter(|diagnostic| diagnostic.message.contains(part))
        .map(|diagnostic| diagnostic.line.0)
        .collect()
}

fn last_feedrate_mm_min(toolpath: &Toolpath) -> f64 {
    match toolpath.segments.last().expect("a move").motion {
        Motion::Feed { feedrate } => 60.0 * feedrate,
        Motion::Rapid { .. } => f64::NAN,
    }
}

#[test]
fn a_mode_of_feed_forgets_its_former_f() {
    for dialect in [Dialect::Iso, Dialect::LinuxCnc, Dialect::Mach, Dialect::Grbl, Dialect::Siemens] {
        for (text, lines) in [
            ("G21 G94 F600\nG93 G1 X10 F2\nG94 X20\nX30", &[3][..]),
            ("G21 G94 F600\nG93 G1 X10 F2\nG94\nX20 F700", &[]),
            ("G21 G94 F600\nS1000 M3\nG95 G1 X10 F0.2\nG94 X20", &[4]),
            ("G21 S1000 M3\nG95 F0.2\nG94 G1 X10 F600\nG95 X20", &[4]),
        ] {
            let toolpath = run(dialect, text);
            assert_eq!(lines_of(&toolpath, "cancelled the feedrate"), lines, "{dialect:?}: {text}");
        }
    }
    let toolpath = run(Dialect::Iso, "G94 F600\nG93 G1 X10 F2\nG94 X20");
    assert!((last_feedrate_mm_min(&toolpath) - 600.0).abs() < 1e-9, "the former F is the best guess");
    let again = "G94 F600\nG1 X10\nG94\nX20\nX30";
    assert_eq!(
        lines_of(&run(Dialect::LinuxCnc, again), "cancelled the feedrate"),
        [4],
        "as rs274 refuses it"
    );
    assert!(lines_of(&run(Dialect::Iso, again), "cancelled the feedrate").is_empty());
}

#[test]
fn turns_of_a_helix_by_l_are_run_and_told() {
    let turns = |toolpath: &Toolpath| match toolpath.segments.last().expect("a move").curve {
        Curve::Arc(ref arc) => (arc.sweep / std::f64::consts::TAU).round(),
        Curve::Line => 0.0,
    };
    let helix = "G21 G90 F600\nG0 X10 Y0\nG2 X10 Y0 I-10 Z-3 L3";
    let toolpath = run(Dialect::Iso, helix);
    assert_eq!((turns(&toolpath), lines_of(&toolpath, "number of turns")), (3.0, vec![3]));
    for dialect in [Dialect::LinuxCnc, Dialect::Grbl, Dialect::Mach, Dialect::Okuma] {
        let toolpath = run(dialect, helix);
        assert_eq!(
            (turns(&toolpath), lines_of(&toolpath, "L has no meaning")),
            (1.0, vec![3]),
            "{dialect:?}"
        );
    }
    let both = run(Dialect::Iso, "G21 F600\nG0 X10\nG2 X10 Y0 I-10 Z-3 P2 L3");
    assert_eq!((turns(&both), lines_of(&both, "L has no meaning")), (2.0, vec![3]));
    let pitch = run(Dialect::Iso, "G21 F600\nG0 X10\nG2 X10 Y0 I-10 Z-3 K1");
    assert_eq!((turns(&pitch), lines_of(&pitch, "K has no meaning")), (1.0, vec![3]));
    let zero = run(Dialect::Iso, "G21 F600\nG0 X10\nG2 X10 Y0 I-10 K0 Z-3 L1\nG18 G2 X0 I-5 K0 Z-3");
    assert_eq!(lines_of(&zero, "turns").len() + lines_of(&zero, "has no meaning").len(), 0);
    let bad = run(Dialect::Iso, "G21 F600\nG0 X10\nG2 X10 Y0 I-10 Z-3 L2.5");
    assert_eq!(lines_of(&bad, "L2.5 is not a number of turns"), [3]);
}

#[test]
fn pecks_beyond_the_bound_are_told_in_every_cycle_of_klartext() {
    let drill = |cycle: u32, settings: &str| {
        let text = format!(
            "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S1000\n2 CYCL DEF {cycle} HOLE Q200=2 Q201=-50 Q206=150 Q203=+0 Q204=50 {settings}\n3 L X+0 Y+0 R0 FMAX M99\n4 END PGM A MM\n"
        );
        lines_of(&run(Dialect::Klartext, &text), "more than 1000 pecks").len()
    };
    for (cycle, settings) in [(200, ""), (203, "Q213=0 Q205=0.01"), (205, "Q205=0.01 Q258=0.2 Q259=0.2")] {
        assert_eq!(drill(cycle, &format!("{settings} Q202=5")), 0, "{cycle}");
        assert_eq!(drill(cycle, &format!("{settings} Q202=0.02")), 1, "{cycle}");
    }
    assert_eq!(drill(205, "Q202=50 Q205=0.01 Q257=0.001 Q256=0.1"), 1, "chip breaks");
    assert_eq!(drill(209, "Q239=1 Q257=0.02 Q256=0.1"), 1, "taps");
    assert_eq!(drill(209, "Q239=1 Q257=10 Q256=0.1"), 0, "taps");
}

#[test]
fn patterns_without_a_possible_number_of_holes_are_told() {
    for pattern in [
        "HOLES1(0,0,0,0,10,{})",
        "HOLES2(0,0,20,0,30,{})",
        "CYCLE801(0,0,0,5,5,{},2,0)",
        "CYCLE801(0,0,0,5,5,2,{},0)",
    ] {
        for (count, is_told) in [("4", false), ("0", true), ("100000000", true), ("-3", true)] {
            let call = pattern.replace("{}", count);
            let text = format!("F100 S1000 M3\nG0 X0 Y0 Z10\nMCALL CYCLE81(10,0,2,-5)\n{call}\nMCALL\nM30");
            let toolpath = run(Dialect::Siemens, &text);
            assert_eq!(!lines_of(&toolpath, "is no number of holes").is_empty(), is_told, "{call}");
            assert_eq!(toolpath.segments.len() <= 1, is_told, "{call}");
        }
    }
    for (cycle, settings) in [
        (220, "Q216=0 Q217=0 Q244=50 Q245=0 Q246=360 Q247=0 Q241={}"),
        (221, "Q225=0 Q226=0 Q237=5 Q238=5 Q242={} Q243=2 Q224=0"),
    ] {
        for (count, is_told) in [("4", false), ("0", true), ("1000000", true)] {
            let settings = settings.replace("{}", count);
            let text = format!(
                "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S1000\n2 CYCL DEF 200 HOLE Q200=2 Q201=-5 Q206=150 Q202=5 Q203=+0 Q204=50\n3 CYCL DEF {cycle} PATTERN {settings}\n4 L Z+100 FMAX\n5 END PGM A MM\n"
            );
            let toolpath = run(Dialect::Klartext, &text);
            assert_eq!(!lines_of(&toolpath, "is no number of holes").is_empty(), is_told, "{cycle}, {count}");
        }
    }
}
