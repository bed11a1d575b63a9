//! Reading a table of samples at a place between its rows.

use std::ops::Index;

/// The rows of an ascending column around a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RowsAround {
    /// The last row before the place; the first row if there is none.
    pub before: usize,
    /// The next row, or `before` at the end of the column.
    pub after: usize,
    /// The part of the way from one to the other, 0 to 1; 1 where both have one value.
    pub fraction: f64,
}

/// Returns the rows of an ascending column around a place. A place equal to several rows is before the first
/// of them; a place beyond the column is at its end. `row` holds the row of the last search and speeds up the
/// next one nearby. Returns `None` for an empty column.
pub fn rows_around(column: &[f64], place: f64, row: &mut usize) -> Option<RowsAround> {
    rows_around_by(column.len(), |row| column[row], place, row)
}

/// Returns the rows around a place, as [`rows_around`], in a table of `rows` rows that holds its column in `value`.
#[inline]
pub fn rows_around_by(
    rows: usize,
    value: impl Fn(usize) -> f64,
    place: f64,
    row: &mut usize,
) -> Option<RowsAround> {
    let last = rows.checked_sub(1)?;
    let is_before = |row: usize| {
        (row == 0 || row < last && value(row) < place) && (last <= row + 1 || place <= value(row + 1))
    };
    if !is_before(*row) {
        *row += 1;
    }
    if !is_before(*row) {
        *row = rows_before(rows, &value, place, *row).clamp(1, last.max(1)) - 1;
    }
    let (before, after) = (*row, (*row + 1).min(last));
    let span = value(after) - value(before);
    let fraction = if 0.0 < span { ((place - value(before)) / span).clamp(0.0, 1.0) } else { 1.0 };
    Some(RowsAround { before, after, fraction })
}

/// Returns the number of rows of an ascending column before a place. The search begins at the row `near` and doubles its
/// steps forwards, so that it is short for a place a little farther on.
fn rows_before(rows: usize, value: impl Fn(usize) -> f64, place: f64, near: usize) -> usize {
    let is_before = |row: usize| value(row) < place;
    let (mut before, mut end) = (0, rows);
    if near < rows && is_before(near) {
        let mut step = 1;
        before = near + 1;
        while before + step < rows && is_before(before + step) {
            before += step + 1;
            step *= 2;
        }
        end = (before + step).min(rows);
    }
    while before < end {
        let middle = before + (end - before) / 2;
        if is_before(middle) {
            before = middle + 1;
        } else {
            end = middle;
        }
    }
    before
}

impl RowsAround {
    /// Returns the value of another column on the straight line between both rows.
    pub fn between(&self, values: &(impl Index<usize, Output = f64> + ?Sized)) -> f64 {
        self.between_by(|row| values[row])
    }

    /// Returns the position (mm) between both rows, by the cubic through the positions and velocities (mm/s) at both times
    /// (s), and the velocity on the straight line.
    pub fn motion(&self, time: &[f64], position: &[f64], velocity: &[f64]) -> (f64, f64) {
        let RowsAround { before, after, fraction: s } = *self;
        let span = time[after] - time[before];
        let (s2, s3) = (s * s, s * s * s);
        let at = position[before] * (2.0 * s3 - 3.0 * s2 + 1.0)
            + span * velocity[before] * (s3 - 2.0 * s2 + s)
            + position[after] * (3.0 * s2 - 2.0 * s3)
            + span * velocity[after] * (s3 - s2);
        (at, self.between(velocity))
    }

    /// Returns the value of another column, as [`RowsAround::between`], that is held in `value`.
    pub fn between_by(&self, value: impl Fn(usize) -> f64) -> f64 {
        value(self.before) + self.fraction * (value(self.after) - value(self.before))
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

    #[test]
    fn a_place_is_found_from_every_row() {
        let column: Vec<f64> = (0..40).map(|row| f64::from(row * row / 7)).collect();
        for place in (-1..230).map(f64::from) {
            let before = column.partition_point(|value| *value < place).clamp(1, column.len() - 1) - 1;
            for start in 0..=column.len() {
                let mut row = start;
                let found = rows_around(&column, place, &mut row).expect("forty rows");
                assert_eq!(found.before, before, "{place} from {start}");
            }
        }
    }

    #[test]
    fn pairs_are_read_as_columns_are() {
        let pairs = [(0.0, 10.0), (1.0, 20.0), (1.0, 30.0), (3.0, 50.0)];
        let (column, values) = (pairs.map(|pair| pair.0), pairs.map(|pair| pair.1));
        for place in [-1.0, 0.0, 0.5, 1.0, 1.5, 3.0, 4.0] {
            for start in 0..4 {
                let (mut own, mut other) = (start, start);
                let rows = rows_around_by(4, |row| pairs[row].0, place, &mut own).expect("four rows");
                assert_eq!(Some(rows), rows_around(&column, place, &mut other), "{place} from {start}");
                assert_eq!(rows.between_by(|row| pairs[row].1), rows.between(&values));
            }
        }
    }
}
