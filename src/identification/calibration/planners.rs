//! Runs → the planner that is nearest to them, if a planner is nearer than filters.
//!
//! Each family of planners is fitted from its guesses ([`families`]). Two models are compared at the noise of the more likely
//! one. Of the families, one is chosen whose ramps have the recorded shape, if there is one.

use crate::identification::calibration::choice::{Fitting, Model};
use crate::identification::calibration::{
    BETTER_FAMILY, MAX_NOISE_ROUNDS, MIN_CONTRADICTING_COST, families, jerk_limits, largest_shift,
};
use crate::identification::fit::{FTOL, Whitening, cost_of, ramp_misfit};
use crate::machine::Machine;
use crate::simulation::feed::LINUXCNC_SERVO_PERIOD_S;

/// Least shift of any moment of the runs that distinguishes two planners, s. Simulated planners are not more exact than a
/// servo period.
const MIN_DISTINGUISHING_SHIFT_S: f64 = LINUXCNC_SERVO_PERIOD_S;
/// Least delay of filters that shape ramps, s: the longest usual cycle of a control.
const MIN_FILTER_DELAY_S: f64 = 4e-3;
/// Largest misfit of the ramps of a planner with the right law: up to 0.032 in the development seeds. Up to
/// [`MAX_RAMP_MISFIT`](crate::machine::MAX_RAMP_MISFIT) another law may be nearer, and is tried.
const MAX_MISFIT_OF_RIGHT_LAW: f64 = 0.04;
/// Share of the fits of planners in the progress.
const PLANNERS_SHARE: f64 = 0.4;

