//! Events → points, and the monotone curve through them.
//!
//! The curve is the one nearest to the points, weighted by their counts, that never falls (or never rises):
//! neighbours that violate the order are pooled, one after another, until none do. The standard deviation of
//! the curve is the larger of two: the spread within the points over the root of their count, and the
//! jackknife over the n points,
//!
//! ```text
//! σ² = (n − 1)/n Σ_k (f₋ₖ(x) − f(x))²
//! ```
//!
//! Sources: pool adjacent violators, Barlow, Bartholomew, Bremner and Brunk 1972; the jackknife, Efron and Stein 1981.

use crate::simulation::ordered::sort_by_number;
use crate::simulation::sampled::rows_around_by;

/// A group of events with similar abscissas, core units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LawPoint {
    /// Mean abscissa.
    pub over: f64,
    /// Mean value.
    pub value: f64,
    /// Standard deviation of the values; 0 for one event.
    pub spread: f64,
    /// Number of events.
    pub count: usize,
}

/// The value of the curve at a point, core units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurveLevel {
    /// Abscissa.
    pub over: f64,
    /// Value.
    pub value: f64,
    /// Standard deviation of the value.
    pub deviation: f64,
}

/// Most points of one law; beyond that number the closest points are merged.
const MAX_POINTS: usize = 40;

/// Groups pairs of abscissa and value into points. The abscissas of one point differ at most by `apart`: the
/// larger of a value in core units and a part of the abscissa.
pub fn points(mut pairs: Vec<(f64, f64)>, apart: (f64, f64)) -> Vec<LawPoint> {
    pairs.retain(|(over, value)| over.is_finite() && value.is_finite());
    sort_by_number(&mut pairs, |pair| pair.0);
    let (mut by, mut ratio) = apart;
    loop {
        let mut groups: Vec<&[(f64, f64)]> = Vec::new();
        let mut from = 0;
        for at in 1..=pairs.len() {
            let first = pairs[from].0;
            if at == pairs.len() || by.max(ratio * first.abs()) < pairs[at].0 - first {
                groups.push(&pairs[from..at]);
                from = at;
            }
        }
        if groups.len() <= MAX_POINTS {
            return groups.into_iter().map(point).collect();
        }
        (by, ratio) = (1.5 * by, 1.5 * ratio);
    }
}

fn point(group: &[(f64, f64)]) -> LawPoint {
    let count = group.len() as f64;
    let mean = |of: fn(&(f64, f64)) -> f64| group.iter().map(of).sum::<f64>() / count;
    let (over, value) = (mean(|pair| pair.0), mean(|pair| pair.1));
    let squares: f64 = group.iter().map(|pair| (pair.1 - value).powi(2)).sum();
    LawPoint { over, value, spread: (squares / (count - 1.0).max(1.0)).sqrt(), count: group.len() }
}

/// Returns the monotone curve at each point.
pub fn monotone(points: &[LawPoint], is_rising: bool) -> Vec<CurveLevel> {
    let whole = pooled(points, is_rising);
    let left_out: Vec<Vec<f64>> = (0..points.len())
        .map(|out| {
            let others: Vec<LawPoint> =
                points.iter().enumerate().filter(|(at, _)| *at != out).map(|(_, point)| *point).collect();
            let values = pooled(&others, is_rising);
            points.iter().map(|point| between(&others, &values, point.over)).collect()
        })
        .collect();
    let count = points.len() as f64;
    let level = |(at, point): (usize, &LawPoint)| {
        let squares: f64 = left_out.iter().map(|values| (values[at] - whole[at]).powi(2)).sum();
        let jackknife = ((count - 1.0) / count * squares).sqrt();
        let own = point.spread / (point.count as f64).sqrt();
        let deviation = if 1 < points.len() { own.max(jackknife) } else { own };
        CurveLevel { over: point.over, value: whole[at], deviation }
    };
    points.iter().enumerate().map(level).collect()
}

/// Returns the nearest monotone values, by pooling neighbours.
fn pooled(points: &[LawPoint], is_rising: bool) -> Vec<f64> {
    let sign = if is_rising { 1.0 } else { -1.0 };
    let mut pools: Vec<(f64, f64, usize)> = Vec::new();
    for point in points {
        pools.push((sign * point.value, point.count as f64, 1));
        while let [.., before, last] = pools.as_slice() {
            if before.0 <= last.0 {
                break;
            }
            let weight = before.1 + last.1;
            let merged = ((before.0 * before.1 + last.0 * last.1) / weight, weight, before.2 + last.2);
            pools.truncate(pools.len() - 2);
            pools.push(merged);
        }
    }
    pools.into_iter().flat_map(|(value, _, width)| std::iter::repeat_n(sign * value, width)).collect()
}

/// Returns the value at `over` of the curve through the points: linear between them, constant beyond.
fn between(points: &[LawPoint], values: &[f64], over: f64) -> f64 {
    let rows = rows_around_by(points.len(), |row| points[row].over, over, &mut 0);
    rows.map_or(0.0, |rows| rows.between(values))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(values: &[f64]) -> Vec<LawPoint> {
        let point =
            |(at, value): (usize, &f64)| LawPoint { over: at as f64, value: *value, spread: 0.0, count: 1 };
        values.iter().enumerate().map(point).collect()
    }

    #[test]
    fn neighbours_that_violate_the_order_are_put_together() {
        assert_eq!(pooled(&of(&[1.0, 3.0, 2.0, 4.0]), true), [1.0, 2.5, 2.5, 4.0]);
        assert_eq!(pooled(&of(&[4.0, 1.0, 3.0, 2.0]), false), [4.0, 2.0, 2.0, 2.0]);
        assert_eq!(pooled(&of(&[3.0, 2.0, 1.0]), true), [2.0; 3]);
    }

    #[test]
    fn points_weigh_by_their_count() {
        let heavy = [
            LawPoint { over: 0.0, value: 2.0, spread: 0.0, count: 3 },
            LawPoint { over: 1.0, value: 1.0, spread: 0.0, count: 1 },
        ];
        assert_eq!(pooled(&heavy, true), [1.75, 1.75]);
    }

    #[test]
    fn events_of_like_abscissa_are_one_point_with_their_spread() {
        let found = points(vec![(1.0, 10.0), (1.001, 12.0), (2.0, 5.0), (f64::NAN, 1.0)], (0.01, 0.0));
        assert_eq!(found.len(), 2);
        assert!((found[0].value - 11.0).abs() < 1e-12 && (found[0].spread - 2f64.sqrt()).abs() < 1e-12);
        assert_eq!((found[0].count, found[1].count), (2, 1));
    }

    #[test]
    fn a_straight_law_without_noise_is_its_own_curve() {
        let line = of(&[0.0, 1.0, 2.0, 3.0, 4.0]);
        let curve = monotone(&line, true);
        for (level, point) in curve.iter().zip(&line) {
            assert_eq!(level.value, point.value);
        }
        // Only at the ends does leaving a point out change anything.
        assert!(curve[2].deviation < 1e-12 && 0.5 < curve[0].deviation, "{curve:?}");
    }

    #[test]
    fn crowded_laws_keep_a_bounded_number_of_points() {
        let many = (0..5000).map(|at| (f64::from(at), 1.0)).collect();
        let found = points(many, (0.5, 0.0));
        assert!(found.len() <= MAX_POINTS);
        assert_eq!(found.iter().map(|point| point.count).sum::<usize>(), 5000);
    }
}
