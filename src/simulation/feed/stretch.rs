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
//! A long program is one stretch of millions of segments, and to fetch them costs more than to reckon with them: each
//! of these steps goes over them once.

use std::ops::Range;

use crate::machine::{Junction, Machine, PlannedBy, TimeConstants};
use crate::simulation::feed::blend::{self, Blend, Leg};
use crate::simulation::feed::block::{self, End, Part};
use crate::simulation::feed::corner::CornerLaw;
use crate::simulation::feed::junction::{self, Turn};
use crate::simulation::feed::ramp::Ramp;
use crate::simulation::feed::{
    FeedPlan, Limit, Phase, Pulse, Pulses, Rule, Stretch, is_stopped_by_mode, limits, positioning,
    running_sum,
};
use crate::simulation::filter::FilterChain;
use crate::simulation::toolpath::{Motion, Segment, Toolpath, Vector};

/// Plans the segments of `range`, between two full stops.
pub(super) fn add_stretch(
    plan: &mut FeedPlan,
    range: Range<usize>,
    toolpath: &Toolpath,
    machine: &Machine,
    rule: Rule,
) {
    // Feedrates and corners of the stretch are in the lists of the plan from the beginning: a long program has no room
    // for them twice.
    let FeedPlan { filters, segment_feedrates, corner_feedrates, pulses, phases, .. } = plan;
    let (first_feedrate, first_corner, first_pulse) =
        (segment_feedrates.len(), corner_feedrates.len(), pulses.len());
    let asked = Asked::of(toolpath, range.clone(), machine, segment_feedrates);
    let feedrates = &mut segment_feedrates[first_feedrate..];
    let filter = asked.filter(filters, &toolpath.segments.at(range.start), machine);
    let chain = &filters[filter];
    let stretch = Planned { toolpath, machine, rule, filter: chain, law: CornerLaw::new(chain), range };
    let supplied = stretch.supplied(&asked);
    let is_blended = machine.interpolator.junction == Junction::AccelerationBlend;
    // A planner of ramps knows what it is supplied with.
    let is_known = is_blended || machine.interpolator.planned_by == PlannedBy::Supply;
    if is_known && let Some(supplied) = &supplied {
        feedrates.iter_mut().zip(supplied).for_each(|(feedrate, most)| *feedrate = feedrate.min(*most));
    }
    let Corners { mut blends, mut lowered } = stretch.corners(feedrates, corner_feedrates);
    if is_blended {
        blends.push(Blend::none(0.0));
        let (blended, at_corners) = stretch.blended(feedrates, &asked.accelerations, &blends);
        pulses.extend(blended);
        corner_feedrates.truncate(first_corner);
        corner_feedrates.extend(at_corners);
    } else {
        // The full stop at the end.
        corner_feedrates.push(0.0);
        let corners = &mut corner_feedrates[first_corner..];
        if let Some(supplied) = supplied.filter(|_| !is_known) {
            lowered = starved(&supplied, feedrates, &lowered);
        }
        stretch.reach(corners, feedrates, &asked);
        stretch.add_pulses(pulses, &asked, &lowered, feedrates, corners);
    }
    let pulses = first_pulse..pulses.len();
    phases.push(Phase::Motion(Stretch { segments: stretch.range, pulses, filter }));
}

/// What is asked of each segment by itself, apart from its feedrate.
struct Asked {
    /// Accelerations, mm/s²; empty where nothing depends on them.
    accelerations: Vec<f64>,
    /// The feedrate requested on the first segment, mm/s.
    first: f64,
    /// The largest feedrate requested, mm/s.
    largest: f64,
}

