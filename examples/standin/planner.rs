//! The second kernel: a look-ahead planner with limited jerk, of another family than FIR filters.
//!
//! Corners between lines are rounded by parabolas whose middle stays within the tolerance ε of the
//! corner, with legs d = 4 ε / ‖u2 − u1‖, at most half of the shorter line. Every piece of the rounded
//! path has a speed limit: the programmed feed, each axis' velocity limit V_k / |u_k|, and on curves
//! √(A / (√2 κ)), which leaves A/√2 for the tangential acceleration, so that both together stay within
//! every axis' limit A. Speeds change as in [`crate::ramp`].
//! Non-tangential joints at arcs are full stops.

use crate::path::{Shape, add, between, norm};
use crate::physics::{Motion, Physics};
use crate::ramp::{Leg, profile};
use crate::reader::Step;
use crate::schedule::{Phase, run};

/// Used where no acceleration, mm/s², or jerk, mm/s³, is given.
const ACCELERATION: f64 = 1500.0;
const JERK: f64 = 50_000.0;

/// Commands the program.
pub fn command(steps: &[Step], physics: &Physics) -> Motion {
    let mut motion = Motion::default();
    let mut offset = 0.0;
    let mut stretch: Vec<(u32, Shape, f64)> = Vec::new();
    let mut last = None;
    let end = Step::Wait { line: 0, seconds: 0.0, tool_change: false };
    for step in steps.iter().chain([&end]) {
        match step {
            Step::Move { line, shape, rapid, feed } => {
                if last.is_none() && motion.position.is_empty() {
                    motion.position.push(shape.point(0.0));
                    motion.line.push(0);
                }
                let (ratio, from, to) = physics.feed_override;
                let speed = match rapid {
                    true => physics.rapid * physics.rapid_override,
                    false if (from..=to).contains(line) => feed * ratio,
                    false => *feed,
                };
                stretch.push((*line, shape.clone(), speed));
                last = Some(shape.clone());
            }
            Step::Wait { line, seconds, tool_change } => {
                let (shapes, pieces) = rounded(&std::mem::take(&mut stretch), physics);
                offset = run(&phases(&pieces, &shapes, physics), &shapes, physics, offset, &mut motion);
                let more = physics.wait.map_or(0.0, |(at, s)| if at == *line { s } else { 0.0 });
                let pause = seconds + more + if *tool_change { physics.tool_change } else { 0.0 };
                if let Some(shape) = &last {
                    let phase = Phase::standing(0, *line, shape.length(), pause);
                    offset = run(&[phase], std::slice::from_ref(shape), physics, offset, &mut motion);
                }
            }
        }
    }
    motion
}

/// Rounds the corners of a stretch and sets each piece's limits.
fn rounded(moves: &[(u32, Shape, f64)], physics: &Physics) -> (Vec<Shape>, Vec<Leg>) {
    let (mut shapes, mut pieces) = (Vec::new(), Vec::new());
    let mut push = |line: u32, shape: Shape, speed: f64| {
        let length = shape.length();
        if length < 1e-9 {
            return;
        }
        let curvature = shape.curvature();
        let mut piece = Leg {
            shape: shapes.len(),
            start: 0.0,
            line,
            length,
            speed,
            acceleration: physics.path_acceleration,
        };
        let weakest = physics.axis_acceleration.iter().copied().fold(ACCELERATION, f64::min);
        for axis in 0..3 {
            let share = shape.share(axis).max(1e-9);
            piece.speed = piece.speed.min(physics.axis_velocity[axis] / share);
            piece.acceleration =
                piece.acceleration.min(physics.axis_acceleration[axis].min(ACCELERATION) / share);
        }
        if 0.0 < curvature {
            let share = weakest / 2f64.sqrt();
            piece.speed = piece.speed.min((share.min(physics.centripetal) / curvature).sqrt());
            piece.acceleration = piece.acceleration.min(share);
        }
        shapes.push(shape);
        pieces.push(piece);
    };
    let mut begin = moves.first().map_or([0.0; 3], |m| m.1.point(0.0));
    for (i, (line, shape, speed)) in moves.iter().enumerate() {
        let Shape::Line { to, .. } = shape else {
            push(*line, shape.clone(), *speed);
            begin = shape.point(shape.length());
            continue;
        };
        match moves.get(i + 1) {
            Some((_, next @ Shape::Line { .. }, following)) => {
                let (u, w) = (shape.tangent(0.0), next.tangent(0.0));
                let step = norm(between(u, w));
                let leg =
                    (4.0 * physics.tolerance / step.max(1e-9)).min(shape.length().min(next.length()) / 2.0);
                if !(1e-6..=1.999).contains(&step) {
                    push(*line, Shape::Line { from: begin, to: *to }, *speed);
                    begin = *to;
                } else {
                    let (enter, leave) = (add(*to, -leg, u), add(*to, leg, w));
                    push(*line, Shape::Line { from: begin, to: enter }, *speed);
                    push(*line, Shape::parabola(enter, *to, leave), speed.min(*following));
                    begin = leave;
                }
            }
            _ => {
                push(*line, Shape::Line { from: begin, to: *to }, *speed);
                begin = *to;
            }
        }
    }
    (shapes, pieces)
}

fn phases(pieces: &[Leg], shapes: &[Shape], physics: &Physics) -> Vec<Phase> {
    let n = pieces.len();
    let jerk = physics.jerk.min(JERK);
    let mut joints = vec![0.0; n + 1];
    for i in 1..n {
        let (before, after) = (&shapes[pieces[i - 1].shape], &shapes[pieces[i].shape]);
        let step = norm(between(before.tangent(before.length()), after.tangent(0.0)));
        let smooth = step < 3e-4;
        joints[i] = if smooth { pieces[i - 1].speed.min(pieces[i].speed) } else { 0.0 };
    }
    profile(pieces, joints, jerk, physics.hold)
}
