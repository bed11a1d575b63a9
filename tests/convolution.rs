//! The profile against an independent computation: the command laid on a fine grid of time and
//! averaged by running sums, filter after filter, instead of piecewise polynomials.
//!
//! ```text
//! first filter      v(t) = (P(t) − P(t − T)) / T         exact at grid points, P commanded position
//! further filters   v(t) = 1/T ∫ v dt, from t − T to t   by trapezoids
//! position          P(t) = ∫ v dt                        by trapezoids
//! ```
//!
//! The error of the trapezoids falls with the square of the step, and so must the difference from
//! the profile, if it is exact. Beside that: the closed forms of the paper for a single move, the
//! derivatives against finite differences, and a program of an hour.

use truefeed::machine::{Junction, Machine, TimeConstants};
use truefeed::simulation::feed::{CornerPolicy, FeedPlan, Phase, RestToRest};
use truefeed::simulation::gcode::read;
use truefeed::simulation::interpreter::trace;
use truefeed::simulation::profile::{Moment, Profile};
use truefeed::simulation::simulate;
use truefeed::simulation::toolpath::{Point, Toolpath, Vector};

/// Contour tolerance of all plans here, mm.
const TOLERANCE: f64 = 0.02;

/// Corners of all kinds, blocks shorter than the filters, feedrates up and down.
const LINES: &str = "G1 X10 F3000\nY4\nX10.5 Y4.2\nX10.8 Y4.1 Z0.3 F6000\nX11 Y4.4\nX11.1\nX9 Y12 Z-5\nX2 F900\nX1.9 Y11.95\nX0 Y0 Z0 F5000";

/// Tangent and other transitions, a full circle, a helix of two turns, short arcs.
const ARCS: &str = "G1 X5 F3000\nG3 X8 Y3 I0 J3\nG1 Y6\nG2 I4 J0 F1800\nG3 X6 Y8 I-2 J0 Z1\nG1 X2 F6000\nG3 I0.5 J0 Z4 P2\nG2 X2.2 Y7.8 I0 J-0.2\nG3 X2.4 Y7.6 I0.2 J0\nG1 X9";

const FILTERS: [&[f64]; 8] = [
    &[0.024],
    &[0.024; 2],
    &[0.016; 3],
    &[0.012; 4],
    &[0.020, 0.008],
    &[0.005, 0.031],
    &[0.020, 0.011, 0.004],
    &[0.030, 0.002, 0.007, 0.001],
];

/// All constants above are whole multiples of this, s.
const COMMON_DIVISOR: f64 = 0.001;

fn machine(constants: &[f64], acceleration: f64) -> Machine {
    let mut machine = Machine::default();
    machine.interpolator.filters = constants.len();
    machine.interpolator.time_constants = TimeConstants::Unequal(constants.to_vec());
    machine.path.acceleration = acceleration;
    // Under a law of junctions that never binds, acceleration shapes the command itself.
    machine.interpolator.junction = Junction::AxisStep(1e9);
    machine
}

fn planned(program: &str, machine: &Machine) -> (Toolpath, FeedPlan) {
    let toolpath = trace(&read(program.as_bytes()), machine);
    let plan = simulate::with_policy(&toolpath, machine, CornerPolicy::Isolated(TOLERANCE));
    (toolpath, plan)
}

/// The only stretch of a plan.
fn stretch(plan: &FeedPlan) -> &RestToRest {
    match plan.phases.as_slice() {
        [Phase::Motion(stretch)] => stretch,
        phases => panic!("one stretch, not {phases:?}"),
    }
}

/// Every program and filter chain, with and without ramps.
fn for_all_cases(mut check: impl FnMut(&str, &Toolpath, &FeedPlan)) {
    for constants in FILTERS {
        for (name, program) in [("lines", LINES), ("arcs", ARCS)] {
            for acceleration in [f64::INFINITY, 700.0] {
                let (toolpath, plan) = planned(program, &machine(constants, acceleration));
                check(&format!("{name}, {constants:?}, A {acceleration}"), &toolpath, &plan);
            }
        }
    }
}

/// Position (mm) along the three axes and distance along the path (mm).
type Place = nalgebra::Vector4<f64>;

