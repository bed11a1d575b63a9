//! The chart of cutting loads over distance: force (N), power (W) and removal rate (cm³/min), one
//! panel each, by the programmed and by the predicted feedrate.
//!
//! Between the places of an engagement the curves are at 0. The abscissa is that of the chart of feedrates,
//! so that both can be compared over the same distances.

use plotters::prelude::*;

use crate::cutting::{CutLoad, Engagement, LoadCurve};
use crate::plot::decimate::{clipped, decimated};
use crate::plot::panel::{Axes, DrawError, Look, axis_number, borders};
use crate::plot::{Abscissa, Column, Theme, View};
use crate::simulation::sampled::rows_around;
use crate::units::{mm_per_min, watts_of_n_mm_per_s};

/// Room above the largest value, as a part of it.
const HEADROOM_SHARE: f64 = 0.08;

/// Cubic millimetres in a cubic centimetre.
const MM3_PER_CM3: f64 = 1000.0;

/// One quantity at both feedrates.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LoadCurves {
    /// At the programmed feedrate.
    pub programmed: Column,
    /// At the predicted feedrate.
    pub predicted: Column,
}

/// Data of the chart, in columns of equal length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LoadChart {
    /// Distance along the programmed path, mm, ascending.
    pub distance: Vec<f64>,
    /// Largest force within a revolution, N.
    pub force: LoadCurves,
    /// Power, W.
    pub power: LoadCurves,
    /// Removal rate, cm³/min.
    pub removal_rate: LoadCurves,
    /// Feed per tooth, mm; it is not drawn.
    pub feed_per_tooth: LoadCurves,
}

impl LoadChart {
    /// Returns the chart of an engagement's loads at the programmed and the predicted feedrate.
    pub fn of(engagement: &Engagement, [programmed, predicted]: &[LoadCurve; 2]) -> LoadChart {
        let none = CutLoad::default();
        let mut rows: Vec<(f64, [&CutLoad; 2])> = Vec::new();
        let mut end = f64::NEG_INFINITY;
        for (index, place) in engagement.places.iter().enumerate() {
            let start = place.distance - 0.5 * place.length;
            // A tiny distance is rounding; more is a gap in which nothing is cut.
            if end + 1e-6 < start {
                if end.is_finite() {
                    rows.push((end, [&none, &none]));
                }
                rows.push((start, [&none, &none]));
            }
            rows.push((place.distance, [&programmed.at[index], &predicted.at[index]]));
            end = place.distance + 0.5 * place.length;
        }
        if end.is_finite() {
            rows.push((end, [&none, &none]));
        }
        let column = |by: usize, of: fn(&CutLoad) -> f64| {
            rows.iter().map(|(_, loads)| of(loads[by])).collect::<Vec<_>>().into()
        };
        let curves =
            |of: fn(&CutLoad) -> f64| LoadCurves { programmed: column(0, of), predicted: column(1, of) };
        LoadChart {
            distance: rows.iter().map(|(at, _)| *at).collect(),
            force: curves(|load| load.force),
            power: curves(|load| watts_of_n_mm_per_s(load.power)),
            removal_rate: curves(|load| mm_per_min(load.removal_rate) / MM3_PER_CM3),
            feed_per_tooth: curves(|load| load.feed_per_tooth),
        }
    }

    /// Returns the range of distances of the chart, mm.
    pub fn span(&self) -> (f64, f64) {
        let ends = self.distance.first().zip(self.distance.last());
        ends.map_or((0.0, 1.0), |(&from, &to)| (from, to.max(from + 1e-3)))
    }

    /// Returns force, power and removal rate at a distance (mm), each at the programmed and the predicted
    /// feedrate; linear between rows, 0 beyond them.
    pub fn reading(&self, distance: f64) -> [[f64; 2]; 3] {
        let ends = self.distance.first().zip(self.distance.last());
        let is_within = ends.is_some_and(|(first, last)| *first < distance && distance <= *last);
        let rows = rows_around(&self.distance, distance, &mut 0).filter(|_| is_within);
        [&self.force, &self.power, &self.removal_rate].map(|curves| {
            let curves = [&curves.programmed, &curves.predicted];
            curves.map(|values| rows.map_or(0.0, |rows| rows.between(&values[..])))
        })
    }
}

