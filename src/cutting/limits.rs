//! The limits of tool and spindle, and constants common to the lists of exceeded limits and of headroom below
//! them.

/// A limited quantity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum LimitKind {
    /// Force on the tool, N.
    ToolForce,
    /// Torque on the tool, N·mm.
    ToolTorque,
    /// Power through the tool, N·mm/s.
    ToolPower,
    /// Thickness of a chip, mm.
    ToolChip,
    /// Bend of the tool at its tip, mm.
    ToolDeflection,
    /// Force on the spindle, N.
    SpindleForce,
    /// Torque of the spindle, N·mm.
    SpindleTorque,
    /// Power of the spindle, N·mm/s.
    SpindlePower,
}

/// Largest distance between two places beyond a limit that count as one part, mm.
pub(crate) const MAX_GAP_MM: f64 = 10.0;

/// Factors on the programmed feedrate.
pub(crate) const FEED_FACTORS: [f64; 8] = [1.1, 1.2, 1.3, 1.5, 1.75, 2.0, 2.5, 3.0];

/// Least level share of a motion with a known load: on steeper motions the bottom cuts.
pub(crate) const MIN_LEVEL_SHARE: f64 = 0.5;
