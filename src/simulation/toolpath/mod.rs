//! Blocks → toolpath: where the tool is told to go, and where it has to stop.
//!
//! A toolpath is a chain of segments, each beginning where the one before ends, in mm and in
//! one coordinate system (the machine's; work offsets, shifts, rotation, scaling and mirrors are
//! already applied). Between segments lie the stops: dwells, tool changes and other M-words, and
//! turns of rotary axes alone.
//!
//! Order of execution within a block: units, plane, distance and path modes; F; T; S; M-words that
//! act before the motion (M6 and all not named below, as written); work offset; tool length; dwell,
//! change of coordinates, reference move or motion; M-words that act after it (M0, M1, M2, M5, M9,
//! M30, M60). That is RS274/NGC, Table 5, but for M5 and M9, which wait for the motion as on Fanuc
//! controls.
//!
//! Rules where controls differ or a program does not say:
//! - The tool begins at the machine's zero, in mm, G17, G54, G90, G91.1, G94, G64; axis words before
//!   the first motion word move in rapid.
//! - The values of expressions are worked out before their block is run, by the rules of the
//!   parameters module; a value that is not whole counts as written with a decimal point.
//! - P of G4 is in seconds; without a decimal point, in a program with a `%` line or an O
//!   number, in milliseconds. X and U of G4 are in seconds.
//! - Work offsets and tool lengths that neither program nor machine file gives are zero. G28, G30
//!   and G53 are run in the axes whose reference point the machine knows; in the others the tool
//!   stays where it is.
//! - G61, G61.1 and G9 ask for a full stop at the end of rapid and feed moves alike; what else a
//!   program says about tolerances is told in the path mode module.
//! - Rotary axes go where their words say, neither the shortest way nor modulo 360. Beside a move
//!   F holds along X, Y and Z, or on Fanuc controls along all axes.
//! - Cycles (G73 to G89) are run hole by hole, by the rules of the cycle module.
//! - Corner treatments and cutter compensation are in the compensation module.
//! - A program that shows itself as one for a lathe is declined, by the signs of the turning module.
//! - Tilted planes (G68.2) and cylindrical or polar interpolation are not applied. Each says so.
//! - Lengths without a decimal point are lengths as written, but where the machine file gives an
//!   increment for them.
//!
//! Where controls read a word in two ways, the dialect decides: Fanuc for ISO programs and Okuma's,
//! RS274/NGC and LinuxCNC for the others.
//!
//! Source: NIST RS274/NGC (Kramer, Proctor, Messina 2000), Sect. 3.5 to 3.8.

mod block;
mod center;
mod compensation;
mod control;
mod coupled;
mod curve;
mod cycle;
mod doubt;
mod feed_mode;
mod frame;
mod functions;
mod increment;
mod klartext;
mod motion;
mod operations;
mod own;
mod parameters;
mod path_mode;
mod plain;
mod plane;
#[cfg(test)]
pub(crate) mod random;
mod remark;
mod rotary;
mod run;
mod segments;
mod siemens;
mod spline;
mod straight;
mod trace;
mod turning;
mod words;

pub use curve::{Arc, Curve};
pub use motion::ASSUMED_FEEDRATE;
pub use operations::{MOST_OPERATIONS, Operation};
pub use path_mode::{Blending, PathMode};
pub use segments::Segments;
pub use straight::{LINES_OF_A_PART, trace_straight, trace_text};
pub use trace::{trace, trace_within};

use crate::machine::Spin;
use crate::simulation::gcode::{Diagnostic, Dialect, Doubt, LineNumber};
use crate::simulation::running_sum::running_sum;

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
        from: Spin,
        /// What it is to do.
        to: Spin,
        /// The M-word that says so; none where it is an S word alone.
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
    pub spins: Vec<(usize, Spin)>,
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
        let lengths = (0..self.segments.len()).map(|segment| self.segments.length(segment));
        [0.0].into_iter().chain(running_sum(lengths)).collect()
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
}
