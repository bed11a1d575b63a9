//! Which names count as right for which change: the one table by which diagnoses are judged.

use serde_json::{Value, json};

/// A change, and the causes that say what it was. The limit of an axis must also be that of the right axis.
const RIGHT: [(&str, &[&str]); 22] = [
    ("axis_acceleration", &["axis_acceleration_limit"]),
    ("axis_velocity", &["axis_velocity_limit"]),
    ("feed_override", &["feed_override"]),
    ("feed_override_interval", &["feed_override", "adaptive_feed"]),
    ("rapid_override", &["rapid_override"]),
    ("feed_hold", &["feed_hold"]),
    ("operator_pause", &["feed_hold"]),
    ("blend_tolerance", &["corner_tolerance"]),
    // G61 still passes tangents without a stop, as the smallest of tolerances does.
    ("exact_path", &["exact_stop", "corner_tolerance"]),
    ("exact_stop", &["exact_stop"]),
    ("spindle_delay", &["spindle_wait", "unmodelled_wait"]),
    ("spindle_ramp", &["spindle_wait", "unmodelled_wait"]),
    ("tool_change", &["unmodelled_wait"]),
    // No name is made for it: corners are passed by another law, or as with a smaller tolerance.
    ("arc_blends_off", &["junction_rule", "corner_tolerance"]),
    // The slider cuts off feeds and rapids alike; which of them suffer depends on the program. A limit of velocity must be
    // that along the path.
    ("velocity_slider", &["axis_velocity_limit", "feed_override", "rapid_override"]),
    ("servo_lag", &["servo_lag"]),
    ("backlash", &["backlash"]),
    ("junction_deviation", &["junction_rule"]),
    ("square_corner_velocity", &["junction_rule"]),
    ("look_ahead", &["look_ahead"]),
    ("path_acceleration", &["path_acceleration_limit"]),
    // The motion ends before a line and begins again after a time: a wait as well as a hold.
    ("pause_before_line", &["feed_hold", "unmodelled_wait"]),
];

/// Whether a cause that was named says what was changed.
pub fn is_right(kind: &str, value: &Value, cause: &Value) -> bool {
    let id = cause["id"].as_str().unwrap_or_default();
    let known = RIGHT.iter().any(|(name, ids)| *name == kind && ids.contains(&id));
    let axis = match kind {
        "velocity_slider" => Some("XYZ"),
        _ => value["axis"].as_str().filter(|_| kind.starts_with("axis_") || kind == "backlash"),
    };
    let named = cause["parameters"]["axis"].as_str();
    known && axis.is_none_or(|axis| named.is_none_or(|named| named == axis))
}

/// Whether a name in the list of rivals is right: its id, and its axis if the name has one.
pub fn is_right_name(kind: &str, value: &Value, name: &str) -> bool {
    let (id, axis) = name.split_once(" (").map_or((name, None), |(id, axis)| (id, axis.strip_suffix(')')));
    is_right(kind, value, &json!({ "id": id, "parameters": { "axis": axis } }))
}
