//! Laws of acceleration limits behind the filters: the same path, never sooner, never too steep.

use crate::laws::paths::{Case, Random, cases};
use truefeed::machine::{Junction, Machine, TimeConstants};
use truefeed::quote::breakdown;
use truefeed::simulation::feed::{CornerPolicy, FeedPlan};
use truefeed::simulation::gcode::read;
use truefeed::simulation::interpreter::trace;
use truefeed::simulation::profile::Profile;
use truefeed::simulation::simulate;
use truefeed::simulation::toolpath::Toolpath;

fn case_count() -> usize {
    crate::shared::case_count(1000)
}

/// Cases whose junctions follow the tolerance, with a limit along the path or on each axis, and their
/// plans before and after: of the same command, for on arcs the limits of the axes bound that as well.
fn slowed(seed: u64) -> impl Iterator<Item = (Case, Random, [FeedPlan; 2])> {
    cases(seed, case_count()).map(|(mut case, mut random)| {
        case.machine.interpolator.junction = Junction::Tolerance;
        case.machine.path.acceleration = random.log_between(50.0, 20_000.0);
        if random.chance(0.5) {
            case.machine.path.acceleration = f64::INFINITY;
            for axis in &mut case.machine.axes {
                axis.acceleration = random.log_between(50.0, 20_000.0);
            }
        }
        let slowed = case.plan();
        let filtered = FeedPlan { time_scaling: None, ..slowed.clone() };
        (case, random, [filtered, slowed])
    })
}

#[test]
fn limits_that_never_act_change_no_bit() {
    let mut untouched = 0;
    for (mut case, _, [_, slowed]) in slowed(41) {
        untouched += usize::from(slowed.time_scaling.is_none());
        let mut limited = |acceleration: f64| {
            case.machine.path.acceleration = acceleration;
            case.machine.axes.iter_mut().for_each(|axis| axis.acceleration = acceleration);
            case.plan()
        };
        let [within, free] = [1e15, f64::INFINITY].map(&mut limited);
        assert_eq!(within, free, "case {}", case.number);
    }
    assert!(
        (case_count() / 50..case_count() / 2).contains(&untouched),
        "most limits act: {untouched} do not"
    );
}

#[test]
fn time_is_only_lost_and_adds_up() {
    for (case, _, [filtered, slowed]) in slowed(42) {
        let (before, after) =
            (Profile::new(&case.toolpath, &filtered), Profile::new(&case.toolpath, &slowed));
        let wanted: Vec<f64> = (0..=200).map(|i| before.length() * f64::from(i) / 200.0).collect();
        let (early, late) = (before.crossing_times(&wanted), after.crossing_times(&wanted));
        let lost: Vec<f64> = early.iter().zip(&late).map(|(early, late)| late - early).collect();
        assert!(-1e-8 <= lost[0], "case {}: {}", case.number, lost[0]);
        for (pair, distance) in lost.windows(2).zip(&wanted) {
            assert!(pair[0] - 1e-8 <= pair[1], "case {} at {distance} mm: {pair:?} s", case.number);
        }
        let end = after.cycle_time();
        let (lost, difference) = (lost[200], end - before.cycle_time());
        assert!((lost - difference).abs() < 1e-6 * end, "case {}: {lost}, {difference}", case.number);
        let parts = breakdown(&case.toolpath, &case.machine, &slowed).total();
        for total in [slowed.cycle_time(), parts] {
            assert!((total / end - 1.0).abs() < 1e-12, "case {}: {total} s, not {end} s", case.number);
        }
        for (time, distance) in late.iter().zip(&wanted).skip(1).take(199) {
            let there = after.at_time(*time).distance;
            assert!((there - distance).abs() < 1e-6 * after.length(), "case {}: {there}", case.number);
        }
    }
}

/// The limits hold at the samples; where the path turns sharply between two of them, which is rare, an
/// axis is above its own.
#[test]
fn feedrate_rises_and_falls_within_the_limits() {
    let (mut reached, mut above, mut all) = (0, 0, 0);
    for (case, mut random, [_, slowed]) in slowed(43) {
        let profile = Profile::new(&case.toolpath, &slowed);
        let shortest = slowed.filters.iter().map(|filter| filter.delay()).fold(f64::INFINITY, f64::min);
        for _ in 0..100 {
            let time = random.between(0.0, profile.cycle_time());
            let gap = 0.05 * shortest;
            let [before, after] = [time - gap, time + gap].map(|time| profile.at_time(time).velocity);
            let slope = (after.norm() - before.norm()).abs() / (2.0 * gap);
            let of_axis =
                |k: usize| (after[k] - before[k]).abs() / (2.0 * gap) / case.machine.axes[k].acceleration;
            let used = (0..3).map(of_axis).fold(slope / case.machine.path.acceleration, f64::max);
            reached += usize::from(0.99 < used);
            above += usize::from(1.15 < used);
            all += 1;
        }
    }
    assert!(case_count() < reached, "the limits decide: {reached}");
    assert!(above < all / 500, "above their limit: {above} of {all}");
}

