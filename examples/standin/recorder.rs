//! The recorder: sample rate with jitter, standing time before the start, clock ratio, quantisation, noise,
//! gaps, with or without line numbers. Its times begin at nought, wherever the program began.

use std::fmt::Write;

use crate::physics::{Motion, TICK};
use crate::random::Random;

/// How a recording is taken.
#[derive(Clone, Debug)]
pub struct Recorder {
    pub rate: f64,
    /// Standing time before the motion, s.
    pub lead: f64,
    /// Deviation of the sampling instants, s, and of the positions, mm; least step of a position, mm.
    pub jitter: f64,
    pub noise: f64,
    pub quantum: f64,
    /// What its clock is off by although nothing is concealed: some ten parts in a million.
    pub drift: f64,
    /// Stretches without samples.
    pub gaps: usize,
    pub lines: bool,
}

impl Recorder {
    /// Draws a recorder; a slow one for long programs, so that no file becomes too large.
    pub fn draw(random: &mut Random) -> Recorder {
        let rate = random.pick(&[20.0, 50.0, 1000.0 / 9.0, 250.0, 500.0]);
        Recorder {
            rate,
            lead: random.uniform(0.05, 1.5),
            jitter: random.pick(&[0.0, 0.01, 0.03]) / rate,
            noise: random.pick(&[0.0, 0.0003, 0.0008]),
            quantum: random.pick(&[0.0001, 0.001]),
            drift: 3e-5 * random.normal(),
            gaps: if random.chance(0.15) { 1 + random.below(2) } else { 0 },
            lines: random.chance(0.3),
        }
    }

    /// One without errors, to measure with.
    pub fn ideal() -> Recorder {
        Recorder {
            rate: 250.0,
            lead: 0.5,
            jitter: 0.0,
            noise: 0.0,
            quantum: 1e-4,
            drift: 0.0,
            gaps: 0,
            lines: true,
        }
    }

    /// The recording as CSV, `clock` seconds of the recorder to one of the machine.
    pub fn record(&self, motion: &Motion, clock: f64, random: &mut Random) -> String {
        let mut text = String::from("t_s,x_mm,y_mm,z_mm");
        text += if self.lines { ",line\n" } else { "\n" };
        let total = self.lead + motion.position.len() as f64 * TICK + 0.3;
        let gaps: Vec<f64> = (0..self.gaps).map(|_| random.uniform(0.1, 0.9) * total).collect();
        let (last, period) = (motion.position.len() - 1, 1.0 / self.rate);
        for i in 0.. {
            let machine = (i as f64 * period + self.jitter * random.normal()).max(0.0);
            if total < machine {
                break;
            }
            let noise = [0; 3].map(|_| self.noise * random.normal());
            if gaps.iter().any(|gap| (*gap..gap + 0.15).contains(&machine)) {
                continue;
            }
            let at = ((machine - self.lead) / TICK).max(0.0);
            let (k, part) = ((at as usize).min(last), at.fract());
            let next = (k + 1).min(last);
            let read = |axis: usize| {
                let (a, b) = (motion.position[k][axis], motion.position[next][axis]);
                ((a + part * (b - a) + noise[axis]) / self.quantum).round() * self.quantum
            };
            // Adding nought turns −0 into 0.
            let (x, y, z) = (read(0) + 0.0, read(1) + 0.0, read(2) + 0.0);
            write!(text, "{:.4},{x:.4},{y:.4},{z:.4}", machine * clock * (1.0 + self.drift))
                .expect("text takes any length");
            if self.lines {
                write!(text, ",{}", motion.line[k]).expect("text takes any length");
            }
            text.push('\n');
        }
        text
    }
}
