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
//! A sample counts once the tool has moved by several standard deviations of the noise since the last
//! one that did. Source: map matching by hidden Markov models, Newson and Krumm 2009.

use crate::identification::alignment::path::{Foot, Path};
use crate::identification::alignment::{AlignmentError, Fix};
use crate::identification::recording::{Axes, Channel};
use crate::simulation::toolpath::{Point, Vector};

/// Ways kept from sample to sample.
const WAYS: usize = 6;
/// Ways tried at the beginning, when the place is not known.
const FIRST_WAYS: usize = 64;
/// What a sample off the path costs; a sample farther away than this allows is off it.
const OFF_PATH: f64 = 60.0;
/// Samples are thinned to at most about so many that count.
const MOST_SAMPLES: usize = 150_000;
/// A position that is told again for longer than this is one at which the tool stays, s.
const STAYS: f64 = 0.1;
/// The tool has moved when it is so many standard deviations of the noise from where it was.
const MOVED: f64 = 6.0;
/// With less of the way off the path it is not looked at from afar.
const WELL: f64 = 0.05;
/// How much farther from the path the tool may be, looked at from afar.
const FROM_AFAR: f64 = 8.0;
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

/// The place of each sample that counts.
pub struct Matched {
    /// Where the tool was when, ascending in time and distance; samples off the path are left out.
    pub fixes: Vec<Fix>,
    /// Length of recorded way that is off the path, as a part of all.
    pub off_path: f64,
    /// Root mean square of the distance from the path, mm.
    pub spread: f64,
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

    /// The same positions with `shift` (mm) taken off.
    pub fn shifted(&self, shift: Vector) -> Track {
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
    let scale = (2.0 * tolerance).max(3.0 * track.noise).max(0.02);
    let closely = follow_within(track, &samples, path, scale);
    match &closely {
        Ok(matched) if matched.off_path < WELL => closely,
        _ => {
            let afar = follow_within(track, &samples, path, FROM_AFAR * scale);
            let off = |matched: &Result<Matched, _>| matched.as_ref().map_or(1.0, |matched| matched.off_path);
            if off(&afar) < off(&closely) { afar } else { closely }
        }
    }
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

fn traced_back(track: &Track, samples: &[usize], columns: &[Vec<Way>]) -> Matched {
    let mut way = 0;
    let mut fixes = Vec::with_capacity(samples.len());
    let (mut off, mut all) = (0.0, 0.0);
    let (mut squares, mut count) = (0.0, 0.0f64);
    for order in (0..columns.len()).rev() {
        let Way { along, away, from, .. } = columns[order][way];
        let sample = samples[order];
        let before = order.checked_sub(1).map_or(sample, |order| samples[order]);
        let moved = (track.position[sample] - track.position[before]).norm();
        all += moved;
        if away.is_finite() {
            fixes.push(Fix { time: track.time[sample], distance: along, sample: Some(sample) });
            squares += away * away;
            count += 1.0;
        } else {
            off += moved;
        }
        way = from as usize;
    }
    fixes.reverse();
    let off_path = if 0.0 < all { off / all } else { 1.0 };
    Matched { fixes, off_path, spread: (squares / count.max(1.0)).sqrt() }
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
    let mut after = 0;
    time.iter()
        .map(|&stamp| {
            while after < channel.time.len() && channel.time[after] <= stamp {
                after += 1;
            }
            match (after.checked_sub(1), channel.values.get(after)) {
                (None, first) => first.copied().unwrap_or(0.0),
                (Some(last), None) => channel.values[last],
                (Some(last), Some(next)) => {
                    let share = (stamp - channel.time[last]) / (channel.time[after] - channel.time[last]);
                    channel.values[last] + share * (next - channel.values[last])
                }
            }
        })
        .collect()
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
