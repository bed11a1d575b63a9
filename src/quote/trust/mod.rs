//! The doubts of a program, in seconds of its cycle time.
//!
//! | effect | bound |
//! |---|---|
//! | axis word missing | the position may be any between those of nearby moves: the slowest way over it and on, and the straight way past it |
//! | arc that does not close | each of its coordinates in turn put where the arc closes with the others |
//! | turns of an arc unclear | these turns, each the length of the circle; of a pitch as many as there are in the rise |
//! | pecks left out | as many times the time of the hole as they are more |
//! | arc without a circle | half a circle about the chord, or the longest of the arcs nearby |
//! | feed missing | the slowest and the fastest feedrate of the program; without any from [`MIN_FEEDRATE_MM_S`] to the rapid feedrate |
//! | motion word missing | the other of rapid and the slowest feedrate |
//! | hole missing | the longest of the program, or one over all its heights |
//! | unknown position | [`ASSUMED_TRAVEL_MM`] there and back in rapid |
//!
//! A bound includes the time of a stop, as the path around the doubt changes. A doubt without a bound has no
//! seconds.

mod arcs;

use crate::machine::Machine;
use crate::quote::trust::arcs::{half_circle, lengths_that_close};
use crate::simulation::feed::FeedPlan;
use crate::simulation::gcode::{Doubt, DoubtCause, DoubtEffect, Letters, LineNumber};
use crate::simulation::ordered::sort_by_number;
use crate::simulation::toolpath::{Arc, Curve, Motion, Point, Segment, StopCause, Toolpath};
use crate::units::mm_per_s;
use std::f64::consts::TAU;

/// Assumed travel of an axis to an unknown position, mm.
pub const ASSUMED_TRAVEL_MM: f64 = 1000.0;
/// Slowest feedrate assumed for a program that sets none, mm/s: 100 mm/min.
pub const MIN_FEEDRATE_MM_S: f64 = 100.0 / 60.0;
/// Index of the axis along which the passes of a program differ.
const TOOL_AXIS: usize = 2;
/// Number of moves of an axis before and after a doubt that show the possible positions of the axis.
const NEARBY_MOVES: usize = 6;
/// Number of segments before and after a doubt in which these moves are searched.
const NEARBY_SEGMENTS: usize = 100;
/// Ratio by which a missing feedrate may be slower or faster than those of the program.
const FEEDRATE_MARGIN_RATIO: f64 = 2.0;
/// Multiple of a dwell in milliseconds by which the same number in seconds is longer.
const SECONDS_OVER_MILLISECONDS: f64 = 999.0;

/// The doubts about a cycle time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Trust {
    /// Doubts, those without a bound first, then by their seconds.
    pub doubts: Vec<CauseInDoubt>,
}

/// One cause of doubt.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CauseInDoubt {
    /// Cause.
    pub cause: DoubtCause,
    /// Number of occurrences.
    pub count: usize,
    /// First and last line of the program.
    pub lines: (LineNumber, LineNumber),
    /// Largest error of the cycle time in either direction, s; `None` if it has no bound.
    pub seconds: Option<f64>,
}

impl Trust {
    /// Returns the largest error of the cycle time in either direction by the doubts that have a bound, s.
    pub fn seconds_in_doubt(&self) -> f64 {
        self.doubts.iter().filter_map(|doubt| doubt.seconds).fold(0.0, |sum, seconds| sum + seconds)
    }

    /// Returns `true` if every doubt has a bound.
    pub fn is_bounded(&self) -> bool {
        self.doubts.iter().all(|doubt| doubt.seconds.is_some())
    }

    /// Adds a doubt; `is_counted` is `false` for a further doubt about the same move.
    fn add(&mut self, cause: DoubtCause, line: LineNumber, seconds: Option<f64>, is_counted: bool) {
        let found = self.doubts.iter().position(|known| known.cause == cause);
        let index = found.unwrap_or_else(|| {
            self.doubts.push(CauseInDoubt { cause, count: 0, lines: (line, line), seconds: Some(0.0) });
            self.doubts.len() - 1
        });
        let doubt = &mut self.doubts[index];
        doubt.count += usize::from(is_counted);
        doubt.lines = (doubt.lines.0.min(line), doubt.lines.1.max(line));
        doubt.seconds = doubt.seconds.zip(seconds).map(|(sum, more)| sum + more);
    }
}

