//! The machine as a form: the parameter table as JSON for the page, with the units in which it can show
//! lengths, and the filled form back.
//!
//! A filled form is a flat object, `{"interpolator.filters": 3, "rapid.feed_mm_min": null, …}`;
//! a field left empty is null or absent.

use serde::Serialize;
use serde_json::{Map, Value};

use crate::machine::{Access, Machine, PARAMETERS, parameter, presets};
use crate::project::machine::written::{
    CALIBRATION_KEYS, TIME_CONSTANT_KEYS, WrittenValue, contradiction, position, rivals, set, written,
};
use crate::project::{TextFault, VERSION, motion_of_machine};
use crate::simulation::gcode::{ArcCenters, Dialect};
use crate::simulation::ordered::sort_by_number;
use crate::units::LengthUnit;

#[derive(Serialize)]
struct MachineForm {
    fields: Vec<FormField>,
    presets: Vec<PresetRow>,
    lengths: [LengthUnitRow; 2],
    version: &'static str,
}

/// A unit in which the page can show lengths and feedrates.
#[derive(Serialize)]
struct LengthUnitRow {
    word: &'static str,
    symbol: &'static str,
    feed_symbol: &'static str,
    fine_symbol: &'static str,
    /// Length of the unit.
    in_mm: f64,
    decimals: usize,
    feed_decimals: usize,
}

/// One parameter as a form field.
#[derive(Serialize)]
pub(in crate::project) struct FormField {
    pub(in crate::project) key: &'static str,
    pub(in crate::project) label: &'static str,
    pub(in crate::project) doc: &'static str,
    /// Name of the field's group, for people.
    pub(in crate::project) group: &'static str,
    /// Neutral value.
    pub(in crate::project) neutral: Value,
    /// `number`, `list`, `choice`, `flag`, `text`, `codes` or `tools`.
    pub(in crate::project) kind: &'static str,
    pub(in crate::project) unit: Option<&'static str>,
    pub(in crate::project) min: Option<f64>,
    pub(in crate::project) max: Option<f64>,
    pub(in crate::project) whole: bool,
    pub(in crate::project) words: &'static [&'static str],
}

impl FormField {
    /// Returns a field without a kind.
    pub(in crate::project) fn empty(
        key: &'static str,
        label: &'static str,
        doc: &'static str,
        group: &'static str,
        neutral: Value,
    ) -> FormField {
        FormField {
            key,
            label,
            doc,
            group,
            neutral,
            kind: "",
            unit: None,
            min: None,
            max: None,
            whole: false,
            words: &[],
        }
    }

    /// Returns the field as a number, or a list of numbers, within `bounds` in `unit`.
    pub(in crate::project) fn of_numbers(
        self,
        kind: &'static str,
        unit: &'static str,
        bounds: (f64, f64),
        whole: bool,
    ) -> FormField {
        FormField { kind, unit: Some(unit), min: Some(bounds.0), max: Some(bounds.1), whole, ..self }
    }
}

/// The groups of parameters, by the first part of their keys.
const GROUPS: [(&str, &str); 15] = [
    ("interpolator", "Filters and corners"),
    ("path", "Limits along the path"),
    ("axis", "Axes"),
    ("rapid", "Rapids"),
    ("path_modes", "Tolerances that programs set"),
    ("times", "Times"),
    ("halts", "Waits and holds"),
    ("override", "Overrides"),
    ("cycles", "Cycles"),
    ("program", "Reading of programs"),
    ("tools", "Tools"),
    ("work_offsets", "Work offsets"),
    ("recorder", "Recorder"),
    ("rates", "Rates"),
    ("", "Name and origin"),
];

/// Returns the group of a key.
fn group(key: &str) -> &'static str {
    let first = key.split('.').next().unwrap_or(key);
    GROUPS.iter().find(|(prefix, _)| *prefix == first).unwrap_or(&GROUPS[GROUPS.len() - 1]).1
}

#[derive(Serialize)]
struct PresetRow {
    name: String,
    source: &'static str,
    caveat: &'static str,
    values: Map<String, Value>,
}

