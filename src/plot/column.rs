//! A column of values that tells the least and the largest of any rows without a look at each.
//!
//! Every 16 rows know their extremes, every 16 of these groups theirs, and so on:
//!
//! ```text
//! level 2                    |--------------- 256 rows ---------------|
//! level 1   |16|16|  …   |16||16|16|  …                               |16|16|
//! rows      ······           ········································        ····
//!                ^ begin                                                   end ^
//! ```
//!
//! Of n rows some 32 log₁₆ n values are looked at: a picture of millions of rows costs what its pixel columns do.

use std::ops::{Deref, Range};
use std::sync::Arc;

/// Rows of a group, and groups of the next larger one.
const GROUP: usize = 16;

/// Values in rows, and their extremes. Copies share them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Column(Arc<Rows>);

#[derive(Debug, Default, PartialEq)]
struct Rows {
    values: Vec<f64>,
    /// The extremes of groups, level after level.
    groups: Vec<Extremes>,
}

/// The least and the largest of some values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extremes {
    /// The least.
    pub lowest: f64,
    /// The largest.
    pub highest: f64,
}

impl Extremes {
    const OF_NONE: Extremes = Extremes { lowest: f64::INFINITY, highest: f64::NEG_INFINITY };

    /// Those of one value.
    pub fn of(value: f64) -> Extremes {
        Extremes { lowest: value, highest: value }
    }

    /// Those of these values and of others.
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
        let mut groups = Vec::with_capacity(values.len() / (GROUP - 1) + GROUP);
        groups.extend(values.chunks(GROUP).map(|rows| Extremes::OF_NONE.and_rows(rows)));
        let mut begin = 0;
        // The last level has no whole group of groups.
        while GROUP <= groups.len() - begin {
            let end = groups.len();
            for group in (begin..end).step_by(GROUP) {
                groups.push(Extremes::OF_NONE.and_groups(&groups[group..end.min(group + GROUP)]));
            }
            begin = end;
        }
        Column(Arc::new(Rows { values, groups }))
    }
}

impl Deref for Column {
    type Target = [f64];

    fn deref(&self) -> &[f64] {
        &self.0.values
    }
}

impl Column {
    /// The extremes of these rows; none of no rows. Panics beyond the end.
    pub fn extremes(&self, rows: Range<usize>) -> Option<Extremes> {
        if rows.is_empty() {
            return None;
        }
        let Rows { values, groups: all } = &*self.0;
        let (before, whole, after) = around_groups(&rows);
        if whole.is_empty() {
            return Some(Extremes::OF_NONE.and_rows(&values[rows]));
        }
        let mut found = Extremes::OF_NONE.and_rows(&values[before]).and_rows(&values[after]);
        let (mut groups, mut level, mut count) = (whole, &all[..], values.len());
        loop {
            let (before, whole, after) = around_groups(&groups);
            if whole.is_empty() {
                return Some(found.and_groups(&level[groups]));
            }
            found = found.and_groups(&level[before]).and_groups(&level[after]);
            count = count.div_ceil(GROUP);
            (groups, level) = (whole, &level[count..]);
        }
    }
}

/// The whole groups in a range, as a range of groups, with what lies before and after them.
fn around_groups(range: &Range<usize>) -> (Range<usize>, Range<usize>, Range<usize>) {
    let whole = range.start.div_ceil(GROUP)..range.end / GROUP;
    (range.start..whole.start * GROUP, whole.clone(), whole.end * GROUP..range.end)
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
