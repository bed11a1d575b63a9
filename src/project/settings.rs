//! All settings of the page in one text: machine, tolerances, terms and unit of length, never a program.
//! “Save settings” writes the text to a file, and links contain it after their `#`.
//!
//! ```text
//! {"truefeed": 1, "preset": "name", "machine": {key: value, …}, "tolerances_mm": [0.01], "programmed": true,
//!  "terms": {key: value, …}, "length_unit": "inch"}
//! ```
//!
//! Machine and terms contain values that are not neutral; a text without a unit is metric. The reader refuses
//! anything unknown, with the reason, so that a broken or hostile link changes nothing.

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use crate::machine::{Machine, ToleranceError, checked_tolerance, presets};
use crate::plot::PALETTE_SIZE;
use crate::project::machine::form::values;
use crate::project::quote::terms::{terms_from_values, terms_values};
use crate::project::{TextFault, machine_from_form};
use crate::quote::Terms;
use crate::units::LengthUnit;

/// Longest text of settings, bytes.
const MAX_SETTINGS_BYTES: usize = 200_000;

/// Version of the format.
const SETTINGS_VERSION: u32 = 1;

/// The reason why a text is refused as settings.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SettingsError {
    /// The text is too long.
    #[error("it is too long for settings")]
    TooLong,
    /// The text is not the object above.
    #[error("Truefeed does not understand it ({0})")]
    Malformed(String),
    /// The text has another version.
    #[error("it is of version {0}, and this page reads version {SETTINGS_VERSION}")]
    Version(u32),
    /// The machine has faults.
    #[error("its machine has a fault: {}", fault_texts(.0))]
    Machine(Vec<TextFault>),
    /// The terms have faults.
    #[error("its quote has a fault: {}", fault_texts(.0))]
    Terms(Vec<TextFault>),
    /// A tolerance is invalid.
    #[error("a tolerance has a fault: {0}")]
    Tolerance(#[from] ToleranceError),
    /// The page cannot show lengths in the unit.
    #[error("it has lengths in {0}; the page can show metric and inch")]
    LengthUnit(String),
    /// There are no tolerances, or more than a chart shows.
    #[error("it has {0} tolerances; the page can show 1 to {PALETTE_SIZE}")]
    Tolerances(usize),
}

