//! Other families of controls: planners that ramp in trapezoids, for recordings that filters cannot explain.
//!
//! Filters ramp in a constant time, whatever the step; planners that are limited in acceleration ramp in Δv/a. Each
//! family of [`Planner`] has a separate law of corners ([`crate::simulation::feed::junction`]). The guesses of a
//! family are the nearest with the accelerations that the ramps or the arcs of the runs hold, the nearest of a grid of
//! accelerations, the same for all axes, and values of its law of corners, and the nearest with an acceleration beside that.
//! Rapids are as fast as their plateaus (`rapids`).

use crate::identification::calibration::held_accelerations::HeldAccelerations;
use crate::identification::calibration::rapids::{RapidPlateaus, RapidRates, limit_feed_as_rapids};
use crate::identification::calibration::{nearest, nearest_with_cost};
use crate::identification::effects::parameters::{JUNCTION_RATIOS, MAX_OVERRIDE, PLANNER_ACCELERATION};
use crate::identification::fit::{Run, Whitening};
use crate::machine::{
    CHORD_ERROR_RATIOS, GRBL_STEP_SEGMENT_S, GRBL_STEP_TIMER_HZ, Junction, KLIPPER_MIN_CRUISE_RATIO, Machine,
    Planner,
};
use crate::simulation::ordered::sort_by_number;

/// Initial values of the minimum cruise ratio in fits: Klipper's default, and a small value, because a fit does not free a
/// ratio of 0.
const INITIAL_CRUISE_RATIOS: [f64; 2] = [KLIPPER_MIN_CRUISE_RATIO, 0.1];
/// Exponents p tried for the acceleration when the cruise ratio changes from r₀ to r: the acceleration is multiplied by
/// ((1 − r₀) / (1 − r))^p. With p = 0 long moves keep their acceleration, with p = 1 short moves do.
const CRUISE_ACCELERATION_EXPONENTS: [f64; 3] = [0.0, 0.5, 1.0];

/// Largest relative difference of the steps of two recordings of one machine.
const MAX_STEP_DIFFERENCE_RATIO: f64 = 1e-3;

/// A family of planners as a calibration tries it.
#[derive(Clone, Copy)]
struct CandidateFamily {
    planner: Planner,
    /// `true` if the machine file's contour tolerance bounds the blends; `false` if nothing does. A fit cannot change from
    /// one to the other.
    keeps_tolerance: bool,
    /// `true` if its axes, or the path on a control that limits that instead, are limited to the velocities that they
    /// reached again and again.
    is_limited: bool,
    /// Minimum cruise ratio, 0 if the family has none.
    cruise_ratio: f64,
}

/// The basis of the guesses of all families.
struct Guessing<'a> {
    /// The machine before the calibration.
    machine: &'a Machine,
    /// The machine with the waits and the rapid feed that filters need.
    fitted: &'a Machine,
    runs: &'a [Run<'a>],
    whitenings: &'a [Whitening],
    plateaus: Option<RapidPlateaus>,
    held: HeldAccelerations,
}

/// Returns the machines of each family that are nearest to the runs, before any fit, and only the nearest one of each of Marlin's
/// two families. `machine` is the machine before the calibration; `fitted` has the waits and the rapid feed
/// that filters need. Acceleration blends are guessed with a contour tolerance, as the control may be started with one, and
/// without.
pub fn guesses(
    machine: &Machine,
    fitted: &Machine,
    runs: &[Run],
    whitenings: &[Whitening],
    (plateaus, held): (Option<RapidPlateaus>, HeldAccelerations),
) -> Vec<Machine> {
    let mut plain = fitted.clone();
    plain.interpolator.contour_tolerance = machine.interpolator.contour_tolerance;
    let guessing = Guessing { machine, fitted: &plain, runs, whitenings, plateaus, held };
    let guesses = |planner: Planner| {
        let all =
            candidates(planner, &plain, plateaus).into_iter().flat_map(|candidate| guessing.of(candidate));
        match planner {
            Planner::AxisStep | Planner::ChordDeviation => guessing.nearest(all).into_iter().collect(),
            _ => all.collect::<Vec<Machine>>(),
        }
    };
    Planner::ALL.into_iter().flat_map(guesses).collect()
}

