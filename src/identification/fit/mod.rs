//! Machine, runs and free parameters → [`Fit`]: the values at which the simulation is closest.
//!
//! Each tried value needs a whole simulation; the minimised cost is
//!
//! ```text
//! Σ_runs Σ_k ρ(ν_k),    ρ(ν) = ν² for |ν| ≤ c, then 2 c |ν| − c²
//! ```
//!
//! over the whitened residuals ν of `whitened`. Beyond c the cost grows only linearly, so that an unexplained
//! wait does not distort the other values (Huber 1964). The fit uses Levenberg and Marquardt's method
//! with difference quotients; a parameter at its bound is fixed.
//!
//! Uncertainties are computed in `uncertainty`: neighbouring residuals may be correlated, and more samples of
//! the same motion add no certainty.

mod free_parameter;
mod golden_section;
mod information;
mod leave_one_out;
pub mod levenberg_marquardt;
mod minimise;
mod aligned_run;
mod uncertainty;
mod whitening;

use std::borrow::Cow;

use nalgebra::DMatrix;

pub use aligned_run::{AlignedRun, AlignedRunError};
pub use free_parameter::{Exactness, FreeParameter, VariationScale};
pub use golden_section::golden_section;
pub use information::inverse;
pub use leave_one_out::{HeldOutBlock, held_out_blocks};
pub use uncertainty::dispersion;
pub use whitening::{NORMAL_MEDIAN_DEVIATION, Whitening};

use crate::identification::alignment::{Alignment, ProgramPlace, times_at_marks};
use crate::identification::comparison::{Comparison, RampMisfit, compare, ramp_windows, residuals};
use crate::machine::Machine;
use crate::simulation::feed::FeedPlan;
use crate::simulation::simulate;
use crate::simulation::toolpath::Toolpath;

/// Relative cost decrease below which the fit stops (MINPACK `ftol`).
pub const FTOL: f64 = 1e-4;

/// A program with the recording of one of its runs.
#[derive(Clone)]
pub struct Run<'a> {
    /// Program.
    pub toolpath: &'a Toolpath,
    /// Recording aligned with it.
    pub alignment: &'a Alignment,
    /// Override switches in the recording, as ratios of feed and rapid.
    pub overrides: (Option<f64>, Option<f64>),
}

/// The result of a fit.
#[derive(Clone, Debug)]
pub struct Fit {
    /// Machine with the fitted values.
    pub machine: Machine,
    /// Fitted values, core units, in the order of the free parameters.
    pub values: Vec<f64>,
    /// Standard deviations, core units; infinite if the runs do not determine a value.
    pub deviations: Vec<f64>,
    /// Correlations of the values; 1 on the diagonal.
    pub correlations: DMatrix<f64>,
    /// Remaining cost, Σ ρ.
    pub cost: f64,
    /// Whitened residuals of each run.
    pub whitened: Vec<Vec<f64>>,
    /// `true` if the search converged.
    pub converged: bool,
}

impl Run<'_> {
    /// Returns `true` if the start of the program was recorded.
    pub fn starts(&self) -> bool {
        self.alignment.marks.first().is_some_and(|mark| mark.place == ProgramPlace::Start)
    }

    /// Returns the machine with the switches of this run.
    pub fn machine(&self, machine: &Machine) -> Machine {
        let mut machine = machine.clone();
        if let Some(ratio) = self.overrides.0 {
            machine.overrides.feed = ratio;
        }
        if let Some(ratio) = self.overrides.1 {
            machine.overrides.rapid = ratio;
        }
        machine
    }

    /// Returns `true` if the program has rapid moves.
    pub fn has_rapid(&self) -> bool {
        self.toolpath.has_rapid()
    }

    /// Returns `true` if another run has the same program and, on this machine, the same override switches.
    pub fn is_like(&self, other: &Run, machine: &Machine) -> bool {
        let switches = |run: &Run| {
            let (feed, rapid) = run.overrides;
            (feed.unwrap_or(machine.overrides.feed), rapid.unwrap_or(machine.overrides.rapid))
        };
        switches(self) == switches(other) && self.toolpath == other.toolpath
    }

    /// Returns the alignment with its stamps corrected by the rate of the recorder's clock in the machine
    /// file.
    pub fn by_clock(&self, machine: &Machine) -> Cow<'_, Alignment> {
        self.alignment.by_right_clock(machine.recorder.clock_ratio)
    }

    /// Returns the plan of the run on a machine.
    pub fn plan(&self, machine: &Machine) -> FeedPlan {
        simulate(self.toolpath, &self.machine(machine))
    }

    /// Returns the comparison of the recording with the run on a machine.
    pub fn compared(&self, machine: &Machine) -> Comparison {
        compare(self.toolpath, &self.plan(machine), self.alignment)
    }

    /// Returns the delay of the recorded machine at each mark, s.
    pub fn residuals(&self, machine: &Machine) -> Vec<f64> {
        let machine = &self.machine(machine);
        self.residuals_of(machine, &simulate(self.toolpath, machine))
    }

    /// Returns the delay at each mark, s, for a plan on the machine with the switches of this run.
    fn residuals_of(&self, machine: &Machine, plan: &FeedPlan) -> Vec<f64> {
        let mut simulated = times_at_marks(self.toolpath, machine, plan, self.alignment);
        simulated.iter_mut().for_each(|time| *time *= machine.recorder.clock_ratio);
        residuals(self.alignment, &simulated)
    }
}

