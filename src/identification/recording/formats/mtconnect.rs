//! MTConnect streams: the XML with which an agent answers `/sample` or `/current`.
//!
//! ```text
//! <DeviceStream> <ComponentStream component="Linear" name="X">
//!   <Samples> <Position dataItemId="x2" subType="ACTUAL" timestamp="2022-08-08T13:51:34.7Z">1.5</Position>
//!   <Events>  <Execution dataItemId="e1" timestamp="…">ACTIVE</Execution>
//! ```
//!
//! Agents convert values to the units of the standard: MILLIMETER, MILLIMETER/SECOND, PERCENT,
//! REVOLUTION/MINUTE. The reader reads Position of a linear axis named X, Y or Z, PathPosition, PathFeedrate,
//! PathFeedrateOverride and the older PathFeedrate of subtype OVERRIDE, Line, LineNumber, Block, Execution,
//! Program, ToolNumber, ToolId, RotaryVelocity and SpindleSpeed. A value holds until the next one of its
//! item. Components follow one another in the file, so that stamps ascend only within an item; each item is
//! sorted by its stamps. Several consecutive answers in a file, as in a saved stream, are one recording; an
//! observation that occurs in several of them counts once.
//!
//! Source: MTConnect Part 3. Not read: time series, data sets, conditions, several devices (the first one
//! with motion is read).

use std::collections::HashMap;

use crate::identification::recording::assemble::{Capture, Signal};
use crate::identification::recording::clock::{iso, seconds};
use crate::identification::recording::field::{ChannelField, ChannelLabel, LoopSide};
use crate::identification::recording::formats::events::{name_not_read, signal};
use crate::identification::recording::unit::{LogUnit, MM, MM_PER_S, PERCENT, RPM};
use crate::identification::recording::{RecordingError, RecordingRemarks};

/// End of a document.
const DOCUMENT_END: &str = "</MTConnectStreams>";

/// One observation.
struct Observation {
    device: String,
    item: String,
    label: ChannelLabel,
    stamp: i64,
    value: String,
}

/// Reads one or more documents.
pub(in crate::identification::recording) fn read(
    text: &str,
    remarks: &mut RecordingRemarks,
) -> Result<Vec<Capture>, RecordingError> {
    let mut observations = Vec::new();
    let mut unread = Vec::new();
    let mut rest = text;
    let mut line = 1;
    let mut documents = 0;
    while let Some(start) = document_start(rest) {
        let end = rest.find(DOCUMENT_END).map_or(rest.len(), |at| at + DOCUMENT_END.len());
        if end <= start {
            rest = &rest[end..];
            continue;
        }
        let before = line + rest[..start].matches('\n').count();
        match document(&rest[start..end], before, &mut observations, &mut unread) {
            Ok(()) => documents += 1,
            // An interrupted stream ends within a document.
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
            Some(
                ChannelField::Position(..)
                    | ChannelField::Point(_)
                    | ChannelField::Feed(_)
                    | ChannelField::Line
            )
        )
    };
    let Some(device) = observations.iter().find(moves).or(observations.first()).map(device) else {
        return Err(RecordingError::Missing("the streams contain no observation of motion"));
    };
    let origin = observations.iter().map(|observation| observation.stamp).min().unwrap_or(0);
    let mut index: HashMap<String, usize> = HashMap::new();
    let mut items: Vec<(ChannelLabel, Vec<(f64, &str)>)> = Vec::new();
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

/// Returns the beginning of the next document, without its declaration.
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
            label: ChannelLabel { name: item.to_owned(), field: Some(field), unit },
            stamp,
            value: node.text().unwrap_or("").trim().to_owned(),
        });
    }
    unread.sort();
    unread.dedup();
    Ok(())
}

/// Returns the field of an observation, with its unit; `None` if it is not read.
fn field(name: &str, sub_type: &str, axis: &str) -> Option<(ChannelField, Option<LogUnit>)> {
    let side = match sub_type {
        "COMMANDED" | "PROGRAMMED" => LoopSide::Commanded,
        "ACTUAL" => LoopSide::Actual,
        _ => LoopSide::Unstated,
    };
    Some(match name {
        "Position" => {
            let axis = match axis.to_ascii_uppercase().as_str() {
                "X" | "X1" => 0,
                "Y" | "Y1" => 1,
                "Z" | "Z1" => 2,
                _ => return None,
            };
            (ChannelField::Position(side, axis), Some(MM))
        }
        "PathPosition" => (ChannelField::Point(side), Some(MM)),
        "PathFeedrateOverride" if sub_type == "RAPID" => (ChannelField::RapidOverride, Some(PERCENT)),
        "PathFeedrateOverride" if sub_type == "JOG" => return None,
        "PathFeedrateOverride" => (ChannelField::FeedOverride, Some(PERCENT)),
        "PathFeedrate" if sub_type == "OVERRIDE" => (ChannelField::FeedOverride, Some(PERCENT)),
        "PathFeedrate" if sub_type == "RAPID" || sub_type == "JOG" => return None,
        "PathFeedrate" => (ChannelField::Feed(side), Some(MM_PER_S)),
        "Line" | "LineNumber" => (ChannelField::Line, None),
        "Block" => (ChannelField::Block, None),
        "Execution" => (ChannelField::Status, None),
        "Program" => (ChannelField::Program, None),
        "ToolNumber" | "ToolId" => (ChannelField::Tool, None),
        "RotaryVelocity" | "SpindleSpeed" if sub_type != "OVERRIDE" && side != LoopSide::Commanded => {
            (ChannelField::SpindleSpeed, Some(RPM))
        }
        _ => return None,
    })
}

/// Parses XML whose first line is `line` of the file.
pub(in crate::identification::recording) fn parse(
    text: &str,
    line: usize,
) -> Result<roxmltree::Document<'_>, RecordingError> {
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

/// Most attributes of an element: the parser compares each with all before it.
const MAX_ATTRIBUTES: usize = 256;

/// Returns the offset of an element with more than [`MAX_ATTRIBUTES`]; `None` if there is none.
fn too_many_attributes(text: &str) -> Option<usize> {
    let bytes = text.as_bytes();
    let (mut tag, mut quote, mut attributes) = (None, None, 0);
    for (at, byte) in bytes.iter().copied().enumerate() {
        match (tag, quote) {
            (None, _) => {
                // Comments, declarations and instructions have no attributes, and may contain single quotes.
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
