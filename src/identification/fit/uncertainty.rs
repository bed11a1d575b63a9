//! Uncertainty of fitted values.
//!
//! Least squares assume that the whitened residuals ν are independent with variance 1. The residuals of a
//! model are not: they persist for a while, and the recorder's clock is only as good as its quartz. Three
//! contributions are therefore combined, with the derivatives J of ν, the weights W and H = JᵀWJ:
//!
//! | contribution | estimate |
//! |---|---|
//! | remaining residuals, as seen | H⁻¹ ĉ, with ĉ the variance of the sums of ν over contiguous blocks over that of independent ones, at the length of block where it is largest (batch means) |
//! | remaining residuals, where a value acts | the jackknife that leaves out one of several contiguous blocks (H − H_g)⁻¹ g_g, at the length at which the values move most; for a value that depends on one block, at shorter ones |
//! | the clock, which no residual shows | (H⁻¹ JᵀW n)² σ², n the whitened residuals through a clock whose rate is off by 1, σ the standard deviation of the rate |
//!
//! The variance of a value is the larger of the first two, plus the third. The cycles of a control, and the
//! limit to which the laws of model and control agree, are added separately, see
//! [`FreeParameter::floor`](crate::identification::fit::FreeParameter::floor). Sources: Efron and Tibshirani
//! 1993, Sect. 11.5 and 17; Flegal and Jones 2010 for batch means. Clocks of recorders are off by 10 to 200
//! ppm: quartzes by 50, computers that follow no other clock by more.

use nalgebra::{DMatrix, DVector};

use crate::identification::fit::information::{Information, inverse};
use crate::identification::fit::levenberg_marquardt::SearchMinimum;
use crate::identification::fit::minimise::weight;

/// Standard deviation of a clock's rate, for errors of 10 to 200 ppm of which each size is as likely as its
/// double.
const CLOCK_DEVIATION_RATIO: f64 = 8.2e-5;
/// Most blocks of a run; each further length is twice the one before.
const MAX_BLOCKS: usize = 512;
/// Fewest blocks of a run.
const MIN_BLOCKS: usize = 8;
/// Share of the information on a value in one block, from which on the other blocks do not determine the
/// value.
const MIN_INFORMATION_SHARE: f64 = 0.5;
/// Least information on an optimiser's coordinate that counts.
const MIN_INFORMATION: f64 = 1e-9;

/// Returns the ratio of the variance of sums of whitened residuals over blocks to the variance of independent
/// residuals, at the block length at which the ratio is largest; at least 1.
pub fn dispersion(whitened: &[Vec<f64>]) -> f64 {
    let of = |blocks: usize| {
        let (mut squares, mut expected) = (0.0, 0.0);
        for run in whitened {
            for block in run.chunks(run.len().div_ceil(blocks).max(1)) {
                squares += block.iter().map(|value| weight(*value) * value).sum::<f64>().powi(2);
                expected += block.iter().map(|value| weight(*value)).sum::<f64>();
            }
        }
        if 0.0 < expected { squares / expected } else { 1.0 }
    };
    scales().map(of).fold(1.0, f64::max)
}

/// Returns the numbers of blocks.
fn scales() -> impl Iterator<Item = usize> {
    std::iter::successors(Some(MIN_BLOCKS), |blocks| Some(2 * blocks))
        .take_while(|blocks| *blocks <= MAX_BLOCKS)
}

/// Returns the covariance of the optimiser's coordinates; infinite on the diagonal for coordinates that the
/// runs do not determine. `clocks` are the whitened residuals caused by a clock whose rate is off by 1, run
/// by run.
pub fn covariance(found: &SearchMinimum, clocks: &[Vec<f64>]) -> DMatrix<f64> {
    let count = found.point.len();
    let all = Information::of_all(&found.residuals, &found.jacobians, count);
    let known: Vec<usize> = (0..count).filter(|at| MIN_INFORMATION < all.normal[(*at, *at)]).collect();
    let mut covariance = DMatrix::from_diagonal_element(count, count, f64::INFINITY);
    covariance.fill_lower_triangle(0.0, 1);
    covariance.fill_upper_triangle(0.0, 1);
    let normal = all.among(&known).normal;
    let Some(inverse) = inverse(&normal) else { return covariance };
    let plain = &inverse * dispersion(&found.residuals);
    let moved = jackknife(found, clocks.len(), &known, &normal);
    let mut clock = DVector::zeros(count);
    for ((whitened, jacobian), trace) in found.residuals.iter().zip(&found.jacobians).zip(clocks) {
        for (row, (value, trace)) in whitened.iter().zip(trace).enumerate() {
            clock += weight(*value) * trace * jacobian.row(row).transpose();
        }
    }
    let clock = CLOCK_DEVIATION_RATIO * &inverse * clock.select_rows(&known);
    let own = |at: usize| plain[(at, at)].max(moved[at]).sqrt();
    for (i, &row) in known.iter().enumerate() {
        for (j, &column) in known.iter().enumerate() {
            let related = plain[(i, j)] / (plain[(i, i)] * plain[(j, j)]).sqrt();
            covariance[(row, column)] = related * own(i) * own(j) + clock[i] * clock[j];
        }
    }
    covariance
}