/// Returns the dialects as JSON text: a list of keyword and name.
pub fn dialects() -> String {
    let named = Dialect::WORDS.map(|(word, _, name)| serde_json::json!({ "word": word, "name": name }));
    serde_json::Value::from(named.to_vec()).to_string()
}

/// Returns the possible references of I, J and K of arcs as JSON text: a list of keyword and name.
pub fn arc_centers() -> String {
    let named = ArcCenters::WORDS.map(|(word, _, name)| serde_json::json!({ "word": word, "name": name }));
    serde_json::Value::from(named.to_vec()).to_string()
}

/// Returns the parameter table, the presets and the units of length as JSON text.
pub fn form() -> String {
    let neutral = values(&Machine::default());
    let fields = PARAMETERS.iter().map(|row| {
        let neutral = neutral[row.key].clone();
        let empty = FormField::empty(row.key, row.label, row.doc, group(row.key), neutral);
        match &row.access {
            Access::Number { unit, min, max, whole, .. } => {
                empty.of_numbers("number", unit.symbol(), (*min, *max), *whole)
            }
            Access::List { unit, min, max, whole, .. } => {
                empty.of_numbers("list", unit.symbol(), (*min, *max), *whole)
            }
            Access::Choice { words, .. } => FormField { kind: "choice", words, ..empty },
            Access::Flag { .. } => FormField { kind: "flag", ..empty },
            Access::Text { .. } => FormField { kind: "text", ..empty },
            Access::Codes { .. } => FormField { kind: "codes", ..empty },
            Access::Tools => FormField { kind: "tools", unit: Some("mm"), ..empty },
        }
    });
    let presets = presets().into_iter().map(|preset| PresetRow {
        name: preset.machine.name.clone(),
        source: preset.source,
        caveat: preset.caveat,
        values: values(&preset.machine),
    });
    let lengths = LengthUnit::WORDS.map(|(word, unit)| LengthUnitRow {
        word,
        symbol: unit.symbol(),
        feed_symbol: unit.feed_symbol(),
        fine_symbol: unit.fine_symbol(),
        in_mm: unit.in_mm(),
        decimals: unit.decimals(),
        feed_decimals: unit.feed_decimals(),
    });
    let form =
        MachineForm { fields: fields.collect(), presets: presets.collect(), lengths, version: VERSION };
    serde_json::to_string(&form).expect("text and finite numbers have a JSON form")
}

/// Returns a machine as a filled form, as JSON.
pub fn machine_values(machine: &Machine) -> String {
    Value::Object(values(machine)).to_string()
}

/// Returns a machine as a filled form.
pub(in crate::project) fn values(machine: &Machine) -> Map<String, Value> {
    let values = PARAMETERS.iter().map(|row| {
        let value = match written(machine, row) {
            None | Some(WrittenValue::Empty) => Value::Null,
            Some(WrittenValue::Number(value)) => Value::from(value),
            Some(WrittenValue::Text(text)) => Value::from(text),
            Some(WrittenValue::Flag(flag)) => Value::from(flag),
            Some(WrittenValue::List(values)) => Value::from(values),
            Some(WrittenValue::Codes(codes) | WrittenValue::Tools(codes)) => {
                Value::Object(filled(codes.into_iter().map(|(code, seconds)| (code, Value::from(seconds)))))
            }
        };
        (row.key.to_string(), value)
    });
    filled(values)
}

/// Returns a filled form from keys and values. They are inserted one by one, because `collect` sorts them
/// first, and each call of `collect` adds another sort of 4 kB to the WebAssembly module.
pub(in crate::project) fn filled(values: impl Iterator<Item = (String, Value)>) -> Map<String, Value> {
    let mut map = Map::new();
    map.extend(values);
    map
}

