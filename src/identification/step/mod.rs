//! One recorded straight move → the filters of the interpolator.
//!
//! A single block of length L at feedrate F, from rest to rest, is a rectangular command of the duration Tv =
//! L/F, so that a control records behind the filters
//!
//! ```text
//! feedrate   v(t) = F [V(t − t0) − V(t − t0 − Tv)]
//! position   p(t) = p0 + F [S(t − t0) − S(t − t0 − Tv)]
//! ```
//!
//! with the step responses V and S of the filter chain. For one to four equal filters, and for two unequal
//! ones (the seven-segment profile), least squares determine F, t0, Tv, p0 and the time constants; the
//! sampling may be irregular and its start is free. A command of duration Tv behind one filter T cannot be
//! distinguished from a command of duration T behind a filter Tv. With one filter or an unequal pair, the
//! command is therefore assumed to be longer than any filter: L ≥ F T1.
//!
//! Standard uncertainties come from the scatter of the residuals and the Jacobian, and so assume noise that
//! is independent from sample to sample. If neighbouring residuals have a correlation ρ > 0, n samples count
//! as n (1 − ρ)/(1 + ρ) independent ones.
//!
//! The filters are chosen by the Bayesian information criterion
//!
//! ```text
//! BIC = m ln(RSS/n) + k ln m
//! ```
//!
//! over the n samples on the ramps, where the models differ, with the sum RSS of the squared residuals, k
//! parameters and m = (n − k) (1 − ρ)/(1 + ρ). Samples at rest or in the cruise are not evidence. If the BIC
//! of a model is within [`TELLING_MARGIN`] of the best, this recording cannot distinguish the two, and the
//! model is listed as a rival. Two unequal filters contain one filter and two equal ones as limits: they are
//! preferred to these only beyond that margin, and are rivals only if their BIC is lower.
//!
//! Source: Ward et al. 2021, Sect. 2.2, where T1 = Tacc/n is read from a chart.

mod along;
mod misfit;
mod response;
#[cfg(test)]
mod tests;

pub use along::identify_move;
pub use response::RecordedQuantity;

use std::ops::Range;

use crate::identification::step::misfit::{Minimum, minimise};
use crate::identification::step::response::{Response, Shape};
use crate::simulation::running_sum::running_sum;

/// Difference of BIC from which on the recording distinguishes two models: odds above 100 to 1.
pub const TELLING_MARGIN: f64 = 10.0;

/// Largest residual that counts as noise, as a part of the feedrate; of the length it is half of this part.
const LARGEST_RESIDUAL: f64 = 0.05;

/// Residuals below this part of the recorded range are rounding.
const ROUNDING_RATIO: f64 = 1e-11;

/// Largest time between the move and a sample at rest that is used, as a multiple of the time from 10 % to 90
/// % of the length.
const REST: f64 = 1.5;

/// A recorded move along a line.
#[derive(Clone, Copy, Debug)]
pub struct Recording<'a> {
    /// Time of each sample, s; rising.
    pub times: &'a [f64],
    /// Recorded values, mm or mm/s, one per time.
    pub values: &'a [f64],
    /// Recorded quantity.
    pub quantity: RecordedQuantity,
}

/// A value with its standard uncertainty, in one unit; infinite if the recording does not determine it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The value.
    pub value: f64,
    /// One standard deviation.
    pub uncertainty: f64,
}

/// A candidate of filter chains.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filters {
    /// This number of filters of one time constant.
    Equal(usize),
    /// Two filters of different time constants.
    UnequalPair,
}

impl Filters {
    /// All candidates.
    pub const ALL: [Filters; 5] =
        [Filters::Equal(1), Filters::Equal(2), Filters::Equal(3), Filters::Equal(4), Filters::UnequalPair];

    /// Returns the number of filters.
    pub fn order(self) -> usize {
        match self {
            Filters::Equal(order) => order,
            Filters::UnequalPair => 2,
        }
    }

    /// Returns `true` if these filters become `other` at a limit of their time constants.
    fn contains(self, other: Filters) -> bool {
        self == Filters::UnequalPair && matches!(other, Filters::Equal(1 | 2))
    }
}

/// One filter chain fitted to the recording.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// Filters.
    pub filters: Filters,
    /// Time constants, s; one if they are equal, otherwise the longer first.
    pub time_constants: Vec<Estimate>,
    /// Beginning of the command, t0, s on the clock of the recording.
    pub start: Estimate,
    /// Commanded feedrate F, mm/s; negative where the position falls.
    pub feedrate: Estimate,
    /// Length of the move L = F Tv, mm; with the sign of the feedrate.
    pub length: Estimate,
    /// Root mean square of the residuals, in the unit of the recording.
    pub residual_rms: f64,
    /// Bayesian information criterion; only differences are meaningful.
    pub bic: f64,
    /// Samples taken while the filters rise or fall.
    pub samples_on_ramps: usize,
    /// `true` if the least squares converged.
    pub converged: bool,
}

