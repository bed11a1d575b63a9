//! Time stepping: a list of phases of constant jerk along the path becomes positions at a fixed tick.
//!
//! Within a phase s(t) = s0 + v t + a t²/2 + j t³/6. The operator's and the outside effects act here, on
//! how fast the schedule is run through: m(t, p) seconds of schedule a second.

use crate::path::{Shape, Vector};
use crate::physics::{Motion, Physics, TICK};

/// A stretch of time with constant jerk, on one shape.
#[derive(Clone, Copy, Debug)]
pub struct Phase {
    /// Index of the shape, and the program line.
    pub shape: usize,
    pub line: u32,
    /// Where on the shape it begins, mm, and its seconds, speed, acceleration and jerk there.
    pub start: f64,
    pub seconds: f64,
    pub speed: f64,
    pub acceleration: f64,
    pub jerk: f64,
}

impl Phase {
    /// Standing still at the end of a shape.
    pub fn standing(shape: usize, line: u32, start: f64, seconds: f64) -> Phase {
        Phase { shape, line, start, seconds, speed: 0.0, acceleration: 0.0, jerk: 0.0 }
    }

    fn at(&self, t: f64) -> f64 {
        self.start + t * (self.speed + t * (self.acceleration / 2.0 + t * self.jerk / 6.0))
    }

    fn speed_at(&self, t: f64) -> f64 {
        self.speed + t * (self.acceleration + t * self.jerk / 2.0)
    }
}

/// Runs through `phases`, `offset` seconds before the first of which the next tick lies; gives the
/// seconds that the last tick falls short of the end.
pub fn run(phases: &[Phase], shapes: &[Shape], physics: &Physics, offset: f64, motion: &mut Motion) -> f64 {
    let mut wanted = TICK - offset;
    let mut since = 0.0;
    for phase in phases {
        let mut local = 0.0;
        let mut spent = 0.0;
        loop {
            let point = shapes[phase.shape].point(phase.at(local));
            let pace = pace(physics, motion.position.len() as f64 * TICK, point, phase.speed_at(local));
            let step = (wanted - since).max(0.0) * pace;
            if phase.seconds < local + step {
                since += (phase.seconds - local) / pace;
                spent += (phase.seconds - local) / pace;
                break;
            }
            local += step;
            spent += wanted - since;
            motion.position.push(shapes[phase.shape].point(phase.at(local)));
            motion.line.push(phase.line);
            (wanted, since) = (TICK, 0.0);
        }
        *motion.line_seconds.entry(phase.line).or_default() += spent;
        motion.cycle_time += spent;
    }
    TICK - (wanted - since)
}

/// Seconds of schedule a second.
fn pace(physics: &Physics, time: f64, at: Vector, speed: f64) -> f64 {
    let mut pace = 1.0;
    if speed <= 0.0 {
        return pace;
    }
    if let Some((depth, frequency)) = physics.modulation {
        pace *= 1.0 - depth * (0.5 + 0.5 * (std::f64::consts::TAU * frequency * time).sin());
    }
    if let Some((from, to, ratio)) = physics.zone
        && (from..to).contains(&at[0])
    {
        pace *= ratio;
    }
    if let Some((limit, slope)) = physics.falling {
        pace *= ((limit - slope * at[0]).max(5.0) / speed).min(1.0);
    }
    pace
}
