//! A diagnosis as JSON and as text: the sentence that says it, then what, where, how sure, what else it
//! could be, and by how much the fit improves. The form of the JSON is fixed; more fields may be added.

mod account;
mod chart;
mod html;
mod sentence;
mod told;

pub use chart::{RunChart, diagnosis_chart};

use serde::Serialize;
use serde_json::{Map, Value, json};

use crate::identification::alignment::{Alignment, AlignmentError};
use crate::identification::comparison::Comparison;
use crate::identification::diagnosis::{Cause, Diagnosis, Pulsation, Region, Verdict};
use crate::identification::effects::{Effect, Finding, Reported, ReportedValue, WRONG_PROGRAM, is_whole};
use crate::machine::Machine;
use crate::project::calibrated_view::rounded;
use crate::project::comparison::{Refusal, sentence_of};
use crate::project::diagnosis::account::{AccountRow, in_seconds};
use crate::project::diagnosis::sentence::sentence;
use crate::project::diagnosis::told::{Change, Told, changes, told};
use crate::project::form::values;
use crate::project::results::spacing_note;
use crate::units::mm_per_min;

/// Digits of what is changed in the form.
const DIGITS: usize = 6;
/// Regions that are told as text.
const TOLD: usize = 8;

/// What was found, for people and programs.
#[derive(Clone, Debug, Serialize)]
pub struct DiagnosisReport {
    verdict: &'static str,
    /// What the user reads first.
    sentence: String,
    causes: Vec<CauseRow>,
    /// How the simulated time becomes the recorded one; null where nothing is compared.
    account: Option<AccountRow>,
    regions: Vec<RegionRow>,
    fit: Fit,
    not_excited: Vec<String>,
    /// A pace that rises and falls with time; null where it does not.
    pulsation: Option<PulsationRow>,
    /// Where the first recording lies; null where nothing is compared.
    alignment: Option<AlignmentRow>,
    messages: Vec<String>,
    /// The extended machine as a filled form; null where nothing is compared.
    values: Option<Map<String, Value>>,
    /// What the extended machine has otherwise than the machine before, as in the form.
    changes: Vec<Change>,
    /// Names of the recordings, in the order of `run`.
    runs: Vec<String>,
}

/// How often, and by what part of the feedrate.
#[derive(Clone, Copy, Debug, Serialize)]
struct PulsationRow {
    frequency_hz: f64,
    depth: f64,
}

/// How a recording lies on its program.
#[derive(Clone, Copy, Debug, Serialize)]
struct AlignmentRow {
    /// Recorded less programmed coordinates.
    shift_mm: [f64; 3],
    /// How often the program was run in it.
    passes: usize,
}

/// A named cause.
#[derive(Clone, Debug, Serialize)]
struct CauseRow {
    #[serde(skip)]
    effect: Effect,
    id: &'static str,
    parameters: Map<String, Value>,
    uncertainty: Map<String, Value>,
    lines: Vec<[u32; 2]>,
    /// Time it explains, s, as in the account.
    seconds: Option<f64>,
    /// Position error it explains, mm; null for causes of time.
    position_mm: Option<f64>,
    confidence: Option<f64>,
    indistinguishable_from: Vec<String>,
    /// Name for people, and which of several.
    name: String,
    /// What it is, a sentence with its numbers.
    sentence: String,
    /// The same within a sentence, without what it costs.
    #[serde(skip)]
    clause: String,
    /// What vendors call the setting; may be empty.
    vendors: &'static str,
    /// In how many stretches it was better, and worse, where it was not fitted.
    sections: Option<[usize; 2]>,
    /// The parameters with their uncertainty and units, for people.
    told: Vec<Told>,
}

/// Where simulation and recording differ.
#[derive(Clone, Debug, Serialize)]
struct RegionRow {
    lines: [u32; 2],
    distance_mm: [f64; 2],
    time_s: [f64; 2],
    seconds: f64,
    /// Which of the recordings, from 0.
    run: usize,
}

