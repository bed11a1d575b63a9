//! What a chart has in sight as a table.

use wasm_bindgen::prelude::*;

use crate::plot::{Abscissa, Cell, Extremes};
use crate::units::mm_per_min;
use crate::web::chart::Chart;

/// Rows of the table behind a chart.
const ROWS: usize = 20;

/// A stretch of what is in sight; a pair holds the least and the largest, and an empty list says that there is none.
#[wasm_bindgen(getter_with_clone)]
pub struct TableRow {
    /// Where it begins, mm, or s over time.
    pub from: f64,
    /// Where it ends, mm, or s over time.
    pub to: f64,
    /// First and last line of the program.
    pub lines: Vec<u32>,
    /// Programmed feedrate, mm/min.
    pub programmed: Vec<f64>,
    /// Each curve, in their order.
    pub curves: Vec<TableCell>,
    /// Time lost up to its end, s; none without a recording.
    pub lost: Option<f64>,
    /// The same against the machine after, s; none where there is but one.
    #[wasm_bindgen(js_name = lostAfter)]
    pub lost_after: Option<f64>,
}

/// One curve in a stretch.
#[wasm_bindgen(getter_with_clone)]
#[derive(Clone)]
pub struct TableCell {
    /// Feedrate, mm/min.
    pub feedrate: Vec<f64>,
    /// Largest contour error, mm; none where there is neither a corner nor an arc.
    pub error: Option<f64>,
}

#[wasm_bindgen]
impl Chart {
    /// What is in sight, in equal stretches.
    pub fn table(&self) -> Vec<TableRow> {
        let in_minutes = |Extremes { lowest, highest }| vec![mm_per_min(lowest), mm_per_min(highest)];
        let cell = |cell: Option<Cell>| TableCell {
            feedrate: cell.map(|cell| in_minutes(cell.feedrate)).unwrap_or_default(),
            error: cell.and_then(|cell| cell.error),
        };
        let rows = self.shown().table(self.view.distance, ROWS).into_iter().map(|row| {
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

    /// Whether it is over time.
    #[wasm_bindgen(js_name = isOverTime)]
    pub fn is_over_time(&self) -> bool {
        self.shown().abscissa == Abscissa::Time
    }

    /// What each curve is called.
    pub fn labels(&self) -> Vec<String> {
        self.chart.curves.iter().map(|curve| curve.label.clone()).collect()
    }
}
