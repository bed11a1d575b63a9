//! The terms of an offer as a form.

use wasm_bindgen::prelude::*;

use crate::project::{self, faults_to_json};

/// Returns the terms of an offer as JSON: a list of fields.
#[wasm_bindgen(js_name = termsForm)]
pub fn terms_form() -> String {
    project::terms_form()
}

/// Returns the faults of filled terms, as JSON: a list of key and message.
#[wasm_bindgen(js_name = termFaults)]
pub fn term_faults(terms: &str) -> String {
    faults_to_json(&project::terms_from_form(terms).err().unwrap_or_default())
}