/// Before and after.
#[derive(Clone, Debug, Default, Serialize)]
struct Fit {
    feed_rmse_mm_min: Sides,
    position_rmse_mm: Sides,
    cycle_time_error_s: Sides,
    held_out: HeldOut,
}

#[derive(Clone, Debug, Default, Serialize)]
struct HeldOut {
    feed_rmse_mm_min: Sides,
}

#[derive(Clone, Copy, Debug, Default, Serialize)]
struct Sides {
    before: Option<f64>,
    after: Option<f64>,
}

impl DiagnosisReport {
    /// Of a diagnosis of the recordings with these names.
    pub fn new(diagnosis: &Diagnosis, names: &[String]) -> DiagnosisReport {
        let named = |cause: &Cause| {
            let hypothesis = &cause.candidate.hypothesis;
            (hypothesis.effect.id, hypothesis.name())
        };
        let account =
            AccountRow::new(&diagnosis.accounts, &diagnosis.causes.iter().map(named).collect::<Vec<_>>());
        let shown = account.balance.causes.iter().map(|hundredths| in_seconds(*hundredths));
        let causes: Vec<CauseRow> =
            diagnosis.causes.iter().zip(shown).map(|(own, seconds)| cause(own, seconds)).collect();
        let machine = extended(&diagnosis.machine, names);
        let mut messages: Vec<String> =
            diagnosis.messages.iter().map(|message| sentence_of(message)).collect();
        if diagnosis.verdict == Verdict::Ambiguous {
            messages.push(
                "A short probe program separates what cannot be told apart here: truefeed probe --between CAUSE CAUSE."
                    .to_string(),
            );
        }
        DiagnosisReport {
            verdict: word(diagnosis.verdict),
            sentence: sentence(diagnosis, &causes, &account.balance),
            causes,
            account: Some(account),
            regions: diagnosis.regions.iter().map(region).collect(),
            fit: Fit {
                feed_rmse_mm_min: sides(diagnosis, |side| mean_square(side, feed_error)),
                position_rmse_mm: Sides {
                    before: diagnosis.form.map(|form| form.0),
                    after: diagnosis.form.map(|form| form.1),
                },
                cycle_time_error_s: sides(diagnosis, |side| {
                    Some(side.iter().map(|side| side.whole.simulated - side.whole.recorded).sum())
                }),
                held_out: HeldOut {
                    feed_rmse_mm_min: diagnosis.held_out.map_or(Sides::default(), |held_out| Sides {
                        before: Some(mm_per_min(held_out.before)),
                        after: Some(mm_per_min(held_out.after)),
                    }),
                },
            },
            not_excited: diagnosis.not_excited.clone(),
            pulsation: diagnosis
                .pulsation
                .map(|Pulsation { frequency, depth }| PulsationRow { frequency_hz: frequency, depth }),
            alignment: None,
            messages,
            values: Some(values(&machine)),
            changes: Vec::new(),
            runs: names.to_vec(),
        }
    }

