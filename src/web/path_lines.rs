//! The line of the program at a place of the path, with its feedrate and time.

use js_sys::Float64Array;
use wasm_bindgen::prelude::*;

use crate::plot::Programmed;
use crate::units::mm_per_min;
use crate::web::path::PathView;

#[wasm_bindgen]
impl PathView {
    /// Returns the line of the program that runs at a distance, mm.
    #[wasm_bindgen(js_name = lineAt)]
    pub fn line_at(&self, distance: f64) -> Option<u32> {
        let ends = &self.programmed.end;
        let segment = ends.partition_point(|&end| end < distance).min(ends.len().saturating_sub(1));
        self.programmed.line.get(segment).copied()
    }

    /// Returns the mean feedrate around a distance (mm), mm/min; undefined without a run.
    #[wasm_bindgen(js_name = feedrateAt)]
    pub fn feedrate_at(&self, distance: f64) -> Option<f64> {
        let step = self.pace.end.partition_point(|&end| end < distance);
        self.pace.value.get(step).copied().map(mm_per_min)
    }

    /// Returns the range of the path on which a line of the program first runs: from and to, mm; for a line
    /// without a move, the range of the next line with a move. Empty if there is none.
    #[wasm_bindgen(js_name = stretchOf)]
    pub fn stretch_of(&self, line: u32) -> Vec<f64> {
        let Programmed { end, line: lines, .. } = &self.programmed;
        let own = lines.iter().position(|&other| other == line);
        let next = || {
            let later = lines.iter().enumerate().filter(|(_, other)| line < **other);
            later.min_by_key(|(index, other)| (**other, *index)).map(|(index, _)| index)
        };
        let Some(first) = own.or_else(next) else { return Vec::new() };
        let last = first + lines[first..].iter().take_while(|other| **other == lines[first]).count() - 1;
        vec![if first == 0 { 0.0 } else { end[first - 1] }, end[last]]
    }
}

/// Returns the value of the column `of` at the place where the ascending `column` has the value `value`,
/// linear between two rows. The columns are not copied, because the columns of a long program take
/// most of the memory.
#[wasm_bindgen]
pub fn between(column: &Float64Array, of: &Float64Array, value: f64) -> f64 {
    let (mut low, mut high) = (0, column.length().saturating_sub(1));
    while low + 1 < high {
        let middle = low.midpoint(high);
        if column.get_index(middle) < value { low = middle } else { high = middle }
    }
    let ends = [low, high].map(|row| column.get_index(row));
    let span = ends[1] - ends[0];
    let part = if 0.0 < span { ((value - ends[0]) / span).clamp(0.0, 1.0) } else { 1.0 };
    of.get_index(low) + part * (of.get_index(high) - of.get_index(low))
}
