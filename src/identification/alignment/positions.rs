//! Recorded positions → distance along the path over time.
//!
//! The tool never goes back along its path, and between two samples it goes on by about as much as it
//! moves. Of all ways through the places near each sample the one is taken that costs least,
//!
//! ```text
//! Σ ρ(d / σ_d) + ρ((Δs − |Δp|) / σ_s),    ρ(x) = x² for x ≤ 3, then 6 x − 9
//! ```
//!
//! with d (mm) the distance from the path, Δs ≥ 0 (mm) the way along the path and |Δp| (mm) the way
//! between the samples. A sample may also be off the path, at a fixed cost: machines go to their tool
//! changer. The search keeps the few cheapest ways from sample to sample, each looking only a little
//! ahead, so that its cost is linear and a path that crosses or retraces itself is followed in order:
//! the nearest point alone would jump. Time is never stretched; it is read off.
//!
//! At the end of the path, and off it, the tool may also begin again: a recording of several passes is taken apart
//! there, and so is what comes before and after a run.
//!
//! A sample counts once the tool has moved by several standard deviations of the noise since the last
//! one that did. Source: map matching by hidden Markov models, Newson and Krumm 2009.

use crate::identification::alignment::path::{Foot, Path};
use crate::identification::alignment::{AlignmentError, Fix};
use crate::identification::recording::{Axes, Channel};
use crate::simulation::sampled::rows_around;
use crate::simulation::toolpath::{Point, Vector};

/// Ways kept from sample to sample.
const WAYS: usize = 6;
/// Ways tried at the beginning, when the place is not known.
const FIRST_WAYS: usize = 64;
/// What a sample off the path costs; a sample farther away than this allows is off it.
const OFF_PATH: f64 = 60.0;
/// What it costs to begin again; less than two samples off the path would be no reason to.
const BEGIN_AGAIN: f64 = 2.0 * OFF_PATH;
/// A pass as long as this part of the longest is one too.
pub const WHOLE_PASS: f64 = 0.9;
/// Samples are thinned to at most about so many that count.
const MOST_SAMPLES: usize = 150_000;
/// A position that is told again for longer than this is one at which the tool stays, s.
const STAYS: f64 = 0.1;
/// The tool has moved when it is so many standard deviations of the noise from where it was.
const MOVED: f64 = 6.0;
/// With less of the way off the path it is not looked at from afar.
const WELL: f64 = 0.05;
/// How much farther from the path the tool may be, looked at from afar.
pub const FROM_AFAR: f64 = 8.0;
/// Largest part of the recorded way that may be off the path.
const MAX_OFF_PATH: f64 = 0.3;
/// No recorder of positions is finer than this, mm.
const FINEST: f64 = 2e-4;

/// Positions of all axes at common stamps.
#[derive(Clone, Debug)]
pub struct Track {
    /// Stamps, s, ascending.
    pub time: Vec<f64>,
    /// Positions, mm; 0 in axes that were not recorded.
    pub position: Vec<Point>,
    /// Which axes were recorded.
    pub recorded: [bool; 3],
    /// Standard deviation of the noise of one coordinate, mm.
    pub noise: f64,
    /// Median time between samples, s.
    pub interval: f64,
}

/// The place of each sample of a pass that counts.
pub struct Matched {
    /// Where the tool was when, ascending in time and distance; samples off the path are left out.
    pub fixes: Vec<Fix>,
    /// Recorded way off the path between the first and the last fix, as a part of all there.
    pub off_path: f64,
    /// Recorded way on the path, mm.
    pub on_path: f64,
    /// All recorded way, that of other passes and outside of any included, mm.
    pub recorded: f64,
    /// Root mean square of the distance from the path, mm.
    pub spread: f64,
    /// Passes of the program in the recording; this is the first of the whole ones.
    pub passes: usize,
}

impl Matched {
    /// The part of the recording, or if that is more of the path (mm), that this pass makes up.
    pub fn part(&self, path: f64) -> f64 {
        self.on_path / self.recorded.min(path).max(1e-9)
    }

    /// Returns `true` if enough of the recorded way lies on the path for the recording to be of it.
    pub fn is_on_path(&self) -> bool {
        self.off_path <= MAX_OFF_PATH
    }
}

impl Track {
    /// The positions of a recording; none where no axis was recorded or there is hardly a sample.
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
        // A position that is told again is not another sample; of one that stays the last tells until when.
        let repeats = |row: usize| row != 0 && all[row] == all[row - 1];
        let mut kept: Vec<usize> = Vec::with_capacity(all.len());
        for row in 0..all.len() {
            let ends = repeats(row) && (row + 1 == all.len() || !repeats(row + 1));
            let stays = kept.last().is_some_and(|first| STAYS < time[row] - time[*first]);
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
        let mut noises: Vec<f64> = columns.iter().flatten().map(|column| noise(column)).collect();
        noises.sort_by(f64::total_cmp);
        let noise = noises.last().copied().unwrap_or(0.0).max(FINEST);
        let mut intervals: Vec<f64> = time.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let interval = median(&mut intervals);
        Some(Track { time, position, recorded: axes.each_ref().map(Option::is_some), noise, interval })
    }

