//! Tables: rows of cells, usually below a row of names.
//!
//! ```text
//! t_s,x_mm,y_mm,feed_mm_min,line          Zeit;X Ist;Y Ist;Vorschub        names
//! 0.000,0.0000,0.0000,0.0,2               ms;mm;mm;mm/min                  units, in a row of their own
//! 0.004,0.0000,0.0003,90.0,2              0,0;0,0000;0,0000;0,0
//!
//! cell = number, decimal point or comma | time stamp | words | "quoted"
//! ```
//!
//! `layout` finds head and separator, `field` interprets the names. Time is a column of stamps, or of numbers
//! in the unit that its name states. Without a unit the step determines it if that is unambiguous (see
//! [`time_unit`]); otherwise the file is refused.
//!
//! Heidenhain's `scope2csv` (pyLSV2, scripts/scope2csv.py) writes names such as `x_s_actual`, no time and no
//! units: time is row × interval, [`DEFAULT_SCOPE_INTERVAL_S`] by default. The control sends packets of 32 samples;
//! samples lost between two packets leave no trace in the file.
//!
//! A table of `time, item, value` is an event log (`events`); `headerless` identifies the columns of a table
//! without names.
//!
//! Not read: thousands separators, more than one table in a file.

use std::sync::Arc;

use crate::identification::recording::assemble::{Capture, Signal, SignalData, from_origin};
use crate::identification::recording::clock::{
    RecordingRows, iso, median_step, split_event_recordings, split_recordings,
};
use crate::identification::recording::diagnostic::is_tolerable;
use crate::identification::recording::field::{ChannelField, ChannelLabel, is_scope, is_siemens_recorder};
use crate::identification::recording::formats::columns::{Misfits, TableColumn, TableRows};
use crate::identification::recording::formats::events::{self, ItemEvent, name_not_read};
use crate::identification::recording::formats::headerless;
use crate::identification::recording::formats::layout::{TableLayout, body, each_row, event_columns, layout};
use crate::identification::recording::formats::siemens_recorder::DEFAULT_CYCLE_TIME_S;
use crate::identification::recording::text::{CellContent, number};
use crate::identification::recording::unit::{LogUnit, MICROSECOND, MILLISECOND, NANOSECOND, SECOND};
use crate::identification::recording::{ReadingOptions, RecordingError, RecordingRemarks, Sampling};

/// Default interval of Heidenhain's scope, s: twice the 3 ms of its position loop.
pub const DEFAULT_SCOPE_INTERVAL_S: f64 = 6e-3;

/// Reads a table, and returns the name of its kind.
pub(in crate::identification::recording) fn read(
    text: &str,
    options: &ReadingOptions,
    remarks: &mut RecordingRemarks,
) -> Result<(&'static str, Vec<Capture>), RecordingError> {
    let layout = layout(text, options)?;
    let mut labels: Vec<ChannelLabel> =
        layout.names.iter().zip(&layout.units).map(|(name, unit)| ChannelLabel::read(name, *unit)).collect();
    labels.resize_with(layout.width.max(labels.len()), || ChannelLabel {
        name: String::new(),
        field: None,
        unit: None,
    });
    if let Some(columns) = event_columns(&labels) {
        return Ok(("event table", read_events(text, &layout, columns, options, remarks)?));
    }
    let nameless = layout.names.is_empty();
    let rows = rows(text, &layout, labels, nameless, remarks)?;
    if nameless {
        let rows = headerless::named(rows, options, remarks)?;
        return Ok(("rows without names (halsampler)", captures(rows, options, remarks)?));
    }
    Ok(("table", captures(rows, options, remarks)?))
}

