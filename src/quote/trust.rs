//! What a program leaves in doubt, in seconds of its cycle time.
//!
//! | effect | bound |
//! |---|---|
//! | axis word missing | the position may be any between those of nearby moves: the slowest way over it and on, and the straight way past it |
//! | arc that does not close | each of its coordinates in turn put where the arc closes with the others |
//! | arc without a circle | half a circle about the chord, or the longest of the arcs nearby |
//! | feed missing | the slowest and the fastest feedrate of the program; without any from [`MIN_FEEDRATE`] to the rapid feedrate |
//! | motion word missing | the other of rapid and the slowest feedrate |
//! | hole missing | the longest of the program, or one over all its heights |
//! | unknown position | [`ASSUMED_TRAVEL`] there and back in rapid |
//!
//! A bound adds the time that a stop takes, as the path around it changes. Where nothing bounds a doubt it has no seconds.

mod arcs;

use crate::machine::Machine;
use crate::quote::trust::arcs::{half_circle, lengths_that_close};
use crate::simulation::feed::FeedPlan;
use crate::simulation::gcode::{Cause, Doubt, Effect, Letters, LineNumber};
use crate::simulation::toolpath::{Curve, Motion, Point, Segment, StopCause, Toolpath};
use crate::units::mm_per_s;

/// How far an axis travels at most to a position that nobody gives, mm.
pub const ASSUMED_TRAVEL: f64 = 1000.0;
/// The slowest feedrate of a program that gives none, mm/s: 100 mm/min.
pub const MIN_FEEDRATE: f64 = 100.0 / 60.0;
/// The axis along which passes differ.
const TOOL_AXIS: usize = 2;
/// So many moves of an axis before and after a doubt tell where it may be.
const NEARBY_MOVES: usize = 6;
/// They are looked for among so many segments before and after.
const NEARBY_SEGMENTS: usize = 100;
/// A feedrate that is missing may be so much slower or faster than those of the program.
const FEED_MARGIN: f64 = 2.0;
/// The seconds that a time in seconds has more than one in milliseconds, by the latter.
const EXCESS_OF_SECONDS: f64 = 999.0;

/// How far a cycle time can be trusted.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Trust {
    /// Why it is in doubt, those without a bound first, then by their seconds; empty where nothing is.
    pub doubts: Vec<InDoubt>,
}

/// One cause of doubt with all that it touches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InDoubt {
    /// Why.
    pub cause: Cause,
    /// How often.
    pub count: usize,
    /// First and last line of the program.
    pub lines: (LineNumber, LineNumber),
    /// By how much the cycle time may be too long or too short, s; none where nothing bounds it.
    pub seconds: Option<f64>,
}

impl Trust {
    /// By how much the cycle time may be too long or too short, s, as far as that has a bound.
    pub fn seconds_in_doubt(&self) -> f64 {
        self.doubts.iter().filter_map(|doubt| doubt.seconds).fold(0.0, |sum, seconds| sum + seconds)
    }

    /// Whether every doubt has a bound.
    pub fn is_bounded(&self) -> bool {
        self.doubts.iter().all(|doubt| doubt.seconds.is_some())
    }

    fn add(&mut self, cause: Cause, line: LineNumber, seconds: Option<f64>) {
        let found = self.doubts.iter().position(|known| known.cause == cause);
        let index = found.unwrap_or_else(|| {
            self.doubts.push(InDoubt { cause, count: 0, lines: (line, line), seconds: Some(0.0) });
            self.doubts.len() - 1
        });
        let doubt = &mut self.doubts[index];
        doubt.count += 1;
        doubt.lines = (doubt.lines.0.min(line), doubt.lines.1.max(line));
        doubt.seconds = doubt.seconds.zip(seconds).map(|(sum, more)| sum + more);
    }
}

