//! Cutter compensation against LinuxCNC's own interpreter.
//!
//! `rs274 -g` (Debian package linuxcnc-uspace) prints the moves it would run, with four decimals
//! of the unit of length in force; where it is not installed the test says so. Programs it
//! refuses are compared up to there. Its tool table is in inch.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use truefeed::machine::{Machine, Tool};
use truefeed::simulation::gcode::{self, Dialect, Options};
use truefeed::simulation::interpreter;
use truefeed::simulation::toolpath::{Curve, Segment, Toolpath};

/// Diameters of tools 1, 2 and 3, mm.
const DIAMETERS: [f64; 3] = [5.08, 6.0, 1.0];

/// A move as LinuxCNC prints it; lengths in mm.
#[derive(Debug)]
struct Canonical {
    is_rapid: bool,
    end: [f64; 3],
    /// Centre in the plane, and the sign of the turn.
    arc: Option<([f64; 2], f64)>,
    plane: [usize; 3],
}

struct Interpreted {
    moves: Vec<Canonical>,
    /// mm in the last digit printed.
    digit: f64,
    has_ended: bool,
    complaint: String,
}

fn interpret(program: &Path, name: &str) -> Option<Interpreted> {
    let folder = std::env::temp_dir().join(format!("truefeed-compensation-{}-{name}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder for the tool table");
    let mut table = String::new();
    for (index, diameter) in DIAMETERS.iter().enumerate() {
        let (number, inches) = (index + 1, diameter / 25.4);
        writeln!(table, "T{number} P{number} D{inches:.10} ;").expect("text grows");
    }
    std::fs::write(folder.join("tool.tbl"), table).expect("a writable folder");
    let run = Command::new("rs274")
        .args(["-g", "-t", "tool.tbl"])
        .arg(program)
        .current_dir(&folder)
        // It keeps its tools in a file there, which all runs of one home would share.
        .env("HOME", &folder)
        .stdin(Stdio::null())
        .output();
    std::fs::remove_dir_all(&folder).expect("our own folder");
    let run = match run {
        Ok(run) => run,
        Err(_) => {
            eprintln!(
                "skipped: LinuxCNC's interpreter: rs274 is not there; scripts/test --with-linuxcnc installs it"
            );
            return None;
        }
    };
    let text = String::from_utf8_lossy(&run.stdout).into_owned();
    let (mut unit, mut digit, mut plane) = (1.0, 1e-4, [0, 1, 2]);
    let mut moves = Vec::new();
    let mut last = [0.0; 3];
    for line in text.lines() {
        let Some((head, rest)) = line.split_once('(') else { continue };
        let word = head.split_whitespace().last().unwrap_or_default();
        let values: Vec<f64> =
            rest.trim_end_matches(')').split(',').filter_map(|value| value.trim().parse().ok()).collect();
        match word {
            "USE_LENGTH_UNITS" if rest.contains("INCHES") => (unit, digit) = (25.4, 25.4e-4),
            "USE_LENGTH_UNITS" => unit = 1.0,
            "SELECT_PLANE" if rest.contains("XZ") => plane = [2, 0, 1],
            "SELECT_PLANE" if rest.contains("YZ") => plane = [1, 2, 0],
            "SELECT_PLANE" => plane = [0, 1, 2],
            "STRAIGHT_TRAVERSE" | "STRAIGHT_FEED" => {
                let end = [values[0] * unit, values[1] * unit, values[2] * unit];
                let is_rapid = word == "STRAIGHT_TRAVERSE";
                if (0..3).any(|axis| digit < (end[axis] - last[axis]).abs()) {
                    moves.push(Canonical { is_rapid, end, arc: None, plane });
                }
                last = end;
            }
            "ARC_FEED" => {
                let mut end = [0.0; 3];
                (end[plane[0]], end[plane[1]]) = (values[0] * unit, values[1] * unit);
                end[plane[2]] = values[5] * unit;
                let center = [values[2] * unit, values[3] * unit];
                moves.push(Canonical { is_rapid: false, end, arc: Some((center, values[4])), plane });
                last = end;
            }
            _ => {}
        }
    }
    let complaint = String::from_utf8_lossy(&run.stderr).replace("executing\n", "");
    Some(Interpreted { moves, digit, has_ended: text.contains("PROGRAM_END"), complaint })
}

fn trace(text: &[u8]) -> Toolpath {
    let mut machine = Machine::default();
    for (number, diameter) in (1..).zip(DIAMETERS) {
        machine.tools.insert(number, Tool { diameter });
    }
    let options = Options { dialect: Some(Dialect::LinuxCnc), ..Options::default() };
    interpreter::trace(&gcode::read_with(text, &options), &machine)
}

/// How the two differ, where they do.
fn difference(toolpath: &Toolpath, expected: &Interpreted) -> Option<String> {
    let digit = expected.digit;
    let found: Vec<_> = toolpath.segments.iter().filter(|segment| digit < segment.length).collect();
    for (index, expected) in expected.moves.iter().enumerate() {
        let Some(segment) = found.get(index) else {
            return Some(format!("move {index} is missing: {expected:?}"));
        };
        let is_rapid = segment.motion.is_rapid();
        let ends = (0..3).all(|axis| (segment.end[axis] - expected.end[axis]).abs() <= 0.51 * digit + 1e-6);
        let arcs = match (&segment.curve, &expected.arc) {
            (Curve::Line, None) => true,
            (Curve::Arc(arc), Some((center, turn))) => {
                let [a, b, _] = expected.plane;
                let sign = (arc.e1[a] * arc.e2[b] - arc.e1[b] * arc.e2[a]).signum();
                let apart = (arc.center[a] - center[0]).abs().max((arc.center[b] - center[1]).abs());
                apart <= 0.51 * digit + 1e-6 && 0.0 < sign * turn
            }
            _ => false,
        };
        if is_rapid != expected.is_rapid || !ends || !arcs {
            return Some(format!("move {index}:\n{segment:?}\nexpected {expected:?}"));
        }
    }
    (expected.has_ended && found.len() != expected.moves.len())
        .then(|| format!("{} moves, expected {}", found.len(), expected.moves.len()))
}

fn programs() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let own = std::fs::read_dir(root.join("tests/data/programs/ngc")).expect("our programs are there");
    let mut programs: Vec<PathBuf> = own.map(|entry| entry.expect("a readable folder").path()).collect();
    programs.retain(|path| path.to_string_lossy().contains("compensation"));
    programs.retain(|path| path.extension().is_some_and(|extension| extension == "ngc"));
    programs.sort();
    assert!(!programs.is_empty(), "the programs of the repository are always there");
    programs.push(root.join("../shared/gcode/linuxcnc/linuxcnc__comp.ngc"));
    programs.retain(|path| path.exists());
    programs
}

