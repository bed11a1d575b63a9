//! One acceleration for the axes of a machine, which are taken to be alike until the runs contradict it.
//!
//! Two axes at once limit arcs and corners, so one acceleration that is too high beside one that is too low fits
//! nearly as well as the true ones, which are often equal. The calibration therefore fits the accelerations of all
//! axes as one value. If the cost of this value is higher by less than [`MIN_CONTRADICTING_COST`] for each value that is
//! saved, the machine has it in all axes; otherwise the calibration tries X and Y alone.

use crate::identification::calibration::judgement::Judgement;
use crate::identification::calibration::motion::axis_of;
use crate::identification::calibration::{Estimate, MIN_CONTRADICTING_COST, ParameterVerdict};
use crate::identification::effects::parameters::AXIS_ACCELERATION;
use crate::identification::fit::{Fit, FreeParameter};
use crate::machine::Machine;

/// Groups of axes that may be alike; the group that saves most values comes first.
const GROUPS: [&[usize]; 2] = [&[0, 1, 2], &[0, 1]];

/// Returns the judgement with one parameter for the accelerations of axes that are alike, and these axes; if the
/// runs contradict it for every group, the judgement as given and no axes. `fitted` fits parameters, starting from
/// a machine.
pub fn alike(
    judgement: Judgement,
    mut fitted: impl FnMut(&Machine, &[(FreeParameter, f64)]) -> Fit,
) -> (Judgement, &'static [usize]) {
    for group in GROUPS {
        let Some(as_one) = as_one(&judgement, group) else { continue };
        let parameters: Vec<(FreeParameter, f64)> = as_one.fitted().cloned().collect();
        let last = fitted(&as_one.last.machine, &parameters);
        let saved = (group.len() - 1) as f64;
        if last.cost < judgement.last.cost + saved * MIN_CONTRADICTING_COST {
            return (Judgement { last, ..as_one }, group);
        }
    }
    (judgement, &[])
}

/// Returns the estimates with an estimate for each axis of a group whose accelerations are one parameter; this
/// parameter has the key of the first axis.
pub fn of_each_axis(estimates: Vec<Estimate>, group: &[usize], before: &Machine) -> Vec<Estimate> {
    let of_group = |estimate: Estimate| -> Vec<Estimate> {
        let is_one = group.first().is_some_and(|first| estimate.key == AXIS_ACCELERATION[*first].key);
        let others = if is_one { &group[1..] } else { &[] };
        let of_axis = |axis: &usize| Estimate {
            key: AXIS_ACCELERATION[*axis].key.to_string(),
            before: before.axes[*axis].acceleration,
            ..estimate.clone()
        };
        let others: Vec<Estimate> = others.iter().map(of_axis).collect();
        [estimate].into_iter().chain(others).collect()
    };
    estimates.into_iter().flat_map(of_group).collect()
}

/// Returns the judgement with one parameter for the accelerations of a group, not yet fitted; `None` if one of
/// these accelerations was not freed or is infinite.
fn as_one(judgement: &Judgement, group: &'static [usize]) -> Option<Judgement> {
    let place =
        |axis: &usize| (0..judgement.all.len()).find(|at| axis_of(&judgement.all[*at].0) == Some(*axis));
    let places: Vec<usize> = group.iter().filter_map(place).collect();
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
