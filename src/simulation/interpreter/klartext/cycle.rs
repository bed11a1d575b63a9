//! Cycles: their definitions, and the calls that make their holes.
//!
//! A definition of a drilling cycle is kept until the next one. CYCL CALL and M99 make one hole at the position of
//! the tool, CYCL CALL POS moves to one, M89 makes one after every move until M99. Cycles 220 and 221 make a
//! circle or rows of holes at once, with the cycle defined before. The other cycles below 100 act at their
//! definition.

use crate::simulation::gcode::{LineNumber, address, whole_number};
use crate::simulation::interpreter::block::Block;
use crate::simulation::interpreter::bounds::{MAX_DWELL_S, MAX_HOLES};
use crate::simulation::interpreter::cycle::NoHole;
use crate::simulation::interpreter::klartext::KlartextRemark;
use crate::simulation::interpreter::klartext::hole::is_hole;
use crate::simulation::interpreter::remark::TraceRemark;
use crate::simulation::interpreter::state::Interpreter;
use crate::simulation::toolpath::Blending;
use crate::simulation::toolpath::Point;
use std::collections::BTreeMap;

/// Cycles without moves at their definition: contours, their data, subprograms, orientation of the spindle,
/// settings of touch probes.
const WITHOUT_MOVES: &[u32] = &[12, 13, 14, 20, 30, 239, 270, 271];

/// The definition in force, and the parameters of all cycles.
#[derive(Default)]
pub(super) struct CycleState {
    pub(super) number: Option<u32>,
    /// The settings of a cycle of several lines, by line.
    pub(super) settings: [Option<f64>; 10],
    /// The values that the program assigned to the parameters of cycles, by number.
    pub(super) parameters: BTreeMap<u32, f64>,
    /// `true` after M89.
    is_modal: bool,
    /// A pattern (cycle 220, 221) that waits for its parameters.
    pattern: Option<(u32, LineNumber)>,
}

impl CycleState {
    /// Returns a parameter as assigned by the program; 0 if it is not.
    pub(super) fn q(&self, number: u32) -> f64 {
        self.parameters.get(&number).copied().unwrap_or(0.0)
    }
}

