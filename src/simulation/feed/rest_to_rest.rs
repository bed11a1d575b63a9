//! One rest-to-rest motion: the command along its segments and at its corners, and its pulses.
//!
//! ```text
//! |limits    each segment by itself: the requested feedrate and every limit but the tolerance
//! |corners   each segment within its tolerance, and each corner between two of them by its law
//! |supply    no segment faster than its blocks are supplied, unless that is known in advance
//! |reach     no corner faster than its neighbours allow, if the command keeps an acceleration limit
//! |pulses    of each segment between its corners
//! ```
//!
//! A long program is one motion of millions of segments, and fetching them costs more than computing with
//! them. If neither supply nor reach limits anything, the last step runs a few segments behind the corners,
//! and each segment is fetched only twice. A corner is a chain of roots and quotients, and the processor
//! overlaps several corners if no other work lies between them. The corners of [`CORNERS_AHEAD`] segments are
//! therefore computed before the pulses of these segments.

use std::iter::repeat_n;
use std::ops::Range;

use crate::machine::{CornerPlanning, Junction, Machine, TimeConstants};
use crate::simulation::feed::blend::{self, Blend, Leg, Parabola};
use crate::simulation::feed::block::{self, BlockEnd, BlockPart};
use crate::simulation::feed::corner::CornerLaw;
use crate::simulation::feed::corner_blend;
use crate::simulation::feed::corner_curve::CornerCurve;
use crate::simulation::feed::halts::HaltSchedule;
use crate::simulation::feed::junction::{self, CornerTurn};
use crate::simulation::feed::parabola;
use crate::simulation::feed::ramp::{self, Ramp};
use crate::simulation::feed::smoothing;
use crate::simulation::feed::step_segments::StepTimer;
use crate::simulation::feed::{
    CornerPolicy, FeedPlan, Phase, Pulse, Pulses, RestToRest, SegmentTolerance, is_stopped_by_mode,
    is_unqueued_arc, limits, positioning, stands_before, turns_may_stop,
};
use crate::simulation::filter::FilterChain;
use crate::simulation::toolpath::{Curve, Motion, Segment, Toolpath, Vector};