/// Returns the signals of the columns, split where time restarts.
fn captures(
    mut rows: TableRows,
    options: &ReadingOptions,
    remarks: &mut RecordingRemarks,
) -> Result<Vec<Capture>, RecordingError> {
    let names: Vec<&str> = rows.labels.iter().map(|label| label.name.as_str()).collect();
    let at = rows.labels.iter().position(|label| label.field == Some(ChannelField::Time));
    let found = || rows.labels.iter().map(|label| label.name.clone()).collect();
    if !rows.labels.iter().any(|label| label.field.is_some_and(ChannelField::tells_motion)) {
        return Err(RecordingError::NothingKnown { found: found() });
    }
    let (origin, stamps) = match at.map(|at| (at, &rows.columns[at])) {
        Some((_, TableColumn::Stamps(stamps))) => {
            let first = stamps.iter().flatten().next().copied().unwrap_or(0);
            let (_, seconds) = from_origin(
                &[&[first][..], &stamps.iter().map(|s| s.unwrap_or(first)).collect::<Vec<_>>()].concat(),
            );
            let seconds = seconds[1..].iter().zip(stamps);
            (Some(first), seconds.map(|(s, known)| known.map_or(f64::NAN, |_| *s)).collect::<Vec<f64>>())
        }
        Some((at, TableColumn::Numbers(values))) => {
            let first = values.iter().copied().find(|value| value.is_finite()).unwrap_or(0.0);
            let unit = match rows.labels[at].unit.or(options.time_unit) {
                Some(unit) => unit,
                None => {
                    let unit = time_unit(values, &rows.labels[at].name)?;
                    let message = format!("no unit stated: the step between samples says {}", unit.symbol);
                    remarks.info(Some(&rows.labels[at].name), message);
                    unit
                }
            };
            (None, values.iter().map(|value| (value - first) * unit.factor).collect())
        }
        _ => {
            let interval = match options.interval.filter(|interval| interval.is_finite() && 0.0 < *interval) {
                Some(interval) => interval,
                None if is_scope(&names) => {
                    let message = format!(
                        "no time column: the interval between rows is assumed to be {} µs, as in Heidenhain's oscilloscope; state the interval if it differs; samples lost between packets of 32 leave no trace",
                        DEFAULT_SCOPE_INTERVAL_S * 1e6
                    );
                    remarks.warn(None, None, message);
                    DEFAULT_SCOPE_INTERVAL_S
                }
                None if is_siemens_recorder(&names) => {
                    let message = format!(
                        "no time column: a cycle is assumed to take {} ms; state the interval if it differs",
                        DEFAULT_CYCLE_TIME_S * 1e3
                    );
                    remarks.warn(None, None, message);
                    DEFAULT_CYCLE_TIME_S
                }
                None => return Err(RecordingError::NoTime { found: found() }),
            };
            (None, counted(&rows, interval, remarks))
        }
    };
    let unread: Vec<String> = rows
        .labels
        .iter()
        .filter(|label| label.field.is_none() && !label.name.is_empty())
        .map(|l| l.name.clone())
        .collect();
    name_not_read(unread, remarks);
    // Copies of a row are compared without the time column.
    for (label, column) in rows.labels.iter().zip(&mut rows.columns) {
        if matches!(label.field, Some(ChannelField::Time | ChannelField::SampleNumber)) {
            *column = TableColumn::Skipped;
        }
    }
    let parts = split_recordings(&stamps, |row| rows.lines[row], |a, b| rows.same(a, b), remarks)?;
    Ok(parts.into_iter().map(|part| Capture { origin, signals: rows.signals(&part) }).collect())
}

/// Returns the stamps of rows that are `interval` (s) apart, by their sample numbers if recorded.
fn counted(rows: &TableRows, interval: f64, remarks: &mut RecordingRemarks) -> Vec<f64> {
    let numbers = rows.labels.iter().zip(&rows.columns).find_map(|(label, column)| match column {
        TableColumn::Numbers(values) if label.field == Some(ChannelField::SampleNumber) => Some(values),
        _ => None,
    });
    let Some(numbers) = numbers else {
        return (0..rows.lines.len()).map(|row| row as f64 * interval).collect();
    };
    let jump = |pair: &[f64]| pair[1] - pair[0] - 1.0;
    let lost: f64 = numbers.windows(2).map(jump).filter(|jump| 0.0 < *jump).sum();
    if 0.0 < lost {
        let at = numbers.windows(2).position(|pair| 0.0 < jump(pair)).map(|row| rows.lines[row + 1]);
        remarks.warn(
            at,
            None,
            format!("{lost} samples were lost by the recorder: gaps in the sample numbers"),
        );
    }
    numbers.iter().map(|number| number * interval).collect()
}

/// Returns the unit of times that state none. Dates in s, ms, µs or ns since 1970 are unambiguous. Other
/// times are judged by their step, for logs of 1 Hz to 1 kHz: steps up to 0.5 are seconds, from 50 on
/// milliseconds, from 100 000 on microseconds; other steps are refused.
fn time_unit(values: &[f64], name: &str) -> Result<LogUnit, RecordingError> {
    let first = values.iter().copied().find(|value| value.is_finite()).unwrap_or(0.0);
    for (unit, from) in [(SECOND, 1e9), (MILLISECOND, 1e12), (MICROSECOND, 1e15), (NANOSECOND, 1e18)] {
        if (from..5.0 * from).contains(&first) {
            return Ok(unit);
        }
    }
    let steps = values.windows(2).map(|pair| (pair[1] - pair[0]).abs()).filter(|step| 0.0 < *step);
    match median_step(steps.collect()) {
        step if 0.0 < step && step <= 0.5 => Ok(SECOND),
        step if (50.0..=5e3).contains(&step) => Ok(MILLISECOND),
        step if 1e5 <= step => Ok(MICROSECOND),
        step => Err(RecordingError::TimeUnit { name: name.to_owned(), step }),
    }
}