/// The motion that the profile and its derivatives tell of is one.
#[test]
fn derivatives_are_those_of_the_motion() {
    let mut compared = 0;
    for (case, mut random, [_, slowed]) in
        slowed(44).filter(|(.., [_, slowed])| slowed.time_scaling.is_some())
    {
        let profile = Profile::new(&case.toolpath, &slowed);
        let fastest = case.toolpath.segments.iter().map(|s| case.requested(&s)).fold(0.0, f64::max);
        for _ in 0..50 {
            let time = random.between(0.0, profile.cycle_time());
            let gap = 1e-6;
            let [before, now, after] = [time - gap, time, time + gap].map(|time| profile.at_time(time));
            let velocity = (after.position - before.position) / (2.0 * gap);
            let off = (velocity - now.velocity).norm() / fastest;
            assert!(off < 0.01, "case {} at {time} s: {off} of the feedrate", case.number);
            compared += 1;
        }
    }
    assert!(10 * case_count() < compared, "{compared}");
}

/// A line of `length` mm at `feedrate` mm/s along X on three filters of `constant` s.
fn line(length: f64, feedrate: f64, constant: f64, acceleration: f64) -> (Toolpath, Machine, FeedPlan) {
    let mut machine = Machine::default();
    machine.interpolator.time_constants = TimeConstants::Equal(constant);
    machine.interpolator.filters = 3;
    machine.axes[0].acceleration = acceleration;
    let program = format!("G1 X{length} F{}\n", feedrate * 60.0);
    let toolpath = trace(&read(program.as_bytes()), &machine);
    let slowed = simulate::with_policy(&toolpath, &machine, CornerPolicy::Isolated(0.01));
    (toolpath, machine, slowed)
}

#[test]
fn without_filters_a_single_move_is_a_trapezoid_or_a_triangle() {
    for (length, feedrate, acceleration) in
        [(200.0, 100.0, 300.0), (1.0, 100.0, 300.0), (5000.0, 3.0, 50.0), (30.0, 90.0, 2000.0)]
    {
        let (toolpath, _, slowed) = line(length, feedrate, 1e-6, acceleration);
        let expected = if feedrate * feedrate < length * acceleration {
            length / feedrate + feedrate / acceleration
        } else {
            2.0 * f64::sqrt(length / acceleration)
        };
        let found = slowed.cycle_time();
        assert!((found - expected).abs() < 1e-5, "{length} mm at {feedrate}: {found} s, not {expected} s");
        let profile = Profile::new(&toolpath, &slowed);
        for part in [0.1, 0.3, 0.45] {
            let time = part * expected;
            let feedrate = (acceleration * time).min(feedrate);
            let found = profile.at_time(time).velocity.x;
            assert!((found - feedrate).abs() < 1e-3 * feedrate, "{found} mm/s, not {feedrate} mm/s");
        }
    }
}

/// Three filters of T take a step F at ¾F/T at most; a limit above that costs nothing, and one below it
/// begins to act where the ramp of the filters has that slope, and goes on straight up to F.
#[test]
fn ramps_of_filters_begin_round_and_end_sharp() {
    let (feedrate, constant) = (60.0, 0.03);
    let steepest = 0.75 * feedrate / constant;
    assert_eq!(line(50.0, feedrate, constant, steepest * 1.001).2.time_scaling, None);
    let acceleration = 0.5 * steepest;
    // In the first third F (t/T)³/6 rises with F t²/(2T³), up to A at t = T √(2AT/F).
    let begin = constant * (2.0 * acceleration * constant / feedrate).sqrt();
    let reached = feedrate * (begin / constant).powi(3) / 6.0;
    let ramp = begin + (feedrate - reached) / acceleration;
    let run = feedrate * begin.powi(4) / (24.0 * constant.powi(3))
        + 0.5 * (feedrate * feedrate - reached * reached) / acceleration;
    let expected = 2.0 * ramp + (50.0 - 2.0 * run) / feedrate;
    let found = line(50.0, feedrate, constant, acceleration).2.cycle_time();
    assert!((found - expected).abs() < 1e-4, "{found} s, not {expected} s");
}