/// How far the cycle time of `plan` can be trusted.
pub fn trust(toolpath: &Toolpath, machine: &Machine, plan: &FeedPlan) -> Trust {
    let mut trust = Trust::default();
    if toolpath.doubts.is_empty() {
        return trust;
    }
    let bounds = Bounds::new(toolpath, machine, plan);
    // What several doubts say of one move is as large as the largest of them.
    let (mut place, mut seconds_there) = (None, 0.0);
    for doubt in &toolpath.doubts {
        let mut seconds = bounds.seconds(doubt);
        if matches!(doubt.effect, Effect::Words(_) | Effect::Arc | Effect::Block | Effect::Travel) {
            if place != Some((doubt.line, doubt.after)) {
                (place, seconds_there) = (Some((doubt.line, doubt.after)), 0.0);
            }
            let all = seconds.unwrap_or(0.0);
            seconds = seconds.map(|seconds| (seconds - seconds_there).max(0.0));
            seconds_there = seconds_there.max(all);
        }
        trust.add(doubt.cause, doubt.line, seconds);
    }
    trust.doubts.retain(|doubt| doubt.seconds != Some(0.0));
    let order = |doubt: &InDoubt| doubt.seconds.unwrap_or(f64::INFINITY);
    trust.doubts.sort_by(|a, b| order(b).total_cmp(&order(a)));
    trust
}

/// The time of the pulses of a segment, s.
fn seconds_of(plan: &FeedPlan, segment: usize) -> f64 {
    let pulses = &plan.pulses;
    let pulses = pulses.range(pulses.before(segment)..pulses.before(segment + 1));
    pulses.filter(|pulse| !pulse.is_halt()).map(|pulse| pulse.duration).sum()
}

/// What bounds are worked out from.
struct Bounds<'a> {
    toolpath: &'a Toolpath,
    machine: &'a Machine,
    plan: &'a FeedPlan,
    /// The slowest and the fastest feedrate that a move without one may have, mm/s.
    feedrates: [f64; 2],
    /// The longest time that a hole may take, s.
    hole: Option<f64>,
    /// The longest dwell, s.
    dwell: Option<f64>,
    /// The time that a stop takes, s.
    stop: f64,
}

impl<'a> Bounds<'a> {
    fn new(toolpath: &'a Toolpath, machine: &'a Machine, plan: &'a FeedPlan) -> Bounds<'a> {
        let stop = plan.filters.iter().map(|filter| 2.0 * filter.half_delay()).fold(0.0, f64::max);
        let dwell = toolpath.stops.iter().filter_map(|stop| stop.cause.dwell()).reduce(f64::max);
        let mut bounds = Bounds { toolpath, machine, plan, feedrates: [0.0; 2], hole: None, dwell, stop };
        bounds.feedrates = bounds.feedrates_of_program();
        bounds.hole = bounds.longest_hole().or_else(|| bounds.deepest_hole());
        bounds
    }

    /// The slowest and the fastest feedrate, mm/s, of moves that have one for sure, with a margin.
    fn feedrates_of_program(&self) -> [f64; 2] {
        let is_unsure =
            |doubt: &&Doubt| doubt.effect == Effect::Feed && doubt.cause != Cause::FeedsBeyondRapid;
        let doubts = self.toolpath.doubts.iter().filter(is_unsure);
        let mut unsure = doubts.map(|doubt| doubt.after..doubt.until).peekable();
        let mut feedrates: Option<[f64; 2]> = None;
        for (index, segment) in self.toolpath.segments.iter().enumerate() {
            while unsure.next_if(|range| range.end <= index).is_some() {}
            let is_unsure = unsure.peek().is_some_and(|range| range.contains(&index));
            if let (false, Motion::Feed { feedrate }) = (is_unsure, segment.motion) {
                let [low, high] = feedrates.unwrap_or([feedrate; 2]);
                feedrates = Some([low.min(feedrate), high.max(feedrate)]);
            }
        }
        match feedrates {
            Some([low, high]) => [low / FEED_MARGIN, high * FEED_MARGIN],
            None => [MIN_FEEDRATE, self.machine.rapid.feedrate.max(MIN_FEEDRATE)],
        }
    }

    /// The longest time of moves in a row on one line of the program, as holes have, s.
    fn longest_hole(&self) -> Option<f64> {
        let (mut longest, mut line, mut moves, mut seconds) = (None, LineNumber(0), 0, 0.0);
        for (index, segment) in self.toolpath.segments.iter().enumerate() {
            if segment.line != line {
                (line, moves, seconds) = (segment.line, 0, 0.0);
            }
            moves += 1;
            seconds += seconds_of(self.plan, index);
            if 1 < moves {
                longest = Some(seconds.max(longest.unwrap_or(0.0)));
            }
        }
        longest
    }

    /// The time of a hole over all heights of the program, s.
    fn deepest_hole(&self) -> Option<f64> {
        let heights = self.toolpath.segments.iter().map(|segment| segment.end[TOOL_AXIS]);
        let (low, high) =
            heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| (low.min(at), high.max(at)));
        let depth = high - low;
        (0.0 < depth)
            .then(|| depth / self.feedrates[0] + depth / self.machine.rapid.feedrate + 2.0 * self.stop)
    }

