//! Coordinates, inverse time and rotary axes against LinuxCNC's own interpreter, where its command
//! `rs274` (Debian package linuxcnc-uspace) is installed.
//!
//! It prints moves in program coordinates p, and beside them the offsets in force, from which
//! m = tool + g5x + R (p + g92). Numbers have four decimals, so that some ten-thousandths of a
//! millimetre are rounding.

use std::io::Write;
use std::process::{Command, Stdio};
use truefeed::machine::Machine;
use truefeed::simulation::gcode::{Dialect, Options, Severity, read_with};
use truefeed::simulation::interpreter::trace;
use truefeed::simulation::toolpath::{Curve, Motion, StopCause};

/// Where a move ends: X, Y, Z in mm, A, B, C in degrees.
type Place = [f64; 6];

/// A move, with its F where it is a feed move, and whether it is an arc.
#[derive(Debug, PartialEq)]
struct Move {
    end: Place,
    feed: Option<f64>,
    is_arc: bool,
}

/// The moves LinuxCNC makes of a program; none where it is not installed.
fn by_linuxcnc(text: &str, name: &str) -> Option<Vec<Move>> {
    let path = std::env::temp_dir().join(format!("truefeed-{}-{name}.ngc", std::process::id()));
    let mut file = std::fs::File::create(&path).expect("a writable folder");
    file.write_all(text.as_bytes()).expect("a writable file");
    let output = Command::new("rs274").arg("-g").arg(&path).stdin(Stdio::null()).output();
    std::fs::remove_file(&path).expect("the file is ours");
    let output = String::from_utf8(output.ok()?.stdout).expect("it prints ASCII");
    assert!(output.contains("PROGRAM_END"), "LinuxCNC refuses {text}");
    let (mut g5x, mut g92, mut tool, mut degrees, mut feed) = ([0.0; 6], [0.0; 6], [0.0; 6], 0.0f64, 0.0);
    let (mut last, mut moves) = ([0.0; 6], Vec::new());
    for line in output.lines() {
        let Some((head, numbers)) = line.split_once('(') else { continue };
        let numbers = numbers.split(')').next().unwrap_or_default().split([',', ' ']);
        let numbers: Vec<f64> = numbers.filter_map(|number| number.parse().ok()).collect();
        let six = |from: usize| -> Place { numbers[from..from + 6].try_into().expect("six axes") };
        let machine = |program: Place| -> Place {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let shifted: Place = std::array::from_fn(|axis| program[axis] + g92[axis]);
            let mut turned = shifted;
            turned[0] = cos * shifted[0] - sin * shifted[1];
            turned[1] = sin * shifted[0] + cos * shifted[1];
            std::array::from_fn(|axis| turned[axis] + g5x[axis] + tool[axis])
        };
        match head.split_whitespace().last().unwrap_or_default() {
            "SET_G5X_OFFSET" => g5x = six(1),
            "SET_G92_OFFSET" => g92 = six(0),
            "USE_TOOL_LENGTH_OFFSET" => tool = six(0),
            "SET_XY_ROTATION" => degrees = numbers[0],
            "SET_FEED_RATE" => feed = numbers[0],
            "STRAIGHT_TRAVERSE" => moves.push(Move { end: machine(six(0)), feed: None, is_arc: false }),
            "STRAIGHT_FEED" => moves.push(Move { end: machine(six(0)), feed: Some(feed), is_arc: false }),
            "ARC_FEED" => {
                let [x, y, z, a, b, c] = [0, 1, 5, 6, 7, 8].map(|index| numbers[index]);
                moves.push(Move { end: machine([x, y, z, a, b, c]), feed: Some(feed), is_arc: true });
            }
            _ => {}
        }
    }
    // What does not move is no move with us.
    moves.retain(|found| {
        let apart = found.end.iter().zip(last).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        last = found.end;
        found.is_arc || 2e-3 < apart
    });
    Some(moves)
}

/// The moves we make of it.
fn by_us(text: &str) -> Vec<Move> {
    let mut machine = Machine::default();
    machine.axes.iter_mut().for_each(|axis| axis.home = Some(0.0));
    let options = Options { dialect: Some(Dialect::LinuxCnc), ..Options::default() };
    let toolpath = trace(&read_with(text.as_bytes(), &options), &machine);
    let errors: Vec<_> =
        toolpath.diagnostics.iter().filter(|found| found.severity == Severity::Error).collect();
    assert!(errors.is_empty(), "{errors:?}");
    let (mut moves, mut at) = (Vec::new(), [0.0; 6]);
    let mut stops = toolpath.stops.iter().peekable();
    for index in 0..=toolpath.segments.len() {
        while let Some(stop) = stops.next_if(|stop| stop.after <= index) {
            if let StopCause::Rotary { rotation, rate } = stop.cause {
                (0..3).for_each(|axis| at[3 + axis] += rotation[axis].to_degrees());
                moves.push(Move { end: at, feed: rate.map(|rate| 60.0 * rate.to_degrees()), is_arc: false });
            }
        }
        let Some(segment) = toolpath.segments.get(index) else { break };
        (0..3).for_each(|axis| at[axis] = segment.end[axis]);
        (0..3).for_each(|axis| at[3 + axis] += segment.rotation[axis].to_degrees());
        let feed = match segment.motion {
            Motion::Rapid { .. } => None,
            Motion::Feed { feedrate } => Some(60.0 * feedrate),
        };
        moves.push(Move { end: at, feed, is_arc: segment.curve != Curve::Line });
    }
    moves
}