fn place(position: Point, distance: f64) -> Place {
    Place::new(position.x, position.y, position.z, distance)
}

/// The commanded place at a time, s; before the first pulse and after the last it stands.
fn commanded(toolpath: &Toolpath, plan: &FeedPlan, begins: &[(f64, f64)], time: f64) -> Place {
    let index = begins.partition_point(|&(begin, _)| begin <= time).max(1) - 1;
    let (pulse, (begin, travelled)) = (plan.pulses.at(index), begins[index]);
    let elapsed = (time - begin).clamp(0.0, pulse.duration);
    let [first, last] = pulse.feedrate;
    let run = elapsed * (first + 0.5 * (last - first) * elapsed / pulse.duration);
    let segment = toolpath.segments.at(pulse.segment as usize);
    place(segment.point(pulse.offset + run), travelled + run)
}

/// The filtered velocity (mm/s) and place at every grid point, by moving averages.
fn convolved(toolpath: &Toolpath, plan: &FeedPlan, steps_per_ms: usize) -> (Vec<Place>, Vec<Place>) {
    let step = COMMON_DIVISOR / steps_per_ms as f64;
    let windows: Vec<usize> = plan.filters[0]
        .time_constants()
        .iter()
        .map(|constant| (constant / COMMON_DIVISOR).round() as usize * steps_per_ms)
        .collect();
    let mut begins = Vec::new();
    let (mut time, mut travelled) = (0.0, 0.0);
    for pulse in &plan.pulses {
        begins.push((time, travelled));
        time += pulse.duration;
        travelled += 0.5 * (pulse.feedrate[0] + pulse.feedrate[1]) * pulse.duration;
    }
    let count = (time / step) as usize + 2 + windows.iter().sum::<usize>();
    let command: Vec<Place> =
        (0..count).map(|i| commanded(toolpath, plan, &begins, i as f64 * step)).collect();
    let first = windows[0];
    let mut velocity: Vec<Place> =
        (0..count).map(|i| (command[i] - command[i.saturating_sub(first)]) / (first as f64 * step)).collect();
    for &window in &windows[1..] {
        let travel = trapezoids(&velocity, step);
        velocity = (0..count)
            .map(|i| (travel[i] - travel[i.saturating_sub(window)]) / (window as f64 * step))
            .collect();
    }
    let travel = trapezoids(&velocity, step);
    let places = travel.into_iter().map(|travel| command[0] + travel).collect();
    (velocity, places)
}

/// Running integral of values `step` apart.
fn trapezoids(values: &[Place], step: f64) -> Vec<Place> {
    let mut sum = Place::zeros();
    let mut sums = vec![sum];
    sums.extend(values.windows(2).map(|pair| {
        sum += 0.5 * step * (pair[0] + pair[1]);
        sum
    }));
    sums
}

/// Largest difference in velocity (mm/s), position and distance (mm).
fn difference(toolpath: &Toolpath, plan: &FeedPlan, steps_per_ms: usize) -> [f64; 3] {
    let profile = Profile::new(toolpath, plan);
    let (velocities, places) = convolved(toolpath, plan, steps_per_ms);
    let step = COMMON_DIVISOR / steps_per_ms as f64;
    let mut largest = [0.0f64; 3];
    for (i, (velocity, place)) in velocities.iter().zip(&places).enumerate() {
        let state = profile.at_time(i as f64 * step);
        let apart = [
            (velocity.xyz() - state.velocity).norm(),
            (place.xyz() - state.position.coords).norm(),
            (place.w - state.distance).abs(),
        ];
        (0..3).for_each(|k| largest[k] = largest[k].max(apart[k]));
    }
    largest
}

