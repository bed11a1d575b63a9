//! The misfit of a response to recorded values as a problem of least squares.

use nalgebra::{DMatrix, DVector};

use crate::identification::fit::inverse;
use crate::identification::fit::levenberg_marquardt::{self, Problem, Search};
use crate::identification::step::response::Response;

/// A search with plain squares that ends when gains are only rounding. Exact derivatives cost little here, so it computes them
/// after every step.
const SEARCH: Search = Search {
    huber: f64::INFINITY,
    ftol: 1e-12,
    atol: 0.0,
    damping: 1e-3,
    max_damping: 1e12,
    max_steps: 300,
    min_secant_gain_ratio: f64::INFINITY,
};

/// The end of the search.
pub struct Minimum {
    pub parameters: DVector<f64>,
    pub residuals: Vec<f64>,
    /// (JᵀJ)⁻¹; `None` if the recording does not determine some parameter.
    pub cofactors: Option<DMatrix<f64>>,
    pub converged: bool,
}

/// Returns the parameters whose response is closest to `values`.
pub fn minimise(response: &Response, values: &[f64], guess: DVector<f64>) -> Minimum {
    let misfit = Misfit { response, values: DVector::from_column_slice(values) };
    let minimum = levenberg_marquardt::minimise(&misfit, guess, SEARCH, &mut |_| {});
    let jacobian = &minimum.jacobians[0];
    Minimum {
        cofactors: inverse(&jacobian.tr_mul(jacobian)),
        parameters: minimum.point,
        residuals: minimum.residuals.concat(),
        converged: minimum.converged,
    }
}

struct Misfit<'a> {
    response: &'a Response<'a>,
    values: DVector<f64>,
}

impl Problem for Misfit<'_> {
    fn residuals(&self, parameters: &DVector<f64>) -> Option<Vec<Vec<f64>>> {
        let misfit = self.response.values(parameters)? - &self.values;
        Some(vec![misfit.as_slice().to_vec()])
    }

    fn jacobians(&self, parameters: &DVector<f64>, _: &[Vec<f64>], _: &[DMatrix<f64>]) -> Vec<DMatrix<f64>> {
        vec![self.response.jacobian(parameters)]
    }

    fn after_step(&self, parameters: &DVector<f64>, step: &DVector<f64>) -> DVector<f64> {
        self.response.bounded(parameters + step)
    }

    fn is_at_bound(&self, parameters: &DVector<f64>, parameter: usize, downhill: f64) -> bool {
        self.response.is_at_bound(parameters, parameter, downhill)
    }
}
