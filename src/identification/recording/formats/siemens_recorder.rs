//! SINUMERIK Edge / Data Recorder: JSON, also in its ZIP archive. Its tables (`…_hfdata.csv`) are read by `table`.
//!
//! ```text
//! { "Header":  { "CycleTimeMs": 2, "Initial": { "Time": "…", "HFProbeCounter": 3214 },
//!                "SignalListHFData": [ { "Name": "…", "Address": "DES_POS|1", "Axis": "X" }, … ] },
//!   "Payload": [ { "HFData": [ [3214, 12.5, …], … ] },           one row a cycle, signals in order
//!                { "HFBlockEvent": { "HFProbeCounter": 3220, "SeekOffset": 17, "GCode": "G1 X10" } },
//!                { "LFData": [ { "address": "…/actFeedRateIpo", "value": 1000, "HFProbeCounter": 3300 } ] },
//!                { "HFTimestamp": { "HFProbeCounter": 3214, "Time": "…" } } ],
//!   "Footer":  … }
//! ```
//!
//! The signal CYCLE, or else a first number in addition to the listed signals, counts cycles. Time is the
//! count times the cycle time, which is [`DEFAULT_CYCLE_TIME_S`] if the header does not give it. DES_POS|n is
//! the setpoint after fine interpolation and ENC_POS|n the encoder (also ENC1_POS, ENC2_POS) of axis n in mm;
//! axes 1 to 3 are X, Y, Z if the header does not name them. Block events give line, block and tool on
//! change, low-frequency data all other fields, each at its count.
//!
//! Source: Siemens Industrial Operations X documentation, "Data output format". Not read: chains of files as
//! a whole (each file is read alone), HFCallEvent, ExternalData, motor and current signals. The whole tree is
//! in memory, about ten times the size of the file.

use serde_json::Value;
use std::collections::HashMap;

use crate::identification::recording::assemble::{Capture, Signal, SignalData};
use crate::identification::recording::clock::{iso, split_recordings};
use crate::identification::recording::field::{ChannelField, ChannelLabel, LoopSide};
use crate::identification::recording::formats::events::{name_not_read, signal};
use crate::identification::recording::text::is_plausible;
use crate::identification::recording::unit::MM;
use crate::identification::recording::{RecordingError, RecordingRemarks, Sampling};

/// Position-control cycle if the header gives none, s.
pub const DEFAULT_CYCLE_TIME_S: f64 = 2e-3;

const SECONDS_PER_MILLISECOND: f64 = 1e-3;

/// Reads a recorder file.
pub(in crate::identification::recording) fn read(
    text: &str,
    remarks: &mut RecordingRemarks,
) -> Result<Vec<Capture>, RecordingError> {
    let root: Value = serde_json::from_str(text).map_err(|error| RecordingError::Syntax {
        line: error.line(),
        column: error.column(),
        message: format!("the JSON is not well-formed: {error}"),
    })?;
    let (Some(header), Some(payload)) = (root.get("Header"), root.get("Payload").and_then(Value::as_array))
    else {
        return Err(RecordingError::UnknownFormat(
            "JSON without the Header and Payload of a SINUMERIK recorder",
        ));
    };
    let labels = labels(header);
    let cycle = match header.get("CycleTimeMs").and_then(as_number).filter(|cycle| 0.0 < *cycle) {
        Some(milliseconds) => milliseconds * SECONDS_PER_MILLISECOND,
        None => {
            let message = format!(
                "no cycle time in the header: assumed to be {} ms",
                DEFAULT_CYCLE_TIME_S / SECONDS_PER_MILLISECOND
            );
            remarks.warn(None, None, message);
            DEFAULT_CYCLE_TIME_S
        }
    };
    let mut unread: Vec<String> =
        labels.iter().filter(|l| l.field.is_none()).map(|l| l.name.clone()).collect();
    let mut samples = CycleSamples { counts: Vec::new(), columns: vec![Vec::new(); labels.len()] };
    let mut events = HeldEvents::new();
    for part in payload {
        samples.read(part, &labels);
        read_block_event(part, &mut events);
        read_slow_data(part, &mut events);
    }
    let first = samples.counts.iter().copied().find(|count| count.is_finite()).unwrap_or(0.0);
    let stamps: Vec<f64> = samples.counts.iter().map(|count| (count - first) * cycle).collect();
    let mut signals = Vec::new();
    if !stamps.is_empty() {
        let columns = &samples.columns;
        let same = |a: usize, b: usize| {
            columns.iter().all(|column| column.is_empty() || column[a].to_bits() == column[b].to_bits())
        };
        let parts = split_recordings(&stamps, |row| row + 1, same, remarks)?;
        if let Some(part) = parts.into_iter().max_by_key(|part| part.rows.len()) {
            let time: std::sync::Arc<[f64]> = part.time.into();
            for (label, column) in labels.into_iter().zip(columns) {
                if matches!(label.field, None | Some(ChannelField::SampleNumber)) {
                    continue;
                }
                let data = SignalData::Numbers(part.rows.iter().map(|row| column[*row]).collect());
                signals.push(Signal { label, sampling: Sampling::Sampled, time: time.clone(), data });
            }
        }
    }
    let mut names: Vec<&String> = events.keys().collect();
    names.sort();
    for name in names {
        let (label, events) = &events[name];
        if label.field.is_none() {
            unread.push(label.name.clone());
            continue;
        }
        let events = events.iter().map(|(count, value)| ((count - first) * cycle, value.as_str())).collect();
        signals.push(signal(label.clone(), events, remarks));
    }
    name_not_read(unread, remarks);
    let origin =
        header.get("Initial").and_then(|initial| initial.get("Time")).and_then(Value::as_str).and_then(iso);
    Ok(vec![Capture { origin, signals }])
}