/// At 1/32 ms the averages differ from the profile by less than 0.2 µm/s in velocity and 3 nm in
/// position; a 16 times wider step makes it some 16² times as much. With a single filter the
/// averaged velocity is exact already.
#[test]
fn moving_averages_approach_the_profile_with_the_square_of_the_step() {
    for_all_cases(|case, toolpath, plan| {
        let [coarse, fine] = [2, 32].map(|steps_per_ms| difference(toolpath, plan, steps_per_ms));
        let bounds = [2e-4, 3e-6, 3e-6];
        for (k, quantity) in ["velocity", "position", "distance"].into_iter().enumerate() {
            assert!(fine[k] < bounds[k], "{case}: {quantity} differs by {}", fine[k]);
            let order = (coarse[k] / fine[k]).ln() / 16f64.ln();
            let exact = k == 0 && plan.filters[0].time_constants().len() == 1;
            if exact {
                assert!(coarse[k] < 1e-11, "{case}: {quantity} differs by {}", coarse[k]);
            } else {
                assert!((1.8..2.2).contains(&order), "{case}: {quantity} converges with order {order}");
            }
        }
    });
}

/// Velocity, acceleration and jerk of a single move of `t_v` seconds at F, by Eq. 5 to 7: two
/// filters T. Rows 2 and 4 of Eq. 5 with the factor F / (2 T²), printed as F / (2 T).
fn two_filters(f: f64, t1: f64, t_v: f64, t: f64) -> [f64; 3] {
    let unit = f / (t1 * t1);
    let half = 0.5 * unit;
    match t {
        _ if t < t1 => [half * t * t, unit * t, unit],
        _ if t < 2.0 * t1 => [half * (-t * t + 4.0 * t1 * t - 2.0 * t1 * t1), unit * (-t + 2.0 * t1), -unit],
        _ if t < t_v => [f, 0.0, 0.0],
        _ if t < t_v + t1 => {
            [half * (-t * t + 2.0 * t_v * t - t_v * t_v + 2.0 * t1 * t1), unit * (-t + t_v), -unit]
        }
        _ if t < t_v + 2.0 * t1 => [
            half * (t * t - 2.0 * t_v * t - 4.0 * t1 * t + (t_v + 2.0 * t1).powi(2)),
            unit * (t - t_v - 2.0 * t1),
            unit,
        ],
        _ => [0.0; 3],
    }
}

/// The same by Eq. 31 to 33: three filters T. Row 5 of Eq. 31 with − Tv² t, printed as − Tv t.
fn three_filters(f: f64, t1: f64, t_v: f64, t: f64) -> [f64; 3] {
    let unit = f / t1.powi(3);
    let half = 0.5 * unit;
    let (t2, t3) = (t * t, t * t * t);
    match t {
        _ if t < t1 => [half / 3.0 * t3, half * t2, unit * t],
        _ if t < 2.0 * t1 => [
            half * (-2.0 / 3.0 * t3 + 3.0 * t1 * t2 - 3.0 * t1 * t1 * t + t1.powi(3)),
            unit * (-t2 + 3.0 * t1 * t - 1.5 * t1 * t1),
            2.0 * unit * (-t + 1.5 * t1),
        ],
        _ if t < 3.0 * t1 => [
            half * (t3 / 3.0 - 3.0 * t1 * t2 + 9.0 * t1 * t1 * t - 7.0 * t1.powi(3)),
            unit * (0.5 * t2 - 3.0 * t1 * t + 4.5 * t1 * t1),
            unit * (t - 3.0 * t1),
        ],
        _ if t < t_v => [f, 0.0, 0.0],
        _ if t < t_v + t1 => [
            half * (-t3 / 3.0 + t_v * t2 - t_v * t_v * t + t_v.powi(3) / 3.0 + 2.0 * t1.powi(3)),
            unit * (-0.5 * t2 + t_v * t - 0.5 * t_v * t_v),
            unit * (-t + t_v),
        ],
        _ if t < t_v + 2.0 * t1 => [
            half * (2.0 / 3.0 * t3 - 2.0 * t_v * t2 - 3.0 * t1 * t2
                + 3.0 * t1 * t1 * t
                + 2.0 * t_v * t_v * t
                + 6.0 * t_v * t1 * t
                - 2.0 / 3.0 * t_v.powi(3)
                - 3.0 * t_v * t_v * t1
                - 3.0 * t_v * t1 * t1
                + t1.powi(3)),
            unit * (t2 - 2.0 * t_v * t - 3.0 * t1 * t + 1.5 * t1 * t1 + t_v * t_v + 3.0 * t_v * t1),
            2.0 * unit * (t - t_v - 1.5 * t1),
        ],
        _ if t < t_v + 3.0 * t1 => [
            half * (-t3 / 3.0 + t_v * t2 + 3.0 * t1 * t2
                - t_v * t_v * t
                - 9.0 * t1 * t1 * t
                - 6.0 * t_v * t1 * t
                + (t_v + 3.0 * t1).powi(3) / 3.0),
            half * (-t2 + 2.0 * t_v * t + 6.0 * t1 * t - t_v * t_v - 9.0 * t1 * t1 - 6.0 * t_v * t1),
            unit * (-t + t_v + 3.0 * t1),
        ],
        _ => [0.0; 3],
    }
}