impl Interpreter<'_> {
    /// Runs CYCL DEF.
    pub(super) fn define_cycle(&mut self, block: Block, number: u32, step: Option<u32>) {
        let number = number.min(1_000_000);
        let step = step.map(|step| step.min(9) as usize);
        let has_value = self.given.get(address::SETTING).is_some();
        match (number, step) {
            (7, Some(1..)) => self.shift_datum(block),
            (8, Some(1..)) => self.mirror_axes(),
            (8, Some(0)) => {}
            (9, Some(1..)) => self.wait(block),
            (10, Some(1..)) => self.rotate_plane(block, address::SETTING),
            (11, Some(1..)) => self.scale_all(block),
            (26, Some(1..)) => self.scale_axes(block),
            (32, Some(1)) => self.tolerance(block),
            (32, Some(0)) if !has_value => {
                let source = "CYCL DEF 32".to_string();
                self.set_tolerance(block.place(), source, Blending::Machine);
            }
            (7 | 9 | 10 | 11 | 26 | 32, _) => {}
            (19, Some(1..))
                if b"ABC".iter().any(|axis| self.given.get(*axis).is_some_and(|angle| angle != 0.0)) =>
            {
                let what = "the tilted working plane is not modelled: moves are taken as written";
                self.remark(block.place(), KlartextRemark::CycleSetting { number, what });
            }
            (19, _) => {}
            (247, _) => {
                let what = "presets of the control are unknown: the current one stays in force";
                self.remark(block.place(), KlartextRemark::CycleSetting { number, what });
            }
            (220 | 221, _) => self.klartext.cycle.pattern = Some((number, block.line)),
            (400..=499, _) => self.remark(block.place(), KlartextRemark::Cycle { number }),
            (_, Some(step @ 1..)) if self.klartext.cycle.number == Some(number) => {
                self.klartext.cycle.settings[step] = self.given.get(address::SETTING);
            }
            _ if WITHOUT_MOVES.contains(&number) => {}
            _ => {
                let cycle = &mut self.klartext.cycle;
                (cycle.number, cycle.is_modal, cycle.settings) = (Some(number), false, [None; 10]);
            }
        }
    }

    /// Runs cycle 9, a dwell.
    fn wait(&mut self, block: Block) {
        match self.given.get(address::SETTING) {
            Some(seconds) if (0.0..=MAX_DWELL_S).contains(&seconds) => {
                self.canonical.dwell(block.line, seconds);
            }
            Some(seconds) => self.remarks.add(block.place(), TraceRemark::BadDwell { seconds }),
            None => self.remarks.add(block.place(), TraceRemark::NoDwellTime),
        }
    }

    /// Runs cycle 32, which sets the contour tolerance; without T, or with 0, the tolerance of the machine.
    fn tolerance(&mut self, block: Block) {
        let tolerance = self.given.get(address::SETTING).filter(|tolerance| *tolerance != 0.0);
        let source = tolerance.map_or("CYCL DEF 32".to_string(), |value| format!("CYCL DEF 32 T{value}"));
        let blending = tolerance.map_or(Blending::Machine, |value| Blending::Within(value * self.modal.unit));
        self.set_tolerance(block.place(), source, blending);
    }

    /// Runs CYCL CALL.
    pub(super) fn call_cycle(&mut self, block: Block) {
        self.settle_approach();
        self.klartext.cycle.is_modal = false;
        self.run_cycle(block, 0.0);
    }

    /// Runs CYCL CALL POS, which moves in the plane to the hole; its Z lifts or lowers the surface of the cycle.
    pub(super) fn call_cycle_at(&mut self, block: Block) {
        self.settle_approach();
        let Some(mut target) = self.target(block) else { return };
        let axis = self.canonical.plane.axes()[2];
        let lift = self.given.get(b"XYZ"[axis]).unwrap_or(0.0) * self.modal.unit;
        target[axis] = self.canonical.position[axis];
        self.rapid_to(block, target);
        self.run_cycle(block, lift);
    }

    /// Makes the hole of M99 or M89, after the move of their block.
    pub(super) fn call_after_move(&mut self, block: Block, called: bool, begins: bool) {
        let cycle = &mut self.klartext.cycle;
        if called {
            cycle.is_modal = false;
        } else if begins {
            cycle.is_modal = true;
        }
        if called || (cycle.is_modal && self.moves_axes()) {
            self.settle_approach();
            self.run_cycle(block, 0.0);
        }
    }

    /// Runs the cycle in force at the position of the tool, with its surface lifted (mm).
    fn run_cycle(&mut self, block: Block, lift: f64) {
        let Some(number) = self.klartext.cycle.number else {
            self.remark(block.place(), KlartextRemark::NoCycle);
            return;
        };
        if is_hole(number) {
            self.make_klartext_hole(block, number, lift);
        } else if number == 12 {
            let (name, what) =
                ("cycle 12", "the program it calls is not run: its moves are missing from the time");
            self.remark(block.place(), KlartextRemark::Statement { name, what });
        } else {
            self.remark(block.place(), KlartextRemark::Cycle { number });
        }
    }

    /// Runs a pattern with the next statement, when all its parameters are known.
    pub(super) fn run_pattern(&mut self) {
        let Some((number, line)) = self.klartext.cycle.pattern.take() else { return };
        let block = Block::of_words(&[], line);
        let unit = self.modal.unit;
        let cycle = &self.klartext.cycle;
        let numbers: &[u32] = if number == 220 { &[241] } else { &[242, 243] };
        let counts: Option<Vec<u32>> = numbers.iter().map(|number| whole_number(cycle.q(*number))).collect();
        let count =
            counts.as_ref().map(|counts| counts.iter().map(|count| f64::from(*count)).product::<f64>());
        let Some(counts) = counts.filter(|_| count.is_some_and(|count| (1.0..=MAX_HOLES).contains(&count)))
        else {
            let count = numbers.iter().map(|number| cycle.q(*number)).product();
            let what = NoHole::NoCount(count).to_string();
            return self.remark(block.place(), KlartextRemark::NoHole { number, what });
        };
        let q = |number: u32| cycle.q(number) * unit;
        let angle = |number: u32| cycle.q(number).to_radians();
        let mut places = Vec::new();
        if number == 220 {
            let count = counts[0];
            let (first, last, step) = (angle(245), angle(246), angle(247));
            let is_closed = ((last - first).abs() - std::f64::consts::TAU).abs() < 1e-9;
            let spaces = if is_closed { f64::from(count) } else { f64::from(count) - 1.0 };
            let step = if step != 0.0 { step } else { (last - first) / spaces.max(1.0) };
            places.extend((0..count).map(|index| {
                let at = first + step * f64::from(index);
                [q(216) + 0.5 * q(244) * at.cos(), q(217) + 0.5 * q(244) * at.sin()]
            }));
        } else {
            let (columns, rows) = (counts[0], counts[1]);
            let (sin, cos) = angle(224).sin_cos();
            places.extend((0..columns * rows).map(|index| {
                let (row, column) = (index / columns, index % columns);
                // Every other row runs backwards.
                let column = if row % 2 == 0 { column } else { columns - 1 - column };
                let (along, across) = (f64::from(column) * q(237), f64::from(row) * q(238));
                [q(225) + cos * along - sin * across, q(226) + sin * along + cos * across]
            }));
        }
        let [a, b, _] = self.canonical.plane.axes();
        for place in places {
            let mut program: Point = self.frame.to_program(&self.canonical.position);
            (program[a], program[b]) = (place[0], place[1]);
            let mut target = self.frame.to_machine(&program);
            let axis = self.canonical.plane.axes()[2];
            target[axis] = self.canonical.position[axis];
            if !self.is_within_reach(block, 'X', target.coords.amax()) {
                return;
            }
            self.rapid_to(block, target);
            self.run_cycle(block, 0.0);
        }
    }
}
