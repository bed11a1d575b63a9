//! Files that the page saves, and reading them: charts as SVG, the machine, the settings.

use wasm_bindgen::prelude::*;

use crate::plot::{svg, svg_of_view};
use crate::project::{self, machine_from_form, machine_from_toml, machine_values, toml_from_machine};
use crate::web::chart::Chart;
use crate::web::theme::{theme, theme_of_documents};

#[wasm_bindgen]
impl Chart {
    /// Returns the whole chart as SVG for a document, dark on white and in mm; undefined if it cannot be
    /// drawn.
    pub fn svg(&self, width: u32, height: u32) -> Option<String> {
        svg(&self.chart, &theme_of_documents(), (width, height))
    }

    /// Returns the view as SVG in the unit shown, dark on white; undefined if it cannot be drawn.
    #[wasm_bindgen(js_name = svgInSight)]
    pub fn svg_in_sight(&self, width: u32, height: u32) -> Option<String> {
        svg_of_view(self.shown(), self.view, &theme(false), (width, height))
    }
}

/// Returns the machine of a filled form as a machine file; undefined if the form has faults.
#[wasm_bindgen(js_name = machineFile)]
pub fn machine_file(machine: &str) -> Option<String> {
    machine_from_form(machine).ok().map(|machine| toml_from_machine(&machine))
}

/// Returns the values of a machine file for the form, as JSON; throws the fault of the file.
#[wasm_bindgen(js_name = valuesOfFile)]
pub fn values_of_file(text: &str) -> Result<String, String> {
    machine_from_toml(text).map(|machine| machine_values(&machine)).map_err(|fault| fault.to_string())
}

/// Returns the text of settings given with filled forms; throws the reason if there is none.
#[wasm_bindgen(js_name = settingsText)]
pub fn settings_text(full: &str) -> Result<String, String> {
    project::settings_text(full).map_err(|error| error.to_string())
}

/// Returns settings with filled forms, as JSON, from their text; throws the reason if there are none.
#[wasm_bindgen(js_name = settingsFromText)]
pub fn settings_from_text(text: &str) -> Result<String, String> {
    project::settings_from_text(text).map_err(|error| error.to_string())
}