#[test]
fn a_single_move_is_that_of_the_paper() {
    type Form = fn(f64, f64, f64, f64) -> [f64; 3];
    let (f, length, t1) = (50.0, 5.0, 0.0255);
    let t_v = length / f;
    for (order, form) in [(2, two_filters as Form), (3, three_filters as Form)] {
        let (toolpath, plan) = planned("G1 X5 F3000", &machine(&vec![t1; order], f64::INFINITY));
        let profile = Profile::new(&toolpath, &plan);
        for i in 0..5000 {
            let t = (i as f64 + 0.5) / 5000.0 * profile.cycle_time();
            let dynamics = profile.dynamics_at_time(t).expect("it moves");
            let found = [profile.at_time(t).velocity.x, dynamics.acceleration.x, dynamics.jerk.x];
            let expected = form(f, t1, t_v, t);
            for k in 0..3 {
                let scale = f / t1.powi(k as i32);
                let apart = (found[k] - expected[k]).abs() / scale;
                assert!(apart < 1e-12, "n = {order}, t = {t}, derivative {k}: {apart}");
            }
        }
    }
}

/// Away from the kinks, where a derivative jumps, each quantity is the slope of the one before.
#[test]
fn derivatives_are_slopes() {
    for_all_cases(|case, toolpath, plan| {
        let profile = Profile::new(toolpath, plan);
        let motion = profile.motion(stretch(plan));
        let filter = motion.filter();
        let mut kinks: Vec<f64> = (0..plan.pulses.len())
            .flat_map(|pulse| filter.knots().map(move |knot| (pulse, knot)))
            .map(|(pulse, knot)| motion.pulse_start(pulse) + knot)
            .chain(filter.knots().map(|knot| motion.command_time() + knot))
            .collect();
        kinks.sort_by(f64::total_cmp);
        let step = 1e-6;
        let smooth = |t: f64| {
            let next = kinks.partition_point(|&kink| kink < t - 2.0 * step);
            kinks.get(next).is_none_or(|&kink| t + 2.0 * step < kink)
        };
        let fastest = plan.segment_feedrates.iter().copied().fold(0.0, f64::max);
        let shortest = filter.time_constants().iter().copied().fold(f64::INFINITY, f64::min);
        let mut checked = 0;
        for i in 0..2000 {
            let t = (i as f64 + 0.5) / 2000.0 * motion.duration();
            if !smooth(t) {
                continue;
            }
            let [before, now, after] = [t - step, t, t + step].map(|t| motion.moment(t));
            let slope = |a: Vector, b: Vector| (b - a) / (2.0 * step);
            let (state, dynamics) = (motion.state(now), motion.dynamics(now));
            let velocity = slope(motion.state(before).position.coords, motion.state(after).position.coords);
            let acceleration = slope(motion.state(before).velocity, motion.state(after).velocity);
            let jerk = slope(motion.dynamics(before).acceleration, motion.dynamics(after).acceleration);
            let apart = [
                (velocity - state.velocity).norm() / fastest,
                (acceleration - dynamics.acceleration).norm() * shortest / fastest,
                (jerk - dynamics.jerk).norm() * shortest * shortest / fastest,
            ];
            assert!(apart.iter().all(|apart| *apart < 1e-6), "{case}, t = {t}: {apart:?}");
            checked += 1;
        }
        assert!(1900 < checked, "{case}: most moments are smooth");
    });
}