/// Returns the machine of a filled form.
///
/// # Errors
///
/// Returns all faults of the form.
pub fn machine_from_form(json: &str) -> Result<Machine, Vec<TextFault>> {
    let values: Map<String, Value> = serde_json::from_str(json).map_err(|error| {
        vec![TextFault { place: Some((error.line(), error.column())), key: None, message: error.to_string() }]
    })?;
    let mut machine = Machine::default();
    let mut faults = Vec::new();
    // Empty fields first: clearing one form of the time constants must not undo another.
    let mut fields: Vec<(&String, &Value)> = values.iter().collect();
    sort_by_number(&mut fields, |(key, _)| position(key) as f64);
    let (empty, filled): (Vec<_>, Vec<_>) = fields.into_iter().partition(|(_, value)| value.is_null());
    for (key, value) in empty.into_iter().chain(filled) {
        let outcome = match value_as_written(value) {
            Some(written) => set(&mut machine, key, written),
            None => Err(TextFault::at_key(key, "this is not a value of a parameter".to_string())),
        };
        faults.extend(outcome.err());
    }
    let is_filled = |key: &str| values.get(key).is_some_and(|value| !value.is_null());
    for (first, second) in rivals(&is_filled) {
        let label = parameter(first).map_or(first, |row| row.label);
        faults.push(TextFault::at_key(second, format!("give either this or {label}; leave the other empty")));
    }
    if !TIME_CONSTANT_KEYS.iter().any(|key| is_filled(key)) {
        faults.push(TextFault::at_key(TIME_CONSTANT_KEYS[0], "expected a number".to_string()));
    }
    faults.extend(contradiction(&machine));
    if faults.is_empty() { Ok(machine) } else { Err(faults) }
}

/// Returns a filled form with one field changed, all as JSON; `None` if `form` or `value` is not JSON. A
/// change of the machine's motion clears the errors of its calibration, which no longer apply.
pub fn edited(form: &str, key: &str, value: &str) -> Option<String> {
    let mut values: Map<String, Value> = serde_json::from_str(form).ok()?;
    let motion = |values: &Map<String, Value>| {
        machine_from_form(&Value::Object(values.clone()).to_string())
            .map(|machine| motion_of_machine(&machine))
    };
    let before = motion(&values);
    values.insert(key.to_string(), serde_json::from_str(value).ok()?);
    if before != motion(&values) {
        values.extend(CALIBRATION_KEYS.map(|key| (key.to_string(), Value::Null)));
    }
    Some(Value::Object(values).to_string())
}

/// Returns faults as JSON text, a list of key and message.
pub fn faults_to_json(faults: &[TextFault]) -> String {
    #[derive(Serialize)]
    struct FieldFault<'a> {
        key: Option<&'a str>,
        message: &'a str,
    }
    let of_fields =
        faults.iter().map(|TextFault { key, message, .. }| FieldFault { key: key.as_deref(), message });
    serde_json::to_string(&of_fields.collect::<Vec<_>>()).expect("text has a JSON form")
}

