//! Export of Beckhoff's TwinCAT Scope (TE13xx) as text.
//!
//! ```text
//! Name               project                                head of the file
//! File               …
//! Starttime of export  132959733843760000   date   time     100 ns since 1601
//!
//! Name            X act  Y act   Name            feed       a group of channels, another group
//! SampleTime[ms]  1      1       SampleTime[ms]  5
//! Unit            mm (Length) …  Unit            mm/s
//!                                                           a blank line
//! 0       0.0    0.0             0     12.5                 time in ms and values, a group each
//! 1       0.1    0.0             5     12.6
//! EOF                                                       or not
//! ```
//!
//! Separator tab, `;` or `,`; decimal comma or point. Every column headed `Name` is the time of the channels
//! to its right, so that groups with different sample times keep their stamps; a group that ends earlier has
//! empty cells. `ScaleFactor` and `Offset` are already applied to the values. A channel is identified by its
//! name, or else by its `SymbolName`.
//!
//! Source: infosys.beckhoff.com, TE13xx; the test files of pytcs. Not read: binary exports (.svb), triggered
//! exports with several heads.

use std::sync::Arc;

use crate::identification::recording::assemble::{Capture, Signal, SignalData};
use crate::identification::recording::clock::split_recordings;
use crate::identification::recording::field::ChannelLabel;
use crate::identification::recording::formats::events::name_not_read;
use crate::identification::recording::text::{CellContent, number};
use crate::identification::recording::unit::{LogUnit, MILLISECOND};
use crate::identification::recording::{RecordingError, RecordingRemarks, Sampling};

/// Steps of 100 ns from 1601, where FILETIME begins, to 1970.
const FILETIME_EPOCH: i64 = 116_444_736_000_000_000;

/// Returns `true` if the text is a Scope export: a head that begins with `Name`, and rows of a channel head.
pub(in crate::identification::recording) fn is_scope(text: &str) -> bool {
    let mut lines = text.lines().take(60);
    lines.next().is_some_and(|line| line.trim_start_matches('"').starts_with("Name"))
        && lines.any(|line| line.trim_start_matches('"').starts_with("SampleTime"))
}

/// A group of channels with one time column.
struct Group {
    /// Column of its times.
    time: usize,
    /// Columns of its channels.
    channels: Vec<(usize, ChannelLabel)>,
}

/// Reads a Scope export.
pub(in crate::identification::recording) fn read(
    text: &str,
    remarks: &mut RecordingRemarks,
) -> Result<Vec<Capture>, RecordingError> {
    let head_end = text.lines().position(|line| line.starts_with("SampleTime")).unwrap_or(0);
    let sample_line = text.lines().nth(head_end).unwrap_or("");
    let separator = ['\t', ';', ','].into_iter().find(|c| sample_line.contains(*c));
    let separator =
        separator.ok_or(RecordingError::Missing("the header of the channels has no separator"))?;
    let cells = |line: &'_ str| -> Vec<String> {
        line.split(separator).map(|cell| cell.trim().trim_matches('"').to_owned()).collect()
    };
    let lines: Vec<&str> = text.lines().collect();
    // The channels' head begins with the last `Name` before the sample times.
    let head = (0..head_end).rev().find(|at| lines[*at].starts_with("Name"));
    let head = head.ok_or(RecordingError::Missing("the header of the channels has no row of names"))?;
    let names = cells(lines[head]);
    let mut units: Vec<String> = Vec::new();
    let mut symbols: Vec<String> = Vec::new();
    let mut first = head;
    while first < lines.len() && !lines[first].trim().is_empty() {
        let row = cells(lines[first]);
        // Without its blank line the head ends with the first number.
        if matches!(number(&row[0], true), CellContent::Number(_)) {
            break;
        }
        match row[0].as_str() {
            "Unit" => units = row,
            "SymbolName" => symbols = row,
            _ => {}
        }
        first += 1;
    }
    let (mut groups, unread) = groups_of(&names, &units, &symbols);
    name_not_read(unread, remarks);
    groups.retain(|group| !group.channels.is_empty());
    if groups.is_empty() {
        return Err(RecordingError::NothingKnown {
            found: names.into_iter().filter(|name| name != "Name").collect(),
        });
    }
    let mut rows: Vec<(usize, Vec<&str>)> = Vec::new();
    for (at, line) in lines.iter().enumerate().skip(first) {
        let row: Vec<&str> = line.split(separator).map(|cell| cell.trim().trim_matches('"')).collect();
        if row[0] == "EOF" {
            break;
        }
        if row.iter().any(|cell| !cell.is_empty()) {
            rows.push((at + 1, row));
        }
    }
    if !text.ends_with(['\n', '\r']) && rows.last().is_some_and(|(_, row)| row.len() < names.len()) {
        let cut = rows.pop();
        remarks.warn(cut.map(|(line, _)| line), None, "the last row is cut short and left out".to_owned());
    }
    let origin =
        lines[..head].iter().find(|line| line.to_lowercase().starts_with("starttime")).and_then(|line| {
            let ticks: i64 = cells(line).get(1)?.parse().ok()?;
            ticks.checked_sub(FILETIME_EPOCH)?.checked_mul(100)
        });
    let mut signals = Vec::new();
    for group in &groups {
        signals.extend(group.signals(&rows, remarks)?);
    }
    Ok(vec![Capture { origin, signals }])
}

