//! One recorded straight move → the filters of the interpolator.
//!
//! A single block of length L at feedrate F, from rest to rest, is a rectangular pulse of the
//! duration Tv = L/F behind the filters, so what a control records of it is
//!
//! ```text
//! feedrate   v(t) = F [V(t − t0) − V(t − t0 − Tv)]
//! position   p(t) = p0 + F [S(t − t0) − S(t − t0 − Tv)]
//! ```
//!
//! with the step responses V and S of the filter chain. For one to four equal filters, and for two
//! unequal ones (the seven-segment profile), F, t0, Tv, p0 and the time constants are found by
//! least squares; the sampling may be irregular and its start is free. A pulse of duration Tv behind
//! one filter T cannot be told from a pulse of duration T behind a filter Tv, so with one filter or an
//! unequal pair the move is taken to be commanded for longer than any filter lasts: L ≥ F T1.
//!
//! Standard uncertainties come from the scatter of the residuals and the Jacobian, so they hold for
//! noise that differs from sample to sample. Where neighbouring residuals resemble each other by
//! ρ > 0, the samples count as n (1 − ρ)/(1 + ρ) of them.
//!
//! The filters are chosen by the Bayesian information criterion
//!
//! ```text
//! BIC = m ln(RSS/n) + k ln m
//! ```
//!
//! over the n samples on the ramps alone, where the models differ; k parameters; m = (n − k) times
//! the above for resemblance. Samples at rest or in the cruise are not evidence. Models whose BIC is within
//! [`TELLING_MARGIN`] of the best cannot be told apart by this recording, and are named. Two unequal
//! filters contain one filter and two equal ones as limits: they are chosen before those only beyond
//! that margin, and are their rivals only where they do better.
//!
//! Source: Ward et al. 2021, Sect. 2.2, which reads T1 = Tacc/n off a chart.

mod misfit;
mod response;
#[cfg(test)]
mod tests;

pub use response::Quantity;

use crate::identification::step::misfit::{Minimum, minimise};
use crate::identification::step::response::{Response, Shape};

/// Difference of BIC from which one model is preferred beyond doubt: odds above 100 to 1.
pub const TELLING_MARGIN: f64 = 10.0;

/// Residuals larger than this part of the feedrate, or half of it of the length, are not noise.
const LARGEST_RESIDUAL: f64 = 0.05;

/// Residuals below this part of the recorded range are rounding.
const ROUNDING: f64 = 1e-11;

/// How far from the move samples at rest are still used, in times between 10 % and 90 % of the way.
const REST: f64 = 1.5;

/// A recorded move along a line.
#[derive(Clone, Copy, Debug)]
pub struct Recording<'a> {
    /// When each sample was taken, s; rising.
    pub times: &'a [f64],
    /// What was recorded, mm or mm/s; as many as times.
    pub values: &'a [f64],
    /// Which of the two it is.
    pub quantity: Quantity,
}

/// A value with its standard uncertainty, in the same unit; infinite where the recording says nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The value.
    pub value: f64,
    /// One standard deviation.
    pub uncertainty: f64,
}

/// A filter chain that is tried.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filters {
    /// So many filters of the same time constant.
    Equal(usize),
    /// Two filters with time constants of their own.
    UnequalPair,
}

impl Filters {
    /// All that are tried.
    pub const ALL: [Filters; 5] =
        [Filters::Equal(1), Filters::Equal(2), Filters::Equal(3), Filters::Equal(4), Filters::UnequalPair];

    /// How many filters there are.
    pub fn order(self) -> usize {
        match self {
            Filters::Equal(order) => order,
            Filters::UnequalPair => 2,
        }
    }

    /// Whether these filters become `other` at a limit of their time constants.
    fn contains(self, other: Filters) -> bool {
        self == Filters::UnequalPair && matches!(other, Filters::Equal(1 | 2))
    }
}

/// One filter chain fitted to the recording.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// Which filters.
    pub filters: Filters,
    /// Their time constants, s; one if they are equal, otherwise the longer first.
    pub time_constants: Vec<Estimate>,
    /// When the command begins, t0, s on the clock of the recording.
    pub start: Estimate,
    /// Commanded feedrate F, mm/s; negative where the position falls.
    pub feedrate: Estimate,
    /// Length of the move L = F Tv, mm; with the sign of the feedrate.
    pub length: Estimate,
    /// Root mean square of the residuals, in the unit of the recording.
    pub residual_rms: f64,
    /// Bayesian information criterion; only differences mean something.
    pub bic: f64,
    /// Samples taken while the filters rise or fall.
    pub samples_on_ramps: usize,
    /// Whether the least squares came to rest.
    pub converged: bool,
}

impl Fit {
    /// The time constants of all filters, s.
    pub fn chain(&self) -> Vec<f64> {
        match self.filters {
            Filters::Equal(order) => vec![self.time_constants[0].value; order],
            Filters::UnequalPair => self.time_constants.iter().map(|constant| constant.value).collect(),
        }
    }
}

