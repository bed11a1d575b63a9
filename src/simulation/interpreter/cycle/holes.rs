//! The steps of a hole as segments and stops.

use crate::simulation::interpreter::block::Block;
use crate::simulation::interpreter::cycle::hole::{HolePlan, HoleStep, MAX_PECKS, SpindleTurn, work};
use crate::simulation::interpreter::cycle::{Hole, NoHole};
use crate::simulation::interpreter::remark::TraceRemark;
use crate::simulation::interpreter::state::Interpreter;
use crate::simulation::toolpath::{Curve, Motion};

/// Most steps of all holes of a program, so that a short text cannot cause endless work.
const MAX_STEPS: usize = 2_000_000;

/// Number of steps per block with a hole that do not count, so that a long program of plain holes remains below
/// the bound.
const FREE_STEPS: usize = 4;

impl Interpreter<'_> {
    /// Returns the steps of `hole`, and remarks if they differ from the program.
    ///
    /// # Errors
    ///
    /// If the hole cannot be made.
    pub(crate) fn plan_hole(&mut self, block: Block, hole: &Hole) -> Result<HolePlan, NoHole> {
        let work = work(hole)?;
        self.cycle.steps = self.cycle.steps.saturating_sub(FREE_STEPS);
        self.remark_on_deeper_pecks(block, work.pecks_per_made);
        Ok(work)
    }

    /// Remarks on a hole with fewer pecks than programmed.
    pub(crate) fn remark_on_deeper_pecks(&mut self, block: Block, per_made: f64) {
        if 1.0 < per_made {
            self.remarks.add(block.place(), TraceRemark::DeeperPecks { most: MAX_PECKS, per_made });
        }
    }

    /// Makes a hole at the position of the tool in the plane; its axis is the plane's normal.
    ///
    /// # Errors
    ///
    /// If all holes together have too many steps.
    pub(crate) fn make_hole(&mut self, block: Block, work: &HolePlan) -> Result<(), NoHole> {
        self.cycle.steps += work.steps.len();
        if MAX_STEPS < self.cycle.steps {
            return Err(NoHole::TooMuchWork(MAX_STEPS));
        }
        self.canonical.stop_as_in_cycles();
        let ([a, b, normal], center) = (self.canonical.plane.axes(), self.canonical.position);
        for step in &work.steps {
            let mut target = self.canonical.position;
            match *step {
                HoleStep::Rapid(to) => target[normal] = to,
                HoleStep::Feed { to, feedrate } => {
                    target[normal] = to;
                    let length = (to - self.canonical.position[normal]).abs();
                    self.push(block, target, Curve::Line, length, Motion::Feed { feedrate });
                }
                HoleStep::Shift([along_a, along_b]) => {
                    target[a] = center[a] + along_a;
                    target[b] = center[b] + along_b;
                }
                HoleStep::Dwell(seconds) => self.canonical.dwell(block.line, seconds),
                HoleStep::Stop => self.turn_spindle(block, 5),
                HoleStep::Orient => self.turn_spindle(block, 19),
                HoleStep::Start(SpindleTurn::Right) => self.turn_spindle(block, 3),
                HoleStep::Start(SpindleTurn::Left) => self.turn_spindle(block, 4),
                HoleStep::Wait => self.canonical.machine_function(block.line, 0),
            }
            self.rapid_to(block, target);
        }
        Ok(())
    }
}
