//! Do the units close? The integral of the feed, and the length of the recorded positions, must be
//! the length of the path:
//!
//! ```text
//! factor · ∫ v dt = L,   factor of a unit: 1/60 mm/min, 1 mm/s, 25.4/60 inch/min, 1000/60 m/min …
//! ```
//!
//! With a stated unit the factor must be 1 within [`TOLERANCE`]; without one it is the factor of a
//! candidate. A known factor other than that is named in the refusal, because it is the mistake to
//! look for. Factors are half as much again apart or more, so not two of them fit.
//!
//! What is compared must be the same motion. Where the machine also goes home and to its tool
//! changer, as no program says, the whole run is longer than the path (by half on a small part);
//! [`closure_on`] compares only the lines that cut. Lag shortens recorded positions and vibration
//! lengthens them, by some 10 % each in bad cases, which is why the tolerance is not finer; the
//! ratio is returned for stages that want to be stricter.
//!
//! The length of noisy positions is taken in steps of [`STEP`] standard deviations of the noise σ,
//! found from second differences: summing sample by sample would add some 1.6 σ a sample.

use std::ops::Range;
use thiserror::Error;

use crate::identification::recording::unit::{FEEDS, LENGTHS, MM, MM_PER_S, Unit};
use crate::identification::recording::{Axes, Channel, Recording, Scale};
use crate::units::SECONDS_PER_MINUTE;

/// How far the lengths may be apart, as a part of the path.
pub const TOLERANCE: f64 = 0.15;

/// Shortest step of the recorded path in standard deviations of its noise.
const STEP: f64 = 10.0;

/// What a length was found from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measure {
    /// The integral of the feed.
    Feed,
    /// The length of the recorded positions.
    Positions,
}

/// Units that close.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Closure {
    /// What was measured.
    pub measure: Measure,
    /// The unit of the file.
    pub unit: Unit,
    /// Length recorded, mm.
    pub length: f64,
    /// Length recorded over the length of the path.
    pub ratio: f64,
}

/// Why units do not close.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum ClosureError {
    /// Neither feed nor positions.
    #[error("neither feed nor positions are recorded, so units cannot be checked")]
    NothingToMeasure,
    /// The path has no length.
    #[error("the path has no length to compare with")]
    NoPath,
    /// Wrong by a factor that units explain.
    #[error(
        "`{name}` in {unit} makes {length:.1} mm of a path of {path:.1} mm; it would fit with a factor of \
         {factor:.6}{}", .instead.map(|unit| format!(", that is in {}", unit.symbol)).unwrap_or(", as of a wrong unit of time".to_owned())
    )]
    WouldFit {
        /// Name of the column.
        name: String,
        /// Unit it was read in.
        unit: &'static str,
        /// Length recorded, mm.
        length: f64,
        /// Length of the path, mm.
        path: f64,
        /// What the values would have to be multiplied by.
        factor: f64,
        /// The unit that would be, if it has a name.
        instead: Option<Unit>,
    },
    /// Wrong by something else.
    #[error(
        "`{name}` makes {length:.1} mm of a path of {path:.1} mm in {unit}; no unit explains a ratio of {ratio:.4}: \
         another program, or a part of the run is missing"
    )]
    NoFactor {
        /// Name of the column.
        name: String,
        /// Unit it was read in, or of which the ratio is given.
        unit: &'static str,
        /// Length recorded, mm.
        length: f64,
        /// Length of the path, mm.
        path: f64,
        /// Length recorded over the length of the path.
        ratio: f64,
    },
}

/// Checks the feed (or, where none is recorded, the positions) against a path of `path` mm, which
/// must be the one the recording, or the part of it given, covers.
pub fn closure(recording: &Recording, path: f64) -> Result<Closure, ClosureError> {
    let has_feed = recording.feed.is_some() || recording.commanded_feed.is_some();
    closure_of(if has_feed { Measure::Feed } else { Measure::Positions }, recording, path)
}

