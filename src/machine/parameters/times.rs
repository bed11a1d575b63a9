//! The rows of the times that are not motion.
//!
//! A time that is left empty is that of all other M-words, and these take none unless told so.

use std::collections::BTreeMap;

use crate::machine::parameter::{Access, Parameter, number};
use crate::machine::{Machine, Times};
use crate::units::Unit;

/// Seconds that a machine function can take: up to an hour.
const SECONDS: (f64, f64) = (0.0, 3600.0);

/// A row for a time.
const fn time(
    key: &'static str,
    label: &'static str,
    doc: &'static str,
    get: fn(&Machine) -> Option<f64>,
    set: fn(&mut Machine, Option<f64>),
) -> Parameter {
    Parameter { key, label, doc, access: number(Unit::Second, SECONDS, get, set) }
}

/// A row for the M-words of a group.
const fn words(
    key: &'static str,
    label: &'static str,
    doc: &'static str,
    get: fn(&Machine) -> Option<Vec<f64>>,
    set: fn(&mut Machine, Vec<f64>),
) -> Parameter {
    let access = Access::List { unit: Unit::Number, min: 0.0, max: 9999.0, whole: true, most: 20, get, set };
    Parameter { key, label, doc, access }
}

/// Seconds by word.
const fn codes(
    letter: char,
    get: fn(&Machine) -> &BTreeMap<u32, f64>,
    get_mut: fn(&mut Machine) -> &mut BTreeMap<u32, f64>,
) -> Access {
    Access::Codes { letter, unit: Unit::Second, min: SECONDS.0, max: SECONDS.1, get, get_mut }
}

fn written(words: &[u32]) -> Option<Vec<f64>> {
    Some(words.iter().map(|word| f64::from(*word)).collect())
}

fn read(words: Vec<f64>) -> Vec<u32> {
    words.into_iter().map(|word| word as u32).collect()
}

