//! A parameter of the machine that a fit may change.
//!
//! Times, feedrates and tolerances are positive and vary by ratios, so their logarithm is fitted; what
//! may be zero, a wait or a ratio near 1, is fitted as it is.

use std::sync::Arc;

use crate::machine::{Handle, Machine};

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

/// How exactly a machine can have a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exactness {
    /// As exactly as the law of the model is that of the control.
    Law,
    /// A time that the control counts in cycles.
    Cycles,
    /// A time that a function takes, counted in cycles.
    Wait,
    /// As a switch is set, or a clock runs.
    Exact,
}

/// How a value is given to a machine.
type Set = Arc<dyn Fn(&mut Machine, f64) + Send + Sync>;

/// A parameter of a machine that a fit may change.
#[derive(Clone)]
pub struct Freed {
    /// The parameter.
    pub handle: Handle,
    /// Value to begin with, core units.
    pub start: f64,
    /// Least and largest value, core units.
    pub bounds: (f64, f64),
    /// How it is varied.
    pub scale: Scale,
    /// Whether all times are linear in it, as in a wait: its derivative is the same everywhere.
    pub is_linear: bool,
    /// How exactly a machine can have it.
    pub exactness: Exactness,
    set: Set,
}

impl std::fmt::Debug for Freed {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Freed")
            .field("handle", &self.handle)
            .field("start", &self.start)
            .finish_non_exhaustive()
    }
}

impl Freed {
    /// A number in the table of parameters.
    pub fn new(handle: Handle, start: f64, bounds: (f64, f64), scale: Scale) -> Freed {
        let set = move |machine: &mut Machine, value: f64| handle.set(machine, value);
        Freed {
            handle,
            start: start.clamp(bounds.0, bounds.1),
            bounds,
            scale,
            is_linear: false,
            exactness: Exactness::Law,
            set: Arc::new(set),
        }
    }

    /// A time that a function of the machine takes.
    pub fn wait(handle: Handle, start: f64, bounds: (f64, f64)) -> Freed {
        Freed { exactness: Exactness::Wait, ..Freed::new(handle, start, bounds, Scale::Difference) }
    }

    /// Replaces what giving a value does to a machine.
    pub fn with(self, set: impl Fn(&mut Machine, f64) + Send + Sync + 'static) -> Freed {
        Freed { set: Arc::new(set), ..self }
    }

    /// Also does this to a machine that is given a value.
    pub fn also(self, set: impl Fn(&mut Machine) + Send + Sync + 'static) -> Freed {
        let first = Arc::clone(&self.set);
        self.with(move |machine, value| {
            first(machine, value);
            set(machine);
        })
    }

    /// Marks all times as linear in the parameter.
    pub fn linear(self) -> Freed {
        Freed { is_linear: true, ..self }
    }

    /// Marks the parameter as counted in cycles of the control.
    pub fn counted_in_cycles(self) -> Freed {
        Freed { exactness: Exactness::Cycles, ..self }
    }

    /// Marks the parameter as the setting of a switch or a clock.
    pub fn exact(self) -> Freed {
        Freed { exactness: Exactness::Exact, ..self }
    }

    /// Moves the value to begin with, core units.
    pub fn starting_at(&self, start: f64) -> Freed {
        Freed { start: start.clamp(self.bounds.0, self.bounds.1), ..self.clone() }
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
        match self.exactness {
            Exactness::Cycles | Exactness::Wait => CYCLE / 12f64.sqrt(),
            Exactness::Exact => 0.0,
            Exactness::Law => LAW * value.abs(),
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