fn fault_texts(faults: &[TextFault]) -> String {
    faults.iter().map(TextFault::to_string).collect::<Vec<_>>().join("; ")
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Settings {
    truefeed: u32,
    #[serde(default)]
    preset: String,
    machine: Map<String, Value>,
    tolerances_mm: Vec<f64>,
    programmed: bool,
    #[serde(default)]
    terms: Map<String, Value>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    length_unit: Option<String>,
}

/// Returns the text of settings, from a text whose machine and terms are filled forms.
///
/// # Errors
///
/// Returns the errors of [`settings_from_text`].
pub fn settings_text(full: &str) -> Result<String, SettingsError> {
    let mut settings = checked(full)?;
    let neutral = values(&Machine::default());
    settings.machine.retain(|key, value| neutral.get(key) != Some(value));
    let neutral = terms_values(&Terms::default());
    settings.terms.retain(|key, value| neutral.get(key) != Some(value));
    let unit = settings.length_unit.as_deref().and_then(LengthUnit::from_word);
    settings.length_unit.take_if(|_| unit == Some(LengthUnit::default()));
    Ok(serde_json::to_string(&settings).expect("what was read can be written"))
}

/// Reads settings from a text; returns them as JSON, with machine and terms as filled forms.
///
/// # Errors
///
/// Returns an error if the text does not contain settings, has another version, or contains a value that is
/// not allowed.
pub fn settings_from_text(text: &str) -> Result<String, SettingsError> {
    let settings = checked(text)?;
    Ok(serde_json::to_string(&settings).expect("what was read can be written"))
}

/// Returns settings with only allowed values; forms are completed with neutral values.
fn checked(text: &str) -> Result<Settings, SettingsError> {
    if MAX_SETTINGS_BYTES < text.len() {
        return Err(SettingsError::TooLong);
    }
    let malformed = |error: serde_json::Error| SettingsError::Malformed(error.to_string());
    let value: Value = serde_json::from_str(text).map_err(malformed)?;
    if let Some(other) = value
        .get("truefeed")
        .and_then(Value::as_u64)
        .filter(|&version| version != u64::from(SETTINGS_VERSION))
    {
        return Err(SettingsError::Version(other.try_into().unwrap_or(u32::MAX)));
    }
    let settings: Settings = serde_json::from_value(value).map_err(malformed)?;
    if settings.tolerances_mm.is_empty() || PALETTE_SIZE < settings.tolerances_mm.len() {
        return Err(SettingsError::Tolerances(settings.tolerances_mm.len()));
    }
    for &tolerance in &settings.tolerances_mm {
        checked_tolerance(tolerance)?;
    }
    if let Some(word) = settings.length_unit.as_ref().filter(|word| LengthUnit::from_word(word).is_none()) {
        return Err(SettingsError::LengthUnit(word.clone()));
    }
    let mut form = values(&Machine::default());
    form.extend(settings.machine);
    // JavaScript writes 0.0 as 0, which is another JSON value, so the values of the checked machine replace the form.
    let machine = machine_from_form(&Value::Object(form).to_string()).map_err(SettingsError::Machine)?;
    let terms = terms_from_values(&settings.terms).map_err(SettingsError::Terms)?;
    let known = presets().into_iter().any(|preset| preset.machine.name == settings.preset);
    let preset = if known { settings.preset } else { String::new() };
    Ok(Settings { preset, machine: values(&machine), terms: terms_values(&terms), ..settings })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_neutral_number_is_left_out_whether_it_is_written_as_a_whole_number_or_not() {
        let text = |zero: &str| {
            format!(
                r#"{{"truefeed": 1, "machine": {{"times.start_s": {zero}}}, "tolerances_mm": [0.01], "programmed": true}}"#
            )
        };
        let [whole, decimal] = ["0", "0.0"].map(|zero| settings_text(&text(zero)).expect("it is right"));
        assert!(!whole.contains("times.start_s"), "{whole}");
        assert_eq!(whole, decimal);
    }

    fn full(machine: &Machine, terms: Value) -> Value {
        serde_json::json!({"truefeed": 1, "preset": presets()[1].machine.name, "machine": values(machine),
            "tolerances_mm": [0.01, 0.03], "programmed": false, "terms": terms})
    }

    #[test]
    fn settings_come_back_whole_and_are_short() {
        let mut machine = presets()[1].machine.clone();
        machine.interpolator.time_constants = crate::machine::TimeConstants::FromJerk(4e4);
        machine.times.m_codes = [(8, 3.0)].into();
        machine.rates.hourly = 80.0;
        let filled = full(&machine, Value::Object(terms_values(&Terms { quantity: 12, ..Terms::default() })));
        let text = settings_text(&filled.to_string()).expect("right");
        assert!(text.len() < 600, "{text}");
        let back: Value = serde_json::from_str(&settings_from_text(&text).expect("right")).expect("JSON");
        assert_eq!(back, filled);
        let mut inches = filled.clone();
        inches["length_unit"] = Value::from("metric");
        assert_eq!(settings_text(&inches.to_string()).expect("right"), text);
        inches["length_unit"] = Value::from("inch");
        let text = settings_text(&inches.to_string()).expect("right");
        let back: Value = serde_json::from_str(&settings_from_text(&text).expect("right")).expect("JSON");
        assert_eq!(back, inches);
        // A link is read as well when it is the whole.
        assert!(settings_from_text(&filled.to_string()).is_ok());
    }

    #[test]
    fn what_is_not_settings_is_refused_with_the_reason() {
        let good = full(&Machine::default(), serde_json::json!({}));
        let with = |key: &str, value: Value| {
            let mut other = good.clone();
            other[key] = value;
            settings_from_text(&other.to_string()).expect_err(key)
        };
        assert!(matches!(settings_from_text("%%%"), Err(SettingsError::Malformed(_))));
        assert!(matches!(settings_from_text(""), Err(SettingsError::Malformed(_))));
        assert!(matches!(settings_from_text("[1]"), Err(SettingsError::Malformed(_))));
        assert_eq!(settings_from_text(&" ".repeat(MAX_SETTINGS_BYTES + 1)), Err(SettingsError::TooLong));
        assert_eq!(with("truefeed", Value::from(2)), SettingsError::Version(2));
        assert!(matches!(with("program", Value::from("G1")), SettingsError::Malformed(_)));
        assert!(matches!(with("machine", serde_json::json!({"__proto__": 1})), SettingsError::Machine(_)));
        assert!(matches!(
            with("machine", serde_json::json!({"interpolator.filters": 99})),
            SettingsError::Machine(_)
        ));
        assert!(matches!(with("terms", serde_json::json!({"quantity": 0})), SettingsError::Terms(_)));
        assert!(matches!(with("tolerances_mm", serde_json::json!([1e9])), SettingsError::Tolerance(_)));
        assert_eq!(with("tolerances_mm", serde_json::json!([])), SettingsError::Tolerances(0));
        assert_eq!(with("length_unit", Value::from("cubit")), SettingsError::LengthUnit("cubit".to_string()));
        assert!(
            with("terms", serde_json::json!({"quantity": 0}))
                .to_string()
                .contains("quantity: expected a whole number")
        );
    }

    #[test]
    fn a_machine_from_elsewhere_has_no_preset_here() {
        let mut other = full(&Machine::default(), serde_json::json!({}));
        other["preset"] = Value::from("<img src=x>");
        let back: Value =
            serde_json::from_str(&settings_from_text(&other.to_string()).expect("right")).expect("JSON");
        assert_eq!(back["preset"], "");
    }
}
