//! A calibration as JSON and as text: what became of each parameter, the runs before and after, and the
//! calibrated machine as a filled form.

use serde::Serialize;
use serde_json::{Map, Value};

use crate::identification::calibration::{Calibration, Estimate, RunResult, Verdict};
use crate::identification::comparison::{Comparison, Durations};
use crate::identification::diagnosis::ModelError;
use crate::machine::{Access, Machine, parameter};
use crate::project::Fault;
use crate::project::comparison::{feedrate, percent};
use crate::project::form::{machine_from_form, values};
use crate::units::{PERCENT, Unit, mm_per_min};

/// Fitted numbers in the form have so many digits.
const DIGITS: usize = 5;
/// What planners with steps of velocity are known by.
const STEP: &str = "interpolator.axis_velocity_step_mm_min";
/// A correlation from which two parameters are said to depend on each other.
const DEPENDENT: f64 = 0.95;

/// What a calibration gave.
#[derive(Clone, Debug, Serialize)]
pub struct CalibrationReport {
    /// What the user reads first.
    sentence: String,
    estimates: Vec<Row>,
    runs: Vec<RunRow>,
    /// What else to know, a sentence each.
    remarks: Vec<String>,
    /// The calibrated machine as a filled form.
    values: Map<String, Value>,
    /// Its contour tolerance.
    tolerance_mm: f64,
}

/// What became of a parameter; numbers in its unit.
#[derive(Clone, Debug, Serialize)]
struct Row {
    key: String,
    label: String,
    unit: &'static str,
    before: String,
    after: String,
    /// Standard deviation; none where it is not known.
    deviation: Option<String>,
    verdict: &'static str,
    /// The same as numbers: before, after, deviation.
    numbers: [Option<f64>; 3],
}

/// A run before and after.
#[derive(Clone, Debug, Serialize)]
struct RunRow {
    name: String,
    /// Simulated against recorded cycle time, before and after.
    time: String,
    /// The same of motion alone.
    motion: String,
    /// Root mean square of the differences of the feedrates of cutting, and what CAM's is.
    feed: Option<String>,
    cam_feed: Option<String>,
    /// Simulated less recorded cycle time as a part of the recorded one, before and after.
    cycle_time_error: [f64; 2],
    /// The same of motion alone.
    motion_error: [f64; 2],
    /// Before, after, and CAM's.
    feed_rmse_mm_min: Option<[f64; 3]>,
}

impl CalibrationReport {
    /// Of the calibration of `before` from runs with these names, and the error that the calibrated machine leaves on them.
    pub fn new(
        before: &Machine,
        calibration: &Calibration,
        error: ModelError,
        names: &[String],
    ) -> CalibrationReport {
        let mut machine = calibration.machine.clone();
        machine.provenance = provenance(calibration, names);
        machine.cycle_time_error = Some(worst(calibration, |side| side.whole));
        machine.calibrated_at = tolerances(calibration);
        error.keep_in(&mut machine);
        if !before.name.ends_with(CALIBRATED) {
            machine.name = format!("{}{CALIBRATED}", before.name);
        }
        let mut rows: Vec<Row> = calibration.estimates.iter().map(row).collect();
        let orders = (before.interpolator.filters, machine.interpolator.filters);
        if 1 < calibration.orders.len() {
            let label = parameter(FILTERS).map_or(FILTERS, |row| row.label);
            rows.insert(
                0,
                Row {
                    key: FILTERS.to_string(),
                    label: label.to_string(),
                    unit: "",
                    before: orders.0.to_string(),
                    after: orders.1.to_string(),
                    deviation: None,
                    verdict: word(if orders.0 == orders.1 { Verdict::Agrees } else { Verdict::Fitted }),
                    numbers: [Some(orders.0 as f64), Some(orders.1 as f64), None],
                },
            );
        }
        let runs = calibration.runs.iter().zip(names).map(|(run, name)| run_row(run, name)).collect();
        CalibrationReport {
            sentence: sentence(calibration),
            estimates: rows,
            runs,
            remarks: remarks(calibration),
            tolerance_mm: machine.interpolator.contour_tolerance,
            values: rounded(values(&machine), &values(before), DIGITS),
        }
    }
}

