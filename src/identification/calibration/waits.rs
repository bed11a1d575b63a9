//! What of a machine's waits a recording shows: one parameter for each kind of stop it ran through.
//!
//! The first guess of each is the median, over its visits, of what the visit took longer than the motion
//! in it; the fit then takes all of them together with the motion.

use std::collections::BTreeMap;

use crate::identification::alignment::median;
use crate::identification::comparison::Comparison;
use crate::identification::fit::{Freed, Scale};
use crate::machine::Machine;
use crate::simulation::toolpath::{Stop, StopCause, Toolpath};

/// No wait is longer, s: an operator's pause is not a property of the machine.
const LONGEST: f64 = 600.0;

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
    /// The kind of a stop; none where its time is programmed or follows from motion.
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

    /// Its key in the machine file.
    pub fn key(self) -> String {
        match self {
            Kind::ToolChange => "times.tool_change_s".to_string(),
            Kind::FirstToolChange => "times.first_tool_change_s".to_string(),
            Kind::SpindleStart => "times.spindle_start_s".to_string(),
            Kind::SpindleStop => "times.spindle_stop_s".to_string(),
            Kind::MWord(code) => format!("times.m_codes.M{code}"),
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
    pub fn freed(self, start: f64) -> Freed {
        Freed::new(self.key(), start, (0.0, LONGEST), Scale::Difference, move |machine, seconds| {
            let times = &mut machine.times;
            match self {
                Kind::ToolChange => times.tool_change = seconds,
                Kind::FirstToolChange => times.first_tool_change = Some(seconds),
                Kind::SpindleStart => times.spindle.start = Some(seconds),
                Kind::SpindleStop => times.spindle.stop = Some(seconds),
                Kind::MWord(code) => drop(times.m_codes.insert(code, seconds)),
            }
        })
        .linear()
    }
}

fn is_standing(spin: &crate::machine::Spin) -> bool {
    spin.direction == crate::machine::Direction::Standing
}

/// The kinds of stops in what was recorded, with a first guess of each (s) and how often it came.
pub fn guesses(machine: &Machine, compared: &[(&Toolpath, &Comparison)]) -> Vec<(Kind, f64, usize)> {
    let mut samples: BTreeMap<Kind, Vec<f64>> = BTreeMap::new();
    let changes = |toolpath: &Toolpath| {
        let is_change = |stop: &Stop| matches!(stop.cause, StopCause::ToolChange { .. });
        let all: Vec<usize> =
            (0..toolpath.stops.len()).filter(|at| is_change(&toolpath.stops[*at])).collect();
        all
    };
    // Of programs with one change each, first and others are the same.
    let has_others = compared.iter().any(|(toolpath, _)| 1 < changes(toolpath).len());
    for (toolpath, comparison) in compared {
        let first = changes(toolpath).first().copied().filter(|_| has_others);
        for visit in comparison.lost.iter().filter(|visit| visit.waits()) {
            let kind = |at: usize| match Kind::of(&toolpath.stops[at].cause) {
                Some(Kind::ToolChange) if first == Some(at) => Some(Kind::FirstToolChange),
                kind => kind,
            };
            let kinds: Vec<Kind> = visit.stops.clone().filter_map(kind).collect();
            for kind in &kinds {
                // What several stops of one line took cannot be told apart there: each gets its part.
                let seconds = kind.value(machine) + visit.seconds() / kinds.len() as f64;
                samples.entry(*kind).or_default().push(seconds);
            }
        }
    }
    let guess = |(kind, mut seconds): (Kind, Vec<f64>)| {
        let count = seconds.len();
        (kind, median(&mut seconds).clamp(0.0, LONGEST), count)
    };
    samples.into_iter().map(guess).collect()
}

/// By how much longer than simulated the time from the start of a program to its first block is, s.
pub fn start_guess(compared: &[(&Toolpath, &Comparison)]) -> f64 {
    let first = compared.iter().filter_map(|(_, comparison)| comparison.residuals.get(1).copied());
    let mut seconds: Vec<f64> = first.collect();
    median(&mut seconds).clamp(-LONGEST, LONGEST)
}
