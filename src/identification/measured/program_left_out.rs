//! The error of a calibrated machine on other programs, estimated by leaving out each program of the
//! calibration.
//!
//! The parameters fitted to all programs are fitted again without one of them; the relative error e of the
//! motion time of that program is then an error on a program unknown to the fit. From n such errors and a
//! prior of [`PRIOR_WEIGHT`] errors of the size u, half of the range that contains nine of ten other programs is
//!
//! ```text
//! r = t(0.95, PRIOR + n) · s √(1 + 1/programs),     s² = (PRIOR · u² + Σ e²) / (PRIOR + n),     u² = ε² + m²
//! ```
//!
//! m is the usual relative error of the fit on the sections of the runs, corrected by √(n/(n − k)) for n sections and k
//! fitted parameters, of which each could make one section right: a model that is off on parts of a run is off on other programs by as much. ε is
//! [`MIN_USUAL_ERROR_RATIO`], the error of models without such errors. The range of a calibration by one program, from which
//! none can be left out, comes from u alone, and each further program moves the range towards its own errors.
//!
//! Sources: the predictive distribution of a normal mean of unknown variance, Gelman et al. 2013, Sect. 3.3;
//! leaving out, Stone 1974.

use crate::identification::alignment::median;
use crate::identification::fit::{FreeParameter, NORMAL_MEDIAN_DEVIATION, Run, Whitening, fit};
use crate::machine::{CalibratedOn, Machine};
use crate::quote::{NORMAL_QUANTILE_95, features_of};

/// Weight of the prior, in errors of the size u.
const PRIOR_WEIGHT: f64 = 4.0;
/// Least usual error on other programs, as a part of the time: the RMS error of calibrations by one program that fit this
/// program almost exactly, 0.18 % on 36 pairs of programs of grbl, Klipper and LinuxCNC (the seeds 135443670, 15238624,
/// 168598907 and 58934268).
const MIN_USUAL_ERROR_RATIO: f64 = 0.002;
/// Number of sections of a run, equally long in time, beyond one for each fitted parameter: as many remain free.
const FREE_SECTIONS: usize = 8;
/// Largest half of the range that a file states, as a part of the time: with a larger one, nothing is known of the time.
const MAX_HALF_RANGE: f64 = 1.0;
/// Relative cost decrease below which a step is the last.
const ROUGH_FTOL: f64 = 1e-2;

/// Returns the calibration entries of a machine file: the possible error on other programs, and the features
/// of the programs of the runs. `freed` are the fitted parameters, each with its value before the fit.
pub fn calibrated_on(machine: &Machine, runs: &[Run], freed: &[(FreeParameter, f64)]) -> CalibratedOn {
    let programs = programs(runs);
    let errors = left_out(machine, runs, freed, &programs);
    CalibratedOn {
        range: Some(half_range(&errors, programs.len(), usual_error(machine, runs, freed.len()))),
        ramp_misfit: machine.calibrated_on.ramp_misfit,
        velocities: velocities(runs),
        assumed_accelerations: machine.calibrated_on.assumed_accelerations,
        least_accelerations: machine.calibrated_on.least_accelerations,
        least_jerks: machine.calibrated_on.least_jerks,
        acceleration_deviations: machine.calibrated_on.acceleration_deviations,
        largest_override: machine.calibrated_on.largest_override,
        other_chord_ratios: machine.calibrated_on.other_chord_ratios.clone(),
        only_rapid_feedrate: machine.calibrated_on.only_rapid_feedrate,
        assumed_rapids: machine.calibrated_on.assumed_rapids,
        ..features_of(runs.iter().map(|run| run.toolpath))
    }
}

/// Time over which velocities are averaged, s: noise of a micrometre changes the mean by less than 0.1 mm/s.
const VELOCITY_WINDOW_S: f64 = 0.02;

