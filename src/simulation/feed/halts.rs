//! Halts that the program does not ask for, in the feed plan: pulses of no feedrate.
//!
//! A halt of t seconds is a pulse of feedrate 0 that lasts t, so that the command is taken away and given back
//! as it was. The filters run empty meanwhile, the motion ramps down and up again as to and from a full
//! stop, and what it costs is t exactly, however short it is: the command is later by t from there on, and
//! its area is the same.
//!
//! | halt | where its pulse lies |
//! |---|---|
//! | feed hold | within the pulse that sends its place, which it divides |
//! | wait before a line that moves first | before the first pulse of its stretch |
//! | wait at an S word in a block of motion | before the first pulse of its stretch |
//! | wait for position | behind the last pulse of its stretch |
//!
//! A wait before a line that begins with a function, a dwell or a turn of rotary axes adds to that.
//!
//! Limits: a feed hold takes the command away at once, whatever the acceleration limit before the filters.

use std::collections::BTreeMap;
use std::ops::Range;

use crate::machine::Machine;
use crate::simulation::feed::{FeedPlan, Phase, Pulse, Pulses, exact_stop_by_turn};
use crate::simulation::toolpath::{Motion, Segment, Segments, Toolpath};

/// The halts of a toolpath on a machine.
#[derive(Debug, Default)]
pub(super) struct Halting {
    /// Seconds before each stop that has a wait of its own, by index.
    stops: BTreeMap<usize, f64>,
    /// Seconds before each segment that has one, by index.
    segments: BTreeMap<usize, f64>,
    /// Feed holds by segment: how far along it (mm) and how long (s).
    holds: BTreeMap<usize, (f64, f64)>,
}

impl Halting {
    /// Where the halts of a machine fall.
    pub(super) fn of(toolpath: &Toolpath, machine: &Machine) -> Halting {
        let halts = &machine.halts;
        let mut found = Halting::default();
        if 0.0 < machine.times.spindle_change {
            found.segments.extend(toolpath.speed_changes().map(|next| (next, machine.times.spindle_change)));
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
            // A line's path goes on over its stops, up to the next line.
            let end = segment
                + segments.range(segment..segments.len()).take_while(|next| next.line == line).count();
            let begins = segment == 0 || segments.at(segment - 1).line != line;
            if begins
                && let Some(&seconds) = halts.feed_holds.get(&line.0)
                && 0.0 < seconds
            {
                let (held, along) = place_on(segments, segment..end, halts.place(line.0));
                found.holds.insert(held, (along, seconds));
            }
            segment += 1;
        }
        found
    }

    /// Whether the machine stands before a segment.
    pub(super) fn stands_before(&self, segment: usize) -> bool {
        self.segments.contains_key(&segment)
    }

    /// Whether the machine stands before any segment.
    pub(super) fn has_segments(&self) -> bool {
        !self.segments.is_empty()
    }

    /// Puts the halts into a plan that stands where they do.
    pub(super) fn put_into(&self, plan: &mut FeedPlan, toolpath: &Toolpath, machine: &Machine) {
        let in_position = machine.halts.in_position;
        if self.stops.is_empty() && self.segments.is_empty() && self.holds.is_empty() && in_position <= 0.0 {
            return;
        }
        let pulses = std::mem::take(&mut plan.pulses);
        let mut stop = 0;
        let mut phases = plan.phases.iter_mut().peekable();
        while let Some(phase) = phases.next() {
            let stretch = match phase {
                Phase::Wait(wait) => {
                    wait.duration += self.stops.get(&stop).copied().unwrap_or(0.0);
                    stop += 1;
                    continue;
                }
                Phase::Motion(stretch) => stretch,
            };
            let first = plan.pulses.len();
            let halt = |segment: usize, offset: f64, duration: f64| Pulse {
                segment: segment as u32,
                duration,
                offset,
                feedrate: [0.0, 0.0],
            };
            if let Some(&seconds) = self.segments.get(&stretch.segments.start) {
                plan.pulses.push(halt(stretch.segments.start, 0.0, seconds));
            }
            for own in pulses.by_segment(stretch.pulses.clone()) {
                match self.holds.get(&pulses.segment(own.start)) {
                    Some(&(place, seconds)) => held(&pulses, own, place, seconds, &mut plan.pulses),
                    None => plan.pulses.extend(pulses.range(own)),
                }
            }
            let last = stretch.segments.end - 1;
            let goes_on = matches!(phases.peek(), Some(Phase::Motion(_)));
            if 0.0 < in_position
                && goes_on
                && waits_for_position(&toolpath.segments.at(last), &toolpath.segments.at(last + 1), machine)
            {
                plan.pulses.push(halt(last, toolpath.segments.length(last), in_position));
            }
            stretch.pulses = first..plan.pulses.len();
        }
    }
}

/// Whether rapid moves end in a full stop for the sake of position.
pub(super) fn rapid_ends_stop(before: &Segment, machine: &Machine) -> bool {
    before.motion == Motion::Rapid
        && 0.0 < machine.halts.in_position
        && machine.halts.in_position_at.has_rapid_ends()
}

/// Whether the full stop between two segments is one that waits for position.
fn waits_for_position(before: &Segment, after: &Segment, machine: &Machine) -> bool {
    let is_exact = before.exact_stop || exact_stop_by_turn(before, after, machine);
    rapid_ends_stop(before, machine) || (is_exact && machine.halts.in_position_at.has_exact_stops())
}

/// The segment, and how far along it (mm), at this part of the length of those in a range.
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

/// Adds the pulses of a segment, which are `own` of all, with the command taken away at a place (mm along it) for so many
/// seconds.
fn held(all: &Pulses, own: Range<usize>, place: f64, seconds: f64, pulses: &mut Pulses) {
    let divided = own.clone().rfind(|&index| all.at(index).offset <= place).unwrap_or(own.start);
    pulses.extend(all.range(own.start..divided));
    let pulse = all.at(divided);
    let [first, last] = pulse.feedrate;
    let slope = (last - first) / pulse.duration;
    let way = (place - pulse.offset).max(0.0);
    // first t + slope t²/2 = way, without a difference of like numbers.
    let root = (first * first + 2.0 * slope * way).max(0.0).sqrt();
    let before = if 0.0 < way { (2.0 * way / (first + root)).min(pulse.duration) } else { 0.0 };
    let there = first + slope * before;
    let offset = pulse.offset + before * 0.5 * (first + there);
    if 0.0 < before {
        pulses.push(Pulse { duration: before, feedrate: [first, there], ..pulse });
    }
    pulses.push(Pulse { duration: seconds, offset, feedrate: [0.0, 0.0], ..pulse });
    if before < pulse.duration {
        pulses.push(Pulse { duration: pulse.duration - before, offset, feedrate: [there, last], ..pulse });
    }
    pulses.extend(all.range(divided + 1..own.end));
}
