use super::*;
use crate::simulation::feed::CornerPolicy;
use crate::simulation::gcode::read;
use crate::simulation::interpreter::trace;
use crate::simulation::simulate;

fn timed(text: &str) -> (f64, Trust) {
    let machine = crate::machine::presets()[1].machine.clone();
    let toolpath = trace(&read(text.as_bytes()), &machine);
    let plan = simulate::with_policy(&toolpath, &machine, CornerPolicy::Programmed);
    (plan.cycle_time(), trust(&toolpath, &machine, &plan))
}

const SOUND: &str =
    "G90 G17\nG0 X10 Y0\nG1 Z-1 F500\nG1 X30 Y0 F900\nG3 X20 Y10 I-10 J0\nG1 X0 Y10\nX0 Y0\nG0 Z50\n";

/// The doubts of a program that is sound but for `to` in place of `from`; they hold the true time.
fn broken(from: &str, to: &str) -> Trust {
    assert!(SOUND.contains(from), "{from}");
    let (right, sure) = timed(SOUND);
    assert_eq!(sure, Trust::default());
    let (stated, trust) = timed(&SOUND.replacen(from, to, 1));
    let (error, doubt) = ((stated - right).abs(), trust.seconds_in_doubt());
    assert!(error <= doubt, "{to}: {error} s off, {doubt} s in doubt, {trust:?}");
    trust
}

fn causes(trust: &Trust) -> Vec<DoubtCause> {
    trust.doubts.iter().map(|doubt| doubt.cause).collect()
}

#[test]
fn an_arc_that_does_not_close_is_bounded_by_those_that_do() {
    for (from, to) in [("I-10", "I-4"), ("I-10", "I-25"), ("J0", "J7"), ("X20", "X24"), ("Y10 I", "Y6 I")] {
        let trust = broken(from, to);
        assert_eq!(causes(&trust), [DoubtCause::OpenArcs], "{to}");
        assert_eq!(trust.doubts[0].lines, (LineNumber(5), LineNumber(5)));
        // No more than two full turns of it.
        assert!(trust.seconds_in_doubt() < 25.0, "{to}: {trust:?}");
    }
}

/// A helix of one turn, with turns that the control may run beside it.
#[test]
fn turns_that_may_be_run_have_a_cause_of_their_own() {
    let helix = |words: &str| format!("G0 X10 Y0 Z1\nG2 X10 Y0 I-10 Z-5{words} F1000\nG0 Z50\n");
    let (one, sure) = timed(&helix(""));
    let (three, _) = timed(&helix(" P3"));
    assert_eq!(sure, Trust::default());
    for words in [" L3", " K2", " L3 K2", " P3.5"] {
        let (stated, trust) = timed(&helix(words));
        assert_eq!(causes(&trust), [DoubtCause::UnclearTurns], "{words}");
        assert_eq!((trust.doubts[0].count, trust.is_bounded()), (1, true), "{words}: {trust:?}");
        for meant in [one, three] {
            let (error, doubt) = ((stated - meant).abs(), trust.seconds_in_doubt());
            assert!(error <= doubt && doubt < 2.0 * (three - one), "{words}: {error} s off, {trust:?}");
        }
    }
}

/// The time grows with the pecks by as much for each, so that two programs with few of them tell that of many.
#[test]
fn pecks_that_are_left_out_are_bounded() {
    let iso = |peck: f64| format!("G0 X0 Y0 Z5\nG98 G83 X10 Z-48 R2 Q{peck} F500\nX20\nG80\nM30\n");
    let klartext = |peck: f64| {
        format!(
            "BEGIN PGM A MM\nTOOL CALL 1 Z S1000\nL X+0 Y+0 Z+5 R0 FMAX\nCYCL DEF 200 Q200=2 Q201=-48 Q206=500 Q202={peck} Q210=0.1 Q203=0 Q204=5 Q211=0\nL X+10 Y+0 R0 FMAX M99\nL X+20 R0 FMAX M99\nEND PGM A MM\n"
        )
    };
    let programs = [("G83", iso as fn(f64) -> String, 50.0), ("cycle 200", klartext, 48.0)];
    for (name, program, depth) in programs {
        let pecked = |pecks: f64| timed(&program(depth / pecks));
        let ((few, none), (more, _)) = (pecked(400.0), pecked(800.0));
        assert_eq!(none, Trust::default(), "{name}");
        let true_time = more + (more - few) / 400.0 * (5000.0 - 800.0);
        let (stated, trust) = pecked(5000.0);
        assert_eq!((causes(&trust), trust.doubts[0].count), (vec![DoubtCause::UnmadeHoles], 2), "{name}");
        let (error, doubt) = (true_time - stated, trust.seconds_in_doubt());
        assert!(error <= doubt && doubt < 1.3 * error, "{name}: {error} s off, {trust:?}");
    }
    // Pecks that shrink without a least one have no number.
    let text = "G0 X0 Y0 Z5 F100\nMCALL CYCLE83(5,0,1,-50,,-5,,-0.5,0,0,1,0)\nX10 Y0\nMCALL\nM30\n";
    let (_, trust) = timed(text);
    assert_eq!((causes(&trust), trust.is_bounded()), (vec![DoubtCause::UnmadeHoles], false), "{trust:?}");
}

