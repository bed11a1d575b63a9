//! The figures: rates with their intervals, tables by kind, and the list of what went wrong.

use std::collections::BTreeMap;
use std::fmt::Write;

use serde_json::{Value, json};
use truefeed::quote::UnshownFeature;

use crate::interval::clopper_pearson;

/// Edges between the bins of "x % sure".
const BINS: [f64; 5] = [0.5, 0.7, 0.9, 0.97, 1.0 + 1e-9];

/// A count with the interval in which its rate lies nine times in ten.
pub fn rate(hits: usize, of: usize) -> Value {
    if of == 0 {
        return json!({ "hits": 0, "of": 0 });
    }
    let (low, high) = clopper_pearson(hits, of);
    json!({ "hits": hits, "of": of, "low_90": low, "high_90": high })
}

fn is(case: &Value, key: &str, value: &str) -> bool {
    case[key] == value
}

/// The causes that a case names.
fn named(case: &Value) -> impl Iterator<Item = &Value> {
    case["named"].as_array().into_iter().flatten()
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let upper = *values.get(values.len() / 2)?;
    Some(0.5 * (upper + values[(values.len() - 1) / 2]))
}

fn largest(values: &[f64]) -> Option<f64> {
    values.iter().copied().max_by(f64::total_cmp)
}

/// Everything that is reported, case by case and in sum.
pub fn results(answers: &Value, cases: Vec<Value>, transfers: Vec<Value>) -> Value {
    let role = |role: &'static str| cases.iter().filter(move |case| is(case, "role", role));
    let count = |role: &'static str, outcome: &'static str| {
        let of: Vec<&Value> = cases.iter().filter(|case| is(case, "role", role)).collect();
        rate(of.iter().filter(|case| is(case, "outcome", outcome)).count(), of.len())
    };
    let changes = |visible: bool, outcome: &'static str| {
        let of: Vec<&Value> = role("change").filter(|case| case["visible"] == visible).collect();
        rate(of.iter().filter(|case| is(case, "outcome", outcome)).count(), of.len())
    };
    let right = |case: &&Value| is(case, "outcome", "first") || is(case, "outcome", "later");
    let found: Vec<&Value> = cases.iter().filter(right).collect();
    let extra = |case: &&&Value| named(case).any(|cause| cause["right"] == false);
    let by = |own: bool, probed: bool| {
        transfers.iter().filter(move |one| one["own"] == own && (one["probed"] == true) == probed)
    };
    let seconds = |role: &'static str| -> Vec<f64> {
        cases
            .iter()
            .filter(|case| is(case, "role", role))
            .filter_map(|case| case["seconds"].as_f64())
            .collect()
    };
    let by_outcome = |visible: bool| -> Value {
        let all = ["first", "later", "wrong", "silent", "unknown", "refused"];
        all.iter()
            .map(|outcome| (outcome.to_string(), changes(visible, outcome)))
            .collect::<serde_json::Map<_, _>>()
            .into()
    };
    json!({
        "seed": answers["seed"],
        "clean_with_a_name": count("clean", "named"),
        "clean_unknown": count("clean", "unknown"),
        "clean_refused": count("clean", "refused"),
        "other_clean_with_a_name": count("other", "named"),
        "other_clean_refused": count("other", "refused"),
        "other_clean_unknown": count("other", "unknown"),
        "changes_visible": by_outcome(true),
        "changes_not_visible": by_outcome(false),
        "false_second_causes": rate(found.iter().filter(extra).count(), found.len()),
        "sure": sureness(&cases),
        "by_kind": by_kind(&cases),
        "by_program_kind": by_program_kind(&cases, &transfers),
        "transfer": errors(by(false, false), "error"),
        "range": ranges(by(false, false)),
        "transfer_of_preset": errors(by(true, false), "error_of_preset"),
        "own": errors(by(true, false), "error"),
        "preset_with_a_name": count("preset", "named"),
        "preset_unknown": count("preset", "unknown"),
        "preset_refused": count("preset", "refused"),
        "probed_with_a_name": count("probed", "named"),
        "probed_unknown": count("probed", "unknown"),
        "probed_refused": count("probed", "refused"),
        "transfer_of_probe": errors(by(false, true), "error"),
        "range_of_probe": ranges(by(false, true)),
        "transfer_of_shown_words": errors(by(false, false).filter(shows_words), "error"),
        "range_of_shown_words": ranges(by(false, false).filter(shows_words)),
        "transfer_of_probe_of_shown_words": errors(by(false, true).filter(shows_words), "error"),
        "range_of_probe_of_shown_words": ranges(by(false, true).filter(shows_words)),
        "seconds_of_clean": { "median": median(seconds("clean")), "worst": largest(&seconds("clean")) },
        "seconds_of_change": { "median": median(seconds("change")), "worst": largest(&seconds("change")) },
        "cases": cases,
        "transfers": transfers,
    })
}

