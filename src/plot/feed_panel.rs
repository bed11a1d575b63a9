//! The upper panel: shaded rapids, programmed steps and the feedrate of each curve, exactly or by means with a band.

use std::ops::Range;

use plotters::coord::Shift;
use plotters::prelude::*;

use crate::plot::decimate::{MAX_ROWS_DRAWN, by_column, clipped, decimated};
use crate::plot::panel::{Axes, Borders, DrawError, Look, borders};
use crate::plot::strips::{QuantityLine, strips};
use crate::plot::{Abscissa, Extremes, FeedChart, FeedrateCurve, Grains, SectionGrain, Strip, View};
use crate::simulation::sampled::rows_around_by;

/// Width of the programmed steps, points.
const PROGRAMMED_WIDTH_PT: f64 = 5.0;

/// Width of the programmed steps if the chart compares a recorded with a simulated motion, points.
const PROGRAMMED_WIDTH_BESIDE_RECORDING_PT: f64 = 1.5;

/// Returns the width of the programmed steps of a chart, points.
pub(crate) fn programmed_width(chart: &FeedChart) -> f64 {
    if chart.lost.is_some() { PROGRAMMED_WIDTH_BESIDE_RECORDING_PT } else { PROGRAMMED_WIDTH_PT }
}

/// Opacity of the bands of all other curves together, as a ratio to the opacity of the curve on top.
const OTHER_BANDS_OPACITY: f64 = 0.8;
/// Factor on the opacity of the area below a band.
const BELOW_BAND_OPACITY: f64 = 0.4;

/// The layout common to all feedrate panels of a chart.
pub(crate) struct FeedLayout {
    /// Pixel columns of a panel.
    columns: usize,
    /// Points of each curve for exact sections.
    exact: Vec<Vec<(f64, f64)>>,
    /// Resolution of each section.
    pub grains: Grains,
}

impl FeedLayout {
    /// Lays out panels as wide as an area.
    ///
    /// # Errors
    ///
    /// Returns an error if the backend fails.
    pub fn of<B: DrawingBackend>(
        chart: &FeedChart,
        view: View,
        look: &Look,
        area: &DrawingArea<B, Shift>,
    ) -> Result<FeedLayout, DrawError<B>> {
        let borders = borders(&look.panel(area, &axes(chart, view, look, false))?);
        let columns = (borders.x.1 - borders.x.0).max(1.0) as usize;
        let exact: Vec<_> = chart
            .curves
            .iter()
            .map(|curve| decimated(&curve.distance, &curve.feedrate, view.distance, columns))
            .collect();
        let grains = Grains::of(chart, &exact, view, columns as f64 / look.scale);
        Ok(FeedLayout { columns, exact, grains })
    }
}

fn axes(chart: &FeedChart, view: View, look: &Look, is_one_of_many: bool) -> Axes {
    let unit = look.theme.unit;
    let symbol = unit.feed_symbol();
    Axes {
        distance: view.distance,
        distance_title: None,
        distance_unit_size: chart.abscissa.unit_size(unit),
        value: (unit.feedrate(view.feedrate.0), unit.feedrate(view.feedrate.1)),
        value_title: if is_one_of_many { symbol.to_string() } else { format!("Feedrate ({symbol})") },
    }
}

