//! Toolpath → feed plan: the pulse train that the control sends through its filters.
//!
//! Between two full stops lies a stretch. In it each segment becomes the pulses of [`block`], its
//! corners taken as in [`corner`] and its feedrate limited as in [`limits`]. The plan is exact
//! and needs no time step: a stretch lasts the sum of its pulses plus the filter delay D, because
//! the filters have to run empty before the machine stands.
//!
//! A turn of rotary axes alone has no length along the path: it is a wait of its time, and a chain of
//! turns costs the filter delay once.
//!
//! Chains of nearly straight lines may be planned as one, as in the module of smoothing. With the junctions
//! of LinuxCNC the segments of a stretch become pulses as in [`blend`].
//!
//! What ends a stretch, each costing a full D:
//!
//! - the beginning and the end of the program;
//! - a dwell, a tool change or another M-word: machine functions wait for the motion to end;
//! - an exact stop: G9 and G61, a corner sharper than the machine's exact-stop angle, both ends
//!   of every rapid where the machine has rapids stop or wait for position;
//! - a wait before a line, of `halts`;
//! - a change of the filters' constants, between feed and rapid, where rapids have their own:
//!   filters can only be exchanged while the machine stands, or distance would be lost.
//!
//! Otherwise rapids are blended like feed moves, with the rapid feedrate along the path: that is
//! the neutral setting of controls in contouring mode.
//!
//! Controls run an arc as chords. The corners between chords are too flat to cost anything, but what the
//! command holds for the corner on which an arc begins or ends is held along one chord only. This is
//! what the stand-in machine does, by a millisecond; a corner on an arc may so leave the tolerance by
//! itself, which `CornerMode::Guaranteed` corrects.
//!
//! Acceleration limits of axes and path act behind the filters, in [`retiming`]; where the machine says so, or
//! junctions follow laws of acceleration, they shape the command itself.
//!
//! With constants from the jerk limit (Eq. 8, T1 = √(F/J)) F is the largest feedrate asked for in
//! the stretch, so that the filters are constant while the machine moves; feed and rapid then
//! differ, and are joined by a full stop.

pub mod blend;
pub mod block;
pub mod corner;
mod halts;
pub mod junction;
pub mod limits;
mod positioning;
mod ramp;
pub mod retiming;
mod smoothing;
mod tolerances;

pub use retiming::{Knot, Pace, Retiming};
pub use tolerances::{Bound, Held, Limit, Tolerances};

use crate::machine::{Junction, Machine, TimeConstants};
use crate::simulation::feed::blend::{Blend, Leg};
use crate::simulation::feed::block::{End, Part};
use crate::simulation::feed::corner::CornerLaw;
use crate::simulation::feed::halts::Halting;
use crate::simulation::feed::junction::Turn;
use crate::simulation::feed::ramp::Ramp;
use crate::simulation::filter::FilterChain;
use crate::simulation::gcode::LineNumber;
use crate::simulation::toolpath::{Motion, Segment, Stop, StopCause, Toolpath, Vector};

/// A piece of command along one segment, linear in time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pulse {
    /// Index of the segment.
    pub segment: u32,
    /// Duration, s; positive.
    pub duration: f64,
    /// Distance from the start of the segment to where the pulse begins, mm.
    pub offset: f64,
    /// Commanded feedrate at its beginning and at its end, mm/s.
    pub feedrate: [f64; 2],
}

/// Motion from one full stop to the next.
#[derive(Clone, Debug, PartialEq)]
pub struct Stretch {
    /// Its segments in the toolpath.
    pub segments: std::ops::Range<usize>,
    /// Its pulses in the plan.
    pub pulses: std::ops::Range<usize>,
    /// Its filters in the plan.
    pub filter: usize,
}

/// Time that is not motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wait {
    /// How long, s.
    pub duration: f64,
    /// Why.
    pub cause: StopCause,
    /// Line of the program.
    pub line: LineNumber,
}

/// What the machine does next.
#[derive(Clone, Debug, PartialEq)]
pub enum Phase {
    /// It moves.
    Motion(Stretch),
    /// It waits.
    Wait(Wait),
}

