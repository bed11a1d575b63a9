//! Recordings with their programs: compared one at a time, and collected to calibrate a machine.

use js_sys::Function;
use wasm_bindgen::prelude::*;

use crate::identification::calibration::calibrate;
use crate::identification::comparison::{LostTimeCurve, Pointwise, compare, lost_time_curve, pointwise};
use crate::identification::diagnosis::ModelError;
use crate::identification::fit::{AlignedRun, Run};
use crate::identification::measured::{calibrated_on, measure};
use crate::identification::recording::ReadingOptions;
use crate::machine::Machine;
use crate::project::{
    CalibrationReport, ComparisonRefusal, ComparisonReport, MoveReport, faults_to_json, machine_from_form,
};
use crate::simulation::profile::Profile;
use crate::web::job::object;
use crate::web::program_path::toolpath;

/// Aligns a recording with its program.
fn recorded(
    program: &[u8],
    dialect: Option<String>,
    recording: &[u8],
    interval_s: Option<f64>,
    machine: &Machine,
) -> Result<AlignedRun, ComparisonRefusal> {
    let options = ReadingOptions::at_interval(interval_s);
    AlignedRun::with(toolpath(program, dialect, machine), recording, &options, machine)
        .map_err(|error| ComparisonRefusal::from(&error))
}

/// Identifies the filters of a machine from the recording of one straight move from rest to rest. Returns the machine of
/// a filled form with these filters, and the summary; throws the form's faults as JSON, or the reason why no filters
/// were identified.
#[wasm_bindgen(js_name = filtersOfMove)]
pub fn filters_of_move(machine: &str, name: &str, recording: &[u8]) -> Result<JsValue, JsError> {
    let machine = machine_from_form(machine).map_err(|faults| JsError::new(&faults_to_json(&faults)))?;
    let report = MoveReport::read(recording, &ReadingOptions::default(), name);
    object(&report.map_err(|reason| JsError::new(&reason))?.on(&machine))
}

/// The comparison of a recording with the simulation.
#[wasm_bindgen(getter_with_clone, js_name = Matched)]
pub struct ComparisonResult {
    /// Comparison as an object; undefined if it is refused.
    pub report: JsValue,
    /// Reason of a refusal; undefined if there is none.
    pub refusal: JsValue,
    /// Curves; empty if the comparison is refused.
    pub columns: ComparisonColumns,
}

/// The curves of a comparison: distances in mm, feedrates in mm/s, times in s.
#[wasm_bindgen(getter_with_clone, js_name = MatchedColumns)]
#[derive(Clone, Default)]
pub struct ComparisonColumns {
    /// Distances of the recorded feedrate.
    #[wasm_bindgen(js_name = recordedDistance)]
    pub recorded_distance: Vec<f64>,
    /// Recorded feedrate.
    #[wasm_bindgen(js_name = recordedFeedrate)]
    pub recorded_feedrate: Vec<f64>,
    /// Recorded time, since the first place with a time in both.
    #[wasm_bindgen(js_name = recordedTime)]
    pub recorded_time: Vec<f64>,
    /// Distances of the simulated feedrate.
    #[wasm_bindgen(js_name = simulatedDistance)]
    pub simulated_distance: Vec<f64>,
    /// Simulated feedrate.
    #[wasm_bindgen(js_name = simulatedFeedrate)]
    pub simulated_feedrate: Vec<f64>,
    /// Simulated time.
    #[wasm_bindgen(js_name = simulatedTime)]
    pub simulated_time: Vec<f64>,
    /// Distances of the time lost.
    #[wasm_bindgen(js_name = lostDistance)]
    pub lost_distance: Vec<f64>,
    /// Time lost.
    #[wasm_bindgen(js_name = lostSeconds)]
    pub lost_seconds: Vec<f64>,
}

