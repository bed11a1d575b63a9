//! The request for a quote by another program: one JSON object, refused with a reason if it is invalid.
//!
//! ```text
//! {"machine": MACHINE, "tolerances": [0.01, null], "dialect": "siemens", "name": "part.mpf"}
//! MACHINE = "name of a preset" | "text of a machine file" | {"preset": "name", "key": value, …}
//! ```
//!
//! Tolerances are in mm; null, or an empty list, means the tolerances of the program. A machine has the
//! keys and units of its file ([`PARAMETERS`](crate::machine::PARAMETERS)); they replace values of the
//! preset if the request names one. Only `machine` is required.

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use crate::machine::{Machine, Preset, ToleranceError, checked_tolerance, presets};
use crate::project::machine::form::values;
use crate::project::{TextFault, machine_from_form, machine_from_toml};
use crate::simulation::feed::Tolerances;
use crate::simulation::gcode::Dialect;

/// Most tolerances of a request: each needs a simulation.
const MAX_TOLERANCES: usize = 32;

/// A request for a quote.
#[derive(Clone, Debug)]
pub struct QuoteRequest {
    /// Name of the program.
    pub name: String,
    /// Machine.
    pub machine: Machine,
    /// Tolerances, each simulated once; at least one.
    pub tolerances: Vec<Tolerances>,
    /// Dialect; `None` to detect it from the program.
    pub dialect: Option<Dialect>,
}

