//! Scores the reports of `truefeed diagnose --json` beside the answers, which are sealed unless they are
//! somebody else's.
//!
//! Top-1: the first cause is the one concealed. Set: it is the first, or among those the first cannot be told
//! from. Strength is in multiples of a rough detection limit, fixed before. Localisation is the overlap of
//! the lines named with those whose duration changed, |A ∩ B| / |A ∪ B|. A parameter is covered where the
//! truth lies within 1.645 standard deviations: 90 % should be. A missing report counts as a wrong one.
//!
//! On the second program of a case, which nobody was fitted to, the errors of the diagnosis stand beside
//! those of its rivals, in percent of the cycle time recorded.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::path::Path;

use serde_json::Value;
use sha2::{Digest, Sha256};

use crate::effects::OUTSIDE;

type Refusal = Box<dyn std::error::Error>;

/// A count of successes.
#[derive(Default, Clone, Copy)]
struct Rate {
    hits: usize,
    of: usize,
}

impl Rate {
    fn add(&mut self, hit: bool) {
        self.hits += usize::from(hit);
        self.of += 1;
    }

    fn words(self) -> String {
        if self.of == 0 { "–".into() } else { format!("{} of {}", self.hits, self.of) }
    }
}

/// What one case came to.
pub struct Outcome {
    /// The folder of the case.
    pub name: String,
    /// What kind of case it was drawn as.
    pub stratum: String,
    /// What is concealed.
    pub effect: String,
    /// How strongly, in detection limits.
    pub strength: f64,
    missing: bool,
    unknown: bool,
    /// Whether it was named first.
    pub top: bool,
    set: bool,
    set_size: usize,
    named: usize,
    overlap: Option<f64>,
    parameter_errors: Vec<f64>,
    covered: Vec<bool>,
    /// Held-out feed RMSE before and after, mm/min.
    pub feed: Option<(f64, f64)>,
    cycle: Option<(f64, f64)>,
    /// What the diagnosis took, s.
    seconds: Option<f64>,
    /// Errors on the second program; null where there is none.
    pub transfer: Value,
}

impl Outcome {
    /// By what part of the cycle time a rival is wrong on the second program.
    pub fn transfer_error(&self, rival: &str) -> Option<f64> {
        let error = self.transfer[rival]["cycle_time_error_s"].as_f64()?;
        Some((error / self.transfer["recorded_s"].as_f64()?).abs())
    }
}

/// Those that speak of the second program, as `proof` calls them and as people do.
pub const RIVALS: [(&str, &str); 5] = [
    ("believed", "machine file as believed"),
    ("factor", "one factor for the cycle time"),
    ("refit", "T1 and tolerance refitted"),
    ("nearest", "five nearest blocks, no physics"),
    ("diagnosis", "the diagnosis"),
];

/// The tables as Markdown. `folder` holds the cases and `answers.json`, `reports` has
/// `case-NN/report.json`.
pub fn page(folder: &Path, reports: &Path) -> Result<String, Refusal> {
    let (seal, outcomes) = outcomes(folder, reports)?;
    let mut text = format!("Answers {seal}, {} cases.\n\n", outcomes.len());
    summary(&outcomes, &mut text);
    if outcomes.iter().any(|outcome| 0.0 < outcome.strength) {
        strengths(&outcomes, &mut text);
    }
    effects(&outcomes, &mut text);
    if outcomes.iter().any(|outcome| outcome.transfer.is_object()) {
        rivals(&outcomes, &mut text);
    }
    Ok(text)
}

