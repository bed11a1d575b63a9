//! The segments of a toolpath as they are kept: 40 bytes each.
//!
//! A long program has millions of segments, and the memory they take is what tracing and planning wait for. A segment
//! begins where the one before ends, so only the first start is kept. Most go on as the one before does: the feedrate
//! and what few have, a curve, a turn or an exact stop, are kept where they change. A segment is put together whenever it
//! is read, which costs about as much as to fetch one that is kept whole; arcs and turns are shared, not copied.
//!
//! Limits: no more than 2³¹ changes of how they go; a feedrate is finite, as an infinite one is rapid.

use crate::simulation::compact::{Compact, Keep};
use crate::simulation::gcode::LineNumber;
use crate::simulation::toolpath::{Curve, Motion, Point, Rotation, Segment, Vector};
use std::collections::TryReserveError;

/// The segments of a toolpath in order, each beginning where the one before ends.
pub type Segments = Compact<Moves>;

/// How segments are kept.
#[derive(Clone, Default)]
pub struct Moves {
    /// Where the first begins, mm.
    start: Point,
    moves: Vec<Move>,
    /// How they go, a new one wherever that changes.
    ways: Vec<Way>,
    /// Of the segments that have one, in their order.
    shapes: Vec<Shape>,
}

/// One segment without its start and its way.
#[derive(Clone)]
struct Move {
    /// Where it ends, mm.
    end: Point,
    /// mm.
    length: f64,
    line: LineNumber,
    /// The lowest bit: it is an arc or turns axes. The others: the index of its way.
    mark: u32,
}

const _: () = assert!(size_of::<Move>() == 40);

/// How segments go that follow one another.
#[derive(Clone, Copy, PartialEq)]
struct Way {
    /// mm/s; infinite in rapid.
    feedrate: f64,
    exact_stop: bool,
    /// How many shapes there are up to here; that of a segment which has one is the last of them.
    shapes: u32,
}

/// What few segments have.
#[derive(Clone)]
struct Shape {
    curve: Curve,
    rotation: Rotation,
}

impl Way {
    #[inline]
    fn motion(&self) -> Motion {
        match self.feedrate {
            f64::INFINITY => Motion::Rapid,
            feedrate => Motion::Feed { feedrate },
        }
    }
}

impl Move {
    /// It is an arc or turns axes. That can be told without its way, for whose memory it would have to wait.
    #[inline]
    fn has_shape(&self) -> bool {
        self.mark & 1 == 1
    }

    /// The index of its way.
    #[inline]
    fn way(&self) -> usize {
        (self.mark >> 1) as usize
    }
}

impl Moves {
    /// The shape of a segment that has one.
    #[inline]
    fn shape(&self, of: &Move) -> Option<&Shape> {
        of.has_shape().then(|| &self.shapes[self.ways[of.way()].shapes as usize - 1])
    }

    /// Where the segment with this index begins, mm.
    #[inline]
    fn start(&self, index: usize) -> Point {
        index.checked_sub(1).map_or(self.start, |before| self.moves[before].end)
    }

    /// The shape of the segment with this index. This and those that follow are for where so many are looked at that even to
    /// put a segment together takes time. Panics beyond the end.
    #[inline]
    pub fn curve(&self, index: usize) -> &Curve {
        self.shape(&self.moves[index]).map_or(&Curve::Line, |shape| &shape.curve)
    }

    /// The length of the segment with this index, mm. Panics beyond the end.
    #[inline]
    pub fn length(&self, index: usize) -> f64 {
        self.moves[index].length
    }

    /// From the start to the end of the segment with this index, over its length: the tangent of a line. Panics beyond
    /// the end.
    #[inline]
    pub fn direction(&self, index: usize) -> Vector {
        let kept = &self.moves[index];
        (kept.end - self.start(index)) / kept.length
    }

    /// The unit tangents at the beginning and at the end of the segment with this index. Panics beyond the end.
    #[inline]
    pub fn tangents(&self, index: usize) -> [Vector; 2] {
        match self.moves[index].has_shape() {
            true => self.at(index).tangents(),
            false => [self.direction(index); 2],
        }
    }

    /// The position at a distance (mm) from the start of the segment with this index, mm. Panics beyond the end.
    #[inline]
    pub fn point(&self, index: usize, distance: f64) -> Point {
        let kept = &self.moves[index];
        self.curve(index).point(self.start(index), kept.end, distance / kept.length)
    }

    /// How the segment with this index is run. Panics beyond the end.
    #[inline]
    pub fn motion(&self, index: usize) -> Motion {
        self.ways[self.moves[index].way()].motion()
    }

    /// Whether this segment and the one before it are lines in feed, programmed alike, without a turn and without an exact
    /// stop. Panics at the first, and beyond the end.
    #[inline]
    pub fn goes_on(&self, index: usize) -> bool {
        let (before, kept) = (&self.moves[index - 1], &self.moves[index]);
        let way = &self.ways[kept.way()];
        before.mark == kept.mark && !kept.has_shape() && way.feedrate.is_finite() && !way.exact_stop
    }

