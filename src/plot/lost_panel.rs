//! The lower panel of a chart with a recording: the time that the recorded machine has lost since the start,
//! over distance.
//!
//! Where the line rises the recorded machine is slower than the simulated one, where it falls faster; a step
//! is a wait. The ordinate fits the view and always includes 0. The panel draws the lost time against the
//! machine before and after a change, in the colours of their feedrates.

use plotters::coord::Shift;
use plotters::prelude::*;

use crate::plot::decimate::{clipped, decimated};
use crate::plot::feed_panel::rapid_ranges;
use crate::plot::panel::{Axes, Borders, DrawError, Look, borders};
use crate::plot::{Abscissa, FeedChart, LostTime, View};
use crate::simulation::sampled::rows_around;

/// Room above and below the data, as a part of it.
const HEADROOM_SHARE: f64 = 0.08;

/// Least span of the ordinate, s: smaller differences are noise of the recorder.
const MIN_SPAN_S: f64 = 1e-3;

/// Draws the lost time on an area.
pub(crate) fn draw<B: DrawingBackend>(
    chart: &FeedChart,
    lost: &LostTime,
    view: View,
    look: &Look,
    area: &DrawingArea<B, Shift>,
) -> Result<Borders, DrawError<B>> {
    let after = chart.lost_after.as_ref();
    let all = [lost].into_iter().chain(after);
    let value = all
        .map(|lost| in_sight(lost, view.distance))
        .fold((0.0f64, 0.0f64), |(low, high), own| (low.min(own.0), high.max(own.1)));
    let axes = Axes {
        distance: view.distance,
        distance_title: Some(Abscissa::Distance.title(look.theme.unit)),
        distance_unit_size: Abscissa::Distance.unit_size(look.theme.unit),
        value,
        value_title: "Time lost (s)".to_string(),
    };
    let mut context = look.panel(area, &axes)?;
    let borders = borders(&context);
    let columns = (borders.x.1 - borders.x.0).max(1.0) as usize;

    let theme = &look.theme;
    let (low, high) = axes.value;
    for (from, to) in rapid_ranges(chart, view, columns) {
        context.draw_series([Rectangle::new([(from, low), (to, high)], theme.rapid.filled())])?;
    }
    look.mesh(&mut context, &axes)?;
    let none = [(view.distance.0, 0.0), (view.distance.1, 0.0)];
    context.draw_series([PathElement::new(none, theme.axis.stroke_width(look.points(1.0)))])?;
    let lines = match after {
        None => vec![(lost, theme.curves[0])],
        Some(after) => vec![(lost, theme.curves[1]), (after, theme.curves[2])],
    };
    for (lost, color) in lines {
        let kept = decimated(&lost.distance, &lost.seconds, view.distance, columns);
        let line = color.stroke_width(look.points(1.75));
        let parts = clipped(&kept, View { distance: view.distance, feedrate: axes.value });
        context.draw_series(parts.into_iter().map(|part| PathElement::new(part, line)))?;
    }
    Ok(borders)
}

/// Returns the least and the largest lost time (s) between two distances (mm), extended to include 0 and some
/// room.
fn in_sight(lost: &LostTime, (low, high): (f64, f64)) -> (f64, f64) {
    let (at, seconds) = (&lost.distance, &lost.seconds);
    let inside = seconds.extremes(at.partition_point(|at| *at < low)..at.partition_point(|at| *at <= high));
    let ends = [low, high].map(|end| Some(rows_around(at, end, &mut 0)?.between(&seconds[..])));
    let inside = inside.map(|inside| [inside.lowest, inside.highest]).into_iter().flatten();
    let all = inside.chain(ends.into_iter().flatten());
    let (least, largest) = all.fold((0.0f64, 0.0f64), |(a, b), value| (a.min(value), b.max(value)));
    let room = HEADROOM_SHARE * (largest - least).max(MIN_SPAN_S);
    (least - room, largest + room)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ordinate_fits_what_is_in_sight_and_has_zero_in_it() {
        let lost =
            LostTime { distance: vec![0.0, 10.0, 10.0, 20.0], seconds: vec![0.0, 1.0, 5.0, 3.0].into() };
        let (low, high) = in_sight(&lost, (0.0, 5.0));
        assert!(low < 0.0 && (high - 0.5 * (1.0 + HEADROOM_SHARE)).abs() < 1e-12, "{low} to {high}");
        let (low, high) = in_sight(&lost, (12.0, 13.0));
        assert!(low < 0.0 && 4.6 < high && high < 5.1, "{low} to {high}");
        let (low, high) = in_sight(&LostTime::default(), (0.0, 1.0));
        assert!(low < 0.0 && 0.0 < high);
    }
}
