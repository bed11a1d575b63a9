//! Rows of halts and of overrides by line: findings of a diagnosis.

use crate::machine::InPosition;
use crate::machine::parameter::{Parameter, row};

/// Bounds of a halt, s: up to an hour.
const HALT_BOUNDS_S: (f64, f64) = (0.0, 3600.0);

/// Bounds of the ratio of an override.
const OVERRIDE_BOUNDS: (f64, f64) = (0.01, 10.0);

/// The rows; tables are by line of the program.
pub(super) const HALTS: [Parameter; 7] = [
    row!("override.feed_by_line", "Feed override by line", codes 'L' Number OVERRIDE_BOUNDS [overrides.feed_by_line],
        "Factor on programmed feedrates, from a line up to the next one listed: for example L412 = 0.78; L901 = 1."),
    row!("override.rapid_by_line", "Rapid override by line", codes 'L' Number OVERRIDE_BOUNDS [overrides.rapid_by_line],
        "Factor on the rapid feedrate, from a line up to the next one listed: for example L412 = 0.25; L901 = 1."),
    row!("halts.waits", "Waits before lines", codes 'L' Second HALT_BOUNDS_S [halts.waits],
        "Seconds that the machine waits before a line of the program: for example L64 = 2.7."),
    row!("halts.feed_holds", "Feed holds", codes 'L' Second HALT_BOUNDS_S [halts.feed_holds],
        "Seconds of a feed hold within a line of the program: for example L472 = 3."),
    row!("halts.feed_hold_places", "Places of feed holds", codes 'L' Number (0.0, 1.0) [halts.feed_hold_places],
        "Place of a feed hold as a part of its line's path, 0 to 1: for example L472 = 0.4. Without a value: half."),
    row!("halts.in_position_s", "Wait for position", value Second (0.0, 60.0) [halts.in_position] or 0.0,
        "Time at each full stop of the motion until the axes are in position. 0: none."),
    row!("halts.in_position_at", "Waits for position at", choice InPosition [halts.in_position_at],
        "rapid ends: every rapid ends in a full stop with the wait; exact stops: the stops of the program and of sharp corners; both."),
];
