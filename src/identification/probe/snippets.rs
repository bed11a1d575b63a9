//! Machine → the bank of snippets: short moves in air, each of which shows some effects and hides others.
//!
//! | snippet | what it distinguishes |
//! |---|---|
//! | star of directions at a ladder of feedrates | axis from path limits; families of ramps by T(Δv) |
//! | corners of many angles, also turned by 45° | tolerance, junction rules, constants of the filters |
//! | corners so slow that no block limits their blends | the override that a control plans them for |
//! | circles of several radii, both ways | centripetal limits, lag, play |
//! | chains of collinear blocks of 0.1 to 1.6 mm | block time (v ∝ L) from look-ahead (v ∝ √L) |
//! | zigzags, one curve at several chord errors | look-ahead, smoothing, minimum feeds |
//! | rapids along one axis, two and three | settings of rapid moves |
//! | M-code in motion, dwells | waits; the recorder's clock from an override |
//! | reversals and sharp stops | play, vibration |
//!
//! Feedrates are parts of the largest feedrate that every axis allows; lengths shrink with it, so that a slow
//! machine takes no longer. Each snippet begins with a rapid to its start and ends with a dwell, so that the
//! dynamics of one do not affect the next.

use std::f64::consts::{FRAC_1_SQRT_2, TAU};
use std::fmt::Write;

use crate::machine::Machine;
use crate::units::mm_per_min;

/// Size of the box of every snippet, mm: X, Y and Z begin at 0.
pub const SNIPPET_SPACE_MM: [f64; 3] = [120.0, 120.0, 20.0];
/// Fastest feedrate, mm/s: 8 m/min.
const MAX_FEEDRATE_MM_S: f64 = 8000.0 / 60.0;
/// Least length factor: below it the rounding of coordinates to 0.1 µm would be visible.
const MIN_LENGTH_FACTOR: f64 = 0.02;
/// Dwell between snippets, s.
const SNIPPET_DWELL_S: f64 = 0.1;

/// A few self-contained lines of G-code.
#[derive(Clone, Debug, PartialEq)]
pub struct Snippet {
    /// Name for people.
    pub name: String,
    /// Lines, each with its line ending.
    pub lines: String,
}

/// Writes the lines of one snippet.
struct SnippetWriter {
    lines: String,
    at: [f64; 3],
    size: f64,
}

impl SnippetWriter {
    fn new(start: [f64; 3], size: f64) -> SnippetWriter {
        let mut writer = SnippetWriter { lines: String::new(), at: start, size };
        let [x, y, z] = start;
        writer.line(&format!("G0 X{} Y{} Z{}", number(x), number(y), number(z)));
        writer
    }

    fn line(&mut self, text: &str) {
        let _ = writeln!(self.lines, "{text}");
    }

    fn feedrate(&mut self, feedrate: f64) {
        self.line(&format!("F{}", number(mm_per_min(feedrate))));
    }

    /// Adds a straight move by a vector, mm at full size.
    fn by(&mut self, code: &str, way: [f64; 3]) {
        for (at, part) in self.at.iter_mut().zip(way) {
            *at += self.size * part;
        }
        let [x, y, z] = self.at;
        self.line(&format!("{code} X{} Y{} Z{}", number(x), number(y), number(z)));
    }

    /// Adds a full circle about a centre at this distance in X, mm at full size.
    fn circle(&mut self, code: &str, centre: f64) {
        let [x, y, _] = self.at;
        self.line(&format!("{code} X{} Y{} I{} J0", number(x), number(y), number(self.size * centre)));
    }

    fn pause(&mut self, seconds: f64) {
        self.line(&format!("G4 P{seconds:.2}"));
    }

    fn done(mut self, name: impl Into<String>) -> Snippet {
        self.pause(SNIPPET_DWELL_S);
        Snippet { name: name.into(), lines: self.lines }
    }
}