impl CalibrationReport {
    /// The calibrated machine, its fitted numbers with the digits they have here.
    pub fn machine(&self) -> Result<Machine, Vec<Fault>> {
        machine_from_form(&Value::Object(self.values.clone()).to_string())
    }

    /// As JSON.
    pub fn to_json(&self) -> String {
        serde_json::to_string(self).expect("strings and numbers can be written")
    }

    /// For people.
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
        self.remarks.iter().fold(text, |text, remark| text + "\n" + remark)
    }
}

/// What a calibrated machine's name ends with.
const CALIBRATED: &str = ", calibrated";

const FILTERS: &str = "interpolator.filters";

fn word(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Fitted => "fitted",
        Verdict::Agrees => "agrees, kept",
        Verdict::Unknown => "cannot be told from these runs",
    }
}

fn row(estimate: &Estimate) -> Row {
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
    Row {
        key: estimate.key.clone(),
        label,
        unit: unit.symbol(),
        before: as_limit(before),
        after: match deviation {
            Some(deviation) if estimate.verdict == Verdict::Fitted => to_the_digits_of(after, deviation),
            _ => as_limit(after),
        },
        deviation: deviation.map(|deviation| to_the_digits_of(deviation, deviation)),
        verdict: word(estimate.verdict),
        numbers: [Some(before), Some(after), deviation].map(|number| number.filter(|n| n.is_finite())),
    }
}

/// A number, where a limit that is none has a dash.
fn as_limit(value: f64) -> String {
    if value.is_finite() { as_short(value) } else { "–".to_string() }
}

/// A number with at most five digits, without zeros at its end.
pub(super) fn as_short(value: f64) -> String {
    significant(value, DIGITS).to_string().replace('-', "−")
}

/// A number with the decimals that a deviation with two digits has.
pub(super) fn to_the_digits_of(value: f64, deviation: f64) -> String {
    if 0.0 < deviation && deviation.is_finite() {
        let decimals = (1.0 - deviation.log10().floor()).clamp(0.0, 9.0) as usize;
        format!("{value:.decimals$}").replace('-', "−")
    } else {
        as_short(value)
    }
}

/// A number rounded to so many digits.
fn significant(value: f64, digits: usize) -> f64 {
    format!("{value:.*e}", digits - 1).parse().unwrap_or(value)
}

/// The relative error of a simulated duration.
fn error(of: Durations) -> f64 {
    of.simulated / of.recorded - 1.0
}

fn run_row(run: &RunResult, name: &str) -> RunRow {
    let both = |of: fn(&Comparison) -> Durations| {
        format!("{} → {}", percent(error(of(&run.before))), percent(error(of(&run.after))))
    };
    let feeds = run.before.feed.zip(run.after.feed);
    RunRow {
        name: name.to_string(),
        time: both(|side| side.whole),
        motion: both(|side| side.motion),
        feed: feeds.map(|(before, after)| format!("{:.0} → {}", mm_per_min(before.rms), feedrate(after.rms))),
        cam_feed: feeds.map(|(_, after)| feedrate(after.programmed_rms)),
        cycle_time_error: [error(run.before.whole), error(run.after.whole)],
        motion_error: [error(run.before.motion), error(run.after.motion)],
        feed_rmse_mm_min: feeds
            .map(|(before, after)| [before.rms, after.rms, after.programmed_rms].map(mm_per_min)),
    }
}

/// What the machine file says of where its numbers come from.
fn provenance(calibration: &Calibration, names: &[String]) -> String {
    let at_most = |of: fn(&Comparison) -> Durations| {
        // What is rounded to nothing is not nothing.
        let percent = (PERCENT * worst(calibration, of)).max(0.1);
        format!("{percent:.1} %")
    };
    format!(
        "calibrated from {}; there the cycle time is off by {} at most, motion alone by {}",
        names.join(", "),
        at_most(|side| side.whole),
        at_most(|side| side.motion)
    )
}

/// The contour tolerances of the runs, each once.
fn tolerances(calibration: &Calibration) -> Vec<f64> {
    let mut all: Vec<f64> = calibration.runs.iter().map(|run| significant(run.tolerance, DIGITS)).collect();
    all.sort_by(f64::total_cmp);
    all.dedup();
    all
}

