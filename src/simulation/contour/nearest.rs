//! The search for the moment at which the filtered path is nearest to a programmed point.
//!
//! The search begins half a filter delay after the point X was commanded. Its first step leads to where the distance
//! would be least if the path continued straight, each further step to where it would be least if the path
//! bent as between the last two steps. Once a step passes the nearest moment, regula falsi narrows the
//! bracket around it. The search stays within the delay, so that it cannot find another pass over the same
//! place.

use crate::simulation::profile::{MotionState, RememberedSteps};
use crate::simulation::toolpath::{Point, Segment};

/// The search for the nearest moment ends when a step gains no more than this part of the square of the
/// distance.
const MIN_SEARCH_GAIN: f64 = 1e-9;
/// Most steps of that search.
const MAX_SEARCH_STEPS: usize = 30;

/// Returns the distance (mm) of the filtered path from a point that was commanded at `commanded` (s since the
/// beginning of the motion), no earlier than the pulse `pulse`.
pub(super) fn distance_from_path(
    steps: &mut RememberedSteps,
    point: Point,
    commanded: f64,
    pulse: usize,
) -> f64 {
    let moment = steps.cursor.moment_from(pulse, commanded + steps.cursor.motion.filter().half_delay());
    let state = steps.state(moment);
    nearest(steps, point, commanded, pulse, state, 0.0)
}

/// Returns the distance (mm) of the filtered path from a point, given the state half a filter delay later; if
/// it is at most `enough`, any value up to that.
pub(super) fn nearest(
    steps: &mut RememberedSteps,
    point: Point,
    commanded: f64,
    pulse: usize,
    mut state: MotionState,
    enough: f64,
) -> f64 {
    let delay = steps.cursor.motion.filter().delay();
    let mut time = commanded + 0.5 * delay;
    let mut nearest = f64::INFINITY;
    // Moments before and after the nearest one, with (P − X)·Ṗ once that is known.
    let (mut before, mut after) = ((commanded, f64::NAN), (commanded + delay, f64::NAN));
    let mut was_before = None;
    let mut last: Option<(f64, f64)> = None;
    for step in 1..=MAX_SEARCH_STEPS {
        let away = state.position - point;
        nearest = nearest.min(away.norm());
        if nearest <= enough || step == MAX_SEARCH_STEPS {
            break;
        }
        let receding = away.dot(&state.velocity);
        // The weight of an end that stays is halved, so that it does not stay forever.
        let is_before = receding < 0.0;
        let stays = was_before.replace(is_before) == Some(is_before);
        if is_before {
            before = (time, receding);
            after.1 *= if stays { 0.5 } else { 1.0 };
        } else {
            after = (time, receding);
            before.1 *= if stays { 0.5 } else { 1.0 };
        }
        let between = before.0 + (after.0 - before.0) * before.1 / (before.1 - after.1);
        // The slope of (P − X)·Ṗ: from the last step, or as if the path were straight.
        let grown = last.replace((time, receding)).map(|(then, was)| (receding - was) / (time - then));
        let slope = grown.filter(|slope| 0.0 < *slope).unwrap_or(state.velocity.norm_squared());
        let straight = time - receding / slope;
        let next = if between.is_nan() { straight } else { between }.clamp(before.0, after.0);
        // A step reduces the square of the distance by its length times its slope.
        let gain = (receding * (next - time)).abs();
        if gain.is_nan() || gain <= MIN_SEARCH_GAIN * nearest * nearest {
            break;
        }
        time = next;
        let moment = steps.cursor.moment_from(pulse, time);
        state = steps.state(moment);
    }
    nearest
}

/// Returns the distance (mm) of a point from a segment near the distance `s` (mm) along it.
pub(super) fn distance_from_segment(segment: &Segment, mut s: f64, point: Point) -> f64 {
    let mut away = segment.point(s) - point;
    // Newton's method for the foot of the perpendicular; on a line one step is exact. Where an arc bends more than
    // it is long, a step may lead away.
    for _ in 0..4 {
        let [tangent, curvature, _] = segment.derivatives(s);
        let change = tangent.norm_squared() + away.dot(&curvature);
        let next = (s - away.dot(&tangent) / change).clamp(0.0, segment.length);
        let next_away = segment.point(next) - point;
        let is_nearer = 0.0 < change && next_away.norm_squared() < away.norm_squared();
        if !is_nearer {
            break;
        }
        (s, away) = (next, next_away);
    }
    away.norm()
}
