//! The path of a control that merges short lines: the distance along the program, on the line that replaces it.
//!
//! A merged line of length l covers a part of length S of the program, which begins at the distance s0. At the distance s
//! along the program the tool is (s − s0) l/S along the line.

use crate::simulation::feed::corner_curve::{CornerCurve, on_curve};
use crate::simulation::feed::substitute::Substitute;
use crate::simulation::running_sum::running_sum;
use crate::simulation::toolpath::{Point, Segments, Vector};

/// The path with its merged lines, and where along the program each of its segments begins.
#[derive(Clone, Debug, PartialEq)]
pub struct MergedPath {
    segments: Segments,
    /// Distance along the program at which each segment begins, and the last ends, mm.
    begins: Vec<f64>,
}

impl MergedPath {
    /// Returns the path of a substitute, which has at least one segment.
    pub(super) fn of(substitute: &Substitute) -> MergedPath {
        let lengths = substitute.covers.iter().map(|cover| cover.length);
        let begins = running_sum([0.0].into_iter().chain(lengths)).collect();
        MergedPath { segments: substitute.toolpath.segments.clone(), begins }
    }

    /// Returns the position of the tool (mm) at a distance along the program (mm), with the curves in place of its corners,
    /// and its derivative by that distance.
    pub fn at(&self, distance: f64, curves: &[CornerCurve]) -> (Point, Vector) {
        let last = self.segments.len() - 1;
        let index = self.begins.partition_point(|begin| *begin <= distance).saturating_sub(1).min(last);
        let length = self.segments.length(index);
        let ratio = length / (self.begins[index + 1] - self.begins[index]);
        let offset = ((distance - self.begins[index]) * ratio).clamp(0.0, length);
        let (position, derivative) = on_curve(curves, index, offset, &self.segments)
            .unwrap_or_else(|| self.segments.point_and_tangent(index, offset));
        (position, ratio * derivative)
    }
}
