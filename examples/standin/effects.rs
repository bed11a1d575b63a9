//! What can be concealed, and how strongly.
//!
//! The strength k is a multiple of a rough detection limit, the same for the whole benchmark and fixed
//! before it is run; each effect's size follows from k by the rule beside its name below. Limits are set
//! relative to what the clean motion of the very program reaches, so that they act.

use serde_json::{Value, json};

use crate::path::Shape;
use crate::physics::Physics;
use crate::random::Random;
use crate::reader::Step;

/// The library: every effect that a diagnosis can name.
pub const LIBRARY: [&str; 23] = [
    "axis_acceleration_limit",
    "path_acceleration_limit",
    "axis_velocity_limit",
    "jerk_limit",
    "centripetal_acceleration_limit",
    "filter_time_constant",
    "filter_order",
    "unequal_filters",
    "corner_tolerance",
    "junction_rule",
    "exact_stop",
    "in_position_wait",
    "block_processing_time",
    "look_ahead",
    "path_smoothing",
    "feed_override",
    "rapid_override",
    "feed_hold",
    "unmodelled_wait",
    "servo_lag",
    "backlash",
    "structural_vibration",
    "recorder_clock",
];

/// Effects outside the library.
pub const OUTSIDE: [&str; 4] =
    ["feed_modulation", "slow_zone", "position_dependent_limit", "quadrant_glitch"];

/// The program recorded is another one than the program given.
pub const WRONG_PROGRAM: &str = "wrong_program";

/// Effects that do not act on lines of their own.
pub fn acts_everywhere(id: &str) -> bool {
    let everywhere = [
        "filter_",
        "unequal_",
        "servo_",
        "backlash",
        "structural",
        "recorder",
        "feed_mod",
        "quadrant",
        "wrong",
    ];
    everywhere.iter().any(|start| id.starts_with(start))
}

/// Effects that a machine has on every program; the others are an operator's, a recorder's or one line's.
pub fn belongs_to_machine(id: &str) -> bool {
    let of_one_run =
        ["feed_override", "rapid_override", "feed_hold", "unmodelled_wait", "recorder_clock", WRONG_PROGRAM];
    !of_one_run.contains(&id)
}

const AXES: [&str; 3] = ["X", "Y", "Z"];

/// Effects without a size of their own.
pub const ALL_OR_NOTHING: [&str; 2] = ["filter_order", WRONG_PROGRAM];

