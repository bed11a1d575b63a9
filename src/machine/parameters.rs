//! The table of machine parameters: one row feeds the machine file, the form on the page,
//! the manual and, later, the fit.
//!
//! A row's key is its place in the machine file, `[table]` and key joined by a dot. Values pass
//! through [`Unit`] on their way in and out, so that the rest of the program sees mm, s and rad.

mod axes;
mod curves;
mod halts;
mod reading;
mod times;

use crate::machine::junction::JUNCTION;
use crate::machine::parameter::{Access, JERK_MM_S3, Parameter, TOLERANCE_MM, finite, number, whole};
use crate::machine::parameters::axes::axes;
use crate::machine::parameters::curves::CURVES;
use crate::machine::parameters::halts::HALTS;
use crate::machine::parameters::reading::READING;
use crate::machine::parameters::times::TIMES;
use crate::machine::supply::SUPPLY;
use crate::machine::words::choice_of;
use crate::machine::{ARC_STEP, CornerMode, RAPID_ROTARY_RATE, TimeConstants};
use crate::units::Unit;

/// The row with this key.
pub fn parameter(key: &str) -> Option<&'static Parameter> {
    PARAMETERS.iter().find(|parameter| parameter.key == key)
}

const TIME_CONSTANT_S: (f64, f64) = (1e-4, 2.0);

/// Time constants are one choice of three, so that setting one form replaces the others, and
/// taking back a form that is not in force changes nothing.
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

