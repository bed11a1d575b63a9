//! What SINUMERIK programs say beyond ISO: statements, frames, poles, tolerances.
//!
//! - `TRANS`, `ROT`, `SCALE`, `MIRROR` put a frame in place of all that are programmed; with an A
//!   before them they add to it. Without words they take all back. `ROT` turns by RPL in the plane
//!   in force, or about X, Y and Z one after the other.
//! - `SUPA`, G53 and G153 take the words of their block in machine coordinates.
//! - G110, G111 and G112 set the pole of AP and RP, from the position, the origin and the last pole.
//! - G60 and G9 stop at the end of a move; G64 does not; G641 begins a rounding ADIS before a corner;
//!   G642 to G645 and `CYCLE832` keep a contour tolerance.
//! - G70 and G71 give the unit of lengths, pitches among them, and leave feeds in that of the machine, which is
//!   taken as metric; G700 and G710 give the unit of feeds too.
//! - Modal calls, drilling cycles and patterns of holes are those of the modules below.
//! - G33, G331 and G332 run at the pitch times the spindle speed, G63 at F.
//!
//! Not modelled, and said: swivelled planes (`CYCLE800`), orientation transformations (`TRAORI`),
//! splines, compressors, milling cycles, measuring.
//!
//! Source: SINUMERIK 840D sl, Programming Manual Fundamentals and Job Planning, 2013.

mod cycle;
mod deep;
mod points;
mod positions;
mod statements;
mod variables;
mod words;

pub(super) use words::{SiemensWord, meaning};

use crate::simulation::gcode::{DrillingCycle, FrameChange, HolePattern};
use crate::simulation::toolpath::Point;

/// What stays in force in SINUMERIK programs alone.
#[derive(Default)]
pub(super) struct Siemens {
    /// G70 or G71 is in force: F is in the machine's own unit of length.
    pub(super) leaves_feeds: bool,
    /// The pole of AP and RP in program coordinates, mm.
    pub(super) pole: Point,
    /// The cycle of MCALL.
    pub(super) modal: Option<DrillingCycle>,
    /// The last polar angle, rad, and radius, mm.
    pub(super) polar: (f64, f64),
    /// The pitch of the last G331 or G33, mm.
    pitch: Option<f64>,
}

/// What the statements and G words of a block ask for.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum SiemensAction {
    /// TRANS and the like.
    Frame { change: FrameChange, is_added: bool },
    /// MCALL, with the cycle that may follow.
    Modal(Option<DrillingCycle>),
    /// A drilling cycle at the place.
    Cycle(DrillingCycle),
    /// HOLES1, HOLES2, CYCLE801, CYCLE802.
    Holes(HolePattern),
    /// CIP.
    Through,
    /// CT.
    Tangential,
    /// SUPA.
    MachineCoordinates,
    /// G110 to G112.
    Pole(u16),
    /// G331, or G332 for the way back, with the M word that says how the spindle turns after it; G33
    /// to G35 without.
    Thread(Option<u32>),
    /// G63.
    FloatingTap,
}

#[cfg(test)]
mod tests;
