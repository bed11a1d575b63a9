//! The table of machine parameters: one row serves the machine file, the form on the page, the manual and the
//! fit.
//!
//! The key of a row is its place in the machine file, `[table]` and key joined by a dot. [`Unit`] converts
//! values on their way in and out, so that the rest of the program uses mm, s and rad.

mod axes;
mod calibrated;
mod curves;
mod halts;
mod reading;
mod times;

use crate::machine::block_supply::BLOCK_SUPPLY;
use crate::machine::junction::JUNCTION;
use crate::machine::keyword::variant_of;
use crate::machine::parameter::{
    Access, JERK_BOUNDS_MM_S3, Parameter, TOLERANCE_BOUNDS_MM, number, row, whole,
};
use crate::machine::parameters::axes::axes;
use crate::machine::parameters::calibrated::CALIBRATED;
use crate::machine::parameters::curves::CURVES;
use crate::machine::parameters::halts::HALTS;
use crate::machine::parameters::reading::READING;
use crate::machine::parameters::times::TIMES;
use crate::machine::{CornerMode, DEFAULT_ARC_STEP_RAD, DEFAULT_ROTARY_RATE_RAD_S, TimeConstants};
use crate::units::Unit;

/// Returns the row with this key; `None` if there is none.
pub fn parameter(key: &str) -> Option<&'static Parameter> {
    PARAMETERS.iter().find(|parameter| parameter.key == key)
}

const TIME_CONSTANT_BOUNDS_S: (f64, f64) = (1e-4, 2.0);
/// Bounds of distances along the path.
const DISTANCE_BOUNDS_MM: (f64, f64) = (0.0, 1e12);

/// Time constants have one of three forms: setting one replaces the others, and clearing a form that is not
/// current has no effect.
fn set_equal(constants: &mut TimeConstants, value: Option<f64>) {
    if let Some(seconds) = value {
        *constants = TimeConstants::Equal(seconds);
    }
}

fn set_from_jerk(constants: &mut TimeConstants, value: Option<f64>) {
    if let Some(jerk) = value {
        *constants = TimeConstants::FromJerk(jerk);
    }
}

fn equal(constants: &TimeConstants) -> Option<f64> {
    match constants {
        TimeConstants::Equal(seconds) => Some(*seconds),
        _ => None,
    }
}

fn jerk(constants: &TimeConstants) -> Option<f64> {
    match constants {
        TimeConstants::FromJerk(jerk) => Some(*jerk),
        _ => None,
    }
}

const NAMES: [Parameter; 2] = [
    Parameter {
        key: "name",
        label: "Name",
        doc: "Your name for the machine.",
        access: Access::Text { get: |m| &m.name, set: |m, v| m.name = v.to_string() },
    },
    Parameter {
        key: "provenance",
        label: "Provenance",
        doc: "The origin of the numbers: which runs, and how far off they are.",
        access: Access::Text { get: |m| &m.provenance, set: |m, v| m.provenance = v.to_string() },
    },
];

