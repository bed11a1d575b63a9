//! A request for an offer → its report for the page and as JSON. Amounts are in the currency of the terms,
//! times in s.

use serde::Deserialize;
use serde_json::{Map, Value};

use crate::machine::Machine;
use crate::project::machine::written::tidy;
use crate::project::prediction::time_range::RangeRow;
use crate::project::quote::offer::facts::{facts, uncertainty_row};
use crate::project::quote::offer::report::{
    AddendRow, Batch, Kinds, OfferReport, RemarkCounts, ShareRow, ToleranceRow,
};
use crate::project::quote::terms::terms_from_values;
use crate::project::{TextFault, machine_from_form};
use crate::quote::{Addend, AddendKind, Offer, Terms, Uncertainty, offer};
use crate::units::{MINUTES_PER_HOUR, PERCENT, SECONDS_PER_HOUR, Unit};

/// A request for an offer: filled forms of machine and terms, and runs of `predict --json`, of which times
/// and tolerance are read. The offer is for the run `chosen`; other runs are listed for comparison.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct OfferRequest {
    machine: Map<String, Value>,
    terms: Map<String, Value>,
    program: String,
    /// Date of the offer, as printed; may be empty.
    #[serde(default)]
    date: String,
    programmed_time_s: f64,
    #[serde(default)]
    remarks: RemarkCounts,
    runs: Vec<OfferedRun>,
    chosen: usize,
}

#[derive(Deserialize)]
struct OfferedRun {
    tolerance: String,
    tolerance_mm: f64,
    breakdown: Kinds,
    operations: Vec<OfferedPart>,
    tools: Vec<OfferedPart>,
    #[serde(default)]
    in_doubt: Option<String>,
    #[serde(default)]
    range: Option<RangeRow>,
}

#[derive(Deserialize)]
struct OfferedPart {
    line: Option<u32>,
    name: Option<String>,
    tool: Option<u32>,
    tool_name: Option<String>,
    time_s: f64,
}

impl OfferReport {
    /// Reads a request as JSON text and returns its offer.
    ///
    /// # Errors
    ///
    /// Returns the faults of the forms in the request.
    pub fn from_json(json: &str) -> Result<OfferReport, Vec<TextFault>> {
        let malformed = |message: String| vec![TextFault { place: None, key: None, message }];
        let mut asked: OfferRequest =
            serde_json::from_str(json).map_err(|error| malformed(error.to_string()))?;
        let machine = machine_from_form(&Value::Object(asked.machine).to_string())?;
        let terms = terms_from_values(&asked.terms)?;
        if asked.runs.len() <= asked.chosen {
            return Err(malformed(format!("there is no run {}", asked.chosen)));
        }
        let tolerances = tolerance_rows(&asked.runs, &machine, &terms);
        let OfferedRun { tolerance, tolerance_mm, breakdown, operations, tools, in_doubt, range } =
            asked.runs.swap_remove(asked.chosen);
        let cycle = breakdown.cycle();
        let own_range = range.as_ref().map(|range| Unit::Percent.to_core(range.percent));
        let uncertainty = Uncertainty::of(&terms, &machine, tolerance_mm, own_range);
        let middle = offer(&cycle, 1.0, &machine, &terms);
        let ends = uncertainty.ratio().map(|ratio| {
            [1.0 - ratio, 1.0 + ratio].map(|of_cycle| offer(&cycle, of_cycle, &machine, &terms))
        });
        let batch = |quantity: u32| Batch {
            quantity,
            unit_price: middle.unit_price(quantity),
            total: middle.amount(middle.total_of(quantity)),
            unit_price_range: ends.as_ref().map(|ends| ends.each_ref().map(|end| end.unit_price(quantity))),
            total_range: ends
                .as_ref()
                .map(|ends| ends.each_ref().map(|end| end.amount(end.total_of(quantity)))),
        };
        let mut quantities = terms.breaks.clone();
        quantities.push(terms.quantity);
        quantities.sort_unstable();
        quantities.dedup();
        let mut report = OfferReport {
            reference: terms.reference.clone(),
            program: asked.program,
            machine: machine.name.clone(),
            tolerance,
            date: asked.date,
            remarks: asked.remarks,
            facts: Vec::new(),
            currency: terms.currency.clone(),
            decimals: terms.rounding.decimals(),
            programmed_time_s: asked.programmed_time_s,
            cycle_time_s: cycle.total(),
            breakdown,
            uncertainty: uncertainty_row(uncertainty, cycle.total(), tolerance_mm, &machine, range.as_ref()),
            in_doubt: in_doubt.unwrap_or_default(),
            addends: middle.addends.iter().map(|addend| addend_row(addend, &middle, &terms)).collect(),
            once: middle.amount(middle.once),
            part: middle.amount(middle.part),
            batch: batch(terms.quantity),
            breaks: quantities.into_iter().map(batch).collect(),
            tolerances,
            operations: share_rows(&middle, operations),
            tools: share_rows(&middle, tools),
            cycle_cost: middle.amount(middle.cycle()),
            notes: notes(&terms, &machine),
        };
        report.facts = facts(&report);
        Ok(report)
    }

