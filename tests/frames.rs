//! Coordinates, feed modes and rotary axes: laws that hold from program to cycle time.

use truefeed::machine::{Machine, TimeConstants};
use truefeed::simulation::feed::{CornerPolicy, FeedPlan, limits};
use truefeed::simulation::gcode::{Dialect, Options, Severity, read_with};
use truefeed::simulation::interpreter::trace;
use truefeed::simulation::simulate;
use truefeed::simulation::toolpath::{Motion, Point, Segment, StopCause, Toolpath};

/// Runs a program for LinuxCNC, which reads the words of the others too.
fn run_on(text: &str, machine: &Machine) -> Toolpath {
    let options = Options { dialect: Some(Dialect::LinuxCnc), ..Options::default() };
    let toolpath = trace(&read_with(text.as_bytes(), &options), machine);
    for segment in &toolpath.segments {
        let apart = (segment.point(segment.length) - segment.end).norm();
        let back = (segment.point(0.0) - segment.start).norm();
        assert!(apart.max(back) < 1e-8, "{text}: {segment:?}");
    }
    toolpath
}

fn run(text: &str) -> Toolpath {
    run_on(text, &Machine::default())
}

/// A run without a word of complaint.
fn run_well(text: &str) -> Toolpath {
    let toolpath = run(text);
    let bad: Vec<_> = toolpath.diagnostics.iter().filter(|found| found.severity != Severity::Info).collect();
    assert!(bad.is_empty(), "{text}: {bad:?}");
    toolpath
}

fn plan_of(toolpath: &Toolpath, machine: &Machine) -> FeedPlan {
    simulate::with_policy(toolpath, machine, CornerPolicy::Isolated(machine.interpolator.contour_tolerance))
}

fn feedrate(segment: &Segment) -> f64 {
    match segment.motion {
        Motion::Feed { feedrate } => feedrate,
        Motion::Rapid { .. } => f64::INFINITY,
    }
}

/// Reproducible numbers: Marsaglia's xorshift.
struct Random(u64);

impl Random {
    fn below(&mut self, bound: u64) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0 % bound
    }

    /// Uniform in −50 to 50 with three decimals.
    fn coordinate(&mut self) -> f64 {
        (self.below(100_001) as f64 - 50_000.0) / 1000.0
    }
}

/// Rapids, lines, arcs by centre and by radius, helices and full circles in the plane X Y.
fn random_moves(random: &mut Random, count: usize) -> String {
    let mut text = String::from("G1 F1200\n");
    for _ in 0..count {
        let [x, y, z] = [random.coordinate(), random.coordinate(), random.coordinate()];
        let (turn, half) = (2 + random.below(2), 1.0 + random.below(20_000) as f64 / 1000.0);
        text += &match random.below(6) {
            0 => format!("G0 X{x} Y{y} Z{z}\n"),
            1 => format!("G91 G{turn} X{half} Y{half} I{half}\nG90\n"),
            2 => format!("G91 G{turn} X{} Y0 R{} Z1\nG90\n", 2.0 * half, 1.5 * half),
            3 => format!("G91 G{turn} X{} R-{}\nG90\n", half, half),
            4 => format!("G{turn} I{half} J{}\n", -half),
            _ => format!("G1 X{x} Y{y} Z{z}\n"),
        };
    }
    text
}

