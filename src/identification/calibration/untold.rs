//! Accelerations that the runs do not determine.
//!
//! An axis that never ramps at its limit leaves it open. Two axes that only ramp together leave both open: a line
//! in the direction d has the acceleration min_k a_k/|d_k|, and one direction does not show which of them is the
//! least. An axis is determined if the other parameters, fitted again without its limit, are farther from the runs,
//! and if the standard deviation of the fit is small. The machine file names the axes that are not determined, and
//! a diagnosis fits their accelerations again beside a cause. It goes no lower than the least acceleration at which the
//! calibrating runs would not have been slower: on the same program, a lower one cannot explain the lost time of a cause.

use crate::identification::calibration::alike::AlikeAxes;
use crate::identification::calibration::judgement::Judgement;
use crate::identification::calibration::motion::axis_of;
use crate::identification::calibration::{MIN_CONTRADICTING_COST, ParameterVerdict, largest_shift};
use crate::identification::effects::parameters::{AXIS_ACCELERATION, MAX_OVERRIDE};
use crate::identification::fit::{Fit, FreeParameter, Run, Whitening, cost_of};
use crate::machine::{ArcChords, CHORD_ERROR_RATIOS, Machine};

/// Least shift of any moment of the runs, s, from which they determine a limit. Below it, a fit follows the error
/// of the model.
const MIN_MOVED_S: f64 = 0.015;
/// Number of halvings of the range, as a ratio, in which a least acceleration is searched: to 1.8 %.
const HALVINGS: usize = 7;
/// Largest relative standard deviation of a limit that the runs determine. A cause would be off by as much, and a
/// diagnosis calls more than that part of the lost time unexplained.
pub const MAX_RELATIVE_DEVIATION: f64 = 0.05;

/// Returns `true` for each axis whose acceleration the runs do not determine: it is lent from other axes, its
/// standard deviation is too large, or the other parameters fit as well without its limit. `alike` are the axes whose
/// accelerations are one parameter.
pub fn untold(
    judgement: &Judgement,
    alike: AlikeAxes,
    runs: &[Run],
    whitenings: &[Whitening],
    mut fitted: impl FnMut(&Machine, &[(FreeParameter, f64)]) -> Fit,
) -> [bool; 3] {
    let Judgement { all, believed, verdicts, last, .. } = judgement;
    let mut untold = [false; 3];
    let is_lent = |at: usize| verdicts[at] == ParameterVerdict::Unknown && !believed[at].is_finite();
    for at in (0..all.len()).filter(|at| is_lent(*at)) {
        if let Some(axis) = axis_of(&all[at].0) {
            untold[axis] = true;
        }
    }
    let is_vague = |value: f64, deviation: f64| MAX_RELATIVE_DEVIATION * value < deviation;
    for axis in alike.axes {
        let mut without = last.machine.clone();
        without.axes[*axis].acceleration = f64::INFINITY;
        untold[*axis] = is_vague(last.machine.axes[*axis].acceleration, alike.deviations[*axis])
            || is_unseen(&without, cost_of(&without, runs, whitenings), last, runs);
    }
    let fitted_ones = (0..all.len()).filter(|at| verdicts[*at] == ParameterVerdict::Fitted);
    for (place, at) in fitted_ones.enumerate() {
        let freed = &all[at].0;
        let Some(axis) = axis_of(freed).filter(|axis| !alike.axes.contains(axis)) else { continue };
        if is_vague(last.values[place], last.deviations[place]) {
            untold[axis] = true;
            continue;
        }
        let mut without = last.machine.clone();
        freed.apply(&mut without, freed.bounds.1);
        let is_freed =
            |other: usize| other != at && (verdicts[other] == ParameterVerdict::Fitted || is_lent(other));
        let rest = (0..all.len()).filter(|other| is_freed(*other)).map(|other| {
            let (freed, before) = &all[other];
            (freed.starting_at(freed.handle.get(&last.machine).unwrap_or(freed.start)), *before)
        });
        let rest = fitted(&without, &rest.collect::<Vec<_>>());
        untold[axis] = is_unseen(&rest.machine, rest.cost, last, runs);
    }
    untold
}

