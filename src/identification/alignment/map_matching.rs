//! Recorded positions → distance along the path over time.
//!
//! The tool never moves back along its path, and between two samples it moves along the path by about its
//! displacement. Of all tracks through the places near each sample the search finds the one with the least
//! cost,
//!
//! ```text
//! Σ ρ(d / σ_d) + ρ((Δs − |Δp|) / σ_s),    ρ(x) = x² for x ≤ 3, then 6 x − 9
//! ```
//!
//! with d (mm) the distance from the path, σ_d and σ_s (mm) the standard deviations, Δs ≥ 0 (mm) the length
//! along the path and |Δp| (mm) the displacement between the samples. A sample may also be off the path, at a
//! fixed cost: machines move to their tool changer. The search (a Viterbi algorithm) keeps the few cheapest
//! tracks from sample to sample, each with a short look-ahead. Its time is therefore linear, and it follows a
//! path that crosses or retraces itself in order, where the nearest point alone would jump. Time is never
//! stretched.
//!
//! At the end of the path, and off the path, a track may also restart: this divides a recording of several
//! passes, and separates the moves before and after a run.
//!
//! A sample is used once the tool has moved by several standard deviations of the noise since the last one
//! used. Source: map matching by hidden Markov models, Newson and Krumm 2009.

use crate::identification::alignment::path::{Path, Projection};
use crate::identification::alignment::{AlignmentError, Fix};
use crate::identification::recording::{Axes, Channel, noise};
use crate::simulation::ordered::sort_by_number;
use crate::simulation::sampled::rows_around;
use crate::simulation::toolpath::{Point, Vector};

/// Most tracks kept from sample to sample.
const MAX_TRACKS: usize = 6;
/// Most tracks kept at the beginning, when the place is unknown.
const MAX_FIRST_TRACKS: usize = 64;
/// Cost of a sample off the path, and so the largest cost of a sample on it.
const OFF_PATH_COST: f64 = 60.0;
/// Cost of a new beginning; the cost of two samples off the path must exceed it.
const RESTART_COST: f64 = 2.0 * OFF_PATH_COST;
/// Least length of a whole pass, as a part of the longest pass.
pub const MIN_PASS_RATIO: f64 = 0.9;
/// Approximate limit of the number of samples used.
const MAX_SAMPLES: usize = 150_000;
/// Least duration of a repeated position that counts as a rest of the tool, s.
const MIN_REST_S: f64 = 0.1;
/// Least displacement of a moving tool, in standard deviations of the noise.
pub const MIN_DISPLACEMENT_SIGMAS: f64 = 6.0;
/// Part of the length off the path below which the coarse pass is skipped.
const MAX_CLOSE_OFF_PATH: f64 = 0.05;
/// Factor on the allowed distance from the path in the coarse pass.
pub const COARSE_DISTANCE_FACTOR: f64 = 8.0;
/// Largest part of the recorded length that may be off the path.
const MAX_OFF_PATH_RATIO: f64 = 0.3;
/// Least noise of a recorder of positions, mm.
const MIN_NOISE_MM: f64 = 2e-4;
/// Least step of recorded positions, mm: a finer one does not differ from noise.
const MIN_STEP_MM: f64 = 5e-4;
/// Largest error of a recorded position by the rounding of the number itself, mm.
const ROUNDING_MM: f64 = 1e-6;
/// Number of parts into which controls divide the number of steps in a millimetre: grbl's `$100` has three decimals.
const STEPS_PER_MM_RESOLUTION: f64 = 1000.0;
/// Largest relative error of a step read off recorded positions.
const MAX_STEP_ERROR_RATIO: f64 = 1e-6;

/// Positions of all axes at common stamps.
#[derive(Clone, Debug)]
pub struct Track {
    /// Stamps, s, ascending.
    pub time: Vec<f64>,
    /// Positions, mm; 0 in axes that were not recorded.
    pub position: Vec<Point>,
    /// Recorded axes.
    pub recorded: [bool; 3],
    /// Standard deviation of the noise of one coordinate, mm.
    pub noise: f64,
    /// Median time between samples, s.
    pub interval: f64,
    /// Distances of which all recorded positions of an axis are multiples, mm; 0 if there is none.
    pub steps: [f64; 3],
}

impl Track {
    /// Returns the mean velocity between two samples, mm/s.
    pub fn velocity_between(&self, from: usize, to: usize) -> Vector {
        (self.position[to] - self.position[from]) / (self.time[to] - self.time[from])
    }