/// Returns `true` if the calibration showed every M word of the program: it knows nothing of the time of another one.
fn shows_words(transfer: &&Value) -> bool {
    let mut unshown = transfer["unshown"].as_array().into_iter().flatten();
    !unshown.any(|one| one["what"] == UnshownFeature::MWords.words())
}

/// The median and the largest of relative errors, and how many there are.
fn errors<'a>(transfers: impl Iterator<Item = &'a Value>, key: &str) -> Value {
    let all: Vec<f64> = transfers.filter_map(|transfer| transfer[key].as_f64()).map(f64::abs).collect();
    json!({ "of": all.len(), "worst": largest(&all), "median": median(all) })
}

/// How many times of other programs lie within the range that the machine file states, and half its width.
fn ranges<'a>(transfers: impl Iterator<Item = &'a Value>) -> Value {
    // A range that is no number tells nothing, so it is as wide as can be and does not count as held.
    let of = |transfer: &Value| {
        Some((transfer["error"].as_f64()?, transfer["range"].as_f64().unwrap_or(f64::INFINITY)))
    };
    let stated: Vec<(f64, f64)> = transfers.filter_map(of).collect();
    // The error is a part of the recorded time, the range one of the predicted time.
    let is_held = |error: f64, half: f64| half.is_finite() && error.abs() <= half * (1.0 + error);
    let held = stated.iter().filter(|(error, half)| is_held(*error, *half)).count();
    json!({ "held": rate(held, stated.len()), "median_half_width": median(stated.iter().map(|(_, half)| *half).collect()) })
}

/// The confidence of each named cause, and whether it is right.
pub fn judged<'a>(cases: impl Iterator<Item = &'a Value>) -> Vec<(f64, bool)> {
    cases
        .flat_map(named)
        .filter_map(|cause| Some((cause["confidence"].as_f64()?, cause["right"] == true)))
        .collect()
}

/// The mean square of confidence less truth, which is 0 or 1.
pub fn brier(judged: &[(f64, bool)]) -> f64 {
    let squares = judged.iter().map(|(sure, right)| (sure - f64::from(u8::from(*right))).powi(2));
    squares.sum::<f64>() / judged.len().max(1) as f64
}

/// How "x % sure" agrees with what is true: over the causes named in clean runs and in changes.
fn sureness(cases: &[Value]) -> Value {
    let runs = cases.iter().filter(|case| is(case, "role", "clean") || is(case, "role", "change"));
    let judged = judged(runs);
    let brier = brier(&judged);
    let mut from = 0.0;
    let mut bins = Vec::new();
    for to in BINS {
        let inside: Vec<&(f64, bool)> =
            judged.iter().filter(|(sure, _)| from <= *sure && *sure < to).collect();
        let mean = inside.iter().map(|(sure, _)| sure).sum::<f64>() / inside.len().max(1) as f64;
        let right = inside.iter().filter(|(_, right)| *right).count();
        bins.push(json!({ "from": from, "to": to, "mean": mean, "right": rate(right, inside.len()) }));
        from = to;
    }
    json!({ "causes": judged.len(), "brier": brier, "bins": bins })
}

/// Outcomes of the changes, by what was changed and whether it can be seen.
fn by_kind(cases: &[Value]) -> Value {
    let mut counts: BTreeMap<(String, bool), BTreeMap<String, usize>> = BTreeMap::new();
    for case in cases.iter().filter(|case| is(case, "role", "change")) {
        let kind = case["kind"].as_str().unwrap_or_default().to_string();
        let outcome = case["outcome"].as_str().unwrap_or_default().to_string();
        *counts.entry((kind, case["visible"] == true)).or_default().entry(outcome).or_default() += 1;
    }
    counts
        .into_iter()
        .map(|((kind, visible), outcomes)| json!({ "kind": kind, "visible": visible, "outcomes": outcomes }))
        .collect::<Vec<_>>()
        .into()
}

