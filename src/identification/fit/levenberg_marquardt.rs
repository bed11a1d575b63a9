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
//! The derivatives J cost most of the search, so J follows an accepted step by the secant rule, with the sizes dᵢ of the
//! columns of J as the units of the parameters:
//!
//! ```text
//! J ← J + (ν(x + Δ) − ν(x) − JΔ) (D²Δ)ᵀ / (ΔᵀD²Δ),     D = diag(dᵢ)
//! ```
//!
//! J is computed again where a step gains too little of the predicted gain, and before the search ends.
//!
//! Source: Madsen, Nielsen and Tingleff 2004, Sect. 3.2 and 3.5; Broyden 1965; Marquardt 1963; Huber 1964.

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
    /// Least ratio of the gain of a step to the predicted one at which the derivatives follow the step by the secant rule;
    /// infinite to compute them after every step.
    pub min_secant_gain_ratio: f64,
}

/// The end of a search.
pub struct SearchMinimum {
    /// Point of least cost.
    pub point: DVector<f64>,
    /// Residuals there, block by block.
    pub residuals: Vec<Vec<f64>>,
    /// Derivatives at that point or, if the last step gained next to nothing, before that step; block by block.
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
    let mut slopes = Slopes::new(problem.jacobians(&point, &residuals, &[]));
    let mut damping = search.damping;
    let mut converged = point.is_empty();
    for step in 0..search.max_steps {
        if converged {
            break;
        }
        progress(step as f64 / search.max_steps as f64);
        if slopes.source == SlopesSource::Outdated {
            slopes.compute(problem, &point, &residuals);
        }
        // If a parameter affects few residuals, the equations need damping to have a solution.
        let Some((next, foretold)) =
            damped_step(problem, &point, &residuals, &slopes.current, damping, search.huber)
        else {
            damping *= 10.0;
            continue;
        };
        let there = problem.residuals(&next);
        let cost_there = there.as_ref().map_or(f64::INFINITY, |there| cost(there));
        if let Some(there) = there.filter(|_| cost_there < least) {
            let gain = least - cost_there;
            let is_last = gain < search.ftol * least + search.atol;
            converged = is_last && slopes.source == SlopesSource::Computed;
            if !is_last && search.min_secant_gain_ratio * foretold <= gain {
                slopes.follow(&(&next - &point), &residuals, &there);
            } else if !converged {
                slopes.source = SlopesSource::Outdated;
            }
            (point, residuals, least) = (next, there, cost_there);
            damping = (damping * (1.0 - (2.0 * gain / foretold - 1.0).powi(3)).clamp(0.2, 2.0)).max(1e-9);
        } else if slopes.source == SlopesSource::Computed {
            damping *= 8.0;
            converged = search.max_damping < damping;
        } else {
            slopes.source = SlopesSource::Outdated;
        }
    }
    if slopes.source != SlopesSource::Computed {
        slopes.compute(problem, &point, &residuals);
    }
    progress(1.0);
    SearchMinimum { point, residuals, jacobians: slopes.current, cost: least, converged }
}

/// The derivatives of a search, block by block.
struct Slopes {
    current: Vec<DMatrix<f64>>,
    /// The derivatives as they were computed last.
    computed: Vec<DMatrix<f64>>,
    source: SlopesSource,
}

/// The source of the current derivatives.
#[derive(PartialEq)]
enum SlopesSource {
    /// They were computed at the point of the search.
    Computed,
    /// They have followed a step by the secant rule.
    Followed,
    /// They are to be computed again.
    Outdated,
}

impl Slopes {
    fn new(computed: Vec<DMatrix<f64>>) -> Slopes {
        Slopes { current: computed.clone(), computed, source: SlopesSource::Computed }
    }

    /// Computes the derivatives at a point.
    fn compute(&mut self, problem: &impl Problem, point: &DVector<f64>, residuals: &[Vec<f64>]) {
        *self = Slopes::new(problem.jacobians(point, residuals, &self.computed));
    }

