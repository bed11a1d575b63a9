//! What causes are called: a sentence for people, and the vendors' names of the setting.
//!
//! Names of settings are from the vendors' manuals: Siemens machine data (MD), Heidenhain machine
//! parameters (MP) and configuration names, Fanuc parameter numbers, grbl and LinuxCNC settings.

use serde_json::{Map, Value};

/// A sentence from the parameters of a cause, its lines, and the seconds it explains.
type Sentence = fn(&Map<String, Value>, &[(u32, u32)], f64) -> String;

/// What is known of a cause.
pub struct Known {
    /// The sentence for people.
    pub sentence: Sentence,
    /// What vendors call the setting.
    pub vendors: &'static str,
}

/// What is known of the cause with this id.
pub fn known(id: &str) -> Known {
    let of = |sentence: Sentence, vendors| Known { sentence, vendors };
    match id {
        "axis_acceleration_limit" => of(
            |p, _, s| {
                let (a, costs) = (number(p, "a_mm_s2"), costs(s));
                match p.contains_key("planner") {
                    true => format!(
                        "Ramps grow with the speed step: the planner is limited in acceleration, {a} mm/s² on each axis, \
                         and does not filter{costs}."
                    ),
                    false => format!("Axis {} accelerates at {a} mm/s² at most{costs}.", word(p, "axis")),
                }
            },
            "MAX_AX_ACCEL (Siemens MD32300), maxAcceleration or MP1060 (Heidenhain), $120–$122 (grbl), MAX_ACCELERATION (LinuxCNC)",
        ),
        "path_acceleration_limit" => of(
            |p, _, s| {
                format!(
                    "Ramps grow with the speed step: the machine accelerates along the path at {} mm/s² at most{}.",
                    number(p, "a_mm_s2"),
                    costs(s)
                )
            },
            "MAX_PATH_ACCEL (Siemens), MP1061 (Heidenhain), max_accel (Klipper)",
        ),
        "axis_velocity_limit" => of(
            |p, _, s| {
                format!(
                    "Axis {} moves at {} mm/min at most{}.",
                    word(p, "axis"),
                    number(p, "v_mm_min"),
                    costs(s)
                )
            },
            "MAX_AX_VELO (Siemens), No. 1422 (Fanuc), MP1010 (Heidenhain), $110–$112 (grbl)",
        ),
        "jerk_limit" => of(
            |p, _, s| match p.get("at") {
                Some(_) => format!(
                    "Rapids run from stand to stand with a jerk of {} mm/s³, so that short ones take less{}.",
                    number(p, "j_mm_s3"),
                    costs(s)
                ),
                None => format!(
                    "Jerk is limited to {} mm/s³, so that ramps grow with the speed step{}.",
                    number(p, "j_mm_s3"),
                    costs(s)
                ),
            },
            "MAX_AX_JERK (Siemens MD32431), MAX_PATH_JERK, maxPathJerk (Heidenhain)",
        ),
        "centripetal_acceleration_limit" => of(
            |p, _, s| {
                format!(
                    "Curves are taken at a centripetal acceleration of {} mm/s² at most{}.",
                    number(p, "a_mm_s2"),
                    costs(s)
                )
            },
            "Nos. 1730–1732 (Fanuc), MD20602 (Siemens)",
        ),
        "filter_time_constant" => of(
            |p, _, s| {
                format!("The filters' time constant is {} s{}.", number(p, "time_constant_s"), costs(s))
            },
            "MD32410 (Siemens), filter frequency (Heidenhain)",
        ),
        "filter_order" => of(
            |p, _, s| {
                format!(
                    "The control filters {} times, not as often as the machine file says{}.",
                    number(p, "filters"),
                    costs(s)
                )
            },
            "AX_JERK_MODE (Siemens MD32402), triangle or HSC filter (Heidenhain)",
        ),
        "unequal_filters" => of(
            |p, _, s| {
                format!(
                    "The filters have unequal time constants, {} s{}.",
                    list(p, "time_constants_s"),
                    costs(s)
                )
            },
            "MD32410 and MD32411 (Siemens)",
        ),
        "corner_tolerance" => of(
            |p, _, s| match word(p, "at").as_str() {
                "arcs" => format!("Arcs are not slowed by the contour tolerance of corners{}.", costs(s)),
                _ => format!(
                    "Corners are blended within {} mm{}.",
                    number(p, "contour_tolerance_mm"),
                    costs(s)
                ),
            },
            "cycle 32 T (Heidenhain), CYCLE832 or CTOL (Siemens), G64 P (LinuxCNC), G187 E (Haas)",
        ),
        "junction_rule" => of(
            |p, _, s| {
                format!(
                    "Corners follow another rule, {} of {}{}.",
                    word(p, "rule").replace('_', " "),
                    number(p, "value"),
                    costs(s)
                )
            },
            "$11 (grbl), square_corner_velocity (Klipper), No. 1783 (Fanuc)",
        ),
        "exact_stop" => of(
            |p, lines, s| match p.get("angle_deg").and_then(Value::as_f64) {
                Some(_) => format!(
                    "The machine stops at every corner sharper than {}°{}.",
                    number(p, "angle_deg"),
                    costs(s)
                ),
                None => format!("The machine stops exactly {}{}.", at_lines(lines), costs(s)),
            },
            "G9, G61, G60",
        ),
        "in_position_wait" => of(
            |p, _, s| {
                format!(
                    "At full stops the machine waits {} s until its axes are in position{}.",
                    number(p, "seconds"),
                    costs(s)
                )
            },
            "in-position width (Fanuc No. 1826), STOP_LIMIT_FINE (Siemens MD36010), timePosOK (Heidenhain)",
        ),
        "block_processing_time" => of(
            |p, _, s| format!("The control needs {} s for every block{}.", number(p, "seconds"), costs(s)),
            "block cycle time",
        ),
        "look_ahead" => of(
            |p, _, s| format!("The control looks {} blocks ahead{}.", number(p, "blocks"), costs(s)),
            "look-ahead buffer, G103 P (Haas), BLOCK_BUFFER_SIZE (grbl)",
        ),
        "path_smoothing" => of(
            |p, _, s| {
                let does = if p.contains_key("at") { "rounds corners" } else { "merges short blocks" };
                format!("The control {does} within {} mm{}.", number(p, "tolerance_mm"), costs(s))
            },
            "COMPCAD (Siemens), G5.1 Q1 (Fanuc), G64 Q (LinuxCNC)",
        ),
        "feed_override" => of(
            |p, _, s| {
                let percent = 100.0 * p.get("ratio").and_then(Value::as_f64).unwrap_or(f64::NAN);
                let line = |key: &str| p.get(key).and_then(Value::as_u64).filter(|line| 0 < *line);
                let place = match (line("from_line"), line("to_line")) {
                    (Some(first), Some(last)) => format!("From line {first} to line {last} the"),
                    (Some(first), None) => format!("From line {first} on the"),
                    (None, Some(last)) => format!("Up to line {last} the"),
                    (None, None) => "The".to_string(),
                };
                format!(
                    "{place} machine ran at {} % of the programmed feed: feed override{}.",
                    three(percent),
                    costs(s)
                )
            },
            "feed override switch",
        ),
        "rapid_override" => of(
            |p, _, s| {
                let percent = 100.0 * p.get("ratio").and_then(Value::as_f64).unwrap_or(f64::NAN);
                format!(
                    "Rapid moves ran at {} % of the rapid feed: rapid override{}.",
                    three(percent),
                    costs(s)
                )
            },
            "rapid override switch",
        ),
        "adaptive_feed" => of(
            |_, lines, s| format!("The feed was adapted smoothly {}{}.", at_lines(lines), costs(s)),
            "adaptive feed control",
        ),
        "feed_hold" => of(
            |p, _, s| {
                format!(
                    "The operator held the feed in line {} for {} s{}.",
                    number(p, "line"),
                    number(p, "seconds"),
                    costs(s)
                )
            },
            "feed hold",
        ),
        "unmodelled_wait" => of(
            |p, lines, _| {
                let code = word(p, "code");
                let what = match (code.as_str(), word(p, "or_code").as_str()) {
                    ("", _) => at_lines(lines),
                    (code, "") => format!("at {code}"),
                    (code, others) => format!("at {code} or {others}, between which nothing moves"),
                };
                let seconds = p.get("seconds").and_then(Value::as_f64).unwrap_or(f64::NAN);
                let more = if seconds < 0.0 { "less" } else { "more" };
                format!(
                    "The machine waits {} s {more} than the machine file says {what}.",
                    three(seconds.abs())
                )
            },
            "",
        ),
        "servo_lag" => of(
            |p, _, _| match p.contains_key("kv_1_s") {
                true => format!("The axes follow with a lag: Kv = {} 1/s.", number(p, "kv_1_s")),
                false => format!("The axes follow with a lag of {} s.", number(p, "time_constant_s")),
            },
            "POSCTRL_GAIN (Siemens MD32200), No. 1825 (Fanuc), MP1810 (Heidenhain)",
        ),
        "backlash" => of(
            |p, _, _| format!("Axis {} has {} mm of backlash.", word(p, "axis"), number(p, "width_mm")),
            "BACKLASH (Siemens MD32450), No. 1851 (Fanuc), MP710 (Heidenhain)",
        ),
        "structural_vibration" => of(
            |p, _, _| {
                format!(
                    "The structure vibrates in {} at {} Hz with a damping of {}.",
                    word(p, "axis"),
                    number(p, "frequency_hz"),
                    number(p, "damping")
                )
            },
            "",
        ),
        "recorder_clock" => {
            of(|p, _, _| format!("The recorder's clock runs at {} of the true rate.", number(p, "ratio")), "")
        }
        _ => of(|_, lines, s| format!("Something acts {}{}.", at_lines(lines), costs(s)), ""),
    }
}

