//! Parameters of causes and changes of the machine as text: a name, numbers with the digits that their
//! uncertainty justifies, a unit.

use serde::Serialize;
use serde_json::{Map, Value};

use crate::identification::effects::{Quantity, RATIO, Reported, ReportedValue, is_whole};
use crate::machine::{Access, parameter};

use crate::project::figures::{as_short, to_the_digits_of};
use crate::project::machine::written::CALIBRATION_KEYS;
use crate::simulation::ordered::sort_by_number;
use crate::units::Unit;

/// A parameter of a cause as text.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ParameterText {
    name: &'static str,
    value: String,
    /// Standard deviation; `None` if unknown.
    deviation: Option<String>,
    unit: &'static str,
}

impl ParameterText {
    /// Returns the name, and the value with deviation and unit.
    pub fn name_and_value(&self) -> (&'static str, String) {
        let deviation = self.deviation.as_ref().map_or(String::new(), |deviation| format!(" ± {deviation}"));
        (self.name, format!("{}{deviation} {}", self.value, self.unit).trim_end().to_string())
    }
}

/// A changed field of the machine form.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FieldChange {
    pub key: String,
    pub label: String,
    pub unit: &'static str,
    pub before: String,
    pub after: String,
    /// The value after the change, if it is one number.
    number: Option<f64>,
}

/// Returns the parameters of a cause as text.
pub fn parameter_texts(all: &[ReportedValue]) -> Vec<ParameterText> {
    let mut values: Vec<&ReportedValue> = all.iter().collect();
    // By their keys, of which each has its place.
    let place = |value: &&ReportedValue| {
        all.iter().filter(|other| other.quantity.key < value.quantity.key).count() as f64
    };
    sort_by_number(&mut values, place);
    let of = |ReportedValue { quantity, value, deviation }: &ReportedValue| {
        if let (true, Reported::Number(ratio)) = (quantity.key == RATIO.key, value) {
            return percentage(quantity, *ratio, *deviation);
        }
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
        ParameterText { name: quantity.name, value: shown, deviation, unit: quantity.unit }
    };
    values.into_iter().map(of).collect()
}

/// Returns a ratio in percent, with its deviation unless that rounds to 0 at one decimal.
fn percentage(quantity: &Quantity, ratio: f64, deviation: Option<f64>) -> ParameterText {
    let deviation = deviation.map(|deviation| Unit::Percent.from_core(deviation));
    ParameterText {
        name: quantity.name,
        value: format!("{:.1}", Unit::Percent.from_core(ratio)),
        deviation: deviation.filter(|own| MIN_DEVIATION_PERCENT <= *own).map(|own| format!("{own:.1}")),
        unit: Unit::Percent.symbol(),
    }
}

/// Least deviation that one decimal shows, percent.
const MIN_DEVIATION_PERCENT: f64 = 0.05;

/// Returns the fields in which two filled forms differ.
pub fn changes(before: &Map<String, Value>, after: &Map<String, Value>) -> Vec<FieldChange> {
    let is_physics = |key: &str| !["name", "provenance"].contains(&key) && !CALIBRATION_KEYS.contains(&key);
    let changed = after.iter().filter(|(key, value)| is_physics(key) && before.get(*key) != Some(value));
    changed
        .map(|(key, value)| {
            let known = parameter(key);
            FieldChange {
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

/// Formats a value of a form.
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
    use crate::identification::effects::{FROM_LINE, SECONDS};
    use serde_json::json;

    #[test]
    fn parameters_have_names_units_and_the_digits_of_their_deviation() {
        let acceleration = Quantity { key: "a_mm_s2", name: "acceleration", unit: "mm/s²" };
        let axis = Quantity { key: "axis", name: "axis", unit: "" };
        let values = [
            (SECONDS, Reported::Number(0.25), None),
            (acceleration, Reported::Number(1234.567), Some(12.3)),
            (axis, Reported::Word("X".to_string()), None),
            (FROM_LINE, Reported::Number(123_456.0), None),
            (RATIO, Reported::Number(0.779996), Some(0.000084)),
        ];
        let values = values.map(|(quantity, value, deviation)| ReportedValue { quantity, value, deviation });
        let lines: Vec<String> = parameter_texts(&values)
            .iter()
            .map(|one| format!("{}: {}", one.name_and_value().0, one.name_and_value().1))
            .collect();
        let expected = [
            "acceleration: 1235 ± 12 mm/s²",
            "axis: X",
            "from line: 123456",
            "ratio: 78.0 %",
            "time: 0.25 s",
        ];
        assert_eq!(lines, expected);
        let vague = ReportedValue { quantity: RATIO, value: Reported::Number(0.8), deviation: Some(0.012) };
        assert_eq!(parameter_texts(&[vague])[0].name_and_value(), ("ratio", "80.0 ± 1.2 %".to_string()));
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
