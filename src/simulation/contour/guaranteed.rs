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
//! Only what lies within a filter delay of a change is measured again. Reductions may take too much
//! where neighbours were to blame, so the whole is repeated from where it ended while that makes
//! the program faster, and the fastest plan within tolerance is the result.
//!
//! What is measured are programmed points. Where the filtered path is too far from the lines between them all the same, as
//! [`strays`] finds it, the corners it follows there are held to less, and the whole is gone through again.

use crate::machine::Machine;
use crate::simulation::contour::strays::{Stray, strays};
use crate::simulation::contour::{ContourErrors, SegmentErrors, measure};
use crate::simulation::feed::{Bound, FeedPlan, Pulse, Rule, Tolerances, command};
use crate::simulation::profile::Profile;
use crate::simulation::toolpath::{Curve, Toolpath};
use std::collections::BTreeMap;

/// p above.
const STEP: f64 = 0.7;

/// The whole of it is gone through this often at most, for what the reductions took too much of.
const PASSES: usize = 4;

/// A pass that gains less than this part of the cycle time is the last.
const WORTH_ANOTHER_PASS: f64 = 1e-3;

/// An arc is not slowed down below this part of its feedrate in one round.
const SLOWEST_ARC: f64 = 1e-3;

/// Rounds in which feedrates may rise.
const ROUNDS: usize = 12;

/// Rounds in which they only fall, before what still misses is taken at a stop.
const REDUCTIONS: usize = 40;

/// Rounds in which what still misses is taken at a stop; a stop may bring its neighbour to light.
const STOPS: usize = 50;

/// An error this close below the tolerance, as a part of it, is left as it is.
const CLOSE_ENOUGH: f64 = 0.01;

/// Reductions aim this far below the tolerance, as a part of it, so that they end.
const MARGIN: f64 = 0.005;

/// An isolated corner takes the tolerance exactly, but for this part of it.
const ROUNDING: f64 = 1e-9;

/// How often corners are held to less where the filtered path strays between them.
const STRAYINGS: usize = 8;

/// How much of what is left to do a round is taken for: how many it will be is not known before.
const PART_OF_REST: f64 = 0.05;

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

/// An arc and its corners are held to this part of the tolerance, for what lies between the points measured on it.
const BETWEEN_POINTS: f64 = 0.99;

/// Changes a feedrate that is asked for by the error it leads to; `planned` is what other limits
/// leave of it, and `ceiling` what is known to be the most. All in mm/s; false where it stays.
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

