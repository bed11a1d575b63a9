//! Laws that a machine may follow and its file does not name: each is offered to the runs, and kept only if it
//! lowers the cost by a wide margin.
//!
//! | law | parameter | first guesses |
//! |---|---|---|
//! | rapids have separate filters | `rapid.time_constant_s` | ratios to that of feed moves |
//! | rapids run from standstill to standstill | `rapid.positioning_jerk_mm_s3` | jerks with the rapid feedrate of the machine file |
//! | ramps grow with the speed step | `path.jerk_mm_s3` | as in `effects`, with the same filters and shorter ones |
//! | arcs are followed by a separate tolerance | `interpolator.arc_tolerance_mm` | ratios to the contour tolerance |
//! | arcs have a centripetal acceleration | `path.centripetal_acceleration_mm_s2` | accelerations with `NO_TOLERANCE` |
//! | a word waits for the spindle | `times.spindle_awaited_by`, ramp and exponent | as in `spindle` |
//!
//! A law is fitted from the best of its first guesses even if all of them are worse than no law: the filters become
//! shorter with a law, which a guess does not include. The first two laws exclude each other, and so do the two of
//! arcs.

use crate::identification::calibration::spindle;
use crate::identification::effects::{self, parameters};
use crate::identification::fit::Run;
use crate::machine::{Machine, TimeConstants};
use crate::simulation::toolpath::Curve;

/// Least decrease of the cost for which another law is taken.
pub const MIN_LAW_COST_DROP: f64 = 15.0;
/// Least decrease of the cost for which another law is taken, as a part of the cost.
pub const MIN_LAW_COST_DROP_RATIO: f64 = 0.01;
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
    let filtered = parameters::RAPID_TIME_CONSTANT.guesses.iter().map(|ratio| {
        let mut machine = found.clone();
        machine.rapid.time_constants = Some(TimeConstants::Equal(ratio * constant));
        machine
    });
    let mut unfiltered = found.clone();
    // What filters needed for the time of rapids says nothing of the rate here.
    unfiltered.rapid.feedrate = before.rapid.feedrate;
    vec![filtered.collect(), parameters::POSITIONING_JERK.guesses_on(&unfiltered)]
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
    let with = |tolerance: f64| {
        let mut machine = found.clone();
        machine.interpolator.arc_tolerance = Some(tolerance);
        machine
    };
    let own = found.interpolator.contour_tolerance;
    let mut laws = vec![parameters::ARC_TOLERANCE.guesses.iter().map(|ratio| with(ratio * own)).collect()];
    if found.path.centripetal_acceleration.is_infinite() {
        laws.push(parameters::CENTRIPETAL_ACCELERATION.guesses_on(&with(NO_TOLERANCE)));
    }
    laws
}