/// Formats a coordinate to 0.1 µm, without trailing zeros.
fn number(value: f64) -> String {
    let text = format!("{value:.4}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text.is_empty() || text == "-0" { "0".to_string() } else { text.to_string() }
}

/// Returns the feedrate that every axis allows in every direction, mm/s.
pub fn top(machine: &Machine) -> f64 {
    let axes = machine.axes.iter().map(|axis| axis.velocity);
    axes.fold(machine.rapid.feedrate.min(MAX_FEEDRATE_MM_S), f64::min).max(1e-3)
}

/// Returns all snippets for a machine, in the order of a whole program.
pub fn bank(machine: &Machine) -> Vec<Snippet> {
    let top = top(machine);
    let size = (top / (0.25 * MAX_FEEDRATE_MM_S)).clamp(MIN_LENGTH_FACTOR, 1.0);
    let mut bank = vec![dwells(size)];
    for part in [0.12, 0.4, 1.0] {
        for (name, ways) in DIRECTIONS {
            bank.push(star(name, ways, part * top, size));
        }
    }
    for part in [0.25, 0.8] {
        for turned in [0.0, 45.0] {
            for angles in [[10.0, 20.0, 30.0], [45.0, 60.0, 75.0], [90.0, 120.0, 150.0]] {
                bank.push(corners(&angles, turned, part * top, size));
            }
        }
    }
    bank.push(corners(&[60.0, 90.0, 120.0], 0.0, 0.1 * top, size));
    for radius in [1.0, 3.0, 8.0, 20.0] {
        bank.push(circles(radius, 0.3 * top, size));
        bank.push(circles(radius, top, size));
    }
    for length in [0.1, 0.2, 0.4, 0.8, 1.6] {
        bank.push(chain(length, 0.6 * top, size));
    }
    bank.push(zigzag(0.5, 0.6 * top, size));
    bank.push(zigzag(3.0, 0.6 * top, size));
    for chord in [2e-3, 1e-2, 5e-2] {
        bank.push(curve(chord, 0.5 * top, size));
    }
    for way in [[60.0, 0.0, 0.0], [0.0, 60.0, 0.0], [60.0, 60.0, 0.0], [60.0, 30.0, 15.0], [6.0, 3.0, 0.0]] {
        bank.push(rapids(way, size));
    }
    bank.push(functions(0.6 * top, size));
    bank.push(reversals(0.05 * top, size));
    bank.push(reversals(0.4 * top, size));
    bank
}

/// Rays of the star, mm.
const DIRECTIONS: [(&str, [f64; 3]); 6] = [
    ("along X", [1.0, 0.0, 0.0]),
    ("along Y", [0.0, 1.0, 0.0]),
    ("along Z", [0.0, 0.0, 1.0]),
    ("at 30° in XY", [0.866_025_4, 0.5, 0.0]),
    ("at 45° in XY", [FRAC_1_SQRT_2, FRAC_1_SQRT_2, 0.0]),
    ("at 60° in XY", [0.5, 0.866_025_4, 0.0]),
];

fn star(name: &str, ray: [f64; 3], feedrate: f64, size: f64) -> Snippet {
    let mut writer = SnippetWriter::new([20.0, 20.0, 2.0], size);
    writer.feedrate(feedrate);
    for length in [1.0, 4.0, 15.0] {
        for sign in [1.0, -1.0] {
            writer.by("G1", ray.map(|part| sign * length * part));
        }
    }
    writer.done(format!("star {name}, F{}", number(mm_per_min(feedrate))))
}

fn corners(angles: &[f64], turned: f64, feedrate: f64, size: f64) -> Snippet {
    let mut writer = SnippetWriter::new([60.0, 60.0, 10.0], size);
    writer.feedrate(feedrate);
    for angle in angles {
        // Out, turn to the left, back by the same two directions.
        let ray = |degrees: f64| [8.0 * degrees.to_radians().cos(), 8.0 * degrees.to_radians().sin(), 0.0];
        let (first, second) = (ray(turned), ray(turned + angle));
        writer.by("G1", first);
        writer.by("G1", second);
        writer.by("G1", first.map(|part| -part));
        writer.by("G1", second.map(|part| -part));
    }
    let of: Vec<String> = angles.iter().map(|angle| format!("{angle}°")).collect();
    writer.done(format!("corners of {} turned by {turned}°, F{}", of.join(" "), number(mm_per_min(feedrate))))
}

fn circles(radius: f64, feedrate: f64, size: f64) -> Snippet {
    let mut writer = SnippetWriter::new([60.0, 60.0, 10.0], size);
    writer.feedrate(feedrate);
    writer.by("G1", [0.0, -2.0, 0.0]);
    writer.circle("G2", radius);
    writer.circle("G3", radius);
    writer.done(format!("circles of radius {} mm, F{}", number(size * radius), number(mm_per_min(feedrate))))
}

fn chain(length: f64, feedrate: f64, size: f64) -> Snippet {
    let mut writer = SnippetWriter::new([20.0, 40.0, 10.0], size);
    writer.feedrate(feedrate);
    let count = (16.0 / length).ceil().min(60.0) as usize;
    for _ in 0..count {
        writer.by("G1", [length, 0.0, 0.0]);
    }
    writer.by("G1", [20.0, 0.0, 0.0]);
    writer.done(format!("chain of blocks of {} mm, F{}", number(size * length), number(mm_per_min(feedrate))))
}

fn zigzag(length: f64, feedrate: f64, size: f64) -> Snippet {
    let mut writer = SnippetWriter::new([20.0, 60.0, 10.0], size);
    writer.feedrate(feedrate);
    for at in 0..12 {
        writer.by("G1", [length, if at % 2 == 0 { 0.3 * length } else { -0.3 * length }, 0.0]);
    }
    writer.done(format!("zigzag of {} mm, F{}", number(size * length), number(mm_per_min(feedrate))))
}

/// Returns half a circle of radius 10 mm in chords.
fn curve(chord: f64, feedrate: f64, size: f64) -> Snippet {
    let radius = 10.0;
    let step = 2.0 * (1.0 - chord / radius).acos();
    let count = (0.5 * TAU / step).ceil() as usize;
    let mut writer = SnippetWriter::new([40.0, 60.0, 10.0], size);
    writer.feedrate(feedrate);
    writer.by("G1", [0.0, 5.0, 0.0]);
    for at in 0..count {
        let place = |at: usize| 0.5 * TAU * at as f64 / count as f64;
        let (a, b) = (place(at), place(at + 1));
        writer.by("G1", [radius * (a.cos() - b.cos()), radius * (b.sin() - a.sin()), 0.0]);
    }
    writer.done(format!("curve with a chord error of {} mm", number(size * chord)))
}

fn rapids(way: [f64; 3], size: f64) -> Snippet {
    let mut writer = SnippetWriter::new([20.0, 20.0, 2.0], size);
    writer.pause(SNIPPET_DWELL_S);
    writer.by("G0", way);
    writer.pause(SNIPPET_DWELL_S);
    writer.by("G0", way.map(|part| -part));
    writer.done(format!("rapid of X{} Y{} Z{}", way[0] * size, way[1] * size, way[2] * size))
}

/// Returns coolant on and off in the middle of a straight line, and the same line without them.
fn functions(feedrate: f64, size: f64) -> Snippet {
    let mut writer = SnippetWriter::new([20.0, 80.0, 10.0], size);
    writer.feedrate(feedrate);
    writer.by("G1", [15.0, 0.0, 0.0]);
    writer.line("M8");
    writer.by("G1", [15.0, 0.0, 0.0]);
    writer.line("M9");
    writer.by("G1", [15.0, 0.0, 0.0]);
    writer.by("G1", [15.0, 0.0, 0.0]);
    writer.done("coolant on and off in smooth motion")
}

/// Returns long waits next to a short move: a clock scales both, an override only the move.
fn dwells(size: f64) -> Snippet {
    let mut writer = SnippetWriter::new([20.0, 20.0, 10.0], size);
    writer.pause(2.0);
    writer.by("G0", [5.0, 0.0, 0.0]);
    writer.pause(2.0);
    writer.done("dwells")
}

/// Returns moves of each axis back and forth, with a rest at the turning points.
fn reversals(feedrate: f64, size: f64) -> Snippet {
    let mut writer = SnippetWriter::new([40.0, 40.0, 5.0], size);
    writer.feedrate(feedrate);
    for axis in 0..3 {
        for sign in [1.0, -1.0, 1.0, -1.0] {
            let mut way = [0.0; 3];
            way[axis] = sign * 2.0;
            writer.by("G1", way);
        }
        writer.pause(SNIPPET_DWELL_S);
    }
    writer.done(format!("reversals of each axis, F{}", number(mm_per_min(feedrate))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation::gcode::read;
    use crate::simulation::interpreter::trace;

    #[test]
    fn every_snippet_stays_in_its_space_and_ends_at_rest() {
        let mut slow = Machine::default();
        slow.axes[1].velocity = 2.0;
        for machine in [Machine::default(), slow] {
            for snippet in bank(&machine) {
                let program = format!("G21 G90 G94 G17\n{}", snippet.lines);
                let toolpath = trace(&read(program.as_bytes()), &machine);
                for segment in toolpath.segments.iter() {
                    for axis in 0..3 {
                        let at = segment.end[axis];
                        let space = -1e-9..=SNIPPET_SPACE_MM[axis] + 1e-9;
                        assert!(
                            space.contains(&at),
                            "{}: {at} mm along {}",
                            snippet.name,
                            ["X", "Y", "Z"][axis]
                        );
                    }
                }
                assert!(!toolpath.segments.is_empty() && !toolpath.stops.is_empty(), "{}", snippet.name);
            }
        }
    }

    #[test]
    fn coordinates_have_four_decimals_at_most() {
        let written = [0.0, -0.00001, 12.0, 0.1, 1.0 / 3.0, -2.50001].map(number);
        assert_eq!(written, ["0", "0", "12", "0.1", "0.3333", "-2.5"]);
    }
}
