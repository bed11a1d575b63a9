//! What may be changed on the controller for a recording, one thing at a time, and how strongly.
//!
//! Strengths are uniform in the logarithm, from what no recording shows to what nobody overlooks.

use serde_json::{Value, json};

use crate::machine::{AXES, Family, Limits};
use crate::random::Random;
use crate::trace::Scale;
use crate::words::{Manner, PathMode, rounded_to};

/// The run to be changed.
pub struct Case<'a> {
    pub limits: &'a Limits,
    pub manner: &'a Manner,
    /// What the clean run takes, s.
    pub seconds: f64,
    /// The highest speed along the path in it, mm/s.
    pub fastest: f64,
}

/// A change as it was drawn.
pub struct Drawn {
    /// How the recorder is told.
    pub options: Vec<String>,
    /// What is concealed.
    pub value: Value,
    pub scale: Scale,
}

impl Drawn {
    fn new(option: &str, setting: String, value: Value) -> Drawn {
        Drawn { options: vec![option.into(), setting], value, scale: Scale::Command }
    }
}

/// A kind of change.
pub struct Kind {
    pub name: &'static str,
    /// Whether it moves the recorded path beside the command and leaves the time.
    pub bends_path: bool,
    /// The controls on which it can be made.
    pub on: &'static [Family],
    /// Whether a program has what it changes.
    pub applies: fn(&Manner) -> bool,
    pub draw: fn(&mut Random, &Case) -> Drawn,
}

const ANY: fn(&Manner) -> bool = |_| true;
const BLENDS: fn(&Manner) -> bool = |manner| manner.path != PathMode::Exact;

const ALL: &[Family] = &[
    Family::LinuxCnc,
    Family::Grbl,
    Family::Klipper,
    Family::Marlin,
    Family::MarlinDeviation,
    Family::TinyG,
];
/// Controls whose operator acts while a block runs.
const WITHIN_BLOCKS: &[Family] = &[Family::LinuxCnc, Family::Grbl];
const WITH_AXIS_VELOCITY: &[Family] =
    &[Family::LinuxCnc, Family::Grbl, Family::Marlin, Family::MarlinDeviation, Family::TinyG];
const WITH_AXIS_ACCELERATION: &[Family] =
    &[Family::LinuxCnc, Family::Grbl, Family::Marlin, Family::MarlinDeviation];
const BUFFERED: &[Family] = &[Family::Grbl, Family::Marlin, Family::MarlinDeviation, Family::TinyG];
const LINUXCNC: &[Family] = &[Family::LinuxCnc];
const WITH_DEVIATION: &[Family] = &[Family::Grbl, Family::MarlinDeviation];
const KLIPPER: &[Family] = &[Family::Klipper];

const fn kind(
    name: &'static str,
    on: &'static [Family],
    applies: fn(&Manner) -> bool,
    draw: fn(&mut Random, &Case) -> Drawn,
) -> Kind {
    Kind { name, bends_path: false, on, applies, draw }
}

/// Those of LinuxCNC come first, in the order in which its seeds draw them.
pub static KINDS: [Kind; 24] = [
    kind("axis_acceleration", WITH_AXIS_ACCELERATION, ANY, axis_acceleration),
    kind("axis_velocity", WITH_AXIS_VELOCITY, ANY, axis_velocity),
    kind("feed_override", ALL, ANY, feed_override),
    kind("feed_override_interval", ALL, ANY, feed_override_interval),
    kind("rapid_override", WITHIN_BLOCKS, ANY, rapid_override),
    kind("feed_hold", WITHIN_BLOCKS, ANY, |random, case| halt("--hold-at", random, case)),
    kind("operator_pause", LINUXCNC, ANY, |random, case| halt("--pause-at", random, case)),
    kind("blend_tolerance", LINUXCNC, BLENDS, blend_tolerance),
    kind("exact_path", LINUXCNC, BLENDS, |_, _| Drawn::new("--path", "G61".into(), json!({ "mode": "G61" }))),
    kind("exact_stop", LINUXCNC, BLENDS, |_, _| {
        Drawn::new("--path", "G61.1".into(), json!({ "mode": "G61.1" }))
    }),
    kind("spindle_delay", LINUXCNC, |manner| manner.spindle, spindle_delay),
    kind("spindle_ramp", LINUXCNC, |manner| manner.spindle, spindle_ramp),
    kind("tool_change", LINUXCNC, |manner| manner.tool_changes, tool_change),
    kind("arc_blends_off", LINUXCNC, BLENDS, |_, _| {
        Drawn::new("--traj", "ARC_BLEND_ENABLE=0".into(), json!({ "arc_blend_enable": 0 }))
    }),
    kind("velocity_slider", LINUXCNC, ANY, velocity_slider),
    Kind { name: "servo_lag", bends_path: true, on: LINUXCNC, applies: ANY, draw: servo_lag },
    Kind { name: "backlash", bends_path: true, on: LINUXCNC, applies: ANY, draw: backlash },
    kind("junction_deviation", WITH_DEVIATION, ANY, junction_deviation),
    kind("look_ahead", BUFFERED, ANY, look_ahead),
    kind("axis_acceleration", KLIPPER, ANY, acceleration_of_z),
    kind("path_acceleration", KLIPPER, ANY, path_acceleration),
    kind("square_corner_velocity", KLIPPER, ANY, square_corner_velocity),
    kind("velocity_slider", KLIPPER, ANY, velocity_slider),
    kind("pause_before_line", KLIPPER, ANY, |random, case| halt("--hold-at", random, case)),
];