/// Returns the highest velocity of each axis in the runs that recorded positions, mm/s; `None` without such a
/// run. A run without positions does not show how an axis reaches its velocity, and so does not support
/// faster moves.
fn velocities(runs: &[Run]) -> Option<[f64; 3]> {
    let mut highest = [0.0f64; 3];
    let tracks: Vec<_> = runs.iter().filter_map(|run| run.alignment.track.as_ref()).collect();
    for track in &tracks {
        let window = (VELOCITY_WINDOW_S / track.interval).ceil().max(1.0) as usize;
        for first in 0..track.time.len().saturating_sub(window) {
            let velocity = track.velocity_between(first, first + window);
            for (highest, velocity) in highest.iter_mut().zip(&velocity) {
                *highest = highest.max(velocity.abs());
            }
        }
    }
    (!tracks.is_empty()).then_some(highest)
}

/// Groups the runs by program, by index.
fn programs(runs: &[Run]) -> Vec<Vec<usize>> {
    let mut programs: Vec<Vec<usize>> = Vec::new();
    for (index, run) in runs.iter().enumerate() {
        match programs.iter_mut().find(|own| runs[own[0]].toolpath == run.toolpath) {
            Some(own) => own.push(index),
            None => programs.push(vec![index]),
        }
    }
    programs
}

/// Returns the relative error of the motion time of each program on the machine fitted to all other programs.
fn left_out(
    machine: &Machine,
    runs: &[Run],
    freed: &[(FreeParameter, f64)],
    programs: &[Vec<usize>],
) -> Vec<f64> {
    if programs.len() < 2 {
        return Vec::new();
    }
    let error = |out: &Vec<usize>| {
        let others: Vec<Run> =
            runs.iter().enumerate().filter(|(at, _)| !out.contains(at)).map(|(_, run)| run.clone()).collect();
        let machine = without(machine, &others, freed);
        let own = out.iter().map(|at| runs[*at].compared(&machine).motion);
        let (simulated, recorded) = own.fold((0.0, 0.0), |(simulated, recorded), motion| {
            (simulated + motion.simulated, recorded + motion.recorded)
        });
        simulated / recorded - 1.0
    };
    programs.iter().map(error).filter(|error| error.is_finite()).collect()
}

/// Returns the machine fitted to these runs alone; parameters that they do not determine keep their value.
fn without(machine: &Machine, runs: &[Run], freed: &[(FreeParameter, f64)]) -> Machine {
    let whiten =
        |run: &Run| Whitening::of(run.alignment, &run.residuals(machine)).with_sections(run.alignment);
    let whitenings: Vec<Whitening> = runs.iter().map(whiten).collect();
    let all: Vec<FreeParameter> = freed.iter().map(|(freed, _)| freed.clone()).collect();
    let found = fit(machine, runs, &all, &whitenings, ROUGH_FTOL, &mut |_| {});
    let mut machine = found.machine;
    for ((freed, before), deviation) in freed.iter().zip(&found.deviations) {
        if !deviation.is_finite() && before.is_finite() {
            freed.apply(&mut machine, *before);
        }
    }
    machine
}

/// Returns u.
fn usual_error(machine: &Machine, runs: &[Run], fitted: usize) -> f64 {
    let mut sizes: Vec<f64> = runs
        .iter()
        .flat_map(|run| section_errors(run, machine, FREE_SECTIONS + fitted))
        .map(f64::abs)
        .collect();
    if sizes.is_empty() {
        return MIN_USUAL_ERROR_RATIO;
    }
    let count = sizes.len();
    let free = count.saturating_sub(fitted).max(1);
    // Unlike a root mean square, a median does not grow by a halt in one section.
    let left = median(&mut sizes) / NORMAL_MEDIAN_DEVIATION * (count as f64 / free as f64).sqrt();
    MIN_USUAL_ERROR_RATIO.hypot(left)
}

/// Returns the relative error of the time of each of `count` sections of a run.
fn section_errors(run: &Run, machine: &Machine, count: usize) -> Vec<f64> {
    let marks = &run.alignment.marks;
    let Some((first, last)) = marks.first().zip(marks.last()) else { return Vec::new() };
    let delays = run.residuals(machine);
    let begin = |section: usize| {
        let time = first.time + (last.time - first.time) * section as f64 / count as f64;
        marks.partition_point(|mark| mark.time < time).min(marks.len() - 1)
    };
    let error = |section: usize| {
        let (from, to) = (begin(section), begin(section + 1));
        (from < to).then(|| (delays[to] - delays[from]) / (marks[to].time - marks[from].time))
    };
    (0..count).filter_map(error).filter(|error| error.is_finite()).collect()
}

