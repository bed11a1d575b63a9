//! The share of each operation and each tool in the cycle time.
//!
//! Operations follow one another without gaps, and every operation has one tool, so that the sums over all
//! operations and over all tools are the whole. A tool change counts for the tool that enters the spindle.
//! Where the motion continues from one operation to the next without a stop, each segment counts for the
//! operation to which it belongs.

use std::ops::Range;

use crate::machine::Machine;
use crate::quote::breakdown::{Breakdown, Ledger};
use crate::simulation::feed::FeedPlan;
use crate::simulation::feed::limits::rapid_feedrate;
use crate::simulation::gcode::LineNumber;
use crate::simulation::running_sum::{RunningSum, running_sum};
use crate::simulation::toolpath::{Motion, Operation, Segment, StopCause, Toolpath};

/// The time and moves of a part of a program.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TimeShare {
    /// Time by kind.
    pub breakdown: Breakdown,
    /// CAM's estimate, s.
    pub programmed: f64,
    /// Length of the feed moves, mm.
    pub feed_length: f64,
    /// Length of the rapid moves, mm.
    pub rapid_length: f64,
    /// Number of moves.
    pub moves: usize,
}

impl TimeShare {
    /// Returns the time, s.
    pub fn time(&self) -> f64 {
        self.breakdown.total()
    }

    /// Returns the time beyond CAM's estimate, s.
    pub fn lost(&self) -> f64 {
        self.time() - self.programmed
    }
}

impl std::ops::AddAssign for TimeShare {
    fn add_assign(&mut self, more: TimeShare) {
        self.breakdown += more.breakdown;
        self.programmed += more.programmed;
        self.feed_length += more.feed_length;
        self.rapid_length += more.rapid_length;
        self.moves += more.moves;
    }
}

/// An operation with its share.
#[derive(Clone, Debug, PartialEq)]
pub struct OperationShare {
    /// The operation.
    pub operation: Operation,
    /// Least and greatest line of its moves and stops.
    pub lines: (LineNumber, LineNumber),
    /// Distance along the path at which its moves begin and end, mm.
    pub distance: (f64, f64),
    /// Share of the cycle time.
    pub share: TimeShare,
}

/// A tool with its share.
#[derive(Clone, Debug, PartialEq)]
pub struct ToolShare {
    /// Number of the tool; `None` if no T word gives it.
    pub tool: Option<u32>,
    /// Name in a comment.
    pub name: Option<String>,
    /// Number of its operations.
    pub operations: usize,
    /// Share of the cycle time.
    pub share: TimeShare,
}

/// Returns CAM's estimate, s: length over programmed feedrate, rapids at the rapid feedrate, and dwells,
/// without ramps, corners, tool changes and overrides.
pub fn programmed_time(toolpath: &Toolpath, machine: &Machine) -> f64 {
    let moves = toolpath.segments.iter().map(|segment| segment.length / programmed(&segment, machine));
    let dwells = toolpath.stops.iter().map(|stop| programmed_wait(&stop.cause, machine));
    running_sum(moves.chain(dwells)).last().unwrap_or(0.0)
}

/// Returns the programmed feedrate of a segment, mm/s.
pub(super) fn programmed(segment: &Segment, machine: &Machine) -> f64 {
    match segment.motion {
        Motion::Rapid { .. } => rapid_feedrate(segment, machine),
        Motion::Feed { feedrate } => feedrate,
    }
}

/// Returns CAM's estimate of a stop, s.
pub(super) fn programmed_wait(cause: &StopCause, machine: &Machine) -> f64 {
    match *cause {
        StopCause::Dwell { seconds } => seconds,
        StopCause::Rotary { rotation, rate: Some(rate) } => rotation.norm() / rate,
        StopCause::Rotary { rotation, rate: None } => rotation.amax() / machine.rapid.rotary_rate,
        _ => 0.0,
    }
}

/// Returns the share of each operation; a toolpath without operations counts as one.
pub(super) fn operation_shares(
    toolpath: &Toolpath,
    machine: &Machine,
    plan: &FeedPlan,
) -> Vec<OperationShare> {
    let ledger = Ledger::new(toolpath, machine, plan);
    let whole = [Operation::default()];
    let operations = if toolpath.operations.is_empty() { &whole[..] } else { &toolpath.operations };
    let ends = operations.iter().skip(1).map(|next| (next.first_segment, next.first_stop));
    let ends = ends.chain([(toolpath.segments.len(), toolpath.stops.len())]);
    let mut travelled = RunningSum::default();
    let shares = operations.iter().zip(ends).map(|(operation, (segments_end, stops_end))| {
        let (segments, stops) = (operation.first_segment..segments_end, operation.first_stop..stops_end);
        let (share, (first, last)) = share(toolpath, machine, &ledger, segments, stops);
        let begin = travelled.value();
        travelled.add(share.feed_length);
        travelled.add(share.rapid_length);
        OperationShare {
            operation: operation.clone(),
            lines: (first.min(last), last),
            distance: (begin, travelled.value()),
            share,
        }
    });
    shares.collect()
}

/// Returns the share of these segments and stops, and their first and last line; the lines are in reverse
/// order if there are no segments and stops.
fn share(
    toolpath: &Toolpath,
    machine: &Machine,
    ledger: &Ledger,
    segments: Range<usize>,
    stops: Range<usize>,
) -> (TimeShare, (LineNumber, LineNumber)) {
    let moves = toolpath.segments.range(segments.clone());
    let mut lines = (LineNumber(u32::MAX), LineNumber(0));
    let mut pass = |line: LineNumber| lines = (lines.0.min(line), lines.1.max(line));
    let [mut time, mut feed_length, mut rapid_length] = [RunningSum::default(); 3];
    // One pass for all sums: assembling millions of segments takes longer than adding them.
    for segment in moves.clone() {
        let length = if segment.motion.is_rapid() { &mut rapid_length } else { &mut feed_length };
        length.add(segment.length);
        time.add(segment.length / programmed(&segment, machine));
        pass(segment.line);
    }
    for stop in &toolpath.stops[stops.clone()] {
        time.add(programmed_wait(&stop.cause, machine));
        pass(stop.line);
    }
    let share = TimeShare {
        programmed: time.value(),
        feed_length: feed_length.value(),
        rapid_length: rapid_length.value(),
        moves: moves.len(),
        breakdown: ledger.breakdown(segments, stops),
    };
    (share, lines)
}

/// Returns the share of each tool in the order of first use.
pub(super) fn tool_shares(operations: &[OperationShare]) -> Vec<ToolShare> {
    let mut tools: Vec<ToolShare> = Vec::new();
    for OperationShare { operation, share, .. } in operations {
        match tools.iter_mut().find(|tool| tool.tool == operation.tool) {
            Some(tool) => {
                tool.operations += 1;
                tool.share += *share;
                tool.name = tool.name.take().or_else(|| operation.tool_name.clone());
            }
            None => tools.push(ToolShare {
                tool: operation.tool,
                name: operation.tool_name.clone(),
                operations: 1,
                share: *share,
            }),
        }
    }
    tools
}
