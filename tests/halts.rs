//! Halts that a recording shows and the machine believed in does not have are found again.

use std::fmt::Write;
use std::ops::Range;

use truefeed::identification::alignment::{Alignment, align};
use truefeed::identification::diagnosis::{Diagnosis, Verdict, diagnose, feed_holds};
use truefeed::identification::effects::Reported;
use truefeed::identification::fit::Run;
use truefeed::identification::recording;
use truefeed::machine::{Machine, Planner};
use truefeed::project::machine_from_toml;
use truefeed::simulation::feed::CornerPolicy;
use truefeed::simulation::gcode::read;
use truefeed::simulation::interpreter::trace;
use truefeed::simulation::profile::Profile;
use truefeed::simulation::simulate;
use truefeed::simulation::toolpath::Toolpath;

/// A meander of lines and arcs with rapids between, and holes with a dwell at their bottom.
fn program() -> String {
    let mut text = String::from("G21 G90\nG0 X0 Y0 Z5\nG1 Z0 F600\n");
    for row in 0..12 {
        let y = 4 * row;
        let _ = write!(text, "G1 X40 Y{y} F1800\nG3 X40 Y{} J1 I0\nG1 X3 F1200\nY{}\n", y + 2, y + 4);
        if row % 4 == 3 {
            let _ = write!(text, "G0 Z5\nG0 X{row} Y{}\nG1 Z0 F600\n", y + 4);
        }
    }
    for hole in 0..6 {
        let _ = write!(text, "G0 X{} Y50 Z5\nG1 Z-4 F600\nG4 P0.25\nG0 Z5\n", 7 * hole);
    }
    text + "G0 Z20\n"
}

/// The line of the dwell in a hole of the program.
fn dwell(hole: usize) -> u32 {
    let program = program();
    let mut dwells = program.lines().zip(1..).filter(|(line, _)| line.starts_with("G4"));
    dwells.nth(hole).map_or(0, |(_, line)| line)
}

/// What a recorder sees of a run, every 10 ms and to a micrometre or two, as a table.
fn recorded(program: &str, machine: &Machine) -> String {
    let toolpath = trace(&read(program.as_bytes()), machine);
    let plan = simulate::with_policy(&toolpath, machine, CornerPolicy::Programmed);
    let profile = Profile::new(&toolpath, &plan);
    let mut seed = 1u64;
    let mut noise = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        4e-3 * ((seed >> 33) as f64 / 2f64.powi(31) - 0.5)
    };
    let mut text = String::from("t_s,x_mm,y_mm,z_mm\n");
    for sample in 0..=(profile.cycle_time() * 100.0) as u32 {
        let time = f64::from(sample) / 100.0;
        let p = profile.at_time(time).position;
        let _ = writeln!(text, "{time:.3},{:.4},{:.4},{:.4}", p.x + noise(), p.y + noise(), p.z + noise());
    }
    text
}

/// The diagnosis of a run of a machine against the one without halts.
fn diagnosed(halted: &Machine) -> Diagnosis {
    diagnosed_against(&Machine::default(), halted)
}

/// The diagnosis of a run of a machine against another one.
fn diagnosed_against(machine: &Machine, halted: &Machine) -> Diagnosis {
    aligned(halted, |toolpath, alignment| diagnosed_as_aligned(machine, toolpath, &alignment))
}

fn diagnosed_as_aligned(machine: &Machine, toolpath: &Toolpath, alignment: &Alignment) -> Diagnosis {
    diagnose(machine, &[Run { toolpath, alignment, overrides: (None, None) }], &mut |_| {})
}

/// A run of a machine, aligned with the one without halts.
fn aligned<T>(halted: &Machine, then: impl FnOnce(&Toolpath, Alignment) -> T) -> T {
    aligned_on(&program(), halted, then)
}

/// A run of a program on a machine, aligned with the one without halts.
fn aligned_on<T>(program: &str, halted: &Machine, then: impl FnOnce(&Toolpath, Alignment) -> T) -> T {
    let machine = Machine::default();
    let toolpath = trace(&read(program.as_bytes()), &machine);
    let log = recording::read(recorded(program, halted).as_bytes()).expect("a table");
    let alignment = align(&log.recordings[0], &toolpath, &machine).expect("the same program");
    then(&toolpath, alignment)
}

/// The causes with their line (0 where they have none) and seconds.
fn causes(diagnosis: &Diagnosis) -> Vec<(&'static str, u32, f64)> {
    let causes = diagnosis.causes.iter().map(|cause| {
        let reported = (cause.candidate.hypothesis.report)(&cause.candidate.values);
        let number = |name: &str| {
            let found = reported.iter().find(|(known, _)| known.key == name);
            found.map_or(0.0, |(_, value)| if let Reported::Number(number) = value { *number } else { 0.0 })
        };
        (cause.candidate.hypothesis.effect.id, number("line") as u32, number("seconds"))
    });
    causes.collect()
}

