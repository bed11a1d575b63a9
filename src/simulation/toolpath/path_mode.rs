//! Path modes: the tolerances that a program sets, each from one segment on.

use crate::simulation::gcode::LineNumber;

/// The path mode from one segment on, up to the next entry.
#[derive(Clone, Debug, PartialEq)]
pub struct PathMode {
    /// Index of the first segment it holds for.
    pub from: usize,
    /// Line of the program that set it.
    pub line: LineNumber,
    /// The words that set it, such as `G64 P0.01`.
    pub source: String,
    /// The tolerance at corners and along arcs.
    pub blending: Blending,
    /// Distance within which lines are to be merged into one, mm (Q of G64); `None` for the tolerance.
    pub merging: Option<f64>,
}

/// The permitted deviation of the motion from the programmed path.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Blending {
    /// None at corners: a full stop after each segment. Arcs keep the machine's tolerance.
    ExactStop,
    /// As `ExactStop`, but LinuxCNC stops only where its acceleration does not allow the corner as programmed.
    ExactPath,
    /// The machine's own tolerance.
    #[default]
    Machine,
    /// A contour tolerance, mm.
    Within(f64),
    /// Distance along the path before each corner at which its rounding may begin, mm.
    Distance(f64),
}
