//! The stock as a height map, cut by a mill step by step.
//!
//! Each cell of side a (mm) holds the height of the material at its centre; the mill lowers the cells that it
//! passes over to the height of its bottom. A mill of radius R cuts the cells whose centres it covers, so
//! that the area it sweeps is known except for a strip of half a cell along its border,
//!
//! ```text
//! |ΔV| ≤ ½ √2 a · border · depth        borders average out, so it is less in practice
//! ```
//!
//! The work of a step from P to Q grows with the rows under the mill and the newly covered cells; if the mill
//! moves down, with all cells it covers. A height map cannot represent overhanging material.

use crate::cutting::setup::{CuttingError, MAX_MAP_CELLS, Mill, StockBox};
use crate::simulation::toolpath::Point;

/// The top of the material over a rectangle.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightMap {
    /// Corner with the least x and y, mm.
    origin: [f64; 2],
    /// Sides of a cell, mm; at most the resolution, so that whole cells fill the stock.
    cell: [f64; 2],
    /// Cells along x and y.
    size: [usize; 2],
    /// Bottom of the stock, mm.
    floor: f64,
    /// Top of the untouched stock, mm.
    top: f64,
    /// Height of each cell, mm, row after row along x.
    heights: Vec<f64>,
}

impl HeightMap {
    /// Returns the untouched stock, with cells of `resolution` (mm) or a little less.
    ///
    /// # Errors
    ///
    /// Returns an error if the stock has no volume or would need too many cells.
    pub fn new(stock: &StockBox, resolution: f64) -> Result<HeightMap, CuttingError> {
        let extent = [0, 1, 2].map(|axis: usize| stock.max[axis] - stock.min[axis]);
        if let Some(axis) = extent.iter().position(|extent| extent.is_nan() || *extent <= 0.0) {
            return Err(CuttingError::EmptyStock { axis: ['X', 'Y', 'Z'][axis] });
        }
        let cells = [0, 1].map(|axis: usize| (extent[axis] / resolution - 1e-9).ceil().max(1.0));
        // A long thin stock has at least one cell across.
        if resolution.is_nan() || resolution <= 0.0 || 2.0 * MAX_MAP_CELLS < cells[0] * cells[1] {
            let coarser = stock.finest();
            return Err(CuttingError::TooFine { resolution, coarser });
        }
        let size = cells.map(|cells| cells as usize);
        Ok(HeightMap {
            origin: [stock.min[0], stock.min[1]],
            cell: [extent[0] / cells[0], extent[1] / cells[1]],
            size,
            floor: stock.min[2],
            top: stock.max[2],
            heights: vec![stock.max[2]; size[0] * size[1]],
        })
    }

    /// Returns the longer side of a cell, mm.
    pub fn resolution(&self) -> f64 {
        self.cell[0].max(self.cell[1])
    }

    /// Returns the height of the material at a place, mm; `None` outside of the stock.
    pub fn height(&self, x: f64, y: f64) -> Option<f64> {
        let [i, j] = [(x - self.origin[0]) / self.cell[0], (y - self.origin[1]) / self.cell[1]];
        let is_inside = 0.0 <= i && i < self.size[0] as f64 && 0.0 <= j && j < self.size[1] as f64;
        is_inside.then(|| self.heights[j as usize * self.size[0] + i as usize])
    }

    /// Returns the volume of the remaining material, mm³.
    pub fn volume(&self) -> f64 {
        let heights: f64 = self.heights.iter().map(|height| height - self.floor).sum();
        heights * self.cell[0] * self.cell[1]
    }

    /// Returns `true` if a mill of this radius cannot touch the stock anywhere between two points.
    pub fn is_clear(&self, radius: f64, a: Point, b: Point) -> bool {
        let is_beside = (0..2).any(|axis| {
            let [least, most] = [a[axis].min(b[axis]) - radius, a[axis].max(b[axis]) + radius];
            most <= self.origin[axis] || self.origin[axis] + self.cell[axis] * self.size[axis] as f64 <= least
        });
        is_beside || self.top <= a.z.min(b.z)
    }

    /// Returns the parts of the straight path from `a` to `b`, from 0 to 1, between which a mill of this
    /// radius can touch the stock; `None` if it cannot.
    pub fn reach(&self, radius: f64, a: Point, b: Point) -> Option<(f64, f64)> {
        let (mut from, mut to) = (0.0_f64, 1.0_f64);
        let mut within = |start: f64, end: f64, low: f64, high: f64| {
            let way = end - start;
            if way == 0.0 {
                if start < low || high < start {
                    to = f64::NEG_INFINITY;
                }
                return;
            }
            let ends = [(low - start) / way, (high - start) / way];
            from = from.max(ends[0].min(ends[1]));
            to = to.min(ends[0].max(ends[1]));
        };
        for axis in 0..2 {
            let extent = self.cell[axis] * self.size[axis] as f64;
            let low = self.origin[axis];
            within(a[axis], b[axis], low - radius, low + extent + radius);
        }
        within(a.z, b.z, f64::NEG_INFINITY, self.top);
        (from < to).then_some((from, to))
    }

    /// Cuts with the tip of a mill at `to`; returns the removed volume, mm³. `from` is the position of the
    /// last cut of the same mill, near enough that no cell lies between the two cuts.
    pub fn cut(&mut self, mill: &Mill, from: Option<Point>, to: Point) -> f64 {
        let radius = mill.radius();
        if self.is_clear(radius, to, to) {
            return 0.0;
        }
        // Below the flat of the mill the step before has left no material, unless the mill moves down.
        let flat = radius - mill.corner_radius.min(radius);
        let done = from.filter(|from| from.z <= to.z && 0.0 < flat);
        let mut removed = 0.0;
        for row in self.covered(1, to.y, radius) {
            let y = self.center(1, row);
            let Some(half) = half_chord(radius, y - to.y) else { continue };
            let columns = self.covered(0, to.x, half);
            let skipped = match done.and_then(|from| Some((from.x, half_chord(flat, y - from.y)?))) {
                Some((x, half)) => self.covered(0, x, half),
                None => columns.start..columns.start,
            };
            let before = columns.start..columns.end.min(skipped.start);
            let after = columns.start.max(skipped.end.max(before.end))..columns.end;
            for column in before.chain(after) {
                let bottom = match mill.corner_radius {
                    0.0 => to.z,
                    _ => to.z + mill.rise((self.center(0, column) - to.x).hypot(y - to.y)),
                };
                let height = &mut self.heights[row * self.size[0] + column];
                let lower = bottom.max(self.floor);
                if lower < *height {
                    removed += *height - lower;
                    *height = lower;
                }
            }
        }
        removed * self.cell[0] * self.cell[1]
    }

    fn center(&self, axis: usize, index: usize) -> f64 {
        self.origin[axis] + self.cell[axis] * (index as f64 + 0.5)
    }

    /// Returns the indices of the cells along an axis whose centres lie within `half` of a place.
    fn covered(&self, axis: usize, place: f64, half: f64) -> std::ops::Range<usize> {
        let first = ((place - half - self.origin[axis]) / self.cell[axis] - 0.5).ceil();
        let last = ((place + half - self.origin[axis]) / self.cell[axis] - 0.5).floor();
        // A cast maps negative values to 0.
        let start = (first as usize).min(self.size[axis]);
        let end = ((last + 1.0) as usize).clamp(start, self.size[axis]);
        start..end
    }
}

fn half_chord(radius: f64, away: f64) -> Option<f64> {
    let square = radius * radius - away * away;
    (0.0 <= square).then(|| square.sqrt())
}
