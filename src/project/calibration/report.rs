//! The calibration report as JSON and as text: the result of each parameter, the runs before and after, and
//! the calibrated machine as a filled form.

use serde::Serialize;
use serde_json::{Map, Value};

use crate::identification::calibration::{Calibration, Estimate, ParameterVerdict, RunResult};
use crate::identification::comparison::{Comparison, Durations};
use crate::identification::diagnosis::ModelError;
use crate::identification::measured::Measured;
use crate::machine::{Access, Machine, parameter};
use crate::project::TextFault;
use crate::project::figures::{FITTED_DIGITS, as_short, significant, to_the_digits_of};
use crate::project::machine::form::{machine_from_form, values};
use crate::project::recording::comparison::{feedrate, percent};
use crate::project::recording::measured_laws::MeasuredReport;
use crate::quote::UNKNOWN_LAW_ERROR_RATIO;
use crate::units::{PERCENT, Unit, mm_per_min};

/// Key of planners with steps of velocity.
const AXIS_STEP_KEY: &str = "interpolator.axis_velocity_step_mm_min";
/// Correlation from which two parameters are reported as dependent.
const MIN_DEPENDENT_CORRELATION: f64 = 0.95;

/// The report of a calibration.
#[derive(Clone, Debug, Serialize)]
pub struct CalibrationReport {
    /// Summary, which comes first.
    sentence: String,
    estimates: Vec<EstimateRow>,
    runs: Vec<RunRow>,
    /// Laws of the machine as the runs show them; null if not requested.
    measured: Option<MeasuredReport>,
    /// Other remarks, one sentence each.
    remarks: Vec<String>,
    /// Calibrated machine as a filled form.
    values: Map<String, Value>,
    /// Contour tolerance of the calibrated machine.
    tolerance_mm: f64,
}

/// The result of a parameter; numbers in its unit.
#[derive(Clone, Debug, Serialize)]
struct EstimateRow {
    key: String,
    label: String,
    unit: &'static str,
    before: String,
    after: String,
    /// Standard deviation; `None` if unknown.
    deviation: Option<String>,
    verdict: &'static str,
    /// Values before and after, and the deviation, as numbers.
    numbers: [Option<f64>; 3],
}

/// The errors of a run before and after the calibration.
#[derive(Clone, Debug, Serialize)]
struct RunRow {
    name: String,
    /// Simulated against recorded cycle time, before and after.
    time: String,
    /// Simulated against recorded motion time, before and after.
    motion: String,
    /// RMS difference of the feedrates of cutting, and CAM's.
    feed: Option<String>,
    cam_feed: Option<String>,
    /// Simulated less recorded cycle time as a part of the recorded one, before and after.
    cycle_time_error: [f64; 2],
    /// Simulated less recorded motion time as a part of the recorded one, before and after.
    motion_error: [f64; 2],
    /// RMS difference of the feedrates before, after, and of CAM's estimate.
    feed_rmse_mm_min: Option<[f64; 3]>,
}

impl CalibrationReport {
    /// Returns the report of the calibration of `before` from runs with these names; `error` is the error on
    /// these runs after the calibration.
    pub fn new(
        before: &Machine,
        calibration: &Calibration,
        error: ModelError,
        names: &[String],
    ) -> CalibrationReport {
        let mut machine = calibration.machine.clone();
        machine.provenance = provenance(calibration, names);
        machine.cycle_time_error = Some(calibration.worst_error(|side| side.whole));
        machine.calibrated_at = tolerances(calibration);
        error.keep_in(&mut machine);
        if !before.name.ends_with(CALIBRATED_SUFFIX) {
            machine.name = format!("{}{CALIBRATED_SUFFIX}", before.name);
        }
        let mut rows: Vec<EstimateRow> = calibration.estimates.iter().map(estimate_row).collect();
        let orders = (before.interpolator.filters, machine.interpolator.filters);
        if 1 < calibration.orders.len() {
            let label = parameter(FILTERS_KEY).map_or(FILTERS_KEY, |row| row.label);
            rows.insert(
                0,
                EstimateRow {
                    key: FILTERS_KEY.to_string(),
                    label: label.to_string(),
                    unit: "",
                    before: orders.0.to_string(),
                    after: orders.1.to_string(),
                    deviation: None,
                    verdict: word(if orders.0 == orders.1 {
                        ParameterVerdict::Agrees
                    } else {
                        ParameterVerdict::Fitted
                    }),
                    numbers: [Some(orders.0 as f64), Some(orders.1 as f64), None],
                },
            );
        }
        let runs = calibration.runs.iter().zip(names).map(|(run, name)| run_row(run, name)).collect();
        CalibrationReport {
            sentence: sentence(calibration),
            estimates: rows,
            runs,
            measured: None,
            remarks: remarks(before, calibration),
            tolerance_mm: machine.interpolator.contour_tolerance,
            values: rounded(values(&machine), &values(before), FITTED_DIGITS),
        }
    }
}