/// How the answers were kept, and what each case came to.
pub fn outcomes(folder: &Path, reports: &Path) -> Result<(String, Vec<Outcome>), Refusal> {
    let sealed = std::fs::read(folder.join("answers.json"))?;
    let seal: String = Sha256::digest(&sealed).iter().map(|byte| format!("{byte:02x}")).collect();
    let sealed_as = std::fs::read_to_string(folder.join("sealed.txt")).ok();
    if sealed_as.as_ref().is_some_and(|noted| !noted.starts_with(&seal)) {
        return Err("answers.json is not the one that was sealed".into());
    }
    let answers: BTreeMap<String, Value> = serde_json::from_slice(&sealed)?;
    let mut outcomes = Vec::new();
    for (name, answer) in &answers {
        let read = |file: &str| -> Result<Value, Refusal> {
            match std::fs::read(reports.join(name).join(file)) {
                Ok(bytes) => {
                    Ok(serde_json::from_slice(&bytes).map_err(|fault| format!("{name}/{file}: {fault}"))?)
                }
                Err(_) => Ok(Value::Null),
            }
        };
        let transfer = read("transfer.json")?;
        let name = name.clone();
        outcomes.push(Outcome { name, transfer, ..outcome(answer, &read("report.json")?) });
    }
    let manner = if sealed_as.is_some() { "sealed as" } else { "not sealed, SHA-256" };
    Ok((format!("{manner} `{seal}`"), outcomes))
}

fn outcome(answer: &Value, report: &Value) -> Outcome {
    let none = serde_json::Map::new();
    let truth = answer["effects"].as_object().unwrap_or(&none);
    let causes: Vec<&Value> = report["causes"].as_array().map_or(vec![], |all| all.iter().collect());
    let id = |cause: &Value| cause["id"].as_str().unwrap_or_default().to_string();
    let set_of = |cause: &Value| -> BTreeSet<String> {
        let alike = cause["indistinguishable_from"].as_array().into_iter().flatten();
        alike.map(|other| other.as_str().map_or_else(|| id(other), String::from)).chain([id(cause)]).collect()
    };
    let ambiguous = report["verdict"] == "ambiguous";
    let mut first: BTreeSet<String> = causes.first().map(|cause| set_of(cause)).unwrap_or_default();
    if ambiguous {
        first.extend(causes.iter().map(|cause| id(cause)));
    }
    let leading: BTreeSet<String> = causes.iter().take(truth.len()).map(|cause| id(cause)).collect();
    let accepted: Vec<&str> =
        answer["accepted"].as_array().into_iter().flatten().filter_map(Value::as_str).collect();
    let strata_ambiguous = answer["stratum"] == "ambiguous";
    // `wrong_program` may also be said as a verdict.
    let refused = report["verdict"] == "not_comparable" && truth.contains_key("wrong_program");
    let top = match answer["stratum"].as_str() {
        Some("planner") => leading.iter().any(|k| accepted.contains(&k.as_str())),
        _ => refused || !truth.is_empty() && truth.keys().all(|k| leading.contains(k)),
    };
    // A feed that swings by itself may also be called adaptive.
    let adaptive = truth.contains_key("feed_modulation") && leading.contains("adaptive_feed");
    let set = match strata_ambiguous {
        true => accepted.iter().all(|k| first.contains(*k)),
        false if truth.len() == 1 => top || truth.keys().all(|k| first.contains(k)),
        false => top,
    };
    let mut result = Outcome {
        name: String::new(),
        stratum: stratum(answer, truth),
        effect: truth.keys().cloned().collect::<Vec<_>>().join(" + "),
        strength: answer["strength"].as_f64().unwrap_or(0.0),
        missing: report.is_null(),
        unknown: report["verdict"] == "unknown" || adaptive,
        top,
        set,
        set_size: first.len(),
        named: causes.len(),
        overlap: None,
        parameter_errors: vec![],
        covered: vec![],
        feed: pair(&report["fit"]["held_out"]["feed_rmse_mm_min"]),
        cycle: pair(&report["fit"]["cycle_time_error_s"]),
        seconds: report["seconds_of_diagnosis"].as_f64(),
        transfer: Value::Null,
    };
    for (name, parameters) in truth {
        let Some(cause) = causes.iter().find(|cause| id(cause) == *name) else { continue };
        if let (Some(real), Some(found)) = (real_lines(&answer["lines"][name]), lines_in(&cause["lines"])) {
            let common = real.intersection(&found).count() as f64;
            result.overlap = Some(common / real.union(&found).count().max(1) as f64);
        }
        compare(parameters, cause, &mut result);
    }
    result
}

/// As it was drawn; of answers by others, by what they conceal.
fn stratum(answer: &Value, truth: &serde_json::Map<String, Value>) -> String {
    if let Some(drawn) = answer["stratum"].as_str() {
        return drawn.into();
    }
    match truth.len() {
        0 => "negative".into(),
        1 if truth.keys().all(|id| OUTSIDE.contains(&id.as_str())) => "outside".into(),
        1 => "single".into(),
        _ => "double".into(),
    }
}

