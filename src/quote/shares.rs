//! What each operation and each tool takes of the cycle time.
//!
//! Operations follow one another without gaps, and every operation has one tool, so that the sums
//! over all operations and over all tools are the whole. A tool's change counts for the tool that
//! comes in. A move that goes through from one operation to the next without a stop counts for the
//! operation its segment belongs to.

use std::ops::Range;

use crate::machine::Machine;
use crate::quote::breakdown::{Breakdown, Ledger};
use crate::simulation::feed::{FeedPlan, running_sum};
use crate::simulation::gcode::LineNumber;
use crate::simulation::toolpath::{Motion, Operation, Segment, Stop, StopCause, Toolpath};

/// What a part of a program takes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Share {
    /// Where its time goes.
    pub breakdown: Breakdown,
    /// What CAM would say of it, s.
    pub programmed: f64,
    /// Length of its feed moves, mm.
    pub feed_length: f64,
    /// Length of its rapid moves, mm.
    pub rapid_length: f64,
    /// How many moves it has.
    pub moves: usize,
}

impl Share {
    /// How long it takes, s.
    pub fn time(&self) -> f64 {
        self.breakdown.total()
    }

    /// How much longer it takes than CAM would say, s.
    pub fn lost(&self) -> f64 {
        self.time() - self.programmed
    }
}

impl std::ops::AddAssign for Share {
    fn add_assign(&mut self, more: Share) {
        self.breakdown += more.breakdown;
        self.programmed += more.programmed;
        self.feed_length += more.feed_length;
        self.rapid_length += more.rapid_length;
        self.moves += more.moves;
    }
}

/// An operation and what it takes.
#[derive(Clone, Debug, PartialEq)]
pub struct OperationShare {
    /// The operation.
    pub operation: Operation,
    /// Least and greatest line of its moves and stops.
    pub lines: (LineNumber, LineNumber),
    /// Where its moves begin and end along the path, mm.
    pub distance: (f64, f64),
    /// What it takes.
    pub share: Share,
}

/// A tool and what it takes.
#[derive(Clone, Debug, PartialEq)]
pub struct ToolShare {
    /// Its number; none where no T word says so.
    pub tool: Option<u32>,
    /// What a comment calls it.
    pub name: Option<String>,
    /// How many operations it has.
    pub operations: usize,
    /// What it takes.
    pub share: Share,
}

/// What CAM would say, s: length over programmed feedrate, rapids at the rapid feedrate, dwells;
/// no ramps, no corners, no changes, no overrides.
pub fn programmed_time(toolpath: &Toolpath, machine: &Machine) -> f64 {
    programmed_time_of(toolpath.segments.iter(), &toolpath.stops, machine)
}

fn programmed_time_of(segments: impl Iterator<Item = Segment>, stops: &[Stop], machine: &Machine) -> f64 {
    let moves = segments.map(|segment| match segment.motion {
        Motion::Rapid => segment.length / machine.rapid.feedrate,
        Motion::Feed { feedrate } => segment.length / feedrate,
    });
    let dwells = stops.iter().map(|stop| programmed_wait(&stop.cause, machine));
    running_sum(moves.chain(dwells)).last().unwrap_or(0.0)
}

/// What CAM would say of a stop, s.
pub(super) fn programmed_wait(cause: &StopCause, machine: &Machine) -> f64 {
    match *cause {
        StopCause::Dwell { seconds } => seconds,
        StopCause::Rotary { rotation, rate: Some(rate) } => rotation.norm() / rate,
        StopCause::Rotary { rotation, rate: None } => rotation.amax() / machine.rapid.rotary_rate,
        _ => 0.0,
    }
}

/// What each operation of a toolpath takes; a toolpath without operations is a single one.
pub(super) fn of_operations(toolpath: &Toolpath, machine: &Machine, plan: &FeedPlan) -> Vec<OperationShare> {
    let ledger = Ledger::new(toolpath, machine, plan);
    let whole = [Operation::default()];
    let operations = if toolpath.operations.is_empty() { &whole[..] } else { &toolpath.operations };
    let ends = operations.iter().skip(1).map(|next| (next.first_segment, next.first_stop));
    let ends = ends.chain([(toolpath.segments.len(), toolpath.stops.len())]);
    let mut travelled = 0.0;
    let shares = operations.iter().zip(ends).map(|(operation, (segments_end, stops_end))| {
        let (segments, stops) = (operation.first_segment..segments_end, operation.first_stop..stops_end);
        let share = share(toolpath, machine, &ledger, segments.clone(), stops.clone());
        let lines = toolpath.segments.range(segments).map(|segment| segment.line);
        let lines = lines.chain(toolpath.stops[stops].iter().map(|stop| stop.line));
        let (first, last) = lines.fold((LineNumber(u32::MAX), LineNumber(0)), |(first, last), line| {
            (first.min(line), last.max(line))
        });
        let begin = travelled;
        travelled += share.feed_length + share.rapid_length;
        OperationShare {
            operation: operation.clone(),
            lines: (first.min(last), last),
            distance: (begin, travelled),
            share,
        }
    });
    shares.collect()
}

fn share(
    toolpath: &Toolpath,
    machine: &Machine,
    ledger: &Ledger,
    segments: Range<usize>,
    stops: Range<usize>,
) -> Share {
    let moves = toolpath.segments.range(segments.clone());
    let length = |rapid: bool| {
        let moves = moves.clone().filter(|segment| (segment.motion == Motion::Rapid) == rapid);
        running_sum(moves.map(|segment| segment.length)).last().unwrap_or(0.0)
    };
    Share {
        programmed: programmed_time_of(moves.clone(), &toolpath.stops[stops.clone()], machine),
        feed_length: length(false),
        rapid_length: length(true),
        moves: moves.len(),
        breakdown: ledger.breakdown(segments, stops),
    }
}

/// What each tool takes, in the order of first use.
pub(super) fn of_tools(operations: &[OperationShare]) -> Vec<ToolShare> {
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
