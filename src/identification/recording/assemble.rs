//! Signals of a reader → recordings: one channel per field, in core units, without missing values, with gaps;
//! signals without motion are refused.
//!
//! If a field has several signals, the one with the most values is read. Samples at least [`MIN_GAP_STEPS`]
//! usual steps apart have a gap between them; an event UNAVAILABLE begins a gap that ends with the next
//! value.

use std::ops::Range;
use std::sync::Arc;

use crate::identification::recording::clock::{MIN_SAMPLES, median_step, seconds};
use crate::identification::recording::field::{ChannelField, ChannelLabel, LoopSide};
use crate::identification::recording::text::{CellContent, number};
use crate::identification::recording::unit::{FEEDS, LENGTHS, LogUnit, PERCENT, RATIO, RPM};
use crate::identification::recording::{
    Axes, Channel, ChannelUnit, Recording, RecordingError, RecordingRemarks, Sampling, Status, runs,
};

/// Step between samples from which there is a gap, in usual steps.
const MIN_GAP_STEPS: f64 = 5.0;

/// Largest override that counts as a ratio; larger ones are in per cent.
const MAX_OVERRIDE_RATIO: f64 = 5.0;

/// A column or item of a file.
#[derive(Debug)]
pub(super) struct Signal {
    pub(super) label: ChannelLabel,
    pub(super) sampling: Sampling,
    /// Stamps, s from an origin common to all signals of a capture; ascending.
    pub(super) time: Arc<[f64]>,
    pub(super) data: SignalData,
}

/// Values of a signal, one per stamp.
#[derive(Debug)]
pub(super) enum SignalData {
    /// Numbers; NaN where missing.
    Numbers(Vec<f64>),
    /// Words; `None` if missing.
    Texts(Vec<Option<String>>),
}

impl Signal {
    fn known(&self) -> usize {
        match &self.data {
            SignalData::Numbers(values) => values.iter().filter(|value| value.is_finite()).count(),
            SignalData::Texts(values) => values.iter().flatten().count(),
        }
    }
}

/// All signals of one clock.
#[derive(Debug)]
pub(super) struct Capture {
    /// Origin of the clock, ns since 1970.
    pub(super) origin: Option<i64>,
    pub(super) signals: Vec<Signal>,
}

/// Returns a recording for each capture; a remark names captures without motion, which are left out.
pub(super) fn recordings(
    captures: Vec<Capture>,
    remarks: &mut RecordingRemarks,
) -> Result<Vec<Recording>, RecordingError> {
    let many = 1 < captures.len();
    let mut recordings = Vec::new();
    let mut refusal = None;
    for (nth, capture) in captures.into_iter().enumerate() {
        match recording(capture, remarks) {
            Ok(recording) => recordings.push(recording),
            Err(error) => {
                if many {
                    remarks.warn(
                        None,
                        None,
                        format!("recording {} of the file is left out: {error}", nth + 1),
                    );
                }
                refusal.get_or_insert(error);
            }
        }
    }
    if recordings.is_empty() {
        return Err(refusal.unwrap_or(RecordingError::Empty));
    }
    Ok(recordings)
}

