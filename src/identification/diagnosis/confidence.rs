//! The confidence of a cause: the odds of its gain in likelihood to the price of its parameters,
//!
//! ```text
//! confidence = k · most · g / (g + price)        g = gain / dispersion
//! ```
//!
//! with the dispersion of the remaining residuals, since related residuals hold less information than independent
//! ones. `most` is the largest confidence that the held-out stretches and the causes that fit as well allow. These odds compare
//! the causes of the library with one another and with none. k is the chance that the true cause is in the library and the machine
//! file as right as it says ([`CHANCE_OF_LIBRARY`]), which no recording shows.

use crate::identification::diagnosis::cause::{AcceptedCause, UNSURE, candidates, odds};
use crate::identification::diagnosis::evidence::with_all;
use crate::identification::diagnosis::{Evidence, gates};
use crate::identification::fit::Run;
use crate::machine::Machine;

/// Chance k that a cause is right which the odds leave no doubt of. It is the part of right ones among the 811 causes with odds of
/// at least 0.99 that were named on all seeds up to 131595228; on the ten seeds after it, it is 156 of 162 (`docs/seeds.md`).
pub const CHANCE_OF_LIBRARY: f64 = 784.0 / 811.0;

/// Returns the causes with their confidence multiplied by the odds of each beside the others: the ratio of its gain in
/// likelihood to gain and price, where the gain counts less the more the remaining residuals are related. Causes whose
/// confidence is then below [`UNSURE`] are removed.
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
