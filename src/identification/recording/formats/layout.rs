//! The layout of a table: the end of its head, the separator of its cells, and its rows as fields.
//!
//! ```text
//! table     = { preamble } [ names ] [ units ] { row }
//! separator = tab | ";" | "," | "|" | blanks        the one under which most cells are numbers
//! ```
//!
//! The separator is the one that cuts the second half of the first [`SNIFFED_LINES`] lines into rows of one
//! width with the largest share of numbers and stamps. The first row as wide as those with a number
//! in it begins the data; the one or two lines above it are names and units, and anything before is
//! preamble. Lines that begin with `#` or `%` are comments, but may hold the names.
//!
//! A last row without a line end may be cut within a number; it is kept only if it has as many decimals as
//! the row before. Not read: units in a third row, line breaks within quotes above the data.

use crate::identification::recording::clock::iso;
use crate::identification::recording::field::{ChannelField, ChannelLabel};
use crate::identification::recording::text::{CellContent, is_missing, number};
use crate::identification::recording::unit::LogUnit;
use crate::identification::recording::{ReadingOptions, RecordingError};
use crate::simulation::ordered::sort_by_number;

/// Number of lines that determine separator and head.
const SNIFFED_LINES: usize = 200;

/// Longest line that may be a row, bytes: two thousand columns of thirty characters.
pub(in crate::identification::recording) const MAX_LINE_BYTES: usize = 1 << 16;

/// Separators, the more significant first: a tie goes to the earlier one.
const SEPARATORS: &[char] = &['\t', ';', ',', '|', ' '];

/// The layout of a table.
#[derive(Debug)]
pub(in crate::identification::recording) struct TableLayout {
    pub(in crate::identification::recording) separator: char,
    /// Fields in a row.
    pub(in crate::identification::recording) width: usize,
    /// Names, if there is a row of them.
    pub(in crate::identification::recording) names: Vec<String>,
    /// Units, one per name.
    pub(in crate::identification::recording) units: Vec<Option<LogUnit>>,
    /// Lines before the first row.
    pub(in crate::identification::recording) skipped: usize,
}

/// Returns separator, names, units and first row of a table; an error if names and rows do not match.
pub(in crate::identification::recording) fn layout(
    text: &str,
    options: &ReadingOptions,
) -> Result<TableLayout, RecordingError> {
    let lines: Vec<(usize, &str)> =
        text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty()).take(SNIFFED_LINES).collect();
    if let Some((at, line)) = lines.iter().find(|(_, line)| MAX_LINE_BYTES < line.len()) {
        return Err(RecordingError::LongLine { line: at + 1, bytes: line.len(), most: MAX_LINE_BYTES });
    }
    // Values of events may contain any separator, so that a head of time, item and value suffices.
    for separator in SEPARATORS.iter().take(4) {
        let head = lines.first().map(|(_, line)| split(line, *separator)).unwrap_or_default();
        let names: Vec<String> = head.into_iter().map(str::to_owned).collect();
        let labels: Vec<ChannelLabel> = names.iter().map(|name| ChannelLabel::read(name, None)).collect();
        if event_columns(&labels).is_some() {
            let (width, units) = (names.len(), vec![None; names.len()]);
            return Ok(TableLayout { separator: *separator, width, names, units, skipped: lines[0].0 + 1 });
        }
    }
    let body = &lines[lines.len() / 2..];
    let mut best: Option<(f64, char, usize)> = None;
    for separator in SEPARATORS {
        let rows: Vec<Vec<&str>> = body.iter().map(|(_, line)| split(line, *separator)).collect();
        let mut widths: Vec<usize> = rows.iter().map(Vec::len).collect();
        sort_by_number(&mut widths, |width| *width as f64);
        let Some(width) = widths.get(widths.len() / 2).copied() else { continue };
        let regular = rows.iter().filter(|row| row.len() == width);
        let values = regular.clone().flatten().filter(|cell| is_value(cell)).count();
        let cells = rows.iter().map(Vec::len).sum::<usize>().max(1);
        // A separator that leaves one column counts only if no other separator divides the rows.
        let score = values as f64 / cells as f64 * if width < 2 { 0.1 } else { 1.0 };
        if best.is_none_or(|(other, ..)| other < score) {
            best = Some((score, *separator, width));
        }
    }
    let (score, separator, width) = best.ok_or(RecordingError::Empty)?;
    if score <= 0.0 {
        return Err(RecordingError::UnknownFormat("no separator splits it into rows of numbers"));
    }
    let is_row = |line: &str| {
        let cells = split(line, separator);
        // A row may have lost some fields, and a name may look like a number, but not most of them.
        let values = cells.iter().filter(|cell| is_value(cell)).count();
        cells.len() == width && 0 < values && !line.trim_start().starts_with(['#', '%'])
    };
    let first = lines.iter().position(|(_, line)| is_row(line));
    let first = first.ok_or(RecordingError::UnknownFormat("no row of numbers was found"))?;
    let above = first.checked_sub(1).map(|above| split(lines[above].1, separator)).unwrap_or_default();
    let known = above.iter().filter(|name| ChannelLabel::read(name, None).field.is_some()).count();
    if 2 <= known && above.len() <= 2 * known && width + 1 != above.len() && above.len() + 1 < width.max(3) {
        // The names belong to other columns: a decimal comma doubles the fields.
        let (line, count) = (lines[first].0 + 1, lines.len() - first);
        return Err(RecordingError::FieldCount { line, found: width, expected: above.len(), count });
    }
    let bare = |line: &'_ str| line.trim().trim_start_matches(['#', '%', '/']).trim().to_owned();
    let heads: Vec<Vec<String>> = lines[..first]
        .iter()
        .map(|(_, line)| split(&bare(line), separator).iter().map(|cell| (*cell).to_owned()).collect())
        .filter(|cells: &Vec<String>| {
            cells.len() + 1 == width || cells.len() == width || cells.len() == width + 1
        })
        .collect();
    let is_unit = |cell: &String| LogUnit::parse(cell).is_some();
    let (names, unit_row) = match heads.as_slice() {
        [.., names, units]
            if names.iter().any(|name| ChannelLabel::read(name, None).field.is_some())
                && units.iter().any(is_unit)
                && units.iter().all(|cell| {
                    is_unit(cell) || is_missing(cell) || cell.len() <= 3 || cell.starts_with(['[', '('])
                }) =>
        {
            (names.clone(), units.clone())
        }
        [.., names] => (names.clone(), Vec::new()),
        [] => (options.columns.clone().unwrap_or_default(), Vec::new()),
    };
    let units = (0..names.len()).map(|at| unit_row.get(at).and_then(|cell| LogUnit::parse(cell))).collect();
    Ok(TableLayout { separator, width, names, units, skipped: lines[first].0 })
}

