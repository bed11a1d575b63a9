//! A column of values that only few segments have: those have one each, with their index beside it.

use std::ops::Range;

/// Values that only few segments have.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Few {
    /// The indices of the segments, ascending.
    segments: Vec<u32>,
    values: Vec<f64>,
}

impl Few {
    /// The values of these segments, whose indices ascend; as many as there are of both.
    pub fn new(segments: Vec<u32>, values: Vec<f64>) -> Few {
        debug_assert!(segments.is_sorted() && segments.len() == values.len());
        Few { segments, values }
    }

    /// The indices of the segments and their values.
    pub fn into_columns(self) -> (Vec<u32>, Vec<f64>) {
        (self.segments, self.values)
    }

    /// The value of a segment; none where it has none.
    pub fn get(&self, segment: usize) -> Option<f64> {
        self.within(segment..segment + 1).first().copied()
    }

    /// All values in the order of their segments.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// The values of those of these segments that have one.
    pub fn within(&self, segments: Range<usize>) -> &[f64] {
        let before = |end: usize| self.segments.partition_point(|&segment| (segment as usize) < end);
        &self.values[before(segments.start)..before(segments.end)]
    }

    /// Adds the value of a segment behind all that have one; where that is the last of them, it keeps its value.
    pub(super) fn add(&mut self, segment: usize, value: f64) {
        if self.segments.last() != Some(&(segment as u32)) {
            self.segments.push(segment as u32);
            self.values.push(value);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_found_by_their_segments() {
        let mut few = Few::default();
        assert_eq!((few.get(0), few.within(0..9)), (None, &[][..]));
        for (segment, value) in [(2, 0.5), (2, 9.0), (3, 0.25), (7, 1.0)] {
            few.add(segment, value);
        }
        let found: Vec<Option<f64>> = (0..9).map(|segment| few.get(segment)).collect();
        let none = None;
        assert_eq!(found, [none, none, Some(0.5), Some(0.25), none, none, none, Some(1.0), none]);
        assert_eq!(few.within(3..7), [0.25]);
        assert_eq!(few.within(3..8), [0.25, 1.0]);
        assert_eq!(few.within(4..7), [0.0; 0]);
        assert_eq!(few.values(), [0.5, 0.25, 1.0]);
        let (segments, values) = few.clone().into_columns();
        assert_eq!(Few::new(segments, values), few);
    }
}
