//! Tables: rows of cells, usually under a row of names.
//!
//! ```text
//! t_s,x_mm,y_mm,feed_mm_min,line          Zeit;X Ist;Y Ist;Vorschub        names
//! 0.000,0.0000,0.0000,0.0,2               ms;mm;mm;mm/min                  units, in a row of their own
//! 0.004,0.0000,0.0003,90.0,2              0,0;0,0000;0,0000;0,0
//!
//! cell = number, decimal point or comma | time stamp | words | "quoted"
//! ```
//!
//! `layout` finds head and separator, `field` understands the names. Time is a column of stamps, or
//! of numbers in the unit its name states; without a unit the step tells it only where it cannot be
//! another (see [`time_unit`]), and otherwise the file is refused.
//!
//! Heidenhain's `scope2csv` (pyLSV2, scripts/scope2csv.py) writes names such as `x_s_actual`, no
//! time and no units: time is row × interval, [`SCOPE_INTERVAL`] unless told otherwise. The control
//! sends packets of 32 samples; samples lost between two packets leave no trace in the file.
//!
//! A table of `time, item, value` is an event log (`events`); one without names goes through
//! `nameless`.
//!
//! Left out: thousands separators, more than one table in a file.

use std::sync::Arc;

use crate::identification::recording::assemble::{Capture, Data, Signal, from_origin};
use crate::identification::recording::clock::{Stretch, event_stretches, iso, stretches, usual};
use crate::identification::recording::columns::{Column, Rows};
use crate::identification::recording::diagnostic::few;
use crate::identification::recording::events::{self, Event, name_not_read};
use crate::identification::recording::field::{Field, Label, is_scope, is_siemens_recorder};
use crate::identification::recording::layout::{Layout, body, each_row, event_columns, layout};
use crate::identification::recording::nameless;
use crate::identification::recording::siemens_recorder::CYCLE_TIME;
use crate::identification::recording::text::{Cell, is_missing, number};
use crate::identification::recording::unit::{MICROSECOND, MILLISECOND, NANOSECOND, SECOND, Unit};
use crate::identification::recording::{Options, RecordingError, Remarks, Sampling};

/// Interval of Heidenhain's scope where nothing else is said, s: twice the 3 ms of its position loop.
pub const SCOPE_INTERVAL: f64 = 6e-3;