impl CalibrationReport {
    /// Returns the report with the laws of the machine as the runs show them.
    pub fn measured(self, measured: &Measured) -> CalibrationReport {
        CalibrationReport { measured: Some(MeasuredReport::new(measured)), ..self }
    }

    /// Returns the calibrated machine, with its fitted numbers rounded to the digits of the report.
    ///
    /// # Errors
    ///
    /// Returns all faults of the values.
    pub fn machine(&self) -> Result<Machine, Vec<TextFault>> {
        machine_from_form(&Value::Object(self.values.clone()).to_string())
    }

    /// Returns the report as JSON.
    pub fn to_json(&self) -> String {
        serde_json::to_string(self).expect("strings and numbers can be written")
    }

    /// Returns the report as text for people.
    pub fn to_text(&self) -> String {
        let mut text = self.sentence.clone();
        for row in &self.estimates {
            let deviation =
                row.deviation.as_ref().map_or(String::new(), |deviation| format!(" ± {deviation}"));
            let after = format!("{}{deviation} {}", row.after, row.unit);
            text += &format!("\n{:34} {:>12} → {after:26} {}", row.label, row.before, row.verdict);
        }
        for run in &self.runs {
            text += &format!("\n{}: cycle time {}, motion {}", run.name, run.time, run.motion);
            if let (Some(feed), Some(cam)) = (&run.feed, &run.cam_feed) {
                text += &format!(", feed RMSE {feed}, CAM's {cam}");
            }
        }
        text.extend(self.measured.iter().map(|measured| format!("\n{}", measured.to_text())));
        self.remarks.iter().fold(text, |text, remark| text + "\n" + remark)
    }
}

/// Suffix of a calibrated machine's name.
const CALIBRATED_SUFFIX: &str = ", calibrated";

const FILTERS_KEY: &str = "interpolator.filters";

fn word(verdict: ParameterVerdict) -> &'static str {
    match verdict {
        ParameterVerdict::Fitted => "fitted",
        ParameterVerdict::Agrees => "agrees, kept",
        ParameterVerdict::Unknown => "these runs cannot determine it",
        ParameterVerdict::Recorded => "read off the recorded rapids",
    }
}

/// Returns `true` if the calibration gave the parameter a value of the runs.
fn is_changed(estimate: &Estimate) -> bool {
    matches!(estimate.verdict, ParameterVerdict::Fitted | ParameterVerdict::Recorded)
}

fn estimate_row(estimate: &Estimate) -> EstimateRow {
    let known = parameter(&estimate.key);
    let unit = known.map_or(Unit::Second, |row| match row.access {
        Access::Number { unit, .. } => unit,
        _ => Unit::Number,
    });
    let label = match (known, estimate.key.rsplit_once('.')) {
        (Some(row), _) => row.label.to_string(),
        (None, Some((_, word))) => word.to_string(),
        (None, None) => estimate.key.clone(),
    };
    let deviation = estimate.deviation.map(|deviation| unit.from_core(deviation).abs());
    let [before, after] = [estimate.before, estimate.value].map(|value| unit.from_core(value));
    EstimateRow {
        key: estimate.key.clone(),
        label,
        unit: unit.symbol(),
        before: as_limit(before),
        after: match deviation {
            Some(deviation) if is_changed(estimate) => to_the_digits_of(after, deviation),
            _ => as_limit(after),
        },
        deviation: deviation.map(|deviation| to_the_digits_of(deviation, deviation)),
        verdict: word(estimate.verdict),
        numbers: [Some(before), Some(after), deviation].map(|number| number.filter(|n| n.is_finite())),
    }
}

