//! A recorded run along its path: times at places, and feedrates around them.
//!
//! A window has at least three samples, and enough of them that the noise of two positions is at most the
//! part [`MAX_WINDOW_NOISE_RATIO`] of the feedrate. A plateau consists of three consecutive windows whose
//! feedrates agree to the part [`MAX_PLATEAU_DIFFERENCE_RATIO`].

use std::ops::Range;

use crate::identification::alignment::{Fix, Method, Track, median};
use crate::identification::fit::Run;
use crate::simulation::sampled::rows_around_by;
use crate::simulation::toolpath::{Curve, Motion, Toolpath};

/// Noise of a window, as a part of the feedrate.
const MAX_WINDOW_NOISE_RATIO: f64 = 0.02;
/// Least number of samples in a window.
const MIN_SAMPLES: usize = 3;
/// Longest window of more than the least number of samples, s: a longer one would blur the law.
const MAX_WINDOW_S: f64 = 0.06;
/// Largest relative difference of the windows of a plateau.
const MAX_PLATEAU_DIFFERENCE_RATIO: f64 = 0.01;
/// Part of the programmed feedrate from which on the feedrate counts as reached.
pub const MIN_REACHED_RATIO: f64 = 0.95;
/// Distance from a place at which the tool has left it, in standard deviations of the noise.
const MIN_LEFT_SIGMAS: f64 = 6.0;

/// A run along its path.
pub struct RunCourse<'a> {
    /// Program.
    pub toolpath: &'a Toolpath,
    /// Distance along the path before each segment, and at its end, mm.
    pub distances: Vec<f64>,
    /// Recorded over programmed feedrate on plateaus, where no law limits it.
    pub ratio: f64,
    fixes: &'a [Fix],
    track: &'a Track,
}

/// A steady feedrate.
#[derive(Clone, Debug, PartialEq)]
pub struct SteadyPlateau {
    /// Feedrate, mm/s.
    pub feedrate: f64,
    /// Duration of its windows, s.
    pub window: f64,
    /// Indices of its samples.
    pub samples: Range<usize>,
}

