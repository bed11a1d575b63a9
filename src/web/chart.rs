//! The chart on its canvas, with its curves, its view and the frame of the last drawing.
//!
//! All pixels at the interface are CSS pixels from the canvas' top left corner; the conversion to device
//! pixels is done here.

use wasm_bindgen::prelude::*;
use web_sys::HtmlCanvasElement;

use crate::plot::{
    ChartValues, CurveErrors, CurveValues as CurveAt, FeedChart, FeedrateCurve, Frame, Grains, LostTime,
    Programmed, Theme, TolerancePart, View, draw,
};
use crate::units::mm_per_min;
use crate::web::canvas::Canvas;
use crate::web::theme::theme;

/// Distance from the pointer within which the largest contour error is reported, pixels.
const POINTER_REACH_PX: f64 = 4.0;

/// A chart of feedrate and contour error over distance.
#[wasm_bindgen]
pub struct Chart {
    pub(super) chart: FeedChart,
    /// The chart over time, if it is shown.
    timed: Option<FeedChart>,
    with_rapids: bool,
    dark: bool,
    pub(super) view: View,
    pub(super) frame: Frame,
    pub(super) scale: f64,
}

/// The data under the pointer.
#[wasm_bindgen(getter_with_clone, js_name = Pointer)]
pub struct ChartPointer {
    /// Pixel column of the distance.
    pub x: f64,
    /// Distance along the path, mm.
    pub distance: f64,
    /// Line of the program at the distance.
    pub line: Option<u32>,
    /// Programmed feedrate at the distance, mm/min.
    pub programmed: Option<f64>,
    /// `true` if the segment at the distance is a rapid move.
    pub rapid: bool,
    /// Values of each curve, in the order of the curves.
    pub curves: Vec<CurveAtPointer>,
    /// Time lost up to the distance, s; undefined without a recording.
    pub lost: Option<f64>,
    /// Time lost against the machine after a change, s; undefined if there is one machine only.
    #[wasm_bindgen(js_name = lostAfter)]
    pub lost_after: Option<f64>,
}

/// One curve at one distance.
#[wasm_bindgen(getter_with_clone, js_name = CurveReading)]
#[derive(Clone)]
pub struct CurveAtPointer {
    /// Name of the curve.
    pub label: String,
    /// Feedrate, mm/min; the mean of the strip if means are drawn at the distance.
    pub feedrate: f64,
    /// Least and largest feedrate in that strip, mm/min; empty where every sample is drawn.
    pub range: Vec<f64>,
    /// Index of the curve.
    pub index: usize,
    /// Pixel row of the feedrate, kept inside the plotting area.
    pub y: f64,
    /// Time since the start, s.
    pub time: f64,
    /// Largest contour error nearby, mm; undefined if no corner or arc is near.
    pub error: Option<f64>,
}

