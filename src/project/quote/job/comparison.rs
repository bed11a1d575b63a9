//! Comparison of two jobs, such as two revisions or two machines: differences by operation and in total.

use std::collections::HashMap;

use serde::Serialize;

use crate::project::quote::job::report::{JobReport, OperationRow};

/// The differences between two jobs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct JobComparison {
    pub(super) names: [String; 2],
    /// Operations of either job, in the order of the first; operations only in the second come last.
    pub(super) operations: Vec<OperationPair>,
    pub(super) cycle_time_s: Difference,
    pub(super) set_up_s: Difference,
    pub(super) batch_time_s: Difference,
    pub(super) unit_price: Difference,
    pub(super) total: Difference,
    pub(super) currency: String,
    /// Remarks, such as different currencies or quantities, which make differences of amounts meaningless.
    pub(super) remarks: Vec<String>,
}

/// Two values and their difference.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Difference {
    /// Value of the first job.
    pub first: f64,
    /// Value of the second job.
    pub second: f64,
    /// The second less the first.
    pub difference: f64,
}

/// An operation of both jobs, or of one.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct OperationPair {
    pub(super) name: String,
    /// Index in each job.
    pub(super) index: [Option<usize>; 2],
    pub(super) cycle_time_s: [Option<f64>; 2],
    /// Cost of a part without margin and set-up.
    pub(super) part_cost: [Option<f64>; 2],
    /// The second less the first; a missing operation takes no time.
    pub(super) cycle_time_difference_s: f64,
}

impl JobComparison {
    /// Compares the second job with the first. Operations are paired by name, in order if several have the
    /// same name, and the remaining ones by program.
    pub fn new(first: &JobReport, second: &JobReport) -> JobComparison {
        let partners = partners(&first.operations, &second.operations);
        let mut is_taken = vec![false; second.operations.len()];
        let mut operations = Vec::new();
        let pair = |indices| pair([first, second], indices);
        for (own, partner) in partners.into_iter().enumerate() {
            if let Some(index) = partner {
                is_taken[index] = true;
            }
            operations.push(pair([Some(own), partner]));
        }
        let others = (0..is_taken.len()).filter(|index| !is_taken[*index]);
        operations.extend(others.map(|other| pair([None, Some(other)])));
        let of = |value: fn(&JobReport) -> f64| difference(value(first), value(second));
        JobComparison {
            names: [first.name.clone(), second.name.clone()],
            operations,
            cycle_time_s: of(|job| job.cycle_time_s),
            set_up_s: of(|job| job.set_up_s),
            batch_time_s: of(|job| job.batch_time_s),
            unit_price: of(|job| job.batch.unit_price),
            total: of(|job| job.batch.total),
            currency: first.currency.clone(),
            remarks: remarks(first, second),
        }
    }

    /// Returns the comparison as JSON text.
    pub fn to_json(&self) -> String {
        serde_json::to_string_pretty(self).expect("text and finite numbers have a JSON form")
    }
}

fn difference(first: f64, second: f64) -> Difference {
    Difference { first, second, difference: second - first }
}

/// Returns the partner in the second job of each operation of the first.
fn partners(first: &[OperationRow], second: &[OperationRow]) -> Vec<Option<usize>> {
    let mut partners = vec![None; first.len()];
    let mut is_taken = vec![false; second.len()];
    let keys: [fn(&OperationRow) -> &str; 2] = [|row| &row.name, |row| &row.program];
    for key in keys {
        let mut waiting: HashMap<&str, Vec<usize>> = HashMap::new();
        for index in (0..second.len()).rev().filter(|index| !is_taken[*index]) {
            waiting.entry(key(&second[index])).or_default().push(index);
        }
        for (own, partner) in first.iter().zip(&mut partners).filter(|(_, partner)| partner.is_none()) {
            *partner = waiting.get_mut(key(own)).and_then(Vec::pop);
            if let Some(index) = *partner {
                is_taken[index] = true;
            }
        }
    }
    partners
}

fn pair(jobs: [&JobReport; 2], index: [Option<usize>; 2]) -> OperationPair {
    let both = [0, 1].map(|side| index[side].map(|index| &jobs[side].operations[index]));
    let times = both.map(|row| row.map(|row| row.cycle_time_s));
    let name = both[0].or(both[1]).map(|row| row.name.clone());
    OperationPair {
        name: name.unwrap_or_default(),
        index,
        cycle_time_s: times,
        part_cost: both.map(|row| row.map(|row| row.part_cost)),
        cycle_time_difference_s: times[1].unwrap_or(0.0) - times[0].unwrap_or(0.0),
    }
}

fn remarks(first: &JobReport, second: &JobReport) -> Vec<String> {
    let mut remarks = Vec::new();
    if first.currency != second.currency {
        let (one, other) = (&first.currency, &second.currency);
        remarks.push(format!("Prices are in {one} and {other}; nothing is converted."));
    }
    if first.batch.quantity != second.batch.quantity {
        let (one, other) = (first.batch.quantity, second.batch.quantity);
        remarks.push(format!("The batches have {one} and {other} parts."));
    }
    remarks
}
