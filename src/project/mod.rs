//! All texts that enter or leave the program: machine files, the page's form, results.
//!
//! Only this module defines formats of files and messages, and so uses serde. Names contain their units here
//! (`cycle_time_s`), and values are converted through the parameter table
//! ([`PARAMETERS`](crate::machine::PARAMETERS)), so that the core uses mm, s and rad.

mod calibration;
mod cutting;
mod diagnosis;
mod fault;
mod figures;
mod file_kind;
mod machine;
mod prediction;
mod quote;
mod recording;
mod request;
mod settings;

pub use calibration::move_report::MoveReport;
pub use calibration::report::CalibrationReport;
pub use cutting::file::{EXAMPLE_CUTTING, cutting_from_toml};
pub use cutting::results::{cutting_refusal, cutting_remarks, cutting_table, loads_csv, materials_json};
pub use cutting::tool_list::described_tools_json;
pub use diagnosis::{DiagnosisReport, RunChart, diagnosis_chart, extended};
pub use fault::TextFault;
pub use figures::{clock, grouped};
pub use file_kind::{FileKind, file_kind, holds_blocks};
pub use machine::file::{machine_from_toml, motion_of_machine, toml_from_machine};
pub use machine::form::{
    arc_centers, dialects, edited, faults_to_json, form, machine_from_form, machine_values,
};
pub use prediction::archive::{ArchiveKeys, ArchiveLine, LineBeginning, LineOwner};
pub use prediction::results::{Prediction, ToleranceRangeRow, profile_csv, severity_word, spacing_note};
pub use prediction::revisions::{RevisedSide, RevisionsReport};
pub use prediction::time_losses::time_loss_texts;
pub use prediction::time_range::range_sentence;
pub use prediction::trust::doubt_sentence;
pub use quote::job::{
    JobComparison, JobFile, JobOperationFile, JobReport, MachineSource, PlannedProgram, letter_form,
};
pub use quote::offer::report::OfferReport;
pub use quote::terms::{terms_form, terms_from_form};
pub use recording::comparison::{ComparisonRefusal, ComparisonReport, lost_label};
pub use recording::measured_laws::{MeasuredReport, law_chart};
pub use request::{QuoteRequest, RequestError};
pub use settings::{SettingsError, settings_from_text, settings_text};

/// Version of this build, unique to its commit (`build.rs`): `0.1.0`, or `0.1.0+12.gc32ad9a` 12 commits
/// later.
pub const VERSION: &str = env!("TRUEFEED_VERSION");
