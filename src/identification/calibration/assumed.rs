//! Assumed accelerations and jerks of the axes whose limits the runs do not determine.
//!
//! An axis that never ramps at its limit leaves its acceleration open: any larger value fits equally well, and a
//! fit ends wherever its last step led. Axes of one machine are alike, so the geometric mean of the others is the
//! better guess for programs in which the axis does ramp. Jerks of ramps are lent likewise.
//!
//! Limits: no limit is lent if that of no axis is known; a rotary axis has nothing in common with these
//! axes.

use crate::identification::calibration::is_unknown;
use crate::identification::calibration::motion::axis_among;
use crate::identification::effects::parameters::{AXIS_ACCELERATION, AXIS_JERK, Adjustable};
use crate::identification::fit::{Fit, FreeParameter};
use crate::machine::Machine;

/// Ratios by which accelerations that compensated for the limit of another axis are raised.
const RAISED_BY: [f64; 3] = [1.0, 1.3, 1.7];

/// Gives each acceleration or jerk that the runs hardly determine, and that the machine did not have before, the mean of
/// the others as the value to go back to.
pub fn lend(all: &mut [(FreeParameter, f64)], best: &Fit) {
    for (at, mean) in lent(all, best) {
        all[at].1 = mean;
    }
}

/// Returns the machines from which to fit again, each with the lent limits, and with the accelerations of the others
/// raised by one of `RAISED_BY`; empty if none is lent. If one axis has no limit, the accelerations of the others
/// compensate for it and are too low.
pub fn starts(all: &[(FreeParameter, f64)], best: &Fit) -> Vec<Machine> {
    let lent = lent(all, best);
    if lent.is_empty() {
        return Vec::new();
    }
    let of = |ratio: f64| {
        let mut machine = best.machine.clone();
        machine.axes.iter_mut().for_each(|axis| axis.acceleration *= ratio);
        lent.iter().for_each(|(at, mean)| all[*at].0.apply(&mut machine, *mean));
        machine
    };
    RAISED_BY.map(of).to_vec()
}

/// Returns the lent accelerations (mm/s²) and jerks (mm/s³), each with its place among the parameters.
fn lent(all: &[(FreeParameter, f64)], best: &Fit) -> Vec<(usize, f64)> {
    [AXIS_ACCELERATION, AXIS_JERK].into_iter().flat_map(|limits| lent_among(limits, all, best)).collect()
}

/// Returns those of [`lent`] that are limits of this kind.
fn lent_among(limits: [Adjustable; 3], all: &[(FreeParameter, f64)], best: &Fit) -> Vec<(usize, f64)> {
    let (open, known): (Vec<usize>, Vec<usize>) = (0..all.len())
        .filter(|at| axis_among(limits, &all[*at].0).is_some())
        .partition(|at| is_unknown(&all[*at].0, best.values[*at], best.deviations[*at]));
    let mean = known.iter().map(|at| best.values[*at].ln()).sum::<f64>() / known.len() as f64;
    let is_lent = |at: &usize| mean.is_finite() && !all[*at].1.is_finite();
    open.into_iter().filter(is_lent).map(|at| (at, mean.exp())).collect()
}
