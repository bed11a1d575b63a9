//! Path modes: how far the motion may leave the programmed path, from one segment on.

use crate::simulation::gcode::LineNumber;

/// The path mode from one segment on, up to that of the next entry.
#[derive(Clone, Debug, PartialEq)]
pub struct PathMode {
    /// The first segment it holds for.
    pub from: usize,
    /// Line of the program that set it.
    pub line: LineNumber,
    /// The words that set it, such as `G64 P0.01`.
    pub source: String,
    /// What holds at corners and along arcs.
    pub blending: Blending,
    /// Distance within which lines are to be merged into one, mm (Q of G64); none: the tolerance.
    pub merging: Option<f64>,
}

/// How far the motion may leave the programmed path.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Blending {
    /// Not at all between segments: a full stop after each. Arcs keep the machine's tolerance.
    ExactStop,
    /// The same, but LinuxCNC stops only where its acceleration does not allow the corner as programmed.
    ExactPath,
    /// The machine's own tolerance.
    #[default]
    Machine,
    /// A contour tolerance, mm.
    Within(f64),
    /// A distance along the path before each corner at which its rounding may begin, mm.
    Distance(f64),
}
