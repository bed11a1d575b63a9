//! Causes that change the form of the path and no time: lag, play, vibration.
//!
//! They are judged by the form error: the distance between recorded and simulated positions at equal times,
//! without the delay common to all. The search for values tries the trials, then varies one value after
//! another by golden sections.
//!
//! | measure of the form error | shows best |
//! |---|---|
//! | root mean square over all samples | what acts at a few places, such as a vibration behind corners |
//! | geometric mean over short parts | what acts everywhere, beside a few places where the model is far off |
//!
//! A control that blends corners freely leaves errors of tenths of a millimetre there, whose mean square hides a
//! backlash of a hundredth. The geometric mean is the likelihood of parts whose errors have unknown sizes. It is used
//! where a calibration has measured what it leaves by itself.

use crate::identification::comparison::{ContourDeviation, TYPICAL_PARTS, compare};
use crate::identification::diagnosis::evidence::{Candidate, Looked, with_all};
use crate::identification::diagnosis::standing::{MAX_UNEXPLAINED_RATIO, Standing};
use crate::identification::diagnosis::{Cause, regions};
use crate::identification::effects::{Hypothesis, Trace};
use crate::identification::fit::{Run, golden_section};
use crate::machine::Machine;
use crate::side_by_side::side_by_side;
use crate::simulation::ordered::sort_by_number;

/// Largest form error that counts as explained whole, in standard deviations of the noise of positions; the larger of
/// this and [`WHOLE_MM`] applies.
const WHOLE_DEVIATIONS: f64 = 4.0;
/// Largest form error that counts as explained whole without noise, mm.
const WHOLE_MM: f64 = 0.01;
/// Largest form error beside causes of time that noise explains, in standard deviations of the noise of positions; the
/// larger of this and [`UNSEEN_MM`] applies.
const UNSEEN_DEVIATIONS: f64 = 4.0;
/// Largest form error of a simulation without drives, mm.
const UNSEEN_MM: f64 = 2e-3;
/// Least form error for which the search looks for causes, in standard deviations of the noise of positions: the noise
/// of all axes together is √3 of them. The larger of this and [`SEARCHED_MM`] applies.
const SEARCHED_DEVIATIONS: f64 = 2.5;
/// Least form error for which the search looks for causes without noise, mm.
const SEARCHED_MM: f64 = 2e-3;
/// Least part of the form error that a cause must remove.
const WORTH: f64 = 0.35;
/// Least form error that a cause must remove, as the root of the difference of the squares, mm.
const MIN_REMOVED_MM: f64 = 2e-3;
/// Number of rounds of golden sections, each over all values.
const SEARCH_ROUNDS: usize = 3;
/// Number of golden-section steps for a value in a round.
const STEPS_PER_ROUND: usize = 7;
/// Number of contiguous parts of a recording that count as independent.
const RECORDING_PARTS: usize = 16;
/// Step of the difference quotients of a value, in the optimiser's coordinate: they show the influence of each part of
/// a recording on the value.
const QUOTIENT_STEP: f64 = 2e-3;
/// Number of parts of the recordings without which a cause must still remove [`WORTH`] of the error, those in which it
/// removes most: an error of a moment, such as an unknown wait, resembles any cause of form.
const MOMENTS: usize = 2;
/// Largest number of causes of form.
const MAX_FORM_CAUSES: usize = 3;
/// Number of causes of form whose values are searched between their trials.
const REFINED: usize = 2;

/// Measure of the form error over all samples of a recording.
#[derive(Clone, Copy, Debug, PartialEq)]
enum FormMeasure {
    RootMeanSquare,
    Typical,
}

impl FormMeasure {
    /// Returns the form error of a machine, mm.
    fn of(self, forms: &[ContourDeviation], machine: &Machine) -> f64 {
        let mean = |of: &dyn Fn(&ContourDeviation) -> f64| {
            forms.iter().map(of).sum::<f64>() / forms.len().max(1) as f64
        };
        match self {
            FormMeasure::RootMeanSquare => mean(&|form| form.error(machine).0.powi(2)).sqrt(),
            FormMeasure::Typical => mean(&|form| form.typical_error(machine).ln()).exp(),
        }
    }