#[test]
fn turns_and_mirrors_change_neither_lengths_nor_times() {
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    let machine = Machine::default();
    for case in 0..60 {
        let moves = random_moves(&mut random, 40);
        let [x, y] = [random.coordinate(), random.coordinate()];
        let degrees = random.below(360_000) as f64 / 1000.0;
        let change = [
            format!("G68 X{x} Y{y} R{degrees}"),
            format!("G51.1 X{x}"),
            format!("G51.1 X{x} Y{y}\nG51.1 Z3"),
            format!("G10 L2 P1 R{degrees}"),
            format!("G51.1 Y{y}\nG51 X{y} Y{x} P1\nG68 X{y} R-{degrees}"),
            format!("G51 X{x} I-1 J1 K1"),
            format!("G18 G68 X{x} Z{y} R{degrees}\nG17"),
            format!("G19 G68 Y{x} Z{y} R{degrees}\nG51.1 Y3\nG17"),
        ];
        // The first move leads from the tool's place into the coordinates: it is left out.
        let first = format!("G0 X{x} Y{y} Z5\n");
        let without_first = |mut toolpath: Toolpath| {
            toolpath.segments = toolpath.segments.iter().skip(1).collect();
            toolpath
        };
        let plain = without_first(run_well(&format!("{first}{moves}")));
        let change = &change[case % change.len()];
        let changed = without_first(run_well(&format!("{change}\n{first}{moves}")));
        assert_eq!(plain.segments.len(), changed.segments.len());
        for (a, b) in plain.segments.iter().zip(&changed.segments) {
            assert!((a.length - b.length).abs() < 1e-9 * (1.0 + a.length), "{change}\n{a:?}\n{b:?}");
        }
        let [before, after] = [&plain, &changed].map(|toolpath| plan_of(toolpath, &machine).cycle_time());
        assert!((before - after).abs() < 1e-6 * before, "{change}: {before} s, {after} s");
    }
}

#[test]
fn scaling_scales_lengths_and_leaves_the_feedrate() {
    let mut random = Random(77);
    let moves = random_moves(&mut random, 60);
    let plain = run_well(&format!("G0 X1 Y1 Z1\n{moves}"));
    for factor in ["P2.5", "P2500", "I2.5 J2.5 K2.5"] {
        let scaled = run_well(&format!("G51 X0 Y0 Z0 {factor}\nG0 X1 Y1 Z1\n{moves}"));
        for (a, b) in plain.segments.iter().zip(&scaled.segments) {
            assert!((2.5 * a.length - b.length).abs() < 1e-8, "{a:?}\n{b:?}");
            assert!((2.5 * a.end.coords - b.end.coords).norm() < 1e-8);
            assert_eq!(feedrate(&a), feedrate(&b));
        }
    }
}

#[test]
fn a_mirrored_arc_is_the_image_of_the_arc() {
    let mut random = Random(5);
    let moves = random_moves(&mut random, 60);
    let plain = run_well(&format!("G0 X1 Y1 Z1\n{moves}"));
    let mirrored = run_well(&format!("G51.1 X10\nG0 X1 Y1 Z1\n{moves}"));
    for (a, b) in plain.segments.iter().zip(&mirrored.segments).skip(1) {
        for fraction in [0.0, 0.2, 0.6, 1.0] {
            let (a, b) = (a.point(fraction * a.length), b.point(fraction * b.length));
            assert!((Point::new(20.0 - a.x, a.y, a.z) - b).norm() < 1e-9);
        }
    }
}

#[test]
fn every_operation_ends() {
    let ends = "G69\nG50\nG50.1\nG15\nG49\nG92.1\nG52 X0 Y0 Z0\nG54";
    let begins = "G55\nG51.1 X3\nG51 X1 P2.\nG68 X2 Y5 R17\nG16\nG92 X9\nG52 X3 Y2 Z1\nG10 L1 P1 Z7\nG43 H1";
    let toolpath = run_well(&format!("{begins}\n{ends}\nG0 X1 Y2 Z3"));
    assert_eq!(toolpath.segments.last().expect("a move").end, Point::new(1.0, 2.0, 3.0));
}

#[test]
fn changes_of_coordinates_alone_move_nothing() {
    let words = [
        "G92 X3 Y-2 A5",
        "G92.1",
        "G92.2",
        "G92.3",
        "G52 X4 Z1",
        "G54",
        "G55",
        "G59.3",
        "G54.1 P5",
        "G10 L2 P1 X7 Y1",
        "G10 L20 P1 X2 A9",
        "G10 L2 P2 R33",
        "G68 X5 R20",
        "G69",
        "G51 X3 P2.",
        "G50",
        "G51.1 Y4",
        "G50.1",
        "G16",
        "G15",
        "G43.1 Z9",
        "G49",
        "G10 L1 P1 Z4",
        "G43 H1",
        "G17",
        "G18",
    ];
    let mut random = Random(11);
    for _ in 0..200 {
        let mut text = String::from("G0 X10 Y20 Z30\n");
        for _ in 0..random.below(30) {
            text += words[random.below(words.len() as u64) as usize];
            text.push('\n');
        }
        let toolpath = run(&text);
        assert_eq!((toolpath.segments.len(), toolpath.stops.len()), (1, 0), "{text}");
        // Nor do they lose the place: by increments in the coordinates of the start it is found.
        let back = run(&format!("{text}G69\nG50\nG50.1\nG15\nG54\nG10 L2 P1 R0\nG17 G91 G0 X1"));
        let end = back.segments.last().expect("a move").end;
        assert!((end - Point::new(11.0, 20.0, 30.0)).norm() < 1e-9, "{text}: {end}");
    }
}

