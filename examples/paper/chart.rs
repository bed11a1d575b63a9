//! Line charts side by side in one SVG, small enough to be kept beside the text.

use plotters::prelude::*;
use truefeed::plot::Theme;

/// A curve: its name and its points.
pub struct Curve {
    pub name: String,
    pub points: Vec<(f64, f64)>,
}

/// One chart.
pub struct Panel {
    pub title: String,
    pub x: &'static str,
    pub y: &'static str,
    pub curves: Vec<Curve>,
}

/// A curve of `count` points of a function.
pub fn curve(name: &str, range: (f64, f64), count: usize, function: impl Fn(f64) -> f64) -> Curve {
    let at = |i: usize| range.0 + (range.1 - range.0) * i as f64 / (count - 1) as f64;
    let points = (0..count).map(|i| (at(i), function(at(i)))).collect();
    Curve { name: name.to_string(), points }
}

const WIDTH: u32 = 420;
const HEIGHT: u32 = 280;
/// Height of title and names.
const HEAD: u32 = 38;

/// Draws panels in rows of `columns`.
pub fn svg(panels: &[Panel], columns: usize) -> String {
    let mut text = String::new();
    let rows = panels.len().div_ceil(columns);
    {
        let size = (WIDTH * columns as u32, HEIGHT * rows as u32);
        let root = SVGBackend::with_string(&mut text, size).into_drawing_area();
        root.fill(&WHITE).expect("drawing to memory cannot fail");
        for (area, panel) in root.split_evenly((rows, columns)).iter().zip(panels) {
            draw(area, panel);
        }
        root.present().expect("drawing to memory cannot fail");
    }
    text
}

fn draw(area: &DrawingArea<SVGBackend, plotters::coord::Shift>, panel: &Panel) {
    let all = || panel.curves.iter().flat_map(|curve| &curve.points);
    let bounds = |value: &dyn Fn(&(f64, f64)) -> f64| {
        all().map(value).fold((f64::MAX, f64::MIN), |(a, b), v| (a.min(v), b.max(v)))
    };
    let (x, y) = (bounds(&|point| point.0), bounds(&|point| point.1));
    let room = 0.08 * (y.1 - y.0).max(1e-12);
    let (head, area) = area.split_vertically(HEAD);
    name_curves(&head, panel);
    let mut context = ChartBuilder::on(&area)
        .margin(6)
        .margin_right(14)
        .x_label_area_size(34)
        .y_label_area_size(56)
        .build_cartesian_2d(x.0..x.1, y.0 - room..y.1 + room)
        .expect("drawing to memory cannot fail");
    context
        .configure_mesh()
        .x_labels(6)
        .y_labels(6)
        .x_label_formatter(&number)
        .y_label_formatter(&number)
        .light_line_style(TRANSPARENT)
        .x_desc(panel.x)
        .y_desc(panel.y)
        .draw()
        .expect("drawing to memory cannot fail");
    for (curve, color) in panel.curves.iter().zip(Theme::LIGHT.curves.iter().cycle()) {
        let line = LineSeries::new(thinned(&curve.points, x, y), color.stroke_width(2));
        context.draw_series(line).expect("drawing to memory cannot fail");
    }
}

/// Writes the title, and below it the names of the curves beside their colours.
fn name_curves(head: &DrawingArea<SVGBackend, plotters::coord::Shift>, panel: &Panel) {
    let drawn = "drawing to memory cannot fail";
    head.draw(&Text::new(panel.title.as_str(), (40, 6), ("sans-serif", 14))).expect(drawn);
    let mut left = 40;
    for (curve, color) in
        panel.curves.iter().zip(Theme::LIGHT.curves.iter().cycle()).filter(|_| panel.curves.len() > 1)
    {
        head.draw(&PathElement::new([(left, 30), (left + 14, 30)], color.stroke_width(2))).expect(drawn);
        head.draw(&Text::new(curve.name.as_str(), (left + 18, 24), ("sans-serif", 11))).expect(drawn);
        left += 26 + 11 * curve.name.chars().count() as i32 / 2;
    }
}

/// A short number for an axis.
fn number(value: &f64) -> String {
    let value = if value.abs() < 1e-9 { 0.0 } else { *value };
    let text = if value.abs() >= 100.0 { format!("{value:.0}") } else { format!("{value:.3}") };
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_string() } else { text }
}

/// Without points that lie on the same pixels as the one before.
fn thinned(points: &[(f64, f64)], x: (f64, f64), y: (f64, f64)) -> Vec<(f64, f64)> {
    let pixel = |point: &(f64, f64)| {
        let along = f64::from(WIDTH) * (point.0 - x.0) / (x.1 - x.0);
        let up = f64::from(HEIGHT) * (point.1 - y.0) / (y.1 - y.0).max(1e-12);
        (along.round() as i64, up.round() as i64)
    };
    let mut kept: Vec<(f64, f64)> = Vec::new();
    for point in points {
        if kept.last().is_none_or(|last| pixel(last) != pixel(point)) {
            kept.push(*point);
        }
    }
    kept
}