/// The pulse train of a whole program.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FeedPlan {
    /// Time before the first phase, s.
    pub start: f64,
    /// Motion and waits in order.
    pub phases: Vec<Phase>,
    /// All pulses in order.
    pub pulses: Vec<Pulse>,
    /// The filter chains in use.
    pub filters: Vec<FilterChain>,
    /// Command at the corner after each segment, mm/s; 0 at a full stop.
    pub corner_feedrates: Vec<f64>,
    /// Command along each segment between its corners, mm/s.
    pub segment_feedrates: Vec<f64>,
    /// What acceleration limits behind the filters cost; none where they cost nothing.
    pub retiming: Option<Retiming>,
}

/// By what the corners and arcs are commanded.
#[derive(Clone, Copy, Debug)]
pub enum Rule<'a> {
    /// By the laws of [`corner`] and [`limits`] for this contour tolerance, mm.
    Isolated(f64),
    /// By the same laws for the tolerances that the program sets, and the machine's where it sets none.
    Programmed,
    /// By feedrates found elsewhere, mm/s, one entry a segment; every other limit still holds.
    Given {
        /// At the corner after each segment.
        corners: &'a [f64],
        /// Along each segment, in place of the law for arcs.
        segments: &'a [f64],
    },
}

impl Rule<'_> {
    /// What the tolerances are taken from; where feedrates are given none is asked for.
    fn tolerances(self) -> Tolerances {
        match self {
            Rule::Isolated(tolerance) => Tolerances::One(tolerance),
            Rule::Programmed | Rule::Given { .. } => Tolerances::Programmed,
        }
    }
}

impl From<Tolerances> for Rule<'_> {
    fn from(tolerances: Tolerances) -> Self {
        match tolerances {
            Tolerances::One(tolerance) => Rule::Isolated(tolerance),
            Tolerances::Programmed => Rule::Programmed,
        }
    }
}

impl Pulse {
    /// Whether it is one of the halts that the program does not ask for.
    pub fn is_halt(&self) -> bool {
        self.feedrate == [0.0, 0.0]
    }
}

impl FeedPlan {
    /// Cycle time, s: all pulses, the filter delay of every stretch and what it loses behind the filters,
    /// and the waits. Exact but for the rounding of the last digit and what is lost.
    pub fn cycle_time(&self) -> f64 {
        let durations = self.phases.iter().flat_map(|phase| match phase {
            Phase::Wait(wait) => [wait.duration, 0.0, 0.0],
            Phase::Motion(stretch) => {
                let delay = self.filters[stretch.filter].delay();
                [self.command_time(stretch), delay, retiming::lost(self.knots(stretch))]
            }
        });
        running_sum([self.start].into_iter().chain(durations)).last().unwrap_or(0.0)
    }

    /// The stretches of motion in order.
    pub fn stretches(&self) -> impl Iterator<Item = &Stretch> {
        self.phases.iter().filter_map(|phase| match phase {
            Phase::Motion(stretch) => Some(stretch),
            Phase::Wait(_) => None,
        })
    }

    /// The knots of a stretch where it loses time behind the filters; none where it does not.
    pub fn knots(&self, stretch: &Stretch) -> &[Knot] {
        self.retiming.as_ref().map_or(&[], |retiming| retiming.knots(stretch))
    }

    /// How long the pulses of a stretch last, s; the motion lasts the filter delay longer, and what it
    /// loses behind the filters.
    pub fn command_time(&self, stretch: &Stretch) -> f64 {
        let durations = self.pulses[stretch.pulses.clone()].iter().map(|pulse| pulse.duration);
        running_sum(durations).last().unwrap_or(0.0)
    }
}

/// The sums of the first 1, 2, 3 … values, each as if rounded once: Neumaier's summation, so that
/// a million blocks lose no more digits than one.
pub fn running_sum(values: impl Iterator<Item = f64>) -> impl Iterator<Item = f64> {
    values.scan((0.0f64, 0.0), |(sum, lost), value| {
        let next = *sum + value;
        *lost += if value.abs() <= sum.abs() { (*sum - next) + value } else { (value - next) + *sum };
        *sum = next;
        Some(next + *lost)
    })
}

/// The feed plan of a toolpath on a machine.
pub fn plan(toolpath: &Toolpath, machine: &Machine, rule: Rule) -> FeedPlan {
    let Some(merged) = smoothing::merged(toolpath, machine, rule.tolerances()) else {
        return plan_as_written(toolpath, machine, rule);
    };
    let given = merged.given(rule);
    let rule = given.as_ref().map_or(rule, |(corners, segments)| Rule::Given { corners, segments });
    merged.spread(plan_as_written(&merged.toolpath, machine, rule), toolpath)
}

