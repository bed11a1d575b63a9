//! The whole picture: the legend, below it the panel of feedrates, below that the panel of contour errors or
//! of lost time, both over the same distance.

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use crate::plot::feed_panel::{self, FeedLayout, programmed_width};
use crate::plot::panel::{Borders, DrawError, FONT, FONT_SIZE_PT, Look, axis_number};
use crate::plot::{FeedChart, Frame, Grains, Theme, View, error_panel, lost_panel};
use crate::units::LengthUnit;

/// Part of the height below the legend that the feedrates take.
const FEED_HEIGHT_SHARE: f64 = 0.6;

/// Part of the height that the feedrates take if each curve has its own panel, or if the picture is lower
/// than [`LOW_PICTURE_PT`].
const LARGE_FEED_HEIGHT_SHARE: f64 = 0.7;
const LOW_PICTURE_PT: f64 = 320.0;

/// Least height of the lower panel including axis and numbers, points; at most half of the picture.
const MIN_LOWER_PANEL_PT: f64 = 100.0;

/// Draws a chart over the whole of a backend, with or without the names of its curves, and returns the frame
/// of its data.
///
/// # Errors
///
/// Returns an error if the backend fails.
pub fn draw<B: DrawingBackend>(
    chart: &FeedChart,
    view: View,
    theme: &Theme,
    scale: f64,
    has_legend: bool,
    backend: B,
) -> Result<Frame, DrawError<B>> {
    let (low, high) = (theme.unit.feedrate(view.feedrate.0), theme.unit.feedrate(view.feedrate.1));
    let least = match theme.unit {
        _ if chart.lost.is_some() => 6,
        LengthUnit::Millimetre => 5,
        // Contour errors such as 0.0005.
        LengthUnit::Inch => 7,
    };
    let label_characters = axis_number(theme, high, high - low).chars().count().max(least);
    let look = Look { theme: *theme, scale, label_characters };
    let root = backend.into_drawing_area();
    root.fill(&theme.background)?;
    let legend = if has_legend { draw_legend(chart, &look, &root)? } else { 0 };
    let (_, body) = root.split_vertically(legend);
    let is_low = f64::from(body.dim_in_pixel().1) < LOW_PICTURE_PT * scale;
    let part = if chart.stacked || is_low { LARGE_FEED_HEIGHT_SHARE } else { FEED_HEIGHT_SHARE };
    let height = f64::from(body.dim_in_pixel().1);
    let below = ((1.0 - part) * height).max((MIN_LOWER_PANEL_PT * scale).min(0.5 * height));
    let (upper, lower) = body.split_vertically((height - below).round() as u32);
    let (feed, grains, pitch) = draw_feedrates(chart, view, &look, &upper)?;
    let below = match &chart.lost {
        None => error_panel::draw(chart, view, &look, &lower)?,
        Some(lost) => lost_panel::draw(chart, lost, view, &look, &lower)?,
    };
    root.present()?;
    Ok(Frame { view, x: feed.x, y: feed.y, pitch, errors_y: below.y, grains })
}

/// Draws the feedrates in one panel or in one per curve; returns the borders of the first panel and the
/// distance to the next, pixels.
fn draw_feedrates<B: DrawingBackend>(
    chart: &FeedChart,
    view: View,
    look: &Look,
    area: &DrawingArea<B, Shift>,
) -> Result<(Borders, Grains, f64), DrawError<B>> {
    let layout = FeedLayout::of(chart, view, look, area)?;
    if !chart.stacked || chart.curves.len() < 2 {
        let borders = feed_panel::draw(chart, None, &layout, view, look, area)?;
        return Ok((borders, layout.grains, 0.0));
    }
    let panels = area.split_evenly((chart.curves.len(), 1));
    let mut borders = Vec::new();
    for (index, panel) in panels.iter().enumerate() {
        borders.push(feed_panel::draw(chart, Some(index), &layout, view, look, panel)?);
    }
    let pitch = borders[1].y.0 - borders[0].y.0;
    Ok((borders.swap_remove(0), layout.grains, pitch))
}

