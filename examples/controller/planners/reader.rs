//! Programs as the factory writes them, as straight blocks and waits.

use std::f64::consts::TAU;

use crate::Refusal;

/// A straight block.
#[derive(Clone, Debug)]
pub struct Block {
    pub from: [f64; 3],
    pub length: f64,
    pub direction: [f64; 3],
    /// The programmed feedrate, mm/s; `None` for a rapid at the rate of the machine.
    pub feed: Option<f64>,
    pub line: i64,
}

impl Block {
    /// The point `done` mm behind its start.
    pub fn point(&self, done: f64) -> [f64; 3] {
        std::array::from_fn(|axis| self.from[axis] + done * self.direction[axis])
    }

    /// The largest value along the block that keeps each axis within its own.
    pub fn along(&self, by_axis: &[f64; 3]) -> f64 {
        limit_along(&self.direction, by_axis)
    }
}

/// The largest value along `direction` that keeps each axis within its own.
pub fn limit_along(direction: &[f64; 3], by_axis: &[f64; 3]) -> f64 {
    let of = |axis: usize| by_axis[axis] / direction[axis].abs();
    (0..3).filter(|axis| direction[*axis] != 0.0).map(of).fold(f64::INFINITY, f64::min)
}

/// One thing that the program tells the control.
#[derive(Clone, Debug)]
pub enum Item {
    Move(Block),
    /// The motion ends, then rests, s.
    Rest {
        seconds: f64,
        line: i64,
    },
}

/// The blocks that a planner knows when it runs item `number`: at most `look_ahead`, up to the next rest.
pub fn known(items: &[Item], number: usize, look_ahead: usize) -> Vec<&Block> {
    let known = items[number..].iter().take(look_ahead);
    known
        .map_while(|item| match item {
            Item::Move(block) => Some(block),
            Item::Rest { .. } => None,
        })
        .collect()
}

/// How a control reads a program.
pub struct Reading {
    /// How many chords an arc of a radius (mm), an angle (rad) and a length (mm) has.
    pub chords: fn(f64, f64, f64) -> f64,
    /// Positions are whole numbers of this, mm, if at all.
    pub step: Option<f64>,
    /// Whether G0 runs at the feedrate in force.
    pub rapids_have_feed: bool,
    /// The unit of the time of G4, s.
    pub dwell_unit: f64,
    /// Whether a new state of spindle or coolant waits until the motion has ended; if not, only M5 does.
    pub spindle_waits: bool,
}

/// What holds from line to line.
struct Modal {
    at: [f64; 3],
    scale: f64,
    motion: i64,
    feed: f64,
    speed: f64,
    spindle: i64,
    /// The last word of the coolant, M7 to M9.
    coolant: i64,
}

/// Returns the blocks and waits of a program.
pub fn read(text: &str, how: &Reading) -> Result<Vec<Item>, Refusal> {
    let mut modal =
        Modal { at: [0.0; 3], scale: 1.0, motion: 0, feed: 0.0, speed: 0.0, spindle: 5, coolant: 9 };
    let mut items = Vec::new();
    for (line, source) in (1..).zip(text.lines()) {
        let words = words(source).map_err(|why| format!("line {line}: {why}"))?;
        modal.obeys(&words, line, how, &mut items).map_err(|why| format!("line {line}: {why}"))?;
    }
    Ok(items)
}

fn words(line: &str) -> Result<Vec<(char, f64)>, Refusal> {
    let mut words = Vec::new();
    let mut rest = line.split(';').next().unwrap_or_default().trim();
    while let Some(letter) = rest.chars().next() {
        if letter == '(' {
            rest = rest.split_once(')').ok_or("a comment has no end")?.1.trim_start();
            continue;
        }
        let number = rest[letter.len_utf8()..].trim_start();
        let end = number.find(|c: char| !"+-.0123456789".contains(c)).unwrap_or(number.len());
        words.push((letter, number[..end].parse().map_err(|_| format!("{letter} has no number"))?));
        rest = number[end..].trim_start();
    }
    Ok(words)
}

