//! The machine as a form: the parameter table as JSON for the page, and the filled form back.
//!
//! A filled form is a flat object, `{"interpolator.filters": 3, "rapid.feed_mm_min": null, …}`;
//! a field left empty is null or absent.

use serde::Serialize;
use serde_json::{Map, Value};

use crate::machine::{Access, Machine, PARAMETERS, parameter, presets};
use crate::project::{
    CALIBRATION, Fault, TIME_CONSTANTS, VERSION, Written, contradiction, motion_of_machine, position, rivals,
    set, written,
};
use crate::simulation::gcode::{ArcCenters, Dialect};

#[derive(Serialize)]
struct Form {
    fields: Vec<Field>,
    presets: Vec<Preset>,
    version: &'static str,
}

/// One parameter as a form field.
#[derive(Serialize)]
pub(super) struct Field {
    pub(super) key: &'static str,
    pub(super) label: &'static str,
    pub(super) doc: &'static str,
    /// What it belongs to, as people call it.
    pub(super) group: &'static str,
    /// What it is when nothing is said.
    pub(super) neutral: Value,
    /// `number`, `list`, `choice`, `flag`, `text`, `codes` or `tools`.
    pub(super) kind: &'static str,
    pub(super) unit: Option<&'static str>,
    pub(super) min: Option<f64>,
    pub(super) max: Option<f64>,
    pub(super) whole: bool,
    pub(super) words: &'static [&'static str],
}

