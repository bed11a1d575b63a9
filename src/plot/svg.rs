//! A chart as a picture that stands in a document: SVG text.

use plotters::prelude::SVGBackend;
use plotters_backend::{
    BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingBackend, DrawingErrorKind,
};

use crate::plot::{FeedChart, LoadChart, Theme, ToleranceChart, View, draw, draw_loads, draw_tolerances};

/// The whole chart as SVG of this width and height (pixels of the page); none where it cannot be drawn.
pub fn svg(chart: &FeedChart, theme: &Theme, size: (u32, u32)) -> Option<String> {
    svg_of_view(chart, chart.full_view(false), theme, size)
}

/// What is in sight of a chart, as [`svg`].
pub fn svg_of_view(chart: &FeedChart, view: View, theme: &Theme, size: (u32, u32)) -> Option<String> {
    picture(size, |backend| draw(chart, view, theme, 1.0, backend).is_ok())
}

/// A chart of cutting loads over all of the path, as [`svg`].
pub fn svg_of_loads(chart: &LoadChart, theme: &Theme, size: (u32, u32)) -> Option<String> {
    let span = chart.span();
    picture(size, |backend| draw_loads(chart, span, theme, 1.0, backend).is_ok())
}

/// A chart of cycle time over tolerance, as [`svg`].
pub fn svg_of_tolerances(chart: &ToleranceChart, theme: &Theme, size: (u32, u32)) -> Option<String> {
    picture(size, |backend| draw_tolerances(chart, theme, 1.0, backend).is_ok())
}

fn picture(size: (u32, u32), draw: impl FnOnce(Letters) -> bool) -> Option<String> {
    let mut text = String::new();
    let drawn = draw(Letters(SVGBackend::with_string(&mut text, size)));
    drawn.then_some(text)
}

/// Mean width of a letter and height of a line as multiples of the size of the text.
const LETTER: (f64, f64) = (0.55, 1.45);

type SvgError<'a> = <SVGBackend<'a> as DrawingBackend>::ErrorType;
type Drawn<'a> = Result<(), DrawingErrorKind<SvgError<'a>>>;

/// SVG whose texts are as wide as their letters are on average: plotters measures them in a browser by an
/// inline style, which the page's Content-Security-Policy refuses.
struct Letters<'a>(SVGBackend<'a>);

impl<'a> DrawingBackend for Letters<'a> {
    type ErrorType = SvgError<'a>;

    fn get_size(&self) -> (u32, u32) {
        self.0.get_size()
    }

    fn ensure_prepared(&mut self) -> Drawn<'a> {
        self.0.ensure_prepared()
    }

    fn present(&mut self) -> Drawn<'a> {
        self.0.present()
    }

    fn draw_pixel(&mut self, point: BackendCoord, color: BackendColor) -> Drawn<'a> {
        self.0.draw_pixel(point, color)
    }

    fn draw_line<S: BackendStyle>(&mut self, from: BackendCoord, to: BackendCoord, style: &S) -> Drawn<'a> {
        self.0.draw_line(from, to, style)
    }

    fn draw_rect<S: BackendStyle>(
        &mut self,
        upper_left: BackendCoord,
        bottom_right: BackendCoord,
        style: &S,
        fill: bool,
    ) -> Drawn<'a> {
        self.0.draw_rect(upper_left, bottom_right, style, fill)
    }

    fn draw_path<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(
        &mut self,
        path: I,
        style: &S,
    ) -> Drawn<'a> {
        self.0.draw_path(path, style)
    }

    fn draw_circle<S: BackendStyle>(
        &mut self,
        center: BackendCoord,
        radius: u32,
        style: &S,
        fill: bool,
    ) -> Drawn<'a> {
        self.0.draw_circle(center, radius, style, fill)
    }

    fn fill_polygon<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(
        &mut self,
        corners: I,
        style: &S,
    ) -> Drawn<'a> {
        self.0.fill_polygon(corners, style)
    }

    fn draw_text<S: BackendTextStyle>(&mut self, text: &str, style: &S, at: BackendCoord) -> Drawn<'a> {
        self.0.draw_text(text, style, at)
    }

    fn estimate_text_size<S: BackendTextStyle>(
        &self,
        text: &str,
        style: &S,
    ) -> Result<(u32, u32), DrawingErrorKind<Self::ErrorType>> {
        let (width, height) = LETTER;
        let letters = text.chars().count() as f64;
        Ok(((width * style.size() * letters).ceil() as u32, (height * style.size()).round() as u32))
    }
}
