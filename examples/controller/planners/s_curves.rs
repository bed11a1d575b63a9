//! Marlin and TinyG.
//!
//! - Marlin: trapezoids within the acceleration of the axes, of which each ramp may be a curve of fifth order
//!   (`S_CURVE_ACCELERATION`) that takes as long, v = v₀ + Δv (10 τ³ − 15 τ⁴ + 6 τ⁵). No axis changes its velocity at a
//!   corner by more than its step (`CLASSIC_JERK`), and from rest a motion begins with such a step.
//! - TinyG: ramps within the jerk J of the axes and no limit of acceleration, 2 √(Δv / J) long, and the corners of grbl.
//!
//! Both know as many blocks as their buffer holds. An override holds from a line on.

use super::grbl;
use super::piece::{LineOverrides, Piece};
use super::reader::{Block, Item, Reading, known, limit_along};
use super::settings::Settings;

/// Pieces of constant acceleration of a curved ramp.
const PIECES: usize = 24;
/// Halvings of the interval of a peak velocity.
const HALVINGS: usize = 48;

pub const MARLIN: Reading = Reading {
    chords: |_, _, length| length,
    step: None,
    rapids_have_feed: true,
    dwell_unit: 1e-3,
    spindle_waits: true,
};

/// Largest distance of an arc from its chords on TinyG, mm.
const CHORD_ERROR_MM: f64 = 0.01;

pub const TINYG: Reading = Reading {
    chords: |radius, angle, _| {
        0.5 * angle * radius / (CHORD_ERROR_MM * (2.0 * radius - CHORD_ERROR_MM)).sqrt()
    },
    step: None,
    rapids_have_feed: false,
    dwell_unit: 1.0,
    spindle_waits: true,
};

/// How the velocity changes on a block.
#[derive(Clone, Copy)]
enum Ramp {
    Linear(f64),
    /// Of fifth order, with this mean acceleration.
    Curved(f64),
    Jerk(f64),
}

impl Ramp {
    fn seconds(self, change: f64) -> f64 {
        match self {
            Ramp::Linear(a) | Ramp::Curved(a) => change.abs() / a,
            Ramp::Jerk(jerk) => 2.0 * (change.abs() / jerk).sqrt(),
        }
    }

    /// Every ramp is symmetric about its middle.
    fn way(self, from: f64, to: f64) -> f64 {
        0.5 * (from + to) * self.seconds(to - from)
    }

    /// The part of the change of velocity that is done at a part of the time.
    fn done(self, part: f64) -> f64 {
        match self {
            Ramp::Linear(_) => part,
            Ramp::Curved(_) => part.powi(3) * (10.0 - 15.0 * part + 6.0 * part * part),
            Ramp::Jerk(_) if part < 0.5 => 2.0 * part * part,
            Ramp::Jerk(_) => 1.0 - 2.0 * (1.0 - part).powi(2),
        }
    }

    /// The highest velocity, up to `highest`, from which a ramp to `end` is no longer than `length`.
    fn reach(self, end: f64, length: f64, highest: f64) -> f64 {
        highest_where(end, highest, |velocity| self.way(velocity, end) <= length)
    }
}

fn highest_where(from: f64, to: f64, holds: impl Fn(f64) -> bool) -> f64 {
    if to <= from || holds(to) {
        return to.max(from);
    }
    let (mut low, mut high) = (from, to);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if holds(middle) { low = middle } else { high = middle }
    }
    low
}

struct Control<'a> {
    settings: &'a Settings,
    overrides: LineOverrides,
}

/// Returns the motion of a program.
pub fn run(items: &[Item], settings: &Settings) -> Vec<Piece> {
    let with = |overrides: LineOverrides| Control { settings, overrides }.pieces(items);
    let clean = with(LineOverrides::default());
    if settings.feed_overrides.is_empty() { clean } else { with(LineOverrides::of(settings, &clean)) }
}

