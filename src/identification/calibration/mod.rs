//! Machine and runs → [`Calibration`]: the machine that predicts the next program.
//!
//! What is fitted, each where the runs show it: order and constant of the filters, contour tolerance,
//! rapid feedrate, and the time of each kind of stop; of planners, which have no filters, instead of these the
//! accelerations of axes or path and the law of corners (`families`) or what ramps and corners are planned by
//! (`steps`). The fit is of [`crate::identification::fit`]; what belongs here is the judgement of its result:
//!
//! - a parameter that the runs say nothing of, or less than ±`UNKNOWN` of, stays at its value, and the
//!   reason is said; an acceleration of an axis that was not there before is taken from the other axes (`assumed`);
//! - a value is kept that the data do not contradict: with it, and all others fitted again, the cost is
//!   higher by less than `CONTRADICTED`. One after another, because parameters that depend on each other
//!   hide behind each other;
//! - a log of lines and feedrates at polls shows no shape of ramps: there the order and the family stay, and
//!   of waits the median of the visits is taken, which no error of the motion moves;
//! - the order of the filters stays unless another one is better by `BETTER_ORDER`, and rapid moves keep
//!   the filters of feed moves unless they are better by the margin of `laws`, the total delay being the
//!   first guess of each. So it is with the other laws there: one that is taken in is not put back. Another family
//!   must be better by `BETTER_FAMILY` or `BETTER_STEPS`, beside the filters with all laws that they need.

mod alike;
mod assumed;
mod choice;
mod families;
mod judgement;
mod laws;
mod motion;
mod rapids;
mod spindle;
mod steps;
mod untold;
mod waits;

use nalgebra::DMatrix;

pub use motion::{ACCELERATIONS, RAPIDS};
pub use rapids::RapidPlateaus;
pub use waits::guesses;

use crate::identification::alignment::Method;
use crate::identification::calibration::choice::{Fitting, Model};
use crate::identification::calibration::judgement::Judgement;
use crate::identification::comparison::{Comparison, Durations, compare};
use crate::identification::fit::{
    Exactness, FTOL, Fit, FreeParameter, Run, VariationScale, Whitening, cost_of, fit,
};
use crate::machine::{Handle, Machine, TimeConstants};
use crate::simulation::feed::Tolerances;

/// A relative standard deviation above which a positive parameter counts as unknown.
const UNKNOWN: f64 = 0.4;
/// By how much, and by what part, the cost must fall for another filter order.
const BETTER_ORDER: (f64, f64) = (15.0, 0.1);
/// By what part the cost must fall for another family of controls.
const BETTER_FAMILY: f64 = 0.3;
/// The same for planners with steps of velocity at corners, whose runs are often logs of lines.
const BETTER_STEPS: f64 = 0.02;
/// A wait that is uncertain by more than itself and by more than this, s, counts as unknown.
const MOST_UNCERTAIN: f64 = 0.5;
/// One that is read off a log of lines counts as unknown where the fit leaves more than this, s.
const SEPARATED: f64 = 5.0;
/// A value is contradicted where going back to it costs more than this: two standard deviations.
const CONTRADICTED: f64 = 4.0;
/// Values farther than this from the one before, in standard deviations, are not tried again.
const DOUBTFUL: f64 = 5.0;
/// A step that gains less than this part of the cost is the last of fits that are only to be compared.
const ROUGHLY: f64 = 3e-3;
/// Orders of filters tried.
const ORDERS: std::ops::RangeInclusive<usize> = 1..=4;

/// Fits are repeated at the noise they leave while that falls below this part of what it was, so many times at most.
const LESS_NOISE: f64 = 0.8;
const MAX_NOISE_ROUNDS: usize = 6;

/// What became of a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// It has the fitted value.
    Fitted,
    /// The data do not contradict the value it had.
    Agrees,
    /// The data say nothing of it; it has the value it had.
    Unknown,
}

/// One parameter after the calibration.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    /// Its key in the machine file.
    pub key: String,
    /// The value before, core units.
    pub before: f64,
    /// The value in the machine now, core units.
    pub value: f64,
    /// Standard deviation of the fitted value, core units; none where it is unknown.
    pub deviation: Option<f64>,
    /// What became of it.
    pub verdict: Verdict,
}

/// A run before and after.
#[derive(Clone, Debug)]
pub struct RunResult {
    /// Against the machine as it was.
    pub before: Comparison,
    /// Against the calibrated machine.
    pub after: Comparison,
    /// Contour tolerance under which most of it was cut, mm.
    pub tolerance: f64,
}