/// Formats a limit; a dash for no limit.
fn as_limit(value: f64) -> String {
    if value.is_finite() { as_short(value) } else { "–".to_string() }
}

fn run_row(run: &RunResult, name: &str) -> RunRow {
    let both = |of: fn(&Comparison) -> Durations| {
        format!(
            "{} → {}",
            percent(of(&run.before).relative_error()),
            percent(of(&run.after).relative_error())
        )
    };
    let feeds = run.before.feed.zip(run.after.feed);
    RunRow {
        name: name.to_string(),
        time: both(|side| side.whole),
        motion: both(|side| side.motion),
        feed: feeds.map(|(before, after)| format!("{:.0} → {}", mm_per_min(before.rms), feedrate(after.rms))),
        cam_feed: feeds.map(|(_, after)| feedrate(after.programmed_rms)),
        cycle_time_error: [run.before.whole.relative_error(), run.after.whole.relative_error()],
        motion_error: [run.before.motion.relative_error(), run.after.motion.relative_error()],
        feed_rmse_mm_min: feeds
            .map(|(before, after)| [before.rms, after.rms, after.programmed_rms].map(mm_per_min)),
    }
}

/// Returns the provenance for the machine file.
fn provenance(calibration: &Calibration, names: &[String]) -> String {
    let at_most = |of: fn(&Comparison) -> Durations| {
        // An error that would round to 0 is given as 0.1 %.
        let percent = (PERCENT * calibration.worst_error(of)).max(0.1);
        format!("{percent:.1} %")
    };
    format!(
        "calibrated from {}; on these the cycle time is off by {} at most, motion alone by {}",
        names.join(", "),
        at_most(|side| side.whole),
        at_most(|side| side.motion)
    )
}

/// Returns the contour tolerances of the runs, each once.
fn tolerances(calibration: &Calibration) -> Vec<f64> {
    let mut all: Vec<f64> =
        calibration.runs.iter().map(|run| significant(run.tolerance, FITTED_DIGITS)).collect();
    all.sort_by(f64::total_cmp);
    all.dedup();
    all
}

fn sentence(calibration: &Calibration) -> String {
    let largest = |side: fn(&RunResult) -> &Comparison| {
        calibration.runs.iter().map(|run| side(run).whole.relative_error().abs()).fold(0.0, f64::max)
    };
    let count = match calibration.runs.len() {
        1 => "one run".to_string(),
        many => format!("{many} runs"),
    };
    let which = if calibration.runs.len() == 1 { "" } else { " at most" };
    let changed = calibration.estimates.iter().filter(|estimate| is_changed(estimate)).count();
    format!(
        "Calibrated from {count}: the cycle time is off by {:.1} %{which} now, {:.1} % before; {changed} of {} parameters \
         changed.",
        100.0 * largest(|run| &run.after),
        100.0 * largest(|run| &run.before),
        calibration.estimates.len(),
    )
}

