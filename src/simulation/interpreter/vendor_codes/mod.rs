//! G and M words of one family of controls, and known words that are not run.
//!
//! ```text
//! Haas    G70 I J L        holes on a circle of radius I, from the angle J on, L of them
//!         G71 I J K L      holes on an arc of radius I, from the angle J on, K degrees from hole to hole, L of them
//!         G72 I J L        holes on a line at the angle J, I from hole to hole, the first here
//!         G100 G101 X      mirror off and on        G110 … G129   work offsets, G154 P1 … P20
//!         G84.2 G84.3      rigid tapping, right and left hand
//! Fanuc   G60 X Y Z        positioning from one side: the overrun and return are not timed
//! Brother G100 T X Y Z     tool change, then rapid to X Y and from there to Z; T distinguishes it from Haas
//! NGC     G28.1 G30.1      keep the position as the reference point of G28, G30
//! Mach    M47              restart: one run is timed
//!         G70, G71         inch and mm
//! Okuma   G15 Hn, G16 Hn   work offset n from here on, or in this block; H0 is the machine's zero
//!         G54 … G59 Hn     tool length, G53 none
//!         G71 Z, M53       cycles return to Z        M54   cycles return to R
//!         NCYL             a move to the place of the hole, without a hole
//!         G284             rigid tapping
//! ```
//!
//! Angles are in degrees, counter-clockwise from X. A remark on each word that is not run names the missing part;
//! the tool does not move.
//!
//! On controls of printers some M words set values of the control, axis by axis (`M201 X500 Y500`): if one begins
//! a block without a G word, the other words of the block belong to it.
//!
//! Okuma: M52 (return to the upper limit) needs the reference point of Z. Not modelled: the stop of the spindle by
//! G80 on some of its machines.
//!
//! Sources: Haas, Mill Operator's Manual, G70 to G72; Yaskawa, YASNAC PC NC programming manual,
//! Sect. 4.1; LinuxCNC 2.9, G28; Okuma, post processors for OSP-E100M and OSP-P300 and the OSP-P300M
//! programming manual; Brother, CNC-C00 programming manual, G100.

mod meaning;
mod words;

pub(super) use meaning::meaning;

use crate::simulation::toolpath::Point;

/// A word of one family that uses the axis words of its block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum VendorCode {
    /// A word that is left out with its axis words, for this reason.
    Unsupported(&'static str),
    /// G70 to G72.
    BoltHoles,
    /// G28.1 and G30.1.
    KeepReference,
    /// G60.
    FromOneSide,
    /// G71 Z.
    ReturnLevel,
    /// G100: with T the tool change with the moves to the work, else the end of G101.
    OneTouchChange,
}

/// A word of one family that acts before the axis words of its block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum VendorModal {
    /// G15 Hn and, for this block alone, G16 Hn.
    OffsetByH,
    /// G110 to G129.
    OffsetByCode,
    /// G53, and G54 to G59.
    LengthByH,
    /// A tapping cycle with the feed coupled to the spindle, by ten times its number.
    RigidTap(u16),
    /// A word without a model: name and consequence.
    NotModelled(&'static str, &'static str),
}

/// M words that set speeds, accelerations, steps and the like, with the numbers of Marlin and RepRapFirmware.
const SETTINGS: [u16; 31] = [
    92, 201, 202, 203, 204, 205, 206, 207, 208, 209, 218, 220, 221, 301, 303, 304, 350, 425, 566, 569, 572,
    574, 584, 593, 665, 666, 851, 906, 907, 913, 914,
];

/// State of these words from block to block.
#[derive(Default)]
pub(super) struct VendorState {
    /// The work offset to restore after this block.
    offset_after: Option<u16>,
    /// The positions of G28.1 and G30.1, mm.
    pub(super) kept: [Option<Point>; 2],
    /// The height of G71, mm along the axis of the holes.
    pub(super) return_level: Option<f64>,
    /// Number of the last of M52, M53 and M54.
    pub(super) returns_by: Option<u32>,
}

#[cfg(test)]
mod tests;
