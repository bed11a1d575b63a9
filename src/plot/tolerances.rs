//! The chart of cycle time over contour tolerance, which shows the time that a wider tolerance saves.
//!
//! The abscissa is the contour tolerance on a logarithmic axis, µm or in; the ordinate the cycle time, s.
//! Each machine has a line, straight between the computed tolerances. A dot marks each chosen tolerance, in the
//! colour of its curve in the chart of feedrates; a broad pale line is the programmed time. The ordinate fits
//! the data and need not begin at 0.

use plotters::prelude::*;

use crate::machine::{checked_tolerance, tolerance_label_in};
use crate::plot::Theme;
use crate::plot::panel::{Axes, DrawError, FONT, FONT_SIZE_PT, Look, PanelContext, axis_number, borders};
use crate::simulation::sampled::{RowsAround, rows_around};
use crate::units::LengthUnit;

/// Least and largest tolerance of the lines, mm.
const TOLERANCE_BOUNDS_MM: (f64, f64) = (0.001, 1.0);
const POINTS_PER_LINE: usize = 24;

/// Room above and below the data, as a part of it, and least span of the ordinate, s.
const HEADROOM_SHARE: f64 = 0.1;
const MIN_SPAN_S: f64 = 0.1;

/// Largest difference of a logarithm from a whole decade that counts as rounding.
const MAX_ROUNDING_DECADES: f64 = 1e-9;

/// Radius of a dot, points.
const DOT_RADIUS_PT: f64 = 4.5;

/// Significant digits of a tolerance under the pointer.
const SIGNIFICANT_DIGITS: f64 = 2.0;

/// Returns the tolerances of a line, mm: evenly spaced on the logarithmic axis.
pub fn curve_tolerances() -> Vec<f64> {
    let ratio = (TOLERANCE_BOUNDS_MM.1 / TOLERANCE_BOUNDS_MM.0).log10() / (POINTS_PER_LINE - 1) as f64;
    (0..POINTS_PER_LINE).map(|k| TOLERANCE_BOUNDS_MM.0 * 10f64.powf(ratio * k as f64)).collect()
}

/// Cycle time over contour tolerance on one machine, in columns of equal length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TimeCurve {
    /// Contour tolerance, mm, ascending.
    pub tolerance: Vec<f64>,
    /// Cycle time, s.
    pub time: Vec<f64>,
}

/// A chosen tolerance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToleranceMark {
    /// Index of its colour among the curves.
    pub color: usize,
    /// Contour tolerance, mm.
    pub tolerance: f64,
    /// Cycle time, s.
    pub time: f64,
}

/// Data of the chart.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ToleranceChart {
    /// Cycle time by length over feedrate, s.
    pub programmed: f64,
    /// The machine, and another one for comparison.
    pub curves: Vec<TimeCurve>,
    /// Chosen tolerances on the first curve.
    pub marks: Vec<ToleranceMark>,
}

/// The plotting area of the chart, pixels, and its ranges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToleranceFrame {
    /// Left and right.
    pub x: (f64, f64),
    /// Top and bottom.
    pub y: (f64, f64),
    /// Decimal logarithms of the tolerances at left and right, in the unit.
    pub decades: (f64, f64),
    /// Cycle times at bottom and top, s.
    pub time: (f64, f64),
    /// Unit of the tolerances on the axis.
    pub unit: LengthUnit,
}

impl TimeCurve {
    /// Returns the cycle time (s) at a tolerance (mm), linear between rows on the logarithmic axis; `None`
    /// outside them.
    pub fn at(&self, tolerance: f64) -> Option<f64> {
        let (first, last) = (self.tolerance.first()?, self.tolerance.last()?);
        if tolerance < *first || *last < tolerance {
            return None;
        }
        let RowsAround { before, after, .. } = rows_around(&self.tolerance, tolerance, &mut 0)?;
        let (low, high) = (self.tolerance[before].log10(), self.tolerance[after].log10());
        let part = if low < high { (tolerance.log10() - low) / (high - low) } else { 1.0 };
        Some(self.time[before] + part * (self.time[after] - self.time[before]))
    }
}

impl ToleranceFrame {
    /// Returns the tolerance (mm) at a pixel column, with two significant digits in the unit of the axis;
    /// `None` outside the area.
    pub fn tolerance_at(&self, x: f64) -> Option<f64> {
        let part = (x - self.x.0) / (self.x.1 - self.x.0);
        let exact = 10f64.powf(self.decades.0 + part * (self.decades.1 - self.decades.0));
        let step = 10f64.powf(exact.log10().floor() - (SIGNIFICANT_DIGITS - 1.0));
        (0.0..=1.0)
            .contains(&part)
            .then(|| self.unit.to_mm((exact / step).round() * step))
            .and_then(|t| checked_tolerance(t).ok())
    }

    /// Returns the pixel column of a tolerance (mm).
    pub fn x_of(&self, tolerance: f64) -> f64 {
        let at = self.unit.from_mm(tolerance).log10();
        let part = (at - self.decades.0) / (self.decades.1 - self.decades.0);
        self.x.0 + part * (self.x.1 - self.x.0)
    }

