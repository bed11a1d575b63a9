//! The evidence of the runs for or against a machine, as one number: the cost of the whitened residuals.

use crate::identification::diagnosis::standing::is_elsewhere;
use crate::identification::effects::parameters::{
    AXIS_ACCELERATION, AXIS_JERK, AXIS_RAPID, Adjustable, RAPID_FEEDRATE,
};
use crate::identification::effects::{Between, Hypothesis};
use crate::identification::fit::{
    FTOL, Fit, FreeParameter, Run, Whitening, cost_of, dispersion, fit, golden_section, whitened,
    whitenings_in_common,
};
use crate::machine::Machine;

/// Number of golden-section steps around the best of the points between two trials.
const SECTIONS: usize = 5;
/// Number of points between two trials at which the cost is computed before the golden sections.
const POINTS_BETWEEN_TRIALS: usize = 9;
/// Ratio of the cost with a limit to the cost without it above which tighter limits are not tried.
const TOO_TIGHT: f64 = 3.0;

/// Runs with the noise assumed of their residuals.
#[derive(Clone)]
pub struct Evidence<'a> {
    /// Runs.
    pub runs: &'a [Run<'a>],
    /// Whitening of the residuals of each run.
    pub whitenings: Vec<Whitening>,
    /// Parameters that no run of the calibration determined: they are fitted with every cause and are no causes
    /// themselves.
    assumed: Vec<FreeParameter>,
}

/// Runs in which causes are searched.
pub struct Looked<'a> {
    /// Whole runs, or excerpts of them.
    pub runs: &'a [Run<'a>],
    /// Whole runs.
    pub whole: &'a [Run<'a>],
    /// `true` if `runs` are excerpts.
    pub in_parts: bool,
}

impl<'a> Looked<'a> {
    /// Returns the evidence of the runs with the noise under which the residuals of a machine are normal.
    pub fn evidence(&self, machine: &Machine) -> Evidence<'a> {
        match self.in_parts {
            true => Evidence::in_common(self.runs, machine),
            false => Evidence::of(self.runs, machine),
        }
    }
}

/// A hypothesis with the values at which it fits best.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// Hypothesis.
    pub hypothesis: Hypothesis,
    /// Values of its free parameters, core units.
    pub values: Vec<f64>,
    /// Standard deviations of the values, core units; NaN if unknown.
    pub deviations: Vec<f64>,
    /// Cost with the hypothesis at these values.
    pub cost: f64,
    /// Parameters that the calibration had assumed, with the values fitted together with the hypothesis, core units.
    pub beside: Vec<(FreeParameter, f64)>,
}

impl Candidate {
    /// Returns a candidate whose only value was read off the recordings, with its standard deviation (NaN if unknown),
    /// and no cost yet.
    pub fn read_off(hypothesis: Hypothesis, value: f64, deviation: f64) -> Candidate {
        let (values, deviations) = (vec![value], vec![deviation]);
        Candidate { hypothesis, values, deviations, cost: f64::NAN, beside: Vec::new() }
    }

    /// Sets the assumed parameters of a machine to the values that were fitted together with the hypothesis.
    pub fn apply_beside(&self, machine: &mut Machine) {
        self.beside.iter().for_each(|(freed, value)| freed.apply(machine, *value));
    }
}