impl Guessing<'_> {
    /// Returns the nearest machines of a family.
    fn of(&self, candidate: CandidateFamily) -> Vec<Machine> {
        let at = |acceleration: &f64| {
            let mut of = self.fitted.clone();
            of.become_planner(candidate.planner, *acceleration);
            self.with_ways_of_rapids(candidate, of)
        };
        let grid: Vec<Vec<Machine>> = PLANNER_ACCELERATION.guesses.iter().map(at).collect();
        let at_held = self.at_held(candidate);
        let by_grid = grid.iter().flatten();
        match candidate.planner {
            Planner::AccelerationBlend => {
                let by_ramps = self.nearest(by_grid.chain(&at_held).cloned());
                // A blend that nothing bounds has no tolerance to scale.
                let scaled = |of: Machine| self.nearest(with_junctions(&of));
                let by_ramps = if candidate.keeps_tolerance { by_ramps.and_then(scaled) } else { by_ramps };
                by_ramps.and_then(|of| self.nearest(with_circles(&of))).into_iter().collect()
            }
            _ => {
                // A fit from the accelerations that the runs hold mostly leaves nothing that the others could explain.
                let at_held = self.nearest(at_held.iter().flat_map(with_junctions));
                let by_ramps = self.nearest(by_grid.cloned());
                let near = by_ramps.into_iter().flat_map(|of| self.nearest_with_corners(&grid, &of));
                at_held
                    .into_iter()
                    .chain(near)
                    .flat_map(|of| with_and_without_steps(&of, self.runs))
                    .collect()
            }
        }
    }

    /// Returns a family with the accelerations that the runs hold, one machine for each way of rapids; none if they hold none.
    fn at_held(&self, candidate: CandidateFamily) -> Vec<Machine> {
        let held = self.held.of_planner(candidate.planner, self.fitted);
        held.into_iter().flat_map(|of| self.with_ways_of_rapids(candidate, of)).collect()
    }

    /// Returns a planner of a family that has its accelerations with all that distinguishes the family, one machine for each
    /// way of rapids.
    fn with_ways_of_rapids(&self, candidate: CandidateFamily, planner: Machine) -> Vec<Machine> {
        let CandidateFamily { planner: family, keeps_tolerance, is_limited, cruise_ratio } = candidate;
        let mut of = planner;
        of.interpolator.minimum_cruise_ratio = cruise_ratio;
        if let Some(seen) = self.plateaus {
            seen.limit_feed(family, &mut of);
            of = seen.limited_to_fastest(family, &of).filter(|_| is_limited).unwrap_or(of);
        }
        if family == Planner::AccelerationBlend && keeps_tolerance {
            of.interpolator.contour_tolerance = self.fitted.interpolator.contour_tolerance;
        }
        with_rapids(family, &of, self.machine, self.fitted, self.plateaus)
    }

    /// Returns the planner of the nearest acceleration and junction value, and the nearest one with an acceleration beside that.
    /// Slow corners make up for steep ramps, so a fit from one side may end in a minimum that is not the least. `grid` has
    /// the machines of each acceleration, one for each way of rapids; `from` is one of them. From its acceleration on, the
    /// search goes to the nearer neighbour until neither is nearer. If the ramps hold no acceleration, it begins with the
    /// nearest of all.
    fn nearest_with_corners(&self, grid: &[Vec<Machine>], from: &Machine) -> Vec<Machine> {
        let place = |(at, of): (usize, &Vec<Machine>)| Some((at, of.iter().position(|of| of == from)?));
        let Some((mut at, way)) = grid.iter().enumerate().find_map(place) else { return Vec::new() };
        let nearest_at =
            |index: usize| nearest_with_cost(with_junctions(&grid[index][way]), self.runs, self.whitenings);
        let mut tried: Vec<Option<(f64, Machine)>> = vec![None; grid.len()];
        let cost_of = |tried: &[Option<(f64, Machine)>], index: usize| {
            tried[index].as_ref().map_or(f64::INFINITY, |(cost, _)| *cost)
        };
        if !self.held.shows_ramps() {
            tried = (0..grid.len()).map(nearest_at).collect();
            let mut by_cost: Vec<usize> = (0..grid.len()).collect();
            sort_by_number(&mut by_cost, |index| cost_of(&tried, *index));
            at = by_cost[0];
        }
        loop {
            let around = at.saturating_sub(1)..(at + 2).min(grid.len());
            for index in around.clone() {
                if tried[index].is_none() {
                    tried[index] = nearest_at(index);
                }
            }
            let mut by_cost: Vec<usize> = around.collect();
            sort_by_number(&mut by_cost, |index| cost_of(&tried, *index));
            if by_cost[0] == at {
                let both = by_cost.iter().take(2).filter_map(|index| tried[*index].take());
                let mut both: Vec<Machine> = both.map(|(_, of)| of).collect();
                // Accelerations above a limit of the machine are all that limit.
                both.dedup();
                return both;
            }
            at = by_cost[0];
        }
    }

    /// Returns the machine that is nearest to the runs.
    fn nearest(&self, machines: impl IntoIterator<Item = Machine>) -> Option<Machine> {
        nearest(machines, self.runs, self.whitenings)
    }
}

