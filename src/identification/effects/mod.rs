//! The library of effects: what may have been left out, as parameters of the machine to be freed.
//!
//! A row of the table says what there is to know of an effect: id, nature, vendors' names, when a probe is of no use,
//! the sentence for people, and the hypotheses that offer it. A hypothesis says which parameters leave their neutral
//! values, within which bounds, and which values are tried first. It has no physics of its own: what a value does is
//! said by the simulation alone. Calibration, diagnosis, probe, page and command read this table; there is no other
//! list of effects.
//!
//! | trace | effects |
//! |---|---|
//! | time along the path | limits, filters, corners, stops, overrides, block times, waits |
//! | form of the path, no time | servo lag, backlash, vibration |
//! | time of the recorder | its clock |
//!
//! Only what the program can excite is offered: a limit is tried below what the program asks for.

mod corners;
mod drives;
mod effect;
mod filters;
mod limits;
mod overrides;
mod report;
mod stops;
mod supply;
mod table;
mod waits;

pub use effect::{Context, Effect, Hypothesis, Nature, Origin, Row, Trace};
pub use limits::POSITIONING_JERKS_MM_S3;
pub use report::{
    FROM_DISTANCE, FROM_LINE, Finding, LINE, Quantity, RATIO, Report, Reported, ReportedValue, SECONDS,
    TO_DISTANCE, TO_LINE, is_whole,
};
pub use table::*;
pub use waits::{Kind, LONGEST_WAIT_S};

use crate::identification::fit::Run;
use crate::machine::{InPosition, Machine};

/// The hypotheses that the runs can excite on a machine, in the order of the table.
pub fn library(machine: &Machine, runs: &[Run]) -> Vec<Hypothesis> {
    let context = Context::new(machine, runs);
    ALL.iter().flat_map(|effect| (effect.offered)(*effect, &context)).collect()
}

/// The jerk along the path, with the filters and the tolerance fitted again; `None` where the filters are unequal.
pub fn ramps(machine: &Machine) -> Option<Hypothesis> {
    limits::ramps(JERK_LIMIT, machine)
}

/// A stop at the end of every block, and the wait for position at each: on a machine that does neither, the stop alone leaves
/// so much that it fits badly, and there is no wait without it. None where the machine stops or waits already.
pub fn awaited_stops(machine: &Machine, runs: &[Run]) -> Option<[Hypothesis; 2]> {
    let stops = machine.interpolator.stopping_angle() < std::f64::consts::PI;
    if stops || 0.0 < machine.halts.in_position {
        return None;
    }
    let of = |effect: Effect, machine: &Machine| (effect.offered)(effect, &Context::new(machine, runs));
    let at_every_end = |hypothesis: &Hypothesis| hypothesis.trials.contains(&vec![0.0]);
    let stop = of(EXACT_STOP, machine).into_iter().find(at_every_end)?;
    let at_stops = |wait: &Hypothesis| wait.variant == InPosition::ExactStops.word();
    let wait = of(IN_POSITION_WAIT, &stop.machine(machine, &[0.0])).into_iter().find(at_stops)?;
    Some([stop, wait])
}
