//! Junction laws, by which a control limits the feedrate at corners, and their rows in the parameter table.

use crate::machine::keyword::keywords;
use crate::machine::parameter::{Access, Parameter, row};

/// The law that limits the feedrate at a corner in addition to the contour tolerance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Junction {
    /// No law: only the tolerance limits corners.
    Tolerance,
    /// A circle within the contour tolerance that the acceleration allows, or a parabola, as in LinuxCNC.
    AccelerationBlend,
    /// Only a parabola, as in LinuxCNC without arc blends.
    ParabolicBlend,
    /// A stop at each corner that the acceleration does not allow without a blend, as in LinuxCNC's exact
    /// path mode.
    ExactPath,
    /// The acceleration on a circle that passes the corner at this distance, mm, as in grbl.
    Deviation(f64),
    /// This feedrate at a corner of 90°, mm/s, and at other corners the same centripetal acceleration on a
    /// circle that passes them equally closely, as in Klipper.
    SquareCorner(f64),
    /// This step of velocity of any axis, mm/s, as in Marlin.
    AxisStep(f64),
}

impl Junction {
    /// The laws that a keyword selects, with their keywords.
    const KEYWORDS: [(&'static str, Junction); 4] = [
        ("tolerance", Junction::Tolerance),
        ("acceleration_blend", Junction::AccelerationBlend),
        ("parabolic_blend", Junction::ParabolicBlend),
        ("exact_path", Junction::ExactPath),
    ];

    /// Returns `true` if corners are those of LinuxCNC: circles, parabolas, or exact.
    pub fn blends_in_time(self) -> bool {
        matches!(self, Junction::AccelerationBlend | Junction::ParabolicBlend | Junction::ExactPath)
    }
}

/// The rows of the law. Each law with a value has a row, so that the value carries its unit; setting the
/// value selects the law, and clearing it clears only that law.
pub(super) const JUNCTION: [Parameter; 8] = [
    Parameter {
        key: "interpolator.junction_rule",
        label: "Junctions",
        doc: "tolerance: the contour tolerance alone limits corners; acceleration_blend: also the acceleration on a circle within it, as in LinuxCNC; parabolic_blend: both legs run at once, as in LinuxCNC without arc blends; exact_path: every program runs as after G61 of LinuxCNC, with a stop at each corner that the acceleration of the axes does not allow as programmed.",
        access: Access::Choice {
            words: &const { keywords(&Junction::KEYWORDS) },
            get: |m| {
                let rule =
                    Junction::KEYWORDS.iter().find(|(_, junction)| *junction == m.interpolator.junction);
                rule.unwrap_or(&Junction::KEYWORDS[0]).0
            },
            set: |m, v| {
                let rule = Junction::KEYWORDS.iter().find(|(word, _)| *word == v);
                if let Some((_, junction)) = rule.filter(|(_, junction)| *junction != Junction::Tolerance) {
                    m.interpolator.junction = *junction
                }
            },
        },
    },
    row!("interpolator.junction_deviation_mm", "Junction deviation",
        case Millimetre (1e-6, 10.0) [interpolator.junction] of Junction::Deviation, else Junction::Tolerance,
        "The acceleration on a circle that passes the corner at this distance limits its feedrate, as in grbl. Empty: no such limit."),
    row!("interpolator.square_corner_velocity_mm_min", "Square-corner velocity",
        case MillimetrePerMinute (0.01, 1e6) [interpolator.junction] of Junction::SquareCorner, else Junction::Tolerance,
        "Highest feedrate at a corner of 90°; other corners follow from the same circle, as in Klipper. Empty: no such limit."),
    row!("interpolator.axis_velocity_step_mm_min", "Velocity step of axes",
        case MillimetrePerMinute (0.01, 1e6) [interpolator.junction] of Junction::AxisStep, else Junction::Tolerance,
        "Largest step of an axis velocity at a corner. Empty: no such limit."),
    row!("interpolator.max_override_percent", "Override planned for", value Percent (100.0, 1000.0) [interpolator.max_override] or 1.0,
        "Largest feed override that the control plans blends for, which makes them wider than the programmed feedrate needs, as in LinuxCNC (MAX_FEED_OVERRIDE)."),
    row!("interpolator.slowing_angle_deg", "Corners slow to a stop at", limit Degree (1.0, 3600.0) [interpolator.slowing_angle],
        "The control slows corners by the fourth power of their angle, down to a full stop from this angle on. Empty: it does not."),
    row!("interpolator.path_smoothing_mm", "Path smoothing", optional Millimetre (0.0, 10.0) [interpolator.path_smoothing],
        "The control merges lines that deviate from one line by no more than this. 0: it does not; empty: with acceleration_blend, by Q or P of G64."),
    row!("interpolator.corner_smoothing_mm", "Corner smoothing", value Millimetre (0.0, 10.0) [interpolator.corner_smoothing] or 0.0,
        "Corners that a curve can pass within this distance do not slow the motion. 0: all do."),
];
