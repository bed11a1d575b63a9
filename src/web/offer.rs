//! The offer: the price of a run with its addends, and its documents.

use wasm_bindgen::prelude::*;

use crate::project::{OfferReport, faults_to_json};

/// An offer and its documents.
#[wasm_bindgen(js_name = Offered)]
pub struct OfferHandle {
    report: OfferReport,
}

#[wasm_bindgen(js_class = Offered)]
impl OfferHandle {
    /// Returns the offer of a request as JSON text; throws the faults of its forms as JSON.
    #[wasm_bindgen(constructor)]
    pub fn new(asked: &str) -> Result<OfferHandle, String> {
        let report = OfferReport::from_json(asked).map_err(|faults| faults_to_json(&faults))?;
        Ok(OfferHandle { report })
    }

    /// Returns the report as JSON.
    pub fn json(&self) -> String {
        self.report.to_json()
    }

    /// Returns the report as CSV.
    pub fn csv(&self) -> String {
        self.report.to_csv()
    }

    /// Returns the costing as an HTML document, with charts as SVG, each with a caption.
    pub fn html(&self, charts: Vec<String>, captions: Vec<String>) -> String {
        self.report.to_html(&charts.into_iter().zip(captions).collect::<Vec<_>>())
    }
}
