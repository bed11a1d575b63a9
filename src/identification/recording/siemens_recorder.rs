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
//! The signal CYCLE, or else a first number beyond the list of signals, counts cycles; time is that
//! count × the cycle time, which is [`CYCLE_TIME`] where the header does not give it. DES_POS|n is
//! the setpoint after fine interpolation and ENC_POS|n the encoder (also ENC1_POS, ENC2_POS) of axis
//! n in mm; axes 1 to 3 are X, Y, Z where the header names none. Block events give line, block and
//! tool on change, low-frequency data the rest, both at their count.
//!
//! Source: Siemens Industrial Operations X documentation, "Data output format". Left out: chains of
//! files (each is read alone), HFCallEvent, ExternalData, motor and current signals. The whole tree
//! is held in memory: some ten times the file.

use serde_json::Value;
use std::collections::HashMap;

use crate::identification::recording::assemble::{Capture, Data, Signal};
use crate::identification::recording::clock::{iso, stretches};
use crate::identification::recording::events::{name_not_read, signal};
use crate::identification::recording::field::{Field, Label, Side};
use crate::identification::recording::text::is_plausible;
use crate::identification::recording::unit::MM;
use crate::identification::recording::{RecordingError, Remarks, Sampling};

/// Position-control cycle where the header gives none, s.
pub const CYCLE_TIME: f64 = 2e-3;

const MILLISECONDS: f64 = 1e-3;

/// Reads a recorder file.
pub(super) fn read(text: &str, remarks: &mut Remarks) -> Result<Vec<Capture>, RecordingError> {
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
    let cycle_column = labels.iter().position(|label| label.field == Some(Field::SampleNumber));
    let cycle = match header.get("CycleTimeMs").and_then(as_number).filter(|cycle| 0.0 < *cycle) {
        Some(milliseconds) => milliseconds * MILLISECONDS,
        None => {
            let message =
                format!("no cycle time in the header: taken to be {} ms", CYCLE_TIME / MILLISECONDS);
            remarks.warn(None, None, message);
            CYCLE_TIME
        }
    };
    let mut counts: Vec<f64> = Vec::new();
    let mut columns: Vec<Vec<f64>> = vec![Vec::new(); labels.len()];
    let mut events: HashMap<String, (Label, Vec<(f64, String)>)> = HashMap::new();
    let mut unread: Vec<String> =
        labels.iter().filter(|l| l.field.is_none()).map(|l| l.name.clone()).collect();
    for part in payload {
        for row in part.get("HFData").and_then(Value::as_array).into_iter().flatten() {
            let Some(row) = row.as_array() else { continue };
            let shift = usize::from(row.len() == labels.len() + 1);
            let count = match cycle_column {
                Some(at) => row.get(at + shift),
                None if shift == 1 => row.first(),
                None => None,
            };
            let next = counts.last().map_or(0.0, |last| last + 1.0);
            counts.push(count.map_or(Some(next), as_number).unwrap_or(f64::NAN));
            for (at, column) in columns.iter_mut().enumerate().filter(|(at, _)| labels[*at].field.is_some()) {
                column.push(row.get(at + shift).and_then(as_number).unwrap_or(f64::NAN));
            }
        }
        if let Some(event) = part.get("HFBlockEvent") {
            let count = event.get("HFProbeCounter").and_then(as_number);
            for (name, field) in
                [("SeekOffset", Field::Line), ("GCode", Field::Block), ("ActiveTool", Field::Tool)]
            {
                if let (Some(count), Some(value)) = (count, event.get(name).and_then(as_text)) {
                    let label = Label { name: name.to_owned(), field: Some(field), unit: None };
                    events.entry(name.to_owned()).or_insert((label, Vec::new())).1.push((count, value));
                }
            }
        }
        for row in part.get("LFData").and_then(Value::as_array).into_iter().flatten() {
            let count = row.get("HFProbeCounter").or(row.get("HfProbeCounter")).and_then(as_number);
            let address = row.get("address").or(row.get("Address")).and_then(Value::as_str).unwrap_or("");
            let value = row.get("value").or(row.get("Value")).and_then(as_text);
            let (Some(count), Some(value)) = (count, value) else { continue };
            let last = address.rsplit('/').next().unwrap_or(address);
            let name = last.split('[').next().unwrap_or(last);
            let known =
                events.entry(address.to_owned()).or_insert_with(|| (Label::read(name, None), Vec::new()));
            known.1.push((count, value));
        }
    }
    let first = counts.iter().copied().find(|count| count.is_finite()).unwrap_or(0.0);
    let stamps: Vec<f64> = counts.iter().map(|count| (count - first) * cycle).collect();
    let mut signals = Vec::new();
    if !stamps.is_empty() {
        let same = |a: usize, b: usize| {
            columns.iter().all(|column| column.is_empty() || column[a].to_bits() == column[b].to_bits())
        };
        let parts = stretches(&stamps, |row| row + 1, same, remarks)?;
        if let Some(part) = parts.into_iter().max_by_key(|part| part.rows.len()) {
            let time: std::sync::Arc<[f64]> = part.time.into();
            for (label, column) in labels.into_iter().zip(&columns) {
                if matches!(label.field, None | Some(Field::SampleNumber)) {
                    continue;
                }
                let data = Data::Numbers(part.rows.iter().map(|row| column[*row]).collect());
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

/// The signals of the header, in the order of a row.
fn labels(header: &Value) -> Vec<Label> {
    let list = header.get("SignalListHFData").and_then(Value::as_array);
    let label = |signal: &Value| {
        let text = |key: &str| signal.get(key).and_then(Value::as_str).unwrap_or("");
        let address = if text("Address").is_empty() { text("Name") } else { text("Address") };
        let mut label = Label::read(address, None);
        if address.eq_ignore_ascii_case("CYCLE") {
            label.field = Some(Field::SampleNumber);
        }
        let side = match address.split('|').next().unwrap_or("") {
            "DES_POS" => Some(Side::Commanded),
            "ENC_POS" | "ENC1_POS" | "ENC2_POS" => Some(Side::Actual),
            _ => None,
        };
        let axis = match text("Axis").trim_end_matches('1') {
            "X" => Some(0),
            "Y" => Some(1),
            "Z" => Some(2),
            "" => None,
            // An axis with another name is no linear axis of the three.
            _ => Some(3),
        };
        if let (Some(side), Some(axis)) = (side, axis) {
            label.field = (axis < 3).then_some(Field::Position(side, axis));
        }
        if matches!(label.field, Some(Field::Position(..))) {
            label.unit = Some(MM);
        }
        label
    };
    list.into_iter().flatten().map(label).collect()
}

/// A number, also one written as text.
fn as_number(value: &Value) -> Option<f64> {
    value.as_f64().or_else(|| value.as_str()?.trim().parse().ok()).filter(|number| is_plausible(*number))
}

/// A value as text; null is none.
fn as_text(value: &Value) -> Option<String> {
    match value {
        Value::String(text) => Some(text.clone()),
        Value::Number(number) => Some(number.to_string()),
        Value::Bool(truth) => Some(truth.to_string()),
        _ => None,
    }
}
