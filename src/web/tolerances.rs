//! The chart of cycle time over contour tolerance on its canvas. Pixels are those of the page.

use wasm_bindgen::prelude::*;
use web_sys::HtmlCanvasElement;

use crate::plot::{
    self, TimeCurve, ToleranceChart, ToleranceFrame, ToleranceMark, draw_tolerances, svg_of_tolerances,
};
use crate::web::canvas::Canvas;
use crate::web::theme::theme;

/// Returns the tolerances of a curve, mm.
#[wasm_bindgen(js_name = curveTolerances)]
pub fn curve_tolerances() -> Vec<f64> {
    plot::curve_tolerances()
}

/// The chart of cycle time over contour tolerance.
#[wasm_bindgen]
pub struct TolerancePicture {
    chart: ToleranceChart,
    frame: Option<ToleranceFrame>,
    scale: f64,
}

#[wasm_bindgen]
impl TolerancePicture {
    /// Returns a chart with only the programmed time (s).
    #[wasm_bindgen(constructor)]
    pub fn new(programmed: f64) -> TolerancePicture {
        let chart = ToleranceChart { programmed, ..ToleranceChart::default() };
        TolerancePicture { chart, frame: None, scale: 1.0 }
    }

    /// Adds the line of a machine: tolerances (mm, ascending) and cycle times (s).
    pub fn add(&mut self, tolerance: Vec<f64>, time: Vec<f64>) {
        self.chart.curves.push(TimeCurve { tolerance, time });
    }

    /// Marks a tolerance (mm) at its cycle time (s) in the colour with this index.
    pub fn mark(&mut self, color: usize, tolerance: f64, time: f64) {
        self.chart.marks.push(ToleranceMark { color, tolerance, time });
    }

    /// Draws on a canvas of this size in CSS pixels.
    pub fn draw(
        &mut self,
        canvas: HtmlCanvasElement,
        width: f64,
        height: f64,
        ratio: f64,
        dark: bool,
    ) -> Result<(), String> {
        let backend = Canvas::sized(canvas, width, height, ratio)?;
        let frame =
            draw_tolerances(&self.chart, &theme(dark), ratio, backend).map_err(|error| error.to_string())?;
        (self.frame, self.scale) = (Some(frame), ratio);
        Ok(())
    }

    /// Returns the chart as SVG for a document, dark on white; undefined if it cannot be drawn.
    pub fn svg(&self, width: u32, height: u32) -> Option<String> {
        svg_of_tolerances(&self.chart, &theme(false), (width, height))
    }

    /// Returns the tolerance (mm) at a pixel column; undefined outside the plotting area.
    #[wasm_bindgen(js_name = toleranceAt)]
    pub fn tolerance_at(&self, x: f64) -> Option<f64> {
        self.frame?.tolerance_at(x * self.scale)
    }

    /// Returns the pixel column of a tolerance (mm), and top and bottom of the plotting area; empty before
    /// the first drawing.
    #[wasm_bindgen(js_name = columnOf)]
    pub fn column_of(&self, tolerance: f64) -> Vec<f64> {
        let frame = self.frame.iter();
        frame
            .flat_map(|frame| [frame.x_of(tolerance), frame.y.0, frame.y.1])
            .map(|pixel| pixel / self.scale)
            .collect()
    }

    /// Returns the cycle time (s) at a tolerance (mm) on each line; NaN outside the line.
    pub fn times(&self, tolerance: f64) -> Vec<f64> {
        self.chart.curves.iter().map(|curve| curve.at(tolerance).unwrap_or(f64::NAN)).collect()
    }
}