impl Field {
    /// A field without a kind.
    pub(super) fn empty(
        key: &'static str,
        label: &'static str,
        doc: &'static str,
        group: &'static str,
        neutral: Value,
    ) -> Field {
        Field {
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

/// What a key belongs to.
fn group(key: &str) -> &'static str {
    let first = key.split('.').next().unwrap_or(key);
    GROUPS.iter().find(|(prefix, _)| *prefix == first).unwrap_or(&GROUPS[GROUPS.len() - 1]).1
}

#[derive(Serialize)]
struct Preset {
    name: String,
    source: &'static str,
    caveat: &'static str,
    values: Map<String, Value>,
}

/// The dialects a program can be read in, as JSON text: a list of word and name.
pub fn dialects() -> String {
    let named = Dialect::WORDS.map(|(word, _, name)| serde_json::json!({ "word": word, "name": name }));
    serde_json::Value::from(named.to_vec()).to_string()
}

/// What I, J and K of arcs may count from, as JSON text: a list of word and name.
pub fn arc_centers() -> String {
    let named = ArcCenters::WORDS.map(|(word, _, name)| serde_json::json!({ "word": word, "name": name }));
    serde_json::Value::from(named.to_vec()).to_string()
}

/// The parameter table and the presets as JSON text.
pub fn form() -> String {
    let neutral = values(&Machine::default());
    let fields = PARAMETERS.iter().map(|row| {
        let neutral = neutral[row.key].clone();
        let empty = Field::empty(row.key, row.label, row.doc, group(row.key), neutral);
        match &row.access {
            Access::Number { unit, min, max, whole, .. } => Field {
                kind: "number",
                unit: Some(unit.symbol()),
                min: Some(*min),
                max: Some(*max),
                whole: *whole,
                ..empty
            },
            Access::List { unit, min, max, whole, .. } => Field {
                kind: "list",
                unit: Some(unit.symbol()),
                min: Some(*min),
                max: Some(*max),
                whole: *whole,
                ..empty
            },
            Access::Choice { words, .. } => Field { kind: "choice", words, ..empty },
            Access::Flag { .. } => Field { kind: "flag", ..empty },
            Access::Text { .. } => Field { kind: "text", ..empty },
            Access::Codes { .. } => Field { kind: "codes", ..empty },
            Access::Tools => Field { kind: "tools", unit: Some("mm"), ..empty },
        }
    });
    let presets = presets().into_iter().map(|preset| Preset {
        name: preset.machine.name.clone(),
        source: preset.source,
        caveat: preset.caveat,
        values: values(&preset.machine),
    });
    let form = Form { fields: fields.collect(), presets: presets.collect(), version: VERSION };
    serde_json::to_string(&form).expect("text and finite numbers have a JSON form")
}

/// A machine as a filled form, as JSON.
pub fn machine_values(machine: &Machine) -> String {
    Value::Object(values(machine)).to_string()
}

/// A machine as a filled form.
pub(super) fn values(machine: &Machine) -> Map<String, Value> {
    let values = PARAMETERS.iter().map(|row| {
        let value = match written(machine, row) {
            None | Some(Written::Empty) => Value::Null,
            Some(Written::Number(value)) => Value::from(value),
            Some(Written::Text(text)) => Value::from(text),
            Some(Written::Flag(flag)) => Value::from(flag),
            Some(Written::List(values)) => Value::from(values),
            Some(Written::Codes(codes) | Written::Tools(codes)) => {
                Value::Object(filled(codes.into_iter().map(|(code, seconds)| (code, Value::from(seconds)))))
            }
        };
        (row.key.to_string(), value)
    });
    filled(values)
}

/// The values of a form by their keys, put in one by one: to collect them sorts them first, and each place that collects
/// adds a sort of its own, 4 kB, to what a first visit fetches.
pub(super) fn filled(values: impl Iterator<Item = (String, Value)>) -> Map<String, Value> {
    let mut map = Map::new();
    map.extend(values);
    map
}

/// The machine of a filled form, or everything wrong with it.
pub fn machine_from_form(json: &str) -> Result<Machine, Vec<Fault>> {
    let values: Map<String, Value> = serde_json::from_str(json).map_err(|error| {
        vec![Fault { place: Some((error.line(), error.column())), key: None, message: error.to_string() }]
    })?;
    let mut machine = Machine::default();
    let mut faults = Vec::new();
    // Empty fields first: taking back one form of the time constants must not undo another.
    let mut fields: Vec<(&String, &Value)> = values.iter().collect();
    fields.sort_by_key(|(key, value)| (!value.is_null(), position(key)));
    for (key, value) in fields {
        let outcome = match value_as_written(value) {
            Some(written) => set(&mut machine, key, written),
            None => Err(Fault::at_key(key, "this is not a value for a parameter".to_string())),
        };
        faults.extend(outcome.err());
    }
    let is_filled = |key: &str| values.get(key).is_some_and(|value| !value.is_null());
    for (first, second) in rivals(&is_filled) {
        let label = parameter(first).map_or(first, |row| row.label);
        faults.push(Fault::at_key(second, format!("give either this or {label}; leave the other empty")));
    }
    if !TIME_CONSTANTS.iter().any(|key| is_filled(key)) {
        faults.push(Fault::at_key(TIME_CONSTANTS[0], "expected a number".to_string()));
    }
    faults.extend(contradiction(&machine));
    if faults.is_empty() { Ok(machine) } else { Err(faults) }
}

/// A filled form after an edit of one field, all as JSON. What moves the machine otherwise than when it was calibrated
/// takes the error of its calibration away.
pub fn edited(form: &str, key: &str, value: &str) -> Option<String> {
    let mut values: Map<String, Value> = serde_json::from_str(form).ok()?;
    let motion = |values: &Map<String, Value>| {
        machine_from_form(&Value::Object(values.clone()).to_string())
            .map(|machine| motion_of_machine(&machine))
    };
    let before = motion(&values);
    values.insert(key.to_string(), serde_json::from_str(value).ok()?);
    if before != motion(&values) {
        values.extend(CALIBRATION.map(|key| (key.to_string(), Value::Null)));
    }
    Some(Value::Object(values).to_string())
}

/// Faults as JSON text, a list of key and message.
pub fn faults_to_json(faults: &[Fault]) -> String {
    #[derive(Serialize)]
    struct FieldFault<'a> {
        key: Option<&'a str>,
        message: &'a str,
    }
    let of_fields =
        faults.iter().map(|Fault { key, message, .. }| FieldFault { key: key.as_deref(), message });
    serde_json::to_string(&of_fields.collect::<Vec<_>>()).expect("text has a JSON form")
}

fn value_as_written(value: &Value) -> Option<Written> {
    match value {
        Value::Null => Some(Written::Empty),
        Value::Bool(flag) => Some(Written::Flag(*flag)),
        Value::Number(number) => number.as_f64().map(Written::Number),
        Value::String(text) => Some(Written::Text(text.clone())),
        Value::Array(values) => values.iter().map(Value::as_f64).collect::<Option<_>>().map(Written::List),
        Value::Object(codes) => {
            let codes = codes.iter().map(|(code, seconds)| Some((code.clone(), seconds.as_f64()?)));
            codes.collect::<Option<_>>().map(Written::Codes)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::project::{RAPID, REQUIRED};

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
        let [error_key, .., tolerances_key] = CALIBRATION;
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
            let known = ["name", "provenance"].contains(&row.key) || CALIBRATION.contains(&row.key);
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
        for row in numbers.filter(|row| !TIME_CONSTANTS.contains(&row.key)) {
            match with_empty(row.key) {
                Ok(machine) => {
                    assert!(!REQUIRED.contains(&row.key), "{}", row.key);
                    assert_eq!(written(&machine, row), written(&Machine::default(), row), "{}", row.key);
                }
                Err(faults) if row.key == RAPID => assert_eq!(faults[0].key.as_deref(), Some(RAPID)),
                Err(faults) => {
                    assert!(REQUIRED.contains(&row.key), "{}", row.key);
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
        let faults = [Fault::at_key("name", "say \"x\"".to_string())];
        assert_eq!(faults_to_json(&faults), r#"[{"key":"name","message":"say \"x\""}]"#);
    }
}
