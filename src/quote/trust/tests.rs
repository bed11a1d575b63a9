use super::*;
use crate::simulation::feed::Rule;
use crate::simulation::gcode::read;
use crate::simulation::simulate;
use crate::simulation::toolpath::trace;

fn timed(text: &str) -> (f64, Trust) {
    let machine = crate::machine::presets()[1].machine.clone();
    let toolpath = trace(&read(text.as_bytes()), &machine);
    let plan = simulate::by_rule(&toolpath, &machine, Rule::Programmed);
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

fn causes(trust: &Trust) -> Vec<Cause> {
    trust.doubts.iter().map(|doubt| doubt.cause).collect()
}

#[test]
fn an_arc_that_does_not_close_is_bounded_by_those_that_do() {
    for (from, to) in [("I-10", "I-4"), ("I-10", "I-25"), ("J0", "J7"), ("X20", "X24"), ("Y10 I", "Y6 I")] {
        let trust = broken(from, to);
        assert_eq!(causes(&trust), [Cause::OpenArcs], "{to}");
        assert_eq!(trust.doubts[0].lines, (LineNumber(5), LineNumber(5)));
        // No more than two full turns of it.
        assert!(trust.seconds_in_doubt() < 25.0, "{to}: {trust:?}");
    }
}

#[test]
fn words_and_blocks_that_cannot_be_read_are_bounded_by_the_moves_around_them() {
    for (from, to, cause) in [
        ("X30 ", "X ", Cause::UnreadWords),
        ("X30 ", "X3..0 ", Cause::UnreadWords),
        ("G1 X0 Y10", "G1 X0 ?10", Cause::BlocksNotRun),
        ("F900", "F", Cause::UnreadWords),
        ("G0 Z50", "G Z50", Cause::UnreadWords),
    ] {
        let trust = broken(from, to);
        assert!(causes(&trust).contains(&cause) && trust.is_bounded(), "{to}: {trust:?}");
    }
}

#[test]
fn a_feed_that_is_missing_is_bounded_by_those_of_the_program() {
    let trust = broken(" F500", "");
    assert_eq!(causes(&trust), [Cause::MissingFeeds]);
    let (stated, trust) = timed(&SOUND.replace(" F500", "").replace(" F900", ""));
    // Nobody knows it: more than the time itself is in doubt.
    assert!(stated < trust.seconds_in_doubt() && trust.is_bounded(), "{trust:?}");
}

#[test]
fn what_nothing_bounds_says_so() {
    let (_, trust) = timed(&SOUND.replace("G0 Z50", "M98 P77\nG0 Z50"));
    assert_eq!(causes(&trust), [Cause::MissingSubprograms]);
    assert_eq!((trust.is_bounded(), trust.seconds_in_doubt()), (false, 0.0));
}

#[test]
fn a_reference_position_is_in_doubt_until_the_machine_gives_it() {
    let text = SOUND.replace("G0 Z50", "G28 Z50");
    let (_, trust) = timed(&text);
    assert_eq!(causes(&trust), [Cause::UnknownHome]);
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