impl Modal {
    fn obeys(
        &mut self,
        words: &[(char, f64)],
        line: i64,
        how: &Reading,
        items: &mut Vec<Item>,
    ) -> Result<(), Refusal> {
        let of = |letter: char| words.iter().find(|word| word.0 == letter).map(|word| word.1);
        let (mut spindle, mut coolant, mut dwells) = (self.spindle, self.coolant, false);
        for (letter, value) in words {
            match (letter, *value as i64) {
                ('G', 20) => self.scale = 25.4,
                ('G', 21) => self.scale = 1.0,
                ('G', 4) => dwells = true,
                ('G', motion @ 0..=3) => self.motion = motion,
                ('G', 17 | 40 | 49 | 80 | 90 | 94) | ('N', _) | ('M', 2 | 30) => {}
                ('F', _) => self.feed = value * self.scale / 60.0,
                ('M', word @ 3..=5) => spindle = word,
                ('M', word @ 7..=9) => coolant = word,
                ('S' | 'X' | 'Y' | 'Z' | 'I' | 'J' | 'P', _) => {}
                _ => return Err(format!("{letter}{value} means nothing here").into()),
            }
        }
        let speed = of('S').unwrap_or(self.speed);
        let waits = if how.spindle_waits {
            spindle != self.spindle || spindle != 5 && speed != self.speed || coolant != self.coolant
        } else {
            words.contains(&('M', 5.0))
        };
        (self.spindle, self.speed, self.coolant) = (spindle, speed, coolant);
        if waits {
            items.push(Item::Rest { seconds: 0.0, line });
        }
        if dwells {
            items.push(Item::Rest { seconds: how.dwell_unit * of('P').unwrap_or(0.0), line });
            return Ok(());
        }
        if ['X', 'Y', 'Z'].iter().all(|axis| of(*axis).is_none()) {
            return Ok(());
        }
        let mut end = self.at;
        for (axis, letter) in ['X', 'Y', 'Z'].into_iter().enumerate() {
            end[axis] = of(letter).map_or(end[axis], |value| self.scale * value);
        }
        let offset = ['I', 'J'].map(|letter| self.scale * of(letter).unwrap_or(0.0));
        self.moves(end, offset, line, how, items);
        Ok(())
    }

    fn moves(&mut self, end: [f64; 3], offset: [f64; 2], line: i64, how: &Reading, items: &mut Vec<Item>) {
        let feed = (self.motion != 0 || how.rapids_have_feed).then_some(self.feed);
        let start = self.at;
        if self.motion >= 2 {
            let clockwise = self.motion == 2;
            let centre = [start[0] + offset[0], start[1] + offset[1]];
            let angle_of = |point: &[f64; 3]| (point[1] - centre[1]).atan2(point[0] - centre[0]);
            let (radius, begin) = (offset[0].hypot(offset[1]), angle_of(&start));
            let turn = (angle_of(&end) - begin).rem_euclid(TAU);
            let sweep = match (clockwise, turn < 1e-9) {
                (false, true) => TAU,
                (true, true) => -TAU,
                (false, _) => turn,
                (true, _) => turn - TAU,
            };
            let length = (radius * sweep).hypot(end[2] - start[2]);
            let count = (how.chords)(radius, sweep.abs(), length).floor().max(1.0);
            for part in (1..count as usize).map(|number| number as f64 / count) {
                let angle = begin + part * sweep;
                let [x, y] = [centre[0] + radius * angle.cos(), centre[1] + radius * angle.sin()];
                self.straight([x, y, start[2] + part * (end[2] - start[2])], feed, line, how, items);
            }
        }
        self.straight(end, feed, line, how, items);
    }

    fn straight(
        &mut self,
        end: [f64; 3],
        feed: Option<f64>,
        line: i64,
        how: &Reading,
        items: &mut Vec<Item>,
    ) {
        let on_step =
            |point: [f64; 3]| how.step.map_or(point, |step| point.map(|mm| (mm / step).round() * step));
        let (from, to) = (on_step(self.at), on_step(end));
        self.at = end;
        let way: [f64; 3] = std::array::from_fn(|axis| to[axis] - from[axis]);
        let length = way.iter().map(|mm| mm * mm).sum::<f64>().sqrt();
        if length > 1e-9 {
            items.push(Item::Move(Block { from, length, direction: way.map(|mm| mm / length), feed, line }));
        }
    }
}
