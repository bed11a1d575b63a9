//! The programmed path for projections.
//!
//! Within a range of distances along the path, [`Path::nearest`] returns every local minimum of the distance
//! from a point: on a line the foot of the perpendicular, on an arc the best of closely spaced points,
//! improved by Newton's method. Axes that were not recorded are ignored.

use std::ops::Range;

use crate::simulation::ordered::sort_by_number;
use crate::simulation::toolpath::{Curve, Point, Segment, Segments, Toolpath, Vector};

/// Largest angle between search points on an arc, rad.
const MAX_ARC_STEP_RAD: f64 = 0.2;

/// Part of the path within which a pass begins.
const ENTRY_RATIO: f64 = 0.02;
/// Number of moves within which a pass begins.
const ENTRY_MOVES: usize = 3;
/// Distance along the path below which two places are one, mm: no recorder resolves less.
const SAME_PLACE_MM: f64 = 1e-3;

/// A path with its distances.
pub struct Path<'a> {
    segments: &'a Segments,
    /// Distance before each segment, and at the end, mm.
    distances: Vec<f64>,
    /// 1 for each axis that counts, 0 for the others.
    counts: Vector,
}

/// The projection of a point onto the path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projection {
    /// Distance along the path, mm.
    pub along: f64,
    /// Distance from the point, mm.
    pub away: f64,
    /// `true` if the connection is perpendicular to the path.
    is_perpendicular: bool,
}