impl Fitting<'_> {
    /// Replaces the model by the nearest planner if that is nearer by far; `plain` has the filters without laws.
    pub fn try_planners(&mut self, plain: &Machine, model: &mut Model) {
        let starts = families::guesses(
            self.machine,
            plain,
            self.runs(),
            &model.whitenings,
            (self.plateaus, self.held),
        );
        self.share.part = PLANNERS_SHARE / starts.len().max(1) as f64;
        let of_families = self.fitted_families(&starts);
        self.share.part /= MAX_NOISE_ROUNDS as f64;
        let Some(planner) = self.chosen_planner(of_families) else { return };
        let [own, with_filters] = self.costs(&planner, model);
        // Filters shorter than a cycle of the control shape no ramp, so the control is a planner; neither do filters whose
        // ramps have another shape.
        let delay = model.best.machine.interpolator.filter_delay(0.0);
        let shapes_ramps = MIN_FILTER_DELAY_S <= delay
            && (self.has_recorded_ramps(model) || !self.has_recorded_ramps(&planner));
        if own < max_cost(with_filters, shapes_ramps)
            && self.can_distinguish(&planner.best.machine, &model.best.machine)
        {
            *model = planner;
        }
    }

    /// Returns the nearest planner of each family of these starts.
    fn fitted_families(&mut self, starts: &[Machine]) -> Vec<Model> {
        let mut firsts: Vec<&Machine> = Vec::new();
        let mut further: Vec<(usize, &Machine)> = Vec::new();
        for start in starts {
            match firsts.iter().position(|first| is_same_family(first, start)) {
                Some(family) => further.push((family, start)),
                None => firsts.push(start),
            }
        }
        let mut of_families = self.planners(&firsts);
        // The runs cannot contradict a fit whose cost is so low, so another fit of its family cannot replace it.
        let is_settled = |family: &Model| {
            family.best.cost < MIN_CONTRADICTING_COST || self.is_ruled_out(family, &of_families)
        };
        let are_settled: Vec<bool> = of_families.iter().map(is_settled).collect();
        // The accelerations of other ramps may have become such that quintic ones have no better shape with them.
        let quintic: Vec<Option<Machine>> = firsts.iter().map(|start| with_quintic_ramps(start)).collect();
        let with_other_ramps =
            quintic.iter().enumerate().filter_map(|(family, start)| Some((family, start.as_ref()?)));
        further.extend(with_other_ramps.filter(|(family, _)| !self.has_its_ramps(&of_families[*family])));
        further.retain(|(family, _)| !are_settled[*family]);
        let others = self.planners(&further.iter().map(|(_, start)| *start).collect::<Vec<_>>());
        for ((family, start), next) in further.into_iter().zip(others) {
            let is_of_law = !start.interpolator.quintic_ramps || self.has_its_ramps(&next);
            if is_of_law && self.is_nearer(&next, &of_families[family]) {
                of_families[family] = next;
            }
        }
        of_families
    }

    /// Returns the planners fitted from some starts.
    fn planners(&mut self, starts: &[&Machine]) -> Vec<Model> {
        self.side_by_side(starts.len(), |fitting, at| fitting.planner(starts[at]))
    }

    /// Returns `true` if a family needs no further start. Its first fit began at the accelerations that the ramps hold. If its
    /// ramps do not have the recorded shape, and a planner that is nearer by far has such ramps, the family is wrong.
    fn is_ruled_out(&self, family: &Model, all: &[Model]) -> bool {
        let is_right = |other: &Model| self.has_its_ramps(other) && self.is_nearer_by_far(other, family);
        self.held.shows_ramps() && !self.has_recorded_ramps(family) && all.iter().any(is_right)
    }

    /// Returns the planner fitted from a start.
    fn planner(&mut self, start: &Machine) -> Model {
        let (mut best, mut whitenings) = self.fit_at_own_noise(start, 1, FTOL);
        // What has no derivative is chosen again where the fit has come to.
        if let Some(other) = families::chosen_again(&best.machine, self.runs(), &whitenings) {
            (best, whitenings) = self.fit_at_own_noise(&other, 1, FTOL);
        }
        let model = Model { best, whitenings, order: 1 };
        self.or_with_quintic_ramps(model)
    }

    /// Returns a planner of Marlin with quintic ramps if these have the recorded shape and others have not. They take as long,
    /// but places within ramps are passed at other times, so all else is fitted again.
    fn or_with_quintic_ramps(&mut self, model: Model) -> Model {
        let Some(quintic) = with_quintic_ramps(&model.best.machine) else { return model };
        let misfit = ramp_misfit(&model.best.machine, self.runs());
        if misfit.is_within(MAX_MISFIT_OF_RIGHT_LAW)
            || misfit.of_path < ramp_misfit(&quintic, self.runs()).of_path
        {
            return model;
        }
        let (best, whitenings) = self.fit_at_own_noise(&quintic, 1, FTOL);
        let quintic = Model { best, whitenings, order: 1 };
        if self.has_its_ramps(&quintic) { quintic } else { model }
    }

    /// Returns the planner of a family whose ramps have the recorded shape, unless another one is nearer by far; `None` if
    /// there is no family. The times of blocks hardly tell two families apart in a program of few corners; the shape of
    /// its ramps may.
    fn chosen_planner(&mut self, of_families: Vec<Model>) -> Option<Model> {
        let (with_its_ramps, others): (Vec<Model>, Vec<Model>) =
            of_families.into_iter().partition(|model| self.needs_no_jerk_limit(model));
        if let Some(own) = self.nearest_planner(with_its_ramps)
            && !others.iter().any(|other| self.is_nearer_by_far(other, &own))
        {
            return Some(own);
        }
        // Quintic ramps look like ramps of constant jerk, so their times decide.
        let is_right =
            |planner: &Model| planner.best.cost < MIN_CONTRADICTING_COST && self.has_its_ramps(planner);
        let mut has_right_law = others.iter().any(is_right);
        let mut limited = Vec::new();
        for planner in others {
            let planner = if has_right_law { planner } else { self.with_jerk_limit(planner) };
            has_right_law |= planner.best.machine.limits_jerk() && self.has_its_ramps(&planner);
            limited.push(planner);
        }
        self.nearest_planner(limited)
    }

    /// Returns `true` if a planner is by far the nearer of two, both at its own noise and at the noise of the other one.
    fn is_nearer_by_far(&self, planner: &Model, other: &Model) -> bool {
        [planner, other].into_iter().all(|at_noise_of| {
            let [own, before] = self.costs_at_noise_of(at_noise_of, [planner, other]);
            own < max_cost(before, true)
        })
    }

    /// Returns the planner that is nearest to the runs; `None` if there is none.
    fn nearest_planner(&self, planners: Vec<Model>) -> Option<Model> {
        planners.into_iter().reduce(|best, next| if self.is_nearer(&next, &best) { next } else { best })
    }

    /// Returns a planner whose ramps do not have the recorded shape with a jerk limit if that is nearer by far; otherwise
    /// returns the planner unchanged.
    fn with_jerk_limit(&mut self, planner: Model) -> Model {
        let starts = jerk_limits::with_jerk_limits(&planner.best.machine, self.runs(), &planner.whitenings);
        let mut nearest = planner;
        for start in &starts {
            let limited = self.planner(start);
            if self.is_nearer(&limited, &nearest) {
                nearest = limited;
                if self.has_its_ramps(&nearest) {
                    break;
                }
            }
        }
        nearest
    }

    /// Returns `true` if ramps have the recorded shape, or if no run shows it.
    fn has_recorded_ramps(&self, model: &Model) -> bool {
        ramp_misfit(&model.best.machine, self.runs()).is_of_law()
    }

    /// Returns `true` if the ramps of a planner of trapezoids have the recorded shape; of Marlin's, without doubt.
    fn needs_no_jerk_limit(&self, model: &Model) -> bool {
        match families::is_of_marlin(&model.best.machine) {
            true => !model.best.machine.interpolator.quintic_ramps && self.has_its_ramps(model),
            false => self.has_recorded_ramps(model),
        }
    }

    /// Returns `true` if the shape of ramps leaves no doubt of the law of a planner, or if no run shows it.
    fn has_its_ramps(&self, model: &Model) -> bool {
        ramp_misfit(&model.best.machine, self.runs()).is_within(MAX_MISFIT_OF_RIGHT_LAW)
    }

    /// Returns `true` if a planner is nearer to the runs than an earlier one: by far if both blend corners in time or it has
    /// more parameters, otherwise so that the runs contradict the earlier one. Of two families that the runs cannot
    /// distinguish, the one with fewer parameters counts as nearer; of two with as many, one that costs enough less.
    fn is_nearer(&self, planner: &Model, earlier: &Model) -> bool {
        let [own, others] = [planner, earlier].map(|model| model.best.values.len());
        let is_same = is_same_family(&planner.best.machine, &earlier.best.machine);
        let costs_less = |by_far: bool| {
            let [cost, before] = self.costs(planner, earlier);
            cost < max_cost(before, by_far)
        };
        if !self.can_distinguish(&planner.best.machine, &earlier.best.machine) {
            return !is_same && (own < others || own == others && costs_less(false));
        }
        let blends = planner.best.machine.interpolator.junction.blends_in_time();
        costs_less(others < own || blends && is_same)
    }

    /// Returns the costs of two models at the noise of the more likely one: at the noise of the other one, hardly anything
    /// would distinguish two that leave little. The process noise alone does not tell which leaves less, since a model that
    /// is far off at a few places may have none elsewhere.
    fn costs(&self, one: &Model, other: &Model) -> [f64; 2] {
        let unlikely = |model: &Model| {
            let log_variances = model.whitenings.iter().map(Whitening::log_variance);
            cost_of(&model.best.machine, self.runs(), &model.whitenings) + log_variances.sum::<f64>()
        };
        let likely = if unlikely(one) < unlikely(other) { one } else { other };
        self.costs_at_noise_of(likely, [one, other])
    }

    /// Returns the costs of two models at the noise of a model.
    pub fn costs_at_noise_of(&self, noisy: &Model, models: [&Model; 2]) -> [f64; 2] {
        models.map(|model| cost_of(&model.best.machine, self.runs(), &noisy.whitenings))
    }

    /// Returns `true` if the runs can distinguish two planners.
    pub fn can_distinguish(&self, one: &Machine, other: &Machine) -> bool {
        MIN_DISTINGUISHING_SHIFT_S < largest_shift([one, other], self.runs())
    }

    /// Replaces the model by one with another way to blend corners if the runs contradict the first one. It fits each of
    /// them, because the accelerations may have made up for a wrong one.
    pub fn try_other_blends(&mut self, model: &mut Model) {
        self.share.part = 0.02;
        let starts = families::with_other_blends(&model.best.machine);
        let Some(found) = self.nearest_fit(&starts, model, FTOL) else { return };
        if found.cost < model.best.cost - MIN_CONTRADICTING_COST
            && self.can_distinguish(&found.machine, &model.best.machine)
        {
            let order = model.order;
            let (best, whitenings) = self.fit_at_own_noise(&found.machine, order, FTOL);
            *model = Model { best, whitenings, order };
        }
    }
}

