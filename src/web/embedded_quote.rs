//! A quote in one call, for pages that embed it and for Node: a program and a request in, a prediction out.

use js_sys::Function;
use wasm_bindgen::prelude::*;

use crate::project::{Prediction, QuoteRequest, RequestError};
use crate::quote::{programmed_time, quote};
use crate::simulation::gcode::Options;
use crate::simulation::interpreter::trace_text;
use crate::simulation::simulate;
use crate::web::job::object;
use crate::web::text::ProgramText;

/// Quotes a program as a request in JSON specifies ([`QuoteRequest`]); returns the object that `predict
/// --json` prints. Calls `progress` with the completed fraction, 0 to 1. Throws a refusal as JSON: kind,
/// message and faults.
#[wasm_bindgen(js_name = quoteProgram)]
pub fn quote_program(program: Vec<u8>, request: &str, progress: &Function) -> Result<JsValue, JsValue> {
    quote_text(program.into(), request, progress)
}

/// Quotes a text that arrived piece by piece, as [`quote_program`] does.
#[wasm_bindgen(js_name = quoteText)]
pub fn quote_text(program: ProgramText, request: &str, progress: &Function) -> Result<JsValue, JsValue> {
    let refused = |error: RequestError| JsValue::from(error.to_json());
    let QuoteRequest { name, machine, tolerances, dialect } =
        QuoteRequest::from_json(request).map_err(refused)?;
    let toolpath = trace_text(program.bytes, &Options { dialect, ..Options::default() }, &machine);
    let of = tolerances.len() as f64;
    let quotes = tolerances.iter().enumerate().map(|(index, &tolerance)| {
        // An exception of a listener does not stop the computation.
        let mut tell = |part: f64| drop(progress.call1(&JsValue::NULL, &((index as f64 + part) / of).into()));
        tell(0.0);
        let (plan, errors) = simulate::within(&toolpath, &machine, tolerance, &mut tell);
        quote(&toolpath, &machine, &plan, tolerance, &errors)
    });
    let quotes: Vec<_> = quotes.collect();
    let programmed = programmed_time(&toolpath, &machine);
    Ok(object(&Prediction::new(&name, &toolpath, programmed, &quotes))?)
}