fn recording(capture: Capture, remarks: &mut RecordingRemarks) -> Result<Recording, RecordingError> {
    let found: Vec<String> = capture.signals.iter().map(|signal| signal.label.name.clone()).collect();
    let mut signals = points_as_axes(capture.signals);
    signals.retain(|signal| signal.label.field.is_some() && 0 < signal.known());
    let tells_motion = |signal: &Signal| signal.label.field.is_some_and(ChannelField::tells_motion);
    if !signals.iter().any(tells_motion) {
        return Err(RecordingError::NothingKnown { found });
    }
    let known: usize = signals.iter().map(Signal::known).sum();
    let longest = signals.iter().map(Signal::known).max().unwrap_or(0);
    if known < MIN_SAMPLES || longest < 2 {
        return Err(RecordingError::TooFewSamples { found: longest, needed: MIN_SAMPLES });
    }
    nothing_moves(&signals, remarks)?;
    let first =
        signals.iter().filter_map(|signal| signal.time.first()).copied().fold(f64::INFINITY, f64::min);
    let last =
        signals.iter().filter_map(|signal| signal.time.last()).copied().fold(f64::NEG_INFINITY, f64::max);
    // Relative to an extreme stamp, others would become equal by rounding.
    let stays = |signal: &Signal| signal.time.windows(2).all(|pair| pair[0] - first < pair[1] - first);
    if let Some(lost) = signals.iter().find(|signal| !stays(signal)) {
        let name = &lost.label.name;
        let message = format!("{name} is left out: its times do not overlap those of the other columns");
        remarks.warn(None, None, message);
        signals.retain(stays);
        if !signals.iter().any(tells_motion) {
            return Err(RecordingError::NothingKnown { found });
        }
    }
    let mut builder = ChannelBuilder { first, shifted: Vec::new(), gaps_of: None, remarks };
    let mut recording = Recording {
        started: capture.origin.map(|origin| origin.saturating_add((first * 1e9) as i64)),
        duration: last - first,
        ..Recording::default()
    };
    recording.commanded = builder.axes(&mut signals, LoopSide::Commanded);
    recording.actual = builder.axes(&mut signals, LoopSide::Actual);
    recording.actual_is_stated = recording.actual.iter().any(Option::is_some);
    let unstated = builder.axes(&mut signals, LoopSide::Unstated);
    if !recording.actual_is_stated {
        recording.actual = unstated;
    } else if recording.commanded.iter().all(Option::is_none) {
        recording.commanded = unstated;
    }
    recording.commanded_feed = builder.number(&mut signals, ChannelField::Feed(LoopSide::Commanded));
    recording.feed = builder
        .number(&mut signals, ChannelField::Feed(LoopSide::Actual))
        .or_else(|| builder.number(&mut signals, ChannelField::Feed(LoopSide::Unstated)));
    recording.line = builder.line(&mut signals);
    recording.feed_override = builder.number(&mut signals, ChannelField::FeedOverride);
    recording.rapid_override = builder.number(&mut signals, ChannelField::RapidOverride);
    recording.spindle_speed = builder.number(&mut signals, ChannelField::SpindleSpeed);
    recording.block = builder.text(&mut signals, ChannelField::Block);
    recording.program = builder.text(&mut signals, ChannelField::Program);
    recording.tool = builder.text(&mut signals, ChannelField::Tool);
    recording.status = builder.status(&mut signals);
    recording.runs = runs::runs(&recording);
    Ok(recording)
}

/// Splits signals with X, Y and Z in one value into three.
fn points_as_axes(signals: Vec<Signal>) -> Vec<Signal> {
    let mut split = Vec::with_capacity(signals.len());
    for signal in signals {
        let (Some(ChannelField::Point(side)), SignalData::Texts(texts)) = (signal.label.field, &signal.data)
        else {
            split.push(signal);
            continue;
        };
        let mut axes: [Vec<f64>; 3] = Default::default();
        for text in texts {
            let mut parts = text.as_deref().unwrap_or("").split_whitespace();
            for axis in &mut axes {
                let value = parts.next().map(|part| number(part, false));
                axis.push(if let Some(CellContent::Number(value)) = value { value } else { f64::NAN });
            }
        }
        for (axis, values) in axes.into_iter().enumerate() {
            let name = format!("{} {}", signal.label.name, ["X", "Y", "Z"][axis]);
            let label = ChannelLabel {
                name,
                field: Some(ChannelField::Position(side, axis)),
                unit: signal.label.unit,
            };
            let time = signal.time.clone();
            split.push(Signal { label, sampling: signal.sampling, time, data: SignalData::Numbers(values) });
        }
    }
    split
}