/// Adds the plan of the motion that begins with the first segment of `range`, up to the next full stop or the
/// end of `range`; returns the index one past its last segment.
pub(super) fn add_rest_to_rest(
    plan: &mut FeedPlan,
    range: Range<usize>,
    toolpath: &Toolpath,
    machine: &Machine,
    halts: &HaltSchedule,
    policy: CornerPolicy,
) -> usize {
    // The lists of the plan hold the feedrates and corners from the beginning: a long program has no room for
    // them twice.
    let FeedPlan { filters, segment_feedrates, corner_feedrates, corner_curves, pulses, phases, .. } = plan;
    let (first_feedrate, first_corner, first_pulse) =
        (segment_feedrates.len(), corner_feedrates.len(), pulses.len());
    let segment_limits = SegmentLimits::of(toolpath, range.clone(), machine, halts, segment_feedrates);
    let range = range.start..segment_limits.end;
    let feedrates = &mut segment_feedrates[first_feedrate..];
    let filter = segment_limits.filter(filters, &toolpath.segments.at(range.start), machine);
    let chain = &filters[filter];
    let has_many_corners = MANY_CORNERS < range.len();
    let law = if has_many_corners { CornerLaw::for_many_corners(chain) } else { CornerLaw::new(chain) };
    let planner = MotionPlanner {
        toolpath,
        machine,
        policy,
        filter: chain,
        law,
        range,
        segment_limits: &segment_limits,
    };
    let supplied = planner.supplied();
    let is_blended = machine.interpolator.junction.blends_in_time();
    // A planner of ramps knows its supply in advance.
    let is_known = is_blended || machine.interpolator.planned_by == CornerPlanning::Supply;
    if is_known && let Some(supplied) = &supplied {
        feedrates.iter_mut().zip(supplied).for_each(|(feedrate, most)| *feedrate = feedrate.min(*most));
    }
    let starving = supplied.filter(|_| !is_known);
    let are_final = !is_blended && starving.is_none() && !planner.has_reach();
    // The segments slowed by the tolerance, each with the requested feedrate, mm/s.
    let mut lowered = Vec::new();
    let mut blends = planner.corners(feedrates, corner_feedrates, |commanded| {
        if are_final {
            planner.add_pulses(pulses, commanded);
        } else if commanded.feedrate < commanded.without_tolerance {
            lowered.push((commanded.i, commanded.without_tolerance));
        }
    });
    // The segments before which the planner stops at a corner.
    let mut stops = Vec::new();
    if is_blended {
        blends.push(Blend::none(0.0));
        let (blended, at_corners) = planner.blended_with_parabolas(feedrates, &mut blends);
        pulses.extend(blended);
        corner_curves.extend(planner.curves(&blends));
        corner_feedrates.truncate(first_corner);
        let is_stop = |corner: &usize| at_corners[*corner - 1] == 0.0;
        stops.extend((1..at_corners.len()).filter(is_stop).map(|corner| planner.range.start + corner));
        corner_feedrates.extend(at_corners);
    } else if !are_final {
        let corners = &mut corner_feedrates[first_corner..];
        if let Some(supplied) = starving {
            lowered = limited_by_supply(&supplied, feedrates, &lowered);
        }
        let at_rests = planner.reach(corners, feedrates);
        let mut lowered = lowered.into_iter().peekable();
        let mut before = at_rests[0];
        let behind = corners[..corners.len() - 1].iter().chain([&at_rests[1]]);
        for (i, (&feedrate, &after)) in feedrates.iter().zip(behind).enumerate() {
            let without_tolerance =
                lowered.next_if(|(at, _)| *at == i).map_or(feedrate, |(_, requested)| requested);
            let corners = [std::mem::replace(&mut before, after), after];
            let feedrates = [feedrate, without_tolerance];
            planner.add_pulses(pulses, &planner.commanded(i, planner.length(i), feedrates, corners));
        }
    }
    phases.extend(motions(planner.range, stops, pulses, first_pulse, filter));
    segment_limits.end
}

/// Returns the motions along segments whose pulses begin with `first_pulse`: from rest to rest between the `stops`, each
/// the index of the segment behind it. The next leg begins when the filters have run empty.
fn motions(
    segments: Range<usize>,
    stops: Vec<usize>,
    pulses: &Pulses,
    first_pulse: usize,
    filter: usize,
) -> impl Iterator<Item = Phase> {
    let (mut segment, mut pulse) = (segments.start, first_pulse);
    stops.into_iter().chain([segments.end]).map(move |end| {
        let (first_segment, first_pulse) = (segment, pulse);
        (segment, pulse) = (end, pulses.before(end, first_pulse));
        Phase::Motion(RestToRest { segments: first_segment..segment, pulses: first_pulse..pulse, filter })
    })
}

/// Least number of corners for which a table of the corner law saves time: a corner takes 25 ns with the
/// table and 93 ns without, and the table itself is computed once.
const MANY_CORNERS: usize = 500;

/// The limits of the segments of a motion other than their feedrates, each segment by itself.
pub(super) struct SegmentLimits {
    /// Index one past the last segment of the motion in the toolpath.
    end: usize,
    /// Accelerations, mm/s²; empty if nothing depends on them.
    pub(super) accelerations: Vec<f64>,
    /// The feedrate requested on the first segment, mm/s.
    first: f64,
    /// The largest feedrate requested, mm/s.
    largest: f64,
}

