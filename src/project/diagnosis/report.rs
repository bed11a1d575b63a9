//! A diagnosis as JSON and as text: its summary, then the causes, their places, their confidence, the
//! alternatives, and the improvement of the fit. Fields of the JSON keep their names and meanings; fields may
//! be added.

use serde::Serialize;
use serde_json::{Map, Value, json};

use crate::identification::alignment::{Alignment, AlignmentError};
use crate::identification::comparison::{Comparison, PooledFeedError};
use crate::identification::diagnosis::{Cause, Diagnosis, Pulsation, Region, Verdict};
use crate::identification::effects::{Finding, Reported, ReportedValue, WRONG_PROGRAM, is_whole};
use crate::identification::measured::Measured;
use crate::machine::Machine;
use crate::project::calibration::report::rounded;
use crate::project::diagnosis::account::{AccountRow, seconds_of};
use crate::project::diagnosis::chart::RunChart;
use crate::project::diagnosis::parameter_text::{FieldChange, changes, parameter_texts};
use crate::project::diagnosis::rows::{
    AlignmentRow, BeforeAfter, CauseRow, FitImprovement, HeldOutImprovement, PulsationRow, RegionRow,
};
use crate::project::diagnosis::sentence::sentence;
use crate::project::machine::form::values;
use crate::project::prediction::results::spacing_note;
use crate::project::recording::comparison::{ComparisonRefusal, sentence_of};
use crate::project::recording::measured_laws::MeasuredReport;
use crate::units::mm_per_min;

/// Digits of changed values in the form.
const CHANGE_DIGITS: usize = 6;
/// Most regions listed as text.
const MAX_REGIONS_AS_TEXT: usize = 8;

/// A diagnosis for people and programs.
#[derive(Clone, Debug, Serialize)]
pub struct DiagnosisReport {
    pub(super) verdict: &'static str,
    /// Summary, which comes first.
    pub(super) sentence: String,
    pub(super) causes: Vec<CauseRow>,
    /// Account from the simulated to the recorded time; null if nothing is compared.
    pub(super) account: Option<AccountRow>,
    pub(super) regions: Vec<RegionRow>,
    pub(super) fit: FitImprovement,
    pub(super) not_excited: Vec<String>,
    /// Periodic pulsation of the feedrate; null if there is none.
    pub(super) pulsation: Option<PulsationRow>,
    /// Laws of the machine as the runs show them; null if nothing is compared.
    pub(super) measured: Option<MeasuredReport>,
    /// Place of the first recording; null if nothing is compared.
    pub(super) alignment: Option<AlignmentRow>,
    pub(super) messages: Vec<String>,
    /// Machine with its causes as a filled form; null if nothing is compared.
    pub(super) values: Option<Map<String, Value>>,
    /// Differences of the form between this machine and the machine before.
    pub(super) changes: Vec<FieldChange>,
    /// Names of the recordings, in the order of `run`.
    pub(super) runs: Vec<String>,
}

impl DiagnosisReport {
    /// Returns the report of a diagnosis of recordings with these names.
    pub fn new(diagnosis: &Diagnosis, names: &[String]) -> DiagnosisReport {
        let named = |cause: &Cause| {
            let hypothesis = &cause.candidate.hypothesis;
            (hypothesis.effect.id, hypothesis.name())
        };
        let account =
            AccountRow::new(&diagnosis.accounts, &diagnosis.causes.iter().map(named).collect::<Vec<_>>());
        let shown = account.balance.causes.iter().map(|hundredths| seconds_of(*hundredths));
        let causes: Vec<CauseRow> =
            diagnosis.causes.iter().zip(shown).map(|(own, seconds)| cause(own, seconds)).collect();
        let machine = extended(&diagnosis.machine, names);
        let mut messages: Vec<String> =
            diagnosis.messages.iter().map(|message| sentence_of(message)).collect();
        messages.extend(probe_message(diagnosis));
        DiagnosisReport {
            verdict: word(diagnosis.verdict),
            sentence: sentence(diagnosis, &causes, &account.balance),
            causes,
            account: Some(account),
            regions: diagnosis.regions.iter().map(region).collect(),
            fit: FitImprovement {
                feed_rmse_mm_min: sides(diagnosis, feed_rmse),
                position_rmse_mm: BeforeAfter {
                    before: diagnosis.form.map(|form| form.0),
                    after: diagnosis.form.map(|form| form.1),
                },
                cycle_time_error_s: sides(diagnosis, |side| {
                    Some(side.iter().map(|side| side.whole.simulated - side.whole.recorded).sum())
                }),
                held_out: HeldOutImprovement {
                    feed_rmse_mm_min: diagnosis.held_out.map_or(BeforeAfter::default(), |held_out| {
                        BeforeAfter {
                            before: Some(mm_per_min(held_out.before)),
                            after: Some(mm_per_min(held_out.after)),
                        }
                    }),
                },
            },
            not_excited: diagnosis.not_excited.clone(),
            pulsation: diagnosis
                .pulsation
                .map(|Pulsation { frequency, depth }| PulsationRow { frequency_hz: frequency, depth }),
            measured: None,
            alignment: None,
            messages,
            values: Some(values(&machine)),
            changes: Vec::new(),
            runs: names.to_vec(),
        }
    }