    /// Where the lines end that go on as this segment does; the next index where none does. It takes no longer than the
    /// logarithm of their number. Panics beyond the end.
    pub fn goes_on_until(&self, index: usize) -> usize {
        let count = self.count();
        if count <= index + 1 || !self.goes_on(index + 1) {
            return index + 1;
        }
        // Ways never come back, and one that a line has gone has no shape any more.
        let mark = self.moves[index].mark;
        let mut step = 1;
        while index + step < count && self.moves[index + step].mark == mark {
            step *= 2;
        }
        let known = index + step / 2;
        let unknown = &self.moves[known..count.min(index + step)];
        known + unknown.partition_point(|kept| kept.mark == mark)
    }

    /// Each segment with the one that follows it.
    #[inline]
    pub fn pairs(&self) -> impl Iterator<Item = (Segment, Segment)> {
        (1..self.count()).map(|after| (self.at(after - 1), self.at(after)))
    }

    /// Makes room for so many more, and for no more than that. It is an error where there is no such room.
    pub fn try_reserve_exact(&mut self, additional: usize) -> Result<(), TryReserveError> {
        self.moves.try_reserve_exact(additional)
    }

    /// Takes the last segment away.
    pub fn pop(&mut self) -> Option<Segment> {
        let last = self.at(self.count().checked_sub(1)?);
        if self.moves.pop()?.has_shape() {
            self.shapes.pop();
        }
        self.ways.truncate(self.moves.last().map_or(0, |left| left.way() + 1));
        Some(last)
    }
}

impl Keep for Moves {
    type Item = Segment;

    #[inline]
    fn count(&self) -> usize {
        self.moves.len()
    }

    #[inline]
    fn at(&self, index: usize) -> Segment {
        let kept = &self.moves[index];
        let way = &self.ways[kept.way()];
        let line = || Shape { curve: Curve::Line, rotation: Rotation::NONE };
        let shape = self.shape(kept).map_or_else(line, Shape::clone);
        Segment {
            start: self.start(index),
            end: kept.end,
            curve: shape.curve,
            length: kept.length,
            motion: way.motion(),
            rotation: shape.rotation,
            exact_stop: way.exact_stop,
            line: kept.line,
        }
    }

    /// It begins where the last one ends; if it is the first, anywhere.
    #[inline]
    fn push(&mut self, segment: Segment) {
        let Segment { start, end, curve, length, motion, rotation, exact_stop, line } = segment;
        match self.moves.last() {
            Some(last) => debug_assert_eq!(start, last.end, "line {line:?} begins where the one before ends"),
            None => self.start = start,
        }
        let has_shape = !matches!(curve, Curve::Line) || !rotation.is_none();
        if has_shape {
            self.shapes.push(Shape { curve, rotation });
        }
        let feedrate = match motion {
            Motion::Rapid => f64::INFINITY,
            Motion::Feed { feedrate } => feedrate,
        };
        let way = Way { feedrate, exact_stop, shapes: self.shapes.len() as u32 };
        if self.ways.last() != Some(&way) {
            self.ways.push(way);
        }
        let mark = (self.ways.len() as u32 - 1) << 1 | u32::from(has_shape);
        self.moves.push(Move { end, length, line, mark });
    }

    fn reserve(&mut self, additional: usize) {
        self.moves.reserve(additional);
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
                motion: if one_in(3) { Motion::Rapid } else { Motion::Feed { feedrate: radius.round() } },
                rotation: if one_in(4) { turn.into() } else { Rotation::NONE },
                exact_stop: one_in(3),
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
                    let goes_on =
                        is_feed && before.motion == segment.motion && is_line(before) && is_line(segment);
                    assert_eq!(kept.goes_on(index), goes_on);
                    let until = kept.goes_on_until(index - 1);
                    assert!((index..until).all(|next| kept.goes_on(next)), "{index} to {until}");
                    assert!(until == count || !kept.goes_on(until), "{index} to {until}");
                }
                assert_eq!(kept.point(index, 0.3), segment.point(0.3));
                let line = Segment { curve: Curve::Line, ..segment.clone() };
                assert_eq!(kept.direction(index), line.tangent(0.0));
                assert_eq!(kept.tangents(index), segment.tangents());
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

    /// A line, an arc and a line may be programmed alike, and yet go on only where line follows line.
    #[test]
    fn lines_go_on_up_to_an_arc() {
        let mut random = Random(0xa2c);
        for _ in 0..500 {
            let like = |of: &Segment| Segment {
                motion: Motion::Feed { feedrate: 5.0 },
                rotation: Rotation::NONE,
                exact_stop: false,
                ..of.clone()
            };
            let count = 1 + random.below(40);
            let mut all: Vec<Segment> = random_segments(&mut random, count).iter().map(like).collect();
            let arc = random.below(2 * count);
            for (index, segment) in all.iter_mut().enumerate() {
                if index != arc {
                    segment.curve = Curve::Line;
                }
            }
            let kept: Segments = all.iter().cloned().collect();
            for index in 0..count {
                let end = (index + 1..count).find(|next| !kept.goes_on(*next)).unwrap_or(count);
                assert_eq!(kept.goes_on_until(index), end, "{index} of {count}, arc {arc}");
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
