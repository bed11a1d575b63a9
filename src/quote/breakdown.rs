//! Feed plan → breakdown: the parts of the cycle time for cutting, rapids, dwells, tool changes and machine
//! functions.
//!
//! The breakdown adds up to the cycle time. Each pulse counts for the motion of its segment, the filter delay
//! of a rest-to-rest motion half for its first and half for its last segment, time lost behind the filters
//! for the segment on which it is lost, and each wait for its cause. Halts in motion that the program does
//! not request are other time. A part of a program has a breakdown by the same rules, so that parts add up to
//! the whole.

use std::ops::Range;

use crate::machine::{MCodeGroup, Machine};
use crate::simulation::feed::{FeedPlan, Phase, Wait};
use crate::simulation::running_sum::RunningSum;
use crate::simulation::toolpath::{StopCause, Toolpath};

/// The cycle time by kind, s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Breakdown {
    /// Feed moves.
    pub cutting: f64,
    /// Rapid moves.
    pub rapid: f64,
    /// Programmed dwells.
    pub dwell: f64,
    /// Tool changes.
    pub tool_change: f64,
    /// Other time.
    pub other: f64,
    /// The other time by function; adds up to `other`.
    pub functions: FunctionBreakdown,
}

/// Time of machine functions, s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FunctionBreakdown {
    /// Starts, stops and changes of speed of the spindle.
    pub spindle: f64,
    /// Coolant on and off.
    pub coolant: f64,
    /// Program stops and optional stops.
    pub stops: f64,
    /// Pallet changes.
    pub pallet: f64,
    /// Clamping and unclamping.
    pub clamp: f64,
    /// Other M-words.
    pub m_words: f64,
    /// From the start of the program to its first block.
    pub start: f64,
    /// Halts in motion that the program does not request: feed holds, waits.
    pub halts: f64,
}

impl Breakdown {
    /// Returns the sum of all kinds of time, s.
    pub fn total(&self) -> f64 {
        self.cutting + self.rapid + self.dwell + self.tool_change + self.other
    }
}

impl std::ops::AddAssign for Breakdown {
    fn add_assign(&mut self, more: Breakdown) {
        self.cutting += more.cutting;
        self.rapid += more.rapid;
        self.dwell += more.dwell;
        self.tool_change += more.tool_change;
        self.other += more.other;
        self.functions += more.functions;
    }
}

impl std::ops::AddAssign for FunctionBreakdown {
    fn add_assign(&mut self, more: FunctionBreakdown) {
        self.spindle += more.spindle;
        self.coolant += more.coolant;
        self.stops += more.stops;
        self.pallet += more.pallet;
        self.clamp += more.clamp;
        self.m_words += more.m_words;
        self.start += more.start;
        self.halts += more.halts;
    }
}

/// Returns the breakdown of a plan.
pub fn breakdown(toolpath: &Toolpath, machine: &Machine, plan: &FeedPlan) -> Breakdown {
    Ledger::new(toolpath, machine, plan).breakdown(0..toolpath.segments.len(), 0..toolpath.stops.len())
}

/// A plan prepared for the breakdown of its parts: the work for a part is proportional to its size.
pub(super) struct Ledger<'a> {
    toolpath: &'a Toolpath,
    machine: &'a Machine,
    plan: &'a FeedPlan,
    /// The segments at the ends of rest-to-rest motions, each with half the filter delay (s), in order.
    ends: Vec<(usize, f64)>,
    /// The waits, one per stop.
    waits: Vec<&'a Wait>,
}

impl<'a> Ledger<'a> {
    pub(super) fn new(toolpath: &'a Toolpath, machine: &'a Machine, plan: &'a FeedPlan) -> Ledger<'a> {
        let (mut ends, mut waits) = (Vec::new(), Vec::new());
        for phase in &plan.phases {
            match phase {
                Phase::Motion(rest_to_rest) => {
                    let half = plan.filters[rest_to_rest.filter].half_delay();
                    ends.extend([(rest_to_rest.segments.start, half), (rest_to_rest.segments.end - 1, half)]);
                }
                Phase::Wait(wait) => waits.push(wait),
            }
        }
        Ledger { toolpath, machine, plan, ends, waits }
    }

    /// Returns the breakdown of these segments and stops.
    pub(super) fn breakdown(&self, segments: Range<usize>, stops: Range<usize>) -> Breakdown {
        let mut breakdown = Breakdown::default();
        if segments.start == 0 && stops.start == 0 {
            breakdown.functions.start = self.plan.start;
            breakdown.other = self.plan.start;
        }
        let is_rapid = |segment: usize| self.toolpath.segments.motion(segment).is_rapid();
        let pulses = &self.plan.pulses;
        let (mut cutting, mut rapid, mut halts) = (RunningSum::default(), RunningSum::default(), 0.0);
        let mut add = |segment: usize, time: f64| {
            let moves = if is_rapid(segment) { &mut rapid } else { &mut cutting };
            moves.add(time);
        };
        for pulse in pulses.range(pulses.of_segments(segments.clone())) {
            if pulse.is_halt() {
                halts += pulse.duration;
            } else {
                add(pulse.segment as usize, pulse.duration);
            }
        }
        let before = |segment: usize| self.ends.partition_point(|(end, _)| *end < segment);
        for &(end, half) in &self.ends[before(segments.start)..before(segments.end)] {
            add(end, half);
        }
        let lost =
            self.plan.time_scaling.as_ref().map_or(&[][..], |time_scaling| time_scaling.lost_on(segments));
        for &(segment, lost) in lost {
            add(segment, lost);
        }
        breakdown.functions.halts = halts;
        breakdown.other += halts;
        (breakdown.cutting, breakdown.rapid) = (cutting.value(), rapid.value());
        for wait in &self.waits[stops] {
            let functions = &mut breakdown.functions;
            let function = match wait.cause {
                StopCause::Dwell { .. } => {
                    breakdown.dwell += wait.duration;
                    continue;
                }
                StopCause::Rotary { rate, .. } => {
                    let is_rapid = rate.is_none();
                    *(if is_rapid { &mut breakdown.rapid } else { &mut breakdown.cutting }) += wait.duration;
                    continue;
                }
                StopCause::ToolChange { .. } | StopCause::SameTool { .. } => {
                    breakdown.tool_change += wait.duration;
                    continue;
                }
                StopCause::Spindle { .. } => &mut functions.spindle,
                StopCause::MCode { code } => match self.machine.times.function(code) {
                    MCodeGroup::Coolant => &mut functions.coolant,
                    MCodeGroup::Stop => &mut functions.stops,
                    MCodeGroup::Pallet => &mut functions.pallet,
                    MCodeGroup::Clamp => &mut functions.clamp,
                    MCodeGroup::Other => &mut functions.m_words,
                },
            };
            *function += wait.duration;
            breakdown.other += wait.duration;
        }
        breakdown
    }
}
