//! Machine, runs and freed parameters → [`Fit`]: the values at which the simulation is closest.
//!
//! The whole simulation is run again for every value that is tried; what is minimised is
//!
//! ```text
//! Σ_runs Σ_k ρ(ν_k),    ρ(ν) = ν² for |ν| ≤ c, then 2 c |ν| − c²
//! ```
//!
//! over the whitened residuals ν of `whitened`, so that a wait that nobody explained does not bend
//! everything else (Huber 1964). The method is Levenberg's and Marquardt's with difference quotients, a
//! parameter at its bound standing still.
//!
//! Uncertainties are those of `uncertainty`: neighbours may be related, and more samples of the same motion make
//! nothing more certain.

mod freed;
mod golden_section;
mod information;
mod left_out;
pub mod levenberg_marquardt;
mod minimise;
mod recorded;
mod uncertainty;
mod whitened;

use std::borrow::Cow;

use nalgebra::DMatrix;

pub use freed::{Exactness, Freed, Scale};
pub use golden_section::golden_section;
pub use information::inverse;
pub use left_out::{LeftOut, left_out};
pub use recorded::{Recorded, RecordedError};
pub use uncertainty::dispersion;
pub use whitened::Whitening;

use crate::identification::alignment::{Alignment, Place, times_at_marks};
use crate::identification::comparison::residuals;
use crate::machine::Machine;
use crate::simulation::feed::FeedPlan;
use crate::simulation::simulate;
use crate::simulation::toolpath::{Motion, Toolpath};

/// The part of the cost that is hardly worth a step.
pub const HARDLY: f64 = 1e-4;

/// A program with the recording of one of its runs.
#[derive(Clone)]
pub struct Run<'a> {
    /// The program.
    pub toolpath: &'a Toolpath,
    /// The recording on it.
    pub alignment: &'a Alignment,
    /// Override switches that the recording itself shows, as ratios of feed and rapid.
    pub overrides: (Option<f64>, Option<f64>),
}

/// Where a fit ended.
#[derive(Clone, Debug)]
pub struct Fit {
    /// The machine with the values found.
    pub machine: Machine,
    /// The values, core units, in the order of what was freed.
    pub values: Vec<f64>,
    /// Their standard deviations, core units; infinite where the runs say nothing of one.
    pub deviations: Vec<f64>,
    /// How they depend on each other; 1 on the diagonal.
    pub correlations: DMatrix<f64>,
    /// What is left, Σ ρ.
    pub cost: f64,
    /// The whitened residuals of each run.
    pub whitened: Vec<Vec<f64>>,
    /// Whether it came to its end.
    pub converged: bool,
}

impl Run<'_> {
    /// Whether the start of the program was recorded.
    pub fn starts(&self) -> bool {
        self.alignment.marks.first().is_some_and(|mark| mark.place == Place::Start)
    }

    /// The machine as it was set in this run.
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

    /// Whether the program has rapid moves.
    pub fn has_rapid(&self) -> bool {
        self.toolpath.segments.iter().any(|segment| segment.motion == Motion::Rapid)
    }

    /// Whether another run is of the same program on a machine that is set alike.
    pub fn is_like(&self, other: &Run, machine: &Machine) -> bool {
        let switches = |run: &Run| {
            let (feed, rapid) = run.overrides;
            (feed.unwrap_or(machine.overrides.feed), rapid.unwrap_or(machine.overrides.rapid))
        };
        switches(self) == switches(other) && self.toolpath == other.toolpath
    }

    /// Where the machine was by a clock that is right, if the recorder's is the one that the machine file says.
    pub fn by_clock(&self, machine: &Machine) -> Cow<'_, Alignment> {
        self.alignment.by_right_clock(machine.recorder.clock_ratio)
    }

    /// The plan of the run on a machine.
    pub fn plan(&self, machine: &Machine) -> FeedPlan {
        simulate(self.toolpath, &self.machine(machine))
    }

    /// By how much the recorded machine is later at each mark, s.
    pub fn residuals(&self, machine: &Machine) -> Vec<f64> {
        let machine = &self.machine(machine);
        self.residuals_of(machine, &simulate(self.toolpath, machine))
    }

    /// The same of a plan on the machine as it was set.
    fn residuals_of(&self, machine: &Machine, plan: &FeedPlan) -> Vec<f64> {
        let mut simulated = times_at_marks(self.toolpath, machine, plan, self.alignment);
        simulated.iter_mut().for_each(|time| *time *= machine.recorder.clock_ratio);
        residuals(self.alignment, &simulated)
    }
}

/// The whitened residuals of each run on a machine; runs of one program one after another share their plan.
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

/// Σ ρ of whitened residuals.
pub fn cost<'a>(whitened: impl IntoIterator<Item = &'a f64>) -> f64 {
    whitened.into_iter().map(|value| minimise::rho(*value)).sum()
}

/// The cost of a machine: what is minimised.
pub fn cost_of(machine: &Machine, runs: &[Run], whitenings: &[Whitening]) -> f64 {
    cost(whitened(machine, runs, whitenings).iter().flatten())
}

/// Fits parameters of a machine to runs, from the values they begin with, until a step gains less than the
/// part `hardly` of the cost. `progress` is told the part that is done.
pub fn fit(
    machine: &Machine,
    runs: &[Run],
    freed: &[Freed],
    whitenings: &[Whitening],
    hardly: f64,
    progress: &mut dyn FnMut(f64),
) -> Fit {
    let found = minimise::minimise(machine, runs, freed, whitenings, hardly, progress);
    let values: Vec<f64> =
        freed.iter().zip(found.point.iter()).map(|(freed, varied)| freed.outward(*varied)).collect();
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

/// What a recorder's clock that is off leaves of each run, whitened, for a rate that is off by 1.
fn clocks(runs: &[Run], whitenings: &[Whitening]) -> Vec<Vec<f64>> {
    let of_run = |(run, whitening): (&Run, &Whitening)| {
        let marks = &run.alignment.marks;
        let begin = marks.first().map_or(0.0, |mark| mark.time);
        whitening.apply(&marks.iter().map(|mark| mark.time - begin).collect::<Vec<f64>>())
    };
    runs.iter().zip(whitenings).map(of_run).collect()
}

/// A machine with these values of what is freed, core units.
pub fn with(machine: &Machine, freed: &[Freed], values: &[f64]) -> Machine {
    let mut machine = machine.clone();
    for (freed, value) in freed.iter().zip(values) {
        freed.apply(&mut machine, *value);
    }
    machine
}
