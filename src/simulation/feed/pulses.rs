//! The packed pulses of a plan: 20 bytes each.
//!
//! A long program has one and a half pulses per segment, and their memory limits the speed of planning. Two
//! thirds of the pulses begin where their segment begins, and nearly all others where the only earlier pulse
//! of the segment ends. Most pulses are even, so that a single feedrate describes them. Separate lists hold
//! the offsets and end feedrates of the exceptions. A pulse is read back bit for bit.
//!
//! Limits: no more than 2³² − 1 exceptions.

use crate::simulation::feed::Pulse;
use crate::simulation::packed::{PackedVec, Packing};
use std::collections::TryReserveError;
use std::ops::Range;

/// The pulses of a plan in order.
pub type Pulses = PackedVec<PulsePacking>;

/// The layout of packed pulses.
#[derive(Clone, Default)]
pub struct PulsePacking {
    kept: Vec<PackedPulse>,
    /// Marks of the exceptions among each [`PULSES_PER_MARK`] pulses.
    marks: Vec<ExceptionMarks>,
    /// Distances from the start of the segment, mm, of the exceptions in order.
    offsets: Vec<f64>,
    /// XOR of the bits of the feedrates at beginning and end of the exceptions in order, up to the last
    /// exception that is not even; the list is empty if commands have no ramps.
    changes: Vec<u64>,
}

/// A pulse without offset and end feedrate, and without padding.
#[derive(Clone, Copy)]
#[repr(C, packed(4))]
struct PackedPulse {
    segment: u32,
    /// Duration, s.
    duration: f64,
    /// Feedrate at the beginning, mm/s.
    feedrate: f64,
}

const _: () = assert!(size_of::<PackedPulse>() == 20);

/// Marks of the exceptions among consecutive pulses.
#[derive(Clone, Copy)]
struct ExceptionMarks {
    /// Number of exceptions before these pulses.
    before: u32,
    /// One bit per pulse, the lowest for the first.
    bits: u32,
}

/// Number of pulses whose marks share an entry.
const PULSES_PER_MARK: usize = u32::BITS as usize;

impl PulsePacking {
    /// Returns the index of the segment of a pulse without assembling the pulse, which takes time in long
    /// loops.
    ///
    /// # Panics
    ///
    /// Panics if `index` is out of bounds.
    #[inline]
    pub fn segment(&self, index: usize) -> usize {
        self.kept[index].segment as usize
    }

    /// Returns the duration of a pulse, s.
    ///
    /// # Panics
    ///
    /// Panics if `index` is out of bounds.
    #[inline]
    pub fn duration(&self, index: usize) -> f64 {
        self.kept[index].duration
    }

    /// Returns the feedrates at the beginning and at the end of a pulse, mm/s.
    ///
    /// # Panics
    ///
    /// Panics if `index` is out of bounds.
    #[inline]
    pub fn feedrates(&self, index: usize) -> [f64; 2] {
        let first = self.kept[index].feedrate;
        if self.changes.is_empty() {
            return [first; 2];
        }
        [first, self.beside(index).map_or(first, |beside| self.last_feedrate(first, beside))]
    }

    /// Returns the distance from the start of the segment to the beginning of a pulse, mm.
    ///
    /// # Panics
    ///
    /// Panics if `index` is out of bounds.
    #[inline]
    pub fn offset(&self, index: usize) -> f64 {
        let usual = || self.usual_offset(index, self.kept[index].segment);
        self.beside(index).map_or_else(usual, |beside| self.offsets[beside])
    }

    /// Returns the indices of the pulses of some segments.
    pub fn of_segments(&self, segments: Range<usize>) -> Range<usize> {
        let first = self.before(segments.start, 0);
        first..self.before(segments.end, first)
    }

    /// Returns the number of pulses before a segment. The search skips the first `skipped` pulses, all of which must lie
    /// before the segment.
    ///
    /// # Panics
    ///
    /// Panics if there are fewer pulses than `skipped`.
    pub fn before(&self, segment: usize, skipped: usize) -> usize {
        skipped + self.kept[skipped..].partition_point(|kept| (kept.segment as usize) < segment)
    }

    /// Groups the pulses with these indices by their segments: returns the indices of each group.
    ///
    /// # Panics
    ///
    /// Panics if the range is out of bounds.
    #[inline]
    pub fn by_segment(&self, range: Range<usize>) -> impl Iterator<Item = Range<usize>> {
        let mut end = range.start;
        self.kept[range].chunk_by(|a, b| a.segment == b.segment).map(move |own| {
            let begin = end;
            end += own.len();
            begin..end
        })
    }

