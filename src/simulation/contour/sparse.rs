//! A sparse column: values of a few segments, each with its index.

/// Values of a few segments.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SparseColumn {
    /// Indices of the segments, ascending.
    segments: Vec<u32>,
    values: Vec<f64>,
}

impl SparseColumn {
    /// Returns the indices of the segments and their values.
    pub fn into_columns(self) -> (Vec<u32>, Vec<f64>) {
        (self.segments, self.values)
    }

    /// Returns the value of a segment; `None` if it has none.
    pub fn get(&self, segment: usize) -> Option<f64> {
        self.segments.binary_search(&(segment as u32)).ok().map(|at| self.values[at])
    }

    /// Returns all values in the order of their segments.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Appends the value of a segment; if that is the last segment with a value, the value does not change.
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
        let mut few = SparseColumn::default();
        assert_eq!(few.get(0), None);
        for (segment, value) in [(2, 0.5), (2, 9.0), (3, 0.25), (7, 1.0)] {
            few.add(segment, value);
        }
        let found: Vec<Option<f64>> = (0..9).map(|segment| few.get(segment)).collect();
        let none = None;
        assert_eq!(found, [none, none, Some(0.5), Some(0.25), none, none, none, Some(1.0), none]);
        assert_eq!(few.values(), [0.5, 0.25, 1.0]);
        assert_eq!(few.into_columns(), (vec![2, 3, 7], vec![0.5, 0.25, 1.0]));
    }
}
