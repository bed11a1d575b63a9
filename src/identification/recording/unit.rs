//! Units a log can be written in, found in names (`feed_mm_min`), in brackets (`Time [ms]`) or in
//! a row of their own, and what they are in core units:
//!
//! ```text
//! value in core units = factor · value in the file      (s, mm, mm/s, rad, rad/s, ratio)
//! ```
//!
//! Where no unit is stated a value stays as it is in the file and carries the units it may have;
//! `closure` tells which of them it is. Left out: temperatures, loads, accelerations.

use std::f64::consts::{PI, TAU};

use crate::units::{MM_PER_INCH, SECONDS_PER_MINUTE};

/// What a unit measures.
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

/// A unit values are written in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    /// As people write it.
    pub symbol: &'static str,
    /// What it measures.
    pub dimension: Dimension,
    /// Core units in one of it.
    pub factor: f64,
}

const fn unit(symbol: &'static str, dimension: Dimension, factor: f64) -> Unit {
    Unit { symbol, dimension, factor }
}

/// Millimetre.
pub const MM: Unit = unit("mm", Dimension::Length, 1.0);
/// Inch.
pub const INCH: Unit = unit("inch", Dimension::Length, MM_PER_INCH);
/// Micrometre.
pub const MICROMETRE: Unit = unit("µm", Dimension::Length, 1e-3);
/// Metre.
pub const METRE: Unit = unit("m", Dimension::Length, 1e3);
/// Second.
pub const SECOND: Unit = unit("s", Dimension::Time, 1.0);
/// Millisecond.
pub const MILLISECOND: Unit = unit("ms", Dimension::Time, 1e-3);
/// Microsecond.
pub const MICROSECOND: Unit = unit("µs", Dimension::Time, 1e-6);
/// Nanosecond.
pub const NANOSECOND: Unit = unit("ns", Dimension::Time, 1e-9);
/// Minute.
pub const MINUTE: Unit = unit("min", Dimension::Time, SECONDS_PER_MINUTE);
/// Millimetre per second.
pub const MM_PER_S: Unit = unit("mm/s", Dimension::Feed, 1.0);
/// Millimetre per minute.
pub const MM_PER_MIN: Unit = unit("mm/min", Dimension::Feed, 1.0 / SECONDS_PER_MINUTE);
/// Metre per minute.
pub const M_PER_MIN: Unit = unit("m/min", Dimension::Feed, 1e3 / SECONDS_PER_MINUTE);
/// Metre per second.
pub const M_PER_S: Unit = unit("m/s", Dimension::Feed, 1e3);
/// Inch per minute.
pub const INCH_PER_MIN: Unit = unit("inch/min", Dimension::Feed, MM_PER_INCH / SECONDS_PER_MINUTE);
/// Inch per second.
pub const INCH_PER_S: Unit = unit("inch/s", Dimension::Feed, MM_PER_INCH);
/// Per cent.
pub const PERCENT: Unit = unit("%", Dimension::Ratio, 1e-2);
/// A pure ratio.
pub const RATIO: Unit = unit("1", Dimension::Ratio, 1.0);
/// Revolutions per minute.
pub const RPM: Unit = unit("rev/min", Dimension::Rotation, TAU / SECONDS_PER_MINUTE);
/// Revolutions per second.
pub const REV_PER_S: Unit = unit("rev/s", Dimension::Rotation, TAU);
/// Degrees per second.
pub const DEGREE_PER_S: Unit = unit("°/s", Dimension::Rotation, PI / 180.0);
/// Degree.
pub const DEGREE: Unit = unit("°", Dimension::Angle, PI / 180.0);
/// Radian.
pub const RADIAN: Unit = unit("rad", Dimension::Angle, 1.0);

/// What a length without a unit may be in, most usual first.
pub const LENGTHS: &[Unit] = &[MM, INCH, MICROMETRE, METRE];
/// What a feed without a unit may be in, most usual first.
pub const FEEDS: &[Unit] = &[MM_PER_MIN, MM_PER_S, INCH_PER_MIN, M_PER_MIN, INCH_PER_S, M_PER_S];
/// What a spindle speed without a unit may be in: nobody writes anything else.
pub const ROTATIONS: &[Unit] = &[RPM];

/// Spellings, in lower case and without blanks, of every unit.
const SPELLINGS: &[(&str, Unit)] = &[
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

impl Unit {
    /// The unit written as `text`, such as `mm/min`, `mm_per_min`, `[ms]` or `mm (Length)`.
    pub fn parse(text: &str) -> Option<Unit> {
        let text = text.trim().trim_start_matches(['[', '(']).trim_end_matches([']', ')']);
        let text = text.split([' ', '(']).next().unwrap_or("").to_lowercase();
        let text = text.replace("_per_", "/").replace('_', "/").replace("·", "");
        SPELLINGS.iter().find(|(spelling, _)| *spelling == text).map(|(_, unit)| *unit)
    }
}
