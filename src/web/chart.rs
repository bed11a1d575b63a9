//! The chart on its canvas: it keeps the curves, the view and the frame of the last drawing.
//!
//! All pixels that come in and go out are those of the page (CSS pixels, from the canvas' top
//! left corner); the device's pixel ratio is applied here.

use wasm_bindgen::prelude::*;
use web_sys::HtmlCanvasElement;

use crate::plot::{
    Curve, CurveReading as CurveAt, Errors, FeedChart, Frame, LostTime, Programmed, Reading, Stretch, Theme,
    View, draw,
};
use crate::units::mm_per_min;
use crate::web::canvas::Canvas;
use crate::web::theme::theme;

/// The contour error read out is the largest this near to the pointer, pixels.
const REACH: f64 = 4.0;

/// A chart of feedrate and contour error over distance.
#[wasm_bindgen]
pub struct Chart {
    pub(super) chart: FeedChart,
    /// The same over time, where that is shown.
    timed: Option<FeedChart>,
    with_rapids: bool,
    dark: bool,
    pub(super) view: View,
    frame: Frame,
    scale: f64,
}

/// Where the pointer is in the data.
#[wasm_bindgen(getter_with_clone)]
pub struct Pointer {
    /// Pixel column of the distance.
    pub x: f64,
    /// Distance along the path, mm.
    pub distance: f64,
    /// Line of the program run there.
    pub line: Option<u32>,
    /// Programmed feedrate there, mm/min.
    pub programmed: Option<f64>,
    /// Whether a rapid move is run there.
    pub rapid: bool,
    /// What each curve says there, in the order of the curves.
    pub curves: Vec<CurveReading>,
    /// Time lost up to there, s; none without a recording.
    pub lost: Option<f64>,
    /// The same against the machine after, s; none where there is but one.
    #[wasm_bindgen(js_name = lostAfter)]
    pub lost_after: Option<f64>,
}

/// One curve at one distance.
#[wasm_bindgen(getter_with_clone)]
#[derive(Clone)]
pub struct CurveReading {
    /// Name of the curve.
    pub label: String,
    /// Feedrate, mm/min.
    pub feedrate: f64,
    /// Pixel row of the feedrate, kept inside the plotting area.
    pub y: f64,
    /// Time since the start, s.
    pub time: f64,
    /// Largest contour error near there, mm; none where neither a corner nor an arc is near.
    pub error: Option<f64>,
}

#[wasm_bindgen]
impl Chart {
    /// An empty chart.
    #[wasm_bindgen(constructor)]
    #[allow(clippy::new_without_default)] // JavaScript knows no default
    pub fn new() -> Chart {
        let view = View::up_to(1.0, 1.0);
        let frame = Frame { view, x: (0.0, 1.0), y: (0.0, 1.0), pitch: 0.0, errors_y: (0.0, 1.0) };
        Chart {
            chart: FeedChart::default(),
            timed: None,
            with_rapids: false,
            dark: false,
            view,
            frame,
            scale: 1.0,
        }
    }

    /// Begins anew with the programmed feedrate of a job; the columns are those of `Steps`.
    pub fn program(&mut self, end: Vec<f64>, feedrate: Vec<f64>, rapid: &[u8], line: Vec<u32>) {
        let rapid = rapid.iter().map(|&flag| flag != 0).collect();
        let span = self.span();
        self.view.distance = (span[0], span[1]);
        self.chart = FeedChart {
            programmed: Programmed::new(end, feedrate, rapid, line),
            stacked: self.chart.stacked,
            ..FeedChart::default()
        };
        self.timed = None;
    }

    /// Draws over time or over distance what has been filled, with the same stretch in sight.
    #[wasm_bindgen(js_name = setOverTime)]
    pub fn set_over_time(&mut self, over_time: bool) {
        let span = self.span();
        self.timed = over_time.then(|| self.chart.over_time());
        self.view = self.whole();
        self.follow(span[0], span[1]);
    }

    /// Draws every curve in a panel of its own, or all in one.
    #[wasm_bindgen(js_name = setStacked)]
    pub fn set_stacked(&mut self, stacked: bool) {
        self.chart.stacked = stacked;
        if let Some(timed) = &mut self.timed {
            timed.stacked = stacked;
        }
    }

    /// Adds a curve under a name, empty until it is filled: where each tolerance holds along the
    /// path, and what it is; all in mm.
    pub fn add(&mut self, label: String, from: &[f64], to: &[f64], tolerance: &[f64]) {
        let stretches = from.iter().zip(to).zip(tolerance);
        let tolerances =
            stretches.map(|((&from, &to), &tolerance)| Stretch { from, to, tolerance }).collect();
        self.chart.curves.push(Curve { label, tolerances, ..Curve::default() });
    }