#[test]
fn our_programs_run_as_on_linuxcnc() {
    for path in programs() {
        let Some(expected) = interpret(&path, "own") else { return };
        assert!(expected.has_ended, "{}: {}", path.display(), expected.complaint);
        let toolpath = trace(&std::fs::read(&path).expect("a readable file"));
        if let Some(difference) = difference(&toolpath, &expected) {
            panic!("{}: {difference}", path.display());
        }
    }
}

/// xorshift64, uniform from 0 to 1.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }
}

/// A contour of lines and arcs that turns at random, compensated on one side.
fn random_program(seed: u64) -> String {
    let mut random = Random(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1);
    random.unit();
    let is_zx = random.unit() < 0.4;
    let (a, b, c, i, j) = if is_zx { ('Z', 'X', 'Y', 'K', 'I') } else { ('X', 'Y', 'Z', 'I', 'J') };
    let plane = if is_zx { "G18" } else { "G17" };
    let side = if random.unit() < 0.5 { "G41" } else { "G42" };
    let d = 1 + (3.0 * random.unit()) as usize;
    let lead_in = match random.unit() {
        kind if kind < 0.7 => format!("G1 {a}-20 {b}-20"),
        kind if kind < 0.8 => format!("G2 {a}-20 {b}-20 {i}0 {j}10"),
        kind if kind < 0.9 => format!("G3 {a}-20 {b}-20 {i}10 {j}0"),
        _ => format!("G3 {a}-20 {b}-20 R{:.3}", random.between(8.0, 20.0)),
    };
    let mut text = format!("G21 G90 G64 {plane}\nG0 X-30 Y-30 Z-30\nF500\n{side} D{d}\n{lead_in}\n");
    let (mut x, mut y, mut direction) = (-20.0f64, -20.0f64, random.between(-3.0, 3.0));
    for _ in 0..12 {
        direction += random.between(-3.2, 3.2) * if random.unit() < 0.3 { 0.0 } else { 1.0 };
        let turn = if random.unit() < 0.5 { 1.0 } else { -1.0 };
        match random.unit() {
            kind if kind < 0.5 => {
                let length = random.between(1.0, 30.0);
                (x, y) = (x + length * direction.cos(), y + length * direction.sin());
                let g = if random.unit() < 0.1 { "G0" } else { "G1" };
                writeln!(text, "{g} {a}{x:.9} {b}{y:.9}").expect("text grows");
            }
            kind if kind < 0.9 => {
                let (radius, sweep) = (random.between(1.0, 20.0), random.between(0.2, 6.0));
                let (to_x, to_y) = (-turn * direction.sin() * radius, turn * direction.cos() * radius);
                let end = direction + turn * sweep;
                let (center_x, center_y) = (x + to_x, y + to_y);
                (x, y) = (center_x + turn * end.sin() * radius, center_y - turn * end.cos() * radius);
                direction = end;
                let g = if 0.0 < turn { "G3" } else { "G2" };
                writeln!(text, "{g} {a}{x:.9} {b}{y:.9} {i}{to_x:.9} {j}{to_y:.9}").expect("text grows");
            }
            _ => {
                let height = random.between(-5.0, 5.0);
                writeln!(text, "G1 {c}{height:.3}").expect("text grows");
            }
        }
    }
    text += "G40\nG1 X100 Y100 Z100\nM2\n";
    text
}

