//! Parameters of causes and changes of the machine as people read them: a name, numbers with the digits
//! that their uncertainty leaves, a unit.

use serde::Serialize;
use serde_json::{Map, Value};

use crate::machine::{Access, parameter};
use crate::project::CALIBRATION;
use crate::project::calibrated_view::{as_short, to_the_digits_of};

/// Endings of a parameter's key with the unit they stand for, the longer ones first.
const UNITS: [(&str, &str); 9] = [
    ("_mm_min", "mm/min"),
    ("_mm_s2", "mm/s²"),
    ("_mm_s3", "mm/s³"),
    ("_1_s", "1/s"),
    ("_mm", "mm"),
    ("_deg", "°"),
    ("_hz", "Hz"),
    ("_s", "s"),
    ("seconds", "s"),
];

/// What the letters mean that stand for a quantity.
const NAMES: [(&str, &str); 6] = [
    ("a", "acceleration"),
    ("v", "velocity"),
    ("j", "jerk"),
    ("kv", "Kv"),
    ("seconds", "time"),
    ("from_line", "from line"),
];

/// A parameter of a cause.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Told {
    name: String,
    value: String,
    /// Standard deviation; none where it is not known.
    deviation: Option<String>,
    unit: &'static str,
}

impl Told {
    /// Name, then value with deviation and unit.
    pub fn both(&self) -> (&str, String) {
        let deviation = self.deviation.as_ref().map_or(String::new(), |deviation| format!(" ± {deviation}"));
        (&self.name, format!("{}{deviation} {}", self.value, self.unit).trim_end().to_string())
    }
}

/// A field of the machine form that is otherwise than before.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Change {
    pub key: String,
    pub label: String,
    pub unit: &'static str,
    pub before: String,
    pub after: String,
    /// The value after, where it is one number.
    number: Option<f64>,
}

/// The parameters of a cause.
pub fn told(parameters: &Map<String, Value>, uncertainty: &Map<String, Value>) -> Vec<Told> {
    let of = |(key, value): (&String, &Value)| {
        let ending = UNITS.iter().find(|(ending, _)| key.ends_with(ending));
        let stem = ending.map_or(key.as_str(), |(ending, _)| key.strip_suffix(ending).unwrap_or(key));
        let stem = if stem.is_empty() { key } else { stem };
        let known = NAMES.iter().find(|(letters, _)| *letters == stem);
        let name = known.map_or_else(|| stem.replace('_', " "), |(_, name)| (*name).to_string());
        let deviation = uncertainty.get(key).and_then(Value::as_f64).filter(|deviation| 0.0 < *deviation);
        let shown = match (value.as_f64(), deviation) {
            (Some(number), Some(deviation)) => to_the_digits_of(number, deviation),
            _ => text(value),
        };
        let deviation = deviation.map(|deviation| to_the_digits_of(deviation, deviation));
        Told { name, value: shown, deviation, unit: ending.map_or("", |(_, unit)| unit) }
    };
    parameters.iter().map(of).collect()
}

/// The fields of a filled form that another has otherwise.
pub fn changes(before: &Map<String, Value>, after: &Map<String, Value>) -> Vec<Change> {
    let is_physics = |key: &str| !["name", "provenance"].contains(&key) && !CALIBRATION.contains(&key);
    let changed = after.iter().filter(|(key, value)| is_physics(key) && before.get(*key) != Some(value));
    changed
        .map(|(key, value)| {
            let known = parameter(key);
            Change {
                key: key.clone(),
                label: known.map_or(key.as_str(), |known| known.label).to_string(),
                unit: known.map_or("", |known| match known.access {
                    Access::Number { unit, .. } => unit.symbol(),
                    _ => "",
                }),
                before: before.get(key).map_or_else(|| text(&Value::Null), text),
                after: text(value),
                number: value.as_f64(),
            }
        })
        .collect()
}

/// A value of a form as text.
fn text(value: &Value) -> String {
    match value {
        Value::Null => "–".to_string(),
        Value::Bool(true) => "yes".to_string(),
        Value::Bool(false) => "no".to_string(),
        Value::String(word) => word.replace('_', " "),
        Value::Number(number) => match number.as_i64() {
            Some(whole) => whole.to_string().replace('-', "−"),
            None => as_short(number.as_f64().unwrap_or(f64::NAN)),
        },
        Value::Array(all) => all.iter().map(text).collect::<Vec<_>>().join(", "),
        Value::Object(all) => {
            all.iter().map(|(key, value)| format!("{key}: {}", text(value))).collect::<Vec<_>>().join(", ")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn parameters_have_names_units_and_the_digits_of_their_deviation() {
        let parameters = json!({ "a_mm_s2": 1234.567, "axis": "X", "seconds": 0.25, "from_line": 123456 });
        let uncertainty = json!({ "a_mm_s2": 12.3 });
        let all =
            told(parameters.as_object().expect("an object"), uncertainty.as_object().expect("an object"));
        let lines: Vec<String> =
            all.iter().map(|one| format!("{}: {}", one.both().0, one.both().1)).collect();
        assert_eq!(lines, ["acceleration: 1235 ± 12 mm/s²", "axis: X", "from line: 123456", "time: 0.25 s"]);
    }

    #[test]
    fn changes_are_what_is_otherwise_in_the_form() {
        let before = json!({ "name": "a", "override.feed": 1.0, "rapid.feed_mm_min": 12000.0 });
        let after = json!({ "name": "b", "override.feed": 0.78, "rapid.feed_mm_min": 12000.0 });
        let changes = changes(before.as_object().expect("an object"), after.as_object().expect("an object"));
        assert_eq!(changes.len(), 1);
        assert_eq!((changes[0].before.as_str(), changes[0].after.as_str()), ("1", "0.78"));
        assert_eq!(changes[0].number, Some(0.78));
    }
}
