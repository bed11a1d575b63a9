//! Values that a calibration had to assume or got wrong, as another program shows them.
//!
//! No calibrating run determined these accelerations and rapid rates, and none had a tool change, say, so a program that
//! reaches them shows their value for the first time. That is no cause: a diagnosis takes them from the recording
//! before it looks for causes, if they lower the cost by more than a cause with as many parameters must.
//!
//! An axis that the recording moves faster than its limit has no such limit: the calibration took another reason to be
//! slow for it, such as the centripetal acceleration on its arcs. The limit is raised to the velocity that the axis
//! holds.
//!
//! The feed override that LinuxCNC plans for decides how widely it blends corners that no tolerance limits, and at which
//! tangents it stops in exact path mode (G61). Other corners do not show this override. Nor do arcs that other limits slow
//! show their chords.
//!
//! A program with few corners, or with slow ones, shows the junction law of a planner to some ten per cent only, and chains
//! of short lines of another program depend on it strongly. So that law may differ by [`JUNCTION_LAW_RATIO`] there, and an
//! acceleration by [`ACCELERATION_RATIO`].
//!
//! Limits: a change of an assumed value after the calibration cannot be seen, nor a limit that was raised, nor such a small
//! change of corners or accelerations.

use crate::identification::calibration::{MAX_RELATIVE_DEVIATION, RapidPlateaus, guesses, nearest};
use crate::identification::comparison::Comparison;
use crate::identification::diagnosis::evidence::{Evidence, assumed};
use crate::identification::diagnosis::gates::price;
use crate::identification::effects::parameters::{
    AXIS_ACCELERATION, AXIS_VELOCITY_STEP, Adjustable, JUNCTION_DEVIATION, MAX_OVERRIDE, PATH_ACCELERATION,
    SQUARE_CORNER_VELOCITY,
};
use crate::identification::fit::{FTOL, FreeParameter, Run, fit};
use crate::machine::{Junction, Machine};

/// Largest ratio between the calibrated value of a junction law and its value in the recording of another program: of 20
/// calibrations of development data, half were within 5 % of the true value, and the worst was off by a factor of 1.5.
const JUNCTION_LAW_RATIO: f64 = 1.5;

/// Largest ratio between a calibrated acceleration and its value in the recording of another program: a calibration takes an
/// acceleration for determined up to a standard deviation of that size.
const ACCELERATION_RATIO: f64 = 1.0 + MAX_RELATIVE_DEVIATION;

/// Returns the machine with the values that its calibration had assumed replaced by those that the runs show, and
/// without limits that the runs exceed. `None` if there are none of both, or if the runs do not show them.
pub fn shown(machine: &Machine, runs: &[Run]) -> Option<Machine> {
    let seen = RapidPlateaus::of(runs);
    let (mut raised, exceeded) = match &seen {
        Some(seen) => seen.raised(&with_plateaus(machine, seen)),
        None => (machine.clone(), 0),
    };
    let waits = assumed_waits(machine, runs);
    waits.iter().for_each(|wait| wait.apply(&mut raised, wait.start));
    let is_exact_path = |run: &Run| run.toolpath.segments.iter().any(|segment| segment.exact_path);
    let shows_override = machine.calibrated_on.largest_override.is_some()
        || machine.interpolator.junction.blends_in_time() && runs.iter().any(is_exact_path);
    let near: Vec<FreeParameter> = junction_law(machine).into_iter().chain(accelerations(machine)).collect();
    let other_chords = &machine.calibrated_on.other_chord_ratios;
    let chosen = usize::from(shows_override) + usize::from(!other_chords.is_empty());
    let count = assumed(machine).len() + exceeded + waits.len() + chosen + near.len();
    if count == 0 {
        return None;
    }
    let fitted = |machine: &Machine| {
        let evidence = Evidence::of(runs, machine);
        let from_here = |own: &FreeParameter| own.starting_at(own.handle.get(machine).unwrap_or(own.start));
        let others = waits.iter().chain(&near).map(from_here);
        let freed: Vec<FreeParameter> = assumed(machine).into_iter().chain(others).collect();
        fit(machine, runs, &freed, &evidence.whitenings, FTOL, &mut |_| {}).machine
    };
    // At the noise that the first leaves: at that of what was assumed wrongly hardly anything is seen.
    let mut first = fitted(&raised);
    let nearest_of = |first: Machine, others: Vec<Machine>| {
        let all = [first.clone()].into_iter().chain(others);
        nearest(all, runs, &Evidence::of(runs, &first).whitenings).unwrap_or(first)
    };
    if shows_override {
        let planned = MAX_OVERRIDE.guesses_on(&first);
        first = nearest_of(first, planned);
    }
    if !other_chords.is_empty() {
        let chorded = other_chords.iter().map(|ratio| first.with_scaled_chords(*ratio)).collect();
        first = nearest_of(first, chorded);
    }
    let found = fitted(&first);
    let fine = Evidence::of(runs, &found);
    (price(runs, count) < fine.cost(machine) - fine.cost(&found)).then_some(found)
}

