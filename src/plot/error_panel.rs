//! The lower panel: the contour error of each curve over distance, with its tolerance.
//!
//! The panel shows the largest error in each pixel column as an outline over a pale area: a corner appears as
//! a needle, an arc as a step, and a finishing pass of a thousand blocks as its envelope. Dashed lines are
//! the tolerances. The ordinate begins at 0 and fits the view.

use plotters::coord::Shift;
use plotters::element::DashedPathElement;
use plotters::prelude::*;

use crate::plot::decimate::count_before;
use crate::plot::feed_panel::rapid_ranges;
use crate::plot::panel::{Axes, Borders, DrawError, Look, borders};
use crate::plot::{FeedChart, FeedrateCurve, Programmed, TolerancePart, View};
use crate::units::LengthUnit;

/// Ratio of the ordinate to the largest error in view.
const HEADROOM_RATIO: f64 = 1.12;

/// Opacity of the area below an outline.
const AREA_OPACITY: f64 = 0.16;

/// Largest number of rises and falls per point of the picture at which an outline is drawn as a line; above
/// it, the largest error in columns of [`COLUMN_PT`] is drawn.
const MAX_TURNS_PER_PT: f64 = 0.05;
const COLUMN_PT: f64 = 4.0;

/// Draws the contour errors of a chart on an area.
pub(crate) fn draw<B: DrawingBackend>(
    chart: &FeedChart,
    view: View,
    look: &Look,
    area: &DrawingArea<B, Shift>,
) -> Result<Borders, DrawError<B>> {
    let unit = look.theme.unit;
    let axes = |top: f64| Axes {
        distance: view.distance,
        distance_title: Some(chart.abscissa.title(unit)),
        distance_unit_size: chart.abscissa.unit_size(unit),
        value: (0.0, top),
        value_title: format!("Contour error ({})", unit.fine_symbol()),
    };
    // The number of columns must be known before the errors in them determine the scale.
    let borders = borders(&look.panel(area, &axes(1.0))?);
    let columns = (borders.x.1 - borders.x.0).max(1.0) as usize;
    let shown: Vec<(&FeedrateCurve, RGBColor)> = chart
        .curves
        .iter()
        .zip(look.theme.curves.iter().copied().cycle())
        .filter(|(curve, _)| !curve.hidden)
        .collect();
    let by = |columns: usize| -> Vec<_> {
        let of = |curve| outline(curve, &chart.programmed, view, columns, unit);
        shown.iter().map(|(curve, _)| of(curve)).collect()
    };
    let mut outlines = by(columns);
    if outlines.iter().any(|outline| MAX_TURNS_PER_PT * columns as f64 / look.scale < rise(outline)) {
        outlines = by((columns as f64 / (COLUMN_PT * look.scale)).ceil() as usize);
    }
    let in_sight: Vec<Vec<TolerancePart>> =
        shown.iter().map(|(curve, _)| merged(&curve.tolerances, view, columns)).collect();
    let tolerances = in_sight.iter().flatten().map(|stretch| unit.fine(stretch.tolerance));
    let errors = outlines.iter().flatten().map(|&(_, error)| error);
    let largest = tolerances.chain(errors).fold(0.0, f64::max);
    let axes = axes(HEADROOM_RATIO * if 0.0 < largest { largest } else { 1.0 });
    let mut context = look.panel(area, &axes)?;

    let theme = &look.theme;
    for (from, to) in rapid_ranges(chart, view, columns) {
        context.draw_series([Rectangle::new([(from, 0.0), (to, axes.value.1)], theme.rapid.filled())])?;
    }
    look.mesh(&mut context, &axes)?;
    // The widest tolerance first: smaller ones remain visible on top of it.
    for (outline, (_, color)) in outlines.iter().zip(&shown).rev() {
        context.draw_series(
            steps(outline).map(|ground| Polygon::new(ground, color.mix(AREA_OPACITY).filled())),
        )?;
        let line = color.stroke_width(look.points(1.25));
        context.draw_series(steps(outline).map(|step| PathElement::new(step, line)))?;
    }
    let tolerances = in_sight.iter().zip(&shown);
    for (stretch, color) in
        tolerances.flat_map(|(all, (_, color))| all.iter().map(move |stretch| (stretch, color)))
    {
        let tolerance = unit.fine(stretch.tolerance);
        let ends = [(stretch.from, tolerance), (stretch.to, tolerance)];
        let dashes = (look.points(5.0) as i32, look.points(4.0) as i32);
        let line = color.mix(0.8).stroke_width(look.points(1.0));
        context.draw_series([DashedPathElement::new(ends, dashes.0, dashes.1, line)])?;
    }
    Ok(borders)
}

/// Returns the total rise and fall of an outline, in heights from the abscissa to its top.
fn rise(outline: &[(f64, f64)]) -> f64 {
    let top = outline.iter().fold(f64::MIN_POSITIVE, |top, point| top.max(point.1));
    outline.windows(2).map(|pair| (pair[1].1 - pair[0].1).abs()).sum::<f64>() / top
}

/// Returns the parts within the view, cut at its borders; neighbours with the same tolerance are joined, and
/// parts narrower than a pixel column are dropped.
fn merged(tolerances: &[TolerancePart], view: View, columns: usize) -> Vec<TolerancePart> {
    let (low, high) = view.distance;
    let narrow = (high - low) / columns as f64;
    let mut joined: Vec<TolerancePart> = Vec::new();
    for stretch in tolerances.iter().filter(|stretch| stretch.from < high && low < stretch.to) {
        let (from, to) = (stretch.from.max(low), stretch.to.min(high));
        match joined.last_mut() {
            Some(last) if last.tolerance == stretch.tolerance && last.to == from => last.to = to,
            _ => joined.push(TolerancePart { from, to, ..*stretch }),
        }
    }
    joined.retain(|stretch| narrow <= stretch.to - stretch.from);
    joined
}