    /// Returns the report as JSON text.
    pub fn to_json(&self) -> String {
        serde_json::to_string_pretty(self).expect("text and finite numbers have a JSON form")
    }

    /// Formats an amount with its decimals.
    pub(in crate::project) fn money(&self, amount: f64) -> String {
        format!("{amount:.*}", self.decimals as usize)
    }

    /// Formats the price of one part: a quotient, with at least two decimals.
    pub(in crate::project) fn unit_price(&self, amount: f64) -> String {
        format!("{amount:.*}", self.decimals.max(2) as usize)
    }
}

/// Name of the time before any tool is called.
const BEFORE_FIRST_TOOL: &str = "Before the first tool";

pub(in crate::project) fn addend_row(addend: &Addend, offer: &Offer, terms: &Terms) -> AddendRow {
    let hourly = addend.rate.map(|rate| tidy(rate * SECONDS_PER_HOUR));
    let attended = if addend.item == AddendKind::Attendance && terms.attendance < 1.0 {
        format!(" ({:.0} % of the cycle)", PERCENT * terms.attendance)
    } else {
        String::new()
    };
    let margin = Unit::Percent.from_core(terms.margin);
    let basis = match (addend.time, hourly, addend.item) {
        (Some(time), Some(hourly), _) => format!("{} × {hourly} per h{attended}", duration(time)),
        (_, _, AddendKind::MarginOnce | AddendKind::MarginPart) => {
            format!("{} % of the {}", tidy(margin), crate::quote::MarginOf::WORDS[terms.margin_of as usize])
        }
        _ => String::new(),
    };
    let times = if addend.once { 1 } else { i128::from(offer.quantity) };
    AddendRow {
        item: label(addend.item),
        basis,
        once: addend.once,
        time_s: addend.time,
        hourly,
        amount: offer.amount(addend.steps),
        of_batch: offer.amount(times * addend.steps),
    }
}

/// Formats a paid time.
fn duration(time: f64) -> String {
    let minutes = time * MINUTES_PER_HOUR / SECONDS_PER_HOUR;
    if minutes < 10.0 { format!("{time:.1} s") } else { format!("{minutes:.1} min") }
}

fn label(item: AddendKind) -> &'static str {
    match item {
        AddendKind::SetUpMachine => "Set-up, machine",
        AddendKind::SetUpOperator => "Set-up, operator",
        AddendKind::Fixed => "Fixed cost of the batch",
        AddendKind::MarginOnce => "Margin on set-up and fixed cost",
        AddendKind::Cutting => "Machine, cutting",
        AddendKind::Rapid => "Machine, rapids",
        AddendKind::Dwell => "Machine, dwells",
        AddendKind::ToolChange => "Machine, tool changes",
        AddendKind::OtherTime => "Machine, other times of the cycle",
        AddendKind::Attendance => "Operator, during the cycle",
        AddendKind::LoadingMachine => "Load and unload, machine",
        AddendKind::LoadingOperator => "Load and unload, operator",
        AddendKind::Material => "Material",
        AddendKind::OtherCost => "Other cost",
        AddendKind::MarginPart => "Margin on the part",
    }
}

fn tolerance_rows(runs: &[OfferedRun], machine: &Machine, terms: &Terms) -> Vec<ToleranceRow> {
    let row = |run: &OfferedRun| {
        let cycle = run.breakdown.cycle();
        let offer = offer(&cycle, 1.0, machine, terms);
        ToleranceRow {
            tolerance: run.tolerance.clone(),
            cycle_time_s: cycle.total(),
            unit_price: offer.unit_price(terms.quantity),
            total: offer.amount(offer.total()),
        }
    };
    if runs.len() < 2 { Vec::new() } else { runs.iter().map(row).collect() }
}

