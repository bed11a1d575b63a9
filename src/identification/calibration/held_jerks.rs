//! The jerk that the ramps of a recording hold.
//!
//! A planner that is limited in jerk alone ramps at J (mm/s³) up to the middle of a ramp and at −J from there on, so that
//! its acceleration changes by J T from each two of four successive windows of T (s) to the next two. If a distance may be
//! off by e (mm), J may be off by 4 e / T³. A part of a ramp counts if the path is straight, and if that error and the
//! difference of the two changes are at most the part [`MAX_DIFFERENCE_RATIO`] of J. If each axis has a limit, J is the
//! limit of the axis that moves furthest. The median of all of them is a start for a fit: a start from a wrong jerk ends in
//! a minimum where slow corners make up for short ramps.
//!
//! Limits: ramps shorter than eight samples show no jerk, nor does noise in fast sampling.

use crate::identification::alignment::{Track, median};
use crate::identification::calibration::rapid_moves::turns;
use crate::identification::calibration::rapids::largest_error;
use crate::identification::fit::Run;

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
    let parts: Vec<(usize, f64)> = tracks.flat_map(|track| parts(track)).collect();
    let held = |mut all: Vec<f64>| (MIN_PARTS <= all.len()).then(|| median(&mut all));
    let of_all = held(parts.iter().map(|(_, jerk)| *jerk).collect())?;
    let of_axis = |axis: usize| parts.iter().filter(move |part| part.0 == axis).map(|(_, jerk)| *jerk);
    Some([0, 1, 2].map(|axis| held(of_axis(axis).collect()).unwrap_or(of_all)))
}

/// Returns the parts of the ramps of a track: the axis that moves furthest, and its jerk.
fn parts(track: &Track) -> Vec<(usize, f64)> {
    let error = largest_error(track);
    let begins = |window: usize| {
        let end = track.time.len().saturating_sub(4 * window);
        (0..end).step_by(window).map(move |begin| (begin, window))
    };
    let all = WINDOWS.into_iter().flat_map(begins);
    all.filter_map(|(begin, window)| part(track, begin, window, error)).collect()
}

/// Returns the part of a ramp from the sample `begin` on, over four windows of `window` samples; `None` if its jerk is not
/// held, or if distances that are off by `error` (mm) hide it.
fn part(track: &Track, begin: usize, window: usize, error: f64) -> Option<(usize, f64)> {
    let seconds = (track.time[begin + 4 * window] - track.time[begin]) / 4.0;
    let [first, second] = [begin, begin + window].map(|from| track.successive_velocities(from, window));
    let changes = [first, second].map(|velocities| {
        let [before, within, after] = velocities.map(|velocity| velocity.norm());
        (after - 2.0 * within + before) / seconds.powi(2)
    });
    let held = 0.5 * (changes[0] + changes[1]).abs();
    let largest_difference = MAX_DIFFERENCE_RATIO * held;
    let is_held = (changes[0] - changes[1]).abs() <= largest_difference
        && 4.0 * error <= largest_difference * seconds.powi(3);
    let axis = second[0].iamax();
    let share = second[0][axis].abs() / second[0].norm();
    let is_straight = !turns(&first) && !turns(&second);
    (0.0 < held && is_held && is_straight).then_some((axis, held * share))
}