impl SegmentLimits {
    /// Adds to `feedrates` (mm/s) the largest feedrate of each segment under every limit but the tolerance,
    /// for the motion at the beginning of `range`.
    fn of(
        toolpath: &Toolpath,
        range: Range<usize>,
        machine: &Machine,
        halts: &HaltSchedule,
        feedrates: &mut Vec<f64>,
    ) -> SegmentLimits {
        let is_blended = machine.interpolator.junction.blends_in_time();
        let has_accelerations = machine.limits_command() || machine.interpolator.look_ahead.is_finite();
        let (mut accelerations, mut first, mut largest) = (Vec::new(), None, 0.0_f64);
        let are_alike = !has_accelerations && limits::are_lines_alike(machine);
        let segments = &toolpath.segments;
        let stands_before = |next: usize| stands_before(segments, next, machine) || halts.stands_before(next);
        let may_stand_anywhere = turns_may_stop(machine) || halts.has_segments();
        let mut end = range.start;
        while end < range.end && (end == range.start || !stands_before(end)) {
            let index = end;
            end = if are_alike { segments.plain_lines_end(index).min(range.end) } else { index + 1 };
            if may_stand_anywhere {
                end = (index + 1..end).find(|&next| stands_before(next)).unwrap_or(end);
            }
            let segment = segments.at(index);
            let requested = limits::requested_feedrate(&segment, machine);
            let requested = positioning::feedrate(&segment, requested, machine);
            first.get_or_insert(requested);
            largest = largest.max(requested);
            let mut feedrate = requested.min(limits::curve_feedrate(&segment, machine));
            if has_accelerations {
                let own = junction::acceleration_before_turn(&segment, machine);
                feedrate = feedrate.min(limits::blended_arc_feedrate(&segment, own, machine));
                accelerations.push(junction::acceleration_of_ramps(&segment, own, machine));
            }
            feedrates.extend(repeat_n(feedrate, end - index));
        }
        if is_blended {
            let last = accelerations.last_mut().expect("a motion has a segment");
            let might_blend = !is_stopped_by_mode(toolpath, end, machine);
            if is_unqueued_arc(toolpath, end - 1) {
                *last = parabola::unqueued_acceleration(&segments.at(end - 1), might_blend, machine);
            } else if might_blend {
                *last *= parabola::PARABOLA_SHARE;
            }
        }
        SegmentLimits { end, accelerations, first: first.unwrap_or(0.0), largest }
    }

    /// Returns the index of the filters of the motion that begins with the segment `first`; adds the filters
    /// to the list if no equal ones are in it.
    fn filter(&self, filters: &mut Vec<FilterChain>, first: &Segment, machine: &Machine) -> usize {
        let setting = match (first.motion, &machine.rapid.time_constants) {
            (Motion::Rapid { .. }, Some(own)) => own,
            _ => &machine.interpolator.time_constants,
        };
        let order = machine.interpolator.filters;
        let constants = match setting {
            _ if positioning::applies(first, machine) => {
                vec![positioning::time_constant(first, self.first, machine); order]
            }
            TimeConstants::Equal(constant) => vec![*constant; order],
            TimeConstants::FromJerk(jerk) => vec![(self.largest / jerk).sqrt(); order],
            TimeConstants::Unequal(constants) => constants.clone(),
        };
        let known = filters.iter().rposition(|filter| filter.time_constants() == constants);
        known.unwrap_or_else(|| {
            filters.push(FilterChain::new(&constants));
            filters.len() - 1
        })
    }
}

/// The motion being planned; its segments are counted from its first.
pub(super) struct MotionPlanner<'a> {
    toolpath: &'a Toolpath,
    pub(super) machine: &'a Machine,
    policy: CornerPolicy<'a>,
    pub(super) filter: &'a FilterChain,
    law: CornerLaw<'a>,
    pub(super) range: Range<usize>,
    pub(super) segment_limits: &'a SegmentLimits,
}

/// A segment with its command between and at its corners.
struct CommandedSegment {
    /// Index, counted from the first segment of the motion.
    i: usize,
    /// Length, mm.
    length: f64,
    /// Distance along which a corner's command can be held, mm.
    chord: f64,
    /// Command between the corners, mm/s.
    feedrate: f64,
    /// Command before the tolerance lowered it, mm/s.
    without_tolerance: f64,
    /// Command at the corner before and at the corner after, mm/s.
    corners: [f64; 2],
}

