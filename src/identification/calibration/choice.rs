//! Runs → the model of the control that is nearest to them, fitted.
//!
//! The choice begins with filters, of each order and with the laws that the runs show; planners follow, with each way to
//! blend corners and with rapid rates that no plateau shows, and steps of velocity at corners. Another model is taken if it
//! is nearer by the margin of its kind (see the front file).

use crate::identification::calibration::held_accelerations::HeldAccelerations;
use crate::identification::calibration::motion::{motion, spindle_ramp};
use crate::identification::calibration::rapids::{RapidPlateaus, RapidRates, is_limited_as_rapids};
use crate::identification::calibration::{
    BETTER_STEPS, MAX_NOISE_RATIO, MAX_NOISE_ROUNDS, MIN_CONTRADICTING_COST, MIN_ORDER_COST_DROP,
    MIN_ORDER_COST_DROP_RATIO, ROUGH_COST_TOLERANCE, Share, assumed, compared, laws, nearest, polled,
    run_fit, set_order, steps, waits, wander, whitened, whitened_in_parts,
};
use crate::identification::comparison::Comparison;
use crate::identification::effects::MIN_EXPLAINED_SHARE;
use crate::identification::effects::parameters::{CLOCK_RATIO, DWELL_EXCESS, FILTERS, PROGRAM_START};
use crate::identification::fit::{FTOL, Fit, FreeParameter, Run, Whitening};
use crate::machine::{Machine, TimeConstants};
use crate::side_by_side::side_by_side;
use crate::simulation::ordered::sort_by_number;

/// Initial value of the dwell excess in a fit, s: half the cycle of a 10 ms task.
const INITIAL_DWELL_EXCESS_S: f64 = 0.005;

/// Standard deviation of the clock ratio that a calibration assumes before it sees a run. The clock of a computer that
/// follows no other clock is off by 2e-4, and a step timer that the simulation does not model is off by 5e-4 to 1.2e-3.
const PRIOR_CLOCK_DEVIATION_RATIO: f64 = 5e-4;

/// The common input of all fits of a calibration.
pub struct Fitting<'a> {
    /// The machine before the calibration.
    pub machine: &'a Machine,
    /// Runs of the calibration.
    whole: &'a [Run<'a>],
    /// Excerpts of the runs, if the fits see only these.
    parts: Option<&'a [Run<'a>]>,
    /// The waits to be fitted, each with its value before the calibration.
    waits: Vec<(FreeParameter, f64)>,
    pub plateaus: Option<RapidPlateaus>,
    /// The accelerations that the runs hold.
    pub held: HeldAccelerations,
    pub share: Share<'a>,
}

/// A fitted model of the control.
pub struct Model {
    pub best: Fit,
    /// The whitenings at which it was fitted.
    pub whitenings: Vec<Whitening>,
    /// The order of its filters; 1 for planners.
    pub order: usize,
}