/// A limit that is lower than `own` by 3 to 70 %, mm/s².
fn lower_acceleration(random: &mut Random, own: f64) -> f64 {
    rounded_to(own * (1.0 - random.log_uniform(0.03, 0.7)), 1)
}

/// The kind of this name.
pub fn named(name: &str) -> Option<&'static Kind> {
    KINDS.iter().find(|kind| kind.name == name)
}

fn axis_acceleration(random: &mut Random, case: &Case) -> Drawn {
    let axis = random.below(3);
    let a = lower_acceleration(random, case.limits.acceleration[axis]);
    let value = json!({ "axis": AXES[axis].to_uppercase(), "a_mm_s2": a });
    Drawn::new(&format!("--acc-{}", AXES[axis]), a.to_string(), value)
}

fn acceleration_of_z(random: &mut Random, case: &Case) -> Drawn {
    let a = lower_acceleration(random, case.limits.acceleration[2]);
    Drawn::new("--acc-z", a.to_string(), json!({ "axis": "Z", "a_mm_s2": a }))
}

/// Klipper's `max_accel`. Corners keep their velocities.
fn path_acceleration(random: &mut Random, case: &Case) -> Drawn {
    let a = lower_acceleration(random, case.limits.acceleration[0]);
    Drawn::new("--acc-x", a.to_string(), json!({ "a_mm_s2": a }))
}

/// A factor to either side.
fn factor(random: &mut Random) -> f64 {
    let factor = random.log_uniform(1.2, 10.0);
    if random.chance(0.5) { factor } else { 1.0 / factor }
}

fn junction_deviation(random: &mut Random, case: &Case) -> Drawn {
    let mm = rounded_to(case.limits.junction_deviation() * factor(random), 4);
    Drawn::new("--junction-deviation", mm.to_string(), json!({ "junction_deviation_mm": mm }))
}

fn square_corner_velocity(random: &mut Random, case: &Case) -> Drawn {
    let v = rounded_to(case.limits.square_corner_velocity() * factor(random), 2);
    Drawn::new("--square-corner-velocity", v.to_string(), json!({ "square_corner_velocity_mm_s": v }))
}

/// Blocks that the buffer holds.
fn look_ahead(random: &mut Random, _: &Case) -> Drawn {
    let blocks = random.log_uniform(2.0, 12.0).round();
    Drawn::new("--look-ahead", blocks.to_string(), json!({ "blocks": blocks }))
}

fn axis_velocity(random: &mut Random, case: &Case) -> Drawn {
    let axis = random.below(3);
    let v = rounded_to(case.limits.velocity[axis] * (1.0 - random.log_uniform(0.05, 0.9)), 2);
    let value = json!({ "axis": AXES[axis].to_uppercase(), "v_mm_min": 60.0 * v });
    Drawn::new(&format!("--vel-{}", AXES[axis]), v.to_string(), value)
}

/// Whole percents; one in five is above the programmed feed.
fn override_ratio(random: &mut Random) -> f64 {
    let part = random.log_uniform(0.01, 0.6);
    rounded_to(if random.chance(0.2) { 1.0 + part.min(0.5) } else { 1.0 - part }, 2)
}

fn feed_override(random: &mut Random, _: &Case) -> Drawn {
    let ratio = override_ratio(random);
    Drawn::new("--override", ratio.to_string(), json!({ "ratio": ratio }))
}