/// A segment on one side of a corner.
#[derive(Clone, Copy)]
struct SegmentAtCorner {
    limit: SegmentTolerance,
    /// Length, mm.
    length: f64,
    /// Unit tangents at the beginning and at the end.
    tangents: [Vector; 2],
    /// Command along it, mm/s.
    feedrate: f64,
    /// Command before the tolerance lowered it, mm/s.
    without_tolerance: f64,
}

/// Number of segments whose corners are computed before their pulses.
const CORNERS_AHEAD: usize = 64;

impl MotionPlanner<'_> {
    fn segment(&self, i: usize) -> Segment {
        self.toolpath.segments.at(self.range.start + i)
    }

    fn curve(&self, i: usize) -> &Curve {
        self.toolpath.segments.curve(self.range.start + i)
    }

    pub(super) fn length(&self, i: usize) -> f64 {
        self.toolpath.segments.length(self.range.start + i)
    }

    /// Returns the unit tangents of a segment at its beginning and at its end.
    pub(super) fn tangents(&self, i: usize) -> [Vector; 2] {
        self.toolpath.segments.length_and_tangents(self.range.start + i).1
    }

    /// Returns the acceleration limit of the command on a segment, mm/s²; infinite if acceleration limits act
    /// behind the filters.
    pub(super) fn acceleration(&self, i: usize) -> f64 {
        if self.machine.limits_command() { self.segment_limits.accelerations[i] } else { f64::INFINITY }
    }

    /// Lowers the feedrates (mm/s) to those that the tolerance allows along each segment, adds the command at
    /// the corner after each (mm/s), and calls `then` for each. Returns the blends of all corners, including
    /// the beginning of the motion, if junctions are blends.
    fn corners(
        &self,
        feedrates: &mut [f64],
        corners: &mut Vec<f64>,
        mut then: impl FnMut(&CommandedSegment),
    ) -> Vec<Blend> {
        let mut blends = vec![Blend::none(0.0)];
        let mut limits = self.policy.tolerances().limits(self.toolpath, self.machine, self.range.start);
        let count = feedrates.len();
        // The segments whose pulses are still to come: the index of the first, and the corner before it.
        let mut sides: Vec<SegmentAtCorner> = Vec::with_capacity(count.min(CORNERS_AHEAD + 1));
        let (mut first, mut before) = (0, 0.0);
        for some in feedrates.chunks_mut(CORNERS_AHEAD) {
            for (feedrate, limit) in some.iter_mut().zip(&mut limits) {
                let side = self.side(first + sides.len(), *feedrate, limit);
                *feedrate = side.feedrate;
                sides.push(side);
            }
            let known = corners.len();
            corners.extend(
                (1..sides.len()).map(|i| self.corner(first + i, &sides[i - 1], &sides[i], &mut blends)),
            );
            if first + sides.len() == count {
                corners.push(0.0);
            }
            for (side, &after) in sides.iter().zip(&corners[known..]) {
                let feedrates = [side.feedrate, side.without_tolerance];
                let corners = [std::mem::replace(&mut before, after), after];
                then(&self.commanded(first, side.length, feedrates, corners));
                first += 1;
            }
            sides.drain(..corners.len() - known);
        }
        blends
    }

    /// Returns a segment with the requested feedrate `requested` (mm/s) and the feedrate that its tolerance
    /// allows.
    fn side(&self, i: usize, requested: f64, limit: SegmentTolerance) -> SegmentAtCorner {
        let (length, tangents) = self.toolpath.segments.length_and_tangents(self.range.start + i);
        let most = match self.policy {
            CornerPolicy::Given { segments, .. } => segments[self.range.start + i],
            _ => {
                let tolerance = self.machine.interpolator.arc_tolerance.unwrap_or(limit.along());
                limits::arc_feedrate(self.curve(i), length, self.filter, tolerance)
            }
        };
        let feedrate = if most < requested { most } else { requested };
        SegmentAtCorner { limit, length, tangents, feedrate, without_tolerance: requested }
    }

    /// Returns the command at the corner before a segment, mm/s.
    fn corner(
        &self,
        i: usize,
        before: &SegmentAtCorner,
        after: &SegmentAtCorner,
        blends: &mut Vec<Blend>,
    ) -> f64 {
        let slower = before.feedrate.min(after.feedrate);
        let change = after.tangents[0] - before.tangents[1];
        let by_policy = match self.policy {
            CornerPolicy::Given { corners, .. } => corners[self.range.start + i - 1].min(slower),
            _ if 0.0 < self.machine.interpolator.corner_smoothing
                && smoothing::is_rounded(&self.segment(i - 1), &self.segment(i), self.machine) =>
            {
                return slower;
            }
            _ => {
                let turn = change.norm();
                let tolerance = before.limit.towards(after.limit, turn);
                self.law.feedrate(tolerance / turn, before.feedrate, after.feedrate)
            }
        };
        let slowed = junction::slowed(&change, slower, self.machine);
        let by_policy = by_policy.min(slowed);
        let turn = || CornerTurn::between(&self.segment(i - 1), &self.segment(i));
        let by_limits = match self.machine.interpolator.junction {
            Junction::Tolerance => self.axis_corner_feedrate(&change),
            Junction::AccelerationBlend | Junction::ParabolicBlend | Junction::ExactPath => {
                let segments = [self.segment(i - 1), self.segment(i)];
                let side = |at: usize, side: &SegmentAtCorner| parabola::CornerSide {
                    segment: &segments[at],
                    feedrate: side.feedrate,
                    whole_acceleration: None,
                };
                let sides = [side(0, before), side(1, after)];
                let blend = corner_blend::blend(sides, self.machine, before.limit.along());
                let most = if matches!(self.policy, CornerPolicy::Given { .. }) { by_policy } else { slowed };
                blends.push(blend.no_faster_than(most));
                blend.feedrate
            }
            _ => turn().feedrate(self.machine, [self.acceleration(i - 1), self.acceleration(i)]),
        };
        by_policy.min(by_limits)
    }

    /// Returns the largest corner command at which the turn keeps each axis within its jerk limit, mm/s: an
    /// axis whose velocity steps by c |Δu| before the filters has the jerk c |Δu| max ḣ after them. One
    /// filter has no finite jerk, and no limit on it can be kept.
    fn axis_corner_feedrate(&self, change: &Vector) -> f64 {
        let axes = &self.machine.axes;
        if axes.iter().all(|axis| axis.jerk == f64::INFINITY) {
            return f64::INFINITY;
        }
        let slope = self.filter.peak_impulse_slope();
        let axes = axes.iter().enumerate().filter(|_| slope.is_finite());
        axes.map(|(k, axis)| axis.jerk / (change[k].abs() * slope)).fold(f64::INFINITY, f64::min)
    }

    /// Lays the parabolas, and returns the pulses and the command at each corner, mm/s, if junctions are blends.
    fn blended_with_parabolas(&self, feedrates: &[f64], blends: &mut [Blend]) -> (Vec<Pulse>, Vec<f64>) {
        if !blends.iter().any(Blend::is_parabola) {
            return self.blended(feedrates, blends);
        }
        self.lay_parabolas(feedrates, blends, &vec![0.0; blends.len()]);
        let (pulses, speeds) = self.blended(feedrates, blends);
        let length = |leg: usize| self.length(leg);
        let early = parabola::times_in_period(blends, &pulses, &speeds, self.range.start, length);
        self.lay_parabolas(feedrates, blends, &early);
        self.blended(feedrates, blends)
    }

    /// Computes the parabolas on the parts of their legs that the circles at the other ends leave. A servo period begins the
    /// time `early` (s) before the first leg of each falls below b1.
    fn lay_parabolas(&self, feedrates: &[f64], blends: &mut [Blend], early: &[f64]) {
        let taken =
            |blend: &Blend, side: usize| if blend.is_parabola() { 0.0 } else { blend.distances[side] };
        for i in 1..blends.len() - 1 {
            let Some(Parabola { tolerance, .. }) = blends[i].parabola else { continue };
            let lengths =
                [self.length(i - 1) - taken(&blends[i - 1], 1), self.length(i) - taken(&blends[i + 1], 0)];
            let segments = [self.segment(i - 1), self.segment(i)];
            let side = |at: usize| parabola::CornerSide {
                segment: &segments[at],
                feedrate: feedrates[i - 1 + at],
                whole_acceleration: self.unqueued_acceleration(i - 1 + at).or_else(|| {
                    (!self.shares(i - 1 + at, blends)).then(|| self.segment_limits.accelerations[i - 1 + at])
                }),
            };
            blends[i] = parabola::blend([side(0), side(1)], self.machine, tolerance, lengths, early[i]);
        }
    }

    /// Returns `true` if a segment shares its acceleration with another one in a parabola: at either end, or,
    /// if all corners are parabolas, at its end only.
    fn shares(&self, i: usize, blends: &[Blend]) -> bool {
        let is_alone = self.machine.interpolator.junction == Junction::ParabolicBlend;
        blends[i + 1].is_parabola() || !is_alone && blends[i].is_parabola()
    }

    /// Returns the acceleration beside a parabola of an arc behind which no move is queued, mm/s²; `None` for any other
    /// segment.
    fn unqueued_acceleration(&self, i: usize) -> Option<f64> {
        is_unqueued_arc(self.toolpath, self.range.start + i)
            .then(|| parabola::unqueued_acceleration(&self.segment(i), true, self.machine))
    }

    /// Returns the pulses and the command at each corner, mm/s, if junctions are blends.
    fn blended(&self, feedrates: &[f64], blends: &[Blend]) -> (Vec<Pulse>, Vec<f64>) {
        let legs = feedrates.iter().zip(&self.segment_limits.accelerations).enumerate();
        let leg = |(i, (&feedrate, &acceleration)): (usize, (&f64, &f64))| {
            let (length, is_line) = (self.length(i), *self.curve(i) == Curve::Line);
            // The turns at the ends of an arc use a part of its acceleration; the curvature has only the rest.
            let left = 1.0 - blends[i].taken.max(blends[i + 1].taken);
            let unqueued = self.unqueued_acceleration(i);
            let most = match is_line || left == 1.0 || unqueued.is_some() {
                true => f64::INFINITY,
                false => corner_blend::arc_feedrate(&self.segment(i), left, self.machine),
            };
            let is_rapid = self.toolpath.segments.motion(self.range.start + i).is_rapid();
            let whole = Leg { length, feedrate: feedrate.min(most), acceleration, is_line, is_rapid };
            match (self.shares(i, blends), unqueued) {
                (true, Some(acceleration)) => Leg { acceleration, ..whole },
                (true, None) => parabola::shared(&self.segment(i), whole, self.machine),
                (false, _) => whole,
            }
        };
        let legs: Vec<Leg> = legs.map(leg).collect();
        blend::pulses(&legs, blends, self.machine.interpolator.look_ahead, self.range.start)
    }

    /// Returns the curve behind each segment; there is none behind the last.
    fn curves(&self, blends: &[Blend]) -> impl Iterator<Item = CornerCurve> {
        let replaced = |i: usize| blend::blended_lengths(self.length(i), &blends[i], &blends[i + 1]);
        let behind = move |i: usize| {
            let distances = [replaced(i - 1)[1], replaced(i)[0]];
            CornerCurve { distances, is_parabola: blends[i].is_parabola() }
        };
        (1..self.range.len()).map(behind).chain([CornerCurve::NONE])
    }

    /// Returns the ramp of constant jerk by which the command of a segment changes; `None` if its jerk is not
    /// limited.
    #[inline]
    pub(super) fn ramp(&self, i: usize) -> Option<Ramp> {
        if !self.machine.limits_jerk() {
            return None;
        }
        let segment = self.segment(i);
        let jerk = limits::jerk(&segment, self.machine);
        Ramp::of(jerk, self.acceleration(i)).filter(|_| !positioning::applies(&segment, self.machine))
    }

    /// Returns a segment of a length (mm) with its feedrate, its feedrate without the tolerance, and the
    /// command at its corners, all mm/s.
    fn commanded(
        &self,
        i: usize,
        length: f64,
        [feedrate, without_tolerance]: [f64; 2],
        corners: [f64; 2],
    ) -> CommandedSegment {
        let chord = limits::first_chord(self.curve(i), length, self.machine);
        CommandedSegment { i, length, chord, feedrate, without_tolerance, corners }
    }

    /// Adds the pulses of a segment.
    fn add_pulses(&self, pulses: &mut Pulses, commanded: &CommandedSegment) {
        let &CommandedSegment { i, length, chord, feedrate, without_tolerance, corners } = commanded;
        let number = self.range.start + i;
        if number == SAMPLED_SEGMENTS {
            reserve_pulses(pulses, self.toolpath.segments.len() - SAMPLED_SEGMENTS);
        }
        // There is no motion before the first segment or after the last. A corner slowed by supply holds its
        // command over the same distance, and so longer.
        let end = |corner: f64, is_blended: bool| {
            let command = corner.min(feedrate);
            let longer = if command < corner { corner / command } else { 1.0 };
            let hold = match is_blended {
                true => (longer * self.law.hold(corner, without_tolerance)).min(chord / command),
                false => 0.0,
            };
            BlockEnd { feedrate: command, hold }
        };
        let ends = [end(corners[0], 0 < i), end(corners[1], i + 1 < self.range.len())];
        let mut offset = 0.0;
        let add = |(duration, first, last): BlockPart| {
            if 0.0 < duration {
                pulses.push(Pulse { segment: number as u32, duration, offset, feedrate: [first, last] });
                offset += duration * 0.5 * (first + last);
            }
        };
        let timer = StepTimer::of(self.machine, || self.segment(i).tangent(0.0));
        match self.ramp(i) {
            Some(ramp) => {
                let parts = ramp.parts(length, feedrate, ends[0], ends[1]);
                let has_filters = self.machine.has_filters();
                run(parts.into_iter().flat_map(|part| ramp.pieces(part, has_filters)), timer, add);
            }
            None => {
                let parts = block::parts(length, feedrate, self.acceleration(i), ends[0], ends[1]);
                match self.machine.interpolator.quintic_ramps {
                    true => run(parts.into_iter().flat_map(ramp::quintic), timer, add),
                    false => run(parts, timer, add),
                }
            }
        }
    }
}