/// Reads a table, and says which kind it is.
pub(super) fn read(
    text: &str,
    options: &Options,
    remarks: &mut Remarks,
) -> Result<(&'static str, Vec<Capture>), RecordingError> {
    let layout = layout(text, options)?;
    let mut labels: Vec<Label> =
        layout.names.iter().zip(&layout.units).map(|(name, unit)| Label::read(name, *unit)).collect();
    labels.resize_with(layout.width.max(labels.len()), || Label {
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
        let rows = nameless::named(rows, options, remarks)?;
        return Ok(("rows without names (halsampler)", captures(rows, options, remarks)?));
    }
    Ok(("table", captures(rows, options, remarks)?))
}

/// Columns → signals, cut where time starts again.
fn captures(
    mut rows: Rows,
    options: &Options,
    remarks: &mut Remarks,
) -> Result<Vec<Capture>, RecordingError> {
    let names: Vec<&str> = rows.labels.iter().map(|label| label.name.as_str()).collect();
    let at = rows.labels.iter().position(|label| label.field == Some(Field::Time));
    let found = || rows.labels.iter().map(|label| label.name.clone()).collect();
    if !rows.labels.iter().any(|label| label.field.is_some_and(Field::tells_motion)) {
        return Err(RecordingError::NothingKnown { found: found() });
    }
    let (origin, stamps) = match at.map(|at| (at, &rows.columns[at])) {
        Some((_, Column::Stamps(stamps))) => {
            let first = stamps.iter().flatten().next().copied().unwrap_or(0);
            let (_, seconds) = from_origin(
                &[&[first][..], &stamps.iter().map(|s| s.unwrap_or(first)).collect::<Vec<_>>()].concat(),
            );
            let seconds = seconds[1..].iter().zip(stamps);
            (Some(first), seconds.map(|(s, known)| known.map_or(f64::NAN, |_| *s)).collect::<Vec<f64>>())
        }
        Some((at, Column::Numbers(values))) => {
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
                        "no time column: one row is taken to be {} µs, as Heidenhain's scope records; give the \
                         interval if it is another; samples lost between packets of 32 leave no trace",
                        SCOPE_INTERVAL * 1e6
                    );
                    remarks.warn(None, None, message);
                    SCOPE_INTERVAL
                }
                None if is_siemens_recorder(&names) => {
                    let message = format!(
                        "no time column: a cycle is taken to be {} ms; give the interval if it is another",
                        CYCLE_TIME * 1e3
                    );
                    remarks.warn(None, None, message);
                    CYCLE_TIME
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
    // The time column has done its work, and is no value that could differ between copies of a row.
    for (label, column) in rows.labels.iter().zip(&mut rows.columns) {
        if matches!(label.field, Some(Field::Time | Field::SampleNumber)) {
            *column = Column::Skipped;
        }
    }
    let parts = stretches(&stamps, |row| rows.lines[row], |a, b| rows.same(a, b), remarks)?;
    Ok(parts.into_iter().map(|part| Capture { origin, signals: rows.signals(&part) }).collect())
}

/// Stamps of rows `interval` s apart, or of their sample numbers.
fn counted(rows: &Rows, interval: f64, remarks: &mut Remarks) -> Vec<f64> {
    let numbers = rows.labels.iter().zip(&rows.columns).find_map(|(label, column)| match column {
        Column::Numbers(values) if label.field == Some(Field::SampleNumber) => Some(values),
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

/// The unit of times that state none. Dates in s, ms, µs or ns since 1970 tell themselves apart; of
/// steps, those up to half a second can only be seconds and those from 50 only milliseconds, of
/// which there are microseconds from 100 000 on, for logs of 1 Hz to 1 kHz. Between is refused.
fn time_unit(values: &[f64], name: &str) -> Result<Unit, RecordingError> {
    let first = values.iter().copied().find(|value| value.is_finite()).unwrap_or(0.0);
    for (unit, from) in [(SECOND, 1e9), (MILLISECOND, 1e12), (MICROSECOND, 1e15), (NANOSECOND, 1e18)] {
        if (from..5.0 * from).contains(&first) {
            return Ok(unit);
        }
    }
    let steps = values.windows(2).map(|pair| (pair[1] - pair[0]).abs()).filter(|step| 0.0 < *step);
    match usual(steps.collect()) {
        step if 0.0 < step && step <= 0.5 => Ok(SECOND),
        step if (50.0..=5e3).contains(&step) => Ok(MILLISECOND),
        step if 1e5 <= step => Ok(MICROSECOND),
        step => Err(RecordingError::TimeUnit { name: name.to_owned(), step }),
    }
}

impl Rows {
    /// Whether two rows hold the same values. Texts are told by the row they changed in.
    fn same(&self, a: usize, b: usize) -> bool {
        self.columns.iter().all(|column| match column {
            Column::Numbers(values) => values[a].to_bits() == values[b].to_bits(),
            Column::Texts(changes) => {
                let after = changes.partition_point(|(row, _)| *row <= b);
                after.checked_sub(1).is_none_or(|last| changes[last].0 <= a)
            }
            _ => true,
        })
    }

    /// The signals of a stretch of rows.
    fn signals(&self, part: &Stretch) -> Vec<Signal> {
        let time: Arc<[f64]> = part.time.as_slice().into();
        let mut signals = Vec::new();
        for (label, column) in self.labels.iter().zip(&self.columns) {
            let label = label.clone();
            match column {
                Column::Numbers(values) => {
                    let values = part.rows.iter().map(|row| values[*row]).collect();
                    let data = Data::Numbers(values);
                    signals.push(Signal { label, sampling: Sampling::Sampled, time: time.clone(), data });
                }
                Column::Texts(changes) => signals.push(on_change(label, changes, part)),
                _ => {}
            }
        }
        signals
    }
}

/// The texts of a stretch of rows, one where it changes.
fn on_change(label: Label, changes: &[(usize, Option<String>)], part: &Stretch) -> Signal {
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
    Signal { label, sampling: Sampling::OnChange, time: time.into(), data: Data::Texts(texts) }
}

/// Reads a table of events.
fn read_events(
    text: &str,
    layout: &Layout,
    (time, item, value): (usize, usize, usize),
    options: &Options,
    remarks: &mut Remarks,
) -> Result<Vec<Capture>, RecordingError> {
    let label = Label::read(&layout.names[time], layout.units[time]);
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
        if !few(faults.len(), cells.len() + faults.len()) {
            return Err(RecordingError::FieldCount {
                line,
                found,
                expected: layout.width,
                count: faults.len(),
            });
        }
        remarks.warn(Some(line), None, format!("{} rows are cut short and left out", faults.len()));
    }
    let plain = matches!(cells.first().map(|cell| number(&cell.1, true)), Some(Cell::Number(_)));
    let (origin, times): (Option<i64>, Vec<Option<f64>>) = if plain {
        let numbers: Vec<f64> = cells
            .iter()
            .map(|cell| if let Cell::Number(n) = number(&cell.1, true) { n } else { f64::NAN })
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
        if !few(count, times.len()) {
            let (line, text) = (cells[bad].0, cells[bad].1.clone());
            return Err(RecordingError::Stamp { line, column: time + 1, text, count });
        }
        remarks.warn(Some(cells[bad].0), None, format!("{count} rows have no stamp and are left out"));
    }
    let known: Vec<(usize, f64)> =
        times.iter().enumerate().filter_map(|(row, time)| Some((row, (*time)?))).collect();
    let seconds: Vec<f64> = known.iter().map(|(_, time)| *time).collect();
    let parts = event_stretches(&seconds, |row| cells[known[row].0].0, remarks)?;
    let mut not_read = Vec::new();
    let mut captures = Vec::with_capacity(parts.len());
    for rows in parts {
        let events = rows.iter().map(|row| {
            let (_, _, item, value) = &cells[known[*row].0];
            Event { time: seconds[*row], item, value }
        });
        captures.push(Capture { origin, signals: events::signals(events, &[], &mut not_read, remarks) });
    }
    name_not_read(not_read, remarks);
    Ok(captures)
}

/// Reads the rows into columns.
fn rows(
    text: &str,
    layout: &Layout,
    labels: Vec<Label>,
    nameless: bool,
    remarks: &mut Remarks,
) -> Result<Rows, RecordingError> {
    let width = labels.len();
    let mut columns: Vec<Column> = labels
        .iter()
        .map(|label| match label.field {
            Some(field) if field.is_text() => Column::Texts(Vec::new()),
            Some(_) => Column::Numbers(Vec::new()),
            None if nameless => Column::Numbers(Vec::new()),
            None => Column::Skipped,
        })
        .collect();
    let mut lines: Vec<usize> = Vec::new();
    let mut narrow: (usize, usize, usize) = (0, 0, 0);
    let mut not_numbers: Vec<(usize, usize, String)> = vec![(0, 0, String::new()); width];
    let time = labels.iter().position(|label| label.field == Some(Field::Time));
    each_row(text, layout, |line, fields| {
        let extra = fields.len().saturating_sub(width);
        let only_blank = fields[fields.len() - extra..].iter().all(|field| field.is_empty());
        if fields.len() + 1 < width || fields.len() < layout.width.min(width) || !only_blank {
            if narrow.0 == 0 {
                (narrow.1, narrow.2) = (line, fields.len());
            }
            narrow.0 += 1;
            return;
        }
        let row = lines.len();
        lines.push(line);
        if let (0, Some(at)) = (row, time)
            && fields
                .get(at)
                .is_some_and(|cell| !matches!(number(cell, true), Cell::Number(_)) && iso(cell).is_some())
        {
            columns[at] = Column::Stamps(Vec::new());
        }
        for (at, column) in columns.iter_mut().enumerate() {
            let cell = fields.get(at).copied().unwrap_or("");
            match column {
                Column::Numbers(values) => values.push(match number(cell, true) {
                    Cell::Number(value) => value,
                    cell_kind => {
                        let fault = &mut not_numbers[at];
                        if cell_kind == Cell::Other {
                            if fault.0 == 0 {
                                (fault.1, fault.2) = (line, cell.chars().take(40).collect());
                            }
                            fault.0 += 1;
                        }
                        f64::NAN
                    }
                }),
                Column::Texts(changes) => {
                    let text = (!is_missing(cell)).then_some(cell);
                    if changes.last().is_none_or(|(_, last)| last.as_deref() != text) {
                        changes.push((row, text.map(str::to_owned)));
                    }
                }
                Column::Stamps(stamps) => {
                    let stamp = iso(cell);
                    let fault = &mut not_numbers[at];
                    if stamp.is_none() {
                        if fault.0 == 0 {
                            (fault.1, fault.2) = (line, cell.chars().take(40).collect());
                        }
                        fault.0 += 1;
                    }
                    stamps.push(stamp);
                }
                Column::Skipped => {}
            }
        }
    });
    if body(text, layout).1 {
        let message =
            "the row after this one has no line end and other decimals: cut short, left out".to_owned();
        remarks.warn(lines.last().copied(), None, message);
    }
    if 0 < narrow.0 {
        let (count, line, found) = narrow;
        if !few(count, lines.len() + count) {
            return Err(RecordingError::FieldCount { line, found, expected: layout.width, count });
        }
        let message =
            format!("{count} rows have another number of fields and are left out; this is the first");
        remarks.warn(Some(line), None, message);
    }
    for (at, (count, line, text)) in not_numbers.into_iter().enumerate() {
        if count == 0 {
            continue;
        }
        let name = labels[at].name.clone();
        if !few(count, lines.len()) {
            return Err(match &columns[at] {
                Column::Stamps(_) => RecordingError::Stamp { line, column: at + 1, text, count },
                _ => RecordingError::NotNumber { line, column: at + 1, name, text, count },
            });
        }
        remarks.warn(
            Some(line),
            Some(&name),
            format!("{count} cells such as `{text}` are no values and left out"),
        );
    }
    Ok(Rows { labels, columns, lines })
}
