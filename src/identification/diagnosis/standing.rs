//! How far a machine file may be believed.
//!
//! No simulation is exact. What a calibration left of its own runs is the error of the model, and no cause of any run:
//!
//! | machine file | a search for causes begins with | machine causes are named |
//! |---|---|---|
//! | never checked on a recording of its machine | any lost time that noise does not leave | as they are found |
//! | describes its machine | more than `ELSEWHERE` times what calibration left | if they are few and leave little |
//! | misses it: off by more than `WORST` on its own runs | none | none: what is left is unknown |
//!
//! On programs that it was not calibrated on a machine file may be off by the range that it states for them
//! ([`elsewhere`]), in form by nobody knows how much: there a difference within that is no cause, and drives are
//! not named.
//!
//! The origin of a preset is a measurement of another machine, so a preset counts as never checked.

use crate::identification::fit::Run;
use crate::machine::Machine;
use crate::quote::error_beyond_calibration;

/// How many times what calibration left on its own runs a model may leave on others.
pub const ELSEWHERE: f64 = 1.5;
/// Relative error of the cycle time on its own runs from which on a calibrated machine file does not describe its
/// machine: what a prediction may be off by at worst.
const WORST: f64 = 0.03;

/// How far a machine file may be believed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Standing {
    /// It was never checked on a recording of its machine.
    Unchecked,
    /// Calibration left no more than this of the recorded time unexplained, as a part of it.
    Describes(f64),
    /// It is off on the very runs that it was calibrated on.
    Misses,
}

/// The machine with what its file may be off by on these runs, and that, as a part of the time, where it was not
/// calibrated on them.
pub fn on_these(machine: &Machine, runs: &[Run]) -> (Machine, Option<f64>) {
    let mut machine = machine.clone();
    let off = runs.iter().filter_map(|run| error_beyond_calibration(run.toolpath, &machine)).reduce(f64::max);
    let Some((off, left)) = off.zip(machine.unexplained_time) else {
        // Rapids that were not at their full rate then are not now: one that is slower is slower for a cause.
        machine.calibrated_on.assumed_rapids = [false; 3];
        return (machine, None);
    };
    machine.unexplained_time = Some(left.max(off / ELSEWHERE));
    machine.form_error = Some(f64::INFINITY);
    (machine, Some(off))
}

impl Standing {
    /// Of a machine as it comes from its file.
    pub fn of(machine: &Machine) -> Standing {
        let net = machine.cycle_time_error.map_or(0.0, f64::abs);
        match machine.unexplained_time {
            None if machine.cycle_time_error.is_none() || WORST < net => Standing::Unchecked,
            None => Standing::Describes(net),
            Some(_) if WORST < net => Standing::Misses,
            Some(left) => Standing::Describes(net.max(ELSEWHERE * left)),
        }
    }

    /// What the machine file is known to be off by, as a part of the time.
    pub fn known_error(self) -> f64 {
        match self {
            Standing::Describes(error) => error,
            Standing::Unchecked | Standing::Misses => 0.0,
        }
    }
}
