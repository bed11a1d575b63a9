//! A chart as a picture in a document: SVG text.

use plotters::prelude::SVGBackend;
use plotters_backend::{
    BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingBackend, DrawingErrorKind,
};

use crate::plot::{
    FeedChart, LawChart, LoadChart, Theme, ToleranceChart, View, draw, draw_law, draw_loads, draw_tolerances,
};

/// Returns the whole chart as SVG of this width and height (pixels of the page); `None` if it cannot be drawn.
///
/// # Examples
///
/// ```
/// use truefeed::machine::Machine;
/// use truefeed::plot::{FeedrateCurve, FeedChart, Programmed, Theme, svg};
/// use truefeed::simulation::{gcode::read, profile::Profile, simulate, interpreter::trace};
///
/// let machine = Machine::default();
/// let toolpath = trace(&read(b"G21 G90 G1 X40 F3000\nY40\nX0"), &machine);
/// let plan = simulate(&toolpath, &machine);
/// let drawn = Profile::new(&toolpath, &plan).drawn();
/// let curve = FeedrateCurve {
///     distance: drawn.distance,
///     feedrate: drawn.feedrate.into(),
///     time: drawn.time,
///     ..FeedrateCurve::default()
/// };
/// let programmed = Programmed::of(&toolpath, &machine);
/// let chart = FeedChart { programmed, curves: vec![curve], ..FeedChart::default() };
/// let picture = svg(&chart, &Theme::LIGHT, (800, 400)).expect("there is room for it");
/// assert!(picture.starts_with("<svg"));
/// ```
pub fn svg(chart: &FeedChart, theme: &Theme, size: (u32, u32)) -> Option<String> {
    svg_of_view(chart, chart.full_view(false), theme, size)
}

/// Returns a view of a chart as SVG, like [`svg`].
pub fn svg_of_view(chart: &FeedChart, view: View, theme: &Theme, size: (u32, u32)) -> Option<String> {
    picture(size, |backend| draw(chart, view, theme, 1.0, true, backend).is_ok())
}

/// Returns a chart of cutting loads over the whole path as SVG, like [`svg`].
pub fn svg_of_loads(chart: &LoadChart, theme: &Theme, size: (u32, u32)) -> Option<String> {
    let span = chart.span();
    picture(size, |backend| draw_loads(chart, span, theme, 1.0, backend).is_ok())
}

/// Returns a chart of cycle time over tolerance as SVG, like [`svg`].
pub fn svg_of_tolerances(chart: &ToleranceChart, theme: &Theme, size: (u32, u32)) -> Option<String> {
    picture(size, |backend| draw_tolerances(chart, theme, 1.0, backend).is_ok())
}

/// Returns the chart of a law as measured as SVG, like [`svg`].
pub fn svg_of_law(chart: &LawChart, theme: &Theme, size: (u32, u32)) -> Option<String> {
    picture(size, |backend| draw_law(chart, theme, 1.0, backend).is_ok())
}

fn picture(size: (u32, u32), draw: impl FnOnce(LetterSizedSvg) -> bool) -> Option<String> {
    let mut text = String::new();
    let drawn = draw(LetterSizedSvg(SVGBackend::with_string(&mut text, size)));
    drawn.then_some(text)
}

/// Mean width of a letter, in sizes of the text.
const LETTER_WIDTH_EM: f64 = 0.55;
/// Height of a line, in sizes of the text.
const LINE_HEIGHT_EM: f64 = 1.45;

type SvgError<'a> = <SVGBackend<'a> as DrawingBackend>::ErrorType;
type SvgDrawn<'a> = Result<(), DrawingErrorKind<SvgError<'a>>>;

/// An SVG backend that estimates the width of a text by its letters: in a browser, plotters would measure it
/// by an inline style, which the page's Content-Security-Policy refuses.
struct LetterSizedSvg<'a>(SVGBackend<'a>);

impl<'a> DrawingBackend for LetterSizedSvg<'a> {
    type ErrorType = SvgError<'a>;

    fn get_size(&self) -> (u32, u32) {
        self.0.get_size()
    }

    fn ensure_prepared(&mut self) -> SvgDrawn<'a> {
        self.0.ensure_prepared()
    }

    fn present(&mut self) -> SvgDrawn<'a> {
        self.0.present()
    }

    fn draw_pixel(&mut self, point: BackendCoord, color: BackendColor) -> SvgDrawn<'a> {
        self.0.draw_pixel(point, color)
    }

    fn draw_line<S: BackendStyle>(
        &mut self,
        from: BackendCoord,
        to: BackendCoord,
        style: &S,
    ) -> SvgDrawn<'a> {
        self.0.draw_line(from, to, style)
    }

    fn draw_rect<S: BackendStyle>(
        &mut self,
        upper_left: BackendCoord,
        bottom_right: BackendCoord,
        style: &S,
        fill: bool,
    ) -> SvgDrawn<'a> {
        self.0.draw_rect(upper_left, bottom_right, style, fill)
    }

    fn draw_path<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(
        &mut self,
        path: I,
        style: &S,
    ) -> SvgDrawn<'a> {
        self.0.draw_path(path, style)
    }

    fn draw_circle<S: BackendStyle>(
        &mut self,
        center: BackendCoord,
        radius: u32,
        style: &S,
        fill: bool,
    ) -> SvgDrawn<'a> {
        self.0.draw_circle(center, radius, style, fill)
    }

    fn fill_polygon<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(
        &mut self,
        corners: I,
        style: &S,
    ) -> SvgDrawn<'a> {
        self.0.fill_polygon(corners, style)
    }

    fn draw_text<S: BackendTextStyle>(&mut self, text: &str, style: &S, at: BackendCoord) -> SvgDrawn<'a> {
        self.0.draw_text(text, style, at)
    }

    fn estimate_text_size<S: BackendTextStyle>(
        &self,
        text: &str,
        style: &S,
    ) -> Result<(u32, u32), DrawingErrorKind<Self::ErrorType>> {
        let (width, height) = (LETTER_WIDTH_EM, LINE_HEIGHT_EM);
        let letters = text.chars().count() as f64;
        Ok(((width * style.size() * letters).ceil() as u32, (height * style.size()).round() as u32))
    }
}
