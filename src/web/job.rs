//! A program on a machine, simulated for one tolerance after the other.

use wasm_bindgen::prelude::*;

use crate::machine::Machine;
use crate::plot::Programmed;
use crate::project;
use crate::quote;
use crate::simulation::feed;
use crate::simulation::gcode;
use crate::simulation::profile::Profile;
use crate::simulation::toolpath::{self, Toolpath};

/// A program traced on a machine, ready to be simulated.
#[wasm_bindgen]
pub struct Job {
    machine: Machine,
    toolpath: Toolpath,
}

#[wasm_bindgen]
impl Job {
    /// Reads a program for a machine given as JSON; throws the machine's faults as JSON text.
    #[wasm_bindgen(constructor)]
    pub fn new(program: &[u8], machine: &str) -> Result<Job, String> {
        let machine = project::machine_from_json(machine).map_err(|faults| project::faults_json(&faults))?;
        let toolpath = toolpath::trace(&gcode::read(program), &machine);
        Ok(Job { machine, toolpath })
    }

    /// What is known before any simulation, as JSON.
    pub fn summary(&self) -> String {
        project::program_json(&self.toolpath, &self.machine)
    }

    /// The programmed feedrate over distance.
    pub fn steps(&self) -> Steps {
        let Programmed { end, feedrate, rapid, line } = Programmed::of(&self.toolpath, &self.machine);
        Steps { end, feedrate, rapid: rapid.into_iter().map(u8::from).collect(), line }
    }

    /// Simulates the program for a contour tolerance (mm).
    pub fn simulate(&self, tolerance: f64) -> Run {
        let plan = feed::plan(&self.toolpath, &self.machine, tolerance);
        let profile = Profile::new(&self.toolpath, &plan);
        let samples = profile.samples();
        let summary = project::run_json(&quote::quote(&self.toolpath, &profile, &self.machine, tolerance));
        let columns = Columns { distance: samples.distance, feedrate: samples.feedrate, time: samples.time };
        Run { summary, columns }
    }
}

/// The result of one simulation.
#[wasm_bindgen(getter_with_clone)]
pub struct Run {
    /// Times and price as JSON.
    pub summary: String,
    /// The profile.
    pub columns: Columns,
}

/// A profile over distance as columns of equal length.
#[wasm_bindgen(getter_with_clone)]
#[derive(Clone)]
pub struct Columns {
    /// Distance along the path, mm.
    pub distance: Vec<f64>,
    /// Feedrate, mm/s.
    pub feedrate: Vec<f64>,
    /// Time since the start, s.
    pub time: Vec<f64>,
}

/// The programmed feedrate, one row a segment.
#[wasm_bindgen(getter_with_clone)]
pub struct Steps {
    /// Where the segment ends along the path, mm.
    pub end: Vec<f64>,
    /// Programmed feedrate, mm/s.
    pub feedrate: Vec<f64>,
    /// 1 for rapid moves, 0 for others.
    pub rapid: Vec<u8>,
    /// Line of the program.
    pub line: Vec<u32>,
}