    /// Returns the report of a recording that does not belong to the program.
    pub fn not_comparable(error: &AlignmentError) -> DiagnosisReport {
        let cause = CauseRow {
            effect: WRONG_PROGRAM,
            id: WRONG_PROGRAM.id,
            parameters: Map::from_iter([("what".to_string(), Value::from(error.to_string()))]),
            uncertainty: Map::new(),
            lines: Vec::new(),
            seconds: None,
            position_mm: None,
            confidence: None,
            indistinguishable_from: Vec::new(),
            name: WRONG_PROGRAM.name(),
            sentence: sentence_of(&error.to_string()),
            clause: error.to_string(),
            vendors: WRONG_PROGRAM.vendors,
            sections: None,
            told: Vec::new(),
        };
        let causes = if is_of_another_program(error) { vec![cause] } else { Vec::new() };
        DiagnosisReport {
            verdict: "not_comparable",
            sentence: sentence_of(&error.to_string()),
            causes,
            account: None,
            regions: Vec::new(),
            fit: FitImprovement::default(),
            not_excited: Vec::new(),
            pulsation: None,
            measured: None,
            alignment: None,
            messages: vec![ComparisonRefusal::from(error).advice.to_string()],
            values: None,
            changes: Vec::new(),
            runs: Vec::new(),
        }
    }

    /// Returns the report with the place of the first recording on its program.
    pub fn aligned(self, alignment: &Alignment) -> DiagnosisReport {
        let row = AlignmentRow { shift_mm: alignment.shift.into(), passes: alignment.passes };
        DiagnosisReport { alignment: Some(row), ..self }
    }

    /// Returns the report with the laws of the machine as the runs show them.
    pub fn measured(self, measured: &Measured) -> DiagnosisReport {
        DiagnosisReport { measured: Some(MeasuredReport::new(measured)), ..self }
    }

    /// Returns the report with the changes against the machine before.
    pub fn beside(self, before: &Machine) -> DiagnosisReport {
        let before = values(before);
        let values = self.values.map(|values| rounded(values, &before, CHANGE_DIGITS));
        let changes = values.as_ref().map_or(Vec::new(), |values| changes(&before, values));
        DiagnosisReport { values, changes, ..self }
    }

    /// Returns the report with notes on the features that the chart of each run leaves out.
    pub fn drawn_by(mut self, charts: &[RunChart]) -> DiagnosisReport {
        for (chart, name) in charts.iter().zip(&self.runs) {
            let note = spacing_note(chart.spacing).map(|note| format!("Chart of {name}: {note}"));
            self.messages.extend(note);
        }
        self
    }

    /// Returns the report as JSON.
    pub fn to_json(&self) -> String {
        serde_json::to_string(self).expect("strings and numbers can be written")
    }

    /// Returns the report as text for people.
    pub fn to_text(&self) -> String {
        let mut text = self.sentence.clone();
        text.extend(self.account.iter().map(|account| format!("\n{}", account.to_text())));
        // For a recording of another program the cause repeats the summary.
        for cause in self.causes.iter().filter(|cause| cause.sentence != self.sentence) {
            text += &format!("\n{}: {}", cause.name, cause.sentence);
            if let Some(confidence) = cause.confidence {
                text += &format!(" Confidence {:.0} %.", 100.0 * confidence);
            }
            if !cause.indistinguishable_from.is_empty() {
                let others = cause.indistinguishable_from.join(", ");
                text += &format!(" This recording cannot separate it from {others}.");
            }
            if !cause.vendors.is_empty() {
                text += &format!(" Settings: {}.", cause.vendors);
            }
        }
        for region in self.regions.iter().take(MAX_REGIONS_AS_TEXT) {
            let [first, last] = region.lines;
            text += &format!("\nlines {first} to {last}: {:+.3} s", region.seconds);
        }
        let mut row = |name: &str, sides: BeforeAfter, unit: &str, decimals: usize| {
            if let (Some(before), Some(after)) = (sides.before, sides.after) {
                text += &format!("\n{name}: {before:.decimals$} → {after:.decimals$} {unit}");
            }
        };
        row("cycle time, simulated minus recorded", self.fit.cycle_time_error_s, "s", 3);
        row("feed RMSE", self.fit.feed_rmse_mm_min, "mm/min", 1);
        row("feed RMSE outside the fit", self.fit.held_out.feed_rmse_mm_min, "mm/min", 1);
        row("position RMSE", self.fit.position_rmse_mm, "mm", 4);
        if !self.not_excited.is_empty() {
            text += &format!("\nthis program cannot reveal: {}", self.not_excited.join(", "));
        }
        text.extend(self.measured.iter().map(|measured| format!("\n{}", measured.to_text())));
        self.messages.iter().fold(text, |text, message| text + "\n" + message)
    }
}

