//! What stands for itself, and is taken in before anything is searched: an override that [`plateaus`] reads off, waits at
//! functions as [`waits`] does, and feed holds, as [`rests`] finds them.
//!
//! What is read off stays as it is; holds are fitted again with everything that comes after, unless excerpts are
//! looked at, which may not hold them.

use crate::identification::diagnosis::cause::{AcceptedCause, candidates, odds};
use crate::identification::diagnosis::evidence::with_all;
use crate::identification::diagnosis::plateaus::{self, Said};
use crate::identification::diagnosis::search::Looked;
use crate::identification::diagnosis::{Candidate, gates, rests, waits};
use crate::identification::effects::{FEED_OVERRIDE, Hypothesis};
use crate::machine::Machine;

/// What stays as it is, and what is fitted again. What is known now is taken out of the library.
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
