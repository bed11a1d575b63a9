//! Laws that a machine may follow and its file does not name: each is offered to the runs, and kept only if it
//! lowers the cost by a wide margin.
//!
//! | law | parameter | first guesses |
//! |---|---|---|
//! | rapids have separate filters | `rapid.time_constant_s` | twice that of feed moves |
//! | rapids run from standstill to standstill | `rapid.positioning_jerk_mm_s3` | as in `effects` |
//! | ramps grow with the speed step | `path.jerk_mm_s3` | as in `effects`, with the same filters and shorter ones |
//! | arcs are followed by a separate tolerance | `interpolator.arc_tolerance_mm` | `ARCS` of the contour tolerance |
//! | arcs have a centripetal acceleration | `path.centripetal_acceleration_mm_s2` | `CENTRIPETAL` with `NO_TOLERANCE` |
//! | a word waits for the spindle | `times.spindle_awaited_by`, ramp and exponent | as in `spindle` |
//!
//! A law is fitted from the best of its first guesses even if all of them are worse than no law: the filters become
//! shorter with a law, which a guess does not include. The first two laws exclude each other, and so do the two of
//! arcs.

use crate::identification::calibration::spindle;
use crate::identification::effects::{self, POSITIONING_JERKS_MM_S3};
use crate::identification::fit::Run;
use crate::machine::{Machine, TimeConstants};
use crate::simulation::toolpath::Curve;

/// Least decrease of the cost for which another law is taken.
pub const MIN_LAW_COST_DROP: f64 = 15.0;
/// Least decrease of the cost for which another law is taken, as a part of the cost.
pub const MIN_LAW_COST_DROP_RATIO: f64 = 0.01;
/// Ratio of the time constant of rapid moves to that of feed moves, tried first.
const RAPID_SLOWER: f64 = 2.0;
/// Tolerances of arcs tried first, as ratios to that of corners.
const ARCS: [f64; 3] = [0.3, 3.0, 30.0];

/// Centripetal accelerations tried first, mm/s².
const CENTRIPETAL: [f64; 6] = [100.0, 200.0, 400.0, 800.0, 1600.0, 3200.0];
/// Tolerance of arcs so wide that only the centripetal acceleration limits their feedrate, mm.
const NO_TOLERANCE: f64 = 1.0;

/// The machines from which the fit of one law begins.
pub type Law = Vec<Machine>;

/// A function that returns the laws of one choice, given the machine before the calibration, the machine fitted so
/// far, and the runs.
pub type Choice = fn(&Machine, &Machine, &[Run]) -> Vec<Law>;

/// The choices, made one after another: of each the best law is kept, or none.
pub const CHOICES: [Choice; 4] = [spindles, rapids, ramps, arcs];

/// Returns the law of words that wait for the spindle.
fn spindles(_: &Machine, found: &Machine, runs: &[Run]) -> Vec<Law> {
    let guesses = spindle::guesses(found, runs);
    if guesses.is_empty() { Vec::new() } else { vec![guesses] }
}

/// Returns the laws of the ramps of rapids.
fn rapids(before: &Machine, found: &Machine, runs: &[Run]) -> Vec<Law> {
    let TimeConstants::Equal(constant) = found.interpolator.time_constants else { return Vec::new() };
    let is_named = found.rapid.time_constants.is_some() || found.rapid.positioning_jerk.is_finite();
    if is_named || !found.has_filters() || !runs.iter().any(Run::has_rapid) {
        return Vec::new();
    }
    let mut own = found.clone();
    own.rapid.time_constants = Some(TimeConstants::Equal(RAPID_SLOWER * constant));
    let positioned = POSITIONING_JERKS_MM_S3.map(|jerk| {
        let mut machine = found.clone();
        machine.rapid.positioning_jerk = jerk;
        // What filters needed for the time of rapids says nothing of the rate here.
        machine.rapid.feedrate = before.rapid.feedrate;
        machine
    });
    vec![vec![own], positioned.to_vec()]
}

/// Returns the law of the ramps of the feedrate.
fn ramps(_: &Machine, found: &Machine, _: &[Run]) -> Vec<Law> {
    if found.path.jerk.is_finite() || !found.has_filters() {
        return Vec::new();
    }
    let law = effects::ramps(found);
    vec![law.iter().flat_map(|law| law.trials.iter().map(|values| law.machine(found, values))).collect()]
}

/// Returns the laws of the feedrate on arcs.
fn arcs(_: &Machine, found: &Machine, runs: &[Run]) -> Vec<Law> {
    let is_arc = |run: &Run| run.toolpath.segments.iter().any(|segment| segment.curve != Curve::Line);
    if found.interpolator.arc_tolerance.is_some() || !found.has_filters() || !runs.iter().any(is_arc) {
        return Vec::new();
    }
    let with = |ratio: f64| {
        let mut machine = found.clone();
        machine.interpolator.arc_tolerance = Some(ratio * machine.interpolator.contour_tolerance);
        machine
    };
    let mut laws = vec![ARCS.map(with).to_vec()];
    if found.path.centripetal_acceleration.is_infinite() {
        let limited = |acceleration: f64| {
            let mut machine = found.clone();
            machine.path.centripetal_acceleration = acceleration;
            machine.interpolator.arc_tolerance = Some(NO_TOLERANCE);
            machine
        };
        laws.push(CENTRIPETAL.map(limited).to_vec());
    }
    laws
}
