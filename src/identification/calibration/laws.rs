//! Laws that a machine may follow and its file does not name: each is offered to the runs, and kept only if
//! they are much better with it.
//!
//! | law | parameter | first guesses |
//! |---|---|---|
//! | rapids have filters of their own | `rapid.time_constant_s` | twice that of feed moves |
//! | rapids run from stand to stand | `rapid.positioning_jerk_mm_s3` | as in `effects` |
//! | ramps grow with the speed step | `path.jerk_mm_s3` | as in `effects`, with filters as they are and shorter |
//! | arcs are followed by a tolerance of their own | `interpolator.arc_tolerance_mm` | `ARCS` of the contour tolerance |
//! | arcs are run at a centripetal acceleration | `path.centripetal_acceleration_mm_s2` | `CENTRIPETAL`, the tolerance giving way |
//! | a word waits for the spindle | `times.spindle_awaited_by`, ramp and exponent | as in `spindle` |
//!
//! A law whose first guesses are all worse than none at all is still fitted from the best of them: with it the
//! filters become shorter, and that a guess does not know. The first two exclude each other, and so do
//! the two of arcs.

use crate::identification::calibration::spindle;
use crate::identification::effects::{self, POSITIONING_JERKS_MM_S3};
use crate::identification::fit::Run;
use crate::machine::{Machine, TimeConstants};
use crate::simulation::toolpath::Curve;

/// By how much, and by what part, the cost must fall for another law.
pub const BETTER: (f64, f64) = (15.0, 0.01);
/// How much slower filters of rapid moves are tried first.
const RAPID_SLOWER: f64 = 2.0;
/// Tolerances of arcs tried first, as ratios of that of corners.
const ARCS: [f64; 3] = [0.3, 3.0, 30.0];

/// Centripetal accelerations tried first, mm/s², and a tolerance of arcs that leaves it to them, mm.
const CENTRIPETAL: [f64; 6] = [100.0, 200.0, 400.0, 800.0, 1600.0, 3200.0];
const NO_TOLERANCE: f64 = 1.0;

/// Machines to begin the fit of one law from.
pub type Law = Vec<Machine>;

/// The laws of one choice, from the machine as it was, the one that fits so far, and the runs.
pub type Choice = fn(&Machine, &Machine, &[Run]) -> Vec<Law>;

/// The choices, one after another: of each the best law is kept, or none.
pub const CHOICES: [Choice; 4] = [spindles, rapids, ramps, arcs];

/// What waits for the spindle.
fn spindles(_: &Machine, found: &Machine, runs: &[Run]) -> Vec<Law> {
    let guesses = spindle::guesses(found, runs);
    if guesses.is_empty() { Vec::new() } else { vec![guesses] }
}

/// How rapids ramp.
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

/// How the feedrate changes.
fn ramps(_: &Machine, found: &Machine, _: &[Run]) -> Vec<Law> {
    if found.path.jerk.is_finite() || !found.has_filters() {
        return Vec::new();
    }
    let law = effects::ramps(found);
    vec![law.iter().flat_map(|law| law.trials.iter().map(|values| law.machine(found, values))).collect()]
}

/// How arcs are followed.
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
