//! Klipper: trapezoids of path velocity with one acceleration along the path, planned over all blocks between two waits.
//!
//! A corner is passed on a circle that touches both lines at a distance δ = v₉₀² (√2 − 1) / a from it, and no faster than
//! the circle that touches them in their middles. With a minimum cruise ratio r, a run of blocks that only speeds up and
//! slows down is no faster than with the acceleration (1 − r) a (`toolhead.py`).

use std::f64::consts::SQRT_2;

use super::piece::{LineOverrides, Piece, line_at, ramps};
use super::reader::{Block, Item, Reading};
use super::settings::Settings;

/// `resolution` of arcs, mm.
const CHORD_MM: f64 = 0.1;

pub const READING: Reading = Reading {
    chords: |_, _, length| length / CHORD_MM,
    step: None,
    rapids_have_feed: true,
    dwell_unit: 1e-3,
    spindle_waits: false,
};

/// A block as the look-ahead sees it; velocities are squared.
struct Planned<'a> {
    block: &'a Block,
    acceleration: f64,
    cruise: f64,
    /// The highest at its start that the corner and the blocks before it allow; at `acceleration` and at the lower one.
    start: f64,
    smoothed_start: f64,
    /// Largest change of the squared velocity along the block, at each of the two accelerations.
    change: f64,
    smoothed_change: f64,
}

/// Returns the motion of a program.
pub fn run(items: &[Item], settings: &Settings) -> Vec<Piece> {
    let acts = !settings.feed_overrides.is_empty() || settings.hold.is_some();
    // Both act between two lines here, so the run without them says between which.
    let clean = if acts { planned(items, settings, |_| 1.0) } else { Vec::new() };
    let overrides = LineOverrides::of(settings, &clean);
    let mut items = items.to_vec();
    let mut held = 0;
    if let Some((time, seconds)) = settings.hold {
        held = line_at(&clean, time);
        let is_at = |item: &Item| matches!(item, Item::Move(block) if block.line == held);
        let place = items.iter().position(is_at).unwrap_or(items.len());
        items.insert(place, Item::Rest { seconds, line: held });
    }
    let mut pieces = planned(&items, settings, |line| overrides.at(line));
    for piece in &mut pieces {
        piece.feed_override = overrides.at(piece.line);
        piece.held = piece.line == held && piece.direction == [0.0; 3];
    }
    pieces
}

fn planned(items: &[Item], settings: &Settings, ratio: impl Fn(i64) -> f64) -> Vec<Piece> {
    let mut pieces = Vec::new();
    let mut queue: Vec<Planned> = Vec::new();
    let mut at = [0.0; 3];
    for item in items {
        match item {
            Item::Move(block) => {
                let next = enters(block, queue.last(), settings, ratio(block.line));
                queue.push(next);
                at = block.point(block.length);
            }
            Item::Rest { seconds, line } => {
                flush(&mut queue, &mut pieces);
                pieces.push(Piece::rest(at, *seconds, *line));
            }
        }
    }
    flush(&mut queue, &mut pieces);
    pieces
}

/// A block at the end of the queue, with the limits of its start.
fn enters<'a>(block: &'a Block, before: Option<&Planned>, settings: &Settings, ratio: f64) -> Planned<'a> {
    let rises = block.direction[2] != 0.0;
    let of_z = |own: f64, z: f64| if rises { own.min(z / block.direction[2].abs()) } else { own };
    let asked = block.feed.unwrap_or(0.0) * ratio;
    let path_velocity = settings.path_velocity.min(settings.velocity[0]);
    let velocity = of_z(asked.min(path_velocity), settings.velocity[2]);
    let acceleration = of_z(settings.acceleration[0], settings.acceleration[2]);
    let change = 2.0 * block.length * acceleration;
    let smoothed = 2.0 * block.length * (1.0 - settings.cruise_ratio) * settings.acceleration[0];
    let mut next = Planned {
        block,
        acceleration,
        cruise: velocity * velocity,
        start: 0.0,
        smoothed_start: 0.0,
        change,
        smoothed_change: smoothed.min(change),
    };
    if let Some(before) = before {
        let slower = next.cruise.min(before.cruise).min(before.start + before.change);
        next.start = slower.min(corner(before, &next, settings));
        next.smoothed_start = next.start.min(before.smoothed_start + before.smoothed_change);
    }
    next
}

/// The square of the highest velocity at the corner between two blocks.
fn corner(before: &Planned, after: &Planned, settings: &Settings) -> f64 {
    let [one, other] = [before.block, after.block];
    let cos: f64 = -(0..3).map(|axis| one.direction[axis] * other.direction[axis]).sum::<f64>();
    let half_sine = (0.5 * (1.0 - cos)).max(0.0).sqrt();
    let half_cosine = (0.5 * (1.0 + cos)).max(0.0).sqrt();
    if half_sine >= 1.0 || half_cosine <= 0.0 {
        return f64::INFINITY;
    }
    let deviation = settings.square_corner_velocity.powi(2) * (SQRT_2 - 1.0) / settings.acceleration[0];
    let weaker = before.acceleration.min(after.acceleration);
    let on_circle = deviation * half_sine / (1.0 - half_sine) * weaker;
    on_circle.min(0.25 * half_sine / half_cosine * before.change.min(after.change))
}

/// Plans all blocks of the queue to end in rest, and empties it.
fn flush(queue: &mut Vec<Planned>, pieces: &mut Vec<Piece>) {
    // Start, cruise and end of each block.
    let mut plans = vec![(0.0, 0.0, 0.0); queue.len()];
    // Blocks of a descent whose peak is not known before what leads up to it.
    let mut descent: Vec<(usize, f64, f64)> = Vec::new();
    let (mut end, mut smoothed_end, mut peak): (f64, f64, f64) = (0.0, 0.0, 0.0);
    for (number, next) in queue.iter().enumerate().rev() {
        let (reachable, smoothed_reachable) = (end + next.change, smoothed_end + next.smoothed_change);
        let (start, smoothed_start) =
            (next.start.min(reachable), next.smoothed_start.min(smoothed_reachable));
        if smoothed_start < smoothed_reachable {
            if smoothed_start + next.smoothed_change > smoothed_end || !descent.is_empty() {
                peak = next.cruise.min(0.5 * (smoothed_start + smoothed_reachable));
                let mut top = peak;
                for (later, from, to) in descent.drain(..).rev() {
                    top = top.min(from);
                    plans[later] = (from.min(top), top, to.min(top));
                }
            }
            let cruise = (0.5 * (start + reachable)).min(next.cruise).min(peak);
            plans[number] = (start.min(cruise), cruise, end.min(cruise));
        } else {
            descent.push((number, start, end));
        }
        (end, smoothed_end) = (start, smoothed_start);
    }
    for (next, (start, cruise, end)) in queue.drain(..).zip(plans) {
        let [mut velocity, cruise, end] = [start, cruise, end].map(f64::sqrt);
        let mut done = 0.0;
        for (a, seconds) in ramps(velocity, cruise, end, next.block.length, next.acceleration) {
            let piece = Piece::of(next.block, done, velocity, a, seconds);
            let (way, after) = piece.after(seconds);
            (done, velocity) = (done + way, after);
            pieces.push(piece);
        }
    }
}