/// Compares a recording with the simulation of a program on the machine of a filled form, at the program's
/// tolerances, or the machine's where the program sets none; throws the form's faults as JSON. `interval_s` is the
/// time between the rows of the recording if its file does not state it.
#[wasm_bindgen(js_name = compareRecording)]
pub fn compare_recording(
    program: &[u8],
    machine: &str,
    dialect: Option<String>,
    recording: &[u8],
    interval_s: Option<f64>,
) -> Result<ComparisonResult, JsError> {
    let machine = machine_from_form(machine).map_err(|faults| JsError::new(&faults_to_json(&faults)))?;
    let aligned = match recorded(program, dialect, recording, interval_s, &machine) {
        Ok(aligned) => aligned,
        Err(refusal) => {
            let refusal = object(&refusal)?;
            return Ok(ComparisonResult {
                report: JsValue::UNDEFINED,
                refusal,
                columns: ComparisonColumns::default(),
            });
        }
    };
    let AlignedRun { toolpath, log, alignment, switches } = &aligned;
    let plan = aligned.run().plan(&machine);
    let comparison = compare(toolpath, &plan, alignment);
    let curve = Profile::new(toolpath, &plan).drawn();
    let Pointwise { distance, recorded_time, recorded, .. } = pointwise(toolpath, &plan, alignment);
    let LostTimeCurve { distance: lost_distance, seconds: lost_seconds } =
        lost_time_curve(toolpath, alignment, &comparison);
    let begin = alignment.marks.first().map_or(0.0, |mark| mark.time);
    let report = ComparisonReport::new(log, switches, toolpath, alignment, &comparison);
    Ok(ComparisonResult {
        report: object(&report.drawn_by(&curve))?,
        refusal: JsValue::UNDEFINED,
        columns: ComparisonColumns {
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

/// Runs of one machine, collected for a calibration or a diagnosis.
#[wasm_bindgen(js_name = Runs)]
pub struct RunCollection {
    pub(super) machine: Machine,
    pub(super) names: Vec<String>,
    pub(super) aligned: Vec<AlignedRun>,
}

#[wasm_bindgen(js_class = Runs)]
impl RunCollection {
    /// Returns an empty collection for the machine of a filled form; throws the form's faults as JSON.
    #[wasm_bindgen(constructor)]
    pub fn new(machine: &str) -> Result<RunCollection, JsError> {
        let machine = machine_from_form(machine).map_err(|faults| JsError::new(&faults_to_json(&faults)))?;
        Ok(RunCollection { machine, names: Vec::new(), aligned: Vec::new() })
    }

    /// Adds a run with a name; returns `true` if the run could be compared. `interval_s` is as for a comparison.
    pub fn add(
        &mut self,
        name: String,
        program: &[u8],
        dialect: Option<String>,
        recording: &[u8],
        interval_s: Option<f64>,
    ) -> bool {
        let Ok(aligned) = recorded(program, dialect, recording, interval_s, &self.machine) else {
            return false;
        };
        self.names.push(name);
        self.aligned.push(aligned);
        true
    }

    /// Calibrates the machine; undefined without runs. Calls `progress` with the completed fraction, 0 to 1.
    pub fn calibrate(&self, progress: &Function) -> Result<JsValue, JsError> {
        if self.aligned.is_empty() {
            return Ok(JsValue::UNDEFINED);
        }
        let runs: Vec<Run> = self.aligned.iter().map(AlignedRun::run).collect();
        let mut tell = |part: f64| drop(progress.call1(&JsValue::NULL, &part.into()));
        let mut calibration = calibrate(&self.machine, &runs, &mut tell);
        let error = ModelError::of(&calibration.machine, &runs);
        let measured = measure(&calibration.machine, &runs);
        calibration.machine.calibrated_on = calibrated_on(&calibration.machine, &runs, &calibration.fitted);
        object(&CalibrationReport::new(&self.machine, &calibration, error, &self.names).measured(&measured))
    }
}
