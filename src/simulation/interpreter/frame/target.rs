//! Destinations of axis words.

use crate::machine::AXES;
use crate::simulation::interpreter::block::Block;
use crate::simulation::interpreter::bounds::MAX_COORDINATE_MM;
use crate::simulation::interpreter::frame::Affine;
use crate::simulation::interpreter::remark::TraceRemark;
use crate::simulation::interpreter::state::Interpreter;
use crate::simulation::toolpath::{Point, Vector};

impl Interpreter<'_> {
    /// Returns the destination of the axis words, mm, or `None` if it is out of reach.
    pub(crate) fn target(&mut self, block: Block) -> Option<Point> {
        let mut target = self.canonical.position;
        let values = self.axis_values();
        if let Some(chain) = self.frame.turned().copied() {
            return self.turned_target(block, &chain, values);
        }
        for (axis, letter) in AXES.into_iter().enumerate() {
            let Some(value) = values[axis] else { continue };
            target[axis] = match self.modal.is_incremental {
                true => self.canonical.position[axis] + value,
                false => self.frame.coordinate(axis, value),
            };
            if !self.is_within_reach(block, letter, target[axis]) {
                return None;
            }
        }
        Some(target)
    }

    /// Returns the destination of `values`, in program coordinates, under the chain, mm; `None` if it is out of
    /// reach.
    pub(crate) fn turned_target(
        &mut self,
        block: Block,
        chain: &Affine,
        values: [Option<f64>; 3],
    ) -> Option<Point> {
        let program = self.frame.to_program(&self.canonical.position);
        let mut step = Vector::zeros();
        for (axis, letter) in AXES.into_iter().enumerate() {
            let Some(value) = values[axis] else { continue };
            step[axis] = if self.modal.is_incremental { value } else { value - program[axis] };
            if !self.is_within_reach(block, letter, value) {
                return None;
            }
        }
        // An axis without a word adds exactly 0, and so keeps its digits.
        let target = self.canonical.position + chain.vector(&step);
        let is_within = target.coords.amax() <= MAX_COORDINATE_MM;
        if !is_within {
            self.remarks.add(block.place(), TraceRemark::OutOfReach { letter: 'X' });
        }
        is_within.then_some(target)
    }
}
