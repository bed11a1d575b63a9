//! A quote in one call, for pages that embed it and for Node: a program and a request in, a prediction out.

use js_sys::Function;
use wasm_bindgen::prelude::*;

use crate::project::{Prediction, QuoteRequest, RequestError};
use crate::quote::{programmed_time, quote};
use crate::simulation::gcode::Options;
use crate::simulation::simulate;
use crate::simulation::toolpath::trace_text;
use crate::web::job::object;
use crate::web::text::ProgramText;

/// Quotes a program as a request in JSON asks for ([`QuoteRequest`]): what `predict --json` prints, as
/// an object. `progress` is called with the part done. Throws a refusal as JSON: kind, message and faults.
#[wasm_bindgen(js_name = quoteProgram)]
pub fn quote_program(program: Vec<u8>, request: &str, progress: &Function) -> Result<JsValue, JsValue> {
    quote_text(program.into(), request, progress)
}

/// The same for a text that came piece by piece.
#[wasm_bindgen(js_name = quoteText)]
pub fn quote_text(program: ProgramText, request: &str, progress: &Function) -> Result<JsValue, JsValue> {
    let refused = |error: RequestError| JsValue::from(error.to_json());
    let QuoteRequest { name, machine, tolerances, dialect } =
        QuoteRequest::from_json(request).map_err(refused)?;
    let toolpath = trace_text(program.bytes, &Options { dialect, ..Options::default() }, &machine);
    let of = tolerances.len() as f64;
    let quotes = tolerances.iter().enumerate().map(|(index, &tolerance)| {
        // What a listener throws is its own affair.
        let mut tell = |part: f64| drop(progress.call1(&JsValue::NULL, &((index as f64 + part) / of).into()));
        tell(0.0);
        let (plan, errors) = simulate::within(&toolpath, &machine, tolerance, &mut tell);
        quote(&toolpath, &machine, &plan, tolerance, &errors)
    });
    let quotes: Vec<_> = quotes.collect();
    let programmed = programmed_time(&toolpath, &machine);
    Ok(object(&Prediction::new(&name, &toolpath, programmed, &quotes))?)
}
