//! Rows of what is particular to arcs and to positioning: how closely arcs are followed, and how rapids ramp.

use crate::machine::parameters::{Access, JERK_MM_S3, Parameter, TOLERANCE_MM, finite, number};
use crate::units::Unit;

/// The rows.
pub(super) const CURVES: [Parameter; 4] = [
    Parameter {
        key: "interpolator.arc_tolerance_mm",
        label: "Contour tolerance of arcs",
        doc: "How far the motion may run inside an arc; empty: the contour tolerance.",
        access: number(
            Unit::Millimetre,
            TOLERANCE_MM,
            |m| m.interpolator.arc_tolerance,
            |m, v| m.interpolator.arc_tolerance = v,
        ),
    },
    Parameter {
        key: "rapid.positioning_jerk_mm_s3",
        label: "Jerk of positioning",
        doc: "Each rapid runs from stand to stand, its ramps T1 = √(speed reached / this jerk) a filter, for the axis that moves furthest; empty: not so.",
        access: number(
            Unit::MillimetrePerSecond3,
            JERK_MM_S3,
            |m| finite(m.rapid.positioning_jerk),
            |m, v| m.rapid.positioning_jerk = v.unwrap_or(f64::INFINITY),
        ),
    },
    Parameter {
        key: "path.jerk_mm_s3",
        label: "Path jerk limit",
        doc: "Largest jerk along the path: a change of feedrate by Δv takes 2 √(Δv / jerk) before the filters; empty: no limit.",
        access: number(
            Unit::MillimetrePerSecond3,
            JERK_MM_S3,
            |m| finite(m.path.jerk),
            |m, v| m.path.jerk = v.unwrap_or(f64::INFINITY),
        ),
    },
    Parameter {
        key: "path.acceleration_limits_command",
        label: "Acceleration before the filters",
        doc: "Acceleration limits shape the command before the filters, so that a ramp takes both; else what leaves the filters is run slower where it is beyond them.",
        access: Access::Flag { get: |m| m.path.limits_command, set: |m, v| m.path.limits_command = v },
    },
];
