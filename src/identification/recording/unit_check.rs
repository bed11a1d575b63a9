//! The unit check: the integral of the feed, and the length of the recorded positions, must equal the length
//! of the path:
//!
//! ```text
//! factor · ∫ v dt = L,   factor of a unit: 1/60 mm/min, 1 mm/s, 25.4/60 inch/min, 1000/60 m/min …
//! ```
//!
//! The factor of a stated unit must be 1 within [`MAX_LENGTH_DIFFERENCE_RATIO`]; without a stated unit it
//! must match a candidate's. If another known factor fits, the error names it as the likely mistake.
//! Factors differ by at least a factor of 1.5, so that no two of them fit.
//!
//! Both lengths must belong to one motion. If the machine also moves home and to its tool changer, which is
//! not in the program, the whole run is longer than the path (by half on a small part);
//! [`check_unit_on_lines`] compares only the lines that cut. Lag shortens recorded positions and vibration
//! lengthens them, by about 10 % each in bad cases, so that the tolerance cannot be finer; the ratio is
//! returned for stages with stricter limits.
//!
//! The length of noisy positions is measured in steps of [`MIN_STEP_SIGMAS`] standard deviations of the noise
//! σ, estimated from second differences: a sum over all samples would be too long by about 1.6 σ per sample.

use std::ops::Range;
use thiserror::Error;

use crate::identification::recording::noise::noise;
use crate::identification::recording::unit::{FEEDS, LENGTHS, LogUnit, MM, MM_PER_S};
use crate::identification::recording::{Axes, Channel, ChannelUnit, Recording};
use crate::units::SECONDS_PER_MINUTE;

/// Largest difference of the lengths, as a part of the path.
pub const MAX_LENGTH_DIFFERENCE_RATIO: f64 = 0.15;

/// Shortest step of the recorded path, in standard deviations of its noise.
const MIN_STEP_SIGMAS: f64 = 10.0;

/// The source of a recorded length.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measure {
    /// The integral of the feed.
    Feed,
    /// The length of the recorded positions.
    Positions,
}

/// A unit that passes the check.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UnitCheck {
    /// Source of the length.
    pub measure: Measure,
    /// Unit of the file.
    pub unit: LogUnit,
    /// Recorded length, mm.
    pub length: f64,
    /// Recorded length over the length of the path.
    pub ratio: f64,
}

/// The reason why units fail the check.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum UnitCheckError {
    /// Neither feed nor positions.
    #[error("the recording has neither feed nor positions, so Truefeed cannot check units")]
    NothingToMeasure,
    /// The path has no length.
    #[error("the path has no length to compare with")]
    NoPath,
    /// The length is wrong by the factor between two units.
    #[error(
        "`{name}` in {unit} gives {length:.1} mm for a path of {path:.1} mm; it would fit with a factor of {factor:.6}{}", .instead.map(|unit| format!(", that is in {}", unit.symbol)).unwrap_or(", as from a wrong unit of time".to_owned())
    )]
    WouldFit {
        /// Name of the column.
        name: String,
        /// Unit in which it was read.
        unit: &'static str,
        /// Recorded length, mm.
        length: f64,
        /// Length of the path, mm.
        path: f64,
        /// Factor that would correct the values.
        factor: f64,
        /// Unit with that factor, if it has a name.
        instead: Option<LogUnit>,
    },
    /// The length is wrong by another factor.
    #[error(
        "`{name}` gives {length:.1} mm for a path of {path:.1} mm in {unit}; no unit explains a ratio of {ratio:.4}: this is another program, or a part of the run is missing"
    )]
    NoFactor {
        /// Name of the column.
        name: String,
        /// Unit in which it was read, or to which the ratio refers.
        unit: &'static str,
        /// Recorded length, mm.
        length: f64,
        /// Length of the path, mm.
        path: f64,
        /// Recorded length over the length of the path.
        ratio: f64,
    },
}

/// Checks the feed (or the positions, if no feed was recorded) against the length `path` (mm) of the part of
/// the program that the recording covers.
///
/// # Errors
///
/// Returns an error if neither was recorded, or if the length differs from the length of the path.
pub fn check_unit(recording: &Recording, path: f64) -> Result<UnitCheck, UnitCheckError> {
    let has_feed = recording.feed.is_some() || recording.commanded_feed.is_some();
    check_unit_by(if has_feed { Measure::Feed } else { Measure::Positions }, recording, path)
}

/// Checks the feed or the positions against a path of the length `path` (mm).
///
/// # Errors
///
/// Returns an error if the quantity was not recorded, or if the length differs from the length of the path.
pub fn check_unit_by(
    measure: Measure,
    recording: &Recording,
    path: f64,
) -> Result<UnitCheck, UnitCheckError> {
    if path.is_nan() || path <= 0.0 {
        return Err(UnitCheckError::NoPath);
    }
    match measure {
        Measure::Feed => {
            let feed = recording.feed.as_ref().or(recording.commanded_feed.as_ref());
            let feed = feed.ok_or(UnitCheckError::NothingToMeasure)?;
            let end = recording.runs.last().map_or(recording.duration, |run| run.time.end);
            settle(measure, feed, MM_PER_S, feed.integral(end), path)
        }
        Measure::Positions => {
            let axes = recording.positions();
            match (path_length(axes), axes.iter().flatten().next()) {
                (Some(length), Some(channel)) => settle(measure, channel, MM, length, path),
                _ => Err(UnitCheckError::NothingToMeasure),
            }
        }
    }
}

