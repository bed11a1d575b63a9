//! The library of effects: what may have been left out, as parameters of the machine to be freed.
//!
//! A hypothesis says which parameters leave their neutral values, within which bounds, and which values
//! are tried first. It has no physics of its own: what a value does is said by the simulation alone. Ids and
//! parameters are those of the contract of `diagnose`.
//!
//! | trace | ids |
//! |---|---|
//! | time along the path | limits, filters, corners, stops, overrides, block times, waits |
//! | form of the path, no time | servo lag, backlash, vibration |
//! | time of the recorder | its clock |
//!
//! Only what the program can excite is offered: a limit is tried below what the program asks for.

mod form;
mod jerk;
mod motion;
mod stops;

use crate::identification::fit::{Freed, Run};
use crate::machine::Machine;

/// What trace an effect leaves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trace {
    /// Time along the path.
    Time,
    /// The form of the path.
    Form,
}

/// A value of a cause as it is reported, in the units of its name.
#[derive(Clone, Debug, PartialEq)]
pub enum Reported {
    /// A number.
    Number(f64),
    /// Several.
    List(Vec<f64>),
    /// A word.
    Word(String),
}

/// What is reported of the values: names with the values, and with the factor by which the uncertainty of
/// a freed parameter (core units) is reported under the same name.
pub type Report = std::sync::Arc<dyn Fn(&[f64]) -> Vec<(&'static str, Reported)> + Send + Sync>;

/// An effect that may have been left out.
#[derive(Clone)]
pub struct Hypothesis {
    /// Its id.
    pub id: &'static str,
    /// Which of several of that id, for people: the axis, the rule; may be empty.
    pub variant: String,
    /// What trace it leaves.
    pub trace: Trace,
    /// The parameters it frees.
    pub freed: Vec<Freed>,
    /// The values tried first, one entry a parameter.
    pub trials: Vec<Vec<f64>>,
    /// Whether values between the trials mean anything.
    pub is_continuous: bool,
    /// How the values are reported.
    pub report: Report,
}

impl std::fmt::Debug for Hypothesis {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} {}", self.id, self.variant)
    }
}

impl Hypothesis {
    /// Its name for people.
    pub fn name(&self) -> String {
        let words = self.id.replace('_', " ");
        if self.variant.is_empty() { words } else { format!("{words} ({})", self.variant) }
    }

    /// Whether it is a limit and nothing else, by which the machine is the slower the lower it is.
    pub fn is_limit(&self) -> bool {
        self.id.ends_with("_limit") && self.freed.len() == 1
    }

    /// Whether it varies what another one fits beside its own parameter.
    pub fn is_fitted_beside(&self, other: &Hypothesis) -> bool {
        let beside = other.freed.iter().skip(1);
        beside.into_iter().any(|beside| self.freed.iter().any(|own| own.key == beside.key))
    }

    /// The machine with these values.
    pub fn machine(&self, machine: &Machine, values: &[f64]) -> Machine {
        crate::identification::fit::with(machine, &self.freed, values)
    }
}

/// The effects that the runs can excite on a machine, those that leave time along the path first.
pub fn library(machine: &Machine, runs: &[Run]) -> Vec<Hypothesis> {
    let mut all = motion::hypotheses(machine, runs);
    all.extend(jerk::hypotheses(machine, runs));
    all.extend(stops::hypotheses(machine, runs));
    all.extend(form::hypotheses(runs));
    all
}

/// Numbers from `from` to `to` in even ratios.
pub(crate) fn ratios(from: f64, to: f64, count: usize) -> Vec<f64> {
    let part = |at: usize| at as f64 / (count - 1).max(1) as f64;
    (0..count).map(|at| from * (to / from).powf(part(at))).collect()
}
