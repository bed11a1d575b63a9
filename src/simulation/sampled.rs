//! Reading a table of samples at a place between its rows.

use std::ops::Index;

/// The rows of an ascending column around a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RowsAround {
    /// The last row before the place; the first row where there is none.
    pub before: usize,
    /// The row behind that, or the same one at the end of the column.
    pub after: usize,
    /// The part of the way from one to the other, 0 to 1; 1 where both have one value.
    pub fraction: f64,
}

/// The rows of an ascending column around a place: at equal rows before the first of them, and beyond the ends of
/// the column the end. `row` is where the last place was found, from which the next is found the sooner. Returns
/// `None` for an empty column.
pub fn rows_around(column: &[f64], place: f64, row: &mut usize) -> Option<RowsAround> {
    let last = column.len().checked_sub(1)?;
    let is_before = |row: usize| {
        (row == 0 || row < last && column[row] < place) && (last <= row + 1 || place <= column[row + 1])
    };
    if !is_before(*row) {
        *row += 1;
    }
    if !is_before(*row) {
        *row = column.partition_point(|value| *value < place).clamp(1, last.max(1)) - 1;
    }
    let (before, after) = (*row, (*row + 1).min(last));
    let span = column[after] - column[before];
    let fraction = if 0.0 < span { ((place - column[before]) / span).clamp(0.0, 1.0) } else { 1.0 };
    Some(RowsAround { before, after, fraction })
}

impl RowsAround {
    /// The value of another column on the straight line between both rows.
    pub fn between(&self, values: &(impl Index<usize, Output = f64> + ?Sized)) -> f64 {
        values[self.before] + self.fraction * (values[self.after] - values[self.before])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_found_whichever_way_one_goes() {
        let (column, values) = ([0.0, 1.0, 1.0, 3.0], [10.0, 20.0, 30.0, 50.0]);
        let mut row = 0;
        let mut at = |place: f64| rows_around(&column, place, &mut row).expect("four rows").between(&values);
        assert_eq!([-1.0, 0.5, 1.0, 2.0, 3.0, 9.0].map(&mut at), [10.0, 15.0, 20.0, 40.0, 50.0, 50.0]);
        assert_eq!([2.0, 0.25, -3.0].map(&mut at), [40.0, 12.5, 10.0]);
        assert_eq!(rows_around(&[1.0], 5.0, &mut 3).expect("one row").between(&[7.0]), 7.0);
        assert_eq!(rows_around(&[], 5.0, &mut 0), None);
    }
}
