//! Whitening: the residuals of a run as independent numbers.
//!
//! The delay of a recording at the marks is a sum: the time lost so far, which persists from mark to mark,
//! and the error of each mark, which does not. For a process
//!
//! ```text
//! x_k = x_{k−1} + w,  var w = q² Δt        lost so far, s, by what no model knows; q in s/√s
//! r_k = x_k + v,      var v = σ_k²         the residual, s, with the error of the mark
//! ```
//!
//! the innovations ν_k = r_k − E(x_k | r_1 … r_{k−1}), each divided by its standard deviation, are
//! independent with variance 1 (Kalman 1960). They are linear in r, so that the same recursion whitens
//! residuals and derivatives. The start offset is unknown, so that the first mark has no innovation.
//!
//! Robust weights discount deviations that are rare and always of one sign, such as a delay at each entry
//! into a contour, although these can add up to minutes. A fit for cycle times therefore also uses long
//! sections: the time lost in each of `SECTIONS_PER_RUN` equal parts of the run's time, over its standard
//! deviation by the same process.
//!
//! q is chosen so that |ν| has the median of a standard normal variable; outliers then have no
//! influence.

use crate::identification::alignment::{Alignment, median};

/// Median of the absolute value of a standard normal variable.
pub const NORMAL_MEDIAN_DEVIATION: f64 = 0.6745;

/// Number of sections of a run.
const SECTIONS_PER_RUN: usize = 16;

/// The whitening of the residuals of one run.
#[derive(Clone, Debug)]
pub struct Whitening {
    /// Kalman gain at each mark, and one over the standard deviation of its innovation.
    steps: Vec<(f64, f64)>,
    /// Process noise q, s/√s.
    pub process_noise: f64,
    /// First and last mark of each section, and one over the standard deviation of the time lost in it.
    sections: Vec<(usize, usize, f64)>,
}

impl Whitening {
    /// Returns the whitening of the marks of an alignment with the process noise `wander`, s/√s.
    pub fn new(alignment: &Alignment, wander: f64) -> Whitening {
        let marks = &alignment.marks;
        let mut variance = f64::INFINITY;
        let mut before = marks.first().map_or(0.0, |mark| mark.time);
        let steps = marks.iter().map(|mark| {
            let error = mark.deviation * mark.deviation;
            let predicted = variance + wander * wander * (mark.time - before).max(0.0);
            before = mark.time;
            if predicted.is_infinite() {
                variance = error;
                return (1.0, 0.0);
            }
            let gain = predicted / (predicted + error);
            variance = (1.0 - gain) * predicted;
            (gain, 1.0 / (predicted + error).sqrt())
        });
        Whitening { steps: steps.collect(), process_noise: wander, sections: Vec::new() }
    }

    /// Adds the sections of the run, whose residuals follow those of the marks.
    pub fn with_sections(self, alignment: &Alignment) -> Whitening {
        self.with_equal_sections(SECTIONS_PER_RUN, alignment)
    }

    /// Divides the run into `count` sections of equal duration and adds them; their residuals follow those of the marks.
    pub fn with_equal_sections(self, count: usize, alignment: &Alignment) -> Whitening {
        let marks = &alignment.marks;
        let Some((first, last)) = marks.first().zip(marks.last()) else { return self };
        let length = (last.time - first.time) / count as f64;
        let bound = |at: usize| {
            let time = first.time + at as f64 * length;
            marks.partition_point(|mark| mark.time < time).min(marks.len() - 1)
        };
        let section = |at: usize| {
            let (begin, end) = (bound(at), bound(at + 1));
            let lasts = marks[end].time - marks[begin].time;
            let errors = marks[begin].deviation.powi(2) + marks[end].deviation.powi(2);
            let variance = self.process_noise * self.process_noise * lasts + errors;
            (begin < end).then(|| (begin, end, 1.0 / variance.sqrt()))
        };
        let sections = (0..count).filter_map(section).collect();
        Whitening { sections, ..self }
    }

    /// Scales the whitened residuals so that the run has the weight of `weight` runs.
    pub fn with_weight(mut self, weight: f64) -> Whitening {
        let part = weight.sqrt();
        self.steps.iter_mut().for_each(|(_, scale)| *scale *= part);
        self.sections.iter_mut().for_each(|(_, _, scale)| *scale *= part);
        self
    }

    /// Sets the weight of marks that satisfy `is_ignored` to 0; the process continues through them.
    pub fn ignore(&mut self, is_ignored: impl Fn(usize) -> bool) {
        for (mark, (_, scale)) in self.steps.iter_mut().enumerate() {
            if is_ignored(mark) {
                *scale = 0.0;
            }
        }
    }

    /// Returns Σ ln σ² over the innovations, σ being their standard deviations in s. Beside Σ ν², it makes two whitenings
    /// comparable: −2 ln of the likelihood is their sum, up to a constant.
    pub fn log_variance(&self) -> f64 {
        let sections = self.sections.iter().map(|(_, _, scale)| *scale);
        let scales = self.steps.iter().map(|(_, scale)| *scale).chain(sections);
        scales.filter(|scale| 0.0 < *scale).map(|scale| -2.0 * scale.ln()).sum()
    }