const GENERAL: [Parameter; 28] = [
    Parameter {
        key: "interpolator.filters",
        label: "Filters",
        doc: "First-order FIR filters in series: 2 gives jerk-limited ramps, 3 smoother ones.",
        access: whole(
            (1.0, 4.0),
            |m| Some(m.interpolator.filters as f64),
            |m, v| m.interpolator.filters = v.unwrap_or(3.0) as usize,
        ),
    },
    Parameter {
        key: "interpolator.time_constant_s",
        label: "Time constant T1",
        doc: "Averaging time of each filter; a full ramp lasts filters × T1.",
        access: number(
            Unit::Second,
            TIME_CONSTANT_BOUNDS_S,
            |m| equal(&m.interpolator.time_constants),
            |m, v| set_equal(&mut m.interpolator.time_constants, v),
        ),
    },
    Parameter {
        key: "interpolator.max_jerk_mm_s3",
        label: "Jerk limit",
        doc: "Instead of T1: T1 = √(feedrate / jerk), per feedrate.",
        access: number(
            Unit::MillimetrePerSecond3,
            JERK_BOUNDS_MM_S3,
            |m| jerk(&m.interpolator.time_constants),
            |m, v| set_from_jerk(&mut m.interpolator.time_constants, v),
        ),
    },
    Parameter {
        key: "interpolator.time_constants_s",
        label: "Time constants",
        doc: "Instead of T1: one averaging time for each filter.",
        access: Access::List {
            unit: Unit::Second,
            min: TIME_CONSTANT_BOUNDS_S.0,
            max: TIME_CONSTANT_BOUNDS_S.1,
            whole: false,
            least: 1,
            most: 4,
            get: |m| match &m.interpolator.time_constants {
                TimeConstants::Unequal(list) => Some(list.clone()),
                _ => None,
            },
            set: |m, v| m.interpolator.time_constants = TimeConstants::Unequal(v),
        },
    },
    row!("interpolator.contour_tolerance_mm", "Contour tolerance", value Millimetre TOLERANCE_BOUNDS_MM [interpolator.contour_tolerance] or 0.01,
        "How far the motion may leave the programmed path at a corner."),
    Parameter {
        key: "interpolator.corner_mode",
        label: "Corner mode",
        doc: "paper: treats each corner as if it were alone, as published; guaranteed: keeps the filtered path within the tolerance everywhere.",
        access: Access::Choice {
            words: &[CornerMode::WORDS[0].0, CornerMode::WORDS[1].0],
            get: |m| m.interpolator.corner_mode.word(),
            set: |m, v| {
                if let Some(mode) = variant_of(&CornerMode::WORDS, v) {
                    m.interpolator.corner_mode = mode;
                }
            },
        },
    },
    row!("interpolator.exact_stop_angle_deg", "Exact stop above", value Degree (0.0, 180.0) [interpolator.exact_stop_angle] or std::f64::consts::PI,
        "Full stop where the path turns by more than this angle; 0: at the end of every block; 180: never."),
    row!("interpolator.arc_step_deg", "Chords of arcs", value Degree (0.01, 3600.0) [interpolator.arc_step] or DEFAULT_ARC_STEP_RAD,
        "Angle of the chords into which the control divides an arc; the slowing at a corner ends with the first chord. Empty: 1; 3600: undivided."),
    row!("rapid.feed_mm_min", "Rapid feedrate", limit MillimetrePerMinute (1.0, 1e6) [rapid.feedrate],
        "Feedrate of rapid moves along the path. Empty: only the rapids of the axes limit it, and each axis needs one."),
    row!("rapid.rotary_deg_min", "Rapid rate of rotary axes", value DegreePerMinute (1.0, 1e7) [rapid.rotary_rate] or DEFAULT_ROTARY_RATE_RAD_S,
        "Rate of each of A, B and C in rapid. Empty: 9000 (25 rev/min)."),
    Parameter {
        key: "rapid.exact_stop",
        label: "Stop around rapids",
        doc: "Makes a full stop where feed changes to rapid and back, and between rapids.",
        access: Access::Flag { get: |m| m.rapid.exact_stop, set: |m, v| m.rapid.exact_stop = v },
    },
    Parameter {
        key: "rapid.time_constant_s",
        label: "Time constant T1 of rapids",
        doc: "Averaging time of each filter in rapids. Empty: as in feed. If it differs, feed and rapid meet in a full stop.",
        access: number(
            Unit::Second,
            TIME_CONSTANT_BOUNDS_S,
            |m| m.rapid.time_constants.as_ref().and_then(equal),
            |m, v| {
                m.rapid.time_constants = v
                    .map(TimeConstants::Equal)
                    .or_else(|| m.rapid.time_constants.take().filter(|t| equal(t).is_none()))
            },
        ),
    },
    Parameter {
        key: "rapid.max_jerk_mm_s3",
        label: "Jerk limit of rapids",
        doc: "Instead of the rapids' own T1: T1 = √(rapid feedrate / jerk).",
        access: number(
            Unit::MillimetrePerSecond3,
            JERK_BOUNDS_MM_S3,
            |m| m.rapid.time_constants.as_ref().and_then(jerk),
            |m, v| {
                m.rapid.time_constants = v
                    .map(TimeConstants::FromJerk)
                    .or_else(|| m.rapid.time_constants.take().filter(|t| jerk(t).is_none()))
            },
        ),
    },
    row!("path.velocity_mm_min", "Path velocity limit", limit MillimetrePerMinute (1.0, 1e6) [path.velocity],
        "Largest velocity along the path in feed and rapid, as an operator sets it; empty: no limit."),
    row!("path.acceleration_mm_s2", "Path acceleration limit", limit MillimetrePerSecond2 (1.0, 1e6) [path.acceleration],
        "Largest acceleration along the path; empty: no limit."),
    row!("path.centripetal_acceleration_mm_s2", "Centripetal acceleration limit", limit MillimetrePerSecond2 (1.0, 1e6) [path.centripetal_acceleration],
        "Largest acceleration towards the centre of an arc; empty: no limit."),
    row!("override.feed", "Feed override", value Number (0.01, 10.0) [overrides.feed] or 1.0,
        "Factor on every programmed feedrate; 1: as programmed."),
    row!("override.rapid", "Rapid override", value Number (0.01, 10.0) [overrides.rapid] or 1.0,
        "Factor on the rapid feedrate; 1: full."),
    Parameter {
        key: "override.from_line",
        label: "Feed override from line",
        doc: "First line of the program on which the feed override is in force; empty: the first.",
        access: whole(
            (0.0, 4e9),
            |m| Some(f64::from(m.overrides.lines.0)),
            |m, v| m.overrides.lines.0 = v.unwrap_or(0.0) as u32,
        ),
    },
    Parameter {
        key: "override.to_line",
        label: "Feed override to line",
        doc: "Last line of the program on which the feed override is in force; empty: the last.",
        access: whole(
            (0.0, 4e9),
            |m| (m.overrides.lines.1 < u32::MAX).then_some(f64::from(m.overrides.lines.1)),
            |m, v| m.overrides.lines.1 = v.map_or(u32::MAX, |line| line as u32),
        ),
    },
    Parameter {
        key: "override.from_mm",
        label: "Feed override from",
        doc: "Distance along the path from which the feed override is in force; empty: from the beginning.",
        access: number(
            Unit::Millimetre,
            DISTANCE_BOUNDS_MM,
            |m| (0.0 < m.overrides.span.0).then_some(m.overrides.span.0),
            |m, v| m.overrides.span.0 = v.unwrap_or(0.0),
        ),
    },
    row!("override.to_mm", "Feed override to", limit Millimetre DISTANCE_BOUNDS_MM [overrides.span.1],
        "Distance along the path up to which the feed override is in force; empty: to the end."),
    row!("recorder.clock_ratio", "Recorder clock", value Number (0.5, 2.0) [recorder.clock_ratio] or 1.0,
        "Ratio of the recorder's clock to the true time. Does not change the motion."),
    row!("cycles.peck_retract_mm", "Retract of chip breaking", optional Millimetre (0.0, 100.0) [cycles.peck_retract],
        "Retraction of G73 between pecks. Empty: 0.254 mm as in LinuxCNC, 1 mm in programs with a % line or an O number."),
    row!("cycles.peck_clearance_mm", "Clearance of pecking", optional Millimetre (0.0, 100.0) [cycles.peck_clearance],
        "Distance above the last depth at which G83 changes from rapid to feed. Empty: 0.254 mm as in LinuxCNC, 1 mm in programs with a % line or an O number."),
    Parameter {
        key: "cycles.tap_pecks_out",
        label: "Tapping retracts to R between pecks",
        doc: "Peck tapping (G84 with Q) retracts to R between pecks, as Fanuc with 5200#5 = 1; otherwise by the retract of chip breaking.",
        access: Access::Flag { get: |m| m.cycles.taps_out, set: |m, v| m.cycles.taps_out = v },
    },
    Parameter {
        key: "tools",
        label: "Tool diameters",
        doc: "Diameter in mm by tool number, for example 5 = 10.0; cutter compensation (G41, G42) needs it.",
        access: Access::Tools,
    },
    row!("rates.hourly", "Hourly rate", value Number (0.0, 1e6) [rates.hourly] or 0.0,
        "Price of an hour of machine time, in your currency; empty: no price."),
];