/// Numbers that both know; places in the program are judged by the overlap of lines instead.
fn compare(parameters: &Value, cause: &Value, result: &mut Outcome) {
    for (key, value) in parameters.as_object().into_iter().flatten() {
        let Some(real) = value.as_f64().filter(|_| !key.contains("line")) else { continue };
        let Some(found) = cause["parameters"][key].as_f64() else { continue };
        result.parameter_errors.push((found / real - 1.0).abs());
        if let Some(deviation) = cause["uncertainty"][key].as_f64() {
            result.covered.push((found - real).abs() <= 1.645 * deviation);
        }
    }
}

fn pair(value: &Value) -> Option<(f64, f64)> {
    Some((value["before"].as_f64()?, value["after"].as_f64()?))
}

/// The lines of an answer; nothing where the effect acts everywhere.
fn real_lines(value: &Value) -> Option<BTreeSet<i64>> {
    let lines: BTreeSet<i64> = value.as_array()?.iter().filter_map(Value::as_i64).collect();
    (!lines.contains(&-1)).then_some(lines)
}

/// The lines of a report, written as ranges.
fn lines_in(value: &Value) -> Option<BTreeSet<i64>> {
    let ranges = value.as_array()?.iter();
    Some(
        ranges
            .filter_map(|r| Some(r[0].as_i64()?..=r[1].as_i64()?.min(r[0].as_i64()? + 1_000_000)))
            .flatten()
            .collect(),
    )
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

fn shown(value: Option<f64>, decimals: usize) -> String {
    value.map_or("–".into(), |v| format!("{v:.decimals$}"))
}

fn percent(value: Option<f64>) -> String {
    value.map_or("–".into(), |v| format!("{:.1} %", 100.0 * v))
}

/// The share of those that hold.
fn share(of: impl Iterator<Item = bool>) -> Option<f64> {
    let all: Vec<bool> = of.collect();
    (!all.is_empty()).then(|| all.iter().filter(|hit| **hit).count() as f64 / all.len() as f64)
}

fn rate<'a>(outcomes: impl Iterator<Item = &'a Outcome>, hit: impl Fn(&Outcome) -> bool) -> Rate {
    let mut rate = Rate::default();
    outcomes.for_each(|outcome| rate.add(!outcome.missing && hit(outcome)));
    rate
}

fn summary(outcomes: &[Outcome], text: &mut String) {
    let of = |stratum: &'static str| outcomes.iter().filter(move |o| o.stratum == stratum);
    let mut row =
        |name: &str, value: String| writeln!(text, "| {name} | {value} |").expect("text takes any length");
    row("what", "figure".into());
    row("---", "---:".into());
    row("single causes named first", rate(of("single"), |o| o.top).words());
    row("single causes named in the set", rate(of("single"), |o| o.set).words());
    row(
        "median size of the set",
        shown(median(of("single").filter(|o| o.set).map(|o| o.set_size as f64).collect()), 0),
    );
    row("negatives with a cause named", rate(of("negative"), |o| 0 < o.named).words());
    row("doubles, both named", rate(of("double"), |o| o.top).words());
    row("planners of another family, limits named", rate(of("planner"), |o| o.top).words());
    row("outside the library, called unknown", rate(of("outside"), |o| o.unknown).words());
    row("ambiguous by design, the whole set", rate(of("ambiguous"), |o| o.set).words());
    let overlaps = outcomes.iter().filter_map(|o| o.overlap).collect();
    row("median overlap of lines", shown(median(overlaps), 2));
    let errors = outcomes.iter().flat_map(|o| o.parameter_errors.clone()).collect();
    row("median error of a parameter", percent(median(errors)));
    row("parameters within their 90 %", percent(share(outcomes.iter().flat_map(|o| o.covered.clone()))));
    let held =
        |pick: fn((f64, f64)) -> f64| median(outcomes.iter().filter_map(|o| o.feed.map(pick)).collect());
    row("held-out feed RMSE before, mm/min", shown(held(|p| p.0), 1));
    row("held-out feed RMSE after, mm/min", shown(held(|p| p.1), 1));
    let cycle =
        |pick: fn((f64, f64)) -> f64| median(outcomes.iter().filter_map(|o| o.cycle.map(pick)).collect());
    row("cycle-time error before, s", shown(cycle(|p| p.0.abs()), 3));
    row("cycle-time error after, s", shown(cycle(|p| p.1.abs()), 3));
    let floor = of("negative").filter_map(|o| o.cycle.map(|p| p.0.abs())).reduce(f64::max);
    row("floor: largest cycle-time error before, nothing concealed, s", shown(floor, 3));
    row(
        "median time of a diagnosis, s",
        shown(median(outcomes.iter().filter_map(|o| o.seconds).collect()), 1),
    );
    row(
        "reports missing",
        format!("{} of {}", outcomes.iter().filter(|o| o.missing).count(), outcomes.len()),
    );
}

