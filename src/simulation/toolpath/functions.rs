//! Machine functions: what M, S and T words make the machine wait for.
//!
//! S is a speed in rpm that the spindle takes up at M3 or M4, or at once where it runs. An S word
//! alone stops the motion only where the machine has a spindle ramp: else there is nothing to wait
//! for. S under G96 is a cutting speed, and beside G4, G10, G50, G65, G66 and G92 it is not the
//! spindle's; M5 and M19 stop the spindle, and so does a tool change.
//!
//! A tool change to the tool that is in the spindle does nothing, as on most controls; which tool
//! that is at the beginning is not known.

use crate::machine::{Direction, Spin};
use crate::simulation::gcode::{Comment, Place};
use crate::simulation::toolpath::block::Block;
use crate::simulation::toolpath::operations::operations;
use crate::simulation::toolpath::remark::Untraced;
use crate::simulation::toolpath::trace::Tracer;
use crate::simulation::toolpath::words::tenths;
use crate::simulation::toolpath::{StopCause, Toolpath};

/// The speeds that are taken at their word, rpm.
const SPEEDS: std::ops::RangeInclusive<f64> = 0.0..=1e6;

/// Ten times the numbers of the G words beside which S is not a speed of the spindle.
const OTHER_SPEEDS: [u16; 6] = [40, 100, 500, 650, 660, 920];

/// The state of spindle and tool changer.
#[derive(Default)]
pub(super) struct Functions {
    spin: Spin,
    /// The speed that the next M3 or M4 takes up, rpm.
    pub(super) speed: Option<f64>,
    /// S is a cutting speed, by G96.
    has_surface_speed: bool,
    tool_in_spindle: Option<u32>,
}

impl Tracer<'_> {
    /// S, and the wait for it where it is alone.
    pub(super) fn take_speed(&mut self, block: Block) {
        let mut is_other = false;
        for tenths in block.words.iter().filter(|word| word.letter == b'G').filter_map(tenths) {
            match tenths {
                960 => self.functions.has_surface_speed = true,
                970 => self.functions.has_surface_speed = false,
                _ => is_other |= OTHER_SPEEDS.contains(&tenths),
            }
        }
        let is_speed = !is_other && !self.functions.has_surface_speed;
        let Some(speed) = self.given.get(b'S').filter(|_| is_speed) else { return };
        if !SPEEDS.contains(&speed) {
            self.remarks.add(block.place_of_letter(b'S'), Untraced::BadSpeed { value: speed });
            return;
        }
        self.functions.speed = Some(speed);
        let from = self.functions.spin;
        let has_spindle_word =
            block.words.iter().any(|word| word.letter == b'M' && [3.0, 4.0, 5.0, 19.0].contains(&word.value));
        if has_spindle_word || from.direction == Direction::Standing || from.speed == speed {
            return;
        }
        let to = Spin { speed, ..from };
        self.spin(to);
        let times = &self.machine.times;
        if times.spindle.ramp != 0.0 && times.spindle_awaited_by.is_empty() {
            self.stop(block, StopCause::Spindle { from, to, code: None });
        }
    }

    /// Cuts the toolpath into operations, given the comments of the program.
    pub(super) fn find_operations(&mut self, comments: &[Comment]) {
        let Toolpath { segments, stops, .. } = &self.toolpath;
        let (operations, beyond) = operations(segments, stops, comments);
        if let Some(last) = operations.last().filter(|_| 0 < beyond) {
            self.remarks.add(Place::line(last.line), Untraced::ManyOperations { beyond });
        }
        self.toolpath.operations = operations;
    }

    /// M3, M4, M5 and M19.
    pub(super) fn turn_spindle(&mut self, block: Block, code: u32) -> StopCause {
        let direction = match code {
            3 => Direction::Clockwise,
            4 => Direction::Counterclockwise,
            _ => Direction::Standing,
        };
        let from = self.functions.spin;
        let mut to = Spin::STANDING;
        if direction != Direction::Standing {
            if self.functions.speed.is_none() && self.machine.times.spindle.ramp != 0.0 {
                self.remarks.add(block.place(), Untraced::NoSpeed { code });
            }
            to = Spin { direction, speed: self.functions.speed.unwrap_or(0.0) };
        }
        self.spin(to);
        StopCause::Spindle { from, to, code: Some(code) }
    }

    /// The spindle turns like this from here on.
    fn spin(&mut self, spin: Spin) {
        self.functions.spin = spin;
        let after = self.toolpath.segments.len();
        let spins = &mut self.toolpath.spins;
        spins.pop_if(|known| known.0 == after);
        spins.push((after, spin));
    }

    /// Waits for what one of these words would have the spindle do, without the word.
    pub(super) fn spindle_stop(&mut self, block: Block, code: u32) {
        let cause = self.turn_spindle(block, code);
        self.stop(block, cause);
    }

    /// A change to the tool that was last asked for.
    pub(super) fn change_tool(&mut self, block: Block) -> StopCause {
        let tool = self.modal.tool;
        match (tool, self.functions.tool_in_spindle) {
            (Some(tool), Some(present)) if tool == present => {
                self.remarks.add(block.place(), Untraced::SameTool { tool });
                StopCause::SameTool { tool }
            }
            _ => {
                self.functions.tool_in_spindle = tool;
                self.spin(Spin::STANDING);
                StopCause::ToolChange { tool }
            }
        }
    }
}

#[cfg(test)]
mod tests;
