//! LinuxCNC's planner by closed forms, whose speeds and accelerations were read off recordings of it.

use std::f64::consts::{PI, SQRT_2};

use truefeed::machine::{CornerMode, Junction, Machine, TimeConstants};
use truefeed::project::machine_from_toml;
use truefeed::simulation::gcode::read;
use truefeed::simulation::interpreter::trace;
use truefeed::simulation::profile::{Profile, Resolution};
use truefeed::simulation::simulate;
use truefeed::simulation::toolpath::Point;

fn planner() -> Machine {
    machine_from_toml(include_str!("data/machines/linuxcnc.toml")).expect("the file is right")
}

fn time(program: &str, machine: &Machine) -> f64 {
    simulate(&trace(&read(program.as_bytes()), machine), machine).cycle_time()
}

/// The last half of a servo period is not in the closed forms.
const WITHIN_S: f64 = 2e-3;

/// Both legs overlap while the first brakes: an arc at √(0.866 · A/2 · r) with half of half its acceleration, and a line that
/// is the last of the program, with half of its own.
#[test]
fn without_arc_blends_the_next_leg_starts_while_the_last_one_brakes() {
    let mut machine = planner();
    machine.interpolator.junction = Junction::ParabolicBlend;
    machine.axes.iter_mut().for_each(|axis| (axis.acceleration, axis.velocity) = (960.0, 60.0));
    let radius = 3.841;
    let (arc, line) = (PI * radius, 83.589);
    let on_arc = (0.75f64.sqrt() * 480.0 * radius).sqrt();
    let on_line = 2850.0 / 60.0;
    let expected = arc / on_arc + line / on_line + on_line / 480.0;
    let found = time("G21 G64\nG3 X0 Y7.682 I0 J3.841 F2850\nG1 X-83.589", &machine);
    assert!((found - expected).abs() < WITHIN_S, "{found} s, {expected} s");
}

/// A leg of a chain of parabolas in servo periods, as tp.c of LinuxCNC 2.9 runs it.
struct Leg {
    left: f64,
    velocity: f64,
    /// Velocity below which the next leg starts while this one brakes.
    blend_velocity: f64,
    is_overlapped: bool,
}

/// Servo period, s.
const PERIOD_S: f64 = 1e-3;

impl Leg {
    /// Moves on by one period. The leg is overlapped from the first period in which it brakes below its blend velocity.
    fn advance(&mut self, acceleration: f64, feedrate: f64) {
        let half = 0.5 * acceleration * PERIOD_S;
        let square = half * half + acceleration * (2.0 * self.left - self.velocity * PERIOD_S);
        let can_stop = (square.max(half * half)).sqrt() - half;
        let most = acceleration * PERIOD_S;
        let next = can_stop.min(feedrate).clamp(self.velocity - most, self.velocity + most);
        self.is_overlapped |= next < self.velocity && next < self.blend_velocity;
        self.left -= 0.5 * (self.velocity + next) * PERIOD_S;
        self.velocity = next;
    }
}

/// Returns the duration of a chain of legs of these lengths, s.
fn in_periods(lengths: &[f64], acceleration: f64, feedrate: f64) -> f64 {
    let top = |length: f64| feedrate.min((acceleration * length).sqrt());
    let leg = |(at, &left): (usize, &f64)| {
        let blend_velocity = lengths.get(at + 1).map_or(0.0, |&next| {
            let ramp = top(left).max(top(next)) / acceleration;
            top(left).min(acceleration * ramp.min(left / top(left)).min(next / top(next)))
        });
        Leg { left, velocity: 0.0, blend_velocity, is_overlapped: false }
    };
    let mut waiting = lengths.iter().enumerate().map(leg);
    let mut legs: Vec<Leg> = waiting.next().into_iter().collect();
    let mut periods = 0;
    while !legs.is_empty() {
        periods += 1;
        if legs.len() == 1 {
            legs.extend(waiting.next());
        }
        legs[0].advance(acceleration, feedrate);
        if legs[0].is_overlapped && 1 < legs.len() {
            legs[1].advance(acceleration, feedrate);
        }
        if legs[0].velocity == 0.0 {
            legs.remove(0);
        }
    }
    f64::from(periods) * PERIOD_S
}

