//! Straight moves that something other than the program ends or drives: a probe, or the spindle.
//!
//! ```text
//! G31, G38.2 … G38.5 X Y Z   until the probe touches, at F     run to the end, as if it never did
//! G33 X Y Z K                thread: K per revolution          feedrate K S
//! G33.1 X Y Z K              rigid tapping: the same, then the spindle turns round and the tool
//!                            comes back to where it began
//! ```
//!
//! K is in the unit of length in force, S in rev/min. They act in their own block alone. Where a
//! probe touches nobody can tell, so the time of probing is an upper bound, but the moves after it
//! begin where the control has its tool if nothing is touched. That a thread waits for the
//! spindle's index, and that the tap overruns while the spindle turns round, is not modelled.
//!
//! Source: LinuxCNC 2.9, G-code reference, G33, G33.1 and G38; Fanuc B-63944EN, G31.

use crate::simulation::toolpath::block::{AXIS_WORDS, Block};
use crate::simulation::toolpath::feed_mode::FEEDRATES;
use crate::simulation::toolpath::remark::{Code, Untraced};
use crate::simulation::toolpath::trace::Tracer;
use crate::simulation::toolpath::{Curve, Motion, Point};
use crate::units::mm_per_s;

impl Tracer<'_> {
    /// G31 and G38: to the end, at the feedrate in force, where the tool then stands still.
    pub(super) fn probe(&mut self, block: Block, code: Code) {
        self.remarks.add(block.place(), Untraced::Probing { code });
        let Some(target) = self.target(block) else { return };
        self.exact_stop = true;
        self.feed_to(block, target);
        self.probed = Some(self.position);
    }

    /// G33 and, with the way back, G33.1.
    pub(super) fn thread(&mut self, block: Block, code: Code, is_tapping: bool) {
        if !self.given.has(AXIS_WORDS) {
            return;
        }
        let (Some(end), begin) = (self.target(block), self.position) else { return };
        let speed = self.functions.speed;
        let by_spindle = self.given.get(b'K').zip(speed).map(|(pitch, speed)| {
            let per_revolution = pitch.abs() * self.modal.unit;
            mm_per_s(per_revolution * speed)
        });
        let feedrate = by_spindle.filter(|feedrate| FEEDRATES.contains(feedrate));
        if feedrate.is_none() {
            self.remarks.add(block.place(), Untraced::NoThreadFeed { code });
        }
        let feedrate = feedrate.unwrap_or_else(|| self.feedrate(block));
        self.exact_stop |= is_tapping;
        self.stroke(block, end, feedrate);
        if is_tapping {
            let turn = self.cycle.turn;
            self.spindle_stop(block, turn.reversed().code());
            self.stroke(block, begin, feedrate);
            self.spindle_stop(block, turn.code());
        }
    }

    fn stroke(&mut self, block: Block, end: Point, feedrate: f64) {
        let length = (end - self.position).norm();
        self.push(block, end, Curve::Line, length, Motion::Feed { feedrate });
    }
}

#[cfg(test)]
mod tests;
