//! Rows of halts and of overrides by line: findings of a diagnosis.

use std::collections::BTreeMap;

use crate::machine::keyword::variant_of;
use crate::machine::parameter::{Access, Parameter, row};
use crate::machine::{InPosition, Machine};
use crate::units::Unit;

/// Bounds of a halt, s: up to an hour.
const HALT_BOUNDS_S: (f64, f64) = (0.0, 3600.0);

/// Bounds of the ratio of an override.
const OVERRIDE_BOUNDS: (f64, f64) = (0.01, 10.0);

/// Returns the row of a table of values by line of the program.
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
        "Factor on programmed feedrates, from a line up to the next one listed: for example L412 = 0.78; L901 = 1.",
        Unit::Number,
        OVERRIDE_BOUNDS,
        |m| &m.overrides.feed_by_line,
        |m| &mut m.overrides.feed_by_line,
    ),
    by_line(
        "override.rapid_by_line",
        "Rapid override by line",
        "Factor on the rapid feedrate, from a line up to the next one listed: for example L412 = 0.25; L901 = 1.",
        Unit::Number,
        OVERRIDE_BOUNDS,
        |m| &m.overrides.rapid_by_line,
        |m| &mut m.overrides.rapid_by_line,
    ),
    by_line(
        "halts.waits",
        "Waits before lines",
        "Seconds that the machine waits before a line of the program: for example L64 = 2.7.",
        Unit::Second,
        HALT_BOUNDS_S,
        |m| &m.halts.waits,
        |m| &mut m.halts.waits,
    ),
    by_line(
        "halts.feed_holds",
        "Feed holds",
        "Seconds of a feed hold within a line of the program: for example L472 = 3.",
        Unit::Second,
        HALT_BOUNDS_S,
        |m| &m.halts.feed_holds,
        |m| &mut m.halts.feed_holds,
    ),
    by_line(
        "halts.feed_hold_places",
        "Places of feed holds",
        "Place of a feed hold as a part of its line's path, 0 to 1: for example L472 = 0.4. Without a value: half.",
        Unit::Number,
        (0.0, 1.0),
        |m| &m.halts.feed_hold_places,
        |m| &mut m.halts.feed_hold_places,
    ),
    row!("halts.in_position_s", "Wait for position", value Second (0.0, 60.0) [halts.in_position] or 0.0,
        "Time at each full stop of the motion until the axes are in position. 0: none."),
    Parameter {
        key: "halts.in_position_at",
        label: "Waits for position at",
        doc: "rapid ends: every rapid ends in a full stop with the wait; exact stops: those of the program and of sharp corners; both.",
        access: Access::Choice {
            words: &[InPosition::WORDS[0].0, InPosition::WORDS[1].0, InPosition::WORDS[2].0],
            get: |m| m.halts.in_position_at.word(),
            set: |m, v| {
                if let Some(at) = variant_of(&InPosition::WORDS, v) {
                    m.halts.in_position_at = at;
                }
            },
        },
    },
];
