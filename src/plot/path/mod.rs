//! The path in space, coloured by what the machine does on it: data in, pixels out.
//!
//! A [`Trail`] is the programmed path as a chain of straight edges: lines as they are, arcs as chords of at most three
//! degrees. A [`Pace`] is the feedrate over distance in steps, coarse enough for colours. A [`Scene`] lays shades on
//! the trail, divides its edges where the shade changes, and is drawn by [`raster`] as a [`Camera`] sees it.
//!
//! Shades are ranks, the worst last: where several passes fall on one pixel, it shows the worst of them, as a chart
//! decimated to its highest and lowest points does.
//!
//! Units: mm, mm/s, s; loss is a part of the programmed feedrate, time lost against a recording is in s/mm.

mod camera;
mod palette;
mod raster;
mod svg;
#[cfg(test)]
mod tests;

pub use camera::Camera;
pub use palette::{ink, palette};
pub use raster::{Drawing, Raster, raster};
pub use svg::{Sheet, svg_of_path};

use crate::plot::Programmed;
use crate::simulation::profile::FeedCurve;
use crate::simulation::toolpath::{Curve, Toolpath};

/// Widest angle of a chord of an arc, rad.
const CHORD: f64 = std::f64::consts::PI / 60.0;
/// How many shades there are.
pub const SHADES: usize = 16;
/// Ranks: nothing, rapids, the shades, and what is marked.
pub const RAPID: u8 = 1;
const FIRST_SHADE: u8 = 2;
/// The rank of what is marked.
pub const MARKED: u8 = FIRST_SHADE + SHADES as u8;

/// The programmed path as a chain of edges.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Trail {
    /// Positions, mm; one more than there are edges.
    pub points: Vec<[f32; 3]>,
    /// Distance of each along the path, mm; ascending.
    pub distance: Vec<f64>,
}

impl Trail {
    /// The trail of a toolpath.
    pub fn of(toolpath: &Toolpath) -> Trail {
        let mut trail = Trail::default();
        let mut travelled = 0.0;
        if let Some(first) = toolpath.segments.first() {
            trail.push([first.start.x, first.start.y, first.start.z], 0.0);
        }
        for segment in &toolpath.segments {
            let chords = match &segment.curve {
                Curve::Line => 1,
                Curve::Arc(arc) => (arc.sweep / CHORD).ceil().clamp(1.0, 1e5) as usize,
            };
            for chord in 1..=chords {
                let along = segment.length * chord as f64 / chords as f64;
                let point = if chord == chords { segment.end } else { segment.point(along) };
                trail.push([point.x, point.y, point.z], travelled + along);
            }
            travelled += segment.length;
        }
        trail
    }

    fn push(&mut self, point: [f64; 3], distance: f64) {
        self.points.push(point.map(|axis| axis as f32));
        self.distance.push(distance);
    }
}

/// A quantity over distance in steps.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pace {
    /// Where each step ends along the path, mm; ascending.
    pub end: Vec<f64>,
    /// Its value: mean feedrate (mm/s), or time lost (s/mm).
    pub value: Vec<f64>,
}

impl Pace {
    /// The feedrate of a profile, in steps within which it changes by 3 % or half a per cent of the fastest.
    pub fn of(curve: &FeedCurve) -> Pace {
        let fastest = curve.feedrate.iter().copied().fold(0.0, f64::max);
        let mut pace = Pace::default();
        let mut first = 0;
        let (mut low, mut high) = (f64::INFINITY, 0.0f64);
        for row in 0..curve.distance.len() {
            let feedrate = curve.feedrate[row];
            let is_last = row + 1 == curve.distance.len();
            (low, high) = (low.min(feedrate), high.max(feedrate));
            if high - low <= 0.03 * high + 0.005 * fastest && !is_last {
                continue;
            }
            let way = curve.distance[row] - curve.distance[first];
            let time = curve.time[row] - curve.time[first];
            if 0.0 < way {
                pace.end.push(curve.distance[row]);
                pace.value.push(way / time.max(f64::MIN_POSITIVE));
            }
            first = row;
            (low, high) = (feedrate, feedrate);
        }
        pace
    }

    /// The time lost against a recording, in steps of a thousandth of the path or longer.
    pub fn of_lost(distance: &[f64], seconds: &[f64]) -> Pace {
        let least = distance.last().map_or(0.0, |end| 1e-3 * end);
        let mut pace = Pace::default();
        let mut first = 0;
        for row in 0..distance.len() {
            let way = distance[row] - distance[first];
            if 0.0 < way && (least <= way || row + 1 == distance.len()) {
                pace.end.push(distance[row]);
                pace.value.push((seconds[row] - seconds[first]) / way);
                first = row;
            }
        }
        pace
    }
}