/// The rows of all parts of the payload.
struct CycleSamples {
    /// Count of cycles of each row; NaN if it is no number.
    counts: Vec<f64>,
    /// Values of each signal that is read, one per row; empty for the others.
    columns: Vec<Vec<f64>>,
}

impl CycleSamples {
    /// Adds the rows of a part.
    fn read(&mut self, part: &Value, labels: &[ChannelLabel]) {
        let cycle_column = labels.iter().position(|label| label.field == Some(ChannelField::SampleNumber));
        for row in part.get("HFData").and_then(Value::as_array).into_iter().flatten() {
            let Some(row) = row.as_array() else { continue };
            let shift = usize::from(row.len() == labels.len() + 1);
            let count = match cycle_column {
                Some(at) => row.get(at + shift),
                None if shift == 1 => row.first(),
                None => None,
            };
            let next = self.counts.last().map_or(0.0, |last| last + 1.0);
            self.counts.push(count.map_or(Some(next), as_number).unwrap_or(f64::NAN));
            for (at, column) in self.columns.iter_mut().enumerate() {
                if labels[at].field.is_some() {
                    column.push(row.get(at + shift).and_then(as_number).unwrap_or(f64::NAN));
                }
            }
        }
    }
}

/// Values on change, by name or address, each with the count of cycles at which it began.
type HeldEvents = HashMap<String, (ChannelLabel, Vec<(f64, String)>)>;

/// Adds line, block and tool of a part's block event.
fn read_block_event(part: &Value, events: &mut HeldEvents) {
    let Some(event) = part.get("HFBlockEvent") else { return };
    let count = event.get("HFProbeCounter").and_then(as_number);
    for (name, field) in [
        ("SeekOffset", ChannelField::Line),
        ("GCode", ChannelField::Block),
        ("ActiveTool", ChannelField::Tool),
    ] {
        if let (Some(count), Some(value)) = (count, event.get(name).and_then(as_text)) {
            let label = ChannelLabel { name: name.to_owned(), field: Some(field), unit: None };
            events.entry(name.to_owned()).or_insert((label, Vec::new())).1.push((count, value));
        }
    }
}

/// Adds the low-frequency data of a part.
fn read_slow_data(part: &Value, events: &mut HeldEvents) {
    for row in part.get("LFData").and_then(Value::as_array).into_iter().flatten() {
        let count = row.get("HFProbeCounter").or(row.get("HfProbeCounter")).and_then(as_number);
        let address = row.get("address").or(row.get("Address")).and_then(Value::as_str).unwrap_or("");
        let value = row.get("value").or(row.get("Value")).and_then(as_text);
        let (Some(count), Some(value)) = (count, value) else { continue };
        let last = address.rsplit('/').next().unwrap_or(address);
        let name = last.split('[').next().unwrap_or(last);
        let entry = events.entry(address.to_owned());
        let (_, values) = entry.or_insert_with(|| (ChannelLabel::read(name, None), Vec::new()));
        values.push((count, value));
    }
}

/// Returns the signals of the header, in the order of a row.
fn labels(header: &Value) -> Vec<ChannelLabel> {
    let list = header.get("SignalListHFData").and_then(Value::as_array);
    let label = |signal: &Value| {
        let text = |key: &str| signal.get(key).and_then(Value::as_str).unwrap_or("");
        let address = if text("Address").is_empty() { text("Name") } else { text("Address") };
        let mut label = ChannelLabel::read(address, None);
        if address.eq_ignore_ascii_case("CYCLE") {
            label.field = Some(ChannelField::SampleNumber);
        }
        let side = match address.split('|').next().unwrap_or("") {
            "DES_POS" => Some(LoopSide::Commanded),
            "ENC_POS" | "ENC1_POS" | "ENC2_POS" => Some(LoopSide::Actual),
            _ => None,
        };
        let axis = match text("Axis").trim_end_matches('1') {
            "X" => Some(0),
            "Y" => Some(1),
            "Z" => Some(2),
            "" => None,
            // An axis with another name is not one of the three linear axes.
            _ => Some(3),
        };
        if let (Some(side), Some(axis)) = (side, axis) {
            label.field = (axis < 3).then_some(ChannelField::Position(side, axis));
        }
        if matches!(label.field, Some(ChannelField::Position(..))) {
            label.unit = Some(MM);
        }
        label
    };
    list.into_iter().flatten().map(label).collect()
}

/// Returns a number, including one that is written as text.
fn as_number(value: &Value) -> Option<f64> {
    value.as_f64().or_else(|| value.as_str()?.trim().parse().ok()).filter(|number| is_plausible(*number))
}

/// Returns a value as text; `None` for null.
fn as_text(value: &Value) -> Option<String> {
    match value {
        Value::String(text) => Some(text.clone()),
        Value::Number(number) => Some(number.to_string()),
        Value::Bool(truth) => Some(truth.to_string()),
        _ => None,
    }
}