fn remarks(before: &Machine, calibration: &Calibration) -> Vec<String> {
    let mut all = Vec::new();
    if !calibration.converged {
        all.push("The fit did not converge; its values may still change.".to_string());
    }
    let is_new = |estimate: &Estimate| estimate.key == AXIS_STEP_KEY && estimate.before.is_infinite();
    if calibration.estimates.iter().any(is_new) {
        all.push(
            "Filters do not explain these runs: the control plans its ramps and passes corners with a step of velocity, so the time constant and the contour tolerance of this machine mean nothing."
                .to_string(),
        );
    }
    if calibration.machine.rapid.at_feedrate && !before.rapid.at_feedrate {
        all.push(
            "This control runs rapids at the feedrate that F has set, as Klipper and Marlin do: G0 without F is as slow as the G1 before it."
                .to_string(),
        );
    }
    if let Some(misfit) = calibration.machine.calibrated_on.misfit_of_unknown_law() {
        all.push(format!(
            "Accelerations within ramps are off by {:.0} % in the median: the control ramps by a law that Truefeed does not have, or the calibration has missed its law. Its accelerations therefore have no standard deviation. The times of these programs are right, those of other programs may be off by {:.0} %.",
            PERCENT * misfit,
            PERCENT * UNKNOWN_LAW_ERROR_RATIO
        ));
    }
    let (keys, correlations) = &calibration.correlations;
    let label =
        |key: &str| parameter(key).map_or(key.rsplit('.').next().unwrap_or(key), |row| row.label).to_string();
    for i in 0..keys.len() {
        for j in 0..i {
            let correlation = correlations[(i, j)];
            if MIN_DEPENDENT_CORRELATION < correlation.abs() {
                all.push(format!(
                    "These runs hardly separate {} from {} (correlation {correlation:+.2}).",
                    label(&keys[j]),
                    label(&keys[i])
                ));
            }
        }
    }
    all
}

/// Returns a filled form with the numbers that a fit changed rounded to their significant digits.
pub(in crate::project) fn rounded(
    values: Map<String, Value>,
    before: &Map<String, Value>,
    digits: usize,
) -> Map<String, Value> {
    fn round(value: Value, before: Option<&Value>, digits: usize) -> Value {
        match value {
            Value::Number(number) if before != Some(&Value::Number(number.clone())) => {
                number.as_f64().map_or(Value::Null, |number| Value::from(significant(number, digits)))
            }
            Value::Array(values) if before != Some(&Value::Array(values.clone())) => {
                values.into_iter().map(|value| round(value, None, digits)).collect()
            }
            Value::Object(entries) => {
                let own = |key: &str| before.and_then(|before| before.get(key));
                let entries = entries.into_iter().map(|(key, value)| {
                    let value = round(value, own(&key), digits);
                    (key, value)
                });
                Value::Object(entries.collect())
            }
            other => other,
        }
    }
    let entries = values.into_iter().map(|(key, value)| {
        let value = round(value, before.get(&key), digits);
        (key, value)
    });
    entries.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_changed_is_rounded() {
        let before = values(&Machine::default());
        let mut machine = Machine::default();
        machine.rapid.feedrate *= 1.0123456789;
        machine.times.m_codes.insert(8, 2.3456789);
        let after = rounded(values(&machine), &before, FITTED_DIGITS);
        for (key, value) in &after {
            match key.as_str() {
                "rapid.feed_mm_min" => {
                    let rounded = value.as_f64().expect("a number");
                    assert_eq!(rounded, significant(rounded, FITTED_DIGITS));
                    assert_ne!(Some(value), before.get(key));
                }
                "times.m_codes" => assert_eq!(value["M8"], 2.3457),
                _ => assert_eq!(Some(value), before.get(key), "{key}"),
            }
        }
    }

    #[test]
    fn words_of_the_table_have_units_and_labels() {
        let estimate = |key: &str, value: f64| Estimate {
            key: key.to_string(),
            before: value,
            value: 1.1 * value,
            deviation: Some(0.01 * value),
            verdict: ParameterVerdict::Fitted,
        };
        let rapid = estimate_row(&estimate("rapid.feed_mm_min", 200.0));
        assert_eq!((rapid.unit, &*rapid.before, &*rapid.after), ("mm/min", "12000", "13200"));
        assert_eq!(rapid.deviation.as_deref(), Some("120"));
        let word = estimate_row(&estimate("times.m_codes.M8", 2.0));
        assert_eq!((&*word.label, word.unit, &*word.after), ("M8", "s", "2.200"));
    }
}