fn feed_override_interval(random: &mut Random, case: &Case) -> Drawn {
    let ratio = override_ratio(random);
    let lasts = case.seconds * random.log_uniform(0.05, 0.6);
    let from = random.uniform(0.05 * case.seconds, 0.95 * case.seconds - lasts);
    let setting = format!("{from:.3}:{ratio},{:.3}:1", from + lasts);
    Drawn::new("--override-at", setting, json!({ "ratio": ratio }))
}

fn rapid_override(random: &mut Random, _: &Case) -> Drawn {
    let ratio = rounded_to(1.0 - random.log_uniform(0.05, 0.8), 2);
    Drawn::new("--rapid-override", ratio.to_string(), json!({ "ratio": ratio }))
}

fn halt(option: &str, random: &mut Random, case: &Case) -> Drawn {
    let (at, lasts) = (case.seconds * random.uniform(0.05, 0.9), random.log_uniform(0.03, 5.0));
    let value = json!({ "seconds": rounded_to(lasts, 3), "at_s": rounded_to(at, 3) });
    Drawn::new(option, format!("{at:.3}:{lasts:.3}"), value)
}

/// Another tolerance than the program's, or one where it has none.
fn blend_tolerance(random: &mut Random, case: &Case) -> Drawn {
    let mm = match case.manner.path {
        PathMode::Within(p) | PathMode::Merging(p, _) => {
            let factor = random.log_uniform(1.2, 20.0);
            if random.chance(0.5) { (p * factor).min(0.5) } else { (p / factor).max(0.001) }
        }
        _ => random.log_uniform(0.002, 0.2),
    };
    let mm = rounded_to(mm, 4);
    // The recorder writes the words in the program's place and units, where the program has such words.
    let inch = case.manner.inch && case.manner.path != PathMode::Unsaid;
    let words = if inch { format!("G64 P{:.6}", mm / 25.4) } else { format!("G64 P{mm}") };
    Drawn::new("--path", words, json!({ "contour_tolerance_mm": mm }))
}

fn spindle_delay(random: &mut Random, _: &Case) -> Drawn {
    let seconds = rounded_to(random.log_uniform(0.05, 5.0), 3);
    Drawn::new("--at-speed-delay", seconds.to_string(), json!({ "seconds": seconds, "at": "start" }))
}

fn spindle_ramp(random: &mut Random, _: &Case) -> Drawn {
    let ramp = random.log_uniform(2e3, 1e5).round();
    Drawn::new("--spindle-ramp", ramp.to_string(), json!({ "rpm_per_s": ramp, "at": "each speed" }))
}

fn tool_change(random: &mut Random, _: &Case) -> Drawn {
    let seconds = rounded_to(random.log_uniform(0.05, 8.0), 3);
    Drawn::new("--tool-change-s", seconds.to_string(), json!({ "seconds": seconds }))
}

fn velocity_slider(random: &mut Random, case: &Case) -> Drawn {
    let v = rounded_to(case.fastest * (1.0 - random.log_uniform(0.03, 0.9)), 2);
    Drawn::new("--max-vel-slider", v.to_string(), json!({ "v_mm_min": 60.0 * v }))
}

/// All axes alike, or one alone.
fn servo_lag(random: &mut Random, _: &Case) -> Drawn {
    let seconds = rounded_to(random.log_uniform(0.0005, 0.05), 5);
    let alone = random.chance(0.25).then(|| random.below(3));
    let axes = (0..3).filter(|axis| alone.is_none_or(|one| one == *axis));
    let setting: Vec<String> = axes.map(|axis| format!("{}:{:.2}", AXES[axis], 1e3 * seconds)).collect();
    let axis = alone.map(|axis| AXES[axis].to_uppercase());
    let value = json!({ "time_constant_s": seconds, "only_axis": axis });
    Drawn { scale: Scale::Motor, ..Drawn::new("--servo-lag-ms", setting.join(","), value) }
}

/// Recorded at the motor of an axis with compensation, or at a table without it.
fn backlash(random: &mut Random, _: &Case) -> Drawn {
    let (axis, width) = (random.below(3), rounded_to(random.log_uniform(0.001, 0.1), 4));
    let scale = random.pick(&[Scale::Motor, Scale::Table]);
    let value =
        json!({ "axis": AXES[axis].to_uppercase(), "width_mm": width, "recorded_at": format!("{scale:?}") });
    Drawn { scale, ..Drawn::new("--backlash", format!("{}:{width}", AXES[axis]), value) }
}
