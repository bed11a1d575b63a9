//! The picture itself: legend, axes, shaded rapids, programmed steps and curves.
//!
//! plotters draws on whole pixels of the device, so every size here is in points of the page
//! times `scale`, device pixels a point.

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use crate::plot::decimate::{clipped, decimated};
use crate::plot::{FeedChart, Frame, View};
use crate::units::mm_per_min;

/// Colours of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Theme {
    /// Behind everything.
    pub background: RGBColor,
    /// Text.
    pub text: RGBColor,
    /// Grid lines.
    pub grid: RGBColor,
    /// Stretches of rapid motion.
    pub rapid: RGBColor,
    /// Axes and their ticks.
    pub axis: RGBColor,
    /// The programmed feedrate: broad and pale, so that it shows on both sides of a curve on it.
    pub programmed: RGBColor,
    /// Curves in their order.
    pub curves: [RGBColor; PALETTE],
}

/// How many curves have a colour of their own.
pub const PALETTE: usize = 6;

impl Theme {
    /// Dark on white. The curves' colours are those of Okabe and Ito, which people with any
    /// kind of colour vision can tell apart.
    pub const LIGHT: Theme = Theme {
        background: RGBColor(255, 255, 255),
        text: RGBColor(64, 72, 82),
        grid: RGBColor(229, 232, 236),
        rapid: RGBColor(243, 244, 246),
        axis: RGBColor(120, 128, 138),
        programmed: RGBColor(196, 202, 210),
        curves: [
            RGBColor(0, 114, 178),
            RGBColor(213, 94, 0),
            RGBColor(0, 158, 115),
            RGBColor(204, 121, 167),
            RGBColor(230, 159, 0),
            RGBColor(86, 180, 233),
        ],
    };

    /// Light on dark, the same colours in an order that begins with the light ones.
    pub const DARK: Theme = Theme {
        background: RGBColor(22, 26, 31),
        text: RGBColor(190, 198, 207),
        grid: RGBColor(45, 51, 59),
        rapid: RGBColor(31, 36, 43),
        axis: RGBColor(135, 145, 156),
        programmed: RGBColor(84, 94, 105),
        curves: [
            RGBColor(86, 180, 233),
            RGBColor(230, 159, 0),
            RGBColor(0, 158, 115),
            RGBColor(204, 121, 167),
            RGBColor(240, 228, 66),
            RGBColor(213, 94, 0),
        ],
    };
}

type Drawn<B> = Result<Frame, DrawingAreaErrorKind<<B as DrawingBackend>::ErrorType>>;

const FONT: &str = "system-ui, sans-serif";
/// Width of the programmed steps.
const PROGRAMMED_WIDTH: f64 = 5.0;
const FONT_SIZE: f64 = 12.0;
/// Width of a character against the font's size, on the wide side.
const CHARACTER: f64 = 0.62;