/// Conceals one effect of strength k in `physics`, which held the base; gives its parameters, or nothing
/// where the program has nothing for it to act on.
pub fn conceal(
    id: &str,
    k: f64,
    steps: &[Step],
    physics: &mut Physics,
    random: &mut Random,
) -> Option<Value> {
    let cuts: Vec<(u32, &Shape, f64)> = steps
        .iter()
        .filter_map(|step| match step {
            Step::Move { line, shape, rapid: false, feed } => Some((*line, shape, *feed)),
            _ => None,
        })
        .collect();
    let rapids = steps.iter().filter(|step| matches!(step, Step::Move { rapid: true, .. })).count();
    let fastest = cuts.iter().map(|c| c.2).fold(0.0, f64::max);
    let delay: f64 = physics.boxes.iter().sum();
    let n = physics.boxes.len();
    let axis = random.below(2);
    let mean_of_short = cuts
        .iter()
        .map(|c| c.1.length() / c.2)
        .filter(|t| *t < 0.05)
        .fold((0.0, 0), |(s, n), t| (s + t, n + 1));
    Some(match id {
        // The ramp to full feed takes 0.2 k of the filter delay.
        "axis_acceleration_limit" => {
            physics.axis_acceleration[axis] = fastest / (0.2 * k * delay);
            json!({"axis": AXES[axis], "a_mm_s2": physics.axis_acceleration[axis]})
        }
        "path_acceleration_limit" => {
            physics.path_acceleration = fastest / (0.2 * k * delay);
            json!({"a_mm_s2": physics.path_acceleration})
        }
        // The fastest cut along the axis loses a share of 0.05 k / (1 + 0.05 k).
        "axis_velocity_limit" => {
            let reached =
                cuts.iter().filter(|c| 2.0 < c.1.length()).map(|c| c.2 * c.1.share(axis)).fold(0.0, f64::max);
            let limit = reached / (1.0 + 0.05 * k);
            physics.axis_velocity[axis] = limit;
            (1.0 < reached).then_some(json!({"axis": AXES[axis], "v_mm_min": 60.0 * limit}))?
        }
        // The ramp to full feed takes 0.2 k of the filter delay: 2 √(F/J).
        "jerk_limit" => {
            physics.jerk = 4.0 * fastest / (0.2 * k * delay).powi(2);
            json!({"j_mm_s3": physics.jerk})
        }
        "centripetal_acceleration_limit" => {
            let tolerated = 24.0 * physics.tolerance / physics.boxes.iter().map(|t| t * t).sum::<f64>();
            let reached =
                cuts.iter().map(|c| (c.2 * c.2 * c.1.curvature()).min(tolerated)).fold(0.0, f64::max);
            physics.centripetal = reached / (1.0 + 0.05 * k).powi(2);
            (0.0 < reached).then_some(json!({"a_mm_s2": physics.centripetal}))?
        }
        // 2 % a unit.
        "filter_time_constant" => {
            let ratio = if random.chance(0.5) { 1.0 + 0.02 * k } else { 1.0 / (1.0 + 0.02 * k) };
            physics.boxes.iter_mut().for_each(|t| *t *= ratio);
            json!({"time_constant_s": physics.boxes[0]})
        }
        "filter_order" => {
            let orders: Vec<usize> = [2, 3, 4].into_iter().filter(|m| *m != n).collect();
            physics.boxes = vec![physics.boxes[0]; random.pick(&orders)];
            json!({"filters": physics.boxes.len()})
        }
        "unequal_filters" => {
            let spread = (0.08 * k).min(0.8);
            let last = n - 1;
            physics.boxes[0] *= 1.0 + spread;
            physics.boxes[last] *= 1.0 - spread;
            json!({"time_constants_s": physics.boxes})
        }
        "corner_tolerance" => {
            physics.tolerance *= (random.sign() * 0.12 * k).exp();
            json!({"contour_tolerance_mm": physics.tolerance})
        }
        "junction_rule" => {
            physics.axis_step = 20.0 / k;
            json!({"rule": "axis_velocity_step", "value": 60.0 * physics.axis_step})
        }
        // The sharper half of the corners at k = 1, nearly all at 10.
        "exact_stop" => {
            let angle = (90.0 / (1.0 + 0.3 * k)).max(22.0);
            physics.exact_stop = angle.to_radians();
            json!({"angle_deg": angle})
        }
        "in_position_wait" if 0 < rapids => {
            physics.in_position = 0.004 * k;
            json!({"seconds": physics.in_position, "at": "rapid ends"})
        }
        // A unit is a tenth more than the mean time of the short blocks.
        "block_processing_time" if 50 < mean_of_short.1 => {
            physics.block_time = mean_of_short.0 / f64::from(mean_of_short.1) * (0.9 + 0.1 * k);
            json!({"seconds": physics.block_time})
        }
        // Full feed needs the blocks of half the filter delay in sight; 10 % fewer a unit.
        "look_ahead" if 50 < mean_of_short.1 => {
            let needed = delay / 2.0 / (mean_of_short.0 / f64::from(mean_of_short.1));
            physics.look_ahead = (needed / (1.0 + 0.1 * k)).round().max(1.0);
            (3.0 <= needed).then_some(json!({"blocks": physics.look_ahead}))?
        }
        "path_smoothing" if 50 < mean_of_short.1 => {
            physics.smoothing = physics.tolerance * 0.2 * k;
            json!({"tolerance_mm": physics.smoothing})
        }
        "feed_override" => {
            let ratio = 1.0 + random.sign() * 0.01 * k;
            let lines: Vec<u32> = cuts.iter().map(|c| c.0).collect();
            let from = if random.chance(0.4) { 1 } else { lines[random.below(lines.len() * 3 / 4)] };
            let to = lines[lines.len() - 1];
            physics.feed_override = (ratio, from, to);
            json!({"ratio": ratio, "from_line": from, "to_line": to})
        }
        "rapid_override" if 0 < rapids => {
            physics.rapid_override = 1.0 / (1.0 + 0.1 * k);
            json!({"ratio": physics.rapid_override})
        }
        "feed_hold" => {
            let line = cuts[random.below(cuts.len())].0;
            physics.hold = Some((line, 0.1 * k));
            json!({"line": line, "seconds": 0.1 * k})
        }
        "unmodelled_wait" => {
            let words = steps.iter().filter_map(|step| match step {
                Step::Wait { line, .. } => Some(*line),
                Step::Move { .. } => None,
            });
            // The end of the program is no place for a wait: nothing follows that shows it.
            let words: Vec<u32> = words.collect();
            let line = *words.get(random.below(words.len() - 1)).filter(|_| 1 < words.len())?;
            physics.wait = Some((line, 0.1 * k));
            json!({"line": line, "seconds": 0.1 * k})
        }
        "servo_lag" => {
            physics.drive.lag = 0.002 * k;
            json!({"time_constant_s": physics.drive.lag})
        }
        "backlash" => {
            physics.drive.backlash = Some((axis, 0.003 * k));
            json!({"axis": AXES[axis], "width_mm": 0.003 * k})
        }
        // The deflection under an acceleration a is a/ω², so it grows with k where ω falls with √k.
        "structural_vibration" => {
            let (frequency, damping) = (25.0 / k.sqrt(), random.log_uniform(0.01, 0.08));
            physics.drive.mode = Some((axis, frequency, damping));
            json!({"axis": AXES[axis], "frequency_hz": frequency, "damping": damping})
        }
        "recorder_clock" => {
            physics.clock = 1.0 + random.sign() * 0.002 * k;
            json!({"ratio": physics.clock})
        }
        "feed_modulation" => {
            let (depth, frequency) = ((0.03 * k).min(0.6), random.uniform(0.5, 2.0));
            physics.modulation = Some((depth, frequency));
            json!({"depth": depth, "hz": frequency})
        }
        "slow_zone" | "position_dependent_limit" => {
            let ends: Vec<f64> = cuts.iter().map(|c| c.1.point(c.1.length())[0]).collect();
            let far = ends.iter().copied().fold(0.0, f64::max);
            if id == "slow_zone" {
                let from = random.uniform(0.1, 0.7) * far;
                physics.zone = Some((from, from + 0.2 * far, 1.0 / (1.0 + 0.05 * k)));
                json!({"from_mm": from, "to_mm": from + 0.2 * far, "ratio": 1.0 / (1.0 + 0.05 * k)})
            } else {
                let slope = fastest * (0.05 * k).min(0.8) / far;
                physics.falling = Some((fastest, slope));
                json!({"at_zero_mm_s": fastest, "per_mm_1_s": slope})
            }
        }
        "quadrant_glitch" => {
            physics.drive.friction = Some((0.003 * k, 0.03));
            json!({"width_mm": 0.003 * k, "decay_s": 0.03})
        }
        _ => return None,
    })
}
