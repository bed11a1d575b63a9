//! Rows of a table as columns, while they are read.

use crate::identification::recording::field::Label;

/// One column while it is read.
#[derive(Debug)]
pub(super) enum Column {
    /// NaN where missing.
    Numbers(Vec<f64>),
    /// Rows from which on another text holds.
    Texts(Vec<(usize, Option<String>)>),
    /// Stamps, ns.
    Stamps(Vec<Option<i64>>),
    /// Nothing is made of it.
    Skipped,
}

/// Rows of a table, as columns.
#[derive(Debug)]
pub(super) struct Rows {
    pub(super) labels: Vec<Label>,
    pub(super) columns: Vec<Column>,
    /// Line of the file each row stands in.
    pub(super) lines: Vec<usize>,
}
