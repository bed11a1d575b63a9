//! The plan that keeps the contour tolerance everywhere, and is hardly slower than necessary.
//!
//! The isolated law considers one corner. If several corners lie within one filter delay, the filtered path
//! may leave the programmed one by more than the tolerance (their deviations add up), or by less (the law is
//! too cautious). The plan is therefore corrected by its contour error e, measured at each corner and arc:
//!
//! ```text
//! c ← c (ε / e)^p
//! ```
//!
//! where c is the command at the corner, or along the arc, and ε the tolerance. At an isolated corner e ∝ c,
//! on a fine polyline, as on an arc, e ∝ c²: with p = 0.7 each round multiplies the remaining misfit by 0.3
//! or −0.4, so that it converges.
//!
//! After some rounds feedrates are only reduced, until no error is above ε. The reductions end, because a
//! corner at c = 0 holds the command for a whole filter delay, and then e = 0: an exact stop. Only segments
//! within a filter delay of a change are measured again. A corner may be reduced too much if a neighbour
//! caused its error, so the rounds are repeated from their result while that makes the program faster; the
//! fastest plan within tolerance is the result.
//!
//! Errors are measured at programmed points. If the filtered path is nevertheless too far from the lines
//! between them, as [`off_path_spans`] finds, the tolerance of the corners there is reduced, and the
//! correction is repeated.

use crate::machine::Machine;
use crate::simulation::contour::off_path::{OffPathSpan, off_path_spans};
use crate::simulation::contour::{ContourErrors, SegmentErrors, measure};
use crate::simulation::feed::{CornerPolicy, FeedPlan, Pulse, ToleranceBound, Tolerances, command};
use crate::simulation::profile::Profile;
use crate::simulation::toolpath::{Curve, Toolpath};
use std::collections::BTreeMap;

/// Exponent p.
const STEP_EXPONENT: f64 = 0.7;

/// Most passes, each of which undoes reductions that were too large.
const MAX_PASSES: usize = 4;

/// A pass that gains less than this part of the cycle time is the last.
const MIN_PASS_GAIN: f64 = 1e-3;

/// Least factor on the feedrate of an arc in one round.
const MIN_ARC_FACTOR: f64 = 1e-3;

/// Number of rounds in which feedrates may rise.
const FREE_ROUNDS: usize = 12;

/// Number of rounds in which feedrates only fall; corners that then still exceed the tolerance become stops.
const REDUCTION_ROUNDS: usize = 40;

/// Number of rounds in which corners become stops; a stop may reveal that a neighbour exceeds the tolerance.
const STOP_ROUNDS: usize = 50;

/// An error this close below the tolerance, as a part of it, is not corrected.
const MAX_UNUSED_TOLERANCE: f64 = 0.01;

/// Reductions aim this far below the tolerance, as a part of it, so that they end.
const REDUCTION_MARGIN: f64 = 0.005;

/// Part of the tolerance by which an error may exceed it through rounding, as an isolated corner uses the
/// whole tolerance.
const ERROR_ROUNDING_RATIO: f64 = 1e-9;

/// Most repetitions for filtered paths that stray between corners. Of 4,000 hostile paths one strayed, by a
/// quarter of the tolerance.
const MAX_OFF_PATH_PASSES: usize = 8;

/// Part of the remaining work by which a round advances the progress: the number of rounds is not known in
/// advance.
const ROUND_PROGRESS_SHARE: f64 = 0.05;

/// The change of feedrates in one round.
#[derive(Clone, Copy)]
enum RoundKind {
    UpAndDown,
    Down,
    Stop,
}

impl RoundKind {
    fn of(number: usize) -> RoundKind {
        match number {
            _ if number < FREE_ROUNDS => RoundKind::UpAndDown,
            _ if number < FREE_ROUNDS + REDUCTION_ROUNDS => RoundKind::Down,
            _ => RoundKind::Stop,
        }
    }

    /// Returns the factor on a feedrate whose error is `error` times the tolerance; `None` leaves it
    /// unchanged.
    fn factor(self, error: f64) -> Option<f64> {
        let miss = (1.0 - REDUCTION_MARGIN) / error;
        match self {
            RoundKind::UpAndDown if (1.0 - MAX_UNUSED_TOLERANCE..=1.0).contains(&error) => None,
            RoundKind::UpAndDown => Some(miss.powf(STEP_EXPONENT).clamp(0.25, 2.0)),
            _ if error <= 1.0 => None,
            RoundKind::Down => Some(miss.powf(STEP_EXPONENT).max(0.25)),
            RoundKind::Stop => Some(0.0),
        }
    }
}

/// Part of the tolerance that is allowed on an arc and at its corners, to cover deviations between the
/// measured points.
const ARC_TOLERANCE_RATIO: f64 = 0.99;

