//! The segments of a toolpath in packed form: 28 bytes each.
//!
//! A long program has millions of segments, and the time of tracing and planning goes into moving their memory. A
//! segment begins where the one before ends, so only the first start is stored; the length of a line is the
//! distance of its ends. Most segments have the motion of the segment before and the next line of the program, so
//! a group of such segments shares its motion. The few arcs, turns of axes and exact stops begin a new group.
//! [`Segments`] assembles a segment whenever it is read, which costs less than to fetch a whole one from memory;
//! arcs and turns are shared, not copied.
//!
//! Limits: no more than 2³² − 1 segments; a feedrate is not negative, as a negative one is rapid.

use crate::simulation::gcode::LineNumber;
use crate::simulation::packed::{PackedVec, Packing};
use crate::simulation::toolpath::{Curve, Motion, Point, Rotation, Segment, Vector};
use std::collections::TryReserveError;

/// The segments of a toolpath in order, each beginning where the one before ends.
pub type Segments = PackedVec<Moves>;

/// Storage of segments.
#[derive(Clone, Default)]
pub struct Moves {
    /// Start of the first segment, if there is one, and the end of each, mm.
    points: Vec<Point>,
    /// Index of the group of each segment.
    group_indices: Vec<u32>,
    /// The groups, in order.
    groups: Vec<SegmentGroup>,
    /// The shapes of the segments that have one, in order.
    shapes: Vec<SegmentShape>,
}

/// Segments with one motion that follow one another, on lines that follow one another.
#[derive(Clone, Copy)]
struct SegmentGroup {
    /// Feedrate, mm/s; in rapid the modal one, with a negative sign.
    feedrate: f64,
    /// Index of its first segment.
    first: u32,
    /// Line of that segment.
    line: u32,
    /// Number of shapes up to and with this group.
    shapes: u32,
    /// `true` if its only segment has the last of those shapes.
    has_shape: bool,
    exact_stop: bool,
    exact_path: bool,
}

/// The part of a segment that few have: arcs, turns of axes, and lengths other than the distance of the ends.
#[derive(Clone)]
struct SegmentShape {
    curve: Curve,
    rotation: Rotation,
    /// Length, mm.
    length: f64,
}

impl SegmentGroup {
    #[inline]
    fn motion(&self) -> Motion {
        match self.feedrate {
            feedrate if feedrate < 0.0 => Motion::Rapid { modal_feedrate: -feedrate },
            feedrate => Motion::Feed { feedrate },
        }
    }

    /// Returns the line of one of its segments, by the index of that segment.
    #[inline]
    fn line(&self, index: usize) -> LineNumber {
        LineNumber(self.line.wrapping_add(index as u32 - self.first))
    }

    /// Returns `true` if its segments are lines in feed, without turns of axes and without exact stops.
    #[inline]
    fn is_plain(&self) -> bool {
        !self.has_shape && !self.exact_stop && 0.0 < self.feedrate
    }
}

impl Moves {
    /// Returns the group of the segment with this index.
    #[inline]
    fn group(&self, index: usize) -> &SegmentGroup {
        &self.groups[self.group_indices[index] as usize]
    }

    /// Returns the shape of a segment of this group, if it has one.
    #[inline]
    fn shape_of(&self, group: &SegmentGroup) -> Option<&SegmentShape> {
        group.has_shape.then(|| &self.shapes[group.shapes as usize - 1])
    }

    /// Returns the shape of the segment with this index, if it has one.
    #[inline]
    fn shape(&self, index: usize) -> Option<&SegmentShape> {
        // Most programs have no shapes, and need not look up the group.
        if self.shapes.is_empty() { None } else { self.shape_of(self.group(index)) }
    }

    /// Returns start and end of the segment with this index, mm.
    #[inline]
    fn ends(&self, index: usize) -> [Point; 2] {
        [self.points[index], self.points[index + 1]]
    }

    /// Returns the vector from the start to the end of the segment with this index, mm.
    #[inline]
    fn chord(&self, index: usize) -> Vector {
        let [start, end] = self.ends(index);
        end - start
    }

    /// Returns the curve of the segment with this index. This method and those below spare hot loops the whole
    /// segment.
    ///
    /// # Panics
    ///
    /// If there is no such segment.
    #[inline]
    pub fn curve(&self, index: usize) -> &Curve {
        self.shape(index).map_or(&Curve::Line, |shape| &shape.curve)
    }

