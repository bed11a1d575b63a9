//! A job in the words of LinuxCNC, in the manner of one of many post-processors.

use std::fmt::Write;

use serde_json::{Value, json};

use crate::jobs::{Move, Point};
use crate::machine::{Family, Limits};
use crate::random::Random;

/// How corners are passed, as the program says it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PathMode {
    /// No word at all.
    Unsaid,
    /// G64: as fast as it goes.
    Fast,
    /// G64 P, mm.
    Within(f64),
    /// G64 P Q, mm: short blocks may be merged.
    Merging(f64, f64),
    /// G61.
    Exact,
}

/// The manner of a post-processor.
#[derive(Clone, Debug)]
pub struct Manner {
    pub inch: bool,
    pub path: PathMode,
    pub numbered: bool,
    /// Words that hold are not said again.
    pub modal: bool,
    pub spindle: bool,
    pub tool_changes: bool,
    /// Holes by G81 and G83, or by moves.
    pub cycles: bool,
    pub decimals: usize,
    /// The feedrate of rapids, mm/min, on a control that runs them as it runs feed moves.
    pub rapid_feed: Option<f64>,
    /// The unit of the time of a dwell, s.
    pub dwell_unit: f64,
    /// Whether M5 precedes every M3, where M3 is a macro for which no motion stops.
    pub stops_spindle: bool,
}

impl Manner {
    pub fn draw(random: &mut Random) -> Manner {
        let inch = random.chance(0.3);
        let tolerance = rounded_to(random.log_uniform(0.005, 0.1), 3);
        let path = match random.below(20) {
            0..=8 => PathMode::Within(tolerance),
            9 => PathMode::Merging(tolerance, tolerance),
            10..=13 => PathMode::Fast,
            14..=15 => PathMode::Exact,
            _ => PathMode::Unsaid,
        };
        Manner {
            inch,
            path,
            numbered: random.chance(0.3),
            modal: random.chance(0.6),
            spindle: random.chance(0.6),
            tool_changes: random.chance(0.5),
            cycles: random.chance(0.8),
            decimals: if inch { 4 } else { 3 } + random.below(2),
            rapid_feed: None,
            dwell_unit: 1.0,
            stops_spindle: false,
        }
    }

    /// This manner in the words that a control of `family` knows.
    pub fn on(self, family: Family, limits: &Limits) -> Manner {
        let plain = Manner { path: PathMode::Unsaid, tool_changes: false, cycles: false, ..self.clone() };
        match family {
            Family::LinuxCnc => self,
            Family::Grbl | Family::TinyG => plain,
            Family::Marlin | Family::MarlinDeviation => {
                let rapid_feed = Some((60.0 * limits.velocity[0].min(limits.velocity[1])).round());
                Manner { rapid_feed, dwell_unit: 1e-3, ..plain }
            }
            Family::Klipper => {
                let rapid_feed = Some((60.0 * limits.velocity[0]).round());
                Manner { rapid_feed, dwell_unit: 1e-3, stops_spindle: true, ..plain }
            }
        }
    }

    pub fn to_json(&self) -> Value {
        json!({ "inch": self.inch, "path_mode": self.path_words(), "numbered": self.numbered, "modal": self.modal,
                "spindle": self.spindle, "tool_changes": self.tool_changes, "decimals": self.decimals })
    }

    /// The feedrate written on each rapid, mm/min; programs that write a word only where it changes leave rapids the feedrate
    /// of the feed move before, at which such a control runs them.
    fn feed_of_rapids(&self) -> Option<f64> {
        self.rapid_feed.filter(|_| !self.modal)
    }

    fn path_words(&self) -> String {
        let length = |mm: f64| if self.inch { number(mm / 25.4, 5) } else { number(mm, 4) };
        match self.path {
            PathMode::Unsaid => String::new(),
            PathMode::Fast => "G64".into(),
            PathMode::Within(p) => format!("G64 P{}", length(p)),
            PathMode::Merging(p, q) => format!("G64 P{} Q{}", length(p), length(q)),
            PathMode::Exact => "G61".into(),
        }
    }

    /// The program as text, a line for each word or move.
    pub fn write(&self, kind: &str, clearance: f64, moves: &[Move]) -> String {
        let mut post =
            Post { manner: self, lines: vec![], at: None, motion: "", feed: 0.0, tool: 0, hole: None };
        post.lines.push(format!("({kind})"));
        post.lines.push(format!("{} G17 G90 G94 G40 G49 G80", if self.inch { "G20" } else { "G21" }));
        if self.path != PathMode::Unsaid {
            post.lines.push(self.path_words());
        }
        // What precedes the first move is in no recording, so the tool goes up before anything else.
        let feed = self.rapid_feed.map(|feed| post.feed_word(feed)).unwrap_or_default();
        post.lines.push(format!("G0 Z{}{feed}", post.length(clearance)));
        for next in moves {
            post.add(next, clearance);
        }
        post.ends_cycle();
        if self.spindle {
            post.lines.push("M5".into());
        }
        post.lines.push(if self.numbered { "M30" } else { "M2" }.into());
        let mut text = String::new();
        for (count, line) in (1..).zip(&post.lines) {
            let block = if self.numbered && count > 1 { format!("N{} ", 10 * count) } else { String::new() };
            writeln!(text, "{block}{line}").expect("text takes any length");
        }
        text
    }
}

pub fn rounded_to(value: f64, decimals: i32) -> f64 {
    let unit = 10f64.powi(decimals);
    (value * unit).round() / unit
}

/// A number with no more digits than it needs.
fn number(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text.is_empty() || text == "-0" { "0".into() } else { text.into() }
}

