//! Machine and runs → [`Calibration`]: the machine that predicts the next program.
//!
//! A calibration fits these parameters if the runs show them: order and constant of the filters, contour tolerance,
//! rapid feedrate, and the time of each kind of stop. Planners have no filters; their parameters are instead the
//! accelerations of axes or path and the law of corners (`families`), or the limits by which they plan ramps and
//! corners (`steps`). The fit is that of [`crate::identification::fit`]; this module judges its result:
//!
//! - a parameter that the runs do not show, or show with a relative standard deviation above
//!   `MAX_KNOWN_RELATIVE_DEVIATION`, keeps its value, and its verdict gives the reason; an acceleration that an
//!   axis did not have before is taken from the other axes (`assumed`);
//! - a value that the data do not contradict is kept: with it, and all others fitted again, the cost is higher by
//!   less than `MIN_CONTRADICTING_COST`. The values are judged one after another, because parameters that depend on each
//!   other hide each other;
//! - the rate of the recorder's clock is fitted beside them if positions are recorded, because accelerations would make up for
//!   a clock that is off by a thousandth; it is expected to be right to 5·10⁻⁴;
//! - a log of lines and feedrates at polls does not show the shape of ramps: the order and the family do not
//!   change, and each wait is the median of its visits, which no error of the motion shifts;
//! - the order of the filters does not change unless another one lowers the cost by the larger of
//!   `MIN_ORDER_COST_DROP` and the part `MIN_ORDER_COST_DROP_RATIO`, and rapid moves keep the filters of feed moves
//!   unless separate filters lower it by the margin of `laws`, the total delay being the first guess of each. The
//!   other laws of `laws` follow the same rule; a law that is taken is not put back. Another family must be better
//!   by `BETTER_FAMILY` or `BETTER_STEPS` than the filters with all laws that they need.

mod alike;
mod assumed;
mod choice;
mod excerpts;
mod families;
mod held_accelerations;
mod held_jerks;
mod jerk_limits;
mod judgement;
mod laws;
mod motion;
mod planners;
mod ramp_doubt;
mod rapid_feedrates;
mod rapid_moves;
mod rapids;
mod spindle;
mod steps;
mod untold;
mod waits;

use nalgebra::DMatrix;

pub use excerpts::{CALIBRATION_WINDOWS_S, DIAGNOSIS_WINDOWS_S, Excerpt, excerpts};
pub use rapids::RapidPlateaus;
pub use untold::MAX_RELATIVE_DEVIATION;
pub use waits::guesses;

use crate::identification::alignment::Method;
use crate::identification::calibration::choice::{Fitting, Model};
use crate::identification::calibration::judgement::Judgement;
use crate::identification::calibration::untold::Untold;
use crate::identification::comparison::{Comparison, Durations};
use crate::identification::effects::parameters::PROGRAM_START;
use crate::identification::fit::{
    Exactness, FTOL, Fit, FreeParameter, Run, VariationScale, Whitening, cost_of, fit, ramp_misfit,
    whitenings_in_common,
};
use crate::machine::{Handle, Machine, TimeConstants};
use crate::simulation::feed::Tolerances;

