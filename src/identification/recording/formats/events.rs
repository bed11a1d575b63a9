//! Event logs: a line states when items changed, and their new values.
//!
//! SHDR, the protocol of MTConnect adapters, and files of it:
//!
//! ```text
//! 2017-02-06T17:40:26.9218750Z|Block_Number|0
//! 2022-08-08T13:51:36.8902584Z|p1block|G138|p1linelabel|NN2|p1BlockNumber|5
//! ```
//!
//! `time|item|value` with any number of pairs; `device:item` and `time@duration` are allowed; lines of
//! commands (`* PING`), assets (`@ASSET@`) and conditions (six fields whose value is NORMAL, WARNING, FAULT
//! or UNAVAILABLE) are skipped. Long tables (`t_s,key,value`) are divided into cells by `table` and become
//! signals here. A value holds until the next event of its item; each item has its own stamps. UNAVAILABLE
//! begins a gap; a silent connection cannot be distinguished from values that do not change. Adapters do not
//! state their units.
//!
//! Source: MTConnect Part 1, "SHDR protocol"; cppagent's demo logs; NIST's smstestbed. Not read: time series
//! and data sets in one value, quoted values that contain `|`.

use std::collections::HashMap;

use crate::identification::recording::assemble::{Capture, Signal, SignalData, from_origin};
use crate::identification::recording::clock::{iso, split_event_recordings};
use crate::identification::recording::diagnostic::is_tolerable;
use crate::identification::recording::field::ChannelLabel;
use crate::identification::recording::text::{CellContent, is_missing, number};
use crate::identification::recording::unit::LogUnit;
use crate::identification::recording::{RecordingError, RecordingRemarks, Sampling};
use crate::simulation::ordered::sort_by_number;

/// Number of lines that determine the format.
const SNIFFED_LINES: usize = 50;

/// Returns `true` if `text` is SHDR: most of its first lines are `stamp|item|value`.
pub(in crate::identification::recording) fn is_shdr(text: &str) -> bool {
    let (mut yes, mut all) = (0, 0);
    for (_, line) in lines(text).take(SNIFFED_LINES) {
        all += 1;
        yes += usize::from(line.split_once('|').is_some_and(|(time, _)| stamp(time).is_some()));
    }
    0 < yes && all < 2 * yes
}

/// Returns the lines of events with their numbers, without blank lines, commands and the bodies of assets
/// between two lines that end in one `--multiline--` mark.
fn lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut asset: Option<&str> = None;
    text.lines().enumerate().map(|(at, line)| (at + 1, line.trim())).filter(move |(_, line)| {
        let mark = line.find("--multiline--").map(|at| &line[at..]);
        match (asset, mark) {
            (None, Some(mark)) => {
                asset = Some(mark);
                false
            }
            (Some(open), Some(mark)) if open == mark => {
                asset = None;
                false
            }
            (open, _) => open.is_none() && !line.is_empty() && !line.starts_with('*'),
        }
    })
}

/// Reads the time of an SHDR line, ns; a duration after `@` is ignored.
fn stamp(text: &str) -> Option<i64> {
    iso(text.split('@').next()?)
}

/// A change of an item.
#[derive(Clone, Copy, Debug)]
pub(in crate::identification::recording) struct ItemEvent<'a> {
    /// Time, s from an origin common to all events.
    pub(in crate::identification::recording) time: f64,
    /// Name of the item.
    pub(in crate::identification::recording) item: &'a str,
    /// New value.
    pub(in crate::identification::recording) value: &'a str,
}

/// Reads SHDR.
pub(in crate::identification::recording) fn read(
    text: &str,
    remarks: &mut RecordingRemarks,
) -> Result<Vec<Capture>, RecordingError> {
    let mut rows: Vec<(usize, &str)> = Vec::new();
    let mut stamps: Vec<i64> = Vec::new();
    let mut bad: Option<(usize, &str)> = None;
    let mut faults = 0;
    let mut first_joined: Option<usize> = None;
    let mut joined = 0;
    for (at, line) in lines(text) {
        match line.split_once('|').and_then(|(time, rest)| Some((stamp(time)?, rest))) {
            // Stamps of assets are from another clock, often of another day.
            Some((_, rest)) if rest.starts_with('@') => {}
            Some((stamp, rest)) => {
                stamps.push(stamp);
                rows.push((at, rest));
            }
            // A value may be on the next line.
            None if !line.contains('|') && rows.last().is_some_and(|(_, rest)| rest.ends_with('|')) => {
                if let Some((_, rest)) = rows.last_mut() {
                    let from = rest.as_ptr() as usize - text.as_ptr() as usize;
                    let to = line.as_ptr() as usize - text.as_ptr() as usize + line.len();
                    *rest = &text[from..to];
                }
                joined += 1;
                first_joined.get_or_insert(at);
            }
            None => {
                faults += 1;
                bad.get_or_insert((at, line));
            }
        }
    }
    // Without a line end the last value may be cut within a number, and still look like a number.
    if !text.ends_with(['\n', '\r'])
        && let Some((line, rest)) = rows.last_mut()
        && let Some((front, value)) = rest.rsplit_once('|')
        && matches!(number(value, true), CellContent::Number(_))
    {
        *rest = front.rsplit_once('|').map_or("", |(front, _)| front);
        remarks.warn(Some(*line), None, "the last line is incomplete: its last value is left out".to_owned());
    }
    if let Some((line, text)) = bad {
        if !is_tolerable(faults, rows.len() + faults) {
            let text = text.chars().take(40).collect();
            return Err(RecordingError::Stamp { line, column: 1, text, count: faults });
        }
        let message = format!("{faults} lines are cut short and left out; this is the first");
        remarks.warn(Some(line), None, message);
    }
    if 0 < joined {
        remarks.warn(
            first_joined,
            None,
            format!("{joined} values are on separate lines: joined to their item"),
        );
    }
    let (origin, seconds) = from_origin(&stamps);
    let stretches = split_event_recordings(&seconds, |row| rows[row].0, remarks)?;
    let mut not_read = Vec::new();
    let mut captures = Vec::with_capacity(stretches.len());
    for stretch in stretches {
        let events = stretch.iter().flat_map(|row| {
            pairs(rows[*row].1).map(|(item, value)| ItemEvent { time: seconds[*row], item, value })
        });
        captures
            .push(Capture { origin: Some(origin), signals: signals(events, &[], &mut not_read, remarks) });
    }
    let is_read = |capture: &Capture| !capture.signals.is_empty();
    if !not_read.is_empty() && !captures.iter().any(is_read) {
        return Err(RecordingError::NothingKnown { found: not_read });
    }
    name_not_read(not_read, remarks);
    Ok(captures)
}

