//! What an estimator enters: terms as a form.

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