/// Draws the feedrates of a chart on an area, or only those of the curve with the index `only`.
pub(crate) fn draw<B: DrawingBackend>(
    chart: &FeedChart,
    only: Option<usize>,
    layout: &FeedLayout,
    view: View,
    look: &Look,
    area: &DrawingArea<B, Shift>,
) -> Result<Borders, DrawError<B>> {
    let theme = &look.theme;
    let FeedLayout { columns, grains, exact } = layout;
    let columns = *columns;
    let axes = axes(chart, view, look, only.is_some());
    let unit = theme.unit;
    let feed = axes.value;
    let mut context = look.panel(area, &axes)?;
    let borders = borders(&context);

    for (from, to) in rapid_ranges(chart, view, columns) {
        context.draw_series([Rectangle::new([(from, feed.0), (to, feed.1)], theme.rapid.filled())])?;
    }
    look.mesh(&mut context, &axes)?;
    // The quoted or recorded curve is on top.
    let on_top = |index: &usize| *index == chart.on_top;
    let below = (0..chart.curves.len()).rev().filter(|index| !on_top(index)).chain([chart.on_top]);
    let is_shown = |index: &usize| chart.curves.get(*index).is_some_and(|curve| !curve.hidden);
    let shown: Vec<usize> =
        below.filter(|index| is_shown(index) && only.is_none_or(|own| own == *index)).collect();
    let color = |index: usize| theme.curves[index % theme.curves.len()];
    for &index in &shown {
        for strips in dense(chart, &chart.curves[index], grains, view) {
            let inside = |feedrate: f64| unit.feedrate(feedrate.clamp(view.feedrate.0, view.feedrate.1));
            let mut ground = |low: fn(&Strip) -> f64, high: fn(&Strip) -> f64, part: f64| {
                let lower = outline(&strips, low).into_iter();
                let upper = outline(&strips, high).into_iter().rev();
                let at = |at: f64| at.clamp(view.distance.0, view.distance.1);
                let points = lower.chain(upper).map(|(d, f)| (at(d), inside(f))).collect::<Vec<_>>();
                context.draw_series([Polygon::new(points, color(index).mix(part).filled())]).map(|_| ())
            };
            let is_on_top = shown.last() == Some(&index);
            let share = if is_on_top { 1.0 } else { OTHER_BANDS_OPACITY / (shown.len() - 1) as f64 };
            let part = theme.band * share;
            ground(|strip| strip.band.lowest, |strip| strip.band.highest, part)?;
            ground(|strip| strip.all.lowest, |strip| strip.band.lowest, BELOW_BAND_OPACITY * part)?;
        }
    }
    let mut line = |points: &[(f64, f64)], style: ShapeStyle| {
        let parts = clipped(points, view).into_iter();
        let shown =
            |part: Vec<(f64, f64)>| part.into_iter().map(|(d, f)| (d, unit.feedrate(f))).collect::<Vec<_>>();
        context.draw_series(parts.map(|part| PathElement::new(shown(part), style))).map(|_| ())
    };
    if !chart.programmed.hidden {
        let steps = programmed_steps(chart, view, columns);
        let points = mixed(&steps, grains, QuantityLine::of_programmed(chart, &chart.programmed));
        line(&points, theme.programmed.stroke_width(look.points(programmed_width(chart))))?;
    }
    for &index in &shown {
        let curve = &chart.curves[index];
        let points = mixed(&exact[index], grains, QuantityLine::of_curve(chart, curve));
        line(&points, color(index).stroke_width(look.points(1.75)))?;
    }
    Ok(borders)
}

/// Returns the strips of a curve in the sections with means, run by run.
fn dense(chart: &FeedChart, curve: &FeedrateCurve, grains: &Grains, view: View) -> Vec<Vec<Strip>> {
    let runs = grains.runs().filter_map(|(grain, ends)| match grain {
        SectionGrain::Means(group) if ends.0 < view.distance.1 => {
            Some(strips(chart, curve, &grains.borders(group, ends)))
        }
        _ => None,
    });
    runs.filter(|strips| !strips.is_empty()).collect()
}

/// Returns a value of each strip as a polyline, with a point in the middle of each strip.
fn outline(strips: &[Strip], says: fn(&Strip) -> f64) -> Vec<(f64, f64)> {
    let (first, last) = (&strips[0], &strips[strips.len() - 1]);
    let middles = strips.iter().map(|strip| (0.5 * (strip.ends.0 + strip.ends.1), says(strip)));
    [(first.ends.0, says(first))].into_iter().chain(middles).chain([(last.ends.1, says(last))]).collect()
}