    /// Returns the pixel row of a cycle time (s).
    pub fn y_of(&self, time: f64) -> f64 {
        let part = (time - self.time.0) / (self.time.1 - self.time.0);
        self.y.1 - part * (self.y.1 - self.y.0)
    }
}

/// Draws the chart over the whole of a backend and returns its frame.
///
/// # Errors
///
/// Returns an error if the backend fails.
pub fn draw_tolerances<B: DrawingBackend>(
    chart: &ToleranceChart,
    theme: &Theme,
    scale: f64,
    backend: B,
) -> Result<ToleranceFrame, DrawError<B>> {
    let unit = theme.unit;
    let (decades, time) = (decades(chart, unit), times(chart));
    let characters = axis_number(theme, time.1, time.1 - time.0).chars().count() + 1;
    let look = Look { theme: *theme, scale, label_characters: characters.max(5) };
    let root = backend.into_drawing_area();
    root.fill(&theme.background)?;
    let axes = Axes {
        distance: decades,
        distance_title: Some(format!("Contour tolerance ({})", unit.fine_symbol())),
        distance_unit_size: 1.0,
        value: time,
        value_title: "Cycle time (s)".to_string(),
    };
    let mut context = look.panel(&root, &axes)?;
    let borders = borders(&context);
    mesh(&look, &mut context, &axes)?;

    let at = |tolerance: f64| unit.from_mm(tolerance).log10();
    let points = |size: f64| look.points(size);
    let programmed = [(decades.0, chart.programmed), (decades.1, chart.programmed)];
    context.draw_series([PathElement::new(programmed, theme.programmed.stroke_width(points(2.5)))])?;
    for (index, curve) in chart.curves.iter().enumerate().rev() {
        let rows = curve.tolerance.iter().zip(&curve.time).map(|(&tolerance, &time)| (at(tolerance), time));
        let color = if index == 0 { theme.text } else { theme.axis };
        let rows: Vec<_> = rows.collect();
        if index == 0 {
            context.draw_series([PathElement::new(rows, color.stroke_width(points(1.75)))])?;
        } else {
            let dash = points(5.0);
            context.draw_series(DashedLineSeries::new(rows, dash, dash, color.stroke_width(points(1.5))))?;
        }
    }
    for mark in &chart.marks {
        let color = theme.curves[mark.color % theme.curves.len()];
        let place = (at(mark.tolerance), mark.time);
        context.draw_series([Circle::new(place, points(DOT_RADIUS_PT), color.filled())])?;
    }
    root.present()?;
    Ok(ToleranceFrame { x: borders.x, y: borders.y, decades, time, unit })
}

/// Draws grid, axes and numbers: the abscissa has a number per decade and lines at two and five times it.
fn mesh<B: DrawingBackend>(
    look: &Look,
    context: &mut PanelContext<B>,
    axes: &Axes,
) -> Result<(), DrawError<B>> {
    let Theme { text, axis, grid, .. } = look.theme;
    let (low, high) = axes.distance;
    let whole = low.floor() as i32..=high.ceil() as i32;
    for at in whole.flat_map(|decade| [2f64, 5.0].map(|times| f64::from(decade) + times.log10())) {
        if low < at && at < high {
            let line = [(at, axes.value.0), (at, axes.value.1)];
            context.draw_series([PathElement::new(line, grid.stroke_width(look.points(1.0)))])?;
        }
    }
    let font = (FONT, look.points(FONT_SIZE_PT)).into_font().color(&text);
    let number = |value: &f64| axis_number(&look.theme, *value, axes.value.1 - axes.value.0);
    let unit = look.theme.unit;
    let tolerance = |decade: &f64| {
        let label = tolerance_label_in(unit, unit.to_mm(10f64.powf(*decade)));
        label.split(' ').next().unwrap_or_default().to_string()
    };
    let rows = f64::from(context.plotting_area().dim_in_pixel().1) / (28.0 * look.scale);
    context
        .configure_mesh()
        .x_labels((high - low).floor() as usize + 1)
        .y_labels((rows as usize).clamp(2, 12))
        .x_label_formatter(&tolerance)
        .y_label_formatter(&number)
        .x_desc(axes.distance_title.as_deref().unwrap_or_default())
        .y_desc(&*axes.value_title)
        .label_style(font.clone())
        .axis_desc_style(font)
        .axis_style(axis.stroke_width(look.points(1.0)))
        .bold_line_style(grid.stroke_width(look.points(1.0)))
        .light_line_style(TRANSPARENT)
        .set_all_tick_mark_size(look.points(4.0))
        .draw()
}

/// Returns the decimal logarithms of the least and the largest tolerance in view, in a unit: whole decades.
fn decades(chart: &ToleranceChart, unit: LengthUnit) -> (f64, f64) {
    let marks = chart.marks.iter().map(|mark| mark.tolerance);
    let (low, high) = marks.fold(TOLERANCE_BOUNDS_MM, |(low, high), at| (low.min(at), high.max(at)));
    let (low, high) = (unit.from_mm(low), unit.from_mm(high));
    ((low.log10() + MAX_ROUNDING_DECADES).floor(), (high.log10() - MAX_ROUNDING_DECADES).ceil())
}

