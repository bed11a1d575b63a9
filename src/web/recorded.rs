//! Recordings beside their programs: compared one at a time, and several of them to calibrate a machine.

use js_sys::Function;
use wasm_bindgen::prelude::*;

use crate::identification::calibration::calibrate;
use crate::identification::comparison::{Course, Pointwise, compare, course, pointwise};
use crate::identification::diagnosis::ModelError;
use crate::identification::fit::{Recorded, Run};
use crate::machine::Machine;
use crate::project::{CalibrationReport, ComparisonReport, Refusal, faults_to_json, machine_from_form};
use crate::simulation::profile::Profile;
use crate::web::job::object;
use crate::web::traced::toolpath;

/// A recording on its program.
fn recorded(
    program: &[u8],
    dialect: Option<String>,
    recording: &[u8],
    machine: &Machine,
) -> Result<Recorded, Refusal> {
    Recorded::new(toolpath(program, dialect, machine), recording, machine)
        .map_err(|error| Refusal::from(&error))
}

/// A recording beside the simulation.
#[wasm_bindgen(getter_with_clone)]
pub struct Matched {
    /// The comparison as an object, or undefined where it is refused.
    pub report: JsValue,
    /// Why it is refused, or undefined.
    pub refusal: JsValue,
    /// The curves; empty where it is refused.
    pub columns: MatchedColumns,
}

/// The curves of a comparison: distances in mm, feedrates in mm/s, times in s.
#[wasm_bindgen(getter_with_clone)]
#[derive(Clone, Default)]
pub struct MatchedColumns {
    /// Where the recorded feedrate is known.
    #[wasm_bindgen(js_name = recordedDistance)]
    pub recorded_distance: Vec<f64>,
    /// The feedrate there.
    #[wasm_bindgen(js_name = recordedFeedrate)]
    pub recorded_feedrate: Vec<f64>,
    /// When, since the first place that both have a time for.
    #[wasm_bindgen(js_name = recordedTime)]
    pub recorded_time: Vec<f64>,
    /// The simulated profile.
    #[wasm_bindgen(js_name = simulatedDistance)]
    pub simulated_distance: Vec<f64>,
    /// Its feedrate.
    #[wasm_bindgen(js_name = simulatedFeedrate)]
    pub simulated_feedrate: Vec<f64>,
    /// Its time.
    #[wasm_bindgen(js_name = simulatedTime)]
    pub simulated_time: Vec<f64>,
    /// Where the time lost is known.
    #[wasm_bindgen(js_name = lostDistance)]
    pub lost_distance: Vec<f64>,
    /// The time lost up to there.
    #[wasm_bindgen(js_name = lostSeconds)]
    pub lost_seconds: Vec<f64>,
}

/// Compares a recording with the simulation of a program on the machine of a filled form, at the
/// program's own tolerances or else the machine's; throws the form's faults as JSON.
#[wasm_bindgen(js_name = compareRecording)]
pub fn compare_recording(
    program: &[u8],
    machine: &str,
    dialect: Option<String>,
    recording: &[u8],
) -> Result<Matched, JsError> {
    let machine = machine_from_form(machine).map_err(|faults| JsError::new(&faults_to_json(&faults)))?;
    let aligned = match recorded(program, dialect, recording, &machine) {
        Ok(aligned) => aligned,
        Err(refusal) => {
            let refusal = object(&refusal)?;
            return Ok(Matched { report: JsValue::UNDEFINED, refusal, columns: MatchedColumns::default() });
        }
    };
    let Recorded { toolpath, log, alignment, switches } = &aligned;
    let plan = aligned.run().plan(&machine);
    let comparison = compare(toolpath, &plan, alignment);
    let curve = Profile::new(toolpath, &plan).drawn();
    let Pointwise { distance, recorded_time, recorded, .. } = pointwise(toolpath, &plan, alignment);
    let Course { distance: lost_distance, seconds: lost_seconds } = course(toolpath, alignment, &comparison);
    let begin = alignment.marks.first().map_or(0.0, |mark| mark.time);
    let report = ComparisonReport::new(log, switches, toolpath, alignment, &comparison);
    Ok(Matched {
        report: object(&report.drawn_by(&curve))?,
        refusal: JsValue::UNDEFINED,
        columns: MatchedColumns {
            recorded_distance: distance,
            recorded_feedrate: recorded,
            recorded_time: recorded_time.into_iter().map(|time| time - begin).collect(),
            simulated_distance: curve.distance,
            simulated_feedrate: curve.feedrate,
            simulated_time: curve.time,
            lost_distance,
            lost_seconds,
        },
    })
}

/// Runs of one machine, collected to calibrate it, or to say what was left out of it.
#[wasm_bindgen]
pub struct Runs {
    pub(super) machine: Machine,
    pub(super) names: Vec<String>,
    pub(super) aligned: Vec<Recorded>,
}

#[wasm_bindgen]
impl Runs {
    /// No runs yet of the machine of a filled form; throws the form's faults as JSON.
    #[wasm_bindgen(constructor)]
    pub fn new(machine: &str) -> Result<Runs, JsError> {
        let machine = machine_from_form(machine).map_err(|faults| JsError::new(&faults_to_json(&faults)))?;
        Ok(Runs { machine, names: Vec::new(), aligned: Vec::new() })
    }

    /// Adds a run under a name; says whether it could be compared.
    pub fn add(&mut self, name: String, program: &[u8], dialect: Option<String>, recording: &[u8]) -> bool {
        let Ok(aligned) = recorded(program, dialect, recording, &self.machine) else { return false };
        self.names.push(name);
        self.aligned.push(aligned);
        true
    }

    /// Calibrates the machine; undefined where there are no runs. `progress` is called with the part that
    /// is done.
    pub fn calibrate(&self, progress: &Function) -> Result<JsValue, JsError> {
        if self.aligned.is_empty() {
            return Ok(JsValue::UNDEFINED);
        }
        let runs: Vec<Run> = self.aligned.iter().map(Recorded::run).collect();
        let mut tell = |part: f64| drop(progress.call1(&JsValue::NULL, &part.into()));
        let calibration = calibrate(&self.machine, &runs, &mut tell);
        let error = ModelError::of(&calibration.machine, &runs);
        object(&CalibrationReport::new(&self.machine, &calibration, error, &self.names))
    }
}
