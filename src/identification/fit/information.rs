//! Fisher information of a part of the runs on the values: information and gradient of weighted least
//! squares,
//!
//! ```text
//! H = JᵀWJ,    g = JᵀWν
//! ```
//!
//! with ν the whitened residuals of the part, J their derivatives by the optimiser's coordinates, W Huber's
//! weights.

use std::ops::{AddAssign, Range};

use nalgebra::{DMatrix, DVector};

use crate::identification::fit::minimise::weight;

/// H and g of a part of the runs.
#[derive(Clone)]
pub struct Information {
    pub normal: DMatrix<f64>,
    pub gradient: DVector<f64>,
}

impl Information {
    /// Returns zero information about `count` parameters.
    pub fn none(count: usize) -> Information {
        Information { normal: DMatrix::zeros(count, count), gradient: DVector::zeros(count) }
    }

    /// Returns the information of some rows of a run.
    pub fn of(whitened: &[f64], jacobian: &DMatrix<f64>, rows: Range<usize>) -> Information {
        let mut own = Information::none(jacobian.ncols());
        for row in rows {
            let value = whitened[row];
            let slope = jacobian.row(row).transpose();
            own.gradient += weight(value) * value * &slope;
            own.normal += weight(value) * &slope * slope.transpose();
        }
        own
    }

    /// Returns the information of all runs.
    pub fn of_all(whitened: &[Vec<f64>], jacobians: &[DMatrix<f64>], count: usize) -> Information {
        let mut all = Information::none(count);
        for (whitened, jacobian) in whitened.iter().zip(jacobians) {
            all += Information::of(whitened, jacobian, 0..whitened.len());
        }
        all
    }

    /// Returns the information on some of the values, with the others fixed.
    pub fn among(&self, known: &[usize]) -> Information {
        let normal = self.normal.select_rows(known).select_columns(known);
        Information { normal, gradient: self.gradient.select_rows(known) }
    }
}

impl AddAssign for Information {
    fn add_assign(&mut self, other: Information) {
        self.normal += other.normal;
        self.gradient += other.gradient;
    }
}

/// Returns the inverse, computed from the matrix scaled to a unit diagonal; `None` if there is none.
pub fn inverse(normal: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let count = normal.nrows();
    if (0..count).any(|at| normal[(at, at)] <= 0.0) {
        return None;
    }
    let scale = normal.diagonal().map(|own| 1.0 / own.sqrt());
    let scaled = DMatrix::from_fn(count, count, |i, j| normal[(i, j)] * scale[i] * scale[j]);
    let ridge = DMatrix::identity(count, count) * 1e-12;
    let inverse = (scaled + ridge).cholesky()?.inverse();
    Some(DMatrix::from_fn(count, count, |i, j| inverse[(i, j)] * scale[i] * scale[j]))
}
