//! The path in space, coloured by feedrate, by lost time or by part of the program: data in, pixels out.
//!
//! A [`Trail`] is the programmed path as a chain of straight edges: lines unchanged, arcs as chords of at
//! most three degrees. A [`SteppedCurve`] is the feedrate over distance in steps, coarse enough for colours.
//! A [`Scene`] is a trail with shades, with its edges divided where the shade changes; [`raster`] draws it
//! through a [`Camera`].
//!
//! Shades are ranks, the worst last. If several passes cover one pixel, it shows the nearest pass, and of
//! equally near ones the worst, as a chart keeps the highest and lowest points of a pixel column.
//!
//! Units: mm, mm/s, s; loss is a part of the programmed feedrate, time lost against a recording is in s/mm.

mod camera;
mod light;
mod palette;
mod raster;
mod svg;
#[cfg(test)]
mod tests;

pub use camera::Camera;
pub use light::Light;
pub use palette::{ground, ink, palette};
pub use raster::{Drawing, Raster, raster};
pub use svg::{Sheet, svg_of_path};

use crate::plot::Programmed;
use crate::simulation::profile::FeedCurve;
use crate::simulation::sampled::{RowsAround, rows_around};
use crate::simulation::toolpath::{Curve, Toolpath};

/// Widest angle of a chord of an arc, rad.
const CHORD: f64 = std::f64::consts::PI / 60.0;
/// Part of the length or width of the cuts above which their height counts as deep.
const DEEP: f32 = 0.02;
/// Number of shades.
pub const SHADES: usize = 16;
/// Ranks: 0 for nothing, 1 for rapids, then the shades, then the marked part.
pub const RAPID_RANK: u8 = 1;
const FIRST_SHADE_RANK: u8 = 2;
/// Rank of the marked part.
pub const MARKED_RANK: u8 = FIRST_SHADE_RANK + SHADES as u8;

/// The programmed path as a chain of edges.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Trail {
    /// Positions, mm; one more than there are edges.
    pub points: Vec<[f32; 3]>,
    /// Distance of each position along the path, mm; ascending.
    pub distance: Vec<f64>,
}