/// All fits and what follows from them.
#[derive(Clone, Debug, PartialEq)]
pub struct Identification {
    /// A fit for each of [`Filters::ALL`], in that order.
    pub fits: Vec<Fit>,
    /// Index of the chosen one.
    pub chosen: usize,
    /// Indices of the fits that the recording cannot tell from it.
    pub rivals: Vec<usize>,
    /// For how many independent samples those on the ramps count, m.
    pub effective_samples: f64,
}

impl Identification {
    /// The chosen fit.
    pub fn best(&self) -> &Fit {
        &self.fits[self.chosen]
    }

    /// Whether the recording tells the chosen filters from all others.
    pub fn is_certain(&self) -> bool {
        self.rivals.is_empty()
    }
}

/// How an identification ended.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// The filters are known as well as the recording allows.
    Converged(Identification),
    /// The least squares of the best fit did not come to rest.
    LostPatience(Identification),
    /// Something other than one straight move was recorded.
    NotASingleMove {
        /// What no filter explains: residual by feedrate, or by length; 1 where nothing moves.
        unexplained: f64,
    },
    /// The ramps pass between the samples.
    TooFewSamples {
        /// Samples on the ramps of the best fit, or samples at all if there are hardly any.
        found: usize,
        /// How many there have to be.
        needed: usize,
    },
    /// The columns are not a recording.
    Unreadable(Fault),
}

/// Why columns are not a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Fault {
    /// The columns differ in length.
    #[error("{times} times and {values} values")]
    LengthsDiffer {
        /// How many times.
        times: usize,
        /// How many values.
        values: usize,
    },
    /// A number that is none.
    #[error("row {row}: not a finite number")]
    NotFinite {
        /// Counted from 0.
        row: usize,
    },
    /// A time that is not after the one before.
    #[error("row {row}: the time is not after that of the row before")]
    TimeNotRising {
        /// Counted from 0.
        row: usize,
    },
}

/// Finds the filters behind a recorded move.
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

/// Where the move lies in a recording.
struct Move {
    /// When half of the way is done, s.
    middle: f64,
    /// Time from 10 % to 90 % of the way, s.
    width: f64,
    from: f64,
    to: f64,
}

impl Move {
    /// Finds the move by the part of the way done; none where the recording ends where it began.
    fn of(recording: &Recording) -> Option<Move> {
        let Recording { times, values, .. } = recording;
        let travelled: Vec<f64> = match recording.quantity {
            Quantity::Position => values.iter().map(|value| value - values[0]).collect(),
            Quantity::Feedrate => {
                let gaps = times.windows(2).zip(values.windows(2));
                let areas = gaps.map(|(t, v)| (t[1] - t[0]) * 0.5 * (v[0] + v[1]));
                let sums = areas.scan(0.0, |sum, area| {
                    *sum += area;
                    Some(*sum)
                });
                [0.0].into_iter().chain(sums).collect()
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

    /// The samples of the move and of some rest around it.
    fn cut<'a>(&self, recording: &Recording<'a>) -> (&'a [f64], &'a [f64]) {
        let from = recording.times.partition_point(|&time| time < self.from);
        let to = recording.times.partition_point(|&time| time <= self.to);
        (&recording.times[from..to], &recording.values[from..to])
    }
}

/// Compares the fits on the samples that lie on the ramps of any of them.
fn conclude(minima: &[(Response, Minimum)], values: &[f64]) -> Outcome {
    let samples = values.len();
    let shapes: Vec<Shape> = minima.iter().map(|(response, m)| response.shape(&m.parameters)).collect();
    let on_ramps = |shape: &Shape, row: usize| shape.on_ramp(minima[0].0.times[row]);
    let telling: Vec<usize> =
        (0..samples).filter(|&row| shapes.iter().any(|shape| on_ramps(shape, row))).collect();
    let sum_of_squares =
        |minimum: &Minimum| -> f64 { telling.iter().map(|&row| minimum.residuals[row].powi(2)).sum() };
    let (low, high) = values.iter().fold((f64::MAX, f64::MIN), |(a, b), &v| (a.min(v), b.max(v)));
    let floor = telling.len() as f64 * (ROUNDING * (high - low)).powi(2);
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
    let unexplained = match minima[chosen].0.quantity {
        Quantity::Feedrate => best.residual_rms / best.feedrate.value.abs(),
        Quantity::Position => 2.0 * best.residual_rms / best.length.value.abs(),
    };
    if unexplained.is_nan() || LARGEST_RESIDUAL < unexplained {
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

/// Index of the lowest number.
fn lowest(numbers: &[f64]) -> usize {
    (0..numbers.len()).min_by(|&a, &b| numbers[a].total_cmp(&numbers[b])).expect("there is at least one")
}

/// What the parameters of a minimum say, with their uncertainties.
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

/// The part of the samples that counts as independent: (1 − ρ)/(1 + ρ) with the correlation ρ of
/// neighbouring residuals, where that is more than chance.
fn independence(residuals: &[f64]) -> f64 {
    let squares: f64 = residuals.iter().map(|residual| residual * residual).sum();
    let products: f64 = residuals.windows(2).map(|pair| pair[0] * pair[1]).sum();
    let correlation = products / squares;
    if correlation.is_nan() || correlation < 2.0 / (residuals.len() as f64).sqrt() {
        return 1.0;
    }
    (1.0 - correlation) / (1.0 + correlation)
}
