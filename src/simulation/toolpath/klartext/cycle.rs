//! `CYCL DEF`: what a cycle is defined to do, and when it is called.
//!
//! Cycles of coordinates and settings (7, 8, 9, 10, 11, 26, 32, 247) act where they are defined. A
//! drilling cycle waits for `CYCL CALL`, `CYCL CALL POS`, M99 (once, after the motion) or M89 (after
//! every motion, until M99). Patterns (220, 221) call it at each of their points. Every other cycle is
//! named in a diagnostic where it is called.

use crate::machine::AXES;
use crate::simulation::gcode::{
    CYCLE_NUMBER, CYCLE_PARAMETERS, CYCLE_STEP, FIRST_PARAMETER, LineNumber, Reference, Word, address,
};
use crate::simulation::toolpath::block::Block;
use crate::simulation::toolpath::klartext::KlartextRemark;
use crate::simulation::toolpath::path_mode::Blending;
use crate::simulation::toolpath::trace::Tracer;
use crate::simulation::toolpath::{StopCause, Vector};
use std::collections::BTreeMap;

/// The longest dwell that is taken at its word, s.
const LONGEST_DWELL: f64 = 1e6;

/// The most points of a pattern.
const MOST_POINTS: f64 = 10_000.0;

/// What cycles keep from block to block.
#[derive(Default)]
pub(super) struct Cycle {
    /// The machining cycle that a call runs.
    pub(super) number: Option<u32>,
    /// Its settings by line, for the cycles before 200.
    pub(super) settings: [Option<f64>; 8],
    /// What the parameters hold, as written.
    parameters: BTreeMap<u32, f64>,
    /// The number and the line of the `CYCL DEF` being read.
    defined: (u32, u32),
    is_modal: bool,
    /// A pattern whose parameters may still follow.
    pattern: Option<(u32, LineNumber)>,
}

impl Cycle {
    /// Takes in an argument of a block.
    pub(super) fn take_word(&mut self, word: &Word) {
        let whole = word.value.clamp(0.0, 1e6) as u32;
        match word.letter {
            CYCLE_NUMBER => self.defined = (whole, 0),
            CYCLE_STEP => self.defined.1 = whole,
            letter => {
                let place = letter.checked_sub(FIRST_PARAMETER).map(usize::from);
                if let Some(number) = place.and_then(|place| CYCLE_PARAMETERS.get(place)) {
                    self.parameters.insert(*number, word.value);
                }
            }
        }
    }

    /// What a parameter holds; 0 where nothing was assigned to it.
    pub(super) fn parameter(&self, number: u32) -> f64 {
        self.parameters.get(&number).copied().unwrap_or(0.0)
    }
}