    /// Returns the mean velocities over three successive windows of `window` samples from the sample `first` on, mm/s.
    pub fn successive_velocities(&self, first: usize, window: usize) -> [Vector; 3] {
        [0, 1, 2].map(|part| self.velocity_between(first + part * window, first + (part + 1) * window))
    }
}

/// The places of the samples of a pass.
pub struct MatchedPass {
    /// Distances of the tool over time, both ascending, without samples off the path.
    pub fixes: Vec<Fix>,
    /// Part of the recorded length between the first and the last fix that is off the path.
    pub off_path: f64,
    /// Recorded length on the path, mm.
    pub on_path: f64,
    /// Total recorded length, mm, including other passes and moves outside of any.
    pub recorded: f64,
    /// RMS distance from the path, mm.
    pub spread: f64,
    /// Number of passes of the program in the recording; this is the first whole one.
    pub passes: usize,
}

impl MatchedPass {
    /// Returns the part of the recording that this pass makes up, or of a path of length `path` (mm) if that
    /// part is larger.
    pub fn part(&self, path: f64) -> f64 {
        self.on_path / self.recorded.min(path).max(1e-9)
    }

    /// Returns `true` if enough of the recorded length is on the path for the recording to belong to it.
    pub fn is_on_path(&self) -> bool {
        self.off_path <= MAX_OFF_PATH_RATIO
    }
}

impl Track {
    /// Returns the positions of a recording; `None` if no axis was recorded or there are too few samples.
    pub fn new(axes: &Axes) -> Option<Track> {
        let longest = axes.iter().flatten().max_by_key(|channel| channel.time.len())?;
        let time = longest.time.to_vec();
        if time.len() < 3 {
            return None;
        }
        let columns = axes.each_ref().map(|axis| axis.as_ref().map(|channel| on_stamps(channel, &time)));
        let position = (0..time.len())
            .map(|row| {
                let at = |axis: usize| columns[axis].as_ref().map_or(0.0, |column| column[row]);
                Point::new(at(0), at(1), at(2))
            })
            .collect();
        let all: Vec<Point> = position;
        // A repeated position is not a further sample; of a position at rest the last one marks the end of
        // the rest.
        let repeats = |row: usize| row != 0 && all[row] == all[row - 1];
        let mut kept: Vec<usize> = Vec::with_capacity(all.len());
        for row in 0..all.len() {
            let ends = repeats(row) && (row + 1 == all.len() || !repeats(row + 1));
            let stays = kept.last().is_some_and(|first| MIN_REST_S < time[row] - time[*first]);
            if !repeats(row) || (ends && stays) {
                kept.push(row);
            }
        }
        let position: Vec<Point> = kept.iter().map(|row| all[*row]).collect();
        let time: Vec<f64> = kept.iter().map(|row| time[*row]).collect();
        if time.len() < 3 {
            return None;
        }
        let columns = columns
            .map(|column| column.map(|column| kept.iter().map(|row| column[*row]).collect::<Vec<f64>>()));
        let steps = columns.each_ref().map(|column| column.as_ref().map_or(0.0, |column| lattice(column)));
        let recorded = columns.iter().zip(steps).filter_map(|(column, step)| Some((column.as_ref()?, step)));
        let mut noises: Vec<f64> = recorded.map(|(column, step)| noise_and_rounding(column, step)).collect();
        noises.sort_by(f64::total_cmp);
        let noise = noises.last().copied().unwrap_or(0.0).max(MIN_NOISE_MM);
        let mut intervals: Vec<f64> = time.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let interval = median(&mut intervals);
        Some(Track { time, position, recorded: axes.each_ref().map(Option::is_some), noise, interval, steps })
    }

    /// Returns the recorded positions without those at which the tool has hardly moved, mm.
    pub fn polyline(&self) -> Vec<Point> {
        self.moved().into_iter().map(|sample| self.position[sample]).collect()
    }

    /// Returns the indices of the samples at which the tool has moved, the first included.
    fn moved(&self) -> Vec<usize> {
        let mut step = MIN_DISPLACEMENT_SIGMAS * self.noise;
        loop {
            let mut moved = vec![0];
            let mut last = self.position[0];
            for (index, position) in self.position.iter().enumerate() {
                if step <= (position - last).norm() {
                    moved.push(index);
                    last = *position;
                }
            }
            if moved.len() <= MAX_SAMPLES {
                return moved;
            }
            step *= 2.0;
        }
    }

