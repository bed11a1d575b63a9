//! Halts that the program does not ask for: none changes nothing, each costs exactly its seconds, and
//! nothing of the path is lost.

use crate::laws::paths::{Case, Random, cases};
use truefeed::machine::{Halts, InPosition, Machine};
use truefeed::project::{machine_from_toml, toml_from_machine};
use truefeed::quote::breakdown;
use truefeed::simulation::profile::Profile;
use truefeed::simulation::toolpath::Toolpath;

fn case_count() -> usize {
    crate::shared::case_count(2_000)
}

/// The case on a machine with other halts.
fn with(case: &Case, change: impl FnOnce(&mut Machine)) -> Case {
    let mut machine = case.machine.clone();
    change(&mut machine);
    Case { toolpath: case.toolpath.clone(), machine, number: case.number }
}

/// A line of the path, seconds and a part of the line's path.
fn halt(toolpath: &Toolpath, random: &mut Random) -> (u32, f64, f64) {
    let line = 1 + random.between(0.0, toolpath.segments.len() as f64) as u32;
    (line, random.log_between(1e-3, 10.0), random.unit())
}

fn assert_close(found: f64, expected: f64, case: &Case) {
    assert!(
        (found - expected).abs() <= 1e-12 * expected.abs().max(1.0),
        "case {}: {found}, not {expected}",
        case.number
    );
}

#[test]
fn halts_of_no_time_change_no_bit() {
    for (case, mut random) in cases(71, case_count()) {
        let (line, _, place) = halt(&case.toolpath, &mut random);
        let none = with(&case, |machine| {
            machine.halts.feed_holds.insert(line, 0.0);
            machine.halts.feed_holds.insert(100_000, 3.0);
            machine.halts.feed_hold_places.insert(line, place);
            machine.halts.waits.insert(line, 0.0);
            machine.halts.waits.insert(100_000, 3.0);
            machine.halts.in_position_at = InPosition::RapidEnds;
        });
        assert_eq!(none.plan(), case.plan(), "case {}", case.number);
    }
}

#[test]
fn a_feed_hold_costs_its_seconds_and_loses_no_way() {
    for (case, mut random) in cases(72, case_count()) {
        let (line, seconds, place) = halt(&case.toolpath, &mut random);
        let held = with(&case, |machine| {
            machine.halts.feed_holds.insert(line, seconds);
            machine.halts.feed_hold_places.insert(line, place);
        });
        let (free_plan, held_plan) = (case.plan(), held.plan());
        assert_close(held_plan.cycle_time(), free_plan.cycle_time() + seconds, &case);
        let mut area = 0.0;
        for pulse in &held_plan.pulses {
            assert!(0.0 < pulse.duration, "case {}: {pulse:?}", case.number);
            area += 0.5 * pulse.duration * (pulse.feedrate[0] + pulse.feedrate[1]);
        }
        let (free, held) =
            (Profile::new(&case.toolpath, &free_plan), Profile::new(&case.toolpath, &held_plan));
        assert!((area / free.length() - 1.0).abs() < 1e-9, "case {}", case.number);
        assert_close(held.cycle_time(), held_plan.cycle_time(), &case);

        // The command is never earlier than without the hold, and never later than by the hold.
        let distances: Vec<f64> = (1..50).map(|i| free.length() * f64::from(i) / 50.0).collect();
        let (before, after) = (free.crossing_times(&distances), held.crossing_times(&distances));
        assert!(after.windows(2).all(|pair| pair[0] <= pair[1]), "case {}", case.number);
        for (before, after) in before.iter().zip(&after) {
            let later = after - before;
            assert!((-1e-6..=seconds + 1e-6).contains(&later), "case {}: {later} s", case.number);
        }
    }
}

#[test]
fn the_machine_stands_where_it_is_held() {
    for (case, mut random) in cases(73, case_count()) {
        let (line, _, place) = halt(&case.toolpath, &mut random);
        let held = with(&case, |machine| {
            machine.halts.feed_holds.insert(line, 10.0);
            machine.halts.feed_hold_places.insert(line, place);
        });
        let plan = held.plan();
        let profile = Profile::new(&case.toolpath, &plan);
        let segment = line as usize - 1;
        let there = profile.distance_before(segment) + place * case.toolpath.segments.length(segment);
        // The last moment before the command comes back.
        let before = profile.time_at_distance(there * (1.0 - 1e-9));
        let state = profile.at_time(before + 5.0);
        let scale = 1e-6 * profile.length().max(1.0);
        assert!((state.distance - there).abs() < scale, "case {}: {} {there}", case.number, state.distance);
        assert!(state.velocity.norm() < 1e-6 * 1000.0, "case {}: {:?}", case.number, state.velocity);
    }
}

#[test]
fn a_wait_before_a_line_is_a_full_stop_that_lasts() {
    for (case, mut random) in cases(74, case_count()) {
        let (line, seconds, _) = halt(&case.toolpath, &mut random);
        let waiting = |seconds: f64| {
            with(&case, |machine| {
                machine.halts.waits.insert(line, seconds);
            })
        };
        let (short, long) = (waiting(1.0).time(), waiting(1.0 + seconds).time());
        assert_close(long, short + seconds, &case);
        let plan = waiting(1.0).plan();
        let starts =
            |segment: usize| plan.rest_to_rest_motions().any(|stretch| stretch.segments.start == segment);
        assert!(starts(line as usize - 1), "case {}", case.number);
    }
}

#[test]
fn a_wait_for_position_comes_at_each_full_stop_of_motion() {
    for (case, mut random) in cases(75, case_count()) {
        let seconds = random.log_between(1e-3, 1.0);
        let exact = with(&case, |machine| {
            machine.halts.in_position = seconds;
            machine.halts.in_position_at = InPosition::ExactStops;
        });
        let segments = &case.toolpath.segments;
        let waits = |after: usize| case.toolpath.stops.iter().any(|stop| stop.after == after);
        let stops = (1..segments.len()).filter(|after| segments.at(after - 1).exact_stop && !waits(*after));
        assert_close(exact.time(), case.time() + seconds * stops.count() as f64, &case);
    }
}

#[test]
fn parts_of_a_held_program_add_up() {
    for (case, mut random) in cases(76, case_count()) {
        let (line, seconds, place) = halt(&case.toolpath, &mut random);
        let held = with(&case, |machine| {
            machine.halts.feed_holds.insert(line, seconds);
            machine.halts.feed_hold_places.insert(line, place);
            machine.halts.waits.insert(line, seconds);
            machine.halts.in_position = 0.1;
        });
        let plan = held.plan();
        let parts = breakdown(&held.toolpath, &held.machine, &plan);
        assert!((parts.total() / plan.cycle_time() - 1.0).abs() < 1e-9, "case {}", case.number);
        assert!(seconds <= parts.functions.halts, "case {}: {parts:?}", case.number);
    }
}

#[test]
fn halts_come_back_from_a_machine_file() {
    let halts = Halts {
        waits: [(64, 2.7), (8, 0.5)].into(),
        feed_holds: [(472, 3.0)].into(),
        feed_hold_places: [(472, 0.4)].into(),
        in_position: 0.05,
        in_position_at: InPosition::RapidEnds,
    };
    let mut machine = Machine { halts, ..Machine::default() };
    machine.overrides.feed_by_line = [(412, 0.78), (901, 1.0)].into();
    machine.overrides.rapid_by_line = [(412, 0.25)].into();
    let text = toml_from_machine(&machine);
    assert_eq!(machine_from_toml(&text).expect("it was written so"), machine, "{text}");
}