/// Returns the least acceleration of each axis that is `untold`, mm/s²: with a lower one the runs would have been slower.
/// 0 for the other axes; `None` if there are no untold ones.
pub fn least(last: &Fit, untold: [bool; 3], runs: &[Run], whitenings: &[Whitening]) -> Option<[f64; 3]> {
    let of_axis = |axis: usize| {
        let own = last.machine.axes[axis].acceleration;
        let lowest = AXIS_ACCELERATION[axis].assumed(own, 0.0).bounds.0;
        let is_allowed = |acceleration: f64| {
            let mut lower = last.machine.clone();
            lower.axes[axis].acceleration = acceleration;
            is_unseen(&lower, cost_of(&lower, runs, whitenings), last, runs)
        };
        if !untold[axis] || !own.is_finite() {
            return 0.0;
        }
        if is_allowed(lowest) {
            return lowest;
        }
        let (mut contradicted, mut allowed) = (lowest, own);
        for _ in 0..HALVINGS {
            let between = (contradicted * allowed).sqrt();
            *if is_allowed(between) { &mut allowed } else { &mut contradicted } = between;
        }
        contradicted
    };
    untold.contains(&true).then(|| [0, 1, 2].map(of_axis))
}

/// Returns the largest override for which the control may plan its corners as far as the runs show; `None` if they
/// determine that override, or if the control does not blend corners in time.
pub fn largest_override(last: &Fit, runs: &[Run], whitenings: &[Whitening]) -> Option<f64> {
    let interpolator = &last.machine.interpolator;
    let is_allowed = |other: &&Machine| {
        interpolator.junction.blends_in_time()
            && interpolator.max_override < other.interpolator.max_override
            && cost_of(other, runs, whitenings) < last.cost + MIN_CONTRADICTING_COST
    };
    MAX_OVERRIDE
        .guesses_on(&last.machine)
        .iter()
        .filter(is_allowed)
        .map(|other| other.interpolator.max_override)
        .reduce(f64::max)
}

/// Returns those of [`CHORD_ERROR_RATIOS`] at which the chords of arcs would be the same to the runs, because other limits
/// slow their arcs, or because they have none; none if the control has no chords.
pub fn other_chord_ratios(last: &Fit, runs: &[Run], whitenings: &[Whitening]) -> Vec<f64> {
    let has_chords = last.machine.interpolator.arc_chords != ArcChords::Whole;
    let is_allowed = |ratio: &f64| {
        let other = last.machine.with_scaled_chords(*ratio);
        is_unseen(&other, cost_of(&other, runs, whitenings), last, runs)
    };
    CHORD_ERROR_RATIOS.into_iter().filter(|ratio| has_chords && is_allowed(ratio)).collect()
}

/// Returns `true` if the runs cannot distinguish a machine with this cost from the machine of the last fit.
fn is_unseen(machine: &Machine, cost: f64, last: &Fit, runs: &[Run]) -> bool {
    cost < last.cost + MIN_CONTRADICTING_COST || largest_shift([&last.machine, machine], runs) < MIN_MOVED_S
}

#[cfg(test)]
mod tests {
    use nalgebra::DMatrix;

    use super::*;
    use crate::identification::alignment::recorded;
    use crate::machine::{FREE_BLEND_MM, Junction, Planner};

    /// Calls `test` with legs along X and Y that are blended within a tolerance, mm, and with a fit that has the machine that
    /// ran them.
    fn on_blended_legs(tolerance: f64, test: impl FnOnce(Fit, &[Run], &[Whitening])) {
        let mut machine = Machine::default();
        machine.interpolator.junction = Junction::AccelerationBlend;
        machine.interpolator.contour_tolerance = tolerance;
        machine.axes.iter_mut().for_each(|axis| axis.acceleration = 500.0);
        on_program("G1 X100 F3000\nY100\nX0\nY0", machine, test);
    }

