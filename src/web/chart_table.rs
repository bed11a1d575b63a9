//! The view of a chart as a table.

use wasm_bindgen::prelude::*;

use crate::plot::{Abscissa, CurveRange, Extremes};
use crate::units::mm_per_min;
use crate::web::chart::Chart;

/// Rows of the table of a chart.
const ROWS_PER_TABLE: usize = 20;

/// An equal part of the view; a pair holds the least and the largest value, and an empty list means none.
#[wasm_bindgen(getter_with_clone)]
pub struct TableRow {
    /// Beginning, mm, or s over time.
    pub from: f64,
    /// End, mm, or s over time.
    pub to: f64,
    /// First and last line of the program.
    pub lines: Vec<u32>,
    /// Programmed feedrate, mm/min.
    pub programmed: Vec<f64>,
    /// Each curve, in order.
    pub curves: Vec<TableCell>,
    /// Time lost up to the end, s; undefined without a recording.
    pub lost: Option<f64>,
    /// Time lost against the machine after a change, s; undefined if there is one machine only.
    #[wasm_bindgen(js_name = lostAfter)]
    pub lost_after: Option<f64>,
}

/// The values of one curve in a part of the view.
#[wasm_bindgen(getter_with_clone)]
#[derive(Clone)]
pub struct TableCell {
    /// Feedrate, mm/min.
    pub feedrate: Vec<f64>,
    /// Largest contour error, mm; undefined without a corner or an arc.
    pub error: Option<f64>,
}

#[wasm_bindgen]
impl Chart {
    /// Returns the view in equal parts.
    pub fn table(&self) -> Vec<TableRow> {
        let in_minutes = |Extremes { lowest, highest }| vec![mm_per_min(lowest), mm_per_min(highest)];
        let cell = |cell: Option<CurveRange>| TableCell {
            feedrate: cell.map(|cell| in_minutes(cell.feedrate)).unwrap_or_default(),
            error: cell.and_then(|cell| cell.error),
        };
        let rows = self.shown().table(self.view.distance, ROWS_PER_TABLE).into_iter().map(|row| {
            let along = (self.distance_of(row.from), self.distance_of(row.to));
            TableRow {
                from: row.from,
                to: row.to,
                lines: self.chart.lines(along).map(|(first, last)| vec![first, last]).unwrap_or_default(),
                programmed: row.programmed.map(in_minutes).unwrap_or_default(),
                curves: row.curves.into_iter().map(cell).collect(),
                lost: row.lost,
                lost_after: row.lost_after,
            }
        });
        rows.collect()
    }

    /// Returns `true` if the chart is over time.
    #[wasm_bindgen(js_name = isOverTime)]
    pub fn is_over_time(&self) -> bool {
        self.shown().abscissa == Abscissa::Time
    }
}