/// Refuses a recording whose motion is constant, and adds a remark on single constant columns.
fn nothing_moves(signals: &[Signal], remarks: &mut RecordingRemarks) -> Result<(), RecordingError> {
    let mut constant = Vec::new();
    let mut moving = 0;
    for signal in signals {
        let changes = match (&signal.label.field, &signal.data) {
            (
                Some(ChannelField::Position(..) | ChannelField::Feed(_) | ChannelField::Line),
                SignalData::Numbers(values),
            ) => {
                let mut known = values.iter().filter(|value| value.is_finite());
                let first = known.next();
                known.any(|value| Some(value) != first)
            }
            (Some(ChannelField::Block), SignalData::Texts(values)) => {
                let mut known = values.iter().flatten();
                let first = known.next();
                known.any(|value| Some(value) != first)
            }
            _ => continue,
        };
        if changes {
            moving += 1;
        } else {
            constant.push(signal.label.name.clone());
        }
    }
    if moving == 0 {
        constant.dedup();
        return Err(RecordingError::NothingMoves { constant });
    }
    for name in constant {
        remarks.info(Some(&name), "constant throughout".to_owned());
    }
    Ok(())
}

/// Turns signals into channels.
struct ChannelBuilder<'a> {
    /// The stamp that becomes 0.
    first: f64,
    /// Time vectors before and after the shift, so that the columns of a table continue to share one vector.
    shifted: Vec<[Arc<[f64]>; 2]>,
    /// The time vector whose gaps were last remarked on.
    gaps_of: Option<Arc<[f64]>>,
    remarks: &'a mut RecordingRemarks,
}