impl<'a> Evidence<'a> {
    /// Returns the evidence of runs with the noise under which the residuals of a machine are normal, for each run
    /// separately.
    pub fn of(runs: &'a [Run<'a>], machine: &Machine) -> Evidence<'a> {
        let whiten = |run: &Run| Whitening::of(run.alignment, &run.residuals(machine));
        Evidence { runs, whitenings: runs.iter().map(whiten).collect(), assumed: assumed(machine) }
    }

    /// Returns the evidence of runs that are parts of one: all have the same noise, that of their residuals together.
    pub fn in_common(runs: &'a [Run<'a>], machine: &Machine) -> Evidence<'a> {
        Evidence { runs, whitenings: whitenings_in_common(machine, runs), assumed: assumed(machine) }
    }

    /// Returns the whitened residuals of a machine, run by run.
    pub fn whitened(&self, machine: &Machine) -> Vec<Vec<f64>> {
        whitened(machine, self.runs, &self.whitenings)
    }

    /// Returns the cost of a machine.
    pub fn cost(&self, machine: &Machine) -> f64 {
        cost_of(machine, self.runs, &self.whitenings)
    }

    /// Returns the increase of the cost without each of the candidates, from the cost of a machine with all of them.
    pub fn gains(&self, base: &Machine, all: &[Candidate]) -> Vec<f64> {
        let cost = self.cost(&with_all(base, all));
        let gain = |at: usize| {
            let mut others = all.to_vec();
            others.remove(at);
            self.cost(&with_all(base, &others)) - cost
        };
        (0..all.len()).map(gain).collect()
    }

    /// Returns the dispersion of the residuals that a machine leaves: the ratio of their variance to that of
    /// independent residuals, by which differences of cost count less.
    pub fn dispersion(&self, machine: &Machine) -> f64 {
        dispersion(&self.whitened(machine))
    }

    /// Returns a hypothesis at the best of its trials, or at the best value between them that has a meaning; `None`
    /// without trials.
    pub fn screened(&self, machine: &Machine, hypothesis: &Hypothesis) -> Option<Candidate> {
        let neutral = self.cost(machine);
        // One that is looser than the machine's own may cost as much, and says nothing of tighter ones.
        let own = hypothesis.freed[0].handle.get(machine).unwrap_or(f64::INFINITY);
        let is_too_tight =
            |limit: f64, cost: f64| hypothesis.is_limit() && limit < own && TOO_TIGHT * neutral < cost;
        let mut tried: Vec<(Vec<f64>, f64)> =
            hypothesis.trials.iter().map(|values| (values.clone(), f64::INFINITY)).collect();
        // The loosest first: where a limit costs much, tighter ones cost more.
        for (values, cost) in tried.iter_mut().rev() {
            *cost = self.cost(&hypothesis.machine(machine, values));
            if is_too_tight(values[0], *cost) {
                break;
            }
        }
        let best = (0..tried.len()).min_by(|a, b| tried[*a].1.total_cmp(&tried[*b].1))?;
        let (mut values, mut cost) = tried[best].clone();
        let acts = |at: usize| 1e-6 * neutral < (tried[at].1 - neutral).abs();
        if hypothesis.is_continuous() {
            // Between the trials on both sides, by golden sections of the first parameter. Where no trial is
            // better than none at all, what is better may lie between one that does not act and one that does too much.
            let edge = (1..tried.len()).find(|at| acts(at - 1) != acts(*at));
            let (before, after) = match edge {
                Some(edge) if neutral <= cost => (edge - 1, edge),
                _ => (best.saturating_sub(1), (best + 1).min(tried.len() - 1)),
            };
            let freed = &hypothesis.freed[0];
            let side = |at: usize| freed.to_internal(tried[at].0[0]);
            let (low, high) = (side(before), side(after));
            let at = |varied: f64, values: &mut Vec<f64>, cost: &mut f64| {
                let mut there = values.clone();
                there[0] = freed.from_internal(varied);
                let found = self.cost(&hypothesis.machine(machine, &there));
                if found < *cost {
                    (*values, *cost) = (there, found);
                }
                found
            };
            // What acts from a threshold on is flat before it: first a few points between, then sections.
            let between = |part: usize| low + (high - low) * part as f64 / (POINTS_BETWEEN_TRIALS + 1) as f64;
            let mut closest = (1, f64::INFINITY);
            for part in (1..=POINTS_BETWEEN_TRIALS).rev() {
                let found = at(between(part), &mut values, &mut cost);
                if found <= closest.1 {
                    closest = (part, found);
                }
                if is_too_tight(freed.from_internal(between(part)), found) {
                    break;
                }
            }
            let bracket = (between(closest.0 - 1), between(closest.0 + 1));
            golden_section(bracket, SECTIONS, |varied| at(varied, &mut values, &mut cost));
        }
        let mut deviations = vec![f64::NAN; values.len()];
        match hypothesis.between_trials {
            Between::AnyValue => {}
            Between::Nothing => deviations[0] = deviation_between_trials(&hypothesis.trials, best),
            Between::WholeNumbers => {
                let beside = |at: usize| tried.get(at).map_or(values[0], |(values, _)| values[0]);
                let bracket = (beside(best.saturating_sub(1)), beside(best + 1));
                let cost_of = |value: f64| self.cost(&hypothesis.machine(machine, &[value]));
                let (value, its_cost) = least_whole_number((values[0], cost), bracket, cost_of);
                (values, cost) = (vec![value], its_cost);
                deviations[0] = uniform_deviation(1.0);
            }
        }
        Some(Candidate { hypothesis: hypothesis.clone(), values, deviations, cost, beside: Vec::new() })
    }

    /// Returns a candidate fitted by least squares together with others that are already named, and those others with
    /// their new values. A whole number is compared with its neighbours, because screening found it with parameters that the
    /// calibration had assumed.
    pub fn refined(
        &self,
        machine: &Machine,
        candidate: &Candidate,
        with: &[Candidate],
    ) -> (Candidate, Vec<Candidate>) {
        let mut best = self.fitted(machine, candidate, with);
        if candidate.hypothesis.between_trials != Between::WholeNumbers || self.assumed.is_empty() {
            return best;
        }
        let (least, most) = candidate.hypothesis.freed[0].bounds;
        loop {
            let own = best.0.values[0];
            let neighbours =
                [own - 1.0, own + 1.0].into_iter().filter(|value| (least..=most).contains(value));
            let fitted =
                |value: f64| self.fitted(machine, &Candidate { values: vec![value], ..best.0.clone() }, with);
            let nearest = neighbours.map(fitted).min_by(|one, other| one.0.cost.total_cmp(&other.0.cost));
            match nearest {
                Some(nearest) if nearest.0.cost < best.0.cost => best = nearest,
                _ => return best,
            }
        }
    }

    /// Returns a candidate fitted together with others, and those others; a whole number stays.
    fn fitted(
        &self,
        machine: &Machine,
        candidate: &Candidate,
        with: &[Candidate],
    ) -> (Candidate, Vec<Candidate>) {
        let all: Vec<Candidate> = [candidate].into_iter().chain(with).cloned().collect();
        let (base, freed) = self.freed(machine, &all);
        let Fit { values, deviations, cost, .. } =
            fit(&base, self.runs, &freed, &self.whitenings, FTOL, &mut |_| {});
        let own =
            all.iter().filter(|each| each.hypothesis.is_continuous()).map(|each| each.values.len()).sum();
        let beside: Vec<(FreeParameter, f64)> =
            freed.iter().zip(&values).skip(own).map(|(freed, value)| (freed.clone(), *value)).collect();
        let mut taken = 0;
        let mut take = |each: &Candidate| {
            let mut each = each.clone();
            if each.hypothesis.is_continuous() {
                let range = taken..taken + each.values.len();
                each.values = values[range.clone()].to_vec();
                each.deviations = deviations[range.clone()].to_vec();
                taken = range.end;
            }
            each.cost = cost;
            each.beside.clone_from(&beside);
            each
        };
        let own = take(candidate);
        (own, with.iter().map(take).collect())
    }

    /// Returns the machine with the candidates that have no values between their trials, and the free parameters of a
    /// fit: those of the other candidates, in their order, then those that the calibration had assumed and that no
    /// candidate frees.
    pub fn freed(&self, machine: &Machine, all: &[Candidate]) -> (Machine, Vec<FreeParameter>) {
        let is_fitted = |each: &&Candidate| each.hypothesis.is_continuous();
        let taken: Vec<Candidate> = all.iter().filter(|each| !is_fitted(each)).cloned().collect();
        let own = |each: &Candidate| {
            let own = each.hypothesis.freed.iter().zip(&each.values);
            own.map(|(freed, value)| freed.starting_at(*value)).collect::<Vec<FreeParameter>>()
        };
        let mut freed: Vec<FreeParameter> = all.iter().filter(is_fitted).flat_map(own).collect();
        let now = with_all(machine, all);
        let is_taken = |beside: &FreeParameter| {
            let mut of = all.iter().flat_map(|each| &each.hypothesis.freed);
            of.any(|own| own.handle == beside.handle)
        };
        let beside = self.assumed.iter().filter(|beside| !is_taken(beside));
        freed.extend(beside.map(|own| own.starting_at(own.handle.get(&now).unwrap_or(own.start))));
        (with_all(machine, &taken), freed)
    }
}