/// Draws a chart over the whole of a backend and returns where the data lies on it.
pub fn draw<B: DrawingBackend>(
    chart: &FeedChart,
    view: View,
    theme: &Theme,
    scale: f64,
    backend: B,
) -> Drawn<B> {
    let points = |size: f64| (size * scale).round() as u32;
    let font = (FONT, points(FONT_SIZE)).into_font().color(&theme.text);
    let root = backend.into_drawing_area();
    root.fill(&theme.background)?;
    let (width, height) = root.dim_in_pixel();
    let legend = draw_legend(chart, theme, scale, &root)?;

    let feed = (mm_per_min(view.feedrate.0), mm_per_min(view.feedrate.1));
    let widest = grouped(feed.1, feed.1 - feed.0).chars().count().max(5);
    let label_width = CHARACTER * FONT_SIZE * widest as f64 + 32.0;
    let labels = |pixels: u32, spacing: f64| ((f64::from(pixels) / (spacing * scale)) as usize).clamp(2, 12);

    let mut context = ChartBuilder::on(&root)
        .margin_top(legend + points(6.0))
        .margin_right(points(36.0))
        .margin_left(points(4.0))
        .margin_bottom(points(4.0))
        .x_label_area_size(points(42.0))
        .y_label_area_size(points(label_width))
        .build_cartesian_2d(view.distance.0..view.distance.1, feed.0..feed.1)?;
    let (x, y) = context.plotting_area().get_pixel_range();
    let columns = (x.end - x.start).max(1) as usize;

    for (from, to) in rapid_stretches(chart, view, columns) {
        context.draw_series([Rectangle::new([(from, feed.0), (to, feed.1)], theme.rapid.filled())])?;
    }
    context
        .configure_mesh()
        .x_labels(labels(width, 110.0))
        .y_labels(labels(height, 44.0))
        .x_label_formatter(&|value| grouped(*value, view.distance.1 - view.distance.0))
        .y_label_formatter(&|value| grouped(*value, feed.1 - feed.0))
        .x_desc("Distance along the path (mm)")
        .y_desc("Feedrate (mm/min)")
        .label_style(font.clone())
        .axis_desc_style(font)
        .axis_style(theme.axis.stroke_width(points(1.0)))
        .bold_line_style(theme.grid.stroke_width(points(1.0)))
        .light_line_style(TRANSPARENT)
        .set_all_tick_mark_size(points(4.0))
        .draw()?;

    let mut line = |points: &[(f64, f64)], style: ShapeStyle| {
        let parts = clipped(points, view).into_iter();
        let in_minutes =
            |part: Vec<(f64, f64)>| part.into_iter().map(|(d, f)| (d, mm_per_min(f))).collect::<Vec<_>>();
        context.draw_series(parts.map(|part| PathElement::new(in_minutes(part), style))).map(|_| ())
    };
    line(&programmed_steps(chart, view, columns), theme.programmed.stroke_width(points(PROGRAMMED_WIDTH)))?;
    for (curve, color) in chart.curves.iter().zip(theme.curves.iter().cycle()) {
        let kept = decimated(&curve.distance, &curve.feedrate, view.distance, columns);
        line(&kept, color.stroke_width(points(1.75)))?;
    }
    root.present()?;
    let ends = |range: std::ops::Range<i32>| (f64::from(range.start), f64::from(range.end));
    Ok(Frame { view, x: ends(x), y: ends(y) })
}

/// Draws the names of what is shown in rows at the top; returns their height in pixels.
fn draw_legend<B: DrawingBackend>(
    chart: &FeedChart,
    theme: &Theme,
    scale: f64,
    root: &DrawingArea<B, Shift>,
) -> Result<u32, DrawingAreaErrorKind<B::ErrorType>> {
    let points = |size: f64| (size * scale).round() as i32;
    let (swatch, gap, row) = (points(18.0), points(6.0), points(20.0));
    let style =
        (FONT, points(FONT_SIZE)).into_font().color(&theme.text).pos(Pos::new(HPos::Left, VPos::Center));
    let curves =
        chart.curves.iter().zip(theme.curves.iter().cycle()).map(|(curve, color)| (&*curve.label, color));
    let left = points(16.0);
    let right = root.dim_in_pixel().0 as i32 - points(12.0);
    let (mut x, mut y) = (left, points(14.0));
    let curves = curves.map(|(label, color)| (label, color, 2.5));
    for (label, color, thickness) in
        [("programmed", &theme.programmed, PROGRAMMED_WIDTH)].into_iter().chain(curves)
    {
        let width = swatch + gap + root.estimate_text_size(label, &style)?.0 as i32;
        if left < x && right < x + width {
            (x, y) = (left, y + row);
        }
        let line = PathElement::new([(x, y), (x + swatch, y)], color.stroke_width(points(thickness) as u32));
        root.draw(&line)?;
        root.draw(&Text::new(label, (x + swatch + gap, y), style.clone()))?;
        x += width + points(18.0);
    }
    Ok((y + row / 2) as u32)
}

/// Where rapid moves lie within the view, from and to (mm); neighbours closer than a pixel are one.
fn rapid_stretches(chart: &FeedChart, view: View, columns: usize) -> Vec<(f64, f64)> {
    let (low, high) = view.distance;
    let pixel = (high - low) / columns as f64;
    let mut stretches: Vec<(f64, f64)> = Vec::new();
    for index in chart.programmed.within(view.distance).filter(|&index| chart.programmed.rapid[index]) {
        let (from, to) = (chart.programmed.start(index).max(low), chart.programmed.end[index].min(high));
        match stretches.last_mut() {
            Some(last) if from < last.1 + pixel => last.1 = to,
            _ => stretches.push((from, to)),
        }
    }
    stretches
}

/// The programmed feedrate in sight as a polyline with a point at either side of each change, decimated.
fn programmed_steps(chart: &FeedChart, view: View, columns: usize) -> Vec<(f64, f64)> {
    let steps = &chart.programmed;
    let seen = steps.within(view.distance);
    let (mut distance, mut feedrate) = (Vec::new(), Vec::new());
    for index in seen.clone() {
        let here = steps.feedrate[index];
        for (at, is_change) in [
            (steps.start(index), index == seen.start || steps.feedrate[index - 1] != here),
            (steps.end[index], index + 1 == seen.end || steps.feedrate[index + 1] != here),
        ] {
            if is_change {
                distance.push(at);
                feedrate.push(here);
            }
        }
    }
    decimated(&distance, &feedrate, view.distance, columns)
}

