//! An offer as text: what the page shows, JSON and CSV. Amounts are in the currency of the terms, times in s.

use std::fmt::Write;

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use crate::machine::Machine;
use crate::project::terms::terms_from_values;
use crate::project::{Fault, machine_from_form};
use crate::quote::{Addend, Breakdown, Item, Offer, Terms, Uncertainty, offer};
use crate::units::{MINUTES_PER_HOUR, PERCENT, SECONDS_PER_HOUR, Unit};

/// What an offer is asked for: filled forms of machine and terms, and a run of `predict --json`, of which
/// only the times are read.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Asked {
    machine: Map<String, Value>,
    terms: Map<String, Value>,
    program: String,
    tolerance: String,
    programmed_time_s: f64,
    run: Run,
}

#[derive(Deserialize)]
struct Run {
    breakdown: Kinds,
    operations: Vec<Part>,
    tools: Vec<Part>,
}

#[derive(Deserialize)]
struct Kinds {
    cutting_s: f64,
    rapid_s: f64,
    dwell_s: f64,
    tool_change_s: f64,
    other_s: f64,
}

#[derive(Deserialize)]
struct Part {
    line: Option<u32>,
    name: Option<String>,
    tool: Option<u32>,
    tool_name: Option<String>,
    time_s: f64,
}

/// An offer for people and for other programs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OfferReport {
    pub(super) reference: String,
    pub(super) program: String,
    pub(super) machine: String,
    pub(super) tolerance: String,
    pub(super) currency: String,
    /// Decimals of the amounts.
    pub(super) decimals: u32,
    pub(super) programmed_time_s: f64,
    pub(super) cycle_time_s: f64,
    pub(super) uncertainty: UncertaintyRow,
    pub(super) addends: Vec<AddendRow>,
    pub(super) once: f64,
    pub(super) part: f64,
    /// The batch asked for.
    pub(super) batch: Batch,
    /// Other quantities, ascending, that of the batch among them.
    pub(super) breaks: Vec<Batch>,
    /// Cost of the cycle by operation, machine and operator, without margin; together `cycle_cost`.
    pub(super) operations: Vec<ShareRow>,
    /// The same by tool.
    pub(super) tools: Vec<ShareRow>,
    pub(super) cycle_cost: f64,
    /// How the numbers are meant, one sentence each.
    pub(super) notes: Vec<String>,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct UncertaintyRow {
    /// given, calibrated or unknown.
    kind: &'static str,
    /// As a part of the cycle time.
    pub(super) ratio: Option<f64>,
    pub(super) cycle_time_s: Option<[f64; 2]>,
    pub(super) sentence: String,
}

/// One amount; `of_batch` is what the batch pays of it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct AddendRow {
    pub(super) item: &'static str,
    /// What it is made of, such as 45.0 min × 80.00 per h.
    pub(super) basis: String,
    pub(super) once: bool,
    pub(super) time_s: Option<f64>,
    pub(super) hourly: Option<f64>,
    pub(super) amount: f64,
    pub(super) of_batch: f64,
}

/// A quantity and its price; the ranges are those of the uncertain cycle time.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct Batch {
    pub(super) quantity: u32,
    pub(super) unit_price: f64,
    pub(super) total: f64,
    pub(super) unit_price_range: Option<[f64; 2]>,
    pub(super) total_range: Option<[f64; 2]>,
}

/// An operation or a tool.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct ShareRow {
    pub(super) line: Option<u32>,
    pub(super) tool: Option<u32>,
    pub(super) name: String,
    pub(super) time_s: f64,
    pub(super) amount: f64,
}

impl OfferReport {
    /// The offer that a JSON text asks for, or what is wrong with its forms.
    pub fn from_json(json: &str) -> Result<OfferReport, Vec<Fault>> {
        let asked: Asked = serde_json::from_str(json)
            .map_err(|error| vec![Fault { place: None, key: None, message: error.to_string() }])?;
        let machine = machine_from_form(&Value::Object(asked.machine).to_string())?;
        let terms = terms_from_values(&asked.terms)?;
        let Run { breakdown, operations, tools } = asked.run;
        let cycle = Breakdown {
            cutting: breakdown.cutting_s,
            rapid: breakdown.rapid_s,
            dwell: breakdown.dwell_s,
            tool_change: breakdown.tool_change_s,
            other: breakdown.other_s,
            ..Breakdown::default()
        };
        let uncertainty = Uncertainty::of(&terms, &machine);
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
        Ok(OfferReport {
            reference: terms.reference.clone(),
            program: asked.program,
            machine: machine.name.clone(),
            tolerance: asked.tolerance,
            currency: terms.currency.clone(),
            decimals: terms.rounding.decimals(),
            programmed_time_s: asked.programmed_time_s,
            cycle_time_s: cycle.total(),
            uncertainty: uncertainty_row(uncertainty, cycle.total(), &machine),
            addends: middle.addends.iter().map(|addend| addend_row(addend, &middle, &terms)).collect(),
            once: middle.amount(middle.once),
            part: middle.amount(middle.part),
            batch: batch(terms.quantity),
            breaks: quantities.into_iter().map(batch).collect(),
            operations: share_rows(&middle, operations),
            tools: share_rows(&middle, tools),
            cycle_cost: middle.amount(middle.cycle),
            notes: notes(&terms, &machine),
        })
    }