impl<'a> Fitting<'a> {
    /// Returns the fitting of a machine to runs, and the machine with the first guesses of the waits that the runs
    /// show; `before` compares the runs with the machine before the calibration.
    pub fn new(
        machine: &'a Machine,
        runs: &'a [Run<'a>],
        before: &[Comparison],
        progress: &'a mut dyn FnMut(f64),
    ) -> (Fitting<'a>, Machine) {
        let mut guess = machine.clone();
        let mut waits = Vec::new();
        for (kind, seconds) in waits::guesses(machine, runs, before) {
            let freed = kind.freed(seconds);
            freed.apply(&mut guess, seconds);
            waits.push((freed, kind.value(machine)));
        }
        if runs.iter().any(|run| run.starts()) {
            let seconds = (machine.times.start + waits::start_guess(before)).max(0.0);
            let freed = PROGRAM_START.calibrated(seconds);
            freed.apply(&mut guess, seconds);
            waits.push((freed, machine.times.start));
        }
        if runs.iter().flat_map(|run| &run.toolpath.stops).any(|stop| stop.cause.dwell().is_some()) {
            waits.push((DWELL_EXCESS.calibrated(INITIAL_DWELL_EXCESS_S), machine.times.dwell_excess));
        }
        let plateaus = RapidPlateaus::of(runs);
        if let Some(seen) = plateaus {
            guess.rapid.at_feedrate = seen.feedrates.are_programmed(guess.rapid.at_feedrate);
        }
        let held = HeldAccelerations::of(runs);
        let share = Share { done: 0.0, part: 0.2, progress };
        (Fitting { machine, whole: runs, parts: None, waits, plateaus, held, share }, guess)
    }

    /// Returns the model that is nearest to excerpts of the runs, fitted to the whole runs, and the cost of each order of
    /// filters tried. Without excerpts it is the one that is nearest to the whole runs.
    pub fn model_by_parts(&mut self, parts: &'a [Run<'a>], guess: &Machine) -> (Model, Vec<(usize, f64)>) {
        if parts.is_empty() {
            return self.model(guess);
        }
        self.parts = Some(parts);
        let (Model { best, order, .. }, orders) = self.model(guess);
        self.parts = None;
        let (best, whitenings) = self.fit_at_own_noise(&best.machine, order, FTOL);
        (Model { best, whitenings, order }, orders)
    }

    /// Returns the results of pieces of work that fit side by side, each on a copy of this fitting.
    pub fn side_by_side<T: Send>(
        &mut self,
        count: usize,
        work: impl Fn(&mut Fitting, usize) -> T + Sync,
    ) -> Vec<T> {
        let Fitting { machine, whole, parts, ref waits, plateaus, held, ref mut share } = *self;
        let on_copy = |at: usize| {
            let share = Share { done: 0.0, part: 0.0, progress: &mut |_| {} };
            work(&mut Fitting { machine, whole, parts, waits: waits.clone(), plateaus, held, share }, at)
        };
        let (done, all) = (share.done, share.part * count as f64);
        share.done += all;
        side_by_side(count, on_copy, &mut |part| (share.progress)((done + part * all).min(1.0)))
    }

    /// Returns the runs that the fits see.
    pub fn runs(&self) -> &'a [Run<'a>] {
        self.parts.unwrap_or(self.whole)
    }

    /// Returns the whitenings of these runs at the noise that a machine leaves.
    fn whitened(&self, machine: &Machine) -> Vec<Whitening> {
        match self.parts {
            Some(parts) => whitened_in_parts(machine, parts),
            None => whitened(machine, self.whole),
        }
    }

    /// Returns the model that is nearest to the runs, and the cost of each order of filters tried.
    fn model(&mut self, guess: &Machine) -> (Model, Vec<(usize, f64)>) {
        let shows_ramps = self.machine.has_filters() && self.runs().iter().any(|run| polled(run).is_none());
        let (mut model, orders) = self.filters(guess, shows_ramps);
        // A planner has no use for the laws of filters.
        let plain = model.best.machine.clone();
        self.take_laws(&mut model);
        if shows_ramps {
            self.try_planners(&plain, &mut model);
        }
        self.try_other_blends(&mut model);
        self.try_reached_rates(&mut model);
        self.try_assumed_accelerations(&mut model);
        self.try_steps_at_corners(&mut model);
        self.drop_idle_limits(&mut model);
        self.drop_idle_rapid_rates(&mut model);
        (model, orders)
    }

    /// Removes the velocity limits of axes that the machine did not have before and that another law makes unnecessary:
    /// on arcs of one radius the acceleration keeps an axis below one velocity again and again, too. First all of them,
    /// then each alone.
    fn drop_idle_limits(&mut self, model: &mut Model) {
        let order = model.order;
        for some in [&[0, 1, 2][..], &[0], &[1], &[2]] {
            let limits = |machine: &Machine, axis: usize| machine.axes[axis].velocity.is_finite();
            let is_new = |axis: &usize| {
                !limits(self.machine, *axis)
                    && limits(&model.best.machine, *axis)
                    && !is_limited_as_rapids(&model.best.machine, *axis, self.plateaus)
            };
            let new: Vec<usize> = some.iter().copied().filter(is_new).collect();
            if new.is_empty() {
                continue;
            }
            let start = self.without_limits(&model.best.machine, &new);
            let best = self.fit(&start, order, &model.whitenings, FTOL);
            let [with, without] =
                [&model.best.machine, &best.machine].map(|machine| self.unexplained(machine));
            if without - with < MIN_EXPLAINED_SHARE {
                model.best = best;
            }
        }
    }

    /// Takes the rate of Z, then that along the path, from the rapids of a planner with a minimum cruise ratio if the runs do
    /// not contradict that: such a planner also holds the velocity of rapids that are too short for their rate.
    fn drop_idle_rapid_rates(&mut self, model: &mut Model) {
        for drop in [RapidRates::without_z, RapidRates::without_path] {
            let has_cruise_ratio = 0.0 < model.best.machine.interpolator.minimum_cruise_ratio;
            let Some(seen) = self.plateaus.filter(|_| has_cruise_ratio) else { return };
            let without = seen.with_rates(drop);
            if without == seen {
                continue;
            }
            self.plateaus = Some(without);
            let start = without.limited_along_path(&model.best.machine, self.machine);
            let best = self.fit(&start, model.order, &model.whitenings, FTOL);
            let is_contradicted = model.best.cost + MIN_CONTRADICTING_COST < best.cost
                && self.can_distinguish(&best.machine, &model.best.machine);
            if is_contradicted {
                self.plateaus = Some(seen);
            } else {
                model.best = best;
            }
        }
    }

    /// Fits the rapid rate of each axis of a planner that showed no plateau, from the velocity that it reached on, and keeps it
    /// if the runs contradict the assumed one. A plateau shorter than three windows is not seen, and a fit makes up for a
    /// wrong rate with other ramps.
    fn try_reached_rates(&mut self, model: &mut Model) {
        for axis in 0..3 {
            let machine = &model.best.machine;
            let is_open = !machine.has_filters()
                && machine.interpolator.minimum_cruise_ratio == 0.0
                && machine.axes[axis].rapid.is_finite();
            let Some(seen) = self.plateaus.filter(|_| is_open) else { continue };
            let reached = seen.reached[axis].fastest;
            if seen.rates(machine).axes[axis].is_some()
                || reached <= 0.0
                || machine.axes[axis].rapid <= reached
            {
                continue;
            }
            let mut start = machine.clone();
            if is_limited_as_rapids(machine, axis, self.plateaus) {
                start.axes[axis].velocity = reached;
            }
            start.axes[axis].rapid = reached;
            self.plateaus = Some(seen.with_rates(|rates| rates.with_guessed(axis, reached)));
            let best = self.fit(&start, model.order, &model.whitenings, FTOL);
            if best.cost + MIN_CONTRADICTING_COST < model.best.cost {
                model.best = best;
            } else {
                self.plateaus = Some(seen);
            }
        }
    }

    /// Returns the lost time that a machine leaves, added up place by place, as a part of the recorded time.
    fn unexplained(&self, machine: &Machine) -> f64 {
        let compared = compared(machine, self.runs());
        let lost = compared.iter().flat_map(|run| &run.lost).map(|visit| visit.seconds().abs()).sum::<f64>();
        lost / compared.iter().map(|run| run.whole.recorded).sum::<f64>()
    }

    /// Returns the machine without the velocity limits of these axes, with rapids as the runs show them.
    fn without_limits(&self, machine: &Machine, axes: &[usize]) -> Machine {
        let mut without = machine.clone();
        axes.iter().for_each(|axis| without.axes[*axis].velocity = f64::INFINITY);
        // Along the path, no axis has a rapid rate.
        if let Some(seen) = self.plateaus.filter(|_| machine.rapid.feedrate == f64::INFINITY) {
            axes.iter().for_each(|axis| without.axes[*axis].rapid = f64::INFINITY);
            let limited = seen.limited_by_axis(&without, self.machine);
            axes.iter().for_each(|axis| without.axes[*axis].rapid = limited.axes[*axis].rapid);
        }
        without
    }

    /// Returns the parameters of a fit that starts from a machine, each with its value before the calibration.
    pub fn parameters(&self, order: usize, start: &Machine) -> Vec<(FreeParameter, f64)> {
        let mut all = motion(self.machine, start, order, self.runs(), self.plateaus);
        all.extend(spindle_ramp(self.machine, start));
        if self.runs().iter().all(|run| polled(run).is_none()) {
            let [own, from] = [self.machine, start].map(|machine| machine.recorder.clock_ratio);
            let clock = CLOCK_RATIO.calibrated(from).linear().expected(own, PRIOR_CLOCK_DEVIATION_RATIO);
            all.push((clock, own));
        }
        all.extend(self.waits.iter().map(|(freed, value)| {
            (freed.starting_at(freed.handle.get(start).unwrap_or(freed.start)), *value)
        }));
        all
    }

    /// Returns the fit from a machine of the parameters that its family has. If the fit takes a parameter to its neutral
    /// value, such as a minimum cruise ratio of 0, the machine no longer has that law, and the others are fitted without it.
    fn fit(&mut self, start: &Machine, order: usize, whitenings: &[Whitening], hardly: f64) -> Fit {
        let parameters = self.parameters(order, start);
        let found = run_fit(start, self.runs(), &parameters, whitenings, hardly, &mut self.share);
        let remaining = self.parameters(order, &found.machine);
        if remaining.len() == parameters.len() {
            return found;
        }
        run_fit(&found.machine, self.runs(), &remaining, whitenings, hardly, &mut self.share)
    }

    /// Returns a fit from a machine at the noise that it leaves, repeated while that noise falls, and the whitenings of the last
    /// fit. At the noise of a wrong law, hardly anything distinguishes the values of the right one.
    pub fn fit_at_own_noise(&mut self, start: &Machine, order: usize, hardly: f64) -> (Fit, Vec<Whitening>) {
        let mut whitenings = self.whitened(start);
        let mut best = self.fit(start, order, &whitenings, hardly);
        for _ in 1..MAX_NOISE_ROUNDS {
            let less = self.whitened(&best.machine);
            if MAX_NOISE_RATIO * wander(&whitenings) < wander(&less) {
                break;
            }
            whitenings = less;
            best = self.fit(&best.machine, order, &whitenings, hardly);
        }
        (best, whitenings)
    }

    /// Returns the fitted filters of the nominal order, or of another one that is nearer by far, and the cost of
    /// each order tried.
    fn filters(&mut self, guess: &Machine, shows_ramps: bool) -> (Model, Vec<(usize, f64)>) {
        let nominal = self.machine.interpolator.filters;
        let first = self.fit(guess, nominal, &self.whitened(guess), ROUGH_COST_TOLERANCE);
        let whitenings = self.whitened(&first.machine);
        let best = self.fit(&first.machine, nominal, &whitenings, ROUGH_COST_TOLERANCE);
        let mut orders = vec![(nominal, best.cost)];
        let mut model = Model { best, whitenings, order: nominal };
        let is_equal = matches!(self.machine.interpolator.time_constants, TimeConstants::Equal(_));
        let others = FILTERS.guesses.iter().map(|order| *order as usize);
        for order in others.filter(|order| *order != nominal && is_equal && shows_ramps) {
            self.share.part = 0.06;
            let mut start = model.best.machine.clone();
            set_order(&mut start, order);
            let found = self.fit(&start, order, &model.whitenings, ROUGH_COST_TOLERANCE);
            orders.push((order, found.cost));
            let margin = MIN_ORDER_COST_DROP.max(MIN_ORDER_COST_DROP_RATIO * model.best.cost);
            if found.cost < model.best.cost - margin {
                (model.best, model.order) = (found, order);
            }
        }
        sort_by_number(&mut orders, |(order, _)| *order as f64);
        (model, orders)
    }

    /// Adds every law of filters that the runs show to the model.
    fn take_laws(&mut self, model: &mut Model) {
        self.share.part = 0.05;
        let mut is_other = false;
        for choice in laws::CHOICES {
            let laws = choice(self.machine, &model.best.machine, self.whole);
            let firsts = laws.into_iter().filter_map(|law| nearest(law, self.runs(), &model.whitenings));
            let firsts: Vec<Machine> = firsts.collect();
            let found = self.nearest_fit(&firsts, model, ROUGH_COST_TOLERANCE);
            let margin = laws::MIN_LAW_COST_DROP.max(laws::MIN_LAW_COST_DROP_RATIO * model.best.cost);
            if let Some(found) = found.filter(|found| found.cost < model.best.cost - margin) {
                (model.best, is_other) = (found, true);
            }
        }
        if is_other {
            model.whitenings = self.whitened(&model.best.machine);
            model.best = self.fit(&model.best.machine, model.order, &model.whitenings, ROUGH_COST_TOLERANCE);
        }
    }

    /// Returns the fit of least cost among those that start from these machines, at the order and noise of a model; `None`
    /// if there is no start.
    pub fn nearest_fit(&mut self, starts: &[Machine], model: &Model, hardly: f64) -> Option<Fit> {
        let fits = starts.iter().map(|start| self.fit(start, model.order, &model.whitenings, hardly));
        fits.min_by(|a, b| a.cost.total_cmp(&b.cost))
    }

    /// Fits once more from the accelerations of other axes if that of an axis is unknown, and replaces the model if
    /// the new fit is nearer.
    fn try_assumed_accelerations(&mut self, model: &mut Model) {
        self.share.part = 0.02;
        let order = model.order;
        for start in assumed::starts(&self.parameters(order, &model.best.machine), &model.best) {
            let (best, whitenings) = self.fit_at_own_noise(&start, order, FTOL);
            let next = Model { best, whitenings, order };
            let [cost, before] = self.costs_at_noise_of(&next, [&next, model]);
            if cost < (1.0 - FTOL) * before {
                *model = next;
            }
        }
    }

    /// Replaces the model by a planner with steps of velocity at corners if that is nearer.
    fn try_steps_at_corners(&mut self, model: &mut Model) {
        self.share.part = 0.03;
        let order = model.order;
        let starts = steps::guesses(self.machine, &model.best.machine, self.runs(), &model.whitenings);
        let found = self.nearest_fit(&starts, model, ROUGH_COST_TOLERANCE);
        if let Some(found) = found.filter(|found| found.cost < (1.0 - BETTER_STEPS) * model.best.cost) {
            let (best, whitenings) = self.fit_at_own_noise(&found.machine, order, ROUGH_COST_TOLERANCE);
            *model = Model { best, whitenings, order };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identification::alignment::recorded_positions;
    use crate::identification::fit::AlignedRun;
    use crate::machine::Planner;

    /// Rapids of Z that hold their rate for 20 ms, by a planner that assumes a higher one.
    #[test]
    fn a_rate_without_a_plateau_is_fitted_from_the_velocity_that_rapids_reached() {
        let mut truth = Machine::default();
        truth.become_planner(Planner::JunctionDeviation, 1120.0);
        truth.axes.iter_mut().for_each(|axis| axis.rapid = 88.0);
        truth.axes[2].rapid = 79.0;
        let turn =
            "G0 Z4\nG0 X80\nG1 Z-3.18 F900\nG1 X0 F3000\nG0 Z4\nG0 X50 Y9\nG1 Z-3.18 F900\nG1 X0 Y0 F3000\n";
        let (toolpath, csv) = recorded_positions(&turn.repeat(4), &truth, |_, at| at);
        let aligned = AlignedRun::new(toolpath, csv.as_bytes(), &truth).expect("it is of this program");
        let runs = [aligned.run()];
        let mut start = truth.clone();
        start.axes[2].rapid = 88.0;
        let mut progress = |_| {};
        let (mut fitting, _) = Fitting::new(&start, &runs, &compared(&start, &runs), &mut progress);
        assert_eq!(fitting.plateaus.expect("there are positions").rates.axes[2], None);
        let (best, whitenings) = fitting.fit_at_own_noise(&start, 1, FTOL);
        let mut model = Model { best, whitenings, order: 1 };
        assert!(0.01 < (model.best.machine.axes[2].acceleration / 1120.0 - 1.0).abs());
        fitting.try_reached_rates(&mut model);
        let z = &model.best.machine.axes[2];
        assert!((z.rapid - 79.0).abs() < 0.5, "{} mm/s", z.rapid);
        assert!((z.acceleration / 1120.0 - 1.0).abs() < 0.005, "{} mm/s²", z.acceleration);
        // It counts as assumed all the same.
        assert!(fitting.plateaus.expect("there are positions").rates.guessed_axes[2]);
    }
}
