//! Freed parameters of a machine as a problem of least squares: the whole simulation is run again for every value.

use nalgebra::{DMatrix, DVector};

use crate::identification::fit::levenberg_marquardt::{self, Minimum, Problem, Search};
use crate::identification::fit::{Freed, Run, Scale, Whitening, whitened, with};
use crate::machine::Machine;

/// c: whitened residuals beyond it count less.
const HUBER: f64 = 2.0;
/// A step that lowers the cost by less than this is the last.
const ATOL: f64 = 0.02;
/// Most steps.
const MAX_STEPS: usize = 25;
/// The longest step of what varies by ratios: no step is longer than the model is straight.
const MAX_RATIO_STEP: f64 = 0.7;

/// Huber's weight of a whitened residual.
pub fn weight(value: f64) -> f64 {
    levenberg_marquardt::weight(value, HUBER)
}

/// Huber's ρ.
pub fn rho(value: f64) -> f64 {
    levenberg_marquardt::rho(value, HUBER)
}

/// The values, as they are varied, at which the cost is least, to a relative decrease of `ftol`.
pub fn minimise(
    machine: &Machine,
    runs: &[Run],
    freed: &[Freed],
    whitenings: &[Whitening],
    ftol: f64,
    progress: &mut dyn FnMut(f64),
) -> Minimum {
    let problem = Fitted { machine, runs, freed, whitenings };
    let search =
        Search { huber: HUBER, ftol, atol: ATOL, damping: 1e-2, max_damping: 1e6, max_steps: MAX_STEPS };
    levenberg_marquardt::minimise(&problem, problem.start(), search, progress)
}

/// The whitened residuals where the values begin, and their derivatives by what is varied, run by run.
pub fn linearised(
    machine: &Machine,
    runs: &[Run],
    freed: &[Freed],
    whitenings: &[Whitening],
) -> (Vec<Vec<f64>>, Vec<DMatrix<f64>>) {
    let problem = Fitted { machine, runs, freed, whitenings };
    let start = problem.start();
    let residuals = problem.whitened(&start);
    let jacobians = problem.jacobians(&start, &residuals, &[]);
    (residuals, jacobians)
}

/// Parameters of a machine that are fitted to runs.
struct Fitted<'a> {
    machine: &'a Machine,
    runs: &'a [Run<'a>],
    freed: &'a [Freed],
    whitenings: &'a [Whitening],
}

impl Fitted<'_> {
    /// The values to begin with, as they are varied.
    fn start(&self) -> DVector<f64> {
        let start = self.freed.iter().map(|freed| freed.inward(freed.start));
        DVector::from_iterator(self.freed.len(), start)
    }

    fn whitened(&self, varied: &DVector<f64>) -> Vec<Vec<f64>> {
        let values: Vec<f64> =
            self.freed.iter().zip(varied.iter()).map(|(freed, varied)| freed.outward(*varied)).collect();
        whitened(&with(self.machine, self.freed, &values), self.runs, self.whitenings)
    }
}

impl Problem for Fitted<'_> {
    fn residuals(&self, varied: &DVector<f64>) -> Option<Vec<Vec<f64>>> {
        Some(self.whitened(varied))
    }

    /// Central difference quotients; at a bound from one side. Columns of linear parameters are kept.
    fn jacobians(
        &self,
        varied: &DVector<f64>,
        found: &[Vec<f64>],
        last: &[DMatrix<f64>],
    ) -> Vec<DMatrix<f64>> {
        let mut jacobians: Vec<DMatrix<f64>> =
            found.iter().map(|run| DMatrix::zeros(run.len(), self.freed.len())).collect();
        for (column, freed) in self.freed.iter().enumerate() {
            if freed.is_linear && !last.is_empty() {
                for (jacobian, last) in jacobians.iter_mut().zip(last) {
                    jacobian.set_column(column, &last.column(column));
                }
                continue;
            }
            let step = freed.step(freed.outward(varied[column]));
            let beside = |sign: f64| {
                let mut beside = varied.clone();
                beside[column] = freed.inward(freed.outward(varied[column] + sign * step));
                (beside[column], self.whitened(&beside))
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

    fn behind(&self, varied: &DVector<f64>, step: &DVector<f64>) -> DVector<f64> {
        DVector::from_fn(varied.len(), |at, _| {
            let freed = &self.freed[at];
            let limit = if freed.scale == Scale::Ratio { MAX_RATIO_STEP } else { f64::INFINITY };
            freed.inward(freed.outward(varied[at] + step[at].clamp(-limit, limit)))
        })
    }

    fn is_at_bound(&self, varied: &DVector<f64>, parameter: usize, downhill: f64) -> bool {
        let freed = &self.freed[parameter];
        let (value, (low, high)) = (freed.outward(varied[parameter]), freed.bounds);
        (value <= low && downhill < 0.0) || (high <= value && 0.0 < downhill)
    }
}
