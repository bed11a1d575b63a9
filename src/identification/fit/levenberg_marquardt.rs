//! Least squares by Levenberg and Marquardt, with Huber's weights and bounds.
//!
//! ```text
//! (JᵀWJ + λ diag JᵀWJ) Δ = −JᵀWν,     W = min(1, c / |ν|)
//! ```
//!
//! A step Δ that lowers the cost is accepted. λ falls if the gain equals the predicted one and rises if the
//! gain falls short (Nielsen's rule: otherwise the search would oscillate at a kink of the residuals). If
//! there is no gain, λ rises and the step shortens. A parameter that the step pushes against its bound, or
//! that affects no residual, is left out of the step.
//!
//! Source: Madsen, Nielsen and Tingleff 2004, Sect. 3.2; Marquardt 1963; Huber 1964.

use nalgebra::{DMatrix, DVector};

/// A problem of least squares: residuals ν in one or several blocks.
pub trait Problem {
    /// Returns the residuals at a point, block by block; `None` outside their domain.
    fn residuals(&self, point: &DVector<f64>) -> Option<Vec<Vec<f64>>>;

    /// Returns the derivatives of `residuals` at a point, one column per parameter, block by block. `last`
    /// holds the derivatives at the previous point and is empty at first.
    fn jacobians(
        &self,
        point: &DVector<f64>,
        residuals: &[Vec<f64>],
        last: &[DMatrix<f64>],
    ) -> Vec<DMatrix<f64>>;

    /// Returns the point after a step, limited to the bounds and to the range in which the residuals are
    /// nearly linear.
    fn after_step(&self, point: &DVector<f64>, step: &DVector<f64>) -> DVector<f64>;

    /// Returns `true` if a parameter is on a bound that the direction `downhill` crosses.
    fn is_at_bound(&self, point: &DVector<f64>, parameter: usize, downhill: f64) -> bool;
}

/// The weights of residuals, and the end of the search.
#[derive(Clone, Copy, Debug)]
pub struct Search {
    /// c: larger residuals are weighted less; infinite for plain squares.
    pub huber: f64,
    /// Relative decrease of the cost below which a step is the last (MINPACK `ftol`).
    pub ftol: f64,
    /// Decrease of the cost below which a step is the last.
    pub atol: f64,
    /// λ of the first step.
    pub damping: f64,
    /// λ beyond which no step is tried.
    pub max_damping: f64,
    /// Most steps.
    pub max_steps: usize,
}

/// The end of a search.
pub struct SearchMinimum {
    /// Point of least cost.
    pub point: DVector<f64>,
    /// Residuals there, block by block.
    pub residuals: Vec<Vec<f64>>,
    /// Derivatives there, block by block.
    pub jacobians: Vec<DMatrix<f64>>,
    /// Σ ρ of the residuals.
    pub cost: f64,
    /// `true` if the search converged before it ran out of steps.
    pub converged: bool,
}

/// Returns Huber's weight of a residual.
pub fn weight(value: f64, huber: f64) -> f64 {
    if value.abs() <= huber { 1.0 } else { huber / value.abs() }
}

/// Returns Huber's ρ of a residual.
pub fn rho(value: f64, huber: f64) -> f64 {
    let size = value.abs();
    if size <= huber { size * size } else { 2.0 * huber * size - huber * huber }
}

/// Searches for the point of least cost from `start`, at which residuals must be defined. Calls `progress`
/// with the completed fraction, 0 to 1.
pub fn minimise(
    problem: &impl Problem,
    start: DVector<f64>,
    search: Search,
    progress: &mut dyn FnMut(f64),
) -> SearchMinimum {
    let cost =
        |residuals: &[Vec<f64>]| residuals.iter().flatten().map(|value| rho(*value, search.huber)).sum();
    let mut point = start;
    let mut residuals = problem.residuals(&point).expect("the search begins where there are residuals");
    let mut least: f64 = cost(&residuals);
    let mut jacobians = Vec::new();
    let mut damping = search.damping;
    let mut converged = point.is_empty();
    let mut moved = true;
    for step in 0..search.max_steps {
        progress(step as f64 / search.max_steps as f64);
        if moved {
            jacobians = problem.jacobians(&point, &residuals, &jacobians);
        }
        if converged {
            break;
        }
        // If a parameter affects few residuals, the equations need damping to have a solution.
        let Some((next, foretold)) =
            damped_step(problem, &point, &residuals, &jacobians, damping, search.huber)
        else {
            damping *= 10.0;
            moved = false;
            continue;
        };
        let there = problem.residuals(&next);
        let cost_there = there.as_ref().map_or(f64::INFINITY, |there| cost(there));
        moved = cost_there < least;
        if let Some(there) = there.filter(|_| moved) {
            let gain = least - cost_there;
            converged = gain < search.ftol * least + search.atol;
            (point, residuals, least) = (next, there, cost_there);
            damping = (damping * (1.0 - (2.0 * gain / foretold - 1.0).powi(3)).clamp(0.2, 2.0)).max(1e-9);
        } else {
            damping *= 8.0;
            converged = search.max_damping < damping;
        }
    }
    if jacobians.is_empty() || moved {
        jacobians = problem.jacobians(&point, &residuals, &jacobians);
    }
    progress(1.0);
    SearchMinimum { point, residuals, jacobians, cost: least, converged }
}

/// Returns the point after the damped step, and the predicted decrease of the cost for linear residuals;
/// `None` if the equations have no solution.
fn damped_step(
    problem: &impl Problem,
    point: &DVector<f64>,
    residuals: &[Vec<f64>],
    jacobians: &[DMatrix<f64>],
    damping: f64,
    huber: f64,
) -> Option<(DVector<f64>, f64)> {
    let count = point.len();
    let mut normal = DMatrix::zeros(count, count);
    let mut downhill = DVector::zeros(count);
    for (residuals, jacobian) in residuals.iter().zip(jacobians) {
        let mut weighted = jacobian.clone();
        for (row, value) in residuals.iter().enumerate() {
            weighted.row_mut(row).scale_mut(weight(*value, huber));
        }
        normal += weighted.tr_mul(jacobian);
        downhill -= weighted.tr_mul(&DVector::from_column_slice(residuals));
    }
    let scale = normal.diagonal().map(|own: f64| if 1e-12 < own { 1.0 / own.sqrt() } else { 0.0 });
    let is_held: Vec<bool> =
        (0..count).map(|at| scale[at] == 0.0 || problem.is_at_bound(point, at, downhill[at])).collect();
    let scaled = DMatrix::from_fn(count, count, |i, j| match (i == j, is_held[i] || is_held[j]) {
        (true, true) => 1.0,
        (false, true) => 0.0,
        (true, false) => 1.0 + damping,
        (false, false) => normal[(i, j)] * scale[i] * scale[j],
    });
    let right = DVector::from_fn(count, |at, _| if is_held[at] { 0.0 } else { downhill[at] * scale[at] });
    let solution = scaled.cholesky()?.solve(&right);
    let next = problem.after_step(point, &solution.component_mul(&scale));
    let step = &next - point;
    let foretold = step.dot(&(2.0 * downhill - normal * &step));
    next.iter().all(|value| value.is_finite()).then_some((next, foretold))
}