/// Tolerances that a program selects by a level of the control.
const LEVELS: [Parameter; 6] = [
    row!("path_modes.rough_mm", "Tolerance of rough", optional Millimetre TOLERANCE_BOUNDS_MM [path_modes.rough],
        "Contour tolerance that G187 P1 (rough) selects. Empty: unknown, the contour tolerance holds."),
    row!("path_modes.medium_mm", "Tolerance of medium", optional Millimetre TOLERANCE_BOUNDS_MM [path_modes.medium],
        "Contour tolerance that G187 P2 (medium) selects. Empty: unknown, the contour tolerance holds."),
    row!("path_modes.finish_mm", "Tolerance of finish", optional Millimetre TOLERANCE_BOUNDS_MM [path_modes.finish],
        "Contour tolerance that G187 P3 (finish) selects. Empty: unknown, the contour tolerance holds."),
    row!("path_modes.level_1_mm", "Tolerance of level 1", optional Millimetre TOLERANCE_BOUNDS_MM [path_modes.level_1],
        "Contour tolerance that G5.1 Q1 R1 selects. Empty: unknown, the contour tolerance holds."),
    row!("path_modes.level_10_mm", "Tolerance of level 10", optional Millimetre TOLERANCE_BOUNDS_MM [path_modes.level_10],
        "Contour tolerance that G5.1 Q1 R10 selects; R2 to R9 lie evenly between. Empty: unknown, the contour tolerance holds."),
    row!("path_modes.tolerance_override_mm", "Tolerance instead of programmed ones", optional Millimetre TOLERANCE_BOUNDS_MM [path_modes.tolerance_override],
        "Replaces every tolerance that a program sets (G64 P and so on). Empty: the program's tolerances hold."),
];

/// All parameters in the order of forms and files.
pub static PARAMETERS: std::sync::LazyLock<Vec<Parameter>> = std::sync::LazyLock::new(|| {
    NAMES
        .into_iter()
        .chain(CALIBRATED)
        .chain(GENERAL)
        .chain(CURVES)
        .chain(JUNCTION)
        .chain(BLOCK_SUPPLY)
        .chain(LEVELS)
        .chain(READING)
        .chain(TIMES)
        .chain(HALTS)
        .chain(axes())
        .collect()
});