/// Returns by how much each corner of a chain of parabolas takes longer in the simulation than in servo periods, s. The
/// chain has legs of these lengths (mm), again and again.
fn longer_at_each_corner(lengths: &[f64]) -> f64 {
    let mut machine = planner();
    machine.interpolator.junction = Junction::ParabolicBlend;
    machine.axes.iter_mut().for_each(|axis| (axis.acceleration, axis.velocity) = (3000.0, 100.0));
    let (count, turn) = (60, 0.04f64);
    let chain: Vec<f64> = lengths.iter().copied().cycle().take(count).collect();
    let leg = |(at, length): (usize, &f64)| {
        let (sin, cos) = if at.is_multiple_of(2) { (0.0, 1.0) } else { turn.sin_cos() };
        format!("G91 X{:.9} Y{:.9}\n", length * cos, length * sin)
    };
    let program = format!("G21 G64\nG1 F3190\n{}", chain.iter().enumerate().map(leg).collect::<String>());
    let (expected, found) = (in_periods(&chain, 1500.0, 3190.0 / 60.0), time(&program, &machine));
    (found - expected) / (count - 1) as f64
}

/// The next leg starts up to a servo period before the last one brakes, each time by as much if all legs are as long.
#[test]
fn the_next_leg_starts_at_the_beginning_of_a_servo_period() {
    for length in [2.05, 2.2, 2.56, 3.3, 7.0] {
        let longer = longer_at_each_corner(&[length]);
        assert!(longer.abs() < 0.1 * PERIOD_S, "{length} mm: {longer} s at each corner");
    }
}

/// Legs that only peak or hardly hold their feedrate, and long legs that brake well before the next one starts.
#[test]
fn the_next_leg_starts_with_the_first_period_in_which_the_last_one_is_slower_at_its_end() {
    let chains = [&[1.71][..], &[1.9], &[7.0, 0.3], &[5.4, 0.62], &[3.3, 0.41, 2.2]];
    let each: Vec<f64> = chains.iter().map(|lengths| longer_at_each_corner(lengths)).collect();
    assert!(each.iter().all(|longer| longer.abs() < 0.2 * PERIOD_S), "{each:?} s longer at each corner");
}

/// Before an arc, the leg's brake is held against the direction in which the arc accelerates, towards its centre as well:
/// 28.7 mm/s in the recording, where the tangents alone would allow all of 47.5.
#[test]
fn an_arc_that_goes_straight_on_slows_the_line_before_it() {
    let mut machine = planner();
    machine.interpolator.junction = Junction::ParabolicBlend;
    machine.axes.iter_mut().for_each(|axis| (axis.acceleration, axis.velocity) = (960.0, 60.0));
    let onto_arc = |radius: f64| {
        // Two legs onto an arc, with a move behind each arc.
        let (end, onto) = (2.0 * radius, "G1 X83.589 F2850");
        let half = format!("{onto}\nG3 Y{end:.3} I0 J{radius}\nG1 X-83.589\nG3 Y0 I0 J-{radius}");
        let program = format!("G21 G64 P0.062\n{half}\nG1 X83.589");
        time(&program, &machine) - 2.0 * PI * radius / (0.75f64.sqrt() * 480.0 * radius).sqrt().min(47.5)
    };
    let (tight, wide) = (onto_arc(3.841), onto_arc(400.0));
    assert!(wide + 0.05 < tight, "{tight} s, {wide} s");
}

/// An arc behind which no move is queued has half of its acceleration for ramps, and half of that where it might blend:
/// 460 and 230 mm/s² in the recording. Of one behind which another is queued, the turn leaves 878 of 920 mm/s².
#[test]
fn an_arc_that_is_last_in_the_queue_starts_and_stops_with_half_of_its_acceleration() {
    let mut machine = planner();
    let limits = [(920.0, 119.0), (1410.0, 74.0), (1190.0, 104.0)];
    machine.axes.iter_mut().zip(limits).for_each(|(axis, own)| (axis.acceleration, axis.velocity) = own);
    let (circle, feedrate) = ("G2 X0 Y0 I20 J0", 50.0);
    let expected = |acceleration: f64| 40.0 * PI / feedrate + feedrate / acceleration;
    let one = |mode: &str| time(&format!("G21 {mode} F3000\n{circle}"), &machine);
    let waiting = time(&format!("G21 G61.1 F3000\n{circle}\nG4 P1\n{circle}"), &machine);
    let two = time(&format!("G21 G61.1 F3000\n{circle}\n{circle}"), &machine);
    let turning = 74.0 * 74.0 / 20.0 / 920.0;
    let queued = expected(920.0 * (1.0f64 - turning * turning).sqrt());
    for (found, expected) in [
        (one("G61.1"), expected(460.0)),
        (one("G64"), expected(230.0)),
        (waiting, 2.0 * expected(460.0) + 1.0),
        (two, queued + expected(460.0)),
    ] {
        assert!((found - expected).abs() < 2.0 * WITHIN_S, "{found} s, {expected} s");
    }
}

