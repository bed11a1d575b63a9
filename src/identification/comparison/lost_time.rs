//! The lost-time curve: time lost over distance, for charts.

use crate::identification::alignment::Alignment;
use crate::identification::comparison::Comparison;
use crate::simulation::toolpath::Toolpath;

/// The time lost over distance; rows of equal distance are a wait.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LostTimeCurve {
    /// Distance along the path, mm; ascending.
    pub distance: Vec<f64>,
    /// Time lost since the first mark, s.
    pub seconds: Vec<f64>,
}

/// Returns the time lost at every mark.
pub fn lost_time_curve(toolpath: &Toolpath, alignment: &Alignment, comparison: &Comparison) -> LostTimeCurve {
    let distances = toolpath.distances();
    let length = distances[distances.len() - 1];
    let mut curve = LostTimeCurve::default();
    let mut least = 0.0f64;
    for (mark, seconds) in alignment.marks.iter().zip(&comparison.residuals) {
        least = least.max(mark.place.distance(toolpath, &distances).min(length));
        curve.distance.push(least);
        curve.seconds.push(*seconds);
    }
    curve
}