const GENERAL: [Parameter; 31] = [
    Parameter {
        key: "name",
        label: "Name",
        doc: "What you call the machine.",
        access: Access::Text { get: |m| &m.name, set: |m, v| m.name = v.to_string() },
    },
    Parameter {
        key: "provenance",
        label: "Provenance",
        doc: "Where the numbers come from: which runs, and how far off they are.",
        access: Access::Text { get: |m| &m.provenance, set: |m, v| m.provenance = v.to_string() },
    },
    Parameter {
        key: "calibration.cycle_time_error_percent",
        label: "Error of the cycle time",
        doc: "How far off the cycle time was where these numbers were calibrated: the uncertainty of a quote; empty: unknown. An edit of the motion empties it.",
        access: number(Unit::Percent, (0.0, 100.0), |m| m.cycle_time_error, |m, v| m.cycle_time_error = v),
    },
    Parameter {
        key: "calibration.unexplained_percent",
        label: "Time left unexplained",
        doc: "Lost time, place by place and nothing set off, that these numbers left unexplained where they were calibrated: what a diagnosis takes for the model's own error; empty: unknown.",
        access: number(Unit::Percent, (0.0, 1000.0), |m| m.unexplained_time, |m, v| m.unexplained_time = v),
    },
    Parameter {
        key: "calibration.form_error_mm",
        label: "Error of the form",
        doc: "Root mean square distance of recorded from simulated positions at equal times where these numbers were calibrated; empty: unknown.",
        access: number(Unit::Millimetre, (0.0, 1000.0), |m| m.form_error, |m, v| m.form_error = v),
    },
    Parameter {
        key: "calibration.tolerances_mm",
        label: "Tolerances of that error",
        doc: "Contour tolerances it was found at, the only ones it holds for. Empty: the contour tolerance.",
        access: Access::List {
            unit: Unit::Millimetre,
            min: TOLERANCE_MM.0,
            max: TOLERANCE_MM.1,
            whole: false,
            most: 20,
            get: |m| Some(m.calibrated_at.clone()).filter(|list| !list.is_empty()),
            set: |m, v| m.calibrated_at = v,
        },
    },
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
            TIME_CONSTANT_S,
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
            JERK_MM_S3,
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
            min: TIME_CONSTANT_S.0,
            max: TIME_CONSTANT_S.1,
            whole: false,
            most: 4,
            get: |m| match &m.interpolator.time_constants {
                TimeConstants::Unequal(list) => Some(list.clone()),
                _ => None,
            },
            set: |m, v| m.interpolator.time_constants = TimeConstants::Unequal(v),
        },
    },
    Parameter {
        key: "interpolator.contour_tolerance_mm",
        label: "Contour tolerance",
        doc: "How far the motion may leave the programmed path at a corner.",
        access: number(
            Unit::Millimetre,
            TOLERANCE_MM,
            |m| Some(m.interpolator.contour_tolerance),
            |m, v| m.interpolator.contour_tolerance = v.unwrap_or(0.01),
        ),
    },
    Parameter {
        key: "interpolator.corner_mode",
        label: "Corner mode",
        doc: "paper: each corner as if alone, as published; guaranteed: the filtered path holds the tolerance everywhere.",
        access: Access::Choice {
            words: &[CornerMode::WORDS[0].0, CornerMode::WORDS[1].0],
            get: |m| m.interpolator.corner_mode.word(),
            set: |m, v| {
                if let Some(mode) = choice_of(&CornerMode::WORDS, v) {
                    m.interpolator.corner_mode = mode;
                }
            },
        },
    },
    Parameter {
        key: "interpolator.exact_stop_angle_deg",
        label: "Exact stop above",
        doc: "Full stop where the path turns by more than this angle; 180: never.",
        access: number(
            Unit::Degree,
            (0.0, 180.0),
            |m| Some(m.interpolator.exact_stop_angle),
            |m, v| m.interpolator.exact_stop_angle = v.unwrap_or(std::f64::consts::PI),
        ),
    },
    Parameter {
        key: "interpolator.arc_step_deg",
        label: "Chords of arcs",
        doc: "An arc is run as chords that turn by this angle: what is held for a corner on it ends with the first; empty: 1, 3600: arcs are run whole.",
        access: number(
            Unit::Degree,
            (0.01, 3600.0),
            |m| Some(m.interpolator.arc_step),
            |m, v| m.interpolator.arc_step = v.unwrap_or(ARC_STEP),
        ),
    },
    Parameter {
        key: "rapid.feed_mm_min",
        label: "Rapid feedrate",
        doc: "Feedrate of rapid moves along the path; empty: only the rapids of the axes, where each has one.",
        access: number(
            Unit::MillimetrePerMinute,
            (1.0, 1e6),
            |m| finite(m.rapid.feedrate),
            |m, v| m.rapid.feedrate = v.unwrap_or(f64::INFINITY),
        ),
    },
    Parameter {
        key: "rapid.rotary_deg_min",
        label: "Rapid rate of rotary axes",
        doc: "Rate at which each of A, B and C turns in rapid; empty: 9000, that is 25 rev/min.",
        access: number(
            Unit::DegreePerMinute,
            (1.0, 1e7),
            |m| Some(m.rapid.rotary_rate),
            |m, v| m.rapid.rotary_rate = v.unwrap_or(RAPID_ROTARY_RATE),
        ),
    },
    Parameter {
        key: "rapid.exact_stop",
        label: "Stop around rapids",
        doc: "Full stop where feed changes to rapid and back, and between rapids.",
        access: Access::Flag { get: |m| m.rapid.exact_stop, set: |m, v| m.rapid.exact_stop = v },
    },
    Parameter {
        key: "rapid.time_constant_s",
        label: "Time constant T1 of rapids",
        doc: "Averaging time of each filter in rapids; empty: as in feed. Where it differs, a full stop joins feed and rapid.",
        access: number(
            Unit::Second,
            TIME_CONSTANT_S,
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
            JERK_MM_S3,
            |m| m.rapid.time_constants.as_ref().and_then(jerk),
            |m, v| {
                m.rapid.time_constants = v
                    .map(TimeConstants::FromJerk)
                    .or_else(|| m.rapid.time_constants.take().filter(|t| jerk(t).is_none()))
            },
        ),
    },
    Parameter {
        key: "path.acceleration_mm_s2",
        label: "Path acceleration limit",
        doc: "Largest acceleration along the path; empty: no limit.",
        access: number(
            Unit::MillimetrePerSecond2,
            (1.0, 1e6),
            |m| finite(m.path.acceleration),
            |m, v| m.path.acceleration = v.unwrap_or(f64::INFINITY),
        ),
    },
    Parameter {
        key: "path.centripetal_acceleration_mm_s2",
        label: "Centripetal acceleration limit",
        doc: "Largest acceleration towards the centre of an arc; empty: no limit.",
        access: number(
            Unit::MillimetrePerSecond2,
            (1.0, 1e6),
            |m| finite(m.path.centripetal_acceleration),
            |m, v| m.path.centripetal_acceleration = v.unwrap_or(f64::INFINITY),
        ),
    },
    Parameter {
        key: "override.feed",
        label: "Feed override",
        doc: "Factor on every programmed feedrate; 1: as programmed.",
        access: number(
            Unit::Number,
            (0.01, 10.0),
            |m| Some(m.overrides.feed),
            |m, v| m.overrides.feed = v.unwrap_or(1.0),
        ),
    },
    Parameter {
        key: "override.rapid",
        label: "Rapid override",
        doc: "Factor on the rapid feedrate; 1: full.",
        access: number(
            Unit::Number,
            (0.01, 10.0),
            |m| Some(m.overrides.rapid),
            |m, v| m.overrides.rapid = v.unwrap_or(1.0),
        ),
    },
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
        key: "recorder.clock_ratio",
        label: "Recorder clock",
        doc: "Time the recorder's clock shows over the time that passes; changes no motion.",
        access: number(
            Unit::Number,
            (0.5, 2.0),
            |m| Some(m.recorder.clock_ratio),
            |m, v| m.recorder.clock_ratio = v.unwrap_or(1.0),
        ),
    },
    Parameter {
        key: "cycles.peck_retract_mm",
        label: "Retract of chip breaking",
        doc: "How far G73 lifts the tool between pecks; empty: 0.254 mm as LinuxCNC, 1 mm in programs with a % line or an O number.",
        access: number(
            Unit::Millimetre,
            (0.0, 100.0),
            |m| m.cycles.peck_retract,
            |m, v| m.cycles.peck_retract = v,
        ),
    },
    Parameter {
        key: "cycles.peck_clearance_mm",
        label: "Clearance of pecking",
        doc: "How far above the last depth G83 goes from rapid to feed; empty: 0.254 mm as LinuxCNC, 1 mm in programs with a % line or an O number.",
        access: number(
            Unit::Millimetre,
            (0.0, 100.0),
            |m| m.cycles.peck_clearance,
            |m, v| m.cycles.peck_clearance = v,
        ),
    },
    Parameter {
        key: "cycles.tap_pecks_out",
        label: "Tapping comes out between pecks",
        doc: "Tapping with Q (G84) goes out to R between pecks, as Fanuc with 5200#5 = 1; else back by the retract of chip breaking.",
        access: Access::Flag { get: |m| m.cycles.taps_out, set: |m, v| m.cycles.taps_out = v },
    },
    Parameter {
        key: "tools",
        label: "Tool diameters",
        doc: "Diameter in mm by tool number, for example 5 = 10.0; cutter compensation (G41, G42) needs it.",
        access: Access::Tools,
    },
    Parameter {
        key: "rates.hourly",
        label: "Hourly rate",
        doc: "Price of an hour of machine time, in your currency; empty: no price.",
        access: number(
            Unit::Number,
            (0.0, 1e6),
            |m| Some(m.rates.hourly),
            |m, v| m.rates.hourly = v.unwrap_or(0.0),
        ),
    },
];