/// Returns the least and the largest cycle time (s) in view.
fn times(chart: &ToleranceChart) -> (f64, f64) {
    let all = chart.curves.iter().flat_map(|curve| curve.time.iter().copied());
    let all = all.chain(chart.marks.iter().map(|mark| mark.time));
    let start = (chart.programmed, chart.programmed);
    let (low, high) = all.fold(start, |(low, high), time| (low.min(time), high.max(time)));
    let room = HEADROOM_SHARE * (high - low).max(MIN_SPAN_S);
    ((low - room).max(0.0), high + room)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chart() -> ToleranceChart {
        let tolerance = curve_tolerances();
        let time = tolerance.iter().map(|tolerance| 100.0 - 10.0 * tolerance.log10()).collect();
        ToleranceChart {
            programmed: 90.0,
            curves: vec![TimeCurve { tolerance, time }],
            marks: vec![
                ToleranceMark { color: 0, tolerance: 0.01, time: 120.0 },
                ToleranceMark { color: 1, tolerance: 0.05, time: 113.0 },
            ],
        }
    }

    fn svg(chart: &ToleranceChart) -> (String, ToleranceFrame) {
        drawn(chart, &Theme::LIGHT)
    }

    fn drawn(chart: &ToleranceChart, theme: &Theme) -> (String, ToleranceFrame) {
        let mut text = String::new();
        let backend = SVGBackend::with_string(&mut text, (640, 300));
        let frame = draw_tolerances(chart, theme, 1.0, backend).expect("an SVG in memory can be drawn");
        (text, frame)
    }

    #[test]
    fn in_inches_the_axis_has_decades_of_an_inch() {
        let theme = Theme { unit: LengthUnit::Inch, ..Theme::LIGHT };
        let (text, frame) = drawn(&chart(), &theme);
        assert!(text.contains("Contour tolerance (in)"));
        assert_eq!(frame.decades, (-5.0, -1.0));
        for tick in ["0.0001", "0.001", "0.01"] {
            assert!(text.lines().any(|line| line.trim() == tick), "{tick}");
        }
        let at = frame.tolerance_at(frame.x_of(0.0312)).expect("inside");
        assert_eq!(tolerance_label_in(LengthUnit::Inch, at), "0.0012 in");
    }

    #[test]
    fn tolerances_span_three_decades_evenly() {
        let all = curve_tolerances();
        assert_eq!(all.len(), POINTS_PER_LINE);
        assert!((all[0] - 0.001).abs() < 1e-15 && (all[POINTS_PER_LINE - 1] - 1.0).abs() < 1e-12);
        let ratio = all[1] / all[0];
        assert!(all.windows(2).all(|pair| (pair[1] / pair[0] / ratio - 1.0).abs() < 1e-12));
    }

    #[test]
    fn a_line_is_straight_on_the_logarithmic_axis_and_ends_where_it_ends() {
        let curve = &chart().curves[0];
        for tolerance in [0.001, 0.0123, 0.5, 0.9] {
            let time = curve.at(tolerance).expect("within the line");
            assert!((time - (100.0 - 10.0 * f64::log10(tolerance))).abs() < 1e-9);
        }
        assert_eq!((curve.at(0.0005), curve.at(1.5), TimeCurve::default().at(0.01)), (None, None, None));
    }

    #[test]
    fn dots_lie_where_the_frame_says_in_their_colours() {
        let (text, frame) = svg(&chart());
        for (mark, color) in chart().marks.iter().zip(["#0072B2", "#D55E00"]) {
            let circle =
                text.lines().find(|line| line.starts_with("<circle") && line.contains(color)).expect(color);
            let number = |name: &str| -> f64 {
                let rest = circle.split(&format!(" {name}=\"")).nth(1).expect("a circle has a place");
                rest.split('"').next().expect("quoted").parse().expect("a number")
            };
            assert!((number("cx") - frame.x_of(mark.tolerance)).abs() <= 1.5, "{circle} {frame:?}");
            assert!((number("cy") - frame.y_of(mark.time)).abs() <= 1.5, "{circle} {frame:?}");
        }
        for title in ["Contour tolerance (µm)", "Cycle time (s)"] {
            assert_eq!(text.matches(title).count(), 1, "{title}");
        }
    }

    #[test]
    fn what_is_pointed_at_is_what_one_would_type() {
        let (_, frame) = svg(&chart());
        let at = frame.tolerance_at(frame.x_of(0.0123)).expect("inside");
        assert_eq!(tolerance_label_in(LengthUnit::Millimetre, at), "12 µm");
        assert_eq!((frame.tolerance_at(frame.x.0 - 1.0), frame.tolerance_at(frame.x.1 + 1.0)), (None, None));
        let empty = svg(&ToleranceChart::default()).1;
        assert!(empty.time.0 < empty.time.1);
    }
}
