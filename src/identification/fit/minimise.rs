//! Free parameters of a machine as a problem of least squares: each trial needs a whole simulation.

use nalgebra::{DMatrix, DVector};

use crate::identification::fit::levenberg_marquardt::{self, Problem, Search, SearchMinimum};
use crate::identification::fit::{FreeParameter, Run, VariationScale, Whitening, whitened, with};
use crate::machine::Machine;
use crate::side_by_side::side_by_side;

/// c: larger whitened residuals are weighted less.
const HUBER_THRESHOLD: f64 = 2.0;
/// Decrease of the cost below which a step is the last.
const ATOL: f64 = 0.02;
/// Most steps.
const MAX_STEPS: usize = 25;
/// Least ratio of the gain of a step to the predicted one at which the derivatives follow the step.
const MIN_SECANT_GAIN_RATIO: f64 = 0.25;
/// Longest step of the logarithm of a value: the model is nearly linear over it.
const MAX_RATIO_STEP: f64 = 0.7;

/// Returns Huber's weight of a whitened residual.
pub fn weight(value: f64) -> f64 {
    levenberg_marquardt::weight(value, HUBER_THRESHOLD)
}

/// Returns Huber's ρ of a whitened residual.
pub fn rho(value: f64) -> f64 {
    levenberg_marquardt::rho(value, HUBER_THRESHOLD)
}

/// Returns the point of least cost, in the optimiser's coordinates; the search stops once a step lowers the
/// cost by less than the part `ftol`.
pub fn minimise(
    machine: &Machine,
    runs: &[Run],
    freed: &[FreeParameter],
    whitenings: &[Whitening],
    ftol: f64,
    progress: &mut dyn FnMut(f64),
) -> SearchMinimum {
    let problem = FitProblem { machine, runs, freed, whitenings };
    let search = Search {
        huber: HUBER_THRESHOLD,
        ftol,
        atol: ATOL,
        damping: 1e-2,
        max_damping: 1e6,
        max_steps: MAX_STEPS,
        min_secant_gain_ratio: MIN_SECANT_GAIN_RATIO,
    };
    levenberg_marquardt::minimise(&problem, problem.start(), search, progress)
}

/// Returns the whitened residuals at the initial values, and their derivatives by the optimiser's
/// coordinates, run by run.
pub fn linearised(
    machine: &Machine,
    runs: &[Run],
    freed: &[FreeParameter],
    whitenings: &[Whitening],
) -> (Vec<Vec<f64>>, Vec<DMatrix<f64>>) {
    let problem = FitProblem { machine, runs, freed, whitenings };
    let start = problem.start();
    let residuals = problem.whitened(&start);
    let jacobians = problem.jacobians(&start, &residuals, &[]);
    (residuals, jacobians)
}

/// The parameters of a machine to fit to runs.
struct FitProblem<'a> {
    machine: &'a Machine,
    runs: &'a [Run<'a>],
    freed: &'a [FreeParameter],
    whitenings: &'a [Whitening],
}

impl FitProblem<'_> {
    /// Returns the initial values in optimiser's coordinates.
    fn start(&self) -> DVector<f64> {
        let start = self.freed.iter().map(|freed| freed.to_internal(freed.start));
        DVector::from_iterator(self.freed.len(), start)
    }

    /// Returns the whitened residuals of each run and, after them, one residual for each parameter with an expected value.
    fn whitened(&self, varied: &DVector<f64>) -> Vec<Vec<f64>> {
        let values: Vec<f64> = self
            .freed
            .iter()
            .zip(varied.iter())
            .map(|(freed, varied)| freed.from_internal(*varied))
            .collect();
        let mut all = whitened(&with(self.machine, self.freed, &values), self.runs, self.whitenings);
        let pairs = self.freed.iter().zip(&values);
        let priors: Vec<f64> = pairs.filter_map(|(freed, value)| freed.from_expected(*value)).collect();
        if !priors.is_empty() {
            all.push(priors);
        }
        all
    }
}

impl Problem for FitProblem<'_> {
    fn residuals(&self, varied: &DVector<f64>) -> Option<Vec<Vec<f64>>> {
        Some(self.whitened(varied))
    }

    /// Returns central difference quotients, one-sided at a bound. Columns of linear parameters are kept from
    /// `last`.
    fn jacobians(
        &self,
        varied: &DVector<f64>,
        found: &[Vec<f64>],
        last: &[DMatrix<f64>],
    ) -> Vec<DMatrix<f64>> {
        let difference = |column: usize| {
            let freed = &self.freed[column];
            let step = freed.step(freed.from_internal(varied[column]));
            let beside = |sign: f64| {
                let mut beside = varied.clone();
                beside[column] = freed.to_internal(freed.from_internal(varied[column] + sign * step));
                (beside[column], self.whitened(&beside))
            };
            if !freed.is_linear {
                return (beside(-1.0), beside(1.0));
            }
            // A linear parameter needs no second point, unless it is at its upper bound.
            let (own, above) = ((varied[column], found.to_vec()), beside(1.0));
            if own.0 < above.0 { (own, above) } else { (beside(-1.0), own) }
        };
        let is_kept = |column: usize| self.freed[column].is_linear && !last.is_empty();
        let columns = 0..self.freed.len();
        let differences =
            side_by_side(columns.len(), |column| (!is_kept(column)).then(|| difference(column)), &mut |_| {});
        let quotient = |run: usize, column: usize| match &differences[column] {
            None => last[run].column(column).into_owned(),
            Some(((low, below), (high, above))) => DVector::from_fn(found[run].len(), |row, _| {
                if low < high { (above[run][row] - below[run][row]) / (high - low) } else { 0.0 }
            }),
        };
        let jacobian = |run: usize| {
            let mut jacobian = DMatrix::zeros(found[run].len(), columns.len());
            columns.clone().for_each(|column| jacobian.set_column(column, &quotient(run, column)));
            jacobian
        };
        (0..found.len()).map(jacobian).collect()
    }

    fn after_step(&self, varied: &DVector<f64>, step: &DVector<f64>) -> DVector<f64> {
        DVector::from_fn(varied.len(), |at, _| {
            let freed = &self.freed[at];
            let limit = if freed.scale == VariationScale::Ratio { MAX_RATIO_STEP } else { f64::INFINITY };
            freed.to_internal(freed.from_internal(varied[at] + step[at].clamp(-limit, limit)))
        })
    }

    fn is_at_bound(&self, varied: &DVector<f64>, parameter: usize, downhill: f64) -> bool {
        let freed = &self.freed[parameter];
        let (value, (low, high)) = (freed.from_internal(varied[parameter]), freed.bounds);
        (value <= low && downhill < 0.0) || (high <= value && 0.0 < downhill)
    }
}