    /// Fills the curve added last; the columns are those of `Columns`.
    pub fn fill(&mut self, distance: Vec<f64>, feedrate: Vec<f64>, time: Vec<f64>) {
        if let Some(curve) = self.chart.curves.last_mut() {
            *curve = Curve { distance, feedrate: feedrate.into(), time, ..std::mem::take(curve) };
        }
    }

    /// Gives the curve added last its contour errors; the columns are those of `Columns`.
    #[wasm_bindgen(js_name = fillErrors)]
    pub fn fill_errors(&mut self, corner: Vec<f64>, arcs: Vec<u32>, along_arcs: Vec<f64>) {
        if let Some(curve) = self.chart.curves.last_mut() {
            curve.errors = Errors { corner: corner.into(), arcs, along_arcs: along_arcs.into() };
        }
    }

    /// Shows the time lost against a recording (s over mm) instead of contour errors.
    #[wasm_bindgen(js_name = showLost)]
    pub fn show_lost(&mut self, distance: Vec<f64>, seconds: Vec<f64>) {
        self.chart.lost = Some(LostTime { distance, seconds: seconds.into() });
    }

    /// Shows the time lost against the machine after as well.
    #[wasm_bindgen(js_name = showLostAfter)]
    pub fn show_lost_after(&mut self, distance: Vec<f64>, seconds: Vec<f64>) {
        self.chart.lost_after = Some(LostTime { distance, seconds: seconds.into() });
    }

    /// Colour of the curve with this index, as CSS writes it.
    pub fn color(&self, index: usize) -> String {
        let curves = self.theme().curves;
        let (r, g, b) =
            (curves[index % curves.len()].0, curves[index % curves.len()].1, curves[index % curves.len()].2);
        format!("rgb({r}, {g}, {b})")
    }

    /// Light on dark or dark on light.
    #[wasm_bindgen(js_name = setDark)]
    pub fn set_dark(&mut self, dark: bool) {
        self.dark = dark;
    }

    /// Fits the ordinate to all feedrates or to those of cutting, and shows everything.
    #[wasm_bindgen(js_name = setRapids)]
    pub fn set_rapids(&mut self, shown: bool) {
        self.with_rapids = shown;
        self.reset();
    }

    /// Whether rapids leave the first view at the top.
    #[wasm_bindgen(js_name = hidesRapids)]
    pub fn hides_rapids(&self) -> bool {
        self.chart.full_view(false) != self.chart.full_view(true)
    }

    /// Draws on a canvas of this size in CSS pixels.
    pub fn draw(
        &mut self,
        canvas: HtmlCanvasElement,
        width: f64,
        height: f64,
        ratio: f64,
    ) -> Result<(), String> {
        let backend = Canvas::sized(canvas, width, height, ratio)?;
        self.scale = ratio;
        self.frame = draw(self.shown(), self.view, &self.theme(), ratio, backend)
            .map_err(|error| error.to_string())?;
        Ok(())
    }

    /// What is in sight: first and last on the abscissa, then on the ordinate.
    pub fn view(&self) -> Vec<f64> {
        let View { distance, feedrate } = self.view;
        vec![distance.0, distance.1, feedrate.0, feedrate.1]
    }

    /// Shows what another chart of the same shows.
    #[wasm_bindgen(js_name = setView)]
    pub fn set_view(&mut self, view: &[f64]) {
        if let &[left, right, bottom, top] = view {
            self.view = View { distance: (left, right), feedrate: (bottom, top) };
        }
    }

    /// Shows everything.
    pub fn reset(&mut self) {
        self.view = self.whole();
    }

    /// Shows everything of a new program, or as much as there still is of what was in sight.
    pub fn fit(&mut self, anew: bool) {
        self.view = if anew { self.whole() } else { self.view.moved(0.0, 0.0, self.whole()) };
    }

    /// Shows a stretch between two distances (mm) with what is around it.
    pub fn show(&mut self, from: f64, to: f64) {
        self.view = View::around(self.on_abscissa((from, to)), self.whole());
    }

    /// Shows the same distances (mm) as another chart.
    pub fn follow(&mut self, from: f64, to: f64) {
        self.view = self.view.over(self.on_abscissa((from, to)), self.whole());
    }

    /// Magnifies along the distance by `factor` about a pixel column, or about the middle.
    pub fn zoom(&mut self, factor: f64, x: Option<f64>) {
        let (low, high) = self.view.distance;
        let center = x.map_or(0.5 * (low + high), |x| self.frame.distance_at(x * self.scale));
        self.view = self.view.zoomed(factor, center, self.whole());
    }

