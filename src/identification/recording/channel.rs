//! One recorded quantity over time.
//!
//! Every channel has ascending stamps. The columns of a table share one vector (`Arc`). Logs written on
//! change have one vector per channel, because an event states when one item changed and nothing about other
//! items: a common grid would invent samples of some items or lose stamps of others. Between stamps
//! ```text
//! sampled      value(t) runs straight from sample to sample
//! on change    value(t) = value of the last event at or before t
//! ```
//!
//! and within a gap the value is unknown. Missing values are left out, so that all values are finite.

use std::ops::Range;
use std::sync::Arc;

use crate::identification::recording::unit::LogUnit;

/// The way in which a channel was written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sampling {
    /// At regular or irregular moments, changed or not.
    Sampled,
    /// When the polled value changed.
    OnChange,
}

/// The unit of a channel in the file, and so of its values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ChannelUnit {
    /// The file states this unit; values are in core units.
    Stated(LogUnit),
    /// The file states no unit; values are as in the file, in one of these units.
    Unstated(&'static [LogUnit]),
    /// Words and counts have no unit.
    Unitless,
}

/// One recorded quantity.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel<V> {
    /// Name in the file.
    pub name: String,
    /// The way in which the channel was written.
    pub sampling: Sampling,
    /// Unit of the values.
    pub unit: ChannelUnit,
    /// Stamps, s from the start of the recording; strictly ascending.
    pub time: Arc<[f64]>,
    /// Values, one per stamp, all finite.
    pub values: Vec<V>,
    /// Ranges of time without values, s: the recorder lost samples or its connection.
    pub gaps: Vec<Range<f64>>,
}

impl<V: Clone> Channel<V> {
    /// Returns the last value at or before `time` (s); `None` before the first stamp and in gaps.
    pub fn held(&self, time: f64) -> Option<&V> {
        let begun = self.gaps.partition_point(|gap| gap.start < time);
        if begun.checked_sub(1).is_some_and(|last| time < self.gaps[last].end) {
            return None;
        }
        let after = self.time.partition_point(|stamp| *stamp <= time);
        self.values.get(after.checked_sub(1)?)
    }

    /// Returns the first and the last stamp, s; `None` for an empty channel.
    pub fn span(&self) -> Option<(f64, f64)> {
        Some((*self.time.first()?, *self.time.last()?))
    }

    /// Returns the part within `range` (s); an on-change channel begins with its value at the start of the
    /// range.
    pub fn during(&self, range: &Range<f64>) -> Channel<V> {
        let from = self.time.partition_point(|stamp| *stamp < range.start);
        let to = self.time.partition_point(|stamp| *stamp < range.end).max(from);
        let carried = self.sampling == Sampling::OnChange && self.time.get(from) != Some(&range.start);
        let carried = if carried { self.held(range.start).cloned() } else { None };
        let mut time = Vec::with_capacity(to - from + 1);
        let mut values = Vec::with_capacity(to - from + 1);
        if let Some(value) = carried {
            time.push(range.start);
            values.push(value);
        }
        time.extend_from_slice(&self.time[from..to]);
        values.extend_from_slice(&self.values[from..to]);
        let first = self.gaps.partition_point(|gap| gap.end <= range.start);
        let past = self.gaps.partition_point(|gap| gap.start < range.end).max(first);
        let gaps =
            self.gaps[first..past].iter().map(|gap| gap.start.max(range.start)..gap.end.min(range.end));
        Channel { name: self.name.clone(), time: time.into(), values, gaps: gaps.collect(), ..*self }
    }
}

impl Channel<f64> {
    /// Returns ∫ value dt up to `end` (s) without gaps: trapezoids of samples, steps of events.
    pub fn integral(&self, end: f64) -> f64 {
        let mut gaps = self.gaps.iter().peekable();
        let mut sum = 0.0;
        for (at, (from, value)) in self.time.iter().zip(&self.values).enumerate() {
            let next = self.time.get(at + 1).copied();
            let mean = match (self.sampling, self.values.get(at + 1)) {
                (Sampling::Sampled, Some(next)) => 0.5 * (value + next),
                (Sampling::Sampled, None) => continue,
                (Sampling::OnChange, _) => *value,
            };
            let to = next.unwrap_or(end).min(end);
            while gaps.next_if(|gap| gap.end <= *from).is_some() {}
            let known = match gaps.peek() {
                Some(gap) if gap.start < to => gap.start.max(*from) - from,
                _ => to - from,
            };
            sum += mean * known.max(0.0);
        }
        sum
    }

    /// Returns the smallest and the largest value; `None` for an empty channel.
    pub fn extent(&self) -> Option<(f64, f64)> {
        let first = *self.values.first()?;
        Some(self.values.iter().fold((first, first), |(low, high), v| (low.min(*v), high.max(*v))))
    }

    /// Returns the channel with its values converted from `unit` if the file states no unit.
    pub fn assuming(mut self, unit: LogUnit) -> Channel<f64> {
        if let ChannelUnit::Unstated(_) = self.unit {
            self.values.iter_mut().for_each(|value| *value *= unit.factor);
            self.unit = ChannelUnit::Stated(unit);
        }
        self
    }
}