    /// Returns the length of the segment with this index, mm.
    ///
    /// # Panics
    ///
    /// If there is no such segment.
    #[inline]
    pub fn length(&self, index: usize) -> f64 {
        self.shape(index).map_or_else(|| self.chord(index).norm(), |shape| shape.length)
    }

    /// Returns the vector from start to end of the segment with this index over its length: the tangent of a line.
    ///
    /// # Panics
    ///
    /// If there is no such segment.
    #[inline]
    pub fn direction(&self, index: usize) -> Vector {
        self.chord(index) / self.length(index)
    }

    /// Returns the length (mm) of the segment with this index, and the unit tangents at both ends.
    ///
    /// # Panics
    ///
    /// If there is no such segment.
    #[inline]
    pub fn length_and_tangents(&self, index: usize) -> (f64, [Vector; 2]) {
        let chord = self.chord(index);
        match self.shape(index) {
            Some(shape) => (shape.length, self.at(index).tangents()),
            None => {
                let length = chord.norm();
                (length, [chord / length; 2])
            }
        }
    }

    /// Returns the position (mm) at a distance (mm) from the start of the segment with this index, and the unit tangent there.
    ///
    /// # Panics
    ///
    /// If there is no such segment.
    pub fn point_and_tangent(&self, index: usize, distance: f64) -> (Point, Vector) {
        let segment = self.at(index);
        (segment.point(distance), segment.tangent(distance))
    }

    /// Returns the position at a distance (mm) from the start of the segment with this index, mm.
    ///
    /// # Panics
    ///
    /// If there is no such segment.
    #[inline]
    pub fn point(&self, index: usize, distance: f64) -> Point {
        let [start, end] = self.ends(index);
        self.curve(index).point(start, end, distance / self.length(index))
    }

    /// Returns the motion of the segment with this index.
    ///
    /// # Panics
    ///
    /// If there is no such segment.
    #[inline]
    pub fn motion(&self, index: usize) -> Motion {
        self.group(index).motion()
    }

    /// Returns `true` if this segment and the one before it are in one group of plain lines: in feed, programmed alike,
    /// without turns and exact stops, and on lines that follow one another.
    ///
    /// # Panics
    ///
    /// If it is the first segment, or there is no such segment.
    #[inline]
    pub fn is_plain_continuation(&self, index: usize) -> bool {
        self.group_indices[index - 1] == self.group_indices[index] && self.group(index).is_plain()
    }

    /// Returns the end of the plain lines that continue this segment; the next index if none does.
    ///
    /// # Panics
    ///
    /// If there is no such segment.
    pub fn plain_lines_end(&self, index: usize) -> usize {
        let group = self.group_indices[index] as usize;
        match self.groups.get(group + 1) {
            _ if !self.groups[group].is_plain() => index + 1,
            Some(next) => next.first as usize,
            None => self.count(),
        }
    }

    /// Returns each segment with the one that follows it.
    #[inline]
    pub fn pairs(&self) -> impl Iterator<Item = (Segment, Segment)> {
        (1..self.count()).map(|after| (self.at(after - 1), self.at(after)))
    }

    /// Reserves memory for a number of further segments and for no more.
    ///
    /// # Errors
    ///
    /// If there is not enough memory.
    pub fn try_reserve_exact(&mut self, additional: usize) -> Result<(), TryReserveError> {
        self.points.try_reserve_exact(additional + usize::from(self.points.is_empty()))?;
        self.group_indices.try_reserve_exact(additional)
    }

    /// Removes the last segment and returns it; `None` if there is none.
    pub fn pop(&mut self) -> Option<Segment> {
        let index = self.count().checked_sub(1)?;
        let last = self.at(index);
        let group = *self.group(index);
        if group.has_shape {
            self.shapes.pop();
        }
        if group.first as usize == index {
            self.groups.pop();
        }
        self.group_indices.pop();
        self.points.truncate(if index == 0 { 0 } else { index + 1 });
        Some(last)
    }
}

impl Packing for Moves {
    type Item = Segment;

    #[inline]
    fn count(&self) -> usize {
        self.group_indices.len()
    }

    #[inline]
    fn at(&self, index: usize) -> Segment {
        let group = self.group(index);
        let [start, end] = self.ends(index);
        let line =
            || SegmentShape { curve: Curve::Line, rotation: Rotation::NONE, length: (end - start).norm() };
        let SegmentShape { curve, rotation, length } =
            self.shape_of(group).map_or_else(line, SegmentShape::clone);
        let &SegmentGroup { exact_stop, exact_path, .. } = group;
        let (motion, line) = (group.motion(), group.line(index));
        Segment { start, end, curve, length, motion, rotation, exact_stop, exact_path, line }
    }

