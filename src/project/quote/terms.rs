//! The terms of an offer as a form: their table as JSON for the page, and the filled form back.
//!
//! A filled form is a flat object, `{"quantity": 10, "set_up_min": 45, "uncertainty_percent": null, …}`;
//! a field left empty is null or absent and takes its neutral value.

use serde_json::{Map, Value};

use crate::project::TextFault;
use crate::project::machine::form::{FormField, filled};
use crate::project::machine::written::tidy;
use crate::quote::{MAX_MARGIN_OF_PRICE, MarginOf, QUANTITY_BOUNDS, TERMS, Term, TermAccess, Terms};
use crate::units::Unit;

/// Returns the table of terms as JSON text: a list of fields.
pub fn terms_form() -> String {
    let neutral = Terms::default();
    let fields = TERMS.iter().map(|row| {
        let empty = FormField::empty(row.key, row.label, row.doc, "", value(&neutral, row));
        match &row.access {
            TermAccess::Number { unit, min, max, whole, .. } => {
                empty.of_numbers("number", unit.symbol(), (*min, *max), *whole)
            }
            TermAccess::Quantities { .. } => empty.of_numbers("list", "parts", QUANTITY_BOUNDS, true),
            TermAccess::Choice { words, .. } => FormField { kind: "choice", words, ..empty },
            TermAccess::Text { .. } => FormField { kind: "text", ..empty },
        }
    });
    serde_json::to_string(&fields.collect::<Vec<_>>()).expect("text and finite numbers have a JSON form")
}

/// Returns terms as a filled form.
pub(in crate::project) fn terms_values(terms: &Terms) -> Map<String, Value> {
    filled(TERMS.iter().map(|row| (row.key.to_string(), value(terms, row))))
}

/// Returns the terms of a filled form as JSON text.
///
/// # Errors
///
/// Returns all faults of the form.
pub fn terms_from_form(json: &str) -> Result<Terms, Vec<TextFault>> {
    let values: Map<String, Value> = serde_json::from_str(json).map_err(|error| {
        vec![TextFault { place: Some((error.line(), error.column())), key: None, message: error.to_string() }]
    })?;
    terms_from_values(&values)
}

/// Returns the terms of a filled form, or all of its faults.
pub(in crate::project) fn terms_from_values(values: &Map<String, Value>) -> Result<Terms, Vec<TextFault>> {
    let mut terms = Terms::default();
    let mut faults: Vec<TextFault> =
        values.iter().filter_map(|(key, value)| set(&mut terms, key, value).err()).collect();
    if terms.margin_of == MarginOf::Price && MAX_MARGIN_OF_PRICE < terms.margin {
        let most = Unit::Percent.from_core(MAX_MARGIN_OF_PRICE);
        let message = format!("a margin of the price is at most {most} %; or choose a margin of the cost");
        faults.push(TextFault::at_key("margin_percent", message));
    }
    if faults.is_empty() { Ok(terms) } else { Err(faults) }
}

