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
use crate::machine::parameter::{
    Access, JERK_BOUNDS_MM_S3, Parameter, TOLERANCE_BOUNDS_MM, list, row, whole,
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

const TIME_CONSTANT_BOUNDS_S: (f64, f64) = (1e-5, 2.0);
/// Bounds of distances along the path.
const DISTANCE_BOUNDS_MM: (f64, f64) = (0.0, 1e12);

/// Bounds of the number of a line.
const LINE_BOUNDS: (f64, f64) = (0.0, 4e9);

/// Replaces the time constants, which have one of three forms. Clearing a form that is not current has no effect, and
/// the current one cannot be cleared.
fn replace(constants: &mut TimeConstants, value: Option<TimeConstants>) {
    if let Some(value) = value {
        *constants = value;
    }
}

/// Replaces the rapids' own time constants, or clears them if they have the form that `read` reads.
fn replace_own(
    constants: &mut Option<TimeConstants>,
    value: Option<TimeConstants>,
    read: fn(&TimeConstants) -> Option<f64>,
) {
    if value.is_some() || constants.as_ref().and_then(read).is_some() {
        *constants = value;
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
    row!(
        "name",
        "Name",
        Access::Text { get: |m| &m.name, set: |m, v| m.name = v.to_string() },
        "Your name for the machine."
    ),
    row!(
        "provenance",
        "Provenance",
        Access::Text { get: |m| &m.provenance, set: |m, v| m.provenance = v.to_string() },
        "The origin of the numbers: which runs, and how far off they are."
    ),
];

const GENERAL: [Parameter; 29] = [
    row!(
        "interpolator.filters",
        "Filters",
        whole(
            (1.0, 4.0),
            |m| Some(m.interpolator.filters as f64),
            |m, v| m.interpolator.filters = v.unwrap_or(3.0) as usize,
        ),
        "First-order FIR filters in series: 2 gives jerk-limited ramps, 3 smoother ones."
    ),
    row!("interpolator.time_constant_s", "Time constant T1", Second TIME_CONSTANT_BOUNDS_S,
        |m| equal(&m.interpolator.time_constants),
        |m, v| replace(&mut m.interpolator.time_constants, v.map(TimeConstants::Equal)),
        "Averaging time of each filter; a full ramp lasts filters × T1."),
    row!("interpolator.max_jerk_mm_s3", "Jerk limit", MillimetrePerSecond3 JERK_BOUNDS_MM_S3,
        |m| jerk(&m.interpolator.time_constants),
        |m, v| replace(&mut m.interpolator.time_constants, v.map(TimeConstants::FromJerk)),
        "Instead of T1: T1 = √(feedrate / jerk), per feedrate."),
    row!(
        "interpolator.time_constants_s",
        "Time constants",
        list(
            Unit::Second,
            TIME_CONSTANT_BOUNDS_S,
            4,
            |m| match &m.interpolator.time_constants {
                TimeConstants::Unequal(list) => Some(list.clone()),
                _ => None,
            },
            |m, v| m.interpolator.time_constants = TimeConstants::Unequal(v),
        ),
        "Instead of T1: one averaging time for each filter."
    ),
    row!("interpolator.contour_tolerance_mm", "Contour tolerance", value Millimetre TOLERANCE_BOUNDS_MM [interpolator.contour_tolerance] or 0.01,
        "How far the motion may leave the programmed path at a corner."),
    row!("interpolator.corner_mode", "Corner mode", choice CornerMode [interpolator.corner_mode],
        "paper: treats each corner as if it were alone, as published; guaranteed: keeps the filtered path within the tolerance everywhere."),
    row!("interpolator.exact_stop_angle_deg", "Exact stop above", value Degree (0.0, 180.0) [interpolator.exact_stop_angle] or std::f64::consts::PI,
        "Full stop where the path turns by more than this angle; 0: at the end of every block; 180: never."),
    row!("interpolator.arc_step_deg", "Chords of arcs", value Degree (0.01, 3600.0) [interpolator.arc_step] or DEFAULT_ARC_STEP_RAD,
        "Angle of the chords into which the control divides an arc; the slowing at a corner ends with the first chord. Empty: 1; 3600: undivided."),
    row!("rapid.feed_mm_min", "Rapid feedrate", limit MillimetrePerMinute (1.0, 1e6) [rapid.feedrate],
        "Feedrate of rapid moves along the path. Empty: only the rapids of the axes limit it, and each axis needs one."),
    row!("rapid.rotary_deg_min", "Rapid rate of rotary axes", value DegreePerMinute (1.0, 1e7) [rapid.rotary_rate] or DEFAULT_ROTARY_RATE_RAD_S,
        "Rate of each of A, B and C in rapid. Empty: 9000 (25 rev/min)."),
    row!(
        "rapid.at_feedrate",
        "Rapids at F",
        flag[rapid.at_feedrate],
        "Rapids run at the feedrate that F has set, up to the rapid feedrates, and the feed override acts on them, as on Klipper and Marlin."
    ),
    row!(
        "rapid.exact_stop",
        "Stop around rapids",
        flag[rapid.exact_stop],
        "Makes a full stop where feed changes to rapid and back, and between rapids."
    ),
    row!("rapid.time_constant_s", "Time constant T1 of rapids", Second TIME_CONSTANT_BOUNDS_S,
        |m| m.rapid.time_constants.as_ref().and_then(equal),
        |m, v| replace_own(&mut m.rapid.time_constants, v.map(TimeConstants::Equal), equal),
        "Averaging time of each filter in rapids. Empty: as in feed. If it differs, feed and rapid meet in a full stop."),
    row!("rapid.max_jerk_mm_s3", "Jerk limit of rapids", MillimetrePerSecond3 JERK_BOUNDS_MM_S3,
        |m| m.rapid.time_constants.as_ref().and_then(jerk),
        |m, v| replace_own(&mut m.rapid.time_constants, v.map(TimeConstants::FromJerk), jerk),
        "Instead of the rapids' own T1: T1 = √(rapid feedrate / jerk)."),
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
    row!(
        "override.from_line",
        "Feed override from line",
        whole(
            LINE_BOUNDS,
            |m| Some(f64::from(m.overrides.lines.0)),
            |m, v| m.overrides.lines.0 = v.unwrap_or(0.0) as u32,
        ),
        "First line of the program on which the feed override is in force; empty: the first."
    ),
    row!(
        "override.to_line",
        "Feed override to line",
        whole(
            LINE_BOUNDS,
            |m| (m.overrides.lines.1 < u32::MAX).then_some(f64::from(m.overrides.lines.1)),
            |m, v| m.overrides.lines.1 = v.map_or(u32::MAX, |line| line as u32),
        ),
        "Last line of the program on which the feed override is in force; empty: the last."
    ),
    row!("override.from_mm", "Feed override from", Millimetre DISTANCE_BOUNDS_MM,
        |m| (0.0 < m.overrides.span.0).then_some(m.overrides.span.0),
        |m, v| m.overrides.span.0 = v.unwrap_or(0.0),
        "Distance along the path from which the feed override is in force; empty: from the beginning."),
    row!("override.to_mm", "Feed override to", limit Millimetre DISTANCE_BOUNDS_MM [overrides.span.1],
        "Distance along the path up to which the feed override is in force; empty: to the end."),
    row!("recorder.clock_ratio", "Recorder clock", value Number (0.5, 2.0) [recorder.clock_ratio] or 1.0,
        "Ratio of the recorder's clock to the true time. Does not change the motion."),
    row!("cycles.peck_retract_mm", "Retract of chip breaking", optional Millimetre (0.0, 100.0) [cycles.peck_retract],
        "Retraction of G73 between pecks. Empty: 0.254 mm as in LinuxCNC, 1 mm in programs with a % line or an O number."),
    row!("cycles.peck_clearance_mm", "Clearance of pecking", optional Millimetre (0.0, 100.0) [cycles.peck_clearance],
        "Distance above the last depth at which G83 changes from rapid to feed. Empty: 0.254 mm as in LinuxCNC, 1 mm in programs with a % line or an O number."),
    row!(
        "cycles.tap_pecks_out",
        "Tapping retracts to R between pecks",
        flag[cycles.taps_out],
        "Peck tapping (G84 with Q) retracts to R between pecks, as Fanuc with 5200#5 = 1; otherwise by the retract of chip breaking."
    ),
    row!(
        "tools",
        "Tool diameters",
        Access::Tools,
        "Diameter in mm by tool number, for example 5 = 10.0; cutter compensation (G41, G42) needs it."
    ),
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