    /// Follows a step from one point to another by the secant rule.
    fn follow(&mut self, step: &DVector<f64>, before: &[Vec<f64>], after: &[Vec<f64>]) {
        let squares = |own: &DMatrix<f64>| {
            DVector::from_iterator(step.len(), own.column_iter().map(|column| column.norm_squared()))
        };
        let sizes = self.current.iter().map(squares).fold(DVector::zeros(step.len()), |sum, own| sum + own);
        let scaled = sizes.component_mul(step);
        let length = scaled.dot(step);
        if length <= 0.0 {
            self.source = SlopesSource::Outdated;
            return;
        }
        for ((own, before), after) in self.current.iter_mut().zip(before).zip(after) {
            let foretold = &*own * step;
            let missing = DVector::from_fn(own.nrows(), |row, _| after[row] - before[row] - foretold[row]);
            own.ger(1.0 / length, &missing, &scaled, 1.0);
        }
        self.source = SlopesSource::Followed;
    }
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

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;

    /// Samples of b·exp(−a·t), of which a and b are sought; counts how often the derivatives are computed.
    #[derive(Default)]
    struct Decay {
        computed: Cell<usize>,
    }

    const TRUE_RATE: f64 = 0.7;
    const TRUE_HEIGHT: f64 = 3.0;

    fn height(rate: f64, height: f64, time: f64) -> f64 {
        height * (-rate * time).exp()
    }

    fn times() -> impl Iterator<Item = f64> {
        (0..40).map(|row| 0.1 * f64::from(row))
    }

    impl Problem for Decay {
        fn residuals(&self, point: &DVector<f64>) -> Option<Vec<Vec<f64>>> {
            let of = |time: f64| height(point[0], point[1], time) - height(TRUE_RATE, TRUE_HEIGHT, time);
            Some(vec![times().map(of).collect()])
        }

        fn jacobians(&self, point: &DVector<f64>, _: &[Vec<f64>], _: &[DMatrix<f64>]) -> Vec<DMatrix<f64>> {
            self.computed.set(self.computed.get() + 1);
            let rows: Vec<f64> = times().collect();
            let of = |row: usize, column: usize| match column {
                0 => -rows[row] * height(point[0], point[1], rows[row]),
                _ => height(point[0], 1.0, rows[row]),
            };
            vec![DMatrix::from_fn(rows.len(), 2, of)]
        }

        fn after_step(&self, point: &DVector<f64>, step: &DVector<f64>) -> DVector<f64> {
            point + step
        }

        fn is_at_bound(&self, _: &DVector<f64>, _: usize, _: f64) -> bool {
            false
        }
    }

    const SEARCH: Search = Search {
        huber: f64::INFINITY,
        ftol: 1e-9,
        atol: 1e-18,
        damping: 1e-2,
        max_damping: 1e6,
        max_steps: 60,
        min_secant_gain_ratio: 0.25,
    };

    #[test]
    fn a_search_finds_the_minimum_and_seldom_computes_derivatives() {
        let (problem, steps) = (Decay::default(), Cell::new(0));
        let start = DVector::from_vec(vec![0.2, 1.0]);
        let found = minimise(&problem, start, SEARCH, &mut |_| steps.set(steps.get() + 1));
        assert!(found.converged);
        assert!((found.point[0] - TRUE_RATE).abs() < 1e-6, "{}", found.point);
        assert!((found.point[1] - TRUE_HEIGHT).abs() < 1e-6, "{}", found.point);
        let computed = problem.computed.get();
        assert!(2 * computed <= steps.get(), "{computed} in {} steps", steps.get());
    }

    #[test]
    fn derivatives_that_follow_a_step_foretell_it() {
        let problem = Decay::default();
        let [from, to] = [[0.2, 1.0], [0.5, 2.5]].map(|point| DVector::from_row_slice(&point));
        let [before, after] = [&from, &to].map(|point| problem.residuals(point).expect("they are defined"));
        let mut slopes = Slopes::new(problem.jacobians(&from, &before, &[]));
        let step = &to - &from;
        let misses = |slopes: &Slopes| {
            let foretold = &slopes.current[0] * &step;
            let pairs = before[0].iter().zip(&after[0]).zip(foretold.iter());
            pairs.map(|((before, after), own)| (after - before - own).abs()).fold(0.0, f64::max)
        };
        assert!(0.1 < misses(&slopes));
        slopes.follow(&step, &before, &after);
        assert!(misses(&slopes) < 1e-12);
    }
}