    /// Of a recording that is not of the program.
    pub fn not_comparable(error: &AlignmentError) -> DiagnosisReport {
        let reason = Refusal::from(error);
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
            fit: Fit::default(),
            not_excited: Vec::new(),
            pulsation: None,
            alignment: None,
            messages: vec![reason.to_string()],
            values: None,
            changes: Vec::new(),
            runs: Vec::new(),
        }
    }

    /// The report with where the first recording lies on its program.
    pub fn aligned(self, alignment: &Alignment) -> DiagnosisReport {
        let row = AlignmentRow { shift_mm: alignment.shift.into(), passes: alignment.passes };
        DiagnosisReport { alignment: Some(row), ..self }
    }

    /// The same beside the machine before, with what was changed in it.
    pub fn beside(self, before: &Machine) -> DiagnosisReport {
        let before = values(before);
        let values = self.values.map(|values| rounded(values, &before, DIGITS));
        let changes = values.as_ref().map_or(Vec::new(), |values| changes(&before, values));
        DiagnosisReport { values, changes, ..self }
    }

    /// The same beside a chart of each run, which may leave something out.
    pub fn drawn_by(mut self, charts: &[RunChart]) -> DiagnosisReport {
        for (chart, name) in charts.iter().zip(&self.runs) {
            let note = spacing_note(chart.spacing).map(|note| format!("Chart of {name}: {note}"));
            self.messages.extend(note);
        }
        self
    }

    /// As JSON.
    pub fn to_json(&self) -> String {
        serde_json::to_string(self).expect("strings and numbers can be written")
    }

    /// For people.
    pub fn to_text(&self) -> String {
        let mut text = self.sentence.clone();
        text.extend(self.account.iter().map(|account| format!("\n{}", account.to_text())));
        for cause in &self.causes {
            text += &format!("\n{}: {}", cause.name, cause.sentence);
            if let Some(confidence) = cause.confidence {
                text += &format!(" Confidence {:.0} %.", 100.0 * confidence);
            }
            if !cause.indistinguishable_from.is_empty() {
                let others = cause.indistinguishable_from.join(", ");
                text += &format!(" It cannot be told from {others} by this recording.");
            }
            if !cause.vendors.is_empty() {
                text += &format!(" Settings: {}.", cause.vendors);
            }
        }
        for region in self.regions.iter().take(TOLD) {
            let [first, last] = region.lines;
            text += &format!("\nlines {first} to {last}: {:+.3} s", region.seconds);
        }
        let mut row = |name: &str, sides: Sides, unit: &str, decimals: usize| {
            if let (Some(before), Some(after)) = (sides.before, sides.after) {
                text += &format!("\n{name}: {before:.decimals$} → {after:.decimals$} {unit}");
            }
        };
        row("cycle time, simulated less recorded", self.fit.cycle_time_error_s, "s", 3);
        row("feed RMSE", self.fit.feed_rmse_mm_min, "mm/min", 1);
        row("feed RMSE where nothing was fitted", self.fit.held_out.feed_rmse_mm_min, "mm/min", 1);
        row("position RMSE", self.fit.position_rmse_mm, "mm", 4);
        if !self.not_excited.is_empty() {
            text += &format!("\nnot excited by this program: {}", self.not_excited.join(", "));
        }
        self.messages.iter().fold(text, |text, message| text + "\n" + message)
    }
}

/// The machine with the causes, which says where they come from.
pub fn extended(machine: &Machine, names: &[String]) -> Machine {
    let provenance = format!("extended by a diagnosis of {}", names.join(", "));
    let provenance = match machine.provenance.as_str() {
        "" => provenance,
        before => format!("{before}; {provenance}"),
    };
    // What it was off by before is not what it is off by now.
    Machine {
        provenance,
        cycle_time_error: None,
        unexplained_time: None,
        form_error: None,
        calibrated_at: Vec::new(),
        ..machine.clone()
    }
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

/// A cause with its `seconds` as the account shows them.
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
        told: told(&values),
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

/// A sentence as a part of another one.
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

fn sides(diagnosis: &Diagnosis, of: impl Fn(&[Comparison]) -> Option<f64>) -> Sides {
    Sides { before: of(&diagnosis.before), after: of(&diagnosis.after) }
}

/// Squares and the way they were taken over.
fn feed_error(comparison: &Comparison) -> Option<(f64, f64)> {
    comparison.feed.map(|feed| (mm_per_min(feed.rms), feed.way))
}

fn mean_square(side: &[Comparison], of: fn(&Comparison) -> Option<(f64, f64)>) -> Option<f64> {
    let (squares, way) = side
        .iter()
        .filter_map(of)
        .fold((0.0, 0.0), |(squares, way), (rms, own)| (squares + own * rms * rms, way + own));
    (0.0 < way).then(|| f64::sqrt(squares / way))
}