impl Trail {
    /// Returns the trail of a toolpath.
    pub fn of(toolpath: &Toolpath) -> Trail {
        let mut trail = Trail::default();
        let mut travelled = 0.0;
        if let Some(first) = toolpath.segments.first() {
            trail.push([first.start.x, first.start.y, first.start.z], 0.0);
        }
        for (segment, end) in toolpath.segments.iter().zip(toolpath.ends()) {
            let chords = match &segment.curve {
                Curve::Line => 1,
                Curve::Arc(arc) => (arc.sweep / CHORD).ceil().clamp(1.0, 1e5) as usize,
            };
            for chord in 1..=chords {
                let along = segment.length * chord as f64 / chords as f64;
                let point = if chord == chords { segment.end } else { segment.point(along) };
                trail.push([point.x, point.y, point.z], travelled + along);
            }
            travelled = end;
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
pub struct SteppedCurve {
    /// End of each step along the path, mm; ascending.
    pub end: Vec<f64>,
    /// Value of each step: mean feedrate (mm/s), or time lost per length (s/mm).
    pub value: Vec<f64>,
}

impl SteppedCurve {
    /// Returns the feedrate of a profile, in steps within which it changes by at most 3 %, or by half a per
    /// cent of the largest feedrate.
    pub fn of(curve: &FeedCurve) -> SteppedCurve {
        let fastest = curve.feedrate.iter().copied().fold(0.0, f64::max);
        let mut pace = SteppedCurve::default();
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

    /// Returns the time lost against a recording, in steps of a thousandth of the path or longer.
    pub fn of_lost(distance: &[f64], seconds: &[f64]) -> SteppedCurve {
        let least = distance.last().map_or(0.0, |end| 1e-3 * end);
        let mut pace = SteppedCurve::default();
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

/// The quantity that colours the path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Coloring {
    /// Feedrate, from 0 to this value, mm/s.
    Feedrate(f64),
    /// The missing part of the programmed feedrate.
    Loss,
    /// Time lost against a recording, from this value gained to this value lost, s/mm.
    Lost(f64),
    /// The part of the program, such as a tool; parts are numbered from 0.
    Part,
}

impl Coloring {
    /// Returns the colouring by feedrates up to the fastest programmed one.
    pub fn by_feedrate(programmed: &Programmed) -> Coloring {
        Coloring::Feedrate(programmed.highest_cutting)
    }

    /// Returns the colouring by time lost that leaves two per cent of the steps beyond its scale.
    pub fn by_lost(lost: &SteppedCurve) -> Coloring {
        let mut sizes: Vec<f64> = lost.value.iter().map(|value| value.abs()).collect();
        sizes.sort_by(f64::total_cmp);
        let top = sizes.get((0.98 * sizes.len() as f64) as usize).copied().unwrap_or(0.0);
        Coloring::Lost(top)
    }

    /// Returns the rank of a value at a programmed feedrate.
    fn rank(self, value: f64, programmed: f64) -> u8 {
        let part = match self {
            Coloring::Feedrate(top) => 1.0 - value / top,
            Coloring::Loss => 1.0 - value / programmed,
            Coloring::Lost(top) => 0.5 * (1.0 + value / top),
            Coloring::Part => return FIRST_SHADE_RANK + (value as usize % SHADES) as u8,
        };
        let part = if part.is_nan() { 0.0 } else { part.clamp(0.0, 1.0) };
        FIRST_SHADE_RANK + (part * SHADES as f64).min(SHADES as f64 - 1.0) as u8
    }
}

/// A trail with its shades.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scene {
    /// Positions of the ends of edges, mm.
    pub points: Vec<[f32; 3]>,
    /// Distance of each position along the path, mm; ascending.
    pub distance: Vec<f64>,
    /// Rank of the edge that begins at each position; the last position has none.
    pub rank: Vec<u8>,
    /// Least and largest coordinates of the cuts, mm; of everything if nothing is cut.
    pub bounds: [[f32; 3]; 2],
}

impl Scene {
    /// Returns a trail with the shades of a curve; beyond the end of the curve, with those of the programmed
    /// feedrate.
    pub fn new(trail: &Trail, programmed: &Programmed, pace: &SteppedCurve, coloring: Coloring) -> Scene {
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
                    Coloring::Lost(_) | Coloring::Part => 0.0,
                    _ => asked,
                });
                let rank = if is_rapid { RAPID_RANK } else { coloring.rank(value, asked) };
                // Neighbouring parts of an edge with the same shade are joined.
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
        scene.bounded()
    }

    /// Returns the scene with the bounds of its cuts.
    fn bounded(mut self) -> Scene {
        let mut bounds = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
        for point in self.cut().flatten() {
            for k in 0..3 {
                bounds[0][k] = bounds[0][k].min(point[k]);
                bounds[1][k] = bounds[1][k].max(point[k]);
            }
        }
        self.bounds = if bounds[0][0] <= bounds[1][0] { bounds } else { [[0.0; 3]; 2] };
        self
    }

    /// Returns the ends of the edges that are cut; of all edges if none are.
    pub(crate) fn cut(&self) -> impl Iterator<Item = &[[f32; 3]]> {
        let edges = self.points.len().saturating_sub(1);
        let is_cut = self.rank.iter().take(edges).any(|rank| *rank != RAPID_RANK);
        let ends = self.points.windows(2).zip(&self.rank);
        ends.filter(move |(_, rank)| !is_cut || **rank != RAPID_RANK).map(|(ends, _)| ends)
    }

    /// Returns the index of the first edge that begins at or beyond a distance, mm; `None` returns the number
    /// of edges.
    pub fn edges_to(&self, distance: Option<f64>) -> u32 {
        let run = |distance| self.distance.partition_point(|&begin| begin < distance) as u32;
        distance.map_or(u32::MAX, run)
    }

    /// Returns `true` if the path is deep enough to be viewed obliquely.
    pub fn is_deep(&self) -> bool {
        let [x, y, z] = [0, 1, 2].map(|k| self.bounds[1][k] - self.bounds[0][k]);
        DEEP * x.max(y) < z
    }

    fn push(&mut self, point: [f32; 3], distance: f64) {
        self.points.push(point);
        self.distance.push(distance);
        self.rank.push(0);
    }

    /// Returns the position at a distance along the path, mm; `None` if there is no path.
    pub fn point(&self, distance: f64) -> Option<[f64; 3]> {
        let RowsAround { before, after, fraction } = rows_around(&self.distance, distance, &mut 0)?;
        let [a, b] = [self.points[before], self.points[after]];
        Some(std::array::from_fn(|k| f64::from(a[k]) + fraction * (f64::from(b[k]) - f64::from(a[k]))))
    }
}
