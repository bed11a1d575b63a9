//! The small chart of a law as measured: points with their spread, the monotone curve through them, and the
//! law of the simulated machine.
//!
//! Points are dots with a bar of one standard deviation to either side, the curve is a line, and the
//! simulated machine an open circle at each point. Both axes begin at 0.

use plotters::prelude::*;

use crate::plot::Theme;
use crate::plot::panel::{Axes, DrawError, Look, axis_number};

/// Room above and to the right of the data, as a part of it.
const HEADROOM_SHARE: f64 = 0.08;
/// Radius of a dot and of a circle, points.
const DOT_RADIUS_PT: f64 = 3.0;
const CIRCLE_RADIUS_PT: f64 = 5.0;

/// Data of the chart, in the units of its titles.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LawChart {
    /// Titles of abscissa and ordinate, with their units.
    pub titles: [String; 2],
    /// Abscissa, value and spread of each point.
    pub points: Vec<[f64; 3]>,
    /// Abscissa and value of the curve.
    pub curve: Vec<[f64; 2]>,
    /// Abscissa and value of the simulated machine's curve.
    pub simulated: Vec<[f64; 2]>,
}

/// Draws the chart over the whole of a backend.
///
/// # Errors
///
/// Returns an error if the backend fails.
pub fn draw_law<B: DrawingBackend>(
    chart: &LawChart,
    theme: &Theme,
    scale: f64,
    backend: B,
) -> Result<(), DrawError<B>> {
    let top = |values: &mut dyn Iterator<Item = f64>| {
        let largest = values.fold(0.0, f64::max);
        if 0.0 < largest { largest * (1.0 + HEADROOM_SHARE) } else { 1.0 }
    };
    let simulated = || chart.simulated.iter();
    let right = top(&mut chart.points.iter().map(|point| point[0]));
    let values = chart.points.iter().map(|point| point[1] + point[2]);
    let high = top(&mut values.chain(simulated().map(|point| point[1])));
    let characters = axis_number(theme, high, high).chars().count() + 1;
    let look = Look { theme: *theme, scale, label_characters: characters.max(5) };
    let root = backend.into_drawing_area();
    root.fill(&theme.background)?;
    let axes = Axes {
        distance: (0.0, right),
        distance_title: Some(chart.titles[0].clone()),
        distance_unit_size: 1.0,
        value: (0.0, high),
        value_title: chart.titles[1].clone(),
    };
    let mut context = look.panel(&root, &axes)?;
    look.mesh(&mut context, &axes)?;
    let [measured, machine, ..] = theme.curves;
    let line = chart.curve.iter().map(|level| (level[0], level[1]));
    context.draw_series(LineSeries::new(line, measured.stroke_width(look.points(1.75))))?;
    let bars = chart.points.iter().map(|&[over, value, spread]| {
        let ends = [(over, (value - spread).max(0.0)), (over, value + spread)];
        PathElement::new(ends, measured.stroke_width(look.points(1.0)))
    });
    context.draw_series(bars)?;
    let dots = chart.points.iter();
    let dots =
        dots.map(|point| Circle::new((point[0], point[1]), look.points(DOT_RADIUS_PT), measured.filled()));
    context.draw_series(dots)?;
    let circles = simulated().map(|point| {
        Circle::new(
            (point[0], point[1]),
            look.points(CIRCLE_RADIUS_PT),
            machine.stroke_width(look.points(1.5)),
        )
    });
    context.draw_series(circles)?;
    root.present()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::svg_of_law;

    #[test]
    fn every_point_is_a_dot_and_every_simulated_one_a_circle() {
        let chart = LawChart {
            titles: ["turn, °".to_string(), "feedrate, mm/min".to_string()],
            points: vec![[30.0, 900.0, 20.0], [90.0, 250.0, 5.0]],
            curve: vec![[30.0, 900.0], [90.0, 250.0]],
            simulated: vec![[30.0, 910.0]],
        };
        let text = svg_of_law(&chart, &Theme::LIGHT, (320, 200)).expect("an SVG in memory can be drawn");
        assert_eq!(text.matches("<circle").count(), 3);
        for title in &chart.titles {
            assert!(text.contains(&**title), "{title}");
        }
        assert!(svg_of_law(&LawChart::default(), &Theme::LIGHT, (320, 200)).is_some());
    }
}