/// The plan with each block run as it is written.
fn plan_as_written(toolpath: &Toolpath, machine: &Machine, rule: Rule) -> FeedPlan {
    let mut plan = FeedPlan { start: machine.times.start, ..FeedPlan::default() };
    plan.segment_feedrates.reserve_exact(toolpath.segments.len());
    plan.corner_feedrates.reserve_exact(toolpath.segments.len());
    let halting = Halting::of(toolpath, machine);
    let segments = &toolpath.segments;
    let mut stops = toolpath.stops.iter().peekable();
    let mut left = Left::default();
    let mut begin = 0;
    while begin < segments.len() {
        while let Some(stop) = stops.next_if(|stop| stop.after <= begin) {
            add_wait(&mut plan, stop, machine, &mut left);
        }
        let next_stop = stops.peek().map_or(usize::MAX, |stop| stop.after);
        let mut end = begin + 1;
        while end < segments.len()
            && end != next_stop
            && !stands_between(&segments.at(end - 1), &segments.at(end), machine)
            && !halting.stands_before(end)
        {
            end += 1;
        }
        add_stretch(&mut plan, begin..end, toolpath, machine, rule);
        begin = end;
    }
    for stop in stops {
        add_wait(&mut plan, stop, machine, &mut left);
    }
    halting.put_into(&mut plan, toolpath, machine);
    plan
}

/// What stops leave to those that follow.
#[derive(Default)]
struct Left {
    /// What the spindle still needs where a later word waits for it, s.
    ramp: f64,
    /// Whether a tool was changed.
    has_changed: bool,
}

fn add_wait(plan: &mut FeedPlan, stop: &Stop, machine: &Machine, left: &mut Left) {
    let is_turn = |cause: &StopCause| matches!(cause, StopCause::Rotary { .. });
    let goes_on = matches!(plan.phases.last(), Some(Phase::Wait(wait)) if is_turn(&wait.cause));
    let mut wait = wait(stop, machine);
    if is_turn(&wait.cause) && !goes_on {
        wait.duration += turn_delay(machine);
    }
    let awaited_by = &machine.times.spindle_awaited_by;
    match stop.cause {
        StopCause::Spindle { from, to, .. } if !awaited_by.is_empty() => {
            left.ramp = machine.times.of_spindle_ramp(from, to);
        }
        StopCause::MCode { code } if awaited_by.contains(&code) => {
            wait.duration += std::mem::take(&mut left.ramp);
        }
        StopCause::ToolChange { .. } => {
            let is_first = !std::mem::replace(&mut left.has_changed, true);
            if let Some(first) = machine.times.first_tool_change.filter(|_| is_first) {
                wait.duration = first;
            }
        }
        _ => {}
    }
    plan.phases.push(Phase::Wait(wait));
}

/// How much longer than its command a turn of rotary axes alone lasts, s: the filters run empty. A
/// jerk limit is one along X, Y and Z, and says nothing of it.
fn turn_delay(machine: &Machine) -> f64 {
    match &machine.interpolator.time_constants {
        TimeConstants::Equal(constant) => machine.interpolator.filters as f64 * constant,
        TimeConstants::Unequal(constants) => constants.iter().sum(),
        TimeConstants::FromJerk(_) => 0.0,
    }
}

fn wait(stop: &Stop, machine: &Machine) -> Wait {
    let duration = match stop.cause {
        StopCause::Dwell { seconds } => seconds,
        StopCause::Rotary { rotation, rate } => limits::rotary_time(&rotation, rate, machine),
        StopCause::ToolChange { tool } => machine.times.of_tool_change(tool),
        StopCause::SameTool { .. } => 0.0,
        StopCause::Spindle { from, to, code } => machine.times.of_spindle(from, to, code),
        StopCause::MCode { code } => machine.times.of_m_code(code),
    };
    Wait { duration, cause: stop.cause, line: stop.line }
}

