//! Halts that the program does not request, in the feed plan: pulses of feedrate 0.
//!
//! A halt of t seconds is a pulse of feedrate 0 that lasts t, so that the command is interrupted and then
//! continues unchanged. The filters run empty meanwhile, and the motion ramps down and up again as at a full
//! stop. A halt costs t exactly, however short it is: the command is later by t from there on, and its area
//! does not change. A feed hold may have ramps of the command as well, see
//! [`feed_hold`](crate::simulation::feed::feed_hold).
//!
//! | halt | where its pulse lies |
//! |---|---|
//! | feed hold | at its place, between ramps if accelerations limit the command |
//! | wait before a line that moves first | before the first pulse of its rest-to-rest motion |
//! | wait at an S word in a block of motion | before the first pulse of its rest-to-rest motion |
//! | wait of the first feed move for the spindle | before the first pulse of its rest-to-rest motion |
//! | wait of the first feed move for the rest of a spindle ramp of k abs(Δn) s | the same |
//! | wait for position | behind the last pulse of its rest-to-rest motion |
//!
//! If the line begins with a function, a dwell or a turn of rotary axes, the wait before it is added to the
//! duration of that stop.
//!
//! A spindle ramp begins at its M word, and dwells and rapid moves overlap it. If an S word among moves starts the ramp, the
//! model lets it begin at the feed move.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::ops::Range;

use crate::machine::{FunctionTimes, Halts, Machine};
use crate::simulation::feed::feed_hold::FeedHold;
use crate::simulation::feed::{FeedPlan, Phase, Pulse, exact_stop_by_turn, total_duration};
use crate::simulation::toolpath::{Segment, Segments, StopCause, Toolpath};

/// The halts of a toolpath on a machine.
#[derive(Debug, Default)]
pub(super) struct HaltSchedule {
    /// Wait before each stop that has one, s, by index of the stop.
    stops: BTreeMap<usize, f64>,
    /// Wait before each segment that has one, s, by index of the segment.
    segments: BTreeMap<usize, f64>,
    /// Feed holds by index of the segment.
    holds: BTreeMap<usize, FeedHold>,
    /// Ramps of the spindle that the first feed move waits for, by index of its segment.
    ramps: BTreeMap<usize, AwaitedRamp>,
}

/// A ramp of the spindle that a feed move waits for.
#[derive(Debug)]
struct AwaitedRamp {
    /// Duration, s.
    duration: f64,
    /// `true` if it begins at a stop of the program.
    begins_at_stop: bool,
}

/// Splits a machine into one without its feed holds and one with no other halts; returns the machine itself and `None` if it
/// has none.
pub(super) fn feed_holds_apart(machine: &Machine) -> (Cow<'_, Machine>, Option<Machine>) {
    if machine.halts.feed_holds.is_empty() {
        return (Cow::Borrowed(machine), None);
    }
    let (mut without, mut holds) = (machine.clone(), machine.clone());
    (holds.halts, holds.times) = (Halts::default(), FunctionTimes::default());
    holds.halts.feed_holds = std::mem::take(&mut without.halts.feed_holds);
    holds.halts.feed_hold_places = std::mem::take(&mut without.halts.feed_hold_places);
    (Cow::Owned(without), Some(holds))
}

impl HaltSchedule {
    /// Returns the halts of a toolpath on a machine.
    pub(super) fn of(toolpath: &Toolpath, machine: &Machine) -> HaltSchedule {
        let halts = &machine.halts;
        let mut found = HaltSchedule::default();
        if 0.0 < machine.times.spindle_change {
            found.segments.extend(toolpath.speed_changes().map(|next| (next, machine.times.spindle_change)));
        }
        if 0.0 < machine.times.spindle_at_feed {
            for feed in toolpath.feeds_at_new_speed() {
                *found.segments.entry(feed.segment).or_default() += machine.times.spindle_at_feed;
            }
        }
        if 0.0 < machine.times.spindle_ramp_at_feed {
            let ramps = toolpath.feeds_at_new_speed().map(|feed| {
                let duration = machine.times.spindle_ramp_at_feed * feed.change;
                let mut stops = toolpath.stops_at(feed.changed_after).iter();
                let begins_at_stop = stops.any(|stop| matches!(stop.cause, StopCause::Spindle { .. }));
                (feed.segment, AwaitedRamp { duration, begins_at_stop })
            });
            found.ramps.extend(ramps);
        }
        if halts.waits.is_empty() && halts.feed_holds.is_empty() {
            return found;
        }
        let (segments, stops) = (&toolpath.segments, &toolpath.stops);
        let (mut segment, mut stop) = (0, 0);
        let mut last_line = None;
        while segment < segments.len() || stop < stops.len() {
            let is_stop =
                stops.get(stop).is_some_and(|next| next.after <= segment || segment == segments.len());
            let line = if is_stop { stops[stop].line } else { segments.at(segment).line };
            if last_line != Some(line)
                && let Some(&seconds) = halts.waits.get(&line.0)
                && 0.0 < seconds
            {
                if is_stop {
                    found.stops.insert(stop, seconds);
                } else {
                    *found.segments.entry(segment).or_default() += seconds;
                }
            }
            last_line = Some(line);
            if is_stop {
                stop += 1;
                continue;
            }
            // The path of a line continues over its stops, up to the next line.
            let end = segment
                + segments.range(segment..segments.len()).take_while(|next| next.line == line).count();
            let begins = segment == 0 || segments.at(segment - 1).line != line;
            if begins
                && let Some(&seconds) = halts.feed_holds.get(&line.0)
                && 0.0 < seconds
            {
                let (held, along) = place_on(segments, segment..end, halts.place(line.0));
                found.holds.insert(held, FeedHold { segment: held, along, duration: seconds });
            }
            segment += 1;
        }
        found
    }

