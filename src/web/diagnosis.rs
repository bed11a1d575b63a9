//! The diagnosis of the collected runs: the report, its documents, and the curves before and after.

use js_sys::Function;
use wasm_bindgen::prelude::*;

use crate::identification::diagnosis::diagnose;
use crate::identification::fit::{AlignedRun, Run};
use crate::identification::measured::measure;
use crate::plot::FeedChart;
use crate::project::{DiagnosisReport, RunChart, diagnosis_chart, machine_from_form};
use crate::quote::quote;
use crate::simulation::feed::Tolerances;
use crate::simulation::simulate;
use crate::web::job::object;
use crate::web::program_path::toolpath;
use crate::web::recordings::RunCollection;
use crate::web::theme::theme;

/// Returns the placeholder in the document for the chart of a run.
#[wasm_bindgen(js_name = markOfChart)]
pub fn mark(run: usize) -> String {
    format!("<!--chart {run}-->")
}

/// A diagnosis.
#[wasm_bindgen(getter_with_clone, js_name = Diagnosed)]
pub struct DiagnosisResult {
    /// The report as an object.
    pub report: JsValue,
    /// Report as JSON.
    pub json: String,
    /// Report as an HTML document, with a comment, [`mark`], in place of the chart of each run: a worker
    /// cannot measure text.
    pub html: String,
    /// Curves of each run.
    pub runs: Vec<DiagnosisColumns>,
}

/// The curves of a run: distances in mm, feedrates in mm/s, times in s.
#[wasm_bindgen(getter_with_clone, js_name = DiagnosedColumns)]
#[derive(Clone, Default)]
pub struct DiagnosisColumns {
    /// End of each segment of the program.
    pub end: Vec<f64>,
    /// Programmed feedrate of each segment.
    pub feedrate: Vec<f64>,
    /// 1 for rapid moves, 0 for others.
    pub rapid: Vec<u8>,
    /// Line of each segment.
    pub line: Vec<u32>,
    /// Distances of the recorded curve, the simulated one, and the simulated one with the causes.
    pub distances: Vec<js_sys::Float64Array>,
    /// Feedrates of these curves.
    pub feedrates: Vec<js_sys::Float64Array>,
    /// Times of these curves.
    pub times: Vec<js_sys::Float64Array>,
    /// Distances of the time lost, before and after.
    #[wasm_bindgen(js_name = lostDistances)]
    pub lost_distances: Vec<js_sys::Float64Array>,
    /// Time lost up to each of these distances.
    #[wasm_bindgen(js_name = lostSeconds)]
    pub lost_seconds: Vec<js_sys::Float64Array>,
}

impl From<FeedChart> for DiagnosisColumns {
    fn from(chart: FeedChart) -> DiagnosisColumns {
        let column = |rows: &[f64]| js_sys::Float64Array::from(rows);
        let lost = || [&chart.lost, &chart.lost_after].into_iter().flatten();
        DiagnosisColumns {
            distances: chart.curves.iter().map(|curve| column(&curve.distance)).collect(),
            feedrates: chart.curves.iter().map(|curve| column(&curve.feedrate)).collect(),
            times: chart.curves.iter().map(|curve| column(&curve.time)).collect(),
            lost_distances: lost().map(|lost| column(&lost.distance)).collect(),
            lost_seconds: lost().map(|lost| column(&lost.seconds)).collect(),
            end: chart.programmed.end,
            feedrate: chart.programmed.feedrate.to_vec(),
            rapid: chart.programmed.rapid.iter().map(|rapid| u8::from(*rapid)).collect(),
            line: chart.programmed.line,
        }
    }
}

#[wasm_bindgen(js_class = Runs)]
impl RunCollection {
    /// Diagnoses the machine; undefined without runs. Calls `progress` with the completed fraction, 0 to 1.
    pub fn diagnose(&self, progress: &Function) -> Result<Option<DiagnosisResult>, JsError> {
        if self.aligned.is_empty() {
            return Ok(None);
        }
        // Recorded switches are ignored, so that the diagnosis finds the operator's actions with or without
        // them.
        let runs: Vec<Run> = self.aligned.iter().map(AlignedRun::run_ignoring_overrides).collect();
        let mut tell = |part: f64| drop(progress.call1(&JsValue::NULL, &part.into()));
        let diagnosis = diagnose(&self.machine, &runs, &mut tell);
        let charts: Vec<RunChart> =
            (0..runs.len()).filter_map(|at| diagnosis_chart(&diagnosis, &self.machine, &runs, at)).collect();
        let report = DiagnosisReport::new(&diagnosis, &self.names).beside(&self.machine).drawn_by(&charts);
        let measured = measure(&diagnosis.machine, &runs);
        let report = report.aligned(&self.aligned[0].alignment).measured(&measured);
        Ok(Some(DiagnosisResult {
            report: object(&report)?,
            json: report.to_json(),
            html: report.to_html(&(0..charts.len()).map(mark).collect::<Vec<_>>(), &theme(false)),
            runs: charts.into_iter().map(|drawn| drawn.chart.into()).collect(),
        }))
    }
}

/// Returns the cycle time (s) of a program on the machine of a filled form, at the program's tolerances,
/// or the machine's where the program sets none; throws the faults of the form.
#[wasm_bindgen(js_name = cycleTime)]
pub fn cycle_time(program: &[u8], machine: &str, dialect: Option<String>) -> Result<f64, String> {
    let machine = machine_from_form(machine)
        .map_err(|faults| faults.iter().map(|fault| fault.to_string()).collect::<Vec<_>>().join("; "))?;
    let toolpath = toolpath(program, dialect, &machine);
    let (plan, errors) = simulate::within(&toolpath, &machine, Tolerances::Programmed, &mut |_| {});
    Ok(quote(&toolpath, &machine, &plan, Tolerances::Programmed, &errors).cycle_time)
}
