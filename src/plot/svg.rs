//! A chart as a picture in a document: SVG text.

use plotters::prelude::SVGBackend;
use plotters_backend::BackendTextStyle;

use crate::plot::measuring::{Measuring, TextMeasure};
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
    let drawn = draw(Measuring { backend: SVGBackend::with_string(&mut text, size), measure: LetterWidth });
    drawn.then_some(text)
}

/// Mean width of a letter, in sizes of the text.
const LETTER_WIDTH_EM: f64 = 0.55;

/// The width of a text, estimated by the number of its letters.
struct LetterWidth;

type LetterSizedSvg<'a> = Measuring<SVGBackend<'a>, LetterWidth>;

impl TextMeasure for LetterWidth {
    fn width<S: BackendTextStyle>(&self, text: &str, style: &S) -> f64 {
        LETTER_WIDTH_EM * style.size() * text.chars().count() as f64
    }
}