/// Largest relative standard deviation at which a positive parameter counts as known.
const MAX_KNOWN_RELATIVE_DEVIATION: f64 = 0.4;
/// Least decrease of the cost for which another filter order is taken.
const MIN_ORDER_COST_DROP: f64 = 15.0;
/// Least decrease of the cost for which another filter order is taken, as a part of the cost.
const MIN_ORDER_COST_DROP_RATIO: f64 = 0.1;
/// Least decrease of the cost for which another family of controls is taken, as a part of the cost.
const BETTER_FAMILY: f64 = 0.3;
/// Least decrease of the cost for which a planner with steps of velocity at corners is taken, as a part of the
/// cost; the runs of such planners are often logs of lines.
const BETTER_STEPS: f64 = 0.02;
/// Standard deviation above which a wait counts as unknown if it also exceeds the wait itself, s.
const MOST_UNCERTAIN: f64 = 0.5;
/// Standard deviation of the fit above which a wait read off a log of lines counts as unknown, s.
const MAX_POLLED_WAIT_DEVIATION_S: f64 = 5.0;
/// Increase of the cost from which the runs contradict going back to a value: two standard deviations.
const MIN_CONTRADICTING_COST: f64 = 4.0;
/// Difference between a fitted value and the one before, in standard deviations, from which going back is not
/// tried.
const MAX_DOUBTFUL_DEVIATIONS: f64 = 5.0;
/// Cost tolerance of fits that are only compared with each other: the relative decrease of the cost below which
/// they stop.
const ROUGH_COST_TOLERANCE: f64 = 3e-3;
/// Ratio of the noise that a fit leaves to the noise before it, below which the fit is repeated.
const MAX_NOISE_RATIO: f64 = 0.8;
/// Largest number of these fits, the first one included.
const MAX_NOISE_ROUNDS: usize = 6;

/// The result of a calibration for one parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ParameterVerdict {
    /// The parameter has the fitted value.
    Fitted,
    /// The data do not contradict the value before, which the parameter keeps.
    Agrees,
    /// The data do not show the parameter, which keeps the value before.
    Unknown,
    /// The parameter has the value that the recorded rapids hold.
    Recorded,
}

/// A parameter after the calibration.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    /// Key in the machine file.
    pub key: String,
    /// Value before the calibration, core units.
    pub before: f64,
    /// Value in the calibrated machine, core units.
    pub value: f64,
    /// Standard deviation of the fitted value, core units; `None` if it is unknown.
    pub deviation: Option<f64>,
    /// Result of the calibration for the parameter.
    pub verdict: ParameterVerdict,
}

/// A run compared with the machine before and after the calibration.
#[derive(Clone, Debug)]
pub struct RunResult {
    /// Comparison with the machine before the calibration.
    pub before: Comparison,
    /// Comparison with the calibrated machine.
    pub after: Comparison,
    /// Contour tolerance under which most of the run was cut, mm.
    pub tolerance: f64,
}

/// A calibrated machine with the results of its calibration.
#[derive(Clone, Debug)]
pub struct Calibration {
    /// Calibrated machine.
    pub machine: Machine,
    /// Results for each parameter.
    pub estimates: Vec<Estimate>,
    /// Keys of the parameters of the last fit, with their correlations.
    pub correlations: (Vec<String>, DMatrix<f64>),
    /// Orders of filters tried, each with its cost.
    pub orders: Vec<(usize, f64)>,
    /// Results for the runs, in the order given.
    pub runs: Vec<RunResult>,
    /// Fitted parameters, which begin with the value found, each with its value before.
    pub fitted: Vec<(FreeParameter, f64)>,
    /// `true` if the last fit converged.
    pub converged: bool,
}

impl Calibration {
    /// Returns the largest relative error that the calibrated machine leaves in a duration of the runs by which it
    /// was calibrated, at most 1.
    pub fn worst_error(&self, of: fn(&Comparison) -> Durations) -> f64 {
        let errors = self.runs.iter().map(|run| of(&run.after).relative_error().abs());
        errors.filter(|error| error.is_finite()).fold(0.0, f64::max).min(1.0)
    }
}

