//! Toolpath → feed plan: the pulse train that the control sends through its filters.
//!
//! Between two full stops lies a rest-to-rest motion. In it each segment becomes the pulses of [`block`];
//! [`corner`] gives the command at its corners and [`limits`] its largest feedrate. The plan is exact and
//! needs no time step: a rest-to-rest motion lasts the sum of its pulses plus the filter delay D, because the
//! filters have to run empty before the machine is at rest.
//!
//! A turn of rotary axes alone has no length along the path: it is a wait of its time, and a chain of
//! turns costs the filter delay once.
//!
//! Arcs may be planned as the chords that the control runs in place of them (module `chords`), and chains of
//! nearly straight lines as one line (module `smoothing`). With the junctions of LinuxCNC the segments of a
//! rest-to-rest motion become pulses as in [`blend`]; with a minimum cruise ratio, as in Klipper, short moves
//! stay below their feedrate (module `cruise`).
//!
//! A rest-to-rest motion ends, and so costs a full D, at
//!
//! - the beginning and the end of the program;
//! - a dwell, a tool change or another M-word: machine functions wait for the motion to end;
//! - an exact stop: G9 and G61, a corner sharper than the machine's exact-stop angle, both ends of every
//!   rapid if rapids of the machine stop or wait for position;
//! - a wait before a line (module `halts`);
//! - a change between feed and rapid under the law of LinuxCNC, which does not blend rapids with feed moves;
//! - a change between feed and rapid if rapids have their own filter constants: filters can only be exchanged
//!   at rest, or distance would be lost.
//!
//! Otherwise rapids are blended like feed moves, with the rapid feedrate along the path, as controls in
//! contouring mode do without further settings.
//!
//! Controls run an arc as chords. The corners between chords are too flat to cost time, but at a corner on
//! which an arc begins or ends the command is held along one chord only. The stand-in machine
//! (`examples/standin`) does the same, to within a millisecond. A corner on an arc may therefore leave the
//! tolerance, which `CornerMode::Guaranteed` corrects.
//!
//! Acceleration limits of axes and path act behind the filters, in [`time_scaling`]. If the machine is set
//! so, or if its junctions follow laws of acceleration, they shape the command itself.
//!
//! With constants from the jerk limit (Eq. 8, T1 = √(F/J)) F is the largest requested feedrate of the
//! rest-to-rest motion, so that the filters are constant while the machine moves. Feed and rapid then have
//! different filters, and a full stop lies between them.

pub mod blend;
pub mod block;
mod blocks;
pub mod corner;
mod circle_contact;
mod corner_blend;
mod corner_curve;
mod cruise;
mod feed_hold;
mod halts;
pub mod junction;
pub mod limits;
mod merged_path;
mod override_span;
mod parabola;
mod positioning;
mod pulses;
mod ramp;
mod reach;
pub mod time_scaling;
mod smoothing;
mod rest_to_rest;
mod step_segments;
mod substitute;
mod tolerances;

pub use corner_curve::{CornerCurve, on_curve};
pub use merged_path::MergedPath;
pub use parabola::LINUXCNC_SERVO_PERIOD_S;
pub use pulses::Pulses;
pub use smoothing::rounding;
pub use time_scaling::{FilteredTime, Knot, TimeScaling};
pub use tolerances::{SegmentTolerance, ToleranceBound, ToleranceRange, Tolerances};

use crate::machine::{Junction, Machine, TimeConstants};
use crate::simulation::feed::halts::HaltSchedule;
use crate::simulation::feed::rest_to_rest::add_rest_to_rest;
use crate::simulation::filter::FilterChain;
use crate::simulation::gcode::LineNumber;
use crate::simulation::running_sum::running_sum;
use crate::simulation::toolpath::{Curve, Segment, Segments, Stop, StopCause, Toolpath, angle_between};

/// A piece of command along one segment, linear in time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pulse {
    /// Index of the segment in the toolpath.
    pub segment: u32,
    /// Duration, s; positive.
    pub duration: f64,
    /// Distance from the start of the segment to the beginning of the pulse, mm.
    pub offset: f64,
    /// Commanded feedrate at the beginning and at the end, mm/s.
    pub feedrate: [f64; 2],
}

/// A motion from one full stop to the next.
#[derive(Clone, Debug, PartialEq)]
pub struct RestToRest {
    /// Indices of the segments in the toolpath.
    pub segments: std::ops::Range<usize>,
    /// Indices of the pulses in the plan.
    pub pulses: std::ops::Range<usize>,
    /// Index of the filter chain in the plan.
    pub filter: usize,
}