    /// As JSON text.
    pub fn to_json(&self) -> String {
        serde_json::to_string_pretty(self).expect("text and finite numbers have a JSON form")
    }

    /// As CSV: a table of the addends, one of the quantities, one of operations and one of tools, each with a head.
    pub fn to_csv(&self) -> String {
        let mut csv = String::from("item,basis,paid,time_s,per_hour,amount,of_batch\n");
        let mut row = |cells: &[String]| {
            let cells: Vec<String> = cells.iter().map(|cell| cell_of_csv(cell)).collect();
            writeln!(csv, "{}", cells.join(",")).expect("writing to a string cannot fail");
        };
        let optional = |value: Option<f64>| value.map(|value| value.to_string()).unwrap_or_default();
        for addend in &self.addends {
            row(&[
                addend.item.to_string(),
                addend.basis.clone(),
                if addend.once { "once" } else { "a part" }.to_string(),
                optional(addend.time_s),
                optional(addend.hourly),
                self.money(addend.amount),
                self.money(addend.of_batch),
            ]);
        }
        let total = [String::new(), self.money(self.batch.total)];
        row(&[
            &["Total".to_string(), format!("{} parts", self.batch.quantity)][..],
            &vec![String::new(); 3],
            &total,
        ]
        .concat());
        row(&[]);
        row(&["quantity", "unit_price", "total", "total_low", "total_high", "currency"].map(str::to_string));
        for batch in &self.breaks {
            let end =
                |index: usize| batch.total_range.map(|ends| self.money(ends[index])).unwrap_or_default();
            row(&[
                batch.quantity.to_string(),
                self.unit_price(batch.unit_price),
                self.money(batch.total),
                end(0),
                end(1),
                self.currency.clone(),
            ]);
        }
        for (title, parts) in [("operation", &self.operations), ("tool", &self.tools)] {
            row(&[]);
            row(&[title, "line", "tool", "time_s", "cost"].map(str::to_string));
            for part in parts {
                let number = |value: Option<u32>| value.map(|value| value.to_string()).unwrap_or_default();
                row(&[
                    part.name.clone(),
                    number(part.line),
                    number(part.tool),
                    part.time_s.to_string(),
                    self.money(part.amount),
                ]);
            }
        }
        csv
    }

    /// An amount with its decimals.
    pub(super) fn money(&self, amount: f64) -> String {
        format!("{amount:.*}", self.decimals as usize)
    }

    /// A price of one part: a quotient, which has two decimals where amounts have fewer.
    pub(super) fn unit_price(&self, amount: f64) -> String {
        format!("{amount:.*}", self.decimals.max(2) as usize)
    }
}

/// A cell as a spreadsheet reads it. What it would take for a formula is text.
fn cell_of_csv(text: &str) -> String {
    let is_formula = text.starts_with(['=', '+', '-', '@', '\t', '\r']) && text.parse::<f64>().is_err();
    let text = if is_formula { format!("'{text}") } else { text.to_string() };
    if text.contains(['"', ',', '\n', '\r', ';']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text
    }
}

fn uncertainty_row(uncertainty: Uncertainty, cycle_time: f64, machine: &Machine) -> UncertaintyRow {
    let ratio = uncertainty.ratio();
    let percent = Unit::Percent.from_core(ratio.unwrap_or(0.0));
    let (kind, sentence) = match uncertainty {
        Uncertainty::Given(_) => ("given", format!("Cycle time ±{percent:.1} %, as entered.")),
        Uncertainty::Calibrated(_) => {
            let from = if machine.provenance.is_empty() { "the machine file" } else { &machine.provenance };
            (
                "calibrated",
                format!(
                    "Cycle time ±{percent:.1} %, from: {from}. A program unlike those can be further off."
                ),
            )
        }
        Uncertainty::Unknown => (
            "unknown",
            match machine.provenance.as_str() {
                "" => "Uncertainty of the cycle time: unknown until the machine is calibrated. Compare a recording of it, \
                       or enter an uncertainty of your own."
                    .to_string(),
                provenance => format!(
                    "Uncertainty of the cycle time: unknown. The machine was changed after its numbers were found, or it \
                     does not say how far off they were ({provenance})."
                ),
            },
        ),
    };
    let ends = ratio.map(|ratio| [1.0 - ratio, 1.0 + ratio].map(|of_cycle| of_cycle * cycle_time));
    UncertaintyRow { kind, ratio, cycle_time_s: ends, sentence }
}

