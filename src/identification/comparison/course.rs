//! The time lost over the distance: the column from which the chart of it is drawn.

use crate::identification::alignment::Alignment;
use crate::identification::comparison::Comparison;
use crate::simulation::toolpath::Toolpath;

/// How much later the recorded machine is, over distance; rows of equal distance are a wait.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Course {
    /// Distance along the path, mm; ascending.
    pub distance: Vec<f64>,
    /// Time lost since the first mark, s.
    pub seconds: Vec<f64>,
}

/// The time lost at every mark.
pub fn course(toolpath: &Toolpath, alignment: &Alignment, comparison: &Comparison) -> Course {
    let distances = toolpath.distances();
    let length = distances[distances.len() - 1];
    let mut course = Course::default();
    let mut least = 0.0f64;
    for (mark, seconds) in alignment.marks.iter().zip(&comparison.residuals) {
        least = least.max(mark.place.distance(toolpath, &distances).min(length));
        course.distance.push(least);
        course.seconds.push(*seconds);
    }
    course
}