fn half_range(errors: &[f64], programs: usize, usual: f64) -> f64 {
    let squares: f64 = errors.iter().map(|error| error * error).sum();
    let freedom = PRIOR_WEIGHT + errors.len() as f64;
    let size = ((PRIOR_WEIGHT * usual * usual + squares) / freedom).sqrt();
    let half = student_95(freedom) * size * (1.0 + 1.0 / programs.max(1) as f64).sqrt();
    half.min(MAX_HALF_RANGE)
}

/// Returns the quantile of Student's distribution below which 95 % lie, to a hundredth from four degrees of
/// freedom on, by the Cornish-Fisher expansion.
fn student_95(freedom: f64) -> f64 {
    let z = NORMAL_QUANTILE_95;
    let first = (z.powi(3) + z) / (4.0 * freedom);
    z + first + (5.0 * z.powi(5) + 16.0 * z.powi(3) + 3.0 * z) / (96.0 * freedom * freedom)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identification::alignment::{Alignment, Method, ProgramPlace, simulated_marks};
    use crate::simulation::gcode::read;
    use crate::simulation::interpreter::trace;
    use crate::simulation::simulate;

    #[test]
    fn the_quantiles_are_those_of_tables() {
        for (freedom, tabled) in [(4.0, 2.132), (7.0, 1.895), (12.0, 1.782), (60.0, 1.671)] {
            assert!((student_95(freedom) / tabled - 1.0).abs() < 0.01, "{freedom}");
        }
    }

    #[test]
    fn a_range_is_never_wider_than_the_time() {
        let halves = [0.01, 0.1, 5.0].map(|error| half_range(&[error; 4], 1, error));
        assert!(halves[0] < halves[1] && halves[1] < halves[2] && halves[2] == MAX_HALF_RANGE, "{halves:?}");
    }

    /// A run that is by turns 1 % slower and 1 % faster than simulated, section by section.
    #[test]
    fn the_usual_error_is_that_of_the_sections_of_the_runs() {
        let machine = Machine::default();
        let legs: String = (1..800).map(|at| format!("G1 X{} F600\n", 0.2 * f64::from(at))).collect();
        let toolpath = trace(&read(legs.as_bytes()), &machine);
        let ends = toolpath.ends().map(ProgramPlace::Along).collect();
        let simulated = simulated_marks(&toolpath, &simulate(&toolpath, &machine), ends, 1e-3);
        let (first, last) = (simulated[0].time, simulated[simulated.len() - 1].time);
        for (fitted, ratio) in [(0, 1.0), (8, 2f64.sqrt()), (24, 2.0)] {
            let section = (last - first) / (FREE_SECTIONS + fitted) as f64;
            let mut marks = simulated.clone();
            for mark in &mut marks {
                let passed = (mark.time - first) / section;
                mark.time += 0.01 * section * (1.0 - (passed % 2.0 - 1.0).abs());
            }
            let alignment = Alignment::of_marks(Method::Positions, first..last, marks, 159.8);
            let runs = [Run { toolpath: &toolpath, alignment: &alignment, overrides: (None, None) }];
            let expected = MIN_USUAL_ERROR_RATIO.hypot(ratio * 0.01 / NORMAL_MEDIAN_DEVIATION);
            let found = usual_error(&machine, &runs, fitted);
            assert!((found / expected - 1.0).abs() < 0.02, "{fitted}: {found}, {expected}");
        }
    }

    #[test]
    fn errors_that_programs_show_take_the_place_of_the_usual_one() {
        let alone = half_range(&[], 1, MIN_USUAL_ERROR_RATIO);
        let small = half_range(&[1e-4; 12], 12, MIN_USUAL_ERROR_RATIO);
        let large = half_range(&[0.05; 12], 12, MIN_USUAL_ERROR_RATIO);
        assert!(small < 0.5 * alone && alone < 0.5 * large, "{small} {alone} {large}");
    }
}
