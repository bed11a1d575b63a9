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

/// A length in µm from one in mm.
pub fn micrometres(length: f64) -> f64 {
    length * MICROMETRES_PER_MM
}

/// A length in mm from one in µm.
pub fn mm_of_micrometres(length_micrometres: f64) -> f64 {
    length_micrometres / MICROMETRES_PER_MM
}

/// A feedrate in mm/s from one in mm/min.
pub fn mm_per_s(feedrate_mm_per_min: f64) -> f64 {
    feedrate_mm_per_min / SECONDS_PER_MINUTE
}

/// A feedrate in mm/min from one in mm/s.
pub fn mm_per_min(feedrate: f64) -> f64 {
    feedrate * SECONDS_PER_MINUTE
}

/// A torque in N·m from one in N·mm.
pub fn n_m_of_n_mm(torque: f64) -> f64 {
    torque / MM_PER_M
}

/// A torque in N·mm from one in N·m.
pub fn n_mm_of_n_m(torque_n_m: f64) -> f64 {
    torque_n_m * MM_PER_M
}

/// A modulus in N/mm² from one in GPa.
pub fn n_per_mm2_of_gpa(modulus_gpa: f64) -> f64 {
    modulus_gpa * MM_PER_M
}

/// A power in W from one in N·mm/s.
pub fn watts_of_n_mm_per_s(power: f64) -> f64 {
    power / MM_PER_M
}

/// A power in N·mm/s from one in W.
pub fn n_mm_per_s_of_watts(power_watts: f64) -> f64 {
    power_watts * MM_PER_M
}

/// The unit in which a machine parameter is written at the borders.
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
    /// The value in core units (mm, s, rad) of `value` given in this unit.
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

    /// The value in this unit of `value` given in core units.
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

    /// The symbol shown to people.
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