impl<'a> RunCourse<'a> {
    /// Returns the course of a run; `None` without recorded positions.
    pub fn of(run: &Run<'a>) -> Option<RunCourse<'a>> {
        let alignment = run.alignment;
        let track = alignment.track.as_deref().filter(|_| alignment.method == Method::Positions)?;
        let (toolpath, fixes) = (run.toolpath, &*alignment.fixes);
        let distances = toolpath.distances();
        let mut course = RunCourse { toolpath, distances, ratio: 1.0, fixes, track };
        course.ratio = course.plateau_ratio();
        Some(course)
    }

    /// Returns the median ratio of plateaus on straight feed blocks to the programmed feedrate.
    fn plateau_ratio(&self) -> f64 {
        let ratio = |segment: usize| {
            let Motion::Feed { feedrate } = self.toolpath.segments.motion(segment) else { return None };
            let is_line = *self.toolpath.segments.curve(segment) == Curve::Line;
            let plateau = is_line.then(|| self.plateau(segment, feedrate)).flatten()?;
            Some(plateau.feedrate / feedrate)
        };
        let mut ratios: Vec<f64> = (0..self.toolpath.segments.len()).filter_map(ratio).collect();
        if ratios.is_empty() { 1.0 } else { median(&mut ratios) }
    }

    /// Returns the programmed feedrate of a segment with the override of the run, mm/s; `None` in rapid.
    pub fn commanded(&self, segment: usize) -> Option<f64> {
        match self.toolpath.segments.motion(segment) {
            Motion::Feed { feedrate } => Some(self.ratio * feedrate),
            Motion::Rapid { .. } => None,
        }
    }

    /// Returns the number of samples in a window at about this feedrate (mm/s); `None` if they would be too
    /// many.
    fn window(&self, feedrate: f64) -> Option<usize> {
        let seconds = 2f64.sqrt() * self.track.noise / (MAX_WINDOW_NOISE_RATIO * feedrate.max(1e-9));
        let samples = (seconds / self.track.interval).ceil();
        (samples <= MIN_SAMPLES as f64 || seconds <= MAX_WINDOW_S)
            .then(|| (samples as usize).max(MIN_SAMPLES))
    }

    /// Returns the indices of the samples on a segment, from the first fix on it to the last.
    pub fn samples(&self, segment: usize) -> Option<Range<usize>> {
        let (begin, end) = (self.distances[segment], self.distances[segment + 1]);
        let first = self.fixes.partition_point(|fix| fix.distance < begin);
        let last = self.fixes.partition_point(|fix| fix.distance <= end).checked_sub(1)?;
        let both = self.fixes.get(first)?.sample.zip(self.fixes[last].sample)?;
        (first < last).then_some(both.0..both.1 + 1)
    }

    /// Returns the mean feedrate (mm/s) of the window that begins with a sample, and the time of its middle,
    /// s.
    fn mean(&self, first: usize, window: usize) -> (f64, f64) {
        let (from, to) = (first, first + window);
        let way = (self.track.position[to] - self.track.position[from]).norm();
        let [begin, end] = [self.track.time[from], self.track.time[to]];
        (way / (end - begin).max(1e-12), 0.5 * (begin + end))
    }

    /// Returns the mean feedrate (mm/s) of a window at whose beginning (or end) the tool may rest, and the
    /// time of its middle, s. Of a position at rest only the first and the last sample are kept; the time
    /// between them is excluded.
    fn mean_at_rest(&self, first: usize, window: usize, is_at_begin: bool) -> (f64, f64) {
        let (from, to) = (first, first + window);
        let longest = 1.5 * self.track.interval;
        let spans = self.track.time[from..=to].windows(2).map(|pair| (pair[1] - pair[0]).min(longest));
        let lasts = spans.sum::<f64>().max(1e-12);
        let way = (self.track.position[to] - self.track.position[from]).norm();
        let middle =
            if is_at_begin { self.track.time[to] - 0.5 * lasts } else { self.track.time[from] + 0.5 * lasts };
        (way / lasts, middle)
    }

    /// Returns the longest plateau of a segment that runs at about `feedrate` (mm/s); `None` if it has none.
    pub fn plateau(&self, segment: usize, feedrate: f64) -> Option<SteadyPlateau> {
        let samples = self.samples(segment)?;
        let window = self.window(feedrate)?;
        let last = samples.end.checked_sub(3 * window + 1)?;
        let is_steady = |first: usize| {
            let means = [0, 1, 2].map(|part| self.mean(first + part * window, window).0);
            0.1 * feedrate < means[1]
                && means.iter().all(|mean| (mean - means[1]).abs() <= MAX_PLATEAU_DIFFERENCE_RATIO * means[1])
        };
        let mut best: Option<Range<usize>> = None;
        let mut open: Option<Range<usize>> = None;
        for first in samples.start..=last {
            if is_steady(first) {
                let begin = open.map_or(first, |open| open.start);
                open = Some(begin..first + 3 * window);
            } else {
                open = None;
            }
            if open.as_ref().map_or(0, |open| open.len()) > best.as_ref().map_or(0, |best| best.len()) {
                best = open.clone();
            }
        }
        let samples = best?;
        let firsts = (samples.start..samples.end - window).step_by(window);
        let count = firsts.len() as f64;
        let feedrate = firsts.map(|first| self.mean(first, window).0).sum::<f64>() / count;
        Some(SteadyPlateau { feedrate, window: window as f64 * self.track.interval, samples })
    }

    /// Returns the feedrate of the fastest window of a segment that runs at about `feedrate`, both mm/s.
    pub fn fastest(&self, segment: usize, feedrate: f64) -> Option<f64> {
        let samples = self.samples(segment)?;
        let window = self.window(feedrate)?;
        let last = samples.end.checked_sub(window + 1)?;
        (samples.start..=last).map(|first| self.mean(first, window).0).max_by(f64::total_cmp)
    }

    /// Returns `true` if a feed segment reached its feedrate.
    pub fn reaches(&self, segment: usize) -> bool {
        let told = self.commanded(segment);
        told.and_then(|told| Some(MIN_REACHED_RATIO * told <= self.fastest(segment, told)?)).unwrap_or(false)
    }

    /// Returns the feedrate at the end of a segment (mm/s) that runs at about `feedrate`: the mean of the
    /// extrapolations of the windows before and behind the end, but at least the mean of the window across
    /// it, less the contribution of ramps.
    pub fn at_end(&self, segment: usize, feedrate: f64) -> Option<f64> {
        let window = self.window(feedrate)?;
        let time = self.passed(self.distances[segment + 1])?;
        let sides = [self.samples(segment)?, self.samples(segment + 1)?];
        let extrapolated = |near: (f64, f64), far: (f64, f64)| {
            near.0 + (near.0 - far.0) / (near.1 - far.1) * (time - near.1)
        };
        let last = sides[0].end.checked_sub(2 * window + 1).filter(|first| sides[0].start <= *first)?;
        let first = sides[1].start;
        if sides[1].end <= first + 2 * window {
            return None;
        }
        let windows = [
            [self.mean(last + window, window), self.mean(last, window)],
            [self.mean(first, window), self.mean(first + window, window)],
        ];
        let [before, after] = windows.map(|[near, far]| extrapolated(near, far).max(0.0));
        // On a blend the tool passes the corner faster than the feedrate at which its ramps would end.
        let (across, _) = self.mean(sides[0].end - 1 - window / 2, window);
        let slope =
            windows.iter().map(|[near, far]| ((far.0 - near.0) / (far.1 - near.1)).abs()).sum::<f64>() / 2.0;
        let least = across - 0.25 * slope * window as f64 * self.track.interval;
        Some((0.5 * (before + after)).max(least))
    }

    /// Returns the time at which the tool passed the place at `distance` (mm along the path), s.
    pub fn passed(&self, distance: f64) -> Option<f64> {
        let fixes = &self.fixes;
        let is_within = fixes.first()?.distance < distance && distance <= fixes.last()?.distance;
        let rows = rows_around_by(fixes.len(), |row| fixes[row].distance, distance, &mut 0);
        Some(rows.filter(|_| is_within)?.between_by(|row| fixes[row].time))
    }

    /// Returns the time of the last fix before a place, mm along the path, s.
    pub fn came(&self, distance: f64) -> Option<f64> {
        let away = MIN_LEFT_SIGMAS * self.track.noise;
        let before = self.fixes.partition_point(|fix| fix.distance <= distance - away).checked_sub(1)?;
        Some(self.fixes[before].time)
    }

    /// Returns the time of the first fix behind a place, mm along the path, s.
    pub fn left(&self, distance: f64) -> Option<f64> {
        let away = MIN_LEFT_SIGMAS * self.track.noise;
        let after = self.fixes.partition_point(|fix| fix.distance < distance + away);
        Some(self.fixes.get(after)?.time)
    }

    /// Returns the time (s) from 10 % to 90 % of a plateau, before it or behind it; `None` if the ramp is too
    /// short for the sampling.
    pub fn ramp(&self, plateau: &SteadyPlateau, is_before: bool) -> Option<f64> {
        let window = self.window(plateau.feedrate)?;
        let last = self.track.time.len().checked_sub(window + 1)?;
        let starts: Box<dyn Iterator<Item = usize>> = match is_before {
            true => Box::new((0..=plateau.samples.start.min(last)).rev()),
            false => Box::new(plateau.samples.end.saturating_sub(window + 1)..=last),
        };
        let mut crossings: Vec<f64> = Vec::new();
        let mut one_before: Option<(f64, f64)> = None;
        for first in starts {
            let (speed, time) = self.mean_at_rest(first, window, is_before);
            let level = if crossings.is_empty() { 0.9 } else { 0.1 } * plateau.feedrate;
            if let Some((faster, then)) = one_before.filter(|_| speed < level) {
                let share = (faster - level) / (faster - speed).max(1e-12);
                crossings.push(then + share.clamp(0.0, 1.0) * (time - then));
                if crossings.len() == 2 {
                    break;
                }
            }
            one_before = Some((speed, time));
        }
        let &[high, low] = crossings.as_slice() else { return None };
        let rise = (high - low).abs();
        let resolved = 2.0 * window as f64 * self.track.interval;
        (resolved <= rise).then_some(rise)
    }

    /// Returns `true` if the program stops before a segment, or behind the last.
    pub fn stops_before(&self, segment: usize) -> bool {
        let has_stop = self.toolpath.stops.binary_search_by_key(&segment, |stop| stop.after).is_ok();
        let is_end = segment == 0 || segment == self.toolpath.segments.len();
        is_end || has_stop || self.toolpath.segments.at(segment - 1).exact_stop
    }

    /// Returns the turn between a segment and the next, rad.
    pub fn turn(&self, segment: usize) -> f64 {
        let (_, [_, end]) = self.toolpath.segments.length_and_tangents(segment);
        let (_, [begin, _]) = self.toolpath.segments.length_and_tangents(segment + 1);
        end.dot(&begin).clamp(-1.0, 1.0).acos()
    }

    /// Returns the axis of a segment, or `diagonal`.
    pub fn along(&self, segment: usize) -> &'static str {
        const MIN_ALONG_AXIS: f64 = 0.999;
        let direction = self.toolpath.segments.direction(segment);
        ["X", "Y", "Z"]
            .into_iter()
            .zip(direction.iter())
            .find(|(_, part)| MIN_ALONG_AXIS < part.abs())
            .map_or("diagonal", |(name, _)| name)
    }
}
