//! Evidence of the arcs of a program on the reference point of their centres.

use crate::simulation::interpreter::block::{Block, CENTER_WORDS, bits};
use crate::simulation::interpreter::center::CenterRule;
use crate::simulation::interpreter::remark::TraceRemark;
use crate::simulation::interpreter::state::Interpreter;
use crate::simulation::toolpath::Point;
use crate::simulation::toolpath::plane::{Plane, tolerated_difference};

impl Interpreter<'_> {
    /// Counts the arc of the block if it closes about a centre from its start or from the origin, but not both.
    pub(crate) fn count_center_evidence(&mut self, block: Block, ends: (Point, Point)) {
        let has_center = self.given.has(CENTER_WORDS) && !self.given.has(bits(b"R")) && !self.given.refers();
        if self.centers.rule == CenterRule::Fixed || !has_center || self.frame.turned().is_some() {
            return;
        }
        if self.centers.rule == CenterRule::Shown {
            self.remarks.add(block.place(), TraceRemark::AbsoluteCenters);
            return;
        }
        let plane = self.canonical.plane;
        let [a, b, _] = plane.axes();
        let mut centers = [ends.0; 2];
        for axis in [a, b] {
            let Some(value) = self.given.get(b"IJK"[axis]) else { continue };
            let value = value * self.modal.unit;
            centers[0][axis] += value;
            centers[1][axis] = self.frame.coordinate(axis, value);
        }
        let [from_start, from_origin] = centers.map(|center| closes(plane, ends, center));
        if from_start != from_origin {
            self.centers.decisive_arcs[usize::from(from_origin)] += 1;
        }
    }
}

/// Returns `true` if both ends are equally far from the centre.
fn closes(plane: Plane, ends: (Point, Point), center: Point) -> bool {
    let [a, b, _] = plane.axes();
    let [start, end] = [ends.0, ends.1].map(|end| (end[a] - center[a]).hypot(end[b] - center[b]));
    (start - end).abs() <= tolerated_difference(start)
}
