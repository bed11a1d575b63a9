//! Accelerations, and jerks on ramps, that the runs do not determine.
//!
//! An axis that never ramps at its limit leaves it open. Two axes that only ramp together leave both open: a line
//! in the direction d has the acceleration min_k a_k/|d_k|, and one direction does not show which of them is the
//! least. An axis is determined if the other parameters, fitted again without its limit, are farther from the runs,
//! and if the standard deviation of the fit is small. The machine file names the axes that are not determined, and
//! a diagnosis fits their accelerations again beside a cause. It goes no lower than the least acceleration at which the
//! calibrating runs would not have been slower: on the same program, a lower one cannot explain the lost time of a cause.
//!
//! For a long run the calibration first tries excerpts. If they determine an axis, so does the whole run, and a fit to excerpts is much
//! faster.

use crate::identification::calibration::alike::AlikeAxes;
use crate::identification::calibration::judgement::Judgement;
use crate::identification::calibration::motion::{axis_among, axis_of};
use crate::identification::calibration::{
    MIN_CONTRADICTING_COST, ParameterVerdict, Share, largest_shift, run_fit, whitened_in_parts,
};
use crate::identification::effects::parameters::{AXIS_ACCELERATION, AXIS_JERK, Adjustable, MAX_OVERRIDE};
use crate::identification::fit::{FTOL, Fit, FreeParameter, Run, Whitening, cost_of};
use crate::machine::{ArcChords, CHORD_ERROR_RATIOS, Machine};
use crate::quote::NORMAL_QUANTILE_95;

/// Least shift of any moment of the runs, s, from which they determine a limit. Below it, a fit follows the error
/// of the model.
const MIN_MOVED_S: f64 = 0.015;
/// Ratio of a least value to one that the runs contradict at which the search for it ends.
const MAX_LEAST_RATIO: f64 = 1.018;
/// Largest relative standard deviation of a limit that the runs determine. A cause would be off by as much, and a
/// diagnosis calls more than that part of the lost time unexplained.
pub const MAX_RELATIVE_DEVIATION: f64 = 0.05;

/// Values that the runs of a calibration do not determine.
pub struct Untold {
    /// `true` for each axis whose acceleration the runs do not determine.
    pub accelerations: [bool; 3],
    /// See [`least`].
    pub least_accelerations: Option<[f64; 3]>,
    /// See [`least`]; `None` if the runs determine all jerks.
    pub least_jerks: Option<[f64; 3]>,
    /// See [`largest_override`].
    pub largest_override: Option<f64>,
    /// See [`other_chord_ratios`].
    pub other_chord_ratios: Vec<f64>,
}

impl Untold {
    /// Returns what some runs do not determine of a judgement on them. `parts` are excerpts of the runs if these are long, and
    /// `alike` the axes whose accelerations are one parameter.
    pub fn of(
        judgement: &Judgement,
        alike: AlikeAxes,
        parts: &[Run],
        (runs, whitenings): (&[Run], &[Whitening]),
        share: &mut Share,
    ) -> Untold {
        let calibrated = &judgement.last.machine;
        let whole = Sample::new(calibrated, runs, whitenings);
        let of_parts = whitened_in_parts(calibrated, parts);
        let in_parts = (!parts.is_empty()).then(|| Sample::new(calibrated, parts, &of_parts));
        let samples: Vec<&Sample> = in_parts.iter().chain([&whole]).collect();
        let accelerations = untold(judgement, alike, &samples, share);
        Untold {
            accelerations,
            least_accelerations: least(&whole, accelerations, AXIS_ACCELERATION),
            least_jerks: least_jerks(&whole, judgement),
            largest_override: largest_override(&whole),
            other_chord_ratios: other_chord_ratios(&whole),
        }
    }

    /// Lowers each jerk for which the fit found no upper bound to the one lent from other axes, or to the least that the runs allow: every
    /// higher jerk fits equally well, and the axes of a machine are usually alike. `fitted` are the parameters of the last fit, each with the lent value.
    pub fn lower_open_jerks(&self, last: &mut Fit, fitted: &[(FreeParameter, f64)]) {
        let least = self.least_jerks.unwrap_or_default();
        for (place, (freed, lent)) in fitted.iter().enumerate() {
            let Some(axis) = axis_among(AXIS_JERK, freed) else { continue };
            let lowered = lent.max(least[axis]);
            let is_open = 0.0 < least[axis] && !last.deviations[place].is_finite();
            if is_open && lowered < last.values[place] {
                last.values[place] = lowered;
                freed.apply(&mut last.machine, lowered);
            }
        }
    }
}