/// Returns the variance of each determined value by leaving out blocks of the `runs`: the largest over all block lengths
/// at which the value is determined without any one block. Expected values, which follow the runs, are never left out.
fn jackknife(found: &SearchMinimum, runs: usize, known: &[usize], normal: &DMatrix<f64>) -> Vec<f64> {
    let mut largest = vec![0.0; known.len()];
    for blocks in scales() {
        let mut squares = vec![0.0; known.len()];
        let mut alone = vec![false; known.len()];
        let mut count = 0.0;
        for (whitened, jacobian) in found.residuals.iter().zip(&found.jacobians).take(runs) {
            let rows = whitened.len();
            let length = rows.div_ceil(blocks).max(1);
            for first in (0..rows).step_by(length) {
                count += 1.0;
                let block = first..(first + length).min(rows);
                let own = Information::of(whitened, jacobian, block).among(known);
                for at in 0..known.len() {
                    alone[at] |= MIN_INFORMATION_SHARE * normal[(at, at)] < own.normal[(at, at)];
                }
                let Some(without) = inverse(&(normal - own.normal)) else { continue };
                for (square, moved) in squares.iter_mut().zip((without * own.gradient).iter()) {
                    *square += moved * moved;
                }
            }
        }
        for at in (0..known.len()).filter(|at| !alone[*at]) {
            largest[at] = f64::max(largest[at], squares[at] * (count - 1.0) / f64::max(count, 1.0));
        }
    }
    largest
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers of variance 1, the same every time.
    fn noise(seed: &mut u64) -> f64 {
        let uniform = (0..12).map(|_| {
            *seed ^= *seed << 13;
            *seed ^= *seed >> 7;
            *seed ^= *seed << 17;
            (*seed >> 11) as f64 / (1u64 << 53) as f64
        });
        uniform.sum::<f64>() - 6.0
    }

    /// Two values, one that acts everywhere and one in one place, fitted to residuals of which neighbours are related
    /// by `related`: how many deviations each is off, and by how much its deviation is larger than the plain one.
    fn fitted(related: f64, seed: &mut u64) -> Vec<(f64, f64)> {
        let count = 2000;
        let jacobian = DMatrix::from_fn(count, 2, |row, column| match column {
            0 => (0.003 * row as f64).sin(),
            _ => f64::from(u8::from((1000..1100).contains(&row))),
        });
        let mut last = 0.0;
        let residuals = DVector::from_fn(count, |_, _| {
            last = related * last + (1.0 - related * related).sqrt() * 0.4 * noise(seed);
            last
        });
        let normal = jacobian.tr_mul(&jacobian);
        let plain = normal.clone().try_inverse().expect("two values that are apart");
        let varied = -&plain * jacobian.tr_mul(&residuals);
        let whitened = vec![(residuals + &jacobian * &varied).iter().copied().collect()];
        let found = SearchMinimum {
            point: varied.clone(),
            residuals: whitened,
            jacobians: vec![jacobian],
            cost: 0.0,
            converged: true,
        };
        let covariance = covariance(&found, &[vec![0.0; count]]);
        let of = |at: usize| {
            let deviation = covariance[(at, at)].sqrt();
            (varied[at].abs() / deviation, deviation / (0.4 * plain[(at, at)].sqrt()))
        };
        (0..2).map(of).collect()
    }

    #[test]
    fn the_truth_lies_where_nine_times_in_ten_it_should_though_neighbours_are_related() {
        let mut seed = 11;
        for (related, larger) in [(0.0, 4.0), (0.95, f64::INFINITY)] {
            let all: Vec<_> = (0..200).map(|_| fitted(related, &mut seed)).collect();
            for value in 0..2 {
                let within = all.iter().filter(|fitted| fitted[value].0 < 1.645).count();
                assert!((150..=200).contains(&within), "value {value} related {related}: {within} of 200");
                let most = all.iter().map(|fitted| fitted[value].1).fold(0.0, f64::max);
                assert!(most < larger, "value {value} related {related}: {most} times the plain deviation");
            }
        }
    }

    #[test]
    fn a_clock_that_is_off_moves_what_goes_with_time() {
        let count = 1000;
        let jacobian = DMatrix::from_element(count, 1, -0.1);
        let found = SearchMinimum {
            point: DVector::zeros(1),
            residuals: vec![vec![0.0; count]],
            jacobians: vec![jacobian],
            cost: 0.0,
            converged: true,
        };
        let deviation = |trace: f64| covariance(&found, &[vec![trace; count]])[(0, 0)].sqrt();
        let (without, with) = (deviation(0.0), deviation(1e6));
        assert!((with - without.hypot(CLOCK_DEVIATION_RATIO * 1e7)).abs() < 1e-6 * with, "{without} {with}");
    }
}
