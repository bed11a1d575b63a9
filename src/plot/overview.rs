//! The overview: the mean feedrate of the curve on top over the whole path, with a pale area below it.
//!
//! The overview has neither axes nor margins, so that the left border is the start of the path and the right
//! one its end.

use plotters::prelude::*;

use crate::plot::feed_panel::clamped_means;
use crate::plot::panel::DrawError;
use crate::plot::{FeedChart, Theme};

/// Opacity of the area below the line.
const AREA_OPACITY: f64 = 0.18;
/// Width of a strip with a mean, points.
const STRIP_WIDTH_PT: f64 = 2.0;

/// Draws the whole of a chart over a backend of `scale` pixels per point.
///
/// # Errors
///
/// Returns an error if the backend fails.
pub fn draw_overview<B: DrawingBackend>(
    chart: &FeedChart,
    theme: &Theme,
    scale: f64,
    backend: B,
) -> Result<(), DrawError<B>> {
    let root = backend.into_drawing_area();
    root.fill(&theme.background)?;
    let view = chart.full_view(false);
    let count = (f64::from(root.dim_in_pixel().0) / (STRIP_WIDTH_PT * scale)).max(1.0) as usize;
    let ((low, high), (bottom, top)) = (view.distance, view.feedrate);
    if let Some(curve) = chart.curves.get(chart.on_top).filter(|curve| !curve.distance.is_empty()) {
        let points = clamped_means(chart, curve, view, count);
        let mut context = ChartBuilder::on(&root).build_cartesian_2d(low..high, bottom..top)?;
        let color = theme.curves[chart.on_top % theme.curves.len()];
        let feet = [(high, bottom), (low, bottom)];
        let ground = points.iter().copied().chain(feet).collect::<Vec<_>>();
        context.draw_series([Polygon::new(ground, color.mix(AREA_OPACITY).filled())])?;
        context.draw_series([PathElement::new(points, color.stroke_width(scale.round() as u32))])?;
    }
    root.present()
}