/// Calibrates a machine by runs on it. `progress` is called with the completed fraction, 0 to 1.
pub fn calibrate(machine: &Machine, runs: &[Run], progress: &mut dyn FnMut(f64)) -> Calibration {
    let before = compared(machine, runs);
    let excerpts = excerpts_for_choice(runs);
    let parts: Vec<Run> = excerpts.iter().map(Excerpt::run).collect();
    let (mut fitting, guess) = Fitting::new(machine, runs, &before, progress);
    let (model, orders) = fitting.model_by_parts(&parts, &guess);
    let judgement = fitting.judgement(&model);
    let Model { whitenings, .. } = model;
    let (judgement, alike) = alike::alike(judgement, |machine, parameters| {
        run_fit(machine, runs, parameters, &whitenings, FTOL, &mut fitting.share)
    });
    let untold = Untold::of(&judgement, alike, &parts, (runs, &whitenings), &mut fitting.share);
    let kept: Vec<(FreeParameter, f64)> = judgement.fitted().cloned().collect();
    let Judgement { all, believed, verdicts, deviations, mut last } = judgement;
    untold.lower_open_jerks(&mut last, &kept);
    let assumed_rapids = rapids::assumed(&last.machine, fitting.plateaus);
    let of_path = last.machine.path.acceleration;
    let is_untold = |freed: &FreeParameter, value: f64, deviation: f64| {
        let of_axis = motion::axis_of(freed);
        // An acceleration of an axis that is as high as that along the path limits nothing.
        of_axis.is_some_and(|axis| {
            untold.accelerations[axis] || of_path < value + MIN_CONTRADICTING_COST.sqrt() * deviation
        }) || motion::rapid_axis_of(freed).is_some_and(|axis| assumed_rapids[axis])
    };
    let mut fitted = last.values.iter().zip(&last.deviations);
    let estimates = all.iter().zip(&verdicts).enumerate().map(|(at, ((freed, before), verdict))| {
        let own = if *verdict == ParameterVerdict::Fitted { fitted.next() } else { None };
        let (value, deviation) = match own {
            Some((value, deviation)) => (*value, *deviation),
            None if *verdict == ParameterVerdict::Recorded => {
                (*before, rapids::deviation_of_plateau(*before))
            }
            None => (*before, deviations[at]),
        };
        Estimate {
            key: freed.handle.key(),
            before: wait_of(freed, machine).unwrap_or(believed[at]),
            value,
            deviation: (deviation.is_finite()
                && *verdict != ParameterVerdict::Unknown
                && !is_untold(freed, value, deviation))
            .then_some(deviation),
            verdict: *verdict,
        }
    });
    let estimates = alike::of_each_axis(estimates.collect(), alike, untold.accelerations, machine);
    last.machine.calibrated_on.acceleration_deviations = motion::acceleration_deviations(&estimates);
    rapids::limit_feed_as_rapids(&mut last.machine, fitting.plateaus);
    let misfit = ramp_misfit(&last.machine, runs);
    last.machine.calibrated_on.ramp_misfit = misfit.of_path;
    last.machine.calibrated_on.assumed_accelerations = untold.accelerations;
    last.machine.calibrated_on.least_accelerations = untold.least_accelerations;
    last.machine.calibrated_on.least_jerks = untold.least_jerks;
    last.machine.calibrated_on.largest_override = untold.largest_override;
    last.machine.calibrated_on.other_chord_ratios = untold.other_chord_ratios;
    last.machine.calibrated_on.assumed_rapids = assumed_rapids;
    last.machine.calibrated_on.only_rapid_feedrate =
        fitting.plateaus.and_then(|seen| seen.feedrates.only_one());
    let after = compared(&last.machine, runs);
    let programmed = Tolerances::Programmed;
    let results = before.into_iter().zip(after).zip(runs).map(|((before, after), run)| {
        let held = programmed.ranges(run.toolpath, &last.machine);
        RunResult { before, after, tolerance: programmed.prevailing(&held, &last.machine) }
    });
    Calibration {
        runs: results.collect(),
        estimates: estimates.into_iter().map(|own| ramp_doubt::doubted(own, &misfit)).collect(),
        correlations: (kept.iter().map(|(freed, _)| freed.handle.key()).collect(), last.correlations),
        fitted: kept
            .into_iter()
            .zip(&last.values)
            .map(|((freed, before), value)| (freed.starting_at(*value), before))
            .collect(),
        orders,
        converged: last.converged,
        machine: last.machine,
    }
}