/// Tolerances that a program asks for by a level of the control.
const LEVELS: [Parameter; 6] = [
    Parameter {
        key: "path_modes.rough_mm",
        label: "Tolerance of rough",
        doc: "Contour tolerance that the program asks for by G187 P1 (rough); empty: unknown, the contour tolerance holds.",
        access: number(Unit::Millimetre, TOLERANCE_MM, |m| m.path_modes.rough, |m, v| m.path_modes.rough = v),
    },
    Parameter {
        key: "path_modes.medium_mm",
        label: "Tolerance of medium",
        doc: "Contour tolerance that the program asks for by G187 P2 (medium); empty: unknown, the contour tolerance holds.",
        access: number(
            Unit::Millimetre,
            TOLERANCE_MM,
            |m| m.path_modes.medium,
            |m, v| m.path_modes.medium = v,
        ),
    },
    Parameter {
        key: "path_modes.finish_mm",
        label: "Tolerance of finish",
        doc: "Contour tolerance that the program asks for by G187 P3 (finish); empty: unknown, the contour tolerance holds.",
        access: number(
            Unit::Millimetre,
            TOLERANCE_MM,
            |m| m.path_modes.finish,
            |m, v| m.path_modes.finish = v,
        ),
    },
    Parameter {
        key: "path_modes.level_1_mm",
        label: "Tolerance of level 1",
        doc: "Contour tolerance that the program asks for by G5.1 Q1 R1; empty: unknown, the contour tolerance holds.",
        access: number(
            Unit::Millimetre,
            TOLERANCE_MM,
            |m| m.path_modes.level_1,
            |m, v| m.path_modes.level_1 = v,
        ),
    },
    Parameter {
        key: "path_modes.level_10_mm",
        label: "Tolerance of level 10",
        doc: "Contour tolerance that the program asks for by G5.1 Q1 R10; levels between lie evenly between both; empty: unknown, the contour tolerance holds.",
        access: number(
            Unit::Millimetre,
            TOLERANCE_MM,
            |m| m.path_modes.level_10,
            |m, v| m.path_modes.level_10 = v,
        ),
    },
    Parameter {
        key: "path_modes.tolerance_override_mm",
        label: "Tolerance in place of programmed ones",
        doc: "What the control holds in place of every tolerance that a program sets (G64 P and so on); empty: what the program says.",
        access: number(
            Unit::Millimetre,
            TOLERANCE_MM,
            |m| m.path_modes.tolerance_override,
            |m, v| m.path_modes.tolerance_override = v,
        ),
    },
];

/// All parameters in the order of forms and files.
pub static PARAMETERS: std::sync::LazyLock<Vec<Parameter>> = std::sync::LazyLock::new(|| {
    GENERAL
        .into_iter()
        .chain(CURVES)
        .chain(JUNCTION)
        .chain(SUPPLY)
        .chain(LEVELS)
        .chain(READING)
        .chain(TIMES)
        .chain(HALTS)
        .chain(axes())
        .collect()
});