impl Fit {
    /// Returns the time constants of all filters, s.
    pub fn chain(&self) -> Vec<f64> {
        match self.filters {
            Filters::Equal(order) => vec![self.time_constants[0].value; order],
            Filters::UnequalPair => self.time_constants.iter().map(|constant| constant.value).collect(),
        }
    }
}

/// All fits and the choice among them.
#[derive(Clone, Debug, PartialEq)]
pub struct Identification {
    /// A fit for each of [`Filters::ALL`], in that order.
    pub fits: Vec<Fit>,
    /// Index of the chosen fit.
    pub chosen: usize,
    /// Indices of the fits that the recording cannot distinguish from the chosen one.
    pub rivals: Vec<usize>,
    /// Number of independent samples on the ramps, m.
    pub effective_samples: f64,
}

impl Identification {
    /// Returns the chosen fit.
    pub fn best(&self) -> &Fit {
        &self.fits[self.chosen]
    }

    /// Returns `true` if the recording distinguishes the chosen filters from all others.
    pub fn is_certain(&self) -> bool {
        self.rivals.is_empty()
    }
}

/// The outcome of an identification.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// The filters are known as well as the recording allows.
    Converged(Identification),
    /// The least squares of the best fit did not converge.
    LostPatience(Identification),
    /// Something other than one straight move was recorded.
    NotASingleMove {
        /// Unexplained residual over feedrate, or over length; 1 if nothing moves.
        unexplained: f64,
    },
    /// The ramps pass between the samples.
    TooFewSamples {
        /// Samples on the ramps of the best fit, or all samples if there are very few.
        found: usize,
        /// Least number of samples.
        needed: usize,
    },
    /// The columns are not a recording.
    Unreadable(Fault),
}

/// The reason why columns are not a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Fault {
    /// The columns differ in length.
    #[error("{times} times and {values} values")]
    LengthsDiffer {
        /// Number of times.
        times: usize,
        /// Number of values.
        values: usize,
    },
    /// A number that is not finite.
    #[error("row {row}: not a finite number")]
    NotFinite {
        /// Index of the row, from 0.
        row: usize,
    },
    /// A time that does not ascend.
    #[error("row {row}: the time is not after that of the row before")]
    TimeNotRising {
        /// Index of the row, from 0.
        row: usize,
    },
}

/// Identifies the filters from a recorded move.
///
/// # Examples
///
/// ```
/// use truefeed::identification::step::{Outcome, RecordedQuantity, Recording, identify};
/// use truefeed::simulation::filter::FilterChain;
///
/// // A move of 9 mm at 100 mm/s, behind three filters of 20 ms.
/// let filters = FilterChain::equal(3, 0.02);
/// let times: Vec<f64> = (0..200).map(|row| 1e-3 * f64::from(row)).collect();
/// let values: Vec<f64> = times
///     .iter()
///     .map(|time| 100.0 * (filters.step(time - 0.02) - filters.step(time - 0.11)))
///     .collect();
/// match identify(&Recording { times: &times, values: &values, quantity: RecordedQuantity::Feedrate }) {
///     Outcome::Converged(found) => assert_eq!(found.best().filters.order(), 3),
///     other => panic!("{other:?}"),
/// }
/// ```
pub fn identify(recording: &Recording) -> Outcome {
    if let Err(fault) = checked(recording) {
        return Outcome::Unreadable(fault);
    }
    let needed = Response::MOST_PARAMETERS + 2;
    if recording.times.len() < needed {
        return Outcome::TooFewSamples { found: recording.times.len(), needed };
    }
    let Some(move_) = Move::of(recording) else {
        return Outcome::NotASingleMove { unexplained: 1.0 };
    };
    let unexplained = move_.elsewhere(recording);
    if !is_noise(unexplained) {
        return Outcome::NotASingleMove { unexplained };
    }
    let (times, values) = move_.cut(recording);
    if times.len() < needed {
        return Outcome::TooFewSamples { found: times.len(), needed };
    }
    let minima: Option<Vec<(Response, Minimum)>> = Filters::ALL
        .into_iter()
        .map(|filters| {
            let response = Response { times, quantity: recording.quantity, filters };
            let guess = response.guess(values, move_.middle, move_.width)?;
            let minimum = minimise(&response, values, guess);
            Some((response, minimum))
        })
        .collect();
    minima.map_or(Outcome::NotASingleMove { unexplained: 1.0 }, |minima| conclude(&minima, values))
}