    /// Reserves memory for exactly `additional` more pulses with the same share of exceptions.
    ///
    /// # Errors
    ///
    /// Returns an error if the allocation fails.
    pub fn try_reserve_exact(&mut self, additional: usize) -> Result<(), TryReserveError> {
        let more = |of: usize| (of as f64 / self.count().max(1) as f64 * additional as f64) as usize;
        let (offsets, changes) = (more(self.offsets.len()), more(self.changes.len()));
        self.kept.try_reserve_exact(additional)?;
        self.marks.try_reserve_exact(additional.div_ceil(PULSES_PER_MARK))?;
        self.offsets.try_reserve_exact(offsets)?;
        self.changes.try_reserve_exact(changes)
    }

    /// Returns capacity and length of all lists.
    #[cfg(test)]
    pub fn room(&self) -> [(usize, usize); 4] {
        let PulsePacking { kept, marks, offsets, changes } = self;
        [
            (kept.capacity(), kept.len()),
            (marks.capacity(), marks.len()),
            (offsets.capacity(), offsets.len()),
            (changes.capacity(), changes.len()),
        ]
    }

    /// Returns the distance from the start of the segment (mm) to the beginning of a pulse that is no
    /// exception: the end of the pulse before it, if that is even and the first of the segment.
    #[inline]
    fn usual_offset(&self, index: usize, segment: u32) -> f64 {
        let before = index.wrapping_sub(1);
        match self.kept.get(before) {
            Some(before) if before.segment == segment => before.duration * before.feedrate,
            _ => 0.0,
        }
    }

    /// Returns the index of a pulse among the exceptions; `None` if it is no exception.
    #[inline]
    fn beside(&self, index: usize) -> Option<usize> {
        let ExceptionMarks { before, bits } = self.marks[index / PULSES_PER_MARK];
        let own = 1 << (index % PULSES_PER_MARK);
        (bits & own != 0).then(|| (before + (bits & (own - 1)).count_ones()) as usize)
    }

    /// Returns the feedrate at the end of a pulse that begins with `first` (mm/s) and has the index `beside`
    /// among the exceptions, mm/s.
    #[inline]
    fn last_feedrate(&self, first: f64, beside: usize) -> f64 {
        f64::from_bits(first.to_bits() ^ self.changes.get(beside).copied().unwrap_or_default())
    }
}

impl Packing for PulsePacking {
    type Item = Pulse;

    #[inline]
    fn count(&self) -> usize {
        self.kept.len()
    }

    #[inline]
    fn at(&self, index: usize) -> Pulse {
        let PackedPulse { segment, duration, feedrate } = self.kept[index];
        let (offset, last) = match self.beside(index) {
            Some(beside) => (self.offsets[beside], self.last_feedrate(feedrate, beside)),
            None => (self.usual_offset(index, segment), feedrate),
        };
        Pulse { segment, duration, offset, feedrate: [feedrate, last] }
    }

    #[inline]
    fn push(&mut self, pulse: Pulse) {
        let Pulse { segment, duration, offset, feedrate: [feedrate, last] } = pulse;
        let (index, change) = (self.count(), feedrate.to_bits() ^ last.to_bits());
        if index.is_multiple_of(PULSES_PER_MARK) {
            self.marks.push(ExceptionMarks { before: self.offsets.len() as u32, bits: 0 });
        }
        // The offset is compared by its bits too, as −0.0 = 0.0.
        let usual = self.usual_offset(index, segment);
        if (offset.to_bits(), change) != (usual.to_bits(), 0) {
            self.marks[index / PULSES_PER_MARK].bits |= 1 << (index % PULSES_PER_MARK);
            if change != 0 {
                self.changes.resize(self.offsets.len(), 0);
                self.changes.push(change);
            }
            self.offsets.push(offset);
        }
        self.kept.push(PackedPulse { segment, duration, feedrate });
    }

