//! MTConnect streams: the XML an agent answers `/sample` or `/current` with.
//!
//! ```text
//! <DeviceStream> <ComponentStream component="Linear" name="X">
//!   <Samples> <Position dataItemId="x2" subType="ACTUAL" timestamp="2022-08-08T13:51:34.7Z">1.5</Position>
//!   <Events>  <Execution dataItemId="e1" timestamp="…">ACTIVE</Execution>
//! ```
//!
//! An agent has converted to the standard's units: MILLIMETER, MILLIMETER/SECOND, PERCENT,
//! REVOLUTION/MINUTE. What is read: Position of a linear axis named X, Y or Z, PathPosition,
//! PathFeedrate, PathFeedrateOverride and the older PathFeedrate of subtype OVERRIDE, Line,
//! LineNumber, Block, Execution, Program, ToolNumber, ToolId, RotaryVelocity and SpindleSpeed.
//! Values hold until the next of the item. Components follow each other in the file, so stamps
//! ascend within an item only; each item is put in order of its stamps. Several answers one after
//! the other in a file, as a saved stream has them, are one recording; observations they share
//! count once.
//!
//! Source: MTConnect Part 3. Left out: time series, data sets, conditions, several devices (the
//! first one with motion is read).

use std::collections::HashMap;

use crate::identification::recording::assemble::{Capture, Signal};
use crate::identification::recording::clock::{iso, seconds};
use crate::identification::recording::events::{name_not_read, signal};
use crate::identification::recording::field::{Field, Label, Side};
use crate::identification::recording::unit::{MM, MM_PER_S, PERCENT, RPM, Unit};
use crate::identification::recording::{RecordingError, Remarks};

/// End of one document.
const END: &str = "</MTConnectStreams>";

/// One observation.
struct Observation {
    device: String,
    item: String,
    label: Label,
    stamp: i64,
    value: String,
}

/// Reads one or more streams documents.
pub(super) fn read(text: &str, remarks: &mut Remarks) -> Result<Vec<Capture>, RecordingError> {
    let mut observations = Vec::new();
    let mut unread = Vec::new();
    let mut rest = text;
    let mut line = 1;
    let mut documents = 0;
    while let Some(start) = document_start(rest) {
        let end = rest.find(END).map_or(rest.len(), |at| at + END.len());
        if end <= start {
            rest = &rest[end..];
            continue;
        }
        let before = line + rest[..start].matches('\n').count();
        match document(&rest[start..end], before, &mut observations, &mut unread) {
            Ok(()) => documents += 1,
            // A stream that was cut off ends within a document.
            Err(error) if 0 < documents => {
                remarks.warn(Some(before), None, format!("the last document is left out: {error}"));
            }
            Err(error) => return Err(error),
        }
        line += rest[..end].matches('\n').count();
        rest = &rest[end..];
    }
    name_not_read(unread, remarks);
    let device = |observation: &Observation| observation.device.clone();
    let moves = |observation: &&Observation| {
        matches!(
            observation.label.field,
            Some(Field::Position(..) | Field::Point(_) | Field::Feed(_) | Field::Line)
        )
    };
    let Some(device) = observations.iter().find(moves).or(observations.first()).map(device) else {
        return Err(RecordingError::Missing("the streams hold no observation that tells of motion"));
    };
    let origin = observations.iter().map(|observation| observation.stamp).min().unwrap_or(0);
    let mut index: HashMap<String, usize> = HashMap::new();
    let mut items: Vec<(Label, Vec<(f64, &str)>)> = Vec::new();
    for observation in observations.iter().filter(|observation| observation.device == device) {
        let at = *index.entry(observation.item.clone()).or_insert_with(|| {
            items.push((observation.label.clone(), Vec::new()));
            items.len() - 1
        });
        items[at].1.push((seconds(origin, observation.stamp), &observation.value));
    }
    let signals: Vec<Signal> =
        items.into_iter().map(|(label, events)| signal(label, events, remarks)).collect();
    Ok(vec![Capture { origin: Some(origin), signals }])
}

/// Where the next document begins, without its declaration.
fn document_start(text: &str) -> Option<usize> {
    text.match_indices("MTConnectStreams")
        .map(|(at, _)| &text[..at])
        .find(|before| {
            before.ends_with('<') || before.rsplit('<').next().is_some_and(|prefix| prefix.ends_with(':'))
        })
        .map(|before| before.rfind('<').unwrap_or(0))
}

