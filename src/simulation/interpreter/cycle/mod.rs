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

mod okuma;
pub(super) mod hole;
mod holes;
mod iso;

pub(super) use hole::{Hole, NoHole};

use crate::simulation::interpreter::cycle::hole::Turn;
use crate::simulation::interpreter::cycle::iso::Active;

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

#[cfg(test)]
mod tests;
