//! Comparison of two revisions of a program.

use wasm_bindgen::prelude::*;

use crate::project::{RevisedSide, RevisionsReport, faults_to_json};
use crate::quote::{Revision, revisions};
use crate::simulation::feed::FeedPlan;
use crate::simulation::gcode::read_with;
use crate::simulation::interpreter::trace;
use crate::simulation::simulate;
use crate::simulation::toolpath::Toolpath;
use crate::web::job::object;
use crate::web::text::ProgramText;

/// The differences between two revisions.
#[wasm_bindgen(getter_with_clone, js_name = RevisedPrograms)]
pub struct RevisionsResult {
    /// The report as an object.
    pub report: JsValue,
    /// Delay of the second against the first, along its path.
    pub columns: DelayColumns,
}

/// Distances in mm, times in s.
#[wasm_bindgen(getter_with_clone, js_name = RevisedColumns)]
#[derive(Clone)]
pub struct DelayColumns {
    /// Distances along the path of the second.
    pub distance: Vec<f64>,
    /// Delay at each distance.
    pub later: Vec<f64>,
}

/// Compares two revisions of a program, each with the machine, the dialect and the tolerance of its side in a
/// JSON list of two; throws their faults as JSON.
#[wasm_bindgen(js_name = compareRevisions)]
pub fn compare_revisions(
    first: ProgramText,
    second: ProgramText,
    sides: &str,
) -> Result<RevisionsResult, JsError> {
    let sides = RevisedSide::both(sides).map_err(|faults| JsError::new(&faults_to_json(&faults)))?;
    let texts = [first.bytes, second.bytes];
    let planned = |side: usize| -> (Toolpath, FeedPlan) {
        let (machine, options, tolerances) = &sides[side];
        let toolpath = trace(&read_with(&texts[side], options), machine);
        let (plan, _) = simulate::within(&toolpath, machine, *tolerances, &mut |_| {});
        (toolpath, plan)
    };
    let both = [planned(0), planned(1)];
    let of = |side: usize| {
        let (toolpath, plan) = &both[side];
        Revision { text: &texts[side], toolpath, plan }
    };
    let found = revisions(&of(0), &of(1));
    Ok(RevisionsResult {
        report: object(&RevisionsReport::new(&found))?,
        columns: DelayColumns { distance: found.distance, later: found.later },
    })
}
