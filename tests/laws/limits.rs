//! Limits of the machine: without effect at their neutral values, respected when finite.

use crate::laws::paths::{Case, Random, cases, line, stretches};
use truefeed::machine::{Axis, CornerPlanning, Junction, Machine};
use truefeed::simulation::feed::limits::requested_feedrate;
use truefeed::simulation::feed::{Pulse, RestToRest};
use truefeed::simulation::profile::Profile;
use truefeed::simulation::toolpath::{Curve, Motion, Point, Segment, Toolpath, Vector};

fn case_count() -> usize {
    crate::shared::case_count(10_000)
}

/// Cases whose machine `limit` has changed.
fn limited(
    seed: u64,
    count: usize,
    mut limit: impl FnMut(&mut Machine, &mut Random),
) -> impl Iterator<Item = (Case, Random)> {
    cases(seed, count).map(move |(mut case, mut random)| {
        limit(&mut case.machine, &mut random);
        (case, random)
    })
}

/// Random times of a profile, s.
fn times(profile: &Profile, random: &mut Random, count: usize) -> Vec<f64> {
    (0..count).map(|_| random.between(0.0, profile.cycle_time())).collect()
}

/// The larger command of a pulse, mm/s.
fn highest(pulse: &Pulse) -> f64 {
    pulse.feedrate[0].max(pulse.feedrate[1])
}

/// By how much the direction changes between two segments.
fn change(before: &Segment, after: &Segment) -> Vector {
    after.tangent(0.0) - before.tangent(before.length)
}

/// The angle by which the path turns between two segments, rad.
fn turn(before: &Segment, after: &Segment) -> f64 {
    before.tangent(before.length).dot(&after.tangent(0.0)).clamp(-1.0, 1.0).acos()
}

/// Limits that are finite, but beyond the reach of any path here, take other ways through the
/// code to the same bits.
#[test]
fn limits_out_of_reach_change_no_bit() {
    for (case, _) in limited(21, case_count(), |machine, _| machine.path.acceleration = f64::INFINITY) {
        let mut machine = case.machine.clone();
        machine.interpolator.exact_stop_angle = std::f64::consts::PI;
        machine.interpolator.block_time = 0.0;
        machine.interpolator.look_ahead = f64::INFINITY;
        machine.path.acceleration = f64::INFINITY;
        machine.path.centripetal_acceleration = f64::INFINITY;
        machine.overrides.feed = 1.0;
        machine.overrides.rapid = 1.0;
        for axis in &mut machine.axes {
            (axis.velocity, axis.acceleration, axis.jerk) = (f64::INFINITY, f64::INFINITY, f64::INFINITY);
            // These act on the motion, not on the plan.
            (axis.servo_lag, axis.backlash, axis.backlash_compensation) = (0.01, 0.1, 0.2);
        }
        let plan = case.plan();
        let neutral = Case { toolpath: case.toolpath.clone(), machine: machine.clone(), ..case };
        assert_eq!(neutral.plan(), plan, "case {}", case.number);

        machine.interpolator.exact_stop_angle = std::f64::consts::PI * (1.0 - f64::EPSILON);
        machine.interpolator.slowing_angle = 1e9;
        machine.interpolator.block_time = 1e-12;
        machine.interpolator.look_ahead = 1e6;
        machine.path.centripetal_acceleration = 1e15;
        for axis in &mut machine.axes {
            (axis.velocity, axis.jerk) = (1e9, 1e30);
        }
        let beyond = Case { toolpath: neutral.toolpath, machine, ..case };
        assert_eq!(beyond.plan(), plan, "case {}", case.number);
    }
}

#[test]
fn a_huge_acceleration_is_as_good_as_none() {
    for (case, _) in limited(22, case_count(), |machine, _| machine.path.acceleration = f64::INFINITY) {
        let mut machine = case.machine.clone();
        machine.path.acceleration = 1e15;
        machine.interpolator.junction = Junction::AxisStep(1e9);
        let limited = Case { toolpath: case.toolpath.clone(), machine, ..case };
        let (time, limited_time) = (case.time(), limited.time());
        assert!((limited_time / time - 1.0).abs() < 1e-9, "case {}: {limited_time}, {time}", case.number);
    }
}

