//! The rows of halts and of overrides by line: what diagnoses may find in a run.

use std::collections::BTreeMap;

use crate::machine::parameter::{Access, Parameter, number};
use crate::machine::words::choice_of;
use crate::machine::{InPosition, Machine};
use crate::units::Unit;

/// Seconds that a halt can take: up to an hour.
const SECONDS: (f64, f64) = (0.0, 3600.0);

/// Bounds of the ratio of an override.
const RATIO: (f64, f64) = (0.01, 10.0);

/// A row for a table of values by line of the program.
const fn by_line(
    key: &'static str,
    label: &'static str,
    doc: &'static str,
    unit: Unit,
    (min, max): (f64, f64),
    get: fn(&Machine) -> &BTreeMap<u32, f64>,
    get_mut: fn(&mut Machine) -> &mut BTreeMap<u32, f64>,
) -> Parameter {
    Parameter { key, label, doc, access: Access::Codes { letter: 'L', unit, min, max, get, get_mut } }
}

pub(super) const HALTS: [Parameter; 7] = [
    by_line(
        "override.feed_by_line",
        "Feed override by line",
        "Factor on programmed feedrates from a line on, until another line has another one: for example L412 = 0.78; L901 = 1.",
        Unit::Number,
        RATIO,
        |m| &m.overrides.feed_by_line,
        |m| &mut m.overrides.feed_by_line,
    ),
    by_line(
        "override.rapid_by_line",
        "Rapid override by line",
        "Factor on the rapid feedrate from a line on, until another line has another one: for example L412 = 0.25; L901 = 1.",
        Unit::Number,
        RATIO,
        |m| &m.overrides.rapid_by_line,
        |m| &mut m.overrides.rapid_by_line,
    ),
    by_line(
        "halts.waits",
        "Waits before lines",
        "Seconds that the machine stands before a line of the program: for example L64 = 2.7.",
        Unit::Second,
        SECONDS,
        |m| &m.halts.waits,
        |m| &mut m.halts.waits,
    ),
    by_line(
        "halts.feed_holds",
        "Feed holds",
        "Seconds that the command is held in the middle of a line of the program: for example L472 = 3.",
        Unit::Second,
        SECONDS,
        |m| &m.halts.feed_holds,
        |m| &mut m.halts.feed_holds,
    ),
    by_line(
        "halts.feed_hold_places",
        "Places of feed holds",
        "Part of the line's path that is run before its feed hold, 0 to 1: for example L472 = 0.4; half where none is given.",
        Unit::Number,
        (0.0, 1.0),
        |m| &m.halts.feed_hold_places,
        |m| &mut m.halts.feed_hold_places,
    ),
    Parameter {
        key: "halts.in_position_s",
        label: "Wait for position",
        doc: "Time at each full stop that motion makes by itself, until the axes are in position; 0: none.",
        access: number(
            Unit::Second,
            (0.0, 60.0),
            |m| Some(m.halts.in_position),
            |m, v| m.halts.in_position = v.unwrap_or(0.0),
        ),
    },
    Parameter {
        key: "halts.in_position_at",
        label: "Position is waited for at",
        doc: "rapid ends: every rapid ends in a full stop with the wait; exact stops: those of the program and of sharp corners; both.",
        access: Access::Choice {
            words: &[InPosition::WORDS[0].0, InPosition::WORDS[1].0, InPosition::WORDS[2].0],
            get: |m| m.halts.in_position_at.word(),
            set: |m, v| {
                if let Some(at) = choice_of(&InPosition::WORDS, v) {
                    m.halts.in_position_at = at;
                }
            },
        },
    },
];