impl TableRows {
    /// Returns `true` if two rows have the same values. Texts are compared by the row in which they changed.
    fn same(&self, a: usize, b: usize) -> bool {
        self.columns.iter().all(|column| match column {
            TableColumn::Numbers(values) => values[a].to_bits() == values[b].to_bits(),
            TableColumn::Texts(changes) => {
                let after = changes.partition_point(|(row, _)| *row <= b);
                after.checked_sub(1).is_none_or(|last| changes[last].0 <= a)
            }
            _ => true,
        })
    }

    /// Returns the signals of one recording's rows.
    fn signals(&self, part: &RecordingRows) -> Vec<Signal> {
        let time: Arc<[f64]> = part.time.as_slice().into();
        let mut signals = Vec::new();
        for (label, column) in self.labels.iter().zip(&self.columns) {
            let label = label.clone();
            match column {
                TableColumn::Numbers(values) => {
                    let values = part.rows.iter().map(|row| values[*row]).collect();
                    let data = SignalData::Numbers(values);
                    signals.push(Signal { label, sampling: Sampling::Sampled, time: time.clone(), data });
                }
                TableColumn::Texts(changes) => signals.push(on_change(label, changes, part)),
                _ => {}
            }
        }
        signals
    }
}

/// Returns the texts of one recording's rows, one per change.
fn on_change(label: ChannelLabel, changes: &[(usize, Option<String>)], part: &RecordingRows) -> Signal {
    let mut time = Vec::new();
    let mut texts: Vec<Option<String>> = Vec::new();
    let mut next = 0;
    for (row, stamp) in part.rows.iter().zip(&part.time) {
        let from = next;
        while changes.get(next).is_some_and(|(at, _)| at <= row) {
            next += 1;
        }
        let text = next.checked_sub(1).and_then(|last| changes[last].1.clone());
        if from != next && texts.last() != Some(&text) {
            time.push(*stamp);
            texts.push(text);
        }
    }
    Signal { label, sampling: Sampling::OnChange, time: time.into(), data: SignalData::Texts(texts) }
}

/// Reads a table of events.
fn read_events(
    text: &str,
    layout: &TableLayout,
    (time, item, value): (usize, usize, usize),
    options: &ReadingOptions,
    remarks: &mut RecordingRemarks,
) -> Result<Vec<Capture>, RecordingError> {
    let label = ChannelLabel::read(&layout.names[time], layout.units[time]);
    let mut cells: Vec<(usize, String, String, String)> = Vec::new();
    let mut faults = Vec::new();
    each_row(text, layout, |line, fields| match (fields.get(time), fields.get(item), fields.get(value)) {
        (Some(time), Some(item), Some(value)) => {
            cells.push((line, (*time).to_owned(), (*item).to_owned(), (*value).to_owned()));
        }
        _ => faults.push((line, fields.len())),
    });
    // Without its line end the last value may be cut within a number, which still looks like one.
    if !text.ends_with(['\n', '\r'])
        && cells
            .last()
            .is_some_and(|cell| cell.3.starts_with(|c: char| c.is_ascii_digit() || c == '-' || c == '+'))
    {
        let cut = cells.pop();
        remarks.warn(cut.map(|cell| cell.0), None, "the last row has no line end: left out".to_owned());
    }
    if let Some((line, found)) = faults.first().copied() {
        if !is_tolerable(faults.len(), cells.len() + faults.len()) {
            return Err(RecordingError::FieldCount {
                line,
                found,
                expected: layout.width,
                count: faults.len(),
            });
        }
        remarks.warn(Some(line), None, format!("{} rows are cut short and left out", faults.len()));
    }
    let plain = matches!(cells.first().map(|cell| number(&cell.1, true)), Some(CellContent::Number(_)));
    let (origin, times): (Option<i64>, Vec<Option<f64>>) = if plain {
        let numbers: Vec<f64> = cells
            .iter()
            .map(|cell| if let CellContent::Number(n) = number(&cell.1, true) { n } else { f64::NAN })
            .collect();
        let unit = match label.unit.or(options.time_unit) {
            Some(unit) => unit,
            None => time_unit(&numbers, &label.name)?,
        };
        (None, numbers.iter().map(|n| Some(n * unit.factor).filter(|n| n.is_finite())).collect())
    } else {
        let stamps: Vec<Option<i64>> = cells.iter().map(|cell| iso(&cell.1)).collect();
        let first = stamps.iter().flatten().next().copied().unwrap_or(0);
        (Some(first), stamps.iter().map(|s| s.map(|s| s.saturating_sub(first) as f64 / 1e9)).collect())
    };
    let bad = times.iter().position(Option::is_none);
    if let Some(bad) = bad {
        let count = times.iter().filter(|time| time.is_none()).count();
        if !is_tolerable(count, times.len()) {
            let (line, text) = (cells[bad].0, cells[bad].1.clone());
            return Err(RecordingError::Stamp { line, column: time + 1, text, count });
        }
        remarks.warn(Some(cells[bad].0), None, format!("{count} rows have no stamp and are left out"));
    }
    let known: Vec<(usize, f64)> =
        times.iter().enumerate().filter_map(|(row, time)| Some((row, (*time)?))).collect();
    let seconds: Vec<f64> = known.iter().map(|(_, time)| *time).collect();
    let parts = split_event_recordings(&seconds, |row| cells[known[row].0].0, remarks)?;
    let mut not_read = Vec::new();
    let mut captures = Vec::with_capacity(parts.len());
    for rows in parts {
        let events = rows.iter().map(|row| {
            let (_, _, item, value) = &cells[known[*row].0];
            ItemEvent { time: seconds[*row], item, value }
        });
        captures.push(Capture { origin, signals: events::signals(events, &[], &mut not_read, remarks) });
    }
    name_not_read(not_read, remarks);
    Ok(captures)
}

