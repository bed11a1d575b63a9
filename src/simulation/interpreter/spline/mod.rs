//! Splines of LinuxCNC: G5, G5.1 and G5.2 … G5.3.
//!
//! ```text
//! G5    X Y I J P Q    cubic Bézier curve: control points at I J from the start and at P Q from the end;
//!                      without I J the curve leaves in the direction in which the G5 before it arrived
//! G5.1  X Y I J        quadratic Bézier curve: control point at I J from the start
//! G5.2  X Y P L        a control point with the weight P of a NURBS of the order L (3), and all blocks with
//!                      axis words after it; the first point is the start, whose weight is a P without X Y
//! G5.3                 runs the NURBS; its knots are uniform, and it touches its first and last point
//! ```
//!
//! All are NURBS, which [`Nurbs`] runs as biarcs.
//!
//! Splines are in the XY plane. G6.2 (NURBS with given knots) is not modelled: feed moves join its control points.
//!
//! Source: LinuxCNC 2.9, G5 to G5.3.

mod words;

use crate::simulation::gcode::LineNumber;
use crate::simulation::interpreter::code::Code;
use crate::simulation::toolpath::Vector;
use crate::simulation::toolpath::nurbs::Nurbs;

/// Highest order of a NURBS; the work at a point of the curve grows with its square.
const MAX_ORDER: usize = 16;

/// A curve by axis words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Spline {
    /// G5.
    Cubic,
    /// G5.1.
    Quadratic,
    /// G5.2.
    Nurbs,
    /// G6.2, whose control points feed moves join.
    GivenKnots,
}

impl Spline {
    fn code(self) -> Code {
        let value = match self {
            Spline::Cubic => 5.0,
            Spline::Quadratic => 5.1,
            Spline::Nurbs => 5.2,
            Spline::GivenKnots => 6.2,
        };
        Code { letter: 'G', value }
    }
}

/// The reason why a spline is not run as written.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub(super) enum NoSpline {
    #[error("the curve needs both I and J")]
    NoDirection,
    #[error("the curve needs both P and Q")]
    NoEndDirection,
    #[error("X and Y without G5 and its P and Q: LinuxCNC stops here")]
    NoWord,
    #[error("splines need the XY plane (G17), in which LinuxCNC allows no other axis")]
    OutOfPlane,
    #[error("the order {order} needs at least as many control points, there are {points}")]
    FewPoints { order: usize, points: usize },
    #[error("the order {0} is beyond {MAX_ORDER}")]
    HighOrder(usize),
    #[error("the knots (K) are not modelled")]
    GivenKnots,
}

/// State of splines from block to block.
#[derive(Debug, Default)]
pub(super) struct SplineState {
    /// Vector from the end of the last G5 to the mirror image of its last control point, in program coordinates,
    /// mm.
    onward: Option<Vector>,
    /// The NURBS that G5.2 began.
    nurbs: Nurbs,
    /// Line of that G5.2.
    nurbs_line: LineNumber,
}

#[cfg(test)]
mod tests;