fn checked(recording: &Recording) -> Result<(), Fault> {
    let Recording { times, values, .. } = recording;
    if times.len() != values.len() {
        return Err(Fault::LengthsDiffer { times: times.len(), values: values.len() });
    }
    if let Some(row) = (0..times.len()).find(|&row| !times[row].is_finite() || !values[row].is_finite()) {
        return Err(Fault::NotFinite { row });
    }
    match (1..times.len()).find(|&row| times[row] <= times[row - 1]) {
        Some(row) => Err(Fault::TimeNotRising { row }),
        None => Ok(()),
    }
}

/// The place of the move in a recording.
struct Move {
    /// Time at half of the length, s.
    middle: f64,
    /// Time from 10 % to 90 % of the length, s.
    width: f64,
    from: f64,
    to: f64,
}

impl Move {
    /// Returns the place of the move, from the times at which it has covered parts of its length; `None` if
    /// the recording ends where it began.
    fn of(recording: &Recording) -> Option<Move> {
        let Recording { times, values, .. } = recording;
        let travelled: Vec<f64> = match recording.quantity {
            RecordedQuantity::Position => values.iter().map(|value| value - values[0]).collect(),
            RecordedQuantity::Feedrate => {
                let gaps = times.windows(2).zip(values.windows(2));
                let areas = gaps.map(|(t, v)| (t[1] - t[0]) * 0.5 * (v[0] + v[1]));
                [0.0].into_iter().chain(running_sum(areas)).collect()
            }
        };
        let farthest = travelled.iter().fold(0.0, |most: f64, way| most.max(way.abs()));
        let whole = travelled[travelled.len() - 1];
        if whole.is_nan() || whole.abs() <= 0.5 * farthest || !farthest.is_finite() {
            return None;
        }
        let done = |part: f64| {
            let after = travelled.iter().position(|way| part <= way / whole)?.max(1);
            let (before, way) = (travelled[after - 1] / whole, travelled[after] / whole);
            let share = if before < way { ((part - before) / (way - before)).clamp(0.0, 1.0) } else { 1.0 };
            Some(times[after - 1] + share * (times[after] - times[after - 1]))
        };
        let (tenth, middle, rest) = (done(0.1)?, done(0.5)?, done(0.9)?);
        let width = rest - tenth;
        (0.0 < width).then_some(Move { middle, width, from: tenth - REST * width, to: rest + REST * width })
    }

    /// Returns the samples of the move and of some rest around it.
    fn cut<'a>(&self, recording: &Recording<'a>) -> (&'a [f64], &'a [f64]) {
        let used = self.used(recording);
        (&recording.times[used.clone()], &recording.values[used])
    }

    /// Returns the indices of these samples.
    fn used(&self, recording: &Recording) -> Range<usize> {
        let from = recording.times.partition_point(|&time| time < self.from);
        from..recording.times.partition_point(|&time| time <= self.to)
    }

    /// Returns by how much a recording differs from rest before and behind the samples that are used: the RMS of its
    /// feedrate as a part of the largest one, or twice that of its position as a part of the length.
    fn elsewhere(&self, recording: &Recording) -> f64 {
        let Recording { values, quantity, .. } = recording;
        let (first, last) = (values[0], values[values.len() - 1]);
        let rests = match quantity {
            RecordedQuantity::Position => [first, last],
            RecordedQuantity::Feedrate => [0.0; 2],
        };
        let used = self.used(recording);
        let before = values[..used.start].iter().map(|value| value - rests[0]);
        let behind = values[used.end..].iter().map(|value| value - rests[1]);
        let outside = (values.len() - used.len()).max(1) as f64;
        let rms = (before.chain(behind).map(|off| off * off).sum::<f64>() / outside).sqrt();
        let fastest = values.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
        as_part(rms, *quantity, fastest, last - first)
    }
}