    /// Returns a vector without its components in axes that were not recorded.
    pub fn in_recorded_axes(&self, vector: Vector) -> Vector {
        Vector::from_fn(|axis, _| if self.recorded[axis] { vector[axis] } else { 0.0 })
    }

    /// Returns the positions with `shift` (mm) subtracted, in the axes that were recorded.
    pub fn shifted(&self, shift: Vector) -> Track {
        let shift = self.in_recorded_axes(shift);
        let position = self.position.iter().map(|position| position - shift).collect();
        Track { time: self.time.clone(), position, ..*self }
    }
}

/// A track through the samples so far: a state of the search.
#[derive(Clone, Copy)]
struct TrackState {
    along: f64,
    cost: f64,
    /// Index of its predecessor among the tracks of the sample before.
    from: u32,
    /// Distance of the sample from the path, mm; infinite if it is off the path.
    away: f64,
}

/// Returns the cheapest track of recorded positions along a path; `tolerance` (mm) is the largest deviation
/// at corners. Axes that lag or vibrate leave the path by more, so a poor fit is followed by a coarse pass.
///
/// # Errors
///
/// Returns an error if the recording is at rest, is nowhere near the path, or leaves it too often.
pub fn follow(track: &Track, path: &Path, tolerance: f64) -> Result<MatchedPass, AlignmentError> {
    let samples = track.moved();
    if samples.len() < 3 {
        return Err(AlignmentError::StandsStill);
    }
    let scale = scale(track, tolerance);
    let closely = follow_within(track, &samples, path, scale);
    let missing = |matched: &Result<MatchedPass, _>| {
        matched.as_ref().map_or(1.0, |matched| matched.off_path.max(1.0 - matched.part(path.length())))
    };
    if missing(&closely) < MAX_CLOSE_OFF_PATH {
        return closely;
    }
    let afar = follow_within(track, &samples, path, COARSE_DISTANCE_FACTOR * scale);
    if missing(&afar) < missing(&closely) { afar } else { closely }
}

/// Returns the allowed distance from the path (mm) of a tool that deviates at corners by `tolerance` (mm).
pub fn scale(track: &Track, tolerance: f64) -> f64 {
    (2.0 * tolerance).max(3.0 * track.noise).max(0.02)
}

fn follow_within(
    track: &Track,
    samples: &[usize],
    path: &Path,
    scale: f64,
) -> Result<MatchedPass, AlignmentError> {
    let mut columns: Vec<Vec<TrackState>> = Vec::with_capacity(samples.len());
    let mut ways: Vec<TrackState> = Vec::new();
    let mut feet = Vec::new();
    let mut next: Vec<TrackState> = Vec::new();
    let mut pace = 0.0f64;
    let first = first_states(track, samples, path, scale);
    let Some((begin, start)) = first else { return Err(AlignmentError::NowhereNear) };
    for (order, &sample) in samples.iter().enumerate().skip(begin) {
        let point = track.position[sample];
        if order == begin {
            ways = start.iter().map(|foot| entered(foot, scale)).collect();
            columns.push(ways.clone());
            continue;
        }
        let before = samples[order - 1];
        let moved = (point - track.position[before]).norm();
        let elapsed = (track.time[sample] - track.time[before]).max(track.interval);
        let expected = moved.max(pace * elapsed.min(20.0 * track.interval));
        pace = if elapsed < 3.0 * track.interval { moved / elapsed } else { 0.0 };
        next.clear();
        for (from, way) in ways.iter().enumerate() {
            let ahead = 1.6 * expected + 4.0 * scale;
            path.nearest(point, way.along..way.along + ahead, &mut feet);
            let sigma = 0.3 * moved + 3.0 * track.noise + scale;
            for foot in &feet {
                let step = foot.along - way.along;
                let cost = way.cost + robust(foot.away / scale) + robust((step - moved) / sigma);
                next.push(TrackState { along: foot.along, cost, from: from as u32, away: foot.away });
            }
            next.push(TrackState {
                cost: way.cost + OFF_PATH_COST,
                from: from as u32,
                away: f64::INFINITY,
                ..*way
            });
        }
        next.extend(restarted(point, ways[0], path, scale, &mut feet));
        sort_by_number(&mut next, |one| one.cost);
        let keep = if order < begin + 50 { MAX_FIRST_TRACKS } else { MAX_TRACKS };
        ways.clear();
        for way in &next {
            let is_new = |kept: &TrackState| 1e-6 < (kept.along - way.along).abs();
            if ways.iter().all(is_new) {
                ways.push(*way);
                if ways.len() == keep {
                    break;
                }
            }
        }
        columns.push(ways.clone());
    }
    Ok(traced_back(track, &samples[begin..], &columns))
}