#[test]
fn overrides_are_other_programmed_feedrates() {
    let twice = |machine: &mut Machine, _: &mut Random| {
        (machine.overrides.feed, machine.overrides.rapid) = (2.0, 0.5);
    };
    for (case, _) in limited(23, case_count(), twice) {
        let mut toolpath = case.toolpath.clone();
        let twice = |mut segment: Segment| {
            if let Motion::Feed { feedrate } = &mut segment.motion {
                *feedrate *= 2.0;
            }
            segment
        };
        toolpath.segments = toolpath.segments.iter().map(twice).collect();
        let mut machine = case.machine.clone();
        machine.rapid.feedrate *= 0.5;
        (machine.overrides.feed, machine.overrides.rapid) = (1.0, 1.0);
        assert_eq!(Case { toolpath, machine, ..case }.plan(), case.plan(), "case {}", case.number);
    }
}

#[test]
fn rapids_take_as_long_as_the_slowest_axis() {
    let limit = |machine: &mut Machine, random: &mut Random| {
        machine.axes.iter_mut().for_each(|axis| axis.rapid = random.log_between(20.0, 900.0));
    };
    for (case, _) in limited(30, case_count(), limit) {
        let Case { toolpath, machine, .. } = &case;
        for segment in toolpath.segments.iter().filter(|s| s.motion.is_rapid() && s.curve == Curve::Line) {
            let alone = |k: usize| (segment.end - segment.start)[k].abs() / machine.axes[k].rapid;
            let slowest = (0..3).map(alone).fold(segment.length / machine.rapid.feedrate, f64::max);
            let time = segment.length / requested_feedrate(&segment, machine);
            assert!((time / slowest - 1.0).abs() < 1e-12, "case {}: {time}, {slowest}", case.number);
        }
    }
}

#[test]
fn rapids_of_axes_above_that_along_the_path_change_nothing() {
    let limit = |machine: &mut Machine, _: &mut Random| {
        machine.axes.iter_mut().for_each(|axis| axis.rapid = 1.001 * machine.rapid.feedrate);
    };
    for (case, _) in limited(31, case_count(), limit) {
        let mut machine = case.machine.clone();
        machine.axes.iter_mut().for_each(|axis| axis.rapid = f64::INFINITY);
        assert_eq!(Case { toolpath: case.toolpath.clone(), machine, ..case }.plan(), case.plan());
    }
}

#[test]
fn no_axis_is_faster_than_its_limit() {
    let limit = |machine: &mut Machine, random: &mut Random| {
        machine.axes.iter_mut().for_each(|axis| axis.velocity = random.log_between(2.0, 300.0));
    };
    for (case, mut random) in limited(24, case_count(), limit) {
        let plan = case.plan();
        let profile = Profile::new(&case.toolpath, &plan);
        for time in times(&profile, &mut random, 50) {
            let velocity = profile.at_time(time).velocity;
            for (k, axis) in case.machine.axes.iter().enumerate() {
                let fast = velocity[k].abs();
                assert!(fast <= axis.velocity * (1.0 + 1e-9), "case {}: {fast} mm/s", case.number);
            }
        }
    }
}

/// Paths along a straight line, whose feedrates change from block to block, on machines that plan ramps
/// before their filters: the acceleration
/// along the path is that of the command, averaged, and so never above its limit.
#[test]
fn acceleration_along_straight_paths_keeps_its_limit() {
    for (mut case, mut random) in cases(25, case_count()) {
        let direction = random.direction();
        let mut start = Point::origin();
        let lines = case.toolpath.segments.iter().map(|segment| {
            let end = start + segment.length * direction;
            let straight = line(start, end, segment.motion);
            start = end;
            Segment { exact_stop: segment.exact_stop, ..straight }
        });
        case.toolpath =
            Toolpath { segments: lines.collect(), stops: case.toolpath.stops.clone(), ..Default::default() };
        case.machine.path.acceleration = random.log_between(50.0, 20_000.0);
        case.machine.interpolator.junction = Junction::AxisStep(1e9);
        let by_axis = random.chance(0.5);
        if by_axis {
            let acceleration = &mut case.machine.path.acceleration;
            case.machine.axes.iter_mut().for_each(|axis| axis.acceleration = *acceleration);
            *acceleration = f64::INFINITY;
        }
        let plan = case.plan();
        let profile = Profile::new(&case.toolpath, &plan);
        for time in times(&profile, &mut random, 50) {
            let Some(dynamics) = profile.dynamics_at_time(time) else { continue };
            let (found, limit) = if by_axis {
                (dynamics.acceleration.amax(), case.machine.axes[0].acceleration)
            } else {
                (dynamics.acceleration.norm(), case.machine.path.acceleration)
            };
            assert!(
                found <= limit * (1.0 + 1e-9),
                "case {} at {time} s: {found}, not {limit} mm/s²",
                case.number
            );
        }
    }
}

