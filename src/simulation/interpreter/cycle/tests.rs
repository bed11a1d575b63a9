//! Laws of cycles in programs.

use crate::machine::Machine;
use crate::simulation::gcode::{Severity, read};
use crate::simulation::interpreter::trace;
use crate::simulation::toolpath::{Motion, StopCause, Toolpath};

fn run(text: &str) -> Toolpath {
    trace(&read(text.as_bytes()), &Machine::default())
}

/// Ends of all moves, feed moves with the sign of `F`.
fn moves(text: &str) -> Vec<(char, [f64; 3])> {
    let letter = |motion: Motion| if motion.is_rapid() { 'R' } else { 'F' };
    let rounded = |value: f64| (1e6 * value).round() / 1e6;
    let toolpath = run(text);
    let ends = toolpath.segments.iter().map(|segment| (letter(segment.motion), segment.end));
    ends.map(|(letter, end)| (letter, [end.x, end.y, end.z].map(rounded))).collect()
}

fn messages(text: &str) -> Vec<(Severity, String)> {
    run(text).diagnostics.into_iter().map(|found| (found.severity, found.message)).collect()
}

#[track_caller]
fn assert_error(text: &str, part: &str) {
    let all = messages(text);
    let is_said = all.iter().any(|(severity, text)| *severity == Severity::Error && text.contains(part));
    assert!(is_said, "{text}: {all:?}");
    assert_eq!(moves(text).len(), 1, "{text}: the hole is not made");
}

fn feed_length(toolpath: &Toolpath) -> f64 {
    let is_feed = |segment: &crate::simulation::toolpath::Segment| !segment.motion.is_rapid();
    toolpath.segments.iter().filter(is_feed).map(|segment| segment.length).sum()
}

#[test]
fn drilling_is_five_moves() {
    let expected = [
        ('R', [0.0, 0.0, 10.0]),
        ('R', [5.0, 6.0, 10.0]),
        ('R', [5.0, 6.0, 2.0]),
        ('F', [5.0, 6.0, -3.0]),
        ('R', [5.0, 6.0, 10.0]),
    ];
    assert_eq!(moves("G0 Z10\nG98 G81 X5 Y6 Z-3 R2 F100"), expected);
    assert_eq!(moves("O1\nG0 Z10\nG81 X5 Y6 Z-3 R2 F100"), expected);
}

#[test]
fn the_same_hole_in_every_plane_and_unit() {
    let one = moves("G17 G0 Z10\nG98 G83 X5 Y6 Z-3 R2 Q1.5 F100\nX7");
    for (text, order) in [
        ("G18 G0 Y10\nG98 G83 Z5 X6 Y-3 R2 Q1.5 F100\nZ7", [2, 0, 1]),
        ("G19 G0 X10\nG98 G83 Y5 Z6 X-3 R2 Q1.5 F100\nY7", [1, 2, 0]),
    ] {
        let turned = |(letter, end): (char, [f64; 3])| (letter, order.map(|axis| end[axis]));
        assert_eq!(moves(text).into_iter().map(turned).collect::<Vec<_>>(), one);
    }
    let inch = moves("G20 G0 Z0.5\nG98 G83 X0.5 Z-0.5 R0.125 Q0.25 F10");
    assert_eq!(inch, moves("G0 Z12.7\nG98 G83 X12.7 Z-12.7 R3.175 Q6.35 F254"));
}

#[test]
fn increments_repeat_along_the_row() {
    for head in ["", "O1\n"] {
        let row = moves(&format!("{head}G0 Z10\nG98 G91 G81 X5 Y1 Z-5 R-8 L3 F100"));
        let holes = moves(&format!("{head}G0 Z10\nG98 G81 X5 Y1 Z-3 R2 F100\nX10 Y2\nX15 Y3"));
        assert_eq!(row, holes);
    }
}

/// R and Z of a Fanuc program stay where they are; on LinuxCNC their numbers become increments.
#[test]
fn a_row_after_an_absolute_hole() {
    let text = "G0 Z10\nG98 G81 X0 Z-3 R2 F100\nG91 X5 K2";
    let lowest = |text: &str| moves(text).iter().map(|(_, end)| end[2]).fold(f64::INFINITY, f64::min);
    assert_eq!(lowest(&format!("O1\n{text}")), -3.0);
    assert_eq!(lowest(text), -3.0);
    assert_eq!(moves(&format!("O1\n{text}")).last(), Some(&('R', [10.0, 0.0, 10.0])));
    assert_eq!(moves(text).last(), Some(&('R', [10.0, 0.0, 12.0])));
}

#[test]
fn no_repeat_moves_nothing_and_keeps_the_words() {
    for head in ["", "O1\n"] {
        let none = format!("{head}G0 Z10\nG98 G81 X5 Z-3 R2 F100 L0");
        assert_eq!(moves(&none).len(), 1);
        assert_eq!(moves(&format!("{none}\nX5")), moves(&none.replace(" L0", "")));
    }
}