/// Returns tracks that restart near `point`, if the cheapest so far is at the end of the path or off the
/// path.
fn restarted(
    point: Point,
    best: TrackState,
    path: &Path,
    scale: f64,
    feet: &mut Vec<Projection>,
) -> Vec<TrackState> {
    feet.clear();
    if best.away.is_infinite() || path.length() - path.entry() < best.along {
        path.nearest(point, 0.0..path.entry(), feet);
    }
    let begins = feet.iter().filter(|foot| foot.away < 5.0 * scale && foot.along < best.along);
    begins
        .map(|foot| TrackState {
            cost: best.cost + RESTART_COST + robust(foot.away / scale),
            ..entered(foot, scale)
        })
        .collect()
}

fn entered(foot: &Projection, scale: f64) -> TrackState {
    TrackState { along: foot.along, cost: robust(foot.away / scale), from: 0, away: foot.away }
}

/// Returns the first sample near the path and its possible places; the beginning of the path comes first if
/// the sample is near it.
fn first_states(
    track: &Track,
    samples: &[usize],
    path: &Path,
    scale: f64,
) -> Option<(usize, Vec<Projection>)> {
    let mut feet = Vec::new();
    let mut order = 0;
    while order < samples.len() {
        let point = track.position[samples[order]];
        path.nearest(point, 0.0..f64::INFINITY, &mut feet);
        feet.retain(|foot| foot.away < 5.0 * scale);
        if !feet.is_empty() {
            sort_by_number(&mut feet, |foot| foot.away);
            let mut first: Vec<Projection> = feet.iter().copied().filter(|foot| foot.along < scale).collect();
            first.extend(feet.iter().take(MAX_FIRST_TRACKS));
            first.truncate(MAX_FIRST_TRACKS);
            return Some((order, first));
        }
        order += (samples.len() / 200).max(1);
    }
    None
}

/// Returns the pass of the cheapest track, traced back sample by sample.
fn traced_back(track: &Track, samples: &[usize], columns: &[Vec<TrackState>]) -> MatchedPass {
    let mut way = 0;
    let mut steps = Vec::with_capacity(samples.len());
    for order in (0..columns.len()).rev() {
        let TrackState { along, away, from, .. } = columns[order][way];
        let sample = samples[order];
        let before = order.checked_sub(1).map_or(sample, |order| samples[order]);
        let moved = (track.position[sample] - track.position[before]).norm();
        steps.push(TrackStep { sample, along, away, moved });
        way = from as usize;
    }
    steps.reverse();
    let begins = (1..steps.len()).filter(|at| steps[*at].along < steps[at - 1].along);
    let bounds: Vec<usize> = [0].into_iter().chain(begins).chain([steps.len()]).collect();
    let passes = bounds.windows(2).map(|pair| trimmed(&steps[pair[0]..pair[1]]));
    let passes: Vec<&[TrackStep]> = passes.filter(|pass| !pass.is_empty()).collect();
    let longest = passes.iter().map(|pass| progress(pass)).fold(0.0, f64::max);
    let whole: Vec<&[TrackStep]> =
        passes.into_iter().filter(|pass| MIN_PASS_RATIO * longest <= progress(pass)).collect();
    let recorded = steps.iter().map(|step| step.moved).sum();
    matched(track, whole.first().copied().unwrap_or_default(), recorded, whole.len())
}

/// A sample on the cheapest track.
struct TrackStep {
    sample: usize,
    along: f64,
    /// Distance from the path, mm; infinite if it is off the path.
    away: f64,
    /// Displacement since the sample before, mm.
    moved: f64,
}

/// Returns a pass from its first sample on the path to its last.
fn trimmed(pass: &[TrackStep]) -> &[TrackStep] {
    let is_on = |step: &TrackStep| step.away.is_finite();
    let first = pass.iter().position(is_on).unwrap_or(pass.len());
    let last = pass.iter().rposition(is_on).map_or(first, |last| last + 1);
    &pass[first..last]
}

fn progress(pass: &[TrackStep]) -> f64 {
    pass.first().zip(pass.last()).map_or(0.0, |(first, last)| last.along - first.along)
}