/// Returns the planner with each value of its junction law that a calibration tries.
pub fn with_junctions(planner: &Machine) -> Vec<Machine> {
    JUNCTION_RATIOS.iter().map(|ratio| planner.with_scaled_junction(*ratio)).collect()
}

/// Returns the variants of a family to be tried: blends with a contour tolerance and without, square corners with each cruise
/// ratio, and all also with limits of velocity if a limit may have held them back.
fn candidates(planner: Planner, plain: &Machine, plateaus: Option<RapidPlateaus>) -> Vec<CandidateFamily> {
    let mut candidates = Vec::new();
    let is_limited = plateaus.is_some_and(|seen| seen.limited_to_fastest(planner, plain).is_some());
    let limits: &[bool] = if is_limited { &[false, true] } else { &[false] };
    let (tolerances, ratios): (&[bool], &[f64]) = match planner {
        Planner::AccelerationBlend => (&[false, true], &[0.0]),
        Planner::JunctionDeviation | Planner::AxisStep | Planner::ChordDeviation => (&[false], &[0.0]),
        Planner::SquareCorner => (&[false], &INITIAL_CRUISE_RATIOS),
    };
    for &is_limited in limits {
        for &keeps_tolerance in tolerances {
            let of =
                |&cruise_ratio: &f64| CandidateFamily { planner, keeps_tolerance, is_limited, cruise_ratio };
            candidates.extend(ratios.iter().map(of));
        }
    }
    candidates
}

/// Returns `true` if a planner passes corners at a feedrate that its law gives, as grbl, Klipper and Marlin do.
pub fn has_junction_law(machine: &Machine) -> bool {
    matches!(
        machine.interpolator.junction,
        Junction::Deviation(_) | Junction::SquareCorner(_) | Junction::AxisStep(_)
    )
}

/// Returns the machine with another way to blend corners, with other steps or step segments, or with another value of its
/// junction law or its cruise ratio, if that is nearer to the runs; `None` if none is nearer. A fit does not find a
/// junction value above which another limit slows every corner, nor a cruise ratio again that it has taken to 0.
pub fn chosen_again(machine: &Machine, runs: &[Run], whitenings: &[Whitening]) -> Option<Machine> {
    let stepped = with_and_without_steps(machine, runs);
    let others = with_other_blends(machine)
        .into_iter()
        .chain(stepped.iter().flat_map(with_and_without_segments))
        .chain(with_other_corners(machine))
        .chain(with_other_chords(machine));
    let others: Vec<Machine> = others.filter(|other| other != machine).collect();
    if others.is_empty() {
        return None;
    }
    let ways = [machine.clone()].into_iter().chain(others);
    nearest(ways, runs, whitenings).filter(|other| other != machine)
}

/// Returns a planner with jerk limits with other chords of arcs, of which each has its own ramps; none if its jerk is not
/// limited.
fn with_other_chords(machine: &Machine) -> Vec<Machine> {
    let ratios = CHORD_ERROR_RATIOS.into_iter().filter(|_| machine.limits_jerk());
    ratios.map(|ratio| machine.with_scaled_chords(ratio)).collect()
}

/// Returns a planner with a junction law with other values of that law, and with the initial cruise ratios if its family has
/// one; none if it has no such law.
fn with_other_corners(machine: &Machine) -> Vec<Machine> {
    if !has_junction_law(machine) {
        return Vec::new();
    }
    // Short moves have the acceleration a (1 − r), and long ones a: the fitted acceleration is one of them, or between both.
    let own = machine.interpolator.minimum_cruise_ratio;
    let with_ratio = |ratio: f64| {
        CRUISE_ACCELERATION_EXPONENTS.map(|exponent: f64| {
            let mut of = machine.with_scaled_accelerations(((1.0 - own) / (1.0 - ratio)).powf(exponent));
            of.interpolator.minimum_cruise_ratio = ratio;
            of
        })
    };
    let has_ratio = matches!(machine.interpolator.junction, Junction::SquareCorner(_));
    let ratios = INITIAL_CRUISE_RATIOS.into_iter().filter(|_| has_ratio);
    with_junctions(machine).into_iter().chain(ratios.flat_map(with_ratio)).collect()
}

