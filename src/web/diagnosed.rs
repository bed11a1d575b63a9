//! What was left out of a machine, from the runs collected: the report, its documents, and the curves before
//! and after.

use js_sys::Function;
use wasm_bindgen::prelude::*;

use crate::identification::diagnosis::diagnose;
use crate::identification::fit::{Recorded, Run};
use crate::plot::FeedChart;
use crate::project::{DiagnosisReport, RunChart, diagnosis_chart, machine_from_form};
use crate::quote::quote;
use crate::simulation::feed::Tolerances;
use crate::simulation::simulate;
use crate::web::job::object;
use crate::web::recorded::Runs;
use crate::web::traced::toolpath;

/// What stands in the document for the chart of a run.
#[wasm_bindgen(js_name = markOfChart)]
pub fn mark(run: usize) -> String {
    format!("<!--chart {run}-->")
}

/// A diagnosis.
#[wasm_bindgen(getter_with_clone)]
pub struct Diagnosed {
    /// The report as an object.
    pub report: JsValue,
    /// The same as JSON.
    pub json: String,
    /// The same as an HTML document; a comment, [`mark`], stands where the chart of each run belongs, because a
    /// worker cannot measure text.
    pub html: String,
    /// The curves, run by run.
    pub runs: Vec<DiagnosedColumns>,
}

/// The curves of a run: distances in mm, feedrates in mm/s, times in s.
#[wasm_bindgen(getter_with_clone)]
#[derive(Clone, Default)]
pub struct DiagnosedColumns {
    /// Where each segment of the program ends.
    pub end: Vec<f64>,
    /// Its programmed feedrate.
    pub feedrate: Vec<f64>,
    /// Whether it is a rapid move.
    pub rapid: Vec<u8>,
    /// Its line.
    pub line: Vec<u32>,
    /// Distances of the recorded, the simulated, and the simulated curve with the causes.
    pub distances: Vec<js_sys::Float64Array>,
    /// Their feedrates.
    pub feedrates: Vec<js_sys::Float64Array>,
    /// Their times.
    pub times: Vec<js_sys::Float64Array>,
    /// Where the time lost is known, before and after.
    #[wasm_bindgen(js_name = lostDistances)]
    pub lost_distances: Vec<js_sys::Float64Array>,
    /// The time lost up to there.
    #[wasm_bindgen(js_name = lostSeconds)]
    pub lost_seconds: Vec<js_sys::Float64Array>,
}

impl From<FeedChart> for DiagnosedColumns {
    fn from(chart: FeedChart) -> DiagnosedColumns {
        let column = |rows: &[f64]| js_sys::Float64Array::from(rows);
        let lost = || [&chart.lost, &chart.lost_after].into_iter().flatten();
        DiagnosedColumns {
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

#[wasm_bindgen]
impl Runs {
    /// Says what was left out of the machine; none where there are no runs. `progress` is called with the
    /// part that is done.
    pub fn diagnose(&self, progress: &Function) -> Result<Option<Diagnosed>, JsError> {
        if self.aligned.is_empty() {
            return Ok(None);
        }
        // What the operator did is to be found, whether or not a switch was recorded.
        let runs: Vec<Run> = self.aligned.iter().map(Recorded::unswitched).collect();
        let mut tell = |part: f64| drop(progress.call1(&JsValue::NULL, &part.into()));
        let diagnosis = diagnose(&self.machine, &runs, &mut tell);
        let charts: Vec<RunChart> =
            (0..runs.len()).filter_map(|at| diagnosis_chart(&diagnosis, &self.machine, &runs, at)).collect();
        let report = DiagnosisReport::new(&diagnosis, &self.names).beside(&self.machine).drawn_by(&charts);
        let report = report.aligned(&self.aligned[0].alignment);
        Ok(Some(Diagnosed {
            report: object(&report)?,
            json: report.to_json(),
            html: report.to_html(&(0..charts.len()).map(mark).collect::<Vec<_>>()),
            runs: charts.into_iter().map(|drawn| drawn.chart.into()).collect(),
        }))
    }
}

/// The cycle time (s) of a program on the machine of a filled form, at the program's own tolerances or else
/// the machine's; throws what is wrong with the form.
#[wasm_bindgen(js_name = cycleTime)]
pub fn cycle_time(program: &[u8], machine: &str, dialect: Option<String>) -> Result<f64, String> {
    let machine = machine_from_form(machine)
        .map_err(|faults| faults.iter().map(|fault| fault.to_string()).collect::<Vec<_>>().join("; "))?;
    let toolpath = toolpath(program, dialect, &machine);
    let (plan, errors) = simulate::within(&toolpath, &machine, Tolerances::Programmed, &mut |_| {});
    Ok(quote(&toolpath, &machine, &plan, Tolerances::Programmed, &errors).cycle_time)
}
