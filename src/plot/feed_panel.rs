//! The upper panel: shaded rapids, programmed steps and the feedrate of each curve.

use std::ops::Range;

use plotters::coord::Shift;
use plotters::prelude::*;

use crate::plot::decimate::{FEW, by_column, clipped, decimated};
use crate::plot::panel::{Axes, Borders, Failure, Look, borders};
use crate::plot::{Abscissa, Extremes, FeedChart, View};
use crate::units::mm_per_min;

/// Width of the programmed steps, points.
const PROGRAMMED_WIDTH: f64 = 5.0;

/// The same beside a recording, where two motions are compared with each other, points.
const PROGRAMMED_WIDTH_BESIDE: f64 = 1.5;

/// Width of the programmed steps of a chart, points.
pub(crate) fn programmed_width(chart: &FeedChart) -> f64 {
    if chart.lost.is_some() { PROGRAMMED_WIDTH_BESIDE } else { PROGRAMMED_WIDTH }
}

/// Draws the feedrates of a chart on an area, or one of them, by its index.
pub(crate) fn draw<B: DrawingBackend>(
    chart: &FeedChart,
    only: Option<usize>,
    view: View,
    look: &Look,
    area: &DrawingArea<B, Shift>,
) -> Result<Borders, Failure<B>> {
    let theme = &look.theme;
    let feed = (mm_per_min(view.feedrate.0), mm_per_min(view.feedrate.1));
    let value_title = if only.is_some() { "mm/min" } else { "Feedrate (mm/min)" };
    let axes = Axes { distance: view.distance, distance_title: None, value: feed, value_title };
    let mut context = look.panel(area, &axes)?;
    let borders = borders(&context);
    let columns = (borders.x.1 - borders.x.0).max(1.0) as usize;

    for (from, to) in rapid_stretches(chart, view, columns) {
        context.draw_series([Rectangle::new([(from, feed.0), (to, feed.1)], theme.rapid.filled())])?;
    }
    look.mesh(&mut context, &axes)?;
    let mut line = |points: &[(f64, f64)], style: ShapeStyle| {
        let parts = clipped(points, view).into_iter();
        let in_minutes =
            |part: Vec<(f64, f64)>| part.into_iter().map(|(d, f)| (d, mm_per_min(f))).collect::<Vec<_>>();
        context.draw_series(parts.map(|part| PathElement::new(in_minutes(part), style))).map(|_| ())
    };
    let programmed = programmed_steps(chart, view, columns);
    line(&programmed, theme.programmed.stroke_width(look.points(programmed_width(chart))))?;
    let all = chart.curves.iter().zip(theme.curves.iter().cycle()).enumerate();
    let mut curves: Vec<_> =
        all.filter(|(index, _)| only.is_none_or(|own| own == *index)).map(|(_, shown)| shown).collect();
    if chart.lost.is_some() {
        // What was recorded lies over what was simulated.
        curves.reverse();
    }
    for (curve, color) in curves {
        let kept = decimated(&curve.distance, &curve.feedrate, view.distance, columns);
        line(&kept, color.stroke_width(look.points(1.75)))?;
    }
    Ok(borders)
}

/// Where rapid moves lie within the view, from and to (mm); neighbours closer than a pixel are one.
pub(crate) fn rapid_stretches(chart: &FeedChart, view: View, columns: usize) -> Vec<(f64, f64)> {
    let (low, high) = view.distance;
    let pixel = (high - low) / columns as f64;
    let mut stretches: Vec<(f64, f64)> = Vec::new();
    if chart.abscissa == Abscissa::Time {
        // Each curve has its rapids at other times.
        return stretches;
    }
    let steps = &chart.programmed;
    let begin = |rapid: &Range<usize>| steps.start(rapid.start);
    let end = |rapid: &Range<usize>| steps.end[rapid.end - 1];
    let first = steps.rapids.partition_point(|rapid| end(rapid) <= low);
    let mut left = &steps.rapids[first..];
    while let Some(rapid) = left.first().filter(|rapid| begin(rapid) < high) {
        let (from, mut to) = (begin(rapid), end(rapid));
        left = &left[1..];
        // Those that begin within a pixel of its end, then those that do of the end of these.
        while let near @ 1.. = left.partition_point(|rapid| begin(rapid) < high.min(to + pixel)) {
            to = end(&left[near - 1]);
            left = &left[near..];
        }
        stretches.push((from.max(low), to.min(high)));
    }
    stretches
}