impl Asked {
    /// Adds to `feedrates` those asked for with every limit but the tolerance, mm/s.
    fn of(toolpath: &Toolpath, range: Range<usize>, machine: &Machine, feedrates: &mut Vec<f64>) -> Asked {
        let is_blended = machine.interpolator.junction == Junction::AccelerationBlend;
        let has_accelerations = machine.limits_command() || machine.interpolator.look_ahead.is_finite();
        let (mut accelerations, mut first, mut largest) = (Vec::new(), None, 0.0_f64);
        for segment in toolpath.segments.range(range.clone()) {
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
            feedrates.push(feedrate);
        }
        if is_blended && !is_stopped_by_mode(toolpath, range.end, machine) {
            accelerations[range.len() - 1] *= 0.5;
        }
        Asked { accelerations, first: first.unwrap_or(0.0), largest }
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
struct Planned<'a> {
    toolpath: &'a Toolpath,
    machine: &'a Machine,
    rule: Rule<'a>,
    filter: &'a FilterChain,
    law: CornerLaw<'a>,
    range: Range<usize>,
}

/// What is found beside the commands at corners.
struct Corners {
    /// Those of all corners where junctions are blends, the beginning of the stretch included.
    blends: Vec<Blend>,
    /// The segments that are slower than asked for, each with the feedrate asked for, mm/s.
    lowered: Vec<(usize, f64)>,
}

/// What a corner has to know of the segment before it.
#[derive(Clone, Copy)]
struct Before {
    limit: Limit,
    /// Command along it, mm/s.
    feedrate: f64,
    /// Its unit tangent at the corner.
    direction: Vector,
}

impl Planned<'_> {
    fn segment(&self, i: usize) -> Segment {
        self.toolpath.segments.at(self.range.start + i)
    }

    fn length(&self, i: usize) -> f64 {
        self.toolpath.segments.length(self.range.start + i)
    }

    /// The acceleration limit of the command on a segment, mm/s²; elsewhere accelerations act behind the filters.
    fn acceleration(&self, i: usize, asked: &Asked) -> f64 {
        if self.machine.limits_command() { asked.accelerations[i] } else { f64::INFINITY }
    }

    /// The feedrates at which blocks are supplied, mm/s: each processed in time, and with the way to a stop in sight; none
    /// where they are always there.
    fn supplied(&self, asked: &Asked) -> Option<Vec<f64>> {
        let interpolator = &self.machine.interpolator;
        if interpolator.block_time == 0.0 && interpolator.look_ahead == f64::INFINITY {
            return None;
        }
        let count = self.range.len();
        let mut travelled = vec![0.0];
        travelled.extend(running_sum((0..count).map(|i| self.length(i))));
        let supplied = |i: usize| {
            let processed = self.length(i) / interpolator.block_time;
            let seen = interpolator.look_ahead.min(count as f64) as usize + i;
            // Whoever sees the end of the stretch sees where it stops.
            let Some(end) = travelled.get(seen).filter(|_| seen < count) else { return processed };
            let (half_delay, acceleration) = (self.filter.half_delay(), asked.accelerations[i]);
            processed.min(limits::stopping_feedrate(end - travelled[i], half_delay, acceleration))
        };
        Some((0..count).map(supplied).collect())
    }

    /// Lowers the feedrates that are asked for (mm/s) to what the tolerance allows along each segment, and adds the
    /// command at each corner between two of them (mm/s).
    fn corners(&self, feedrates: &mut [f64], corners: &mut Vec<f64>) -> Corners {
        let mut found = Corners { blends: vec![Blend::none(0.0)], lowered: Vec::new() };
        let held = self.rule.tolerances().limits(self.toolpath, self.machine, self.range.start);
        let mut last: Option<Before> = None;
        for ((i, feedrate), limit) in feedrates.iter_mut().enumerate().zip(held) {
            let segment = self.segment(i);
            let most = match self.rule {
                Rule::Given { segments, .. } => segments[self.range.start + i],
                _ => {
                    let tolerance = self.machine.interpolator.arc_tolerance.unwrap_or(limit.along());
                    limits::arc_feedrate(&segment, self.filter, tolerance)
                }
            };
            if most < *feedrate {
                found.lowered.push((i, *feedrate));
                *feedrate = most;
            }
            let [entry, direction] = segment.tangents();
            let after = Before { limit, feedrate: *feedrate, direction: entry };
            if let Some(before) = last.replace(Before { direction, ..after }) {
                corners.push(self.corner(i, before, after, &mut found.blends));
            }
        }
        found
    }