    /// By how much the cycle time may be off by `doubt`, s.
    fn seconds(&self, doubt: &Doubt) -> Option<f64> {
        match doubt.effect {
            Effect::Words(letters) => Some(self.of_words(doubt, letters)),
            Effect::Arc => Some(self.of_arc(doubt)),
            Effect::Feed if doubt.cause == Cause::FeedsBeyondRapid => {
                Some(self.of_fast_feed(doubt.after..doubt.until))
            }
            Effect::Feed => Some(self.of_feed(doubt.after..doubt.until)),
            Effect::MotionWord => Some(self.of_motion_word(doubt.after..doubt.until)),
            Effect::Travel => {
                let has_way_back = doubt.until < self.toolpath.segments.len();
                let ways = if has_way_back { 2.0 } else { 1.0 };
                Some(ways * (ASSUMED_TRAVEL / self.machine.rapid.feedrate + self.stop))
            }
            Effect::CycleWord => self.of_cycle_word(doubt.after..doubt.until),
            Effect::Hole => self.hole,
            Effect::Block => {
                let own = self.own(doubt);
                let seconds: f64 = own.clone().map(|index| seconds_of(self.plan, index)).sum();
                Some(seconds.max(self.of_feed(own)) + self.stop)
            }
            Effect::Unbounded if doubt.cause == Cause::UnclearDwells => self.of_dwell(doubt),
            Effect::Unbounded => None,
        }
    }

    /// The segments of the block that a doubt is about.
    fn own(&self, doubt: &Doubt) -> std::ops::Range<usize> {
        let segments = &self.toolpath.segments;
        let end = (doubt.after..doubt.until.min(segments.len()))
            .find(|&index| segments.get(index).is_none_or(|own| own.line != doubt.line));
        doubt.after..end.unwrap_or(doubt.until.min(segments.len()))
    }

    /// A dwell in milliseconds that may be in seconds, or one that is missing.
    fn of_dwell(&self, doubt: &Doubt) -> Option<f64> {
        let stops = &self.toolpath.stops;
        let first = stops.partition_point(|stop| stop.after < doubt.after);
        let own = stops[first..].iter().take_while(|stop| stop.after == doubt.after);
        let own = own.filter(|stop| stop.line == doubt.line).find_map(|stop| match stop.cause {
            StopCause::Dwell { seconds } => Some(EXCESS_OF_SECONDS * seconds),
            _ => None,
        });
        own.or(self.dwell)
    }

    /// Feed moves that may have any feedrate of the program.
    fn of_feed(&self, segments: std::ops::Range<usize>) -> f64 {
        let [slowest, fastest] = self.feedrates;
        let (mut slower, mut faster) = (0.0, 0.0);
        for (index, segment) in self.between(segments) {
            if let Motion::Feed { feedrate } = segment.motion {
                let seconds = seconds_of(self.plan, index);
                slower += (segment.length / slowest - segment.length / feedrate).max(0.0);
                faster += (segment.length / feedrate - segment.length / fastest).max(0.0).min(seconds);
            }
        }
        slower.max(faster)
    }

    /// Feed moves that the machine may run no faster than in rapid.
    fn of_fast_feed(&self, segments: std::ops::Range<usize>) -> f64 {
        let feeds = self.between(segments).filter(|(_, segment)| segment.motion != Motion::Rapid);
        let rapid = self.machine.rapid.feedrate;
        feeds.map(|(index, segment)| (segment.length / rapid - seconds_of(self.plan, index)).max(0.0)).sum()
    }

