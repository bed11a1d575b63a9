//! The one place where units are converted: the core computes in mm, s and rad.
//!
//! | quantity     | core   | at the borders        |
//! |--------------|--------|-----------------------|
//! | length       | mm     | mm, µm, inch          |
//! | time         | s      | s, ms                 |
//! | feedrate     | mm/s   | mm/min, inch/min      |
//! | acceleration | mm/s²  | mm/s²                 |
//! | jerk         | mm/s³  | mm/s³                 |
//! | angle        | rad    | degree                |
//! | turning rate | rad/s  | degree/min            |
//! | force        | N      | N                     |
//! | torque       | N·mm   | N·m                   |
//! | power        | N·mm/s | W                     |
//! | modulus      | N/mm²  | GPa                   |
//!
//! Borders are G-code words, the machine file, the command line's output and the page.

/// Millimetres in an inch, exact by definition.
pub const MM_PER_INCH: f64 = 25.4;

/// Millimetres in a metre.
const MM_PER_M: f64 = 1000.0;

/// Seconds in a minute.
pub const SECONDS_PER_MINUTE: f64 = 60.0;

/// Minutes in an hour.
pub const MINUTES_PER_HOUR: f64 = 60.0;

/// Seconds in an hour.
pub const SECONDS_PER_HOUR: f64 = MINUTES_PER_HOUR * SECONDS_PER_MINUTE;

/// Hundredths in a whole.
pub const PERCENT: f64 = 100.0;

/// Micrometres in a millimetre.
const MICROMETRES_PER_MM: f64 = 1000.0;

/// Converts mm to µm.
pub fn micrometres(length: f64) -> f64 {
    length * MICROMETRES_PER_MM
}

/// Converts µm to mm.
pub fn mm_of_micrometres(length_micrometres: f64) -> f64 {
    length_micrometres / MICROMETRES_PER_MM
}

/// Converts mm/min to mm/s.
pub fn mm_per_s(feedrate_mm_per_min: f64) -> f64 {
    feedrate_mm_per_min / SECONDS_PER_MINUTE
}

/// Converts mm/s to mm/min.
pub fn mm_per_min(feedrate: f64) -> f64 {
    feedrate * SECONDS_PER_MINUTE
}

/// Converts N·mm to N·m.
pub fn n_m_of_n_mm(torque: f64) -> f64 {
    torque / MM_PER_M
}

/// Converts N·m to N·mm.
pub fn n_mm_of_n_m(torque_n_m: f64) -> f64 {
    torque_n_m * MM_PER_M
}

/// Converts GPa to N/mm².
pub fn n_per_mm2_of_gpa(modulus_gpa: f64) -> f64 {
    modulus_gpa * MM_PER_M
}

/// Converts N·mm/s to W.
pub fn watts_of_n_mm_per_s(power: f64) -> f64 {
    power / MM_PER_M
}

/// Converts W to N·mm/s.
pub fn n_mm_per_s_of_watts(power_watts: f64) -> f64 {
    power_watts * MM_PER_M
}

/// The unit of a machine parameter in files and forms.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// A pure number.
    Number,
    /// Millimetre.
    Millimetre,
    /// Second.
    Second,
    /// Millimetre per minute.
    MillimetrePerMinute,
    /// Millimetre per second squared.
    MillimetrePerSecond2,
    /// Millimetre per second cubed.
    MillimetrePerSecond3,
    /// Degree of angle.
    Degree,
    /// Degree of angle per minute.
    DegreePerMinute,
    /// Cycles per second.
    Hertz,
    /// Second for each 1000 revolutions per minute.
    SecondPerThousandRpm,
    /// Minute.
    Minute,
    /// Hundredth.
    Percent,
    /// Per hour, as rates of money.
    PerHour,
}

impl Unit {
    /// Converts `value` from this unit to core units (mm, s, rad).
    pub fn to_core(self, value: f64) -> f64 {
        match self {
            Unit::MillimetrePerMinute => mm_per_s(value),
            Unit::Degree => value.to_radians(),
            Unit::DegreePerMinute => value.to_radians() / SECONDS_PER_MINUTE,
            Unit::SecondPerThousandRpm => value / 1000.0,
            Unit::Minute => value * SECONDS_PER_MINUTE,
            Unit::Percent => value / PERCENT,
            Unit::PerHour => value / SECONDS_PER_HOUR,
            _ => value,
        }
    }

    /// Converts `value` from core units to this unit.
    pub fn from_core(self, value: f64) -> f64 {
        match self {
            Unit::MillimetrePerMinute => mm_per_min(value),
            Unit::Degree => value.to_degrees(),
            Unit::DegreePerMinute => (value * SECONDS_PER_MINUTE).to_degrees(),
            Unit::SecondPerThousandRpm => value * 1000.0,
            Unit::Minute => value / SECONDS_PER_MINUTE,
            Unit::Percent => value * PERCENT,
            Unit::PerHour => value * SECONDS_PER_HOUR,
            _ => value,
        }
    }

    /// Returns the symbol for people.
    pub fn symbol(self) -> &'static str {
        match self {
            Unit::Number => "",
            Unit::Millimetre => "mm",
            Unit::Second => "s",
            Unit::MillimetrePerMinute => "mm/min",
            Unit::MillimetrePerSecond2 => "mm/s²",
            Unit::MillimetrePerSecond3 => "mm/s³",
            Unit::Degree => "°",
            Unit::DegreePerMinute => "°/min",
            Unit::Hertz => "Hz",
            Unit::SecondPerThousandRpm => "s per 1000 rpm",
            Unit::Minute => "min",
            Unit::Percent => "%",
            Unit::PerHour => "per h",
        }
    }
}