/// Time without motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wait {
    /// Duration, s.
    pub duration: f64,
    /// Reason for the wait.
    pub cause: StopCause,
    /// Line of the program.
    pub line: LineNumber,
}

/// A phase of the plan.
#[derive(Clone, Debug, PartialEq)]
pub enum Phase {
    /// The machine moves.
    Motion(RestToRest),
    /// The machine waits.
    Wait(Wait),
}

/// The pulse train of a whole program.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FeedPlan {
    /// Time before the first phase, s.
    pub start: f64,
    /// Motions and waits in order.
    pub phases: Vec<Phase>,
    /// All pulses in order.
    pub pulses: Pulses,
    /// Filter chains in use.
    pub filters: Vec<FilterChain>,
    /// Command at the corner after each segment, mm/s; 0 at a full stop.
    pub corner_feedrates: Vec<f64>,
    /// Command along each segment between its corners, mm/s.
    pub segment_feedrates: Vec<f64>,
    /// The curve in place of the corner behind each segment: of the merged path if there is one, otherwise of the
    /// program. Empty unless the control blends corners in time.
    pub corner_curves: Vec<CornerCurve>,
    /// The path with its merged lines; `None` if the control merges none, or has filters, which round the programmed path.
    pub merged_path: Option<MergedPath>,
    /// Time lost behind the filters through acceleration limits; `None` if they cost nothing.
    pub time_scaling: Option<TimeScaling>,
}

/// The choice of the feedrates of corners and arcs.
#[derive(Clone, Copy, Debug)]
pub enum CornerPolicy<'a> {
    /// By the laws of [`corner`] and [`limits`] for this contour tolerance, mm.
    Isolated(f64),
    /// By the same laws for the program's tolerances, and for the machine's where the program sets none.
    Programmed,
    /// By given feedrates, mm/s, one entry per segment; every other limit still applies.
    Given {
        /// At the corner after each segment.
        corners: &'a [f64],
        /// Along each segment, instead of the law for arcs.
        segments: &'a [f64],
    },
}

impl CornerPolicy<'_> {
    /// Returns the source of the tolerances; given feedrates need none.
    fn tolerances(self) -> Tolerances {
        match self {
            CornerPolicy::Isolated(tolerance) => Tolerances::One(tolerance),
            CornerPolicy::Programmed | CornerPolicy::Given { .. } => Tolerances::Programmed,
        }
    }
}

impl From<Tolerances> for CornerPolicy<'_> {
    fn from(tolerances: Tolerances) -> Self {
        match tolerances {
            Tolerances::One(tolerance) => CornerPolicy::Isolated(tolerance),
            Tolerances::Programmed => CornerPolicy::Programmed,
        }
    }
}

impl Pulse {
    /// Returns `true` if the pulse is a halt that the program does not request.
    pub fn is_halt(&self) -> bool {
        self.feedrate == [0.0, 0.0]
    }

    /// Returns the distance along the segment `elapsed` seconds after the pulse began, mm.
    pub fn offset_after(&self, elapsed: f64) -> f64 {
        let slope = (self.feedrate[1] - self.feedrate[0]) / self.duration;
        self.offset + elapsed * (self.feedrate[0] + 0.5 * slope * elapsed)
    }
}

impl FeedPlan {
    /// Returns the cycle time, s: all pulses, the waits, and for each motion the filter delay and the time
    /// lost behind the filters. Exact to rounding, except for that lost time.
    pub fn cycle_time(&self) -> f64 {
        let durations = self.phases.iter().flat_map(|phase| match phase {
            Phase::Wait(wait) => [wait.duration, 0.0, 0.0],
            Phase::Motion(rest_to_rest) => {
                let delay = self.filters[rest_to_rest.filter].delay();
                [self.command_time(rest_to_rest), delay, time_scaling::lost_time(self.knots(rest_to_rest))]
            }
        });
        running_sum([self.start].into_iter().chain(durations)).last().unwrap_or(0.0)
    }

    /// Returns the cycle time without its waits, s.
    pub fn motion_time(&self) -> f64 {
        let waits = self.phases.iter().map(|phase| match phase {
            Phase::Wait(wait) => wait.duration,
            Phase::Motion(_) => 0.0,
        });
        self.cycle_time() - self.start - waits.sum::<f64>()
    }

    /// Returns the longest filter delay, s.
    pub fn longest_delay(&self) -> f64 {
        self.filters.iter().map(FilterChain::delay).fold(0.0, f64::max)
    }