/// Returns the parameters of a machine that no run of its calibration determined: accelerations, jerks on ramps and rapid rates,
/// the last of the axes or along the path.
pub fn assumed(machine: &Machine) -> Vec<FreeParameter> {
    let of = |(parameter, least): (Adjustable, f64)| {
        let own = parameter.handle().get(machine).filter(|own| own.is_finite())?;
        Some(parameter.assumed(own, least))
    };
    let on = &machine.calibrated_on;
    let least = on.least_accelerations.unwrap_or_default();
    let among = |parameters: [Adjustable; 3], assumed: [bool; 3], least: [f64; 3]| {
        let pairs = parameters.into_iter().zip(least).zip(assumed);
        pairs.filter_map(|(pair, is_assumed)| is_assumed.then_some(pair))
    };
    let accelerations = among(AXIS_ACCELERATION, on.assumed_accelerations, least);
    let least_jerks = on.least_jerks.unwrap_or_default();
    let jerks = among(AXIS_JERK, least_jerks.map(|least| 0.0 < least), least_jerks);
    // In the program of the calibration, rapids that were not at their full rate then are not now either: one that is slower is
    // slower for a cause.
    let assumed_rapids = on.assumed_rapids.map(|is_assumed| is_assumed && is_elsewhere(machine));
    let along_path = (assumed_rapids == [true; 3]).then_some((RAPID_FEEDRATE, 0.0));
    let rapids = among(AXIS_RAPID, assumed_rapids, [0.0; 3]);
    accelerations.chain(jerks).chain(rapids).chain(along_path).filter_map(of).collect()
}

