//! The programs on which speed is measured: generated, never stored, and the same on every computer.
//!
//! Each generator writes at least the requested number of lines of moves. A line depends only on its number
//! and the lines before it.

use std::io::Write;

/// A generated program.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Made {
    /// A raster over a wavy surface of 60 mm: G1 blocks of 0.1 to 0.5 mm at F3000 to F8000.
    Finishing,
    /// A raster as in `Finishing`, with every fourth move an arc in the plane of X and Z.
    Arcs,
    /// Rectangles inside each other, level by level, with rapids between them.
    Roughing,
    /// Peck drilling of a grid, 100 holes per tool.
    Cycles,
}

impl Made {
    pub const ALL: [Made; 4] = [Made::Finishing, Made::Arcs, Made::Roughing, Made::Cycles];

    pub fn word(self) -> &'static str {
        match self {
            Made::Finishing => "finishing",
            Made::Arcs => "arcs",
            Made::Roughing => "roughing",
            Made::Cycles => "cycles",
        }
    }

    pub fn from_word(word: &str) -> Option<Made> {
        Made::ALL.into_iter().find(|made| made.word() == word)
    }

    /// Returns a program of at least `lines` lines.
    pub fn text(self, lines: usize) -> Vec<u8> {
        // The capacity suffices for the whole text, so that its growth does not count as memory of the
        // measured work.
        let mut text = Vec::with_capacity(36 * lines + 1000);
        let outcome = match self {
            Made::Finishing => raster(&mut text, lines, false),
            Made::Arcs => raster(&mut text, lines, true),
            Made::Roughing => roughing(&mut text, lines),
            Made::Cycles => cycles(&mut text, lines),
        };
        outcome.expect("text grows");
        text
    }
}

fn raster(text: &mut Vec<u8>, lines: usize, with_arcs: bool) -> std::io::Result<()> {
    writeln!(text, "G90 G17 G21 G91.1\nS12000 M3\nG0 X0 Y0 Z5")?;
    let (mut x, mut y, mut forward) = (0.0f64, 0.0f64, true);
    let mut feedrate = 3000;
    let mut before = (0.0f64, 0.0f64);
    for line in 0..lines {
        let step = 0.3 + 0.18 * (0.7 * line as f64).sin();
        x += if forward { step } else { -step };
        if !(0.0..=60.0).contains(&x) {
            x = x.clamp(0.0, 60.0);
            y += 0.4;
            forward = !forward;
            feedrate = 3000 + (feedrate - 3000 + 1700) % 5001;
        }
        let z = 1.5 * (0.31 * x).sin() * (0.17 * y).cos() + 0.2 * (1.9 * x).sin();
        let chord = (x - before.0).hypot(z - before.1);
        if with_arcs && line % 4 == 3 && 0.1 < chord {
            writeln!(text, "G18 G2 X{x:.3} Z{z:.3} R{:.3} F{feedrate}", 2.0 * chord)?;
        } else {
            writeln!(text, "G1 X{x:.3} Y{y:.3} Z{z:.3} F{feedrate}")?;
        }
        before = (x, z);
    }
    writeln!(text, "G0 Z5\nM30")
}

fn roughing(text: &mut Vec<u8>, lines: usize) -> std::io::Result<()> {
    writeln!(text, "G90 G17 G21\nT1 M6\nS8000 M3")?;
    let (mut level, mut written) = (0, 0);
    while written < lines {
        level += 1;
        writeln!(text, "G0 X0 Y0 Z5\nG1 Z-{:.2} F800", 0.5 * level as f64)?;
        written += 2;
        for ring in (1..=30).rev() {
            let half = 1.7 * ring as f64;
            writeln!(text, "X-{half:.3} Y-{half:.3} F2500\nX{half:.3}\nY{half:.3}\nX-{half:.3}")?;
            writeln!(text, "Y-{:.3}\nG2 X-{:.3} Y-{half:.3} I0.5 J0\nG1", half - 0.5, half - 0.5)?;
            written += 7;
        }
    }
    writeln!(text, "G0 Z5\nM30")
}

fn cycles(text: &mut Vec<u8>, lines: usize) -> std::io::Result<()> {
    writeln!(text, "G90 G17 G21")?;
    for hole in 0..lines {
        if hole % 100 == 0 {
            writeln!(text, "G80\nT{} M6\nS3000 M3\nG0 X0 Y0 Z10", 1 + hole / 100 % 20)?;
            writeln!(text, "G99 G83 X0 Y0 Z-12 R2 Q4 F250")?;
        }
        writeln!(text, "X{:.3} Y{:.3}", 7.5 * (hole % 10) as f64, 7.5 * (hole / 10 % 10) as f64)?;
    }
    writeln!(text, "G80\nM30")
}