/// A calibrated machine, and how it came about.
#[derive(Clone, Debug)]
pub struct Calibration {
    /// The machine.
    pub machine: Machine,
    /// What became of each parameter.
    pub estimates: Vec<Estimate>,
    /// Keys of what was fitted last, with their correlations.
    pub correlations: (Vec<String>, DMatrix<f64>),
    /// Cost of each order of filters that was tried.
    pub orders: Vec<(usize, f64)>,
    /// The runs, in the order given.
    pub runs: Vec<RunResult>,
    /// What was fitted, beginning with the value found, and the value before.
    pub fitted: Vec<(FreeParameter, f64)>,
    /// Whether the fit came to its end.
    pub converged: bool,
}

impl Calibration {
    /// The largest relative error that the calibrated machine leaves of a duration of its own runs, at most 1.
    pub fn worst_error(&self, of: fn(&Comparison) -> Durations) -> f64 {
        let errors = self.runs.iter().map(|run| of(&run.after).relative_error().abs());
        errors.filter(|error| error.is_finite()).fold(0.0, f64::max).min(1.0)
    }
}

/// Calibrates a machine from runs on it. `progress` is called with the completed fraction, 0 to 1.
pub fn calibrate(machine: &Machine, runs: &[Run], progress: &mut dyn FnMut(f64)) -> Calibration {
    let before = compared(machine, runs);
    let (mut fitting, guess) = Fitting::new(machine, runs, &before, progress);
    let (model, orders) = fitting.model(&guess);
    let judgement = fitting.judgement(&model);
    let Model { whitenings, .. } = model;
    let mut fit = |machine: &Machine, parameters: &[(FreeParameter, f64)]| {
        run_fit(machine, runs, parameters, &whitenings, FTOL, &mut fitting.share)
    };
    let (judgement, as_one) = alike::alike(judgement, &mut fit);
    let untold = untold::untold(&judgement, as_one, runs, &whitenings, &mut fit);
    let kept: Vec<(FreeParameter, f64)> = judgement.fitted().cloned().collect();
    let Judgement { all, believed, verdicts, deviations, mut last } = judgement;
    let is_untold = |freed: &FreeParameter| motion::axis_of(freed).is_some_and(|axis| untold[axis]);
    let mut fitted = last.values.iter().zip(&last.deviations);
    let estimates = all.iter().zip(&verdicts).enumerate().map(|(at, ((freed, before), verdict))| {
        let own = if *verdict == Verdict::Fitted { fitted.next() } else { None };
        let (value, deviation) = match own {
            Some((value, deviation)) => (*value, *deviation),
            None => (*before, deviations[at]),
        };
        Estimate {
            key: freed.handle.key(),
            before: wait_of(freed, machine).unwrap_or(believed[at]),
            value,
            deviation: (deviation.is_finite() && *verdict != Verdict::Unknown && !is_untold(freed))
                .then_some(deviation),
            verdict: *verdict,
        }
    });
    let estimates = alike::of_each_axis(estimates.collect(), as_one, machine);
    rapids::limit_feed_as_rapids(&mut last.machine, fitting.plateaus);
    last.machine.calibrated_on.assumed_accelerations = untold;
    last.machine.calibrated_on.assumed_rapids = rapids::assumed(&last.machine, fitting.plateaus);
    let after = compared(&last.machine, runs);
    let programmed = Tolerances::Programmed;
    let results = before.into_iter().zip(after).zip(runs).map(|((before, after), run)| {
        let held = programmed.ranges(run.toolpath, &last.machine);
        RunResult { before, after, tolerance: programmed.prevailing(&held, &last.machine) }
    });
    Calibration {
        runs: results.collect(),
        estimates,
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

/// The runs against a machine.
fn compared(machine: &Machine, runs: &[Run]) -> Vec<Comparison> {
    runs.iter().map(|run| compare(run.toolpath, &run.plan(machine), run.alignment)).collect()
}

/// The time between polls (s) of a log that has lines and feedrates alone.
fn polled(run: &Run) -> Option<f64> {
    run.alignment.poll.filter(|_| run.alignment.method == Method::Lines)
}

/// The whitening of each run at the noise that a machine leaves, sections with it.
///
/// A line that a control names when it is asked may be the one it prepares: the number leads the motion by
/// about a poll, more on short blocks than on long ones, and in the same way each time. Of such a log a mark is
/// therefore taken to be no better than a poll, or the fit would follow the lead and not the motion. What the
/// model does not know of a program it does not know of each of its runs, and the longer run does not teach it: runs
/// of one program weigh as one, and by the square root of how long they last.
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

/// The machine that is nearest to the runs, the first of those that are equally near; none of none.
fn nearest(
    machines: impl IntoIterator<Item = Machine>,
    runs: &[Run],
    whitenings: &[Whitening],
) -> Option<Machine> {
    let costs = machines.into_iter().map(|machine| (cost_of(&machine, runs, whitenings), machine));
    costs.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, machine)| machine)
}

