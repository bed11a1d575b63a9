//! What is reported of a cause: quantities with their values, and how a sentence reads them.

/// A quantity that is reported: its key in the contract of `diagnose`, which ends with the unit, and what people read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Quantity {
    /// Its key.
    pub key: &'static str,
    /// Its name.
    pub name: &'static str,
    /// Its unit; empty for words, counts and ratios.
    pub unit: &'static str,
}

const fn quantity(key: &'static str, name: &'static str, unit: &'static str) -> Quantity {
    Quantity { key, name, unit }
}

/// A limit of acceleration, mm/s².
pub const ACCELERATION: Quantity = quantity("a_mm_s2", "acceleration", "mm/s²");
/// The angle of corners from which on something happens, °.
pub const ANGLE: Quantity = quantity("angle_deg", "angle", "°");
/// The contour tolerance along arcs, mm.
pub const ARC_TOLERANCE: Quantity = quantity("arc_tolerance_mm", "arc tolerance", "mm");
/// Where it acts, where that is not everywhere.
pub const AT: Quantity = quantity("at", "at", "");
/// The axis, or axes.
pub const AXIS: Quantity = quantity("axis", "axis", "");
/// Angles of corners between which the recording does not tell, °.
pub const BETWEEN: Quantity = quantity("between_deg", "between", "°");
/// A number of blocks.
pub const BLOCKS: Quantity = quantity("blocks", "blocks", "");
/// The word that waits.
pub const CODE: Quantity = quantity("code", "code", "");
/// The feedrate that corners are planned by.
pub const CORNERS_PLANNED_BY: Quantity = quantity("corners_planned_by", "corners planned by", "");
/// A damping ratio.
pub const DAMPING: Quantity = quantity("damping", "damping", "");
/// A number of filters.
pub const FILTERS: Quantity = quantity("filters", "filters", "");
/// A frequency, Hz.
pub const FREQUENCY: Quantity = quantity("frequency_hz", "frequency", "Hz");
/// The distance along the path from which it acts, mm.
pub const FROM_DISTANCE: Quantity = quantity("from_mm", "from", "mm");
/// The first line on which it acts.
pub const FROM_LINE: Quantity = quantity("from_line", "from line", "");
/// A limit of jerk, mm/s³.
pub const JERK: Quantity = quantity("j_mm_s3", "jerk", "mm/s³");
/// The line of the program.
pub const LINE: Quantity = quantity("line", "line", "");
/// Words that may wait instead.
pub const OR_CODE: Quantity = quantity("or_code", "or code", "");
/// The planner that takes the place of filters.
pub const PLANNER: Quantity = quantity("planner", "planner", "");
/// A rapid feedrate, mm/min.
pub const RAPID: Quantity = quantity("rapid_mm_min", "rapid", "mm/min");
/// A ratio to what is believed.
pub const RATIO: Quantity = quantity("ratio", "ratio", "");
/// A law of junctions.
pub const RULE: Quantity = quantity("rule", "rule", "");
/// A time, s.
pub const SECONDS: Quantity = quantity("seconds", "time", "s");
/// A time constant, s.
pub const TIME_CONSTANT: Quantity = quantity("time_constant_s", "time constant", "s");
/// A time constant for each filter, s.
pub const TIME_CONSTANTS: Quantity = quantity("time_constants_s", "time constants", "s");
/// A distance within which something is smoothed, mm.
pub const TOLERANCE: Quantity = quantity("tolerance_mm", "tolerance", "mm");
/// The contour tolerance, mm.
pub const CONTOUR_TOLERANCE: Quantity = quantity("contour_tolerance_mm", "contour tolerance", "mm");
/// The distance along the path up to which it acts, mm.
pub const TO_DISTANCE: Quantity = quantity("to_mm", "to", "mm");
/// The last line on which it acts.
pub const TO_LINE: Quantity = quantity("to_line", "to line", "");
/// The value of a law of junctions.
pub const VALUE: Quantity = quantity("value", "value", "");
/// A limit of velocity, mm/min.
pub const VELOCITY: Quantity = quantity("v_mm_min", "velocity", "mm/min");
/// The width of a play, mm.
pub const WIDTH: Quantity = quantity("width_mm", "width", "mm");