/// Runs, or excerpts of them, that may show a difference from the calibrated machine.
struct Sample<'a> {
    calibrated: &'a Machine,
    runs: &'a [Run<'a>],
    whitenings: &'a [Whitening],
    /// Cost of the calibrated machine.
    cost: f64,
}

impl<'a> Sample<'a> {
    /// Returns the sample of some runs of a calibrated machine.
    fn new(calibrated: &'a Machine, runs: &'a [Run<'a>], whitenings: &'a [Whitening]) -> Sample<'a> {
        Sample { calibrated, runs, whitenings, cost: cost_of(calibrated, runs, whitenings) }
    }

    /// Returns `true` if the runs fit another machine as well as the calibrated one.
    fn fits(&self, other: &Machine) -> bool {
        cost_of(other, self.runs, self.whitenings) < self.cost + MIN_CONTRADICTING_COST
    }

    /// Returns `true` if the runs cannot distinguish another machine from the calibrated one.
    fn is_blind_to(&self, other: &Machine) -> bool {
        self.fits(other) || largest_shift([self.calibrated, other], self.runs) < MIN_MOVED_S
    }

    /// Returns the machine with parameters fitted to the sample, from a machine without a limit.
    fn fitted(&self, without: &Machine, parameters: &[(FreeParameter, f64)], share: &mut Share) -> Machine {
        run_fit(without, self.runs, parameters, self.whitenings, FTOL, share).machine
    }
}

/// Returns `true` for each axis whose acceleration the runs do not determine: it is lent from other axes, its
/// standard deviation is too large, or the other parameters fit as well without its limit. `alike` are the axes whose
/// accelerations are one parameter; `samples` are excerpts of the runs, if they are long, and the runs.
fn untold(judgement: &Judgement, alike: AlikeAxes, samples: &[&Sample], share: &mut Share) -> [bool; 3] {
    let Judgement { all, verdicts, last, .. } = judgement;
    let is_lent = |at: usize| is_lent(judgement, at);
    let mut untold = lent_among(judgement, AXIS_ACCELERATION);
    for axis in alike.axes {
        let mut without = last.machine.clone();
        without.axes[*axis].acceleration = f64::INFINITY;
        untold[*axis] = is_vague(last.machine.axes[*axis].acceleration, alike.deviations[*axis])
            || samples.iter().all(|sample| sample.is_blind_to(&without));
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
        let rest: Vec<(FreeParameter, f64)> = (0..all.len())
            .filter(|other| is_freed(*other))
            .map(|other| {
                let (freed, before) = &all[other];
                (freed.starting_at(freed.handle.get(&last.machine).unwrap_or(freed.start)), *before)
            })
            .collect();
        untold[axis] = samples.iter().all(|sample| {
            // A fit of the others only comes nearer to the runs.
            sample.is_blind_to(&without) || sample.is_blind_to(&sample.fitted(&without, &rest, share))
        });
    }
    untold
}

/// Returns the least jerk of each axis whose jerk on ramps the runs do not determine, as [`least`] does for limits that are lent from
/// other axes or whose standard deviation is too large. A jerk is at most [`NORMAL_QUANTILE_95`] deviations below the fitted one.
fn least_jerks(whole: &Sample, judgement: &Judgement) -> Option<[f64; 3]> {
    let mut untold = lent_among(judgement, AXIS_JERK);
    let mut within = [0.0; 3];
    let Judgement { last, .. } = judgement;
    for ((freed, _), (value, deviation)) in judgement.fitted().zip(last.values.iter().zip(&last.deviations)) {
        if let Some(axis) = axis_among(AXIS_JERK, freed) {
            untold[axis] = is_vague(*value, *deviation);
            within[axis] = value - NORMAL_QUANTILE_95 * deviation;
        }
    }
    let least = least(whole, untold, AXIS_JERK)?;
    Some([0, 1, 2].map(|axis| if untold[axis] { least[axis].max(within[axis]) } else { 0.0 }))
}

/// Returns `true` for each axis whose limit among these is lent from other axes.
fn lent_among(judgement: &Judgement, limits: [Adjustable; 3]) -> [bool; 3] {
    let mut lent = [false; 3];
    for at in (0..judgement.all.len()).filter(|at| is_lent(judgement, *at)) {
        if let Some(axis) = axis_among(limits, &judgement.all[at].0) {
            lent[axis] = true;
        }
    }
    lent
}

/// Returns `true` if the value of a parameter is lent from other axes.
fn is_lent(judgement: &Judgement, at: usize) -> bool {
    judgement.verdicts[at] == ParameterVerdict::Unknown && !judgement.believed[at].is_finite()
}