/// Draws the chart between two distances (mm) over the whole of a backend; returns the left and right border
/// of its panels in pixels.
///
/// # Errors
///
/// Returns an error if the backend fails.
pub fn draw_loads<B: DrawingBackend>(
    chart: &LoadChart,
    distance: (f64, f64),
    theme: &Theme,
    scale: f64,
    backend: B,
) -> Result<(f64, f64), DrawError<B>> {
    let mut sides = (0.0, 1.0);
    let root = backend.into_drawing_area();
    root.fill(&theme.background)?;
    let panels = [
        (&chart.force, "Force (N)", None),
        (&chart.power, "Power (W)", None),
        (&chart.removal_rate, "Removal (cm³/min)", Some(Abscissa::Distance.title(theme.unit))),
    ];
    let tops = panels.each_ref().map(|(curves, ..)| top(&chart.distance, curves, distance));
    let characters = tops.map(|top| axis_number(theme, top, top).chars().count());
    let look = Look { theme: *theme, scale, label_characters: characters.into_iter().fold(5, usize::max) };
    for ((area, (curves, title, distance_title)), top) in
        root.split_evenly((panels.len(), 1)).iter().zip(panels).zip(tops)
    {
        let axes = Axes {
            distance,
            distance_title,
            distance_unit_size: Abscissa::Distance.unit_size(theme.unit),
            value: (0.0, top),
            value_title: title.to_string(),
        };
        let mut context = look.panel(area, &axes)?;
        let borders = borders(&context);
        sides = borders.x;
        let columns = (borders.x.1 - borders.x.0).max(1.0) as usize;
        look.mesh(&mut context, &axes)?;
        let lines = [
            (&curves.programmed, theme.programmed.stroke_width(look.points(2.5))),
            (&curves.predicted, theme.curves[0].stroke_width(look.points(1.75))),
        ];
        for (values, style) in lines {
            let kept = decimated(&chart.distance, values, distance, columns);
            let parts = clipped(&kept, View { distance, feedrate: axes.value });
            context.draw_series(parts.into_iter().map(|part| PathElement::new(part, style)))?;
        }
    }
    root.present()?;
    Ok(sides)
}

/// Returns the top of an ordinate that fits the view.
fn top(at: &[f64], curves: &LoadCurves, (low, high): (f64, f64)) -> f64 {
    let seen = at.partition_point(|at| *at < low)..at.partition_point(|at| *at <= high);
    let of_both = [&curves.programmed, &curves.predicted].map(|values| values.extremes(seen.clone()));
    let largest = of_both.into_iter().flatten().fold(0.0, |top: f64, own| top.max(own.highest));
    if 0.0 < largest { largest * (1.0 + HEADROOM_SHARE) } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cutting::{Mill, Setup, StockBox, engagement, loads, material, programmed_feedrates};
    use crate::machine::Machine;
    use crate::simulation::gcode::read;
    use crate::simulation::interpreter::trace;

    /// Two slots with air between them, the second at half of the feedrate predicted.
    fn chart() -> LoadChart {
        let program = "G21 G90 G0 X-10 Y5 Z5\nZ-2\nG1 X30 F1200\nG0 Z5\nY15\nZ-2\nG1 X-10\n";
        let toolpath = trace(&read(program.as_bytes()), &Machine::default());
        let setup = Setup {
            stock: Some(StockBox { min: [0.0, 0.0, -5.0], max: [20.0, 20.0, 0.0] }),
            resolution: Some(0.2),
            coefficients: material("al7075").map(|material| material.coefficients),
            tool: Some(Mill { diameter: Some(6.0), teeth: Some(2), ..Mill::default() }),
            spindle_speed: Some(8000.0),
            ..Setup::default()
        };
        let cut = engagement(&toolpath, &setup).expect("all is given");
        let programmed = programmed_feedrates(&cut, &toolpath);
        let half: Vec<f64> = programmed.iter().map(|feedrate| 0.5 * feedrate).collect();
        let both = loads(&cut, &toolpath, &setup, &[&programmed, &half]).expect("all is given");
        LoadChart::of(&cut, &both.try_into().expect("two"))
    }

    #[test]
    fn between_cuts_and_around_them_there_is_nothing() {
        let chart = chart();
        assert!(chart.distance.is_sorted());
        assert_eq!((chart.force.programmed[0], chart.force.programmed.last()), (0.0, Some(&0.0)));
        // Each slot begins and ends at 0.
        let zeros = chart.power.programmed.iter().filter(|power| **power == 0.0).count();
        assert!(4 <= zeros, "{zeros}");
        for (programmed, predicted) in chart.force.programmed.iter().zip(&*chart.force.predicted) {
            assert!(*predicted <= *programmed);
        }
        let at = chart.distance.len() / 4;
        let [[force, _], ..] = chart.reading(chart.distance[at]);
        assert!((force - chart.force.programmed[at]).abs() < 1e-9 * force);
        assert_eq!((chart.reading(-1.0), chart.reading(1e9)), ([[0.0; 2]; 3], [[0.0; 2]; 3]));
        // 6 mm × 2 mm × 1200 mm/min.
        let middle = chart.distance.len() / 4;
        assert!((chart.removal_rate.programmed[middle] / 14.4 - 1.0).abs() < 0.1);
    }

    #[test]
    fn the_picture_has_three_panels_with_two_curves_each() {
        let mut svg = String::new();
        let backend = SVGBackend::with_string(&mut svg, (800, 600));
        draw_loads(&chart(), (0.0, 120.0), &Theme::LIGHT, 1.0, backend)
            .expect("an SVG in memory can be drawn");
        for title in ["Force (N)", "Power (W)", "Removal (cm³/min)", "Distance along the path (mm)"] {
            assert_eq!(svg.matches(title).count(), 1, "{title}");
        }
        let hex = |color: RGBColor| format!("stroke=\"#{:02X}{:02X}{:02X}\"", color.0, color.1, color.2);
        for color in [Theme::LIGHT.programmed, Theme::LIGHT.curves[0]] {
            assert!(3 <= svg.matches(&hex(color)).count(), "{}", hex(color));
        }
        let mut empty = String::new();
        let backend = SVGBackend::with_string(&mut empty, (800, 600));
        draw_loads(&LoadChart::default(), (0.0, 1.0), &Theme::LIGHT, 1.0, backend)
            .expect("nothing can be drawn");
    }
}
