//! Recorded positions and a path → possible shifts between their coordinates.
//!
//! Machine coordinates differ from the program's by a zero point and a tool length. Both curves are sampled
//! at even distances, and each bend whose cosine is below [`MIN_TURN_COSINE`] becomes a corner with the
//! directions before and behind it, whether its cause is a corner, a blend, an arc or chords. Two corners
//! with equal directions vote for the difference of their places; the most frequent votes are candidates.
//! Rows of a pocket also vote for shifts by a row, so that candidates are ranked by the part of each curve
//! that the shift brings near the other.

use std::collections::{HashMap, HashSet};

use crate::identification::alignment::map_matching::Track;
use crate::identification::alignment::path::Path;
use crate::simulation::ordered::sort_by_number;
use crate::simulation::toolpath::{Point, Vector};

/// Cosine of the turn below which a bend is a corner: cos 25°.
const MIN_TURN_COSINE: f64 = 0.906;
/// Least cosine between directions that agree: 14°.
const MIN_DIRECTION_COSINE: f64 = 0.97;
/// Length over which a direction is measured, as a part of the size of the curve.
const DIRECTION_SIZE_RATIO: f64 = 0.01;
/// Least length over which a direction is measured, in widths of the tolerance.
const MIN_DIRECTION_TOLERANCES: f64 = 10.0;
/// Most points on a curve.
const MAX_POINTS: f64 = 200_000.0;
/// Most corners of the recording that vote.
const MAX_RECORDED_CORNERS: usize = 300;
/// Most corners of the path that vote.
const MAX_PROGRAMMED_CORNERS: usize = 3000;
/// Most candidates that are ranked.
const MAX_CANDIDATES: usize = 40;
/// Most points of a curve in a ranking.
const MAX_RANKED_POINTS: usize = 4000;
/// Least number of votes: fewer would fit anywhere.
const MIN_VOTES: usize = 4;

/// Returns shifts (mm) of recorded against programmed positions, the likeliest first; `scale` (mm) is the
/// largest distance of the tool from its path.
pub fn shifts(track: &Track, path: &Path, scale: f64) -> Vec<Vector> {
    let (recorded, programmed) = (track.polyline(), path.polyline());
    let over = MIN_DIRECTION_TOLERANCES * scale;
    let over = over.max(DIRECTION_SIZE_RATIO * diagonal(&programmed).min(diagonal(&recorded)));
    let longest = length(&recorded).max(length(&programmed));
    let spacing = (over / 4.0).max(longest / MAX_POINTS);
    let (recorded, programmed) = (evenly(&recorded, spacing), evenly(&programmed, spacing));
    let reach = (over / spacing).round().max(1.0) as usize;
    let seen = thinned(corners(&recorded, reach), MAX_RECORDED_CORNERS);
    let told = thinned(corners(&programmed, reach), MAX_PROGRAMMED_CORNERS);
    let near = (3.0 * scale).max(spacing);
    let mut candidates = voted(&seen, &told, near);
    let overlap = Overlap::new(&recorded, &programmed, near);
    sort_by_number(&mut candidates, |one| -overlap.with(one));
    candidates
}

/// A bend of a curve.
#[derive(Clone, Copy)]
struct CurveCorner {
    at: Point,
    before: Vector,
    after: Vector,
}

fn length(polyline: &[Point]) -> f64 {
    polyline.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum()
}

fn diagonal(points: &[Point]) -> f64 {
    let Some(first) = points.first() else { return 0.0 };
    let bounds = points.iter().fold((*first, *first), |(low, high), point| (low.inf(point), high.sup(point)));
    (bounds.1 - bounds.0).norm()
}

/// Returns points of a polyline, `spacing` (mm) apart along it.
fn evenly(polyline: &[Point], spacing: f64) -> Vec<Point> {
    let mut points: Vec<Point> = polyline.first().copied().into_iter().collect();
    let mut missing = spacing;
    for pair in polyline.windows(2) {
        let way = pair[1] - pair[0];
        let length = way.norm();
        let mut along = missing;
        while along <= length && 0.0 < spacing {
            points.push(pair[0] + way * (along / length));
            along += spacing;
        }
        missing = along - length;
    }
    points
}

/// Returns the corners of evenly spaced points; directions are measured over `reach` of them.
fn corners(points: &[Point], reach: usize) -> Vec<CurveCorner> {
    let corner = |at: usize| {
        let ways = [points[at] - points[at - reach], points[at + reach] - points[at]];
        let [before, after] = ways.map(|way| way.try_normalize(1e-9));
        let (before, after) = before.zip(after)?;
        Some((before.dot(&after), CurveCorner { at: points[at], before, after }))
    };
    let inner = reach..points.len().saturating_sub(reach);
    let mut found: Vec<(usize, f64, CurveCorner)> = Vec::new();
    for at in inner {
        let Some((cosine, corner)) = corner(at).filter(|(cosine, _)| *cosine < MIN_TURN_COSINE) else {
            continue;
        };
        match found.last_mut() {
            // Of the points around one bend the one with the sharpest turn is the corner.
            Some(last) if at - last.0 < reach => {
                if cosine < last.1 {
                    *last = (at, cosine, corner);
                }
            }
            _ => found.push((at, cosine, corner)),
        }
    }
    found.into_iter().map(|(_, _, corner)| corner).collect()
}

/// Returns at most `most` of the items, evenly spaced.
fn thinned<T: Copy>(all: Vec<T>, most: usize) -> Vec<T> {
    let step = all.len().div_ceil(most).max(1);
    all.into_iter().step_by(step).collect()
}

