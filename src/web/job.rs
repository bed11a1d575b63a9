//! A program on a machine, simulated for its own tolerances and for one after the other.

use js_sys::Function;
use serde::Serialize;
use serde_wasm_bindgen::Serializer;
use wasm_bindgen::prelude::*;

use crate::machine::Machine;
use crate::plot::Programmed;
use crate::plot::path::{Pace, Trail};
use crate::project::{HeldTolerance, Prediction, faults_to_json, machine_from_form, spacing_note};
use crate::quote::{programmed_time, quote};
use crate::simulation::feed::Tolerances;
use crate::simulation::gcode::Options;
use crate::simulation::profile::Profile;
use crate::simulation::simulate;
use crate::simulation::toolpath::Toolpath;
use crate::web::path_of;
use crate::web::text::ProgramText;

/// A program traced on a machine, ready to be simulated.
#[wasm_bindgen]
pub struct Job {
    machine: Machine,
    toolpath: Toolpath,
}

#[wasm_bindgen]
impl Job {
    /// Reads a program for a machine given as a filled form, in the dialect of this word or in the
    /// one the program shows; none where that needs the whole module. Throws the form's faults as JSON.
    pub fn of(program: ProgramText, machine: &str, dialect: Option<String>) -> Result<Option<Job>, String> {
        let machine = machine_from_form(machine).map_err(|faults| faults_to_json(&faults))?;
        let options = Options::from_words(&dialect.unwrap_or_default());
        let toolpath = path_of(program.bytes, &options, &machine);
        Ok(toolpath.map(|toolpath| Job { machine, toolpath }))
    }

    /// What is known before any simulation: a prediction without runs.
    pub fn summary(&self) -> Result<JsValue, JsError> {
        object(&Prediction::new("", &self.toolpath, self.programmed_time(), &[]))
    }

    /// The programmed feedrate over distance.
    pub fn steps(&self) -> Steps {
        let (end, feedrate, rapid, line) = Programmed::columns(&self.toolpath, &self.machine);
        Steps { end, feedrate, rapid: rapid.into_iter().map(u8::from).collect(), line }
    }

    /// The path in space.
    pub fn trail(&self) -> TrailColumns {
        Trail::of(&self.toolpath).into()
    }

    /// Where each of the program's own tolerances holds; an empty list where it sets none.
    pub fn tolerances(&self) -> Result<JsValue, JsError> {
        let held = Tolerances::Programmed.held(&self.toolpath, &self.machine);
        object(&held.iter().map(HeldTolerance::from).collect::<Vec<_>>())
    }

    /// The cycle time (s) alone for a contour tolerance (mm), or for the program's own where there is none given.
    #[wasm_bindgen(js_name = cycleTime)]
    pub fn cycle_time(&self, tolerance: Option<f64>) -> f64 {
        let tolerances = tolerance.map_or(Tolerances::Programmed, Tolerances::One);
        simulate::cycle_time_within(&self.toolpath, &self.machine, tolerances, &mut |_| {})
    }

    /// Simulates the program for a contour tolerance (mm), or for its own where there is none given;
    /// `progress` is called with the part done.
    pub fn simulate(&self, tolerance: Option<f64>, progress: &Function) -> Result<Run, JsError> {
        let tolerances = tolerance.map_or(Tolerances::Programmed, Tolerances::One);
        // What a listener throws is its own affair.
        let mut tell = |part: f64| drop(progress.call1(&JsValue::NULL, &part.into()));
        let (plan, errors) = simulate::within(&self.toolpath, &self.machine, tolerances, &mut tell);
        let quote = quote(&self.toolpath, &self.machine, &plan, tolerances, &errors);
        let curve = Profile::new(&self.toolpath, &plan).drawn();
        let Pace { end: pace_end, value: pace_feedrate } = Pace::of(&curve);
        let (arcs, along_arcs) = errors.arc.into_columns();
        Ok(Run {
            note: spacing_note(curve.spacing),
            summary: object(&Prediction::new("", &Toolpath::default(), self.programmed_time(), &[quote]))?,
            columns: Columns {
                distance: curve.distance,
                feedrate: curve.feedrate,
                time: curve.time,
                corner: errors.corner,
                arcs,
                along_arcs,
                pace_end,
                pace_feedrate,
            },
        })
    }
}

impl Job {
    fn programmed_time(&self) -> f64 {
        programmed_time(&self.toolpath, &self.machine)
    }
}

/// A result as the object that its JSON would be read as.
pub(super) fn object(result: &impl Serialize) -> Result<JsValue, JsError> {
    Ok(result.serialize(&Serializer::json_compatible())?)
}

/// The result of one simulation.
#[wasm_bindgen(getter_with_clone)]
pub struct Run {
    /// Times and price: a prediction with one run.
    pub summary: JsValue,
    /// The profile.
    pub columns: Columns,
    /// What the profile leaves out, as a sentence; none where that is nothing.
    pub note: Option<String>,
}

/// A profile over distance and its contour errors, as columns.
#[wasm_bindgen(getter_with_clone)]
#[derive(Clone)]
pub struct Columns {
    /// Distance along the path, mm.
    pub distance: Vec<f64>,
    /// Feedrate, mm/s.
    pub feedrate: Vec<f64>,
    /// Time since the start, s; of the same length as distance and feedrate.
    pub time: Vec<f64>,
    /// Contour error at the corner that ends each segment and on arcs near it, mm.
    pub corner: Vec<f64>,
    /// The segments that are arcs along which there is an error, by index.
    pub arcs: Vec<u32>,
    /// The largest along each of these, away from its corners, mm.
    #[wasm_bindgen(js_name = alongArcs)]
    pub along_arcs: Vec<f64>,
    /// Where the steps of feedrate that colour the path end, mm.
    #[wasm_bindgen(js_name = paceEnd)]
    pub pace_end: Vec<f64>,
    /// Their feedrate, mm/s.
    #[wasm_bindgen(js_name = paceFeedrate)]
    pub pace_feedrate: Vec<f64>,
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

/// The trail of a program as columns.
#[wasm_bindgen(getter_with_clone)]
pub struct TrailColumns {
    /// X, Y and Z of each point in turn, mm.
    pub points: Vec<f32>,
    /// Distance of each point along the path, mm.
    pub distance: Vec<f64>,
}

impl From<Trail> for TrailColumns {
    fn from(trail: Trail) -> TrailColumns {
        TrailColumns { points: trail.points.into_flattened(), distance: trail.distance }
    }
}
