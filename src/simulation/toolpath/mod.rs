//! Canonical moves → segments: the geometry of a program.
//!
//! A toolpath is a chain of segments, each beginning where the one before ends, in mm and in one coordinate system (the
//! machine's; work offsets, shifts, rotation, scaling and mirrors are already applied). Between segments lie the stops:
//! dwells, tool changes and other machine functions, and turns of rotary axes alone.

pub(crate) mod canonical;
pub(crate) mod compensation;
mod curve;
pub(crate) mod nurbs;
pub(crate) mod operations;
mod path_mode;
pub(crate) mod plane;
#[cfg(test)]
pub(crate) mod random;
mod segments;

pub use curve::{Arc, Curve};
pub use operations::{MOST_OPERATIONS, Operation};
pub use path_mode::{Blending, PathMode};
pub use segments::Segments;

use crate::machine::{SpindleDirection, SpindleState};
use crate::simulation::gcode::{Diagnostic, Dialect, Doubt, LineNumber};
use crate::simulation::running_sum::running_sum;

/// Moves shorter than this are rounding, mm.
pub(crate) const MIN_MOVE_MM: f64 = 1e-9;

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
    /// How far A, B and C turn along with it, rad.
    pub rotation: Rotation,
    /// The program asks for a full stop at its end (G9, G61).
    pub exact_stop: bool,
    /// The stop is that of G61, which LinuxCNC makes only where its acceleration does not allow the corner (exact path).
    pub exact_path: bool,
    /// Line of the program it comes from.
    pub line: LineNumber,
}

/// How far rotary axes turn along a segment, rad. On nearly all segments they do not, and a long program has
/// millions of those: it takes room only where they do, and copies share it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rotation(Option<std::sync::Arc<Vector>>);

impl Rotation {
    /// No turn.
    pub const NONE: Rotation = Rotation(None);

    /// Whether nothing turns.
    pub fn is_none(&self) -> bool {
        self.0.is_none()
    }
}

impl From<Vector> for Rotation {
    fn from(turn: Vector) -> Rotation {
        Rotation((turn != Vector::zeros()).then(|| std::sync::Arc::new(turn)))
    }
}

impl std::ops::Deref for Rotation {
    type Target = Vector;

    fn deref(&self) -> &Vector {
        static STILL: Vector = Vector::new(0.0, 0.0, 0.0);
        self.0.as_deref().unwrap_or(&STILL)
    }
}

/// Why the motion stops between two segments.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StopCause {
    /// G4.
    Dwell {
        /// Programmed waiting time, s.
        seconds: f64,
    },
    /// A turn of rotary axes alone.
    Rotary {
        /// How far A, B and C turn, rad.
        rotation: Vector,
        /// At the programmed rate along all three, rad/s; none: in rapid.
        rate: Option<f64>,
    },
    /// M6.
    ToolChange {
        /// The tool that comes in, where a T-word says so.
        tool: Option<u32>,
    },
    /// M6 for the tool that is in the spindle already.
    SameTool {
        /// That tool.
        tool: u32,
    },
    /// The spindle starts, stops or changes its speed.
    Spindle {
        /// What it did.
        from: SpindleState,
        /// What it is to do.
        to: SpindleState,
        /// The M-word that says so, or `None` if it is an S word alone.
        code: Option<u32>,
    },
    /// Any other M-word.
    MCode {
        /// Its number.
        code: u32,
    },
}

impl StopCause {
    /// The programmed waiting time of a dwell, s; none of any other stop.
    pub fn dwell(self) -> Option<f64> {
        match self {
            StopCause::Dwell { seconds } => Some(seconds),
            _ => None,
        }
    }
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
    /// The moves; each begins where the one before ends, and is put together when it is read.
    pub segments: Segments,
    /// The control the program was read for.
    pub dialect: Dialect,
    /// The stops, by ascending `after`; those with the same `after` in program order.
    pub stops: Vec<Stop>,
    /// The parts of the program, in order; the first begins with the first move and stop.
    pub operations: Vec<Operation>,
    /// The path modes that the program sets, by ascending `from`, each once; before the first, and
    /// where there is none, [`Blending::Machine`].
    pub path_modes: Vec<PathMode>,
    /// What the spindle does, and how many segments come before it, by ascending number, each once;
    /// before the first it stands. Beside a compensated contour up to a few moves early.
    pub spins: Vec<(usize, SpindleState)>,
    /// What was left out or assumed, of reading and tracing together, in line order.
    pub diagnostics: Vec<Diagnostic>,
    /// Why nothing of the program is run: a lathe program.
    pub declined: Option<Diagnostic>,
    /// What that leaves in doubt of the time, in the order it comes up.
    pub doubts: Vec<Doubt>,
}

impl Toolpath {
    /// The distance along the path before each segment, and at the end, mm.
    pub fn distances(&self) -> Vec<f64> {
        [0.0].into_iter().chain(self.ends()).collect()
    }

    /// The distance along the path at the end of each segment, mm.
    pub fn ends(&self) -> impl Iterator<Item = f64> {
        running_sum((0..self.segments.len()).map(|segment| self.segments.length(segment)))
    }

    /// The segments before which a running spindle changes its speed by an S word, without a stop of the program.
    pub fn speed_changes(&self) -> impl Iterator<Item = usize> {
        let changes = self.spins.windows(2).filter(|pair| {
            let [before, after] = [pair[0].1, pair[1].1];
            before.direction == after.direction && 0.0 < before.speed && before.speed != after.speed
        });
        let has_stop = |next: &usize| self.stops.binary_search_by_key(next, |stop| stop.after).is_ok();
        let is_among_moves = move |next: &usize| *next < self.segments.len() && !has_stop(next);
        changes.map(|pair| pair[1].0).filter(is_among_moves)
    }

    /// The first feed move after each start of the spindle and each change of its speed.
    pub fn feeds_at_new_speed(&self) -> impl Iterator<Item = usize> {
        let standing = (0, SpindleState::default());
        let before = [standing].into_iter().chain(self.spins.iter().copied());
        let until = self.spins[1.min(self.spins.len())..].iter().map(|next| next.0);
        let until = until.chain([self.segments.len()]);
        let spins = before.zip(&self.spins).zip(until).filter(|(((_, before), (_, own)), _)| {
            own.direction != SpindleDirection::Standing && 0.0 < own.speed && before != own
        });
        spins.filter_map(|((_, (from, _)), until)| {
            (*from..until.min(self.segments.len())).find(|at| self.segments.motion(*at) != Motion::Rapid)
        })
    }
}
