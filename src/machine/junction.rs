//! The law by which a control limits the feedrate at corners, and its rows in the table of parameters.

use crate::machine::parameter::{Access, Parameter, finite, number};
use crate::units::Unit;

/// What limits the feedrate at a corner beside the contour tolerance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Junction {
    /// Nothing.
    Tolerance,
    /// The acceleration on a circle within the contour tolerance, as in LinuxCNC.
    AccelerationBlend,
    /// The acceleration on a circle that passes the corner at this distance, mm, as in grbl.
    Deviation(f64),
    /// This feedrate at a corner of 90°, mm/s, and the same circle at others, as in Klipper.
    SquareCorner(f64),
    /// This step of velocity of any axis, mm/s, as in Marlin.
    AxisStep(f64),
}

const RULES: [&str; 2] = ["tolerance", "acceleration_blend"];

/// The rows of the law. Each law with a value has a row of its own, so that the value carries its
/// unit; giving it chooses the law, and taking it away takes back that law alone.
pub(super) const JUNCTION: [Parameter; 7] = [
    Parameter {
        key: "interpolator.junction_rule",
        label: "Junctions",
        doc: "tolerance: corners by the contour tolerance alone; acceleration_blend: also by the acceleration on a circle within it, as LinuxCNC.",
        access: Access::Choice {
            words: &RULES,
            get: |m| RULES[usize::from(m.interpolator.junction == Junction::AccelerationBlend)],
            set: |m, v| {
                if v == RULES[1] {
                    m.interpolator.junction = Junction::AccelerationBlend
                }
            },
        },
    },
    Parameter {
        key: "interpolator.junction_deviation_mm",
        label: "Junction deviation",
        doc: "Corners also by the acceleration on a circle that passes at this distance, as grbl; empty: not so.",
        access: number(
            Unit::Millimetre,
            (1e-6, 10.0),
            |m| match m.interpolator.junction {
                Junction::Deviation(value) => Some(value),
                _ => None,
            },
            |m, v| match (v, m.interpolator.junction) {
                (Some(value), _) => m.interpolator.junction = Junction::Deviation(value),
                (None, Junction::Deviation(_)) => m.interpolator.junction = Junction::Tolerance,
                _ => (),
            },
        ),
    },
    Parameter {
        key: "interpolator.square_corner_velocity_mm_min",
        label: "Square-corner velocity",
        doc: "Feedrate at a corner of 90° is at most this, at others that of the same circle, as Klipper; empty: not so.",
        access: number(
            Unit::MillimetrePerMinute,
            (0.01, 1e6),
            |m| match m.interpolator.junction {
                Junction::SquareCorner(value) => Some(value),
                _ => None,
            },
            |m, v| match (v, m.interpolator.junction) {
                (Some(value), _) => m.interpolator.junction = Junction::SquareCorner(value),
                (None, Junction::SquareCorner(_)) => m.interpolator.junction = Junction::Tolerance,
                _ => (),
            },
        ),
    },
    Parameter {
        key: "interpolator.axis_velocity_step_mm_min",
        label: "Velocity step of axes",
        doc: "No axis changes its velocity by more than this at a corner; empty: not so.",
        access: number(
            Unit::MillimetrePerMinute,
            (0.01, 1e6),
            |m| match m.interpolator.junction {
                Junction::AxisStep(value) => Some(value),
                _ => None,
            },
            |m, v| match (v, m.interpolator.junction) {
                (Some(value), _) => m.interpolator.junction = Junction::AxisStep(value),
                (None, Junction::AxisStep(_)) => m.interpolator.junction = Junction::Tolerance,
                _ => (),
            },
        ),
    },
    Parameter {
        key: "interpolator.slowing_angle_deg",
        label: "Corners slow to a stop at",
        doc: "Corners are slowed by the fourth power of their turn, down to a full stop from this angle on; empty: not so.",
        access: number(
            Unit::Degree,
            (1.0, 3600.0),
            |m| finite(m.interpolator.slowing_angle),
            |m, v| m.interpolator.slowing_angle = v.unwrap_or(f64::INFINITY),
        ),
    },
    Parameter {
        key: "interpolator.path_smoothing_mm",
        label: "Path smoothing",
        doc: "Lines within this of one line are run as that; 0: none; empty: with acceleration_blend by Q or P of G64.",
        access: number(
            Unit::Millimetre,
            (0.0, 10.0),
            |m| m.interpolator.path_smoothing,
            |m, v| m.interpolator.path_smoothing = v,
        ),
    },
    Parameter {
        key: "interpolator.corner_smoothing_mm",
        label: "Corner smoothing",
        doc: "Corners between lines that a curve passes within this are not slowed; 0: all are.",
        access: number(
            Unit::Millimetre,
            (0.0, 10.0),
            |m| Some(m.interpolator.corner_smoothing),
            |m, v| m.interpolator.corner_smoothing = v.unwrap_or(0.0),
        ),
    },
];
