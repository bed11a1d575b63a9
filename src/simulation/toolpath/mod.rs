//! Canonical functions → segments: the geometry of a program.
//!
//! A toolpath is a chain of segments, each beginning where the one before ends, in mm and in the coordinate system
//! of the machine; work offsets, shifts, rotation, scaling and mirrors are already applied. Between segments lie
//! the stops: dwells, tool changes and other machine functions, and turns of rotary axes alone.

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

pub use curve::{Arc, Curve, angle_between, distance_from_chord};
pub use operations::{MAX_OPERATIONS, Operation};
pub use path_mode::{Blending, PathMode};
pub use segments::Segments;

use crate::machine::{SpindleDirection, SpindleState};
use crate::simulation::gcode::{Diagnostic, Dialect, Doubt, LineNumber};
use crate::simulation::running_sum::running_sum;

/// Shorter moves are rounding errors, mm.
pub(crate) const MIN_MOVE_MM: f64 = 1e-9;

/// A position, mm.
pub type Point = nalgebra::Point3<f64>;
/// A displacement, mm; a velocity, mm/s; or a direction, without unit.
pub type Vector = nalgebra::Vector3<f64>;

/// The feedrate of a segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Motion {
    /// At the machine's rapid feedrate, or at the programmed one on controls that run rapids at that.
    Rapid {
        /// Feedrate that the program has set for feed moves, mm/s; infinite if it has set none.
        modal_feedrate: f64,
    },
    /// At the programmed feedrate.
    Feed {
        /// Programmed feedrate, mm/s; positive and finite.
        feedrate: f64,
    },
}

impl Motion {
    /// A rapid of a program that has set no feedrate.
    pub const RAPID: Motion = Motion::Rapid { modal_feedrate: f64::INFINITY };

    /// Returns `true` for a rapid.
    pub fn is_rapid(&self) -> bool {
        matches!(self, Motion::Rapid { .. })
    }
}

/// One programmed move along one curve; its length is positive.
#[derive(Clone, Debug, PartialEq)]
pub struct Segment {
    /// Start, mm.
    pub start: Point,
    /// End, mm.
    pub end: Point,
    /// Its shape between the two.
    pub curve: Curve,
    /// Length along the curve, mm.
    pub length: f64,
    /// Feed or rapid.
    pub motion: Motion,
    /// Angles by which A, B and C turn during the move, rad.
    pub rotation: Rotation,
    /// `true` if the program requests a full stop at its end (G9, G61).
    pub exact_stop: bool,
    /// `true` if that is the stop of G61, which LinuxCNC makes only where its acceleration does not allow the
    /// corner (exact path).
    pub exact_path: bool,
    /// Line of the program it comes from.
    pub line: LineNumber,
}

/// The angles by which A, B and C turn along a segment, rad. They are zero on nearly all of the millions of
/// segments of a long program, so only others take memory, which copies share.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rotation(Option<std::sync::Arc<Vector>>);

impl Rotation {
    /// No turn.
    pub const NONE: Rotation = Rotation(None);

    /// Returns `true` if no axis turns.
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

/// The cause of a stop between two segments.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StopCause {
    /// G4.
    Dwell {
        /// Programmed waiting time, s.
        seconds: f64,
    },
    /// A turn of rotary axes alone.
    Rotary {
        /// Angles by which A, B and C turn, rad.
        rotation: Vector,
        /// Programmed rate along all three, rad/s; `None` in rapid.
        rate: Option<f64>,
    },
    /// M6.
    ToolChange {
        /// The new tool, if a T word names it.
        tool: Option<u32>,
    },
    /// M6 for the tool that is in the spindle already.
    SameTool {
        /// That tool.
        tool: u32,
    },
    /// The spindle starts, stops or changes its speed.
    Spindle {
        /// Its state before.
        from: SpindleState,
        /// Its state after.
        to: SpindleState,
        /// The M word that says so, or `None` for an S word alone.
        code: Option<u32>,
    },
    /// Any other M-word.
    MCode {
        /// Its number.
        code: u32,
    },
}

impl StopCause {
    /// Returns the programmed waiting time of a dwell, s; `None` for any other stop.
    pub fn dwell(self) -> Option<f64> {
        match self {
            StopCause::Dwell { seconds } => Some(seconds),
            _ => None,
        }
    }

    /// Returns the M-word whose time the machine has: 6 for a tool change, 3 and 5 for any word that starts and stops
    /// the spindle; `None` if the time is programmed or follows from motion.
    pub fn m_code(self) -> Option<u32> {
        match self {
            StopCause::ToolChange { .. } => Some(6),
            StopCause::Spindle { to, code: Some(_), .. } => Some(if to.is_at_rest() { 5 } else { 3 }),
            StopCause::MCode { code } => Some(code),
            StopCause::Dwell { .. }
            | StopCause::Rotary { .. }
            | StopCause::SameTool { .. }
            | StopCause::Spindle { code: None, .. } => None,
        }
    }
}

