//! A row of the parameter table: a key with a label, a sentence, and access to a machine.

use std::collections::BTreeMap;

use crate::machine::Machine;
use crate::units::Unit;

/// The description of a machine parameter for files and forms.
pub struct Parameter {
    /// Key in the machine file, for example `rapid.feed_mm_min`.
    pub key: &'static str,
    /// Short name for forms.
    pub label: &'static str,
    /// One sentence on the effect of the parameter.
    pub doc: &'static str,
    /// Type and access.
    pub access: Access,
}

/// Type and access of a parameter. Numbers are in core units.
pub enum Access {
    /// A number within bounds.
    Number {
        /// Unit in files and forms.
        unit: Unit,
        /// Least value allowed, in that unit.
        min: f64,
        /// Largest value allowed, in that unit.
        max: f64,
        /// `true` for whole numbers.
        whole: bool,
        /// Returns the value; `None` if the machine has none.
        get: fn(&Machine) -> Option<f64>,
        /// Sets the value; `None` restores the neutral one.
        set: fn(&mut Machine, Option<f64>),
    },
    /// A list of numbers within bounds, as [`Access::Number`].
    List {
        /// Unit in files and forms.
        unit: Unit,
        /// Least value allowed, in that unit.
        min: f64,
        /// Largest value allowed, in that unit.
        max: f64,
        /// `true` for whole numbers.
        whole: bool,
        /// Largest number of values.
        most: usize,
        /// Returns the values; `None` if the machine has none.
        get: fn(&Machine) -> Option<Vec<f64>>,
        /// Sets the values.
        set: fn(&mut Machine, Vec<f64>),
    },
    /// One of several keywords.
    Choice {
        /// Keywords.
        words: &'static [&'static str],
        /// Returns the current keyword.
        get: fn(&Machine) -> &'static str,
        /// Sets a keyword.
        set: fn(&mut Machine, &str),
    },
    /// Yes or no.
    Flag {
        /// Returns the value.
        get: fn(&Machine) -> bool,
        /// Sets the value.
        set: fn(&mut Machine, bool),
    },
    /// Any text.
    Text {
        /// Returns the text.
        get: fn(&Machine) -> &str,
        /// Sets the text.
        set: fn(&mut Machine, &str),
    },
    /// A table of numbers by word, for example `M8 = 3.0`.
    Codes {
        /// The letter of the words.
        letter: char,
        /// Unit, in files as in the core.
        unit: Unit,
        /// Least value allowed.
        min: f64,
        /// Largest value allowed.
        max: f64,
        /// Returns the values by number.
        get: fn(&Machine) -> &BTreeMap<u32, f64>,
        /// Returns the values by number, mutably.
        get_mut: fn(&mut Machine) -> &mut BTreeMap<u32, f64>,
    },
    /// The tool table: diameters in mm by tool number.
    Tools,
}

/// Returns the written form of a limit; `None`, a missing key, means infinity.
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

/// Returns the access to a list of at most `most` numbers.
pub(in crate::machine) const fn list(
    unit: Unit,
    (min, max): (f64, f64),
    most: usize,
    get: fn(&Machine) -> Option<Vec<f64>>,
    set: fn(&mut Machine, Vec<f64>),
) -> Access {
    Access::List { unit, min, max, whole: false, most, get, set }
}

/// Returns the access to a list of at most `most` whole numbers.
pub(in crate::machine) const fn whole_list(
    (min, max): (f64, f64),
    most: usize,
    get: fn(&Machine) -> Option<Vec<f64>>,
    set: fn(&mut Machine, Vec<f64>),
) -> Access {
    Access::List { unit: Unit::Number, min, max, whole: true, most, get, set }
}

/// Returns the access to a table of numbers by word.
pub(in crate::machine) const fn codes(
    letter: char,
    unit: Unit,
    (min, max): (f64, f64),
    get: fn(&Machine) -> &BTreeMap<u32, f64>,
    get_mut: fn(&mut Machine) -> &mut BTreeMap<u32, f64>,
) -> Access {
    Access::Codes { letter, unit, min, max, get, get_mut }
}

/// Bounds of the number of an M-code.
pub(in crate::machine) const WORD_BOUNDS: (f64, f64) = (0.0, 9999.0);
/// Largest number of M-codes in a group.
pub(in crate::machine) const MAX_WORDS: usize = 20;

/// Returns the numbers of M-codes as a list.
pub(in crate::machine) fn written_words(words: &[u32]) -> Vec<f64> {
    words.iter().map(|word| f64::from(*word)).collect()
}

/// Returns the M-codes with these numbers.
pub(in crate::machine) fn read_words(numbers: Vec<f64>) -> Vec<u32> {
    numbers.into_iter().map(|number| number as u32).collect()
}

/// Bounds of jerks.
pub(in crate::machine) const JERK_BOUNDS_MM_S3: (f64, f64) = (1.0, 1e9);
pub(in crate::machine) const TOLERANCE_BOUNDS_MM: (f64, f64) = (1e-6, 10.0);

