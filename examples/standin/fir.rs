//! The first kernel: FIR interpolation by brute force in the time domain.
//!
//! The program is cut at full stops. Along each stretch the command is a staircase of speeds: F in a
//! block, c = αF around a corner for h (1 − c/F) on either side, h half the filters' delay, where α is
//! the largest that keeps the filtered path within tolerance,
//!
//!     ε ≥ F ‖u2 − u1‖ [α S(h) + (1 − α) S(αh)],
//!
//! with S the filters' displacement after a unit step of speed, got by running the filters over a
//! sampled step. Where two corners overlap on a short block the slower one wins. An acceleration limit
//! or jerk limit turns the stairs into ramps, see [`crate::ramp`]. Sampled positions
//! at 1 ms then pass, axis by axis, through running sums as long as each filter; the part of a sample
//! by which a filter is longer than whole ticks has its weight. A stop costs the whole delay.
//! A control that cannot read or process blocks fast enough lowers the whole staircase to its cap.
//! Limits: arcs no faster than √(24 R ε / ΣT²); speeds constant on a block.

use crate::path::{Shape, between, norm};
use crate::physics::{Motion, Physics, TICK};
use crate::ramp::{Leg, profile};
use crate::reader::Step;
use crate::schedule::{Phase, run};

/// A block of a stretch with its speed, mm/s, and the cap that processing sets on it, mm/s.
struct Block {
    shape: usize,
    line: u32,
    rapid: bool,
    length: f64,
    /// Before the limits of arcs; it says how long the speed of a corner is held.
    asked: f64,
    feed: f64,
    cap: f64,
    acceleration: f64,
}

/// Commands the program.
pub fn command(steps: &[Step], physics: &Physics) -> Motion {
    let shapes: Vec<Shape> = steps
        .iter()
        .filter_map(|step| match step {
            Step::Move { shape, .. } => Some(shape.clone()),
            Step::Wait { .. } => None,
        })
        .collect();
    let mut motion = Motion::default();
    let mut offset = 0.0;
    if let Some(first) = shapes.first() {
        motion.position.push(first.point(0.0));
        motion.line.push(0);
    }
    let mut shape = 0;
    let mut stretch: Vec<Block> = Vec::new();
    for step in steps {
        match step {
            Step::Move { line, rapid, feed, shape: path } => {
                let stops = stretch.last().is_some_and(|last| {
                    let turn = turn(&shapes[last.shape], path).clamp(0.0, 2.0);
                    let held = 0.0 < physics.in_position && last.rapid;
                    held || physics.exact_stop < 2.0 * (turn / 2.0).asin()
                });
                if stops {
                    let wait =
                        if stretch.last().is_some_and(|b| b.rapid) { physics.in_position } else { 0.0 };
                    offset = flush(&mut stretch, wait, &shapes, physics, offset, &mut motion);
                }
                stretch.push(block(shape, *line, *rapid, *feed, path, physics));
                shape += 1;
            }
            Step::Wait { line, seconds, tool_change } => {
                offset = flush(&mut stretch, 0.0, &shapes, physics, offset, &mut motion);
                let more = physics.wait.map_or(0.0, |(at, s)| if at == *line { s } else { 0.0 });
                let pause = seconds + more + if *tool_change { physics.tool_change } else { 0.0 };
                if let Some(last) = shape.checked_sub(1) {
                    let end = shapes[last].length();
                    offset = run(
                        &[Phase::standing(last, *line, end, pause)],
                        &shapes,
                        physics,
                        offset,
                        &mut motion,
                    );
                }
            }
        }
    }
    flush(&mut stretch, 0.0, &shapes, physics, offset, &mut motion);
    motion
}

/// ‖u2 − u1‖ where one shape meets the next.
fn turn(before: &Shape, after: &Shape) -> f64 {
    norm(between(before.tangent(before.length()), after.tangent(0.0)))
}

