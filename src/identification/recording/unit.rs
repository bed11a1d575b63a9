//! The units of logs, stated in names (`feed_mm_min`), in brackets (`Time [ms]`) or in a separate row, and
//! their conversion to core units:
//!
//! ```text
//! value in core units = factor · value in the file      (s, mm, mm/s, rad, rad/s, ratio)
//! ```
//!
//! Without a stated unit a value remains as in the file and carries its possible units; the unit check
//! selects one. Not read: temperatures, loads, accelerations.

use std::f64::consts::{PI, TAU};

use crate::units::{MM_PER_INCH, SECONDS_PER_MINUTE};

/// The dimension of a unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dimension {
    /// Time; core unit s.
    Time,
    /// Length; core unit mm.
    Length,
    /// Speed along a path; core unit mm/s.
    Feed,
    /// Speed of a spindle; core unit rad/s.
    Rotation,
    /// Angle; core unit rad.
    Angle,
    /// Part of a nominal value; core unit 1.
    Ratio,
}

/// A unit of values in a log.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LogUnit {
    /// Symbol.
    pub symbol: &'static str,
    /// Dimension.
    pub dimension: Dimension,
    /// Number of core units in one unit.
    pub factor: f64,
}

const fn unit(symbol: &'static str, dimension: Dimension, factor: f64) -> LogUnit {
    LogUnit { symbol, dimension, factor }
}

/// Millimetre.
pub const MM: LogUnit = unit("mm", Dimension::Length, 1.0);
/// Inch.
pub const INCH: LogUnit = unit("inch", Dimension::Length, MM_PER_INCH);
/// Micrometre.
pub const MICROMETRE: LogUnit = unit("µm", Dimension::Length, 1e-3);
/// Metre.
pub const METRE: LogUnit = unit("m", Dimension::Length, 1e3);
/// Second.
pub const SECOND: LogUnit = unit("s", Dimension::Time, 1.0);
/// Millisecond.
pub const MILLISECOND: LogUnit = unit("ms", Dimension::Time, 1e-3);
/// Microsecond.
pub const MICROSECOND: LogUnit = unit("µs", Dimension::Time, 1e-6);
/// Nanosecond.
pub const NANOSECOND: LogUnit = unit("ns", Dimension::Time, 1e-9);
/// Minute.
pub const MINUTE: LogUnit = unit("min", Dimension::Time, SECONDS_PER_MINUTE);
/// Millimetre per second.
pub const MM_PER_S: LogUnit = unit("mm/s", Dimension::Feed, 1.0);
/// Millimetre per minute.
pub const MM_PER_MIN: LogUnit = unit("mm/min", Dimension::Feed, 1.0 / SECONDS_PER_MINUTE);
/// Metre per minute.
pub const M_PER_MIN: LogUnit = unit("m/min", Dimension::Feed, 1e3 / SECONDS_PER_MINUTE);
/// Metre per second.
pub const M_PER_S: LogUnit = unit("m/s", Dimension::Feed, 1e3);
/// Inch per minute.
pub const INCH_PER_MIN: LogUnit = unit("inch/min", Dimension::Feed, MM_PER_INCH / SECONDS_PER_MINUTE);
/// Inch per second.
pub const INCH_PER_S: LogUnit = unit("inch/s", Dimension::Feed, MM_PER_INCH);
/// Per cent.
pub const PERCENT: LogUnit = unit("%", Dimension::Ratio, 1e-2);
/// A pure ratio.
pub const RATIO: LogUnit = unit("1", Dimension::Ratio, 1.0);
/// Revolutions per minute.
pub const RPM: LogUnit = unit("rev/min", Dimension::Rotation, TAU / SECONDS_PER_MINUTE);
/// Revolutions per second.
pub const REV_PER_S: LogUnit = unit("rev/s", Dimension::Rotation, TAU);
/// Degrees per second.
pub const DEGREE_PER_S: LogUnit = unit("°/s", Dimension::Rotation, PI / 180.0);
/// Degree.
pub const DEGREE: LogUnit = unit("°", Dimension::Angle, PI / 180.0);
/// Radian.
pub const RADIAN: LogUnit = unit("rad", Dimension::Angle, 1.0);

/// Units of a length without one, most usual first.
pub const LENGTHS: &[LogUnit] = &[MM, INCH, MICROMETRE, METRE];
/// Units of a feed without one, most usual first.
pub const FEEDS: &[LogUnit] = &[MM_PER_MIN, MM_PER_S, INCH_PER_MIN, M_PER_MIN, INCH_PER_S, M_PER_S];
/// Units of a spindle speed without one: logs use no other.
pub const ROTATIONS: &[LogUnit] = &[RPM];

/// Spellings, in lower case and without blanks, of every unit.
const SPELLINGS: &[(&str, LogUnit)] = &[
    ("s", SECOND),
    ("sec", SECOND),
    ("second", SECOND),
    ("seconds", SECOND),
    ("ms", MILLISECOND),
    ("msec", MILLISECOND),
    ("millisecond", MILLISECOND),
    ("milliseconds", MILLISECOND),
    ("us", MICROSECOND),
    ("µs", MICROSECOND),
    ("μs", MICROSECOND),
    ("microseconds", MICROSECOND),
    ("ns", NANOSECOND),
    ("min", MINUTE),
    ("mm", MM),
    ("millimeter", MM),
    ("millimetre", MM),
    ("in", INCH),
    ("inch", INCH),
    ("\"", INCH),
    ("um", MICROMETRE),
    ("µm", MICROMETRE),
    ("μm", MICROMETRE),
    ("m", METRE),
    ("mm/s", MM_PER_S),
    ("mm/sec", MM_PER_S),
    ("millimeter/second", MM_PER_S),
    ("mm/min", MM_PER_MIN),
    ("millimeter/minute", MM_PER_MIN),
    ("m/min", M_PER_MIN),
    ("m/s", M_PER_S),
    ("in/min", INCH_PER_MIN),
    ("inch/min", INCH_PER_MIN),
    ("ipm", INCH_PER_MIN),
    ("in/s", INCH_PER_S),
    ("inch/s", INCH_PER_S),
    ("%", PERCENT),
    ("percent", PERCENT),
    ("pct", PERCENT),
    ("1", RATIO),
    ("ratio", RATIO),
    ("rpm", RPM),
    ("1/min", RPM),
    ("min-1", RPM),
    ("rev/min", RPM),
    ("u/min", RPM),
    ("revolution/minute", RPM),
    ("rev/s", REV_PER_S),
    ("deg/s", DEGREE_PER_S),
    ("°/s", DEGREE_PER_S),
    ("deg", DEGREE),
    ("degree", DEGREE),
    ("°", DEGREE),
    ("rad", RADIAN),
];

impl LogUnit {
    /// Returns the unit written as `text`, such as `mm/min`, `mm_per_min`, `[ms]` or `mm (Length)`; `None` if
    /// `text` is not a unit.
    pub fn parse(text: &str) -> Option<LogUnit> {
        let text = text.trim().trim_start_matches(['[', '(']).trim_end_matches([']', ')']);
        let text = text.split([' ', '(']).next().unwrap_or("").to_lowercase();
        let text = text.replace("_per_", "/").replace('_', "/").replace("·", "");
        SPELLINGS.iter().find(|(spelling, _)| *spelling == text).map(|(_, unit)| *unit)
    }
}
