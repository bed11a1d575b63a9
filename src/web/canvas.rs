//! The canvas of a page, which measures text itself. All other drawing is done by plotters-canvas.

use plotters_backend::BackendTextStyle;
use plotters_canvas::CanvasBackend;
use wasm_bindgen::JsCast;
use web_sys::{CanvasRenderingContext2d, HtmlCanvasElement};

use crate::plot::{Measuring, TextMeasure};

/// A canvas of the page.
pub(super) type Canvas = Measuring<CanvasBackend, CanvasMeasure>;

/// The width of a text on a canvas.
pub(super) struct CanvasMeasure(CanvasRenderingContext2d);

impl Canvas {
    /// Returns the canvas, set to a size in CSS pixels at a pixel ratio, or the reason why it does not permit
    /// drawing.
    pub(super) fn sized(
        canvas: HtmlCanvasElement,
        width: f64,
        height: f64,
        ratio: f64,
    ) -> Result<Canvas, String> {
        canvas.set_width((width * ratio).round() as u32);
        canvas.set_height((height * ratio).round() as u32);
        let context = canvas.get_context("2d").ok().flatten().and_then(|context| context.dyn_into().ok());
        let backend = CanvasBackend::with_canvas_object(canvas);
        match (backend, context) {
            (Some(backend), Some(context)) => Ok(Canvas { backend, measure: CanvasMeasure(context) }),
            _ => Err("this canvas cannot be drawn on".to_string()),
        }
    }
}

impl TextMeasure for CanvasMeasure {
    fn width<S: BackendTextStyle>(&self, text: &str, style: &S) -> f64 {
        let size = style.size();
        self.0.set_font(&format!("{} {size}px {}", style.style().as_str(), style.family().as_str()));
        // If the browser cannot measure text, half the font size per letter is accurate enough.
        let measured = self.0.measure_text(text);
        measured.map_or(0.5 * size * text.chars().count() as f64, |measured| measured.width())
    }
}