    /// Returns the rest-to-rest motions in order.
    pub fn rest_to_rest_motions(&self) -> impl Iterator<Item = &RestToRest> {
        self.phases.iter().filter_map(|phase| match phase {
            Phase::Motion(rest_to_rest) => Some(rest_to_rest),
            Phase::Wait(_) => None,
        })
    }

    /// Returns the knots of a motion that loses time behind the filters; empty if it loses none.
    pub fn knots(&self, rest_to_rest: &RestToRest) -> &[Knot] {
        self.time_scaling.as_ref().map_or(&[], |time_scaling| time_scaling.knots(rest_to_rest))
    }

    /// Returns the total duration of the pulses of a motion, s. The motion lasts longer by the filter delay
    /// and by the time lost behind the filters.
    pub fn command_time(&self, rest_to_rest: &RestToRest) -> f64 {
        total_duration(&self.pulses, rest_to_rest)
    }
}

/// Returns the total duration of the pulses of a motion, s.
fn total_duration(pulses: &Pulses, rest_to_rest: &RestToRest) -> f64 {
    running_sum(rest_to_rest.pulses.clone().map(|pulse| pulses.duration(pulse))).last().unwrap_or(0.0)
}

/// Returns the plan of a toolpath on a machine without the time lost behind the filters, which
/// [`simulate`](crate::simulation::simulate) adds.
pub(crate) fn command(toolpath: &Toolpath, machine: &Machine, policy: CornerPolicy) -> FeedPlan {
    match override_span::divided(toolpath, machine) {
        Some((divided, machine)) => {
            divided.planned(toolpath, policy, |toolpath, policy| plan_of_curves(toolpath, &machine, policy))
        }
        None => plan_of_curves(toolpath, machine, policy),
    }
}

/// Returns the plan with the blocks that the control runs: arcs whole or as chords, and ends at whole steps.
fn plan_of_curves(toolpath: &Toolpath, machine: &Machine, policy: CornerPolicy) -> FeedPlan {
    match blocks::blocks(toolpath, machine) {
        Some(blocks) => {
            blocks.planned(toolpath, policy, |toolpath, policy| plan_of_segments(toolpath, machine, policy))
        }
        None => plan_of_segments(toolpath, machine, policy),
    }
}

/// Returns the plan with each segment run as given, except for lines that are merged.
fn plan_of_segments(toolpath: &Toolpath, machine: &Machine, policy: CornerPolicy) -> FeedPlan {
    match smoothing::merged(toolpath, machine, policy.tolerances()) {
        Some(merged) => {
            // A feed hold occurs at a place of the program that merged lines may not contain.
            let (without, holds) = halts::feed_holds_apart(machine);
            let mut plan = merged
                .planned(toolpath, policy, |toolpath, policy| plan_as_written(toolpath, &without, policy));
            if let Some(holds) = holds {
                HaltSchedule::of(toolpath, &holds).put_into(&mut plan, toolpath, &holds);
            }
            plan
        }
        None => plan_as_written(toolpath, machine, policy),
    }
}

/// Returns the plan without substitutes for arcs, overrides or lines: each segment is planned as one block.
fn plan_as_written(toolpath: &Toolpath, machine: &Machine, policy: CornerPolicy) -> FeedPlan {
    let mut plan = FeedPlan { start: machine.times.start, ..FeedPlan::default() };
    plan.segment_feedrates.reserve_exact(toolpath.segments.len());
    plan.corner_feedrates.reserve_exact(toolpath.segments.len());
    let halts = HaltSchedule::of(toolpath, machine);
    let segments = &toolpath.segments;
    let mut stops = toolpath.stops.iter().peekable();
    let mut left = StopState::default();
    let mut begin = 0;
    while begin < segments.len() {
        while let Some(stop) = stops.next_if(|stop| stop.after <= begin) {
            add_wait(&mut plan, stop, machine, &mut left);
        }
        let next_stop = stops.peek().map_or(segments.len(), |stop| stop.after.min(segments.len()));
        begin = add_rest_to_rest(&mut plan, begin..next_stop, toolpath, machine, &halts, policy);
    }
    for stop in stops {
        add_wait(&mut plan, stop, machine, &mut left);
    }
    halts.put_into(&mut plan, toolpath, machine);
    plan
}

/// The spindle and tool state that one stop passes to the next.
#[derive(Default)]
struct StopState {
    /// Time that the spindle still needs when a later word waits for it, s.
    ramp: f64,
    /// `true` after a tool change.
    has_changed: bool,
}