impl Tracer<'_> {
    /// `CYCL DEF`.
    pub(super) fn define_cycle(&mut self, block: Block) {
        let (number, step) = self.klartext.cycle.defined;
        let setting = self.given.get(address::SETTING);
        match number {
            7 | 8 | 10 | 11 | 26 if 0 < step => self.transform_by_cycle(block, number),
            7 | 8 | 10 | 11 | 26 => {}
            9 => {
                if let Some(seconds) = setting.filter(|_| 0 < step) {
                    if (0.0..=LONGEST_DWELL).contains(&seconds) {
                        self.stop(block, StopCause::Dwell { seconds });
                    } else {
                        let what = "this waiting time is not possible: no dwell";
                        self.remark(block.place(), KlartextRemark::CycleSetting { number, what });
                    }
                }
            }
            32 => {
                let tolerance = setting.filter(|tolerance| step == 1 && 0.0 < *tolerance);
                if let Some(tolerance) = tolerance {
                    let blending = Blending::Within(tolerance * self.modal.unit);
                    self.set_tolerance(block.place(), format!("CYCL DEF 32 T{tolerance}"), blending);
                } else if step <= 1 {
                    self.set_tolerance(block.place(), "CYCL DEF 32".to_string(), Blending::Machine);
                }
            }
            12 if step == 1 => {
                let (name, what) =
                    ("CYCL DEF 12", "the program is not in this file: its moves are missing from the time");
                self.remark(block.place(), KlartextRemark::Statement { name, what });
            }
            12 | 13 | 14 | 20 | 247 => {}
            220 | 221 => self.klartext.cycle.pattern = Some((number, block.line)),
            _ => {
                let cycle = &mut self.klartext.cycle;
                if step == 0 {
                    cycle.number = Some(number);
                    cycle.settings = [None; 8];
                } else if let Some(slot) = cycle.settings.get_mut(step as usize) {
                    *slot = setting.or(self.given.get(b'F'));
                }
            }
        }
    }

    /// `CYCL CALL`.
    pub(super) fn call_cycle(&mut self, block: Block) {
        if self.klartext.cycle.number.is_none() {
            self.remark(block.place(), KlartextRemark::NoCycle);
            return;
        }
        self.klartext_hole(block);
    }

    /// `CYCL CALL POS`: to the place in the plane, then the cycle.
    pub(super) fn call_cycle_at(&mut self, block: Block) {
        self.straight(block);
        self.call_cycle(block);
    }

    /// M99 and M89, and what M89 left in force.
    pub(super) fn call_after_move(&mut self, block: Block, called: bool, is_modal: bool) {
        let was_modal = self.klartext.cycle.is_modal && self.moves_axes();
        self.klartext.cycle.is_modal = (self.klartext.cycle.is_modal || is_modal) && !called;
        if called || is_modal || was_modal {
            self.call_cycle(block);
        }
    }

    /// Runs a pattern once all of its parameters are known.
    pub(super) fn run_pattern(&mut self) {
        let Some((number, line)) = self.klartext.cycle.pattern.take() else { return };
        let q = |parameter: u32| self.klartext.cycle.parameter(parameter);
        let unit = self.modal.unit;
        let count = |value: f64| if (1.0..=MOST_POINTS).contains(&value) { value as u32 } else { 0 };
        let mut points: Vec<[f64; 2]> = Vec::new();
        if number == 220 {
            // Start Q245, step Q247, or all of it from Q245 to Q246 in equal parts.
            let holes = count(q(241));
            let step = match q(247) {
                0.0 if (q(246) - q(245)).rem_euclid(360.0) == 0.0 => 360.0 / f64::from(holes.max(1)),
                0.0 => (q(246) - q(245)) / f64::from(holes.saturating_sub(1).max(1)),
                step => step,
            };
            for hole in 0..holes {
                let angle = (q(245) + f64::from(hole) * step).to_radians();
                points.push([q(216) + 0.5 * q(244) * angle.cos(), q(217) + 0.5 * q(244) * angle.sin()]);
            }
        } else {
            let (columns, rows) = (count(q(242)), count(q(243)));
            let (sin, cos) = q(224).to_radians().sin_cos();
            for row in 0..rows.min(MOST_POINTS as u32 / columns.max(1)) {
                for column in 0..columns {
                    // Every other row runs back.
                    let column = if row % 2 == 0 { column } else { columns - 1 - column };
                    let (along, across) = (f64::from(column) * q(237), f64::from(row) * q(238));
                    points.push([q(225) + along * cos - across * sin, q(226) + along * sin + across * cos]);
                }
            }
        }
        let block = Block { words: &[], line };
        for point in points {
            let [a, b, _] = self.modal.plane.axes();
            let mut program = self.frame.to_program(&self.position);
            (program[a], program[b]) = (point[0] * unit, point[1] * unit);
            let target = self.frame.to_machine(&program);
            if !self.is_within_reach(block, 'X', target.coords.amax()) {
                return;
            }
            self.rapid_to(block, target);
            self.call_cycle(block);
        }
    }

    /// The axis words of a block in mm, absolute or added to `from`.
    pub(super) fn axis_words(&self, from: &Vector) -> [Option<f64>; 3] {
        let mut axis = 0;
        AXES.map(|letter| {
            let value = self.given.get(letter as u8).map(|value| value * self.modal.unit);
            let is_added = self.given.is_incremental(letter as u8, false);
            let value = value.map(|value| if is_added { from[axis] + value } else { value });
            axis += 1;
            value
        })
    }

    /// Whether the setting of a block is an increment.
    pub(super) fn is_added(&self, block: Block, address: u8) -> bool {
        block.words.iter().any(|word| word.letter == address && word.reference == Reference::Incremental)
    }
}
