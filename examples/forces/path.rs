//! The open pocket of Sect. 4.3 as a program: trochoidal lanes along three sides, then a pass along the
//! walls.
//!
//! The pocket is 40 mm along X, 60 mm along Y and open at Y0; its zero lies in the open corner on top.

use std::f64::consts::TAU;
use std::fmt::Write;

/// What the paper does not give.
#[derive(Clone, Copy, Debug)]
pub struct Choice {
    /// Depth of cut along the axis, mm.
    pub depth: f64,
    /// Speed of the spindle, rpm.
    pub speed: f64,
    /// Radius of the loops, mm.
    pub loops: f64,
    /// Way on from loop to loop, mm.
    pub pitch: f64,
    /// Turn from chord to chord in the loops, degrees.
    pub chord: f64,
    /// Left by the loops for the pass along the walls, mm.
    pub allowance: f64,
    /// Radius of the pass in the corners, mm.
    pub corner: f64,
    /// Turn from chord to chord in the corners, degrees.
    pub corner_chord: f64,
    /// The word of the material.
    pub material: &'static str,
}

/// What was chosen.
pub const CHOICE: Choice = Choice {
    depth: 5.0,
    speed: 8000.0,
    loops: 5.0,
    pitch: 1.0,
    chord: 6.0,
    allowance: 1.0,
    corner: 4.0,
    corner_chord: 6.0,
    material: "al7075",
};

/// The pocket, mm.
pub const WIDTH: f64 = 40.0;
pub const LENGTH: f64 = 60.0;
/// The tool, mm.
pub const DIAMETER: f64 = 12.0;
/// Programmed feedrate, mm/min.
pub const FEEDRATE: f64 = 3000.0;

/// A program, and the lines of its sections.
pub struct Part {
    pub program: String,
    /// First and last line of the trochoidal lanes.
    pub trochoid: (u32, u32),
    /// First and last line of the pass along the walls.
    pub corners: (u32, u32),
}

struct Writer {
    program: String,
    lines: u32,
}

impl Writer {
    fn line(&mut self, text: &str) -> u32 {
        writeln!(self.program, "{text}").expect("writing to a string cannot fail");
        self.lines += 1;
        self.lines
    }

    fn to(&mut self, x: f64, y: f64) -> u32 {
        self.line(&format!("X{x:.4} Y{y:.4}"))
    }

    /// Goes outside of the stock, down, and on in feed moves.
    fn begin(&mut self, x: f64, y: f64, depth: f64) -> u32 {
        self.line("G0 Z5");
        self.line(&format!("G0 X{x:.4} Y{y:.4}"));
        self.line(&format!("G0 Z{:.4}", -depth));
        self.line(&format!("G1 F{FEEDRATE:.0}"))
    }
}

/// The program of a choice.
pub fn part(choice: &Choice) -> Part {
    let mut out = Writer { program: String::new(), lines: 0 };
    let radius = 0.5 * DIAMETER;
    out.line("G21 G17 G90 G94");
    out.line("T1 M6");
    out.line(&format!("S{:.0} M3", choice.speed));
    out.line("(TROCHOID)");
    // Up the left side, across along the end and down the right side, so that no strip is left. Loops turn against the clock, so that their front climbs.
    let reach = choice.loops + radius;
    let edge = reach + choice.allowance;
    let ends = [
        (edge, -reach - choice.pitch),
        (edge, LENGTH - edge),
        (WIDTH - edge, LENGTH - edge),
        (WIDTH - edge, -reach - choice.pitch),
    ];
    let mut trochoid = (out.begin(ends[0].0 + choice.loops, ends[0].1, choice.depth), 0);
    let chords = (360.0 / choice.chord).round();
    let mut chord = 0.0;
    for pair in ends.windows(2) {
        let ((x, y), (dx, dy)) = (pair[0], (pair[1].0 - pair[0].0, pair[1].1 - pair[0].1));
        let count = (dx.hypot(dy) / choice.pitch * chords).round();
        for step in 1..=count as usize {
            let share = step as f64 / count;
            chord += 1.0;
            let (sin, cos) = (TAU * chord / chords).sin_cos();
            trochoid.1 = out.to(x + share * dx + choice.loops * cos, y + share * dy + choice.loops * sin);
        }
    }
    out.line("(WALLS)");
    // Up along the right wall, across and down along the left one: the wall lies on the right.
    let (left, right, end) = (radius, WIDTH - radius, LENGTH - radius);
    let first = out.begin(right, -radius - 2.0, choice.depth);
    let mut last = out.to(right, end - choice.corner);
    for (x, y, from) in [(right, end, 0.0), (left, end, 90.0)] {
        let center = [x + if from == 0.0 { -choice.corner } else { choice.corner }, y - choice.corner];
        let chords = (90.0 / choice.corner_chord).round();
        for chord in 1..=chords as usize {
            let angle = f64::to_radians(from + 90.0 * chord as f64 / chords);
            last = out.to(center[0] + choice.corner * angle.cos(), center[1] + choice.corner * angle.sin());
        }
        if from == 0.0 {
            last = out.to(left + choice.corner, end);
        }
    }
    out.to(left, -radius - 2.0);
    out.line("G0 Z5");
    out.line("M30");
    Part { program: out.program, trochoid, corners: (first, last) }
}