/// An arc that is last in the queue has the feedrate that its whole acceleration allows, whatever blends into it: 70 mm/s
/// around 13 mm at 610 mm/s² in the recording, where half of the acceleration would allow 58.6.
#[test]
fn an_arc_that_is_last_in_the_queue_has_the_feedrate_of_its_whole_acceleration() {
    let mut machine = planner();
    machine.axes.iter_mut().for_each(|axis| (axis.acceleration, axis.velocity) = (610.0, 96.0));
    let (mode, circle) = ("G21 G64 P0.03", "G3 X0 Y0 I-13 J0 F4200");
    let alone = time(&format!("{mode}\n{circle}\nG4 P0"), &machine);
    let expected = 26.0 * PI / 70.0 + 70.0 / 152.5;
    assert!((alone - expected).abs() < WITHIN_S, "{alone} s, {expected} s");
    // The circle speeds up while the leg before it brakes.
    let leg = 3.0 / 15.0 + 15.0 / 305.0;
    let behind = time(&format!("{mode}\nG1 Z-3 F900\n{circle}\nG4 P0"), &machine);
    assert!(behind < leg + expected, "{behind} s, {leg} s + {expected} s");
}

/// A line between two arcs that takes less than 10 ms is one ramp: in the recording of a trochoid the tool keeps its 49 mm/s
/// on lines of 0.48 mm. On longer lines it speeds up and brakes again.
#[test]
fn a_short_line_between_arcs_is_one_ramp() {
    let mut machine = planner();
    let (acceleration, radius) = (940.0, 2.949);
    machine.axes.iter_mut().for_each(|axis| (axis.acceleration, axis.velocity) = (acceleration, 218.0));
    let trochoid = |turns: u32, length: f64| {
        let turn = |at: u32| {
            let x = length * f64::from(at);
            format!("G1 X{x:.4}\nG3 Y{radius} J{radius}\nY-{radius} J-{radius}\n")
        };
        let turns: String = (1..=turns).map(turn).collect();
        time(&format!("G21 G64 F3940\nG0 Y-{radius}\n{turns}G1 Y-9\n"), &machine)
    };
    let on_arc = (0.75f64.sqrt() * acceleration * radius).sqrt();
    let speeding =
        |length: f64| 2.0 * ((on_arc * on_arc + acceleration * length).sqrt() - on_arc) / acceleration;
    for (length, line) in [(0.48, 0.48 / on_arc), (0.52, speeding(0.52))] {
        let found = (trochoid(21, length) - trochoid(1, length)) / 20.0;
        let expected = 2.0 * PI * radius / on_arc + line;
        assert!((found - expected).abs() < 1e-5, "{length} mm: {found} s, {expected} s");
    }
}

/// An exact-stop angle of 0 is G61.1: a stop at the end of every block, where the path goes straight on as well.
#[test]
fn an_angle_of_nothing_stops_where_nothing_turns() {
    let mut machine = planner();
    let blocks = "G1 X10 F900\nX20\nG3 Y8 J4\nG1 X5\nG0 Z5";
    let stopped = time(&format!("G21 G61.1\n{blocks}"), &machine);
    machine.interpolator.exact_stop_angle = 0.0;
    let by_angle = time(&format!("G21 G64\n{blocks}"), &machine);
    assert!((stopped - by_angle).abs() < 1e-9, "{stopped} s, {by_angle} s");
}

/// RS274/NGC runs canned cycles in exact path mode, whatever mode the program is in, exact stop included.
#[test]
fn cycles_run_in_exact_path_mode() {
    let mut machine = planner();
    let cycle = time("G21 G64 P0.1\nG0 Z9\nG98 G81 X20 Y0 Z-2 R2 F300\nX40\nG80", &machine);
    let moves = "G0 X20\nZ2\nG1 Z-2 F300\nG0 Z9\nX40\nZ2\nG1 Z-2\nG0 Z9";
    let written = time(&format!("G21 G64 P0.1\nG0 Z9\nG61\n{moves}"), &machine);
    let blended = time(&format!("G21 G64 P0.1\nG0 Z9\n{moves}"), &machine);
    assert!((cycle - written).abs() < 1e-9, "{cycle} s, {written} s");
    assert!(0.01 < (cycle - blended).abs(), "{cycle} s, {blended} s");
    let alone = "G21 G61.1\nG0 Z9\nG64 P0.1\nG98 G81 X20 Y0 Z-2 R2 F300\nX40\nG80";
    let in_its_mode = time(alone, &machine);
    machine.interpolator.exact_stop_angle = 0.0;
    let stopped = time(alone, &machine);
    assert!((in_its_mode - stopped).abs() < 1e-9, "{in_its_mode} s, {stopped} s");
}