/// Gives `add` the parts of a block, in step segments if there is a timer of steps.
#[inline]
fn run(parts: impl IntoIterator<Item = BlockPart>, timer: Option<StepTimer>, add: impl FnMut(BlockPart)) {
    match timer {
        None => parts.into_iter().for_each(add),
        Some(timer) => timer.run(parts).into_iter().for_each(add),
    }
}

/// Lowers the feedrates (mm/s) to those at which blocks are supplied. Returns the slowed segments with their
/// requested feedrates (mm/s); `lowered` lists the segments that were slowed before.
fn limited_by_supply(supplied: &[f64], feedrates: &mut [f64], lowered: &[(usize, f64)]) -> Vec<(usize, f64)> {
    let mut lowered = lowered.iter().copied().peekable();
    let each = feedrates.iter_mut().zip(supplied).enumerate();
    let of = |(i, (feedrate, most)): (usize, (&mut f64, &f64))| {
        let before = lowered.next_if(|(at, _)| *at == i);
        let requested = *feedrate;
        *feedrate = requested.min(*most);
        before.or((*most < requested).then_some((i, requested)))
    };
    each.filter_map(of).collect()
}

/// Number of segments whose pulses serve to estimate those of the others.
const SAMPLED_SEGMENTS: usize = 2_000;

/// Reserves memory for the pulses of the segments that follow the first ones: a list that grows by doubling
/// ends with up to twice the memory it needs, in addition to its old memory. The estimate is ignored if there
/// is no such memory.
fn reserve_pulses(pulses: &mut Pulses, segments: usize) {
    let of_a_segment = pulses.len() as f64 / SAMPLED_SEGMENTS as f64;
    pulses.try_reserve_exact((1.02 * of_a_segment * segments as f64) as usize).ok();
}
