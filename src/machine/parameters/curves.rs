//! Rows of what is particular to arcs and to positioning: how closely arcs are followed, and how rapids ramp.

use crate::machine::ArcChords;
use crate::machine::parameter::{Access, JERK_MM_S3, Parameter, TOLERANCE_MM, finite, number};
use crate::units::Unit;

/// The rows.
pub(super) const CURVES: [Parameter; 7] = [
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
    Parameter {
        key: "interpolator.arc_chord_error_mm",
        label: "Chords of arcs within",
        doc: "An arc is planned as chords that lie within this of it, each a block, as grbl ($12); empty: not so.",
        access: number(
            Unit::Millimetre,
            (1e-5, 10.0),
            |m| match m.interpolator.arc_chords {
                ArcChords::Within(value) => Some(value),
                _ => None,
            },
            |m, v| match (v, m.interpolator.arc_chords) {
                (Some(value), _) => m.interpolator.arc_chords = ArcChords::Within(value),
                (None, ArcChords::Within(_)) => m.interpolator.arc_chords = ArcChords::Whole,
                _ => (),
            },
        ),
    },
    Parameter {
        key: "interpolator.arc_chord_mm",
        label: "Chords of arcs of",
        doc: "An arc is planned as chords of this length, each a block, as Klipper (resolution); empty: not so.",
        access: number(
            Unit::Millimetre,
            (1e-3, 100.0),
            |m| match m.interpolator.arc_chords {
                ArcChords::Long(value) => Some(value),
                _ => None,
            },
            |m, v| match (v, m.interpolator.arc_chords) {
                (Some(value), _) => m.interpolator.arc_chords = ArcChords::Long(value),
                (None, ArcChords::Long(_)) => m.interpolator.arc_chords = ArcChords::Whole,
                _ => (),
            },
        ),
    },
    Parameter {
        key: "interpolator.minimum_cruise_ratio",
        label: "Minimum cruise ratio",
        doc: "Moves that speed up and slow down get no faster than with this part less acceleration, as Klipper; only where acceleration limits shape the command; 0: no such limit.",
        access: number(
            Unit::Number,
            (0.0, 0.99),
            |m| Some(m.interpolator.minimum_cruise_ratio),
            |m, v| m.interpolator.minimum_cruise_ratio = v.unwrap_or(0.0),
        ),
    },
];