    /// Returns the form error that the calibration left, mm; `None` if it is unknown.
    fn calibrated(self, machine: &Machine) -> Option<f64> {
        match self {
            FormMeasure::RootMeanSquare => machine.form_error,
            FormMeasure::Typical => machine.typical_form_error,
        }
    }

    /// Returns the ratio of two form errors, of the machine `with` a cause and of the machine `without`. The parts of
    /// the recordings in which the cause removes most do not count, as many as [`MOMENTS`] of [`RECORDING_PARTS`]. The
    /// ratio is NaN if no part remains that has an error.
    fn ratio_all_along(self, forms: &[ContourDeviation], without: &Machine, with: &Machine) -> f64 {
        let parts = |machine: &Machine| -> Vec<f64> {
            let of = |form: &ContourDeviation| match self {
                FormMeasure::RootMeanSquare => form.parts(machine, RECORDING_PARTS),
                FormMeasure::Typical => form.mean_squares(machine, TYPICAL_PARTS),
            };
            forms.iter().flat_map(of).collect()
        };
        let mut both: Vec<(f64, f64)> = parts(without).into_iter().zip(parts(with)).collect();
        match self {
            FormMeasure::RootMeanSquare => {
                sort_by_number(&mut both, |one| one.1 - one.0);
                let rest = both.get(MOMENTS..).unwrap_or_default();
                let (before, after) =
                    rest.iter().fold((0.0, 0.0), |sums, part| (sums.0 + part.0, sums.1 + part.1));
                (after / before).sqrt()
            }
            FormMeasure::Typical => {
                let mut logarithms: Vec<f64> =
                    both.iter().map(|(before, after)| (after / before).ln()).collect();
                sort_by_number(&mut logarithms, |one| *one);
                let rest = &logarithms[logarithms.len() * MOMENTS / RECORDING_PARTS..];
                (0.5 * rest.iter().sum::<f64>() / rest.len().max(1) as f64).exp()
            }
        }
    }
}

/// Causes of form, and the form errors without and with them, mm.
#[derive(Clone, Debug, Default)]
pub struct Explained {
    pub causes: Vec<Candidate>,
    before: f64,
    after: f64,
}

impl Explained {
    /// Returns the causes with the form errors of other contour deviations; no causes if they remove too little of these.
    fn on(self, measure: FormMeasure, forms: &[ContourDeviation], machine: &Machine) -> Explained {
        if self.causes.is_empty() {
            return self;
        }
        let [before, after] = [machine, &with_all(machine, &self.causes)].map(|own| measure.of(forms, own));
        let causes = if after <= (1.0 - WORTH) * before { self.causes } else { Vec::new() };
        Explained { causes, before, after }
    }

    /// Returns the drives as causes, each with the form error that all of them remove, and with the part of the squared
    /// form error that this is as its confidence.
    pub fn as_causes(&self, runs: &[Run]) -> impl Iterator<Item = Cause> {
        let removed = (self.before * self.before - self.after * self.after).max(0.0).sqrt();
        let confidence = 1.0 - (self.after / self.before).powi(2);
        let lines = regions::all_lines(runs);
        self.causes.iter().map(move |candidate| Cause {
            candidate: candidate.clone(),
            seconds: 0.0,
            form: removed,
            lines: lines.clone(),
            confidence,
            alike: Vec::new(),
            held_out: None,
        })
    }
}

/// Returns a bound of the form error, mm: the larger of a number of standard deviations of the noise and a least error
/// (mm).
fn floor(runs: &[Run], (times, least): (f64, f64)) -> f64 {
    let noise = runs.iter().filter_map(|run| run.alignment.track.as_ref()).map(|track| track.noise);
    (times * noise.fold(0.0, f64::max)).max(least)
}

/// Returns `true` if a form error (mm) is larger than that of noise or of a simulation without drives.
pub fn is_seen(error: f64, runs: &[Run]) -> bool {
    floor(runs, (UNSEEN_DEVIATIONS, UNSEEN_MM)) < error
}

