//! Runs → the model of the control that is nearest to them, fitted.
//!
//! Filters first, of each order, with the laws that the runs show; then planners, and steps of velocity at
//! corners. Another model is taken where it is nearer by the margin of its kind (see the front file).

use crate::identification::calibration::motion::{motion, spindle_ramp};
use crate::identification::calibration::rapids::RapidPlateaus;
use crate::identification::calibration::{
    BETTER_FAMILY, BETTER_ORDER, BETTER_STEPS, ORDERS, ROUGHLY, Share, assumed, at_own_noise, families,
    polled, run_fit, set_order, steps, waits, whitened, with_laws,
};
use crate::identification::comparison::Comparison;
use crate::identification::fit::{FTOL, Fit, FreeParameter, Run, Whitening, cost_of};
use crate::machine::{Handle, Machine, TimeConstants};

/// What every fit of a calibration begins with.
pub struct Fitting<'a> {
    /// The machine as it was.
    machine: &'a Machine,
    pub runs: &'a [Run<'a>],
    /// The waits that are fitted, each with its value before.
    waits: Vec<(FreeParameter, f64)>,
    pub plateaus: Option<RapidPlateaus>,
    pub share: Share<'a>,
}

/// A model of the control, fitted.
pub struct Model {
    pub best: Fit,
    /// Those that it was fitted at.
    pub whitenings: Vec<Whitening>,
    /// Its order of filters; 1 for planners.
    pub order: usize,
}

