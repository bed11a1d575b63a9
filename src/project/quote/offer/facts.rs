//! Facts and uncertainty of an offer, worded once for the page and for every document.

use crate::machine::{Machine, tolerance_label};
use crate::project::prediction::time_range::RangeRow;
use crate::project::quote::offer::report::{Fact, OfferReport, UncertaintyRow};
use crate::quote::Uncertainty;
use crate::units::Unit;

/// Least reported percentage: smaller ones would round to 0.
const MIN_REPORTED_PERCENT: f64 = 0.05;

pub(in crate::project) fn uncertainty_row(
    uncertainty: Uncertainty,
    cycle_time: f64,
    tolerance: f64,
    machine: &Machine,
    range: Option<&RangeRow>,
) -> UncertaintyRow {
    let ratio = uncertainty.ratio();
    let from = if machine.provenance.is_empty() { "the machine file" } else { &machine.provenance };
    let (kind, sentence) = match uncertainty {
        Uncertainty::Given(ratio) => {
            ("given", format!("Cycle time ±{:.1} %, as entered.", Unit::Percent.from_core(ratio)))
        }
        Uncertainty::Calibrated(ratio) => (
            "calibrated",
            match range {
                Some(range) => format!("Cycle time {} From: {from}.", range.sentence),
                None => format!(
                    "Cycle time {}, from: {from}. The error can be larger for other kinds of programs.",
                    spread(ratio)
                ),
            },
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
                "" => "Uncertainty of the cycle time: unknown until the machine is calibrated. Compare a recording, or enter an uncertainty yourself."
                    .to_string(),
                provenance => format!(
                    "Uncertainty of the cycle time: unknown. Somebody changed the machine after its calibration, or the machine file does not contain the error ({provenance})."
                ),
            },
        ),
    };
    let ends = ratio.map(|ratio| [1.0 - ratio, 1.0 + ratio].map(|of_cycle| of_cycle * cycle_time));
    UncertaintyRow { kind, ratio, cycle_time_s: ends, sentence }
}

/// Formats a symmetric error of a cycle time, at least as the smallest reported percentage.
fn spread(ratio: f64) -> String {
    let percent = Unit::Percent.from_core(ratio);
    if percent < MIN_REPORTED_PERCENT { "within ±0.1 %".to_string() } else { format!("±{percent:.1} %") }
}

/// Returns the facts of an offer; terms that are not given are left out.
pub(in crate::project) fn facts(offer: &OfferReport) -> Vec<Fact> {
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
        fact("Cycle time per part", format!("{:.1} s{}", offer.cycle_time_s, range.unwrap_or_default())),
        fact("Of that", kinds.join(", ")),
        fact("CAM estimate", format!("{:.1} s", offer.programmed_time_s)),
        fact("Confidence", offer.uncertainty.sentence.clone()),
        fact("In doubt", offer.in_doubt.trim_start_matches("In doubt: ").to_string()),
        fact(
            "Remarks on the program",
            if remarks.is_empty() { "none".to_string() } else { remarks.join(", ") },
        ),
    ];
    all.into_iter().filter(|fact| !fact.value.is_empty()).collect()
}