/// Returns the standard deviation of a first parameter that is known to be nearer to the trial `at` than to those
/// beside it; NaN for a single trial.
fn deviation_between_trials(trials: &[Vec<f64>], at: usize) -> f64 {
    let value = trials[at][0];
    let apart = |other: Option<&Vec<f64>>| other.map(|other| 0.5 * (other[0] - value).abs());
    let before = apart(at.checked_sub(1).and_then(|before| trials.get(before)));
    let (below, above) = (before, apart(trials.get(at + 1)));
    match (below.or(above), above.or(below)) {
        (Some(below), Some(above)) => uniform_deviation(below + above),
        _ => f64::NAN,
    }
}

/// Returns the standard deviation of a number that is anywhere within an interval of this width with the same probability.
fn uniform_deviation(width: f64) -> f64 {
    width / 12f64.sqrt()
}

/// Returns the whole number within a bracket at which a function is least, and the function there. The search begins at a
/// number at which the function is known and less than at both ends, and goes by steps that halve where neither side is less.
fn least_whole_number(
    (mut value, mut least): (f64, f64),
    (low, high): (f64, f64),
    mut function: impl FnMut(f64) -> f64,
) -> (f64, f64) {
    let mut step = (0.5 * (high - value).max(value - low)).ceil();
    while 1.0 <= step {
        let beside = [value - step, value + step].into_iter().filter(|other| low < *other && *other < high);
        let each: Vec<(f64, f64)> = beside.map(|other| (other, function(other))).collect();
        match each.into_iter().filter(|(_, found)| *found < least).min_by(|a, b| a.1.total_cmp(&b.1)) {
            Some(better) => (value, least) = better,
            None if step == 1.0 => break,
            None => step = (0.5 * step).ceil(),
        }
    }
    (value, least)
}

/// Returns a machine with all of these candidates.
pub fn with_all(machine: &Machine, candidates: &[Candidate]) -> Machine {
    let mut machine = machine.clone();
    for candidate in candidates {
        machine = candidate.hypothesis.machine(&machine, &candidate.values);
        candidate.apply_beside(&mut machine);
    }
    machine
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identification::alignment::recorded;
    use crate::identification::effects::{LOOK_AHEAD, library};
    use crate::machine::{ArcChords, Junction, Planner};

    /// Half circles between rows along X: with all blocks ahead, Y never ramps, so its jerk is assumed, and too high.
    #[test]
    fn a_whole_number_is_compared_with_its_neighbours_where_a_parameter_is_assumed() {
        let mut truth = Machine::default();
        truth.become_planner(Planner::JunctionDeviation, 1e4);
        (truth.interpolator.step_segment, truth.interpolator.look_ahead) = (0.0, 3.0);
        truth.interpolator.junction = Junction::Deviation(0.04);
        truth.interpolator.arc_chords = ArcChords::Within(0.01);
        truth.axes.iter_mut().for_each(|axis| axis.jerk = 41e3);
        truth.axes[1].jerk = 24e3;
        let mut believed = truth.clone();
        believed.interpolator.look_ahead = 15.0;
        believed.axes[1].jerk = 41e3;
        believed.calibrated_on.least_jerks = Some([0.0, 9e3, 0.0]);
        let row = |at: u32| {
            format!(
                "G1 X60\nG3 Y{} J3.2\nG1 X0\nG2 Y{} J3.2\n",
                12.8 * f64::from(at) + 6.4,
                12.8 * f64::from(at) + 12.8
            )
        };
        let program = format!("G1 F2100\n{}", (0..5).map(row).collect::<String>());
        let (toolpath, alignment) = recorded(&program, &truth, 1e-4);
        let runs = [Run { toolpath: &toolpath, alignment: &alignment, overrides: (None, None) }];
        let evidence = Evidence::of(&runs, &believed);
        let hypotheses = library(&believed, &runs);
        let look_ahead = hypotheses.iter().find(|own| own.effect == LOOK_AHEAD).expect("blocks are short");
        let screened = evidence.screened(&believed, look_ahead).expect("there are trials");
        assert_ne!(screened.values, [3.0]);
        let (found, _) = evidence.refined(&believed, &screened, &[]);
        assert_eq!(found.values, [3.0]);
    }

    #[test]
    fn a_counted_number_is_found_between_its_trials() {
        for truth in [31.0, 37.0, 49.0] {
            let cost = |value: f64| (value - truth).abs();
            let start = if truth < 40.0 { 30.0 } else { 50.0 };
            assert_eq!(least_whole_number((start, cost(start)), (20.0, 80.0), cost), (truth, 0.0));
        }
        let nearest = least_whole_number((5.0, 1.0), (4.0, 7.0), |value| (value - 6.0).abs());
        assert_eq!(nearest, (6.0, 0.0));
    }
}
