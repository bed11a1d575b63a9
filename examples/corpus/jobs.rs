//! Jobs as shops have them, as moves of the tool tip in mm, mm/min and s.

use std::f64::consts::{PI, TAU};

/// A point in program coordinates, mm.
pub type Point = [f64; 3];

/// One thing a program tells the machine.
#[derive(Clone, Debug)]
pub enum Move {
    /// Changes the tool; the spindle turns at `rpm` after it.
    Tool {
        number: u32,
        rpm: u32,
        name: &'static str,
    },
    Rapid(Point),
    Line {
        end: Point,
        feed: f64,
    },
    /// An arc in the XY plane, a helix where the height changes.
    Arc {
        end: Point,
        centre: [f64; 2],
        clockwise: bool,
        feed: f64,
    },
    /// A hole from 2 mm above `top`; with pecks of `peck` mm, or in one go if it is 0.
    Hole {
        at: [f64; 2],
        top: f64,
        bottom: f64,
        peck: f64,
        feed: f64,
    },
    Dwell {
        seconds: f64,
    },
}

/// Marsaglia's xorshift.
struct Random(u64);

impl Random {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        low + (high - low) * (self.0 >> 11) as f64 / 53f64.exp2()
    }

    /// A feedrate in steps of 10 mm/min.
    fn feed(&mut self, low: f64, high: f64) -> f64 {
        10.0 * (self.between(low, high) / 10.0).round()
    }
}

/// Rounds a length to the micrometre that programs are written in.
fn rounded(mm: f64) -> f64 {
    (mm * 1e3).round() / 1e3
}

fn point(x: f64, y: f64, z: f64) -> Point {
    [rounded(x), rounded(y), rounded(z)]
}

/// The height above which rapids are safe, mm.
const CLEARANCE_MM: f64 = 5.0;

/// Every kind of job with its moves.
pub fn all(seed: u64) -> Vec<(&'static str, Vec<Move>)> {
    let draw = |job: fn(&mut Random) -> Vec<Move>, stream: u64| {
        let mut random = Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(stream) | 1);
        // The first numbers of neighbouring seeds are alike.
        for _ in 0..8 {
            random.between(0.0, 1.0);
        }
        job(&mut random)
    };
    vec![
        ("finishing", draw(finishing, 2)),
        ("spiral", draw(spiral, 4)),
        ("pocket", draw(pocket, 6)),
        ("trochoid", draw(trochoid, 8)),
        ("roughing", draw(roughing, 10)),
        ("engraving", draw(engraving, 12)),
        ("drilling", draw(drilling, 14)),
    ]
}

/// Moves above a point and down to it.
fn approach(moves: &mut Vec<Move>, start: Point, plunge: f64) {
    moves.push(Move::Rapid([start[0], start[1], CLEARANCE_MM]));
    moves.push(Move::Line { end: start, feed: plunge });
}

fn retract(moves: &mut Vec<Move>) {
    let end = moves.iter().rev().find_map(end_of).expect("a tool has moved");
    moves.push(Move::Rapid([end[0], end[1], CLEARANCE_MM]));
}

fn end_of(told: &Move) -> Option<Point> {
    match told {
        Move::Rapid(end) | Move::Line { end, .. } | Move::Arc { end, .. } => Some(*end),
        _ => None,
    }
}

/// A wavy surface, finished to and fro in short chords as CAM writes them.
fn finishing(random: &mut Random) -> Vec<Move> {
    let (width, depth) = (random.between(50.0, 70.0), random.between(25.0, 35.0));
    let (wave_x, wave_y, height) =
        (random.between(15.0, 30.0), random.between(15.0, 30.0), random.between(2.0, 5.0));
    let (feed, chord, rows) = (random.feed(2000.0, 5000.0), random.between(0.4, 0.8), 26);
    let surface =
        |x: f64, y: f64| -height + 0.5 * height * ((TAU * x / wave_x).sin() * (TAU * y / wave_y).cos() - 1.0);
    let mut moves = vec![Move::Tool { number: 1, rpm: 18_000, name: "BALL D6" }];
    for row in 0..rows {
        let y = depth * f64::from(row) / f64::from(rows - 1);
        let steps = (width / chord) as usize;
        for step in 0..=steps {
            let along = width * step as f64 / steps as f64;
            let x = if row % 2 == 0 { along } else { width - along };
            let end = point(x, y, surface(x, y));
            match (row, step) {
                (0, 0) => approach(&mut moves, end, 600.0),
                _ => moves.push(Move::Line { end, feed }),
            }
        }
    }
    retract(&mut moves);
    moves
}