/// The reason why a request is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RequestError {
    /// The text is not the object above.
    #[error("Truefeed does not understand the request: {0}")]
    Malformed(String),
    /// No preset has this name.
    #[error("there is no machine “{given}”; the presets are {}", .known.iter().map(|name| format!("“{name}”")).collect::<Vec<_>>().join(", "))]
    UnknownPreset {
        /// Given name.
        given: String,
        /// Known names.
        known: Vec<String>,
    },
    /// The values of the machine have faults.
    #[error("the machine has faults: {}", .0.iter().map(TextFault::to_string).collect::<Vec<_>>().join("; "))]
    Machine(Vec<TextFault>),
    /// A tolerance is invalid.
    #[error("{0}")]
    Tolerance(#[from] ToleranceError),
    /// The request has too many tolerances.
    #[error("{0} tolerances are too many; give {MAX_TOLERANCES} at most")]
    TooMany(usize),
    /// No dialect has this keyword.
    #[error("there is no dialect “{given}”; there are {}", Dialect::WORDS.map(|(word, ..)| word).join(", "))]
    UnknownDialect {
        /// Given keyword.
        given: String,
    },
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RequestText {
    machine: Value,
    #[serde(default)]
    tolerances: Vec<Option<f64>>,
    #[serde(default)]
    dialect: Option<String>,
    #[serde(default)]
    name: String,
}

impl QuoteRequest {
    /// Reads a request as JSON text.
    ///
    /// # Errors
    ///
    /// Returns an error if the text is not JSON, or not a valid request.
    pub fn from_json(json: &str) -> Result<QuoteRequest, RequestError> {
        let RequestText { machine, tolerances, dialect, name } =
            serde_json::from_str(json).map_err(|error| RequestError::Malformed(error.to_string()))?;
        if MAX_TOLERANCES < tolerances.len() {
            return Err(RequestError::TooMany(tolerances.len()));
        }
        let machine = machine_of(machine)?;
        let checked = tolerances.into_iter().map(|tolerance| match tolerance {
            None => Ok(Tolerances::Programmed),
            Some(value) => checked_tolerance(value).map(Tolerances::One),
        });
        let mut tolerances = checked.collect::<Result<Vec<_>, _>>()?;
        if tolerances.is_empty() {
            tolerances.push(Tolerances::Programmed);
        }
        let word =
            |word: String| Dialect::from_word(&word).ok_or(RequestError::UnknownDialect { given: word });
        Ok(QuoteRequest { name, machine, tolerances, dialect: dialect.map(word).transpose()? })
    }
}

/// Returns the machine of a request.
pub(super) fn machine_of(given: Value) -> Result<Machine, RequestError> {
    match given {
        // A name is one line without `=`.
        Value::String(text) if text.contains(['=', '\n']) => {
            machine_from_toml(&text).map_err(|fault| RequestError::Machine(vec![fault]))
        }
        Value::String(name) => Ok(preset(&name)?.machine),
        Value::Object(mut own) => {
            let mut form = match own.remove("preset") {
                None => Map::new(),
                Some(Value::String(name)) => values(&preset(&name)?.machine),
                Some(_) => return Err(RequestError::Malformed("“preset” is the name of one".to_string())),
            };
            form.append(&mut own);
            machine_from_form(&Value::Object(form).to_string()).map_err(RequestError::Machine)
        }
        _ => Err(RequestError::Malformed("“machine” is a text or an object".to_string())),
    }
}

fn preset(name: &str) -> Result<Preset, RequestError> {
    let known = || presets().into_iter().map(|preset| preset.machine.name).collect();
    let found = presets().into_iter().find(|preset| preset.machine.name.eq_ignore_ascii_case(name.trim()));
    found.ok_or_else(|| RequestError::UnknownPreset { given: name.to_string(), known: known() })
}

impl RequestError {
    /// Returns the refusal as JSON text: a keyword for its kind, a sentence, and the faults of a machine with
    /// their keys.
    pub fn to_json(&self) -> String {
        #[derive(Serialize)]
        struct OfKey<'a> {
            key: Option<&'a str>,
            message: &'a str,
        }
        #[derive(Serialize)]
        struct RefusalText<'a> {
            kind: &'static str,
            message: String,
            faults: Vec<OfKey<'a>>,
        }
        let kind = match self {
            RequestError::Malformed(_) => "request",
            RequestError::UnknownPreset { .. } | RequestError::Machine(_) => "machine",
            RequestError::Tolerance(_) | RequestError::TooMany(_) => "tolerances",
            RequestError::UnknownDialect { .. } => "dialect",
        };
        let faults: &[TextFault] = if let RequestError::Machine(faults) = self { faults } else { &[] };
        let faults = faults.iter().map(|fault| OfKey { key: fault.key.as_deref(), message: &fault.message });
        let refusal = RefusalText { kind, message: self.to_string(), faults: faults.collect() };
        serde_json::to_string(&refusal).expect("text has a JSON form")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::project::toml_from_machine;

    fn kind(json: &str) -> String {
        let error = QuoteRequest::from_json(json).expect_err(json);
        let refusal: Value = serde_json::from_str(&error.to_json()).expect("a refusal is JSON");
        refusal["kind"].as_str().expect("it has a kind").to_string()
    }

    #[test]
    fn a_machine_is_the_same_by_name_by_file_and_by_values() {
        for Preset { machine, .. } in presets() {
            let ways = [
                Value::from(machine.name.to_lowercase()),
                Value::from(toml_from_machine(&machine)),
                Value::Object(values(&machine)),
                serde_json::json!({ "preset": machine.name }),
            ];
            for way in ways {
                let json = serde_json::json!({ "machine": way }).to_string();
                let request = QuoteRequest::from_json(&json).expect(&json);
                // A file keeps the digits of a value in its unit, one rounding away from the value inside.
                assert_eq!(toml_from_machine(&request.machine), toml_from_machine(&machine), "{json}");
                assert!(matches!(request.tolerances[..], [Tolerances::Programmed]));
            }
        }
    }

    #[test]
    fn values_are_laid_over_the_preset() {
        let name = presets()[1].machine.name.clone();
        let json = serde_json::json!({ "machine": { "preset": name, "times.tool_change_s": 9 } }).to_string();
        let machine = QuoteRequest::from_json(&json).expect("a request").machine;
        assert_eq!(machine.times.tool_change, 9.0);
        assert_eq!(machine.interpolator, presets()[1].machine.interpolator);
    }

    #[test]
    fn what_is_not_understood_is_refused_by_its_kind() {
        let named = |rest: &str| format!(r#"{{"machine": "Older or heavy machine"{rest}}}"#);
        assert!(
            QuoteRequest::from_json(&named(r#", "tolerances": [0.01, null], "dialect": "siemens""#)).is_ok()
        );
        for (json, expected) in [
            ("[]".to_string(), "request"),
            ("{}".to_string(), "request"),
            (named(r#", "extra": 1"#), "request"),
            (r#"{"machine": 3}"#.to_string(), "request"),
            (r#"{"machine": {"preset": 3}}"#.to_string(), "request"),
            (r#"{"machine": "nothing like it"}"#.to_string(), "machine"),
            (r#"{"machine": "filters = 3"}"#.to_string(), "machine"),
            (r#"{"machine": {"interpolator.filters": 99}}"#.to_string(), "machine"),
            (
                r#"{"machine": {"__proto__": {"a": 1}, "preset": "Older or heavy machine"}}"#.to_string(),
                "machine",
            ),
            (named(r#", "tolerances": [-1]"#), "tolerances"),
            (named(r#", "tolerances": [1e300]"#), "tolerances"),
            (named(&format!(r#", "tolerances": [{}]"#, vec!["0.01"; 33].join(","))), "tolerances"),
            (named(r#", "dialect": "esperanto""#), "dialect"),
        ] {
            assert_eq!(kind(&json), expected, "{json}");
        }
    }
}