#[test]
fn a_hole_returns_to_r_or_to_the_height_it_began_at() {
    for head in ["", "O1\n"] {
        let last = |text: &str| moves(&format!("{head}{text}")).pop().expect("a move").1[2];
        assert_eq!(last("G0 Z10\nG99 G81 X5 Z-3 R2 F100"), 2.0);
        assert_eq!(last("G0 Z10\nG99 G81 X5 Z-3 R2 F100\nG98 X6"), 10.0);
        assert_eq!(last("G0 Z10\nG99 G81 X5 Z-3 R2 F100\nX6\nG98 G82 X7 Z-3 R2 P0."), 10.0);
        assert_eq!(last("G0 Z10\nG99 G81 X5 Z-3 R2 F100\nG80\nG98 G81 X6 Z-3 R2"), 2.0);
    }
    assert_eq!(moves("O1\nG0 Z10\nG81 X5 Z-3 R2 F9").last(), Some(&('R', [5.0, 0.0, 10.0])));
    assert_eq!(moves("G0 Z10\nG81 X5 Z-3 R2 F9").last(), Some(&('R', [5.0, 0.0, 2.0])));
}

#[test]
fn pecks_feed_as_long_as_they_should() {
    for (head, clearance) in [("", 0.254), ("O1\n", 1.0)] {
        for code in [73, 83] {
            let toolpath = run(&format!("{head}G0 Z10\nG{code} X1 Z-10 R2 Q5 F100"));
            assert!((feed_length(&toolpath) - 12.0 - 2.0 * clearance).abs() < 1e-9, "{head} G{code}");
            let deep = run(&format!("{head}G0 Z10\nG{code} X1 Z-10 R2 Q50 F100"));
            assert_eq!(deep.segments, run(&format!("{head}G0 Z10\nG81 X1 Z-10 R2 F100")).segments);
        }
    }
    let mut machine = Machine::default();
    machine.cycles.peck_retract = Some(0.5);
    machine.cycles.peck_clearance = Some(0.75);
    let feed = |text: &str| feed_length(&trace(&read(text.as_bytes()), &machine));
    assert_eq!(feed("G0 Z10\nG73 X1 Z-10 R2 Q5 F100"), 13.0);
    assert_eq!(feed("O1\nG0 Z10\nG83 X1 Z-10 R2 Q5 F100"), 13.5);
}

#[test]
fn a_dwell_is_in_the_unit_of_g4() {
    let dwells = |text: &str| {
        let causes = run(text).stops.into_iter().map(|stop| stop.cause);
        causes.collect::<Vec<_>>()
    };
    for (text, seconds) in [
        ("G0 Z9\nG82 X1 Z-1 R2 P1.5 F9", 1.5),
        ("G0 Z9\nG82 X1 Z-1 R2 P2 F9", 2.0),
        ("O1\nG0 Z9\nG82 X1 Z-1 R2 P500 F9", 0.5),
        ("O1\nG0 Z9\nG89 X1 Z-1 R2 P0.5 F9", 0.5),
    ] {
        assert_eq!(dwells(text), [StopCause::Dwell { seconds }], "{text}");
    }
    let guessed = "G0 Z9\nG82 X1 Z-1 R2 P500 F9";
    assert_eq!(dwells(guessed), [StopCause::Dwell { seconds: 0.5 }]);
    assert!(messages(guessed).iter().any(|(severity, _)| *severity == Severity::Warning));
    assert_eq!(dwells("G0 Z9\nG81 X1 Z-1 R2 P2 F9"), []);
    assert_eq!(dwells("O1\nG0 Z9\nG83 X1 Z-1 R2 Q1 P500. F9"), []);
}

#[test]
fn a_tap_turns_the_spindle_round_and_back() {
    let codes = |text: &str| {
        let codes = run(text).stops.into_iter().filter_map(|stop| match stop.cause {
            StopCause::MCode { code } | StopCause::Spindle { code: Some(code), .. } => Some(code),
            _ => None,
        });
        codes.collect::<Vec<_>>()
    };
    assert_eq!(codes("G0 Z9\nG84 X1 Z-1 R2 F9"), [5, 4, 5, 3]);
    assert_eq!(codes("G0 Z9\nG74 X1 Z-1 R2 F9"), [5, 3, 5, 4]);
    assert_eq!(codes("O1\nG0 Z9\nM29 S100\nG84 X1 Z-1 R2 F9"), [29, 4, 3]);
    assert_eq!(codes("O1\nM4\nG0 Z9\nG86 X1 Z-1 R2 F9"), [4, 5, 4]);
    let fast = run("O1\nG0 Z9\nG84 X1 Z-1 R2 J3 F60");
    let feeds: Vec<Motion> = fast.segments.iter().map(|s| s.motion).filter(|m| !m.is_rapid()).collect();
    assert_eq!(feeds, [Motion::Feed { feedrate: 1.0 }, Motion::Feed { feedrate: 3.0 }]);
}

