//! An object of JSON, field by field: an unknown field or a value out of bounds is a fault with its place.

use serde_json::{Map, Value};

use crate::project::TextFault;

/// The fields of an object, with its place in the document.
pub(super) struct Fields<'a> {
    place: String,
    map: &'a Map<String, Value>,
}

impl<'a> Fields<'a> {
    /// Returns the fields of the object at a place; the place of the whole document is empty. An unknown
    /// field is a fault.
    pub(super) fn of(value: &'a Value, place: &str, known: &[&str]) -> Result<Fields<'a>, TextFault> {
        let map = value.as_object().ok_or_else(|| fault(place, "expected an object, {…}"))?;
        let fields = Fields { place: place.to_string(), map };
        match map.keys().find(|key| !known.contains(&key.as_str())) {
            None => Ok(fields),
            Some(key) => {
                let distance = |other: &&&str| strsim::damerau_levenshtein(other, key);
                let nearest = known.iter().min_by_key(distance).expect("every object has fields");
                Err(fields.fault(key, &format!("unknown field; the nearest known one is {nearest}")))
            }
        }
    }

    /// Returns a fault of a field.
    pub(super) fn fault(&self, key: &str, message: &str) -> TextFault {
        fault(&self.place_of(key), message)
    }

    /// Returns the place of a field.
    pub(super) fn place_of(&self, key: &str) -> String {
        if self.place.is_empty() { key.to_string() } else { format!("{}.{key}", self.place) }
    }

    /// Returns the value of a field as written; `None` if it is missing.
    pub(super) fn value(&self, key: &str) -> Option<&'a Value> {
        self.map.get(key)
    }

    /// Returns a field; `None` if it is missing or null.
    fn given(&self, key: &str) -> Option<&'a Value> {
        self.value(key).filter(|value| !value.is_null())
    }

    /// Returns a text of at most `most` characters; empty if it is missing.
    pub(super) fn text(&self, key: &str, most: usize) -> Result<String, TextFault> {
        match self.given(key) {
            None => Ok(String::new()),
            Some(Value::String(text)) if text.chars().count() <= most => Ok(text.clone()),
            Some(_) => Err(self.fault(key, &format!("expected a text of {most} characters at most"))),
        }
    }

    /// Returns a text that must not be empty.
    pub(super) fn needed_text(&self, key: &str, most: usize) -> Result<String, TextFault> {
        let text = self.text(key, most)?;
        if text.is_empty() { Err(self.fault(key, "this field is missing")) } else { Ok(text) }
    }

    /// Returns a number within bounds; `None` if it is missing.
    pub(super) fn number(&self, key: &str, (min, max): (f64, f64)) -> Result<Option<f64>, TextFault> {
        match self.given(key) {
            None => Ok(None),
            Some(value) => match value.as_f64().filter(|number| min <= *number && *number <= max) {
                Some(number) => Ok(Some(number)),
                None => Err(self.fault(key, &format!("expected a number from {min} to {max}"))),
            },
        }
    }

    /// Returns one of several keywords; `None` if it is missing.
    pub(super) fn word<T>(
        &self,
        key: &str,
        known: &[&str],
        of: fn(&str) -> Option<T>,
    ) -> Result<Option<T>, TextFault> {
        match self.given(key) {
            None => Ok(None),
            Some(value) => match value.as_str().and_then(of) {
                Some(found) => Ok(Some(found)),
                None => Err(self.fault(key, &format!("expected one of: {}", known.join(", ")))),
            },
        }
    }

    /// Returns the faults that another reader found in the field as a fault of the field.
    pub(super) fn at(&self, key: &str, faults: &[TextFault]) -> TextFault {
        let first = faults.first();
        let below = first.and_then(|fault| fault.key.as_ref()).map(|below| format!(".{below}"));
        let message = first.map_or(String::new(), |fault| fault.message.clone());
        let more = match faults.len() {
            0 | 1 => String::new(),
            count => format!(" (and {} more)", count - 1),
        };
        self.fault(&format!("{key}{}", below.unwrap_or_default()), &(message + &more))
    }
}

fn fault(place: &str, message: &str) -> TextFault {
    TextFault {
        place: None,
        key: (!place.is_empty()).then(|| place.to_string()),
        message: message.to_string(),
    }
}