/// With a tolerance that never limits them arcs are commanded at √(a/κ), neither above nor below.
#[test]
fn arcs_are_commanded_at_their_centripetal_acceleration() {
    let limit = |machine: &mut Machine, random: &mut Random| {
        machine.path.centripetal_acceleration = random.log_between(1.0, 5000.0);
        machine.interpolator.contour_tolerance = 1e6;
    };
    let mut held = 0;
    for (case, _) in limited(26, case_count(), limit) {
        let plan = case.plan();
        for (segment, feedrate) in case.toolpath.segments.iter().zip(&plan.segment_feedrates) {
            let curvature = segment.derivatives(0.5 * segment.length)[1].norm();
            let fastest = (case.machine.path.centripetal_acceleration / curvature).sqrt();
            let expected = case.requested(&segment).min(fastest);
            assert!((feedrate / expected - 1.0).abs() <= 1e-9, "case {}: {feedrate} mm/s", case.number);
            held += usize::from(*feedrate < case.requested(&segment));
        }
    }
    assert!(case_count() / 10 < held, "the limit decides on many arcs: {held}");
}

#[test]
fn no_block_is_run_in_less_than_the_block_time() {
    let limit = |machine: &mut Machine, random: &mut Random| {
        machine.interpolator.block_time = random.log_between(0.0001, 0.05);
    };
    let mut held = 0;
    for (case, _) in limited(27, case_count(), limit) {
        let mut durations = vec![0.0; case.toolpath.segments.len()];
        let plan = case.plan();
        plan.pulses.iter().for_each(|pulse| durations[pulse.segment as usize] += pulse.duration);
        let least = case.machine.interpolator.block_time;
        for duration in durations {
            assert!(least * (1.0 - 1e-9) <= duration, "case {}: {duration} s", case.number);
            held += usize::from(duration < least * (1.0 + 1e-9));
        }
    }
    assert!(case_count() / 10 < held, "the limit decides on many blocks: {held}");
}

/// With a look-ahead of N blocks the motion can stop within them from any command: what is on
/// its way through the filters, half the delay at that feedrate, and the way to brake.
#[test]
fn motion_can_stop_within_the_look_ahead() {
    let limit = |machine: &mut Machine, random: &mut Random| {
        machine.interpolator.look_ahead = random.between(1.0, 20.0).floor();
    };
    let mut held = 0;
    for (case, _) in limited(28, case_count(), limit) {
        let plan = case.plan();
        let blocks = case.machine.interpolator.look_ahead as usize;
        for (_, stretch) in stretches(&plan) {
            let half_delay = plan.filters[stretch.filter].half_delay();
            for pulse in plan.pulses.range(stretch.pulses.clone()) {
                let seen = pulse.segment as usize + blocks;
                if stretch.segments.end <= seen {
                    continue;
                }
                let visible: f64 =
                    case.toolpath.segments.range(pulse.segment as usize..seen).map(|s| s.length).sum();
                let fast = highest(&pulse);
                let needed = fast * half_delay + 0.5 * fast * fast / case.machine.path.acceleration;
                assert!(needed <= visible * (1.0 + 1e-9), "case {}: {needed} of {visible} mm", case.number);
                held += usize::from(visible * (1.0 - 1e-9) < needed);
            }
        }
    }
    assert!(case_count() / 10 < held, "the limit decides on many blocks: {held}");
}

/// A control that plans corners by what is requested makes none of them faster when it waits for its blocks.
#[test]
fn a_starved_control_is_never_faster() {
    let limit = |machine: &mut Machine, random: &mut Random| {
        machine.interpolator.planned_by = CornerPlanning::Request;
        machine.interpolator.block_time = random.log_between(0.0001, 0.05);
        machine.interpolator.look_ahead = random.between(1.0, 20.0).floor();
    };
    let mut slower = 0;
    for (mut case, _) in limited(33, case_count(), limit) {
        let starved = case.plan().cycle_time();
        case.machine.interpolator.block_time = 0.0;
        case.machine.interpolator.look_ahead = f64::INFINITY;
        let supplied = case.plan().cycle_time();
        assert!(supplied <= starved * (1.0 + 1e-9), "case {}: {supplied} s, {starved} s", case.number);
        slower += usize::from(supplied * 1.001 < starved);
    }
    assert!(case_count() / 10 < slower, "the limits decide on many programs: {slower}");
}