    /// Calls `test` with the run of a program, and with a fit that has the machine that ran it.
    fn on_program(program: &str, machine: Machine, test: impl FnOnce(Fit, &[Run], &[Whitening])) {
        let (toolpath, alignment) = recorded(program, &machine, 1e-3);
        let runs = [Run { toolpath: &toolpath, alignment: &alignment, overrides: (None, None) }];
        let whitenings = [Whitening::new(&alignment, 1e-3)];
        let last = Fit {
            cost: cost_of(&machine, &runs, &whitenings),
            machine,
            values: Vec::new(),
            deviations: Vec::new(),
            correlations: DMatrix::zeros(0, 0),
            whitened: Vec::new(),
            converged: true,
        };
        test(last, &runs, &whitenings);
    }

    fn on_legs(test: impl FnOnce(Fit, &[Run], &[Whitening])) {
        on_blended_legs(0.01, test);
    }

    /// A tolerance keeps the corners as small as they are without any override.
    #[test]
    fn corners_within_a_tolerance_do_not_show_the_override_that_they_are_planned_for() {
        let largest = |last: Fit, runs: &[Run], whitenings: &[Whitening]| {
            assert_eq!(last.machine.interpolator.max_override, 1.0);
            largest_override(&last, runs, whitenings)
        };
        on_blended_legs(0.01, |last, runs, whitenings| {
            assert_eq!(largest(last, runs, whitenings), Some(2.0))
        });
        on_blended_legs(FREE_BLEND_MM, |last, runs, whitenings| {
            assert_eq!(largest(last, runs, whitenings), None)
        });
    }

    /// On chords of length l, grbl is no faster than v² = 8 a δ (r/l)², 54 mm/s here: neither shorter nor longer chords change a feed of
    /// 17 mm/s, only longer ones 47 mm/s, and both 100 mm/s.
    #[test]
    fn arcs_show_their_chords_where_these_slow_them() {
        let ratios = |feed: f64| {
            let mut machine = Machine::default();
            machine.become_planner(Planner::JunctionDeviation, 1190.0);
            machine.interpolator.junction = Junction::Deviation(5e-4);
            let program = format!("G1 X10 F{feed}\nG3 X10 Y20 I0 J10\nG1 X0\nG3 X0 Y0 I0 J-10\n");
            let mut found = Vec::new();
            on_program(&program, machine, |last, runs, whitenings| {
                found = other_chord_ratios(&last, runs, whitenings);
            });
            found
        };
        assert_eq!(ratios(1000.0), CHORD_ERROR_RATIOS);
        assert_eq!(ratios(2840.0), [0.2]);
        assert_eq!(ratios(6000.0), Vec::<f64>::new());
    }

    /// Both axes hold the run back, but the runs hardly determine the value of Y.
    #[test]
    fn an_alike_axis_with_a_vague_value_is_untold() {
        on_legs(|last, runs, whitenings| {
            let (all, believed, verdicts, deviations) = Default::default();
            let judgement = Judgement { all, believed, verdicts, deviations, last };
            let untold_with = |deviation_of_y: f64| {
                let alike = AlikeAxes { axes: &[0, 1], deviations: [1.0, deviation_of_y, f64::INFINITY] };
                untold(&judgement, alike, runs, whitenings, |_, _| unreachable!("nothing is fitted"))
            };
            assert_eq!(untold_with(20.0), [false; 3]);
            assert_eq!(untold_with(30.0), [false, true, false]);
            assert_eq!(untold_with(f64::INFINITY), [false, true, false]);
        });
    }

    #[test]
    fn a_lower_acceleration_than_the_least_one_would_have_slowed_the_runs() {
        on_legs(|last, runs, whitenings| {
            assert_eq!(least(&last, [false; 3], runs, whitenings), None);
            let found = least(&last, [false, true, true], runs, whitenings).expect("two are untold");
            // The runs determine X. Z never moves, so any acceleration that a fit tries is allowed.
            assert!(found[0] == 0.0 && (found[2] - 50.0).abs() < 1e-9, "{found:?}");
            let shift = |ratio: f64| {
                let mut slower = last.machine.clone();
                slower.axes[1].acceleration = ratio * found[1];
                largest_shift([&last.machine, &slower], runs)
            };
            assert!(MIN_MOVED_S < shift(0.99) && shift(1.02) < MIN_MOVED_S, "{found:?}");
        });
    }
}