impl<'a> Path<'a> {
    /// Returns the path of a program; `recorded` selects the axes that count.
    pub fn new(toolpath: &'a Toolpath, recorded: [bool; 3]) -> Path<'a> {
        let counts = Vector::from_fn(|axis, _| f64::from(u8::from(recorded[axis])));
        Path { segments: &toolpath.segments, distances: toolpath.distances(), counts }
    }

    /// Returns the length, mm.
    pub fn length(&self) -> f64 {
        self.distances.last().copied().unwrap_or(0.0)
    }

    /// Returns the segment at a distance along the path, mm.
    pub fn segment_at(&self, along: f64) -> Option<usize> {
        let begun = self.distances.partition_point(|distance| *distance <= along);
        begun.checked_sub(1).map(|segment| segment.min(self.segments.len().saturating_sub(1)))
    }

    /// Returns the length of the path in the axes that count, mm.
    pub fn recorded_length(&self) -> f64 {
        let part = |segment: Segment| match &segment.curve {
            Curve::Line => self.norm(segment.end - segment.start),
            Curve::Arc(_) => {
                let parts = 64;
                let point = |i: usize| segment.point(segment.length * i as f64 / parts as f64);
                (0..parts).map(|i| self.norm(point(i + 1) - point(i))).sum()
            }
        };
        self.segments.iter().map(part).sum()
    }

    /// Returns the corners of a polyline along the path, mm; 0 in axes that do not count.
    pub fn polyline(&self) -> Vec<Point> {
        let counted = |point: Point| Point::from(point.coords.component_mul(&self.counts));
        let first = self.segments.first().map(|segment| counted(segment.start));
        let mut points: Vec<Point> = first.into_iter().collect();
        for segment in self.segments {
            let parts = match &segment.curve {
                Curve::Line => 1,
                Curve::Arc(arc) => (arc.sweep / MAX_ARC_STEP_RAD).ceil().clamp(1.0, 1e4) as usize,
            };
            let offset = |part: usize| segment.length * part as f64 / parts as f64;
            points.extend((1..=parts).map(|part| counted(segment.point(offset(part)))));
        }
        points
    }

    /// Returns the point at a distance along the path (mm) and the direction there; `None` for a path without
    /// segments.
    pub fn at(&self, along: f64) -> Option<(Point, Vector)> {
        let index = self.segment_at(along)?;
        let segment = self.segments.get(index)?;
        let offset = (along - self.distances[index]).clamp(0.0, segment.length);
        Some((segment.point(offset), segment.tangent(offset)))
    }

    /// Returns the length of the beginning of the path within which a pass may enter it, mm: a part of the
    /// whole, and at least the first moves, as the very first one starts wherever the tool was.
    pub fn entry(&self) -> f64 {
        let moves = self.distances.get(ENTRY_MOVES).or(self.distances.last()).copied().unwrap_or(0.0);
        moves.max(ENTRY_RATIO * self.length())
    }

    /// Returns the smallest and the largest coordinates, mm; `None` if nothing moves.
    pub fn extent(&self) -> Option<[Range<f64>; 3]> {
        let first = self.segments.first()?.start;
        let mut extent = [0, 1, 2].map(|axis: usize| first[axis]..first[axis]);
        for segment in self.segments {
            let parts = if segment.curve == Curve::Line { 1 } else { 16 };
            for part in 1..=parts {
                let point = segment.point(segment.length * f64::from(part) / f64::from(parts));
                for axis in 0..3 {
                    extent[axis].start = extent[axis].start.min(point[axis]);
                    extent[axis].end = extent[axis].end.max(point[axis]);
                }
            }
        }
        Some(extent)
    }

    /// Returns in `found` the places within a range of distances (mm) that are nearer to `point` than their neighbourhood.
    /// On a path that returns along itself these are places on the way out and on the way back, however little the two
    /// ways differ; inside of a corner, places on both legs.
    pub fn nearest(&self, point: Point, within: Range<f64>, found: &mut Vec<Projection>) {
        found.clear();
        let Some(first) = self.segment_at(within.start) else { return };
        for (index, segment) in self.segments.iter().enumerate().skip(first) {
            let begin = self.distances[index];
            if within.end < begin {
                break;
            }
            let low = (within.start - begin).clamp(0.0, segment.length);
            let high = (within.end - begin).clamp(low, segment.length);
            match &segment.curve {
                Curve::Line => {
                    let foot = self.on_line(&segment, point);
                    let is_perpendicular = low < foot && foot < high;
                    found.push(self.projection(index, foot.clamp(low, high), point, is_perpendicular));
                }
                Curve::Arc(arc) => {
                    let turning = arc.sweep / segment.length;
                    let parts = ((high - low) * turning / MAX_ARC_STEP_RAD).ceil().clamp(1.0, 1e4) as usize;
                    for part in 0..=parts {
                        let offset = low + (high - low) * part as f64 / parts as f64;
                        let foot = self.improved(&segment, offset, point);
                        let is_perpendicular =
                            low < foot && foot < high && self.is_foot(&segment, foot, point);
                        found.push(self.projection(index, foot.clamp(low, high), point, is_perpendicular));
                    }
                }
            }
        }
        keep_minima(found);
    }

    fn norm(&self, vector: Vector) -> f64 {
        vector.component_mul(&self.counts).norm()
    }

    fn projection(&self, segment: usize, offset: f64, point: Point, is_perpendicular: bool) -> Projection {
        let away = self.norm(self.segments.at(segment).point(offset) - point);
        Projection { along: self.distances[segment] + offset, away, is_perpendicular }
    }

    /// Returns the offset of the foot of the perpendicular on a line, mm; not limited to its ends.
    fn on_line(&self, segment: &Segment, point: Point) -> f64 {
        let direction = segment.tangent(0.0).component_mul(&self.counts);
        let squared = direction.norm_squared();
        if squared < 1e-12 { 0.0 } else { direction.dot(&(point - segment.start)) / squared }
    }

    /// Returns `true` if an offset on an arc is the foot of a perpendicular and nearer than its neighbourhood.
    fn is_foot(&self, segment: &Segment, offset: f64, point: Point) -> bool {
        let (slope, curvature) = self.slopes(segment, offset, point);
        0.0 < curvature && slope.abs() <= SAME_PLACE_MM * curvature
    }

    /// Returns the first and the second derivative of half the squared distance of an arc from a point, mm and 1.
    fn slopes(&self, segment: &Segment, offset: f64, point: Point) -> (f64, f64) {
        let [tangent, curvature, _] = segment.derivatives(offset);
        let away = (segment.point(offset) - point).component_mul(&self.counts);
        (away.dot(&tangent), tangent.component_mul(&self.counts).norm_squared() + away.dot(&curvature))
    }

    /// Returns an offset on an arc after some steps of Newton's method towards the nearest place.
    fn improved(&self, segment: &Segment, offset: f64, point: Point) -> f64 {
        let mut offset = offset;
        for _ in 0..3 {
            let (slope, change) = self.slopes(segment, offset, point);
            if change <= 1e-9 {
                break;
            }
            offset = (offset - slope / change).clamp(0.0, segment.length);
        }
        offset
    }
}

/// Keeps the places, in order along the path, that are local minima: feet of perpendiculars, and other places without a
/// nearer neighbour.
fn keep_minima(found: &mut Vec<Projection>) {
    sort_by_number(found, |one| one.along);
    let all = std::mem::take(found);
    for (index, foot) in all.iter().enumerate() {
        let before = index.checked_sub(1).map(|at| &all[at]);
        let is_minimum = foot.is_perpendicular
            || before.is_none_or(|before| foot.away < before.away)
                && all.get(index + 1).is_none_or(|next| foot.away <= next.away);
        let is_known = found.last().is_some_and(|last: &Projection| foot.along - last.along <= SAME_PLACE_MM);
        if is_minimum && !is_known {
            found.push(*foot);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::Machine;
    use crate::simulation::gcode::read;
    use crate::simulation::interpreter::trace;

    /// Where along a program's path, from a distance on, it is nearest to a point.
    fn nearest(program: &str, from: f64, point: [f64; 3]) -> Vec<f64> {
        let toolpath = trace(&read(program.as_bytes()), &Machine::default());
        let mut found = Vec::new();
        Path::new(&toolpath, [true; 3]).nearest(Point::from(point), from..f64::INFINITY, &mut found);
        found.into_iter().map(|foot| (1e6 * foot.along).round() / 1e6).collect()
    }

    #[test]
    fn a_path_that_goes_back_is_near_on_both_ways() {
        let there_and_back = "G21 G90 G1 X10 F600\nX1\nX7";
        for y in [0.0, 0.3] {
            assert_eq!(nearest(there_and_back, 0.0, [4.0, y, 0.0]), [4.0, 16.0, 22.0]);
            assert_eq!(nearest(there_and_back, 0.0, [6.1, y, 0.0]), [6.1, 13.9, 24.1]);
        }
        assert_eq!(nearest(there_and_back, 0.0, [10.0, 0.0, 0.0]), [10.0]);
    }

    /// The ways out and back differ by a ten-thousandth of a millimetre, and not even that much may decide between them.
    #[test]
    fn a_path_that_goes_back_almost_along_itself_is_near_on_all_ways() {
        let ways = "G21 G90 G1 X0.866 Y0.5 F600\nX0 Y0\nX3.4641 Y2";
        let places = nearest(ways, 0.0, [0.433, 0.25, 0.0]);
        assert_eq!(places.len(), 3, "{places:?}");
    }

    #[test]
    fn a_corner_is_one_place_from_outside_and_two_from_inside() {
        let corner = "G21 G90 G1 X10 F600\nY10";
        assert_eq!(nearest(corner, 0.0, [10.2, -0.1, 0.0]), [10.0]);
        assert_eq!(nearest(corner, 0.0, [9.0, 2.0, 0.0]), [9.0, 12.0]);
        let arc = "G21 G90 G17 G1 X10 F600\nG3 X10 Y10 I0 J5";
        assert_eq!(nearest(arc, 0.0, [10.0, -0.2, 0.0]), [10.0]);
    }
}