/// Returns the doubts about the cycle time of `plan`.
pub fn trust(toolpath: &Toolpath, machine: &Machine, plan: &FeedPlan) -> Trust {
    let mut trust = Trust::default();
    if toolpath.doubts.is_empty() {
        return trust;
    }
    let bounds = DoubtBounds::new(toolpath, machine, plan);
    // Of several doubts about one move only the largest counts.
    let (mut place, mut seconds_there) = (None, 0.0);
    let mut last_arc = None;
    for doubt in &toolpath.doubts {
        let mut seconds = bounds.seconds(doubt);
        let is_of_arc =
            matches!(doubt.effect, DoubtEffect::Arc | DoubtEffect::Turns(_) | DoubtEffect::Pitch(_));
        let is_of_move = is_of_arc
            || matches!(
                doubt.effect,
                DoubtEffect::Words(_) | DoubtEffect::Block | DoubtEffect::Travel | DoubtEffect::Pecks(_)
            );
        if is_of_move {
            if place != Some((doubt.line, doubt.after)) {
                (place, seconds_there) = (Some((doubt.line, doubt.after)), 0.0);
            }
            let all = seconds.unwrap_or(0.0);
            seconds = seconds.map(|seconds| (seconds - seconds_there).max(0.0));
            seconds_there = seconds_there.max(all);
        }
        let arc = is_of_arc.then_some((doubt.cause, doubt.line, doubt.after));
        trust.add(doubt.cause, doubt.line, seconds, arc.is_none() || arc != last_arc);
        last_arc = arc;
    }
    trust.doubts.retain(|doubt| doubt.seconds != Some(0.0));
    let order = |doubt: &CauseInDoubt| doubt.seconds.unwrap_or(f64::INFINITY);
    sort_by_number(&mut trust.doubts, |doubt| -order(doubt));
    trust
}

/// Returns the duration of the pulses of a segment, s.
fn seconds_of(plan: &FeedPlan, segment: usize) -> f64 {
    let pulses = &plan.pulses;
    let pulses = pulses.range(pulses.of_segments(segment..segment + 1));
    pulses.filter(|pulse| !pulse.is_halt()).map(|pulse| pulse.duration).sum()
}

/// The data from which bounds are computed.
struct DoubtBounds<'a> {
    toolpath: &'a Toolpath,
    machine: &'a Machine,
    plan: &'a FeedPlan,
    /// The slowest and the fastest feedrate of a move without a feedrate, mm/s.
    feedrates: [f64; 2],
    /// The longest time of a hole, s.
    hole: Option<f64>,
    /// The longest dwell, s.
    dwell: Option<f64>,
    /// The time of a stop, s.
    stop: f64,
}

impl<'a> DoubtBounds<'a> {
    fn new(toolpath: &'a Toolpath, machine: &'a Machine, plan: &'a FeedPlan) -> DoubtBounds<'a> {
        let stop = plan.filters.iter().map(|filter| 2.0 * filter.half_delay()).fold(0.0, f64::max);
        let dwell = toolpath.stops.iter().filter_map(|stop| stop.cause.dwell()).reduce(f64::max);
        let mut bounds =
            DoubtBounds { toolpath, machine, plan, feedrates: [0.0; 2], hole: None, dwell, stop };
        bounds.feedrates = bounds.feedrates_of_program();
        bounds.hole = bounds.longest_hole().or_else(|| bounds.deepest_hole());
        bounds
    }

    /// Returns the slowest and the fastest feedrate (mm/s) of moves whose feedrate is certain, with a margin.
    fn feedrates_of_program(&self) -> [f64; 2] {
        let is_unsure =
            |doubt: &&Doubt| doubt.effect == DoubtEffect::Feed && doubt.cause != DoubtCause::FeedsBeyondRapid;
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
            Some([low, high]) => [low / FEEDRATE_MARGIN_RATIO, high * FEEDRATE_MARGIN_RATIO],
            None => [MIN_FEEDRATE_MM_S, self.machine.rapid.feedrate.max(MIN_FEEDRATE_MM_S)],
        }
    }