/// Returns the mean feedrates (mm/s) of `count` strips of a curve over a view, as a polyline within it.
pub(crate) fn clamped_means(
    chart: &FeedChart,
    curve: &FeedrateCurve,
    view: View,
    count: usize,
) -> Vec<(f64, f64)> {
    let ((low, high), (bottom, top)) = (view.distance, view.feedrate);
    let border = |k: f64| low + (high - low) * k / count as f64;
    let means = QuantityLine::of_curve(chart, curve)
        .means(&(0..=count).map(|k| border(k as f64)).collect::<Vec<_>>());
    let means = means.into_iter().enumerate();
    means.filter_map(|(k, mean)| Some((border(k as f64 + 0.5), mean?.clamp(bottom, top)))).collect()
}

/// Returns a polyline of the points of exact sections, and of means elsewhere.
fn mixed(exact: &[(f64, f64)], grains: &Grains, line: QuantityLine) -> Vec<(f64, f64)> {
    let mut points = Vec::new();
    for (grain, (from, to)) in grains.runs() {
        match grain {
            SectionGrain::Exact => {
                let inside = [from, to].map(|end| exact.partition_point(|point| point.0 < end));
                points.extend(between(exact, from));
                points.extend(&exact[inside[0]..inside[1]]);
                points.extend(between(exact, to));
            }
            SectionGrain::Means(group) => {
                let borders = grains.borders(group, (from, to));
                let middles = borders.windows(2).map(|ends| 0.5 * (ends[0] + ends[1]));
                points.extend(middles.zip(line.means(&borders)).filter_map(|(at, mean)| Some((at, mean?))));
            }
        }
    }
    points
}

/// Returns the ordinate of a polyline at a place; `None` outside it.
fn between(points: &[(f64, f64)], at: f64) -> Option<(f64, f64)> {
    let is_within = points.first()?.0 < at && at <= points.last()?.0;
    let rows = rows_around_by(points.len(), |row| points[row].0, at, &mut 0).filter(|_| is_within)?;
    Some((at, rows.between_by(|row| points[row].1)))
}

/// Returns the ranges of rapid moves in view, mm; neighbours closer than a pixel are joined.
pub(crate) fn rapid_ranges(chart: &FeedChart, view: View, columns: usize) -> Vec<(f64, f64)> {
    let (low, high) = view.distance;
    let pixel = (high - low) / columns as f64;
    let mut stretches: Vec<(f64, f64)> = Vec::new();
    if chart.abscissa == Abscissa::Time {
        // Over time the rapids of each curve are at different times.
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
        // Ranges that begin within a pixel of the end, then those within a pixel of their end.
        while let near @ 1.. = left.partition_point(|rapid| begin(rapid) < high.min(to + pixel)) {
            to = end(&left[near - 1]);
            left = &left[near..];
        }
        stretches.push((from.max(low), to.min(high)));
    }
    stretches
}

/// Returns the programmed feedrate in view as a polyline with a point at either side of each change, or four
/// points for all changes in one pixel column.
fn programmed_steps(chart: &FeedChart, view: View, columns: usize) -> Vec<(f64, f64)> {
    let steps = &chart.programmed;
    let mut points: Vec<(f64, f64)> = Vec::new();
    let mut add = |begin: f64, end: f64, feedrate: f64| match points.last_mut() {
        Some(last) if *last == (begin, feedrate) => last.0 = end,
        _ => points.extend([(begin, feedrate), (end, feedrate)]),
    };
    for seen in by_column(&steps.end, steps.within(view.distance), view.distance, columns) {
        match steps.feedrate.extremes(seen.clone()) {
            Some(Extremes { lowest, highest }) if MAX_ROWS_DRAWN < seen.len() => {
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
                    rapid_ranges(&chart, view, columns),
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