/// Returns excerpts for the choice of the model. The result is empty if no run is long, or if a run is a log of polls, which
/// shows too little in a window.
fn excerpts_for_choice(runs: &[Run]) -> Vec<Excerpt> {
    let is_polled = runs.iter().any(|run| polled(run).is_some());
    let of_runs = if is_polled { None } else { excerpts(runs, CALIBRATION_WINDOWS_S) };
    of_runs.into_iter().flatten().flatten().collect()
}

/// Returns the comparisons of the runs with a machine.
fn compared(machine: &Machine, runs: &[Run]) -> Vec<Comparison> {
    runs.iter().map(|run| run.compared(machine)).collect()
}

/// Returns the largest difference between the moments of the runs on two machines, s.
fn largest_shift(machines: [&Machine; 2], runs: &[Run]) -> f64 {
    let of_run = |run: &Run| {
        let [one, other] = machines.map(|machine| run.residuals(machine));
        one.iter().zip(other).map(|(one, other)| (one - other).abs()).fold(0.0, f64::max)
    };
    runs.iter().map(of_run).fold(0.0, f64::max)
}

/// Returns the time between polls (s) of a log with lines and feedrates alone; `None` for any other recording.
fn polled(run: &Run) -> Option<f64> {
    run.alignment.poll.filter(|_| run.alignment.method == Method::Lines)
}

/// Returns the whitening of each run, with its sections, at the noise that a machine leaves.
///
/// A control that is polled may report the number of the line it prepares: the number leads the motion by about a
/// poll, more on short blocks than on long ones, and in the same way each time. A mark of such a log therefore
/// counts as no more accurate than a poll; otherwise the fit would follow the lead and not the motion. The error of
/// the model for a program recurs in each of its runs, and a longer run does not reduce it: the runs of one program
/// weigh as one, and by the square root of their durations.
fn whitened(machine: &Machine, runs: &[Run]) -> Vec<Whitening> {
    let whiten = |run: &Run| {
        let residuals = run.residuals(machine);
        let Some(poll) = polled(run) else {
            return Whitening::of(run.alignment, &residuals).with_sections(run.alignment);
        };
        let lasts = |run: &Run| run.alignment.marks.last().map_or(0.0, |mark| mark.time).max(1.0);
        let mean = runs.iter().map(lasts).sum::<f64>() / runs.len() as f64;
        let alike = runs.iter().filter(|other| other.toolpath == run.toolpath).count() as f64;
        let mut alignment = run.alignment.clone();
        alignment.marks.iter_mut().for_each(|mark| mark.deviation = mark.deviation.max(poll));
        Whitening::of(&alignment, &residuals)
            .with_sections(&alignment)
            .with_weight((mean / lasts(run)).sqrt() / alike)
    };
    runs.iter().map(whiten).collect()
}

/// Returns the machine that is nearest to the runs, the first of those that are equally near; `None` if there are
/// no machines.
pub(crate) fn nearest(
    machines: impl IntoIterator<Item = Machine>,
    runs: &[Run],
    whitenings: &[Whitening],
) -> Option<Machine> {
    nearest_with_cost(machines, runs, whitenings).map(|(_, machine)| machine)
}

/// Returns the machine of [`nearest`] after its cost.
fn nearest_with_cost(
    machines: impl IntoIterator<Item = Machine>,
    runs: &[Run],
    whitenings: &[Whitening],
) -> Option<(f64, Machine)> {
    let costs = machines.into_iter().map(|machine| (cost_of(&machine, runs, whitenings), machine));
    costs.min_by(|a, b| a.0.total_cmp(&b.0))
}

/// Returns the whitening of each excerpt, with its only section, at the noise that a machine leaves in all of them.
fn whitened_in_parts(machine: &Machine, parts: &[Run]) -> Vec<Whitening> {
    let whitenings = whitenings_in_common(machine, parts);
    whitenings.into_iter().zip(parts).map(|(own, part)| own.with_equal_sections(1, part.alignment)).collect()
}