/// Compares the fits on the samples on the ramps of any of them.
fn conclude(minima: &[(Response, Minimum)], values: &[f64]) -> Outcome {
    let samples = values.len();
    let shapes: Vec<Shape> = minima.iter().map(|(response, m)| response.shape(&m.parameters)).collect();
    let on_ramps = |shape: &Shape, row: usize| shape.on_ramp(minima[0].0.times[row]);
    let telling: Vec<usize> =
        (0..samples).filter(|&row| shapes.iter().any(|shape| on_ramps(shape, row))).collect();
    let sum_of_squares =
        |minimum: &Minimum| -> f64 { telling.iter().map(|&row| minimum.residuals[row].powi(2)).sum() };
    let (low, high) = values.iter().fold((f64::MAX, f64::MIN), |(a, b), &v| (a.min(v), b.max(v)));
    let floor = telling.len() as f64 * (ROUNDING_RATIO * (high - low)).powi(2);
    let sums: Vec<f64> = minima.iter().map(|(_, minimum)| sum_of_squares(minimum).max(floor)).collect();
    let closest = lowest(&sums);
    let shrink = independence(&minima[closest].1.residuals);
    let effective = |parameters: usize| telling.len().saturating_sub(parameters) as f64 * shrink;
    let fewest = effective(Response::MOST_PARAMETERS);
    let fits: Vec<Fit> = minima
        .iter()
        .zip(&shapes)
        .zip(&sums)
        .map(|(((response, minimum), shape), sum)| {
            let spread = sum / telling.len().max(1) as f64;
            let bic = fewest * spread.ln() + response.parameters() as f64 * fewest.max(1.0).ln();
            let found = (0..samples).filter(|&row| on_ramps(shape, row)).count();
            fit(response, minimum, found, if bic.is_finite() { bic } else { 0.0 })
        })
        .collect();
    let bics: Vec<f64> = fits.iter().map(|fit| fit.bic).collect();
    let first = lowest(&bics);
    let within = |other: &usize| bics[*other] - bics[first] < TELLING_MARGIN;
    let simpler = (0..fits.len()).filter(|&other| fits[first].filters.contains(fits[other].filters));
    let chosen = simpler.filter(within).min_by(|&a, &b| bics[a].total_cmp(&bics[b])).unwrap_or(first);
    let rivals = (0..fits.len())
        .filter(|&other| other != chosen && bics[other] - bics[chosen] < TELLING_MARGIN)
        .filter(|&other| other == first || !fits[other].filters.contains(fits[chosen].filters))
        .collect();
    let best = &fits[chosen];
    let quantity = minima[chosen].0.quantity;
    let unexplained = as_part(best.residual_rms, quantity, best.feedrate.value, best.length.value);
    if !is_noise(unexplained) {
        return Outcome::NotASingleMove { unexplained };
    }
    let needed = minima[chosen].0.parameters_on_ramps() + 1;
    if best.samples_on_ramps < needed {
        return Outcome::TooFewSamples { found: best.samples_on_ramps, needed };
    }
    let converged = best.converged;
    let identification = Identification { chosen, rivals, effective_samples: fewest, fits };
    if converged { Outcome::Converged(identification) } else { Outcome::LostPatience(identification) }
}

/// Returns a root mean square of feedrates as a part of the feedrate of a move (mm/s), or twice that of positions as a
/// part of its length (mm).
fn as_part(rms: f64, quantity: RecordedQuantity, feedrate: f64, length: f64) -> f64 {
    match quantity {
        RecordedQuantity::Feedrate => rms / feedrate.abs(),
        RecordedQuantity::Position => 2.0 * rms / length.abs(),
    }
}

/// Returns `true` if this part of a move may be noise.
fn is_noise(unexplained: f64) -> bool {
    unexplained <= LARGEST_RESIDUAL
}

/// Returns the index of the lowest number.
fn lowest(numbers: &[f64]) -> usize {
    (0..numbers.len()).min_by(|&a, &b| numbers[a].total_cmp(&numbers[b])).expect("there is at least one")
}

/// Returns the parameters of a minimum with their uncertainties.
fn fit(response: &Response, minimum: &Minimum, on_ramps: usize, bic: f64) -> Fit {
    let samples = minimum.residuals.len();
    let squares: f64 = minimum.residuals.iter().map(|residual| residual * residual).sum();
    let freedom = (samples - response.parameters()) as f64 * independence(&minimum.residuals);
    let variance = squares / freedom;
    let uncertainty = |gradient: &[f64]| -> f64 {
        let Some(cofactors) = &minimum.cofactors else { return f64::INFINITY };
        let gradient = nalgebra::DVector::from_column_slice(gradient);
        (variance * (gradient.transpose() * cofactors * &gradient)[0]).max(0.0).sqrt()
    };
    let derived = response.derived(&minimum.parameters, uncertainty);
    Fit {
        filters: response.filters,
        time_constants: derived.time_constants,
        start: derived.start,
        feedrate: derived.feedrate,
        length: derived.length,
        residual_rms: (squares / samples as f64).sqrt(),
        bic,
        samples_on_ramps: on_ramps,
        converged: minimum.converged,
    }
}

/// Returns the part of the samples that counts as independent: (1 − ρ)/(1 + ρ) with the correlation ρ of
/// neighbouring residuals, if ρ is more than chance.
fn independence(residuals: &[f64]) -> f64 {
    let squares: f64 = residuals.iter().map(|residual| residual * residual).sum();
    let products: f64 = residuals.windows(2).map(|pair| pair[0] * pair[1]).sum();
    let correlation = products / squares;
    if correlation.is_nan() || correlation < 2.0 / (residuals.len() as f64).sqrt() {
        return 1.0;
    }
    (1.0 - correlation) / (1.0 + correlation)
}
