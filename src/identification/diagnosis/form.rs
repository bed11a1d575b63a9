//! Causes that change the form of the path and no time: lag, play, vibration.
//!
//! They are judged by the distance between recorded and simulated positions at equal times, the delay
//! common to all taken out. Values are searched over the trials and then one after another by golden
//! sections.

use crate::identification::comparison::ContourDeviation;
use crate::identification::diagnosis::evidence::Candidate;
use crate::identification::diagnosis::standing::{ELSEWHERE, Standing};
use crate::identification::effects::{Hypothesis, Trace};
use crate::identification::fit::{Run, golden_section};
use crate::machine::Machine;
use crate::simulation::ordered::sort_by_number;

/// What is explained whole leaves so many standard deviations of the noise, or so many mm.
const WHOLE: (f64, f64) = (4.0, 0.01);
/// The same of what is seen beside causes of time: a simulation without drives is that close.
const SEEN: (f64, f64) = (4.0, 2e-3);
/// And of what is searched: of all axes together noise makes the square root of three.
const SEARCHED: (f64, f64) = (2.5, 2e-3);
/// A cause of form must take this part of the error away.
const WORTH: f64 = 0.35;
/// And what it takes away be larger than this, by squares, mm.
const LEAST: f64 = 2e-3;
/// Rounds of golden sections, and sections in each.
const ROUNDS: (usize, usize) = (3, 7);
/// Parts of a recording that are independent, and the step at which it is seen what each says of a value.
const PARTS: usize = 16;
const STEP: f64 = 2e-3;
/// A cause of form must take that part away also without so many of the parts in which it does most: what is off
/// for a moment, such as a wait that nobody knows, has the form of anything.
const MOMENTS: usize = 2;
/// Causes of form that are searched between their trials.
const REFINED: usize = 2;

/// The form error of a machine, mm; none without positions.
pub fn error(machine: &Machine, runs: &[Run]) -> Option<f64> {
    let of = |on_time: bool| {
        let forms = forms(machine, runs, on_time);
        (!forms.is_empty()).then(|| rms(&forms, machine))
    };
    of(true).zip(of(false)).map(|(on_time, in_step)| on_time.min(in_step))
}

/// What a form error that noise or a simulation without drives leaves is below, mm.
fn floor(runs: &[Run], (times, least): (f64, f64)) -> f64 {
    let noise = runs.iter().filter_map(|run| run.alignment.track.as_ref()).map(|track| track.noise);
    (times * noise.fold(0.0, f64::max)).max(least)
}

/// Whether a form error is more than noise or a simulation without drives leaves.
pub fn is_seen(error: f64, runs: &[Run]) -> bool {
    floor(runs, SEEN) < error
}

/// The runs with their times as they are, `on_time`, or in step with the recording.
fn forms(machine: &Machine, runs: &[Run], on_time: bool) -> Vec<ContourDeviation> {
    let of_run = |run: &Run| {
        let plan = run.plan(machine);
        let comparison = crate::identification::comparison::compare(run.toolpath, &plan, run.alignment);
        let residuals = (!on_time).then_some(&comparison.residuals[..]);
        ContourDeviation::new(run.toolpath, &plan, run.alignment, &comparison.simulated, residuals)
    };
    runs.iter().filter_map(of_run).collect()
}

fn rms(forms: &[ContourDeviation], machine: &Machine) -> f64 {
    let squares: f64 = forms.iter().map(|form| form.error(machine).0.powi(2)).sum();
    (squares / forms.len().max(1) as f64).sqrt()
}

/// The causes of form, at most one of each id: those that explain the error whole, or else, if `whole` is
/// not asked for, those that take away much of it.
pub fn explained(machine: &Machine, runs: &[Run], library: &[Hypothesis], whole: bool) -> Vec<Candidate> {
    let forms = forms(machine, runs, whole);
    if forms.is_empty() || Standing::of(machine) == Standing::Misses {
        return Vec::new();
    }
    let floor = floor(runs, if whole { WHOLE } else { SEARCHED });
    let before = rms(&forms, machine);
    if before < floor.max(machine.form_error.map_or(0.0, |left| ELSEWHERE * left)) {
        return Vec::new();
    }
    let mut current = machine.clone();
    let mut named: Vec<Candidate> = Vec::new();
    let mut error = before;
    for _ in 0..3 {
        let open = library.iter().filter(|hypothesis| {
            let is_named = |named: &Candidate| named.hypothesis.is_same_as(hypothesis);
            hypothesis.trace() == Trace::Form && !named.iter().any(is_named)
        });
        let mut tried: Vec<Candidate> =
            open.filter_map(|hypothesis| screened(&forms, &current, hypothesis)).collect();
        sort_by_number(&mut tried, |one| one.cost);
        tried.truncate(REFINED);
        let refined = tried.into_iter().map(|candidate| refined(&forms, &current, candidate));
        let Some(candidate) = refined.min_by(|a, b| a.cost.total_cmp(&b.cost)) else { break };
        let with = candidate.hypothesis.machine(&current, &candidate.values);
        let is_worth = candidate.cost <= (1.0 - WORTH) * error
            && LEAST.powi(2) <= error.powi(2) - candidate.cost.powi(2);
        if !is_worth || !is_all_along(&forms, &current, &with) {
            break;
        }
        error = candidate.cost;
        current = with;
        named.push(candidate);
        if error < floor {
            break;
        }
    }
    if whole && (floor < error || 0.5 * before < error) { Vec::new() } else { named }
}