    /// The command at the corner before a segment, mm/s.
    fn corner(&self, i: usize, before: Before, after: Before, blends: &mut Vec<Blend>) -> f64 {
        let slower = before.feedrate.min(after.feedrate);
        let change = after.direction - before.direction;
        let by_rule = match self.rule {
            Rule::Given { corners, .. } => corners[self.range.start + i - 1].min(slower),
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
            _ => turn().feedrate(self.machine, along),
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
    fn blended(&self, feedrates: &[f64], accelerations: &[f64], blends: &[Blend]) -> (Vec<Pulse>, Vec<f64>) {
        let legs = feedrates.iter().zip(accelerations).enumerate();
        let leg = |(i, (&feedrate, &acceleration))| Leg { length: self.length(i), feedrate, acceleration };
        let legs: Vec<Leg> = legs.map(leg).collect();
        blend::pulses(&legs, blends, self.range.start)
    }

    /// The ramp of constant jerk by which the command of a segment changes, where it does.
    fn ramp(&self, i: usize, asked: &Asked) -> Option<Ramp> {
        let ramp = Ramp::of(self.machine, self.acceleration(i, asked))?;
        (!positioning::applies(&self.segment(i), self.machine)).then_some(ramp)
    }

    /// Lowers the corners after each segment (mm/s) that could not be reached from, or left for, their neighbours
    /// within the acceleration limit: |c1² − c2²| ≤ 2 A L for every segment. The stretch begins and ends at a stop.
    fn reach(&self, corners: &mut [f64], feedrates: &[f64], asked: &Asked) {
        if !self.machine.limits_command() && self.machine.path.jerk == f64::INFINITY {
            return;
        }
        let reach = |from: f64, to: f64, i: usize| match self.ramp(i, asked) {
            Some(ramp) => ramp.reach(from, self.length(i), to),
            None => (from * from + 2.0 * self.acceleration(i, asked) * self.length(i)).sqrt(),
        };
        let mut before = 0.0;
        for (i, corner) in corners.iter_mut().enumerate() {
            let slower = feedrates.get(i + 1).map_or(0.0, |next| next.min(feedrates[i]));
            *corner = corner.min(slower);
            *corner = corner.min(reach(before, *corner, i));
            before = *corner;
        }
        for i in (1..corners.len()).rev() {
            let to = corners[i - 1];
            corners[i - 1] = to.min(reach(corners[i], to, i));
        }
    }

    /// Adds the pulses of all segments, commanded at `feedrates` and at the corners after them (mm/s), of which some
    /// are lowered.
    fn add_pulses(
        &self,
        pulses: &mut Pulses,
        asked: &Asked,
        lowered: &[(usize, f64)],
        feedrates: &[f64],
        corners: &[f64],
    ) {
        let mut lowered = lowered.iter().peekable();
        let mut corner = 0.0;
        for (i, (&feedrate, &next_corner)) in feedrates.iter().zip(corners).enumerate() {
            let number = self.range.start + i;
            if number == FIRST_SEGMENTS {
                make_room(pulses, self.toolpath.segments.len() - FIRST_SEGMENTS);
            }
            let segment = self.segment(i);
            let chord = limits::first_chord(&segment, self.machine);
            let without_tolerance = lowered.next_if(|(at, _)| *at == i).map_or(feedrate, |(_, asked)| *asked);
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
            let ends = [end(corner, 0 < i), end(next_corner, i + 1 < corners.len())];
            corner = next_corner;
            let mut offset = 0.0;
            let mut add = |(duration, first, last): Part| {
                if 0.0 < duration {
                    pulses.push(Pulse { segment: number as u32, duration, offset, feedrate: [first, last] });
                    offset += duration * 0.5 * (first + last);
                }
            };
            match self.ramp(i, asked) {
                Some(ramp) => {
                    let parts = ramp.parts(segment.length, feedrate, ends[0], ends[1]);
                    parts.into_iter().flat_map(|part| ramp.pieces(part)).for_each(add);
                }
                None => {
                    let acceleration = self.acceleration(i, asked);
                    let parts = block::parts(segment.length, feedrate, acceleration, ends[0], ends[1]);
                    parts.into_iter().for_each(&mut add);
                }
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
