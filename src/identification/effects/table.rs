//! The table of effects: each row holds all facts about one effect, except its physics.
//!
//! Names of settings are from the vendors' manuals: Siemens machine data (MD), Heidenhain machine parameters (MP)
//! and configuration names, Fanuc parameter numbers, grbl and LinuxCNC settings.

use crate::identification::effects::effect::{Context, Effect, Hypothesis, Nature, Origin, Row};
use crate::identification::effects::report::{self as of, Finding, three_digits};
use crate::identification::effects::{corners, drives, filters, limits, overrides, stops, supply};

/// Rarity of a change that needs new software of the control: one occurs for every twenty changes of settings and
/// switches (2 ln 20).
const OF_SOFTWARE: f64 = 6.0;
/// Rarity of a clock that is off by more than quartz, 2e-4: the clock is built in and cannot be set.
const OF_CLOCKS: f64 = 6.0;

/// Declares the effects with their rows.
macro_rules! effects {
    ($($(#[$doc:meta])* $name:ident { $($row:tt)* })*) => {
        $($(#[$doc])* pub const $name: Effect = Effect(&Row { $($row)* ..DEFAULT_ROW });)*

        /// All effects, in the order of the contract.
        pub const ALL: &[Effect] = &[$($name,)*];
    };
}

/// Returns the effect with this id; `None` if there is none.
///
/// # Examples
///
/// ```
/// use truefeed::identification::effects::{ALL, LOOK_AHEAD, with_id};
///
/// assert_eq!(with_id("look_ahead"), Some(LOOK_AHEAD));
/// assert!(LOOK_AHEAD.vendors.contains("G103 P (Haas)"));
/// assert!(ALL.iter().all(|effect| with_id(effect.id) == Some(*effect)));
/// ```
pub fn with_id(id: &str) -> Option<Effect> {
    ALL.iter().copied().find(|effect| effect.id == id)
}

/// Row with the values that most effects share: a setting of the machine that a program provokes.
const DEFAULT_ROW: Row = Row {
    id: "",
    nature: Nature::Setting,
    origin: Origin::Machine,
    rarity: 0.0,
    vendors: "",
    unprovoked: None,
    offered: none,
    sentence: |f| format!("Something acts {}{}.", f.at_lines(), f.costs()),
};

/// Returns no hypotheses, for an effect that none frees.
fn none(_: Effect, _: &Context) -> Vec<Hypothesis> {
    Vec::new()
}

/// Returns the ratio of a finding as a percentage.
fn percent(f: &Finding) -> String {
    three_digits(100.0 * f.value(of::RATIO).unwrap_or(f64::NAN))
}

effects! {
    /// Acceleration limit of an axis.
    AXIS_ACCELERATION_LIMIT {
        id: "axis_acceleration_limit", nature: Nature::Limit, offered: limits::axis_accelerations,
        vendors: "MAX_AX_ACCEL (Siemens MD32300), maxAcceleration or MP1060 (Heidenhain), $120–$122 (grbl), MAX_ACCELERATION (LinuxCNC)",
        sentence: |f| match (f.number(of::ACCELERATION), f.costs(), f.get(of::PLANNER)) {
            (a, costs, Some(_)) => format!(
                "Ramps grow with the change of speed: the planner limits acceleration to {a} mm/s² on each axis and does not filter{costs}."
            ),
            (a, costs, None) => format!("Axis {} accelerates at {a} mm/s² at most{costs}.", f.word(of::AXIS)),
        },
    }
    /// Acceleration limit of the tool along the path.
    PATH_ACCELERATION_LIMIT {
        id: "path_acceleration_limit", nature: Nature::Limit, offered: limits::path_acceleration,
        vendors: "MAX_PATH_ACCEL (Siemens), MP1061 (Heidenhain), max_accel (Klipper)",
        sentence: |f| format!(
            "Ramps grow with the change of speed: the machine accelerates along the path at {} mm/s² at most{}.",
            f.number(of::ACCELERATION), f.costs()
        ),
    }
    /// Velocity limit of an axis.
    AXIS_VELOCITY_LIMIT {
        id: "axis_velocity_limit", nature: Nature::Limit, offered: limits::axis_velocities,
        vendors: "MAX_AX_VELO (Siemens), No. 1422 (Fanuc), MP1010 or F LIMIT (Heidenhain), $110–$112 (grbl), maximum velocity (LinuxCNC)",
        sentence: |f| match f.word(of::AXIS) {
            limits::ALL_AXES => format!(
                "The machine moves at {} mm/min along the path at most, in feed and rapid{}.", f.number(of::VELOCITY), f.costs()
            ),
            axis => format!("Axis {axis} moves at {} mm/min at most{}.", f.number(of::VELOCITY), f.costs()),
        },
    }
    /// Jerk limit along the path, of rapids, or behind the filters' time constants.
    JERK_LIMIT {
        id: "jerk_limit", nature: Nature::Limit, offered: limits::jerks,
        vendors: "MAX_AX_JERK (Siemens MD32431), MAX_PATH_JERK, maxPathJerk (Heidenhain)",
        sentence: |f| match (f.number(of::JERK), f.costs(), f.get(of::AT)) {
            (jerk, costs, Some(_)) => format!(
                "Rapids start and stop at rest with a jerk of {jerk} mm/s³, so short ones take less time{costs}."
            ),
            (jerk, costs, None) => {
                format!("Jerk is limited to {jerk} mm/s³, so ramps grow with the change of speed{costs}.")
            }
        },
    }
    /// Limit of the acceleration towards the centre on arcs.
    CENTRIPETAL_ACCELERATION_LIMIT {
        id: "centripetal_acceleration_limit", nature: Nature::Limit, offered: limits::centripetal_acceleration,
        vendors: "Nos. 1730–1732 (Fanuc), MD20602 (Siemens)",
        sentence: |f| format!(
            "The machine takes curves at a centripetal acceleration of {} mm/s² at most{}.", f.number(of::ACCELERATION), f.costs()
        ),
    }
    /// Another time constant of the filters.
    FILTER_TIME_CONSTANT {
        id: "filter_time_constant", offered: filters::time_constants,
        vendors: "MD32410 (Siemens), filter frequency (Heidenhain)",
        sentence: |f| format!("The filters' time constant is {} s{}.", f.number(of::TIME_CONSTANT), f.costs()),
    }
    /// A larger or smaller number of filters.
    FILTER_ORDER {
        id: "filter_order", rarity: OF_SOFTWARE, offered: filters::orders,
        vendors: "AX_JERK_MODE (Siemens MD32402), triangle or HSC filter (Heidenhain)",
        sentence: |f| format!(
            "The control has {} filters in series, another number than the machine file{}.", f.number(of::FILTERS), f.costs()
        ),
    }
    /// Unequal filters, one longer than the others.
    UNEQUAL_FILTERS {
        id: "unequal_filters", offered: filters::unequal,
        vendors: "MD32410 and MD32411 (Siemens)",
        sentence: |f| format!("The filters have unequal time constants, {} s{}.", f.list(of::TIME_CONSTANTS), f.costs()),
    }
    /// Another tolerance of corners or arcs.
    CORNER_TOLERANCE {
        id: "corner_tolerance", offered: corners::tolerances,
        vendors: "cycle 32 T (Heidenhain), CYCLE832 or CTOL (Siemens), G64 P (LinuxCNC), G187 E (Haas)",
        sentence: |f| match f.word(of::AT) {
            "arcs" => format!("The contour tolerance of corners does not slow arcs{}.", f.costs()),
            corners::CORNERS_AND_LINES => format!(
                "The control blends corners and merges lines within {} mm{}.", f.number(of::CONTOUR_TOLERANCE), f.costs()
            ),
            _ => format!("The control blends corners within {} mm{}.", f.number(of::CONTOUR_TOLERANCE), f.costs()),
        },
    }
    /// Another law that limits the feedrate at corners.
    JUNCTION_RULE {
        id: "junction_rule", rarity: OF_SOFTWARE, offered: corners::junctions,
        vendors: "$11 (grbl), square_corner_velocity (Klipper), M205 (Marlin), ARC_BLEND_ENABLE (LinuxCNC), No. 1783 (Fanuc)",
        sentence: |f| match f.get(of::VALUE) {
            Some(_) => format!(
                "Corners follow another rule, {} of {}{}.",
                f.word(of::RULE).replace('_', " "), f.number(of::VALUE), f.costs()
            ),
            None => format!("The control blends corners by parabolas and not by circles{}.", f.costs()),
        },
    }
    /// Full stops at corners.
    EXACT_STOP {
        id: "exact_stop", offered: stops::exact_stops,
        vendors: "G9, G61, G60",
        sentence: |f| match f.get(of::ANGLE) {
            Some(of::Reported::Number(0.0)) => format!("The machine stops at the end of every block{}.", f.costs()),
            Some(_) => format!("The machine stops at every corner sharper than {}°{}.", f.number(of::ANGLE), f.costs()),
            None => format!("The machine stops exactly {}{}.", f.at_lines(), f.costs()),
        },
    }
    /// Wait at full stops until the axes are in position.
    IN_POSITION_WAIT {
        id: "in_position_wait", offered: stops::in_position_waits,
        vendors: "in-position width (Fanuc No. 1826), STOP_LIMIT_FINE (Siemens MD36010), timePosOK (Heidenhain)",
        sentence: |f| format!(
            "At full stops the machine waits {} s until its axes are in position{}.", f.number(of::SECONDS), f.costs()
        ),
    }
    /// Least time in which the control runs a block.
    BLOCK_PROCESSING_TIME {
        id: "block_processing_time", rarity: OF_SOFTWARE, offered: supply::block_times,
        vendors: "block cycle time",
        sentence: |f| format!("The control needs {} s for every block{}.", f.number(of::SECONDS), f.costs()),
    }
    /// Number of blocks that the control sees ahead.
    LOOK_AHEAD {
        id: "look_ahead", rarity: OF_SOFTWARE, offered: supply::look_aheads,
        vendors: "look-ahead buffer, G103 P (Haas), BLOCK_BUFFER_SIZE (grbl)",
        sentence: |f| format!("The control looks {} blocks ahead{}.", f.number(of::BLOCKS), f.costs()),
    }
    /// Merging of short blocks or rounding of corners by the control.
    PATH_SMOOTHING {
        id: "path_smoothing", rarity: OF_SOFTWARE, offered: corners::smoothings,
        vendors: "COMPCAD (Siemens), G5.1 Q1 (Fanuc), G64 Q (LinuxCNC)",
        sentence: |f| {
            let does = if f.get(of::AT).is_some() { "rounds corners" } else { "merges short blocks" };
            format!("The control {does} within {} mm{}.", f.number(of::TOLERANCE), f.costs())
        },
    }
    /// Another rate of feed moves, set by the operator.
    FEED_OVERRIDE {
        id: "feed_override", nature: Nature::Switch, origin: Origin::Operator, offered: overrides::feed,
        vendors: "feed override switch",
        sentence: |f| {
            let line = |quantity| f.value(quantity).filter(|line| 0.0 < *line);
            let place = match (line(of::FROM_LINE), line(of::TO_LINE)) {
                (Some(first), Some(last)) => format!("From line {first} to line {last} the"),
                (Some(first), None) => format!("From line {first} on the"),
                (None, Some(last)) => format!("Up to line {last} the"),
                (None, None) => "The".to_string(),
            };
            format!("{place} machine ran at {} % of the programmed feed: feed override{}.", percent(f), f.costs())
        },
    }
    /// Another rate of rapid moves, set by the operator.
    RAPID_OVERRIDE {
        id: "rapid_override", nature: Nature::Switch, origin: Origin::Operator, offered: overrides::rapid,
        vendors: "rapid override switch",
        sentence: |f| format!("Rapid moves ran at {} % of the rapid feed: rapid override{}.", percent(f), f.costs()),
    }
    /// Feed that follows the load.
    ADAPTIVE_FEED {
        id: "adaptive_feed", nature: Nature::Other,
        vendors: "adaptive feed control",
        unprovoked: Some("it follows the load, and a probe runs in air: repeat the cut in air instead"),
        sentence: |f| format!("The feed was adapted smoothly {}{}.", f.at_lines(), f.costs()),
    }
    /// Feed hold by the operator.
    FEED_HOLD {
        id: "feed_hold", nature: Nature::Halt, origin: Origin::Operator,
        vendors: "feed hold",
        unprovoked: Some("an operator causes it: record the same program again instead"),
        sentence: |f| format!(
            "The operator held the feed in line {} for {} s{}.", f.number(of::LINE), f.number(of::SECONDS), f.costs()
        ),
    }
    /// Longer time of a function, or standstill before a line.
    UNMODELLED_WAIT {
        id: "unmodelled_wait", nature: Nature::Halt, offered: stops::waits,
        sentence: |f| {
            let what = match (f.word(of::CODE), f.word(of::OR_CODE)) {
                ("", _) => f.at_lines(),
                (code, "") => format!("at {code}"),
                (code, others) => format!("at {code} or {others}, between which nothing moves"),
            };
            let seconds = f.value(of::SECONDS).unwrap_or(f64::NAN);
            let (size, more) = (three_digits(seconds.abs()), if seconds < 0.0 { "less" } else { "more" });
            format!("The machine waits {size} s {more} than the machine file says {what}.")
        },
    }
    /// Wait of the feed at S words until the spindle has its speed.
    SPINDLE_WAIT {
        id: "spindle_wait", offered: stops::spindle_waits,
        vendors: "SPIND_ON_SPEED_AT_IO_START (Siemens MD35500), No. 3708 bit 0 (Fanuc)",
        unprovoked: Some("a probe runs without the spindle: record a program with S words among its feed moves instead"),
        sentence: |f| match f.get(of::RAMP) {
            Some(_) => format!(
                "First feed moves wait until the spindle has its speed, for which it needs {} s for each 1000 rpm{}.",
                f.number(of::RAMP), f.costs()
            ),
            None => format!(
                "The feed waits {} s at {} until the spindle has its speed{}.",
                f.number(of::SECONDS), f.word(of::AT), f.costs()
            ),
        },
    }
    /// Lag of the axes behind their command.
    SERVO_LAG {
        id: "servo_lag", nature: Nature::Drive, offered: drives::servo_lag,
        vendors: "POSCTRL_GAIN (Siemens MD32200), No. 1825 (Fanuc), MP1810 (Heidenhain)",
        sentence: |f| match f.word(of::AXIS) {
            "" => format!("The axes follow with a lag of {} s.", f.number(of::TIME_CONSTANT)),
            axis => format!("Axis {axis} follows with a lag of {} s.", f.number(of::TIME_CONSTANT)),
        },
    }
    /// Backlash of an axis.
    BACKLASH {
        id: "backlash", nature: Nature::Drive, offered: drives::backlash,
        vendors: "BACKLASH (Siemens MD32450), No. 1851 (Fanuc), MP710 (Heidenhain)",
        sentence: |f| {
            let (axis, width) = (f.word(of::AXIS), f.number(of::WIDTH));
            match f.word(of::RECORDED_AT) {
                "" => format!("Axis {axis} has {width} mm of backlash."),
                _ => format!("The recorded positions of {axis} contain a compensation of {width} mm of backlash."),
            }
        },
    }
    /// Vibration of the structure.
    STRUCTURAL_VIBRATION {
        id: "structural_vibration", nature: Nature::Drive, offered: drives::vibration,
        sentence: |f| format!(
            "The structure vibrates in {} at {} Hz with a damping of {}.",
            f.word(of::AXIS), f.number(of::FREQUENCY), f.number(of::DAMPING)
        ),
    }
    /// Fast or slow clock of the recorder.
    RECORDER_CLOCK {
        id: "recorder_clock", rarity: OF_CLOCKS, nature: Nature::Switch, origin: Origin::Recorder, offered: overrides::recorder_clock,
        sentence: |f| {
            let ratio = f.value(of::RATIO).unwrap_or(f64::NAN);
            let way = if ratio < 1.0 { "slow" } else { "fast" };
            format!("The recorder's clock is {} % {way}.", three_digits(100.0 * (ratio - 1.0).abs()))
        },
    }
    /// Recording of another program.
    WRONG_PROGRAM {
        id: "wrong_program", nature: Nature::Other, origin: Origin::Recorder,
        unprovoked: Some("no program shows it: check which program was recorded"),
    }
}
