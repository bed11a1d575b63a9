//! Changes of speed with limited acceleration and jerk, for both kernels.
//!
//! From speed v0 to v1 with acceleration a and jerk j takes, with Δ = |v1 − v0|,
//!
//!     T = Δ/a + a/j   where a²/j ≤ Δ,   else 2 √(Δ/j),         over   (v0 + v1) T / 2.
//!
//! The acceleration is nought at every joint of two legs. A backward and a forward pass lower the joints
//! to what the path can brake and reach; each leg then gets its seven segments, its peak found by
//! bisection. Either limit may be infinite; with both, speeds change at once.

use crate::schedule::Phase;

/// A piece of path with one speed limit, mm/s, and one acceleration, mm/s²; `start` in mm on its shape.
#[derive(Clone, Debug)]
pub struct Leg {
    pub shape: usize,
    pub line: u32,
    pub start: f64,
    pub length: f64,
    pub speed: f64,
    pub acceleration: f64,
}

/// Seconds to change speed by `change`, mm/s, from and to no acceleration.
fn ramp_seconds(change: f64, a: f64, j: f64) -> f64 {
    if a * a / j <= change { change / a + a / j } else { 2.0 * (change / j).sqrt() }
}

fn ramp_distance(v0: f64, v1: f64, a: f64, j: f64) -> f64 {
    (v0 + v1) / 2.0 * ramp_seconds((v1 - v0).abs(), a, j)
}

/// The largest of the values up to `high` that `fits`; `low` does.
fn largest(low: f64, high: f64, fits: impl Fn(f64) -> bool) -> f64 {
    if fits(high) {
        return high;
    }
    let (mut low, mut high) = (low, high);
    for _ in 0..50 {
        let middle = (low + high) / 2.0;
        if fits(middle) { low = middle } else { high = middle }
    }
    low
}

/// Runs through the legs, no faster at each joint than given, and stops in the line to hold in for its seconds.
pub fn profile(legs: &[Leg], mut joints: Vec<f64>, jerk: f64, hold: Option<(u32, f64)>) -> Vec<Phase> {
    let n = legs.len();
    let reach = |v: f64, cap: f64, p: &Leg| {
        if cap <= v {
            cap
        } else {
            largest(v, cap, |w| ramp_distance(v, w, p.acceleration, jerk) <= p.length)
        }
    };
    for i in (1..n).rev() {
        joints[i] = reach(joints[i + 1], joints[i], &legs[i]);
    }
    for i in 1..n {
        joints[i] = reach(joints[i - 1], joints[i], &legs[i - 1]);
    }
    let held_in = hold.and_then(|(line, _)| {
        let own = |leg: &&Leg| leg.line == line;
        let half = legs.iter().filter(own).map(|leg| leg.length).sum::<f64>() / 2.0;
        let mut run = 0.0;
        let passed = |leg: &Leg| {
            run += if leg.line == line { leg.length } else { 0.0 };
            leg.line == line && half <= run
        };
        legs.iter().position(passed)
    });
    let mut phases = Vec::new();
    for (i, leg) in legs.iter().enumerate() {
        let (v0, v1, a) = (joints[i], joints[i + 1], leg.acceleration);
        let used = |v: f64| ramp_distance(v0, v, a, jerk) + ramp_distance(v, v1, a, jerk);
        let peak = largest(v0.max(v1), leg.speed.max(v0).max(v1), |v| used(v) <= leg.length);
        let mut start = ramp(&mut phases, leg, leg.start, (v0, peak), a, jerk);
        let cruise = (leg.length - used(peak)).max(0.0);
        let halt = hold.filter(|_| held_in == Some(i)).map(|(_, seconds)| seconds);
        for part in 0..2 {
            if 1e-12 < cruise && 0.0 < peak {
                let seconds = cruise / 2.0 / peak;
                let (shape, line) = (leg.shape, leg.line);
                phases.push(Phase { shape, line, start, seconds, speed: peak, acceleration: 0.0, jerk: 0.0 });
                start += cruise / 2.0;
            }
            if let (0, Some(seconds)) = (part, halt) {
                phases.push(Phase::standing(leg.shape, leg.line, start, seconds));
            }
        }
        ramp(&mut phases, leg, start, (peak, v1), a, jerk);
    }
    phases
}

/// The three segments of one change of speed; gives where it ends.
fn ramp(phases: &mut Vec<Phase>, leg: &Leg, start: f64, (from, to): (f64, f64), a: f64, j: f64) -> f64 {
    let change = (to - from).abs();
    if change < 1e-12 || ramp_seconds(change, a, j) <= 0.0 {
        return start;
    }
    let sign = (to - from).signum();
    let seconds = ramp_seconds(change, a, j);
    // Without a limit of jerk the acceleration is there at once.
    let (rounding, steepest) =
        if a * a / j <= change { (a / j, sign * a) } else { (seconds / 2.0, sign * j * seconds / 2.0) };
    let (mut at, mut speed) = (start, from);
    for (t, acceleration, jerk) in [
        (rounding, 0.0, sign * j),
        (seconds - 2.0 * rounding, steepest, 0.0),
        (rounding, steepest, -sign * j),
    ] {
        if t <= 0.0 {
            continue;
        }
        let (shape, line) = (leg.shape, leg.line);
        phases.push(Phase { shape, line, start: at, seconds: t, speed, acceleration, jerk });
        at += t * (speed + t * (acceleration / 2.0 + t * jerk / 6.0));
        speed += t * (acceleration + t * jerk / 2.0);
    }
    at
}