/// Where we find that the tool does not fit, LinuxCNC refuses, and the other way round; but it does
/// not look at moves before a smooth joint, so that a few gouges escape it.
#[test]
fn random_contours_run_as_on_linuxcnc() {
    let path = std::env::temp_dir().join(format!("truefeed-compensation-{}.ngc", std::process::id()));
    let (mut moves, mut gouging, mut overlooked, mut differing) = (0, 0, 0, Vec::new());
    let count: u64 =
        std::env::var("TRUEFEED_CONTOURS").ok().and_then(|text| text.parse().ok()).unwrap_or(200);
    for seed in 1..=count {
        let text = random_program(seed);
        std::fs::write(&path, &text).expect("a writable folder");
        let Some(mut expected) = interpret(&path, "random") else { return };
        let mut toolpath = trace(text.as_bytes());
        let gouges = toolpath.diagnostics.iter().filter(|found| found.message.starts_with("gouge"));
        if let Some(first) = gouges.map(|found| found.line.0).min() {
            gouging += 1;
            overlooked += usize::from(expected.has_ended);
            let digit = expected.digit;
            // It may change the end of the last move in the plane before it.
            let normal = if text.contains("G18") { 1 } else { 2 };
            let is_before = |segment: &Segment| {
                let mut way = segment.end - segment.start;
                way[normal] = 0.0;
                segment.line.0 < first && digit < way.norm()
            };
            let changed = toolpath.segments.iter().rfind(is_before).map_or(0, |segment| segment.line.0);
            toolpath.segments = toolpath.segments.iter().filter(|segment| segment.line.0 < changed).collect();
            let before = toolpath.segments.iter().filter(|segment| digit < segment.length).count();
            expected.moves.truncate(before);
        } else if !expected.has_ended {
            differing.push(format!("seed {seed}\n{text}refused: {}", expected.complaint));
        }
        if let Some(difference) = difference(&toolpath, &expected) {
            differing.push(format!("seed {seed}\n{text}{difference}\n{}", expected.complaint));
        }
        moves += expected.moves.len();
    }
    std::fs::remove_file(&path).expect("our own file");
    assert!(overlooked <= gouging / 10, "{overlooked} of {gouging}");
    println!(
        "{moves} moves agree; {gouging} of {count} contours gouge, {overlooked} of them unnoticed by rs274"
    );
    let first = differing.first().cloned().unwrap_or_default();
    assert!(differing.is_empty(), "{} of {count} differ, the first:\n{first}", differing.len());
}
