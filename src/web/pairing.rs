//! Matching: the program that a recording was run from.

use wasm_bindgen::prelude::*;

use crate::identification::alignment::{Pairing, pair};
use crate::identification::recording::{ReadingOptions, read_with};
use crate::machine::Machine;
use crate::project::{faults_to_json, machine_from_form};
use crate::simulation::toolpath::Toolpath;
use crate::web::program_path::toolpath;

/// Programs that recordings may belong to, on one machine.
#[wasm_bindgen]
pub struct Candidates {
    machine: Machine,
    programs: Vec<Toolpath>,
}

#[wasm_bindgen]
impl Candidates {
    /// Returns an empty list on the machine of a filled form; throws the form's faults as JSON.
    #[wasm_bindgen(constructor)]
    pub fn new(machine: &str) -> Result<Candidates, JsError> {
        let machine = machine_from_form(machine).map_err(|faults| JsError::new(&faults_to_json(&faults)))?;
        Ok(Candidates { machine, programs: Vec::new() })
    }

    /// Adds a program.
    pub fn add(&mut self, program: &[u8], dialect: Option<String>) {
        self.programs.push(toolpath(program, dialect, &self.machine));
    }

    /// Returns the indices of the programs that a recording can belong to: one, several that it cannot
    /// distinguish, or none. `interval_s` is the time between its rows if the file does not state it.
    pub fn of(&self, recording: &[u8], interval_s: Option<f64>) -> Vec<usize> {
        let Ok(log) = read_with(recording, &ReadingOptions::at_interval(interval_s)) else {
            return Vec::new();
        };
        let programs: Vec<&Toolpath> = self.programs.iter().collect();
        match pair(&log, &programs, &self.machine) {
            Pairing::Of(index) => vec![index],
            Pairing::OneOf(indices) => indices,
            Pairing::None(_) => Vec::new(),
        }
    }
}