/// Whether the machine stands between two segments without being told to by a stop.
fn stands_between(before: &Segment, after: &Segment, machine: &Machine) -> bool {
    let rapid = |segment: &Segment| segment.motion == Motion::Rapid;
    let own_filters = machine.rapid.time_constants.is_some()
        || matches!(machine.interpolator.time_constants, TimeConstants::FromJerk(_));
    before.exact_stop
        || (rapid(before) != rapid(after) && own_filters)
        || ((rapid(before) || rapid(after)) && machine.rapid.exact_stop)
        || halts::rapid_ends_stop(before, machine)
        || positioning::applies(before, machine)
        || positioning::applies(after, machine)
        || exact_stop_by_turn(before, after, machine)
}

/// Whether the corner between two segments is sharper than the machine's exact-stop angle.
fn exact_stop_by_turn(before: &Segment, after: &Segment, machine: &Machine) -> bool {
    let angle = machine.interpolator.stopping_angle();
    angle < std::f64::consts::PI && angle < turn(before, after)
}

/// Whether the stop before segment `next` is one of the path mode, known before it is reached, and not
/// the end of the program or a function that waits.
fn is_stopped_by_mode(toolpath: &Toolpath, next: usize, machine: &Machine) -> bool {
    let waits = toolpath.stops.binary_search_by_key(&next, |stop| stop.after).is_ok();
    let before = toolpath.segments.at(next - 1);
    before.exact_stop
        || (!waits && toolpath.segments.get(next).is_some_and(|next| stands_between(&before, &next, machine)))
}

/// The angle by which the path turns between two segments, rad.
fn turn(before: &Segment, after: &Segment) -> f64 {
    let (u1, u2) = (before.tangent(before.length), after.tangent(0.0));
    // Through the half angle: acos loses digits where the turn is small.
    2.0 * (u2 - u1).norm().atan2((u2 + u1).norm())
}