/// A number with as many decimals as an axis over `span` needs, thousands set apart.
fn grouped(value: f64, span: f64) -> String {
    let decimals = (1.5 - span.log10()).ceil().clamp(0.0, 9.0) as usize;
    let text = format!("{:.decimals$}", value + 0.0);
    let (whole, fraction) = text.split_once('.').unwrap_or((&text, ""));
    let (sign, digits) = whole.strip_prefix('-').map_or(("", whole), |digits| ("−", digits));
    let mut out = sign.to_string();
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && digits.len() > 4 && (digits.len() - place) % 3 == 0 {
            out.push('\u{202f}');
        }
        out.push(digit);
    }
    let fraction = fraction.trim_end_matches('0');
    if fraction.is_empty() { out } else { format!("{out}.{fraction}") }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::{Curve, Programmed};

    fn chart() -> FeedChart {
        let programmed = Programmed {
            end: vec![20.0, 60.0, 100.0],
            feedrate: vec![500.0, 20.0, 30.0],
            rapid: vec![true, false, false],
            line: vec![1, 2, 3],
        };
        let curve = |label: &str, dip: f64| Curve {
            label: label.to_string(),
            distance: vec![0.0, 10.0, 20.0, 59.0, 60.0, 61.0, 100.0],
            feedrate: vec![0.0, 500.0, 20.0, 20.0, dip, 30.0, 0.0],
            time: vec![0.0, 1.0, 2.0, 4.0, 4.1, 4.2, 6.0],
        };
        FeedChart { programmed, curves: vec![curve("10 µm", 4.0), curve("20 µm", 9.0)] }
    }

    fn svg(view: View) -> (String, Frame) {
        let mut text = String::new();
        let backend = SVGBackend::with_string(&mut text, (800, 400));
        let frame = draw(&chart(), view, &Theme::LIGHT, 1.0, backend).expect("an SVG in memory can be drawn");
        (text, frame)
    }

    #[test]
    fn shows_axes_with_units_a_legend_and_a_line_of_each_colour() {
        let (text, _) = svg(chart().full_view(false));
        let hex = |RGBColor(r, g, b): RGBColor| format!("stroke=\"#{r:02X}{g:02X}{b:02X}\"");
        for part in ["Distance along the path (mm)", "Feedrate (mm/min)", "programmed", "10 µm", "20 µm"] {
            assert!(text.contains(part), "{part} is missing");
        }
        for color in [Theme::LIGHT.programmed, Theme::LIGHT.curves[0], Theme::LIGHT.curves[1]] {
            assert!(text.matches(&hex(color)).count() >= 2, "{color:?} is missing on the legend or the plot");
        }
    }

    #[test]
    fn nothing_of_a_curve_leaves_the_frame() {
        let view = View { distance: (55.0, 65.0), feedrate: (5.0, 25.0) };
        let (text, frame) = svg(view);
        let lines = text.lines().filter(|line| line.starts_with("<polyline") && line.contains("#0072B2"));
        let mut points = 0;
        for line in lines.skip(1) {
            let list = line
                .split("points=\"")
                .nth(1)
                .and_then(|rest| rest.split('"').next())
                .expect("a polyline has points");
            for pair in list.split_whitespace() {
                let (x, y) = pair.split_once(',').expect("a point is x,y");
                let (x, y): (f64, f64) = (x.parse().expect("a number"), y.parse().expect("a number"));
                assert!(
                    frame.x.0 - 1.0 <= x
                        && x <= frame.x.1 + 1.0
                        && frame.y.0 - 1.0 <= y
                        && y <= frame.y.1 + 1.0,
                    "{pair}"
                );
                points += 1;
            }
        }
        assert!(points >= 4);
    }

    #[test]
    fn numbers_on_axes_are_short_and_grouped() {
        assert_eq!(grouped(12000.0, 12000.0), "12\u{202f}000");
        assert_eq!(grouped(1500.0, 2000.0), "1500");
        assert_eq!(grouped(0.5, 2.0), "0.5");
        assert_eq!(grouped(0.0, 2.0), "0");
        assert_eq!(grouped(123.456, 0.01), "123.456");
    }
}