/// A dome, finished along a spiral of chords.
fn spiral(random: &mut Random) -> Vec<Move> {
    let (radius, pitch, chord) =
        (random.between(15.0, 25.0), random.between(0.5, 0.9), random.between(0.5, 0.9));
    let feed = random.feed(1500.0, 4000.0);
    let mut moves = vec![Move::Tool { number: 2, rpm: 16_000, name: "BALL D8" }];
    let mut angle = 0.0f64;
    approach(&mut moves, point(0.0, 0.0, 0.0), 500.0);
    while angle * pitch / TAU < radius {
        let r = angle * pitch / TAU;
        angle += (chord / r.max(chord)).min(0.8);
        let r = angle * pitch / TAU;
        moves.push(Move::Line {
            end: point(r * angle.cos(), r * angle.sin(), -(r * r) / (3.0 * radius)),
            feed,
        });
    }
    retract(&mut moves);
    moves
}

/// A rectangular pocket from the inside out, with rounded corners, in several depths.
fn pocket(random: &mut Random) -> Vec<Move> {
    let (length, width, corner) =
        (random.between(60.0, 90.0), random.between(40.0, 55.0), random.between(6.0, 9.0));
    let (feed, step, levels) = (random.feed(1200.0, 3000.0), random.between(2.0, 3.0), 30);
    let mut moves = vec![Move::Tool { number: 3, rpm: 12_000, name: "FLAT D10" }];
    for level in 1..=levels {
        let z = rounded(-0.5 * f64::from(level));
        let rings = (0.5 * width / step) as usize;
        for ring in 0..rings {
            let inset = step * (rings - 1 - ring) as f64;
            let (a, b) = (0.5 * length - inset, 0.5 * width - inset);
            let r = rounded((corner - 0.5 * inset).clamp(0.5, 0.9 * a.min(b)));
            let (a, b) = (rounded(a), rounded(b));
            let start = [0.0, -b, z];
            match ring {
                0 => approach(&mut moves, start, 400.0),
                _ => moves.push(Move::Line { end: start, feed }),
            }
            let corners = [(1.0, -1.0), (1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0)];
            for (quadrant, (sx, sy)) in corners.into_iter().enumerate() {
                let centre = [sx * (a - r), sy * (b - r)];
                let ends = [[centre[0], sy * b], [sx * a, centre[1]]];
                let [from, to] = if quadrant % 2 == 0 { ends } else { [ends[1], ends[0]] };
                moves.push(Move::Line { end: point(from[0], from[1], z), feed });
                moves.push(Move::Arc { end: point(to[0], to[1], z), centre, clockwise: false, feed });
            }
            moves.push(Move::Line { end: start, feed });
        }
        retract(&mut moves);
    }
    moves
}

/// A slot in circles that move on a little each time.
fn trochoid(random: &mut Random) -> Vec<Move> {
    let (radius, step) = (rounded(random.between(2.5, 4.0)), rounded(random.between(0.4, 0.7)));
    let (feed, length) = (random.feed(2000.0, 4500.0), random.between(90.0, 110.0));
    let mut moves = vec![Move::Tool { number: 4, rpm: 15_000, name: "FLAT D8" }];
    for level in 1..=8 {
        let z = rounded(-2.0 * f64::from(level));
        approach(&mut moves, point(0.0, -radius, z), 300.0);
        let turns = (length / step) as usize;
        for turn in 0..turns {
            let x = rounded(step * turn as f64);
            moves.push(Move::Arc { end: point(x, radius, z), centre: [x, 0.0], clockwise: false, feed });
            moves.push(Move::Arc { end: point(x, -radius, z), centre: [x, 0.0], clockwise: false, feed });
            moves.push(Move::Line { end: point(x + step, -radius, z), feed });
        }
        retract(&mut moves);
    }
    moves
}