/// False names and transfer errors, by the kind of program that was run.
fn by_program_kind(cases: &[Value], transfers: &[Value]) -> Value {
    let mut kinds: Vec<&str> = cases.iter().filter_map(|case| case["program_kind"].as_str()).collect();
    kinds.sort_unstable();
    kinds.dedup();
    let row = |kind: &&str| {
        let of = |role: &'static str| {
            cases.iter().filter(move |case| is(case, "role", role) && is(case, "program_kind", kind))
        };
        let there = transfers.iter().filter(|one| is(one, "program_kind", kind) && one["probed"] != true);
        let (own, others): (Vec<&Value>, Vec<&Value>) = there.partition(|transfer| transfer["own"] == true);
        json!({
            "kind": kind,
            "clean": of("clean").count(),
            "clean_with_a_name": of("clean").filter(|case| is(case, "outcome", "named")).count(),
            "other": of("other").count(),
            "other_with_a_name": of("other").filter(|case| is(case, "outcome", "named")).count(),
            "changes_visible": of("change").filter(|case| case["visible"] == true).count(),
            "first_visible":
                of("change").filter(|case| case["visible"] == true && is(case, "outcome", "first")).count(),
            "own_error": errors(own.into_iter(), "error"),
            "transfer": errors(others.into_iter(), "error"),
        })
    };
    kinds.iter().map(row).collect::<Vec<_>>().into()
}

fn rate_words(rate: &Value) -> String {
    rate_text(rate, 0)
}

/// As in "3 of 95 (1 to 8 %)", with so many decimals in the interval.
pub fn rate_text(rate: &Value, decimals: usize) -> String {
    let share =
        |key: &str| rate[key].as_f64().map_or("–".into(), |part| format!("{:.decimals$}", 100.0 * part));
    match rate["of"].as_u64() {
        None | Some(0) => "–".into(),
        Some(of) => format!("{} of {of} ({} to {} %)", rate["hits"], share("low_90"), share("high_90")),
    }
}

fn percent(value: &Value) -> String {
    value.as_f64().map_or("–".into(), |part| format!("{:.2} %", 100.0 * part))
}

/// The tables as Markdown, from the results alone.
pub fn page(results: &Value) -> String {
    let mut text = format!(
        "Seed {}, {}; rates with their 90 % interval.\n\n| what | figure |\n| --- | ---: |\n",
        results["seed"],
        results["truefeed"].as_str().unwrap_or_default()
    );
    let mut row =
        |what: &str, figure: String| writeln!(text, "| {what} | {figure} |").expect("text takes any length");
    let refused = results["calibrations"]["refused"].as_array().map_or(0, Vec::len);
    row("calibrations refused", format!("{refused} of {}", results["calibrations"]["of"]));
    row("limits of axes within the 90 % interval stated", rate_words(&results["limits_within"]));
    row("clean runs in which a cause is named", rate_words(&results["clean_with_a_name"]));
    row("clean runs called unknown", rate_words(&results["clean_unknown"]));
    row("clean runs refused", rate_words(&results["clean_refused"]));
    row(
        "clean runs of another program in which a cause is named",
        rate_words(&results["other_clean_with_a_name"]),
    );
    row("clean runs of another program refused", rate_words(&results["other_clean_refused"]));
    row("clean runs of another program called unknown", rate_words(&results["other_clean_unknown"]));
    for outcome in ["first", "later", "wrong", "silent", "unknown", "refused"] {
        row(&format!("visible changes: {outcome}"), rate_words(&results["changes_visible"][outcome]));
    }
    for outcome in ["first", "later", "wrong", "silent", "unknown", "refused"] {
        row(
            &format!("changes below what can be seen: {outcome}"),
            rate_words(&results["changes_not_visible"][outcome]),
        );
    }
    row("right ones with a false cause beside", rate_words(&results["false_second_causes"]));
    for (what, key) in [
        ("cycle time of the program calibrated on", "own"),
        ("cycle time by the preset", "transfer_of_preset"),
    ] {
        let part = &results[key];
        let figure =
            format!("{}, worst {}, of {}", percent(&part["median"]), percent(&part["worst"]), part["of"]);
        row(&format!("{what}, median error"), figure);
    }
    for (of, transfer, range) in [
        ("another program", "transfer", "range"),
        ("another program, its M words shown", "transfer_of_shown_words", "range_of_shown_words"),
        ("the probe", "transfer_of_probe", "range_of_probe"),
        ("the probe, the M words shown", "transfer_of_probe_of_shown_words", "range_of_probe_of_shown_words"),
    ] {
        let (errors, ranges) = (&results[transfer], &results[range]);
        let figure = format!(
            "{}, worst {}, of {}",
            percent(&errors["median"]),
            percent(&errors["worst"]),
            errors["of"]
        );
        row(&format!("cycle times by {of}, median error"), figure);
        row(&format!("cycle times by {of} within the range stated"), rate_words(&ranges["held"]));
        row("half of that range, median", percent(&ranges["median_half_width"]));
    }
    row("clean runs from the preset in which a cause is named", rate_words(&results["preset_with_a_name"]));
    row("clean runs from the preset called unknown", rate_words(&results["preset_unknown"]));
    row("clean runs from the preset refused", rate_words(&results["preset_refused"]));
    row("clean runs by the probe in which a cause is named", rate_words(&results["probed_with_a_name"]));
    row("clean runs by the probe called unknown", rate_words(&results["probed_unknown"]));
    row("clean runs by the probe refused", rate_words(&results["probed_refused"]));
    for (what, key) in [("clean run", "seconds_of_clean"), ("change", "seconds_of_change")] {
        let part = |name: &str| results[key][name].as_f64().unwrap_or(0.0);
        row(
            &format!("diagnosis of a {what}, s"),
            format!("{:.1}, worst {:.1}", part("median"), part("worst")),
        );
    }
    let sure = &results["sure"];
    row(
        "Brier score of \"x % sure\"",
        format!("{:.3}, {} causes", sure["brier"].as_f64().unwrap_or(0.0), sure["causes"]),
    );
    let is_filled = |bin: &&Value| bin["right"]["of"] != 0;
    for bin in sure["bins"].as_array().into_iter().flatten().filter(is_filled) {
        let sure = format!("said {} sure on average, right", percent(&bin["mean"]));
        row(&sure, rate_words(&bin["right"]));
    }
    tables(results, &mut text);
    list_wrong(results, &mut text);
    text
}