/// Returns the machine with its causes, and their origin as its provenance.
pub fn extended(machine: &Machine, names: &[String]) -> Machine {
    let provenance = format!("extended by a diagnosis of {}", names.join(", "));
    let provenance = match machine.provenance.as_str() {
        "" => provenance,
        before => format!("{before}; {provenance}"),
    };
    machine.to_be_changed(provenance)
}

fn word(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::NothingMissing => "nothing_missing",
        Verdict::Explained => "explained",
        Verdict::Ambiguous => "ambiguous",
        Verdict::Unknown => "unknown",
    }
}

fn is_of_another_program(error: &AlignmentError) -> bool {
    matches!(
        error,
        AlignmentError::NowhereNear
            | AlignmentError::OffPath { hint: None, .. }
            | AlignmentError::OtherWay { .. }
            | AlignmentError::LinesDoNotFit { .. }
            | AlignmentError::StopsDoNotFit { .. }
            | AlignmentError::TooFast { .. }
            | AlignmentError::WaysDoNotFit { .. }
    )
}

/// Returns the row of a cause with its `seconds` as in the account.
fn cause(cause: &Cause, seconds: f64) -> CauseRow {
    let candidate = &cause.candidate;
    let hypothesis = &candidate.hypothesis;
    let effect = hypothesis.effect;
    let values = hypothesis.reported(&candidate.values, &candidate.deviations);
    let told_with =
        |seconds: f64| (effect.sentence)(&Finding { values: &values, lines: &cause.lines, seconds });
    let key = |value: &ReportedValue| value.quantity.key.to_string();
    CauseRow {
        effect,
        id: effect.id,
        sentence: told_with(seconds),
        clause: clause_of(&told_with(0.0)),
        name: hypothesis.name(),
        told: parameter_texts(&values),
        parameters: values.iter().map(|value| (key(value), written(&value.value))).collect(),
        uncertainty: (values.iter())
            .filter_map(|value| Some((key(value), json!(value.deviation?))))
            .collect(),
        lines: cause.lines.iter().map(|(first, last)| [*first, *last]).collect(),
        seconds: Some(seconds),
        position_mm: (0.0 < cause.form).then_some(cause.form),
        confidence: Some(cause.confidence.clamp(0.0, 1.0)),
        indistinguishable_from: cause.alike.clone(),
        vendors: effect.vendors,
        sections: cause.held_out.map(|held_out| [held_out.better, held_out.worse]),
    }
}

/// Returns the message that names the probe for the first cause that others cannot be told from; `None` if there is none.
fn probe_message(diagnosis: &Diagnosis) -> Option<String> {
    let of = |cause: &Cause| Some((cause.candidate.hypothesis.clone(), cause.alike.first()?.clone()));
    let (own, other) =
        diagnosis.causes.iter().find_map(of).filter(|_| diagnosis.verdict == Verdict::Ambiguous)?;
    let is_of_axis = other.starts_with(&format!("{} (", own.effect.id));
    let own = own.effect.id_on(own.axes().as_deref().filter(|_| is_of_axis));
    Some(format!(
        "A short probe program separates these causes: truefeed probe --between \"{own}\" \"{other}\"."
    ))
}

/// Returns a sentence as a clause of another one.
fn clause_of(sentence: &str) -> String {
    let mut letters = sentence.trim_end_matches('.').chars();
    letters.next().into_iter().flat_map(char::to_lowercase).chain(letters).collect()
}

fn written(value: &Reported) -> Value {
    match value {
        Reported::Number(number) if is_whole(*number) => json!(*number as i64),
        Reported::Number(number) => json!(number),
        Reported::List(numbers) => json!(numbers),
        Reported::Word(word) => json!(word),
    }
}

fn region(region: &Region) -> RegionRow {
    RegionRow {
        lines: [region.lines.0, region.lines.1],
        distance_mm: [region.distance.start, region.distance.end],
        time_s: [region.time.start, region.time.end],
        seconds: region.seconds,
        run: region.run,
    }
}

fn sides(diagnosis: &Diagnosis, of: impl Fn(&[Comparison]) -> Option<f64>) -> BeforeAfter {
    BeforeAfter { before: of(&diagnosis.before), after: of(&diagnosis.after) }
}

/// Returns the RMS of the feedrate error over all runs, mm/min.
fn feed_rmse(side: &[Comparison]) -> Option<f64> {
    let mut pooled = PooledFeedError::default();
    side.iter().for_each(|comparison| pooled.add(comparison.feed));
    pooled.rms().map(mm_per_min)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_refusal_says_each_sentence_once_and_what_to_do() {
        for (error, advice) in [
            (AlignmentError::TimeUnit { recorded: 0.002, simulated: 1.8 }, "State the unit"),
            (AlignmentError::NowhereNear, "Choose the program that ran"),
        ] {
            let text = DiagnosisReport::not_comparable(&error).to_text();
            let lines: Vec<&str> = text.lines().collect();
            assert_eq!((lines.len(), lines[0]), (2, &*sentence_of(&error.to_string())), "{text}");
            assert!(lines[1].starts_with(advice), "{text}");
        }
    }
}
