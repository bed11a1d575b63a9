//! Standing of a machine file: how far a diagnosis may believe it.
//!
//! No simulation is exact. The time that a calibration left unexplained on its own runs is the error of the model, and
//! no cause of any run:
//!
//! | machine file | a search for causes begins with | machine causes are named |
//! |---|---|---|
//! | never checked on a recording of its machine | any lost time that noise does not leave | as they are found |
//! | describes its machine | more than `MAX_UNEXPLAINED_RATIO` times what calibration left | if they are few and leave little |
//! | misses it: off by more than `WORST` on its own runs | none | none: the remainder is unknown |
//!
//! On programs other than those of its calibration, a machine file may be off by somewhat more than the range that it states
//! for nine in ten of them ([`on_these`]), and in form by an unknown amount. There a difference within that range is no cause, and drives are
//! not named.
//!
//! The origin of a preset is a measurement of another machine, so a preset counts as never checked.

use crate::identification::fit::Run;
use crate::machine::Machine;
use crate::quote::error_beyond_calibration;

/// Largest ratio of the unexplained time of a model on other runs to that which calibration left on its own runs.
pub const MAX_UNEXPLAINED_RATIO: f64 = 1.5;
/// Largest relative error of the cycle time, on the runs of the calibration, of a machine file that describes its
/// machine: the worst error of a prediction.
const WORST: f64 = 0.03;

/// Ratio of two ranges: the one that holds for 98 % of other programs to the stated one, which holds for 90 %. Student's
/// distribution with four degrees of freedom, as for a range from one program, has the quantiles 3.747 at 0.99 and 2.132 at
/// 0.95. A diagnosis needs the wider range because it meets many clean runs and should name no cause on any of them.
const SEARCHED_TO_STATED_RANGE_RATIO: f64 = 1.757;

/// Standing of a machine file: how far a diagnosis may believe it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Standing {
    /// The file was never checked on a recording of its machine.
    Unchecked,
    /// The file describes its machine, and leaves at most this part of the recorded time unexplained.
    Describes(f64),
    /// The file is off on the very runs that it was calibrated on.
    Misses,
}

/// Returns the machine with the error that its file may have on these runs, and that error as a part of the time;
/// `None` for the error if the file was calibrated on the runs, or was never calibrated.
pub fn on_these(machine: &Machine, runs: &[Run]) -> (Machine, Option<f64>) {
    let mut machine = machine.clone();
    let off = runs.iter().filter_map(|run| error_beyond_calibration(run.toolpath, &machine)).reduce(f64::max);
    let Some((off, left)) = off.zip(machine.unexplained_time) else { return (machine, None) };
    let off = SEARCHED_TO_STATED_RANGE_RATIO * off;
    machine.unexplained_time = Some(left.max(off / MAX_UNEXPLAINED_RATIO));
    (machine.form_error, machine.typical_form_error) = (Some(f64::INFINITY), Some(f64::INFINITY));
    (machine, Some(off))
}

/// Returns `true` for a machine of [`on_these`] whose runs are of other programs than its calibration: [`on_these`] marks
/// it by an infinite form error.
pub fn is_elsewhere(machine: &Machine) -> bool {
    machine.form_error == Some(f64::INFINITY)
}

impl Standing {
    /// Returns the standing of a machine that was read from its file.
    pub fn of(machine: &Machine) -> Standing {
        let net = machine.cycle_time_error.map_or(0.0, f64::abs);
        match machine.unexplained_time {
            None if machine.cycle_time_error.is_none() || WORST < net => Standing::Unchecked,
            None => Standing::Describes(net),
            Some(_) if WORST < net => Standing::Misses,
            Some(left) => Standing::Describes(net.max(MAX_UNEXPLAINED_RATIO * left)),
        }
    }

    /// Returns the known error of the machine file, as a part of the time; 0 if it describes no machine or is
    /// unchecked.
    pub fn known_error(self) -> f64 {
        match self {
            Standing::Describes(error) => error,
            Standing::Unchecked | Standing::Misses => 0.0,
        }
    }
}