fn value_as_written(value: &Value) -> Option<WrittenValue> {
    match value {
        Value::Null => Some(WrittenValue::Empty),
        Value::Bool(flag) => Some(WrittenValue::Flag(*flag)),
        Value::Number(number) => number.as_f64().map(WrittenValue::Number),
        Value::String(text) => Some(WrittenValue::Text(text.clone())),
        Value::Array(values) => {
            values.iter().map(Value::as_f64).collect::<Option<_>>().map(WrittenValue::List)
        }
        Value::Object(codes) => {
            let codes = codes.iter().map(|(code, seconds)| Some((code.clone(), seconds.as_f64()?)));
            codes.collect::<Option<_>>().map(WrittenValue::Codes)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::project::machine::written::{RAPID_KEY, REQUIRED_KEYS};

    #[test]
    fn presets_come_back_from_their_own_form() {
        for preset in presets() {
            let json = serde_json::to_string(&values(&preset.machine)).expect("finite");
            assert_eq!(machine_from_form(&json), Ok(preset.machine));
        }
    }

    #[test]
    fn an_edit_of_the_motion_takes_the_error_of_the_calibration_away() {
        let form = Value::Object(values(&presets()[0].machine)).to_string();
        let [error_key, .., tolerances_key] = CALIBRATION_KEYS;
        let error = |key: &str, value: &str| {
            let form: Value = serde_json::from_str(&edited(&form, key, value).expect("JSON")).expect("JSON");
            assert_eq!(form[error_key].is_null(), form[tolerances_key].is_null(), "{key}");
            form[error_key].as_f64()
        };
        assert_eq!(error("name", "\"mine\""), Some(7.9));
        assert_eq!(error("rates.hourly", "80"), Some(7.9));
        assert_eq!(error(error_key, "3"), Some(3.0));
        assert_eq!(error("times.tool_change_s", "9"), None);
        assert_eq!(error("interpolator.filters", "99"), None);
        assert_eq!(edited("[", "name", "1"), None);
    }

    #[test]
    fn every_parameter_has_a_group_of_its_own_name_or_is_of_the_machine_itself() {
        for row in PARAMETERS.iter() {
            let known = ["name", "provenance"].contains(&row.key) || CALIBRATION_KEYS.contains(&row.key);
            assert_eq!(group(row.key) == group(""), known, "{}", row.key);
        }
    }

    #[test]
    fn all_faults_are_told_at_once_with_their_keys() {
        let faults = machine_from_form(
            r#"{"interpolator.time_constant_s": 0.03, "interpolator.filters": 9, "rapid.feed_mm_min": null, "axis.x.speed": 1, "name": 3, "override.feed": 0}"#,
        )
        .expect_err("wrong");
        let mut keys: Vec<_> =
            faults.iter().map(|fault| fault.key.clone().expect("each has a key")).collect();
        keys.sort();
        assert_eq!(
            keys,
            ["axis.x.speed", "interpolator.filters", "name", "override.feed", "rapid.feed_mm_min"]
        );
    }

    #[test]
    fn an_empty_number_is_neutral_unless_the_machine_needs_it() {
        let with_empty = |key: &str| {
            let mut form = values(&presets()[0].machine);
            form[key] = Value::Null;
            machine_from_form(&Value::Object(form).to_string())
        };
        let numbers = PARAMETERS.iter().filter(|row| matches!(row.access, Access::Number { .. }));
        for row in numbers.filter(|row| !TIME_CONSTANT_KEYS.contains(&row.key)) {
            match with_empty(row.key) {
                Ok(machine) => {
                    assert!(!REQUIRED_KEYS.contains(&row.key), "{}", row.key);
                    assert_eq!(written(&machine, row), written(&Machine::default(), row), "{}", row.key);
                }
                Err(faults) if row.key == RAPID_KEY => assert_eq!(faults[0].key.as_deref(), Some(RAPID_KEY)),
                Err(faults) => {
                    assert!(REQUIRED_KEYS.contains(&row.key), "{}", row.key);
                    assert_eq!(faults[0].key.as_deref(), Some(row.key));
                    assert!(faults[0].message.contains("number from"), "{}", faults[0].message);
                }
            }
        }
        let filters = with_empty("interpolator.filters").expect_err("a machine has filters");
        assert_eq!(filters[0].message, "expected a whole number from 1 to 4");
    }

    #[test]
    fn one_form_of_the_time_constants_is_needed_and_enough() {
        let with = |constants: &str| {
            let json = format!(r#"{{"interpolator.filters": 3, {constants} "rapid.feed_mm_min": 9000}}"#);
            machine_from_form(&json).map_err(|faults| faults[0].key.clone().expect("it has a key"))
        };
        let (t1, jerk) =
            (r#""interpolator.time_constant_s": 0.03,"#, r#""interpolator.max_jerk_mm_s3": 4e4,"#);
        assert!(with(t1).is_ok() && with(jerk).is_ok());
        assert_eq!(with(&format!("{t1}{jerk}")), Err("interpolator.max_jerk_mm_s3".to_string()));
        assert_eq!(with(""), Err("interpolator.time_constant_s".to_string()));
    }

    #[test]
    fn faults_keep_key_and_message() {
        let faults = [TextFault::at_key("name", "say \"x\"".to_string())];
        assert_eq!(faults_to_json(&faults), r#"[{"key":"name","message":"say \"x\""}]"#);
    }
}
