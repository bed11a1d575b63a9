//! Free parameters: parameters of the machine that a fit may change.
//!
//! Times, feedrates and tolerances are positive and vary by ratios, so that their logarithm is fitted; values
//! that may be zero, such as a wait or a ratio near 1, are fitted directly.

use std::sync::Arc;

use crate::machine::{Handle, Machine};

/// Interpolation cycle of a control, s: 1 to 4 ms are usual.
const INTERPOLATION_CYCLE_S: f64 = 2e-3;
/// Relative difference between a law in the model and the same law in a control: numbers are rounded, cycles
/// are whole, and two implementations of one law do not agree to the last digit. Of the values that
/// recordings of two stand-in machines determine more exactly than this, nine in ten are off by less than
/// 1.645 times this ratio.
const LAW_AGREEMENT_RATIO: f64 = 2e-3;

/// The way in which a parameter varies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VariationScale {
    /// By ratios.
    Ratio,
    /// By differences.
    Difference,
}

/// The exactness with which a machine can have a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exactness {
    /// As exactly as the model's law agrees with the control's.
    Law,
    /// A time that the control counts in cycles.
    Cycles,
    /// A time of a machine function, counted in cycles.
    Wait,
    /// Exactly, as a switch or a clock.
    Exact,
}

/// Sets a value of a machine.
type Setter = Arc<dyn Fn(&mut Machine, f64) + Send + Sync>;

/// A parameter of a machine that a fit may change.
#[derive(Clone)]
pub struct FreeParameter {
    /// Parameter.
    pub handle: Handle,
    /// Initial value, core units.
    pub start: f64,
    /// Least and largest value, core units.
    pub bounds: (f64, f64),
    /// Way in which the parameter varies.
    pub scale: VariationScale,
    /// `true` if all times are linear in the parameter, as in a wait: its derivative is constant.
    pub is_linear: bool,
    /// Exactness with which a machine can have the value.
    pub exactness: Exactness,
    /// Expected value before any run, and its standard deviation, core units; `None` if no value is expected.
    pub prior: Option<(f64, f64)>,
    set: Setter,
}

impl std::fmt::Debug for FreeParameter {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("FreeParameter")
            .field("handle", &self.handle)
            .field("start", &self.start)
            .finish_non_exhaustive()
    }
}

impl FreeParameter {
    /// Returns a free parameter for a number of the parameter table.
    pub fn new(handle: Handle, start: f64, bounds: (f64, f64), scale: VariationScale) -> FreeParameter {
        let set = move |machine: &mut Machine, value: f64| handle.set(machine, value);
        FreeParameter {
            handle,
            start: start.clamp(bounds.0, bounds.1),
            bounds,
            scale,
            is_linear: false,
            exactness: Exactness::Law,
            prior: None,
            set: Arc::new(set),
        }
    }

    /// Returns a free parameter for the time of a function of the machine, s.
    pub fn wait(handle: Handle, start: f64, bounds: (f64, f64)) -> FreeParameter {
        FreeParameter {
            exactness: Exactness::Wait,
            ..FreeParameter::new(handle, start, bounds, VariationScale::Difference)
        }
    }

    /// Replaces the setter.
    pub fn with(self, set: impl Fn(&mut Machine, f64) + Send + Sync + 'static) -> FreeParameter {
        FreeParameter { set: Arc::new(set), ..self }
    }

    /// Adds an effect to the setter.
    pub fn also(self, set: impl Fn(&mut Machine) + Send + Sync + 'static) -> FreeParameter {
        let first = Arc::clone(&self.set);
        self.with(move |machine, value| {
            first(machine, value);
            set(machine);
        })
    }

    /// Marks all times as linear in the parameter.
    pub fn linear(self) -> FreeParameter {
        FreeParameter { is_linear: true, ..self }
    }

    /// Adds an expected value with its standard deviation, core units, which count as one more observation.
    pub fn expected(self, value: f64, deviation: f64) -> FreeParameter {
        FreeParameter { prior: Some((value, deviation)), ..self }
    }

    /// Returns the distance of a value (core units) from the expected one, in standard deviations; `None` if no value is expected.
    pub fn from_expected(&self, value: f64) -> Option<f64> {
        self.prior.map(|(expected, deviation)| (value - expected) / deviation)
    }

    /// Marks the parameter as counted in cycles of the control.
    pub fn counted_in_cycles(self) -> FreeParameter {
        FreeParameter { exactness: Exactness::Cycles, ..self }
    }

    /// Returns the parameter with another initial value, core units.
    pub fn starting_at(&self, start: f64) -> FreeParameter {
        FreeParameter { start: start.clamp(self.bounds.0, self.bounds.1), ..self.clone() }
    }

    /// Sets the value (core units) of a machine, within bounds; an infinite value means no limit and is set
    /// as such.
    pub fn apply(&self, machine: &mut Machine, value: f64) {
        let within = if value.is_finite() { value.clamp(self.bounds.0, self.bounds.1) } else { value };
        (self.set)(machine, within);
    }

    /// Maps a value (core units) to the optimiser's coordinate: `ln v` for `VariationScale::Ratio`, `v` otherwise.
    pub fn to_internal(&self, value: f64) -> f64 {
        match self.scale {
            VariationScale::Ratio => value.ln(),
            VariationScale::Difference => value,
        }
    }

    /// Maps an optimiser's coordinate to a value (core units), within bounds.
    pub fn from_internal(&self, varied: f64) -> f64 {
        let value = match self.scale {
            VariationScale::Ratio => varied.exp(),
            VariationScale::Difference => varied,
        };
        value.clamp(self.bounds.0, self.bounds.1)
    }

    /// Converts a deviation of the optimiser's coordinate to one of the value, core units.
    pub fn deviation(&self, value: f64, deviation: f64) -> f64 {
        match self.scale {
            VariationScale::Ratio => value * deviation,
            VariationScale::Difference => deviation,
        }
    }

    /// Returns the least standard deviation of a value, core units, however exactly the runs determine it: a
    /// control counts times in cycles that the machine file does not contain, and no law of the model is
    /// exactly the control's. Switches and clocks are exact.
    pub fn floor(&self, value: f64) -> f64 {
        match self.exactness {
            Exactness::Cycles | Exactness::Wait => INTERPOLATION_CYCLE_S / 12f64.sqrt(),
            Exactness::Exact => 0.0,
            Exactness::Law => LAW_AGREEMENT_RATIO * value.abs(),
        }
    }

    /// Returns the step of a difference quotient in the optimiser's coordinate.
    pub fn step(&self, value: f64) -> f64 {
        match self.scale {
            VariationScale::Ratio => 0.01,
            VariationScale::Difference => {
                (0.01 * value.abs()).max(0.002 * (self.bounds.1 - self.bounds.0).min(1.0))
            }
        }
    }
}
