//! The report of a cause: quantities with their values, and their text in a sentence.

/// A reported quantity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Quantity {
    /// Key in the contract of `diagnose`, which ends with the unit.
    pub key: &'static str,
    /// Name that people read.
    pub name: &'static str,
    /// Unit; empty for words, counts and ratios.
    pub unit: &'static str,
}

impl Quantity {
    /// Returns a number of the quantity.
    pub fn number(self, number: f64) -> (Quantity, Reported) {
        (self, Reported::Number(number))
    }

    /// Returns a word for the quantity.
    pub fn word(self, word: impl ToString) -> (Quantity, Reported) {
        (self, Reported::Word(word.to_string()))
    }
}

const fn quantity(key: &'static str, name: &'static str, unit: &'static str) -> Quantity {
    Quantity { key, name, unit }
}

/// A limit of acceleration, mm/s².
pub const ACCELERATION: Quantity = quantity("a_mm_s2", "acceleration", "mm/s²");
/// The least angle of the corners on which an effect acts, °.
pub const ANGLE: Quantity = quantity("angle_deg", "angle", "°");
/// The contour tolerance along arcs, mm.
pub const ARC_TOLERANCE: Quantity = quantity("arc_tolerance_mm", "arc tolerance", "mm");
/// The place at which an effect acts, if it does not act everywhere.
pub const AT: Quantity = quantity("at", "at", "");
/// The axis, or axes.
pub const AXIS: Quantity = quantity("axis", "axis", "");
/// The bounds within which the recording leaves the least angle of corners open, °.
pub const ANGLE_BOUNDS: Quantity = quantity("between_deg", "between", "°");
/// A number of blocks.
pub const BLOCKS: Quantity = quantity("blocks", "blocks", "");
/// The word at which the machine waits.
pub const CODE: Quantity = quantity("code", "code", "");
/// The feedrate by which the control plans corners.
pub const CORNERS_PLANNED_BY: Quantity = quantity("corners_planned_by", "corners planned by", "");
/// A damping ratio.
pub const DAMPING: Quantity = quantity("damping", "damping", "");
/// A number of filters.
pub const FILTERS: Quantity = quantity("filters", "filters", "");
/// A frequency, Hz.
pub const FREQUENCY: Quantity = quantity("frequency_hz", "frequency", "Hz");
/// The distance along the path from which an effect acts, mm.
pub const FROM_DISTANCE: Quantity = quantity("from_mm", "from", "mm");
/// The first line on which an effect acts.
pub const FROM_LINE: Quantity = quantity("from_line", "from line", "");
/// A limit of jerk, mm/s³.
pub const JERK: Quantity = quantity("j_mm_s3", "jerk", "mm/s³");
/// The line of the program.
pub const LINE: Quantity = quantity("line", "line", "");
/// Words at which the machine may wait instead.
pub const OR_CODE: Quantity = quantity("or_code", "or code", "");
/// The planner that takes the place of filters.
pub const PLANNER: Quantity = quantity("planner", "planner", "");
/// A rapid feedrate, mm/min.
pub const RAPID: Quantity = quantity("rapid_mm_min", "rapid", "mm/min");
/// The ramp of the spindle, s for each 1000 rpm.
pub const RAMP: Quantity = quantity("s_per_1000_rpm", "ramp", "s/1000 rpm");
/// A ratio to the assumed value.
pub const RATIO: Quantity = quantity("ratio", "ratio", "");
/// The place of the encoder or scale whose positions were recorded, if it is known.
pub const RECORDED_AT: Quantity = quantity("recorded_at", "recorded at", "");
/// The junction law, which limits the feedrate at corners.
pub const RULE: Quantity = quantity("rule", "rule", "");
/// A time, s.
pub const SECONDS: Quantity = quantity("seconds", "time", "s");
/// A time constant, s.
pub const TIME_CONSTANT: Quantity = quantity("time_constant_s", "time constant", "s");
/// The time constant of each filter, s.
pub const TIME_CONSTANTS: Quantity = quantity("time_constants_s", "time constants", "s");
/// The distance within which the control smooths the path, mm.
pub const TOLERANCE: Quantity = quantity("tolerance_mm", "tolerance", "mm");
/// The contour tolerance, mm.
pub const CONTOUR_TOLERANCE: Quantity = quantity("contour_tolerance_mm", "contour tolerance", "mm");
/// The distance along the path up to which an effect acts, mm.
pub const TO_DISTANCE: Quantity = quantity("to_mm", "to", "mm");
/// The last line on which an effect acts.
pub const TO_LINE: Quantity = quantity("to_line", "to line", "");
/// The value of the parameter of the junction law.
pub const VALUE: Quantity = quantity("value", "value", "");
/// A limit of velocity, mm/min.
pub const VELOCITY: Quantity = quantity("v_mm_min", "velocity", "mm/min");
/// The width of the backlash, mm.
pub const WIDTH: Quantity = quantity("width_mm", "width", "mm");

