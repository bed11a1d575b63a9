//! Least squares by Levenberg and Marquardt, with Huber's weights and bounds.
//!
//! ```text
//! (JᵀWJ + λ diag JᵀWJ) Δ = −JᵀWν,     W = min(1, c / |ν|)
//! ```
//!
//! Source: Madsen, Nielsen and Tingleff 2004, Sect. 3.2; Huber 1964.

use nalgebra::{DMatrix, DVector};

use crate::identification::fit::{Freed, Run, Whitening, cost, whitened, with};
use crate::machine::Machine;

/// c: whitened residuals beyond it count less.
const HUBER: f64 = 2.0;
/// Steps at most.
const MOST_STEPS: usize = 25;
/// A step that gains less than this is the last.
const LEAST: f64 = 0.02;

/// Where the search ended.
pub struct Minimum {
    pub varied: DVector<f64>,
    pub whitened: Vec<Vec<f64>>,
    pub jacobians: Vec<DMatrix<f64>>,
    pub cost: f64,
    pub converged: bool,
}

/// Huber's weight of a whitened residual.
pub fn weight(value: f64) -> f64 {
    if value.abs() <= HUBER { 1.0 } else { HUBER / value.abs() }
}

/// Huber's ρ.
pub fn rho(value: f64) -> f64 {
    let size = value.abs();
    if size <= HUBER { size * size } else { 2.0 * HUBER * size - HUBER * HUBER }
}

/// The values, as they are varied, at which the cost is least, to the part `hardly`.
pub fn minimise(
    machine: &Machine,
    runs: &[Run],
    freed: &[Freed],
    whitenings: &[Whitening],
    hardly: f64,
    progress: &mut dyn FnMut(f64),
) -> Minimum {
    let whitened = whitened_at(machine, runs, freed, whitenings);
    let mut varied = start(freed);
    let mut found = whitened(&varied);
    let mut least = cost(found.iter().flatten());
    let mut jacobians = Vec::new();
    let mut damping = 1e-2;
    let mut converged = freed.is_empty();
    let mut moved = true;
    for step in 0..MOST_STEPS {
        progress(step as f64 / MOST_STEPS as f64);
        if moved {
            jacobians = derivatives(freed, &varied, &found, &whitened, &jacobians);
        }
        if converged {
            break;
        }
        let Some(next) = next(freed, &varied, &found, &jacobians, damping) else {
            damping *= 10.0;
            moved = false;
            continue;
        };
        let there = whitened(&next);
        let cost_there = cost(there.iter().flatten());
        moved = cost_there < least;
        if moved {
            converged = least - cost_there < hardly * least + LEAST;
            (varied, found, least) = (next, there, cost_there);
            damping = (0.2 * damping).max(1e-9);
        } else {
            damping *= 8.0;
            converged = 1e6 < damping;
        }
    }
    if jacobians.is_empty() || moved {
        jacobians = derivatives(freed, &varied, &found, &whitened, &jacobians);
    }
    progress(1.0);
    Minimum { varied, whitened: found, jacobians, cost: least, converged }
}

/// What is left where the values begin, and how it changes with them, run by run.
pub fn linearised(
    machine: &Machine,
    runs: &[Run],
    freed: &[Freed],
    whitenings: &[Whitening],
) -> (Vec<Vec<f64>>, Vec<DMatrix<f64>>) {
    let whitened = whitened_at(machine, runs, freed, whitenings);
    let varied = start(freed);
    let found = whitened(&varied);
    let jacobians = derivatives(freed, &varied, &found, &whitened, &[]);
    (found, jacobians)
}

/// The values to begin with, as they are varied.
fn start(freed: &[Freed]) -> DVector<f64> {
    DVector::from_iterator(freed.len(), freed.iter().map(|freed| freed.inward(freed.start)))
}

/// The whitened residuals by what is varied.
fn whitened_at(
    machine: &Machine,
    runs: &[Run],
    freed: &[Freed],
    whitenings: &[Whitening],
) -> impl Fn(&DVector<f64>) -> Vec<Vec<f64>> {
    move |varied| {
        let values: Vec<f64> =
            freed.iter().zip(varied.iter()).map(|(freed, varied)| freed.outward(*varied)).collect();
        whitened(&with(machine, freed, &values), runs, whitenings)
    }
}