/// The value as a whole number of 2⁻¹⁰⁰, exactly, but for what is smaller.
fn whole(value: f64) -> i128 {
    (value * 100f64.exp2()) as i128
}

/// A finishing pass of `blocks` blocks, each taking some 24 ms.
fn hour_long(blocks: usize) -> Toolpath {
    let mut program = String::from("G1 F2000\n");
    for block in 1..=blocks {
        let x = 0.61 * block as f64;
        let y = 3.0 * (0.11 * x).sin() + 0.02 * (block % 7) as f64;
        program += &format!("X{x:.3} Y{y:.3}\n");
    }
    trace(&read(program.as_bytes()), &Machine::default())
}

#[test]
fn an_hour_of_motion_loses_no_digits() {
    let blocks = 150_000;
    let toolpath = hour_long(blocks);
    let whole_plan = simulate::with_policy(&toolpath, &Machine::default(), CornerPolicy::Isolated(TOLERANCE));
    let whole_profile = Profile::new(&toolpath, &whole_plan);
    let cycle_time = whole_plan.cycle_time();
    assert!((3550.0..3700.0).contains(&cycle_time), "about an hour: {cycle_time}");

    let delay = whole_plan.filters[0].delay();
    let sum = whole_plan.pulses.iter().map(|pulse| whole(pulse.duration)).sum::<i128>() + whole(delay);
    let length: i128 = toolpath.segments.iter().map(|segment| whole(segment.length)).sum();
    let last_digit = f64::EPSILON * cycle_time;
    assert!((whole(cycle_time) - sum).abs() <= whole(last_digit));
    assert!((whole(whole_profile.cycle_time()) - sum).abs() <= whole(last_digit));
    assert!((whole(whole_profile.length()) - length).abs() <= whole(f64::EPSILON * whole_profile.length()));

    // The same last blocks alone; only the first of them is run otherwise, from a full stop.
    let alone =
        Toolpath { segments: toolpath.segments.iter().skip(blocks - 1000).collect(), ..Toolpath::default() };
    let alone_plan = simulate::with_policy(&alone, &Machine::default(), CornerPolicy::Isolated(TOLERANCE));
    let alone_profile = Profile::new(&alone, &alone_plan);
    let before = whole_profile.distance_before(blocks - 1000);
    let (whole_motion, alone_motion) =
        (whole_profile.motion(stretch(&whole_plan)), alone_profile.motion(stretch(&alone_plan)));
    let fastest = 2000.0 / 60.0;
    for back in 1..500 {
        let (late, early) = (whole_plan.pulses.len() - back, alone_plan.pulses.len() - back);
        let elapsed = 0.37 * whole_plan.pulses.duration(late);
        let (a, b) = (Moment { pulse: late, elapsed }, Moment { pulse: early, elapsed });
        let (whole_state, state) = (whole_motion.state(a), alone_motion.state(b));
        let apart = (whole_state.velocity - state.velocity).norm() / fastest;
        assert!(apart <= 1e-12, "{back} pulses before the end: {apart}");
        assert!((whole_state.position - state.position).norm() <= 1e-12 * state.position.coords.norm());
        let apart = (whole_state.distance - before - state.distance).abs();
        assert!(apart <= 1e-12 * whole_profile.length());
        let (whole_dynamics, dynamics) = (whole_motion.dynamics(a), alone_motion.dynamics(b));
        let scale = fastest / 0.0255;
        assert!((whole_dynamics.acceleration - dynamics.acceleration).norm() <= 1e-12 * scale);
        assert!((whole_dynamics.jerk - dynamics.jerk).norm() <= 1e-12 * scale / 0.0255);

        // Asked by the clock, the time itself is rounded; no more is lost than that.
        let since_end = 0.01 * back as f64;
        let whole_state = whole_profile.at_time(cycle_time - since_end);
        let state = alone_profile.at_time(alone_profile.cycle_time() - since_end);
        assert!((whole_state.position - state.position).norm() <= 4.0 * last_digit * fastest);
        assert!((whole_state.velocity - state.velocity).norm() <= 4.0 * last_digit * scale);
    }
}
