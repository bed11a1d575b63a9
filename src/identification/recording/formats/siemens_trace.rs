//! Trace of a SINUMERIK control, saved as XML.
//!
//! ```text
//! <traceDisplaySetup> <signals> <signal key="3" name="…" description="X1 actual position"/> …
//! <traceData> <dataFrame>
//!   <dataSignal id="f1" key="3" interval="0.002"/> …
//!   <rec time="0.002" f1="12.5" f2="0.1"/>
//!   <rec time="0.004" f1="12.6"/>
//! ```
//!
//! `time` is in s. A record contains only the signals sampled at its moment, so that every signal has its own
//! stamps. The name of a record's attribute is the `id` of a `dataSignal`, whose `key` also names a `signal`;
//! the order of either is meaningless. Without `dataSignal`s, `fN` is the N-th signal. A signal is identified
//! by its description, or else by its name; units are rarely given: mm or inch, by the basic system of the
//! machine. Truth values become 0 and 1.
//!
//! Source: readers of such files (Trace-Tools, sinumerik oscilloscopes); no published schema. Not read:
//! several data frames (only the longest is read), response tests (`ResponseTestCustom`).

use roxmltree::{Document, Node};
use std::collections::HashMap;

use crate::identification::recording::assemble::{Capture, Signal, SignalData};
use crate::identification::recording::clock::{iso, split_recordings};
use crate::identification::recording::field::ChannelLabel;
use crate::identification::recording::formats::events::name_not_read;
use crate::identification::recording::formats::mtconnect::parse;
use crate::identification::recording::text::{CellContent, number};
use crate::identification::recording::unit::LogUnit;
use crate::identification::recording::{RecordingError, RecordingRemarks, Sampling};

/// Reads a trace.
pub(in crate::identification::recording) fn read(
    text: &str,
    remarks: &mut RecordingRemarks,
) -> Result<Vec<Capture>, RecordingError> {
    let document = parse(text.trim_start_matches('\u{feff}'), 1)?;
    let frames = document.descendants().filter(|node| node.tag_name().name() == "dataFrame");
    let records = |frame: &Node| frame.children().filter(|node| node.has_tag_name("rec")).count();
    let Some(frame) = frames.max_by_key(records) else {
        return Err(RecordingError::UnknownFormat(
            "XML that is neither MTConnect streams nor a SINUMERIK trace (no `dataFrame`)",
        ));
    };
    let labels = labels(&document, &frame);
    let mut index: HashMap<&str, usize> = HashMap::new();
    let mut values: Vec<(ChannelLabel, Vec<f64>, Vec<f64>)> = Vec::new();
    let mut stamps = 0;
    for record in frame.children().filter(|node| node.has_tag_name("rec")) {
        let Some(CellContent::Number(time)) = record.attribute("time").map(|time| number(time, true)) else {
            continue;
        };
        stamps += 1;
        for attribute in record.attributes() {
            let Some(label) = labels.get(attribute.name()).filter(|label| label.field.is_some()) else {
                continue;
            };
            let at = *index.entry(attribute.name()).or_insert_with(|| {
                values.push((label.clone(), Vec::new(), Vec::new()));
                values.len() - 1
            });
            let value = match attribute.value() {
                "true" => 1.0,
                "false" => 0.0,
                text => match number(text, true) {
                    CellContent::Number(value) => value,
                    _ => f64::NAN,
                },
            };
            values[at].1.push(time);
            values[at].2.push(value);
        }
    }
    if stamps == 0 {
        return Err(RecordingError::Missing("the trace has no record with a time"));
    }
    name_not_read(labels.values().filter(|l| l.field.is_none()).map(|l| l.name.clone()).collect(), remarks);
    if values.is_empty() {
        return Err(RecordingError::NothingKnown {
            found: labels.into_values().map(|label| label.name).collect(),
        });
    }
    let mut signals = Vec::with_capacity(values.len());
    for (label, time, values) in values {
        // Lines of an XML file are unrelated to records, so that remarks use the number of the record.
        let parts = split_recordings(
            &time,
            |row| row + 1,
            |a, b| values[a].to_bits() == values[b].to_bits(),
            remarks,
        )?;
        let Some(part) = parts.into_iter().max_by_key(|part| part.rows.len()) else { continue };
        let data = part.rows.iter().map(|row| values[*row]);
        let data = if label.field.is_some_and(|field| field.is_text()) {
            SignalData::Texts(data.map(|value| value.is_finite().then(|| value.to_string())).collect())
        } else {
            SignalData::Numbers(data.collect())
        };
        signals.push(Signal { label, sampling: Sampling::Sampled, time: part.time.into(), data });
    }
    let header = frame.children().find(|node| node.has_tag_name("frameHeader"));
    let origin = header
        .and_then(|header| header.attribute("startTime"))
        .filter(|text| text.contains('-'))
        .and_then(iso);
    Ok(vec![Capture { origin, signals }])
}

/// Returns the meaning of a record's attributes: by `dataSignal`, or by the order of the signals if there is
/// none.
fn labels(document: &Document, frame: &Node) -> HashMap<String, ChannelLabel> {
    let mut labels_of_keys: HashMap<&str, ChannelLabel> = HashMap::new();
    let mut labels_in_order = Vec::new();
    for node in document.descendants().filter(|node| node.tag_name().name() == "signal") {
        let unit = node.attribute("unit").or(node.attribute("units")).and_then(LogUnit::parse);
        let described = ChannelLabel::read(node.attribute("description").unwrap_or(""), unit);
        let label = if described.field.is_some() {
            described
        } else {
            ChannelLabel::read(node.attribute("name").unwrap_or(""), unit)
        };
        if let Some(key) = node.attribute("key") {
            labels_of_keys.insert(key, label.clone());
        }
        labels_in_order.push(label);
    }
    let mut labels: HashMap<String, ChannelLabel> = HashMap::new();
    for (nth, node) in frame.children().filter(|node| node.has_tag_name("dataSignal")).enumerate() {
        let id = node.attribute("id").map_or_else(|| format!("f{}", nth + 1), str::to_owned);
        let label =
            node.attribute("key").and_then(|key| labels_of_keys.get(key)).or(labels_in_order.get(nth));
        if let Some(label) = label {
            labels.insert(id, label.clone());
        }
    }
    if labels.is_empty() {
        let numbered = labels_in_order.into_iter().enumerate();
        labels = numbered.map(|(nth, label)| (format!("f{}", nth + 1), label)).collect();
    }
    labels
}
