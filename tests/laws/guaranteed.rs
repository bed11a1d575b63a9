//! Guaranteed mode holds the tolerance everywhere: checked by a search of its own, over seeded
//! random paths of lines and arcs, at every corner, along every block, and in both directions.

use crate::laws::paths::{Random, line};
use crate::shared::{case_count, seed_offset};
use truefeed::machine::{CornerMode, Machine, TimeConstants};
use truefeed::simulation::feed::FeedPlan;
use truefeed::simulation::gcode::LineNumber;
use truefeed::simulation::profile::Profile;
use truefeed::simulation::simulate;
use truefeed::simulation::toolpath::{
    Arc, Curve, Motion, Point, Rotation, Segment, Segments, Toolpath, Vector,
};

fn path(random: &mut Random) -> Toolpath {
    let count = 2 + (random.unit() * 14.0) as usize;
    let longest = random.log_between(0.1, 30.0);
    let mut segments = Segments::default();
    let mut start = Point::new(0.0, 0.0, 0.0);
    let mut heading = random.between(0.0, std::f64::consts::TAU);
    let mut feedrate = random.log_between(100.0, 20_000.0) / 60.0;
    for _ in 0..count {
        if random.unit() < 0.2 {
            feedrate = random.log_between(100.0, 20_000.0) / 60.0;
        }
        heading += if random.unit() < 0.5 { random.between(-0.2, 0.2) } else { random.between(-3.1, 3.1) };
        let length = random.log_between(0.01, longest);
        let along = Vector::new(heading.cos(), heading.sin(), 0.0);
        let (curve, end, length) = if random.unit() < 0.3 {
            let side = if random.unit() < 0.5 { 1.0 } else { -1.0 };
            let normal = side * Vector::new(-heading.sin(), heading.cos(), 0.0);
            let radius = random.log_between(0.3, 20.0);
            let sweep = (length / radius).min(5.0);
            let center = start + radius * normal;
            let arc = Arc {
                center,
                e1: -normal,
                e2: along,
                start_radius: radius,
                end_radius: radius,
                sweep,
                rise: Vector::zeros(),
            };
            heading += side * sweep;
            let end = center + radius * (sweep.cos() * -normal + sweep.sin() * along);
            let length = arc.length();
            (Curve::Arc(arc.into()), end, length)
        } else {
            let end = start + length * along;
            (Curve::Line, end, (end - start).norm())
        };
        let line = LineNumber(segments.len() as u32 + 1);
        let motion = Motion::Feed { feedrate };
        segments.push(Segment {
            start,
            end,
            curve,
            length,
            motion,
            rotation: Rotation::NONE,
            exact_stop: false,
            exact_path: false,
            line,
        });
        start = end;
    }
    Toolpath { segments, ..Toolpath::default() }
}

fn machine(random: &mut Random) -> Machine {
    let mut machine = Machine::default();
    let order = 1 + (random.unit() * 4.0) as usize;
    let constants: Vec<f64> = (0..order).map(|_| random.log_between(0.002, 0.04)).collect();
    machine.interpolator.filters = order;
    machine.interpolator.time_constants = if random.unit() < 0.3 {
        TimeConstants::Unequal(constants)
    } else {
        TimeConstants::Equal(constants[0])
    };
    machine.interpolator.corner_mode = CornerMode::Guaranteed;
    machine
}

/// The least value of `f` near the least of `count` values between two ends.
fn least(low: f64, high: f64, count: usize, f: impl Fn(f64) -> f64) -> f64 {
    let at = |i: usize| low + (high - low) * i as f64 / count as f64;
    let best = (0..=count).min_by(|&a, &b| f(at(a)).total_cmp(&f(at(b)))).expect("there are some");
    let (mut a, mut b) = (at(best.saturating_sub(1)), at((best + 1).min(count)));
    for _ in 0..60 {
        let (c, d) = (a + 0.381_966 * (b - a), b - 0.381_966 * (b - a));
        if f(c) < f(d) { b = d } else { a = c }
    }
    f(0.5 * (a + b)).min(f(at(best)))
}

/// When each pulse of a path without stops is commanded, s.
fn command_times(plan: &FeedPlan) -> Vec<f64> {
    let ends = plan.pulses.iter().scan(0.0, |time, pulse| {
        *time += pulse.duration;
        Some(*time)
    });
    [0.0].into_iter().chain(ends).collect()
}

/// The largest distance of programmed points from the filtered path.
fn independent_error(toolpath: &Toolpath, plan: &FeedPlan) -> f64 {
    let profile = Profile::new(toolpath, plan);
    let delay = plan.filters[0].delay();
    let times = command_times(plan);
    let mut largest = 0.0f64;
    for (pulse, &time) in plan.pulses.iter().zip(&times) {
        let segment = toolpath.segments.at(pulse.segment as usize);
        for part in [0.0, 0.37, 0.81] {
            let elapsed = part * pulse.duration;
            let slope = (pulse.feedrate[1] - pulse.feedrate[0]) / pulse.duration;
            let s = pulse.offset + elapsed * (pulse.feedrate[0] + 0.5 * slope * elapsed);
            let point = segment.point(s);
            let now = time + elapsed;
            let distance = least(now, now + delay, 24, |t| (profile.at_time(t).position - point).norm());
            largest = largest.max(distance);
        }
    }
    largest
}

