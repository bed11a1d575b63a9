//! The steps of a hole as segments and stops.

use crate::simulation::interpreter::block::Block;
use crate::simulation::interpreter::cycle::hole::{MAX_PECKS, Step, Turn, Work, work};
use crate::simulation::interpreter::cycle::{Hole, NoHole};
use crate::simulation::interpreter::remark::TraceRemark;
use crate::simulation::interpreter::state::Interpreter;
use crate::simulation::toolpath::{Curve, Motion};

/// The most steps of all holes of a program, so that a short text cannot ask for endless work.
const MAX_STEPS: usize = 2_000_000;

/// Steps that every block with a hole may have beyond them, so that a long program of plain holes
/// does not meet the bound.
const FREE_STEPS: usize = 4;

impl Interpreter<'_> {
    /// The steps of `hole`, and a remark where they are not those that are written.
    pub(crate) fn plan_hole(&mut self, block: Block, hole: &Hole) -> Result<Work, NoHole> {
        let work = work(hole)?;
        self.cycle.steps = self.cycle.steps.saturating_sub(FREE_STEPS);
        self.tell_deeper_pecks(block, work.pecks_per_made);
        Ok(work)
    }

    /// Tells that a hole has fewer pecks than written.
    pub(crate) fn tell_deeper_pecks(&mut self, block: Block, per_made: f64) {
        if 1.0 < per_made {
            self.remarks.add(block.place(), TraceRemark::DeeperPecks { most: MAX_PECKS, per_made });
        }
    }

    /// Makes a hole where the tool stands in the plane; its axis is the plane's normal.
    pub(crate) fn make_hole(&mut self, block: Block, work: &Work) -> Result<(), NoHole> {
        self.cycle.steps += work.steps.len();
        if MAX_STEPS < self.cycle.steps {
            return Err(NoHole::TooMuchWork(MAX_STEPS));
        }
        self.canonical.stop_as_in_cycles();
        let ([a, b, normal], center) = (self.canonical.plane.axes(), self.canonical.position);
        for step in &work.steps {
            let mut target = self.canonical.position;
            match *step {
                Step::Rapid(to) => target[normal] = to,
                Step::Feed { to, feedrate } => {
                    target[normal] = to;
                    let length = (to - self.canonical.position[normal]).abs();
                    self.push(block, target, Curve::Line, length, Motion::Feed { feedrate });
                }
                Step::Shift([along_a, along_b]) => {
                    target[a] = center[a] + along_a;
                    target[b] = center[b] + along_b;
                }
                Step::Dwell(seconds) => self.canonical.dwell(block.line, seconds),
                Step::Stop => self.turn_spindle(block, 5),
                Step::Orient => self.turn_spindle(block, 19),
                Step::Start(Turn::Right) => self.turn_spindle(block, 3),
                Step::Start(Turn::Left) => self.turn_spindle(block, 4),
                Step::Wait => self.canonical.machine_function(block.line, 0),
            }
            self.rapid_to(block, target);
        }
        Ok(())
    }
}