    /// Shows the rectangle between two pixels.
    #[wasm_bindgen(js_name = zoomTo)]
    pub fn zoom_to(&mut self, x0: f64, y0: f64, x1: f64, y1: f64) {
        let corner =
            |x: f64, y: f64| (self.frame.distance_at(x * self.scale), self.frame.feedrate_at(y * self.scale));
        self.view = View::between(corner(x0, y0), corner(x1, y1), self.whole());
    }

    /// Moves the picture by pixels.
    pub fn pan(&mut self, dx: f64, dy: f64) {
        let distance = self.frame.distance_at(0.0) - self.frame.distance_at(dx * self.scale);
        let feedrate = self.frame.feedrate_at(0.0) - self.frame.feedrate_at(dy * self.scale);
        self.view = self.view.moved(distance, feedrate, self.whole());
    }

    /// Moves the picture by a part of its width and height; positive to larger values.
    pub fn step(&mut self, right: f64, up: f64) {
        let size = |(low, high): (f64, f64)| high - low;
        let (distance, feedrate) = (right * size(self.view.distance), up * size(self.view.feedrate));
        self.view = self.view.moved(distance, feedrate, self.whole());
    }

    /// Borders in pixels: left and right of both panels, then top and bottom of the feedrates and of
    /// the contour errors below them.
    pub fn area(&self) -> Vec<f64> {
        let Frame { x, y, pitch, errors_y, .. } = self.frame;
        let panels = if 0.0 < pitch { self.chart.curves.len() } else { 1 };
        let lowest = y.1 + pitch * (panels - 1) as f64;
        [x.0, x.1, y.0, lowest, errors_y.0, errors_y.1].map(|pixel| pixel / self.scale).to_vec()
    }

    /// The distances in sight, mm: first and last.
    pub fn span(&self) -> Vec<f64> {
        vec![self.distance_of(self.view.distance.0), self.distance_of(self.view.distance.1)]
    }

    /// Everything about a pixel column; none outside the path.
    pub fn at(&self, x: f64) -> Option<Pointer> {
        let at = self.frame.distance_at(x * self.scale);
        let distance = if self.timed.is_some() { self.chart.distance_at(at)? } else { at };
        self.pointer(distance, at)
    }

    /// Everything about a distance (mm); none outside the path. Over time each curve is read at the moment
    /// in which the first is there.
    pub fn reading(&self, distance: f64) -> Option<Pointer> {
        self.pointer(distance, self.on_abscissa((distance, distance)).0)
    }
}

impl Chart {
    /// Everything about a distance (mm), with the curves read at a place of the abscissa.
    fn pointer(&self, distance: f64, at: f64) -> Option<Pointer> {
        let shown = self.shown();
        let is_beyond = |at: f64, end: f64| at < 0.0 || end < at;
        if is_beyond(distance, self.chart.length()) || is_beyond(at, shown.length()) {
            return None;
        }
        let reach = self.frame.distance_at(REACH * self.scale) - self.frame.distance_at(0.0);
        let here = self.chart.reading(distance, 0.0);
        let Reading { curves, lost, lost_after, .. } = shown.reading(at, reach);
        let curves = shown.curves.iter().zip(curves).enumerate().filter_map(|(index, (curve, read))| {
            let CurveAt { feedrate, time, error } = read?;
            let time = if self.timed.is_some() { at } else { time };
            let row = self.frame.y_of(feedrate).clamp(self.frame.y.0, self.frame.y.1);
            let y = (row + index as f64 * self.frame.pitch) / self.scale;
            Some(CurveReading { label: curve.label.clone(), feedrate: mm_per_min(feedrate), y, time, error })
        });
        Some(Pointer {
            x: self.frame.x_of(at) / self.scale,
            distance,
            line: here.line,
            programmed: here.programmed.map(mm_per_min),
            rapid: here.rapid,
            curves: curves.collect(),
            lost,
            lost_after,
        })
    }

    /// What is drawn.
    pub(super) fn shown(&self) -> &FeedChart {
        self.timed.as_ref().unwrap_or(&self.chart)
    }

    /// The distance (mm) at a place of the abscissa.
    pub(super) fn distance_of(&self, at: f64) -> f64 {
        match &self.timed {
            None => at,
            Some(_) => self.chart.distance_at(at).unwrap_or(0.0),
        }
    }

    /// Two distances (mm) on the abscissa.
    fn on_abscissa(&self, (from, to): (f64, f64)) -> (f64, f64) {
        let at = |distance: f64| match &self.timed {
            None => distance,
            Some(_) => self.chart.time_at(distance).unwrap_or(0.0),
        };
        (at(from), at(to))
    }

    fn whole(&self) -> View {
        self.shown().full_view(self.with_rapids)
    }

    fn theme(&self) -> Theme {
        theme(self.dark)
    }
}
