//! Cutting forces for the page: computed in the worker, drawn on their canvas.

use js_sys::Function;
use wasm_bindgen::prelude::*;
use web_sys::HtmlCanvasElement;

use crate::cutting::{engagement_with_progress, programmed_and_predicted};
use crate::plot::{LoadChart, LoadCurves, draw_loads, svg_of_loads};
use crate::project::{Prediction, cutting_from_toml, faults_to_json, machine_from_form};
use crate::quote::{programmed_time, quote};
use crate::simulation::feed::Tolerances;
use crate::simulation::profile::Profile;
use crate::simulation::simulate;
use crate::web::canvas::Canvas;
use crate::web::job::object;
use crate::web::program_path::toolpath;
use crate::web::theme::theme;

/// Returns an example of a cutting job, as text.
#[wasm_bindgen(js_name = exampleCutting)]
pub fn example_cutting() -> String {
    crate::project::EXAMPLE_CUTTING.to_string()
}

/// Returns the tools that the comments in the head of a program describe, as a JSON list: number, name,
/// diameter, teeth.
#[wasm_bindgen(js_name = toolsOf)]
pub fn tools_of(head: &[u8]) -> String {
    crate::project::described_tools_json(head)
}

/// Returns the materials of cutting jobs, with coefficients and sources, as JSON.
#[wasm_bindgen]
pub fn materials() -> String {
    crate::project::materials_json()
}

/// The demands of a cut on tool and spindle.
#[wasm_bindgen(getter_with_clone, js_name = Cut)]
pub struct CutResult {
    /// A prediction with one run.
    pub summary: JsValue,
    /// Loads along the path; empty if there are none.
    pub columns: LoadColumns,
}

/// Loads over distance, at the programmed and at the predicted feedrate.
#[wasm_bindgen(getter_with_clone)]
#[derive(Clone, Default)]
pub struct LoadColumns {
    /// Distance along the path, mm.
    pub distance: Vec<f64>,
    /// Force, N.
    #[wasm_bindgen(js_name = programmedForce)]
    pub programmed_force: Vec<f64>,
    /// Force, N.
    #[wasm_bindgen(js_name = predictedForce)]
    pub predicted_force: Vec<f64>,
    /// Power, W.
    #[wasm_bindgen(js_name = programmedPower)]
    pub programmed_power: Vec<f64>,
    /// Power, W.
    #[wasm_bindgen(js_name = predictedPower)]
    pub predicted_power: Vec<f64>,
    /// Removal rate, cm³/min.
    #[wasm_bindgen(js_name = programmedRate)]
    pub programmed_rate: Vec<f64>,
    /// Removal rate, cm³/min.
    #[wasm_bindgen(js_name = predictedRate)]
    pub predicted_rate: Vec<f64>,
    /// Feed per tooth, mm.
    #[wasm_bindgen(js_name = programmedPerTooth)]
    pub programmed_per_tooth: Vec<f64>,
    /// Feed per tooth, mm.
    #[wasm_bindgen(js_name = predictedPerTooth)]
    pub predicted_per_tooth: Vec<f64>,
}

/// Completed fraction after the simulation.
const SIMULATED_FRACTION: f64 = 0.1;
/// Completed fraction after the cut of the stock.
const STOCK_CUT_FRACTION: f64 = 0.5;

