//! The upper panel: shaded rapids, programmed steps and the feedrate of each curve.

use plotters::coord::Shift;
use plotters::prelude::*;

use crate::plot::decimate::{clipped, decimated};
use crate::plot::draw::Failure;
use crate::plot::panel::{Axes, Borders, Look, borders};
use crate::plot::{Abscissa, FeedChart, View};
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