/// Returns the whitened residuals of each run on a machine; consecutive runs of one program share their plan.
pub fn whitened(machine: &Machine, runs: &[Run], whitenings: &[Whitening]) -> Vec<Vec<f64>> {
    let mut last: Option<(&Run, FeedPlan)> = None;
    let each = runs.iter().zip(whitenings).map(|(run, whitening)| {
        let (before, plan) = match last.take() {
            Some((before, plan)) if before.is_like(run, machine) => (before, plan),
            _ => (run, run.plan(machine)),
        };
        let residuals = run.residuals_of(&run.machine(machine), &plan);
        last = Some((before, plan));
        whitening.apply(&residuals)
    });
    each.collect()
}

/// Returns the whitenings of parts of one run. All parts share one noise, which comes from all their residuals.
pub fn whitenings_in_common(machine: &Machine, parts: &[Run]) -> Vec<Whitening> {
    let residuals: Vec<Vec<f64>> = parts.iter().map(|part| part.residuals(machine)).collect();
    let pairs: Vec<_> = parts.iter().zip(&residuals).map(|(part, own)| (part.alignment, &own[..])).collect();
    let process_noise = Whitening::common(&pairs);
    parts.iter().map(|part| Whitening::new(part.alignment, process_noise)).collect()
}

/// Returns Σ ρ of whitened residuals.
pub fn cost<'a>(whitened: impl IntoIterator<Item = &'a f64>) -> f64 {
    whitened.into_iter().map(|value| minimise::rho(*value)).sum()
}

/// Returns the cost of a machine, which a fit minimises.
pub fn cost_of(machine: &Machine, runs: &[Run], whitenings: &[Whitening]) -> f64 {
    cost(whitened(machine, runs, whitenings).iter().flatten())
}

/// Returns the misfit of the ramps of a machine over all runs.
pub fn ramp_misfit(machine: &Machine, runs: &[Run]) -> RampMisfit {
    let windows_of = |run: &Run| {
        let (plan, alignment) = (run.plan(machine), run.by_clock(machine));
        ramp_windows(run.toolpath, &plan, machine, &alignment, &compare(run.toolpath, &plan, &alignment))
    };
    RampMisfit::of(&runs.iter().flat_map(windows_of).collect::<Vec<_>>())
}

/// Fits parameters of a machine to runs, from their initial values, until a step lowers the cost by less than
/// the part `ftol`. Calls `progress` with the completed fraction, 0 to 1.
pub fn fit(
    machine: &Machine,
    runs: &[Run],
    freed: &[FreeParameter],
    whitenings: &[Whitening],
    hardly: f64,
    progress: &mut dyn FnMut(f64),
) -> Fit {
    let found = minimise::minimise(machine, runs, freed, whitenings, hardly, progress);
    let values: Vec<f64> =
        freed.iter().zip(found.point.iter()).map(|(freed, varied)| freed.from_internal(*varied)).collect();
    let covariance = uncertainty::covariance(&found, &clocks(runs, whitenings));
    let deviations = (0..freed.len())
        .map(|at| {
            let deviation = freed[at].deviation(values[at], covariance[(at, at)].max(0.0).sqrt());
            deviation.hypot(freed[at].floor(values[at]))
        })
        .collect();
    let correlations = DMatrix::from_fn(freed.len(), freed.len(), |i, j| {
        let size = (covariance[(i, i)] * covariance[(j, j)]).sqrt();
        if i == j {
            1.0
        } else if size.is_finite() && 0.0 < size {
            covariance[(i, j)] / size
        } else {
            0.0
        }
    });
    Fit {
        machine: with(machine, freed, &values),
        values,
        deviations,
        correlations,
        cost: found.cost,
        whitened: found.residuals,
        converged: found.converged,
    }
}

/// Returns the whitened residuals that a recorder's clock with a rate error of 1 causes, run by run.
fn clocks(runs: &[Run], whitenings: &[Whitening]) -> Vec<Vec<f64>> {
    let of_run = |(run, whitening): (&Run, &Whitening)| {
        let marks = &run.alignment.marks;
        let begin = marks.first().map_or(0.0, |mark| mark.time);
        whitening.apply(&marks.iter().map(|mark| mark.time - begin).collect::<Vec<f64>>())
    };
    runs.iter().zip(whitenings).map(of_run).collect()
}

/// Returns a machine with these values of the free parameters, core units.
pub fn with(machine: &Machine, freed: &[FreeParameter], values: &[f64]) -> Machine {
    let mut machine = machine.clone();
    for (freed, value) in freed.iter().zip(values) {
        freed.apply(&mut machine, *value);
    }
    machine
}