/// Returns a planner with a junction deviation both with the steps of the recorded positions, which may be those of its
/// motors or the resolution of the recorder, and without steps; other planners are returned alone.
fn with_and_without_steps(machine: &Machine, runs: &[Run]) -> Vec<Machine> {
    if !plans_by_deviation(machine) {
        return vec![machine.clone()];
    }
    let recorded: Vec<[f64; 3]> =
        runs.iter().filter_map(|run| Some(run.alignment.track.as_ref()?.steps)).collect();
    let with_steps = |steps: [f64; 3]| {
        let mut machine = machine.clone();
        machine.axes.iter_mut().zip(steps).for_each(|(axis, step)| axis.step = step);
        machine
    };
    let common = |axis: usize| {
        let mut all = recorded.iter().map(|steps| steps[axis]);
        let first = all.next().unwrap_or(0.0);
        let is_same = |other: f64| (other - first).abs() < MAX_STEP_DIFFERENCE_RATIO * first;
        if all.all(is_same) { first } else { 0.0 }
    };
    let mut both = vec![with_steps([0, 1, 2].map(common)), with_steps([0.0; 3])];
    both.dedup();
    both
}

/// Returns `true` if the planner is one of Marlin's, whose ramps may be quintic.
pub fn is_of_marlin(machine: &Machine) -> bool {
    matches!(machine.interpolator.junction, Junction::AxisStep(_))
        || machine.interpolator.short_blocks_are_chords
}

/// Returns `true` if a junction deviation limits corners as in grbl.
pub fn plans_by_deviation(machine: &Machine) -> bool {
    matches!(machine.interpolator.junction, Junction::Deviation(_)) && !is_of_marlin(machine)
}

/// Returns a planner with a junction deviation with the step segments and the timer of grbl, with an exact timer, and without
/// segments; other planners are returned alone.
fn with_and_without_segments(machine: &Machine) -> Vec<Machine> {
    if !plans_by_deviation(machine) {
        return vec![machine.clone()];
    }
    let with_timer = |(segment, frequency): (f64, f64)| {
        let mut machine = machine.clone();
        (machine.interpolator.step_segment, machine.interpolator.step_timer) = (segment, frequency);
        machine
    };
    let grbl = (GRBL_STEP_SEGMENT_S, GRBL_STEP_TIMER_HZ);
    [grbl, (GRBL_STEP_SEGMENT_S, f64::INFINITY), (0.0, f64::INFINITY)].map(with_timer).to_vec()
}

/// Returns the machine with each other way to blend corners; none if it does not blend corners in time.
pub fn with_other_blends(machine: &Machine) -> Vec<Machine> {
    if !machine.interpolator.junction.blends_in_time() {
        return Vec::new();
    }
    let ways = with_circles(machine).into_iter().chain([with_parabolas(machine)]);
    ways.filter(|other| other.interpolator != machine.interpolator).collect()
}

/// Returns the machine with circles at corners, for each largest override that a control may plan them for.
fn with_circles(planner: &Machine) -> Vec<Machine> {
    let mut machine = planner.clone();
    machine.interpolator.junction = Junction::AccelerationBlend;
    MAX_OVERRIDE.guesses_on(&machine)
}

/// Returns the machine with parabolas at corners.
fn with_parabolas(planner: &Machine) -> Machine {
    let mut machine = planner.clone();
    machine.interpolator.junction = Junction::ParabolicBlend;
    machine
}