fn tables(results: &Value, text: &mut String) {
    let mut line = |words: String| writeln!(text, "{words}").expect("text takes any length");
    line("\n| change | visible | first | later | wrong | silent | unknown | refused |".into());
    line("| --- | --- | ---: | ---: | ---: | ---: | ---: | ---: |".into());
    for row in results["by_kind"].as_array().into_iter().flatten() {
        let cell = |outcome: &str| row["outcomes"][outcome].as_u64().unwrap_or(0).to_string();
        let cells = ["first", "later", "wrong", "silent", "unknown", "refused"].map(cell).join(" | ");
        let seen = if row["visible"] == true { "yes" } else { "no" };
        line(format!("| {} | {seen} | {cells} |", row["kind"].as_str().unwrap_or_default()));
    }
    line("\n| program | clean, named | other clean, named | visible changes, first | own | transfer, median | worst |".into());
    line("| --- | ---: | ---: | ---: | ---: | ---: | ---: |".into());
    for row in results["by_program_kind"].as_array().into_iter().flatten() {
        let of = |hits: &str, all: &str| format!("{} of {}", row[hits], row[all]);
        line(format!(
            "| {} | {} | {} | {} | {} | {} | {} |",
            row["kind"].as_str().unwrap_or_default(),
            of("clean_with_a_name", "clean"),
            of("other_with_a_name", "other"),
            of("first_visible", "changes_visible"),
            percent(&row["own_error"]["worst"]),
            percent(&row["transfer"]["median"]),
            percent(&row["transfer"]["worst"]),
        ));
    }
}

/// Each case that did not come out as it should, with what is true and what was said.
fn list_wrong(results: &Value, text: &mut String) {
    let mut line = |words: String| writeln!(text, "{words}").expect("text takes any length");
    line("\nCases that did not come out as they should:\n".into());
    for case in results["cases"].as_array().into_iter().flatten() {
        let outcome = case["outcome"].as_str().unwrap_or_default();
        let extra = named(case).any(|cause| cause["right"] == false);
        let fine = matches!((outcome, case["visible"] == true), ("silent", false) | ("first", _)) && !extra;
        if fine {
            continue;
        }
        let effect = |key: &str| case[key].as_f64().unwrap_or(0.0);
        let truth = match case["kind"].as_str() {
            Some("none") | None if is(case, "role", "preset") => "clean, from the preset".to_string(),
            Some("none") | None => "clean".to_string(),
            Some(kind) => format!(
                "{kind} {}, {:+.2} s, {:.3} mm",
                case["truth"],
                effect("effect_s"),
                effect("effect_mm")
            ),
        };
        let said: Vec<String> = named(case)
            .map(|cause| {
                let sure = 100.0 * cause["confidence"].as_f64().unwrap_or(0.0);
                let seconds = cause["seconds"].as_f64().unwrap_or(0.0);
                let id = cause["id"].as_str().unwrap_or_default();
                format!("{id} {} {seconds:+.2} s, {sure:.0} % sure", cause["parameters"])
            })
            .collect();
        let said = if said.is_empty() {
            format!("{} {}", case["verdict"], case["refused"])
        } else {
            said.join("; ")
        };
        line(format!(
            "- {} ({}, calibrated on {}): {truth} → {outcome}: {said}",
            case["case"].as_str().unwrap_or_default(),
            case["program_kind"].as_str().unwrap_or_default(),
            case["calibrated_on"].as_str().unwrap_or_default(),
        ));
    }
}