#[test]
fn a_position_is_named_as_asked_in_any_coordinates() {
    let mut random = Random(23);
    for _ in 0..200 {
        let degrees = random.below(360);
        let [x, y, z] = [random.coordinate(), random.coordinate(), random.coordinate()];
        for naming in ["G92", "G10 L20 P1", "G10 L20 P0"] {
            let head = format!("G10 L2 P1 X3 Y2 R{degrees}\nG51.1 X2\nG51 P2. X0\nG0 X{y} Y{z} Z{x}\n");
            let toolpath = run(&format!("{head}{naming} X{x} Y{y} Z{z}\nG1 F100 X{x} Y{y} Z{z}\nG0 X{x}"));
            let moved: f64 = toolpath.segments.iter().skip(1).map(|segment| segment.length).sum();
            assert!(moved < 1e-9, "{head}{naming}: {moved} mm");
        }
    }
}

#[test]
fn polar_points_lie_at_their_radius_and_angle() {
    let ends = |text: &str| -> Vec<[f64; 2]> {
        let rounded = |value: f64| (1e6 * value).round() / 1e6 + 0.0;
        run_well(text)
            .segments
            .iter()
            .map(|segment| [rounded(segment.end.x), rounded(segment.end.y)])
            .collect()
    };
    let (cos, sin) = (60f64.to_radians().cos(), 60f64.to_radians().sin());
    let six = |value: f64| (1e6 * value).round() / 1e6;
    assert_eq!(
        ends("G16\nG0 X10 Y0\nY90\nX20\nG15\nX1 Y1"),
        [[10.0, 0.0], [0.0, 10.0], [0.0, 20.0], [1.0, 1.0]]
    );
    assert_eq!(ends("G16 G0 X10 Y30\nG91 Y60\nY90"), [[six(10.0 * sin), 5.0], [0.0, 10.0], [-10.0, 0.0]]);
    // A radius under G91 starts from where the tool is.
    assert_eq!(
        ends("G0 X5\nG16 G91 X10 Y60\nX10 Y-60"),
        [[5.0, 0.0], [10.0, six(10.0 * sin)], [20.0, six(10.0 * sin)]]
    );
    assert_eq!(ends("G52 X5 Y5\nG16 G0 X2 Y90"), [[5.0, 7.0]]);
    assert_eq!(ends("G20 G16 G0 X1 Y60"), [[six(25.4 * cos), six(25.4 * sin)]]);
}

#[test]
fn a_block_of_inverse_time_lasts_its_time() {
    let machine = Machine::default();
    let text = "G93\nG1 X30 F2\nG2 X40 Y10 I0 J10 F4\nG1 X41 A30 F3\nA90 F2\nG0 X0 Y0";
    let toolpath = run_well(text);
    let times: Vec<f64> =
        toolpath.segments.iter().map(|segment| segment.length / feedrate(&segment)).collect();
    for (time, per_minute) in times.iter().zip([2.0, 4.0, 3.0]) {
        assert!((time - 60.0 / per_minute).abs() < 1e-9, "{times:?}");
    }
    let StopCause::Rotary { rotation, rate: Some(rate) } = toolpath.stops[0].cause else { panic!("a turn") };
    assert!((limits::rotary_time(&rotation, Some(rate), &machine) - 30.0).abs() < 1e-9);
    let missing = run("G93 G1 X10 F2\nX20");
    assert_eq!(missing.diagnostics.len(), 1);
    assert!((missing.segments.length(1) / feedrate(&missing.segments.at(1)) - 30.0).abs() < 1e-9);
}

