//! The offer: terms as a form, the price of a run with all it is made of, its documents; and settings as text.

use wasm_bindgen::prelude::*;

use crate::project::{self, OfferReport, faults_to_json};

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

/// An offer and its documents.
#[wasm_bindgen]
pub struct Offered {
    report: OfferReport,
}

#[wasm_bindgen]
impl Offered {
    /// The offer that a JSON text asks for; throws the faults of its forms as JSON.
    #[wasm_bindgen(constructor)]
    pub fn new(asked: &str) -> Result<Offered, String> {
        let report = OfferReport::from_json(asked).map_err(|faults| faults_to_json(&faults))?;
        Ok(Offered { report })
    }

    /// As JSON.
    pub fn json(&self) -> String {
        self.report.to_json()
    }

    /// As CSV.
    pub fn csv(&self) -> String {
        self.report.to_csv()
    }

    /// As an HTML document with charts in SVG and what each shows, which are as many.
    pub fn html(&self, charts: Vec<String>, captions: Vec<String>) -> String {
        self.report.to_html(&charts.into_iter().zip(captions).collect::<Vec<_>>())
    }
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