/// Draws the legend in rows at the top; returns its height in pixels.
fn draw_legend<B: DrawingBackend>(
    chart: &FeedChart,
    look: &Look,
    root: &DrawingArea<B, Shift>,
) -> Result<u32, DrawError<B>> {
    let theme = &look.theme;
    let points = |size: f64| look.points(size) as i32;
    let (swatch, gap, row) = (points(18.0), points(6.0), points(20.0));
    let style =
        (FONT, points(FONT_SIZE_PT)).into_font().color(&theme.text).pos(Pos::new(HPos::Left, VPos::Center));
    let curves = chart.curves.iter().zip(theme.curves.iter().cycle());
    let curves = curves.filter(|(curve, _)| !curve.hidden).map(|(curve, color)| (&*curve.label, color));
    let left = points(16.0);
    let right = root.dim_in_pixel().0 as i32 - points(12.0);
    let (mut x, mut y) = (left, points(14.0));
    let curves = curves.map(|(label, color)| (label, color, 2.5));
    for (label, color, thickness) in
        [("programmed", &theme.programmed, programmed_width(chart))].into_iter().chain(curves)
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::{CurveErrors, FeedrateCurve, LostTime, Programmed, TolerancePart};

    fn chart() -> FeedChart {
        let (end, feedrate) = (vec![20.0, 60.0, 100.0], vec![500.0, 20.0, 30.0]);
        let programmed = Programmed::new(end, feedrate, vec![true, false, false], vec![1, 2, 3]);
        let curve = |label: &str, tolerance: f64, dip: f64| FeedrateCurve {
            label: label.to_string(),
            tolerances: vec![TolerancePart { from: 0.0, to: f64::INFINITY, tolerance }],
            errors: CurveErrors {
                corner: vec![0.0, 1.5 * tolerance, 0.0].into(),
                arcs: vec![2],
                along_arcs: vec![0.004].into(),
            },
            distance: vec![0.0, 10.0, 20.0, 59.0, 60.0, 61.0, 100.0],
            feedrate: vec![0.0, 500.0, 20.0, 20.0, dip, 30.0, 0.0].into(),
            time: vec![0.0, 1.0, 2.0, 4.0, 4.1, 4.2, 6.0],
            ends: Vec::new(),
            hidden: false,
        };
        FeedChart {
            programmed,
            curves: vec![curve("10 µm", 0.01, 4.0), curve("20 µm", 0.02, 9.0)],
            ..FeedChart::default()
        }
    }

    fn svg(view: View) -> (String, Frame) {
        svg_of(&chart(), view)
    }

    fn svg_of(chart: &FeedChart, view: View) -> (String, Frame) {
        sized(chart, view, (800, 640))
    }

    fn sized(chart: &FeedChart, view: View, size: (u32, u32)) -> (String, Frame) {
        themed(chart, view, size, &Theme::LIGHT)
    }

    fn themed(chart: &FeedChart, view: View, size: (u32, u32), theme: &Theme) -> (String, Frame) {
        let mut text = String::new();
        let backend = SVGBackend::with_string(&mut text, size);
        let frame = draw(chart, view, theme, 1.0, true, backend).expect("an SVG in memory can be drawn");
        (text, frame)
    }

    /// The points of all polylines of a colour but the first, which is in the legend.
    fn points_of<'a>(text: &'a str, color: &'a str) -> impl Iterator<Item = (f64, f64)> {
        let is_of_color = move |line: &&str| line.starts_with("<polyline") && line.contains(color);
        text.lines().filter(is_of_color).skip(1).flat_map(|line| {
            let list = line.split("points=\"").nth(1).and_then(|rest| rest.split('"').next());
            list.expect("a polyline has points").split_whitespace().map(|pair| {
                let (x, y) = pair.split_once(',').expect("a point is x,y");
                (x.parse().expect("a number"), y.parse().expect("a number"))
            })
        })
    }

    #[test]
    fn shows_axes_with_units_a_legend_and_a_line_of_each_colour() {
        let (text, _) = svg(chart().full_view(false));
        let hex = |RGBColor(r, g, b): RGBColor| format!("stroke=\"#{r:02X}{g:02X}{b:02X}\"");
        for part in [
            "Distance along the path (mm)",
            "Feedrate (mm/min)",
            "Contour error (µm)",
            "programmed",
            "10 µm",
            "20 µm",
        ] {
            assert!(text.contains(part), "{part} is missing");
        }
        for color in [Theme::LIGHT.programmed, Theme::LIGHT.curves[0], Theme::LIGHT.curves[1]] {
            assert!(text.matches(&hex(color)).count() >= 2, "{color:?} is missing on the legend or the plot");
        }
    }

    #[test]
    fn in_inches_the_axes_have_round_numbers_of_inches_at_their_places() {
        let theme = Theme { unit: LengthUnit::Inch, ..Theme::LIGHT };
        let (text, frame) = themed(&chart(), chart().full_view(false), (800, 640), &theme);
        for title in ["Distance along the path (in)", "Feedrate (in/min)", "Contour error (in)"] {
            assert_eq!(text.matches(title).count(), 1, "{title}");
        }
        // 100 mm are 3.94 in, 30 mm/s are 70.9 in/min and 0.03 mm are 0.00118 in.
        let lines: Vec<&str> = text.lines().map(str::trim).collect();
        let tag_of = |number: &str| {
            lines
                .iter()
                .position(|line| *line == number)
                .map(|at| lines[at - 1])
                .unwrap_or_else(|| panic!("{number}"))
        };
        let place = |tag: &str, name: &str| -> f64 {
            let rest = tag.split(&format!(" {name}=\"")).nth(1).expect("a text has a place");
            rest.split('"').next().expect("quoted").parse().expect("a number")
        };
        assert!((place(tag_of("3"), "x") - frame.x_of(3.0 * 25.4)).abs() <= 2.0);
        // 60 in/min.
        assert!((place(tag_of("60"), "y") - frame.y_of(25.4)).abs() <= 2.0);
        tag_of("0.001");
    }

    #[test]
    fn the_needle_of_a_corner_is_as_high_as_its_error_against_the_dashed_tolerance() {
        let mut chart = chart();
        chart.curves.truncate(1);
        chart.curves[0].errors.corner = vec![0.0, 0.5 * chart.curves[0].tolerances[0].tolerance, 0.0].into();
        let (text, frame) = svg_of(&chart, chart.full_view(false));
        let (top, bottom) = frame.errors_y;
        let points: Vec<_> = points_of(&text, "#0072B2").filter(|&(_, y)| top < y).collect();
        let highest = |points: &mut dyn Iterator<Item = &(f64, f64)>| {
            points.map(|&(_, y)| y).fold(f64::INFINITY, f64::min)
        };
        let line = highest(&mut points.iter());
        let corner = frame.x_of(60.0);
        let needle = points.iter().filter(|(x, y)| (x - corner).abs() <= 2.0 && line + 2.0 < *y);
        let error = bottom - highest(&mut needle.into_iter());
        assert!(50.0 < bottom - line);
        assert!((error / (bottom - line) - 0.5).abs() < 0.02, "{error} of {}", bottom - line);
    }

    #[test]
    fn beside_a_recording_the_lower_panel_is_the_time_lost() {
        let mut chart = chart();
        let lost =
            LostTime { distance: vec![0.0, 50.0, 50.0, 100.0], seconds: vec![0.0, -1.0, 3.0, 2.0].into() };
        chart.lost = Some(lost);
        assert_eq!(chart.reading(25.0, 1.0).lost, Some(-0.5));
        assert_eq!(chart.reading(50.0, 1.0).lost, Some(-1.0));
        assert_eq!(chart.reading(75.0, 1.0).lost, Some(2.5));
        let (text, frame) = svg_of(&chart, chart.full_view(false));
        assert!(text.contains("Time lost (s)") && !text.contains("Contour error"));
        let (top, bottom) = frame.errors_y;
        let rows: Vec<_> = points_of(&text, "#0072B2").filter(|&(_, y)| top <= y).collect();
        let of = |pick: fn(f64, f64) -> f64| rows.iter().map(|&(_, y)| y).reduce(pick).expect("it is drawn");
        let (highest, lowest) = (of(f64::min), of(f64::max));
        assert!(highest < lowest && lowest <= bottom, "{highest} to {lowest} of {bottom}");
        // The wait of 4 s is the whole height between the lowest and the highest point.
        let wait = rows.iter().filter(|(x, _)| (x - frame.x_of(50.0)).abs() <= 1.0);
        assert!(wait.clone().any(|&(_, y)| y == highest) && wait.clone().any(|&(_, y)| y == lowest));
    }

    #[test]
    fn stacked_curves_have_panels_one_below_the_other() {
        let stacked = FeedChart { stacked: true, ..chart() };
        let (text, frame) = svg_of(&stacked, stacked.full_view(false));
        // The lowest panel is too low for more of its title than the unit.
        assert!(text.lines().any(|line| line == "µm") && text.matches("mm/min").count() == 2);
        assert!(frame.y.1 - frame.y.0 < frame.pitch);
        for (index, color) in ["#0072B2", "#D55E00"].into_iter().enumerate() {
            let rows = points_of(&text, color).map(|(_, y)| y).filter(|&y| y < frame.errors_y.0 - 5.0);
            let (top, bottom) =
                (frame.y.0 + index as f64 * frame.pitch, frame.y.1 + index as f64 * frame.pitch);
            let rows: Vec<f64> = rows.collect();
            assert!(
                2 <= rows.len() && rows.iter().all(|y| (top - 2.0..=bottom + 2.0).contains(y)),
                "{color} {rows:?}"
            );
        }
    }

    #[test]
    fn contour_errors_can_be_read_in_a_low_picture_too() {
        let chart = chart();
        let height = |(top, bottom): (f64, f64)| bottom - top;
        for pixels in [216, 240, 300, 640] {
            let (_, frame) = sized(&chart, chart.full_view(false), (560, pixels));
            assert!(40.0 <= height(frame.errors_y), "{:?} of {pixels}", frame.errors_y);
            assert!(
                height(frame.errors_y) <= height(frame.y),
                "{:?} and {:?} of {pixels}",
                frame.y,
                frame.errors_y
            );
        }
    }

    #[test]
    fn nothing_of_a_curve_leaves_the_frame() {
        let view = View { distance: (55.0, 65.0), feedrate: (5.0, 25.0) };
        let (text, frame) = svg(view);
        let inside = |(low, high): (f64, f64), pixel: f64| low - 1.0 <= pixel && pixel <= high + 1.0;
        let mut points = [0, 0];
        for (x, y) in points_of(&text, "#0072B2") {
            let panel = [frame.y, frame.errors_y].iter().position(|&rows| inside(rows, y));
            assert!(inside(frame.x, x), "{x}, {y}");
            points[panel.expect("a point lies in a panel")] += 1;
        }
        assert!(points.iter().all(|&count| count >= 2), "{points:?}");
    }
}