/// A value in the unit of its quantity.
#[derive(Clone, Debug, PartialEq)]
pub enum Reported {
    /// A number.
    Number(f64),
    /// Several.
    List(Vec<f64>),
    /// A word.
    Word(String),
}

impl Reported {
    /// A word.
    pub fn word(word: &str) -> Reported {
        Reported::Word(word.to_string())
    }
}

/// How the values of what a hypothesis frees, in core units, are reported.
pub type Report = std::sync::Arc<dyn Fn(&[f64]) -> Vec<(Quantity, Reported)> + Send + Sync>;

/// A value with its uncertainty.
#[derive(Clone, Debug, PartialEq)]
pub struct ReportedValue {
    /// Of what.
    pub quantity: Quantity,
    /// The value.
    pub value: Reported,
    /// Its standard deviation; `None` where it is not known.
    pub deviation: Option<f64>,
}

/// A named cause as a sentence reads it.
pub struct Finding<'a> {
    /// Its values.
    pub values: &'a [ReportedValue],
    /// Lines on which it acts, as ranges.
    pub lines: &'a [(u32, u32)],
    /// Time it explains, s.
    pub seconds: f64,
}

impl Finding<'_> {
    /// The value of a quantity.
    pub fn get(&self, quantity: Quantity) -> Option<&Reported> {
        self.values.iter().find(|value| value.quantity == quantity).map(|value| &value.value)
    }

    /// The number of a quantity as it is; `None` where it is not reported.
    pub fn value(&self, quantity: Quantity) -> Option<f64> {
        match self.get(quantity) {
            Some(Reported::Number(number)) => Some(*number),
            _ => None,
        }
    }

    /// A number for people: whole, or with three digits.
    pub fn number(&self, quantity: Quantity) -> String {
        match self.value(quantity) {
            Some(whole) if is_whole(whole) => (whole as i64).to_string(),
            Some(number) => three_digits(number),
            None => "?".to_string(),
        }
    }

    /// The numbers of a list for people.
    pub fn list(&self, quantity: Quantity) -> String {
        match self.get(quantity) {
            Some(Reported::List(numbers)) => {
                numbers.iter().copied().map(three_digits).collect::<Vec<_>>().join(", ")
            }
            _ => String::new(),
        }
    }

    /// The word of a quantity; empty where it is not reported.
    pub fn word(&self, quantity: Quantity) -> &str {
        match self.get(quantity) {
            Some(Reported::Word(word)) => word,
            _ => "",
        }
    }

    /// What it costs or saves, as the end of a sentence.
    pub fn costs(&self) -> String {
        match self.seconds {
            s if s.abs() < 5e-3 => String::new(),
            s if 0.0 < s => format!(", which costs {} s", three_digits(s)),
            s => format!(", which saves {} s", three_digits(-s)),
        }
    }

    /// Its lines, as a place.
    pub fn at_lines(&self) -> String {
        match self.lines {
            [] => "somewhere".to_string(),
            [(first, last)] if first == last => format!("at line {first}"),
            [(first, last)] => format!("in lines {first} to {last}"),
            [(first, _), .., (_, last)] => format!("in several places between lines {first} and {last}"),
        }
    }
}

/// Whether a reported number is written without decimals.
pub fn is_whole(number: f64) -> bool {
    number.fract() == 0.0 && number.abs() < 1e9
}

/// A number with three significant digits.
pub fn three_digits(value: f64) -> String {
    let rounded: f64 = format!("{value:.2e}").parse().unwrap_or(value);
    rounded.to_string()
}