    fn reserve(&mut self, additional: usize) {
        self.kept.reserve(additional);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns `count` pulses: each kind of offset with each kind of feedrates, and ever more per segment.
    fn pulses(count: u32) -> Vec<Pulse> {
        let mut end = 0.0_f64;
        let pulse = |number: u32| {
            let (first, last) = (f64::from(number) / 7.0 + 0.1, f64::from(number) / 3.0 + 0.2);
            // From the start, from where the pulse before ends, from just beyond that and from anywhere.
            let offsets = [0.0, end, -0.0, end.next_up(), first];
            let feedrates =
                [[first; 2], [first, last], [0.0, last], [0.0; 2], [-0.0; 2], [0.0, -0.0], [-0.0, 0.0]];
            let pulse = Pulse {
                segment: number.isqrt(),
                duration: first + last,
                offset: offsets[number as usize % offsets.len()],
                feedrate: feedrates[number as usize % feedrates.len()],
            };
            end = pulse.duration * 0.5 * (pulse.feedrate[0] + pulse.feedrate[1]);
            pulse
        };
        (0..count).map(pulse).collect()
    }

    /// Returns the fields of a pulse as bits, which distinguish −0.0 from 0.0.
    fn bits(pulse: Pulse) -> (u32, [u64; 4]) {
        let Pulse { segment, duration, offset, feedrate: [first, last] } = pulse;
        (segment, [duration, offset, first, last].map(f64::to_bits))
    }

    #[test]
    fn what_is_pushed_is_read_bit_for_bit() {
        for count in [0, 1, 2, 100, 5000] {
            let expected = pulses(count);
            let (begin, end) = expected.split_at(expected.len() / 2);
            let mut kept: Pulses = begin.iter().copied().collect();
            kept.extend(end.iter().copied());
            assert_eq!((kept.len(), kept.is_empty()), (expected.len(), expected.is_empty()));
            for (index, &pulse) in expected.iter().enumerate() {
                assert_eq!(bits(kept.at(index)), bits(pulse));
                assert_eq!(kept.segment(index), pulse.segment as usize);
                assert_eq!(kept.duration(index), pulse.duration);
                assert_eq!(kept.offset(index), pulse.offset);
                assert_eq!(kept.feedrates(index), pulse.feedrate);
            }
        }
    }

    #[test]
    fn all_ways_through_them_agree() {
        let expected = pulses(300);
        let kept: Pulses = expected.iter().copied().collect();
        assert!(kept.iter().rev().map(bits).eq(expected.iter().rev().copied().map(bits)));
        for range in [0..0, 0..300, 17..18, 100..250, 300..300] {
            let own = &expected[range.clone()];
            assert_eq!(kept.range(range.clone()).len(), own.len());
            assert!(kept.range(range.clone()).map(bits).eq(own.iter().copied().map(bits)));
            let chunks = kept.by_segment(range).map(|own| kept.range(own).collect::<Vec<Pulse>>());
            assert!(chunks.eq(own.chunk_by(|a, b| a.segment == b.segment)));
        }
        for segment in 0..expected[299].segment as usize + 2 {
            let before = expected.iter().filter(|pulse| (pulse.segment as usize) < segment).count();
            assert_eq!(kept.before(segment, before.min(1)), before);
        }
    }

    #[test]
    fn they_are_equal_by_what_they_are() {
        let expected = pulses(50);
        let whole: Pulses = expected.iter().copied().collect();
        let part: Pulses = whole.range(20..50).collect();
        assert_eq!(part, expected[20..].iter().copied().collect());
        assert_ne!(part, whole);
        assert_eq!(format!("{whole:?}"), format!("{expected:?}"));
    }

    #[test]
    fn only_what_few_have_lies_beside() {
        let even = Pulse { segment: 0, duration: 1.0, offset: 0.0, feedrate: [5.0; 2] };
        let halt = Pulse { feedrate: [0.0; 2], ..even };
        let next = Pulse { offset: 5.0, ..even };
        let mut kept: Pulses = [even, next, Pulse { segment: 1, ..halt }].into_iter().collect();
        assert_eq!(kept.room().map(|(_, needed)| needed), [3, 1, 0, 0]);
        // The third of a segment does not begin where the one before it would end by itself.
        kept.extend([Pulse { segment: 2, ..even }, Pulse { segment: 2, ..next }]);
        kept.push(Pulse { segment: 2, offset: 10.0, ..even });
        assert_eq!(kept.room().map(|(_, needed)| needed), [6, 1, 1, 0]);
        kept.try_reserve_exact(600).expect("there is room");
        assert_eq!(kept.room().map(|(room, _)| room), [606, 20, 101, 0]);
        kept.push(Pulse { segment: 3, feedrate: [5.0, 6.0], ..even });
        assert_eq!(kept.room().map(|(_, needed)| needed), [7, 1, 2, 2]);
    }
}
