//! A chart as a picture that stands in a document: SVG text, dark on white, everything in sight.

use plotters::prelude::SVGBackend;

use crate::plot::{FeedChart, Theme, draw};

/// The whole chart as SVG of this width and height (pixels of the page); none where it cannot be drawn.
pub fn svg(chart: &FeedChart, size: (u32, u32)) -> Option<String> {
    let mut text = String::new();
    let backend = SVGBackend::with_string(&mut text, size);
    let drawn = draw(chart, chart.full_view(false), &Theme::LIGHT, 1.0, backend).is_ok();
    drawn.then_some(text)
}