/// Checks the feed against the length `path` (mm) of the lines for which `counts` returns `true`, over the
/// times at which the control runs these lines.
///
/// # Errors
///
/// Returns an error if no feed was recorded, or if the length differs from the length of the path.
pub fn check_unit_on_lines(
    recording: &Recording,
    path: f64,
    counts: impl Fn(u32) -> bool,
) -> Result<UnitCheck, UnitCheckError> {
    if path.is_nan() || path <= 0.0 {
        return Err(UnitCheckError::NoPath);
    }
    let (Some(feed), Some(line)) = (&recording.feed, &recording.line) else {
        return Err(UnitCheckError::NothingToMeasure);
    };
    let ends = line.time.iter().skip(1).copied().chain([recording.duration]);
    let mut length = 0.0;
    let mut stretch: Option<Range<f64>> = None;
    for ((from, line), to) in line.time.iter().zip(&line.values).zip(ends) {
        stretch = match (stretch, counts(*line)) {
            (Some(stretch), true) => Some(stretch.start..to),
            (None, true) => Some(*from..to),
            (Some(stretch), false) => {
                length += feed.during(&stretch).integral(stretch.end);
                None
            }
            (None, false) => None,
        };
    }
    if let Some(stretch) = stretch {
        length += feed.during(&stretch).integral(stretch.end);
    }
    settle(Measure::Feed, feed, MM_PER_S, length, path)
}

fn settle(
    measure: Measure,
    channel: &Channel<f64>,
    core: LogUnit,
    length: f64,
    path: f64,
) -> Result<UnitCheck, UnitCheckError> {
    let fits = |factor: f64| (length * factor / path - 1.0).abs() <= MAX_LENGTH_DIFFERENCE_RATIO;
    let closes = |unit: LogUnit, factor: f64| {
        Ok(UnitCheck { measure, unit, length: length * factor, ratio: length * factor / path })
    };
    let (unit, candidates) = match channel.unit {
        ChannelUnit::Stated(unit) if fits(1.0) => return closes(unit, 1.0),
        ChannelUnit::Stated(unit) => (unit, &[][..]),
        ChannelUnit::Unstated(units) => (core, units),
        ChannelUnit::Unitless => (core, &[][..]),
    };
    if let Some(found) = candidates.iter().find(|unit| fits(unit.factor)) {
        return closes(*found, found.factor);
    }
    let name = channel.name.clone();
    let named = match measure {
        Measure::Feed => FEEDS,
        Measure::Positions => LENGTHS,
    };
    if let Some(instead) = named.iter().find(|other| fits(other.factor / unit.factor)) {
        let factor = instead.factor / unit.factor;
        return Err(UnitCheckError::WouldFit {
            name,
            unit: unit.symbol,
            length,
            path,
            factor,
            instead: Some(*instead),
        });
    }
    // A factor that is not one of units of the values may be one of units of time.
    match [1e-3, 1e3, SECONDS_PER_MINUTE, 1.0 / SECONDS_PER_MINUTE].into_iter().find(|factor| fits(*factor)) {
        Some(factor) => {
            Err(UnitCheckError::WouldFit { name, unit: unit.symbol, length, path, factor, instead: None })
        }
        None => Err(UnitCheckError::NoFactor { name, unit: unit.symbol, length, path, ratio: length / path }),
    }
}

/// Returns the length of the recorded path, in the positions' unit; `None` if no axis has two samples. At
/// every stamp of any axis the other axes have their last value, or before their first stamp the first value.
pub fn path_length(axes: &Axes) -> Option<f64> {
    if axes.iter().flatten().all(|channel| channel.values.len() < 2) {
        return None;
    }
    let step = MIN_STEP_SIGMAS * axes.iter().flatten().map(|axis| noise(&axis.values)).fold(0.0, f64::max);
    let mut cursors = [0; 3];
    let mut point =
        axes.each_ref().map(|axis| axis.as_ref().and_then(|c| c.values.first()).copied().unwrap_or(0.0));
    let mut anchor = point;
    let mut length = 0.0;
    loop {
        let next = |(axis, at): (&Option<Channel<f64>>, &usize)| axis.as_ref()?.time.get(at + 1).copied();
        let stamp = axes.iter().zip(&cursors).filter_map(next).fold(f64::INFINITY, f64::min);
        if stamp.is_infinite() {
            return Some(length + distance(anchor, point));
        }
        for ((channel, cursor), value) in axes.iter().zip(&mut cursors).zip(&mut point) {
            if let Some(channel) = channel
                && channel.time.get(*cursor + 1).is_some_and(|time| *time <= stamp)
            {
                *cursor += 1;
                *value = channel.values[*cursor];
            }
        }
        let moved = distance(anchor, point);
        if step < moved {
            length += moved;
            anchor = point;
        }
    }
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(&b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}