/// A machine that is held in lines for so many seconds, after so much of their path.
fn held(holds: &[(u32, f64, f64)]) -> Machine {
    let mut machine = Machine::default();
    for (line, seconds, place) in holds {
        machine.halts.feed_holds.insert(*line, *seconds);
        machine.halts.feed_hold_places.insert(*line, *place);
    }
    machine
}

/// One cause is found and no other, in its line and with its seconds.
#[track_caller]
fn assert_alone(machine: &Machine, (cause, line, seconds): (&str, u32, f64)) {
    let diagnosis = diagnosed(machine);
    let found = causes(&diagnosis);
    assert_eq!(found.len(), 1, "{found:?}");
    assert_eq!((found[0].0, found[0].1), (cause, line));
    assert!((found[0].2 - seconds).abs() < 0.02, "{found:?}");
    // The true cause may be none of the library, and no recording shows that.
    let confidence = diagnosis.causes[0].confidence;
    assert!((0.45..0.97).contains(&confidence), "{confidence}");
}

/// One cause is found, a wait or a feed hold, and that the run cannot tell which.
#[track_caller]
fn assert_unseparable(diagnosis: &Diagnosis) {
    let [cause] = &diagnosis.causes[..] else { panic!("{:?}", causes(diagnosis)) };
    let mut named = [&[cause.candidate.hypothesis.effect.id.to_string()], &cause.alike[..]].concat();
    named.sort();
    assert_eq!(named, ["feed_hold", "unmodelled_wait"]);
    assert!(cause.confidence <= 0.5, "{}", cause.confidence);
    assert_eq!(diagnosis.verdict, Verdict::Ambiguous);
}

#[test]
fn nothing_is_missing_where_nothing_was_held() {
    let diagnosis = diagnosed(&Machine::default());
    assert_eq!(diagnosis.verdict, Verdict::NothingMissing, "{:?}", causes(&diagnosis));
}

#[test]
fn two_feed_holds_are_found_with_their_lines_and_seconds() {
    let diagnosis = diagnosed(&held(&[(10, 1.3, 0.3), (34, 0.6, 0.7)]));
    let found = causes(&diagnosis);
    assert_eq!(
        found.iter().map(|(id, line, _)| (*id, *line)).collect::<Vec<_>>(),
        [("feed_hold", 10), ("feed_hold", 34)]
    );
    assert!((found[0].2 - 1.3).abs() < 0.02 && (found[1].2 - 0.6).abs() < 0.02, "{found:?}");
    assert_eq!(diagnosis.verdict, Verdict::Explained);
    let places = &diagnosis.machine.halts.feed_hold_places;
    assert!((places[&10] - 0.3).abs() < 0.01 && (places[&34] - 0.7).abs() < 0.01, "{places:?}");
}

/// The ramps of so short a hold take up most of it: the tool stands for less than a tenth of a second.
#[test]
fn a_feed_hold_hardly_longer_than_its_ramps_is_found_inside_a_line() {
    assert_alone(&held(&[(10, 0.13, 0.3)]), ("feed_hold", 10, 0.13));
}

/// The filters, 77 ms long, never run empty: the tool only slows down.
#[test]
fn a_feed_hold_shorter_than_its_ramps_is_found_as_a_dip() {
    assert_alone(&held(&[(10, 0.055, 0.3)]), ("feed_hold", 10, 0.055));
}

/// The slower rows of a limit dip as well, each like the others.
#[test]
fn a_limit_leaves_no_dip() {
    let mut machine = Machine::default();
    machine.axes[0].acceleration = 200.0;
    let found = causes(&diagnosed(&machine));
    assert!(found.iter().all(|cause| cause.0 != "feed_hold"), "{found:?}");
}

/// Full stops at corners leave rests as short, but where blocks end.
#[test]
fn exact_stops_are_no_feed_holds() {
    let mut machine = Machine::default();
    machine.interpolator.exact_stop_angle = 0.5;
    let found = causes(&diagnosed(&machine));
    assert_eq!(found.iter().map(|cause| cause.0).collect::<Vec<_>>(), ["exact_stop"], "{found:?}");
}

#[test]
fn a_wait_before_a_line_is_not_a_feed_hold() {
    let mut machine = Machine::default();
    machine.halts.waits = [(14, 0.9)].into();
    assert_alone(&machine, ("unmodelled_wait", 14, 0.9));
}

/// Four rows of so many blocks of a length, mm.
fn short_blocks(count: u32, length: f64, feed: u32) -> String {
    let block = move |row: u32, x: u32| format!("G1 X{:.1} Y{} F{feed}\n", length * f64::from(x), 3 * row);
    let rows = |row: u32| (1..=count).map(move |x| block(row, x));
    format!("G21 G90\nG0 X0 Y0\n{}", (0..4).flat_map(rows).collect::<String>())
}