#[wasm_bindgen]
impl Chart {
    /// Returns an empty chart.
    #[wasm_bindgen(constructor)]
    #[allow(clippy::new_without_default)] // JavaScript knows no default
    pub fn new() -> Chart {
        let view = View::up_to(1.0, 1.0);
        let frame = Frame {
            view,
            x: (0.0, 1.0),
            y: (0.0, 1.0),
            pitch: 0.0,
            errors_y: (0.0, 1.0),
            grains: Grains::default(),
        };
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

    /// Replaces everything by the programmed feedrate of a job; the columns are those of `Steps`.
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

    /// Draws over time or over distance, with the same range in view.
    #[wasm_bindgen(js_name = setOverTime)]
    pub fn set_over_time(&mut self, over_time: bool) {
        let span = self.span();
        self.timed = over_time.then(|| self.chart.over_time());
        self.view = self.whole();
        self.follow(span[0], span[1]);
    }

    /// Draws each curve in its own panel, or all curves in one.
    #[wasm_bindgen(js_name = setStacked)]
    pub fn set_stacked(&mut self, stacked: bool) {
        for chart in self.both() {
            chart.stacked = stacked;
        }
    }

    /// Draws a curve, by its index, on top of all others.
    #[wasm_bindgen(js_name = setOnTop)]
    pub fn set_on_top(&mut self, index: usize) {
        for chart in self.both() {
            chart.on_top = index;
        }
    }

    /// Hides or shows a curve by its index, or the programmed feedrate without one.
    #[wasm_bindgen(js_name = setHidden)]
    pub fn set_hidden(&mut self, index: Option<usize>, hidden: bool) {
        for chart in self.both() {
            match index {
                None => chart.programmed.hidden = hidden,
                Some(index) => {
                    chart.curves.iter_mut().skip(index).take(1).for_each(|own| own.hidden = hidden)
                }
            }
        }
    }

    /// Returns the names of the curves.
    pub fn labels(&self) -> Vec<String> {
        self.chart.curves.iter().map(|curve| curve.label.clone()).collect()
    }

    /// Adds a curve with a name, the ranges of its tolerances along the path, and the tolerances, all in mm.
    /// The curve is empty until [`fill`](Chart::fill).
    pub fn add(&mut self, label: String, from: &[f64], to: &[f64], tolerance: &[f64]) {
        let stretches = from.iter().zip(to).zip(tolerance);
        let tolerances =
            stretches.map(|((&from, &to), &tolerance)| TolerancePart { from, to, tolerance }).collect();
        self.chart.curves.push(FeedrateCurve { label, tolerances, ..FeedrateCurve::default() });
    }

    /// Fills the curve added last; the columns come from `Columns`.
    pub fn fill(&mut self, distance: Vec<f64>, feedrate: Vec<f64>, time: Vec<f64>) {
        if let Some(curve) = self.chart.curves.last_mut() {
            *curve = FeedrateCurve { distance, feedrate: feedrate.into(), time, ..std::mem::take(curve) };
        }
    }

    /// Adds contour errors to the curve added last; the columns come from `Columns`.
    #[wasm_bindgen(js_name = fillErrors)]
    pub fn fill_errors(&mut self, corner: Vec<f64>, arcs: Vec<u32>, along_arcs: Vec<f64>) {
        if let Some(curve) = self.chart.curves.last_mut() {
            curve.errors = CurveErrors { corner: corner.into(), arcs, along_arcs: along_arcs.into() };
        }
    }

    /// Shows the time lost against a recording (s over mm) instead of contour errors.
    #[wasm_bindgen(js_name = showLost)]
    pub fn show_lost(&mut self, distance: Vec<f64>, seconds: Vec<f64>) {
        self.chart.lost = Some(LostTime { distance, seconds: seconds.into() });
    }

    /// Shows the time lost against the machine after a change as well.
    #[wasm_bindgen(js_name = showLostAfter)]
    pub fn show_lost_after(&mut self, distance: Vec<f64>, seconds: Vec<f64>) {
        self.chart.lost_after = Some(LostTime { distance, seconds: seconds.into() });
    }

    /// Returns the colour of the curve with this index in the notation of CSS.
    pub fn color(&self, index: usize) -> String {
        let curves = self.theme().curves;
        let (r, g, b) =
            (curves[index % curves.len()].0, curves[index % curves.len()].1, curves[index % curves.len()].2);
        format!("rgb({r}, {g}, {b})")
    }

    /// Selects light on dark, or dark on light.
    #[wasm_bindgen(js_name = setDark)]
    pub fn set_dark(&mut self, dark: bool) {
        self.dark = dark;
    }

    /// Fits the ordinate to all feedrates or to those of cutting, and resets the view.
    #[wasm_bindgen(js_name = setRapids)]
    pub fn set_rapids(&mut self, shown: bool) {
        self.with_rapids = shown;
        self.reset();
    }

    /// Returns `true` if rapids leave the first view at the top.
    #[wasm_bindgen(js_name = hidesRapids)]
    pub fn hides_rapids(&self) -> bool {
        self.chart.full_view(false) != self.chart.full_view(true)
    }

    /// Draws on a canvas of this size in CSS pixels; the page shows the legend.
    pub fn draw(
        &mut self,
        canvas: HtmlCanvasElement,
        width: f64,
        height: f64,
        ratio: f64,
    ) -> Result<(), String> {
        let backend = Canvas::sized(canvas, width, height, ratio)?;
        self.scale = ratio;
        self.frame = draw(self.shown(), self.view, &self.theme(), ratio, false, backend)
            .map_err(|error| error.to_string())?;
        Ok(())
    }

    /// Returns the view: first and last on the abscissa, then on the ordinate.
    pub fn view(&self) -> Vec<f64> {
        let View { distance, feedrate } = self.view;
        vec![distance.0, distance.1, feedrate.0, feedrate.1]
    }

    /// Sets the view of another chart of the same data.
    #[wasm_bindgen(js_name = setView)]
    pub fn set_view(&mut self, view: &[f64]) {
        if let &[left, right, bottom, top] = view {
            self.view = View { distance: (left, right), feedrate: (bottom, top) };
        }
    }

    /// Resets the view.
    pub fn reset(&mut self) {
        self.view = self.whole();
    }

    /// Resets the view if the argument is `true`, as for a new program; otherwise limits it to the path.
    pub fn fit(&mut self, anew: bool) {
        self.view = if anew { self.whole() } else { self.view.moved(0.0, 0.0, self.whole()) };
    }

    /// Shows a range of distances (mm) with its surroundings.
    pub fn show(&mut self, from: f64, to: f64) {
        self.view = View::around(self.on_abscissa((from, to)), self.whole());
    }

    /// Shows the distances (mm) of another chart.
    pub fn follow(&mut self, from: f64, to: f64) {
        self.view = self.view.over(self.on_abscissa((from, to)), self.whole());
    }

    /// Magnifies the distance by `factor` about a pixel column, or about the middle.
    pub fn zoom(&mut self, factor: f64, x: Option<f64>) {
        let (low, high) = self.view.distance;
        let center = x.map_or(0.5 * (low + high), |x| self.frame.distance_at(x * self.scale));
        self.view = self.view.zoomed(factor, center, self.whole());
    }

    /// Magnifies the rectangle between two pixels.
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

    /// Returns borders in pixels: left and right of both panels, then top and bottom of the feedrates and of
    /// the contour errors below them.
    pub fn area(&self) -> Vec<f64> {
        let Frame { x, y, pitch, errors_y, .. } = &self.frame;
        let panels = if 0.0 < *pitch { self.chart.curves.len() } else { 1 };
        let lowest = y.1 + pitch * (panels - 1) as f64;
        [x.0, x.1, y.0, lowest, errors_y.0, errors_y.1].map(|pixel| pixel / self.scale).to_vec()
    }

    /// Returns the distances in view, mm: first and last.
    pub fn span(&self) -> Vec<f64> {
        vec![self.distance_of(self.view.distance.0), self.distance_of(self.view.distance.1)]
    }

    /// Returns the data at a pixel column; undefined outside the path.
    pub fn at(&self, x: f64) -> Option<ChartPointer> {
        let at = self.frame.distance_at(x * self.scale);
        let distance = if self.timed.is_some() { self.chart.distance_at(at)? } else { at };
        self.pointer(distance, at)
    }

    /// Returns the data at a distance (mm); undefined outside the path. In a chart over time, each curve is
    /// read at the moment at which the first curve reaches the distance.
    pub fn reading(&self, distance: f64) -> Option<ChartPointer> {
        self.pointer(distance, self.on_abscissa((distance, distance)).0)
    }
}

impl Chart {
    /// Returns the data at a distance (mm), with the curves read at a place of the abscissa.
    fn pointer(&self, distance: f64, at: f64) -> Option<ChartPointer> {
        let shown = self.shown();
        let is_beyond = |at: f64, end: f64| at < 0.0 || end < at;
        if is_beyond(distance, self.chart.length()) || is_beyond(at, shown.length()) {
            return None;
        }
        let reach = self.frame.distance_at(POINTER_REACH_PX * self.scale) - self.frame.distance_at(0.0);
        let here = self.chart.reading(distance, 0.0);
        let ChartValues { curves, lost, lost_after, .. } = shown.reading(at, reach);
        let curves = shown.curves.iter().zip(curves).enumerate().filter_map(|(index, (curve, read))| {
            let CurveAt { feedrate, time, error } = read.filter(|_| !curve.hidden)?;
            let strip = self.frame.grains.strip_at(shown, curve, at);
            let feedrate = strip.map_or(feedrate, |strip| strip.mean);
            let range = strip.iter().flat_map(|strip| [strip.all.lowest, strip.all.highest]);
            let range = range.map(mm_per_min).collect();
            let time = if self.timed.is_some() { at } else { time };
            let row = self.frame.y_of(feedrate).clamp(self.frame.y.0, self.frame.y.1);
            let y = (row + index as f64 * self.frame.pitch) / self.scale;
            let (label, feedrate) = (curve.label.clone(), mm_per_min(feedrate));
            Some(CurveAtPointer { label, feedrate, range, index, y, time, error })
        });
        Some(ChartPointer {
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

    /// Returns the chart over distance, and the one over time if it is shown.
    fn both(&mut self) -> impl Iterator<Item = &mut FeedChart> {
        [&mut self.chart].into_iter().chain(self.timed.as_mut())
    }

    /// Returns the chart that is drawn.
    pub(super) fn shown(&self) -> &FeedChart {
        self.timed.as_ref().unwrap_or(&self.chart)
    }

    /// Returns the distance (mm) at a place of the abscissa.
    pub(super) fn distance_of(&self, at: f64) -> f64 {
        match &self.timed {
            None => at,
            Some(_) => self.chart.distance_at(at).unwrap_or(0.0),
        }
    }

    /// Converts two distances (mm) to the abscissa.
    pub(super) fn on_abscissa(&self, (from, to): (f64, f64)) -> (f64, f64) {
        let at = |distance: f64| match &self.timed {
            None => distance,
            Some(_) => self.chart.time_at(distance).unwrap_or(0.0),
        };
        (at(from), at(to))
    }

    pub(super) fn whole(&self) -> View {
        self.shown().full_view(self.with_rapids)
    }

    pub(super) fn theme(&self) -> Theme {
        theme(self.dark)
    }
}
