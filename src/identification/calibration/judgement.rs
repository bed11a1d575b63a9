//! A fitted model → the parameters that the runs show; every other parameter goes back to the value that it had.

use crate::identification::calibration::choice::{Fitting, Model};
use crate::identification::calibration::{
    MAX_DOUBTFUL_DEVIATIONS, MAX_POLLED_WAIT_DEVIATION_S, MIN_CONTRADICTING_COST, ParameterVerdict, assumed,
    is_unknown, motion, polled, put_back, rapids, settle_waits,
};
use crate::identification::fit::{Exactness, Fit, FreeParameter};
use crate::simulation::ordered::sort_by_number;

/// The parameters of a model with the verdict on each.
#[derive(Clone)]
pub struct Judgement {
    /// The parameters, each with the value that it goes back to.
    pub all: Vec<(FreeParameter, f64)>,
    /// The values before the calibration.
    pub believed: Vec<f64>,
    pub verdicts: Vec<ParameterVerdict>,
    /// The standard deviations of a fit of all parameters.
    pub deviations: Vec<f64>,
    /// The fit of the parameters with the verdict `Fitted`; the others have gone back.
    pub last: Fit,
}

impl Judgement {
    /// Returns the parameters that are fitted, each with the value that it goes back to.
    pub fn fitted(&self) -> impl Iterator<Item = &(FreeParameter, f64)> {
        let is_fitted =
            |(_, verdict): &(&(FreeParameter, f64), &ParameterVerdict)| **verdict == ParameterVerdict::Fitted;
        self.all.iter().zip(&self.verdicts).filter(is_fitted).map(|(parameter, _)| parameter)
    }
}

impl Fitting<'_> {
    /// Returns the judgement of a model, whose parameters are judged one after another.
    pub fn judgement(&mut self, model: &Model) -> Judgement {
        let best = &model.best;
        let mut all = self.parameters(model.order, &best.machine);
        let believed: Vec<f64> = all.iter().map(|(_, before)| *before).collect();
        assumed::lend(&mut all, best);
        let are_polled = self.runs().iter().all(|run| polled(run).is_some());
        let mut verdicts = first_verdicts(&all, best, are_polled);
        for ((freed, back), verdict) in all.iter_mut().zip(&mut verdicts) {
            let axis = motion::rapid_axis_of(freed);
            let recorded = |axis: usize| rapids::recorded(axis, *back, &best.machine, self.plateaus);
            if let Some(rate) = axis.and_then(recorded) {
                (*back, *verdict) = (rate, ParameterVerdict::Recorded);
            }
        }
        self.share.part = 0.04;
        let last = put_back(best, &all, &verdicts, self.runs(), &model.whitenings, &mut self.share);
        let mut judgement = Judgement { all, believed, verdicts, deviations: best.deviations.clone(), last };
        self.keep_sums_of_waits(model, &mut judgement);
        self.put_back_doubtful(model, &mut judgement);
        if are_polled {
            settle_waits(&mut judgement.last, &judgement.all, &judgement.verdicts, self.runs());
        }
        judgement
    }

    /// Keeps the sums of successive waits. The runs may determine the sum of two waits and neither of them, so a
    /// wait goes back only if that does not contradict the sum.
    fn keep_sums_of_waits(&mut self, model: &Model, judgement: &mut Judgement) {
        let is_contradicted = model.best.cost + MIN_CONTRADICTING_COST < judgement.last.cost;
        if !is_contradicted {
            return;
        }
        let is_unknown = |at: &usize| judgement.verdicts[*at] == ParameterVerdict::Unknown;
        let unknown: Vec<usize> = (0..judgement.all.len()).filter(is_unknown).collect();
        unknown.iter().for_each(|at| judgement.verdicts[*at] = ParameterVerdict::Fitted);
        judgement.last = self.put_back(model, judgement);
        unknown
            .into_iter()
            .rev()
            .for_each(|at| self.put_one_back(model, judgement, at, ParameterVerdict::Unknown));
    }

    /// Puts back the values that the runs do not contradict, the least contradicted first. A value that was put
    /// back remains so while the others are judged. A parameter with an expected value is
    /// not put back, because the fit already weighs that value.
    fn put_back_doubtful(&mut self, model: &Model, judgement: &mut Judgement) {
        let best = &model.best;
        let doubt = |at: usize| (best.values[at] - judgement.all[at].1).abs() / best.deviations[at];
        let mut doubtful: Vec<usize> = (0..judgement.all.len())
            .filter(|at| judgement.verdicts[*at] == ParameterVerdict::Fitted)
            .filter(|at| judgement.all[*at].0.prior.is_none())
            .filter(|at| {
                (best.values[*at] - judgement.all[*at].1).abs()
                    < MAX_DOUBTFUL_DEVIATIONS * best.deviations[*at]
            })
            .collect();
        sort_by_number(&mut doubtful, |one| doubt(*one));
        self.share.part = 0.1 / doubtful.len().max(1) as f64;
        doubtful.into_iter().for_each(|at| self.put_one_back(model, judgement, at, ParameterVerdict::Agrees));
    }

    /// Puts one more parameter back, with this verdict, unless the runs contradict that.
    fn put_one_back(
        &mut self,
        model: &Model,
        judgement: &mut Judgement,
        at: usize,
        verdict: ParameterVerdict,
    ) {
        judgement.verdicts[at] = verdict;
        let without = self.put_back(model, judgement);
        if without.cost < judgement.last.cost + MIN_CONTRADICTING_COST {
            judgement.last = without;
        } else {
            judgement.verdicts[at] = ParameterVerdict::Fitted;
        }
    }

    fn put_back(&mut self, model: &Model, judgement: &Judgement) -> Fit {
        let Judgement { all, verdicts, .. } = judgement;
        put_back(&model.best, all, verdicts, self.runs(), &model.whitenings, &mut self.share)
    }
}

/// Returns the first verdicts: `Unknown` for a parameter that the runs hardly determine and that can go back,
/// otherwise `Fitted`.
fn first_verdicts(all: &[(FreeParameter, f64)], best: &Fit, are_polled: bool) -> Vec<ParameterVerdict> {
    let verdict = |(at, (freed, before)): (usize, &(FreeParameter, f64))| {
        let deviation = best.deviations[at];
        let is_unknown = match are_polled && freed.exactness == Exactness::Wait {
            // Of a log of lines waits are read off, and the fit only says whether anything separates them.
            true => !deviation.is_finite() || MAX_POLLED_WAIT_DEVIATION_S < deviation,
            false => is_unknown(freed, best.values[at], deviation),
        };
        // What was not there before cannot be put back; but a limit that no run comes near is taken away again.
        let is_idle = freed.handle.table() == "path" && !deviation.is_finite();
        if is_unknown && (before.is_finite() || is_idle) {
            ParameterVerdict::Unknown
        } else {
            ParameterVerdict::Fitted
        }
    };
    all.iter().enumerate().map(verdict).collect()
}
