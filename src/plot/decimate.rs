//! Fewer points for the same picture.
//!
//! A pixel column shows no more of a curve than where it comes in, its lowest and highest point
//! and where it goes out. Keeping these four samples of each column draws the same pixels from
//! at most four points a column, whatever the number of samples.

use crate::plot::View;

/// The samples of a curve within a view that matter on `columns` pixel columns, in order: a
/// subset of the rows (x, y), with one row outside at either end so that the line reaches the
/// border. `x` is ascending.
pub fn decimated(x: &[f64], y: &[f64], (low, high): (f64, f64), columns: usize) -> Vec<(f64, f64)> {
    let first = x.partition_point(|&v| v < low).saturating_sub(1);
    let last = (x.partition_point(|&v| v <= high) + 1).min(x.len());
    let width = (high - low) / columns as f64;

    let mut kept = Vec::new();
    let mut start = first;
    while start < last {
        let border = low + width * (((x[start] - low) / width).floor() + 1.0);
        let end = start + 1 + x[start + 1..last].partition_point(|&v| v < border);
        let (mut lowest, mut highest) = (start, start);
        for index in start..end {
            if y[index] < y[lowest] {
                lowest = index;
            }
            if y[highest] < y[index] {
                highest = index;
            }
        }
        let mut four = [start, lowest, highest, end - 1];
        four.sort_unstable();
        for (place, index) in four.into_iter().enumerate() {
            if place == 0 || four[place - 1] != index {
                kept.push((x[index], y[index]));
            }
        }
        start = end;
    }
    kept
}

/// The parts of a polyline (distance, feedrate) inside a view, each a polyline of its own.
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

/// The part of a straight line inside a view, after Liang and Barsky.
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
        let kept = decimated(&x, &y, (100.0, 1900.0), columns);
        assert!(kept.len() <= 4 * (columns + 2), "{} points", kept.len());
        assert!(kept.windows(2).all(|pair| pair[0].0 <= pair[1].0));

        let seen = |value: &&f64| (100.0..=1900.0).contains(*value);
        let highs = x.iter().zip(&y).filter(|(d, v)| seen(d) && **v > 40.0).count();
        assert!(highs > 10);
        assert_eq!(kept.iter().filter(|(d, v)| seen(&d) && *v > 40.0).count(), highs);
    }

    #[test]
    fn few_samples_are_all_kept() {
        let (x, y) = ([0.0, 1.0, 1.0, 2.0], [0.0, 5.0, 0.0, 3.0]);
        let kept = decimated(&x, &y, (0.0, 2.0), 100);
        assert_eq!(kept, [(0.0, 0.0), (1.0, 5.0), (1.0, 0.0), (2.0, 3.0)]);
        assert_eq!(decimated(&[], &[], (0.0, 1.0), 10), []);
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