/// A full stop between two segments.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stop {
    /// Number of segments before it.
    pub after: usize,
    /// Its cause.
    pub cause: StopCause,
    /// Line of the program it comes from.
    pub line: LineNumber,
}

/// All moves and stops of a program, in order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Toolpath {
    /// The moves; each begins where the one before ends.
    pub segments: Segments,
    /// Distance along the program at which the first move begins, mm: 0 for a whole program, more for an excerpt of one.
    pub begins_at: f64,
    /// The control the program was read for.
    pub dialect: Dialect,
    /// The stops, by ascending `after`; those with the same `after` in program order.
    pub stops: Vec<Stop>,
    /// The parts of the program, in order; the first begins with the first move and stop.
    pub operations: Vec<Operation>,
    /// The path modes that the program sets, by ascending `from`, each once. Before the first,
    /// [`Blending::Machine`] is in force.
    pub path_modes: Vec<PathMode>,
    /// The states of the spindle with the number of segments before each, by ascending number, each once. Before
    /// the first the spindle is at rest. Beside a compensated contour a state may be a few moves early.
    pub spins: Vec<(usize, SpindleState)>,
    /// The remarks of reading and tracing, in line order: words left out, and assumptions.
    pub diagnostics: Vec<Diagnostic>,
    /// The reason why nothing of the program is run: it is a lathe program.
    pub declined: Option<Diagnostic>,
    /// The doubts about the time that the remarks leave, in the order of the program.
    pub doubts: Vec<Doubt>,
}

/// The first feed move after a change of the spindle's speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FeedAtNewSpeed {
    /// Index of its segment.
    pub segment: usize,
    /// Number of segments before the change.
    pub changed_after: usize,
    /// Change of the speed, rpm; through standstill if the direction changes.
    pub change: f64,
}

impl Toolpath {
    /// Returns the distance along the path before each segment, and at the end, mm.
    pub fn distances(&self) -> Vec<f64> {
        [0.0].into_iter().chain(self.ends()).collect()
    }

    /// Returns the distance along the program before each segment, and at the end, mm. It differs from that along the path in
    /// an excerpt.
    pub fn distances_in_program(&self) -> Vec<f64> {
        self.distances().into_iter().map(|distance| self.begins_at + distance).collect()
    }

    /// Returns the distance along the path at the end of each segment, mm.
    pub fn ends(&self) -> impl Iterator<Item = f64> {
        running_sum((0..self.segments.len()).map(|segment| self.segments.length(segment)))
    }

    /// Returns `true` if any segment is a rapid.
    pub fn has_rapid(&self) -> bool {
        self.segments.iter().any(|segment| segment.motion.is_rapid())
    }

    /// Returns the stops between segment `after − 1` and segment `after`.
    pub fn stops_at(&self, after: usize) -> &[Stop] {
        let behind = &self.stops[self.stops.partition_point(|stop| stop.after < after)..];
        &behind[..behind.partition_point(|stop| stop.after == after)]
    }

    /// Returns the segments before which an S word changes the speed of a running spindle without a stop of the
    /// program.
    pub fn speed_changes(&self) -> impl Iterator<Item = usize> {
        let changes = self.spins.windows(2).filter(|pair| {
            let [before, after] = [pair[0].1, pair[1].1];
            before.direction == after.direction && 0.0 < before.speed && before.speed != after.speed
        });
        let is_among_moves =
            move |next: &usize| *next < self.segments.len() && self.stops_at(*next).is_empty();
        changes.map(|pair| pair[1].0).filter(is_among_moves)
    }

    /// Returns the first feed move after each start of the spindle and each change of its speed.
    pub fn feeds_at_new_speed(&self) -> impl Iterator<Item = FeedAtNewSpeed> {
        let standing = (0, SpindleState::default());
        let before = [standing].into_iter().chain(self.spins.iter().copied());
        let until = self.spins[1.min(self.spins.len())..].iter().map(|next| next.0);
        let until = until.chain([self.segments.len()]);
        let spins = before.zip(&self.spins).zip(until).filter(|(((_, before), (_, own)), _)| {
            own.direction != SpindleDirection::Standing && 0.0 < own.speed && before != own
        });
        spins.filter_map(|(((_, before), (from, own)), until)| {
            let mut moves = *from..until.min(self.segments.len());
            let segment = moves.find(|at| !self.segments.motion(*at).is_rapid())?;
            let change = (own.signed_speed() - before.signed_speed()).abs();
            Some(FeedAtNewSpeed { segment, changed_after: *from, change })
        })
    }
}
