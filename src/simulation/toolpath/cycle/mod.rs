//! Cycles: what is done at each hole, while one is in force.
//!
//! The hole module knows the work along the axis and no program; the iso module reads a cycle's
//! words (G73 to G89); here the steps of a hole become segments and stops. Every block under a
//! cycle makes its hole, L or K times.
//!
//! All moves of a cycle end in a full stop, as on LinuxCNC, which runs them in exact path mode,
//! and on controls that check the position after rapid moves and turn round at the bottom.
//! Spindle words within a cycle (M3, M4, M5, M19 oriented, M0 for a retract by hand) are stops
//! like those that a program writes.

pub(super) mod hole;
mod iso;

pub(super) use hole::{Hole, NoHole};

use crate::simulation::toolpath::block::Block;
use crate::simulation::toolpath::cycle::hole::{MOST_PECKS, Step, Turn, Work, work};
use crate::simulation::toolpath::cycle::iso::Active;
use crate::simulation::toolpath::remark::Untraced;
use crate::simulation::toolpath::trace::Tracer;
use crate::simulation::toolpath::{Curve, Motion, StopCause};

/// The most steps of all holes of a program, so that a short text cannot ask for endless work.
const MOST_STEPS: usize = 2_000_000;

/// Steps that every block with a hole may have beyond them, so that a long program of plain holes
/// does not meet the bound.
const FREE_STEPS: usize = 4;

/// What cycles keep from block to block.
#[derive(Default)]
pub(super) struct Cycles {
    active: Option<Active>,
    /// G99: back to R, or G98: to the initial height.
    pub(super) returns_to_reference: Option<bool>,
    /// The turn of the spindle by the last M3 or M4.
    pub(super) turn: Turn,
    /// M29: tapping is rigid.
    is_rigid: bool,
    /// The last P of a cycle, s.
    dwell: f64,
    /// Steps of all holes so far, less those that are free.
    steps: usize,
}

impl Cycles {
    pub(super) fn is_active(&self) -> bool {
        self.active.is_some()
    }

    /// How the spindle turns.
    pub(super) fn turn(&self) -> Turn {
        self.turn
    }

    /// G80, or a word of motion.
    pub(super) fn end(&mut self) {
        self.active = None;
        self.is_rigid = false;
    }

    /// Takes notice of the M-words that cycles go by.
    pub(super) fn m_word(&mut self, number: Option<u32>) {
        match number {
            Some(3) => self.turn = Turn::Right,
            Some(4) => self.turn = Turn::Left,
            Some(29) => self.is_rigid = true,
            _ => {}
        }
    }
}

impl Tracer<'_> {
    /// The steps of `hole`, and a remark where they are not those that are written.
    pub(super) fn plan_hole(&mut self, block: Block, hole: &Hole) -> Result<Work, NoHole> {
        let work = work(hole)?;
        self.cycle.steps = self.cycle.steps.saturating_sub(FREE_STEPS);
        self.tell_deeper_pecks(block, work.has_deeper_pecks);
        Ok(work)
    }

    /// Tells that a hole has fewer pecks than written.
    pub(super) fn tell_deeper_pecks(&mut self, block: Block, has_deeper_pecks: bool) {
        if has_deeper_pecks {
            self.remarks.add(block.place(), Untraced::DeeperPecks { most: MOST_PECKS });
        }
    }

    /// Makes a hole where the tool stands in the plane; its axis is the plane's normal.
    pub(super) fn make_hole(&mut self, block: Block, work: &Work) -> Result<(), NoHole> {
        self.cycle.steps += work.steps.len();
        if MOST_STEPS < self.cycle.steps {
            return Err(NoHole::TooMuchWork(MOST_STEPS));
        }
        self.exact_stop = true;
        let ([a, b, normal], center) = (self.modal.plane.axes(), self.position);
        for step in &work.steps {
            let mut target = self.position;
            match *step {
                Step::Rapid(to) => target[normal] = to,
                Step::Feed { to, feedrate } => {
                    target[normal] = to;
                    let length = (to - self.position[normal]).abs();
                    self.push(block, target, Curve::Line, length, Motion::Feed { feedrate });
                }
                Step::Shift([along_a, along_b]) => {
                    target[a] = center[a] + along_a;
                    target[b] = center[b] + along_b;
                }
                Step::Dwell(seconds) => self.stop(block, StopCause::Dwell { seconds }),
                Step::Stop => self.spindle_stop(block, 5),
                Step::Orient => self.spindle_stop(block, 19),
                Step::Start(Turn::Right) => self.spindle_stop(block, 3),
                Step::Start(Turn::Left) => self.spindle_stop(block, 4),
                Step::Wait => self.stop(block, StopCause::MCode { code: 0 }),
            }
            self.rapid_to(block, target);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