/// Returns the items and values of a line without its stamp.
fn pairs(rest: &str) -> impl Iterator<Item = (&str, &str)> {
    let fields = rest.split('|').count();
    let mut parts = rest.split('|');
    let second = rest.split('|').nth(1).unwrap_or("");
    let is_condition = fields == 6 && matches!(second, "NORMAL" | "WARNING" | "FAULT" | "UNAVAILABLE");
    std::iter::from_fn(move || if is_condition { None } else { Some((parts.next()?, parts.next()?)) })
        .map(|(item, value)| (item.rsplit(':').next().unwrap_or(item).trim(), value.trim()))
        .filter(|(item, _)| !item.is_empty())
}

/// Remarks on the items that are not read, each once.
pub(in crate::identification::recording) fn name_not_read(
    mut names: Vec<String>,
    remarks: &mut RecordingRemarks,
) {
    names.sort();
    names.dedup();
    if !names.is_empty() {
        let shown = names.iter().take(40).cloned().collect::<Vec<_>>().join(", ");
        let more = if names.len() <= 40 { String::new() } else { format!(" and {} more", names.len() - 40) };
        remarks.info(None, format!("not read: {shown}{more}"));
    }
}

/// Returns one signal per item that is read; `units` holds the units that are known.
pub(in crate::identification::recording) fn signals<'a>(
    events: impl Iterator<Item = ItemEvent<'a>>,
    units: &[(&str, LogUnit)],
    not_read: &mut Vec<String>,
    remarks: &mut RecordingRemarks,
) -> Vec<Signal> {
    let mut index: HashMap<&str, usize> = HashMap::new();
    let mut items: Vec<(ChannelLabel, Vec<(f64, &str)>)> = Vec::new();
    for event in events {
        let at = *index.entry(event.item).or_insert_with(|| {
            let unit = units.iter().find(|(name, _)| *name == event.item).map(|(_, unit)| *unit);
            items.push((ChannelLabel::read(event.item, unit), Vec::new()));
            items.len() - 1
        });
        if items[at].0.field.is_some() {
            items[at].1.push((event.time, event.value));
        }
    }
    let mut signals = Vec::new();
    for (label, events) in items {
        if label.field.is_some() {
            signals.push(signal(label, events, remarks));
        } else {
            not_read.push(label.name);
        }
    }
    signals
}

/// Returns the signal of one item.
pub(in crate::identification::recording) fn signal(
    label: ChannelLabel,
    mut events: Vec<(f64, &str)>,
    remarks: &mut RecordingRemarks,
) -> Signal {
    sort_by_number(&mut events, |event| event.0);
    // If several values have one stamp, the last one counts.
    let mut kept: Vec<(f64, &str)> = Vec::with_capacity(events.len());
    for event in events {
        match kept.last_mut() {
            Some(last) if last.0 == event.0 => *last = event,
            _ => kept.push(event),
        }
    }
    let data = if label.field.is_some_and(|field| field.is_text()) {
        SignalData::Texts(
            kept.iter().map(|(_, text)| (!is_missing(text)).then(|| (*text).to_owned())).collect(),
        )
    } else {
        let cells = kept.iter().map(|(_, text)| number(text, true));
        let values: Vec<f64> = cells
            .clone()
            .map(|cell| if let CellContent::Number(value) = cell { value } else { f64::NAN })
            .collect();
        let others = cells.filter(|cell| *cell == CellContent::Other).count();
        if 0 < others {
            remarks.warn(None, Some(&label.name), format!("{others} values are not numbers and left out"));
        }
        SignalData::Numbers(values)
    };
    Signal { label, sampling: Sampling::OnChange, time: kept.iter().map(|(time, _)| *time).collect(), data }
}
