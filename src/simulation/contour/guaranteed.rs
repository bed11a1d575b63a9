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
//! Only what lies within a filter delay of a change is measured again.

use crate::machine::{CornerMode, Machine};
use crate::simulation::contour::{ContourErrors, contour_errors, measure, stretches};
use crate::simulation::feed::{FeedPlan, Rule, plan};
use crate::simulation::profile::Profile;
use crate::simulation::toolpath::{Curve, Toolpath};

/// p above.
const STEP: f64 = 0.7;

/// Rounds in which feedrates may rise.
const ROUNDS: usize = 12;

/// Rounds in which they only fall, before what still misses is taken at a stop.
const REDUCTIONS: usize = 40;

/// An error this close below the tolerance, as a part of it, is left as it is.
const CLOSE_ENOUGH: f64 = 0.01;

/// Reductions aim this far below the tolerance, as a part of it, so that they end.
const MARGIN: f64 = 0.005;

/// The plan of a toolpath that holds a contour tolerance (mm) in the machine's corner mode, and
/// the contour errors of its profile.
pub fn plan_within(toolpath: &Toolpath, machine: &Machine, tolerance: f64) -> (FeedPlan, ContourErrors) {
    let isolated = plan(toolpath, machine, Rule::Isolated(tolerance));
    let errors = contour_errors(toolpath, &isolated, &Profile::new(toolpath, &isolated));
    match machine.interpolator.corner_mode {
        CornerMode::Paper => (isolated, errors),
        CornerMode::Guaranteed => corrected(toolpath, machine, tolerance, isolated, errors),
    }
}

/// What a round may do to a feedrate.
#[derive(Clone, Copy)]
enum Round {
    UpAndDown,
    Down,
    Stop,
}

impl Round {
    fn of(number: usize) -> Round {
        match number {
            _ if number < ROUNDS => Round::UpAndDown,
            _ if number < ROUNDS + REDUCTIONS => Round::Down,
            _ => Round::Stop,
        }
    }

    /// The factor on a feedrate whose error is `error` times the tolerance; none leaves it.
    fn factor(self, error: f64) -> Option<f64> {
        let miss = (1.0 - MARGIN) / error;
        match self {
            Round::UpAndDown if (1.0 - CLOSE_ENOUGH..=1.0).contains(&error) => None,
            Round::UpAndDown => Some(miss.powf(STEP).clamp(0.25, 2.0)),
            _ if error <= 1.0 => None,
            Round::Down => Some(miss.powf(STEP).max(0.25)),
            Round::Stop => Some(0.0),
        }
    }
}

/// A feedrate that is asked for, and the one that other limits leave of it, mm/s.
fn changed(asked: &mut f64, planned: f64, error: f64, ceiling: f64, round: Round) -> bool {
    let Some(factor) = round.factor(error) else { return false };
    // Raising what another limit holds down would change nothing.
    let held = planned < *asked * (1.0 - 1e-9) || ceiling <= planned;
    if 1.0 <= factor && held {
        return false;
    }
    *asked = (planned * factor).min(ceiling);
    true
}

fn corrected(
    toolpath: &Toolpath,
    machine: &Machine,
    tolerance: f64,
    mut now: FeedPlan,
    mut errors: ContourErrors,
) -> (FeedPlan, ContourErrors) {
    let count = toolpath.segments.len();
    let is_arc = |segment: usize| toolpath.segments[segment].curve != Curve::Line;
    let mut corners = now.corner_feedrates.clone();
    let mut segments = now.segment_feedrates.clone();
    (0..count).filter(|&k| !is_arc(k)).for_each(|k| segments[k] = f64::INFINITY);
    for round in (0..ROUNDS + REDUCTIONS + 1).map(Round::of) {
        let mut moved = vec![false; count];
        for k in 0..count {
            if is_arc(k) {
                let (planned, error) = (now.segment_feedrates[k], errors.arc[k] / tolerance);
                // An arc cannot be run at no feedrate at all; it ends between two stops instead.
                let slowest = 1e-3 * planned;
                moved[k] |= changed(&mut segments[k], planned, error, f64::INFINITY, round);
                segments[k] = segments[k].max(slowest);
            }
            if 0.0 < now.corner_feedrates[k] {
                let slower = now.segment_feedrates[k].min(now.segment_feedrates[k + 1]);
                let (planned, error) = (now.corner_feedrates[k], errors.corner[k] / tolerance);
                moved[k] |= changed(&mut corners[k], planned, error, slower, round);
            }
        }
        if !moved.contains(&true) {
            if errors.largest() <= tolerance {
                break;
            }
            continue;
        }
        now = plan(toolpath, machine, Rule::Given { corners: &corners, segments: &segments });
        let stale = within_a_delay(&now, &moved);
        measure(toolpath, &now, &Profile::new(toolpath, &now), &mut errors, |k| stale[k]);
    }
    (now, errors)
}

/// The segments of which a part is commanded within a filter delay of a segment that moved.
fn within_a_delay(plan: &FeedPlan, moved: &[bool]) -> Vec<bool> {
    let mut stale = moved.to_vec();
    for stretch in stretches(plan) {
        let delay = plan.filters[stretch.filter].delay();
        let mut spread = |pulses: &mut dyn Iterator<Item = usize>| {
            let mut age = f64::INFINITY;
            for index in pulses {
                let pulse = &plan.pulses[index];
                let segment = pulse.segment as usize;
                // A segment is reached by its corner, so one more on each side belongs to it.
                if age <= delay {
                    stale[segment] = true;
                }
                age = if moved[segment] { 0.0 } else { age + pulse.duration };
            }
        };
        spread(&mut stretch.pulses.clone());
        spread(&mut stretch.pulses.clone().rev());
    }
    stale
}