    /// The recorded positions without those at which the tool has hardly moved, mm.
    pub fn polyline(&self) -> Vec<Point> {
        self.moved().into_iter().map(|sample| self.position[sample]).collect()
    }

    /// The samples at which the tool has moved, by index; the first always.
    fn moved(&self) -> Vec<usize> {
        let mut step = MOVED * self.noise;
        loop {
            let mut moved = vec![0];
            let mut last = self.position[0];
            for (index, position) in self.position.iter().enumerate() {
                if step <= (position - last).norm() {
                    moved.push(index);
                    last = *position;
                }
            }
            if moved.len() <= MOST_SAMPLES {
                return moved;
            }
            step *= 2.0;
        }
    }

    /// The same positions with `shift` (mm) taken off, in the axes that were recorded.
    pub fn shifted(&self, shift: Vector) -> Track {
        let shift = Vector::from_fn(|axis, _| if self.recorded[axis] { shift[axis] } else { 0.0 });
        let position = self.position.iter().map(|position| position - shift).collect();
        Track { time: self.time.clone(), position, ..*self }
    }
}

/// A way through the samples so far.
#[derive(Clone, Copy)]
struct Way {
    along: f64,
    cost: f64,
    /// The way it came by, among those of the sample before.
    from: u32,
    /// How far the sample lies from the path, mm; infinite where it is off it.
    away: f64,
}

/// The cheapest way of a track along a path; `tolerance` (mm) is how far the tool may cut corners. Axes
/// that lag or vibrate leave the path by more, so that what does not fit closely is looked at from afar.
pub fn follow(track: &Track, path: &Path, tolerance: f64) -> Result<Matched, AlignmentError> {
    let samples = track.moved();
    if samples.len() < 3 {
        return Err(AlignmentError::StandsStill);
    }
    let scale = scale(track, tolerance);
    let closely = follow_within(track, &samples, path, scale);
    let missing = |matched: &Result<Matched, _>| {
        matched.as_ref().map_or(1.0, |matched| matched.off_path.max(1.0 - matched.part(path.length())))
    };
    if missing(&closely) < WELL {
        return closely;
    }
    let afar = follow_within(track, &samples, path, FROM_AFAR * scale);
    if missing(&afar) < missing(&closely) { afar } else { closely }
}

/// How far the tool may be from the path (mm) where it is on it, cutting corners by a `tolerance` (mm).
pub fn scale(track: &Track, tolerance: f64) -> f64 {
    (2.0 * tolerance).max(3.0 * track.noise).max(0.02)
}

