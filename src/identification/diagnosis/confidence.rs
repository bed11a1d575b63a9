//! How sure a cause is: the odds of what it gains in likelihood to the price of its parameters,
//!
//! ```text
//! confidence = most · g / (g + price)        g = gain / dispersion
//! ```
//!
//! with the dispersion of the residuals that are left, since related ones say less than independent ones, and
//! `most` what the stretches that were held out and the causes that are alike allow.

use crate::identification::diagnosis::cause::{AcceptedCause, UNSURE, candidates, odds};
use crate::identification::diagnosis::evidence::with_all;
use crate::identification::diagnosis::{Evidence, gates};
use crate::identification::fit::Run;
use crate::machine::Machine;

/// What was found, with a confidence that also tells what the likelihood says of each beside the others: the
/// odds are its gain to its price, the gain being worth less as residuals that are left are related. What others leave
/// too little to be sure of is taken back.
pub fn weighed(base: &Machine, runs: &[Run], mut named: Vec<AcceptedCause>) -> Vec<AcceptedCause> {
    if named.is_empty() {
        return named;
    }
    let all = candidates(&named);
    let with = with_all(base, &all);
    let evidence = Evidence::of(runs, &with);
    let dispersion = evidence.dispersion(&with);
    for (found, gain) in named.iter_mut().zip(evidence.gains(base, &all)) {
        let price = gates::price(runs, found.candidate.values.len());
        found.confidence *= odds(gain.max(0.0) / dispersion, price);
    }
    named.retain(|found| UNSURE <= found.confidence);
    named
}
