//! SINUMERIK programs beyond ISO: statements, frames, poles, tolerances.
//!
//! - `TRANS`, `ROT`, `SCALE`, `MIRROR` replace all programmed frames; with an A before them they add to these.
//!   Without words they end all. `ROT` rotates by RPL in the plane in force, or about X, Y and Z one after the
//!   other.
//! - `SUPA`, G53 and G153 take the words of their block in machine coordinates.
//! - G110, G111 and G112 set the pole of AP and RP, from the position, the origin and the last pole.
//! - G60 and G9 stop at the end of a move; G64 does not; G641 begins a rounding ADIS before a corner; G642 to G645
//!   and `CYCLE832` set a contour tolerance.
//! - G70 and G71 set the unit of lengths, including pitches, and leave feeds in the unit of the machine, which is
//!   taken as metric; G700 and G710 set the unit of feeds too.
//! - Modal calls, drilling cycles and patterns of holes are in the modules below.
//! - G33, G331 and G332 run at the pitch times the spindle speed, G63 at F.
//!
//! Not modelled, with a remark: swivelled planes (`CYCLE800`), orientation transformations (`TRAORI`), splines,
//! compressors, milling cycles, measuring.
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

/// Modal state of SINUMERIK programs alone.
#[derive(Default)]
pub(super) struct Siemens {
    /// `true` while G70 or G71 is in force: F is in the machine's own unit of length.
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

/// An action of the statements and G words of a block.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum SiemensAction {
    /// TRANS and the like.
    Frame { change: FrameChange, is_added: bool },
    /// MCALL, with the cycle that may follow.
    Modal(Option<DrillingCycle>),
    /// A drilling cycle at the position.
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
    /// G331, or G332 for the way back, with the M word of the spindle after it; G33 to G35 without.
    Thread(Option<u32>),
    /// G63.
    FloatingTap,
}

#[cfg(test)]
mod tests;