/// Central difference quotients, one column a parameter; at a bound from one side. Columns of linear
/// parameters are kept once they are `known`.
fn derivatives(
    freed: &[Freed],
    varied: &DVector<f64>,
    found: &[Vec<f64>],
    whitened: &impl Fn(&DVector<f64>) -> Vec<Vec<f64>>,
    known: &[DMatrix<f64>],
) -> Vec<DMatrix<f64>> {
    let mut jacobians: Vec<DMatrix<f64>> =
        found.iter().map(|run| DMatrix::zeros(run.len(), freed.len())).collect();
    for (column, freed) in freed.iter().enumerate() {
        if freed.is_linear && !known.is_empty() {
            for (jacobian, known) in jacobians.iter_mut().zip(known) {
                jacobian.set_column(column, &known.column(column));
            }
            continue;
        }
        let step = freed.step(freed.outward(varied[column]));
        let beside = |sign: f64| {
            let mut beside = varied.clone();
            beside[column] = freed.inward(freed.outward(varied[column] + sign * step));
            (beside[column], whitened(&beside))
        };
        // What is linear needs no second point.
        let below = if freed.is_linear { (varied[column], found.to_vec()) } else { beside(-1.0) };
        let ((low, below), (high, above)) = (below, beside(1.0));
        if high - low <= 0.0 {
            continue;
        }
        for (run, jacobian) in jacobians.iter_mut().enumerate() {
            for row in 0..jacobian.nrows() {
                jacobian[(row, column)] = (above[run][row] - below[run][row]) / (high - low);
            }
        }
    }
    jacobians
}

/// The damped step; none where the equations have no solution.
fn next(
    freed: &[Freed],
    varied: &DVector<f64>,
    found: &[Vec<f64>],
    jacobians: &[DMatrix<f64>],
    damping: f64,
) -> Option<DVector<f64>> {
    let count = varied.len();
    let mut normal = DMatrix::zeros(count, count);
    let mut downhill = DVector::zeros(count);
    for (whitened, jacobian) in found.iter().zip(jacobians) {
        let mut weighted = jacobian.clone();
        for (row, value) in whitened.iter().enumerate() {
            weighted.row_mut(row).scale_mut(weight(*value));
        }
        normal += weighted.tr_mul(jacobian);
        downhill -= weighted.tr_mul(&DVector::from_column_slice(whitened));
    }
    let mut next = varied.clone();
    let scale = normal.diagonal().map(|own: f64| if 1e-12 < own { 1.0 / own.sqrt() } else { 0.0 });
    // A parameter that leans against its bound, or that nothing feels, stands still.
    let stands: Vec<bool> = (0..count)
        .map(|at| {
            let value = freed[at].outward(varied[at]);
            let (low, high) = freed[at].bounds;
            scale[at] == 0.0 || (value <= low && downhill[at] < 0.0) || (high <= value && 0.0 < downhill[at])
        })
        .collect();
    let scaled = DMatrix::from_fn(count, count, |i, j| match (i == j, stands[i] || stands[j]) {
        (true, true) => 1.0,
        (false, true) => 0.0,
        (true, false) => 1.0 + damping,
        (false, false) => normal[(i, j)] * scale[i] * scale[j],
    });
    let right = DVector::from_fn(count, |at, _| if stands[at] { 0.0 } else { downhill[at] * scale[at] });
    let solution = scaled.cholesky()?.solve(&right);
    for at in 0..count {
        // No step is longer than the model is straight.
        let limit = match freed[at].scale {
            crate::identification::fit::Scale::Ratio => 0.7,
            crate::identification::fit::Scale::Difference => f64::INFINITY,
        };
        let step = (solution[at] * scale[at]).clamp(-limit, limit);
        next[at] = freed[at].inward(freed[at].outward(varied[at] + step));
    }
    next.iter().all(|value| value.is_finite()).then_some(next)
}
