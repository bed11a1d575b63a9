//! What an estimator enters: terms as a form, and settings as text.

use wasm_bindgen::prelude::*;

use crate::project::{self, faults_to_json};

/// The terms of an offer as JSON: a list of fields.
#[wasm_bindgen(js_name = termsForm)]
pub fn terms_form() -> String {
    project::terms_form()
}

/// What is wrong with filled terms, as JSON: a list of key and message.
#[wasm_bindgen(js_name = termFaults)]
pub fn term_faults(terms: &str) -> String {
    faults_to_json(&project::terms_from_form(terms).err().unwrap_or_default())
}

/// The text of settings given with filled forms; throws why there is none.
#[wasm_bindgen(js_name = settingsText)]
pub fn settings_text(full: &str) -> Result<String, String> {
    project::settings_text(full).map_err(|error| error.to_string())
}

/// Settings with filled forms, as JSON, from their text; throws why there are none.
#[wasm_bindgen(js_name = settingsFromText)]
pub fn settings_from_text(text: &str) -> Result<String, String> {
    project::settings_from_text(text).map_err(|error| error.to_string())
}