#[test]
fn words_and_blocks_that_cannot_be_read_are_bounded_by_the_moves_around_them() {
    for (from, to, cause) in [
        ("X30 ", "X ", DoubtCause::UnreadWords),
        ("X30 ", "X3..0 ", DoubtCause::UnreadWords),
        ("G1 X0 Y10", "G1 X0 ?10", DoubtCause::BlocksNotRun),
        ("F900", "F", DoubtCause::UnreadWords),
        ("G0 Z50", "G Z50", DoubtCause::UnreadWords),
    ] {
        let trust = broken(from, to);
        assert!(causes(&trust).contains(&cause) && trust.is_bounded(), "{to}: {trust:?}");
    }
}

#[test]
fn a_feed_that_is_missing_is_bounded_by_those_of_the_program() {
    let trust = broken(" F500", "");
    assert_eq!(causes(&trust), [DoubtCause::MissingFeeds]);
    let (stated, trust) = timed(&SOUND.replace(" F500", "").replace(" F900", ""));
    // It is unknown: more than the time itself is in doubt.
    assert!(stated < trust.seconds_in_doubt() && trust.is_bounded(), "{trust:?}");
}

#[test]
fn what_nothing_bounds_says_so() {
    let (_, trust) = timed(&SOUND.replace("G0 Z50", "M98 P77\nG0 Z50"));
    assert_eq!(causes(&trust), [DoubtCause::MissingSubprograms]);
    assert_eq!((trust.is_bounded(), trust.seconds_in_doubt()), (false, 0.0));
}

#[test]
fn a_reference_position_is_in_doubt_until_the_machine_gives_it() {
    let text = SOUND.replace("G0 Z50", "G28 Z50");
    let (_, trust) = timed(&text);
    assert_eq!(causes(&trust), [DoubtCause::UnknownHome]);
    let mut machine = crate::machine::presets()[1].machine.clone();
    machine.axes[2].home = Some(100.0);
    let toolpath = trace(&read(text.as_bytes()), &machine);
    assert!(toolpath.doubts.is_empty());
}

#[test]
fn every_doubt_counts() {
    let text = "G1 X1 F500\n".to_string() + &"X2 Y\nX1 Y3\nG2 X5 I1\n".repeat(3000);
    let (_, trust) = timed(&text);
    assert!(3000 <= trust.doubts.iter().map(|doubt| doubt.count).max().unwrap_or(0));
}

/// The length is noticed at the end of the program, and in doubt at its line.
#[test]
fn a_length_without_its_point_is_in_doubt_where_it_stands() {
    let text =
        "G21 G90\nG0 X0.5 Y0.5\nG1 Y5000 F1000\nY6.5\nX10.5\n".to_string() + &"X0.5\nX10.5\n".repeat(50);
    let (stated, trust) = timed(&text);
    let (right, _) = timed(&text.replace("Y5000", "Y5."));
    assert_eq!(causes(&trust), [DoubtCause::MissingPoints]);
    assert_eq!(trust.doubts[0].lines, (LineNumber(3), LineNumber(3)));
    let (error, doubt) = ((stated - right).abs(), trust.seconds_in_doubt());
    assert!(error <= doubt && doubt < 1.1 * error, "{error} s off, {doubt} s in doubt");
    // A shift may be off for all that follows.
    let (_, trust) = timed("G21 G90\nG52 X5000\nG0 X0.5\nG1 X9.5 F1000\n");
    assert_eq!((causes(&trust), trust.is_bounded()), (vec![DoubtCause::MissingPoints], false));
}
