//! A parameter of the machine that a fit may change.
//!
//! Times, feedrates and tolerances are positive and vary by ratios, so their logarithm is fitted; what
//! may be zero, a wait or a ratio near 1, is fitted as it is.

use std::sync::Arc;

use crate::machine::{Access, Machine, parameter};

/// A cycle of interpolation, s: controls have 1 to 4 ms.
const CYCLE: f64 = 2e-3;
/// What the law of a model and that of a control differ by where they are the same, as a part of a value: numbers are
/// rounded, cycles are whole, and two programs for one law do not agree to the last digit. Of what recordings of two
/// stand-in machines tell more exactly than that, nine values in ten are off by less than 1.645 times this.
const LAW: f64 = 2e-3;

/// How a parameter is varied.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// By ratios.
    Ratio,
    /// By differences.
    Difference,
}

/// How a value is given to a machine.
type Set = Arc<dyn Fn(&mut Machine, f64) + Send + Sync>;

/// A parameter that may be changed.
#[derive(Clone)]
pub struct Freed {
    /// Its key in the machine file; of a table with the word, as in `times.m_code_s.M8`.
    pub key: String,
    /// Value to begin with, core units.
    pub start: f64,
    /// Least and largest value, core units.
    pub bounds: (f64, f64),
    /// How it is varied.
    pub scale: Scale,
    /// Whether all times are linear in it, as in a wait: its derivative is the same everywhere.
    pub is_linear: bool,
    set: Set,
}

impl std::fmt::Debug for Freed {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Freed").field("key", &self.key).field("start", &self.start).finish_non_exhaustive()
    }
}

impl Freed {
    /// A parameter that is set by `set`.
    pub fn new(
        key: impl Into<String>,
        start: f64,
        bounds: (f64, f64),
        scale: Scale,
        set: impl Fn(&mut Machine, f64) + Send + Sync + 'static,
    ) -> Freed {
        Freed {
            key: key.into(),
            start: start.clamp(bounds.0, bounds.1),
            bounds,
            scale,
            is_linear: false,
            set: Arc::new(set),
        }
    }

    /// The same, all times being linear in it.
    pub fn linear(self) -> Freed {
        Freed { is_linear: true, ..self }
    }

    /// The same, beginning elsewhere (core units).
    pub fn from(&self, start: f64) -> Freed {
        Freed { start: start.clamp(self.bounds.0, self.bounds.1), ..self.clone() }
    }

    /// The number under a key of the machine file; none where the key is not one of a number.
    pub fn number(key: &'static str, start: f64, bounds: (f64, f64), scale: Scale) -> Option<Freed> {
        let Access::Number { set, .. } = parameter(key)?.access else { return None };
        Some(Freed::new(key, start, bounds, scale, move |machine, value| set(machine, Some(value))))
    }

    /// The value that a machine has (core units); none where it has none, or it is not under a key alone.
    pub fn of(&self, machine: &Machine) -> Option<f64> {
        let Access::Number { get, .. } = parameter(&self.key)?.access else { return None };
        get(machine)
    }

    /// Gives a machine the value (core units), within bounds; an infinite one is no limit, and is given as it is.
    pub fn apply(&self, machine: &mut Machine, value: f64) {
        let within = if value.is_finite() { value.clamp(self.bounds.0, self.bounds.1) } else { value };
        (self.set)(machine, within);
    }

    /// The value as it is varied.
    pub fn inward(&self, value: f64) -> f64 {
        match self.scale {
            Scale::Ratio => value.ln(),
            Scale::Difference => value,
        }
    }

    /// The value of what is varied, within bounds.
    pub fn outward(&self, varied: f64) -> f64 {
        let value = match self.scale {
            Scale::Ratio => varied.exp(),
            Scale::Difference => varied,
        };
        value.clamp(self.bounds.0, self.bounds.1)
    }

    /// What the value is off by (core units) when what is varied is off by `deviation`.
    pub fn deviation(&self, value: f64, deviation: f64) -> f64 {
        match self.scale {
            Scale::Ratio => value * deviation,
            Scale::Difference => deviation,
        }
    }

    /// What a value (core units) may be off by whatever the runs say, as a standard deviation: what lasts a time a control
    /// counts in cycles that nobody wrote into the machine file, and no law is that of the control to the last digit.
    /// Switches and clocks are no law.
    pub fn floor(&self, value: f64) -> f64 {
        let is_one_of = |keys: &[&str]| keys.iter().any(|key| self.key.starts_with(key));
        if is_one_of(&["halts.", "times.", "interpolator.block_time"]) {
            CYCLE / 12f64.sqrt()
        } else if is_one_of(&["override", "recorder."]) {
            0.0
        } else {
            LAW * value.abs()
        }
    }

    /// The step of a difference quotient in what is varied.
    pub fn step(&self, value: f64) -> f64 {
        match self.scale {
            Scale::Ratio => 0.01,
            Scale::Difference => (0.01 * value.abs()).max(0.002 * (self.bounds.1 - self.bounds.0).min(1.0)),
        }
    }
}
