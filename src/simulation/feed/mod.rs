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
//! Arcs may be planned as the chords that the control runs in place of them, as in the module of chords, and chains of
//! nearly straight lines as one, as in the module of smoothing. With the junctions of LinuxCNC the segments of a stretch
//! become pulses as in [`blend`]; with a minimum part of cruising, as in Klipper, short moves stay below their feedrate.
//!
//! What ends a stretch, each costing a full D:
//!
//! - the beginning and the end of the program;
//! - a dwell, a tool change or another M-word: machine functions wait for the motion to end;
//! - an exact stop: G9 and G61, a corner sharper than the machine's exact-stop angle, both ends
//!   of every rapid where the machine has rapids stop or wait for position;
//! - a wait before a line, of `halts`;
//! - a change from feed to rapid and back under the law of LinuxCNC, which blends no rapid with a feed move;
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
//! Acceleration limits of axes and path act behind the filters, in [`time_scaling`]; where the machine says so, or
//! junctions follow laws of acceleration, they shape the command itself.
//!
//! With constants from the jerk limit (Eq. 8, T1 = √(F/J)) F is the largest feedrate asked for in
//! the stretch, so that the filters are constant while the machine moves; feed and rapid then
//! differ, and are joined by a full stop.

pub mod blend;
pub mod block;
mod chords;
pub mod corner;
mod cruise;
mod halts;
pub mod junction;
pub mod limits;
mod positioning;
mod pulses;
mod ramp;
mod reach;
pub mod time_scaling;
mod smoothing;
mod stretch;
mod substitute;
mod tolerances;

pub use pulses::Pulses;
pub use smoothing::rounding;
pub use time_scaling::{Knot, Pace, TimeScaling};
pub use tolerances::{Bound, Held, Limit, Tolerances};

use crate::machine::{Machine, TimeConstants};
use crate::simulation::feed::halts::Halting;
use crate::simulation::feed::stretch::add_stretch;
use crate::simulation::filter::FilterChain;
use crate::simulation::gcode::LineNumber;
use crate::simulation::running_sum::running_sum;
use crate::simulation::toolpath::{Motion, Segment, Segments, Stop, StopCause, Toolpath};

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
    pub pulses: Pulses,
    /// The filter chains in use.
    pub filters: Vec<FilterChain>,
    /// Command at the corner after each segment, mm/s; 0 at a full stop.
    pub corner_feedrates: Vec<f64>,
    /// Command along each segment between its corners, mm/s.
    pub segment_feedrates: Vec<f64>,
    /// What acceleration limits behind the filters cost; none where they cost nothing.
    pub time_scaling: Option<TimeScaling>,
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

    /// How far along its segment the command is so long (s) after the pulse began, mm.
    pub fn offset_after(&self, elapsed: f64) -> f64 {
        let slope = (self.feedrate[1] - self.feedrate[0]) / self.duration;
        self.offset + elapsed * (self.feedrate[0] + 0.5 * slope * elapsed)
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
                [self.command_time(stretch), delay, time_scaling::lost(self.knots(stretch))]
            }
        });
        running_sum([self.start].into_iter().chain(durations)).last().unwrap_or(0.0)
    }

    /// The longest of the filter delays, s.
    pub fn longest_delay(&self) -> f64 {
        self.filters.iter().map(FilterChain::delay).fold(0.0, f64::max)
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
        self.time_scaling.as_ref().map_or(&[], |time_scaling| time_scaling.knots(stretch))
    }

    /// How long the pulses of a stretch last, s; the motion lasts the filter delay longer, and what it
    /// loses behind the filters.
    pub fn command_time(&self, stretch: &Stretch) -> f64 {
        let durations = stretch.pulses.clone().map(|pulse| self.pulses.duration(pulse));
        running_sum(durations).last().unwrap_or(0.0)
    }
}

/// The command on a machine as a plan: complete but for the time that acceleration limits cost behind the filters, which
/// [`simulate`](crate::simulation::simulate) adds.
pub(crate) fn command(toolpath: &Toolpath, machine: &Machine, rule: Rule) -> FeedPlan {
    match chords::chorded(toolpath, machine) {
        Some(chorded) => {
            chorded.planned(toolpath, rule, |toolpath, rule| plan_of_segments(toolpath, machine, rule))
        }
        None => plan_of_segments(toolpath, machine, rule),
    }
}

/// The plan with each segment run as it is, but for lines that are merged.
fn plan_of_segments(toolpath: &Toolpath, machine: &Machine, rule: Rule) -> FeedPlan {
    match smoothing::merged(toolpath, machine, rule.tolerances()) {
        Some(merged) => {
            merged.planned(toolpath, rule, |toolpath, rule| plan_as_written(toolpath, machine, rule))
        }
        None => plan_as_written(toolpath, machine, rule),
    }
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
        let next_stop = stops.peek().map_or(segments.len(), |stop| stop.after.min(segments.len()));
        begin = add_stretch(&mut plan, begin..next_stop, toolpath, machine, &halting, rule);
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

/// Whether the machine stands before the segment `next` without being told to by a stop.
fn stands_before(segments: &Segments, next: usize, machine: &Machine) -> bool {
    // Nearly all go on in feed, and then only a turn can stop the machine.
    (turns_may_stop(machine) || !segments.goes_on(next))
        && stands_between(&segments.at(next - 1), &segments.at(next), machine)
}

/// The same, of two segments that follow one another.
fn stands_between(before: &Segment, after: &Segment, machine: &Machine) -> bool {
    let rapid = |segment: &Segment| segment.motion == Motion::Rapid;
    let own_filters = machine.rapid.time_constants.is_some()
        || matches!(machine.interpolator.time_constants, TimeConstants::FromJerk(_));
    before.exact_stop
        || (rapid(before) != rapid(after) && (own_filters || junction::stops_at_rapids(machine)))
        || ((rapid(before) || rapid(after)) && machine.rapid.exact_stop)
        || halts::rapid_ends_stop(before, machine)
        || positioning::applies(before, machine)
        || positioning::applies(after, machine)
        || exact_stop_by_turn(before, after, machine)
}

/// Whether the corner between two segments is sharper than the machine's exact-stop angle.
fn exact_stop_by_turn(before: &Segment, after: &Segment, machine: &Machine) -> bool {
    turns_may_stop(machine) && machine.interpolator.stopping_angle() < turn(before, after)
}

/// Whether the machine stops at a corner for its angle, be it the sharpest.
fn turns_may_stop(machine: &Machine) -> bool {
    machine.interpolator.stopping_angle() < std::f64::consts::PI
}

/// Whether the stop before segment `next` is one of the path mode, known before it is reached, and not
/// the end of the program or a function that waits.
fn is_stopped_by_mode(toolpath: &Toolpath, next: usize, machine: &Machine) -> bool {
    let waits = toolpath.stops.binary_search_by_key(&next, |stop| stop.after).is_ok();
    let before = toolpath.segments.at(next - 1);
    before.exact_stop
        || (!waits && next < toolpath.segments.len() && stands_before(&toolpath.segments, next, machine))
}

/// The angle by which the path turns between two segments, rad.
fn turn(before: &Segment, after: &Segment) -> f64 {
    let (u1, u2) = (before.tangent(before.length), after.tangent(0.0));
    // Through the half angle: acos loses digits where the turn is small.
    2.0 * (u2 - u1).norm().atan2((u2 + u1).norm())
}