fn block(shape: usize, line: u32, rapid: bool, feed: f64, path: &Shape, physics: &Physics) -> Block {
    let length = path.length();
    let curvature = path.curvature();
    let (ratio, from, to) = physics.feed_override;
    let mut speed = match rapid {
        true => physics.rapid * physics.rapid_override,
        false if (from..=to).contains(&line) => feed * ratio,
        false => feed,
    };
    let mut acceleration = physics.path_acceleration;
    for axis in 0..3 {
        let share = path.share(axis).max(1e-9);
        speed = speed.min(physics.axis_velocity[axis] / share);
        acceleration = acceleration.min(physics.axis_acceleration[axis] / share);
        if 0.0 < curvature && 1e-6 < share {
            speed = speed.min((physics.axis_acceleration[axis] / curvature).sqrt());
        }
    }
    let asked = speed;
    if 0.0 < curvature {
        let variance: f64 = physics.boxes.iter().map(|t| t * t).sum();
        speed = speed.min((24.0 * physics.tolerance / (curvature * variance)).sqrt());
        speed = speed.min((physics.centripetal / curvature).sqrt());
    }
    let cap = if 0.0 < physics.block_time { length / physics.block_time } else { f64::INFINITY };
    Block { shape, line, rapid, length, asked: asked.max(1e-3), feed: speed.max(1e-3), cap, acceleration }
}

/// Commands and filters one stretch, then leaves it empty.
fn flush(
    stretch: &mut Vec<Block>,
    wait: f64,
    shapes: &[Shape],
    physics: &Physics,
    offset: f64,
    motion: &mut Motion,
) -> f64 {
    let blocks = std::mem::take(stretch);
    let Some(last) = blocks.last() else { return offset };
    let boxes = &physics.boxes;
    let delay: f64 = boxes.iter().sum();
    let mut phases = stairs(&blocks, shapes, physics, boxes);
    let (line, end) = (last.line, last.length);
    phases.push(Phase::standing(last.shape, line, end, delay + wait));
    let before = motion.position.len();
    let offset = run(&phases, shapes, physics, offset, motion);
    let start = shapes[blocks[0].shape].point(0.0);
    for axis in 0..3 {
        let mut column: Vec<f64> = motion.position[before..].iter().map(|p| p[axis]).collect();
        for width in boxes {
            running_mean(&mut column, start[axis], width / TICK);
        }
        for (point, value) in motion.position[before..].iter_mut().zip(column) {
            point[axis] = value;
        }
    }
    offset
}

/// The mean of the last `width` samples, the oldest with the part of it that is left; before the
/// first sample lies `start`.
pub fn running_mean(column: &mut [f64], start: f64, width: f64) {
    let width = width.max(1.0);
    let (whole, part) = (width.floor() as usize, width.fract());
    let source = column.to_vec();
    let at = |i: usize, back: usize| i.checked_sub(back).map_or(0.0, |k| source[k] - start);
    let mut sum = 0.0;
    for (i, value) in column.iter_mut().enumerate() {
        sum += at(i, 0) - at(i, whole);
        *value = start + (sum + part * at(i, whole)) / width;
    }
}