/// Returns a planner of Marlin with quintic ramps; `None` if it has them, or is no such planner.
fn with_quintic_ramps(planner: &Machine) -> Option<Machine> {
    let has_others = families::is_of_marlin(planner) && !planner.interpolator.quintic_ramps;
    has_others.then(|| {
        let mut quintic = planner.clone();
        quintic.interpolator.quintic_ramps = true;
        quintic
    })
}

/// Returns the largest cost at which a model takes the place of another one, whose cost is `before`: by far, or so that the
/// runs contradict the other one.
fn max_cost(before: f64, by_far: bool) -> f64 {
    if by_far { (1.0 - BETTER_FAMILY) * before } else { before - MIN_CONTRADICTING_COST }
}

/// Returns `true` if two planners have the same junction law; all ways to blend corners count as one.
fn is_same_family(one: &Machine, other: &Machine) -> bool {
    let [with_chords, others_chords] =
        [one, other].map(|machine| machine.interpolator.short_blocks_are_chords);
    let [one, other] = [one, other].map(|machine| machine.interpolator.junction);
    std::mem::discriminant(&one) == std::mem::discriminant(&other) && with_chords == others_chords
        || one.blends_in_time() && other.blends_in_time()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identification::alignment::{recorded, recorded_positions};
    use crate::identification::calibration::compared;
    use crate::identification::effects::parameters::MINIMUM_CRUISE_RATIO;
    use crate::identification::fit::{AlignedRun, FreeParameter, Run};
    use crate::machine::Planner;

    #[test]
    fn a_fit_that_takes_a_law_away_goes_on_without_its_parameter() {
        let mut truth = Machine::default();
        truth.become_planner(Planner::SquareCorner, 1560.0);
        truth.interpolator.minimum_cruise_ratio = 0.0;
        let square = |side: usize| format!("X{side}\nY{side}\nX0\nY0\n");
        let program = format!("G1 F6000\n{}", (1..=12).map(square).collect::<String>());
        let (toolpath, alignment) = recorded(&program, &truth, 1e-4);
        let runs = [Run { toolpath: &toolpath, alignment: &alignment, overrides: (None, None) }];
        let mut start = truth.clone();
        start.interpolator.minimum_cruise_ratio = 0.001;
        let mut progress = |_| {};
        let (mut fitting, _) = Fitting::new(&start, &runs, &compared(&start, &runs), &mut progress);
        let has_ratio = |parameters: &[(FreeParameter, f64)]| {
            parameters.iter().any(|(freed, _)| freed.handle == MINIMUM_CRUISE_RATIO.handle())
        };
        assert!(has_ratio(&fitting.parameters(1, &start)));
        let (best, _) = fitting.fit_at_own_noise(&start, 1, FTOL);
        let remaining = fitting.parameters(1, &best.machine);
        assert!(!has_ratio(&remaining), "{}", best.machine.interpolator.minimum_cruise_ratio);
        let of_machine = remaining.iter().map(|(freed, _)| freed.handle.get(&best.machine));
        assert_eq!(
            of_machine.collect::<Vec<_>>(),
            best.values.iter().map(|own| Some(*own)).collect::<Vec<_>>()
        );
    }

    #[test]
    fn of_two_families_that_runs_cannot_distinguish_the_one_with_fewer_parameters_is_nearer() {
        let planner = |family: Planner| {
            let mut machine = Machine::default();
            machine.become_planner(family, 1560.0);
            machine.interpolator.minimum_cruise_ratio = 0.0;
            machine.interpolator.step_segment = 0.0;
            machine
        };
        let truth = planner(Planner::SquareCorner);
        let (toolpath, alignment) = recorded("G1 F6000\nX40\nX0\nX40\nX0\n", &truth, 1e-4);
        let runs = [Run { toolpath: &toolpath, alignment: &alignment, overrides: (None, None) }];
        let mut progress = |_| {};
        let (mut fitting, _) = Fitting::new(&truth, &runs, &compared(&truth, &runs), &mut progress);
        let mut model = |family: Planner| {
            let (best, whitenings) = fitting.fit_at_own_noise(&planner(family), 1, FTOL);
            Model { best, whitenings, order: 1 }
        };
        let [more, fewer, mut simpler] =
            [Planner::JunctionDeviation, Planner::SquareCorner, Planner::SquareCorner].map(&mut model);
        assert!(fewer.best.values.len() < more.best.values.len());
        assert!(fitting.is_nearer(&fewer, &more));
        assert!(!fitting.is_nearer(&more, &fewer));
        // Of one family, the earlier one is kept.
        simpler.best.values.pop();
        assert!(!fitting.is_nearer(&simpler, &fewer));
        // Of two with as many parameters, the one that the runs contradict is not.
        let mut contradicted = more;
        contradicted.best.values.truncate(fewer.best.values.len());
        contradicted.best.machine = contradicted.best.machine.with_scaled_accelerations(1.002);
        assert!(!fitting.can_distinguish(&fewer.best.machine, &contradicted.best.machine));
        assert!(fitting.is_nearer(&fewer, &contradicted));
        assert!(!fitting.is_nearer(&contradicted, &fewer));
    }

    /// Wide corners, which LinuxCNC rounds the more the larger the override that it plans for.
    #[test]
    fn accelerations_do_not_make_up_for_a_wrong_override() {
        let mut truth = Machine::default();
        truth.become_planner(Planner::AccelerationBlend, 1560.0);
        truth.interpolator.max_override = 2.0;
        let program = format!("G1 F2820\n{}", "X1.5 Y0\nX0 Y-6.543\nX13.212\nY0\n".repeat(6));
        let (toolpath, alignment) = recorded(&program, &truth, 1e-4);
        let runs = [Run { toolpath: &toolpath, alignment: &alignment, overrides: (None, None) }];
        let mut believed = truth.clone();
        believed.interpolator.max_override = 1.2;
        let before = compared(&believed, &runs);
        let mut progress = |_| {};
        let (mut fitting, start) = Fitting::new(&believed, &runs, &before, &mut progress);
        let (best, whitenings) = fitting.fit_at_own_noise(&start, 1, FTOL);
        let mut model = Model { best, whitenings, order: 1 };
        let accelerations = |model: &Model| model.best.machine.axes.map(|axis| axis.acceleration);
        let made_up = accelerations(&model);
        assert!(made_up[..2].iter().any(|own| 0.02 < (own / 1560.0 - 1.0).abs()), "{made_up:?}");
        fitting.try_other_blends(&mut model);
        let found = accelerations(&model);
        assert!(found[..2].iter().all(|own| (own / 1560.0 - 1.0).abs() < 1e-3), "{found:?}");
        assert!(1.2 < model.best.machine.interpolator.max_override);
    }

    #[test]
    fn a_family_whose_ramps_are_wrong_at_the_held_accelerations_is_ruled_out_by_one_whose_ramps_are_right() {
        let mut truth = Machine::default();
        truth.become_planner(Planner::JunctionDeviation, 400.0);
        let program = format!("G1 F6000\n{}", "X80\nX0\n".repeat(6));
        let (toolpath, csv) = recorded_positions(&program, &truth, |_, at| at);
        let aligned = AlignedRun::new(toolpath, csv.as_bytes(), &truth).expect("it is of this program");
        let runs = [aligned.run()];
        let mut progress = |_| {};
        let (mut fitting, _) = Fitting::new(&truth, &runs, &compared(&truth, &runs), &mut progress);
        assert!(fitting.held.shows_ramps());
        let mut model = || {
            let (best, whitenings) = fitting.fit_at_own_noise(&truth, 1, FTOL);
            Model { best, whitenings, order: 1 }
        };
        let (right, mut wrong) = (model(), model());
        wrong.best.machine = wrong.best.machine.with_scaled_accelerations(0.7);
        let both = [right, wrong];
        assert!(fitting.is_ruled_out(&both[1], &both));
        assert!(!fitting.is_ruled_out(&both[0], &both));
        assert!(!fitting.is_ruled_out(&both[1], &both[1..]), "nothing is nearer");
    }
}
