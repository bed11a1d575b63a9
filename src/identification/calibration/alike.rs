//! One acceleration for the axes of a machine, which are taken to be alike until the runs contradict it.
//!
//! Two axes at once limit arcs and corners, so one acceleration that is too high beside one that is too low fits
//! nearly as well as the true ones, which are often equal. The calibration therefore fits the accelerations of all
//! axes as one value. If the cost of this value is higher by less than [`MIN_CONTRADICTING_COST`] for each value that is
//! saved, the machine has it in all axes; otherwise the calibration tries X and Y alone.
//!
//! The fit of one value assumes that axes are alike; it does not show how well the runs determine each axis. An axis
//! that hardly moves may have any acceleration, even if the common value has a small standard deviation. Each axis
//! therefore states the standard deviation from the fit with separate values.

use crate::identification::calibration::judgement::Judgement;
use crate::identification::calibration::motion::axis_of;
use crate::identification::calibration::{Estimate, MIN_CONTRADICTING_COST, ParameterVerdict};
use crate::identification::effects::parameters::AXIS_ACCELERATION;
use crate::identification::fit::{Fit, FreeParameter};
use crate::machine::Machine;

/// Groups of axes that may be alike; the group that saves most values comes first.
const GROUPS: [&[usize]; 2] = [&[0, 1, 2], &[0, 1]];

/// Axes whose accelerations are one parameter.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AlikeAxes {
    pub axes: &'static [usize],
    /// Standard deviation of the acceleration of each axis in the fit in which each has its own, mm/s².
    pub deviations: [f64; 3],
}

/// Returns the judgement with one parameter for the accelerations of axes that are alike, and these axes; if the
/// runs contradict it for every group, the judgement as given and no axes. `fitted` fits parameters, starting from
/// a machine.
pub fn alike(
    judgement: Judgement,
    mut fitted: impl FnMut(&Machine, &[(FreeParameter, f64)]) -> Fit,
) -> (Judgement, AlikeAxes) {
    for axes in GROUPS {
        let Some(as_one) = as_one(&judgement, axes) else { continue };
        let parameters: Vec<(FreeParameter, f64)> = as_one.fitted().cloned().collect();
        let last = fitted(&as_one.last.machine, &parameters);
        let saved = (axes.len() - 1) as f64;
        if last.cost < judgement.last.cost + saved * MIN_CONTRADICTING_COST {
            let deviations = [0, 1, 2].map(|axis| own_deviation(&judgement, axis));
            return (Judgement { last, ..as_one }, AlikeAxes { axes, deviations });
        }
    }
    (judgement, AlikeAxes::default())
}

/// Returns the estimates with an estimate for each axis of a group whose accelerations are one parameter; this
/// parameter has the key of the first axis. An axis that is `untold` has no deviation.
pub fn of_each_axis(
    estimates: Vec<Estimate>,
    alike: AlikeAxes,
    untold: [bool; 3],
    before: &Machine,
) -> Vec<Estimate> {
    let of_group = |estimate: Estimate| -> Vec<Estimate> {
        let is_one = alike.axes.first().is_some_and(|first| estimate.key == AXIS_ACCELERATION[*first].key);
        if !is_one {
            return vec![estimate];
        }
        let of_axis = |axis: &usize| Estimate {
            key: AXIS_ACCELERATION[*axis].key.to_string(),
            before: before.axes[*axis].acceleration,
            deviation: (!untold[*axis]).then_some(alike.deviations[*axis]),
            ..estimate.clone()
        };
        alike.axes.iter().map(of_axis).collect()
    };
    estimates.into_iter().flat_map(of_group).collect()
}

/// Returns the standard deviation of the acceleration of an axis in the fit of a judgement, mm/s²; infinite if it was not
/// fitted.
fn own_deviation(judgement: &Judgement, axis: usize) -> f64 {
    let mut fitted = judgement.fitted().zip(&judgement.last.deviations);
    let own = fitted.find(|((freed, _), _)| axis_of(freed) == Some(axis));
    own.map_or(f64::INFINITY, |(_, deviation)| *deviation)
}

/// Returns the place of the acceleration of an axis among the parameters of a judgement; `None` if it was not freed.
fn place_of(judgement: &Judgement, axis: usize) -> Option<usize> {
    (0..judgement.all.len()).find(|at| axis_of(&judgement.all[*at].0) == Some(axis))
}

/// Returns the judgement with one parameter for the accelerations of a group, not yet fitted; `None` if one of
/// these accelerations was not freed or is infinite.
fn as_one(judgement: &Judgement, group: &'static [usize]) -> Option<Judgement> {
    let places: Vec<usize> = group.iter().filter_map(|axis| place_of(judgement, *axis)).collect();
    let values: Vec<f64> = group.iter().map(|axis| judgement.last.machine.axes[*axis].acceleration).collect();
    if places.len() < group.len() || !values.iter().all(|value| value.is_finite()) {
        return None;
    }
    let mean = (values.iter().map(|value| value.ln()).sum::<f64>() / values.len() as f64).exp();
    let (first, before) = &judgement.all[places[0]];
    let one = first.starting_at(mean).also(move |machine| {
        let own = machine.axes[group[0]].acceleration;
        group.iter().for_each(|axis| machine.axes[*axis].acceleration = own);
    });
    let mut as_one = judgement.clone();
    (as_one.all[places[0]], as_one.verdicts[places[0]]) = ((one, *before), ParameterVerdict::Fitted);
    for at in places[1..].iter().rev() {
        as_one.all.remove(*at);
        as_one.believed.remove(*at);
        as_one.verdicts.remove(*at);
        as_one.deviations.remove(*at);
    }
    // Each value that is fitted goes on from where it was.
    let machine = &as_one.last.machine;
    for (freed, _) in &mut as_one.all {
        let own = freed.handle.get(machine).unwrap_or(freed.start);
        *freed = freed.starting_at(if axis_of(freed) == Some(group[0]) { mean } else { own });
    }
    Some(as_one)
}
