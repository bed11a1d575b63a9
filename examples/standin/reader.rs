//! The stand-in's own reading of G-code: a subset, so that nothing is shared with the tool it judges.
//!
//! Grammar: words of a letter and a number, G0 G1 G2 G3 modal, X Y Z absolute in mm, I J from the
//! arc's start, F in mm/min, G4 with P in seconds, M6 a tool change, M30 the end; any other M-word
//! is a wait of no time; G17 G21 G90 are taken for granted. The generated programs use no more.

use crate::path::{Shape, Vector, between, norm};

/// What one program line asks for.
#[derive(Clone, Debug)]
pub enum Step {
    /// A move at `feed`, mm/s (infinite for a rapid, which has its own).
    Move { line: u32, shape: Shape, rapid: bool, feed: f64 },
    /// The motion stops; a dwell lasts `seconds`, a tool change the machine's time.
    Wait { line: u32, seconds: f64, tool_change: bool },
}

/// Reads the subset; lines count from 1.
pub fn read(text: &str) -> Vec<Step> {
    let mut steps = Vec::new();
    let (mut at, mut feed, mut mode) = ([0.0; 3], 0.0, 0);
    for (line, text) in (1..).zip(text.lines()) {
        let mut to = at;
        let (mut centre, mut pause, mut dwell) = ([0.0; 2], 0.0, false);
        let (mut moved, mut wait) = (false, None);
        for word in text.split_whitespace() {
            let Some((Ok(value), letter)) = word.get(1..).map(|n| (n.parse::<f64>(), &word[..1])) else {
                continue;
            };
            match letter {
                "G" if value < 3.5 => mode = value as u32,
                "G" => dwell |= value == 4.0,
                "X" | "Y" | "Z" => {
                    to["XYZ".find(letter).expect("one of the three")] = value;
                    moved = true;
                }
                "I" => centre[0] = value,
                "J" => centre[1] = value,
                "F" => feed = value / 60.0,
                "P" => pause = value,
                "M" => wait = Some(value == 6.0),
                _ => {}
            }
        }
        if let Some(tool_change) = wait {
            steps.push(Step::Wait { line, seconds: 0.0, tool_change });
        } else if dwell {
            steps.push(Step::Wait { line, seconds: pause, tool_change: false });
        } else if moved {
            let shape = if mode < 2 { Shape::Line { from: at, to } } else { arc(at, to, centre, mode == 3) };
            if 1e-9 < shape.length() {
                steps.push(Step::Move { line, shape, rapid: mode == 0, feed });
            }
            at = to;
        }
    }
    steps
}

fn arc(from: Vector, to: Vector, offset: [f64; 2], counter: bool) -> Shape {
    let centre = [from[0] + offset[0], from[1] + offset[1], from[2]];
    let angle = |p: Vector| (p[1] - centre[1]).atan2(p[0] - centre[0]);
    let turn = std::f64::consts::TAU;
    let mut sweep = (angle(to) - angle(from)).rem_euclid(turn);
    if norm(between([from[0], from[1], 0.0], [to[0], to[1], 0.0])) < 1e-6 || sweep < 1e-9 {
        sweep = turn;
    }
    if !counter && sweep < turn {
        sweep -= turn;
    } else if !counter {
        sweep = -turn;
    }
    Shape::Arc {
        centre,
        radius: offset[0].hypot(offset[1]),
        start: angle(from),
        sweep,
        rise: to[2] - from[2],
    }
}