fn strengths(outcomes: &[Outcome], text: &mut String) {
    *text += "\n| strength, detection limits | first | in the set |\n| --- | ---: | ---: |\n";
    for (low, high) in [(0.0, 1.0), (1.0, 3.0), (3.0, f64::INFINITY)] {
        let of =
            || outcomes.iter().filter(move |o| o.stratum == "single" && (low..high).contains(&o.strength));
        let (top, set) = (rate(of(), |o| o.top).words(), rate(of(), |o| o.set).words());
        let name = if high.is_finite() { format!("{low} to {high}") } else { format!("above {low}") };
        writeln!(text, "| {name} | {top} | {set} |").expect("text takes any length");
    }
}

fn effects(outcomes: &[Outcome], text: &mut String) {
    *text += "\n| effect | first | in the set | overlap | parameter error | within 90 % |\n";
    *text += "| --- | ---: | ---: | ---: | ---: | ---: |\n";
    let mut by_effect: BTreeMap<&str, Vec<&Outcome>> = BTreeMap::new();
    for outcome in outcomes.iter().filter(|o| o.stratum == "single") {
        by_effect.entry(&outcome.effect).or_default().push(outcome);
    }
    for (effect, group) in by_effect {
        let of = || group.iter().copied();
        let (top, set) = (rate(of(), |o| o.top).words(), rate(of(), |o| o.set).words());
        let overlap = shown(median(of().filter_map(|o| o.overlap).collect()), 2);
        let error = percent(median(of().flat_map(|o| o.parameter_errors.clone()).collect()));
        let covered = percent(share(of().flat_map(|o| o.covered.clone())));
        writeln!(text, "| {effect} | {top} | {set} | {overlap} | {error} | {covered} |")
            .expect("text takes any length");
    }
}

/// What each says of the second programs: where a cause was concealed and named first, where it was not,
/// and where there was none.
fn rivals(outcomes: &[Outcome], text: &mut String) {
    *text +=
        "\nOn another program at twice the tolerance, where what is concealed belongs to the machine:\n\n";
    *text +=
        "| | median error of cycle time | worst | median feed RMSE, mm/min |\n| --- | ---: | ---: | ---: |\n";
    type Kind = fn(&Outcome) -> bool;
    let kinds: [(&str, Kind); 3] = [
        ("cause found", |o| o.top),
        ("cause not found", |o| !o.effect.is_empty() && !o.top),
        ("nothing concealed", |o| o.effect.is_empty()),
    ];
    for (kind, is_meant) in kinds {
        let of = || outcomes.iter().filter(move |o| o.transfer.is_object() && is_meant(o));
        writeln!(text, "| **{kind}, {} cases** | | | |", of().count()).expect("text takes any length");
        for (key, name) in RIVALS {
            let errors: Vec<f64> = of().filter_map(|o| o.transfer_error(key)).collect();
            let worst = errors.iter().copied().reduce(f64::max);
            let feed = median(of().filter_map(|o| o.transfer[key]["feed_rmse_mm_min"].as_f64()).collect());
            let (middle, worst) = (hundredths(median(errors)), hundredths(worst));
            writeln!(text, "| {name} | {middle} | {worst} | {} |", shown(feed, 1))
                .expect("text takes any length");
        }
    }
}

fn hundredths(value: Option<f64>) -> String {
    value.map_or("–".into(), |v| format!("{:.2} %", 100.0 * v))
}