/// Long parallel passes joined by half circles, with a helix into each depth.
fn roughing(random: &mut Random) -> Vec<Move> {
    let (length, step, feed) =
        (random.between(80.0, 140.0), random.between(5.0, 8.0), random.feed(1500.0, 4000.0));
    let (length, step) = (rounded(length), 2.0 * rounded(0.5 * step));
    let mut moves = vec![Move::Tool { number: 5, rpm: 9_000, name: "FLAT D16" }];
    for level in 1..=60 {
        let z = rounded(-f64::from(level));
        let above = rounded(z + 1.0);
        moves.push(Move::Rapid([0.0, 0.0, CLEARANCE_MM]));
        moves.push(Move::Line { end: [0.0, 0.0, above], feed: 800.0 });
        moves.push(Move::Arc {
            end: [8.0, 0.0, rounded(z + 0.5)],
            centre: [4.0, 0.0],
            clockwise: false,
            feed: 600.0,
        });
        moves.push(Move::Arc { end: [0.0, 0.0, z], centre: [4.0, 0.0], clockwise: false, feed: 600.0 });
        for pass in 0..18 {
            let y = rounded(step * f64::from(pass));
            let (x, clockwise) = if pass % 2 == 0 { (length, false) } else { (0.0, true) };
            moves.push(Move::Line { end: point(x, y, z), feed });
            let centre = [x, rounded(y + 0.5 * step)];
            moves.push(Move::Arc { end: point(x, y + step, z), centre, clockwise, feed });
        }
        retract(&mut moves);
    }
    moves
}

/// Strokes like those of letters: short curves with many lifts.
fn engraving(random: &mut Random) -> Vec<Move> {
    let feed = random.feed(600.0, 1500.0);
    let mut moves = vec![Move::Tool { number: 6, rpm: 24_000, name: "V BIT 60" }];
    for letter in 0..90 {
        let (column, row) = (f64::from(letter % 15), f64::from(letter / 15));
        let (x0, y0) = (7.0 * column, 10.0 * row);
        for _ in 0..2 {
            let (mut x, mut y) = (x0 + random.between(0.0, 4.0), y0 + random.between(0.0, 7.0));
            let (mut heading, bend) = (random.between(0.0, TAU), random.between(-0.5, 0.5));
            approach(&mut moves, point(x, y, -0.2), 200.0);
            for _ in 0..14 {
                heading += if random.between(0.0, 1.0) < 0.1 { random.between(-PI, PI) } else { bend };
                (x, y) = (x + 0.35 * heading.cos(), y + 0.35 * heading.sin());
                moves.push(Move::Line { end: point(x, y, -0.2), feed });
            }
            retract(&mut moves);
        }
    }
    moves
}

/// A plate of holes: centred in one go, then drilled with pecks.
fn drilling(random: &mut Random) -> Vec<Move> {
    let (pitch, depth, peck) =
        (random.between(8.0, 12.0), random.between(15.0, 25.0), random.between(3.0, 5.0));
    let (pitch, depth, peck) = (rounded(pitch), rounded(depth), rounded(peck));
    let mut moves = Vec::new();
    let tools = [(7, 6_000, "SPOT D10", -1.5, 0.0, 300.0), (8, 4_500, "DRILL D5", -depth, peck, 450.0)];
    for (number, rpm, name, bottom, peck, feed) in tools {
        moves.push(Move::Tool { number, rpm, name });
        moves.push(Move::Rapid([0.0, 0.0, CLEARANCE_MM]));
        for hole in 0..96 {
            let (column, row) = (hole % 12, hole / 12);
            let column = if row % 2 == 0 { column } else { 11 - column };
            let at = [rounded(pitch * f64::from(column)), rounded(pitch * f64::from(row))];
            moves.push(Move::Hole { at, top: 0.0, bottom, peck, feed });
        }
        moves.push(Move::Dwell { seconds: 0.5 });
    }
    moves
}
