//! The canvas of a page as a plotters backend that measures text by the canvas itself.
//!
//! plotters measures a text by inserting it in the page with an inline style. The page's
//! Content-Security-Policy refuses that style, and the browser would lay out the page again for each label.
//! All other drawing is done by plotters-canvas.

use plotters_backend::{
    BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingBackend, DrawingErrorKind,
};
use plotters_canvas::CanvasBackend;
use wasm_bindgen::JsCast;
use web_sys::{CanvasRenderingContext2d, HtmlCanvasElement};

/// Height of a line of text over its size, as in the page's style.
const LINE_HEIGHT: f64 = 1.45;

type CanvasError = <CanvasBackend as DrawingBackend>::ErrorType;
type CanvasDrawn = Result<(), DrawingErrorKind<CanvasError>>;

/// A canvas of the page.
pub(super) struct Canvas {
    backend: CanvasBackend,
    context: CanvasRenderingContext2d,
}

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
            (Some(backend), Some(context)) => Ok(Canvas { backend, context }),
            _ => Err("this canvas cannot be drawn on".to_string()),
        }
    }
}

impl DrawingBackend for Canvas {
    type ErrorType = CanvasError;

    fn get_size(&self) -> (u32, u32) {
        self.backend.get_size()
    }

    fn ensure_prepared(&mut self) -> CanvasDrawn {
        self.backend.ensure_prepared()
    }

    fn present(&mut self) -> CanvasDrawn {
        self.backend.present()
    }

    fn draw_pixel(&mut self, point: BackendCoord, color: BackendColor) -> CanvasDrawn {
        self.backend.draw_pixel(point, color)
    }

    fn draw_line<S: BackendStyle>(&mut self, from: BackendCoord, to: BackendCoord, style: &S) -> CanvasDrawn {
        self.backend.draw_line(from, to, style)
    }

    fn draw_rect<S: BackendStyle>(
        &mut self,
        upper_left: BackendCoord,
        bottom_right: BackendCoord,
        style: &S,
        fill: bool,
    ) -> CanvasDrawn {
        self.backend.draw_rect(upper_left, bottom_right, style, fill)
    }

    fn draw_path<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(
        &mut self,
        path: I,
        style: &S,
    ) -> CanvasDrawn {
        self.backend.draw_path(path, style)
    }

    fn draw_circle<S: BackendStyle>(
        &mut self,
        center: BackendCoord,
        radius: u32,
        style: &S,
        fill: bool,
    ) -> CanvasDrawn {
        self.backend.draw_circle(center, radius, style, fill)
    }

    fn fill_polygon<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(
        &mut self,
        corners: I,
        style: &S,
    ) -> CanvasDrawn {
        self.backend.fill_polygon(corners, style)
    }

    fn draw_text<S: BackendTextStyle>(&mut self, text: &str, style: &S, at: BackendCoord) -> CanvasDrawn {
        self.backend.draw_text(text, style, at)
    }

    fn estimate_text_size<S: BackendTextStyle>(
        &self,
        text: &str,
        style: &S,
    ) -> Result<(u32, u32), DrawingErrorKind<CanvasError>> {
        let size = style.size();
        self.context.set_font(&format!("{} {size}px {}", style.style().as_str(), style.family().as_str()));
        // If the browser cannot measure text, half the font size per letter is accurate enough.
        let width = self
            .context
            .measure_text(text)
            .map_or(0.5 * size * text.chars().count() as f64, |measured| measured.width());
        Ok((width.ceil() as u32, (LINE_HEIGHT * size).round() as u32))
    }
}