fn follow_within(
    track: &Track,
    samples: &[usize],
    path: &Path,
    scale: f64,
) -> Result<Matched, AlignmentError> {
    let mut columns: Vec<Vec<Way>> = Vec::with_capacity(samples.len());
    let mut ways: Vec<Way> = Vec::new();
    let mut feet = Vec::new();
    let mut next: Vec<Way> = Vec::new();
    let mut pace = 0.0f64;
    let first = first_ways(track, samples, path, scale);
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
                next.push(Way { along: foot.along, cost, from: from as u32, away: foot.away });
            }
            next.push(Way { cost: way.cost + OFF_PATH, from: from as u32, away: f64::INFINITY, ..*way });
        }
        next.extend(begun_again(point, ways[0], path, scale, &mut feet));
        next.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        let keep = if order < begin + 50 { FIRST_WAYS } else { WAYS };
        ways.clear();
        for way in &next {
            let is_new = |kept: &Way| 1e-6 < (kept.along - way.along).abs();
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

/// Ways that begin again near `point`, where the cheapest so far is at the end of the path or off it.
fn begun_again(point: Point, best: Way, path: &Path, scale: f64, feet: &mut Vec<Foot>) -> Vec<Way> {
    feet.clear();
    if best.away.is_infinite() || path.length() - path.entry() < best.along {
        path.nearest(point, 0.0..path.entry(), feet);
    }
    let begins = feet.iter().filter(|foot| foot.away < 5.0 * scale && foot.along < best.along);
    begins
        .map(|foot| Way { cost: best.cost + BEGIN_AGAIN + robust(foot.away / scale), ..entered(foot, scale) })
        .collect()
}

fn entered(foot: &Foot, scale: f64) -> Way {
    Way { along: foot.along, cost: robust(foot.away / scale), from: 0, away: foot.away }
}

/// The first sample that is near the path and the places it may be at; the beginning of the path comes
/// first where the sample is near it.
fn first_ways(track: &Track, samples: &[usize], path: &Path, scale: f64) -> Option<(usize, Vec<Foot>)> {
    let mut feet = Vec::new();
    let mut order = 0;
    while order < samples.len() {
        let point = track.position[samples[order]];
        path.nearest(point, 0.0..f64::INFINITY, &mut feet);
        feet.retain(|foot| foot.away < 5.0 * scale);
        if !feet.is_empty() {
            feet.sort_by(|a, b| a.away.total_cmp(&b.away));
            let mut first: Vec<Foot> = feet.iter().copied().filter(|foot| foot.along < scale).collect();
            first.extend(feet.iter().take(FIRST_WAYS));
            first.truncate(FIRST_WAYS);
            return Some((order, first));
        }
        order += (samples.len() / 200).max(1);
    }
    None
}

/// The cheapest way of all, sample by sample.
fn traced_back(track: &Track, samples: &[usize], columns: &[Vec<Way>]) -> Matched {
    let mut way = 0;
    let mut steps = Vec::with_capacity(samples.len());
    for order in (0..columns.len()).rev() {
        let Way { along, away, from, .. } = columns[order][way];
        let sample = samples[order];
        let before = order.checked_sub(1).map_or(sample, |order| samples[order]);
        let moved = (track.position[sample] - track.position[before]).norm();
        steps.push(Step { sample, along, away, moved });
        way = from as usize;
    }
    steps.reverse();
    let begins = (1..steps.len()).filter(|at| steps[*at].along < steps[at - 1].along);
    let bounds: Vec<usize> = [0].into_iter().chain(begins).chain([steps.len()]).collect();
    let passes = bounds.windows(2).map(|pair| trimmed(&steps[pair[0]..pair[1]]));
    let passes: Vec<&[Step]> = passes.filter(|pass| !pass.is_empty()).collect();
    let longest = passes.iter().map(|pass| progress(pass)).fold(0.0, f64::max);
    let whole: Vec<&[Step]> =
        passes.into_iter().filter(|pass| WHOLE_PASS * longest <= progress(pass)).collect();
    let recorded = steps.iter().map(|step| step.moved).sum();
    matched(track, whole.first().copied().unwrap_or_default(), recorded, whole.len())
}

/// A sample on the cheapest way.
struct Step {
    sample: usize,
    along: f64,
    /// How far it lies from the path, mm; infinite where it is off it.
    away: f64,
    /// How far the tool has moved since the sample before, mm.
    moved: f64,
}

/// A pass from its first sample on the path to its last.
fn trimmed(pass: &[Step]) -> &[Step] {
    let is_on = |step: &Step| step.away.is_finite();
    let first = pass.iter().position(is_on).unwrap_or(pass.len());
    let last = pass.iter().rposition(is_on).map_or(first, |last| last + 1);
    &pass[first..last]
}

fn progress(pass: &[Step]) -> f64 {
    pass.first().zip(pass.last()).map_or(0.0, |(first, last)| last.along - first.along)
}

fn matched(track: &Track, pass: &[Step], recorded: f64, passes: usize) -> Matched {
    let on = || pass.iter().filter(|step| step.away.is_finite());
    // The way to its first sample is not of the pass.
    let way = |steps: &mut dyn Iterator<Item = &Step>| steps.map(|step| step.moved).sum::<f64>();
    let entry = pass.first().map_or(0.0, |step| step.moved);
    let (all, on_path) = (way(&mut pass.iter()) - entry, way(&mut on()) - entry);
    let squares: f64 = on().map(|step| step.away * step.away).sum();
    Matched {
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

/// A channel's values at other stamps, straight between its own.
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

/// Standard deviation of the noise of a column, from its second differences: where nothing accelerates
/// they are noise, √6 times as large; the smaller half of normal values has a root mean square of 0.3776
/// standard deviations.
fn noise(column: &[f64]) -> f64 {
    let second = column.windows(3).map(|w| (w[0] - 2.0 * w[1] + w[2]).abs());
    let mut differences: Vec<f64> = second.collect();
    let mut steps: Vec<f64> =
        column.windows(2).map(|w| (w[1] - w[0]).abs()).filter(|step| 1e-9 < *step).collect();
    steps.sort_by(f64::total_cmp);
    // The smallest step is the quantum where the values lie on a lattice.
    let quantum = steps.first().copied().unwrap_or(0.0).min(0.01);
    let half = differences.len() / 2;
    let still = match half {
        0 => 0.0,
        _ => {
            differences.select_nth_unstable_by(half, f64::total_cmp);
            (differences[..half].iter().map(|d| d * d).sum::<f64>() / half as f64).sqrt()
        }
    };
    (still / (0.3776 * 6.0f64.sqrt())).min(0.05).max(0.5 * quantum)
}

/// The median of values; 0 of none. They are put in another order.
pub fn median(values: &mut [f64]) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}