/// The contour deviations of the runs that have positions, for the commanded motion of one machine.
pub struct Forms {
    /// With the simulated times unchanged.
    on_time: Vec<ContourDeviation>,
    /// In step with the recordings.
    in_step: Vec<ContourDeviation>,
}

impl Forms {
    /// Returns the contour deviations of runs on a machine.
    pub fn of(machine: &Machine, runs: &[Run]) -> Forms {
        let of_run = |run: &Run| {
            let plan = run.plan(machine);
            let simulated = compare(run.toolpath, &plan, run.alignment);
            let samples = ContourDeviation::samples(run.toolpath, &plan);
            let deviation = |residuals: Option<&[f64]>| {
                ContourDeviation::new(&samples, run.alignment, &simulated.simulated, residuals)
            };
            deviation(None).zip(deviation(Some(&simulated.residuals)))
        };
        let with_positions = runs.iter().filter(|run| run.alignment.track.is_some());
        let (on_time, in_step) = with_positions.filter_map(of_run).unzip();
        Forms { on_time, in_step }
    }

    /// Returns the RMS form error on a machine whose motion is commanded alike, mm; `None` without recorded positions.
    pub fn error(&self, machine: &Machine) -> Option<f64> {
        let of = |forms: &[ContourDeviation]| FormMeasure::RootMeanSquare.of(forms, machine);
        (!self.on_time.is_empty()).then(|| of(&self.on_time).min(of(&self.in_step)))
    }

    /// Returns the typical form error in step with the recordings on a machine whose motion is commanded alike, mm; `None`
    /// without recorded positions.
    pub fn typical_error(&self, machine: &Machine) -> Option<f64> {
        (!self.in_step.is_empty()).then(|| FormMeasure::Typical.of(&self.in_step, machine))
    }

    /// Returns the causes of form on a machine whose motion is commanded alike, at most one of each id: if `whole`, causes
    /// that explain the form error whole, with the simulated times unchanged; otherwise causes that remove much of it, in
    /// step with the recording. The result is empty if there are none. Of a long run the search sees excerpts alone, but the
    /// result has the form errors of the whole run.
    pub fn explained(
        &self,
        machine: &Machine,
        looked: &Looked,
        library: &[Hypothesis],
        whole: bool,
    ) -> Explained {
        if self.on_time.is_empty() || Standing::of(machine) == Standing::Misses {
            return Explained::default();
        }
        let of_parts = looked.in_parts.then(|| Forms::of(machine, looked.runs));
        let searched = |measure: FormMeasure, floor: f64| match &of_parts {
            Some(parts) => searched(measure, machine, parts.compared(whole), library, floor).on(
                measure,
                self.compared(whole),
                machine,
            ),
            None => searched(measure, machine, self.compared(whole), library, floor),
        };
        if whole {
            let floor = floor(looked.whole, (WHOLE_DEVIATIONS, WHOLE_MM));
            let found = searched(FormMeasure::RootMeanSquare, floor);
            let is_whole = found.after <= floor && found.after <= 0.5 * found.before;
            return if is_whole { found } else { Explained::default() };
        }
        let floor = floor(looked.whole, (SEARCHED_DEVIATIONS, SEARCHED_MM));
        let found = searched(FormMeasure::RootMeanSquare, floor);
        if found.causes.is_empty() && machine.typical_form_error.is_some() {
            return searched(FormMeasure::Typical, floor);
        }
        found
    }

    /// Returns the contour deviations with the simulated times unchanged if `on_time`, otherwise in step with the recordings.
    fn compared(&self, on_time: bool) -> &[ContourDeviation] {
        if on_time { &self.on_time } else { &self.in_step }
    }
}