fn add_wait(plan: &mut FeedPlan, stop: &Stop, machine: &Machine, left: &mut StopState) {
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

/// Returns the time by which a turn of rotary axes alone outlasts its command, s, while the filters run
/// empty. A jerk limit acts on X, Y and Z and does not lengthen a turn.
fn turn_delay(machine: &Machine) -> f64 {
    machine.interpolator.filter_delay(0.0)
}

fn wait(stop: &Stop, machine: &Machine) -> Wait {
    Wait { duration: stop_time(stop, machine), cause: stop.cause, line: stop.line }
}

/// Returns the time of a stop by itself, s: the first tool change, and words that wait for the spindle, may differ.
pub fn stop_time(stop: &Stop, machine: &Machine) -> f64 {
    match stop.cause {
        StopCause::Dwell { seconds } => seconds + machine.times.dwell_excess,
        StopCause::Rotary { rotation, rate } => limits::rotary_time(&rotation, rate, machine),
        StopCause::ToolChange { tool } => machine.times.of_tool_change(tool),
        StopCause::SameTool { .. } => 0.0,
        StopCause::Spindle { from, to, code } => machine.times.of_spindle(from, to, code),
        StopCause::MCode { code } => machine.times.of_m_code(code),
    }
}

/// Returns `true` if the machine stops before the segment `next` without a programmed stop.
fn stands_before(segments: &Segments, next: usize, machine: &Machine) -> bool {
    // Nearly all segments are feed moves after feed moves, and then only a turn can stop the machine.
    (turns_may_stop(machine) || !segments.is_plain_continuation(next))
        && stands_between(&segments.at(next - 1), &segments.at(next), machine)
}

/// Returns `true` if the machine stops between two consecutive segments without a programmed stop.
fn stands_between(before: &Segment, after: &Segment, machine: &Machine) -> bool {
    let rapid = |segment: &Segment| segment.motion.is_rapid();
    let own_filters = machine.rapid.time_constants.is_some()
        || matches!(machine.interpolator.time_constants, TimeConstants::FromJerk(_));
    before.exact_stop && !halts::is_exact_path(before, machine)
        || (rapid(before) != rapid(after) && (own_filters || junction::stops_at_rapids(machine)))
        || ((rapid(before) || rapid(after)) && machine.rapid.exact_stop)
        || halts::rapid_ends_stop(before, machine)
        || positioning::applies(before, machine)
        || positioning::applies(after, machine)
        || exact_stop_by_turn(before, after, machine) && !halts::is_exact_path(before, machine)
}

/// Returns `true` if the corner between two segments is sharper than the machine's exact-stop angle.
fn exact_stop_by_turn(before: &Segment, after: &Segment, machine: &Machine) -> bool {
    stops_at_every_end(machine)
        || turns_may_stop(machine) && machine.interpolator.stopping_angle() < turn(before, after)
}

/// Returns `true` if the machine stops at the end of every block, even on a straight line, as after G61.1 of
/// LinuxCNC.
fn stops_at_every_end(machine: &Machine) -> bool {
    machine.interpolator.stopping_angle() == 0.0
}

/// Returns `true` if any turn can make the machine stop.
fn turns_may_stop(machine: &Machine) -> bool {
    machine.interpolator.stopping_angle() < std::f64::consts::PI
}

/// Returns `true` if the path mode causes the stop before segment `next`, so that the stop is known in
/// advance; `false` at the end of the program and at a function that waits.
fn is_stopped_by_mode(toolpath: &Toolpath, next: usize, machine: &Machine) -> bool {
    let before = toolpath.segments.at(next - 1);
    before.exact_stop
        || machine.interpolator.junction == Junction::ExactPath
        || stops_at_every_end(machine)
        || (!is_end_of_queue(toolpath, next) && stands_before(&toolpath.segments, next, machine))
}

/// Returns `true` if the control has no move behind segment `next − 1` while that moves: a function waits for its end,
/// or the program ends.
fn is_end_of_queue(toolpath: &Toolpath, next: usize) -> bool {
    toolpath.segments.len() <= next || !toolpath.stops_at(next).is_empty()
}

/// Returns `true` for an arc behind which no move is queued: LinuxCNC finds the feedrate and the acceleration that the
/// turn and the corners of an arc leave only once the next move comes (tcFinalizeLength).
fn is_unqueued_arc(toolpath: &Toolpath, index: usize) -> bool {
    *toolpath.segments.curve(index) != Curve::Line && is_end_of_queue(toolpath, index + 1)
}

/// Returns the angle by which the path turns between two segments, rad.
fn turn(before: &Segment, after: &Segment) -> f64 {
    angle_between(&before.tangent(before.length), &after.tangent(0.0))
}
