//! The boundary to JavaScript: one job that simulates, one chart that draws, one set of runs that calibrates and
//! diagnoses.
//!
//! The worker holds a [`Job`] and answers with summaries and columns; the page holds a
//! [`Chart`] and forwards pixels. What comes in is JSON text, which refuses unknown fields, and
//! numbers; what goes out are the shapes of [`project`], results as objects, and columns as typed
//! arrays with buffers of their own, so that they can be transferred. No arithmetic of units or scales is left to JavaScript.
//!
//! Two modules are made of it: the whole, and with `--cfg first_visit` what there must be before the first chart. What the
//! first leaves out the page asks of the whole, which it fetches meanwhile.

#![deny(clippy::unwrap_used)]

mod canvas;
mod chart;
#[cfg(not(first_visit))]
mod cutting;
#[cfg(not(first_visit))]
mod diagnosed;
#[cfg(not(first_visit))]
mod documents;
mod job;
#[cfg(not(first_visit))]
mod offered;
#[cfg(not(first_visit))]
mod path;
#[cfg(not(first_visit))]
mod quoted;
#[cfg(not(first_visit))]
mod recorded;
#[cfg(not(first_visit))]
mod tabled;
mod terms;
mod text;
mod theme;
#[cfg(not(first_visit))]
mod tolerances;
#[cfg(not(first_visit))]
mod traced;

use wasm_bindgen::prelude::*;

use crate::identification::recording;
use crate::machine::{Machine, USUAL_TOLERANCES, deviation_label, tolerance_from_text, tolerance_label};
use crate::plot::PALETTE;
use crate::project::{self, FileKind, faults_to_json, machine_from_form, motion_of_machine};
use crate::quote;
use crate::simulation::gcode::Options;
use crate::simulation::toolpath::{self, Toolpath};

/// The path of a program on a machine.
#[cfg(not(first_visit))]
fn path_of(program: Vec<u8>, options: &Options, machine: &Machine) -> Option<Toolpath> {
    Some(toolpath::trace_text(program, options, machine))
}

/// The path of a program that goes straight on, as most do; what jumps, calls and computes is left to the whole module,
/// and so is what cannot be read but as a whole.
#[cfg(first_visit)]
fn path_of(program: Vec<u8>, options: &Options, machine: &Machine) -> Option<Toolpath> {
    toolpath::trace_straight(&program, options, machine, toolpath::LINES_OF_A_PART)
}

/// Makes panics readable in the console.
#[wasm_bindgen(start)]
pub fn start() {
    console_error_panic_hook::set_once();
}

/// The machine form as JSON: all parameters and presets.
#[wasm_bindgen]
pub fn form() -> String {
    project::form()
}

/// The dialects a program can be read in, as JSON: a list of word and name.
#[wasm_bindgen]
pub fn dialects() -> String {
    project::dialects()
}

/// What I, J and K of arcs may count from, as JSON: a list of word and name.
#[wasm_bindgen(js_name = arcCenters)]
pub fn arc_centers() -> String {
    project::arc_centers()
}

/// What is wrong with the values of a machine form, as JSON: a list of key and message.
#[wasm_bindgen]
pub fn faults(machine: &str) -> String {
    faults_to_json(&machine_from_form(machine).err().unwrap_or_default())
}

/// A filled machine form after an edit of one field, all as JSON; none where that is no JSON.
#[wasm_bindgen]
pub fn edited(machine: &str, key: &str, value: &str) -> Option<String> {
    project::edited(machine, key, value)
}

/// All that the simulation reads of the machine of a filled form, as text to be compared; none
/// where the form has faults.
#[wasm_bindgen(js_name = motionOf)]
pub fn motion_of(machine: &str) -> Option<String> {
    machine_from_form(machine).ok().map(|machine| motion_of_machine(&machine))
}

/// Price of a cycle time (s) on the machine of a filled form; none where the form has faults.
#[wasm_bindgen]
pub fn price(machine: &str, cycle_time: f64) -> Option<f64> {
    machine_from_form(machine).ok().map(|machine| quote::price(cycle_time, &machine))
}

/// The tolerances to begin with, mm.
#[wasm_bindgen(js_name = usualTolerances)]
pub fn usual_tolerances() -> Vec<f64> {
    USUAL_TOLERANCES.to_vec()
}

/// The tolerance (mm) a text names; throws the reason as a string where it names none.
#[wasm_bindgen(js_name = toleranceFromText)]
pub fn tolerance_from(text: &str) -> Result<f64, String> {
    tolerance_from_text(text).map_err(|error| error.to_string())
}

/// How a tolerance (mm) is shown.
#[wasm_bindgen(js_name = toleranceLabel)]
pub fn label_of_tolerance(tolerance: f64) -> String {
    tolerance_label(tolerance)
}

/// How a distance from the path (mm) is shown.
#[wasm_bindgen(js_name = deviationLabel)]
pub fn label_of_deviation(deviation: f64) -> String {
    deviation_label(deviation)
}

/// How a time lost (s) is shown.
#[wasm_bindgen(js_name = lostLabel)]
pub fn label_of_lost(seconds: f64) -> String {
    project::lost_label(seconds)
}

/// What a file is, by its beginning: `program`, `recording`, `settings`, or the name of what cannot be used.
#[wasm_bindgen(js_name = fileKind)]
pub fn file_kind(head: &[u8]) -> String {
    let kind = match project::file_kind(head) {
        FileKind::Program => "program",
        FileKind::Recording => "recording",
        FileKind::Settings => "settings",
        FileKind::Other(name) => name,
    };
    kind.to_string()
}

/// How many bytes of a file are enough to tell.
#[wasm_bindgen(js_name = sniffedBytes)]
pub fn sniffed_bytes() -> usize {
    recording::SNIFFED_BYTES
}

/// How many curves one chart tells apart by colour.
#[wasm_bindgen(js_name = mostCurves)]
pub fn most_curves() -> usize {
    PALETTE
}