fn addend_row(addend: &Addend, offer: &Offer, terms: &Terms) -> AddendRow {
    let hourly = addend.rate.map(|rate| super::tidy(rate * SECONDS_PER_HOUR));
    let attended = if addend.item == Item::Attendance && terms.attendance < 1.0 {
        format!(" ({:.0} % of the cycle)", PERCENT * terms.attendance)
    } else {
        String::new()
    };
    let margin = Unit::Percent.from_core(terms.margin);
    let basis = match (addend.time, hourly, addend.item) {
        (Some(time), Some(hourly), _) => format!("{} × {hourly} per h{attended}", duration(time)),
        (_, _, Item::MarginOnce | Item::MarginPart) => {
            format!(
                "{} % of the {}",
                super::tidy(margin),
                crate::quote::MarginOf::WORDS[terms.margin_of as usize]
            )
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

/// A time as it is paid.
fn duration(time: f64) -> String {
    let minutes = time * MINUTES_PER_HOUR / SECONDS_PER_HOUR;
    if minutes < 10.0 { format!("{time:.1} s") } else { format!("{minutes:.1} min") }
}

fn label(item: Item) -> &'static str {
    match item {
        Item::SetUpMachine => "Set-up, machine",
        Item::SetUpOperator => "Set-up, operator",
        Item::Fixed => "Fixed cost of the batch",
        Item::MarginOnce => "Margin on set-up and fixed cost",
        Item::Cutting => "Machine, cutting",
        Item::Rapid => "Machine, rapids",
        Item::Dwell => "Machine, dwells",
        Item::ToolChange => "Machine, tool changes",
        Item::OtherTime => "Machine, other times of the cycle",
        Item::Attendance => "Operator, during the cycle",
        Item::LoadingMachine => "Load and unload, machine",
        Item::LoadingOperator => "Load and unload, operator",
        Item::Material => "Material",
        Item::OtherCost => "Other cost",
        Item::MarginPart => "Margin on the part",
    }
}

fn share_rows(offer: &Offer, parts: Vec<Part>) -> Vec<ShareRow> {
    let times: Vec<f64> = parts.iter().map(|part| part.time_s).collect();
    let rows = parts.into_iter().zip(offer.by_time(&times)).map(|(part, steps)| {
        let tool = part.tool.map(|tool| format!("T{tool}"));
        let names = [part.name, tool, part.tool_name].into_iter().flatten();
        let name = names.filter(|name| !name.is_empty()).collect::<Vec<_>>().join(" ");
        ShareRow { line: part.line, tool: part.tool, name, time_s: part.time_s, amount: offer.amount(steps) }
    });
    rows.collect()
}

fn notes(terms: &Terms, machine: &Machine) -> Vec<String> {
    let mut notes = vec![format!(
        "Each amount is rounded to {}; the total is the sum of the rounded amounts, and nothing else is in it. The price of one \
         part is the total by the quantity.",
        crate::quote::Rounding::WORDS
            .iter()
            .find(|word| word.parse() == Ok(1.0 / terms.rounding.steps()))
            .unwrap_or(&"1")
    )];
    if machine.rates.hourly == 0.0 {
        notes.push("The machine has no hourly rate, so that its time costs nothing.".to_string());
    }
    notes
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::machine::presets;
    use crate::project::form::values;

    /// A request over a preset with an hourly rate.
    pub(in crate::project) fn asked(preset: usize, terms: Value, program: &str) -> Value {
        let mut machine = values(&presets()[preset].machine);
        machine.insert("rates.hourly".to_string(), Value::from(90.0));
        let part = |time: f64, line: u32, tool: u32| serde_json::json!({"line": line, "name": "face, \"rough\"", "tool": tool, "tool_name": null, "time_s": time, "blocks": 4});
        serde_json::json!({
            "machine": machine, "terms": terms, "program": program, "tolerance": "10 µm", "programmed_time_s": 90.0,
            "run": {
                "cycle_time_s": 120.0, "price": 3.0,
                "breakdown": {"cutting_s": 100.0, "rapid_s": 15.0, "dwell_s": 0.0, "tool_change_s": 4.0, "other_s": 1.0, "other": {}},
                "operations": [part(70.0, 3, 1), part(50.0, 40, 2)],
                "tools": [part(70.0, 3, 1), part(50.0, 40, 2)],
            },
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
                && measured.uncertainty.sentence.contains("docs/paper.md")
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
    fn a_table_has_every_number_and_no_formula() {
        let csv = report(0, serde_json::json!({"reference": "x", "quantity": 2})).to_csv();
        assert!(
            csv.starts_with("item,basis,paid,time_s,per_hour,amount,of_batch\n\"Machine, cutting\","),
            "{csv}"
        );
        assert!(csv.contains("\"face, \"\"rough\"\" T1\",3,1,70,"), "{csv}");
        assert!(csv.contains("\nTotal,2 parts,,,,,6.00\n"), "{csv}");
        assert_eq!(cell_of_csv("=1+1"), "'=1+1");
        assert_eq!(cell_of_csv("-1.5"), "-1.5");
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
