//! Moves and arcs under a chain that is more than shifts.
//!
//! An arc is worked out in program coordinates, where the words that describe it hold, and then
//! taken to the machine: A e1, A e2 and A w with the radii times the scale k of A. A mirror turns
//! its sense and a rotation its plane without further rules, and the sweep stays.
//!
//! With unequal scales a circle would be an ellipse, which controls do not run. As on Fanuc
//! controls the end and I, J, K are scaled axis by axis, and R by the larger scale of the plane; what
//! comes out is run as a circle or a spiral.

use crate::machine::AXES;
use crate::simulation::toolpath::block::Block;
use crate::simulation::toolpath::frame::Affine;
use crate::simulation::toolpath::motion::REACH;
use crate::simulation::toolpath::plane::Turn;
use crate::simulation::toolpath::remark::Untraced;
use crate::simulation::toolpath::trace::Tracer;
use crate::simulation::toolpath::{Arc, Point, Vector};

impl Tracer<'_> {
    /// Where the axis words point under the chain, mm: `values` in program coordinates.
    pub(in crate::simulation::toolpath) fn turned_target(
        &mut self,
        block: Block,
        chain: &Affine,
        values: [Option<f64>; 3],
    ) -> Option<Point> {
        let program = self.frame.to_program(&self.position);
        let mut step = Vector::zeros();
        for (axis, letter) in AXES.into_iter().enumerate() {
            let Some(value) = values[axis] else { continue };
            step[axis] = if self.modal.is_incremental { value } else { value - program[axis] };
            if !self.is_within_reach(block, letter, value) {
                return None;
            }
        }
        // What is not programmed adds exactly nothing, and so keeps its digits.
        let target = self.position + chain.vector(&step);
        let is_within = target.coords.amax() <= REACH;
        if !is_within {
            self.remarks.add(block.place(), Untraced::OutOfReach { letter: 'X' });
        }
        is_within.then_some(target)
    }

    /// The arc of a block between two machine positions under the chain `map`.
    pub(in crate::simulation::toolpath) fn turned_arc(
        &mut self,
        block: Block,
        map: Affine,
        ends: (Point, Point),
        turn: Turn,
        turns: u32,
    ) -> Result<Arc, Untraced> {
        let program = (self.frame.to_program(&ends.0), self.frame.to_program(&ends.1));
        let center = self.center(block, program, turn)?;
        let plane = self.modal.plane;
        if let Some(scale) = map.scale() {
            return Ok(mapped(&plane.arc(program, center, turn, turns)?, &map, scale));
        }
        if !map.keeps(plane) {
            return Err(Untraced::TiltedUnevenScale);
        }
        self.remarks.add(block.place(), Untraced::UnevenScale);
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

/// An arc under a map that scales all lengths by `scale`.
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