/// Checks the feed or the positions against a path of `path` mm.
pub fn closure_of(measure: Measure, recording: &Recording, path: f64) -> Result<Closure, ClosureError> {
    if path.is_nan() || path <= 0.0 {
        return Err(ClosureError::NoPath);
    }
    match measure {
        Measure::Feed => {
            let feed = recording.feed.as_ref().or(recording.commanded_feed.as_ref());
            let feed = feed.ok_or(ClosureError::NothingToMeasure)?;
            let end = recording.runs.last().map_or(recording.duration, |run| run.time.end);
            settle(measure, feed, MM_PER_S, feed.integral(end), path)
        }
        Measure::Positions => {
            let axes = recording.positions();
            match (path_length(axes), axes.iter().flatten().next()) {
                (Some(length), Some(channel)) => settle(measure, channel, MM, length, path),
                _ => Err(ClosureError::NothingToMeasure),
            }
        }
    }
}

/// Checks the feed against the `path` mm of those lines that `counts` says yes to, over the times
/// at which the control says that it runs them.
pub fn closure_on(
    recording: &Recording,
    path: f64,
    counts: impl Fn(u32) -> bool,
) -> Result<Closure, ClosureError> {
    if path.is_nan() || path <= 0.0 {
        return Err(ClosureError::NoPath);
    }
    let (Some(feed), Some(line)) = (&recording.feed, &recording.line) else {
        return Err(ClosureError::NothingToMeasure);
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
    core: Unit,
    length: f64,
    path: f64,
) -> Result<Closure, ClosureError> {
    let fits = |factor: f64| (length * factor / path - 1.0).abs() <= TOLERANCE;
    let closes = |unit: Unit, factor: f64| {
        Ok(Closure { measure, unit, length: length * factor, ratio: length * factor / path })
    };
    let (unit, candidates) = match channel.scale {
        Scale::Stated(unit) if fits(1.0) => return closes(unit, 1.0),
        Scale::Stated(unit) => (unit, &[][..]),
        Scale::Unstated(units) => (core, units),
        Scale::Unitless => (core, &[][..]),
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
        return Err(ClosureError::WouldFit {
            name,
            unit: unit.symbol,
            length,
            path,
            factor,
            instead: Some(*instead),
        });
    }
    // A factor that is no unit of the values may be one of the time.
    match [1e-3, 1e3, SECONDS_PER_MINUTE, 1.0 / SECONDS_PER_MINUTE].into_iter().find(|factor| fits(*factor)) {
        Some(factor) => {
            Err(ClosureError::WouldFit { name, unit: unit.symbol, length, path, factor, instead: None })
        }
        None => Err(ClosureError::NoFactor { name, unit: unit.symbol, length, path, ratio: length / path }),
    }
}

/// Length of the recorded path, in the positions' unit; none where no axis has two samples. At every
/// stamp of any axis the others are held at their last value, and before it at their first.
pub fn path_length(axes: &Axes) -> Option<f64> {
    if axes.iter().flatten().all(|channel| channel.values.len() < 2) {
        return None;
    }
    let step = STEP * axes.iter().flatten().map(noise).fold(0.0, f64::max);
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

/// Standard deviation of a channel's noise, from the median of its second differences, which for
/// white noise are √6 σ, and of which acceleration fills only the ramps.
fn noise(channel: &Channel<f64>) -> f64 {
    let mut second: Vec<f64> =
        channel.values.windows(3).map(|v| (v[2] - 2.0 * v[1] + v[0]).abs()).filter(|v| 0.0 < *v).collect();
    // Values that repeat are rest or steady motion of a noiseless log.
    if second.is_empty() || second.len() < channel.values.len() / 2 {
        return 0.0;
    }
    let middle = second.len() / 2;
    let median = *second.select_nth_unstable_by(middle, f64::total_cmp).1;
    median / (0.6745 * 6_f64.sqrt())
}