/// What has been written, and what holds.
struct Post<'a> {
    manner: &'a Manner,
    lines: Vec<String>,
    at: Option<Point>,
    motion: &'static str,
    feed: f64,
    tool: u32,
    /// Depth and peck of the drilling cycle in force.
    hole: Option<(f64, f64)>,
}

impl Post<'_> {
    fn length(&self, mm: f64) -> String {
        number(if self.manner.inch { mm / 25.4 } else { mm }, self.manner.decimals)
    }

    fn feed_word(&mut self, feed: f64) -> String {
        if self.manner.modal && feed == self.feed {
            return String::new();
        }
        self.feed = feed;
        format!(" F{}", if self.manner.inch { number(feed / 25.4, 2) } else { number(feed, 1) })
    }

    /// A line that moves to `end`; nothing where it would not move.
    fn moves(&mut self, motion: &'static str, end: &Point, centre: Option<[f64; 2]>, feed: Option<f64>) {
        self.ends_cycle();
        let mut coordinates = String::new();
        for (axis, letter) in ["X", "Y", "Z"].into_iter().enumerate() {
            let word = self.length(end[axis]);
            let holds = self.at.is_some_and(|at| self.length(at[axis]) == word);
            if !holds || !self.manner.modal && centre.is_none() {
                write!(coordinates, " {letter}{word}").expect("text takes any length");
            }
        }
        if let (Some(centre), Some(at)) = (centre, self.at) {
            let (i, j) = (self.length(centre[0] - at[0]), self.length(centre[1] - at[1]));
            write!(coordinates, " I{i} J{j}").expect("text takes any length");
        }
        let still = self.at.is_some_and(|at| (0..3).all(|k| self.length(at[k]) == self.length(end[k])));
        if still && centre.is_none() {
            return;
        }
        let feed = feed.map(|feed| self.feed_word(feed)).unwrap_or_default();
        let repeated = self.manner.modal && self.motion == motion;
        let words = format!("{}{coordinates}{feed}", if repeated { "" } else { motion });
        self.lines.push(words.trim_start().to_string());
        self.motion = motion;
        self.at = Some(*end);
    }

    fn ends_cycle(&mut self) {
        if self.hole.take().is_some() {
            self.lines.push("G80".into());
            self.motion = "";
        }
    }

    fn add(&mut self, next: &Move, clearance: f64) {
        match next {
            Move::Rapid(end) => self.moves("G0", end, None, self.manner.feed_of_rapids()),
            Move::Line { end, feed } => self.moves("G1", end, None, Some(*feed)),
            Move::Arc { end, centre, clockwise, feed } => {
                self.moves(if *clockwise { "G2" } else { "G3" }, end, Some(*centre), Some(*feed));
            }
            Move::Dwell { seconds } => {
                self.ends_cycle();
                self.lines.push(format!("G4 P{}", number(*seconds / self.manner.dwell_unit, 2)));
            }
            Move::Tool { number, rpm, name } => self.tool(*number, *rpm, name),
            Move::Hole { at, bottom, peck, feed, .. } if self.manner.cycles => {
                self.cycle(*at, (*bottom, *peck), *feed, clearance);
            }
            Move::Hole { at, bottom, peck, feed, .. } => self.pecks(*at, *bottom, *peck, *feed, clearance),
        }
    }

    fn tool(&mut self, tool: u32, rpm: u32, name: &str) {
        self.ends_cycle();
        let changes = self.manner.tool_changes && tool != self.tool;
        if changes {
            self.lines.push(format!("T{tool} M6 ({name})"));
        }
        if self.manner.spindle {
            if self.manner.stops_spindle {
                self.lines.push("M5".into());
            }
            self.lines.push(format!("S{rpm} M3"));
        }
        self.tool = tool;
        self.motion = "";
    }

    /// A hole of G81 or G83 that returns to the height of safety.
    fn cycle(&mut self, at: [f64; 2], hole: (f64, f64), feed: f64, clearance: f64) {
        let [x, y] = at.map(|mm| self.length(mm));
        if self.hole != Some(hole) {
            if self.hole.is_none() && self.at.is_none_or(|from| from[2] != clearance) {
                self.moves("G0", &[at[0], at[1], clearance], None, None);
            }
            self.feed = 0.0;
            let peck = if hole.1 > 0.0 { format!(" Q{}", self.length(hole.1)) } else { String::new() };
            let word = if hole.1 > 0.0 { "G83" } else { "G81" };
            let (bottom, plane, feed) = (self.length(hole.0), self.length(2.0), self.feed_word(feed));
            self.lines.push(format!("G98 {word} X{x} Y{y} Z{bottom} R{plane}{peck}{feed}"));
        } else {
            self.lines.push(format!("X{x} Y{y}"));
        }
        self.hole = Some(hole);
        self.motion = "";
        self.at = Some([at[0], at[1], clearance]);
    }

    /// The same hole by moves.
    fn pecks(&mut self, at: [f64; 2], bottom: f64, peck: f64, feed: f64, clearance: f64) {
        let point = |z: f64| [at[0], at[1], z];
        self.moves("G0", &point(clearance), None, self.manner.feed_of_rapids());
        self.moves("G0", &point(2.0), None, self.manner.feed_of_rapids());
        let mut depth = 0.0;
        while depth > bottom {
            let next = if peck > 0.0 { (depth - peck).max(bottom) } else { bottom };
            if depth < 0.0 {
                self.moves("G0", &point(2.0), None, self.manner.feed_of_rapids());
                self.moves("G0", &point(depth + 0.3), None, self.manner.feed_of_rapids());
            }
            self.moves("G1", &point(next), None, Some(feed));
            depth = next;
        }
        self.moves("G0", &point(clearance), None, self.manner.feed_of_rapids());
    }
}
