//! The boundary to JavaScript: a job that simulates, a chart that draws, a set of runs that calibrates and
//! diagnoses.
//!
//! The worker holds a [`Job`] and answers with summaries and columns; the page holds a [`Chart`] and forwards
//! pixels. Input consists of JSON text, in which unknown fields are refused, and of numbers. Output consists
//! of the types of [`project`]: results as objects, and columns as typed arrays, each with its own buffer, so
//! that they can be transferred. JavaScript does not convert units or scales, but writes lengths in inches
//! if the user wants that, by the factor in the machine form.
//!
//! Two WebAssembly modules are built from this code: the whole, and with `--cfg first_visit` the part that
//! the first chart needs. Meanwhile the page fetches the whole module, which does everything else.

#![deny(clippy::unwrap_used)]

mod canvas;
mod chart;
#[cfg(not(first_visit))]
mod cutting;
#[cfg(not(first_visit))]
mod diagnosis;
#[cfg(not(first_visit))]
mod documents;
mod job;
#[cfg(not(first_visit))]
mod jobs;
#[cfg(not(first_visit))]
mod law;
#[cfg(not(first_visit))]
mod path_lines;
#[cfg(not(first_visit))]
mod offer;
mod overview;
#[cfg(not(first_visit))]
mod pairing;
#[cfg(not(first_visit))]
mod path;
#[cfg(not(first_visit))]
mod embedded_quote;
#[cfg(not(first_visit))]
mod recordings;
#[cfg(not(first_visit))]
mod revisions;
#[cfg(not(first_visit))]
mod chart_table;
mod terms;
mod text;
mod theme;
#[cfg(not(first_visit))]
mod tolerances;
#[cfg(not(first_visit))]
mod program_path;

use wasm_bindgen::prelude::*;

use crate::identification::recording;
use crate::machine::{
    Machine, USUAL_TOLERANCES_MM, deviation_label, tolerance_from_text, tolerance_label, tolerance_label_in,
};
use crate::plot::PALETTE_SIZE;
use crate::project::{self, FileKind, faults_to_json, machine_from_form, motion_of_machine};
use crate::quote;
use crate::simulation::gcode::Options;
use crate::simulation::interpreter;
use crate::simulation::toolpath::Toolpath;
use crate::units::LengthUnit;
use crate::web::theme::length_unit;

/// Returns the path of a program on a machine.
#[cfg(not(first_visit))]
fn path_of(program: Vec<u8>, options: &Options, machine: &Machine) -> Option<Toolpath> {
    Some(interpreter::trace_text(program, options, machine))
}

/// Returns the path of a program of plain words without jumps, as most programs are; `None` for programs that
/// jump, call or compute, for programs of Siemens and Heidenhain, and for splines, which need the whole
/// module.
#[cfg(first_visit)]
fn path_of(program: Vec<u8>, options: &Options, machine: &Machine) -> Option<Toolpath> {
    interpreter::trace_plain(&program, options, machine, interpreter::LINES_PER_PART)
}

/// Makes panics readable in the console.
#[wasm_bindgen(start)]
pub fn start() {
    console_error_panic_hook::set_once();
}

/// Returns the machine form as JSON: all parameters and presets.
#[wasm_bindgen]
pub fn form() -> String {
    project::form()
}

/// Returns the dialects as JSON: a list of keyword and name.
#[wasm_bindgen]
pub fn dialects() -> String {
    project::dialects()
}

/// Returns the possible references of I, J and K of arcs as JSON: a list of keyword and name.
#[wasm_bindgen(js_name = arcCenters)]
pub fn arc_centers() -> String {
    project::arc_centers()
}

/// Returns the faults of a machine form as JSON: a list of key and message.
#[wasm_bindgen]
pub fn faults(machine: &str) -> String {
    faults_to_json(&machine_from_form(machine).err().unwrap_or_default())
}

/// Returns a filled machine form after an edit of one field, all as JSON; undefined if the text is not JSON.
#[wasm_bindgen]
pub fn edited(machine: &str, key: &str, value: &str) -> Option<String> {
    project::edited(machine, key, value)
}

/// Returns all parameters that the simulation reads from the machine of a filled form as text for comparison;
/// undefined if the form has faults.
#[wasm_bindgen(js_name = motionOf)]
pub fn motion_of(machine: &str) -> Option<String> {
    machine_from_form(machine).ok().map(|machine| motion_of_machine(&machine))
}

/// Returns the price of a cycle time (s) on the machine of a filled form; undefined if the form has faults.
#[wasm_bindgen]
pub fn price(machine: &str, cycle_time: f64) -> Option<f64> {
    machine_from_form(machine).ok().map(|machine| quote::price(cycle_time, &machine))
}

/// Returns the default tolerances, mm.
#[wasm_bindgen(js_name = usualTolerances)]
pub fn usual_tolerances() -> Vec<f64> {
    USUAL_TOLERANCES_MM.to_vec()
}

/// Returns the tolerance (mm) in a text; a number alone is in the fine unit of the unit with this word. Throws
/// the reason as a string if the text is not a tolerance.
#[wasm_bindgen(js_name = toleranceFromText)]
pub fn tolerance_from(text: &str, unit: &str) -> Result<f64, String> {
    let unit = LengthUnit::from_word(unit).unwrap_or_default();
    tolerance_from_text(text, unit).map_err(|error| error.to_string())
}

/// Formats a tolerance (mm) as documents have it, which also tells it from others.
#[wasm_bindgen(js_name = toleranceLabel)]
pub fn label_of_tolerance(tolerance: f64) -> String {
    tolerance_label(tolerance)
}

/// Formats a tolerance (mm) in the unit shown.
#[wasm_bindgen(js_name = toleranceShown)]
pub fn shown_tolerance(tolerance: f64) -> String {
    tolerance_label_in(length_unit(), tolerance)
}

/// Formats a distance from the path (mm) in the unit shown.
#[wasm_bindgen(js_name = deviationLabel)]
pub fn label_of_deviation(deviation: f64) -> String {
    deviation_label(length_unit(), deviation)
}

/// Formats a time lost (s).
#[wasm_bindgen(js_name = lostLabel)]
pub fn label_of_lost(seconds: f64) -> String {
    project::lost_label(seconds)
}

/// Returns the kind of a file by its beginning: `program`, `recording`, `settings`, `job`, `archive`, or the
/// name of a format that cannot be used.
#[wasm_bindgen(js_name = fileKind)]
pub fn file_kind(head: &[u8]) -> String {
    let kind = match project::file_kind(head) {
        FileKind::Program => "program",
        FileKind::Recording => "recording",
        FileKind::Settings => "settings",
        FileKind::Job => "job",
        FileKind::Archive => "archive",
        FileKind::Other(name) => name,
    };
    kind.to_string()
}

/// Returns the number of bytes that determine the kind of a file.
#[wasm_bindgen(js_name = sniffedBytes)]
pub fn sniffed_bytes() -> usize {
    recording::SNIFFED_BYTES
}

/// Returns the number of curves that one chart distinguishes by colour.
#[wasm_bindgen(js_name = mostCurves)]
pub fn most_curves() -> usize {
    PALETTE_SIZE
}
