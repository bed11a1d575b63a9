//! The rows of a diagnosis report: causes, regions, the improvement of the fit.

use serde::Serialize;
use serde_json::{Map, Value};

use crate::identification::effects::Effect;
use crate::project::diagnosis::parameter_text::ParameterText;

/// Frequency and depth (as a part of the feedrate) of a pulsation.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct PulsationRow {
    pub(super) frequency_hz: f64,
    pub(super) depth: f64,
}

/// The place of a recording on its program.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct AlignmentRow {
    /// Recorded less programmed coordinates.
    pub(super) shift_mm: [f64; 3],
    /// Number of runs of the program in the recording.
    pub(super) passes: usize,
}

/// A named cause.
#[derive(Clone, Debug, Serialize)]
pub(super) struct CauseRow {
    #[serde(skip)]
    pub(super) effect: Effect,
    pub(super) id: &'static str,
    pub(super) parameters: Map<String, Value>,
    pub(super) uncertainty: Map<String, Value>,
    pub(super) lines: Vec<[u32; 2]>,
    /// Time explained, s, as in the account.
    pub(super) seconds: Option<f64>,
    /// Position error explained, mm; null for causes of time.
    pub(super) position_mm: Option<f64>,
    pub(super) confidence: Option<f64>,
    pub(super) indistinguishable_from: Vec<String>,
    /// Name for people, with the variant.
    pub(super) name: String,
    /// Description, a sentence with its numbers.
    pub(super) sentence: String,
    /// Description as a clause, without its cost.
    #[serde(skip)]
    pub(super) clause: String,
    /// Vendors' names of the setting; may be empty.
    pub(super) vendors: &'static str,
    /// Number of held-out sections in which the cause improved the feedrate, and in which it worsened it.
    pub(super) sections: Option<[usize; 2]>,
    /// Parameters with uncertainty and units, for people.
    pub(super) told: Vec<ParameterText>,
}

/// A region in which simulation and recording differ.
#[derive(Clone, Debug, Serialize)]
pub(super) struct RegionRow {
    pub(super) lines: [u32; 2],
    pub(super) distance_mm: [f64; 2],
    pub(super) time_s: [f64; 2],
    pub(super) seconds: f64,
    /// Index of the recording.
    pub(super) run: usize,
}

/// The errors of the fit before and after the causes.
#[derive(Clone, Debug, Default, Serialize)]
pub(super) struct FitImprovement {
    pub(super) feed_rmse_mm_min: BeforeAfter,
    pub(super) position_rmse_mm: BeforeAfter,
    pub(super) cycle_time_error_s: BeforeAfter,
    pub(super) held_out: HeldOutImprovement,
}

#[derive(Clone, Debug, Default, Serialize)]
pub(super) struct HeldOutImprovement {
    pub(super) feed_rmse_mm_min: BeforeAfter,
}

#[derive(Clone, Copy, Debug, Default, Serialize)]
pub(super) struct BeforeAfter {
    pub(super) before: Option<f64>,
    pub(super) after: Option<f64>,
}