/// Returns the planner with the rapids limited as its family limits them, by each axis or along the path. Rapids are
/// as fast as recorded or, if no positions were recorded, as fast as in the machine file and with the filters.
fn with_rapids(
    family: Planner,
    planner: &Machine,
    machine: &Machine,
    fitted: &Machine,
    seen: Option<RapidPlateaus>,
) -> Vec<Machine> {
    let rates = [machine.fastest_rapid(), fitted.fastest_rapid()];
    let told = rates.map(|rate| {
        let rates = RapidRates { path: Some(rate), axes: [Some(rate); 3], guessed_axes: [false; 3] };
        RapidPlateaus::default().with_rates(|_| rates)
    });
    let plateaus = seen.map_or(told.to_vec(), |seen| vec![seen]);
    // Klipper's rapids are moves with a feedrate like any other; the others run each axis at its own rate.
    // Its minimum cruise ratio also holds the velocity of rapids that are too short for their rate.
    let of = |seen: &RapidPlateaus| match family {
        Planner::SquareCorner => {
            let unknown = seen.with_rates(RapidRates::without_path);
            let all = [Some(*seen), seen.rates.path.map(|_| unknown)];
            all.into_iter().flatten().map(|seen| seen.limited_along_path(planner, machine)).collect()
        }
        _ => vec![seen.limited_by_axis(planner, machine)],
    };
    let mut machines: Vec<Machine> = plateaus.iter().flat_map(of).collect();
    machines.iter_mut().for_each(|machine| limit_feed_as_rapids(machine, seen));
    machines
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identification::alignment::recorded;
    use crate::identification::calibration::whitened;

    fn square_corner(acceleration: f64) -> Machine {
        let mut machine = Machine::default();
        machine.become_planner(Planner::SquareCorner, acceleration);
        machine
    }

    /// Long lines with corners at their ends: a ramp twice as steep from a corner that is slower takes about as long.
    #[test]
    fn guesses_lie_on_both_sides_of_an_acceleration() {
        let truth = square_corner(3000.0).with_scaled_junction(2.5);
        let program = format!("G1 F6000\n{}", "X17.8\nY0.3\nX0\nY0\n".repeat(8));
        let (toolpath, alignment) = recorded(&program, &truth, 1e-4);
        let runs = [Run { toolpath: &toolpath, alignment: &alignment, overrides: (None, None) }];
        let whitenings = whitened(&truth, &runs);
        let grid: Vec<Vec<Machine>> =
            PLANNER_ACCELERATION.guesses.iter().map(|of| vec![square_corner(*of)]).collect();
        let machine = &truth;
        let (fitted, whitenings) = (machine, &whitenings);
        let guessing = Guessing {
            machine,
            fitted,
            runs: &runs,
            whitenings,
            plateaus: None,
            held: HeldAccelerations::default(),
        };
        for from in [&grid[0][0], &grid[9][0]] {
            let found = guessing.nearest_with_corners(&grid, from);
            let accelerations = found.iter().map(|machine| machine.path.acceleration).collect::<Vec<_>>();
            assert_eq!(accelerations, [2500.0, 5000.0]);
        }
        let limited = vec![vec![square_corner(500.0)]; 3];
        assert_eq!(guessing.nearest_with_corners(&limited, &limited[1][0]).len(), 1);
    }

    /// Axes never reach the corner velocity of the start, so the cost does not depend on that; and a fit does not free a cruise
    /// ratio of 0.
    #[test]
    fn what_a_fit_cannot_leave_is_chosen_again() {
        let truth = square_corner(1000.0);
        let program = format!("G1 F6000\n{}", "X6\nY6\nX0\nY0\n".repeat(8));
        let (toolpath, alignment) = recorded(&program, &truth, 1e-4);
        let runs = [Run { toolpath: &toolpath, alignment: &alignment, overrides: (None, None) }];
        let whitenings = whitened(&truth, &runs);
        let mut without_ratio = truth.clone();
        without_ratio.interpolator.minimum_cruise_ratio = 0.0;
        let fast_corners = truth.with_scaled_junction(1.0 / JUNCTION_RATIOS[0]);
        for start in [&fast_corners, &without_ratio] {
            let found = chosen_again(start, &runs, &whitenings).expect("the runs show corners and cruises");
            let Junction::SquareCorner(velocity) = found.interpolator.junction else { panic!("another law") };
            assert!((velocity - 5.0).abs() < 1e-9, "{velocity}");
            assert_eq!(found.interpolator.minimum_cruise_ratio, KLIPPER_MIN_CRUISE_RATIO);
        }
        assert_eq!(chosen_again(&truth, &runs, &whitenings), None);
        // Without the ratio, the acceleration lies between those of short and of long moves.
        without_ratio.path.acceleration = 700.0;
        let found = chosen_again(&without_ratio, &runs, &whitenings).expect("the runs show cruises");
        assert_eq!(found.interpolator.minimum_cruise_ratio, KLIPPER_MIN_CRUISE_RATIO);
        assert!(
            (found.path.acceleration - 700.0 * 2.0_f64.sqrt()).abs() < 1e-9,
            "{}",
            found.path.acceleration
        );
    }
}