/// The staircase of speeds along a stretch, with ramps where an acceleration limit asks for them.
fn stairs(blocks: &[Block], shapes: &[Shape], physics: &Physics, boxes: &[f64]) -> Vec<Phase> {
    let half = boxes.iter().sum::<f64>() / 2.0;
    let caps: Vec<f64> =
        (0..blocks.len()).map(|i| blocks[i].cap.min(ahead(&blocks[i..], physics, half))).collect();
    let law = CornerLaw::new(boxes);
    let corner = |i: usize| -> f64 {
        let slower = blocks[i].feed.min(blocks[i + 1].feed);
        let (before, after) = (&shapes[blocks[i].shape], &shapes[blocks[i + 1].shape]);
        let step = turn(before, after);
        let rounding = before.length().min(after.length()) * step / 4.0;
        if rounding < physics.smoothing {
            return slower;
        }
        let (u, w) = (before.tangent(before.length()), after.tangent(0.0));
        let largest = (0..3).map(|k| (w[k] - u[k]).abs()).fold(1e-9, f64::max);
        let tolerated = slower * law.share(physics.tolerance / (slower * step).max(1e-12));
        tolerated.min(physics.axis_step / largest)
    };
    let corners: Vec<f64> = (0..blocks.len().saturating_sub(1)).map(corner).collect();
    let mut pieces: Vec<(usize, f64, f64)> = Vec::new();
    for (i, block) in blocks.iter().enumerate() {
        let feed = block.feed;
        let first = if i == 0 { feed } else { corners[i - 1] };
        let second = corners.get(i).copied().unwrap_or(feed);
        let hold = |c: f64| (c * half * (1.0 - c / block.asked)).clamp(0.0, block.length);
        let (mut one, mut two) = (hold(first), hold(second));
        if block.length < one + two {
            if first < second { two = block.length - one } else { one = block.length - two }
        }
        let rest = block.length - one - two;
        let parts = [(one, first), (rest, feed), (two, second)];
        pieces.extend(parts.iter().filter(|p| 1e-9 < p.0).map(|p| (i, p.0, p.1.min(caps[i]))));
    }
    ramps(&pieces, blocks, physics)
}

/// The speed from which the motion stops within the blocks seen ahead: v h + v²/(2A).
fn ahead(blocks: &[Block], physics: &Physics, half: f64) -> f64 {
    if physics.look_ahead.is_infinite() {
        return f64::INFINITY;
    }
    let seen: f64 = blocks.iter().take(physics.look_ahead as usize).map(|b| b.length).sum();
    2.0 * seen / (half + (half * half + 2.0 * seen / physics.path_acceleration).sqrt())
}

/// Joins pieces (block, mm, mm/s) by ramps, with each block's acceleration.
fn ramps(pieces: &[(usize, f64, f64)], blocks: &[Block], physics: &Physics) -> Vec<Phase> {
    let mut legs: Vec<Leg> = Vec::new();
    for &(block, length, speed) in pieces {
        let at = &blocks[block];
        let before = legs.last().filter(|leg| leg.shape == at.shape);
        let start = before.map_or(0.0, |leg| leg.start + leg.length);
        legs.push(Leg {
            shape: at.shape,
            line: at.line,
            start,
            length,
            speed,
            acceleration: at.acceleration,
        });
    }
    let inner = legs.windows(2).map(|pair| f64::min(pair[0].speed, pair[1].speed));
    let joints: Vec<f64> = std::iter::once(0.0).chain(inner).chain([0.0]).collect();
    profile(&legs, joints, physics.jerk, physics.hold)
}

/// The share α of the feed at a corner for ε / (F ‖u2 − u1‖), found on a sampled step response.
struct CornerLaw {
    displacement: Vec<f64>,
    step: f64,
    half: f64,
}

impl CornerLaw {
    fn new(boxes: &[f64]) -> CornerLaw {
        let delay: f64 = boxes.iter().sum();
        // Fine enough that half a sample a filter does not show.
        let step = delay / 60_000.0;
        let mut speed = vec![1.0; 30_002];
        for width in boxes {
            running_mean(&mut speed, 0.0, width / step);
        }
        let mut displacement = vec![0.0];
        for pair in speed.windows(2) {
            displacement.push(displacement[displacement.len() - 1] + step * (pair[0] + pair[1]) / 2.0);
        }
        CornerLaw { displacement, step, half: delay / 2.0 }
    }

    fn displaced(&self, t: f64) -> f64 {
        let at = t / self.step;
        let i = (at as usize).min(self.displacement.len() - 2);
        self.displacement[i] + (at - i as f64) * (self.displacement[i + 1] - self.displacement[i])
    }

    fn share(&self, allowed: f64) -> f64 {
        let deviation = |a: f64| a * self.displaced(self.half) + (1.0 - a) * self.displaced(a * self.half);
        if deviation(1.0) <= allowed {
            return 1.0;
        }
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..40 {
            let middle = (low + high) / 2.0;
            if deviation(middle) <= allowed { low = middle } else { high = middle }
        }
        f64::max(low, 1e-4)
    }
}