    /// Returns the longest time of consecutive moves on one line of the program, as holes have, s.
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

    /// Returns the time of a hole over all heights of the program, s.
    fn deepest_hole(&self) -> Option<f64> {
        let heights = self.toolpath.segments.iter().map(|segment| segment.end[TOOL_AXIS]);
        let (low, high) =
            heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| (low.min(at), high.max(at)));
        let depth = high - low;
        (0.0 < depth)
            .then(|| depth / self.feedrates[0] + depth / self.machine.rapid.feedrate + 2.0 * self.stop)
    }

    /// Returns the largest error of the cycle time by `doubt`, s; `None` if it has no bound.
    fn seconds(&self, doubt: &Doubt) -> Option<f64> {
        match doubt.effect {
            DoubtEffect::Words(letters) => Some(self.words_bound(doubt, letters)),
            DoubtEffect::Arc => Some(self.arc_bound(doubt)),
            DoubtEffect::Turns(turns) => Some(self.turns_bound(doubt, |_| turns)),
            DoubtEffect::Pitch(pitch) => Some(self.turns_bound(doubt, |arc| arc.rise.norm() / pitch)),
            DoubtEffect::Pecks(per_made) => self.pecks_bound(doubt, per_made),
            DoubtEffect::Feed if doubt.cause == DoubtCause::FeedsBeyondRapid => {
                Some(self.fast_feed_bound(doubt.after..doubt.until))
            }
            DoubtEffect::Feed => Some(self.feed_bound(doubt.after..doubt.until)),
            DoubtEffect::MotionWord => Some(self.motion_word_bound(doubt.after..doubt.until)),
            DoubtEffect::Travel => {
                let has_way_back = doubt.until < self.toolpath.segments.len();
                let ways = if has_way_back { 2.0 } else { 1.0 };
                Some(ways * (ASSUMED_TRAVEL_MM / self.machine.rapid.feedrate + self.stop))
            }
            DoubtEffect::CycleWord => self.cycle_word_bound(doubt.after..doubt.until),
            DoubtEffect::Hole => self.hole,
            DoubtEffect::Block => {
                let block_segments = self.own(doubt);
                let seconds: f64 = block_segments.clone().map(|index| seconds_of(self.plan, index)).sum();
                Some(seconds.max(self.feed_bound(block_segments)) + self.stop)
            }
            DoubtEffect::Unbounded if doubt.cause == DoubtCause::UnclearDwells => self.dwell_bound(doubt),
            DoubtEffect::Unbounded => None,
        }
    }

    /// Returns the indices of the segments of the block in doubt.
    fn own(&self, doubt: &Doubt) -> std::ops::Range<usize> {
        let segments = &self.toolpath.segments;
        let end = (doubt.after..doubt.until.min(segments.len()))
            .find(|&index| segments.get(index).is_none_or(|own| own.line != doubt.line));
        doubt.after..end.unwrap_or(doubt.until.min(segments.len()))
    }

    /// Returns a bound for the next arc with more or fewer full turns, s.
    fn turns_bound(&self, doubt: &Doubt, turns: impl Fn(&Arc) -> f64) -> f64 {
        let segment = self.toolpath.segments.get(doubt.after).filter(|segment| segment.line == doubt.line);
        match segment.map(|segment| segment.curve) {
            Some(Curve::Arc(arc)) => {
                let speed = self.speed(doubt.after).unwrap_or(mm_per_s(1000.0));
                turns(&arc) * TAU * arc.mean_radius() / speed + self.stop
            }
            _ => self.arc_bound(doubt),
        }
    }

    /// Returns a bound for the holes of a block with `per_made` pecks for each modelled peck, each of the
    /// mean duration of the modelled ones, s; `None` without a bound.
    fn pecks_bound(&self, doubt: &Doubt, per_made: f64) -> Option<f64> {
        let own = self.own(doubt);
        let first = self.toolpath.stops.partition_point(|stop| stop.after <= own.start);
        let stops = self.toolpath.stops[first..].iter().take_while(|stop| stop.after <= own.end);
        let dwells: f64 = stops.filter_map(|stop| stop.cause.dwell()).sum();
        let moves = own.len() as f64 * self.stop + own.map(|index| seconds_of(self.plan, index)).sum::<f64>();
        Some((per_made - 1.0) * (moves + dwells)).filter(|seconds| seconds.is_finite())
    }

    /// Returns a bound for a dwell in milliseconds that may be in seconds, or for a missing dwell, s; `None`
    /// without a bound.
    fn dwell_bound(&self, doubt: &Doubt) -> Option<f64> {
        let own = self.toolpath.stops_at(doubt.after).iter();
        let own = own.filter(|stop| stop.line == doubt.line).find_map(|stop| match stop.cause {
            StopCause::Dwell { seconds } => Some(SECONDS_OVER_MILLISECONDS * seconds),
            _ => None,
        });
        own.or(self.dwell)
    }

    /// Returns a bound for feed moves that may have any feedrate of the program, s.
    fn feed_bound(&self, segments: std::ops::Range<usize>) -> f64 {
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

    /// Returns a bound for feed moves that the machine may run no faster than in rapid, s.
    fn fast_feed_bound(&self, segments: std::ops::Range<usize>) -> f64 {
        let feeds = self.between(segments).filter(|(_, segment)| !segment.motion.is_rapid());
        let rapid = self.machine.rapid.feedrate;
        feeds.map(|(index, segment)| (segment.length / rapid - seconds_of(self.plan, index)).max(0.0)).sum()
    }

    /// Returns a bound for moves that may be in rapid or in feed, s.
    fn motion_word_bound(&self, segments: std::ops::Range<usize>) -> f64 {
        let (mut in_rapid, mut in_feed) = (0.0, 0.0);
        for (index, segment) in self.between(segments) {
            let seconds = seconds_of(self.plan, index);
            match segment.motion {
                Motion::Rapid { .. } => in_feed += (segment.length / self.feedrates[0] - seconds).max(0.0),
                Motion::Feed { .. } => {
                    in_rapid += (seconds - segment.length / self.machine.rapid.feedrate).max(0.0);
                }
            }
        }
        in_rapid.max(in_feed)
    }

    /// Returns a bound for moves at the end of which holes may be drilled, s; `None` without a bound.
    fn cycle_word_bound(&self, segments: std::ops::Range<usize>) -> Option<f64> {
        let moves = segments.len().max(1) as f64;
        self.hole.map(|hole| moves * (hole + self.stop) + self.motion_word_bound(segments))
    }

    fn between(&self, range: std::ops::Range<usize>) -> impl Iterator<Item = (usize, Segment)> {
        range.filter_map(|index| Some((index, self.toolpath.segments.get(index)?)))
    }

    /// Returns a bound for missing axis words and arc centres, s.
    fn words_bound(&self, doubt: &Doubt, letters: Letters) -> f64 {
        let arc = if letters.meets(Letters::of(b"IJKR")) { self.arc_bound(doubt) } else { 0.0 };
        let axes = [b"X", b"Y", b"Z"].map(|letter| letters.meets(Letters::of(letter)));
        if axes == [false; 3] {
            return arc;
        }
        arc.max(self.position_bound(doubt, axes)).max(self.arc_end_bound(doubt))
    }

    /// Returns a bound for a move that may end anywhere along `axes` between nearby positions, s.
    fn position_bound(&self, doubt: &Doubt, axes: [bool; 3]) -> f64 {
        let segments = &self.toolpath.segments;
        let own = self.own(doubt);
        let Some(start) = self.position_before(doubt.after) else { return 0.0 };
        let run = if own.is_empty() { start } else { segments.get(own.end - 1).map_or(start, |own| own.end) };
        // The move that returns to a known position.
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
                self.nearby_positions(doubt, axis, [start[axis], end[axis], run[axis]])
            } else {
                [run[axis]; 2]
            }
        });
        let corners = (0..8).map(|corner: usize| {
            seconds(Point::new(ranges[0][corner & 1], ranges[1][corner >> 1 & 1], ranges[2][corner >> 2]))
        });
        let longest = corners.fold(0.0, f64::max);
        let run = seconds(run);
        // A move that is not run may have been in rapid.
        let fastest = if own.is_empty() { self.machine.rapid.feedrate } else { there.max(on) };
        let shortest = (end - start).norm() / fastest;
        let bound = (longest - run).max(run - shortest).max(0.0) + self.stop;
        // A move that is not run at all is assumed to be like the moves around it.
        if own.is_empty() { bound.max(self.longest_move_near(doubt.after)) } else { bound }
    }

    fn position_before(&self, after: usize) -> Option<Point> {
        let segments = &self.toolpath.segments;
        let next = segments.get(after).map(|next| next.start);
        next.or_else(|| segments.get(after.checked_sub(1)?).map(|last| last.end))
    }

    /// Returns the range of positions of an axis in the moves around a doubt, mm.
    fn nearby_positions(&self, doubt: &Doubt, axis: usize, known: [f64; 3]) -> [f64; 2] {
        let mut range = [
            known.iter().copied().fold(f64::INFINITY, f64::min),
            known.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        ];
        let mut look = |indices: &mut dyn Iterator<Item = usize>| {
            let (mut moves, mut first) = (0, None);
            for index in indices.take(NEARBY_SEGMENTS) {
                let Some(segment) = self.toolpath.segments.get(index) else { break };
                // Across the tool axis a cut continues at its position; its depth is that of another pass.
                let is_rapid = segment.motion.is_rapid();
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

    /// Returns the average feedrate of a segment, mm/s.
    fn speed(&self, index: usize) -> Option<f64> {
        let segment = self.toolpath.segments.get(index)?;
        let speed = segment.length / seconds_of(self.plan, index);
        let programmed = match segment.motion {
            Motion::Rapid { .. } => self.machine.rapid.feedrate,
            Motion::Feed { feedrate } => feedrate,
        };
        Some(if speed.is_finite() && 0.0 < speed { speed.min(programmed) } else { programmed })
    }

    /// Returns a bound for the next arc with each of its coordinates in turn placed so that the arc closes,
    /// and with half a circle if there is no arc, s.
    fn arc_bound(&self, doubt: &Doubt) -> f64 {
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

    /// Returns a bound for an arc whose end is in doubt, s.
    fn arc_end_bound(&self, doubt: &Doubt) -> f64 {
        let segment = self.toolpath.segments.get(doubt.after).filter(|segment| segment.line == doubt.line);
        match segment.map(|segment| segment.curve) {
            Some(Curve::Arc(_)) => self.arc_bound(doubt),
            _ => 0.0,
        }
    }

    /// Returns the time of the longest of the moves right before and after, s.
    fn longest_move_near(&self, after: usize) -> f64 {
        let moves = after.saturating_sub(NEARBY_MOVES)..after + NEARBY_MOVES;
        self.between(moves).map(|(index, _)| seconds_of(self.plan, index)).fold(0.0, f64::max)
    }

    /// Returns the time of the longest of the nearby arcs, s.
    fn longest_arc_near(&self, after: usize) -> f64 {
        let first = after.saturating_sub(NEARBY_SEGMENTS);
        let arcs = self.between(first..after + NEARBY_SEGMENTS);
        let arcs = arcs.filter(|(_, segment)| matches!(segment.curve, Curve::Arc(_)));
        arcs.map(|(index, _)| seconds_of(self.plan, index)).fold(0.0, f64::max) + self.stop
    }
}

#[cfg(test)]
mod tests;
