//! A program in the making: moves of the tool tip, with a rough account of the time they take, so that a job can be
//! made as long as it is wanted.

use std::f64::consts::TAU;

use crate::jobs::{Move, Point};

/// Rapids are taken to run at this in the rough account of time, mm/s.
const RAPID: f64 = 120.0;

/// Moves so far, and what they roughly take.
pub struct Job {
    pub moves: Vec<Move>,
    pub at: Point,
    /// The height above which rapids are safe, mm.
    pub clearance: f64,
    seconds: f64,
    target: f64,
}

/// Rounds a length to the micrometre that programs are written in.
pub fn rounded(mm: f64) -> f64 {
    (mm * 1e3).round() / 1e3
}

impl Job {
    /// An empty job above the workpiece that is to take about `target` seconds.
    pub fn new(target: f64, clearance: f64) -> Job {
        let at = [0.0, 0.0, clearance];
        Job { moves: vec![Move::Rapid(at)], at, clearance, seconds: 0.0, target }
    }

    /// Whether a share of the time it is to take is used up.
    pub fn has_filled(&self, share: f64) -> bool {
        self.seconds >= share * self.target
    }

    fn goes(&mut self, end: Point, length: f64, speed: f64) -> Point {
        let end = end.map(rounded);
        self.seconds += length / speed + 0.01;
        self.at = end;
        end
    }

    fn away(&self, end: Point) -> f64 {
        (0..3).map(|axis| (end[axis] - self.at[axis]).powi(2)).sum::<f64>().sqrt()
    }

    pub fn rapid(&mut self, end: Point) {
        let end = self.goes(end, self.away(end), RAPID);
        self.moves.push(Move::Rapid(end));
    }

    pub fn line(&mut self, end: Point, feed: f64) {
        let end = self.goes(end, self.away(end), feed / 60.0);
        self.moves.push(Move::Line { end, feed });
    }

    /// An arc about `centre`, a helix where the height changes.
    pub fn arc(&mut self, end: Point, centre: [f64; 2], clockwise: bool, feed: f64) {
        let angle = |p: Point| (p[1] - centre[1]).atan2(p[0] - centre[0]);
        let turn = if clockwise { angle(self.at) - angle(end) } else { angle(end) - angle(self.at) };
        let turn = if turn.rem_euclid(TAU) < 1e-9 { TAU } else { turn.rem_euclid(TAU) };
        let radius = (self.at[0] - centre[0]).hypot(self.at[1] - centre[1]);
        let length = (radius * turn).hypot(end[2] - self.at[2]);
        let end = self.goes(end, length, feed / 60.0);
        self.moves.push(Move::Arc { end, centre: centre.map(rounded), clockwise, feed });
    }

    pub fn hole(&mut self, at: [f64; 2], bottom: f64, peck: f64, feed: f64) {
        let pecks = if peck > 0.0 { (-bottom / peck).ceil() } else { 1.0 };
        let travel = self.away([at[0], at[1], self.at[2]]) - bottom * (1.0 + pecks);
        self.seconds += (2.0 - bottom) / feed * 60.0 + travel / RAPID + 0.1 * pecks;
        self.at = [rounded(at[0]), rounded(at[1]), self.clearance];
        self.moves.push(Move::Hole { at: at.map(rounded), top: 0.0, bottom, peck, feed });
    }

    /// Changes the tool; the number of the tool in use changes the speed of the spindle alone.
    pub fn tool(&mut self, number: u32, rpm: u32, name: &'static str) {
        self.moves.push(Move::Tool { number, rpm, name });
    }

    pub fn dwell(&mut self, seconds: f64) {
        self.seconds += seconds;
        self.moves.push(Move::Dwell { seconds });
    }

    /// Above `[x, y]`, and down to `start` by feed.
    pub fn approach(&mut self, start: Point, plunge: f64) {
        self.rapid([start[0], start[1], self.clearance]);
        if self.clearance > 3.0 {
            self.rapid([start[0], start[1], rounded(start[2].max(0.0) + 1.0)]);
        }
        self.line(start, plunge);
    }

    pub fn retract(&mut self) {
        self.rapid([self.at[0], self.at[1], self.clearance]);
    }
}
