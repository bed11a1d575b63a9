//! The library of effects: causes that a machine file may lack, as parameters of the machine to be freed.
//!
//! A row of the table holds the facts about an effect: id, nature, vendors' names, when a probe is of no use, the
//! sentence for people, and the hypotheses that offer it. A hypothesis names the parameters that leave their
//! neutral values, and the values tried first. It contains no physics: the simulation alone defines the
//! consequences of a value. Calibration, diagnosis, probe, page and command read this table; there is no other list
//! of effects. Bounds of parameters are in [`parameters`], for hypotheses and calibration alike.
//!
//! | trace | effects |
//! |---|---|
//! | time along the path | limits, filters, corners, stops, overrides, block times, waits |
//! | form of the path, no time | servo lag, backlash, vibration |
//! | time of the recorder | its clock |
//!
//! The library offers only effects that the program can excite: it tries a limit below the value that the program
//! demands.

mod corners;
mod drives;
mod effect;
mod filters;
mod limits;
mod overrides;
pub mod parameters;
mod report;
mod stops;
mod supply;
mod table;
mod waits;

pub use effect::{Between, Context, Effect, Hypothesis, Nature, Origin, Row, Trace};
pub use overrides::free_feed_override;
pub use report::{
    FROM_DISTANCE, FROM_LINE, Finding, LINE, Quantity, RATIO, Report, Reported, ReportedValue, SECONDS,
    TO_DISTANCE, TO_LINE, is_whole,
};
pub use table::*;
pub use waits::{LONGEST_WAIT_S, StopKind};

/// Least time that an effect must explain to count as present in runs, as a part of their time.
pub const MIN_EXPLAINED_SHARE: f64 = 3e-4;

use crate::identification::fit::Run;
use crate::machine::{InPosition, Machine};

/// Returns the hypotheses that the runs can excite on a machine, in the order of the table.
pub fn library(machine: &Machine, runs: &[Run]) -> Vec<Hypothesis> {
    let context = Context::new(machine, runs);
    ALL.iter().flat_map(|effect| (effect.offered)(*effect, &context)).collect()
}

/// Returns the hypothesis of a jerk limit along the path, which fits the filters and the tolerance again; `None` if
/// the filters are unequal.
pub fn ramps(machine: &Machine) -> Option<Hypothesis> {
    limits::ramps(JERK_LIMIT, machine)
}

/// Returns the hypotheses of a stop at the end of every block, and of a wait for position at each of these stops;
/// `None` if the machine already stops at corners or waits for position. On a machine that does neither, the stop
/// alone fits badly because it leaves much of the lost time unexplained, and the wait alone has no stop to act at.
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
