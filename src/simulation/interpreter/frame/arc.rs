//! Arcs under a chain of coordinates that is more than shifts.
//!
//! The interpreter computes an arc in program coordinates, in which its words hold, and maps it to the machine: A
//! e1, A e2 and A w, with the radii times the scale k of A. So a mirror reverses its sense and a rotation turns
//! its plane without further rules, and the sweep does not change.
//!
//! With unequal scales a circle would become an ellipse, which controls do not run. As on Fanuc controls the end
//! and I, J, K are scaled axis by axis, and R by the larger scale of the plane; the result is run as a circle or a
//! spiral.

use crate::simulation::interpreter::block::Block;
use crate::simulation::interpreter::frame::Affine;
use crate::simulation::interpreter::remark::TraceRemark;
use crate::simulation::interpreter::state::Interpreter;
use crate::simulation::toolpath::plane::Turn;
use crate::simulation::toolpath::{Arc, Point};

impl Interpreter<'_> {
    /// Returns the arc of a block between two machine positions under the chain `map`.
    pub(crate) fn turned_arc(
        &mut self,
        block: Block,
        map: Affine,
        ends: (Point, Point),
        turn: Turn,
        turns: u32,
    ) -> Result<Arc, TraceRemark> {
        let program = (self.frame.to_program(&ends.0), self.frame.to_program(&ends.1));
        let center = self.center(block, program, turn)?;
        let plane = self.canonical.plane;
        if let Some(scale) = map.scale() {
            return Ok(mapped(&plane.arc(program, center, turn, turns)?, &map, scale));
        }
        if !map.keeps(plane) {
            return Err(TraceRemark::TiltedUnevenScale);
        }
        self.remarks.add(block.place(), TraceRemark::UnevenScale);
        let turn = if map.flips(plane) { turn.reversed() } else { turn };
        let center = match self.given.get(b'R') {
            Some(radius) => {
                plane.center_of_radius(ends, turn, radius * self.modal.unit * map.largest_scale(plane))?
            }
            None => map.point(&center),
        };
        Ok(plane.arc(ends, center, turn, turns)?)
    }
}

/// Returns an arc under a map that scales all lengths by `scale`.
fn mapped(arc: &Arc, map: &Affine, scale: f64) -> Arc {
    Arc {
        center: map.point(&arc.center),
        e1: map.vector(&arc.e1) / scale,
        e2: map.vector(&arc.e2) / scale,
        start_radius: scale * arc.start_radius,
        end_radius: scale * arc.end_radius,
        sweep: arc.sweep,
        rise: map.vector(&arc.rise),
    }
}
