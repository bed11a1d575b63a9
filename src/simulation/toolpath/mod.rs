//! Blocks → toolpath: where the tool is told to go, and where it has to stop.
//!
//! A toolpath is a chain of segments, each beginning where the one before ends, in mm and in
//! one coordinate system (the machine's; work offsets are already applied). Between segments
//! lie the stops: dwells, tool changes and other M-words.

mod curve;

pub use curve::{Arc, Curve};

use crate::simulation::gcode::{Diagnostic, LineNumber};

/// A position, mm.
pub type Point = nalgebra::Point3<f64>;
/// A displacement, mm; a velocity, mm/s; or a direction, without unit.
pub type Vector = nalgebra::Vector3<f64>;

/// How a segment is to be run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Motion {
    /// At the machine's rapid feedrate.
    Rapid,
    /// At the programmed feedrate.
    Feed {
        /// Programmed feedrate, mm/s; positive and finite.
        feedrate: f64,
    },
}

/// One programmed move along one curve; its length is positive.
#[derive(Clone, Debug, PartialEq)]
pub struct Segment {
    /// Where it begins, mm.
    pub start: Point,
    /// Where it ends, mm.
    pub end: Point,
    /// Its shape between the two.
    pub curve: Curve,
    /// Length along the curve, mm.
    pub length: f64,
    /// Feed or rapid.
    pub motion: Motion,
    /// The program asks for a full stop at its end (G9, G61).
    pub exact_stop: bool,
    /// Line of the program it comes from.
    pub line: LineNumber,
}

/// Why the motion stops between two segments.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StopCause {
    /// G4.
    Dwell {
        /// Programmed waiting time, s.
        seconds: f64,
    },
    /// M6.
    ToolChange {
        /// The tool that comes in, where a T-word says so.
        tool: Option<u32>,
    },
    /// Any other M-word.
    MCode {
        /// Its number.
        code: u32,
    },
}

/// A full stop between two segments.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stop {
    /// How many segments come before it.
    pub after: usize,
    /// Why.
    pub cause: StopCause,
    /// Line of the program it comes from.
    pub line: LineNumber,
}

/// All moves and stops of a program, in order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Toolpath {
    /// The moves; each begins where the one before ends.
    pub segments: Vec<Segment>,
    /// The stops, by ascending `after`; those with the same `after` in program order.
    pub stops: Vec<Stop>,
    /// What was left out or assumed, of reading and tracing together, in line order.
    pub diagnostics: Vec<Diagnostic>,
}