/// Returns the columns of time, item and value, if the table consists of them.
pub(in crate::identification::recording) fn event_columns(
    labels: &[ChannelLabel],
) -> Option<(usize, usize, usize)> {
    let find = |words: &[&str]| labels.iter().position(|l| words.contains(&l.name.to_lowercase().as_str()));
    let item = find(&["key", "item", "dataitem", "dataitemid", "id", "name", "tag", "signal", "variable"])?;
    let value = find(&["value", "wert", "val"])?;
    let time = labels.iter().position(|label| label.field == Some(ChannelField::Time))?;
    Some((time, item, value))
}

/// Splits a line into fields, respecting quotes; sufficient to inspect a table, not to read it.
fn split(line: &str, separator: char) -> Vec<&str> {
    if separator == ' ' {
        return line.split_whitespace().collect();
    }
    let mut quoted = false;
    line.split(|c: char| {
        quoted ^= c == '"';
        c == separator && !quoted
    })
    .map(|cell| cell.trim().trim_matches('"'))
    .collect()
}

fn is_value(cell: &str) -> bool {
    matches!(number(cell, true), CellContent::Number(_)) || iso(cell).is_some()
}

/// Returns the rows of `text`, and `true` if the last one was dropped because it may be cut within a cell.
pub(in crate::identification::recording) fn body<'a>(text: &'a str, layout: &TableLayout) -> (&'a str, bool) {
    let from: usize = text.split_inclusive('\n').take(layout.skipped).map(str::len).sum();
    let body = &text[from..];
    if body.ends_with(['\n', '\r']) {
        return (body, false);
    }
    let last = body.rfind('\n').map_or(0, |at| at + 1);
    let before = body[..last].trim_end().rsplit('\n').next().unwrap_or("");
    let whole = decimals(&body[last..], layout.separator) == decimals(before, layout.separator);
    if whole { (body, false) } else { (&body[..last], true) }
}

/// Calls `row` with line and fields of every row; skips blank lines and comments.
pub(in crate::identification::recording) fn each_row(
    text: &str,
    layout: &TableLayout,
    mut row: impl FnMut(usize, &[&str]),
) {
    let (body, _) = body(text, layout);
    if layout.separator == ' ' {
        for (at, line) in body.lines().enumerate() {
            let line = line.trim();
            if !line.is_empty() && !line.starts_with(['#', '%']) {
                row(layout.skipped + at + 1, &line.split_whitespace().collect::<Vec<_>>());
            }
        }
        return;
    }
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .delimiter(layout.separator as u8)
        .comment(Some(b'#'))
        .from_reader(body.as_bytes());
    let mut record = csv::StringRecord::new();
    // The text is UTF-8 and in memory, so that only its end stops the reader.
    while let Ok(true) = reader.read_record(&mut record) {
        let line = record.position().map_or(0, |position| position.line() as usize);
        let fields: Vec<&str> = record.iter().map(str::trim).collect();
        if fields.iter().any(|field| !field.is_empty()) {
            row(layout.skipped + line, &fields);
        }
    }
}

/// Returns the number of decimals of every cell of a row.
fn decimals(line: &str, separator: char) -> Vec<usize> {
    let cells = split(line.trim_end(), separator).into_iter();
    cells.map(|cell| cell.rfind(['.', ',']).map_or(0, |point| cell.len() - point)).collect()
}