    /// Returns the normalised innovations of residuals, one per mark, 0 at the first, followed by the
    /// innovations of the sections.
    pub fn apply(&self, residuals: &[f64]) -> Vec<f64> {
        let mut state = 0.0;
        let whiten = |(residual, (gain, scale)): (&f64, &(f64, f64))| {
            let innovation = residual - state;
            state += gain * innovation;
            innovation * scale
        };
        let marks = residuals.iter().zip(&self.steps).map(whiten);
        let gained =
            |(begin, end, scale): &(usize, usize, f64)| (residuals[*end] - residuals[*begin]) * scale;
        marks.chain(self.sections.iter().map(gained)).collect()
    }

    /// Returns the whitening that makes the residuals (s) of an alignment standard normal.
    pub fn of(alignment: &Alignment, residuals: &[f64]) -> Whitening {
        Whitening::new(alignment, Whitening::common(&[(alignment, residuals)]))
    }

    /// Returns the process noise that makes the residuals (s) of several recordings together standard normal,
    /// s/√s.
    pub fn common(runs: &[(&Alignment, &[f64])]) -> f64 {
        let typical = |wander: f64| {
            let whitened = runs.iter().map(|(alignment, residuals)| {
                Whitening::new(alignment, wander).apply(residuals).into_iter().skip(1)
            });
            let mut sizes: Vec<f64> = whitened.flatten().map(f64::abs).collect();
            median(&mut sizes)
        };
        let (mut low, mut high) = (1e-6f64, 1.0f64);
        if typical(low) <= NORMAL_MEDIAN_DEVIATION {
            return low;
        }
        for _ in 0..30 {
            let middle = (low * high).sqrt();
            if typical(middle) <= NORMAL_MEDIAN_DEVIATION { high = middle } else { low = middle }
        }
        high
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identification::alignment::{Alignment, Mark, Method, ProgramPlace};

    fn alignment(deviation: f64, count: usize) -> Alignment {
        let mark =
            |at: usize| Mark { place: ProgramPlace::Along(at as f64), time: 0.1 * at as f64, deviation };
        Alignment::of_marks(Method::Positions, 0.0..1.0, (0..count).map(mark).collect(), count as f64)
    }

    /// Normal numbers of variance 1, sums of twelve uniform ones, the same every time.
    fn noise(seed: &mut u64) -> f64 {
        let uniform = (0..12).map(|_| {
            *seed ^= *seed << 13;
            *seed ^= *seed >> 7;
            *seed ^= *seed << 17;
            (*seed >> 11) as f64 / (1u64 << 53) as f64
        });
        uniform.sum::<f64>() - 6.0
    }

    /// Residuals (s) of marks every 0.1 s with the deviation of each (s) and the process noise (s/√s), from a seed and the time
    /// lost before (s).
    fn wandering(
        (mut seed, mut lost): (u64, f64),
        (deviation, wander): (f64, f64),
        count: usize,
    ) -> Vec<f64> {
        let residual = |_| {
            lost += noise(&mut seed) * wander * 0.1f64.sqrt();
            lost + noise(&mut seed) * deviation
        };
        (0..count).map(residual).collect()
    }

    #[test]
    fn innovations_of_the_process_are_white() {
        let (deviation, wander, count) = (2e-3, 4e-3, 20_000);
        let alignment = alignment(deviation, count);
        let residuals = wandering((7, 5.0), (deviation, wander), count);
        let white = Whitening::new(&alignment, wander).apply(&residuals);
        let white = &white[1..];
        let mean_square = white.iter().map(|v| v * v).sum::<f64>() / white.len() as f64;
        let lagged = white.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / white.len() as f64;
        assert!((mean_square - 1.0).abs() < 0.05, "{mean_square}");
        assert!(lagged.abs() < 0.03, "{lagged}");
        let found = Whitening::of(&alignment, &residuals).process_noise;
        assert!((found / wander - 1.0).abs() < 0.15, "{found}");
    }

    #[test]
    fn residuals_are_most_likely_at_their_own_noise() {
        let (deviation, wander, count) = (5e-4, 4e-3, 5_000);
        let alignment = alignment(deviation, count);
        let residuals = wandering((11, 0.0), (deviation, wander), count);
        let unlikely = |wander: f64| {
            let whitening = Whitening::new(&alignment, wander).with_sections(&alignment);
            let squares = whitening.apply(&residuals).iter().map(|own| own * own).sum::<f64>();
            squares + whitening.log_variance()
        };
        let own = unlikely(wander);
        assert!(own < unlikely(0.7 * wander) && own < unlikely(1.4 * wander));
    }

    #[test]
    fn a_start_offset_changes_nothing() {
        let alignment = alignment(1e-3, 50);
        let residuals: Vec<f64> = (0..50).map(|at| f64::from(at * at) * 1e-5).collect();
        let shifted: Vec<f64> = residuals.iter().map(|residual| residual + 17.0).collect();
        let whitening = Whitening::new(&alignment, 1e-3);
        let (one, other) = (whitening.apply(&residuals), whitening.apply(&shifted));
        assert!(one.iter().zip(&other).all(|(a, b)| (a - b).abs() < 1e-6));
    }
}