/// Returns the causes that remove much of the form error. The search stops once the error is below `floor` (mm) or at
/// most [`MAX_UNEXPLAINED_RATIO`] times the error of the calibration. If this holds from the start, the result is empty.
fn searched(
    measure: FormMeasure,
    machine: &Machine,
    forms: &[ContourDeviation],
    library: &[Hypothesis],
    floor: f64,
) -> Explained {
    let before = measure.of(forms, machine);
    let floor = floor.max(measure.calibrated(machine).map_or(0.0, |left| MAX_UNEXPLAINED_RATIO * left));
    let mut current = machine.clone();
    let mut found = Explained { causes: Vec::new(), before, after: before };
    for _ in 0..MAX_FORM_CAUSES {
        if found.after < floor {
            break;
        }
        let open = library.iter().filter(|hypothesis| {
            let is_named = |named: &Candidate| named.hypothesis.is_same_as(hypothesis);
            hypothesis.trace() == Trace::Form && !found.causes.iter().any(is_named)
        });
        let error = |machine: &Machine| measure.of(forms, machine);
        let mut tried = screened(error, &current, &open.collect::<Vec<_>>());
        sort_by_number(&mut tried, |one| one.cost);
        tried.truncate(REFINED);
        let refined = |at: usize| refined(error, forms, &current, tried[at].clone());
        let refined = side_by_side(tried.len(), refined, &mut |_| {}).into_iter();
        let Some(candidate) = refined.min_by(|a, b| a.cost.total_cmp(&b.cost)) else { break };
        let with = candidate.hypothesis.machine(&current, &candidate.values);
        let is_worth = candidate.cost <= (1.0 - WORTH) * found.after
            && MIN_REMOVED_MM.powi(2) <= found.after.powi(2) - candidate.cost.powi(2);
        let is_all_along = || measure.ratio_all_along(forms, &current, &with) < 1.0 - WORTH;
        if !is_worth || !is_all_along() {
            break;
        }
        found.after = candidate.cost;
        current = with;
        found.causes.push(candidate);
    }
    found
}

/// Returns each hypothesis at the best of its trials, with the form error (mm) as its cost; none without trials.
fn screened(
    error: impl Fn(&Machine) -> f64 + Sync,
    machine: &Machine,
    hypotheses: &[&Hypothesis],
) -> Vec<Candidate> {
    let each = hypotheses.iter().flat_map(|own| own.trials.iter().map(move |values| (*own, values)));
    let trials: Vec<(&Hypothesis, &Vec<f64>)> = each.collect();
    let cost = |at: usize| error(&trials[at].0.machine(machine, trials[at].1));
    let costs = side_by_side(trials.len(), cost, &mut |_| {});
    let mut tried = trials.iter().zip(costs).map(|((hypothesis, values), cost)| Candidate {
        hypothesis: (*hypothesis).clone(),
        values: values.to_vec(),
        deviations: vec![f64::NAN; values.len()],
        cost,
        beside: Vec::new(),
    });
    let best =
        |own: &&Hypothesis| tried.by_ref().take(own.trials.len()).min_by(|a, b| a.cost.total_cmp(&b.cost));
    hypotheses.iter().filter_map(best).collect()
}

