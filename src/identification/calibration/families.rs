//! Other families of controls: planners of trapezoids, where filters cannot tell what was recorded.
//!
//! Filters ramp in a constant time, whatever the step; planners that are limited in acceleration ramp in Δv/a. Each
//! family of [`Planner`] has its own law of corners ([`crate::simulation::feed::junction`]). The guess of a family is the
//! nearest of a grid: first of accelerations, the same for all axes, with rapids limited by each axis or along the path,
//! then of the value of its law of corners. Rapids begin at the fastest that was recorded, as no machine is faster than
//! that where it had room.

use crate::identification::calibration::nearest;
use crate::identification::fit::{Run, Whitening};
use crate::machine::{Machine, Planner};

/// Accelerations tried first, mm/s².
const ACCELERATIONS: [f64; 10] = [50.0, 100.0, 200.0, 350.0, 500.0, 800.0, 1300.0, 2500.0, 5000.0, 10_000.0];
/// Values of the law of corners tried first, as ratios of the usual one.
const CORNER_RATIOS: [f64; 7] = [0.05, 0.15, 0.4, 1.0, 2.5, 6.0, 20.0];
/// Time over which a recorded velocity is taken, s, and samples at least.
const VELOCITY_WINDOW: (f64, usize) = (0.02, 5);

/// The machine of each family that is nearest to the runs, before any fit. `machine` is as it was, `fitted` has the waits
/// and the rapid feed that filters need.
pub fn guesses(machine: &Machine, fitted: &Machine, runs: &[Run], whitenings: &[Whitening]) -> Vec<Machine> {
    let mut plain = fitted.clone();
    plain.interpolator.contour_tolerance = machine.interpolator.contour_tolerance;
    let rapids = rapids(machine, fitted, runs);
    let guess = |planner: Planner| {
        let at = |acceleration: f64| {
            let mut of = plain.clone();
            of.become_planner(planner, acceleration);
            of
        };
        let grid = ACCELERATIONS.into_iter().map(at).flat_map(|of| rapids.iter().map(move |own| own.given(&of)));
        let nearest_ramps = nearest(grid, runs, whitenings)?;
        let corners = CORNER_RATIOS.map(|ratio| nearest_ramps.with_scaled_junction(ratio));
        nearest(corners, runs, whitenings)
    };
    Planner::ALL.into_iter().filter_map(guess).collect()
}

/// What limits rapids: the path, and each axis, mm/s.
struct Rapids {
    path: f64,
    axes: [f64; 3],
}

impl Rapids {
    fn given(&self, machine: &Machine) -> Machine {
        let mut machine = machine.clone();
        machine.rapid.feedrate = self.path;
        machine.axes.iter_mut().zip(self.axes).for_each(|(axis, rapid)| axis.rapid = rapid);
        machine
    }
}

/// Ways in which rapids may be limited: by each axis at what was recorded of it or along the path; where no positions were
/// recorded, at what the machine file and the filters say.
fn rapids(machine: &Machine, fitted: &Machine, runs: &[Run]) -> Vec<Rapids> {
    let alone = [f64::INFINITY; 3];
    match fastest(runs) {
        Some((path, axes)) => {
            // An axis that hardly moves says nothing of its rapids: as fast as the fastest.
            let all = axes.iter().copied().fold(0.0, f64::max);
            let by_axis = axes.map(|own| if own < 0.5 * all { all } else { own });
            vec![Rapids { path: f64::INFINITY, axes: by_axis }, Rapids { path, axes: alone }]
        }
        None => {
            let rates = [machine.fastest_rapid(), fitted.fastest_rapid()];
            let ways = rates.map(|rate| {
                [Rapids { path: f64::INFINITY, axes: [rate; 3] }, Rapids { path: rate, axes: alone }]
            });
            ways.into_iter().flatten().collect()
        }
    }
}

/// The fastest recorded velocity along the path and of each axis, mm/s; `None` where no positions were recorded.
fn fastest(runs: &[Run]) -> Option<(f64, [f64; 3])> {
    let (mut path, mut axes) = (0.0f64, [0.0f64; 3]);
    for track in runs.iter().filter_map(|run| run.alignment.track.as_ref()) {
        let window = ((VELOCITY_WINDOW.0 / track.interval).ceil() as usize).max(VELOCITY_WINDOW.1);
        for first in 0..track.time.len().saturating_sub(window) {
            let last = first + window;
            let seconds = track.time[last] - track.time[first];
            // Where samples are missing a mean says nothing of the fastest.
            if seconds <= 0.0 || 2.0 * window as f64 * track.interval < seconds {
                continue;
            }
            let velocity = (track.position[last] - track.position[first]) / seconds;
            path = path.max(velocity.norm());
            axes.iter_mut().zip(velocity.iter()).for_each(|(axis, own)| *axis = axis.max(own.abs()));
        }
    }
    (0.0 < path).then_some((path, axes))
}
