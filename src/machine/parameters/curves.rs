//! Rows of arcs and of positioning: the accuracy of arcs, and the ramps of rapids.

use crate::machine::ArcChords;
use crate::machine::parameter::{JERK_BOUNDS_MM_S3, Parameter, TOLERANCE_BOUNDS_MM, row};

/// The rows.
pub(super) const CURVES: [Parameter; 9] = [
    row!("interpolator.arc_tolerance_mm", "Contour tolerance of arcs", optional Millimetre TOLERANCE_BOUNDS_MM [interpolator.arc_tolerance],
        "How far inside an arc the motion may run. Empty: the contour tolerance."),
    row!("rapid.positioning_jerk_mm_s3", "Jerk of positioning", limit MillimetrePerSecond3 JERK_BOUNDS_MM_S3 [rapid.positioning_jerk],
        "Rapids start and stop at rest; each filter averages over T1 = √(top speed / jerk), for the axis that travels furthest. Empty: rapids are blended."),
    row!("path.jerk_mm_s3", "Path jerk limit", limit MillimetrePerSecond3 JERK_BOUNDS_MM_S3 [path.jerk],
        "Largest jerk along the path: before the filters, a change of feedrate by Δv takes 2 √(Δv / jerk). Empty: no limit."),
    row!(
        "path.acceleration_limits_command",
        "Acceleration before the filters",
        flag[path.limits_command],
        "The control applies acceleration limits before its filters, so a ramp takes the time of both; otherwise Truefeed slows the filtered motion where it exceeds them."
    ),
    row!("interpolator.arc_chord_error_mm", "Chords of arcs within",
        case Millimetre (1e-5, 10.0) [interpolator.arc_chords] of ArcChords::Within, else ArcChords::Whole,
        "The control divides arcs into chords within this distance, each a block, as grbl ($12). Empty: it does not."),
    row!("interpolator.arc_chord_mm", "Chords of arcs of",
        case Millimetre (1e-3, 100.0) [interpolator.arc_chords] of ArcChords::Long, else ArcChords::Whole,
        "The control divides arcs into chords of this length, each a block, as Klipper (resolution). Empty: it does not."),
    row!("interpolator.minimum_cruise_ratio", "Minimum cruise ratio", value Number (0.0, 0.99) [interpolator.minimum_cruise_ratio] or 0.0,
        "Limits the speed of moves that only accelerate and brake, as Klipper does, by lowering their acceleration by this part. Needs acceleration before the filters. 0: no such limit."),
    row!(
        "interpolator.quintic_ramps",
        "Quintic ramps",
        flag[interpolator.quintic_ramps],
        "Ramps of constant acceleration take the same time on a curve of fifth order, which begins and ends without acceleration, as in Marlin (S_CURVE_ACCELERATION)."
    ),
    row!(
        "interpolator.short_blocks_are_chords",
        "Short blocks as chords",
        flag[interpolator.short_blocks_are_chords],
        "Limits the acceleration at each corner to that of the next block. Passes turns of less than 45° into blocks shorter than 1 mm as arcs with these blocks as chords. Marlin does both with a junction deviation (JD_HANDLE_SMALL_SEGMENTS)."
    ),
];