    /// Appends a segment, which begins where the last one ends; the first begins anywhere.
    #[inline]
    fn push(&mut self, segment: Segment) {
        let Segment { start, end, curve, length, motion, rotation, exact_stop, exact_path, line } = segment;
        match self.points.last() {
            Some(last) => debug_assert_eq!(start, *last, "line {line:?} begins where the one before ends"),
            None => self.points.push(start),
        }
        let has_shape =
            !matches!(curve, Curve::Line) || !rotation.is_none() || length != (end - start).norm();
        let feedrate = match motion {
            Motion::Rapid { modal_feedrate } => -modal_feedrate,
            Motion::Feed { feedrate } => feedrate,
        };
        let index = self.count();
        let is_like = |group: &SegmentGroup| {
            group.feedrate == feedrate
                && (group.exact_stop, group.exact_path) == (exact_stop, exact_path)
                && !group.has_shape
                && group.line(index) == line
        };
        if has_shape || !self.groups.last().is_some_and(is_like) {
            if has_shape {
                self.shapes.push(SegmentShape { curve, rotation, length });
            }
            let (first, LineNumber(line), shapes) = (index as u32, line, self.shapes.len() as u32);
            self.groups.push(SegmentGroup {
                feedrate,
                first,
                line,
                shapes,
                has_shape,
                exact_stop,
                exact_path,
            });
        }
        self.group_indices.push(self.groups.len() as u32 - 1);
        self.points.push(end);
    }