impl ChannelBuilder<'_> {
    /// Removes and returns the signal with the most values of `field`.
    fn take(&mut self, signals: &mut Vec<Signal>, field: ChannelField) -> Option<Signal> {
        let (told, rest): (Vec<Signal>, Vec<Signal>) =
            std::mem::take(signals).into_iter().partition(|signal| signal.label.field == Some(field));
        *signals = rest;
        let mut best: Option<Signal> = None;
        for other in told {
            best = Some(match best {
                None => other,
                Some(best) => {
                    let (kept, left) =
                        if best.known() < other.known() { (other, best) } else { (best, other) };
                    let message =
                        format!("not read, because `{}` has the same data with more values", kept.label.name);
                    self.remarks.info(Some(&left.label.name), message);
                    kept
                }
            });
        }
        best
    }

    /// Removes the positions of X, Y and Z on this side of the servo loop from the signals and returns them.
    fn axes(&mut self, signals: &mut Vec<Signal>, side: LoopSide) -> Axes {
        [0, 1, 2].map(|axis| self.number(signals, ChannelField::Position(side, axis)))
    }

    /// Returns `time` relative to the recording's first stamp.
    fn shifted(&mut self, time: &Arc<[f64]>) -> Arc<[f64]> {
        if let Some([_, shifted]) = self.shifted.iter().find(|[from, _]| Arc::ptr_eq(from, time)) {
            return shifted.clone();
        }
        let shifted: Arc<[f64]> = time.iter().map(|stamp| stamp - self.first).collect();
        self.shifted.push([time.clone(), shifted.clone()]);
        shifted
    }

    /// Returns a channel of the values that `of` returns, and the number of values that it cannot read.
    fn channel<V>(&mut self, signal: &Signal, of: impl Fn(usize) -> Option<V>) -> (Channel<V>, usize) {
        let all = self.shifted(&signal.time);
        let values: Vec<Option<V>> = (0..all.len()).map(of).collect();
        let missing = values.iter().filter(|value| value.is_none()).count();
        let mut gaps = Vec::new();
        let (time, values): (Arc<[f64]>, Vec<V>) = if missing == 0 {
            (all.clone(), values.into_iter().flatten().collect())
        } else {
            if signal.sampling == Sampling::OnChange {
                gaps = unavailable(&all, &values);
            }
            let known = all.iter().zip(values).filter_map(|(stamp, value)| Some((*stamp, value?)));
            let (time, values): (Vec<f64>, Vec<V>) = known.unzip();
            (time.into(), values)
        };
        if signal.sampling == Sampling::Sampled {
            gaps = gaps_between(&time);
            let told = self.gaps_of.as_ref().is_some_and(|told| Arc::ptr_eq(told, &time));
            if !gaps.is_empty() && !told {
                let seconds: f64 = gaps.iter().map(|gap| gap.end - gap.start).sum();
                let longest = gaps.iter().map(|gap| gap.end - gap.start).fold(0.0, f64::max);
                let message =
                    format!("{} gaps, {seconds:.3} s together, the longest {longest:.3} s", gaps.len());
                self.remarks.warn(None, Some(&signal.label.name), message);
                self.gaps_of = Some(time.clone());
            }
        }
        let channel = Channel {
            name: signal.label.name.clone(),
            sampling: signal.sampling,
            unit: ChannelUnit::Unitless,
            time,
            values,
            gaps,
        };
        (channel, missing)
    }

    fn number(&mut self, signals: &mut Vec<Signal>, field: ChannelField) -> Option<Channel<f64>> {
        let signal = self.take(signals, field)?;
        let SignalData::Numbers(numbers) = &signal.data else { return None };
        let (mut channel, missing) =
            self.channel(&signal, |at| Some(numbers[at]).filter(|value| value.is_finite()));
        if 0 < missing {
            let message = format!("{missing} of {} values are missing", numbers.len());
            self.remarks.warn(None, Some(&channel.name), message);
        }
        channel.unit = self.scale(field, &signal.label, &channel);
        if let ChannelUnit::Stated(unit) = channel.unit
            && unit.factor != 1.0
        {
            channel.values.iter_mut().for_each(|value| *value *= unit.factor);
        }
        Some(channel)
    }

    /// Returns the unit of a channel whose values are still as in the file, and adds a remark if the file
    /// states none.
    fn scale(&mut self, field: ChannelField, label: &ChannelLabel, channel: &Channel<f64>) -> ChannelUnit {
        let assumed = |remarks: &mut RecordingRemarks, unit: LogUnit| {
            remarks.info(Some(&label.name), format!("no unit stated: taken to be in {}", unit.symbol));
            ChannelUnit::Stated(unit)
        };
        let unstated = |remarks: &mut RecordingRemarks, units: &'static [LogUnit]| {
            let symbols: Vec<&str> = units.iter().map(|unit| unit.symbol).collect();
            let message =
                format!("no unit stated: may be {}; the length of the path decides", symbols.join(", "));
            remarks.info(Some(&label.name), message);
            ChannelUnit::Unstated(units)
        };
        match (label.unit, field) {
            (Some(unit), _) => ChannelUnit::Stated(unit),
            (None, ChannelField::Position(..)) => unstated(self.remarks, LENGTHS),
            (None, ChannelField::Feed(_)) => unstated(self.remarks, FEEDS),
            (None, ChannelField::SpindleSpeed) => assumed(self.remarks, RPM),
            (None, ChannelField::FeedOverride | ChannelField::RapidOverride) => {
                let largest = channel.extent().map_or(0.0, |(_, largest)| largest);
                assumed(self.remarks, if MAX_OVERRIDE_RATIO < largest { PERCENT } else { RATIO })
            }
            _ => ChannelUnit::Unitless,
        }
    }

    fn line(&mut self, signals: &mut Vec<Signal>) -> Option<Channel<u32>> {
        let signal = self.take(signals, ChannelField::Line)?;
        let SignalData::Numbers(numbers) = &signal.data else { return None };
        let is_line = |value: f64| value.fract() == 0.0 && 0.0 <= value && value <= f64::from(u32::MAX);
        let (channel, missing) =
            self.channel(&signal, |at| is_line(numbers[at]).then_some(numbers[at] as u32));
        if 0 < missing {
            let message = format!("{missing} of {} values are missing or no line numbers", numbers.len());
            self.remarks.warn(None, Some(&channel.name), message);
        }
        (!channel.values.is_empty()).then_some(channel)
    }

    fn text(&mut self, signals: &mut Vec<Signal>, field: ChannelField) -> Option<Channel<String>> {
        let signal = self.take(signals, field)?;
        let SignalData::Texts(texts) = &signal.data else { return None };
        let clean = |text: &str| match number(text, false) {
            // Adapters that write only numbers write tools as 21.000000.
            CellContent::Number(value) if field == ChannelField::Tool && value.fract() == 0.0 => {
                format!("{value:.0}")
            }
            _ => text.to_owned(),
        };
        let (channel, _) = self.channel(&signal, |at| texts[at].as_deref().map(clean));
        (!channel.values.is_empty()).then_some(channel)
    }

    fn status(&mut self, signals: &mut Vec<Signal>) -> Option<Channel<Status>> {
        let signal = self.take(signals, ChannelField::Status)?;
        let SignalData::Texts(texts) = &signal.data else { return None };
        let (channel, _) = self.channel(&signal, |at| texts[at].as_deref().and_then(status));
        if let Some(word) = texts.iter().flatten().find(|word| status(word).is_none()) {
            let message = format!("`{word}` is no known status; such values are left out");
            self.remarks.warn(None, Some(&signal.label.name), message);
        }
        (!channel.values.is_empty()).then_some(channel)
    }
}