/// A row of the table: key, label, access, sentence on its effect.
///
/// These words describe a parameter that is one field of the machine; unit and bounds are as in files and forms:
///
/// | word | the field |
/// |---|---|
/// | `optional` | may be missing |
/// | `limit` | is infinite when neutral |
/// | `value` … `or` | has the neutral value behind `or` |
/// | `case` … `of` … `else` | is an enum; the parameter is the value of one variant, and the last one is neutral |
/// | `extent` | is the extent of some values |
/// | `axes` | has a value for each of X, Y and Z, or is missing |
/// | `words` | is a group of M-codes |
/// | `codes` | is a table by the number of a word |
/// | `choice` | is an enum with keywords |
/// | `flag` | is true or false |
///
/// Without a word, functions read and set the parameter: of a number, with a unit, or of the given access.
macro_rules! row {
    ($key:expr, $label:expr, optional $unit:ident $bounds:tt [$($field:tt)+], $doc:expr) => {
        row!($key, $label, $unit $bounds, |m| m.$($field)+, |m, v| m.$($field)+ = v, $doc)
    };
    ($key:expr, $label:expr, limit $unit:ident $bounds:tt [$($field:tt)+], $doc:expr) => {
        row!($key, $label, $unit $bounds, |m| $crate::machine::parameter::finite(m.$($field)+),
            |m, v| m.$($field)+ = v.unwrap_or(f64::INFINITY), $doc)
    };
    ($key:expr, $label:expr, value $unit:ident $bounds:tt [$($field:tt)+] or $neutral:expr, $doc:expr) => {
        row!($key, $label, $unit $bounds, |m| Some(m.$($field)+), |m, v| m.$($field)+ = v.unwrap_or($neutral), $doc)
    };
    ($key:expr, $label:expr, case $unit:ident $bounds:tt [$($field:tt)+] of $variant:path, else $neutral:path, $doc:expr) => {
        row!($key, $label, $unit $bounds,
            |m| match m.$($field)+ {
                $variant(value) => Some(value),
                _ => None,
            },
            |m, v| match (v, m.$($field)+) {
                (Some(value), _) => m.$($field)+ = $variant(value),
                (None, $variant(_)) => m.$($field)+ = $neutral,
                _ => (),
            },
            $doc)
    };
    ($key:expr, $label:expr, extent $unit:ident $bounds:tt [$($field:tt)+], $doc:expr) => {
        row!($key, $label, $crate::machine::parameter::list(
            $crate::units::Unit::$unit,
            $bounds,
            2,
            |m| m.$($field)+.0.map(|(least, largest)| vec![least, largest]),
            |m, v| m.$($field)+ = $crate::machine::Extent::of(&v),
        ), $doc)
    };
    ($key:expr, $label:expr, axes $unit:ident $bounds:tt [$($field:tt)+], $doc:expr) => {
        row!($key, $label, $crate::machine::parameter::list(
            $crate::units::Unit::$unit,
            $bounds,
            3,
            |m| m.$($field)+.map(|axes| axes.to_vec()),
            |m, v| m.$($field)+ = v.try_into().ok(),
        ), $doc)
    };
    ($key:expr, $label:expr, words [$($field:tt)+], $doc:expr) => {
        row!($key, $label, $crate::machine::parameter::whole_list(
            $crate::machine::parameter::WORD_BOUNDS,
            $crate::machine::parameter::MAX_WORDS,
            |m| Some($crate::machine::parameter::written_words(&m.$($field)+)),
            |m, v| m.$($field)+ = $crate::machine::parameter::read_words(v),
        ), $doc)
    };
    ($key:expr, $label:expr, codes $letter:literal $unit:ident $bounds:tt [$($field:tt)+], $doc:expr) => {
        row!($key, $label, $crate::machine::parameter::codes(
            $letter,
            $crate::units::Unit::$unit,
            $bounds,
            |m| &m.$($field)+,
            |m| &mut m.$($field)+,
        ), $doc)
    };
    ($key:expr, $label:expr, choice $choice:ident [$($field:tt)+], $doc:expr) => {
        row!($key, $label, $crate::machine::parameter::Access::Choice {
            words: &const { $crate::machine::keyword::keywords(&$choice::WORDS) },
            get: |m| m.$($field)+.word(),
            set: |m, v| {
                if let Some(choice) = $crate::machine::keyword::variant_of(&$choice::WORDS, v) {
                    m.$($field)+ = choice;
                }
            },
        }, $doc)
    };
    ($key:expr, $label:expr, flag [$($field:tt)+], $doc:expr) => {
        row!($key, $label, $crate::machine::parameter::Access::Flag {
            get: |m| m.$($field)+,
            set: |m, v| m.$($field)+ = v,
        }, $doc)
    };
    ($key:expr, $label:expr, $unit:ident $bounds:tt, $get:expr, $set:expr, $doc:expr) => {
        row!($key, $label, $crate::machine::parameter::number($crate::units::Unit::$unit, $bounds, $get, $set), $doc)
    };
    ($key:expr, $label:expr, $access:expr, $doc:expr) => {
        $crate::machine::parameter::Parameter { key: $key, label: $label, doc: $doc, access: $access }
    };
}
pub(in crate::machine) use row;
