//! The limits of tool and spindle that loads are held against, and what is shared by the lists of where they are exceeded and
//! of where there is headroom below them.

/// What can be exceeded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Limit {
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

/// Way between two exceedings that count as one, mm.
pub(crate) const CLOSE: f64 = 10.0;

/// The factors tried.
pub(crate) const FACTORS: [f64; 8] = [1.1, 1.2, 1.3, 1.5, 1.75, 2.0, 2.5, 3.0];

/// Below this share of level motion the bottom cuts, of which no load is known.
pub(crate) const STEEP: f64 = 0.5;