/// Reads the rows into columns.
fn rows(
    text: &str,
    layout: &TableLayout,
    labels: Vec<ChannelLabel>,
    nameless: bool,
    remarks: &mut RecordingRemarks,
) -> Result<TableRows, RecordingError> {
    let width = labels.len();
    let mut columns: Vec<TableColumn> = labels
        .iter()
        .map(|label| match label.field {
            Some(field) if field.is_text() => TableColumn::Texts(Vec::new()),
            Some(_) => TableColumn::Numbers(Vec::new()),
            None if nameless => TableColumn::Numbers(Vec::new()),
            None => TableColumn::Skipped,
        })
        .collect();
    let mut lines: Vec<usize> = Vec::new();
    let mut narrow = Misfits::<usize>::default();
    let mut not_values = vec![Misfits::<String>::default(); width];
    let time = labels.iter().position(|label| label.field == Some(ChannelField::Time));
    each_row(text, layout, |line, fields| {
        let extra = fields.len().saturating_sub(width);
        let only_blank = fields[fields.len() - extra..].iter().all(|field| field.is_empty());
        if fields.len() + 1 < width || fields.len() < layout.width.min(width) || !only_blank {
            narrow.add(line, || fields.len());
            return;
        }
        let row = lines.len();
        lines.push(line);
        if let (0, Some(at)) = (row, time)
            && fields.get(at).is_some_and(|cell| {
                !matches!(number(cell, true), CellContent::Number(_)) && iso(cell).is_some()
            })
        {
            columns[at] = TableColumn::Stamps(Vec::new());
        }
        for (at, (column, misfits)) in columns.iter_mut().zip(&mut not_values).enumerate() {
            let cell = fields.get(at).copied().unwrap_or("");
            if !column.push(row, cell) {
                misfits.add(line, || cell.chars().take(40).collect());
            }
        }
    });
    if body(text, layout).1 {
        let message = "the row after this one is incomplete: left out".to_owned();
        remarks.warn(lines.last().copied(), None, message);
    }
    if 0 < narrow.count {
        let Misfits { count, line, first: found } = narrow;
        if !is_tolerable(count, lines.len() + count) {
            return Err(RecordingError::FieldCount { line, found, expected: layout.width, count });
        }
        let message =
            format!("{count} rows have another number of fields and are left out; this is the first");
        remarks.warn(Some(line), None, message);
    }
    for (at, Misfits { count, line, first: text }) in not_values.into_iter().enumerate() {
        if count == 0 {
            continue;
        }
        let name = labels[at].name.clone();
        if !is_tolerable(count, lines.len()) {
            return Err(match &columns[at] {
                TableColumn::Stamps(_) => RecordingError::Stamp { line, column: at + 1, text, count },
                _ => RecordingError::NotNumber { line, column: at + 1, name, text, count },
            });
        }
        remarks.warn(
            Some(line),
            Some(&name),
            format!("{count} cells such as `{text}` are no values and left out"),
        );
    }
    Ok(TableRows { labels, columns, lines })
}