impl Control<'_> {
    fn nominal(&self, block: &Block) -> f64 {
        let highest = block.along(&self.settings.velocity).min(self.settings.path_velocity);
        block.feed.map_or(highest, |feed| (feed * self.overrides.at(block.line)).min(highest))
    }

    fn ramp(&self, block: &Block) -> Ramp {
        let a = block.along(&self.settings.acceleration);
        match self.settings {
            Settings { jerk_time: Some(seconds), .. } => Ramp::Jerk(a / seconds),
            Settings { is_curved: true, .. } => Ramp::Curved(a),
            _ => Ramp::Linear(a),
        }
    }

    /// The highest velocity of a block at a rest.
    fn at_rest(&self, block: &Block) -> f64 {
        self.settings.corner_step.map_or(0.0, |step| block.along(&[step; 3]).min(self.nominal(block)))
    }

    fn corner(&self, before: &Block, after: &Block) -> f64 {
        let Some(step) = self.settings.corner_step else {
            return grbl::junction(before, after, self.settings).sqrt();
        };
        let change: [f64; 3] = std::array::from_fn(|axis| after.direction[axis] - before.direction[axis]);
        limit_along(&change, &[step; 3])
    }

    /// The velocity at the end of the first of the known blocks.
    fn exit(&self, known: &[&Block]) -> f64 {
        let mut velocity = known.last().map_or(0.0, |last| self.at_rest(last));
        for pair in known.windows(2).rev() {
            let slower = self.nominal(pair[0]).min(self.nominal(pair[1])).min(self.corner(pair[0], pair[1]));
            velocity = self.ramp(pair[1]).reach(velocity, pair[1].length, slower).min(slower);
        }
        velocity
    }

    fn pieces(&self, items: &[Item]) -> Vec<Piece> {
        let mut pieces = Vec::new();
        let (mut at, mut velocity) = ([0.0; 3], None);
        for (number, item) in items.iter().enumerate() {
            match item {
                Item::Move(block) => {
                    let known = known(items, number, self.settings.look_ahead);
                    let from = velocity.unwrap_or_else(|| self.at_rest(block));
                    velocity = Some(self.runs(block, from, self.exit(&known), &mut pieces));
                    at = block.point(block.length);
                }
                Item::Rest { seconds, line } => {
                    velocity = None;
                    pieces.push(Piece::rest(at, *seconds, *line));
                }
            }
        }
        pieces
    }

    /// Adds the pieces of a block, and returns the velocity at its end.
    fn runs(&self, block: &Block, from: f64, exit: f64, pieces: &mut Vec<Piece>) -> f64 {
        let (ramp, nominal) = (self.ramp(block), self.nominal(block).max(from));
        let exit = if exit > from { ramp.reach(from, block.length, exit) } else { exit };
        let peak = highest_where(from.max(exit), nominal, |peak| {
            ramp.way(from, peak) + ramp.way(peak, exit) <= block.length
        });
        let left = block.length - ramp.way(from, peak) - ramp.way(peak, exit);
        let mut done = 0.0;
        let mut adds = |velocity: f64, to: f64, seconds: f64| {
            let piece =
                Piece::of(block, done, velocity, (to - velocity) / seconds.max(f64::MIN_POSITIVE), seconds);
            done += piece.after(seconds).0;
            pieces.push(Piece { feed_override: self.overrides.at(block.line), ..piece });
        };
        for (from, to, seconds) in [
            (from, peak, ramp.seconds(peak - from)),
            (peak, peak, left.max(0.0) / peak.max(f64::MIN_POSITIVE)),
            (peak, exit, ramp.seconds(exit - peak)),
        ] {
            let count = if from == to || matches!(ramp, Ramp::Linear(_)) { 1 } else { PIECES };
            let at = |number: usize| from + (to - from) * ramp.done(number as f64 / count as f64);
            if seconds > 0.0 {
                (0..count).for_each(|number| adds(at(number), at(number + 1), seconds / count as f64));
            }
        }
        exit
    }
}