#[test]
fn feed_per_revolution_is_that_per_minute_times_the_speed() {
    let moves = random_moves(&mut Random(8), 50).replace("F1200", "");
    let per_minute = run_well(&format!("G94 F300\n{moves}"));
    for text in
        ["G95 F0.25 S1200", "S1200\nG95 F.25", "S1200 G20\nG95 F[0.25/25.4]\nG21", "G95 F.25 S7\nS1200"]
    {
        let per_revolution = run_well(&format!("{text}\n{moves}"));
        for (a, b) in per_minute.segments.iter().zip(&per_revolution.segments) {
            let is_same = match a.motion.is_rapid() {
                true => b.motion.is_rapid(),
                false => (feedrate(&a) - feedrate(&b)).abs() < 1e-9 * feedrate(&a),
            };
            assert!(is_same && a.end == b.end, "{text}: {a:?} {b:?}");
        }
    }
    let back = run("F300 S100\nG95 F2\nG94\nG1 X1");
    assert_eq!(feedrate(&back.segments.at(0)), 5.0, "the former F of G94 is taken");
    assert_eq!(back.diagnostics[0].severity, Severity::Error, "and said, as controls forget it");
}

#[test]
fn rapids_keep_each_axis_within_its_own_limit() {
    let mut machine = Machine::default();
    for (axis, velocity) in machine.axes.iter_mut().zip([150.0, 90.0, 40.0]) {
        axis.velocity = velocity;
    }
    let mut random = Random(41);
    for _ in 0..500 {
        let [x, y, z] = [random.coordinate(), random.coordinate(), random.coordinate()];
        let toolpath = run_on(&format!("G0 X{x} Y{y} Z{z}"), &machine);
        let segment = toolpath.segments.at(0);
        let time = segment.length / limits::requested_feedrate(&segment, &machine);
        let needs =
            [x.abs() / 150.0, y.abs() / 90.0, z.abs() / 40.0, segment.length / machine.rapid.feedrate];
        let longest = needs.into_iter().fold(0.0, f64::max);
        assert!((time - longest).abs() < 1e-12 * longest, "{segment:?}: {time} s, {longest} s");
    }
}

#[test]
fn rotary_axes_keep_their_limits() {
    let mut machine = Machine::default();
    machine.rotary_axes[1].velocity = 90f64.to_radians();
    machine.rapid.rotary_rate = 45f64.to_radians();
    let time = |text: &str| {
        let toolpath = run_on(text, &machine);
        match (toolpath.segments.first(), toolpath.stops.first()) {
            (Some(segment), _) => segment.length / limits::requested_feedrate(&segment, &machine),
            (None, Some(stop)) => match stop.cause {
                StopCause::Rotary { rotation, rate } => limits::rotary_time(&rotation, rate, &machine),
                _ => panic!("{text}: not a turn"),
            },
            (None, None) => 0.0,
        }
    };
    let cases = [
        ("G1 F600 X10 A720", 1.0),
        ("G1 F600 X10 B720", 8.0),
        ("G0 X10 A90", 2.0),
        ("G0 X400 A45", 2.0),
        ("G1 F600 A20", 2.0),
        ("G1 F6e5 B180", 2.0),
        ("G1 F600 A30 C40", 5.0),
        ("G0 A30 C90", 2.0),
        ("G20 G1 F60 A20", 20.0),
        ("G95 F1 S60 G1 A20", 20.0),
    ];
    for (text, expected) in cases {
        let text = text.replace("6e5", "600000");
        assert!((time(&text) - expected).abs() < 1e-9, "{text}: {} s, not {expected} s", time(&text));
    }
}

#[test]
fn a_chain_of_turns_costs_its_time_and_the_filters_once() {
    let mut machine = Machine::default();
    machine.interpolator.time_constants = TimeConstants::Equal(0.02);
    let time = |text: &str| plan_of(&run_on(text, &machine), &machine).cycle_time();
    assert!((time("G1 F600 A20") - 2.06).abs() < 1e-12);
    assert!((time("G1 F600 A20\nA40\nA60") - 6.06).abs() < 1e-12);
    assert!((time("G1 F600 A20\nM3\nA60") - 6.12).abs() < 1e-12);
    let moved = time("G1 F600 X20");
    assert!((time("G1 F600 X20\nA20\nX40") - 2.0 * moved - 2.06).abs() < 1e-12);
}