/// Returns the loads of a program that cuts the stock of a cutting job (text) on the machine of a filled
/// form; throws the fault of the job. Calls `progress` with the completed fraction, 0 to 1.
#[wasm_bindgen(js_name = computeCutting)]
pub fn compute_cutting(
    program: &[u8],
    machine: &str,
    dialect: Option<String>,
    tolerance: Option<f64>,
    job: &str,
    progress: &Function,
) -> Result<CutResult, String> {
    let machine = machine_from_form(machine).map_err(|faults| faults_to_json(&faults))?;
    let setup = cutting_from_toml(job, &machine).map_err(|fault| fault.to_string())?;
    let toolpath = toolpath(program, dialect, &machine);
    let tolerances = tolerance.map_or(Tolerances::Programmed, Tolerances::One);
    // An exception of a listener does not stop the computation.
    let tell = |part: f64| drop(progress.call1(&JsValue::NULL, &part.into()));
    let (plan, errors) =
        simulate::within(&toolpath, &machine, tolerances, &mut |part| tell(SIMULATED_FRACTION * part));
    let quote = quote(&toolpath, &machine, &plan, tolerances, &errors);
    let cut = engagement_with_progress(&toolpath, &setup, &mut |part| {
        tell(SIMULATED_FRACTION + (STOCK_CUT_FRACTION - SIMULATED_FRACTION) * part)
    });
    let curve = Profile::new(&toolpath, &plan).drawn();
    let loads: Vec<_> = cut
        .iter()
        .map(|cut| {
            let mut tell = |part: f64| tell(STOCK_CUT_FRACTION + (1.0 - STOCK_CUT_FRACTION) * part);
            programmed_and_predicted(cut, &toolpath, &setup, &curve, &mut tell)
        })
        .collect();
    let columns = match (&cut, loads.first()) {
        (Ok(cut), Some(Ok(both))) => LoadColumns::from(LoadChart::of(cut, both)),
        _ => LoadColumns::default(),
    };
    let time = programmed_time(&toolpath, &machine);
    // Remarks on the program itself are shown where it is simulated.
    let bare = crate::simulation::toolpath::Toolpath::default();
    let prediction = Prediction::new("", &bare, time, &[quote]).with_cutting(&setup, &cut, &loads);
    let summary = object(&prediction).map_err(|_| "the result has no form in JavaScript".to_string())?;
    Ok(CutResult { summary, columns })
}

impl From<LoadChart> for LoadColumns {
    fn from(chart: LoadChart) -> LoadColumns {
        LoadColumns {
            distance: chart.distance,
            programmed_force: chart.force.programmed.to_vec(),
            predicted_force: chart.force.predicted.to_vec(),
            programmed_power: chart.power.programmed.to_vec(),
            predicted_power: chart.power.predicted.to_vec(),
            programmed_rate: chart.removal_rate.programmed.to_vec(),
            predicted_rate: chart.removal_rate.predicted.to_vec(),
            programmed_per_tooth: chart.feed_per_tooth.programmed.to_vec(),
            predicted_per_tooth: chart.feed_per_tooth.predicted.to_vec(),
        }
    }
}

/// The chart of cutting loads on its canvas.
#[wasm_bindgen]
pub struct LoadPicture {
    chart: LoadChart,
}

#[wasm_bindgen]
impl LoadPicture {
    /// Returns a chart of loads; the columns are those of `LoadColumns`.
    #[wasm_bindgen(constructor)]
    pub fn new(
        distance: Vec<f64>,
        programmed_force: Vec<f64>,
        predicted_force: Vec<f64>,
        programmed_power: Vec<f64>,
        predicted_power: Vec<f64>,
        programmed_rate: Vec<f64>,
        predicted_rate: Vec<f64>,
    ) -> LoadPicture {
        let curves = |programmed: Vec<f64>, predicted: Vec<f64>| LoadCurves {
            programmed: programmed.into(),
            predicted: predicted.into(),
        };
        let chart = LoadChart {
            distance,
            force: curves(programmed_force, predicted_force),
            power: curves(programmed_power, predicted_power),
            removal_rate: curves(programmed_rate, predicted_rate),
            ..LoadChart::default()
        };
        LoadPicture { chart }
    }

    /// Draws the loads between two distances (mm) on a canvas of this size in CSS pixels; returns the left
    /// and right border of the plotting area in CSS pixels.
    #[allow(clippy::too_many_arguments)] // JavaScript has no tuples
    pub fn draw(
        &self,
        canvas: HtmlCanvasElement,
        width: f64,
        height: f64,
        ratio: f64,
        dark: bool,
        from: f64,
        to: f64,
    ) -> Result<Vec<f64>, String> {
        let backend = Canvas::sized(canvas, width, height, ratio)?;
        let (left, right) =
            draw_loads(&self.chart, (from, to.max(from + 1e-3)), &theme(dark), ratio, backend)
                .map_err(|error| error.to_string())?;
        Ok(vec![left / ratio, right / ratio])
    }

    /// Returns the chart as SVG for a document, dark on white; undefined if it cannot be drawn.
    pub fn svg(&self, width: u32, height: u32) -> Option<String> {
        svg_of_loads(&self.chart, &theme(false), (width, height))
    }

    /// Returns the loads at a distance (mm), as rows of programmed and predicted: force, power, removal rate.
    pub fn reading(&self, distance: f64) -> Vec<f64> {
        self.chart.reading(distance).into_iter().flatten().collect()
    }
}