/// The largest error of a duration among the runs after the calibration, as a part of it.
fn worst(calibration: &Calibration, of: fn(&Comparison) -> Durations) -> f64 {
    let errors = calibration.runs.iter().map(|run| error(of(&run.after)).abs());
    errors.filter(|error| error.is_finite()).fold(0.0, f64::max).min(1.0)
}

fn sentence(calibration: &Calibration) -> String {
    let largest = |side: fn(&RunResult) -> &Comparison| {
        calibration.runs.iter().map(|run| error(side(run).whole).abs()).fold(0.0, f64::max)
    };
    let count = match calibration.runs.len() {
        1 => "one run".to_string(),
        many => format!("{many} runs"),
    };
    let which = if calibration.runs.len() == 1 { "" } else { " at most" };
    let fitted = calibration.estimates.iter().filter(|estimate| estimate.verdict == Verdict::Fitted).count();
    format!(
        "Calibrated from {count}: the cycle time is off by {:.1} %{which} now, {:.1} % before; {fitted} of {} parameters \
         changed.",
        100.0 * largest(|run| &run.after),
        100.0 * largest(|run| &run.before),
        calibration.estimates.len(),
    )
}

fn remarks(calibration: &Calibration) -> Vec<String> {
    let mut all = Vec::new();
    if !calibration.converged {
        all.push("The fit did not come to its end; the values may still move.".to_string());
    }
    let is_new = |estimate: &Estimate| estimate.key == STEP && estimate.before.is_infinite();
    if calibration.estimates.iter().any(is_new) {
        all.push(
            "Filters do not explain these runs: the control plans its ramps and passes corners with a step of velocity, \
             so that the time constant and the contour tolerance of this machine say nothing."
                .to_string(),
        );
    }
    let (keys, correlations) = &calibration.correlations;
    let label =
        |key: &str| parameter(key).map_or(key.rsplit('.').next().unwrap_or(key), |row| row.label).to_string();
    for i in 0..keys.len() {
        for j in 0..i {
            let correlation = correlations[(i, j)];
            if DEPENDENT < correlation.abs() {
                all.push(format!(
                    "{} and {} can hardly be told apart by these runs (correlation {correlation:+.2}).",
                    label(&keys[j]),
                    label(&keys[i])
                ));
            }
        }
    }
    all
}

/// A filled form in which what a fit changed has no more digits than it means.
pub(super) fn rounded(
    values: Map<String, Value>,
    before: &Map<String, Value>,
    digits: usize,
) -> Map<String, Value> {
    fn round(value: Value, before: Option<&Value>, digits: usize) -> Value {
        match value {
            Value::Number(number) if before != Some(&Value::Number(number.clone())) => {
                number.as_f64().map_or(Value::Null, |number| Value::from(significant(number, digits)))
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
    fn numbers_have_the_digits_their_deviation_means() {
        assert_eq!(to_the_digits_of(0.0213456, 0.00012), "0.02135");
        assert_eq!(to_the_digits_of(12345.678, 230.0), "12346");
        assert_eq!(to_the_digits_of(2.0, 0.0), "2");
        assert_eq!(as_short(0.025500000000000002), "0.0255");
        assert_eq!(significant(11999.7, 5), 12000.0);
    }

    #[test]
    fn only_what_changed_is_rounded() {
        let before = values(&Machine::default());
        let mut machine = Machine::default();
        machine.rapid.feedrate *= 1.0123456789;
        machine.times.m_codes.insert(8, 2.3456789);
        let after = rounded(values(&machine), &before, DIGITS);
        for (key, value) in &after {
            match key.as_str() {
                "rapid.feed_mm_min" => {
                    let rounded = value.as_f64().expect("a number");
                    assert_eq!(rounded, significant(rounded, DIGITS));
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
            verdict: Verdict::Fitted,
        };
        let rapid = row(&estimate("rapid.feed_mm_min", 200.0));
        assert_eq!((rapid.unit, &*rapid.before, &*rapid.after), ("mm/min", "12000", "13200"));
        assert_eq!(rapid.deviation.as_deref(), Some("120"));
        let word = row(&estimate("times.m_codes.M8", 2.0));
        assert_eq!((&*word.label, word.unit, &*word.after), ("M8", "s", "2.200"));
    }
}