/// A value in the unit of its quantity.
#[derive(Clone, Debug, PartialEq)]
pub enum Reported {
    /// A number.
    Number(f64),
    /// Several numbers.
    List(Vec<f64>),
    /// A word.
    Word(String),
}

/// A function from the values of the parameters that a hypothesis frees, in core units, to the reported quantities.
pub type Report = std::sync::Arc<dyn Fn(&[f64]) -> Vec<(Quantity, Reported)> + Send + Sync>;

/// A reported value with its uncertainty.
#[derive(Clone, Debug, PartialEq)]
pub struct ReportedValue {
    /// Quantity.
    pub quantity: Quantity,
    /// Value.
    pub value: Reported,
    /// Standard deviation; `None` if it is unknown.
    pub deviation: Option<f64>,
}

/// A named cause as its sentence reads it.
pub struct Finding<'a> {
    /// Values of the cause.
    pub values: &'a [ReportedValue],
    /// Lines on which the cause acts, as ranges.
    pub lines: &'a [(u32, u32)],
    /// Time that the cause explains, s.
    pub seconds: f64,
}

impl Finding<'_> {
    /// Returns the value of a quantity; `None` if it is not reported.
    pub fn get(&self, quantity: Quantity) -> Option<&Reported> {
        self.values.iter().find(|value| value.quantity == quantity).map(|value| &value.value)
    }

    /// Returns the number of a quantity without rounding; `None` if no number is reported for it.
    pub fn value(&self, quantity: Quantity) -> Option<f64> {
        match self.get(quantity) {
            Some(Reported::Number(number)) => Some(*number),
            _ => None,
        }
    }

    /// Returns the number of a quantity as text for people: whole, or with three significant digits; `?` if no
    /// number is reported for it.
    pub fn number(&self, quantity: Quantity) -> String {
        match self.value(quantity) {
            Some(whole) if is_whole(whole) => (whole as i64).to_string(),
            Some(number) => three_digits(number),
            None => "?".to_string(),
        }
    }

    /// Returns the numbers of a list as text for people; empty if no list is reported for the quantity.
    pub fn list(&self, quantity: Quantity) -> String {
        match self.get(quantity) {
            Some(Reported::List(numbers)) => {
                numbers.iter().copied().map(three_digits).collect::<Vec<_>>().join(", ")
            }
            _ => String::new(),
        }
    }

    /// Returns the word of a quantity; empty if no word is reported for it.
    pub fn word(&self, quantity: Quantity) -> &str {
        match self.get(quantity) {
            Some(Reported::Word(word)) => word,
            _ => "",
        }
    }

    /// Returns the end of a sentence with the time that the cause costs or saves; empty if that is less than 5 ms.
    pub fn costs(&self) -> String {
        match self.seconds {
            s if s.abs() < 5e-3 => String::new(),
            s if 0.0 < s => format!(", which costs {} s", three_digits(s)),
            s => format!(", which saves {} s", three_digits(-s)),
        }
    }

    /// Returns the lines of the cause as a place in a sentence.
    pub fn at_lines(&self) -> String {
        match self.lines {
            [] => "somewhere".to_string(),
            [(first, last)] if first == last => format!("at line {first}"),
            [(first, last)] => format!("in lines {first} to {last}"),
            [(first, _), .., (_, last)] => format!("in several places between lines {first} and {last}"),
        }
    }
}

/// Returns `true` if a reported number is written without decimals.
pub fn is_whole(number: f64) -> bool {
    number.fract() == 0.0 && number.abs() < 1e9
}

/// Returns a number as text with three significant digits.
pub fn three_digits(value: f64) -> String {
    let rounded: f64 = format!("{value:.2e}").parse().unwrap_or(value);
    rounded.to_string()
}
