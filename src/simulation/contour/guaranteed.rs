//! The plan that holds the contour tolerance everywhere, and is not slower than it needs to be.
//!
//! The isolated law knows one corner. Where several lie under one filter delay the filtered path
//! may leave the programmed one by more than the tolerance (their deviations add up), or by less
//! (the law is too cautious). So the plan is corrected by what it does: with the contour error e
//! measured at each corner and arc,
//!
//! ```text
//! c ← c (ε / e)^p
//! ```
//!
//! where c is the command at the corner, or along the arc, and ε the tolerance. An isolated
//! corner has e ∝ c, a fine polyline e ∝ c² (it is an arc): with p = 0.7 what is left of the
//! misfit shrinks by 0.3 and 0.4 a round, and neither swings.
//!
//! After some rounds only reductions are made, until no error is above ε. They end, because a
//! corner at c = 0 holds the command for a whole filter delay, and then e = 0: an exact stop.

use crate::machine::{CornerMode, Machine};
use crate::simulation::contour::{ContourErrors, contour_errors};
use crate::simulation::feed::{FeedPlan, Rule, plan};
use crate::simulation::profile::Profile;
use crate::simulation::toolpath::{Curve, Toolpath};

/// p above.
const STEP: f64 = 0.7;

/// Rounds in which feedrates may rise.
const ROUNDS: usize = 12;

/// Rounds in which they only fall, before corners that still miss are taken at an exact stop.
const REDUCTIONS: usize = 40;

/// The plan of a toolpath that holds a contour tolerance (mm) in the machine's corner mode, and
/// the contour errors of its profile.
pub fn plan_within(toolpath: &Toolpath, machine: &Machine, tolerance: f64) -> (FeedPlan, ContourErrors) {
    let isolated = plan(toolpath, machine, Rule::Isolated(tolerance));
    let errors = measured(toolpath, &isolated);
    match machine.interpolator.corner_mode {
        CornerMode::Paper => (isolated, errors),
        CornerMode::Guaranteed => corrected(toolpath, machine, tolerance, isolated, errors),
    }
}

fn measured(toolpath: &Toolpath, plan: &FeedPlan) -> ContourErrors {
    contour_errors(toolpath, plan, &Profile::new(toolpath, plan))
}

fn corrected(
    toolpath: &Toolpath,
    machine: &Machine,
    tolerance: f64,
    mut now: FeedPlan,
    mut errors: ContourErrors,
) -> (FeedPlan, ContourErrors) {
    let mut corners = now.corner_feedrates.clone();
    let mut segments: Vec<f64> = toolpath
        .segments
        .iter()
        .zip(&now.segment_feedrates)
        .map(|(segment, feedrate)| if segment.curve == Curve::Line { f64::INFINITY } else { *feedrate })
        .collect();
    for round in 0..ROUNDS + REDUCTIONS + 2 {
        let only_down = ROUNDS <= round;
        if only_down && errors.largest() <= tolerance {
            break;
        }
        let last_resort = ROUNDS + REDUCTIONS <= round;
        for i in 0..errors.error.len() {
            let ratio = tolerance / errors.error[i];
            if only_down && 1.0 <= ratio {
                continue;
            }
            // Reductions aim a little below, so that they end.
            let factor = if last_resort {
                0.0
            } else if only_down {
                (0.99 * ratio).powf(STEP).max(0.25)
            } else {
                ratio.powf(STEP).clamp(0.25, 2.0)
            };
            let segment = errors.segment[i] as usize;
            if errors.on_arc[i] {
                let floor = 1e-3 * now.segment_feedrates[segment];
                segments[segment] = (now.segment_feedrates[segment] * factor).max(floor);
            } else {
                corners[segment] = now.corner_feedrates[segment] * factor;
            }
        }
        now = plan(toolpath, machine, Rule::Given { corners: &corners, segments: &segments });
        errors = measured(toolpath, &now);
    }
    (now, errors)
}