/// Changes a requested feedrate by the error that it causes; `planned` is the feedrate under all limits, and
/// `ceiling` the largest known to be possible, all mm/s. Returns `false` if it does not change.
fn changed(requested: &mut f64, planned: f64, error: f64, ceiling: f64, round: RoundKind) -> bool {
    let Some(factor) = round.factor(error) else { return false };
    // Raising a feedrate has no effect if another limit already keeps the command below it.
    let held = planned < *requested * (1.0 - 1e-9) || ceiling <= planned;
    if 1.0 <= factor && held {
        return false;
    }
    *requested = (planned * factor).min(ceiling);
    true
}

/// Returns the fastest plan of all passes that keeps the contour tolerances everywhere, with its contour
/// errors. Begins with `isolated`, the command by the isolated law. Calls `progress` before each round with
/// the completed fraction, which stays below 1.
pub(crate) fn guaranteed(
    toolpath: &Toolpath,
    machine: &Machine,
    tolerances: Tolerances,
    isolated: FeedPlan,
    progress: &mut dyn FnMut(f64),
) -> (FeedPlan, ContourErrors) {
    let mut requested = RequestedFeedrates::of(toolpath, &isolated);
    let mut now = isolated;
    let mut measured = vec![SegmentErrors::default(); toolpath.segments.len()];
    measure(toolpath, &now, &Profile::new(toolpath, &now), |_| true, |k, found| measured[k] = found);
    let mut errors = ContourErrors::by_corner(&measured);
    let mut shares = ToleranceShares::default();
    let bounds = || tolerances.bounds(toolpath, machine);
    let holds = |errors: &ContourErrors, shares: &ToleranceShares| {
        errors.beyond(shares.of(bounds()), 1.0 + ERROR_ROUNDING_RATIO).next().is_none()
    };
    let allowed: Vec<f64> = bounds().map(|bound| bound.along.max(bound.near)).collect();
    let off_path = |plan: &FeedPlan| off_path_spans(toolpath, plan, &Profile::new(toolpath, plan), &allowed);
    // If the plan by the isolated law keeps the tolerance everywhere, a correction must be faster.
    let mut fastest = (holds(&errors, &shares) && off_path(&now).is_empty())
        .then(|| (now.cycle_time(), now.clone(), errors.clone()));
    // If the path still strays after all repetitions, no programmed point is beyond the tolerance.
    let mut at_points = None;
    let mut rest = 1.0;
    let (mut passes, mut strayings) = (0, 0);
    while passes < MAX_PASSES && strayings < MAX_OFF_PATH_PASSES {
        for round in (0..FREE_ROUNDS + REDUCTION_ROUNDS + STOP_ROUNDS).map(RoundKind::of) {
            progress(1.0 - rest);
            rest *= 1.0 - ROUND_PROGRESS_SHARE;
            if requested.change(&now, &errors, shares.of(bounds()), round) {
                let given =
                    CornerPolicy::Given { corners: &requested.corners, segments: &requested.segments };
                let next = command(toolpath, machine, given);
                let stale = within_a_delay(&now, &next);
                now = next;
                let profile = Profile::new(toolpath, &now);
                measure(toolpath, &now, &profile, |k| stale[k], |k, found| measured[k] = found);
                errors = ContourErrors::by_corner(&measured);
            } else if holds(&errors, &shares) {
                break;
            }
        }
        let off_path = off_path(&now);
        if !off_path.is_empty() {
            if at_points.is_none() && holds(&errors, &shares) {
                at_points = Some((now.clone(), errors.clone()));
            }
            shares.lower(&off_path);
            strayings += 1;
            continue;
        }
        passes += 1;
        let time = now.cycle_time();
        let before = fastest.as_ref().map_or(f64::INFINITY, |(time, ..)| *time);
        if holds(&errors, &shares) && time < before {
            fastest = Some((time, now.clone(), errors.clone()));
        }
        if before < time * (1.0 + MIN_PASS_GAIN) {
            break;
        }
    }
    let fastest = fastest.map(|(_, plan, errors)| (plan, errors));
    fastest.or(at_points).unwrap_or((now, errors))
}

/// The part of its tolerance that each segment may use, reduced where the filtered path strays between
/// corners.
#[derive(Default)]
struct ToleranceShares(BTreeMap<usize, f64>);

impl ToleranceShares {
    /// Returns the bounds reduced by these parts.
    fn of(&self, bounds: impl Iterator<Item = ToleranceBound>) -> impl Iterator<Item = ToleranceBound> {
        bounds.enumerate().map(|(k, bound)| match self.0.get(&k) {
            None => bound,
            Some(share) => ToleranceBound {
                along: share * bound.along,
                corner: share * bound.corner,
                near: share * bound.near,
            },
        })
    }

