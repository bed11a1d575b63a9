//! The form of the path: recorded positions against simulated ones, time taken out.
//!
//! A recorded sample at t is compared with the simulated position at t − t0 − r̃(t) − δ, with r̃ = 0 where the
//! simulation is taken to lose no time, or else the median of the residual over [`AROUND`] on both sides,
//! which keeps jumps; and δ a delay common to all, such as drives
//! and recorders have. δ is found in one Newton step, δ = −Σ e·v / Σ v·v, for e the difference and v the
//! simulated velocity. The part of e along the motion counts by σ²/(σ² + (v τ)²), with σ the noise and τ what
//! stamps are uncertain by: at rapid speed a millisecond is a third of a millimetre. What is left is form: lag at corners, play at reversals, vibration.

use crate::identification::alignment::{Alignment, median};
use crate::machine::Machine;
use crate::simulation::drive::actual_motion;
use crate::simulation::feed::FeedPlan;
use crate::simulation::profile::{Profile, Resolution, Samples};
use crate::simulation::toolpath::Toolpath;

/// Half the time over which the residual is a median, s.
const AROUND: f64 = 1.0;
/// Samples compared at most.
const MOST_SAMPLES: usize = 8000;
/// How far stamps of recorders are off, s; times the speed it is a difference along the motion.
const STAMPS: f64 = 1e-3;
/// Newton's steps for the delay, and the step that is none, s.
const STEPS: usize = 8;
const CLOSE_ENOUGH: f64 = 1e-6;

/// Recorded positions with the simulated times they belong to.
pub struct Form {
    samples: Samples,
    /// Simulated time, s, and recorded position of each sample compared.
    rows: Vec<(f64, [f64; 3])>,
    recorded: [bool; 3],
    /// Standard deviation of a recorded coordinate, mm.
    noise: f64,
}

impl Form {
    /// Of a run whose simulation is at the marks at these times (s) and, where it loses time, has these
    /// residuals (s) there; none without positions.
    pub fn new(
        toolpath: &Toolpath,
        plan: &FeedPlan,
        alignment: &Alignment,
        simulated: &[f64],
        residuals: Option<&[f64]>,
    ) -> Option<Form> {
        let track = alignment.track.as_ref()?;
        let offset = alignment.marks.first()?.time - simulated.first()?;
        let smooth = residuals.map_or(vec![0.0; simulated.len()], |residuals| medians(simulated, residuals));
        let every = alignment.fixes.len().div_ceil(MOST_SAMPLES).max(1);
        let mut mark = 0;
        let mut rows = Vec::new();
        for fix in alignment.fixes.iter().step_by(every) {
            let Some(sample) = fix.sample else { continue };
            while mark + 1 < alignment.marks.len() && alignment.marks[mark + 1].time <= fix.time {
                mark += 1;
            }
            let at = track.position[sample];
            rows.push((fix.time - offset - smooth[mark], [at.x, at.y, at.z]));
        }
        let samples = Profile::new(toolpath, plan).samples(Resolution { feedrate: 2e-3, position: 5e-4 });
        Some(Form { samples, rows, recorded: track.recorded, noise: track.noise.max(2e-3) })
    }

    /// Root mean square of the distance between recorded and simulated positions on a machine with these
    /// drives, mm, and the delay at which it is least, s.
    pub fn error(&self, machine: &Machine) -> (f64, f64) {
        let actual = actual_motion(&self.samples, machine);
        let (mut delay, mut best) = (0.0, 0.0);
        let mut rms = f64::INFINITY;
        for _ in 0..STEPS {
            let (mut along, mut speed, mut squares) = (0.0, 0.0, 0.0);
            let mut row = 0;
            for (time, position) in &self.rows {
                let (forward, own, square) = self.difference(&actual, time - delay, position, &mut row);
                along += forward;
                speed += own;
                squares += square;
            }
            let found = f64::sqrt(squares / self.rows.len().max(1) as f64);
            if found < rms {
                (rms, best) = (found, delay);
            }
            let step = if 0.0 < speed { along / speed } else { 0.0 };
            if step.abs() < CLOSE_ENOUGH {
                break;
            }
            delay -= step;
        }
        (rms, best)
    }

    /// The squares of which `error` takes the root of the mean, mm², in so many contiguous parts of the recording.
    pub fn parts(&self, machine: &Machine, count: usize) -> Vec<f64> {
        let (_, delay) = self.error(machine);
        let actual = actual_motion(&self.samples, machine);
        let mut row = 0;
        let mut square =
            |(time, position): &(f64, [f64; 3])| self.difference(&actual, time - delay, position, &mut row).2;
        let parts = self.rows.chunks(self.rows.len().div_ceil(count).max(1));
        parts.map(|part| part.iter().map(&mut square).sum()).collect()
    }

    /// Of a position to that of a table at a time: e·v, v·v, and the square that counts.
    fn difference(
        &self,
        actual: &Samples,
        time: f64,
        position: &[f64; 3],
        row: &mut usize,
    ) -> (f64, f64, f64) {
        let (there, velocity) = actual.motion_at(time, row);
        let (mut all, mut forward, mut own) = (0.0, 0.0, 0.0);
        for axis in (0..3).filter(|axis| self.recorded[*axis]) {
            let difference = position[axis] - there[axis];
            all += difference * difference;
            forward += difference * velocity[axis];
            own += velocity[axis] * velocity[axis];
        }
        // What lies along the motion counts as far as the stamps are worth it.
        let ahead = if 0.0 < own { forward * forward / own } else { 0.0 };
        let certain = self.noise * self.noise;
        let square = (all - ahead).max(0.0) + ahead * certain / (certain + own * STAMPS * STAMPS);
        (forward, own, square)
    }
}

/// The median of the residuals around each mark, at so many places that the cost is linear.
fn medians(simulated: &[f64], residuals: &[f64]) -> Vec<f64> {
    let mut smooth = vec![0.0; residuals.len()];
    let mut window = Vec::new();
    let (mut from, mut to) = (0, 0);
    let mut last = f64::NEG_INFINITY;
    for at in 0..residuals.len() {
        if simulated[at] - last < 0.1 * AROUND && 0 < at {
            smooth[at] = smooth[at - 1];
            continue;
        }
        last = simulated[at];
        while to < residuals.len() && simulated[to] <= simulated[at] + AROUND {
            to += 1;
        }
        while simulated[from] < simulated[at] - AROUND {
            from += 1;
        }
        window.clear();
        window.extend_from_slice(&residuals[from..to]);
        smooth[at] = median(&mut window);
    }
    smooth
}