/// Returns the free parameters of the accelerations that the calibration determined, each within [`ACCELERATION_RATIO`] of its
/// value.
fn accelerations(machine: &Machine) -> Vec<FreeParameter> {
    let assumed = machine.calibrated_on.assumed_accelerations;
    let of_axes = AXIS_ACCELERATION.into_iter().zip(assumed).filter(|(_, assumed)| !assumed);
    let near = |parameter: Adjustable| {
        let own = parameter.handle().get(machine).filter(|own| own.is_finite())?;
        Some(parameter.near(own, ACCELERATION_RATIO))
    };
    of_axes.map(|(parameter, _)| parameter).chain([PATH_ACCELERATION]).filter_map(near).collect()
}

/// Returns the free parameter for the value of the junction law, within [`JUNCTION_LAW_RATIO`] of the calibrated one; `None` if
/// no law gives corners a feedrate.
fn junction_law(machine: &Machine) -> Option<FreeParameter> {
    let parameter = match machine.interpolator.junction {
        Junction::Deviation(_) => JUNCTION_DEVIATION,
        Junction::SquareCorner(_) => SQUARE_CORNER_VELOCITY,
        Junction::AxisStep(_) => AXIS_VELOCITY_STEP,
        _ => return None,
    };
    let own = parameter.handle().get(machine)?;
    Some(parameter.near(own, JUNCTION_LAW_RATIO))
}

/// Returns the waits at the M-words that no calibrating program has, each with its first guess.
fn assumed_waits(machine: &Machine, runs: &[Run]) -> Vec<FreeParameter> {
    let Some(shown) = &machine.calibrated_on.m_codes else { return Vec::new() };
    let compared: Vec<Comparison> = runs.iter().map(|run| run.compared(machine)).collect();
    let all = guesses(machine, runs, &compared).into_iter();
    all.filter(|(kind, _)| !shown.contains(&kind.m_code())).map(|(kind, guess)| kind.freed(guess)).collect()
}

/// Returns the machine with each assumed rapid rate replaced by the rate that the runs hold for a while: a rate that no
/// move reaches has no slope by which to fit it.
fn with_plateaus(machine: &Machine, seen: &RapidPlateaus) -> Machine {
    let mut machine = machine.clone();
    let assumed = machine.calibrated_on.assumed_rapids;
    let rates = seen.rates(&machine);
    for ((axis, seen), _) in
        machine.axes.iter_mut().zip(rates.axes).zip(assumed).filter(|(_, assumed)| *assumed)
    {
        let has_one_velocity = axis.velocity == axis.rapid;
        axis.rapid = seen.filter(|_| axis.rapid.is_finite()).unwrap_or(axis.rapid);
        if has_one_velocity {
            axis.velocity = axis.rapid;
        }
    }
    if assumed == [true; 3] && machine.rapid.feedrate.is_finite() {
        machine.rapid.feedrate = rates.path.unwrap_or(machine.rapid.feedrate);
    }
    machine
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identification::alignment::recorded;
    use crate::machine::Planner;
    use crate::simulation::simulate;

    /// A calibration on other arcs did not show the chords, which slow these.
    #[test]
    fn chords_that_the_calibration_had_to_assume_are_taken_from_the_recording() {
        let mut machine = Machine::default();
        machine.become_planner(Planner::JunctionDeviation, 1190.0);
        machine.interpolator.junction = Junction::Deviation(5e-4);
        let truth = machine.with_scaled_chords(0.2);
        let program =
            format!("G1 F3830\n{}", "X10\nG3 X10 Y9.4 I0 J4.7\nG1 X0\nG3 X0 Y0 I0 J-4.7\nG1 ".repeat(12));
        let (toolpath, alignment) = recorded(&program, &truth, 1e-3);
        let runs = [Run { toolpath: &toolpath, alignment: &alignment, overrides: (None, None) }];
        machine.calibrated_on.other_chord_ratios = vec![0.2, 5.0];
        let found = shown(&machine, &runs).expect("the runs show the chords");
        assert_eq!(found.interpolator.arc_chords, truth.interpolator.arc_chords);
        let off = [&found, &truth].map(|machine| simulate(&toolpath, machine).cycle_time());
        let off = off[0] - off[1];
        assert!(off.abs() < 0.01, "{off} s");
    }
}