/// Returns `true` if the standard deviation of a limit is too large for a limit that the runs determine.
fn is_vague(value: f64, deviation: f64) -> bool {
    MAX_RELATIVE_DEVIATION * value < deviation
}

/// Returns the least value of each axis that is `untold`, for its limit among these, mm/s² or mm/s³: with a lower one the runs
/// would have been slower. 0 for the other axes; `None` if there are no untold ones.
fn least(whole: &Sample, untold: [bool; 3], limits: [Adjustable; 3]) -> Option<[f64; 3]> {
    let value_of = |axis: usize| limits[axis].handle().get(whole.calibrated).unwrap_or(f64::INFINITY);
    // The fit may have left an undetermined limit many times higher than the others, so the search begins below the lowest.
    let lowest_of_axes = [0, 1, 2].map(value_of).into_iter().fold(f64::INFINITY, f64::min);
    let of_axis = |axis: usize| {
        let own = value_of(axis);
        let freed = limits[axis].assumed(lowest_of_axes.min(own), 0.0);
        let lowest = freed.bounds.0;
        let is_allowed = |value: f64| {
            let mut lower = whole.calibrated.clone();
            freed.apply(&mut lower, value);
            whole.is_blind_to(&lower)
        };
        if !untold[axis] || !own.is_finite() {
            return 0.0;
        }
        if is_allowed(lowest) {
            return lowest;
        }
        let (mut contradicted, mut allowed) = (lowest, own);
        while MAX_LEAST_RATIO * contradicted < allowed {
            let between = (contradicted * allowed).sqrt();
            *if is_allowed(between) { &mut allowed } else { &mut contradicted } = between;
        }
        contradicted
    };
    untold.contains(&true).then(|| [0, 1, 2].map(of_axis))
}

/// Returns the largest override for which the control may plan its corners as far as the runs show; `None` if they
/// determine that override, or if the control does not blend corners in time.
fn largest_override(whole: &Sample) -> Option<f64> {
    let interpolator = &whole.calibrated.interpolator;
    let is_allowed = |other: &&Machine| {
        interpolator.junction.blends_in_time()
            && interpolator.max_override < other.interpolator.max_override
            && whole.fits(other)
    };
    MAX_OVERRIDE
        .guesses_on(whole.calibrated)
        .iter()
        .filter(is_allowed)
        .map(|other| other.interpolator.max_override)
        .reduce(f64::max)
}

/// Returns those of [`CHORD_ERROR_RATIOS`] at which the chords of arcs would be the same to the runs, because other limits
/// slow their arcs, or because they have none; none if the control has no chords.
fn other_chord_ratios(whole: &Sample) -> Vec<f64> {
    let has_chords = whole.calibrated.interpolator.arc_chords != ArcChords::Whole;
    let is_allowed = |ratio: &f64| whole.is_blind_to(&whole.calibrated.with_scaled_chords(*ratio));
    CHORD_ERROR_RATIOS.into_iter().filter(|ratio| has_chords && is_allowed(ratio)).collect()
}

#[cfg(test)]
mod tests {
    use nalgebra::DMatrix;

    use super::*;
    use crate::identification::alignment::recorded;
    use crate::machine::{FREE_BLEND_MM, Junction, Planner};

    /// Calls `test` with the run of legs along X and Y that are blended within a tolerance, mm.
    fn on_blended_legs(tolerance: f64, test: impl FnOnce(Sample)) {
        let mut machine = Machine::default();
        machine.interpolator.junction = Junction::AccelerationBlend;
        machine.interpolator.contour_tolerance = tolerance;
        machine.axes.iter_mut().for_each(|axis| axis.acceleration = 500.0);
        on_program("G1 X100 F3000\nY100\nX0\nY0", machine, test);
    }

    /// Calls `test` with the run of a program by a machine that is calibrated exactly.
    fn on_program(program: &str, machine: Machine, test: impl FnOnce(Sample)) {
        let (toolpath, alignment) = recorded(program, &machine, 1e-3);
        let runs = [Run { toolpath: &toolpath, alignment: &alignment, overrides: (None, None) }];
        let whitenings = [Whitening::new(&alignment, 1e-3)];
        test(Sample::new(&machine, &runs, &whitenings));
    }

    fn on_legs(test: impl FnOnce(Sample)) {
        on_blended_legs(0.01, test);
    }