/// Returns the largest error (µm or in) in each pixel column as a polyline over distance (mm) with a point at
/// either side of each change; it begins and ends on the abscissa.
fn outline(
    curve: &FeedrateCurve,
    programmed: &Programmed,
    view: View,
    columns: usize,
    unit: LengthUnit,
) -> Vec<(f64, f64)> {
    let (low, high) = view.distance;
    let border = |column: usize| low + (high - low) * column as f64 / columns as f64;
    let ends = curve.segment_ends(programmed);
    let mut first = ends.partition_point(|&end| end <= low);
    let mut likely = 0;
    let mut points = vec![(low, 0.0)];
    for column in 0..columns {
        let (from, to) = (border(column), border(column + 1));
        // Segments that end in the column, and the one that continues beyond it.
        likely = count_before(&ends[first..], to, likely);
        let last = first + likely;
        let seen = first..(last + 1).min(ends.len());
        first = last + count_before(&ends[last..], to.next_up(), 0);
        let error = unit.fine(curve.largest_error_on(ends, seen, to).unwrap_or(0.0));
        let last = points[points.len() - 1].1;
        if error != last {
            points.extend([(from, last), (from, error)]);
        }
    }
    let last = points[points.len() - 1].1;
    points.extend([(high, last), (high, 0.0)]);
    points
}

/// Returns the parts of an outline above the abscissa, each from foot to foot.
fn steps(outline: &[(f64, f64)]) -> impl Iterator<Item = Vec<(f64, f64)>> {
    outline.chunk_by(|a, b| 0.0 < a.1 || 0.0 < b.1).filter(|part| part.len() > 1).map(<[_]>::to_vec)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::CurveErrors;

    /// Blocks of 1 mm with errors that repeat after 97, and an arc from 500 to 501 mm.
    fn curve() -> (FeedrateCurve, Programmed) {
        let end: Vec<f64> = (1..=1000).map(f64::from).collect();
        let corner = (0..1000).map(|k| 0.001 * f64::from(k % 97)).collect::<Vec<_>>().into();
        let (arcs, along_arcs) = (vec![500], vec![0.2].into());
        let programmed = Programmed { end, ..Programmed::default() };
        (
            FeedrateCurve { errors: CurveErrors { corner, arcs, along_arcs }, ..FeedrateCurve::default() },
            programmed,
        )
    }

    #[test]
    fn a_column_shows_the_largest_error_in_it_and_none_is_lost() {
        let (curve, programmed) = curve();
        for (distance, columns) in [((0.0, 1000.0), 100), ((0.0, 1000.0), 7919), ((490.5, 510.5), 333)] {
            let view = View { distance, feedrate: (0.0, 1.0) };
            let points = outline(&curve, &programmed, view, columns, LengthUnit::Millimetre);
            assert!(points.len() <= 2 * columns + 4);
            assert!(points.windows(2).all(|pair| pair[0].0 <= pair[1].0));
            let largest = points.iter().fold(0.0, |top: f64, point| top.max(point.1));
            assert!((largest - 200.0).abs() < 1e-9, "{largest}");
            let width = (distance.1 - distance.0) / columns as f64;
            for (k, &error) in curve.errors.corner.iter().enumerate() {
                let at = programmed.end[k];
                if distance.0 < at && at < distance.1 {
                    let near = points.iter().filter(|point| (point.0 - at).abs() <= 1.001 * width);
                    let top = near.fold(0.0, |top: f64, point| top.max(point.1));
                    assert!(
                        LengthUnit::Millimetre.fine(error) <= top + 1e-9,
                        "corner {k} of {columns} columns"
                    );
                }
            }
        }
    }

    #[test]
    fn tolerances_are_joined_and_cut_to_what_is_in_sight() {
        let stretch = |from: f64, to: f64, tolerance: f64| TolerancePart { from, to, tolerance };
        let all = [
            stretch(0.0, 10.0, 1.0),
            stretch(10.0, 20.0, 1.0),
            stretch(20.0, 20.01, 2.0),
            stretch(20.01, 90.0, 3.0),
        ];
        let view = View { distance: (5.0, 50.0), feedrate: (0.0, 1.0) };
        assert_eq!(merged(&all, view, 100), [stretch(5.0, 20.0, 1.0), stretch(20.01, 50.0, 3.0)]);
    }

    #[test]
    fn an_arc_is_a_step_along_the_whole_of_it() {
        let (mut curve, programmed) = curve();
        curve.errors.corner = vec![0.0; 1000].into();
        let view = View { distance: (490.0, 510.0), feedrate: (0.0, 1.0) };
        let points = outline(&curve, &programmed, view, 200, LengthUnit::Millimetre);
        let parts: Vec<_> = steps(&points).collect();
        assert_eq!(parts.len(), 1);
        let (first, last) = (parts[0][0], parts[0][parts[0].len() - 1]);
        assert!((first.0 - 500.0).abs() <= 0.1 && (last.0 - 501.0).abs() <= 0.1, "{first:?} {last:?}");
        assert_eq!((first.1, last.1), (0.0, 0.0));
    }
}