fn share_rows(offer: &Offer, parts: Vec<OfferedPart>) -> Vec<ShareRow> {
    let times: Vec<f64> = parts.iter().map(|part| part.time_s).collect();
    let rows = parts.into_iter().zip(offer.by_time(&times)).map(|(part, steps)| {
        let tool = part.tool.map(|tool| format!("T{tool}"));
        let names = [part.name, tool, part.tool_name].into_iter().flatten();
        let name = names.filter(|name| !name.is_empty()).collect::<Vec<_>>().join(" ");
        let name = if name.is_empty() { BEFORE_FIRST_TOOL.to_string() } else { name };
        ShareRow { line: part.line, tool: part.tool, name, time_s: part.time_s, amount: offer.amount(steps) }
    });
    rows.collect()
}

fn notes(terms: &Terms, machine: &Machine) -> Vec<String> {
    let mut notes = vec![rounding_note(terms)];
    if machine.rates.hourly == 0.0 {
        notes.push("The machine has no hourly rate, so its time costs nothing.".to_string());
    }
    notes
}

/// Returns a note on how amounts are rounded and added up.
pub(in crate::project) fn rounding_note(terms: &Terms) -> String {
    let words = crate::quote::Rounding::WORDS;
    let step = words.iter().find(|word| word.parse() == Ok(1.0 / terms.rounding.steps())).unwrap_or(&"1");
    format!(
        "Each amount is rounded to {step}; the total is the sum of the rounded amounts, and nothing else is in it. The price \
         per part is the total divided by the quantity."
    )
}

#[cfg(test)]
pub(in crate::project) mod tests {
    // What an offer says, and that it adds up.

    use super::*;
    use crate::machine::presets;
    use crate::project::machine::form::values;

    /// A request over a preset with an hourly rate.
    pub(in crate::project) fn asked(preset: usize, terms: Value, program: &str) -> Value {
        let mut machine = values(&presets()[preset].machine);
        machine.insert("rates.hourly".to_string(), Value::from(90.0));
        let part = |time: f64, line: u32, tool: u32| serde_json::json!({"line": line, "name": "face, \"rough\"", "tool": tool, "tool_name": null, "time_s": time, "blocks": 4});
        let run = |tolerance: f64, cutting: f64| {
            serde_json::json!({
                "tolerance": format!("{:.0} µm", 1000.0 * tolerance), "tolerance_mm": tolerance,
                "cycle_time_s": cutting + 20.0, "price": 3.0,
                "breakdown": {"cutting_s": cutting, "rapid_s": 15.0, "dwell_s": 0.0, "tool_change_s": 4.0, "other_s": 1.0, "other": {}},
                "operations": [part(cutting - 30.0, 3, 1), part(50.0, 40, 2)],
                "tools": [part(cutting - 30.0, 3, 1), part(50.0, 40, 2)],
            })
        };
        serde_json::json!({
            "machine": machine, "terms": terms, "program": program, "date": "2026-11-22", "programmed_time_s": 90.0,
            "remarks": {"errors": 1, "warnings": 2}, "runs": [run(0.01, 100.0), run(0.02, 90.0)], "chosen": 0,
        })
    }

    fn report(preset: usize, terms: Value) -> OfferReport {
        OfferReport::from_json(&asked(preset, terms, "=part.nc").to_string()).expect("right")
    }

    #[test]
    fn what_is_shown_adds_up() {
        let terms = serde_json::json!({"quantity": 7, "set_up_min": 33, "loading_s": 41, "operator_hourly": 47,
            "material": 3.333, "fixed": 12.5, "margin_percent": 17, "breaks": [100, 1, 7]});
        let report = report(1, terms);
        let cents = |amount: f64| (100.0 * amount).round() as i64;
        let of_batch: i64 = report.addends.iter().map(|addend| cents(addend.of_batch)).sum();
        assert_eq!(of_batch, cents(report.batch.total));
        assert_eq!(cents(report.once) + 7 * cents(report.part), cents(report.batch.total));
        let quantities: Vec<u32> = report.breaks.iter().map(|batch| batch.quantity).collect();
        assert_eq!(quantities, [1, 7, 100]);
        assert!(report.breaks.windows(2).all(|pair| pair[1].unit_price < pair[0].unit_price));
        let by_operation: i64 = report.operations.iter().map(|row| cents(row.amount)).sum();
        assert_eq!(by_operation, cents(report.cycle_cost));
        assert_eq!(report.cycle_time_s, 120.0);
    }