    /// Moves that may be in rapid or in feed.
    fn of_motion_word(&self, segments: std::ops::Range<usize>) -> f64 {
        let (mut in_rapid, mut in_feed) = (0.0, 0.0);
        for (index, segment) in self.between(segments) {
            let seconds = seconds_of(self.plan, index);
            match segment.motion {
                Motion::Rapid => in_feed += (segment.length / self.feedrates[0] - seconds).max(0.0),
                Motion::Feed { .. } => {
                    in_rapid += (seconds - segment.length / self.machine.rapid.feedrate).max(0.0);
                }
            }
        }
        in_rapid.max(in_feed)
    }

    /// Moves at the end of which holes may be made.
    fn of_cycle_word(&self, segments: std::ops::Range<usize>) -> Option<f64> {
        let moves = segments.len().max(1) as f64;
        self.hole.map(|hole| moves * (hole + self.stop) + self.of_motion_word(segments))
    }

    fn between(&self, range: std::ops::Range<usize>) -> impl Iterator<Item = (usize, Segment)> {
        range.filter_map(|index| Some((index, self.toolpath.segments.get(index)?)))
    }

    /// Axis words that are missing, and the centre of an arc.
    fn of_words(&self, doubt: &Doubt, letters: Letters) -> f64 {
        let arc = if letters.meets(Letters::of(b"IJKR")) { self.of_arc(doubt) } else { 0.0 };
        let axes = [b"X", b"Y", b"Z"].map(|letter| letters.meets(Letters::of(letter)));
        if axes == [false; 3] {
            return arc;
        }
        arc.max(self.of_position(doubt, axes)).max(self.of_arc_end(doubt))
    }

    /// The end of a move that may be anywhere along `axes` between nearby positions.
    fn of_position(&self, doubt: &Doubt, axes: [bool; 3]) -> f64 {
        let segments = &self.toolpath.segments;
        let own = self.own(doubt);
        let Some(start) = self.position_before(doubt.after) else { return 0.0 };
        let run = if own.is_empty() { start } else { segments.get(own.end - 1).map_or(start, |own| own.end) };
        // The move that comes back to a known position.
        let back = doubt.until.max(own.end + 1).min(segments.len());
        let back = back.checked_sub(1).filter(|back| own.end <= *back);
        let end = back.and_then(|back| segments.get(back)).map_or(run, |back| back.end);
        let there = match own.is_empty() {
            true => [doubt.after.checked_sub(1), Some(doubt.after)]
                .into_iter()
                .flatten()
                .filter_map(|index| self.speed(index))
                .reduce(f64::min),
            false => self.speed(own.start),
        };
        let slowest = self.feedrates[0];
        let there = there.unwrap_or(slowest);
        let on = back.and_then(|back| self.speed(back)).unwrap_or(there);
        let seconds = |over: Point| (over - start).norm() / there + (end - over).norm() / on;
        let ranges = [0, 1, 2].map(|axis| {
            if axes[axis] {
                self.nearby(doubt, axis, [start[axis], end[axis], run[axis]])
            } else {
                [run[axis]; 2]
            }
        });
        let corners = (0..8).map(|corner: usize| {
            seconds(Point::new(ranges[0][corner & 1], ranges[1][corner >> 1 & 1], ranges[2][corner >> 2]))
        });
        let longest = corners.fold(0.0, f64::max);
        let run = seconds(run);
        // Of a move that is not run nobody knows whether it was in rapid.
        let fastest = if own.is_empty() { self.machine.rapid.feedrate } else { there.max(on) };
        let shortest = (end - start).norm() / fastest;
        let bound = (longest - run).max(run - shortest).max(0.0) + self.stop;
        // A move that is not run at all is taken for one like those around it.
        if own.is_empty() { bound.max(self.longest_move_near(doubt.after)) } else { bound }
    }

    fn position_before(&self, after: usize) -> Option<Point> {
        let segments = &self.toolpath.segments;
        let next = segments.get(after).map(|next| next.start);
        next.or_else(|| segments.get(after.checked_sub(1)?).map(|last| last.end))
    }

