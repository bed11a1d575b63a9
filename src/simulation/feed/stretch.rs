//! One stretch, from full stop to full stop: the command along its segments and at its corners, and the pulses of it.
//!
//! ```text
//! asked     each segment by itself: what is requested, and every limit but the tolerance
//! corners   each segment within its tolerance, and each corner between two of them by its law
//! starved   no segment faster than its blocks are supplied, unless that was known before
//! reached   no corner faster than its neighbours let it be, where the command keeps an acceleration
//! pulses    of each segment between its corners
//! ```
//!
//! A long program is one stretch of millions of segments, and to fetch them costs more than to reckon with them. Where
//! nothing is starved or to be reached, the last step follows a few segments behind the corners, and they are fetched twice.
//! A corner waits for roots and quotients, one after another, and the processor works on several at once where nothing
//! else is done between them: the corners of some segments come before all pulses of these.

use std::iter::repeat_n;
use std::ops::Range;

use crate::machine::{Junction, Machine, PlannedBy, TimeConstants};
use crate::simulation::feed::blend::{self, Blend, Leg};
use crate::simulation::feed::block::{self, End, Part};
use crate::simulation::feed::corner::CornerLaw;
use crate::simulation::feed::halts::Halting;
use crate::simulation::feed::junction::{self, Turn};
use crate::simulation::feed::ramp::Ramp;
use crate::simulation::feed::smoothing;
use crate::simulation::feed::{
    FeedPlan, Limit, Phase, Pulse, Pulses, Rule, Stretch, is_stopped_by_mode, limits, positioning,
    stands_before, turns_may_stop,
};
use crate::simulation::filter::FilterChain;
use crate::simulation::toolpath::{Curve, Motion, Segment, Toolpath, Vector};

/// Plans from the first segment of `range` on, up to the next full stop or the end of `range`; gives where that is.
pub(super) fn add_stretch(
    plan: &mut FeedPlan,
    range: Range<usize>,
    toolpath: &Toolpath,
    machine: &Machine,
    halting: &Halting,
    rule: Rule,
) -> usize {
    // Feedrates and corners of the stretch are in the lists of the plan from the beginning: a long program has no room
    // for them twice.
    let FeedPlan { filters, segment_feedrates, corner_feedrates, pulses, phases, .. } = plan;
    let (first_feedrate, first_corner, first_pulse) =
        (segment_feedrates.len(), corner_feedrates.len(), pulses.len());
    let asked = Asked::of(toolpath, range.clone(), machine, halting, segment_feedrates);
    let range = range.start..asked.end;
    let feedrates = &mut segment_feedrates[first_feedrate..];
    let filter = asked.filter(filters, &toolpath.segments.at(range.start), machine);
    let chain = &filters[filter];
    let has_many_corners = MANY_CORNERS < range.len();
    let law = if has_many_corners { CornerLaw::for_many_corners(chain) } else { CornerLaw::new(chain) };
    let stretch = Planned { toolpath, machine, rule, filter: chain, law, range, asked: &asked };
    let supplied = stretch.supplied();
    let is_blended = machine.interpolator.junction == Junction::AccelerationBlend;
    // A planner of ramps knows what it is supplied with.
    let is_known = is_blended || machine.interpolator.planned_by == PlannedBy::Supply;
    if is_known && let Some(supplied) = &supplied {
        feedrates.iter_mut().zip(supplied).for_each(|(feedrate, most)| *feedrate = feedrate.min(*most));
    }
    let starving = supplied.filter(|_| !is_known);
    let are_final = !is_blended && starving.is_none() && !stretch.has_reach();
    // The segments that the tolerance makes slower than asked for, each with the feedrate asked for, mm/s.
    let mut lowered = Vec::new();
    let mut blends = stretch.corners(feedrates, corner_feedrates, |commanded| {
        if are_final {
            stretch.add_pulses(pulses, commanded);
        } else if commanded.feedrate < commanded.without_tolerance {
            lowered.push((commanded.i, commanded.without_tolerance));
        }
    });
    if is_blended {
        blends.push(Blend::none(0.0));
        let (blended, at_corners) = stretch.blended(feedrates, &blends);
        pulses.extend(blended);
        corner_feedrates.truncate(first_corner);
        corner_feedrates.extend(at_corners);
    } else if !are_final {
        let corners = &mut corner_feedrates[first_corner..];
        if let Some(supplied) = starving {
            lowered = starved(&supplied, feedrates, &lowered);
        }
        stretch.reach(corners, feedrates);
        let mut lowered = lowered.into_iter().peekable();
        let mut before = 0.0;
        for (i, (&feedrate, &after)) in feedrates.iter().zip(&*corners).enumerate() {
            let without_tolerance = lowered.next_if(|(at, _)| *at == i).map_or(feedrate, |(_, asked)| asked);
            let corners = [std::mem::replace(&mut before, after), after];
            let feedrates = [feedrate, without_tolerance];
            stretch.add_pulses(pulses, &stretch.commanded(i, stretch.length(i), feedrates, corners));
        }
    }
    let pulses = first_pulse..pulses.len();
    phases.push(Phase::Motion(Stretch { segments: stretch.range, pulses, filter }));
    asked.end
}

