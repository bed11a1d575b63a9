//! The jerk that the ramps of a recording hold.
//!
//! A planner that is limited in jerk alone ramps at J (mm/s³) up to the middle of a ramp and at −J from there on. Five
//! successive windows of T (s) then have four accelerations between them, which change by J T from one to the next; where a
//! trapezoid begins, only two such changes may be alike. If a distance may be off by e (mm), J may be off by 4 e / T³. A part
//! of a ramp counts if the path is straight, and if that error and the differences of the changes are at most the part
//! [`MAX_DIFFERENCE_RATIO`] of J. The limit of the axis that moves furthest counts. The median of all parts is a start for a
//! fit: a start from a wrong jerk ends in a minimum where slow corners make up for short ramps.
//!
//! Limits: ramps shorter than five samples show no jerk, nor does noise in fast sampling.

use crate::identification::alignment::{Track, median};
use crate::identification::calibration::held_accelerations::successive_windows;
use crate::identification::calibration::rapid_moves::turns;
use crate::identification::calibration::rapids::largest_error;
use crate::identification::fit::Run;

/// Number of successive windows of a part of a ramp.
const WINDOWS_OF_PART: usize = 5;
/// Windows that are tried, samples.
const WINDOWS: [usize; 6] = [1, 2, 4, 8, 16, 32];
/// Largest difference of the jerks of a ramp, and their largest error, as a part of them.
const MAX_DIFFERENCE_RATIO: f64 = 0.1;
/// Least number of parts of ramps that show a jerk.
const MIN_PARTS: usize = 10;

/// Returns the jerk that the ramps of runs hold along each axis, mm/s³. An axis that shows none has the median of all.
/// Returns `None` if no axis shows one.
pub fn held_jerks(runs: &[Run]) -> Option<[f64; 3]> {
    let tracks = runs.iter().filter_map(|run| run.alignment.track.as_ref());
    held_by(&tracks.flat_map(|track| parts(track)).collect::<Vec<(usize, f64)>>())
}

/// Returns [`held_jerks`] from the parts of all ramps.
fn held_by(parts: &[(usize, f64)]) -> Option<[f64; 3]> {
    let held = |mut all: Vec<f64>| (MIN_PARTS <= all.len()).then(|| median(&mut all));
    let of_all = held(parts.iter().map(|(_, jerk)| *jerk).collect())?;
    let of_axis = |axis: usize| parts.iter().filter(move |part| part.0 == axis).map(|(_, jerk)| *jerk);
    Some([0, 1, 2].map(|axis| held(of_axis(axis).collect()).unwrap_or(of_all)))
}

/// Returns the parts of the ramps of a track: the axis that moves furthest, and its jerk.
fn parts(track: &Track) -> Vec<(usize, f64)> {
    let error = largest_error(track);
    let all = successive_windows(track, &WINDOWS, WINDOWS_OF_PART);
    all.filter_map(|(begin, window)| part(track, begin, window, error)).collect()
}

/// Returns the part of a ramp from the sample `begin` on, in windows of `window` samples; `None` if its jerk is not held, or
/// if distances that are off by `error` (mm) hide it.
fn part(track: &Track, begin: usize, window: usize, error: f64) -> Option<(usize, f64)> {
    let seconds = (track.time[begin + WINDOWS_OF_PART * window] - track.time[begin]) / WINDOWS_OF_PART as f64;
    let velocities = [0, 1, 2].map(|part| track.successive_velocities(begin + part * window, window));
    let jerks = velocities.map(|velocities| {
        let [before, within, after] = velocities.map(|velocity| velocity.norm());
        (after - 2.0 * within + before) / seconds.powi(2)
    });
    let held = jerks[1].abs();
    let largest_difference = MAX_DIFFERENCE_RATIO * held;
    let is_held = jerks.iter().all(|jerk| (jerk - jerks[1]).abs() <= largest_difference)
        && 4.0 * error <= largest_difference * seconds.powi(3);
    let middle = velocities[1][1];
    let axis = middle.iamax();
    (0.0 < held && is_held && !velocities.iter().any(turns))
        .then(|| (axis, held * middle[axis].abs() / middle.norm()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation::toolpath::{Point, Vector};

    const INTERVAL_S: f64 = 0.004;
    const FEEDRATE_MM_S: f64 = 50.0;

    /// Distance within a ramp from rest, as a part of feedrate times duration, at a part of its duration.
    type Ramp = fn(part: f64) -> f64;

    /// Constant jerk up to the middle, and its opposite from there on.
    fn s_curve(part: f64) -> f64 {
        if part < 0.5 { 2.0 / 3.0 * part.powi(3) } else { part - 0.5 + 2.0 / 3.0 * (1.0 - part).powi(3) }
    }

    fn trapezoid(part: f64) -> f64 {
        0.5 * part * part
    }

    /// Returns the jerks of ramps of each axis and duration (s), from rest and back to it, with positions off by `error` (mm).
    fn held(ramps: &[(usize, f64)], ramp: Ramp, error: f64) -> Option<[f64; 3]> {
        let (mut time, mut position, mut at) = (Vec::new(), Vec::new(), Point::origin());
        for (axis, seconds) in ramps.iter().cycle().take(12) {
            let whole = FEEDRATE_MM_S * seconds;
            for sample in 0..(2.0 * seconds / INTERVAL_S) as usize {
                let part = INTERVAL_S * sample as f64 / seconds;
                let travel = whole * if part < 1.0 { ramp(part) } else { 1.0 - ramp(2.0 - part) };
                let noise = if time.len() % 2 == 0 { error } else { -error };
                time.push(INTERVAL_S * time.len() as f64);
                position.push(at + Vector::ith(*axis, travel + noise));
            }
            at[*axis] += whole;
        }
        let track = Track {
            time,
            position,
            recorded: [true; 3],
            noise: error,
            interval: INTERVAL_S,
            steps: [0.0; 3],
        };
        held_by(&parts(&track))
    }

    #[test]
    fn ramps_hold_the_jerk_of_each_axis() {
        let found = held(&[(0, 0.12), (1, 0.2)], s_curve, 1e-6).expect("there are ramps");
        // Δv = J T² / 4.
        let [x, y] = [0.12, 0.2].map(|seconds: f64| 4.0 * FEEDRATE_MM_S / seconds.powi(2));
        assert!((found[0] / x - 1.0).abs() < 0.01 && (found[1] / y - 1.0).abs() < 0.01, "{found:?}");
        // Z does not move.
        assert!((y..=x).contains(&found[2]), "{found:?}");
    }

    #[test]
    fn trapezoids_noise_and_short_ramps_hold_none() {
        assert_eq!(held(&[(0, 0.12), (1, 0.2)], trapezoid, 1e-6), None);
        assert_eq!(held(&[(0, 0.12), (1, 0.2)], s_curve, 0.5), None);
        assert_eq!(held(&[(0, 0.008), (1, 0.008)], s_curve, 1e-6), None);
    }
}
