//! The kinds of stops whose time is one number of the machine.

use crate::identification::fit::FreeParameter;
use crate::machine::{Handle, Machine, SpindleDirection, SpindleState};
use crate::simulation::toolpath::StopCause;

/// No wait is longer, s: an operator's pause is not a property of the machine.
pub const LONGEST_WAIT_S: f64 = 600.0;

/// A kind of stop whose time is one number of the machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// M6.
    ToolChange,
    /// The first M6 of a program that has others.
    FirstToolChange,
    /// The spindle starts or changes its direction, or its speed by an M-word.
    SpindleStart,
    /// The spindle stops.
    SpindleStop,
    /// Any other M-word.
    MWord(u32),
}

impl Kind {
    /// The kind of a stop; `None` if its time is programmed or follows from motion.
    pub fn of(cause: &StopCause) -> Option<Kind> {
        match cause {
            StopCause::ToolChange { .. } => Some(Kind::ToolChange),
            StopCause::Spindle { to, code: Some(_), .. } if to.speed == 0.0 || is_standing(to) => {
                Some(Kind::SpindleStop)
            }
            StopCause::Spindle { code: Some(_), .. } => Some(Kind::SpindleStart),
            StopCause::MCode { code } => Some(Kind::MWord(*code)),
            StopCause::Dwell { .. }
            | StopCause::Rotary { .. }
            | StopCause::SameTool { .. }
            | StopCause::Spindle { code: None, .. } => None,
        }
    }

    /// Its number in the table of parameters.
    pub fn handle(self) -> Handle {
        match self {
            Kind::ToolChange => Handle::number("times.tool_change_s"),
            Kind::FirstToolChange => Handle::number("times.first_tool_change_s"),
            Kind::SpindleStart => Handle::number("times.spindle_start_s"),
            Kind::SpindleStop => Handle::number("times.spindle_stop_s"),
            Kind::MWord(code) => Handle::entry("times.m_codes", code),
        }
    }

    /// The word that asks for it.
    pub fn word(self) -> String {
        match self {
            Kind::ToolChange | Kind::FirstToolChange => "M6".to_string(),
            Kind::SpindleStart => "M3".to_string(),
            Kind::SpindleStop => "M5".to_string(),
            Kind::MWord(code) => format!("M{code}"),
        }
    }

    /// What the machine has for it, s.
    pub fn value(self, machine: &Machine) -> f64 {
        let times = &machine.times;
        match self {
            Kind::ToolChange => times.tool_change,
            Kind::FirstToolChange => times.first_tool_change.unwrap_or(times.tool_change),
            Kind::SpindleStart => times.spindle.start.unwrap_or(times.m_code),
            Kind::SpindleStop => times.spindle.stop.unwrap_or(times.m_code),
            Kind::MWord(code) => times.of_m_code(code),
        }
    }

    /// The parameter, beginning with `start` (s).
    pub fn freed(self, start: f64) -> FreeParameter {
        FreeParameter::wait(self.handle(), start, (0.0, LONGEST_WAIT_S)).linear()
    }
}

fn is_standing(spin: &SpindleState) -> bool {
    spin.direction == SpindleDirection::Standing
}