/// A number with three digits that matter.
fn three(value: f64) -> String {
    let rounded: f64 = format!("{value:.2e}").parse().unwrap_or(value);
    rounded.to_string()
}

fn number(parameters: &Map<String, Value>, key: &str) -> String {
    match parameters.get(key) {
        Some(Value::Number(number)) => match number.as_i64() {
            Some(whole) => whole.to_string(),
            None => three(number.as_f64().unwrap_or(f64::NAN)),
        },
        _ => "?".to_string(),
    }
}

fn list(parameters: &Map<String, Value>, key: &str) -> String {
    let numbers = parameters.get(key).and_then(Value::as_array);
    let numbers = numbers.map(|all| all.iter().filter_map(Value::as_f64).map(three).collect::<Vec<_>>());
    numbers.unwrap_or_default().join(", ")
}

fn word(parameters: &Map<String, Value>, key: &str) -> String {
    parameters.get(key).and_then(Value::as_str).unwrap_or("").to_string()
}

fn costs(seconds: f64) -> String {
    match seconds {
        s if s.abs() < 5e-3 => String::new(),
        s if 0.0 < s => format!(", which costs {} s", three(s)),
        s => format!(", which saves {} s", three(-s)),
    }
}

fn at_lines(lines: &[(u32, u32)]) -> String {
    match lines {
        [] => "somewhere".to_string(),
        [(first, last)] if first == last => format!("at line {first}"),
        [(first, last)] => format!("in lines {first} to {last}"),
        [(first, _), .., (_, last)] => format!("in several places between lines {first} and {last}"),
    }
}