#[test]
fn fine_boring_leaves_the_wall_alone() {
    let expected = [
        ('R', [0.0, 0.0, 9.0]),
        ('R', [4.0, 0.0, 9.0]),
        ('R', [4.0, 0.0, 2.0]),
        ('F', [4.0, 0.0, -1.0]),
        ('R', [4.5, 0.0, -1.0]),
        ('R', [4.5, 0.0, 9.0]),
        ('R', [4.0, 0.0, 9.0]),
    ];
    assert_eq!(moves("O1\nG0 Z9\nG76 X4 Z-1 R2 Q0.5 F9"), expected);
    assert_eq!(moves("O1\nG0 Z9\nG76 X4 Z-1 R2 I0.5 F9"), expected);
}

/// On Fanuc R lies below the bore, which goes up to Z; on LinuxCNC it goes from Z up to K.
#[test]
fn back_boring_works_upwards() {
    let upwards = [
        ('R', [0.5, 0.0, 9.0]),
        ('R', [0.5, 0.0, -20.0]),
        ('R', [0.0, 0.0, -20.0]),
        ('F', [0.0, 0.0, -15.0]),
        ('R', [0.5, 0.0, -15.0]),
        ('R', [0.5, 0.0, 9.0]),
        ('R', [0.0, 0.0, 9.0]),
    ];
    assert_eq!(moves("O1\nG0 Z9\nG87 X0 Z-15 R-20 Q0.5 F9")[1..], upwards);
    let linuxcnc = moves("G0 Z9\nG98 G87 X0 Z-20 R2 I0.5 J0 K-15 F9");
    let feeds: Vec<f64> = linuxcnc.iter().filter(|(kind, _)| *kind == 'F').map(|(_, end)| end[2]).collect();
    assert_eq!(feeds, [-15.0, -20.0]);
}

#[test]
fn a_cycle_ends_by_g80_or_a_motion_word() {
    for end in ["G80\nG0", "G1", "G0"] {
        let ends = moves(&format!("G0 Z10\nG81 X5 Z-3 R2 F100\n{end} X9"));
        assert_eq!(ends.len(), 6, "{end}");
    }
}

/// Holes in a subprogram: P of M98 is no dwell.
#[test]
fn words_of_a_block_without_a_hole_do_not_stay() {
    let text = "O1\nG0 Z10\nG82 X5 Z-3 R2 P500 F100\nM98 P9000 Q3\nX6";
    let dwells = run(text).stops.into_iter().filter(|stop| matches!(stop.cause, StopCause::Dwell { .. }));
    assert!(dwells.map(|stop| stop.cause).eq([StopCause::Dwell { seconds: 0.5 }; 2]));
}

#[test]
fn a_wrong_hole_is_not_made() {
    for head in ["", "O1\n"] {
        assert_error(&format!("{head}G0 Z10\nG81 X5 Z-3 F100"), "no R");
        assert_error(&format!("{head}G0 Z10\nG81 X5 R2 F100"), "no depth (Z)");
        assert_error(&format!("{head}G0 Z10\nG81 X5 Z3 R2 F100"), "above R");
        assert_error(&format!("{head}G0 Z10\nG83 X5 Z-3 R2 F100"), "no Q");
        assert_error(&format!("{head}G0 Z10\nG73 X5 Z-3 R2 Q0 F100"), "pecks of 0 mm");
        assert_error(&format!("{head}G0 Z10\nG81 X5 Z-3 R200000000 F100"), "beyond 10 km");
    }
    assert_error("O1\nG0 Z10\nG76 X5 Z-3 R2 I99999999 F100", "beyond 10 km");
    assert_error("G0 Z10\nG83 X5 Z-3 R2 Q-1 F100", "pecks of -1 mm");
    assert_error("G0 Z10\nG76 P1 X5 Z-3 I1 J1 K1 R2 F100", "threading");
    assert_error("G0 Z10\nG87 X5 Z-3 I1 R2 F100", "no top of the bore (K)");
    assert_eq!(moves("O1\nG0 Z10\nG83 X5 Z-3 R2 Q-1 F100"), moves("O1\nG0 Z10\nG83 X5 Z-3 R2 Q1 F100"));
    let repeats = messages("G0 Z10\nG81 X5 Z-3 R2 L-1 F100");
    assert!(repeats[0].1.contains("cannot be repeated -1 times"), "{repeats:?}");
    let dwell = messages("G0 Z10\nG82 X5 Z-3 R2 P-1 F100");
    assert!(dwell[0].1.contains("waiting time of -1 s"), "{dwell:?}");
}

#[test]
fn a_short_text_asks_for_no_endless_work() {
    let toolpath = run(&format!("G0 Z10\nG91 G83 X1 Z-5 R-8 Q0.0001 F100\n{}", "X1 L9999\n".repeat(3)));
    assert!(toolpath.segments.len() <= 2_000_002, "{}", toolpath.segments.len());
    let said = |part: &str| toolpath.diagnostics.iter().any(|found| found.message.contains(part));
    assert!(said("more than 1000 pecks") && said("more than 2000000 moves"));
}