fn add_stretch(
    plan: &mut FeedPlan,
    range: std::ops::Range<usize>,
    toolpath: &Toolpath,
    machine: &Machine,
    rule: Rule,
) {
    // By their indices, so that lists know how long they will be.
    let segments = range.clone().map(|index| toolpath.segments.at(index));
    let requested: Vec<f64> = (segments.clone())
        .map(|s| positioning::feedrate(&s, limits::requested_feedrate(&s, machine), machine))
        .collect();
    let filter = filter_of_stretch(plan, &toolpath.segments.at(range.start), &requested, machine);
    let chain = &plan.filters[filter];
    let law = CornerLaw::new(chain);
    let (mut without_tolerance, mut accelerations) = (requested, Vec::with_capacity(range.len()));
    for (segment, feedrate) in segments.clone().zip(&mut without_tolerance) {
        let own = positioning::acceleration(&segment, limits::acceleration(&segment, machine), machine);
        let on_curve = limits::curve_feedrate(&segment, machine);
        *feedrate = feedrate.min(on_curve).min(junction::arc_feedrate(&segment, own, machine));
        accelerations.push(own);
    }
    let tolerances = rule.tolerances();
    if machine.interpolator.junction == Junction::AccelerationBlend {
        for (acceleration, segment) in accelerations.iter_mut().zip(segments.clone()) {
            *acceleration = junction::acceleration(&segment, *acceleration, machine);
        }
        if !is_stopped_by_mode(toolpath, range.end, machine) {
            accelerations[range.len() - 1] *= 0.5;
        }
    }
    let lengths = range.clone().map(|index| toolpath.segments.length(index));
    limit_by_look_ahead(&mut without_tolerance, lengths, &accelerations, machine, chain);
    if !machine.limits_command() {
        // There the limits act behind the filters.
        accelerations = Vec::new();
    }
    let acceleration = |i: usize| accelerations.get(i).copied().unwrap_or(f64::INFINITY);
    // Feedrates and corners of the stretch are those of the plan, which keeps them: a long program has no room for both.
    let (first_feedrate, first_corner) = (plan.segment_feedrates.len(), plan.corner_feedrates.len());
    let held = tolerances.limits(toolpath, machine, range.start);
    let feedrates = (segments.clone().zip(&without_tolerance).zip(held).enumerate()).map(
        |(i, ((segment, &feedrate), limit))| match rule {
            Rule::Given { segments, .. } => feedrate.min(segments[range.start + i]),
            _ => feedrate.min(limits::arc_feedrate(
                &segment,
                chain,
                machine.interpolator.arc_tolerance.unwrap_or(limit.along()),
            )),
        },
    );
    plan.segment_feedrates.extend(feedrates);
    let feedrates = &plan.segment_feedrates[first_feedrate..];
    let mut blends = vec![Blend::none(0.0)];
    let held = tolerances.limits(toolpath, machine, range.start);
    let held = held.zip(tolerances.limits(toolpath, machine, range.start + 1));
    let mut first = toolpath.segments.at(range.start);
    for (i, (limit, next_limit)) in (0..range.len() - 1).zip(held) {
        let second = toolpath.segments.at(range.start + i + 1);
        let (before, after) = (feedrates[i], feedrates[i + 1]);
        let slower = before.min(after);
        let change = second.tangent(0.0) - first.tangent(first.length);
        let by_rule = match rule {
            Rule::Given { corners, .. } => corners[range.start + i].min(slower),
            _ => {
                let turn = change.norm();
                law.feedrate(limit.towards(next_limit, turn) / turn, before, after)
            }
        };
        let by_rule = by_rule.min(junction::slowed(&change, slower, machine));
        let by_limits = match machine.interpolator.junction {
            Junction::Tolerance => axis_corner_feedrate(&change, machine, chain),
            Junction::AccelerationBlend => {
                let blend = Turn::between(&first, &second).blend(machine, limit.along(), slower);
                blends.push(Blend { feedrate: blend.feedrate.min(by_rule), ..blend });
                blend.feedrate
            }
            _ => Turn::between(&first, &second).feedrate(machine, limit.along()),
        };
        plan.corner_feedrates.push(by_rule.min(by_limits));
        first = second;
    }
    if machine.interpolator.junction == Junction::AccelerationBlend {
        blends.push(Blend::none(0.0));
        let first_pulse = plan.pulses.len();
        let legs: Vec<Leg> = (segments.zip(feedrates).zip(&accelerations))
            .map(|((segment, &feedrate), &acceleration)| Leg {
                length: segment.length,
                feedrate,
                acceleration,
            })
            .collect();
        let (pulses, at_corners) = blend::pulses(&legs, &blends, range.start);
        plan.pulses.extend(pulses);
        plan.corner_feedrates.truncate(first_corner);
        plan.corner_feedrates.extend(at_corners);
        let pulses = first_pulse..plan.pulses.len();
        plan.phases.push(Phase::Motion(Stretch { segments: range, pulses, filter }));
        return;
    }
    // The full stop at the end.
    plan.corner_feedrates.push(0.0);
    let corners = &mut plan.corner_feedrates[first_corner..];
    let segment = |i: usize| toolpath.segments.at(range.start + i);
    let ramp =
        |i: usize| Ramp::of(machine, acceleration(i)).filter(|_| !positioning::applies(&segment(i), machine));
    if !accelerations.is_empty() || machine.path.jerk.is_finite() {
        let length = |i: usize| toolpath.segments.length(range.start + i);
        limit_by_acceleration(corners, length, acceleration, ramp);
    }
    let first_pulse = plan.pulses.len();
    for (i, segment) in segments.enumerate() {
        if range.start + i == FIRST_SEGMENTS {
            make_room(&mut plan.pulses, toolpath.segments.len() - FIRST_SEGMENTS);
        }
        // Beyond the corner before the first segment, and beyond that after the last, the motion does not go on.
        let end = |feedrate: f64, blended: bool| End {
            feedrate,
            hold: if blended {
                let chord = limits::first_chord(&segment, machine) / feedrate;
                law.hold(feedrate, without_tolerance[i]).min(chord)
            } else {
                0.0
            },
        };
        let before = if i == 0 { end(0.0, false) } else { end(corners[i - 1], true) };
        let ends = [before, end(corners[i], i + 1 < range.len())];
        let mut offset = 0.0;
        let mut add = |(duration, first, last): Part| {
            if 0.0 < duration {
                let segment = (range.start + i) as u32;
                plan.pulses.push(Pulse { segment, duration, offset, feedrate: [first, last] });
                offset += duration * 0.5 * (first + last);
            }
        };
        match ramp(i) {
            Some(ramp) => {
                let parts = ramp.parts(segment.length, feedrates[i], ends[0], ends[1]);
                parts.into_iter().flat_map(|part| ramp.pieces(part)).for_each(add);
            }
            None => {
                let parts = block::parts(segment.length, feedrates[i], acceleration(i), ends[0], ends[1]);
                parts.into_iter().for_each(&mut add);
            }
        }
    }
    plan.phases.push(Phase::Motion(Stretch {
        segments: range,
        pulses: first_pulse..plan.pulses.len(),
        filter,
    }));
}

