//! The limits of axes that calibrations found, beside those that the machines had.

use serde_json::{Value, json};

use crate::figures::rate;

/// Quantile of the normal distribution below which 95 % lie: half the width of a 90 % interval.
const NORMAL_QUANTILE_95: f64 = 1.645;

/// The accelerations (mm/s²) and rapid rates (mm/min) of axes that a calibration states with a deviation, each with its
/// true value.
pub fn limits_of(program: &Value, report: &Value) -> Vec<Value> {
    let true_value = |key: &str| {
        let (axis, quantity) = key.strip_prefix("axis.")?.split_once('.')?;
        let axis = ["x", "y", "z"].iter().position(|own| *own == axis)?;
        let (list, factor) = match quantity {
            "acceleration_mm_s2" => ("acceleration_mm_s2", 1.0),
            "rapid_mm_min" => ("velocity_mm_s", 60.0),
            _ => return None,
        };
        Some(factor * program["limits"][list][axis].as_f64()?)
    };
    let of = |estimate: &Value| {
        let key = estimate["key"].as_str()?;
        let number = |place: usize| estimate["numbers"][place].as_f64();
        let (found, deviation, true_value) = (number(1)?, number(2)?, true_value(key)?);
        Some(
            json!({ "program": program["name"], "key": key, "found": found, "deviation": deviation, "true": true_value }),
        )
    };
    report["estimates"].as_array().into_iter().flatten().filter_map(of).collect()
}

/// How many true values lie within the 90 % interval around the value found.
pub fn within(limits: &[Value]) -> Value {
    let is_within = |limit: &&Value| {
        let number = |key: &str| limit[key].as_f64().unwrap_or(f64::NAN);
        (number("found") - number("true")).abs() <= NORMAL_QUANTILE_95 * number("deviation")
    };
    rate(limits.iter().filter(is_within).count(), limits.len())
}
