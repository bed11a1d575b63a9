//! Canned cycles: G73, G74, G76 and G81 to G89.
//!
//! A cycle word stays in force until G80 or a motion word; each block with an axis word in the
//! meantime is a hole, and L or K repeats it. What is traced is the rapid move to each hole in
//! the plane. The drilling itself is not: the tool stays at its height, and the cycle says how
//! many holes were so left out.

use crate::simulation::gcode::Place;
use crate::simulation::toolpath::block::Block;
use crate::simulation::toolpath::remark::{Code, Untraced};
use crate::simulation::toolpath::trace::Tracer;

/// The most often one block repeats its hole.
const MOST_REPEATS: f64 = 10_000.0;

/// The most repeated holes of a program, so that a short text cannot ask for endless work.
const MOST_REPEATS_OF_PROGRAM: usize = 1_000_000;

/// A cycle in force.
pub(super) struct Cycle {
    pub(super) code: Code,
    pub(super) name: &'static str,
    /// Where its word stands.
    pub(super) place: Place,
    /// How many holes it has made.
    pub(super) holes: usize,
}

impl Tracer<'_> {
    /// Ends the cycle in force, and says what of it was not timed.
    pub(super) fn end_cycle(&mut self) {
        if let Some(Cycle { code, name, place, holes }) = self.cycle.take()
            && 0 < holes
        {
            self.remarks.add(place, Untraced::Cycle { code, name, holes });
        }
    }

    /// Runs a block under a cycle.
    pub(super) fn hole(&mut self, block: Block) {
        let value = self.given.get(b'L').or(self.given.get(b'K')).unwrap_or(1.0);
        let left = MOST_REPEATS_OF_PROGRAM - self.repeats;
        let is_possible = (0.0..=MOST_REPEATS).contains(&value) && value as usize <= left + 1;
        let repeats = if is_possible { value as usize } else { 1 };
        if !is_possible {
            self.remarks.add(block.place(), Untraced::BadRepeats { value });
        }
        self.repeats += repeats.saturating_sub(1);
        let normal = self.modal.plane.axes()[2];
        for _ in 0..repeats {
            let Some(mut target) = self.target(block) else { return };
            target[normal] = self.position[normal];
            self.rapid_to(block, target);
        }
        if let Some(cycle) = &mut self.cycle {
            cycle.holes += repeats;
        }
    }
}