    fn reserve(&mut self, additional: usize) {
        self.points.reserve(additional + usize::from(self.points.is_empty()));
        self.group_indices.reserve(additional);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation::toolpath::Arc;
    use crate::simulation::toolpath::random::Random;

    /// Segments of all kinds in random order.
    fn random_segments(random: &mut Random, count: usize) -> Vec<Segment> {
        let mut end = Point::new(1.0, -2.0, 0.5);
        let mut segment = |line: usize| {
            let mut number = || random.below(2001) as f64 / 100.0 - 10.0;
            let start = std::mem::replace(&mut end, Point::new(number(), number(), number()));
            let turn = Vector::new(number(), 0.0, number());
            let (radius, sweep) = (number().abs() + 1.0, number().abs() + 0.1);
            let center = start - radius * Vector::x();
            let (e1, e2, rise) = (Vector::x(), Vector::y(), number() * Vector::z());
            let arc = Arc { center, e1, e2, start_radius: radius, end_radius: radius, sweep, rise };
            let mut one_in = |of: usize| random.below(of) == 0;
            Segment {
                start,
                end,
                length: if one_in(2) { arc.length() } else { (end - start).norm() },
                curve: if one_in(3) { Curve::Arc(arc.into()) } else { Curve::Line },
                motion: if one_in(3) {
                    Motion::Rapid { modal_feedrate: 1.0 + radius.round() }
                } else {
                    Motion::Feed { feedrate: radius.round() }
                },
                rotation: if one_in(4) { turn.into() } else { Rotation::NONE },
                exact_stop: one_in(3),
                exact_path: one_in(5),
                line: LineNumber(line as u32),
            }
        };
        (0..count).map(&mut segment).collect()
    }

    #[test]
    fn what_is_pushed_is_read_and_taken_back() {
        let mut random = Random(0x5e9);
        for count in (0..200).chain([5000]) {
            let expected = random_segments(&mut random, count);
            let mut kept: Segments = expected.iter().cloned().collect();
            assert_eq!((kept.len(), kept.is_empty()), (count, count == 0));
            assert_eq!((kept.first(), kept.last()), (expected.first().cloned(), expected.last().cloned()));
            assert_eq!(kept.get(count), None);
            for (index, segment) in expected.iter().enumerate() {
                assert_eq!(kept.at(index), *segment);
                assert_eq!((kept.curve(index), kept.length(index)), (&segment.curve, segment.length));
                assert_eq!(kept.motion(index), segment.motion);
                if let Some(before) = index.checked_sub(1).map(|before| &expected[before]) {
                    let is_line =
                        |one: &Segment| one.curve == Curve::Line && one.rotation.is_none() && !one.exact_stop;
                    let is_feed = matches!(segment.motion, Motion::Feed { .. });
                    let is_plain_continuation =
                        is_feed && before.motion == segment.motion && is_line(before) && is_line(segment);
                    assert!(
                        is_plain_continuation || !kept.is_plain_continuation(index),
                        "{index} does not go on"
                    );
                    let until = kept.plain_lines_end(index - 1);
                    assert!(
                        (index..until).all(|next| kept.is_plain_continuation(next)),
                        "{index} to {until}"
                    );
                    assert!(until == count || !kept.is_plain_continuation(until), "{index} to {until}");
                }
                assert_eq!(kept.point(index, 0.3), segment.point(0.3));
                let line = Segment { curve: Curve::Line, ..segment.clone() };
                assert_eq!(kept.direction(index), line.tangent(0.0));
                assert_eq!(kept.length_and_tangents(index), (segment.length, segment.tangents()));
            }
            // Some are taken away and others put in their place.
            let removed = random.below(count + 1);
            for segment in expected[count - removed..].iter().rev() {
                assert_eq!(kept.pop().as_ref(), Some(segment));
            }
            assert!(kept.iter().eq(expected[..count - removed].iter().cloned()));
            kept.extend(expected[count - removed..].iter().cloned());
            assert!(kept.iter().eq(expected.iter().cloned()));
        }
        assert_eq!(Segments::default().pop(), None);
    }

    /// A line, an arc and a line may be programmed alike, and yet go on only where line follows line, also in the text.
    #[test]
    fn lines_go_on_up_to_an_arc() {
        let mut random = Random(0xa2c);
        for _ in 0..500 {
            let like = |of: &Segment| Segment {
                motion: Motion::Feed { feedrate: 5.0 },
                rotation: Rotation::NONE,
                exact_stop: false,
                exact_path: false,
                length: (of.end - of.start).norm(),
                ..of.clone()
            };
            let count = 1 + random.below(40);
            let mut all: Vec<Segment> = random_segments(&mut random, count).iter().map(like).collect();
            let [arc, gap] = [random.below(2 * count), random.below(2 * count)];
            for (index, segment) in all.iter_mut().enumerate() {
                if index != arc {
                    segment.curve = Curve::Line;
                }
                segment.line.0 += u32::from(gap <= index);
            }
            let kept: Segments = all.iter().cloned().collect();
            assert!(kept.iter().eq(all.iter().cloned()));
            let is_line = |index: usize| all[index].curve == Curve::Line;
            for index in 1..count {
                let is_plain_continuation = is_line(index - 1) && is_line(index) && index != gap;
                assert_eq!(
                    kept.is_plain_continuation(index),
                    is_plain_continuation,
                    "{index} of {count}, arc {arc}, gap {gap}"
                );
            }
            for index in 0..count {
                let end = (index + 1..count).find(|next| !kept.is_plain_continuation(*next)).unwrap_or(count);
                assert_eq!(kept.plain_lines_end(index), end, "{index} of {count}, arc {arc}, gap {gap}");
            }
        }
    }

    #[test]
    fn all_ways_through_them_agree() {
        let expected = random_segments(&mut Random(7), 300);
        let kept: Segments = expected.iter().cloned().collect();
        assert!(kept.iter().rev().eq(expected.iter().rev().cloned()));
        assert_eq!(kept.iter().skip(100).step_by(3).len(), 67);
        assert!(kept.iter().skip(100).step_by(3).eq(expected.iter().skip(100).step_by(3).cloned()));
        for range in [0..0, 0..300, 17..18, 100..250, 300..300] {
            assert!(kept.range(range.clone()).eq(expected[range].iter().cloned()));
        }
        let pairs = expected.windows(2).map(|pair| (pair[0].clone(), pair[1].clone()));
        assert!(kept.pairs().eq(pairs));
    }

    #[test]
    fn they_are_equal_by_what_they_are() {
        let expected = random_segments(&mut Random(3), 50);
        let whole: Segments = expected.iter().cloned().collect();
        let part: Segments = whole.range(20..50).collect();
        assert_eq!(part, expected[20..].iter().cloned().collect());
        assert_ne!(part, whole);
        assert_eq!(format!("{whole:?}"), format!("{expected:?}"));
    }

    #[test]
    #[should_panic(expected = "begins where the one before ends")]
    fn a_chain_does_not_break() {
        let all = random_segments(&mut Random(5), 3);
        let _: Segments = [all[0].clone(), all[2].clone()].into_iter().collect();
    }
}
