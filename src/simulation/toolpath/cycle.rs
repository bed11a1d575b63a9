//! Canned cycles: G73, G74, G76 and G81 to G89.
//!
//! A cycle word stays in force until G80 or a motion word; each block with an axis word in the
//! meantime is a hole, and L or K repeats it. What is traced is the rapid move to each hole in
//! the plane. The drilling itself is not: the tool stays at its height, and the cycle says how
//! many holes were so left out.

use crate::simulation::gcode::Place;
use crate::simulation::toolpath::remark::{Code, Untraced};
use crate::simulation::toolpath::trace::{Block, Tracer};

/// The most often one block repeats its hole.
const MOST_REPEATS: f64 = 10_000.0;

/// A cycle in force.
pub(super) struct Cycle {
    pub(super) code: Code,
    pub(super) name: &'static str,
    /// Where its word stands.
    pub(super) place: Place,
    /// How many holes it has made.
    pub(super) holes: u64,
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
        let repeats = self.given.get(b'L').or(self.given.get(b'K')).unwrap_or(1.0);
        let repeats = if (0.0..=MOST_REPEATS).contains(&repeats) { repeats as u64 } else { 1 };
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
