//! A column of values that returns the extremes of any range of rows without reading them all.
//!
//! Each group of 16 rows stores its extremes, each group of 16 groups too, and so on:
//!
//! ```text
//! level 2                    |--------------- 256 rows ---------------|
//! level 1   |16|16|  …   |16||16|16|  …                               |16|16|
//! rows      ······           ········································        ····
//!                ^ begin                                                   end ^
//! ```
//!
//! A query of n rows reads about 32 log₁₆ n values, so that the cost of a picture of millions of rows depends
//! on its number of pixel columns.

use std::ops::{Deref, Range};
use std::sync::Arc;

/// Rows of a group, and groups of a group of the next level.
const GROUP_ROWS: usize = 16;

/// Values in rows, with their extremes. Clones share them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Column(Arc<ColumnRows>);

#[derive(Debug, Default, PartialEq)]
struct ColumnRows {
    values: Vec<f64>,
    /// Extremes of the groups, level by level.
    groups: Vec<Extremes>,
}

/// The least and the largest of some values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extremes {
    /// Least value.
    pub lowest: f64,
    /// Largest value.
    pub highest: f64,
}

impl Extremes {
    const NONE: Extremes = Extremes { lowest: f64::INFINITY, highest: f64::NEG_INFINITY };

    /// Returns the extremes of one value.
    pub fn of(value: f64) -> Extremes {
        Extremes { lowest: value, highest: value }
    }

    /// Returns the extremes of these values and others.
    #[inline]
    pub fn and(self, other: Extremes) -> Extremes {
        Extremes {
            lowest: if other.lowest < self.lowest { other.lowest } else { self.lowest },
            highest: if self.highest < other.highest { other.highest } else { self.highest },
        }
    }

    fn and_rows(self, rows: &[f64]) -> Extremes {
        rows.iter().fold(self, |all, &row| all.and(Extremes::of(row)))
    }

    fn and_groups(self, groups: &[Extremes]) -> Extremes {
        groups.iter().fold(self, |all, &group| all.and(group))
    }
}

impl From<Vec<f64>> for Column {
    fn from(values: Vec<f64>) -> Column {
        // n/16 + n/256 + …, each rounded up.
        let mut groups = Vec::with_capacity(values.len() / (GROUP_ROWS - 1) + GROUP_ROWS);
        groups.extend(values.chunks(GROUP_ROWS).map(|rows| Extremes::NONE.and_rows(rows)));
        let mut begin = 0;
        // The last level has too few groups for a group of the next level.
        while GROUP_ROWS <= groups.len() - begin {
            let end = groups.len();
            for group in (begin..end).step_by(GROUP_ROWS) {
                groups.push(Extremes::NONE.and_groups(&groups[group..end.min(group + GROUP_ROWS)]));
            }
            begin = end;
        }
        Column(Arc::new(ColumnRows { values, groups }))
    }
}

impl Deref for Column {
    type Target = [f64];

    fn deref(&self) -> &[f64] {
        &self.0.values
    }
}

impl Column {
    /// Returns the extremes of these rows; `None` if there are none.
    ///
    /// # Panics
    ///
    /// Panics if the range is out of bounds.
    pub fn extremes(&self, rows: Range<usize>) -> Option<Extremes> {
        if rows.is_empty() {
            return None;
        }
        let ColumnRows { values, groups: all } = &*self.0;
        let (before, whole, after) = around_groups(&rows);
        if whole.is_empty() {
            return Some(Extremes::NONE.and_rows(&values[rows]));
        }
        let mut found = Extremes::NONE.and_rows(&values[before]).and_rows(&values[after]);
        let (mut groups, mut level, mut count) = (whole, &all[..], values.len());
        loop {
            let (before, whole, after) = around_groups(&groups);
            if whole.is_empty() {
                return Some(found.and_groups(&level[groups]));
            }
            found = found.and_groups(&level[before]).and_groups(&level[after]);
            count = count.div_ceil(GROUP_ROWS);
            (groups, level) = (whole, &level[count..]);
        }
    }
}

/// Returns the whole groups in a range, as a range of groups, and the rows before and after them.
fn around_groups(range: &Range<usize>) -> (Range<usize>, Range<usize>, Range<usize>) {
    let whole = range.start.div_ceil(GROUP_ROWS)..range.end / GROUP_ROWS;
    (range.start..whole.start * GROUP_ROWS, whole.clone(), whole.end * GROUP_ROWS..range.end)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_extremes_of_any_rows_are_those_of_each() {
        for count in [0, 1, 15, 16, 17, 255, 256, 257, 5000] {
            let values: Vec<f64> = (0..count).map(|row| f64::from((row * 7919 + row * row) % 101)).collect();
            let column = Column::from(values.clone());
            let count = values.len();
            for step in 0..400 {
                let (a, b) = (step * 7907 % (count + 1), step * 6007 % (count + 1));
                let rows = a.min(b)..a.max(b);
                let each = values[rows.clone()].iter().copied();
                let found = column.extremes(rows.clone());
                let expected = each.clone().reduce(f64::min).zip(each.reduce(f64::max));
                assert_eq!(found.map(|found| (found.lowest, found.highest)), expected, "{rows:?} of {count}");
            }
            assert_eq!(*column, values[..]);
        }
    }
}