    #[test]
    fn an_uncertainty_has_a_source_or_is_unknown() {
        let measured = report(0, serde_json::json!({}));
        assert_eq!(measured.uncertainty.kind, "calibrated");
        assert!(
            measured.uncertainty.sentence.contains("±7.9 %")
                && measured.uncertainty.sentence.contains("Ward et al.")
        );
        let [low, high] = measured.batch.total_range.expect("it has ends");
        assert!(low < measured.batch.total && measured.batch.total < high);
        let typical = report(1, serde_json::json!({}));
        assert_eq!((typical.uncertainty.kind, typical.batch.total_range), ("unknown", None));
        assert!(typical.uncertainty.sentence.contains("unknown until"));
        assert_eq!(
            report(1, serde_json::json!({"uncertainty_percent": 5})).uncertainty.cycle_time_s,
            Some([114.0, 126.0])
        );
    }

    #[test]
    fn what_is_in_doubt_is_a_fact_of_the_offer() {
        let mut asked = asked(0, serde_json::json!({}), "part.nc");
        let sure = OfferReport::from_json(&asked.to_string()).expect("right");
        assert!(sure.facts.iter().all(|fact| fact.name != "In doubt"));
        asked["runs"][0]["in_doubt"] =
            Value::from("In doubt: 12.3 s (2 arcs do not close, first at line 14)");
        let unsure = OfferReport::from_json(&asked.to_string()).expect("right");
        let fact = unsure.facts.iter().find(|fact| fact.name == "In doubt").expect("it is told");
        assert_eq!(fact.value, "12.3 s (2 arcs do not close, first at line 14)");
    }

    #[test]
    fn an_uncertainty_is_claimed_only_at_the_tolerances_it_was_measured_at() {
        let mut asked = asked(0, serde_json::json!({}), "part.nc");
        asked["chosen"] = Value::from(1);
        let elsewhere = OfferReport::from_json(&asked.to_string()).expect("right");
        assert_eq!((elsewhere.tolerance.as_str(), elsewhere.cycle_time_s), ("20 µm", 110.0));
        assert_eq!((elsewhere.uncertainty.kind, elsewhere.uncertainty.cycle_time_s), ("unknown", None));
        let sentence = &elsewhere.uncertainty.sentence;
        assert!(
            sentence.contains("not measured at 20 µm") && sentence.contains("At 10 µm and 50 µm"),
            "{sentence}"
        );
        assert_eq!(elsewhere.batch.total_range, None);
    }

    #[test]
    fn an_error_too_small_to_be_told_is_not_said_to_be_none() {
        let mut asked = asked(0, serde_json::json!({}), "part.nc");
        asked["machine"]["calibration.cycle_time_error_percent"] = Value::from(0.004);
        let sentence = OfferReport::from_json(&asked.to_string()).expect("right").uncertainty.sentence;
        assert!(sentence.starts_with("Cycle time within ±0.1 %, from: eight test pockets"), "{sentence}");
    }

    #[test]
    fn the_batch_is_priced_at_every_tolerance() {
        let report = report(0, serde_json::json!({"quantity": 2}));
        let rows: Vec<_> = report.tolerances.iter().map(|row| (row.tolerance.as_str(), row.total)).collect();
        assert_eq!(rows, [("10 µm", report.batch.total), ("20 µm", 5.5)]);
        let mut asked = asked(0, serde_json::json!({}), "");
        asked["chosen"] = Value::from(2);
        assert!(OfferReport::from_json(&asked.to_string()).is_err());
    }

    #[test]
    fn faults_of_both_forms_are_told() {
        let mut wrong = asked(0, serde_json::json!({"quantity": 0}), "");
        assert_eq!(
            OfferReport::from_json(&wrong.to_string()).expect_err("wrong")[0].key.as_deref(),
            Some("quantity")
        );
        wrong["machine"]["rates.hourly"] = Value::from(-1);
        assert_eq!(
            OfferReport::from_json(&wrong.to_string()).expect_err("wrong")[0].key.as_deref(),
            Some("rates.hourly")
        );
        assert!(OfferReport::from_json("{}").is_err());
    }
}
