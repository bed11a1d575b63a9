//! M, S and T words.

use crate::machine::{SpindleDirection, SpindleState};
use crate::simulation::interpreter::block::Block;
use crate::simulation::interpreter::remark::TraceRemark;
use crate::simulation::interpreter::spindle_and_tool::OTHER_SPEEDS;
use crate::simulation::interpreter::state::Interpreter;
use crate::simulation::interpreter::words::tenths;

/// The speeds that count as meant, rpm.
const SPEEDS_RPM: std::ops::RangeInclusive<f64> = 0.0..=1e6;

impl Interpreter<'_> {
    /// Runs S, with the wait for it if it is alone.
    pub(crate) fn set_speed(&mut self, block: Block) {
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
        if !SPEEDS_RPM.contains(&speed) {
            self.remarks.add(block.place_of_letter(b'S'), TraceRemark::BadSpeed { value: speed });
            return;
        }
        self.functions.speed = Some(speed);
        let from = self.canonical.spin();
        let has_spindle_word =
            block.words.iter().any(|word| word.letter == b'M' && [3.0, 4.0, 5.0, 19.0].contains(&word.value));
        if has_spindle_word || from.direction == SpindleDirection::Standing || from.speed == speed {
            return;
        }
        let times = &self.machine.times;
        let waits = times.spindle.ramp != 0.0 && times.spindle_awaited_by.is_empty();
        self.canonical.set_spindle_speed(block.line, speed, waits);
    }

    /// Runs M3, M4, M5 and M19.
    pub(crate) fn turn_spindle(&mut self, block: Block, code: u32) {
        let direction = match code {
            3 => SpindleDirection::Clockwise,
            4 => SpindleDirection::Counterclockwise,
            _ => SpindleDirection::Standing,
        };
        let mut to = SpindleState::AT_REST;
        if direction != SpindleDirection::Standing {
            if self.functions.speed.is_none() && self.machine.times.spindle.ramp != 0.0 {
                self.remarks.add(block.place(), TraceRemark::NoSpeed { code });
            }
            to = SpindleState { direction, speed: self.functions.speed.unwrap_or(0.0) };
        }
        self.canonical.turn_spindle(block.line, to, code);
    }

    /// Changes to the tool of the last T word.
    pub(crate) fn change_tool(&mut self, block: Block) {
        let tool = self.modal.tool;
        if let (false, Some(tool)) = (self.canonical.change_tool(block.line, tool), tool) {
            self.remarks.add(block.place(), TraceRemark::SameTool { tool });
        }
    }
}
