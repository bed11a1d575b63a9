//! The filters identified from one recorded move, as JSON and as text, and the machine with them.

use serde::Serialize;
use serde_json::{Map, Value};

use crate::identification::recording::{ReadingOptions, read_with};
use crate::identification::step::{Estimate, Filters, Fit, Identification, Outcome, identify_move};
use crate::machine::{Machine, TimeConstants};
use crate::project::calibration::report::rounded;
use crate::project::figures::{FITTED_DIGITS, to_the_digits_of};
use crate::project::machine::form::values;
use crate::units::{PERCENT, Unit, mm_per_min};

/// The filters of a move; every number has its unit in its key.
#[derive(Clone, Debug, Serialize)]
pub struct MoveReport {
    /// Summary, which comes first.
    sentence: String,
    filters: usize,
    time_constants_s: Vec<f64>,
    uncertainty_s: Vec<f64>,
    feedrate_mm_min: f64,
    length_mm: f64,
    /// Alternatives that the recording does not exclude, in words.
    rivals: Vec<String>,
    /// Name of the recording.
    name: String,
    #[serde(skip)]
    fit: Fit,
}

/// A machine with the filters of a move.
#[derive(Clone, Debug, Serialize)]
pub struct MachineOfMove {
    /// Summary of the move and its filters.
    sentence: String,
    /// Machine as a filled form.
    values: Map<String, Value>,
}

impl MoveReport {
    /// Returns the report of the recording with this name, whose file may not state all that `options` do.
    ///
    /// # Errors
    ///
    /// Returns the reason, in one line, if the recording cannot be read or no filters were identified.
    pub fn read(recording: &[u8], options: &ReadingOptions, name: &str) -> Result<MoveReport, String> {
        let log = read_with(recording, options).map_err(|error| format!("{name}: {error}"))?;
        MoveReport::new(log.recordings.first().and_then(identify_move), name)
    }

    fn new(outcome: Option<Outcome>, name: &str) -> Result<MoveReport, String> {
        let refusal = |what: String| format!("{name}: {what}");
        match outcome {
            Some(Outcome::Converged(found)) => Ok(report(&found, name)),
            Some(Outcome::LostPatience(_)) => Err(refusal(
                "the fit of the move did not converge; record it with more samples on its ramps".to_string(),
            )),
            Some(Outcome::NotASingleMove { unexplained }) => Err(refusal(format!(
                "this is not one straight move from rest to rest ({:.0} % of it is something else); record a single one, \
                 long enough to reach its feedrate",
                PERCENT * unexplained.min(1.0)
            ))),
            Some(Outcome::TooFewSamples { found, needed }) => Err(refusal(format!(
                "{found} samples on the ramps of the move are too few, {needed} are needed; record it at a shorter interval"
            ))),
            Some(Outcome::Unreadable(fault)) => Err(refusal(format!("{fault}; record the move again"))),
            None => Err(refusal("it has neither positions nor feedrates; record one of them".to_string())),
        }
    }

    /// Returns the machine with these filters.
    pub fn apply(&self, machine: &Machine) -> Machine {
        let mut machine = machine.to_be_changed(format!("filters from {}", self.name));
        let constants: Vec<f64> = self.fit.time_constants.iter().map(|constant| constant.value).collect();
        machine.interpolator.filters = self.filters;
        machine.interpolator.time_constants = match self.fit.filters {
            Filters::Equal(_) => TimeConstants::Equal(constants[0]),
            Filters::UnequalPair => TimeConstants::Unequal(constants),
        };
        machine
    }

    /// Returns the machine with these filters as a filled form, with the summary.
    pub fn on(&self, machine: &Machine) -> MachineOfMove {
        let values = rounded(values(&self.apply(machine)), &values(machine), FITTED_DIGITS);
        MachineOfMove { sentence: self.sentence.clone(), values }
    }

    /// Returns the report as JSON.
    pub fn to_json(&self) -> String {
        serde_json::to_string(self).expect("strings and numbers can be written")
    }

    /// Returns the report as text for people.
    pub fn to_text(&self) -> String {
        self.sentence.clone()
    }
}

fn report(found: &Identification, name: &str) -> MoveReport {
    let fit = found.best();
    let word = |filters: Filters| match filters {
        Filters::Equal(1) => "one filter".to_string(),
        Filters::Equal(count) => format!("{count} equal filters"),
        Filters::UnequalPair => "two filters of different time constants".to_string(),
    };
    let told = |estimate: &Estimate| {
        let Estimate { value, uncertainty } = *estimate;
        let [value, deviation] = [value, uncertainty].map(|seconds| to_the_digits_of(seconds, uncertainty));
        format!("{value} ± {deviation} s")
    };
    let constants: Vec<String> = fit.time_constants.iter().map(told).collect();
    let rivals: Vec<String> = found.rivals.iter().map(|at| word(found.fits[*at].filters)).collect();
    let doubt = match rivals.as_slice() {
        [] => "the recording distinguishes them from all others".to_string(),
        _ => format!("the recording cannot distinguish them from {}", rivals.join(" or ")),
    };
    let (feedrate, length) = (mm_per_min(fit.feedrate.value.abs()), fit.length.value.abs());
    MoveReport {
        sentence: format!(
            "{name}: one move of {length:.2} mm at {feedrate:.0} {}, {}, T1 {}; {doubt}.",
            Unit::MillimetrePerMinute.symbol(),
            word(fit.filters),
            constants.join(" and "),
        ),
        filters: fit.filters.order(),
        time_constants_s: fit.time_constants.iter().map(|constant| constant.value).collect(),
        uncertainty_s: fit.time_constants.iter().map(|constant| constant.uncertainty).collect(),
        feedrate_mm_min: feedrate,
        length_mm: length,
        rivals,
        name: name.to_string(),
        fit: fit.clone(),
    }
}
