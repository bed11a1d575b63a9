//! Do the units close? The integral of the feed, and the length of the recorded positions, must be
//! the length of the path:
//!
//! ```text
//! ∫ v dt · factor = L        factor = 1, 60, 25.4, 1000 and their products and inverses
//! ```
//!
//! With a stated unit the factor must be 1 within [`TOLERANCE`]; without one it is the factor of a
//! candidate. Any other known factor is named in the refusal, because that is the mistake to look
//! for. The factors are more than a third apart, so not two of them fit.
//!
//! The length of noisy positions is taken in steps of [`STEP`] standard deviations of the noise σ,
//! found from second differences: summing sample by sample would add some 1.6 σ a sample.

use thiserror::Error;

use crate::identification::recording::unit::{MM, MM_PER_S, Unit};
use crate::identification::recording::{Axes, Channel, Recording, Scale};
use crate::units::{MM_PER_INCH, SECONDS_PER_MINUTE};

/// How far the lengths may be apart, as a part of the path.
pub const TOLERANCE: f64 = 0.05;

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
         {factor:.6}{}", .instead.map(|unit| format!(", that is in {}", unit.symbol)).unwrap_or_default()
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
    if path.is_nan() || path <= 0.0 {
        return Err(ClosureError::NoPath);
    }
    if let Some(feed) = recording.feed.as_ref().or(recording.commanded_feed.as_ref()) {
        let end = recording.runs.last().map_or(recording.duration, |run| run.time.end);
        return settle(Measure::Feed, feed, MM_PER_S, feed.integral(end), path);
    }
    match (path_length(recording.positions()), recording.positions().iter().flatten().next()) {
        (Some(length), Some(channel)) => settle(Measure::Positions, channel, MM, length, path),
        _ => Err(ClosureError::NothingToMeasure),
    }
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
    match factors().find(|factor| fits(*factor)) {
        Some(factor) => {
            let named = |named: &&Unit| (named.factor / (unit.factor * factor) - 1.0).abs() < 1e-9;
            let all = match measure {
                Measure::Feed => crate::identification::recording::unit::FEEDS,
                Measure::Positions => crate::identification::recording::unit::LENGTHS,
            };
            let instead = all.iter().find(named).copied();
            Err(ClosureError::WouldFit { name, unit: unit.symbol, length, path, factor, instead })
        }
        None => Err(ClosureError::NoFactor { name, unit: unit.symbol, length, path, ratio: length / path }),
    }
}

/// 1, 60, 25.4, 1000, their products and inverses.
fn factors() -> impl Iterator<Item = f64> {
    const POWERS: [i32; 3] = [0, 1, -1];
    let products = POWERS.into_iter().flat_map(|a| POWERS.into_iter().map(move |b| (a, b)));
    products.flat_map(|(a, b)| {
        let product = SECONDS_PER_MINUTE.powi(a) * MM_PER_INCH.powi(b);
        POWERS.into_iter().map(move |c| product * 1000_f64.powi(c))
    })
}

/// Length of the recorded path, in the positions' unit; none where no axis has two samples. Axes
/// with stamps of their own are held at their last value at the stamps of the first.
pub fn path_length(axes: &Axes) -> Option<f64> {
    let longest = axes.iter().flatten().max_by_key(|channel| channel.values.len())?;
    if longest.values.len() < 2 {
        return None;
    }
    let step = STEP * axes.iter().flatten().map(noise).fold(0.0, f64::max);
    let mut cursors = [0; 3];
    let mut anchor: Option<[f64; 3]> = None;
    let mut length = 0.0;
    let mut point = [0.0; 3];
    for stamp in longest.time.iter() {
        for ((channel, cursor), value) in axes.iter().zip(&mut cursors).zip(&mut point) {
            let Some(channel) = channel else { continue };
            while *cursor + 1 < channel.time.len() && channel.time[*cursor + 1] <= *stamp {
                *cursor += 1;
            }
            *value = channel.values[*cursor];
        }
        let from = *anchor.get_or_insert(point);
        let moved = distance(from, point);
        if step < moved {
            length += moved;
            anchor = Some(point);
        }
    }
    Some(length + anchor.map_or(0.0, |anchor| distance(anchor, point)))
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
