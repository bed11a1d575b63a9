//! The small chart of a law as measured on its canvas. Pixels are those of the page.

use wasm_bindgen::prelude::*;
use web_sys::HtmlCanvasElement;

use crate::plot::{LawChart, draw_law};
use crate::project::law_chart;
use crate::web::canvas::Canvas;
use crate::web::theme::theme;

/// The chart of a law.
#[wasm_bindgen]
pub struct LawPicture(LawChart);

#[wasm_bindgen]
impl LawPicture {
    /// Returns the chart of a law of a report, given as JSON; throws if the text is not a law.
    #[wasm_bindgen(constructor)]
    pub fn new(law: &str) -> Result<LawPicture, String> {
        law_chart(law).map(LawPicture).ok_or_else(|| "not a law of a report".to_string())
    }

    /// Draws on a canvas of this size in CSS pixels.
    pub fn draw(
        &self,
        canvas: HtmlCanvasElement,
        width: f64,
        height: f64,
        ratio: f64,
        dark: bool,
    ) -> Result<(), String> {
        let backend = Canvas::sized(canvas, width, height, ratio)?;
        draw_law(&self.0, &theme(dark), ratio, backend).map_err(|error| error.to_string())
    }
}
