//! The rows of an offer's tables, with amounts in the currency of the terms and times in s.

use serde::{Deserialize, Serialize};

use crate::quote::Breakdown;

/// An offer for people and for other programs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OfferReport {
    pub(in crate::project) reference: String,
    pub(in crate::project) program: String,
    pub(in crate::project) machine: String,
    pub(in crate::project) tolerance: String,
    pub(in crate::project) date: String,
    pub(in crate::project) remarks: RemarkCounts,
    /// Facts about the offer for people.
    pub(in crate::project) facts: Vec<Fact>,
    pub(in crate::project) currency: String,
    /// Decimals of the amounts.
    pub(in crate::project) decimals: u32,
    pub(in crate::project) programmed_time_s: f64,
    pub(in crate::project) cycle_time_s: f64,
    pub(in crate::project) breakdown: Kinds,
    pub(in crate::project) uncertainty: UncertaintyRow,
    /// Doubts about the cycle time and their reasons; empty if there are none.
    pub(in crate::project) in_doubt: String,
    pub(in crate::project) addends: Vec<AddendRow>,
    pub(in crate::project) once: f64,
    pub(in crate::project) part: f64,
    /// The requested batch.
    pub(in crate::project) batch: Batch,
    /// Other quantities, ascending, including the batch.
    pub(in crate::project) breaks: Vec<Batch>,
    /// The batch at each tolerance, if there are several.
    pub(in crate::project) tolerances: Vec<ToleranceRow>,
    /// Cost of the cycle by operation, machine and operator, without margin; adds up to `cycle_cost`.
    pub(in crate::project) operations: Vec<ShareRow>,
    /// Cost of the cycle by tool.
    pub(in crate::project) tools: Vec<ShareRow>,
    pub(in crate::project) cycle_cost: f64,
    /// Notes on the numbers, one sentence each.
    pub(in crate::project) notes: Vec<String>,
}

/// One amount; `of_batch` is its part in the batch.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(in crate::project) struct AddendRow {
    pub(in crate::project) item: &'static str,
    /// Factors of the amount, such as 45.0 min × 80.00 per h.
    pub(in crate::project) basis: String,
    pub(in crate::project) once: bool,
    pub(in crate::project) time_s: Option<f64>,
    pub(in crate::project) hourly: Option<f64>,
    pub(in crate::project) amount: f64,
    pub(in crate::project) of_batch: f64,
}

/// A quantity and its price; the ranges follow from the uncertain cycle time.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(in crate::project) struct Batch {
    pub(in crate::project) quantity: u32,
    pub(in crate::project) unit_price: f64,
    pub(in crate::project) total: f64,
    pub(in crate::project) unit_price_range: Option<[f64; 2]>,
    pub(in crate::project) total_range: Option<[f64; 2]>,
}

/// The batch at another contour tolerance.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(in crate::project) struct ToleranceRow {
    pub(in crate::project) tolerance: String,
    pub(in crate::project) cycle_time_s: f64,
    pub(in crate::project) unit_price: f64,
    pub(in crate::project) total: f64,
}

/// An operation or a tool.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(in crate::project) struct ShareRow {
    pub(in crate::project) line: Option<u32>,
    pub(in crate::project) tool: Option<u32>,
    pub(in crate::project) name: String,
    pub(in crate::project) time_s: f64,
    pub(in crate::project) amount: f64,
}

/// Number of remarks on the program.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(in crate::project) struct RemarkCounts {
    pub(in crate::project) errors: usize,
    pub(in crate::project) warnings: usize,
}

/// The cycle time by kind.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(in crate::project) struct Kinds {
    cutting_s: f64,
    rapid_s: f64,
    dwell_s: f64,
    tool_change_s: f64,
    other_s: f64,
}

impl Kinds {
    /// Returns each kind with its name.
    pub(in crate::project) fn named(self) -> [(&'static str, f64); 5] {
        let Kinds { cutting_s, rapid_s, dwell_s, tool_change_s, other_s } = self;
        [
            ("cutting", cutting_s),
            ("rapids", rapid_s),
            ("dwells", dwell_s),
            ("tool changes", tool_change_s),
            ("other", other_s),
        ]
    }

    /// Returns the kinds of a cycle.
    pub(in crate::project) fn of(cycle: &Breakdown) -> Kinds {
        let Breakdown { cutting, rapid, dwell, tool_change, other, .. } = *cycle;
        Kinds {
            cutting_s: cutting,
            rapid_s: rapid,
            dwell_s: dwell,
            tool_change_s: tool_change,
            other_s: other,
        }
    }

    /// Returns the kinds as the cycle of a quote.
    pub(in crate::project) fn cycle(self) -> Breakdown {
        let Kinds {
            cutting_s: cutting,
            rapid_s: rapid,
            dwell_s: dwell,
            tool_change_s: tool_change,
            other_s: other,
        } = self;
        Breakdown { cutting, rapid, dwell, tool_change, other, ..Breakdown::default() }
    }
}

/// A fact, such as the machine, with its value.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(in crate::project) struct Fact {
    pub(in crate::project) name: &'static str,
    pub(in crate::project) value: String,
}

/// The uncertainty of the cycle time.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(in crate::project) struct UncertaintyRow {
    /// given, calibrated or unknown.
    pub(in crate::project) kind: &'static str,
    /// As a part of the cycle time.
    pub(in crate::project) ratio: Option<f64>,
    pub(in crate::project) cycle_time_s: Option<[f64; 2]>,
    pub(in crate::project) sentence: String,
}
