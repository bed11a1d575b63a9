//! A job as a file: the programs that make a part, their machines, and the terms of the quote.
//!
//! ```text
//! {"truefeed_job": 1, "name": "Bracket",
//!  "machine": MACHINE, "tolerance_mm": 0.01, "dialect": "siemens", "arc_centres": "absolute", "fixture": {"parts": 4},
//!  "terms": {"quantity": 25, "set_up_min": 30, "material": 4.2, …},
//!  "operations": [{"program": "op10.nc", "name": "Face", "set_up_min": 20, "loading_s": 45, …}, …],
//!  "offer": {"customer": "…", "number": "Q-17", "date": "2026-11-23", "tax_percent": 19, …},
//!  "company": {"name": "…", "address": "…", …}}
//! MACHINE = "mill.toml" | "name of a preset" | "text of a machine file" | {"preset": "name", "key": value, …}
//! ```
//!
//! An operation without machine, tolerance, dialect, arc centres, fixture, set-up or loading has those of the
//! job (set-up and loading in its terms). A tolerance of null means the tolerances of the program. Files are
//! relative to the folder of the job. Terms have the keys of their form. An operation may contain its program
//! as `text` instead of a file. `docs/job.schema.json` is a JSON Schema of the format.
//!
//! Only version 1 is read, and an unknown field is refused.

mod comparison;
mod costing_html;
mod csv;
mod fields;
mod file;
mod letter;
mod offer_html;
mod report;
mod result_html;
mod text;

pub use comparison::JobComparison;
pub use file::{JobFile, JobOperationFile, MachineSource};
pub use letter::letter_form;
pub use report::{JobReport, PlannedProgram};

#[cfg(test)]
mod report_tests;
#[cfg(test)]
mod schema_tests;