/// The fastest plan found, pass after pass, that holds the contour tolerances everywhere, with its contour errors.
/// It begins with `isolated`, the command by the isolated law. Before each round `progress` is called with the
/// completed fraction, from 0 up to but never reaching 1.
pub(crate) fn guaranteed(
    toolpath: &Toolpath,
    machine: &Machine,
    tolerances: Tolerances,
    isolated: FeedPlan,
    progress: &mut dyn FnMut(f64),
) -> (FeedPlan, ContourErrors) {
    let mut asked = Asked::of(toolpath, &isolated);
    let mut now = isolated;
    let mut measured = vec![SegmentErrors::default(); toolpath.segments.len()];
    measure(toolpath, &now, &Profile::new(toolpath, &now), |_| true, |k, found| measured[k] = found);
    let mut errors = ContourErrors::by_corner(&measured);
    let mut shares = Shares::default();
    let bounds = || tolerances.bounds(toolpath, machine);
    let holds = |errors: &ContourErrors, shares: &Shares| {
        errors.beyond(shares.of(bounds()), 1.0 + ROUNDING).next().is_none()
    };
    let allowed: Vec<f64> = bounds().map(|bound| bound.along.max(bound.near)).collect();
    let strays = |plan: &FeedPlan| strays(toolpath, plan, &Profile::new(toolpath, plan), &allowed);
    // Where the isolated law holds everywhere its plan is the one to beat.
    let mut fastest = (holds(&errors, &shares) && strays(&now).is_empty())
        .then(|| (now.cycle_time(), now.clone(), errors.clone()));
    // What is left where the path strays however much is taken: no programmed point is beyond tolerance.
    let mut at_points = None;
    let mut rest = 1.0;
    let (mut passes, mut strayings) = (0, 0);
    while passes < PASSES && strayings < STRAYINGS {
        for round in (0..ROUNDS + REDUCTIONS + STOPS).map(Round::of) {
            progress(1.0 - rest);
            rest *= 1.0 - PART_OF_REST;
            if asked.change(&now, &errors, shares.of(bounds()), round) {
                let given = Rule::Given { corners: &asked.corners, segments: &asked.segments };
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
        let strays = strays(&now);
        if !strays.is_empty() {
            if at_points.is_none() && holds(&errors, &shares) {
                at_points = Some((now.clone(), errors.clone()));
            }
            shares.lower(&strays);
            strayings += 1;
            continue;
        }
        passes += 1;
        let time = now.cycle_time();
        let before = fastest.as_ref().map_or(f64::INFINITY, |(time, ..)| *time);
        if holds(&errors, &shares) && time < before {
            fastest = Some((time, now.clone(), errors.clone()));
        }
        if before < time * (1.0 + WORTH_ANOTHER_PASS) {
            break;
        }
    }
    let fastest = fastest.map(|(_, plan, errors)| (plan, errors));
    fastest.or(at_points).unwrap_or((now, errors))
}

/// To which part of its tolerance a segment is held where the filtered path strays between corners.
#[derive(Default)]
struct Shares(BTreeMap<usize, f64>);

impl Shares {
    /// What holds with them.
    fn of(&self, bounds: impl Iterator<Item = Bound>) -> impl Iterator<Item = Bound> {
        bounds.enumerate().map(|(k, bound)| match self.0.get(&k) {
            None => bound,
            Some(share) => {
                Bound { along: share * bound.along, corner: share * bound.corner, near: share * bound.near }
            }
        })
    }

    /// Holds the segments where the path strays to less, each by how far it does at most.
    fn lower(&mut self, strays: &[Stray]) {
        let mut ratios = BTreeMap::new();
        for stray in strays {
            for segment in stray.segments.clone() {
                let ratio = ratios.entry(segment).or_insert(stray.ratio);
                *ratio = stray.ratio.max(*ratio);
            }
        }
        for (segment, ratio) in ratios {
            *self.0.entry(segment).or_insert(1.0) *= (1.0 - MARGIN) / ratio;
        }
    }
}

/// The feedrates that the next plan is asked for, mm/s.
struct Asked {
    corners: Vec<f64>,
    segments: Vec<f64>,
    is_arc: Vec<bool>,
}

impl Asked {
    fn of(toolpath: &Toolpath, plan: &FeedPlan) -> Asked {
        let is_arc: Vec<bool> =
            toolpath.segments.iter().map(|segment| segment.curve != Curve::Line).collect();
        let along = |(feedrate, is_arc): (&f64, &bool)| if *is_arc { *feedrate } else { f64::INFINITY };
        let segments = plan.segment_feedrates.iter().zip(&is_arc).map(along).collect();
        Asked { corners: plan.corner_feedrates.clone(), segments, is_arc }
    }

    /// One round: changes feedrates by what the plan in force does; false where there is nothing to change.
    fn change(
        &mut self,
        now: &FeedPlan,
        errors: &ContourErrors,
        bounds: impl Iterator<Item = Bound>,
        round: Round,
    ) -> bool {
        let mut moved = false;
        for (k, Bound { along, corner, near }) in bounds.enumerate() {
            if self.is_arc[k] {
                let (planned, error) = (now.segment_feedrates[k], errors.along(k) / (BETWEEN_POINTS * along));
                // An arc cannot be run at no feedrate at all; it ends between two stops instead.
                let slowest = SLOWEST_ARC * planned;
                moved |= changed(&mut self.segments[k], planned, error, f64::INFINITY, round);
                self.segments[k] = self.segments[k].max(slowest);
                // What an arc misses by may come from the corners at its ends.
                if 1.0 < error && !matches!(round, Round::UpAndDown) {
                    for corner in [k.checked_sub(1), Some(k)].into_iter().flatten() {
                        let planned = now.corner_feedrates[corner];
                        moved |= changed(&mut self.corners[corner], planned, error, planned, round);
                    }
                }
            }
            let is_beside_arc = self.is_arc[k] || self.is_arc.get(k + 1).is_some_and(|&is_arc| is_arc);
            let share = if is_beside_arc { BETWEEN_POINTS } else { 1.0 };
            let error = (errors.at_point(k) / (share * corner)).max(errors.corner[k] / (share * near));
            if 0.0 < now.corner_feedrates[k] {
                let slower = now.segment_feedrates[k].min(now.segment_feedrates[k + 1]);
                let planned = now.corner_feedrates[k];
                moved |= changed(&mut self.corners[k], planned, error, slower, round);
            } else if 1.0 < error && matches!(round, Round::Stop) {
                // What is off at a stop is a neighbour's, which may have a wider tolerance of its own.
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

/// The segments of which a part is commanded within a filter delay of a segment whose pulses differ
/// between two plans. What lies farther away sees the same command before and after.
fn within_a_delay(before: &FeedPlan, after: &FeedPlan) -> Vec<bool> {
    fn by_segment(plan: &FeedPlan) -> impl Iterator<Item = impl Iterator<Item = Pulse>> {
        let pulses = &plan.pulses;
        pulses.by_segment(0..pulses.len()).map(|own| pulses.range(own))
    }
    let moved: Vec<bool> =
        by_segment(before).zip(by_segment(after)).map(|(before, after)| before.ne(after)).collect();
    let mut stale = moved.clone();
    for stretch in after.stretches() {
        let delay = after.filters[stretch.filter].delay();
        let mut spread = |pulses: &mut dyn Iterator<Item = usize>| {
            let mut age = f64::INFINITY;
            for index in pulses {
                let segment = after.pulses.segment(index);
                stale[segment] |= age <= delay;
                age = if moved[segment] { 0.0 } else { age + after.pulses.duration(index) };
            }
        };
        spread(&mut stretch.pulses.clone());
        spread(&mut stretch.pulses.clone().rev());
    }
    stale
}