/// Whether a machine is as much closer than another without the parts of the recordings where it most is.
fn is_all_along(forms: &[ContourDeviation], without: &Machine, with: &Machine) -> bool {
    let parts =
        |machine: &Machine| forms.iter().flat_map(|form| form.parts(machine, PARTS)).collect::<Vec<f64>>();
    let mut both: Vec<(f64, f64)> = parts(without).into_iter().zip(parts(with)).collect();
    sort_by_number(&mut both, |one| -(one.0 - one.1));
    let rest = both.get(MOMENTS..).unwrap_or_default();
    let (before, after) = rest.iter().fold((0.0, 0.0), |sums, part| (sums.0 + part.0, sums.1 + part.1));
    after < (1.0 - WORTH).powi(2) * before
}

/// A hypothesis at the best of its trials; its cost is the form error, mm.
fn screened(forms: &[ContourDeviation], machine: &Machine, hypothesis: &Hypothesis) -> Option<Candidate> {
    let tried = hypothesis.trials.iter().map(|values| {
        let cost = rms(forms, &hypothesis.machine(machine, values));
        let deviations = vec![f64::NAN; values.len()];
        Candidate {
            hypothesis: hypothesis.clone(),
            values: values.clone(),
            deviations,
            cost,
            beside: Vec::new(),
        }
    });
    tried.min_by(|a, b| a.cost.total_cmp(&b.cost))
}

/// The same at its best values.
fn refined(forms: &[ContourDeviation], machine: &Machine, candidate: Candidate) -> Candidate {
    let Candidate { hypothesis, mut values, cost: mut least, .. } = candidate;
    let error = |values: &[f64]| rms(forms, &hypothesis.machine(machine, values));
    let trials = &hypothesis.trials;
    let at = trials.iter().position(|trial| *trial == values).unwrap_or(0);
    let width = |freed: usize| match freed {
        0 => {
            let side = |at: usize| hypothesis.freed[0].to_internal(trials[at][0]);
            let low = side(at.saturating_sub(1));
            let high = side((at + 1).min(trials.len() - 1));
            0.5 * (high - low).abs()
        }
        _ => 1.5,
    };
    let mut widths: Vec<f64> = (0..values.len()).map(width).collect();
    for _ in 0..ROUNDS.0 {
        for (place, freed) in hypothesis.freed.iter().enumerate() {
            let centre = freed.to_internal(values[place]);
            golden_section((centre - widths[place], centre + widths[place]), ROUNDS.1, |varied| {
                let mut there = values.clone();
                there[place] = freed.from_internal(varied);
                let found = error(&there);
                if found < least {
                    (least, values) = (found, there);
                }
                found
            });
            widths[place] *= 0.3;
        }
    }
    // By how much the value would be another, were one part of the recording left out or another one there.
    let parts = |values: &[f64]| -> Vec<f64> {
        let machine = hypothesis.machine(machine, values);
        forms.iter().flat_map(|form| form.parts(&machine, PARTS)).collect()
    };
    let here = parts(&values);
    let deviations = hypothesis.freed.iter().enumerate().map(|(place, freed)| {
        let beside = |sign: f64| {
            let mut there = values.clone();
            there[place] = freed.from_internal(freed.to_internal(values[place]) + sign * STEP);
            parts(&there)
        };
        let (below, above) = (beside(-1.0), beside(1.0));
        let count = here.len() as f64;
        let slopes: Vec<f64> =
            below.iter().zip(&above).map(|(below, above)| (above - below) / (2.0 * STEP)).collect();
        let mean = slopes.iter().sum::<f64>() / count;
        let scatter =
            slopes.iter().map(|slope| (slope - mean).powi(2)).sum::<f64>() * count / (count - 1.0).max(1.0);
        let bend = |at: usize| (below[at] + above[at] - 2.0 * here[at]) / (STEP * STEP);
        let curvature = (0..here.len()).map(bend).sum::<f64>();
        let varied = if 0.0 < curvature { scatter.sqrt() / curvature } else { 1.0 };
        freed.deviation(values[place], varied.min(1.0)).hypot(freed.floor(values[place]))
    });
    let deviations = deviations.collect();
    Candidate { hypothesis: hypothesis.clone(), values, deviations, cost: least, beside: Vec::new() }
}