    /// Returns what [`untold`] says of X and Y, whose accelerations are one parameter, if that of Y has this deviation, mm/s².
    fn untold_of_alike(deviation_of_y: f64, samples: &[&Sample]) -> [bool; 3] {
        let last = Fit {
            machine: samples[0].calibrated.clone(),
            values: Vec::new(),
            deviations: Vec::new(),
            correlations: DMatrix::zeros(0, 0),
            cost: samples[0].cost,
            whitened: Vec::new(),
            converged: true,
        };
        let (all, believed, verdicts, deviations) = Default::default();
        let judgement = Judgement { all, believed, verdicts, deviations, last };
        let alike = AlikeAxes { axes: &[0, 1], deviations: [1.0, deviation_of_y, f64::INFINITY] };
        let progress = &mut |_| panic!("nothing is fitted");
        untold(&judgement, alike, samples, &mut Share { done: 0.0, part: 0.0, progress })
    }

    /// A tolerance keeps the corners as small as they are without any override.
    #[test]
    fn corners_within_a_tolerance_do_not_show_the_override_that_they_are_planned_for() {
        let largest = |whole: Sample| {
            assert_eq!(whole.calibrated.interpolator.max_override, 1.0);
            largest_override(&whole)
        };
        on_blended_legs(0.01, |whole| assert_eq!(largest(whole), Some(2.0)));
        on_blended_legs(FREE_BLEND_MM, |whole| assert_eq!(largest(whole), None));
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
            on_program(&program, machine, |whole| found = other_chord_ratios(&whole));
            found
        };
        assert_eq!(ratios(1000.0), CHORD_ERROR_RATIOS);
        assert_eq!(ratios(2840.0), [0.2]);
        assert_eq!(ratios(6000.0), Vec::<f64>::new());
    }

    /// Both axes hold the run back, but the runs hardly determine the value of Y.
    #[test]
    fn an_alike_axis_with_a_vague_value_is_untold() {
        on_legs(|whole| {
            assert_eq!(untold_of_alike(20.0, &[&whole]), [false; 3]);
            assert_eq!(untold_of_alike(30.0, &[&whole]), [false, true, false]);
            assert_eq!(untold_of_alike(f64::INFINITY, &[&whole]), [false, true, false]);
        });
    }

    /// The excerpt moves X alone. The whole run moves Y too.
    #[test]
    fn an_axis_is_told_if_one_sample_shows_it() {
        on_legs(|whole| {
            let blind = |part: Sample| {
                assert_eq!(untold_of_alike(20.0, &[&part]), [false, true, false]);
                assert_eq!(untold_of_alike(20.0, &[&part, &whole]), [false; 3]);
                assert_eq!(untold_of_alike(20.0, &[&whole, &part]), [false; 3]);
            };
            on_program("G1 X100 F3000\nX0", whole.calibrated.clone(), blind);
        });
    }

    #[test]
    fn a_lower_acceleration_than_the_least_one_would_have_slowed_the_runs() {
        on_legs(|whole| {
            assert_eq!(least(&whole, [false; 3], AXIS_ACCELERATION), None);
            let found = least(&whole, [false, true, true], AXIS_ACCELERATION).expect("two are untold");
            // The runs determine X. Z never moves, so any acceleration that a fit tries is allowed.
            assert!(found[0] == 0.0 && (found[2] - 50.0).abs() < 1e-9, "{found:?}");
            let shift = |ratio: f64| {
                let mut slower = whole.calibrated.clone();
                slower.axes[1].acceleration = ratio * found[1];
                largest_shift([whole.calibrated, &slower], whole.runs)
            };
            assert!(MIN_MOVED_S < shift(0.99) && shift(1.02) < MIN_MOVED_S, "{found:?}");
        });
    }

    /// X is fitted roughly, Y is open above, and Z is known.
    #[test]
    fn an_open_jerk_is_as_low_as_the_others_unless_the_runs_contradict_that() {
        let values = [21_600.0, 589_000.0, 17_800.0];
        let lowered = |least_of_y: f64| {
            let mut last = Fit {
                machine: Machine::default(),
                values: values.to_vec(),
                deviations: vec![2050.0, f64::INFINITY, 40.0],
                correlations: DMatrix::identity(3, 3),
                cost: 0.0,
                whitened: Vec::new(),
                converged: true,
            };
            let freed = AXIS_JERK.iter().zip(values).map(|(jerk, own)| (jerk.assumed(own, 0.0), 19_700.0));
            let untold = Untold {
                accelerations: [false; 3],
                least_accelerations: None,
                least_jerks: Some([18_200.0, least_of_y, 0.0]),
                largest_override: None,
                other_chord_ratios: Vec::new(),
            };
            untold.lower_open_jerks(&mut last, &freed.collect::<Vec<_>>());
            assert_eq!([last.values[0], last.values[2]], [values[0], values[2]]);
            last.values[1]
        };
        assert_eq!(lowered(5_500.0), 19_700.0);
        assert_eq!(lowered(26_000.0), 26_000.0);
        assert_eq!(lowered(600_000.0), 589_000.0);
    }
}