/// The largest distance of so many filtered points from what was commanded within the filter's reach.
fn reverse_error(toolpath: &Toolpath, plan: &FeedPlan, count: usize) -> f64 {
    let profile = Profile::new(toolpath, plan);
    let delay = plan.filters[0].delay();
    let times = command_times(plan);
    let end = profile.cycle_time();
    let mut largest = 0.0f64;
    for i in 1..count {
        let t = end * i as f64 / count as f64;
        let position = profile.at_time(t).position;
        let within = |&index: &usize| times[index] <= t && t - delay <= times[index + 1];
        let distances = (0..plan.pulses.len()).filter(within).map(|index| {
            let pulse = plan.pulses.at(index);
            let segment = toolpath.segments.at(pulse.segment as usize);
            let length = 0.5 * (pulse.feedrate[0] + pulse.feedrate[1]) * pulse.duration;
            let far = (pulse.offset + length).min(segment.length);
            least(pulse.offset, far, 6, |s| (segment.point(s) - position).norm())
        });
        largest = largest.max(distances.fold(f64::INFINITY, f64::min));
    }
    largest
}

/// Paths that bulged out between corners, each of which was within tolerance: by up to 25 %. Seeds, and the number of the path.
const BULGING: [(u64, usize); 11] = [
    (4327, 854),
    (5020, 738),
    (5097, 840),
    (5251, 30),
    (5251, 877),
    (5405, 758),
    (5482, 790),
    (6175, 288),
    (6175, 952),
    (6252, 636),
    (7022, 735),
];

#[test]
fn the_filtered_path_does_not_bulge_out_between_corners() {
    for (seed, number) in BULGING {
        let mut random = Random(seed);
        let mut drawn = || (path(&mut random), machine(&mut random), random.log_between(0.002, 0.1));
        let (toolpath, machine, tolerance) = (0..=number).map(|_| drawn()).last().expect("one at least");
        let (plan, _) = simulate::within(&toolpath, &machine, tolerance, &mut |_| {});
        let error = reverse_error(&toolpath, &plan, 400);
        assert!(error <= tolerance * (1.0 + 1e-3), "path {number} of {seed}: {error} mm, not {tolerance} mm");
    }
}

/// Largest error beyond the tolerance between the measured points, as a part of the tolerance. The largest seen is 0.0055, in
/// case 3617 of seed 14748.
const MAX_EXCESS_BETWEEN_POINTS: f64 = 0.01;

#[test]
fn the_filtered_path_stays_within_the_tolerance_everywhere() {
    let mut random = Random(0x5eed_0003 + 2 * seed_offset());
    for case in 0..case_count(10_000) {
        let (toolpath, machine) = (path(&mut random), machine(&mut random));
        let tolerance = random.log_between(0.002, 0.1);
        let (plan, errors) = simulate::within(&toolpath, &machine, tolerance, &mut |_| {});
        assert!(errors.largest() <= tolerance * (1.0 + 1e-9), "case {case}: measured {}", errors.largest());
        let error = independent_error(&toolpath, &plan).max(reverse_error(&toolpath, &plan, 60));
        let most = tolerance * (1.0 + MAX_EXCESS_BETWEEN_POINTS) + 1e-6;
        assert!(error <= most, "case {case}: {error} mm for a tolerance of {tolerance} mm");
    }
}

#[test]
fn where_the_isolated_law_is_right_nothing_is_gained_or_lost() {
    let mut random = Random(7);
    for _ in 0..200 {
        let far = 200.0;
        let turn = random.between(0.3, 2.8);
        let corner = Point::new(far, 0.0, 0.0);
        let end = corner + far * Vector::new(turn.cos(), turn.sin(), 0.0);
        let motion = Motion::Feed { feedrate: random.log_between(5.0, 100.0) };
        let segments = [line(Point::origin(), corner, motion), line(corner, end, motion)];
        let toolpath = Toolpath { segments: segments.into_iter().collect(), ..Toolpath::default() };
        let mut machine = machine(&mut random);
        let guaranteed = simulate::within(&toolpath, &machine, 0.01, &mut |_| {}).0.cycle_time();
        machine.interpolator.corner_mode = CornerMode::Paper;
        let paper = simulate::within(&toolpath, &machine, 0.01, &mut |_| {}).0.cycle_time();
        assert!((guaranteed / paper - 1.0).abs() < 1e-3, "{guaranteed} s against {paper} s");
    }
}

/// The corrected plan is found round by round, not by a formula, so that a wider tolerance is not
/// faster by construction. It is but for a few paths in a thousand.
#[test]
fn a_wider_tolerance_is_hardly_ever_slower() {
    let mut random = Random(99 + 2 * seed_offset());
    let paths = case_count(1000);
    let slower = (0..paths).filter(|_| {
        let (toolpath, machine) = (path(&mut random), machine(&mut random));
        let tolerance = random.log_between(0.002, 0.1);
        let time =
            |tolerance: f64| simulate::within(&toolpath, &machine, tolerance, &mut |_| {}).0.cycle_time();
        time(tolerance) * (1.0 + 1e-9) < time(1.2 * tolerance)
    });
    let slower = slower.count();
    eprintln!("slower at 1.2 times the tolerance: {slower} of {paths} paths");
    // One in a hundred, with three standard deviations of that number: seeds differ.
    let expected = paths as f64 / 100.0;
    assert!(slower as f64 <= expected + 3.0 * expected.sqrt(), "{slower} of {paths}");
}