/// Takes into `best` every law that the runs show, and gives the whitening at the noise that is left.
fn with_laws(
    before: &Machine,
    runs: &[Run],
    best: &mut Fit,
    mut whitenings: Vec<Whitening>,
    mut fitted: impl FnMut(&Machine, &[Whitening]) -> Fit,
) -> Vec<Whitening> {
    let mut is_other = false;
    for choice in laws::CHOICES {
        let first = |law: laws::Law| nearest(law, runs, &whitenings);
        let laws = choice(before, &best.machine, runs).into_iter().filter_map(first);
        let found = laws.map(|machine| fitted(&machine, &whitenings));
        let found = found.min_by(|a, b| a.cost.total_cmp(&b.cost));
        let margin = laws::BETTER.0.max(laws::BETTER.1 * best.cost);
        if let Some(found) = found.filter(|found| found.cost < best.cost - margin) {
            (*best, is_other) = (found, true);
        }
    }
    if is_other {
        whitenings = whitened(&best.machine, runs);
        *best = fitted(&best.machine, &whitenings);
    }
    whitenings
}

/// A fit from a machine at the noise that it leaves, again and again while that falls: at the noise of a wrong law
/// hardly anything tells the values of the right one. With the noise of the last.
fn at_own_noise(
    start: &Machine,
    runs: &[Run],
    mut fitted: impl FnMut(&Machine, &[Whitening]) -> Fit,
) -> (Fit, Vec<Whitening>) {
    let wander = |whitenings: &[Whitening]| whitenings.iter().map(|own| own.process_noise).sum::<f64>();
    let mut whitenings = whitened(start, runs);
    let mut best = fitted(start, &whitenings);
    for _ in 1..MAX_NOISE_ROUNDS {
        let less = whitened(&best.machine, runs);
        if LESS_NOISE * wander(&whitenings) < wander(&less) {
            break;
        }
        whitenings = less;
        best = fitted(&best.machine, &whitenings);
    }
    (best, whitenings)
}

/// Progress of one of several fits.
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

/// The fit of what has the verdict of being fitted, the rest at the values it had.
fn put_back(
    best: &Fit,
    all: &[(FreeParameter, f64)],
    verdicts: &[Verdict],
    runs: &[Run],
    whitenings: &[Whitening],
    share: &mut Share,
) -> Fit {
    let mut base = best.machine.clone();
    let mut kept = Vec::new();
    for (at, ((freed, before), verdict)) in all.iter().zip(verdicts).enumerate() {
        if *verdict == Verdict::Fitted {
            kept.push((freed.starting_at(best.values[at]), *before));
        } else {
            freed.apply(&mut base, *before);
        }
    }
    run_fit(&base, runs, &kept, whitenings, FTOL, share)
}

/// Gives the waits that were fitted the median of their visits.
fn settle_waits(last: &mut Fit, all: &[(FreeParameter, f64)], verdicts: &[Verdict], runs: &[Run]) {
    let compared = compared(&last.machine, runs);
    let pairs: Vec<_> = runs.iter().map(|run| run.toolpath).zip(&compared).collect();
    let mut seconds: Vec<(Handle, f64)> = waits::guesses(&last.machine, &pairs)
        .iter()
        .map(|(kind, seconds, _)| (kind.handle(), *seconds))
        .collect();
    let start = last.machine.times.start + waits::start_guess(&pairs);
    seconds.push((Handle::number("times.start_s"), start));
    let fitted = all.iter().zip(verdicts).filter(|(_, verdict)| **verdict == Verdict::Fitted);
    for (at, ((freed, _), _)) in fitted.enumerate() {
        if let Some((_, seconds)) = seconds.iter().find(|(handle, _)| *handle == freed.handle) {
            freed.apply(&mut last.machine, *seconds);
            last.values[at] = *seconds;
        }
    }
}

/// Whether the runs say hardly anything of a parameter.
fn is_unknown(freed: &FreeParameter, value: f64, deviation: f64) -> bool {
    match freed.scale {
        VariationScale::Ratio => deviation.is_nan() || UNKNOWN * value < deviation,
        VariationScale::Difference => !deviation.is_finite() || value.abs().max(MOST_UNCERTAIN) < deviation,
    }
}

/// Gives a machine another number of filters with the same delay in all.
fn set_order(machine: &mut Machine, order: usize) {
    let interpolator = &mut machine.interpolator;
    if let TimeConstants::Equal(constant) = &mut interpolator.time_constants {
        *constant *= interpolator.filters as f64 / order as f64;
    }
    interpolator.filters = order;
}

/// What a machine has of a wait, s; `None` of other parameters.
fn wait_of(freed: &FreeParameter, machine: &Machine) -> Option<f64> {
    freed.handle.get(machine).filter(|_| freed.exactness == Exactness::Wait)
}