/// Whether there is anything to compare with.
#[track_caller]
fn assert_agrees(text: &str, name: &str) -> bool {
    let Some(theirs) = by_linuxcnc(text, name) else {
        eprintln!(
            "skipped: LinuxCNC's interpreter: rs274 is not there; scripts/test --with-linuxcnc installs it"
        );
        return false;
    };
    let ours = by_us(text);
    for (index, (a, b)) in ours.iter().zip(&theirs).enumerate() {
        let apart = a.end.iter().zip(b.end).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let is_same_feed = match (a.feed, b.feed) {
            (Some(a), Some(b)) => (a - b).abs() < 1e-4 * b + 1e-3,
            (a, b) => a == b,
        };
        let is_same = apart < 3e-4 && is_same_feed && a.is_arc == b.is_arc;
        assert!(is_same, "{text}\nmove {index}\nours {a:?}\ntheirs {b:?}");
    }
    assert_eq!(ours.len(), theirs.len(), "{text}\n{ours:?}\n{theirs:?}");
    assert!(!theirs.is_empty(), "{text}");
    true
}

/// Reproducible numbers: Marsaglia's xorshift.
struct Random(u64);

impl Random {
    fn below(&mut self, bound: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % bound as u64) as usize
    }

    /// Uniform in −50 to 50 with two decimals.
    fn coordinate(&mut self) -> f64 {
        (self.below(10_001) as f64 - 5_000.0) / 100.0
    }
}

#[test]
fn coordinates_agree_on_random_programs() {
    let offsets = ["G54", "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3"];
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    for case in 0..40 {
        // The interpreter keeps offsets from run to run: all begin at zero.
        let mut text = String::from("G21 G17 G90 G94 F500 G92.1\n");
        (1..=9).for_each(|n| text += &format!("G10 L2 P{n} X0 Y0 Z0 A0 B0 C0 R0\n"));
        text += "G54\n";
        for _ in 0..40 {
            let [x, y, z, a] = [(); 4].map(|()| random.coordinate());
            let (n, half) = (random.below(10), 1.0 + random.below(2000) as f64 / 100.0);
            // Where the rotation changes under a G92, the interpreter forgets that G92 is turned
            // along and jumps by (1 − R) g92 in its next move: G92.1 comes first.
            text += &match random.below(20) {
                0 => format!("G92.1\nG10 L2 P{n} X{x} Y{y} A{a} R{z}\n"),
                1 => format!("G10 L2 P{n} Z{z}\n"),
                2 => format!("G10 L20 P{n} X{x} Z{z}\n"),
                3 => format!("G92.1\n{}\n", offsets[random.below(9)]),
                4 => format!("G92 X{x} Y{y} A{a}\n"),
                5 => format!("{}\n", ["G92.1", "G92.2", "G92.3"][random.below(3)]),
                6 => format!("G43.1 Z{z}\n"),
                7 => "G49\n".to_string(),
                8 => format!("G91 G1 X{x} A{a} F300\nG90\n"),
                9 => format!("G0 @{half} ^{a}\n"),
                10 => format!("G0 X{x} Y99\nG91 G1 ^{a} F200\nG90\n"),
                19 => format!("G52 X{x} Y{z}\nG0 X{y} Y{x}\nG92.1\nG52 X0 Y0\n"),
                18 => format!("G53 G0 X{x} A{a}\n"),
                11 => format!("G91 G2 X{half} Y{half} I{half} F400\nG90 G1\n"),
                12 => format!("G91 G3 X{half} R{half} Z1 F400\nG90 G1\n"),
                13 => format!("G93 G1 X{x} Y{y} F{half}\nG94 F100\n"),
                14 => format!("G1 A{a} C{x} F{half}\n"),
                15 => format!("G0 B{a}\n"),
                16 => format!("G91.1 G90 G0 Y{x} A{a}\n"),
                _ => format!("G0 X{x} Y{y} Z{z}\n"),
            };
        }
        text += "G0 X1 Y2 Z3 A4\nM2\n";
        if !assert_agrees(&text, &format!("frames-{case}")) {
            return;
        }
    }
}
