//! The overview of a chart, the part in view, and the pixels of places on the path.

use wasm_bindgen::prelude::*;
use web_sys::HtmlCanvasElement;

use crate::plot::draw_overview;
use crate::web::canvas::Canvas;
use crate::web::chart::Chart;

#[wasm_bindgen]
impl Chart {
    /// Draws the whole path, without axes, on a canvas of this size in CSS pixels.
    #[wasm_bindgen(js_name = drawOverview)]
    pub fn draw_overview(
        &self,
        canvas: HtmlCanvasElement,
        width: f64,
        height: f64,
        ratio: f64,
    ) -> Result<(), String> {
        let backend = Canvas::sized(canvas, width, height, ratio)?;
        draw_overview(self.shown(), &self.theme(), ratio, backend).map_err(|error| error.to_string())
    }

    /// Returns the beginning and end of the view as parts of the whole path.
    pub fn part(&self) -> Vec<f64> {
        let (low, high) = self.whole().distance;
        [self.view.distance.0, self.view.distance.1].map(|at| (at - low) / (high - low)).to_vec()
    }

    /// Shows the range between two parts of the whole path.
    #[wasm_bindgen(js_name = showPart)]
    pub fn show_part(&mut self, from: f64, to: f64) {
        let whole = self.whole();
        let (low, high) = whole.distance;
        self.view = self.view.over((low + from * (high - low), low + to * (high - low)), whole);
    }

    /// Returns the pixel columns of distances (mm), within the plotting area.
    pub fn columns(&self, distances: &[f64]) -> Vec<f64> {
        let (left, right) = self.frame.x;
        let column =
            |&at: &f64| self.frame.x_of(self.on_abscissa((at, at)).0).clamp(left, right) / self.scale;
        distances.iter().map(column).collect()
    }
}
