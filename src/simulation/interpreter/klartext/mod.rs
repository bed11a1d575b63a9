//! Heidenhain programs: paths, poles, tools, cycles, transformations.
//!
//! Order of execution within a block: feedrate; M functions that act before the motion; the statement; M functions
//! that act after it (M0, M1, M2, M5, M9, M30); the cycle that M99 or M89 calls. The `path` module moves, the
//! `approach` module leads to and from contours, the `cycle` module makes holes, the `frame` module changes
//! coordinates.
//!
//! - F is modal; FMAX holds for its block alone. F AUTO is the feed of the tool call. In programs in inches F
//!   counts tenths of inches a minute. M136 makes F a feed per revolution.
//! - A tool call changes the tool and stops the spindle; M6 beside it has no effect.
//! - M91 and M92 take the words of their block in machine coordinates.
//! - With R0 after RL or RR the tool leaves the contour at a right angle to its last element.
//!
//! Source: TNC 640, Klartext Programming, 2018. Limits: tilted planes, FK, splines, patterns by PATTERN DEF,
//! pockets and contour cycles are not modelled; a remark names each.

mod queries;
mod approach;
mod cycle;
mod frame;
mod hole;
mod path;
mod remark;
mod statements;

pub(super) use remark::KlartextRemark;

use crate::simulation::interpreter::compensation::{Beside, Side};
use crate::simulation::interpreter::klartext::approach::Approach;
use crate::simulation::interpreter::klartext::cycle::CycleState;
use crate::simulation::toolpath::{Point, Vector};
use std::collections::BTreeMap;

/// Modal state of Heidenhain programs alone.
#[derive(Default)]
pub(super) struct Klartext {
    /// The pole, program coordinates, mm.
    pub(super) pole: Option<Point>,
    /// Angle, rad, and radius, mm, of the last polar word about this pole.
    pub(super) polar: Option<(f64, f64)>,
    /// Sense of the last arc.
    sense: f64,
    /// Direction of the last move at its end, in machine coordinates.
    direction: Option<Vector>,
    /// RL or RR.
    side: Option<Side>,
    /// Position of the tool relative to the contour.
    beside: Option<Beside>,
    /// An approach whose contour is not known yet.
    approach: Option<Approach>,
    /// Radii by TOOL DEF, mm, by tool.
    radii: BTreeMap<u32, f64>,
    /// DR of the tool call, mm.
    radius_difference: f64,
    /// F of the tool call, mm/s.
    auto_feed: Option<f64>,
    /// M136.
    has_feed_per_revolution: bool,
    cycle: CycleState,
    /// The shift of cycle 7, mm.
    datum: Vector,
    /// The angle of cycle 10, rad.
    angle: f64,
}
