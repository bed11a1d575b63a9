//! A feedrate that rises and falls with time: adaptive control, a load that swings, an operator at the override dial.
//!
//! ```text
//!  lost time r                                rate spectrum of r
//!    |    .-.    .-.    .-.                      |      |
//!    |  -'   '--'   '--'   '-                    |      |            f: how often a second
//!    |________________________ t                 |______|_.___.__ f  depth = 2π f A, A amplitude of r
//! ```
//!
//! A pace 1 + d sin 2πft leaves one line in the spectrum. The residual is interpolated at even times and cut into
//! windows with Hann's weights. The amplitude A of each frequency is the median over all windows, so that a wait in one
//! of them does not count. The rate 2π f A of a wandering residual is the same at all frequencies; that of a pulsation
//! exceeds their median [`MIN_POWER_RATIO`] times, in power. An effect of the program is no pulsation: its lost time
//! rises in steps, whose second harmonic has more than [`PURE`] of the power of the first, or an axis moves at the same
//! frequency. Nor is a single place that is slower or faster: it has no line, but as much power beside any frequency. Source
//! of the method: Welch 1967.
//!
//! Limits: frequencies from [`MIN_FREQUENCY_HZ`] to [`MAX_FREQUENCY_HZ`] Hz; depths from [`MIN_DEPTH`]; runs with known positions that
//! last at least one window.

use std::f64::consts::TAU;

use crate::identification::alignment::median;
use crate::identification::comparison::Comparison;
use crate::identification::fit::Run;
use crate::simulation::sampled::rows_around;
use crate::simulation::toolpath::Point;

/// Time between the samples of the residual, s; marks must be about this close.
const SAMPLE_INTERVAL_S: f64 = 0.05;
/// Samples of a window.
const WINDOW_SAMPLES: usize = 256;
/// Lowest frequency searched, Hz.
const MIN_FREQUENCY_HZ: f64 = 0.3;
/// Highest frequency searched, Hz.
const MAX_FREQUENCY_HZ: f64 = 3.0;
/// Distance between searched frequencies, Hz.
const FREQUENCY_STEP_HZ: f64 = 0.04;
/// Least ratio of the power of a pulsation to the median power of all frequencies.
const MIN_POWER_RATIO: f64 = 30.0;
/// Least ratio of the power of an axis at a frequency to its median power, from which on the axis moves at that
/// frequency by itself.
const MOVES: f64 = 8.0;
/// Distance of the frequencies on both sides of a line at which Hann's weights leave nothing of it, Hz.
const RESOLUTION_HZ: f64 = 2.0 / (SAMPLE_INTERVAL_S * WINDOW_SAMPLES as f64);
/// Largest power of the second harmonic of a pulsation, and beside its line, as a part of its power.
const PURE: f64 = 0.1;
/// Least depth of a pulsation, as a part of the feedrate.
const MIN_DEPTH: f64 = 0.01;
/// Largest difference between frequencies that count as one, as a part of the frequency.
const MAX_FREQUENCY_DIFFERENCE: f64 = 0.05;

/// Pace of 1 + `depth` sin 2π `frequency` t.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pulsation {
    /// Frequency, Hz.
    pub frequency: f64,
    /// Amplitude, as a part of the feedrate.
    pub depth: f64,
}

impl Pulsation {
    /// Returns the deepest pulsation that the runs show against a simulation; `None` if they show none.
    pub fn seen(compared: &[Comparison], runs: &[Run]) -> Option<Pulsation> {
        let of_run = |(comparison, run): (&Comparison, &Run)| {
            let times: Vec<f64> = run.alignment.marks.iter().map(|mark| mark.time).collect();
            let found = pulsation(&times, &comparison.residuals)?;
            let fixes = &run.alignment.fixes;
            let sampled =
                |at: usize| Some((fixes[at].time, run.alignment.track.as_ref()?.position[fixes[at].sample?]));
            let (times, positions): (Vec<f64>, Vec<Point>) = (0..fixes.len()).filter_map(sampled).unzip();
            let moves = |axis: usize| {
                let along: Vec<f64> = positions.iter().map(|position| position[axis]).collect();
                Spectrum::of(&times, &along).is_some_and(|axis| axis.has(found.frequency))
            };
            (!times.is_empty() && !(0..3).any(moves)).then_some(found)
        };
        compared.iter().zip(runs).filter_map(of_run).max_by(|a, b| a.depth.total_cmp(&b.depth))
    }