fn matched(track: &Track, pass: &[TrackStep], recorded: f64, passes: usize) -> MatchedPass {
    let on = || pass.iter().filter(|step| step.away.is_finite());
    // The move to the first sample of the pass does not belong to it.
    let way = |steps: &mut dyn Iterator<Item = &TrackStep>| steps.map(|step| step.moved).sum::<f64>();
    let entry = pass.first().map_or(0.0, |step| step.moved);
    let (all, on_path) = (way(&mut pass.iter()) - entry, way(&mut on()) - entry);
    let squares: f64 = on().map(|step| step.away * step.away).sum();
    MatchedPass {
        fixes: on()
            .map(|step| Fix {
                time: track.time[step.sample],
                distance: step.along,
                sample: Some(step.sample),
            })
            .collect(),
        off_path: if 0.0 < all { 1.0 - on_path / all } else { 1.0 },
        on_path,
        recorded,
        spread: (squares / (on().count() as f64).max(1.0)).sqrt(),
        passes,
    }
}

fn robust(x: f64) -> f64 {
    let x = x.abs();
    if x <= 3.0 { x * x } else { 6.0 * x - 9.0 }
}

/// Returns a channel's values at other stamps, linear between its own.
fn on_stamps(channel: &Channel<f64>, time: &[f64]) -> Vec<f64> {
    if channel.time[..] == *time {
        return channel.values.clone();
    }
    let mut row = 0;
    let mut value = |stamp: &f64| {
        rows_around(&channel.time, *stamp, &mut row).map_or(0.0, |rows| rows.between(&channel.values))
    };
    time.iter().map(&mut value).collect()
}

/// Returns the standard deviation of the noise of a column, mm, no less than half the `step` (mm) of a lattice that its
/// values lie on.
fn noise_and_rounding(column: &[f64], step: f64) -> f64 {
    noise(column).min(0.05).max(0.5 * step.min(0.01))
}

/// Returns the largest distance of which all changes of a column are multiples, mm; 0 if there is none.
fn lattice(column: &[f64]) -> f64 {
    let changes = || column.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    let mut step = 0.0;
    for change in changes() {
        step = common_divisor(step, change);
        if 0.0 < step && step < MIN_STEP_MM {
            return 0.0;
        }
    }
    if step == 0.0 {
        return 0.0;
    }
    // The common divisor has the rounding errors of a few changes; a path of thousands of steps adds them up.
    let counted: f64 = changes().map(|change| (change / step).round()).sum();
    with_decimal_steps_per_mm(changes().sum::<f64>() / counted)
}

/// Returns the nearest step (mm) of which a millimetre has a number with as many decimals as controls have, if it is as near
/// as rounding allows; otherwise returns the step unchanged. A step that is off by its rounding would move the programmed
/// points that lie halfway between two steps to the wrong one.
fn with_decimal_steps_per_mm(step: f64) -> f64 {
    let decimal = STEPS_PER_MM_RESOLUTION / (STEPS_PER_MM_RESOLUTION / step).round();
    if (decimal - step).abs() < MAX_STEP_ERROR_RATIO * step { decimal } else { step }
}

/// Returns the largest common divisor of two distances, mm; 0 if both are.
fn common_divisor(mut one: f64, mut other: f64) -> f64 {
    while ROUNDING_MM < other {
        (one, other) = (other, (one - other * (one / other).round()).abs());
    }
    one
}

/// Returns the median of values; 0 if there are none. Reorders the values.
pub fn median(values: &mut [f64]) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_of_whole_steps_have_the_common_divisor_of_their_changes() {
        let z = |steps: [u32; 5]| steps.map(|count| 0.004 * f64::from(count));
        assert!((lattice(&z([0, 2, 5, 5, 9])) - 0.004).abs() < 1e-9);
        assert!((lattice(&z([0, 6, 6, 2, 12])) - 0.008).abs() < 1e-9, "all changes are even");
        assert_eq!(lattice(&[3.0; 4]), 0.0);
        let rounded = z([0, 2, 7, 7, 9]).map(|mm| mm + 30.0 + 2e-9 * (1e3 * mm).sin());
        assert_eq!(lattice(&rounded), 0.004, "a whole number of steps in a millimetre");
        let free: Vec<f64> = (0..50).map(|row| (0.3 * f64::from(row)).sin()).collect();
        assert_eq!(lattice(&free), 0.0);
    }
}