fn set(terms: &mut Terms, key: &str, value: &Value) -> Result<(), TextFault> {
    let fault = |message: String| Err(TextFault::at_key(key, message));
    let Some(row) = TERMS.iter().find(|row| row.key == key) else {
        let distance = |row: &&Term| strsim::damerau_levenshtein(row.key, key);
        let nearest = TERMS.iter().min_by_key(distance).expect("the table is not empty");
        return fault(format!("there is no such term; the nearest known one is {}", nearest.key));
    };
    match (&row.access, value) {
        (TermAccess::Number { set, .. }, Value::Null) => set(terms, None),
        (TermAccess::Number { unit, min, max, whole, set, .. }, value) => match value.as_f64() {
            Some(number) if *min <= number && number <= *max && !(*whole && number.fract() != 0.0) => {
                set(terms, Some(unit.to_core(number)));
            }
            _ => {
                let kind = if *whole { "a whole number" } else { "a number" };
                return fault(
                    format!("expected {kind} from {min} to {max} {}", unit.symbol()).trim_end().into(),
                );
            }
        },
        (TermAccess::Quantities { .. }, Value::Null) => terms.breaks = Vec::new(),
        (TermAccess::Quantities { most }, value) => {
            let quantity = |value: &Value| {
                let number = value.as_f64()?;
                let is_one =
                    QUANTITY_BOUNDS.0 <= number && number <= QUANTITY_BOUNDS.1 && number.fract() == 0.0;
                is_one.then_some(number as u32)
            };
            let quantities: Option<Vec<u32>> =
                value.as_array().and_then(|values| values.iter().map(quantity).collect());
            match quantities {
                Some(quantities) if quantities.len() <= *most => terms.breaks = quantities,
                _ => {
                    return fault(format!(
                        "expected up to {most} whole numbers from {} to {}, such as 1; 10; 100",
                        QUANTITY_BOUNDS.0, QUANTITY_BOUNDS.1
                    ));
                }
            }
        }
        (TermAccess::Choice { words, set, .. }, Value::String(word)) if words.contains(&word.as_str()) => {
            set(terms, word);
        }
        (TermAccess::Choice { .. }, Value::Null) => {}
        (TermAccess::Choice { words, .. }, _) => {
            return fault(format!("expected one of: {}", words.join(", ")));
        }
        (TermAccess::Text { most, set, .. }, Value::String(text)) if text.chars().count() <= *most => {
            set(terms, text);
        }
        (TermAccess::Text { set, .. }, Value::Null) => set(terms, ""),
        (TermAccess::Text { most, .. }, _) => {
            return fault(format!("expected a text of {most} characters at most"));
        }
    }
    Ok(())
}

fn value(terms: &Terms, row: &Term) -> Value {
    match &row.access {
        TermAccess::Number { unit, get, .. } => {
            get(terms).map_or(Value::Null, |value| Value::from(tidy(unit.from_core(value))))
        }
        TermAccess::Quantities { .. } => Value::from(terms.breaks.clone()),
        TermAccess::Choice { get, .. } => Value::from(get(terms)),
        TermAccess::Text { get, .. } => Value::from(get(terms)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn keys(json: &str) -> Vec<String> {
        let faults = terms_from_form(json).expect_err(json);
        faults.into_iter().map(|fault| fault.key.unwrap_or_default()).collect()
    }

    #[test]
    fn terms_come_back_from_their_own_form() {
        let json = r#"{"quantity": 25, "set_up_min": 45, "operator_hourly": 36, "margin_percent": 12.5, "margin_of": "cost",
                "breaks": [5, 50], "rounding": "0.0001", "currency": "CHF", "uncertainty_percent": 4, "reference": "A"}"#;
        let terms = terms_from_form(json).expect("right");
        assert_eq!((terms.quantity, terms.set_up, terms.operator), (25, 2700.0, 0.01));
        assert_eq!((terms.margin, terms.uncertainty), (0.125, Some(0.04)));
        assert_eq!(terms_from_values(&terms_values(&terms)), Ok(terms));
        assert_eq!(terms_from_form("{}"), Ok(Terms::default()));
        let emptied = TERMS.iter().map(|row| (row.key.to_string(), Value::Null)).collect();
        let without_breaks = Terms { breaks: Vec::new(), currency: String::new(), ..Terms::default() };
        assert_eq!(terms_from_values(&emptied), Ok(without_breaks));
    }

    #[test]
    fn what_is_out_of_bounds_is_refused_at_its_key() {
        for (json, key) in [
            (r#"{"quantity": 0}"#, "quantity"),
            (r#"{"quantity": 2.5}"#, "quantity"),
            (r#"{"quantity": "many"}"#, "quantity"),
            (r#"{"breaks": [0]}"#, "breaks"),
            (r#"{"breaks": "10"}"#, "breaks"),
            (r#"{"margin_percent": 96}"#, "margin_percent"),
            (r#"{"margin_of": "air"}"#, "margin_of"),
            (r#"{"set_up_min": -1}"#, "set_up_min"),
            (r#"{"discount": 3}"#, "discount"),
            (r#"{"currency": "a currency nobody has"}"#, "currency"),
        ] {
            assert_eq!(keys(json), [key], "{json}");
        }
        assert!(terms_from_form(r#"{"margin_percent": 96, "margin_of": "cost"}"#).is_ok());
        assert_eq!(keys("[]"), [""]);
    }
}