/// By what the path is coloured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Coloring {
    /// Feedrate, from none to this one, mm/s.
    Feedrate(f64),
    /// The part of the programmed feedrate that is missing.
    Loss,
    /// Time lost against a recording, from so much gained to so much lost, s/mm.
    Lost(f64),
}

impl Coloring {
    /// By feedrates up to the fastest that is programmed.
    pub fn by_feedrate(programmed: &Programmed) -> Coloring {
        Coloring::Feedrate(programmed.highest_cutting)
    }

    /// By time lost, so that two per cent of the steps are beyond the scale.
    pub fn by_lost(lost: &Pace) -> Coloring {
        let mut sizes: Vec<f64> = lost.value.iter().map(|value| value.abs()).collect();
        sizes.sort_by(f64::total_cmp);
        let top = sizes.get((0.98 * sizes.len() as f64) as usize).copied().unwrap_or(0.0);
        Coloring::Lost(top)
    }

    /// The rank of a value where this feedrate is programmed.
    fn rank(self, value: f64, programmed: f64) -> u8 {
        let part = match self {
            Coloring::Feedrate(top) => 1.0 - value / top,
            Coloring::Loss => 1.0 - value / programmed,
            Coloring::Lost(top) => 0.5 * (1.0 + value / top),
        };
        let part = if part.is_nan() { 0.0 } else { part.clamp(0.0, 1.0) };
        FIRST_SHADE + (part * SHADES as f64).min(SHADES as f64 - 1.0) as u8
    }
}

/// The trail with its shades.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scene {
    /// Ends of edges, mm.
    pub points: Vec<[f32; 3]>,
    /// Their distance along the path, mm; ascending.
    pub distance: Vec<f64>,
    /// Rank of the edge that begins at each; the last has none.
    pub rank: Vec<u8>,
}

impl Scene {
    /// Lays the shades of a pace on a trail; without a pace, where it ends, as if it were as programmed.
    pub fn new(trail: &Trail, programmed: &Programmed, pace: &Pace, coloring: Coloring) -> Scene {
        let mut scene = Scene::default();
        let (mut segment, mut step) = (0, 0);
        for (index, (&point, &end)) in trail.points.iter().zip(&trail.distance).enumerate() {
            if index == 0 {
                scene.push(point, end);
                continue;
            }
            let (from, begin) = (trail.points[index - 1], trail.distance[index - 1]);
            let shortest = 1e-9 * (end - begin);
            let mut here = begin;
            loop {
                let next = |ends: &[f64], at: &mut usize| {
                    while ends.get(*at).is_some_and(|&border| border <= here + shortest) {
                        *at += 1;
                    }
                    ends.get(*at).copied().unwrap_or(f64::INFINITY)
                };
                let border = next(&programmed.end, &mut segment).min(next(&pace.end, &mut step));
                let is_rapid = programmed.rapid.get(segment).copied().unwrap_or(false);
                let asked = programmed.feedrate.get(segment).copied().unwrap_or(f64::NAN);
                let value = pace.value.get(step).copied().unwrap_or(match coloring {
                    Coloring::Lost(_) => 0.0,
                    _ => asked,
                });
                let rank = if is_rapid { RAPID } else { coloring.rank(value, asked) };
                // Neighbours of one shade on one edge are one.
                match scene.rank.last_mut() {
                    Some(last) if *last == 0 || *last == rank => *last = rank,
                    _ => {
                        let part = ((here - begin) / (end - begin)) as f32;
                        scene.push(std::array::from_fn(|k| from[k] + part * (point[k] - from[k])), here);
                        scene.rank[scene.points.len() - 1] = rank;
                    }
                }
                if end - shortest <= border {
                    break;
                }
                here = border;
            }
            scene.push(point, end);
        }
        scene
    }

    fn push(&mut self, point: [f32; 3], distance: f64) {
        self.points.push(point);
        self.distance.push(distance);
        self.rank.push(0);
    }

    /// The position at a distance along the path, mm; none where there is no path.
    pub fn point(&self, distance: f64) -> Option<[f64; 3]> {
        let last = self.distance.len().checked_sub(1)?;
        let after = self.distance.partition_point(|&end| end < distance).min(last);
        let before = after.saturating_sub(1);
        let span = self.distance[after] - self.distance[before];
        let part = if 0.0 < span { ((distance - self.distance[before]) / span).clamp(0.0, 1.0) } else { 0.0 };
        let [a, b] = [self.points[before], self.points[after]];
        Some(std::array::from_fn(|k| f64::from(a[k]) + part * (f64::from(b[k]) - f64::from(a[k]))))
    }
}
