//! The columns of a table while its rows are read.

use crate::identification::recording::clock::iso;
use crate::identification::recording::field::ChannelLabel;
use crate::identification::recording::text::{CellContent, is_missing, number};

/// One column while it is read.
#[derive(Debug)]
pub(in crate::identification::recording) enum TableColumn {
    /// Numbers; NaN if missing.
    Numbers(Vec<f64>),
    /// Rows at which the text changes, with the new text.
    Texts(Vec<(usize, Option<String>)>),
    /// Stamps, ns.
    Stamps(Vec<Option<i64>>),
    /// A column that is not read.
    Skipped,
}

impl TableColumn {
    /// Adds the cell of a row. Returns `false` if the content is not a value of this column.
    pub(in crate::identification::recording) fn push(&mut self, row: usize, cell: &str) -> bool {
        match self {
            TableColumn::Numbers(values) => {
                let read = number(cell, true);
                let is_other = read == CellContent::Other;
                values.push(if let CellContent::Number(value) = read { value } else { f64::NAN });
                !is_other
            }
            TableColumn::Texts(changes) => {
                let text = (!is_missing(cell)).then_some(cell);
                if changes.last().is_none_or(|(_, last)| last.as_deref() != text) {
                    changes.push((row, text.map(str::to_owned)));
                }
                true
            }
            TableColumn::Stamps(stamps) => {
                let stamp = iso(cell);
                stamps.push(stamp);
                stamp.is_some()
            }
            TableColumn::Skipped => true,
        }
    }
}

/// Cells, or rows, with faults: their number, and the first of them.
#[derive(Clone, Default)]
pub(in crate::identification::recording) struct Misfits<T> {
    pub(in crate::identification::recording) count: usize,
    /// Line of the first.
    pub(in crate::identification::recording) line: usize,
    pub(in crate::identification::recording) first: T,
}

impl<T> Misfits<T> {
    /// Counts another fault in this line.
    pub(in crate::identification::recording) fn add(&mut self, line: usize, one: impl FnOnce() -> T) {
        if self.count == 0 {
            (self.line, self.first) = (line, one());
        }
        self.count += 1;
    }
}

/// Rows of a table, as columns.
#[derive(Debug)]
pub(in crate::identification::recording) struct TableRows {
    pub(in crate::identification::recording) labels: Vec<ChannelLabel>,
    pub(in crate::identification::recording) columns: Vec<TableColumn>,
    /// Line of the file of each row.
    pub(in crate::identification::recording) lines: Vec<usize>,
}
