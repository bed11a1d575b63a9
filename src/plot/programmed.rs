//! The programmed feedrate: steps, one per segment.

use std::ops::Range;

use crate::machine::Machine;
use crate::plot::{Column, within};
use crate::simulation::feed::limits::rapid_feedrate;
use crate::simulation::toolpath::{Motion, Toolpath};

/// The programmed feedrate as steps over distance, one step per segment.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Programmed {
    /// End of each segment, distance along the path, mm; ascending.
    pub end: Vec<f64>,
    /// Programmed feedrate of each segment, or the machine's rapid feedrate, mm/s.
    pub feedrate: Column,
    /// `true` for each rapid move.
    pub rapid: Vec<bool>,
    /// Line of the program of each segment.
    pub line: Vec<u32>,
    /// Ranges of consecutive rapid moves.
    pub(super) rapids: Vec<Range<usize>>,
    /// Highest feedrate of a feed move, mm/s.
    pub(super) highest_cutting: f64,
    /// Time by length over feedrate up to each end, s; in a chart over time the distance of each end, mm.
    pub(super) other: Vec<f64>,
    /// `true` if the steps are not drawn.
    pub hidden: bool,
}

impl Programmed {
    /// Returns the steps of a toolpath on a machine.
    pub fn of(toolpath: &Toolpath, machine: &Machine) -> Programmed {
        let (end, feedrate, rapid, line) = Programmed::columns(toolpath, machine);
        Programmed::new(end, feedrate, rapid, line)
    }

    /// Returns the columns of the steps, in the order of the arguments of [`Programmed::new`].
    pub fn columns(toolpath: &Toolpath, machine: &Machine) -> (Vec<f64>, Vec<f64>, Vec<bool>, Vec<u32>) {
        let (mut ends, mut feedrates, mut rapids, mut lines) = (vec![], vec![], vec![], vec![]);
        for (segment, end) in toolpath.segments.iter().zip(toolpath.ends()) {
            let (feedrate, rapid) = match segment.motion {
                Motion::Rapid { .. } => (rapid_feedrate(&segment, machine), true),
                Motion::Feed { feedrate } => (feedrate, false),
            };
            ends.push(end);
            feedrates.push(feedrate);
            rapids.push(rapid);
            lines.push(segment.line.0);
        }
        (ends, feedrates, rapids, lines)
    }

    /// Returns the steps of columns of equal length: ends of segments (mm), feedrates (mm/s), rapid moves and
    /// lines of the program.
    pub fn new(end: Vec<f64>, feedrate: Vec<f64>, rapid: Vec<bool>, line: Vec<u32>) -> Programmed {
        let cutting = feedrate.iter().zip(&rapid).filter(|(_, rapid)| !**rapid);
        let highest_cutting = cutting.fold(0.0, |top: f64, (feedrate, _)| top.max(*feedrate));
        let mut rapids = Vec::new();
        let mut next = 0;
        for alike in rapid.chunk_by(|a, b| a == b) {
            let own = next..next + alike.len();
            next = own.end;
            if alike[0] {
                rapids.push(own);
            }
        }
        let (mut begin, mut time) = (0.0, 0.0);
        let times = end.iter().zip(&feedrate).map(|(&end, feedrate)| {
            let seconds = (end - std::mem::replace(&mut begin, end)) / feedrate;
            time += if seconds.is_finite() { seconds } else { 0.0 };
            time
        });
        let other = times.collect();
        Programmed {
            end,
            feedrate: feedrate.into(),
            rapid,
            line,
            rapids,
            highest_cutting,
            other,
            hidden: false,
        }
    }

    /// Returns the beginning of a segment, mm.
    pub(super) fn start(&self, index: usize) -> f64 {
        index.checked_sub(1).map_or(0.0, |before| self.end[before])
    }

    /// Returns the indices of the segments that overlap two distances (mm).
    pub(super) fn within(&self, between: (f64, f64)) -> Range<usize> {
        within(&self.end, between)
    }
}