    /// Returns `true` if the machine halts before a segment.
    pub(super) fn stands_before(&self, segment: usize) -> bool {
        self.segments.contains_key(&segment) || self.ramps.contains_key(&segment)
    }

    /// Returns `true` if the machine halts before any segment.
    pub(super) fn has_segments(&self) -> bool {
        !self.segments.is_empty() || !self.ramps.is_empty()
    }

    /// Inserts the halts into a plan that has full stops where they occur.
    pub(super) fn put_into(&self, plan: &mut FeedPlan, toolpath: &Toolpath, machine: &Machine) {
        let in_position = machine.halts.in_position;
        if self.stops.is_empty() && !self.has_segments() && self.holds.is_empty() && in_position <= 0.0 {
            return;
        }
        let pulses = std::mem::take(&mut plan.pulses);
        let mut stop = 0;
        // The time so far, and when the spindle last began to change its speed, s.
        let (mut clock, mut ramp_began) = (0.0, 0.0);
        let mut phases = plan.phases.iter_mut().peekable();
        while let Some(phase) = phases.next() {
            let rest_to_rest = match phase {
                Phase::Wait(wait) => {
                    wait.duration += self.stops.get(&stop).copied().unwrap_or(0.0);
                    if matches!(wait.cause, StopCause::Spindle { .. }) {
                        ramp_began = clock;
                    }
                    clock += wait.duration;
                    stop += 1;
                    continue;
                }
                Phase::Motion(rest_to_rest) => rest_to_rest,
            };
            let first = plan.pulses.len();
            let halt = |segment: usize, offset: f64, duration: f64| Pulse {
                segment: segment as u32,
                duration,
                offset,
                feedrate: [0.0, 0.0],
            };
            let start = rest_to_rest.segments.start;
            let ramp = self.ramps.get(&start).map_or(0.0, |ramp| {
                let before = if ramp.begins_at_stop { clock - ramp_began } else { 0.0 };
                (ramp.duration - before).max(0.0)
            });
            let seconds = self.segments.get(&start).copied().unwrap_or(0.0) + ramp;
            if 0.0 < seconds {
                plan.pulses.push(halt(start, 0.0, seconds));
            }
            let own = pulses.range(rest_to_rest.pulses.clone());
            let mut holds = self.holds.range(rest_to_rest.segments.clone()).peekable();
            if holds.peek().is_none() {
                plan.pulses.extend(own);
            } else {
                let put = |held: Vec<Pulse>, (_, hold): (&usize, &FeedHold)| {
                    hold.put_into(&held, &toolpath.segments, machine)
                };
                plan.pulses.extend(holds.fold(own.collect(), put));
            }
            let last = rest_to_rest.segments.end - 1;
            let goes_on = matches!(phases.peek(), Some(Phase::Motion(_)));
            if 0.0 < in_position
                && goes_on
                && waits_for_position(&toolpath.segments.at(last), &toolpath.segments.at(last + 1), machine)
            {
                plan.pulses.push(halt(last, toolpath.segments.length(last), in_position));
            }
            rest_to_rest.pulses = first..plan.pulses.len();
            if !self.ramps.is_empty() {
                clock +=
                    total_duration(&plan.pulses, rest_to_rest) + plan.filters[rest_to_rest.filter].delay();
            }
        }
    }
}

/// Returns `true` if rapid moves end in a full stop to reach their position.
pub(super) fn rapid_ends_stop(before: &Segment, machine: &Machine) -> bool {
    before.motion.is_rapid()
        && 0.0 < machine.halts.in_position
        && machine.halts.in_position_at.has_rapid_ends()
}

/// Returns `true` if the corner law decides whether the motion stops behind a segment although the program
/// requests exact stops.
pub(super) fn is_exact_path(before: &Segment, machine: &Machine) -> bool {
    let waits = 0.0 < machine.halts.in_position && machine.halts.in_position_at.has_exact_stops();
    before.exact_path && machine.interpolator.junction.blends_in_time() && !waits
}

/// Returns `true` if the machine waits for position at the full stop between two segments.
fn waits_for_position(before: &Segment, after: &Segment, machine: &Machine) -> bool {
    let is_exact = before.exact_stop || exact_stop_by_turn(before, after, machine);
    rapid_ends_stop(before, machine) || (is_exact && machine.halts.in_position_at.has_exact_stops())
}

/// Returns the place at the fraction `part` of the total length of the segments in a range: the segment and
/// the distance along it (mm).
fn place_on(segments: &Segments, range: Range<usize>, part: f64) -> (usize, f64) {
    let mut left = part * segments.range(range.clone()).map(|segment| segment.length).sum::<f64>();
    let last = range.end - 1;
    for at in range.start..last {
        let length = segments.length(at);
        if left < length {
            return (at, left);
        }
        left -= length;
    }
    (last, left.min(segments.length(last)))
}