/// Returns the status that a word names: MTConnect's Execution and the words of Hurco, Okuma and LinuxCNC.
fn status(word: &str) -> Option<Status> {
    let word = word.trim().to_ascii_uppercase().replace([' ', '-'], "_");
    Some(match word.as_str() {
        "ACTIVE" | "RUNNING" | "RUN" | "EXECUTING" | "START" => Status::Active,
        "FEED_HOLD" | "HOLD" | "INTERRUPTED" | "PAUSED" => Status::Held,
        "PROGRAM_STOPPED" | "STOPPED" | "STOP" | "OPTIONAL_STOP" | "PROGRAM_OPTIONAL_STOP" | "WAIT" => {
            Status::Stopped
        }
        "PROGRAM_COMPLETED" | "COMPLETED" | "FINISHED" | "END" => Status::Ended,
        "READY" | "IDLE" | "RESET" => Status::Idle,
        _ => return None,
    })
}

/// Returns the ranges from every event UNAVAILABLE to the next value.
fn unavailable<V>(time: &[f64], values: &[Option<V>]) -> Vec<Range<f64>> {
    let mut gaps = Vec::new();
    let mut since = None;
    for (stamp, value) in time.iter().zip(values) {
        match (value, since) {
            (None, None) => since = Some(*stamp),
            (Some(_), Some(from)) => {
                gaps.push(from..*stamp);
                since = None;
            }
            _ => {}
        }
    }
    if let Some(from) = since {
        gaps.push(from..f64::INFINITY);
    }
    gaps
}

/// Returns the ranges of missing samples between ascending stamps.
fn gaps_between(time: &[f64]) -> Vec<Range<f64>> {
    let steps: Vec<f64> = time.windows(2).map(|pair| pair[1] - pair[0]).collect();
    if steps.len() < 3 {
        return Vec::new();
    }
    let longest = MIN_GAP_STEPS * median_step(steps);
    let gaps = time.windows(2).filter(|pair| longest < pair[1] - pair[0]);
    gaps.map(|pair| pair[0]..pair[1]).collect()
}

/// Returns the earliest of `stamps` (ns), and all of them in seconds from it.
pub(super) fn from_origin(stamps: &[i64]) -> (i64, Vec<f64>) {
    let origin = stamps.first().copied().unwrap_or(0);
    (origin, stamps.iter().map(|stamp| seconds(origin, *stamp)).collect())
}
