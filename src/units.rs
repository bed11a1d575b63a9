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
//! Borders are G-code words, the machine file, the command line's output and the page. The page can show
//! lengths in inches ([`LengthUnit`]); all other borders have the units of the table.

/// Millimetres in an inch, exact by definition.
pub const MM_PER_INCH: f64 = 25.4;

/// Thousandths of an inch (thou) in an inch.
const THOU_PER_INCH: f64 = 1000.0;

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

/// Converts thousandths of an inch to mm.
pub fn mm_of_thou(length_thou: f64) -> f64 {
    length_thou * MM_PER_INCH / THOU_PER_INCH
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

/// The unit in which the page shows lengths and feedrates; files, forms and documents have their own units.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LengthUnit {
    /// Millimetres, and micrometres for tolerances and errors.
    #[default]
    Millimetre,
    /// Inches, for tolerances and errors too.
    Inch,
}

impl LengthUnit {
    /// All units by their word.
    pub const WORDS: [(&'static str, LengthUnit); 2] =
        [("metric", LengthUnit::Millimetre), ("inch", LengthUnit::Inch)];

    /// Returns the unit of a word; `None` for other words.
    pub fn from_word(word: &str) -> Option<LengthUnit> {
        LengthUnit::WORDS.into_iter().find(|(own, _)| *own == word).map(|(_, unit)| unit)
    }

    /// Returns the length of the unit, mm.
    pub fn in_mm(self) -> f64 {
        match self {
            LengthUnit::Millimetre => 1.0,
            LengthUnit::Inch => MM_PER_INCH,
        }
    }

    /// Converts mm to this unit.
    pub fn from_mm(self, length: f64) -> f64 {
        length / self.in_mm()
    }

    /// Converts this unit to mm.
    pub fn to_mm(self, length: f64) -> f64 {
        length * self.in_mm()
    }

    /// Converts mm/s to this unit per minute.
    pub fn feedrate(self, feedrate: f64) -> f64 {
        self.from_mm(mm_per_min(feedrate))
    }

    /// Converts mm to the unit of tolerances and errors.
    pub fn fine(self, length: f64) -> f64 {
        match self {
            LengthUnit::Millimetre => micrometres(length),
            LengthUnit::Inch => self.from_mm(length),
        }
    }

    /// Converts the unit of tolerances and errors to mm.
    pub fn mm_of_fine(self, length: f64) -> f64 {
        match self {
            LengthUnit::Millimetre => mm_of_micrometres(length),
            LengthUnit::Inch => self.to_mm(length),
        }
    }

    /// Returns the symbol of lengths.
    pub fn symbol(self) -> &'static str {
        match self {
            LengthUnit::Millimetre => "mm",
            LengthUnit::Inch => "in",
        }
    }

    /// Returns the symbol of feedrates.
    pub fn feed_symbol(self) -> &'static str {
        match self {
            LengthUnit::Millimetre => "mm/min",
            LengthUnit::Inch => "in/min",
        }
    }

    /// Returns the symbol of tolerances and errors.
    pub fn fine_symbol(self) -> &'static str {
        match self {
            LengthUnit::Millimetre => "µm",
            LengthUnit::Inch => "in",
        }
    }

    /// Returns the decimals of lengths: about a hundredth of a millimetre.
    pub fn decimals(self) -> usize {
        match self {
            LengthUnit::Millimetre => 2,
            LengthUnit::Inch => 3,
        }
    }

    /// Returns the decimals of feedrates.
    pub fn feed_decimals(self) -> usize {
        match self {
            LengthUnit::Millimetre => 0,
            LengthUnit::Inch => 1,
        }
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn millimetres_are_shown_bit_for_bit() {
        let unit = LengthUnit::default();
        for length in [0.0, 0.1, 1.0 / 3.0, 12_345.678] {
            assert_eq!((unit.from_mm(length), unit.to_mm(length)), (length, length));
            assert_eq!((unit.feedrate(length), unit.fine(length)), (mm_per_min(length), micrometres(length)));
        }
    }

    #[test]
    fn an_inch_is_25_4_mm() {
        let unit = LengthUnit::from_word("inch").expect("a word of a unit");
        assert_eq!((unit.from_mm(50.8), unit.to_mm(2.0), unit.fine(0.254)), (2.0, 50.8, 0.01));
        // 2540 mm/min.
        assert!((unit.feedrate(mm_per_s(2540.0)) - 100.0).abs() < 1e-12);
        assert_eq!((unit.mm_of_fine(0.01), LengthUnit::Millimetre.mm_of_fine(10.0)), (0.254, 0.01));
        assert!((mm_of_thou(1.0) - 0.0254).abs() < 1e-15);
        assert_eq!(LengthUnit::from_word("cubit"), None);
    }
}