    /// Where an axis is in the moves around a doubt, mm.
    fn nearby(&self, doubt: &Doubt, axis: usize, known: [f64; 3]) -> [f64; 2] {
        let mut range = [
            known.iter().copied().fold(f64::INFINITY, f64::min),
            known.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        ];
        let mut look = |indices: &mut dyn Iterator<Item = usize>| {
            let (mut moves, mut first) = (0, None);
            for index in indices.take(NEARBY_SEGMENTS) {
                let Some(segment) = self.toolpath.segments.get(index) else { break };
                // Across the tool a cut goes on where it is; its depth is that of another pass.
                let is_rapid = segment.motion == Motion::Rapid;
                if axis != TOOL_AXIS && is_rapid != *first.get_or_insert(is_rapid) {
                    break;
                }
                moves += usize::from(segment.start[axis] != segment.end[axis]);
                for at in [segment.start[axis], segment.end[axis]] {
                    range = [range[0].min(at), range[1].max(at)];
                }
                if NEARBY_MOVES <= moves {
                    break;
                }
            }
        };
        look(&mut (0..doubt.after.min(self.toolpath.segments.len())).rev());
        look(&mut (doubt.after..self.toolpath.segments.len()));
        range
    }

    /// How fast a segment is run on average, mm/s.
    fn speed(&self, index: usize) -> Option<f64> {
        let segment = self.toolpath.segments.get(index)?;
        let speed = segment.length / seconds_of(self.plan, index);
        let programmed = match segment.motion {
            Motion::Rapid => self.machine.rapid.feedrate,
            Motion::Feed { feedrate } => feedrate,
        };
        Some(if speed.is_finite() && 0.0 < speed { speed.min(programmed) } else { programmed })
    }

    /// The next arc with each of its coordinates in turn put where it closes; without a circle half of one.
    fn of_arc(&self, doubt: &Doubt) -> f64 {
        let segments = &self.toolpath.segments;
        let Some(segment) = segments.get(doubt.after).filter(|segment| segment.line == doubt.line) else {
            return self.longest_arc_near(doubt.after);
        };
        let speed = self.speed(doubt.after).unwrap_or(mm_per_s(1000.0));
        let before = doubt.after.checked_sub(1).and_then(|before| segments.get(before));
        let next = segments.get(doubt.after + 1);
        match &segment.curve {
            Curve::Arc(arc) => {
                let lengths = lengths_that_close(&segment, arc, before.as_ref(), next.as_ref());
                let longest = lengths.map(|length| (length - segment.length).abs()).fold(0.0, f64::max);
                longest / speed + self.stop
            }
            Curve::Line => {
                let half = (half_circle(&segment) - segment.length) / speed + self.stop;
                half.max(self.longest_arc_near(doubt.after))
            }
        }
    }

    /// An arc to an end that is in doubt.
    fn of_arc_end(&self, doubt: &Doubt) -> f64 {
        let segment = self.toolpath.segments.get(doubt.after).filter(|segment| segment.line == doubt.line);
        match segment.map(|segment| segment.curve) {
            Some(Curve::Arc(_)) => self.of_arc(doubt),
            _ => 0.0,
        }
    }

    /// The time of the longest of the moves right before and after, s.
    fn longest_move_near(&self, after: usize) -> f64 {
        let moves = after.saturating_sub(NEARBY_MOVES)..after + NEARBY_MOVES;
        self.between(moves).map(|(index, _)| seconds_of(self.plan, index)).fold(0.0, f64::max)
    }

    /// The time of the longest of the nearby arcs, s.
    fn longest_arc_near(&self, after: usize) -> f64 {
        let first = after.saturating_sub(NEARBY_SEGMENTS);
        let arcs = self.between(first..after + NEARBY_SEGMENTS);
        let arcs = arcs.filter(|(_, segment)| matches!(segment.curve, Curve::Arc(_)));
        arcs.map(|(index, _)| seconds_of(self.plan, index)).fold(0.0, f64::max) + self.stop
    }
}

#[cfg(test)]
mod tests;