/// Groups the channels of a head by their time columns; also returns the names of those that are not read.
fn groups_of(names: &[String], units: &[String], symbols: &[String]) -> (Vec<Group>, Vec<String>) {
    let mut groups: Vec<Group> = Vec::new();
    let mut unread = Vec::new();
    for (column, name) in names.iter().enumerate() {
        if name == "Name" {
            groups.push(Group { time: column, channels: Vec::new() });
            continue;
        }
        let unit = units.get(column).and_then(|text| LogUnit::parse(text));
        let mut label = ChannelLabel::read(name, unit);
        if label.field.is_none() {
            let symbol = symbols.get(column).map_or("", String::as_str);
            label.field = ChannelLabel::read(symbol.rsplit('.').next().unwrap_or(symbol), unit).field;
        }
        match groups.last_mut() {
            Some(group) if label.field.is_some() => group.channels.push((column, label)),
            _ => unread.push(label.name),
        }
    }
    (groups, unread)
}

impl Group {
    fn signals(
        &self,
        rows: &[(usize, Vec<&str>)],
        remarks: &mut RecordingRemarks,
    ) -> Result<Vec<Signal>, RecordingError> {
        let value = |row: usize, column: usize| match rows[row].1.get(column).map(|cell| number(cell, true)) {
            Some(CellContent::Number(value)) => value,
            _ => f64::NAN,
        };
        let stamps: Vec<f64> =
            (0..rows.len()).map(|row| value(row, self.time) * MILLISECOND.factor).collect();
        let same = |a: usize, b: usize| {
            self.channels.iter().all(|(column, _)| value(a, *column).to_bits() == value(b, *column).to_bits())
        };
        let parts = split_recordings(&stamps, |row| rows[row].0, same, remarks)?;
        if 1 < parts.len() {
            remarks.warn(None, None, "time starts again: only the first part of the file is read".to_owned());
        }
        let Some(part) = parts.first() else { return Ok(Vec::new()) };
        let time: Arc<[f64]> = part.time.as_slice().into();
        let mut signals = Vec::with_capacity(self.channels.len());
        for (column, label) in &self.channels {
            let data = if label.field.is_some_and(|field| field.is_text()) {
                let text = |row: &usize| rows[*row].1.get(*column).filter(|cell| !cell.is_empty());
                SignalData::Texts(
                    part.rows.iter().map(|row| text(row).map(|cell| (*cell).to_owned())).collect(),
                )
            } else {
                SignalData::Numbers(part.rows.iter().map(|row| value(*row, *column)).collect())
            };
            signals.push(Signal {
                label: label.clone(),
                sampling: Sampling::Sampled,
                time: time.clone(),
                data,
            });
        }
        Ok(signals)
    }
}