/// A law for many corners pays where there are so many.
const MANY_CORNERS: usize = 500;

/// What is asked of each segment of a stretch by itself, apart from its feedrate.
pub(super) struct Asked {
    /// One past its last segment in the toolpath.
    end: usize,
    /// Accelerations, mm/s²; empty where nothing depends on them.
    pub(super) accelerations: Vec<f64>,
    /// The feedrate requested on the first segment, mm/s.
    first: f64,
    /// The largest feedrate requested, mm/s.
    largest: f64,
}

impl Asked {
    /// Adds to `feedrates` those asked for with every limit but the tolerance, mm/s, of the stretch that `range` begins with.
    fn of(
        toolpath: &Toolpath,
        range: Range<usize>,
        machine: &Machine,
        halting: &Halting,
        feedrates: &mut Vec<f64>,
    ) -> Asked {
        let is_blended = machine.interpolator.junction == Junction::AccelerationBlend;
        let has_accelerations = machine.limits_command() || machine.interpolator.look_ahead.is_finite();
        let (mut accelerations, mut first, mut largest) = (Vec::new(), None, 0.0_f64);
        let are_alike = !has_accelerations && limits::are_lines_alike(machine);
        let segments = &toolpath.segments;
        let stands_before =
            |next: usize| stands_before(segments, next, machine) || halting.stands_before(next);
        let may_stand_anywhere = turns_may_stop(machine) || halting.has_segments();
        let mut end = range.start;
        while end < range.end && (end == range.start || !stands_before(end)) {
            let index = end;
            end = if are_alike { segments.goes_on_until(index).min(range.end) } else { index + 1 };
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
                let own = limits::acceleration(&segment, machine);
                let own = positioning::acceleration(&segment, own, machine);
                feedrate = feedrate.min(junction::arc_feedrate(&segment, own, machine));
                accelerations.push(if is_blended {
                    junction::acceleration(&segment, own, machine)
                } else {
                    own
                });
            }
            feedrates.extend(repeat_n(feedrate, end - index));
        }
        if is_blended && !is_stopped_by_mode(toolpath, end, machine) {
            *accelerations.last_mut().expect("a stretch has a segment") *= 0.5;
        }
        Asked { end, accelerations, first: first.unwrap_or(0.0), largest }
    }

    /// The filters of the stretch that begins with the segment `first`, by index; they are made where there are none
    /// like them yet.
    fn filter(&self, filters: &mut Vec<FilterChain>, first: &Segment, machine: &Machine) -> usize {
        let setting = match (first.motion, &machine.rapid.time_constants) {
            (Motion::Rapid, Some(own)) => own,
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

/// The stretch being planned; its segments are counted from its first.
pub(super) struct Planned<'a> {
    toolpath: &'a Toolpath,
    pub(super) machine: &'a Machine,
    rule: Rule<'a>,
    pub(super) filter: &'a FilterChain,
    law: CornerLaw<'a>,
    pub(super) range: Range<usize>,
    pub(super) asked: &'a Asked,
}

/// A segment between its corners.
struct Commanded {
    /// Counted from the first of the stretch.
    i: usize,
    /// mm.
    length: f64,
    /// How far along it a corner's command can be held, mm.
    chord: f64,
    /// mm/s.
    feedrate: f64,
    /// What was asked for before the tolerance lowered it, mm/s.
    without_tolerance: f64,
    /// At the corner before it and after it, mm/s.
    corners: [f64; 2],
}

/// A segment on one side of a corner.
#[derive(Clone, Copy)]
struct Side {
    limit: Limit,
    /// mm.
    length: f64,
    /// Its unit tangents at its beginning and at its end.
    tangents: [Vector; 2],
    /// Command along it, mm/s.
    feedrate: f64,
    /// What was asked for before the tolerance lowered it, mm/s.
    without_tolerance: f64,
}

/// The corners of so many segments are worked out before their pulses.
const AT_ONCE: usize = 64;

impl Planned<'_> {
    fn segment(&self, i: usize) -> Segment {
        self.toolpath.segments.at(self.range.start + i)
    }

    fn curve(&self, i: usize) -> &Curve {
        self.toolpath.segments.curve(self.range.start + i)
    }

    pub(super) fn length(&self, i: usize) -> f64 {
        self.toolpath.segments.length(self.range.start + i)
    }

    /// The acceleration limit of the command on a segment, mm/s²; elsewhere accelerations act behind the filters.
    pub(super) fn acceleration(&self, i: usize) -> f64 {
        if self.machine.limits_command() { self.asked.accelerations[i] } else { f64::INFINITY }
    }

    /// Lowers the feedrates that are asked for (mm/s) to what the tolerance allows along each segment, adds the command at
    /// the corner after each (mm/s), and goes on with each `then`. Gives the blends of all corners where junctions are
    /// blends, the beginning of the stretch included.
    fn corners(
        &self,
        feedrates: &mut [f64],
        corners: &mut Vec<f64>,
        mut then: impl FnMut(&Commanded),
    ) -> Vec<Blend> {
        let mut blends = vec![Blend::none(0.0)];
        let mut limits = self.rule.tolerances().limits(self.toolpath, self.machine, self.range.start);
        let count = feedrates.len();
        // The segments whose pulses are still to come, the first of them by its number, and the corner before it.
        let mut sides: Vec<Side> = Vec::with_capacity(count.min(AT_ONCE + 1));
        let (mut first, mut before) = (0, 0.0);
        for some in feedrates.chunks_mut(AT_ONCE) {
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

    /// A segment of which a feedrate is asked (mm/s), with what its limit allows.
    fn side(&self, i: usize, asked: f64, limit: Limit) -> Side {
        let (length, tangents) = self.toolpath.segments.length_and_tangents(self.range.start + i);
        let most = match self.rule {
            Rule::Given { segments, .. } => segments[self.range.start + i],
            _ => {
                let tolerance = self.machine.interpolator.arc_tolerance.unwrap_or(limit.along());
                limits::arc_feedrate(self.curve(i), length, self.filter, tolerance)
            }
        };
        let feedrate = if most < asked { most } else { asked };
        Side { limit, length, tangents, feedrate, without_tolerance: asked }
    }

    /// The command at the corner before a segment, mm/s.
    fn corner(&self, i: usize, before: &Side, after: &Side, blends: &mut Vec<Blend>) -> f64 {
        let slower = before.feedrate.min(after.feedrate);
        let change = after.tangents[0] - before.tangents[1];
        let by_rule = match self.rule {
            Rule::Given { corners, .. } => corners[self.range.start + i - 1].min(slower),
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
        let by_rule = by_rule.min(junction::slowed(&change, slower, self.machine));
        let along = before.limit.along();
        let turn = || Turn::between(&self.segment(i - 1), &self.segment(i));
        let by_limits = match self.machine.interpolator.junction {
            Junction::Tolerance => self.axis_corner_feedrate(&change),
            Junction::AccelerationBlend => {
                let blend = turn().blend(self.machine, along, slower);
                blends.push(Blend { feedrate: blend.feedrate.min(by_rule), ..blend });
                blend.feedrate
            }
            _ => turn().feedrate(self.machine, along, [self.acceleration(i - 1), self.acceleration(i)]),
        };
        by_rule.min(by_limits)
    }

    /// The fastest corner command at which the turn keeps each axis within its jerk, mm/s: an axis whose velocity
    /// steps by c |Δu| before the filters has the jerk c |Δu| max ḣ after them. One filter has no finite jerk,
    /// and no limit on it can be kept.
    fn axis_corner_feedrate(&self, change: &Vector) -> f64 {
        let axes = &self.machine.axes;
        if axes.iter().all(|axis| axis.jerk == f64::INFINITY) {
            return f64::INFINITY;
        }
        let slope = self.filter.peak_impulse_slope();
        let axes = axes.iter().enumerate().filter(|_| slope.is_finite());
        axes.map(|(k, axis)| axis.jerk / (change[k].abs() * slope)).fold(f64::INFINITY, f64::min)
    }

    /// The pulses and the command at each corner, mm/s, where junctions are blends.
    fn blended(&self, feedrates: &[f64], blends: &[Blend]) -> (Vec<Pulse>, Vec<f64>) {
        let legs = feedrates.iter().zip(&self.asked.accelerations).enumerate();
        let leg = |(i, (&feedrate, &acceleration))| Leg { length: self.length(i), feedrate, acceleration };
        let legs: Vec<Leg> = legs.map(leg).collect();
        blend::pulses(&legs, blends, self.range.start)
    }

    /// The ramp of constant jerk by which the command of a segment changes, where it does.
    #[inline]
    pub(super) fn ramp(&self, i: usize) -> Option<Ramp> {
        let ramp = Ramp::of(self.machine, self.acceleration(i))?;
        (!positioning::applies(&self.segment(i), self.machine)).then_some(ramp)
    }

    /// A segment of a length (mm) with its feedrate and what that was without the tolerance, and with the command at its
    /// corners, mm/s.
    fn commanded(
        &self,
        i: usize,
        length: f64,
        [feedrate, without_tolerance]: [f64; 2],
        corners: [f64; 2],
    ) -> Commanded {
        let chord = limits::first_chord(self.curve(i), length, self.machine);
        Commanded { i, length, chord, feedrate, without_tolerance, corners }
    }

    /// Adds the pulses of a segment.
    fn add_pulses(&self, pulses: &mut Pulses, commanded: &Commanded) {
        let &Commanded { i, length, chord, feedrate, without_tolerance, corners } = commanded;
        let number = self.range.start + i;
        if number == FIRST_SEGMENTS {
            make_room(pulses, self.toolpath.segments.len() - FIRST_SEGMENTS);
        }
        // Before the first segment, and behind the last, the motion does not go on. Where a corner is starved, its
        // command is held as far along the segment as it would be, and not as long.
        let end = |corner: f64, is_blended: bool| {
            let command = corner.min(feedrate);
            let longer = if command < corner { corner / command } else { 1.0 };
            let hold = match is_blended {
                true => (longer * self.law.hold(corner, without_tolerance)).min(chord / command),
                false => 0.0,
            };
            End { feedrate: command, hold }
        };
        let ends = [end(corners[0], 0 < i), end(corners[1], i + 1 < self.range.len())];
        let mut offset = 0.0;
        let mut add = |(duration, first, last): Part| {
            if 0.0 < duration {
                pulses.push(Pulse { segment: number as u32, duration, offset, feedrate: [first, last] });
                offset += duration * 0.5 * (first + last);
            }
        };
        match self.ramp(i) {
            Some(ramp) => {
                let parts = ramp.parts(length, feedrate, ends[0], ends[1]);
                parts.into_iter().flat_map(|part| ramp.pieces(part)).for_each(add);
            }
            None => {
                let acceleration = self.acceleration(i);
                let parts = block::parts(length, feedrate, acceleration, ends[0], ends[1]);
                parts.into_iter().for_each(&mut add);
            }
        }
    }
}

/// Lowers the feedrates (mm/s) to those at which blocks are supplied; gives the segments that are slower than asked for, of
/// which those in `lowered` were so before.
fn starved(supplied: &[f64], feedrates: &mut [f64], lowered: &[(usize, f64)]) -> Vec<(usize, f64)> {
    let mut lowered = lowered.iter().copied().peekable();
    let each = feedrates.iter_mut().zip(supplied).enumerate();
    let of = |(i, (feedrate, most)): (usize, (&mut f64, &f64))| {
        let before = lowered.next_if(|(at, _)| *at == i);
        let asked = *feedrate;
        *feedrate = asked.min(*most);
        before.or((*most < asked).then_some((i, asked)))
    };
    each.filter_map(of).collect()
}

/// After so many segments it is known how many pulses the others need.
const FIRST_SEGMENTS: usize = 2_000;

/// Makes room for the pulses of the segments that follow the first ones: a list that grows by doubling ends with up to
/// twice the room it needs, beside what it had before. It is a guess, and does no harm where there is no such room.
fn make_room(pulses: &mut Pulses, segments: usize) {
    let of_a_segment = pulses.len() as f64 / FIRST_SEGMENTS as f64;
    pulses.try_reserve_exact((1.02 * of_a_segment * segments as f64) as usize).ok();
}
