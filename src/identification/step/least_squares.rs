//! Least squares by the method of Levenberg and Marquardt.
//!
//! From parameters p with residuals r = y(p) − values and Jacobian J, the step solves
//!
//! ```text
//! (JᵀJ + λ diag JᵀJ) Δ = −Jᵀr
//! ```
//!
//! A step that lowers ‖r‖² is taken and λ falls; otherwise λ rises and the step shortens. A parameter
//! that leans against a bound is left out of the step.
//!
//! Source: Marquardt 1963; Madsen, Nielsen and Tingleff 2004, Sect. 3.2.

use nalgebra::{DMatrix, DVector};

use crate::identification::step::response::Response;

/// Steps tried before giving up.
const PATIENCE: usize = 300;
/// A step that changes the response by this part of it is none.
const STANDSTILL: f64 = 1e-13;
/// A gain of this part of the sum of squares is hardly one; so many in a row are the end.
const HARDLY: (f64, usize) = (1e-9, 10);

/// Where the search ended.
pub struct Minimum {
    pub parameters: DVector<f64>,
    pub residuals: Vec<f64>,
    /// (JᵀJ)⁻¹; none where the recording says nothing of some parameter.
    pub cofactors: Option<DMatrix<f64>>,
    pub converged: bool,
}

/// Searches the parameters whose response is closest to `values`.
pub fn minimise(response: &Response, values: &[f64], guess: DVector<f64>) -> Minimum {
    let values = DVector::from_column_slice(values);
    let misfit = |parameters: &DVector<f64>| response.values(parameters).map(|found| found - &values);
    let mut parameters = guess;
    let mut residuals = misfit(&parameters).expect("a guess is within bounds");
    let mut jacobian = response.jacobian(&parameters);
    let mut damping = 1e-3;
    let mut converged = false;
    let mut hardly = 0;
    for _ in 0..PATIENCE {
        // Where few samples feel the parameters the equations need damping to have a solution.
        let Some(step) = step(response, &parameters, &jacobian, &residuals, damping) else {
            damping *= 5.0;
            continue;
        };
        let felt = (&jacobian * &step).norm();
        if felt <= STANDSTILL * values.norm() && (damping <= 1.0 || 1e8 < damping) {
            converged = true;
            break;
        }
        let next = response.bounded(&parameters + &step);
        let lower = misfit(&next).filter(|found| found.norm_squared() < residuals.norm_squared());
        match lower {
            Some(found) => {
                let squares = residuals.norm_squared();
                let gain = squares - found.norm_squared();
                let foretold = squares - (&residuals + &jacobian * &step).norm_squared();
                // Nielsen's rule: a gain that falls short of what was foretold shortens the next step.
                damping *= (1.0 - (2.0 * gain / foretold - 1.0).powi(3)).clamp(0.1, 2.0);
                damping = damping.max(1e-12);
                (parameters, residuals) = (next, found);
                jacobian = response.jacobian(&parameters);
                hardly = if gain < HARDLY.0 * squares { hardly + 1 } else { 0 };
                if HARDLY.1 <= hardly {
                    converged = true;
                    break;
                }
            }
            // Where rounding hides every gain the search is at its end.
            None if 1e12 < damping => {
                converged = true;
                break;
            }
            None => damping *= 5.0,
        }
    }
    let normal = jacobian.tr_mul(&jacobian);
    Minimum { cofactors: inverse(&normal), parameters, residuals: residuals.as_slice().to_vec(), converged }
}

/// The damped step; none where the equations have no solution.
fn step(
    response: &Response,
    parameters: &DVector<f64>,
    jacobian: &DMatrix<f64>,
    residuals: &DVector<f64>,
    damping: f64,
) -> Option<DVector<f64>> {
    let mut normal = jacobian.tr_mul(jacobian);
    let mut downhill = -jacobian.tr_mul(residuals);
    if let Some(held) = response.held(parameters, &downhill) {
        normal.row_mut(held).fill(0.0);
        normal.column_mut(held).fill(0.0);
        downhill[held] = 0.0;
    }
    let largest = normal.diagonal().max();
    for place in 0..normal.nrows() {
        // A parameter that the residuals do not feel stays where it is.
        let own = normal[(place, place)];
        normal[(place, place)] = own * (1.0 + damping) + if own == 0.0 { largest } else { 0.0 };
    }
    let scale = normal.diagonal().map(|own| 1.0 / own.sqrt());
    let scaled =
        DMatrix::from_fn(normal.nrows(), normal.ncols(), |i, j| normal[(i, j)] * scale[i] * scale[j]);
    let solution = scaled.cholesky()?.solve(&downhill.component_mul(&scale));
    Some(solution.component_mul(&scale)).filter(|step| step.iter().all(|value| value.is_finite()))
}

/// The inverse of normal equations, scaled so that units do not matter.
fn inverse(normal: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let scale = normal.diagonal().map(|own| 1.0 / own.sqrt());
    if scale.iter().any(|value| !value.is_finite()) {
        return None;
    }
    let scaled =
        DMatrix::from_fn(normal.nrows(), normal.ncols(), |i, j| normal[(i, j)] * scale[i] * scale[j]);
    let inverse = scaled.cholesky()?.inverse();
    Some(DMatrix::from_fn(normal.nrows(), normal.ncols(), |i, j| inverse[(i, j)] * scale[i] * scale[j]))
}
