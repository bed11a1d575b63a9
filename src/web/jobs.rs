//! A job of several programs: its price with the addends, its documents and its file; and the content of
//! archives.

use wasm_bindgen::prelude::*;

use crate::identification::recording::archived;
use crate::project::{self, JobComparison, JobFile, JobReport};
use crate::simulation::gcode::title;

/// A job with its price.
#[wasm_bindgen(js_name = PricedJob)]
pub struct JobHandle {
    report: JobReport,
}

#[wasm_bindgen(js_class = PricedJob)]
impl JobHandle {
    /// Returns the job of a request as JSON text, with the times of its programs; throws the fault of the
    /// text.
    #[wasm_bindgen(constructor)]
    pub fn new(asked: &str) -> Result<JobHandle, String> {
        let report = JobReport::from_json(asked).map_err(|fault| project::faults_to_json(&[fault]))?;
        Ok(JobHandle { report })
    }

    /// Returns the report as JSON.
    pub fn json(&self) -> String {
        self.report.to_json()
    }

    /// Returns the report as CSV.
    pub fn csv(&self) -> String {
        self.report.to_csv()
    }

    /// Returns the costing for the house as an HTML document, with charts as SVG, each with a caption.
    pub fn costing(&self, charts: Vec<String>, captions: Vec<String>) -> String {
        self.report.to_costing(&charts.into_iter().zip(captions).collect::<Vec<_>>())
    }

    /// Returns the offer for a customer as an HTML document.
    pub fn offer(&self) -> String {
        self.report.to_offer()
    }

    /// Returns the result for sharing as an HTML document, with pictures as SVG, each with a caption.
    pub fn result(&self, pictures: Vec<String>, captions: Vec<String>) -> String {
        self.report.to_result(&pictures.into_iter().zip(captions).collect::<Vec<_>>())
    }

    /// Returns the differences from another job, as JSON.
    #[wasm_bindgen(js_name = comparedWith)]
    pub fn compared_with(&self, other: &JobHandle) -> String {
        JobComparison::new(&self.report, &other.report).to_json()
    }
}

/// Returns the job of a file with all settings of each operation, as JSON; throws the fault of the file.
#[wasm_bindgen(js_name = jobFromText)]
pub fn job_from_text(text: &str) -> Result<String, String> {
    JobFile::from_json(text).map(|job| job.to_json()).map_err(|fault| fault.to_string())
}

/// Returns the letter around the prices of an offer as a form, JSON: the fields of the offer and of the
/// company.
#[wasm_bindgen(js_name = letterForm)]
pub fn letter_form() -> String {
    project::letter_form()
}

/// Returns the title in the head of a program; undefined if it has none.
#[wasm_bindgen(js_name = programTitle)]
pub fn program_title(head: &[u8]) -> Option<String> {
    title(head)
}

/// Returns `true` if the head of a text that may be a program contains blocks; folders and archives contain
/// other texts as well.
#[wasm_bindgen(js_name = holdsBlocks)]
pub fn holds_blocks(head: &[u8]) -> bool {
    project::holds_blocks(head)
}

/// The files of an archive.
#[wasm_bindgen(js_name = Archived)]
pub struct UnpackedArchive {
    files: Vec<(String, Vec<u8>)>,
}

#[wasm_bindgen(js_class = Archived)]
impl UnpackedArchive {
    /// Unpacks an archive; throws the reason if that fails.
    #[wasm_bindgen(constructor)]
    pub fn new(bytes: &[u8]) -> Result<UnpackedArchive, String> {
        archived(bytes).map(|files| UnpackedArchive { files }).map_err(|error| error.to_string())
    }

    /// Returns the names of the files, with their folders.
    pub fn names(&self) -> Vec<String> {
        self.files.iter().map(|(name, _)| name.clone()).collect()
    }

    /// Removes a file, by its index, and returns its bytes.
    pub fn take(&mut self, index: usize) -> Vec<u8> {
        self.files.get_mut(index).map(|(_, bytes)| std::mem::take(bytes)).unwrap_or_default()
    }
}