/// After so many segments it is known how many pulses the others need.
const FIRST_SEGMENTS: usize = 2_000;

/// Makes room for the pulses of the segments that follow the first ones: a list that grows by doubling ends with up to
/// twice the room it needs, beside what it had before. It is a guess, and does no harm where there is no such room.
fn make_room(pulses: &mut Vec<Pulse>, segments: usize) {
    let of_a_segment = pulses.len() as f64 / FIRST_SEGMENTS as f64;
    pulses.try_reserve_exact((1.02 * of_a_segment * segments as f64) as usize).ok();
}

/// The filters of a stretch with this `first` segment, by index; they are made where the plan does not have them yet.
fn filter_of_stretch(plan: &mut FeedPlan, first: &Segment, feedrates: &[f64], machine: &Machine) -> usize {
    let setting = match (first.motion, &machine.rapid.time_constants) {
        (Motion::Rapid, Some(own)) => own,
        _ => &machine.interpolator.time_constants,
    };
    let order = machine.interpolator.filters;
    let constants = match setting {
        _ if positioning::applies(first, machine) => {
            vec![positioning::time_constant(first, feedrates[0], machine); order]
        }
        TimeConstants::Equal(constant) => vec![*constant; order],
        TimeConstants::FromJerk(jerk) => {
            let largest = feedrates.iter().copied().fold(0.0, f64::max);
            vec![(largest / jerk).sqrt(); order]
        }
        TimeConstants::Unequal(constants) => constants.clone(),
    };
    let known = plan.filters.iter().rposition(|filter| filter.time_constants() == constants);
    known.unwrap_or_else(|| {
        plan.filters.push(FilterChain::new(&constants));
        plan.filters.len() - 1
    })
}

/// The fastest corner command at which the turn keeps each axis within its jerk: an axis whose velocity
/// steps by c |Δu| before the filters has the jerk c |Δu| max ḣ after them. One filter has no finite jerk,
/// and no limit on it can be kept.
fn axis_corner_feedrate(change: &Vector, machine: &Machine, filter: &FilterChain) -> f64 {
    if machine.axes.iter().all(|axis| axis.jerk == f64::INFINITY) {
        return f64::INFINITY;
    }
    let slope = filter.peak_impulse_slope();
    let axes = machine.axes.iter().enumerate().filter(|_| slope.is_finite());
    axes.map(|(k, axis)| axis.jerk / (change[k].abs() * slope)).fold(f64::INFINITY, f64::min)
}

/// Lowers feedrates from which the motion could not stop within the blocks the control sees.
fn limit_by_look_ahead(
    feedrates: &mut [f64],
    lengths: impl Iterator<Item = f64>,
    accelerations: &[f64],
    machine: &Machine,
    filter: &FilterChain,
) {
    if machine.interpolator.look_ahead == f64::INFINITY {
        return;
    }
    let blocks = machine.interpolator.look_ahead as usize;
    let mut travelled = vec![0.0];
    travelled.extend(running_sum(lengths));
    for i in 0..feedrates.len().saturating_sub(blocks) {
        let visible = travelled[i + blocks] - travelled[i];
        let stopping = limits::stopping_feedrate(visible, filter.half_delay(), accelerations[i]);
        feedrates[i] = feedrates[i].min(stopping);
    }
}

/// Lowers the corners after each segment that could not be reached from, or left for, their neighbours
/// within the acceleration limit: |c1² − c2²| ≤ 2 A L for every segment. The stretch begins and ends at a stop.
fn limit_by_acceleration(
    corners: &mut [f64],
    length: impl Fn(usize) -> f64,
    acceleration: impl Fn(usize) -> f64,
    ramp: impl Fn(usize) -> Option<Ramp>,
) {
    let reach = |from: f64, to: f64, i: usize| match ramp(i) {
        Some(ramp) => ramp.reach(from, length(i), to),
        None => (from * from + 2.0 * acceleration(i) * length(i)).sqrt(),
    };
    let mut before = 0.0;
    for (i, corner) in corners.iter_mut().enumerate() {
        *corner = corner.min(reach(before, *corner, i));
        before = *corner;
    }
    for i in (1..corners.len()).rev() {
        let to = corners[i - 1];
        corners[i - 1] = to.min(reach(corners[i], to, i));
    }
}