impl<'a> Fitting<'a> {
    /// The fitting of a machine to runs, and the machine with the waits that the runs show at first sight;
    /// `before` are the runs against the machine as it is.
    pub fn new(
        machine: &'a Machine,
        runs: &'a [Run<'a>],
        before: &[Comparison],
        progress: &'a mut dyn FnMut(f64),
    ) -> (Fitting<'a>, Machine) {
        let mut guess = machine.clone();
        let pairs: Vec<_> = runs.iter().map(|run| run.toolpath).zip(before).collect();
        let mut waits = Vec::new();
        for (kind, seconds, _) in waits::guesses(machine, &pairs) {
            let freed = kind.freed(seconds);
            freed.apply(&mut guess, seconds);
            waits.push((freed, kind.value(machine)));
        }
        if runs.iter().any(|run| run.starts()) {
            let seconds = (machine.times.start + waits::start_guess(&pairs)).max(0.0);
            let freed = FreeParameter::wait(Handle::number("times.start_s"), seconds, (0.0, 600.0));
            freed.apply(&mut guess, seconds);
            waits.push((freed, machine.times.start));
        }
        let share = Share { done: 0.0, part: 0.2, progress };
        (Fitting { machine, runs, waits, plateaus: RapidPlateaus::of(runs), share }, guess)
    }

    /// The model that is nearest to the runs, and the cost of each order of filters that was tried.
    pub fn model(&mut self, guess: &Machine) -> (Model, Vec<(usize, f64)>) {
        let shows_ramps = self.machine.has_filters() && self.runs.iter().any(|run| polled(run).is_none());
        let (mut model, orders) = self.filters(guess, shows_ramps);
        // A planner has no use for the laws of filters.
        let plain = model.best.machine.clone();
        self.take_laws(&mut model);
        if shows_ramps {
            self.try_planners(&plain, &mut model);
        }
        self.try_assumed_accelerations(&mut model);
        self.try_steps_at_corners(&mut model);
        (model, orders)
    }

    /// What is fitted from a machine on, each with its value before.
    pub fn parameters(&self, order: usize, start: &Machine) -> Vec<(FreeParameter, f64)> {
        let mut all = motion(self.machine, start, order, self.runs, self.plateaus);
        all.extend(spindle_ramp(self.machine, start));
        all.extend(self.waits.iter().map(|(freed, value)| {
            (freed.starting_at(freed.handle.get(start).unwrap_or(freed.start)), *value)
        }));
        all
    }

    fn fit(&mut self, start: &Machine, order: usize, whitenings: &[Whitening], hardly: f64) -> Fit {
        let parameters = self.parameters(order, start);
        run_fit(start, self.runs, &parameters, whitenings, hardly, &mut self.share)
    }

    /// As [`at_own_noise`].
    fn fit_at_own_noise(&mut self, start: &Machine, order: usize, hardly: f64) -> (Fit, Vec<Whitening>) {
        at_own_noise(start, self.runs, |machine, whitenings| self.fit(machine, order, whitenings, hardly))
    }

    /// Filters of the nominal order, or of another one that is nearer by far.
    fn filters(&mut self, guess: &Machine, shows_ramps: bool) -> (Model, Vec<(usize, f64)>) {
        let nominal = self.machine.interpolator.filters;
        let first = self.fit(guess, nominal, &whitened(guess, self.runs), ROUGHLY);
        let whitenings = whitened(&first.machine, self.runs);
        let best = self.fit(&first.machine, nominal, &whitenings, ROUGHLY);
        let mut orders = vec![(nominal, best.cost)];
        let mut model = Model { best, whitenings, order: nominal };
        let is_equal = matches!(self.machine.interpolator.time_constants, TimeConstants::Equal(_));
        for order in ORDERS.filter(|order| *order != nominal && is_equal && shows_ramps) {
            self.share.part = 0.06;
            let mut start = model.best.machine.clone();
            set_order(&mut start, order);
            let found = self.fit(&start, order, &model.whitenings, ROUGHLY);
            orders.push((order, found.cost));
            if found.cost < model.best.cost - BETTER_ORDER.0.max(BETTER_ORDER.1 * model.best.cost) {
                (model.best, model.order) = (found, order);
            }
        }
        orders.sort_by_key(|(order, _)| *order);
        (model, orders)
    }

    /// Takes in every law of filters that the runs show.
    fn take_laws(&mut self, model: &mut Model) {
        self.share.part = 0.05;
        let (machine, runs, order) = (self.machine, self.runs, model.order);
        let whitenings = std::mem::take(&mut model.whitenings);
        model.whitenings = with_laws(machine, runs, &mut model.best, whitenings, |machine, whitenings| {
            self.fit(machine, order, whitenings, ROUGHLY)
        });
    }

    /// Takes a planner where it is nearer by far; `plain` are the filters without laws.
    fn try_planners(&mut self, plain: &Machine, model: &mut Model) {
        for start in families::guesses(self.machine, plain, self.runs, &model.whitenings, self.plateaus) {
            let (mut best, mut whitenings) = self.fit_at_own_noise(&start, 1, FTOL);
            // What has no derivative is chosen again where the fit has come to.
            if let Some(other) = families::chosen_again(&best.machine, self.runs, &whitenings) {
                (best, whitenings) = self.fit_at_own_noise(&other, 1, FTOL);
            }
            // At the noise of the one that leaves less, or nothing would tell two apart that leave little.
            let margin = 1.0 - BETTER_FAMILY;
            if best.cost < margin * cost_of(&model.best.machine, self.runs, &whitenings) {
                *model = Model { best, whitenings, order: 1 };
            }
        }
    }

    /// Begins once more with the accelerations of other axes where those of an axis are unknown.
    fn try_assumed_accelerations(&mut self, model: &mut Model) {
        self.share.part = 0.02;
        let order = model.order;
        for start in assumed::starts(&self.parameters(order, &model.best.machine), &model.best) {
            let (best, whitenings) = self.fit_at_own_noise(&start, order, FTOL);
            if best.cost < (1.0 - FTOL) * cost_of(&model.best.machine, self.runs, &whitenings) {
                *model = Model { best, whitenings, order };
            }
        }
    }

    /// Takes a planner with steps of velocity at corners where it is nearer.
    fn try_steps_at_corners(&mut self, model: &mut Model) {
        self.share.part = 0.03;
        let order = model.order;
        let starts = steps::guesses(self.machine, &model.best.machine, self.runs, &model.whitenings);
        let found = starts.iter().map(|start| self.fit(start, order, &model.whitenings, ROUGHLY));
        let found = found.min_by(|a, b| a.cost.total_cmp(&b.cost));
        if let Some(found) = found.filter(|found| found.cost < (1.0 - BETTER_STEPS) * model.best.cost) {
            let (best, whitenings) = self.fit_at_own_noise(&found.machine, order, ROUGHLY);
            *model = Model { best, whitenings, order };
        }
    }
}