/// In blocks of a millimetre, one hold of 25 rests within 0.02 mm of an end by chance: no proof of a wait there.
#[test]
fn a_hold_that_rests_at_the_end_of_a_short_block_is_not_told_from_a_wait() {
    let diagnosis =
        aligned_on(&short_blocks(39, 1.0, 1500), &held(&[(60, 0.8, 0.995)]), |toolpath, alignment| {
            diagnosed_as_aligned(&Machine::default(), toolpath, &alignment)
        });
    assert_unseparable(&diagnosis);
}

/// A planner brakes for a wait over many short blocks, as it does for a hold, which the simulation interrupts at once.
#[test]
fn a_wait_between_short_blocks_of_a_planner_is_not_told_from_a_hold() {
    let mut machine = Machine::default();
    machine.become_planner(Planner::AccelerationBlend, 130.0);
    let mut halted = machine.clone();
    halted.halts.waits = [(160, 2.0)].into();
    let diagnosis = aligned_on(&short_blocks(99, 0.4, 3000), &halted, |toolpath, alignment| {
        diagnosed_as_aligned(&machine, toolpath, &alignment)
    });
    assert_unseparable(&diagnosis);
}

/// An operator who holds the feed while the machine brakes for a stop leaves the same rest.
#[test]
fn a_wait_where_the_machine_stops_is_not_told_from_a_hold_on_its_ramp() {
    let mut machine = Machine::default();
    machine.interpolator.exact_stop_angle = 0.5;
    let mut halted = machine.clone();
    halted.halts.waits = [(15, 0.9)].into();
    assert_unseparable(&diagnosed_against(&machine, &halted));
}

#[test]
fn a_wait_at_a_dwell_is_found_in_its_line() {
    let mut machine = Machine::default();
    machine.halts.waits = [(dwell(2), 0.45)].into();
    assert_alone(&machine, ("unmodelled_wait", dwell(2), 0.45));
}

/// The time before the first mark is the recorder's, however far the machine is at the next sample.
#[test]
fn a_recorder_that_runs_before_the_machine_does_shows_no_hold() {
    let holds = aligned(&Machine::default(), |toolpath, mut alignment| {
        alignment.fixes.retain(|fix| 0.2 < fix.distance);
        let mut standing = alignment.fixes[0];
        alignment.marks.retain(|mark| standing.time <= mark.time);
        standing.time -= 1.0;
        standing.distance = 0.0;
        alignment.fixes.insert(0, standing);
        let runs = [Run { toolpath, alignment: &alignment, overrides: (None, None) }];
        feed_holds(&Machine::default(), &runs, f64::NEG_INFINITY).len()
    });
    assert_eq!(holds, 0);
}

/// A wait of the first feed move for the spindle is no hold, even if the samples on both sides of it are farther apart than
/// a rest is long: the machine may stand anywhere between them.
#[test]
fn a_wait_for_the_spindle_between_two_distant_samples_is_no_feed_hold() {
    let program = "G21 G90 S6000 M3\nG0 X20\nG1 X60 F1200\nY40\n";
    let holds = |halted: &Machine, unseen: Range<f64>| {
        aligned_on(program, halted, |toolpath, mut alignment| {
            alignment.fixes.retain(|fix| !unseen.contains(&fix.distance));
            let runs = [Run { toolpath, alignment: &alignment, overrides: (None, None) }];
            feed_holds(&Machine::default(), &runs, f64::NEG_INFINITY).len()
        })
    };
    let mut waiting = Machine::default();
    waiting.halts.waits = [(3, 0.9)].into();
    assert_eq!(holds(&waiting, 19.99..20.2), 0);
    assert_eq!(holds(&held(&[(3, 0.9, 0.5)]), 39.9..40.1), 1);
}

#[test]
fn waits_for_position_at_rapid_ends_are_found() {
    let mut machine = Machine::default();
    machine.halts.in_position = 0.15;
    machine.halts.in_position_at = truefeed::machine::InPosition::RapidEnds;
    let found = causes(&diagnosed(&machine));
    assert_eq!(found.first().map(|cause| cause.0), Some("in_position_wait"), "{found:?}");
    assert!((found[0].2 - 0.15).abs() < 0.015, "{found:?}");
}

/// LinuxCNC runs lines within P of one line as that line, which has the number of the last of them.
#[test]
fn a_feed_hold_costs_its_time_on_lines_that_are_run_as_one() {
    let program = "G21 G64 P0.05\nG1 F1200 X1\nX2 Y0.001\nX3\nX4 Y0.001\nX5\nX9 Y6\n";
    let mut machine =
        machine_from_toml(include_str!("data/machines/linuxcnc.toml")).expect("the file is right");
    let toolpath = trace(&read(program.as_bytes()), &machine);
    let time =
        |machine: &Machine| simulate::with_policy(&toolpath, machine, CornerPolicy::Programmed).cycle_time();
    let before = time(&machine);
    for line in 2..=7 {
        machine.halts.feed_holds = [(line, 2.5)].into();
        assert!(
            (time(&machine) - before - 2.5).abs() < 1e-9,
            "line {line}: {} s more",
            time(&machine) - before
        );
    }
}
