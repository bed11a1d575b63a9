//! Kinds of stops whose time is one number of the machine.

use crate::identification::fit::FreeParameter;
use crate::machine::{Handle, Machine};
use crate::simulation::toolpath::StopCause;

/// Longest wait, s: a longer one is an operator's pause and not a property of the machine.
pub const LONGEST_WAIT_S: f64 = 600.0;

/// A kind of stop whose time is one number of the machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum StopKind {
    /// Tool change by M6.
    ToolChange,
    /// First M6 of a program that has others.
    FirstToolChange,
    /// Start of the spindle, or a change of its direction.
    SpindleStart,
    /// Stop of the spindle.
    SpindleStop,
    /// Any other M-word.
    MWord(u32),
}

impl StopKind {
    /// Returns the kind of a stop; `None` if its time is programmed or follows from motion.
    pub fn of(cause: &StopCause) -> Option<StopKind> {
        let code = cause.m_code()?;
        Some(match cause {
            StopCause::MCode { .. } => StopKind::MWord(code),
            StopCause::ToolChange { .. } => StopKind::ToolChange,
            StopCause::Spindle { to, .. } if to.is_at_rest() => StopKind::SpindleStop,
            StopCause::Spindle { from, to, .. } if from.direction == to.direction => return None,
            _ => StopKind::SpindleStart,
        })
    }

    /// Returns the M-word of [`StopCause::m_code`].
    pub fn m_code(self) -> u32 {
        match self {
            StopKind::ToolChange | StopKind::FirstToolChange => 6,
            StopKind::SpindleStart => 3,
            StopKind::SpindleStop => 5,
            StopKind::MWord(code) => code,
        }
    }

    /// Returns the handle of its number in the table of parameters.
    pub fn handle(self) -> Handle {
        match self {
            StopKind::ToolChange => Handle::number("times.tool_change_s"),
            StopKind::FirstToolChange => Handle::number("times.first_tool_change_s"),
            StopKind::SpindleStart => Handle::number("times.spindle_start_s"),
            StopKind::SpindleStop => Handle::number("times.spindle_stop_s"),
            StopKind::MWord(code) => Handle::entry("times.m_codes", code),
        }
    }

    /// Returns the word that asks for a stop of this kind.
    pub fn word(self) -> String {
        format!("M{}", self.m_code())
    }

    /// Returns the number of words that the PLC answers: for a tool change T and M6.
    pub fn plc_words(self) -> usize {
        if matches!(self, StopKind::ToolChange | StopKind::FirstToolChange) { 2 } else { 1 }
    }

    /// Returns the time that the machine has for it, s.
    pub fn value(self, machine: &Machine) -> f64 {
        let times = &machine.times;
        match self {
            StopKind::ToolChange => times.tool_change,
            StopKind::FirstToolChange => times.first_tool_change.unwrap_or(times.tool_change),
            StopKind::SpindleStart => times.spindle.start.unwrap_or(times.m_code),
            StopKind::SpindleStop => times.spindle.stop.unwrap_or(times.m_code),
            StopKind::MWord(code) => times.of_m_code(code),
        }
    }

    /// Returns its time as a free parameter that begins with `start` (s).
    pub fn freed(self, start: f64) -> FreeParameter {
        FreeParameter::wait(self.handle(), start, (0.0, LONGEST_WAIT_S)).linear()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation::gcode::read;
    use crate::simulation::interpreter::trace;

    #[test]
    fn a_word_that_changes_the_speed_alone_takes_no_start() {
        let program = b"G1 X1 F600\nS5000 M3\nX2\nS8000 M3\nX3\nM4\nX4\nM5\nX5\n";
        let toolpath = trace(&read(program), &Machine::default());
        let kinds: Vec<_> = toolpath.stops.iter().map(|stop| StopKind::of(&stop.cause)).collect();
        let [start, speed, direction, stop] = kinds[..] else { panic!("{kinds:?}") };
        assert_eq!([start, direction], [Some(StopKind::SpindleStart); 2]);
        assert_eq!([speed, stop], [None, Some(StopKind::SpindleStop)]);
    }
}
