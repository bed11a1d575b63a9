//! The offer: the price of a run with all it is made of, and its documents.

use wasm_bindgen::prelude::*;

use crate::project::{OfferReport, faults_to_json};

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