    /// Returns `true` if the frequency is that of another pulsation, within `MAX_FREQUENCY_DIFFERENCE`.
    pub fn is_as_fast(&self, other: &Pulsation) -> bool {
        (self.frequency / other.frequency).ln().abs() < MAX_FREQUENCY_DIFFERENCE
    }
}

/// Returns the pulsation of residuals (s) at ascending times (s); `None` if they show none.
fn pulsation(times: &[f64], residuals: &[f64]) -> Option<Pulsation> {
    let spectrum = Spectrum::of(times, residuals)?;
    let (frequency, depth) =
        frequencies().zip(spectrum.rates.iter().copied()).max_by(|a, b| a.1.total_cmp(&b.1))?;
    let others = [frequency - RESOLUTION_HZ, frequency + RESOLUTION_HZ, 2.0 * frequency];
    let is_pure = others.iter().all(|other| spectrum.rate(*other).powi(2) < PURE * depth * depth);
    (spectrum.is_above(MIN_POWER_RATIO, depth) && is_pure && MIN_DEPTH <= depth)
        .then_some(Pulsation { frequency, depth })
}

fn frequencies() -> impl Iterator<Item = f64> {
    (0..)
        .map(|at| MIN_FREQUENCY_HZ + FREQUENCY_STEP_HZ * f64::from(at))
        .take_while(|frequency| *frequency <= MAX_FREQUENCY_HZ)
}

/// Rates 2π f A at which values change, for each frequency.
struct Spectrum {
    windows: Vec<Vec<f64>>,
    rates: Vec<f64>,
}

impl Spectrum {
    /// Returns the spectrum of values at ascending times (s). `None` if the times are too few for the frequencies, or
    /// too short for a window.
    fn of(times: &[f64], values: &[f64]) -> Option<Spectrum> {
        let (first, last) = (times.first()?, times.last()?);
        if SAMPLE_INTERVAL_S * (times.len() as f64) < 0.5 * (last - first) {
            return None;
        }
        let even = evenly(times, values);
        let windows: Vec<Vec<f64>> =
            even.windows(WINDOW_SAMPLES).step_by(WINDOW_SAMPLES / 2).map(weighted).collect();
        let mut spectrum = Spectrum { windows, rates: Vec::new() };
        spectrum.rates = frequencies().map(|frequency| spectrum.rate(frequency)).collect();
        (!spectrum.windows.is_empty()).then_some(spectrum)
    }

    /// Returns 2π f A of a frequency (Hz), the median over all windows.
    fn rate(&self, frequency: f64) -> f64 {
        let each = self.windows.iter().map(|window| TAU * frequency * amplitude(window, frequency));
        median(&mut each.collect::<Vec<f64>>())
    }

    /// Returns `true` if the power of a rate is more than `times` that of the median over all frequencies.
    fn is_above(&self, times: f64, rate: f64) -> bool {
        times * median(&mut self.rates.clone()).powi(2) < rate * rate
    }

    /// Returns `true` if the values move at about a frequency (Hz).
    fn has(&self, frequency: f64) -> bool {
        let near = |other: &f64| (other / frequency).ln().abs() < MAX_FREQUENCY_DIFFERENCE;
        let beside = frequencies().zip(&self.rates).filter(|(other, _)| near(other)).map(|(_, rate)| *rate);
        self.is_above(MOVES, beside.fold(self.rate(frequency), f64::max))
    }
}

/// Interpolates values at even times, [`SAMPLE_INTERVAL_S`] apart.
fn evenly(times: &[f64], values: &[f64]) -> Vec<f64> {
    let count = ((times[times.len() - 1] - times[0]) / SAMPLE_INTERVAL_S) as usize;
    let mut row = 0;
    let value = |at: usize| {
        let rows = rows_around(times, times[0] + SAMPLE_INTERVAL_S * at as f64, &mut row);
        rows.map_or(0.0, |rows| rows.between(values))
    };
    (0..=count).map(value).collect()
}

