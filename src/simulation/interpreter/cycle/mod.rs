//! Cycles: the holes of blocks while a cycle is in force.
//!
//! The `hole` module works along the axis and knows no program. The `iso` module reads the words of a cycle (G73
//! to G89). The `holes` module makes segments and stops of the steps of a hole. Every block under a cycle makes
//! its hole, L or K times.
//!
//! All moves of a cycle end in a full stop, as on LinuxCNC, which runs them in exact path mode, and on controls
//! that check the position after rapid moves and reverse at the bottom. Spindle words within a cycle (M3, M4, M5,
//! M19 oriented, M0 for a retract by hand) are stops like those of a program.

mod okuma;
pub(super) mod hole;
mod holes;
mod iso;

pub(super) use hole::{Hole, NoHole};

use crate::simulation::interpreter::cycle::hole::SpindleTurn;
use crate::simulation::interpreter::cycle::iso::ActiveCycle;

/// State of cycles from block to block.
#[derive(Default)]
pub(super) struct Cycles {
    active: Option<ActiveCycle>,
    /// `true` for a return to R (G99), `false` for a return to the initial height (G98).
    pub(super) returns_to_reference: Option<bool>,
    /// The direction of the spindle by the last M3 or M4.
    pub(super) turn: SpindleTurn,
    /// `true` after M29: tapping is rigid.
    is_rigid: bool,
    /// The last P of a cycle, s.
    dwell: f64,
    /// Number of steps of all holes so far, less those that do not count.
    steps: usize,
}

impl Cycles {
    pub(super) fn is_active(&self) -> bool {
        self.active.is_some()
    }

    /// Returns the direction of the spindle.
    pub(super) fn turn(&self) -> SpindleTurn {
        self.turn
    }

    /// Ends the cycle, by G80 or a motion word.
    pub(super) fn end(&mut self) {
        self.active = None;
        self.is_rigid = false;
    }

    /// Reads an M word that affects cycles.
    pub(super) fn m_word(&mut self, number: Option<u32>) {
        match number {
            Some(3) => self.turn = SpindleTurn::Right,
            Some(4) => self.turn = SpindleTurn::Left,
            Some(29) => self.is_rigid = true,
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests;