/// Returns the sum of the process noises of some whitenings: what a machine leaves.
fn wander(whitenings: &[Whitening]) -> f64 {
    whitenings.iter().map(|own| own.process_noise).sum()
}

/// The share of one of several fits in the progress.
struct Share<'a> {
    done: f64,
    part: f64,
    progress: &'a mut dyn FnMut(f64),
}

fn run_fit(
    machine: &Machine,
    runs: &[Run],
    parameters: &[(FreeParameter, f64)],
    whitenings: &[Whitening],
    hardly: f64,
    share: &mut Share,
) -> Fit {
    let freed: Vec<FreeParameter> = parameters.iter().map(|(freed, _)| freed.clone()).collect();
    let (done, part) = (share.done, share.part);
    let progress = &mut share.progress;
    let found = fit(machine, runs, &freed, whitenings, hardly, &mut |of_this| {
        progress((done + part * of_this).min(1.0))
    });
    share.done += part;
    found
}

/// Returns the fit of the parameters with the verdict `Fitted`, with the others at their values before.
fn put_back(
    best: &Fit,
    all: &[(FreeParameter, f64)],
    verdicts: &[ParameterVerdict],
    runs: &[Run],
    whitenings: &[Whitening],
    share: &mut Share,
) -> Fit {
    let mut base = best.machine.clone();
    let mut kept = Vec::new();
    for (at, ((freed, before), verdict)) in all.iter().zip(verdicts).enumerate() {
        if *verdict == ParameterVerdict::Fitted {
            kept.push((freed.starting_at(best.values[at]), *before));
        } else {
            freed.apply(&mut base, *before);
        }
    }
    run_fit(&base, runs, &kept, whitenings, FTOL, share)
}

/// Sets each fitted wait to the median of its visits.
fn settle_waits(last: &mut Fit, all: &[(FreeParameter, f64)], verdicts: &[ParameterVerdict], runs: &[Run]) {
    let compared = compared(&last.machine, runs);
    let mut seconds: Vec<(Handle, f64)> = waits::guesses(&last.machine, runs, &compared)
        .iter()
        .map(|(kind, seconds)| (kind.handle(), *seconds))
        .collect();
    let start = last.machine.times.start + waits::start_guess(&compared);
    seconds.push((PROGRAM_START.handle(), start));
    let fitted = all.iter().zip(verdicts).filter(|(_, verdict)| **verdict == ParameterVerdict::Fitted);
    for (at, ((freed, _), _)) in fitted.enumerate() {
        if let Some((_, seconds)) = seconds.iter().find(|(handle, _)| *handle == freed.handle) {
            freed.apply(&mut last.machine, *seconds);
            last.values[at] = *seconds;
        }
    }
}

/// Returns `true` if the runs hardly determine a parameter.
fn is_unknown(freed: &FreeParameter, value: f64, deviation: f64) -> bool {
    match freed.scale {
        VariationScale::Ratio => deviation.is_nan() || MAX_KNOWN_RELATIVE_DEVIATION * value < deviation,
        VariationScale::Difference => !deviation.is_finite() || value.abs().max(MOST_UNCERTAIN) < deviation,
    }
}

/// Gives a machine another number of filters with the same total delay.
fn set_order(machine: &mut Machine, order: usize) {
    let interpolator = &mut machine.interpolator;
    if let TimeConstants::Equal(constant) = &mut interpolator.time_constants {
        *constant *= interpolator.filters as f64 / order as f64;
    }
    interpolator.filters = order;
}

/// Returns the time that a machine has for a wait, s; `None` if the parameter is not a wait.
fn wait_of(freed: &FreeParameter, machine: &Machine) -> Option<f64> {
    freed.handle.get(machine).filter(|_| freed.exactness == Exactness::Wait)
}
