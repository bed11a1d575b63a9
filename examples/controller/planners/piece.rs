//! Motion as pieces of constant acceleration, and its samples.

use crate::trace::{Row, Trace};

use super::reader::Block;
use super::settings::Settings;

/// Rest before the first motion and after the last, s.
const LEAD_S: f64 = 0.02;
const TAIL_S: f64 = 0.1;

/// A part of a block at constant acceleration, or a rest.
#[derive(Clone, Debug)]
pub struct Piece {
    pub seconds: f64,
    pub from: [f64; 3],
    pub direction: [f64; 3],
    /// At its beginning, mm/s.
    pub velocity: f64,
    pub acceleration: f64,
    pub line: i64,
    pub feed_override: f64,
    pub held: bool,
}

impl Piece {
    /// A piece of `block` that begins `done` mm behind its start.
    pub fn of(block: &Block, done: f64, velocity: f64, acceleration: f64, seconds: f64) -> Piece {
        Piece {
            seconds,
            from: block.point(done),
            direction: block.direction,
            velocity,
            acceleration,
            line: block.line,
            feed_override: 1.0,
            held: false,
        }
    }

    pub fn rest(at: [f64; 3], seconds: f64, line: i64) -> Piece {
        let still = Block { from: at, length: 0.0, direction: [0.0; 3], feed: None, line };
        Piece::of(&still, 0.0, 0.0, 0.0, seconds)
    }

    /// The way from its beginning, mm, and the velocity there after a time.
    pub fn after(&self, seconds: f64) -> (f64, f64) {
        let way = self.velocity * seconds + 0.5 * self.acceleration * seconds * seconds;
        (way, self.velocity + self.acceleration * seconds)
    }

    pub fn point(&self, way: f64) -> [f64; 3] {
        std::array::from_fn(|axis| self.from[axis] + way * self.direction[axis])
    }
}

/// The line that runs at a time of `pieces`; behind their end one behind all lines.
pub fn line_at(pieces: &[Piece], time: f64) -> i64 {
    let mut end = 0.0;
    let piece = pieces.iter().find(|piece| {
        end += piece.seconds;
        end > time
    });
    piece.map_or(i64::MAX, |piece| piece.line)
}

/// Feed overrides that hold from a line on.
#[derive(Default)]
pub struct LineOverrides(Vec<(i64, f64)>);

impl LineOverrides {
    /// The overrides of a run that act between two lines; `clean` is the run without them.
    pub fn of(settings: &Settings, clean: &[Piece]) -> LineOverrides {
        let from = |time: f64| if time > 0.0 { line_at(clean, time) } else { 0 };
        LineOverrides(settings.feed_overrides.iter().map(|(time, ratio)| (from(*time), *ratio)).collect())
    }

    /// The override on a line.
    pub fn at(&self, line: i64) -> f64 {
        self.0.iter().rev().find(|change| change.0 <= line).map_or(1.0, |change| change.1)
    }
}

/// The ramps that lead from `velocity` to `exit` over `length` with `cruise` between them, each as acceleration and
/// time. Where the length is too short to get to the exit, the block ends as near to it as it can.
pub fn ramps(velocity: f64, cruise: f64, exit: f64, length: f64, acceleration: f64) -> Vec<(f64, f64)> {
    let a = acceleration;
    let way = |v1: f64, v2: f64| (v1 * v1 - v2 * v2).abs() / (2.0 * a);
    if velocity * velocity - exit * exit >= 2.0 * a * length {
        let end = (velocity * velocity - 2.0 * a * length).max(0.0).sqrt();
        return vec![(-a, (velocity - end) / a)];
    }
    let exit = exit.min((velocity * velocity + 2.0 * a * length).sqrt());
    let peak = (a * length + 0.5 * (velocity * velocity + exit * exit)).sqrt();
    let top = if velocity > cruise { cruise } else { peak.min(cruise).max(velocity) };
    let left = length - way(velocity, top) - way(top, exit.min(top));
    let first = if top >= velocity { a } else { -a };
    let hold = if top > 0.0 { left.max(0.0) / top } else { 0.0 };
    vec![(first, (top - velocity).abs() / a), (0.0, hold), (-a, (top - exit.min(top)) / a)]
}

/// A row every `step` seconds, positions in whole steps of a motor if it has such.
pub fn sampled(pieces: &[Piece], step: f64, motor_step: Option<f64>) -> Trace {
    let moves = |piece: &&Piece| piece.velocity > 0.0 || piece.acceleration != 0.0;
    let first = pieces.iter().position(|piece| moves(&piece)).unwrap_or(0);
    let total: f64 = pieces[first..].iter().map(|piece| piece.seconds).sum();
    let (mut at, mut begun) = (first, 0.0);
    let row = |number: usize| {
        let t = number as f64 * step;
        let time = (t - LEAD_S).clamp(0.0, total);
        while at + 1 < pieces.len() && time >= begun + pieces[at].seconds {
            begun += pieces[at].seconds;
            at += 1;
        }
        let piece = &pieces[at];
        let is_moving = t >= LEAD_S && t < LEAD_S + total;
        let (way, speed) = piece.after((time - begun).min(piece.seconds));
        let point = piece.point(way);
        let command = motor_step.map_or(point, |size| point.map(|mm| (mm / size).round() * size));
        Row {
            t,
            line: piece.line,
            command,
            motor: command,
            speed: if is_moving { speed.max(0.0) } else { 0.0 },
            feed_override: piece.feed_override,
            held: piece.held,
        }
    };
    let count = ((total + LEAD_S + TAIL_S) / step).ceil() as usize;
    Trace { rows: (0..count).map(row).collect() }
}
