//! System variables that programs read: position, tool, modes.
//!
//! | Fanuc | LinuxCNC | value |
//! |---|---|---|
//! | #5001–#5003, #5041–#5043 | #5420–#5422, `_x` `_y` `_z` | position in the program's coordinates and unit |
//! | #5061–#5063 | #5061–#5063 | end of the last probing move, in the program's coordinates and unit |
//! | #4001, #4002 | | 0 to 3 by G0 to G3; 17 to 19 by the plane |
//! | #4119 | | spindle speed |
//! | #4109 | `_feed` | feedrate, unit of the program per minute |
//! | #4120 | #5400, `_current_tool` | tool |
//! | #4003 | `_incremental` | 90 or 91; `_incremental` is 1 under G91 |
//! | #4006 | `_metric`, `_imperial` | 20 or 21; the names are 1 in their unit |
//!
//! Sources: Fanuc B-63944EN, Sect. 16.2; LinuxCNC 2.9, Parameters.

use crate::simulation::gcode::{Dialect, POSITION_PARAMETERS};
use crate::simulation::interpreter::parameters::Control;
use crate::simulation::interpreter::state::Interpreter;
use crate::simulation::interpreter::words::Mode;
use crate::simulation::toolpath::plane::Turn;
use crate::units::{MM_PER_INCH, mm_per_min};

impl Control for Interpreter<'_> {
    fn numbered(&self, number: u32) -> Option<f64> {
        if self.is_heidenhain() {
            return self.klartext_parameter(number);
        }
        match number {
            5001..=5003 => Some(self.program_position((number - 5001) as usize)),
            5041..=5043 => Some(self.program_position((number - 5041) as usize)),
            5420..=5422 => Some(self.program_position((number - 5420) as usize)),
            5061..=5063 => {
                let probed = self.frame.to_program(&self.probed?);
                Some(probed[(number - 5061) as usize] / self.modal.unit)
            }
            4001 => Some(self.mode_of_program()),
            4002 => Some(19.0 - self.canonical.plane.axes()[2] as f64),
            4119 => self.functions.speed,
            4109 => Some(self.feed_of_program()),
            4120 | 5400 => Some(self.modal.tool.map_or(0.0, f64::from)),
            4003 => Some(if self.modal.is_incremental { 91.0 } else { 90.0 }),
            4006 => Some(if self.modal.unit == MM_PER_INCH { 20.0 } else { 21.0 }),
            _ => None,
        }
    }

    fn named(&self, name: &str) -> Option<f64> {
        let truth = |is_true: bool| Some(if is_true { 1.0 } else { 0.0 });
        if self.dialect == Dialect::Siemens {
            return self.siemens_variable(name);
        }
        match name {
            "_x" => Some(self.program_position(0)),
            "_y" => Some(self.program_position(1)),
            "_z" => Some(self.program_position(2)),
            "_feed" => Some(self.feed_of_program()),
            "_current_tool" | "_selected_tool" => Some(self.modal.tool.map_or(0.0, f64::from)),
            "_incremental" => truth(self.modal.is_incremental),
            "_absolute" => truth(!self.modal.is_incremental),
            "_metric" => truth(self.modal.unit != MM_PER_INCH),
            "_imperial" => truth(self.modal.unit == MM_PER_INCH),
            "_value" => Some(0.0),
            _ => None,
        }
    }
}

impl Interpreter<'_> {
    /// Returns the position of the tool on an axis, in the program's coordinates and unit.
    pub(crate) fn program_position(&self, axis: usize) -> f64 {
        self.frame.to_program(&self.canonical.position)[axis] / self.modal.unit
    }

    /// Returns the number of the motion word in force.
    fn mode_of_program(&self) -> f64 {
        match self.modal.mode {
            None | Some(Mode::Rapid) => 0.0,
            Some(Mode::Straight) => 1.0,
            Some(Mode::Arc(Turn::Clockwise)) => 2.0,
            Some(Mode::Arc(Turn::Counterclockwise)) => 3.0,
            Some(Mode::Spline(_)) => 5.0,
        }
    }

    /// Returns the feedrate in force, in the program's unit per minute.
    fn feed_of_program(&self) -> f64 {
        mm_per_min(self.modal.feedrate.unwrap_or(0.0)) / self.modal.unit
    }

    /// Returns the value of the control behind a Q parameter that the program did not assign.
    pub(crate) fn klartext_parameter(&self, number: u32) -> Option<f64> {
        if let Some(axis) = POSITION_PARAMETERS.iter().position(|known| *known == number) {
            return Some(self.program_position(axis));
        }
        match number {
            108 => self.tool_radius().map(|radius| radius / self.modal.unit),
            109 => Some(self.canonical.plane.axes()[2] as f64),
            113 => Some(if self.modal.unit == MM_PER_INCH { 1.0 } else { 0.0 }),
            _ => None,
        }
    }
}