#[test]
fn the_machine_stands_where_it_has_to() {
    let limit = |machine: &mut Machine, random: &mut Random| {
        machine.interpolator.exact_stop_angle = random.between(0.1, std::f64::consts::PI);
    };
    for (case, _) in limited(29, case_count(), limit) {
        let plan = case.plan();
        let profile = Profile::new(&case.toolpath, &plan);
        let segments = &case.toolpath.segments;
        let stands_after = |index: usize| {
            let (before, after) = (&segments.at(index), &segments.at(index + 1));
            let has_rapid = before.motion.is_rapid() || after.motion.is_rapid();
            before.exact_stop
                || case.toolpath.stops.iter().any(|stop| stop.after == index + 1)
                || case.machine.interpolator.exact_stop_angle + 1e-6 < turn(before, after)
                || (case.machine.rapid.exact_stop && has_rapid)
        };
        let stretches = stretches(&plan);
        for index in (0..segments.len() - 1).filter(|&index| stands_after(index)) {
            assert_eq!(plan.corner_feedrates[index], 0.0, "case {}, corner {index}", case.number);
            let ends = |end: &&(f64, &RestToRest)| end.1.segments.end == index + 1;
            let (start, stretch) = stretches.iter().find(ends).expect("a stretch ends here");
            let time = start + profile.motion(stretch).duration();
            let state = profile.at_time(time);
            let fast = state.velocity.norm() / case.requested(&segments.at(index));
            assert!(fast <= 1e-9, "case {} at {time} s: {fast} of the feedrate", case.number);
            let away = (state.position - segments.at(index).end).norm();
            assert!(away <= 1e-9 * profile.length(), "case {} at {time} s: {away} mm off", case.number);
        }
    }
}

#[test]
fn corners_are_slowed_by_their_turn_down_to_a_stop() {
    let limit = |machine: &mut Machine, random: &mut Random| {
        machine.interpolator.slowing_angle = random.log_between(0.1, 10.0);
    };
    let mut slowed = 0;
    for (case, _) in limited(42, case_count(), limit) {
        let (plan, angle) = (case.plan(), case.machine.interpolator.slowing_angle);
        for (_, stretch) in stretches(&plan) {
            for index in stretch.segments.start..stretch.segments.end - 1 {
                let (before, after) =
                    (&case.toolpath.segments.at(index), &case.toolpath.segments.at(index + 1));
                let turn = turn(before, after);
                assert!(turn <= angle + 1e-6, "case {}, corner {index}: {turn} of {angle}", case.number);
                let slower = plan.segment_feedrates[index].min(plan.segment_feedrates[index + 1]);
                let most = slower * (1.0 - (change(before, after).amax() / angle).powi(4));
                let corner = plan.corner_feedrates[index];
                assert!(corner <= most * (1.0 + 1e-12), "case {}, corner {index}: {corner}", case.number);
                slowed += usize::from(corner == most);
            }
        }
    }
    assert!(case_count() / 10 < slowed, "the law decides on many corners: {slowed}");
}

#[test]
fn corners_keep_the_jerk_of_each_axis() {
    let limit = |machine: &mut Machine, random: &mut Random| {
        machine.axes.iter_mut().for_each(|axis| axis.jerk = random.log_between(1e3, 1e6));
        machine.interpolator.junction = Junction::Tolerance;
    };
    for (case, _) in limited(30, case_count(), limit) {
        let plan = case.plan();
        for (_, stretch) in stretches(&plan) {
            let filter = &plan.filters[stretch.filter];
            for index in stretch.segments.start..stretch.segments.end - 1 {
                let (before, after) =
                    (&case.toolpath.segments.at(index), &case.toolpath.segments.at(index + 1));
                let change = change(before, after);
                let slope = filter.peak_impulse_slope();
                for k in (0..3).filter(|_| slope.is_finite()) {
                    let jerk = plan.corner_feedrates[index] * change[k].abs() * slope;
                    let limit = case.machine.axes[k].jerk;
                    assert!(jerk <= limit * (1.0 + 1e-9), "case {}: {jerk} mm/s³", case.number);
                }
            }
        }
    }
}

/// The override is of the rapid that the axes leave, not of the one that is set.
#[test]
fn a_rapid_override_is_of_what_the_axes_leave() {
    let mut machine =
        Machine { axes: [Axis { velocity: 100.0, ..Axis::default() }; 3], ..Machine::default() };
    let rapid = line(Point::origin(), Point::new(30.0, 40.0, 0.0), Motion::RAPID);
    for (set, ratio, expected) in
        [(200.0, 1.0, 125.0), (200.0, 0.6, 75.0), (90.0, 0.6, 54.0), (200.0, 2.0, 125.0)]
    {
        (machine.rapid.feedrate, machine.overrides.rapid) = (set, ratio);
        let feedrate = requested_feedrate(&rapid, &machine);
        assert!((feedrate - expected).abs() < 1e-12, "{set} mm/s at {ratio}: {feedrate} mm/s");
    }
}