fn document(
    text: &str,
    line: usize,
    observations: &mut Vec<Observation>,
    unread: &mut Vec<String>,
) -> Result<(), RecordingError> {
    let document = parse(text, line)?;
    for node in document.descendants() {
        let name = node.tag_name().name();
        let is_observation = node
            .parent_element()
            .is_some_and(|parent| matches!(parent.tag_name().name(), "Samples" | "Events"));
        let (true, Some(stamp)) = (is_observation, node.attribute("timestamp").and_then(iso)) else {
            continue;
        };
        let component = node.parent_element().and_then(|samples| samples.parent_element());
        let device = component.and_then(|component| component.parent_element());
        let axis = component.and_then(|c| c.attribute("name").or(c.attribute("nativeName"))).unwrap_or("");
        let sub_type = node.attribute("subType").unwrap_or("");
        let item = node.attribute("dataItemId").unwrap_or(name);
        let Some((field, unit)) = field(name, sub_type, axis) else {
            if unread.last().is_none_or(|last| last != name) {
                unread.push(name.to_owned());
            }
            continue;
        };
        observations.push(Observation {
            device: device
                .and_then(|device| device.attribute("uuid").or(device.attribute("name")))
                .unwrap_or("")
                .to_owned(),
            item: item.to_owned(),
            label: Label { name: item.to_owned(), field: Some(field), unit },
            stamp,
            value: node.text().unwrap_or("").trim().to_owned(),
        });
    }
    unread.sort();
    unread.dedup();
    Ok(())
}

/// What an observation tells, and in what unit.
fn field(name: &str, sub_type: &str, axis: &str) -> Option<(Field, Option<Unit>)> {
    let side = match sub_type {
        "COMMANDED" | "PROGRAMMED" => Side::Commanded,
        "ACTUAL" => Side::Actual,
        _ => Side::Unstated,
    };
    Some(match name {
        "Position" => {
            let axis = match axis.to_ascii_uppercase().as_str() {
                "X" | "X1" => 0,
                "Y" | "Y1" => 1,
                "Z" | "Z1" => 2,
                _ => return None,
            };
            (Field::Position(side, axis), Some(MM))
        }
        "PathPosition" => (Field::Point(side), Some(MM)),
        "PathFeedrateOverride" if sub_type == "RAPID" => (Field::RapidOverride, Some(PERCENT)),
        "PathFeedrateOverride" if sub_type == "JOG" => return None,
        "PathFeedrateOverride" => (Field::FeedOverride, Some(PERCENT)),
        "PathFeedrate" if sub_type == "OVERRIDE" => (Field::FeedOverride, Some(PERCENT)),
        "PathFeedrate" if sub_type == "RAPID" || sub_type == "JOG" => return None,
        "PathFeedrate" => (Field::Feed(side), Some(MM_PER_S)),
        "Line" | "LineNumber" => (Field::Line, None),
        "Block" => (Field::Block, None),
        "Execution" => (Field::Status, None),
        "Program" => (Field::Program, None),
        "ToolNumber" | "ToolId" => (Field::Tool, None),
        "RotaryVelocity" | "SpindleSpeed" if sub_type != "OVERRIDE" && side != Side::Commanded => {
            (Field::SpindleSpeed, Some(RPM))
        }
        _ => return None,
    })
}

/// Parses XML whose first line is `line` of the file.
pub(super) fn parse(text: &str, line: usize) -> Result<roxmltree::Document<'_>, RecordingError> {
    if let Some(at) = too_many_attributes(text) {
        let line = line + text[..at].matches('\n').count();
        let message = format!("an element has more than {MAX_ATTRIBUTES} attributes");
        return Err(RecordingError::Syntax { line, column: 1, message });
    }
    roxmltree::Document::parse(text).map_err(|error| {
        let at = error.pos();
        let message = format!("the XML is not well-formed: {error}");
        RecordingError::Syntax { line: line + at.row as usize - 1, column: at.col as usize, message }
    })
}

/// Attributes of an element at most: the parser compares each with all before it.
const MAX_ATTRIBUTES: usize = 256;

/// Where an element with more than [`MAX_ATTRIBUTES`] begins, if there is one.
fn too_many_attributes(text: &str) -> Option<usize> {
    let bytes = text.as_bytes();
    let (mut tag, mut quote, mut attributes) = (None, None, 0);
    for (at, byte) in bytes.iter().copied().enumerate() {
        match (tag, quote) {
            (None, _) => {
                // Comments, declarations and instructions have no attributes, and quotes that may stand alone.
                if byte == b'<' && !matches!(bytes.get(at + 1), Some(b'!' | b'?')) {
                    (tag, attributes) = (Some(at), 0);
                }
            }
            (Some(_), Some(open)) if byte == open => quote = None,
            (Some(_), Some(_)) => {}
            (Some(begin), None) => match byte {
                b'"' | b'\'' => quote = Some(byte),
                b'>' => tag = None,
                b'=' => {
                    attributes += 1;
                    if MAX_ATTRIBUTES < attributes {
                        return Some(begin);
                    }
                }
                _ => {}
            },
        }
    }
    None
}
