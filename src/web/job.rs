//! A program on a machine, simulated at its tolerances and at others.

use js_sys::Function;
use serde::Serialize;
use serde_wasm_bindgen::Serializer;
use wasm_bindgen::prelude::*;

use crate::machine::Machine;
use crate::plot::Programmed;
use crate::plot::path::{SteppedCurve, Trail};
use crate::project::{
    Prediction, ToleranceRangeRow, faults_to_json, machine_from_form, spacing_note, time_loss_texts,
};
use crate::quote::{programmed_time, quote};
use crate::simulation::feed::Tolerances;
use crate::simulation::gcode::Options;
use crate::simulation::profile::Profile;
use crate::simulation::simulate;
use crate::simulation::toolpath::Toolpath;
use crate::units::LengthUnit;
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
    /// Reads a program for a machine given as a filled form, in the dialect of this keyword, or in the
    /// dialect detected from the program; undefined if that needs the whole module. Throws the form's faults
    /// as JSON.
    pub fn of(program: ProgramText, machine: &str, dialect: Option<String>) -> Result<Option<Job>, String> {
        let machine = machine_from_form(machine).map_err(|faults| faults_to_json(&faults))?;
        let options = Options::from_words(&dialect.unwrap_or_default());
        let toolpath = path_of(program.bytes, &options, &machine);
        Ok(toolpath.map(|toolpath| Job { machine, toolpath }))
    }

    /// Returns a prediction without runs, with everything that is known before a simulation.
    pub fn summary(&self) -> Result<JsValue, JsError> {
        object(&Prediction::new("", &self.toolpath, self.programmed_time(), &[]))
    }

    /// Returns the programmed feedrate over distance.
    pub fn steps(&self) -> ProgrammedColumns {
        let (end, feedrate, rapid, line) = Programmed::columns(&self.toolpath, &self.machine);
        ProgrammedColumns { end, feedrate, rapid: rapid.into_iter().map(u8::from).collect(), line }
    }

    /// Returns the path in space.
    pub fn trail(&self) -> TrailColumns {
        Trail::of(&self.toolpath).into()
    }

    /// Returns the ranges of the program's tolerances; an empty list if it sets none.
    pub fn tolerances(&self) -> Result<JsValue, JsError> {
        let held = Tolerances::Programmed.ranges(&self.toolpath, &self.machine);
        object(&held.iter().map(ToleranceRangeRow::from).collect::<Vec<_>>())
    }

    /// Returns the cycle time (s) at a contour tolerance (mm), or at the tolerances of the program if none is
    /// given.
    #[wasm_bindgen(js_name = cycleTime)]
    pub fn cycle_time(&self, tolerance: Option<f64>) -> f64 {
        let tolerances = tolerance.map_or(Tolerances::Programmed, Tolerances::One);
        simulate::cycle_time_within(&self.toolpath, &self.machine, tolerances, &mut |_| {})
    }

    /// Simulates the program at a contour tolerance (mm), or at the tolerances of the program if none is
    /// given; calls `progress` with the completed fraction, 0 to 1.
    pub fn simulate(&self, tolerance: Option<f64>, progress: &Function) -> Result<SimulationResult, JsError> {
        let tolerances = tolerance.map_or(Tolerances::Programmed, Tolerances::One);
        // An exception of a listener does not stop the computation.
        let mut tell = |part: f64| drop(progress.call1(&JsValue::NULL, &part.into()));
        let (plan, errors) = simulate::within(&self.toolpath, &self.machine, tolerances, &mut tell);
        let quote = quote(&self.toolpath, &self.machine, &plan, tolerances, &errors);
        let curve = Profile::new(&self.toolpath, &plan).drawn();
        let SteppedCurve { end: pace_end, value: pace_feedrate } = SteppedCurve::of(&curve);
        let (arcs, along_arcs) = errors.arc.into_columns();
        Ok(SimulationResult {
            note: spacing_note(curve.spacing),
            places_in_inches: time_loss_texts(&quote.lost, LengthUnit::Inch),
            summary: object(&Prediction::new("", &Toolpath::default(), self.programmed_time(), &[quote]))?,
            columns: ProfileColumns {
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

/// Returns a result as a JavaScript object with the fields of its JSON.
pub(super) fn object(result: &impl Serialize) -> Result<JsValue, JsError> {
    Ok(result.serialize(&Serializer::json_compatible())?)
}

/// The result of one simulation.
#[wasm_bindgen(getter_with_clone, js_name = Run)]
pub struct SimulationResult {
    /// Times and price: a prediction with one run.
    pub summary: JsValue,
    /// The profile.
    pub columns: ProfileColumns,
    /// Sentence on the features that the profile leaves out; undefined if it is complete.
    pub note: Option<String>,
    /// Texts of the places that lose most time, with lengths in inches: the summary has them in mm.
    #[wasm_bindgen(js_name = placesInInches)]
    pub places_in_inches: Vec<String>,
}

/// A profile over distance and its contour errors, as columns.
#[wasm_bindgen(getter_with_clone, js_name = Columns)]
#[derive(Clone)]
pub struct ProfileColumns {
    /// Distance along the path, mm.
    pub distance: Vec<f64>,
    /// Feedrate, mm/s.
    pub feedrate: Vec<f64>,
    /// Time since the start, s; of the same length as distance and feedrate.
    pub time: Vec<f64>,
    /// Contour error at the corner that ends each segment and on arcs near it, mm.
    pub corner: Vec<f64>,
    /// Indices of the arcs with an error along them.
    pub arcs: Vec<u32>,
    /// Largest error along each of these arcs, away from its corners, mm.
    #[wasm_bindgen(js_name = alongArcs)]
    pub along_arcs: Vec<f64>,
    /// Ends of the steps of feedrate that colour the path, mm.
    #[wasm_bindgen(js_name = paceEnd)]
    pub pace_end: Vec<f64>,
    /// Feedrate of each step that colours the path, mm/s.
    #[wasm_bindgen(js_name = paceFeedrate)]
    pub pace_feedrate: Vec<f64>,
}

/// The programmed feedrate, one row per segment.
#[wasm_bindgen(getter_with_clone, js_name = Steps)]
pub struct ProgrammedColumns {
    /// Distance along the path at which the segment ends, mm.
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
