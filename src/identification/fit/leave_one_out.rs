//! Leave-one-out: the residuals of a section of the path at the values fitted to all other sections.
//!
//! From the values θ of all sections, at which the gradient nearly vanishes, one Gauss-Newton step leads to
//! the values without the section s:
//!
//! ```text
//! θ₋ₛ − θ = (H − Hₛ)⁻¹ gₛ,     νₛ(θ₋ₛ) = νₛ + Jₛ (θ₋ₛ − θ)
//! ```
//!
//! with ν, J, H and g as in `information`. The information on a value with all others unknown is c = 1/(H⁻¹)ᵢᵢ; the
//! share of a section is the part of c that is lost without it. A value of which one section has nearly all is fixed:
//! the other sections do not determine it, or do not tell it from another value. Source: Cook and Weisberg 1982,
//! Sect. 3.4. Limits: valid as far as the residuals are linear in the values.

use std::ops::Range;

use nalgebra::DMatrix;

use crate::identification::fit::information::{Information, inverse};
use crate::identification::fit::minimise::linearised;
use crate::identification::fit::{FreeParameter, Run, Whitening};
use crate::machine::Machine;

/// Largest share of the information on a value that one section may have; above this share the other sections
/// do not determine the value.
const MAX_INFORMATION_SHARE: f64 = 0.95;

/// The whitened residuals of one section that is held out.
#[derive(Clone, Debug, PartialEq)]
pub struct HeldOutBlock {
    /// Residuals at the values fitted to the other sections.
    pub whitened: Vec<f64>,
    /// Share of the information on each value that is lost without the section.
    pub shares: Vec<f64>,
}

impl HeldOutBlock {
    /// Returns `true` if the other sections determine a value.
    pub fn is_known(&self, value: usize) -> bool {
        self.shares[value] < MAX_INFORMATION_SHARE
    }
}

/// Returns every section of every run, in the order of the runs, at the values fitted to all other sections.
/// The initial values come from a fit to all sections. `sections` returns the sections of a run, given the index of the run
/// and its number of residuals.
pub fn held_out_blocks(
    machine: &Machine,
    runs: &[Run],
    freed: &[FreeParameter],
    whitenings: &[Whitening],
    sections: impl Fn(usize, usize) -> Vec<Range<usize>>,
) -> Vec<HeldOutBlock> {
    let (whitened, jacobians) = linearised(machine, runs, freed, whitenings);
    let all = Information::of_all(&whitened, &jacobians, freed.len());
    let runs = whitened.iter().zip(&jacobians).enumerate();
    runs.flat_map(|(run, (whitened, jacobian))| {
        sections(run, whitened.len()).into_iter().map(|rows| without(&all, whitened, jacobian, rows))
    })
    .collect()
}

fn without(all: &Information, whitened: &[f64], jacobian: &DMatrix<f64>, rows: Range<usize>) -> HeldOutBlock {
    let own = Information::of(whitened, jacobian, rows.clone());
    let (whole, rest) = (on_each(&all.normal), on_each(&(&all.normal - &own.normal)));
    let share = |(whole, rest): (&f64, &f64)| if 0.0 < *whole { (1.0 - rest / whole).max(0.0) } else { 1.0 };
    let shares = whole.iter().zip(&rest).map(share).collect();
    let mut left = HeldOutBlock { whitened: whitened[rows.clone()].to_vec(), shares };
    let known: Vec<usize> = (0..left.shares.len()).filter(|at| left.is_known(*at)).collect();
    let (all, own) = (all.among(&known), own.among(&known));
    if let Some(inverse) = inverse(&(all.normal - own.normal)) {
        let step = inverse * own.gradient;
        let slopes = jacobian.rows(rows.start, rows.len()).select_columns(&known);
        left.whitened.iter_mut().zip((slopes * step).iter()).for_each(|(left, moved)| *left += moved);
    }
    left
}

/// Returns the information on each value with all others unknown; 0 where there is none.
fn on_each(normal: &DMatrix<f64>) -> Vec<f64> {
    let mut each = vec![0.0; normal.nrows()];
    let seen: Vec<usize> = (0..each.len()).filter(|at| 0.0 < normal[(*at, *at)]).collect();
    if let Some(inverse) = inverse(&normal.select_rows(&seen).select_columns(&seen)) {
        seen.iter().zip(inverse.diagonal().iter()).for_each(|(at, variance)| each[*at] = 1.0 / variance);
    }
    each
}

#[cfg(test)]
mod tests {
    use super::*;

    /// For a mean, the residual of a held-out section is its distance from the mean of the others.
    #[test]
    fn the_mean_of_the_others_is_what_a_section_is_held_against() {
        let values = [0.3, -0.2, 0.5, 0.1, -0.4, 0.0, 0.2, 0.6];
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let whitened: Vec<f64> = values.iter().map(|value| value - mean).collect();
        let jacobian = DMatrix::from_element(values.len(), 1, -1.0);
        let all = Information::of(&whitened, &jacobian, 0..values.len());
        let others = values[3..].iter().sum::<f64>() / 5.0;
        let found = without(&all, &whitened, &jacobian, 0..3);
        assert!(found.is_known(0));
        for (left, value) in found.whitened.iter().zip(&values) {
            assert!((left - (value - others)).abs() < 1e-12, "{left} is not {value} − {others}");
        }
    }

    #[test]
    fn a_value_of_one_section_alone_is_not_known_without_it() {
        let whitened = [0.2, -0.2, 0.1, 0.3, 0.0, 0.1];
        let slopes = [1.0, 1.0, 1.0, 1.0, 1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 1.0, 0.0];
        let jacobian = DMatrix::from_row_slice(6, 2, &slopes);
        let all = Information::of(&whitened, &jacobian, 0..6);
        let known = |rows: Range<usize>| {
            [0, 1].map(|value| without(&all, &whitened, &jacobian, rows.clone()).is_known(value))
        };
        assert_eq!((known(0..2), known(2..4)), ([true, false], [true, true]));
    }

    #[test]
    fn values_that_the_others_do_not_tell_apart_are_not_known() {
        let whitened = [0.2, -0.2, 0.1, 0.3];
        // Only the last two rows tell the values apart: without them they are known as their sum.
        let jacobian = DMatrix::from_row_slice(4, 2, &[1.0, 1.0, 1.0, 1.0, 1.0, 0.0, 1.0, 0.0]);
        let all = Information::of(&whitened, &jacobian, 0..4);
        let held = without(&all, &whitened, &jacobian, 2..4);
        assert!(!held.is_known(0) && !held.is_known(1));
        assert_eq!(held.whitened, whitened[2..]);
    }
}
