//! Path smoothing: nothing where it is off, straight lines or corners that slow nothing where it acts, and the program's
//! distances.

use crate::laws::paths::{Case, Random, cases};
use truefeed::machine::{Junction, Machine};
use truefeed::simulation::feed::{CornerPolicy, FeedPlan};
use truefeed::simulation::gcode::read;
use truefeed::simulation::interpreter::trace;
use truefeed::simulation::simulate;
use truefeed::simulation::toolpath::Toolpath;

fn case_count() -> usize {
    crate::shared::case_count(1000)
}

/// With the junctions of LinuxCNC, or as it is.
fn with_junctions(machine: &mut Machine, random: &mut Random) {
    if random.chance(0.5) {
        machine.interpolator.junction = Junction::AccelerationBlend;
        for axis in &mut machine.axes {
            axis.velocity = random.log_between(50.0, 500.0);
            axis.acceleration = random.log_between(100.0, 5000.0);
        }
    }
}

fn programmed(case: &Case) -> FeedPlan {
    simulate::with_policy(&case.toolpath, &case.machine, CornerPolicy::Programmed)
}

/// A polyline along X whose points lie up to `height` (mm) beside it, and the line itself.
fn lines(random: &mut Random, height: f64, count: usize) -> [Toolpath; 2] {
    let mut x = 0.0;
    let mut text = String::from("G21 G90 G1 F3000\n");
    for k in 1..=count {
        x += random.between(0.2, 1.0);
        let y = if k == count { 0.0 } else { random.between(-height, height) };
        text += &format!("X{x:.6} Y{y:.6}\n");
    }
    let straight = format!("G21 G90 G1 F3000\nX{x:.6}\n");
    [text, straight].map(|text| trace(&read(text.as_bytes()), &Machine::default()))
}

#[test]
fn switched_off_it_changes_no_bit() {
    for (mut case, mut random) in cases(70, case_count()) {
        with_junctions(&mut case.machine, &mut random);
        let plan = programmed(&case);
        case.machine.interpolator.path_smoothing = Some(0.0);
        assert!(programmed(&case) == plan, "case {}", case.number);
        // Every corner of more than rounding is farther away.
        case.machine.interpolator.corner_smoothing = 1e-14;
        assert!(programmed(&case) == plan, "case {}", case.number);
    }
}

/// A curve that touches both lines of a corner of φ, the shorter of L, no farther from it than that passes it at
/// L sin(φ/2)/2.
#[test]
fn a_corner_is_slowed_where_no_curve_passes_it_closely() {
    let mut random = Random(73);
    for number in 0..case_count() {
        let (short, long) = (random.between(0.2, 1.0), random.between(1.0, 2.0));
        let angle: f64 = random.between(0.05, 2.0);
        let [first, second] = if random.chance(0.5) { [short, long] } else { [long, short] };
        let (x, y) = (first + second * angle.cos(), second * angle.sin());
        let text = format!("G21 G90 G1 F6000\nX{first:.9}\nX{x:.9} Y{y:.9}\n");
        let mut machine = Machine::default();
        let toolpath = trace(&read(text.as_bytes()), &machine);
        let passed = 0.5 * short * (0.5 * angle).sin();
        let at_corner = |within: f64, machine: &mut Machine| {
            machine.interpolator.corner_smoothing = within;
            simulate::with_policy(&toolpath, machine, CornerPolicy::Programmed).corner_feedrates[0]
        };
        let slowed = at_corner(0.0, &mut machine);
        assert!(slowed < 99.0, "case {number}: {slowed} mm/s");
        assert_eq!(at_corner(0.999 * passed, &mut machine), slowed, "case {number}");
        assert_eq!(at_corner(1.001 * passed, &mut machine), 100.0, "case {number}");
    }
}

#[test]
fn a_chain_takes_the_time_of_its_line() {
    for (mut case, mut random) in cases(71, case_count()) {
        with_junctions(&mut case.machine, &mut random);
        let height = random.log_between(1e-4, 0.05);
        let count = 2 + (90.0 * random.unit()) as usize;
        let [chain, straight] = lines(&mut random, height, count);
        // Chords on the way may end on either side.
        case.machine.interpolator.path_smoothing = Some(2.0 * height);
        let time =
            |toolpath| simulate::with_policy(toolpath, &case.machine, CornerPolicy::Programmed).cycle_time();
        let (found, expected) = (time(&chain), time(&straight));
        assert!((found / expected - 1.0).abs() < 1e-9, "case {}: {found} s, {expected} s", case.number);
    }
}

#[test]
fn each_segment_keeps_its_length() {
    let mut merged = 0;
    for (mut case, mut random) in cases(72, case_count()) {
        with_junctions(&mut case.machine, &mut random);
        let as_written = programmed(&case);
        case.machine.interpolator.path_smoothing = Some(random.log_between(1e-3, 10.0));
        let plan = programmed(&case);
        merged += usize::from(plan != as_written);
        let segments = &case.toolpath.segments;
        let mut reached = vec![0.0f64; segments.len()];
        let mut last = 0;
        for pulse in &plan.pulses {
            let index = pulse.segment as usize;
            let length = segments.length(index);
            assert!(last <= index && 0.0 < pulse.duration, "case {}", case.number);
            assert!((pulse.offset - reached[index]).abs() <= 1e-9 * length, "case {}", case.number);
            reached[index] += 0.5 * pulse.duration * (pulse.feedrate[0] + pulse.feedrate[1]);
            last = index;
        }
        for (segment, reached) in segments.iter().zip(reached) {
            assert!((reached / segment.length - 1.0).abs() < 1e-8, "case {}: {reached}", case.number);
        }
        let covered: Vec<_> =
            plan.rest_to_rest_motions().flat_map(|stretch| stretch.segments.clone()).collect();
        assert!(covered.into_iter().eq(0..segments.len()), "case {}", case.number);
    }
    assert!(case_count() / 10 < merged, "{merged} of the cases have something to merge");
}

/// A chain of any length is tested against no more than a hundred points.
#[test]
fn a_long_chain_is_cut() {
    let mut random = Random(73);
    let mut machine = Machine::default();
    machine.interpolator.path_smoothing = Some(0.01);
    let [chain, straight] = lines(&mut random, 0.0, 20_000);
    let plans = [&chain, &straight]
        .map(|toolpath| simulate::with_policy(toolpath, &machine, CornerPolicy::Programmed));
    assert!((plans[0].cycle_time() / plans[1].cycle_time() - 1.0).abs() < 1e-6);
}
