//! Parameters of causes and changes of the machine as people read them: a name, numbers with the digits
//! that their uncertainty leaves, a unit.

use serde::Serialize;
use serde_json::{Map, Value};

use crate::identification::effects::{Reported, ReportedValue, is_whole};
use crate::machine::{Access, parameter};
use crate::project::CALIBRATION;
use crate::project::calibrated_view::{as_short, to_the_digits_of};

/// A parameter of a cause.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Told {
    name: &'static str,
    value: String,
    /// Standard deviation; none where it is not known.
    deviation: Option<String>,
    unit: &'static str,
}

impl Told {
    /// Name, then value with deviation and unit.
    pub fn both(&self) -> (&'static str, String) {
        let deviation = self.deviation.as_ref().map_or(String::new(), |deviation| format!(" ± {deviation}"));
        (self.name, format!("{}{deviation} {}", self.value, self.unit).trim_end().to_string())
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

/// The parameters of a cause, by their keys.
pub fn told(values: &[ReportedValue]) -> Vec<Told> {
    let mut values: Vec<&ReportedValue> = values.iter().collect();
    values.sort_by_key(|value| value.quantity.key);
    let of = |ReportedValue { quantity, value, deviation }: &ReportedValue| {
        let deviation = deviation.filter(|deviation| 0.0 < *deviation);
        let shown = match (value, deviation) {
            (Reported::Number(number), Some(deviation)) => to_the_digits_of(*number, deviation),
            (Reported::Number(whole), None) if is_whole(*whole) => {
                (*whole as i64).to_string().replace('-', "−")
            }
            (Reported::Number(number), None) => as_short(*number),
            (Reported::List(numbers), _) => {
                numbers.iter().map(|number| as_short(*number)).collect::<Vec<_>>().join(", ")
            }
            (Reported::Word(word), _) => word.replace('_', " "),
        };
        let deviation = deviation.map(|deviation| to_the_digits_of(deviation, deviation));
        Told { name: quantity.name, value: shown, deviation, unit: quantity.unit }
    };
    values.into_iter().map(of).collect()
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
    use crate::identification::effects::{FROM_LINE, Quantity, SECONDS};
    use serde_json::json;

    #[test]
    fn parameters_have_names_units_and_the_digits_of_their_deviation() {
        let acceleration = Quantity { key: "a_mm_s2", name: "acceleration", unit: "mm/s²" };
        let axis = Quantity { key: "axis", name: "axis", unit: "" };
        let values = [
            (SECONDS, Reported::Number(0.25), None),
            (acceleration, Reported::Number(1234.567), Some(12.3)),
            (axis, Reported::word("X"), None),
            (FROM_LINE, Reported::Number(123_456.0), None),
        ];
        let values = values.map(|(quantity, value, deviation)| ReportedValue { quantity, value, deviation });
        let lines: Vec<String> =
            told(&values).iter().map(|one| format!("{}: {}", one.both().0, one.both().1)).collect();
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