/// In exact path mode the corners of a staircase are stops, between which a tenth of the acceleration is missing. A leg
/// begins with a servo period: 1655 recorded legs took up to one period longer than in continuous time, on average half a
/// period. The filter of half a period models this average.
#[test]
fn a_leg_after_a_stop_at_a_corner_begins_when_the_filter_has_run_empty() {
    let mut machine = planner();
    machine.axes.iter_mut().for_each(|axis| axis.acceleration = 500.0);
    machine.interpolator.time_constants = TimeConstants::Equal(5e-4);
    let stairs: String = (1..=20).map(|at| format!("G1 X{at} F2470\nY{at}\n")).collect();
    let leg = 2.0 * (1.0 / (0.9 * 500.0_f64)).sqrt() + 5e-4;
    let found = time(&format!("G21 G90 G61\n{stairs}M30\n"), &machine);
    assert!((found - 40.0 * leg).abs() < 1e-9, "{found} s, {} s", 40.0 * leg);
    // Without arc blends no acceleration is missing.
    machine.interpolator.junction = Junction::ParabolicBlend;
    let leg = 2.0 * (1.0 / 500.0_f64).sqrt() + 5e-4;
    let found = time(&format!("G21 G90 G61\n{stairs}M30\n"), &machine);
    assert!((found - 40.0 * leg).abs() < 1e-9, "{found} s, {} s", 40.0 * leg);
}

/// The tool at the corner of a program: the point of its path that is nearest to it, mm.
fn nearest_to(corner: Point, program: &str, machine: &Machine) -> f64 {
    let toolpath = trace(&read(program.as_bytes()), machine);
    let plan = simulate(&toolpath, machine);
    let samples = Profile::new(&toolpath, &plan).samples(Resolution::FINE);
    let [x, y, z] = &samples.position;
    let apart = |row: usize| (Point::new(x[row], y[row], z[row]) - corner).norm();
    (0..samples.time.len()).map(apart).fold(f64::INFINITY, f64::min)
}

/// Both curves are as wide as the tolerance ε allows. A parabola with the acceleration a along each leg begins at
/// v² = 4 √2 a ε, replaces d = v²/2a = 2 √2 ε of each leg, and has d/4 = ε/√2 of both left beside the corner. It begins
/// earlier by the time e since the beginning of the servo period, at v + a e.
#[test]
fn a_blend_passes_the_corner_within_its_tolerance() {
    let mut machine = planner();
    machine.axes.iter_mut().for_each(|axis| (axis.acceleration, axis.velocity) = (1000.0, 200.0));
    for junction in [Junction::ParabolicBlend, Junction::AccelerationBlend] {
        machine.interpolator.junction = junction;
        for tolerance in [0.02, 0.3] {
            let program = format!("G21 G64 P{tolerance}\nG1 X40 F9000\nY40");
            let found = nearest_to(Point::new(40.0, 0.0, 0.0), &program, &machine);
            // A parabola has half of the acceleration. Its first leg only peaks, and then brakes to v.
            let (half, v) = (500.0, (4.0 * SQRT_2 * 500.0 * tolerance).sqrt());
            let early = ((2.0 * f64::sqrt(half * 40.0) - v) / half).rem_euclid(PERIOD_S);
            let expected = match junction {
                Junction::ParabolicBlend => tolerance * (1.0 + half * early / v).powi(2),
                _ => tolerance,
            };
            assert!(
                (0.99 * expected..1.001 * expected).contains(&found),
                "{junction:?}: {found} of {tolerance} mm"
            );
        }
    }
}

/// G64 Q leaves the points out that are within Q of a line, and the tool is on that line.
#[test]
fn the_tool_is_on_the_line_that_replaces_merged_ones() {
    let machine = planner();
    let top = |q: f64| {
        nearest_to(
            Point::new(20.0, 0.05, 0.0),
            &format!("G21 G64 P0.001 Q{q}\nG1 X20 Y0.05 F3000\nX40 Y0"),
            &machine,
        )
    };
    let [merged, own] = [0.06, 0.001].map(top);
    assert!((merged - 0.05).abs() < 1e-6, "{merged} mm from the point that is left out");
    assert!(own < 2e-3, "{own} mm from the corner");
}

/// Blends keep their tolerance by themselves: the mode that corrects filtered paths changes nothing.
#[test]
fn the_guaranteed_mode_leaves_blends_alone() {
    let program = "G21 G64 P0.01 Q0.05\nG1 X20 Y0.03 F3000\nX40 Y0\nY20\nG3 X30 Y30 I-10\nG1 X0";
    let mut machine = planner();
    let paper = time(program, &machine);
    machine.interpolator.corner_mode = CornerMode::Guaranteed;
    assert_eq!(time(program, &machine), paper);
}