pub(super) const TIMES: [Parameter; 21] = [
    time(
        "times.start_s",
        "Program start",
        "Time from the start of the program to its first block; 0: none.",
        |m| Some(m.times.start),
        |m, v| m.times.start = v.unwrap_or(0.0),
    ),
    time(
        "times.tool_change_s",
        "Tool change",
        "Time of a tool change at M6, from the spindle's stop to the new tool clamped. A chip-to-chip time has the spindle's start and the moves to the change position in it.",
        |m| Some(m.times.tool_change),
        |m, v| m.times.tool_change = v.unwrap_or(Times::default().tool_change),
    ),
    time(
        "times.first_tool_change_s",
        "First tool change",
        "Time of the first tool change of a program, where the spindle is empty and nothing is put back; empty: as others.",
        |m| m.times.first_tool_change,
        |m, v| m.times.first_tool_change = v,
    ),
    Parameter {
        key: "times.tools",
        label: "Tools with their own change time",
        doc: "Seconds by tool, for example T12 = 9.0 for a heavy tool that is changed slowly.",
        access: codes('T', |m| &m.times.tools, |m| &mut m.times.tools),
    },
    time(
        "times.spindle_start_s",
        "Spindle start",
        "Time of M3 and M4 from standstill, besides the ramp; empty: as other M-words.",
        |m| m.times.spindle.start,
        |m, v| m.times.spindle.start = v,
    ),
    time(
        "times.spindle_stop_s",
        "Spindle stop",
        "Time of M5 and M19 to standstill, besides the ramp; empty: as other M-words.",
        |m| m.times.spindle.stop,
        |m, v| m.times.spindle.stop = v,
    ),
    Parameter {
        key: "times.spindle_s_per_1000_rpm",
        label: "Spindle ramp",
        doc: "Time for each 1000 rpm of a change of speed; 0: none, and S words alone do not stop the motion.",
        access: number(
            Unit::SecondPerThousandRpm,
            (0.0, 100.0),
            |m| Some(m.times.spindle.ramp),
            |m, v| m.times.spindle.ramp = v.unwrap_or(0.0),
        ),
    },
    Parameter {
        key: "times.spindle_exponent",
        label: "Exponent of the spindle ramp",
        doc: "By what power of the speed the ramp grows, being as long to 10 000 rpm: 1 at constant torque, 2 at constant power, up to 3 where power falls; empty: 1.",
        access: number(
            Unit::Number,
            (1.0, 4.0),
            |m| m.times.spindle.exponent,
            |m, v| m.times.spindle.exponent = v,
        ),
    },
    words(
        "times.spindle_awaited_by",
        "Words that wait for the spindle",
        "Numbers of the M-words that wait until the spindle has its speed, where M3 and M5 only start the ramp: for example [8, 1, 30]; empty: M3 to M5 wait themselves.",
        |m| written(&m.times.spindle_awaited_by).filter(|words| !words.is_empty()),
        |m, v| m.times.spindle_awaited_by = read(v),
    ),
    time(
        "times.spindle_change_s",
        "Wait at S words",
        "Time that the feed waits at an S word in a block of motion until the spindle has its speed; 0: it goes on.",
        |m| Some(m.times.spindle_change),
        |m, v| m.times.spindle_change = v.unwrap_or(0.0),
    ),
    time(
        "times.coolant_on_s",
        "Coolant on",
        "Time of M7 and M8; empty: as other M-words.",
        |m| m.times.coolant_on,
        |m, v| m.times.coolant_on = v,
    ),
    time(
        "times.coolant_off_s",
        "Coolant off",
        "Time of M9; empty: as other M-words.",
        |m| m.times.coolant_off,
        |m, v| m.times.coolant_off = v,
    ),
    time(
        "times.program_stop_s",
        "Program stop",
        "How long the machine waits at M0 until somebody starts it again; empty: as other M-words.",
        |m| m.times.program_stop,
        |m, v| m.times.program_stop = v,
    ),
    Parameter {
        key: "times.optional_stop",
        label: "Optional stop taken",
        doc: "Whether the switch is set that has the machine wait at M1; else M1 takes what other M-words take.",
        access: Access::Flag {
            get: |m| m.times.takes_optional_stop,
            set: |m, v| m.times.takes_optional_stop = v,
        },
    },
    time(
        "times.optional_stop_s",
        "Optional stop",
        "How long the machine waits at an M1 that is taken; empty: as at M0.",
        |m| m.times.optional_stop,
        |m, v| m.times.optional_stop = v,
    ),
    time(
        "times.pallet_change_s",
        "Pallet change",
        "Time of the M-words that change the pallet; empty: as other M-words.",
        |m| m.times.pallet_change,
        |m, v| m.times.pallet_change = v,
    ),
    words(
        "times.pallet_words",
        "Words that change the pallet",
        "Numbers of the M-words that change the pallet.",
        |m| written(&m.times.pallet_words),
        |m, v| m.times.pallet_words = read(v),
    ),
    time(
        "times.clamp_s",
        "Clamping",
        "Time of each M-word that clamps or unclamps an axis or the part; empty: as other M-words.",
        |m| m.times.clamp,
        |m, v| m.times.clamp = v,
    ),
    words(
        "times.clamp_words",
        "Words that clamp",
        "Numbers of the M-words that clamp and unclamp.",
        |m| written(&m.times.clamp_words),
        |m, v| m.times.clamp_words = read(v),
    ),
    time(
        "times.m_code_s",
        "Other M-words",
        "Time of every M-word for which nothing else is given, beyond stopping; 0: none.",
        |m| Some(m.times.m_code),
        |m, v| m.times.m_code = v.unwrap_or(0.0),
    ),
    Parameter {
        key: "times.m_codes",
        label: "M-words with their own time",
        doc: "Seconds by M-word, in place of the time of its group: M8 = 3.0 for a coolant that needs 3 s. Not for tool changes.",
        access: codes('M', |m| &m.times.m_codes, |m| &mut m.times.m_codes),
    },
];