    /// Lowers the parts of the segments where the path strays, each by the largest deviation there.
    fn lower(&mut self, off_path: &[OffPathSpan]) {
        let mut ratios = BTreeMap::new();
        for span in off_path {
            for segment in span.segments.clone() {
                let ratio = ratios.entry(segment).or_insert(span.ratio);
                *ratio = span.ratio.max(*ratio);
            }
        }
        for (segment, ratio) in ratios {
            *self.0.entry(segment).or_insert(1.0) *= (1.0 - REDUCTION_MARGIN) / ratio;
        }
    }
}

/// The feedrates that the next plan requests, mm/s.
struct RequestedFeedrates {
    corners: Vec<f64>,
    segments: Vec<f64>,
    is_arc: Vec<bool>,
}

impl RequestedFeedrates {
    fn of(toolpath: &Toolpath, plan: &FeedPlan) -> RequestedFeedrates {
        let is_arc: Vec<bool> =
            toolpath.segments.iter().map(|segment| segment.curve != Curve::Line).collect();
        let along = |(feedrate, is_arc): (&f64, &bool)| if *is_arc { *feedrate } else { f64::INFINITY };
        let segments = plan.segment_feedrates.iter().zip(&is_arc).map(along).collect();
        RequestedFeedrates { corners: plan.corner_feedrates.clone(), segments, is_arc }
    }

    /// Runs one round: changes feedrates by the errors of the current plan; returns `false` if nothing
    /// changes.
    fn change(
        &mut self,
        now: &FeedPlan,
        errors: &ContourErrors,
        bounds: impl Iterator<Item = ToleranceBound>,
        round: RoundKind,
    ) -> bool {
        let mut moved = false;
        for (k, ToleranceBound { along, corner, near }) in bounds.enumerate() {
            if self.is_arc[k] {
                let (planned, error) =
                    (now.segment_feedrates[k], errors.along(k) / (ARC_TOLERANCE_RATIO * along));
                // An arc cannot be run at feedrate 0; it ends between two stops instead.
                let slowest = MIN_ARC_FACTOR * planned;
                moved |= changed(&mut self.segments[k], planned, error, f64::INFINITY, round);
                self.segments[k] = self.segments[k].max(slowest);
                // The corners at the ends of an arc may cause its error.
                if 1.0 < error && !matches!(round, RoundKind::UpAndDown) {
                    for corner in [k.checked_sub(1), Some(k)].into_iter().flatten() {
                        let planned = now.corner_feedrates[corner];
                        moved |= changed(&mut self.corners[corner], planned, error, planned, round);
                    }
                }
            }
            let is_beside_arc = self.is_arc[k] || self.is_arc.get(k + 1).is_some_and(|&is_arc| is_arc);
            let share = if is_beside_arc { ARC_TOLERANCE_RATIO } else { 1.0 };
            let error = (errors.at_point(k) / (share * corner)).max(errors.corner[k] / (share * near));
            if 0.0 < now.corner_feedrates[k] {
                let slower = now.segment_feedrates[k].min(now.segment_feedrates[k + 1]);
                let planned = now.corner_feedrates[k];
                moved |= changed(&mut self.corners[k], planned, error, slower, round);
            } else if 1.0 < error && matches!(round, RoundKind::Stop) {
                // The error at a stop comes from a neighbour, whose tolerance may be larger.
                for corner in [k.checked_sub(1), Some(k + 1)].into_iter().flatten() {
                    let planned = now.corner_feedrates.get(corner).copied().unwrap_or(0.0);
                    if 0.0 < planned {
                        moved |= changed(&mut self.corners[corner], planned, error, planned, round);
                    }
                }
            }
        }
        moved
    }
}

/// Returns `true` for each segment of which any part is commanded within a filter delay of a segment whose
/// pulses differ between two plans. The filtered motion of all other segments is the same in both.
fn within_a_delay(before: &FeedPlan, after: &FeedPlan) -> Vec<bool> {
    fn by_segment(plan: &FeedPlan) -> impl Iterator<Item = impl Iterator<Item = Pulse>> {
        let pulses = &plan.pulses;
        pulses.by_segment(0..pulses.len()).map(|own| pulses.range(own))
    }
    let moved: Vec<bool> =
        by_segment(before).zip(by_segment(after)).map(|(before, after)| before.ne(after)).collect();
    let mut stale = moved.clone();
    for rest_to_rest in after.rest_to_rest_motions() {
        let delay = after.filters[rest_to_rest.filter].delay();
        let mut spread = |pulses: &mut dyn Iterator<Item = usize>| {
            let mut age = f64::INFINITY;
            for index in pulses {
                let segment = after.pulses.segment(index);
                stale[segment] |= age <= delay;
                age = if moved[segment] { 0.0 } else { age + after.pulses.duration(index) };
            }
        };
        spread(&mut rest_to_rest.pulses.clone());
        spread(&mut rest_to_rest.pulses.clone().rev());
    }
    stale
}
