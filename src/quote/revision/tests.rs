use super::*;
use crate::machine::Machine;
use crate::simulation::gcode::{Options, read_with};
use crate::simulation::interpreter::trace;
use crate::simulation::simulate;

const OLD: &str = "G21 G90\nN10 G0 X0 Y0\nN20 G1 X50 F600\nN30 Y50\nN40 X0\nN50 Y0\nM30\n";

fn compared(first: &str, second: &str) -> (Revisions, [f64; 2]) {
    let machine = Machine::default();
    let [one, other] =
        [first, second].map(|text| trace(&read_with(text.as_bytes(), &Options::default()), &machine));
    let [before, after] = [&one, &other].map(|toolpath| simulate::simulate(toolpath, &machine));
    let times = [before.cycle_time(), after.cycle_time()];
    let [first, second] = [(first, &one, &before), (second, &other, &after)]
        .map(|(text, toolpath, plan)| Revision { text: text.as_bytes(), toolpath, plan });
    (revisions(&first, &second), times)
}

#[test]
fn a_line_that_is_added_is_a_run_of_its_own_and_numbers_do_not_matter() {
    let new = "G21 G90\nN10 G0 X0 Y0\nN20 G1 X50 F600\nN30 G4 P2\nN40 Y50\nn50 x0\nN60 Y0\nM30\n";
    let (found, times) = compared(OLD, new);
    let told: Vec<_> = found.runs.iter().map(|run| (run.is_same, run.lines.clone())).collect();
    assert_eq!(told, [(true, [1..4, 1..4]), (false, [4..4, 4..5]), (true, [4..8, 5..9])]);
    let added = &found.runs[1];
    assert_eq!(added.seconds[0], 0.0);
    assert_eq!(added.seconds[1], 2.0, "the dwell");
    assert_eq!(added.distance, None);
    let sums = [0, 1].map(|side| found.runs.iter().map(|run| run.seconds[side]).sum::<f64>());
    assert!((sums[0] - times[0]).abs() < 1e-9 && (sums[1] - times[1]).abs() < 1e-9, "{sums:?} {times:?}");
}

#[test]
fn a_feedrate_changes_the_time_of_lines_that_did_not_change() {
    let new = OLD.replace("F600", "F300");
    let (found, times) = compared(OLD, &new);
    let told: Vec<_> = found.runs.iter().map(|run| (run.is_same, run.lines[1].clone())).collect();
    assert_eq!(told, [(true, 1..3), (false, 3..4), (true, 4..8)]);
    let [before, after] = found.runs[2].seconds;
    assert!(10.0 < after - before, "three sides of 50 mm at 5 mm/s instead of 10: {before} {after}");
    assert_eq!(found.runs[2].length, [150.0, 150.0]);
    assert_eq!(found.runs[2].distance, Some((50.0, 200.0)));
    // Where the path ends the second is later by all of the difference, and halfway by half of that of the lines
    // so far.
    assert!((found.later.last().expect("a row") - (times[1] - times[0])).abs() < 1e-9);
    assert_eq!(found.distance.last(), Some(&200.0));
    assert!(found.later.windows(2).all(|pair| pair[0] <= pair[1] + 1e-9));
}

#[test]
fn lines_that_moved_are_anchored_by_the_longest_order_that_both_have() {
    let text = |lines: &[&str]| lines.join("\n");
    let (found, counts) =
        runs(text(&["A1", "B1", "C1", "D1"]).as_bytes(), text(&["C1", "A1", "B1", "D1"]).as_bytes());
    assert_eq!(counts, [4, 4]);
    let told: Vec<_> = found.iter().map(|run| (run.is_same, run.lines.clone())).collect();
    assert_eq!(
        told,
        [(false, [1..1, 1..2]), (true, [1..3, 2..4]), (false, [3..4, 4..4]), (true, [4..5, 4..5])]
    );
}

#[test]
fn every_line_of_both_is_in_one_run_whatever_they_say() {
    let mut state = 7u64;
    let mut next = move |below: u64| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) % below
    };
    for _ in 0..200 {
        let mut text = || {
            let length = next(30);
            (0..length).map(|_| format!("X{}", next(12))).collect::<Vec<_>>()
        };
        let [one, other] = [text(), text()];
        let (found, counts) = runs(one.join("\n").as_bytes(), other.join("\n").as_bytes());
        assert_eq!(counts, [one.len(), other.len()]);
        let mut at = [1, 1];
        for LineRun { lines: [first, second], is_same } in found {
            assert_eq!([first.start, second.start], at);
            let own = |text: &[String], lines: &Range<u32>| {
                text[lines.start as usize - 1..lines.end as usize - 1].to_vec()
            };
            assert_eq!(own(&one, &first) == own(&other, &second), is_same, "{one:?} {other:?}");
            at = [first.end, second.end];
        }
        assert_eq!(at, [one.len() as u32 + 1, other.len() as u32 + 1]);
    }
}

#[test]
fn one_and_the_same_program_differs_nowhere() {
    let (found, _) = compared(OLD, OLD);
    assert_eq!(found.runs.len(), 1);
    assert!(found.runs[0].is_same);
    assert!(found.later.iter().all(|later| *later == 0.0));
    let (empty, counts) = runs(b"", b"");
    assert!(empty.is_empty() && counts == [0, 0]);
}
