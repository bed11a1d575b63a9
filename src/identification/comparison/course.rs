//! The time lost over the distance: the column from which the chart of it is drawn.

use crate::identification::alignment::{Alignment, Place};
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
    let mut distances = vec![0.0];
    for segment in &toolpath.segments {
        distances.push(distances[distances.len() - 1] + segment.length);
    }
    let length = distances[distances.len() - 1];
    let of_stop = |stop: usize| {
        let after = toolpath.stops.get(stop).map_or(toolpath.segments.len(), |stop| stop.after);
        distances[after.min(toolpath.segments.len())]
    };
    let mut course = Course::default();
    let mut least = 0.0f64;
    for (mark, seconds) in alignment.marks.iter().zip(&comparison.residuals) {
        let distance = match mark.place {
            Place::Start => 0.0,
            Place::Along(distance) => distance.min(length),
            Place::Stop(stop) | Place::After(stop) => of_stop(stop),
        };
        least = least.max(distance);
        course.distance.push(least);
        course.seconds.push(*seconds);
    }
    course
}
