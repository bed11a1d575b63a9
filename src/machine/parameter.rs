//! One row of the table of machine parameters: a key with a label, a sentence, and access to a machine.

use std::collections::BTreeMap;

use crate::machine::Machine;
use crate::units::Unit;

/// One machine parameter as people write it.
pub struct Parameter {
    /// Key in the machine file, for example `rapid.feed_mm_min`.
    pub key: &'static str,
    /// Short name for forms.
    pub label: &'static str,
    /// What it does, one sentence.
    pub doc: &'static str,
    /// Its kind, and how to reach it in a machine.
    pub access: Access,
}

/// How a parameter is read from a machine and written to it. Numbers are in core units.
pub enum Access {
    /// A number within bounds.
    Number {
        /// Unit at the borders.
        unit: Unit,
        /// Least value allowed, in that unit.
        min: f64,
        /// Largest value allowed, in that unit.
        max: f64,
        /// Only whole numbers.
        whole: bool,
        /// Its value; none where the machine does not have it.
        get: fn(&Machine) -> Option<f64>,
        /// Gives it a value; none takes it back to neutral.
        set: fn(&mut Machine, Option<f64>),
    },
    /// A list of numbers within bounds, as [`Access::Number`].
    List {
        /// Unit at the borders.
        unit: Unit,
        /// Least value allowed, in that unit.
        min: f64,
        /// Largest value allowed, in that unit.
        max: f64,
        /// Only whole numbers.
        whole: bool,
        /// How many values there can be.
        most: usize,
        /// Its values; none where the machine does not have them.
        get: fn(&Machine) -> Option<Vec<f64>>,
        /// Gives it values.
        set: fn(&mut Machine, Vec<f64>),
    },
    /// One word of several.
    Choice {
        /// The words.
        words: &'static [&'static str],
        /// The word it has.
        get: fn(&Machine) -> &'static str,
        /// Gives it one of the words.
        set: fn(&mut Machine, &str),
    },
    /// Yes or no.
    Flag {
        /// Whether it is set.
        get: fn(&Machine) -> bool,
        /// Sets it.
        set: fn(&mut Machine, bool),
    },
    /// Any text.
    Text {
        /// The text.
        get: fn(&Machine) -> &str,
        /// Gives it a text.
        set: fn(&mut Machine, &str),
    },
    /// A table of numbers by word, for example `M8 = 3.0`.
    Codes {
        /// The letter of the words.
        letter: char,
        /// Unit at the borders and inside.
        unit: Unit,
        /// Least value allowed.
        min: f64,
        /// Largest value allowed.
        max: f64,
        /// The values by number.
        get: fn(&Machine) -> &BTreeMap<u32, f64>,
        /// The same, to be changed.
        get_mut: fn(&mut Machine) -> &mut BTreeMap<u32, f64>,
    },
    /// The tool table: diameters in mm by tool number.
    Tools,
}

/// An infinite limit is written by leaving the key out.
pub(in crate::machine) fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

pub(in crate::machine) const fn number(
    unit: Unit,
    (min, max): (f64, f64),
    get: fn(&Machine) -> Option<f64>,
    set: fn(&mut Machine, Option<f64>),
) -> Access {
    Access::Number { unit, min, max, whole: false, get, set }
}

pub(in crate::machine) const fn whole(
    (min, max): (f64, f64),
    get: fn(&Machine) -> Option<f64>,
    set: fn(&mut Machine, Option<f64>),
) -> Access {
    Access::Number { unit: Unit::Number, min, max, whole: true, get, set }
}

/// Bounds of jerks, and of contour tolerances.
pub(in crate::machine) const JERK_MM_S3: (f64, f64) = (1.0, 1e9);
pub(in crate::machine) const TOLERANCE_MM: (f64, f64) = (1e-6, 10.0);