/// Returns a candidate at its best values, with the form error (mm) as its cost.
fn refined(
    error: impl Fn(&Machine) -> f64,
    forms: &[ContourDeviation],
    machine: &Machine,
    candidate: Candidate,
) -> Candidate {
    let Candidate { hypothesis, mut values, cost: mut least, .. } = candidate;
    let error = |values: &[f64]| error(&hypothesis.machine(machine, values));
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
    for _ in 0..SEARCH_ROUNDS {
        for (place, freed) in hypothesis.freed.iter().enumerate() {
            let centre = freed.to_internal(values[place]);
            golden_section((centre - widths[place], centre + widths[place]), STEPS_PER_ROUND, |varied| {
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
        forms.iter().flat_map(|form| form.parts(&machine, RECORDING_PARTS)).collect()
    };
    let here = parts(&values);
    let deviations = hypothesis.freed.iter().enumerate().map(|(place, freed)| {
        let beside = |sign: f64| {
            let mut there = values.clone();
            there[place] = freed.from_internal(freed.to_internal(values[place]) + sign * QUOTIENT_STEP);
            parts(&there)
        };
        let (below, above) = (beside(-1.0), beside(1.0));
        let count = here.len() as f64;
        let slopes: Vec<f64> =
            below.iter().zip(&above).map(|(below, above)| (above - below) / (2.0 * QUOTIENT_STEP)).collect();
        let mean = slopes.iter().sum::<f64>() / count;
        let scatter =
            slopes.iter().map(|slope| (slope - mean).powi(2)).sum::<f64>() * count / (count - 1.0).max(1.0);
        let bend = |at: usize| (below[at] + above[at] - 2.0 * here[at]) / (QUOTIENT_STEP * QUOTIENT_STEP);
        let curvature = (0..here.len()).map(bend).sum::<f64>();
        let varied = if 0.0 < curvature { scatter.sqrt() / curvature } else { 1.0 };
        freed.deviation(values[place], varied.min(1.0)).hypot(freed.floor(values[place]))
    });
    let deviations = deviations.collect();
    Candidate { hypothesis: hypothesis.clone(), values, deviations, cost: least, beside: Vec::new() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identification::alignment::{RECORDED_ROW_S, recorded_positions};
    use crate::identification::calibration::{DIAGNOSIS_WINDOWS_S, Excerpt, excerpts};
    use crate::identification::effects::{SERVO_LAG, library};
    use crate::identification::fit::AlignedRun;
    use crate::simulation::toolpath::Point;

    /// Lag of the recorded X axis behind its command, s.
    const LAG_S: f64 = 0.03;

    /// Calls `test` with a run that is long enough to be searched in excerpts; X lags until a part of its time.
    fn on_long_run(lags_until: f64, test: impl FnOnce(&Machine, &Looked)) {
        let machine = Machine::default();
        let program = format!("G1 F3000\n{}", "X40\nY30\nX0\nY0\n".repeat(100));
        let mut x = 0.0;
        let (toolpath, csv) = recorded_positions(&program, &machine, |part, at| {
            x = if part < lags_until { at.x + (x - at.x) * (-RECORDED_ROW_S / LAG_S).exp() } else { at.x };
            Point::new(x, at.y, at.z)
        });
        let aligned = AlignedRun::new(toolpath, csv.as_bytes(), &machine).expect("it is of this program");
        let whole = [aligned.run()];
        let excerpts = excerpts(&whole, DIAGNOSIS_WINDOWS_S).expect("the run is long");
        let parts: Vec<Run> = excerpts.iter().flatten().map(Excerpt::run).collect();
        test(&machine, &Looked { runs: &parts, whole: &whole, in_parts: true });
    }

    #[test]
    fn a_lag_is_found_in_excerpts_of_a_long_run() {
        on_long_run(1.0, |machine, looked| {
            let all = library(machine, looked.whole);
            let found = Forms::of(machine, looked.whole).explained(machine, looked, &all, false);
            let [cause] = &found.causes[..] else { panic!("{:?}", found.causes) };
            assert_eq!(cause.hypothesis.effect, SERVO_LAG);
            assert!((cause.values[0] / LAG_S - 1.0).abs() < 0.2, "{} s", cause.values[0]);
            assert!(found.after < 0.5 * found.before, "{} → {} mm", found.before, found.after);
        });
    }

    #[test]
    fn a_cause_of_excerpts_has_the_form_errors_of_the_whole_run() {
        on_long_run(0.1, |machine, looked| {
            let all = library(machine, looked.whole);
            let lag = all.into_iter().find(|own| own.effect == SERVO_LAG && own.variant.contains('X'));
            let cause = Candidate::read_off(lag.expect("X may lag"), LAG_S, f64::NAN);
            let of_parts = Explained { causes: vec![cause], before: 1.0, after: 0.1 };
            let forms = Forms::of(machine, looked.whole);
            let found = of_parts.on(FormMeasure::RootMeanSquare, &forms.in_step, machine);
            assert!(found.causes.is_empty(), "{} → {} mm", found.before, found.after);
        });
    }
}
