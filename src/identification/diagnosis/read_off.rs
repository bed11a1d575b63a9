//! Causes that the recordings show directly, accepted before any search: an override from [`plateaus`], waits at
//! functions from [`waits`], and feed holds from [`rests`].
//!
//! Values that are read off do not change later. Feed holds are the exception: they are fitted again with every later
//! cause, unless the search runs on excerpts, which may not contain them.

use crate::identification::diagnosis::cause::{AcceptedCause, candidates, odds};
use crate::identification::diagnosis::evidence::{Looked, with_all};
use crate::identification::diagnosis::plateaus::{self, Said};
use crate::identification::diagnosis::{Candidate, gates, rests, waits};
use crate::identification::effects::{FEED_OVERRIDE, Hypothesis};
use crate::machine::Machine;

/// Returns the causes whose values do not change any more, and those that are fitted again later. Removes the
/// hypotheses that are settled from `library`.
pub fn read_off(
    start: &Machine,
    looked: &Looked,
    library: &mut Vec<Hypothesis>,
) -> (Vec<AcceptedCause>, Vec<AcceptedCause>) {
    let runs = looked.whole;
    let price = gates::price(runs, 1);
    let found = |(candidate, gain): (Candidate, f64)| AcceptedCause::read_off(candidate, odds(gain, price));
    let mut fixed: Vec<AcceptedCause> = Vec::new();
    let said = plateaus::feed_override(start, runs, library);
    if !matches!(said, Said::Nothing) {
        library.retain(|hypothesis| hypothesis.effect != FEED_OVERRIDE);
    }
    if let Said::Other(candidate) = said {
        fixed.push(AcceptedCause::read_off(candidate, 1.0));
    }
    let now = with_all(start, &candidates(&fixed));
    let waits = waits::at_functions(&now, runs, library, price);
    for (wait, _) in &waits {
        let known = wait.hypothesis.freed[0].handle;
        library.retain(|other| other.freed.first().is_none_or(|freed| freed.handle != known));
    }
    fixed.extend(waits.into_iter().map(found));
    let now = with_all(start, &candidates(&fixed));
    let holds = rests::feed_holds(&now, runs, price).into_iter().map(found);
    if looked.in_parts {
        fixed.extend(holds);
        (fixed, Vec::new())
    } else {
        (fixed, holds.collect())
    }
}