/// Returns a window without its straight line, multiplied by Hann's weights.
fn weighted(window: &[f64]) -> Vec<f64> {
    let count = window.len() as f64;
    let centre = 0.5 * (count - 1.0);
    let mean = window.iter().sum::<f64>() / count;
    let away = |at: usize| at as f64 - centre;
    let along: f64 = window.iter().enumerate().map(|(at, value)| away(at) * value).sum();
    let slope = 12.0 * along / (count * (count * count - 1.0));
    let hann = |at: usize| 0.5 - 0.5 * (TAU * (at as f64 + 0.5) / count).cos();
    let of = |(at, value): (usize, &f64)| hann(at) * (value - mean - slope * away(at));
    window.iter().enumerate().map(of).collect()
}

/// Returns the amplitude of a frequency (Hz) in a weighted window; the mean of Hann's weights is ½.
fn amplitude(window: &[f64], frequency: f64) -> f64 {
    let turn = |at: usize| TAU * frequency * SAMPLE_INTERVAL_S * at as f64;
    let sum =
        |of: fn(f64) -> f64| window.iter().enumerate().map(|(at, value)| value * of(turn(at))).sum::<f64>();
    4.0 * sum(f64::cos).hypot(sum(f64::sin)) / window.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn times(seconds: f64) -> Vec<f64> {
        (0..(seconds / 0.02) as usize).map(|at| 0.02 * at as f64).collect()
    }

    #[test]
    fn a_pace_that_swings_is_found_with_its_depth() {
        for (frequency, depth) in [(0.7, 0.05), (1.65, 0.03), (2.4, 0.2)] {
            let times = times(60.0);
            let swing = |time: &f64| 0.03 * time + depth / (TAU * frequency) * (TAU * frequency * time).sin();
            let found = pulsation(&times, &times.iter().map(swing).collect::<Vec<_>>());
            let found = found.expect("it swings");
            assert!((found.frequency / frequency - 1.0).abs() < 0.05, "{found:?} for {frequency} Hz");
            assert!((found.depth / depth - 1.0).abs() < 0.1, "{found:?} for {depth}");
        }
    }

    /// A feed override for two seconds of a run that lasts one window.
    #[test]
    fn one_faster_place_is_no_pulsation() {
        for (from, to) in [(9.5, 11.4), (5.0, 8.0), (6.0, 6.5), (2.0, 6.0)] {
            let times = times(17.5);
            let gained = |time: &f64| -0.38 * (time.clamp(from, to) - from);
            let found = pulsation(&times, &times.iter().map(gained).collect::<Vec<_>>());
            assert_eq!(found, None, "from {from} to {to} s");
        }
    }

    /// Corners at regular intervals lose time in steps.
    #[test]
    fn steps_and_jumps_are_no_pulsation() {
        let times = times(60.0);
        for every in [0.4, 0.9, 2.0] {
            let steps: Vec<f64> = times.iter().map(|time| 0.02 * (time / every).floor()).collect();
            assert_eq!(pulsation(&times, &steps), None, "steps every {every} s");
        }
        let jump: Vec<f64> = times.iter().map(|time| if 31.0 < *time { 2.7 } else { 0.0 }).collect();
        assert_eq!(pulsation(&times, &jump), None);
    }

    #[test]
    fn what_wanders_does_not_pulsate() {
        let times = times(120.0);
        let (mut seed, mut lost) = (7u64, 0.0);
        let wander: Vec<f64> = times
            .iter()
            .map(|_| {
                seed ^= seed << 13;
                seed ^= seed >> 7;
                seed ^= seed << 17;
                lost += 0.01 * ((seed >> 11) as f64 / (1u64 << 53) as f64 - 0.5);
                lost
            })
            .collect();
        assert_eq!(pulsation(&times, &wander), None);
    }

    #[test]
    fn nothing_is_said_of_next_to_nothing() {
        assert_eq!(pulsation(&[], &[]), None);
        assert_eq!(pulsation(&[1.0], &[0.0]), None);
        assert_eq!(pulsation(&[1.0, 1.0], &[0.0, 2.0]), None);
    }
}
