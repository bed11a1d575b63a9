//! Decimation: fewer points for the same picture.
//!
//! In a pixel column only four points of a curve are visible: its first, its lowest, its highest and its
//! last. These four draw the same pixels as all samples.

use std::ops::Range;

use crate::plot::{Column, View};

/// Most rows of a pixel column that are drawn unchanged; four points replace more rows.
pub const MAX_ROWS_DRAWN: usize = 4;

/// Returns the visible points of a curve on `columns` pixel columns of a view, in order: its samples (x, y),
/// or four points for all samples in one column, with one row outside at either end so that the line reaches
/// the border. `x` is ascending.
pub fn decimated(x: &[f64], y: &Column, (low, high): (f64, f64), columns: usize) -> Vec<(f64, f64)> {
    let first = x.partition_point(|&v| v < low).saturating_sub(1);
    let last = (x.partition_point(|&v| v <= high) + 1).min(x.len());
    let mut kept = Vec::new();
    for rows in by_column(x, first..last, (low, high), columns) {
        let (first, last) = (rows.start, rows.end - 1);
        let at = |row: usize| (x[row], y[row]);
        let mut four = [0, 1, 2, 3].map(|row| at((first + row).min(last)));
        if MAX_ROWS_DRAWN < rows.len()
            && let Some(extremes) = y.extremes(rows)
        {
            four = [at(first), (x[first], extremes.lowest), (x[first], extremes.highest), at(last)];
        }
        kept.extend(four);
    }
    kept.dedup();
    kept
}

/// Groups rows by pixel column, of `columns` from `low` to `high`. The ascending column `x` holds the places
/// of the rows.
pub fn by_column(
    x: &[f64],
    rows: Range<usize>,
    (low, high): (f64, f64),
    columns: usize,
) -> Vec<Range<usize>> {
    let width = (high - low) / columns as f64;
    let mut all = Vec::new();
    let (mut start, mut likely) = (rows.start, 0);
    while start < rows.end {
        let border = low + width * (((x[start] - low) / width).floor() + 1.0);
        likely = 1 + count_before(&x[start + 1..rows.end], border, likely);
        all.push(start..start + likely);
        start += likely;
    }
    all
}

/// Returns the number of ascending rows below a border. The search begins at `likely`, which is faster than
/// bisecting millions of rows: a pixel column has about as many rows as the one before it.
pub fn count_before(x: &[f64], border: f64, likely: usize) -> usize {
    let is_before = |v: f64| v < border;
    let likely = likely.min(x.len());
    let (mut low, mut high, mut step) = (likely, likely, 1);
    while high < x.len() && is_before(x[high]) {
        low = high + 1;
        high = (high + step).min(x.len());
        step *= 2;
    }
    while 0 < low && !is_before(x[low - 1]) {
        high = low - 1;
        low = high.saturating_sub(step);
        step *= 2;
    }
    low + x[low..high].partition_point(|&v| is_before(v))
}

/// Returns the parts of a polyline (distance, feedrate) inside a view, each as a polyline.
pub fn clipped(points: &[(f64, f64)], view: View) -> Vec<Vec<(f64, f64)>> {
    let mut parts: Vec<Vec<(f64, f64)>> = Vec::new();
    for pair in points.windows(2) {
        let Some((from, to)) = inside(pair[0], pair[1], view) else { continue };
        match parts.last_mut() {
            Some(part) if part.last() == Some(&from) => part.push(to),
            _ => parts.push(vec![from, to]),
        }
    }
    parts
}

/// Returns the part of a straight line inside a view, after Liang and Barsky.
fn inside(a: (f64, f64), b: (f64, f64), view: View) -> Option<((f64, f64), (f64, f64))> {
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    let (mut enter, mut leave): (f64, f64) = (0.0, 1.0);
    let borders = [
        (-dx, a.0 - view.distance.0),
        (dx, view.distance.1 - a.0),
        (-dy, a.1 - view.feedrate.0),
        (dy, view.feedrate.1 - a.1),
    ];
    for (outward, room) in borders {
        if outward == 0.0 {
            if room < 0.0 {
                return None;
            }
        } else if outward < 0.0 {
            enter = enter.max(room / outward);
        } else {
            leave = leave.min(room / outward);
        }
    }
    if leave < enter {
        return None;
    }
    let at = |part: f64| {
        if part == 0.0 {
            a
        } else if part == 1.0 {
            b
        } else {
            (a.0 + part * dx, a.1 + part * dy)
        }
    };
    Some((at(enter), at(leave)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A curve with a spike that one sample in a thousand would miss.
    fn spiky(count: usize) -> (Vec<f64>, Vec<f64>) {
        let x: Vec<f64> = (0..count).map(|i| i as f64 * 0.01).collect();
        let y = x
            .iter()
            .map(|v| (v * 0.3).sin() + if (*v * 100.0).round() as usize % 7919 == 5 { 50.0 } else { 0.0 });
        let y = y.collect();
        (x, y)
    }

    #[test]
    fn keeps_every_extreme_with_few_points() {
        let (x, y) = spiky(200_000);
        let columns = 800;
        let kept = decimated(&x, &y.clone().into(), (100.0, 1900.0), columns);
        assert!(kept.len() <= 4 * (columns + 2), "{} points", kept.len());
        assert!(kept.windows(2).all(|pair| pair[0].0 <= pair[1].0));

        let seen = |value: &&f64| (100.0..=1900.0).contains(*value);
        let highs = x.iter().zip(&y).filter(|(d, v)| seen(d) && **v > 40.0).count();
        assert!(highs > 10);
        assert_eq!(kept.iter().filter(|(d, v)| seen(&d) && *v > 40.0).count(), highs);
    }

    #[test]
    fn few_samples_are_all_kept() {
        let (x, y) = ([0.0, 1.0, 1.0, 2.0], Column::from(vec![0.0, 5.0, 0.0, 3.0]));
        let kept = decimated(&x, &y, (0.0, 2.0), 100);
        assert_eq!(kept, [(0.0, 0.0), (1.0, 5.0), (1.0, 0.0), (2.0, 3.0)]);
        assert_eq!(decimated(&[], &Column::default(), (0.0, 1.0), 10), []);
    }

    #[test]
    fn a_border_is_found_wherever_it_is_thought_to_be() {
        let rows: Vec<f64> = (0..100).map(|row| f64::from(row / 3)).collect();
        for count in [0, 1, 2, 17, 100] {
            for border in [-1.0, 0.0, 0.5, 4.0, 20.0, 33.0, 99.0] {
                for likely in [0, 1, 2, 5, 16, 60, 99, 100, 1000] {
                    let found = count_before(&rows[..count], border, likely);
                    assert_eq!(
                        found,
                        rows[..count].partition_point(|row| *row < border),
                        "{border} near {likely}"
                    );
                }
            }
        }
    }

    #[test]
    fn clipping_cuts_at_the_border() {
        let view = View { distance: (0.0, 10.0), feedrate: (0.0, 1.0) };
        let parts = clipped(&[(-5.0, 0.5), (5.0, 0.5), (6.0, 2.0), (8.0, 2.0), (9.0, 0.0)], view);
        assert_eq!(parts.len(), 2);
        assert_eq!(parts[0][0], (0.0, 0.5));
        assert!((parts[0][2].1 - 1.0).abs() < 1e-12);
        assert_eq!(parts[1].last(), Some(&(9.0, 0.0)));
        for (d, f) in parts.concat() {
            assert!((-1e-9..=10.0 + 1e-9).contains(&d) && (-1e-9..=1.0 + 1e-9).contains(&f));
        }
    }
}
