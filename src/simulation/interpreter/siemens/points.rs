//! Points and arcs by the words of SINUMERIK programs alone.
//!
//! - AP and RP give a point about the pole of G110, G111 and G112; an arc to it has the pole as its centre.
//! - ANG with one coordinate of the end: a straight line at this angle to the first axis of the plane.
//! - CR, AR, CIP and CT give an arc by its radius, its opening angle, a point on it, its first direction.
//!
//! Source: SINUMERIK 840D sl, Programming Manual Fundamentals, 2013. Not read: two straight lines by their
//! angles and the end of the second.

use crate::machine::AXES;
use crate::simulation::gcode::address;
use crate::simulation::interpreter::block::Block;
use crate::simulation::interpreter::remark::TraceRemark;
use crate::simulation::interpreter::state::Interpreter;
use crate::simulation::toolpath::{Arc, Point};

impl Interpreter<'_> {
    /// Runs G110 to G112.
    pub(super) fn set_pole(&mut self, block: Block, code: u16) {
        let from = match code {
            110 => self.frame.to_program(&self.canonical.position),
            111 => Point::origin(),
            _ => self.siemens.pole,
        };
        let mut pole = from;
        for (axis, letter) in AXES.into_iter().enumerate() {
            let value = self.given.get(letter as u8).unwrap_or(0.0) * self.modal.unit;
            pole[axis] += value;
            if !self.is_within_reach(block, letter, pole[axis]) {
                return;
            }
        }
        self.siemens.pole = pole;
    }

    /// Runs CIP: the arc through a point, in any plane.
    pub(super) fn arc_through(&mut self, block: Block) {
        let Some(end) = self.target(block) else { return };
        let mut middle = self.frame.to_program(&self.canonical.position);
        for (axis, address) in
            [address::MIDDLE_X, address::MIDDLE_Y, address::MIDDLE_Z].into_iter().enumerate()
        {
            if let Some(value) = self.given.get(address) {
                let value = value * self.modal.unit;
                let is_incremental = self.given.is_incremental(address, self.modal.is_incremental);
                middle[axis] = if is_incremental { middle[axis] + value } else { value };
            }
        }
        let middle = self.frame.to_machine(&middle);
        match Arc::through(self.canonical.position, middle, end) {
            Some(arc) => self.feed_along(block, end, arc),
            None => {
                self.remarks.add(block.place(), TraceRemark::NoArcThrough);
                self.feed_to(block, end);
            }
        }
    }

    /// Runs CT: the arc that begins in the direction of the last move.
    pub(super) fn tangential_arc(&mut self, block: Block) {
        let Some(end) = self.target(block) else { return };
        let direction = self.canonical.toolpath().segments.last().map(|last| last.tangent(last.length));
        let normal = self.canonical.plane.axes()[2];
        match direction.and_then(|direction| Arc::along(self.canonical.position, direction, end, normal)) {
            Some(arc) => self.feed_along(block, end, arc),
            None => self.feed_to(block, end),
        }
    }

    /// Remarks on ANG without an end.
    pub(super) fn check_angle(&mut self, block: Block) {
        let [a, b, _] = self.canonical.plane.axes();
        let has_end = [a, b].into_iter().any(|axis| self.given.get(AXES[axis] as u8).is_some());
        if self.given.get(address::LINE_ANGLE).is_some() && !has_end {
            let what = "a line by its angle alone, whose end the next block gives, is not modelled: one straight line is run instead of two";
            self.remarks.add(block.place(), TraceRemark::Statement { name: "ANG", what });
        }
    }
}
