//! What an offer is of and how sure that is, worded once for the page and for every document.

use serde::Serialize;

use crate::machine::{Machine, tolerance_label};
use crate::project::offer::OfferReport;
use crate::quote::Uncertainty;
use crate::units::Unit;

/// One thing to know, such as the machine, and what it is.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct Fact {
    pub(super) name: &'static str,
    pub(super) value: String,
}

/// How sure the cycle time is.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct UncertaintyRow {
    /// given, calibrated or unknown.
    pub(super) kind: &'static str,
    /// As a part of the cycle time.
    pub(super) ratio: Option<f64>,
    pub(super) cycle_time_s: Option<[f64; 2]>,
    pub(super) sentence: String,
}

/// What is smaller, in percent, would be rounded to nothing.
const LEAST_PERCENT: f64 = 0.05;

pub(super) fn uncertainty_row(
    uncertainty: Uncertainty,
    cycle_time: f64,
    tolerance: f64,
    machine: &Machine,
) -> UncertaintyRow {
    let ratio = uncertainty.ratio();
    let from = if machine.provenance.is_empty() { "the machine file" } else { &machine.provenance };
    let (kind, sentence) = match uncertainty {
        Uncertainty::Given(ratio) => {
            ("given", format!("Cycle time ±{:.1} %, as entered.", Unit::Percent.from_core(ratio)))
        }
        Uncertainty::Calibrated(ratio) => (
            "calibrated",
            format!(
                "Cycle time {}, from: {from}. A program unlike those can be further off.",
                spread(ratio)
            ),
        ),
        Uncertainty::Elsewhere(ratio) => {
            let measured: Vec<String> =
                machine.tolerances_of_error().iter().map(|&other| tolerance_label(other)).collect();
            (
                "unknown",
                format!(
                    "Uncertainty of the cycle time: not measured at {}. At {} it was {}, from: {from}.",
                    tolerance_label(tolerance),
                    measured.join(" and "),
                    spread(ratio),
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

/// How far off a cycle time was, to both sides; never nothing.
fn spread(ratio: f64) -> String {
    let percent = Unit::Percent.from_core(ratio);
    if percent < LEAST_PERCENT { "within ±0.1 %".to_string() } else { format!("±{percent:.1} %") }
}

/// What an offer is of; what is not given is left out.
pub(super) fn facts(offer: &OfferReport) -> Vec<Fact> {
    let fact = |name: &'static str, value: String| Fact { name, value };
    let range = offer.uncertainty.cycle_time_s.map(|[low, high]| format!(", {low:.1} to {high:.1} s"));
    let kinds = offer.breakdown.named().into_iter().filter(|(_, seconds)| *seconds != 0.0);
    let kinds: Vec<String> = kinds.map(|(kind, seconds)| format!("{kind} {seconds:.1} s")).collect();
    let told = |count: usize, what: &str| match count {
        0 => None,
        1 => Some(format!("1 {what}")),
        _ => Some(format!("{count} {what}s")),
    };
    let remarks = [told(offer.remarks.errors, "error"), told(offer.remarks.warnings, "warning")];
    let remarks: Vec<String> = remarks.into_iter().flatten().collect();
    let all = [
        fact("Reference", offer.reference.clone()),
        fact("Program", offer.program.clone()),
        fact("Machine", offer.machine.clone()),
        fact("Contour tolerance", offer.tolerance.clone()),
        fact("Date", offer.date.clone()),
        fact("Cycle time of a part", format!("{:.1} s{}", offer.cycle_time_s, range.unwrap_or_default())),
        fact("Of that", kinds.join(", ")),
        fact("CAM would say", format!("{:.1} s", offer.programmed_time_s)),
        fact("How sure", offer.uncertainty.sentence.clone()),
        fact("In doubt", offer.in_doubt.trim_start_matches("In doubt: ").to_string()),
        fact(
            "Remarks on the program",
            if remarks.is_empty() { "none".to_string() } else { remarks.join(", ") },
        ),
    ];
    all.into_iter().filter(|fact| !fact.value.is_empty()).collect()
}