/// The programmed feedrate in sight as a polyline with a point at either side of each change, or four points for all
/// changes in one of the pixel columns.
fn programmed_steps(chart: &FeedChart, view: View, columns: usize) -> Vec<(f64, f64)> {
    let steps = &chart.programmed;
    let mut points: Vec<(f64, f64)> = Vec::new();
    let mut add = |begin: f64, end: f64, feedrate: f64| match points.last_mut() {
        Some(last) if *last == (begin, feedrate) => last.0 = end,
        _ => points.extend([(begin, feedrate), (end, feedrate)]),
    };
    for seen in by_column(&steps.end, steps.within(view.distance), view.distance, columns) {
        match steps.feedrate.extremes(seen.clone()) {
            Some(Extremes { lowest, highest }) if FEW < seen.len() => {
                let (first, last) = (seen.start, seen.end - 1);
                add(steps.start(first), steps.end[first], steps.feedrate[first]);
                add(steps.end[first], steps.end[first], lowest);
                add(steps.end[first], steps.start(last), highest);
                add(steps.start(last), steps.end[last], steps.feedrate[last]);
            }
            _ => seen.for_each(|index| add(steps.start(index), steps.end[index], steps.feedrate[index])),
        }
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::Programmed;

    /// Segments of 1 to 3 mm, of which some are rapid moves, at ever other feedrates.
    fn chart() -> FeedChart {
        let (mut end, mut ends) = (0, Vec::new());
        for k in 0..4000_u32 {
            end += 1 + k * k % 3;
            ends.push(f64::from(end));
        }
        let feedrate = (0..4000_u32).map(|k| f64::from(10 + k / 3 * 7919 % 101)).collect();
        let rapid = (0..4000_u32).map(|k| k / 7 * 6007 % 11 < 3 || k % 29 == 0).collect();
        let programmed = Programmed::new(ends, feedrate, rapid, (0..4000).collect());
        FeedChart { programmed, ..FeedChart::default() }
    }

    const VIEWS: [(f64, f64); 6] =
        [(0.0, 8000.0), (0.5, 20.5), (300.0, 301.0), (1000.0, 5000.0), (-5.0, 10.0), (7990.0, 9000.0)];

    #[test]
    fn rapids_nearer_than_a_pixel_are_one() {
        let chart = chart();
        let steps = &chart.programmed;
        for (low, high) in VIEWS {
            for columns in [3, 100, 5000] {
                let pixel = (high - low) / columns as f64;
                let mut one_by_one: Vec<(f64, f64)> = Vec::new();
                for index in steps.within((low, high)).filter(|&index| steps.rapid[index]) {
                    let (from, to) = (steps.start(index).max(low), steps.end[index].min(high));
                    match one_by_one.last_mut() {
                        Some(last) if from < last.1 + pixel => last.1 = to,
                        _ => one_by_one.push((from, to)),
                    }
                }
                let view = View { distance: (low, high), feedrate: (0.0, 1.0) };
                assert_eq!(
                    rapid_stretches(&chart, view, columns),
                    one_by_one,
                    "{low} to {high}, {columns} columns"
                );
            }
        }
    }

    #[test]
    fn each_column_shows_the_highest_and_the_lowest_step() {
        let chart = chart();
        let steps = &chart.programmed;
        for (low, high) in VIEWS {
            for columns in [10, 333] {
                let view = View { distance: (low, high), feedrate: (0.0, 1.0) };
                let points = programmed_steps(&chart, view, columns);
                assert!(points.is_sorted_by(|a, b| a.0 <= b.0) && points.len() <= 8 * (columns + 2));
                let width = (high - low) / columns as f64;
                for index in steps.within((low, high)) {
                    let (at, feedrate) = (steps.end[index], steps.feedrate[index]);
                    let near = points.iter().filter(|(x, _)| (x - at).abs() <= 1.001 * width.max(3.0));
                    let (least, most) = near.fold((f64::INFINITY, 0.0_f64), |(least, most), (_, y)| {
                        (least.min(*y), most.max(*y))
                    });
                    assert!(
                        least <= feedrate && feedrate <= most,
                        "step {index}: {feedrate} in {least} to {most}"
                    );
                }
            }
        }
        let view = View { distance: (0.5, 6.0), feedrate: (0.0, 1.0) };
        // The first three of 1, 2 and 2 mm are alike.
        assert_eq!(
            programmed_steps(&chart, view, 1000),
            [(0.0, 10.0), (5.0, 10.0), (5.0, 51.0), (6.0, 51.0)]
        );
    }
}