type GridCell = [i64; 3];

fn cell(vector: &Vector, size: f64) -> GridCell {
    [0, 1, 2].map(|axis: usize| (vector[axis] / size).floor() as i64)
}

fn around(cell: GridCell) -> impl Iterator<Item = GridCell> {
    (0..27).map(move |at| [cell[0] + at % 3 - 1, cell[1] + at / 3 % 3 - 1, cell[2] + at / 9 - 1])
}

/// Returns the shifts with the most votes of pairs of corners, each the mean of its votes.
fn voted(seen: &[CurveCorner], told: &[CurveCorner], size: f64) -> Vec<Vector> {
    let mut votes: HashMap<GridCell, (usize, Vector)> = HashMap::new();
    for recorded in seen {
        for programmed in told {
            if MIN_DIRECTION_COSINE < recorded.before.dot(&programmed.before)
                && MIN_DIRECTION_COSINE < recorded.after.dot(&programmed.after)
            {
                let shift = recorded.at - programmed.at;
                let (count, sum) = votes.entry(cell(&shift, size)).or_insert((0, Vector::zeros()));
                *count += 1;
                *sum += shift;
            }
        }
    }
    let mut cells: Vec<(usize, GridCell)> = votes.iter().map(|(cell, (count, _))| (*count, *cell)).collect();
    // The order of a hash map is arbitrary, so that ties are broken by the cell.
    for axis in (0..3).rev() {
        sort_by_number(&mut cells, |(_, cell)| -(cell[axis] as f64));
    }
    sort_by_number(&mut cells, |(count, _)| -(*count as f64));
    cells.truncate(2 * MAX_CANDIDATES);
    let merged = |cell: GridCell| {
        let near = around(cell).filter_map(|cell| votes.get(&cell));
        near.fold((0, Vector::zeros()), |(count, sum), (more, shift)| (count + more, sum + shift))
    };
    let mut shifts: Vec<(usize, Vector)> = Vec::new();
    for (_, cell) in cells {
        let (count, sum) = merged(cell);
        let shift = sum / count as f64;
        let is_new = shifts.iter().all(|(_, other)| size < (other - shift).norm());
        if MIN_VOTES <= count && is_new && shifts.len() < MAX_CANDIDATES {
            shifts.push((count, shift));
        }
    }
    shifts.into_iter().map(|(_, shift)| shift).collect()
}

/// Two curves with the cells that each passes through.
struct Overlap {
    recorded: (Vec<Point>, HashSet<GridCell>),
    programmed: (Vec<Point>, HashSet<GridCell>),
    size: f64,
}

impl Overlap {
    fn new(recorded: &[Point], programmed: &[Point], size: f64) -> Overlap {
        let side = |points: &[Point]| {
            let cells = points.iter().map(|point| cell(&point.coords, size)).collect();
            (thinned(points.to_vec(), MAX_RANKED_POINTS), cells)
        };
        Overlap { recorded: side(recorded), programmed: side(programmed), size }
    }

    /// Returns the sum of the parts of both curves that are near the other curve if the recorded one is
    /// shifted back by `shift` (mm).
    fn with(&self, shift: &Vector) -> f64 {
        let part = |points: &[Point], cells: &HashSet<GridCell>, by: Vector| {
            let is_near = |point: &&Point| {
                around(cell(&(point.coords + by), self.size)).any(|cell| cells.contains(&cell))
            };
            points.iter().filter(is_near).count() as f64 / points.len().max(1) as f64
        };
        part(&self.recorded.0, &self.programmed.1, -shift)
            + part(&self.programmed.0, &self.recorded.1, *shift)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A zigzag of unequal rows, with points every half millimetre.
    fn zigzag() -> Vec<Point> {
        let mut corners = vec![Point::origin()];
        for row in 0..9 {
            let y = 3.0 * f64::from(row);
            let x = if row % 2 == 0 { 30.0 + f64::from(row) } else { 1.0 };
            corners.extend([Point::new(x, y, 0.0), Point::new(x, y + 3.0, 0.0)]);
        }
        evenly(&corners, 0.5)
    }

    #[test]
    fn corners_vote_for_the_shift_between_two_curves() {
        let shift = Vector::new(-412.3, 77.7, -150.02);
        let programmed = zigzag();
        // Recorded with a way there and back, and twice.
        let mut recorded = vec![Point::new(50.0, 90.0, 70.0)];
        recorded.extend(programmed.iter().chain(&[Point::new(0.0, 50.0, 40.0)]).chain(&programmed));
        let recorded: Vec<Point> = recorded.iter().map(|point| point + shift).collect();
        let recorded = evenly(&recorded, 0.5);
        let found = voted(&corners(&recorded, 4), &corners(&programmed, 4), 0.5);
        let overlap = Overlap::new(&recorded, &programmed, 0.5);
        let best = found.iter().max_by(|a, b| overlap.with(a).total_cmp(&overlap.with(b)));
        let best = best.expect("corners agree");
        assert!((best - shift).norm() < 0.3, "{best:?}");
    }

    #[test]
    fn next_to_nothing_votes_for_nothing() {
        assert!(voted(&corners(&[], 4), &corners(&zigzag(), 4), 0.5).is_empty());
        assert!(corners(&evenly(&[Point::origin(), Point::new(9.0, 0.0, 0.0)], 0.5), 4).is_empty());
        assert_eq!(evenly(&[], 1.0).len(), 0);
    }
}
