//! Shape of ramps: the part of the recorded changes of feedrate that a simulation does not explain, whatever the time
//! lost.
//!
//! A recording consists of windows of [`WINDOW_S`], or of [`MIN_ROWS`] rows if these last longer. In each window
//!
//! ```text
//! misfit² = Σ ((e − a − b v)² − σ²) / Σ (s − c − d t)²
//! ```
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | e | recorded less simulated position, along the motion | mm |
//! | v, s | simulated velocity and distance along the path | mm/s, mm |
//! | t | simulated time | s |
//! | σ | noise of positions | mm |
//! | a, b | shift and delay of the window, by least squares | mm, s |
//! | c, d | motion at constant velocity, by least squares | mm, mm/s |
//!
//! Within a ramp the misfit is the relative error of the simulated acceleration. It is 0 if each ramp has its
//! recorded shape. The misfit of a run is the median over its windows, weighted by the denominator, so that a few
//! places at which the simulation is far off do not change it; for the misfit of an axis, by the part of it that the axis
//! has in the motion of the window. A window is compared at the time lost up to its middle, one
//! for all its rows: the lost times of single marks scatter by milliseconds at blended corners, which would be steps of
//! the position there. Limits: a window that is longer than a ramp dilutes its misfit.

use crate::identification::alignment::Alignment;
use crate::identification::comparison::Comparison;
use crate::identification::comparison::contour_deviation::{PositionDifference, SimulatedClock};
use crate::machine::{MAX_RAMP_MISFIT, Machine};
use crate::simulation::drive::AxisMotion;
use crate::simulation::feed::FeedPlan;
use crate::simulation::ordered::weighted_median;
use crate::simulation::profile::{Profile, Resolution};
use crate::simulation::toolpath::Toolpath;

/// Duration of a window, s: shorter than most ramps, and long enough for noise of micrometres.
const WINDOW_S: f64 = 1.0 / 15.0;
/// Duration above which a window shows no ramp, s.
const MAX_WINDOW_S: f64 = 0.5;
/// Least number of rows of a window.
const MIN_ROWS: usize = 8;
/// Largest number of rows of a run that are compared.
const MAX_ROWS: usize = 16_000;

/// The misfit of the ramps of runs, which is the relative error of their accelerations; `None` if no window shows it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RampMisfit {
    /// Misfit of all ramps.
    pub of_path: Option<f64>,
    /// Misfit of the ramps of X, Y and Z.
    pub of_axes: [Option<f64>; 3],
}

impl RampMisfit {
    /// Returns the misfit of runs, given all their windows.
    pub fn of(windows: &[RampWindow]) -> RampMisfit {
        let median = |part: &dyn Fn(&RampWindow) -> f64| {
            let weighted = windows.iter().map(|window| (window.misfit_square, window.change * part(window)));
            weighted_median(weighted.filter(|(_, weight)| 0.0 < *weight).collect()).map(f64::sqrt)
        };
        RampMisfit {
            of_path: median(&|_| 1.0),
            of_axes: [0, 1, 2].map(|axis| median(&|window| window.of_axes[axis])),
        }
    }

    /// Returns `true` if ramps have the recorded shape, or if no window shows it.
    pub fn is_of_law(&self) -> bool {
        self.is_within(MAX_RAMP_MISFIT)
    }

    /// Returns `true` if the misfit of all ramps is at most `limit`, or if no window shows it.
    pub fn is_within(&self, limit: f64) -> bool {
        self.of_path.is_none_or(|misfit| misfit <= limit)
    }
}

/// The misfit of one window of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RampWindow {
    /// Squared misfit.
    misfit_square: f64,
    /// Simulated change from motion at constant velocity, Σ (s − c − d t)², mm²: the weight of the window.
    change: f64,
    /// Parts of the axes in the sum of the squared velocities.
    of_axes: [f64; 3],
}

/// Returns the misfit of each window of a run; empty if positions were not recorded or too seldom. `comparison` compares
/// the run with `plan`.
pub fn ramp_windows(
    toolpath: &Toolpath,
    plan: &FeedPlan,
    machine: &Machine,
    alignment: &Alignment,
    comparison: &Comparison,
) -> Vec<RampWindow> {
    let clock = SimulatedClock::new(&alignment.marks, &comparison.simulated, &comparison.residuals);
    let (Some(track), Some(mut clock)) = (&alignment.track, clock) else { return Vec::new() };
    let rows = ((WINDOW_S / track.interval) as usize).max(MIN_ROWS);
    if MAX_WINDOW_S < rows as f64 * track.interval {
        return Vec::new();
    }
    let samples = Profile::new(toolpath, plan).samples(Resolution::MOTION);
    let motion = [0, 1, 2].map(|axis| AxisMotion::of(&samples, machine, axis));
    let every = alignment.fixes.len().div_ceil(MAX_ROWS).max(1);
    let mut near = [0; 3];
    let mut found = Vec::new();
    for fixes in alignment.fixes.chunks_exact(rows).step_by(every) {
        let mut window = Window::default();
        let middle = fixes[rows / 2].time;
        let lost = middle - clock.at(middle);
        for fix in fixes {
            let Some(sample) = fix.sample else { continue };
            let (time, position) = (fix.time - lost, track.position[sample].into());
            let e = PositionDifference::of(&motion, track.recorded, time, &position, &mut near);
            let velocity = e.speed_square().sqrt();
            window.add_squares(e.velocity_squares);
            window.push(time, velocity, if 0.0 < velocity { e.along / velocity } else { 0.0 });
        }
        found.extend(window.misfit(track.noise));
    }
    found
}

/// The rows of a window: time (s), velocity and distance of the simulation, and the recorded position ahead of it (mm), with
/// the sums of the squared velocities of the axes, mm²/s².
#[derive(Default)]
struct Window {
    velocity_squares: [f64; 3],
    time: Vec<f64>,
    velocity: Vec<f64>,
    distance: Vec<f64>,
    ahead: Vec<f64>,
}

impl Window {
    /// Adds a row at a simulated time (s), with the simulated velocity (mm/s) and by how far the recorded position is
    /// ahead (mm).
    fn push(&mut self, time: f64, velocity: f64, ahead: f64) {
        let before = self.time.last().zip(self.velocity.last()).zip(self.distance.last());
        let distance = before.map_or(0.0, |((time_before, velocity_before), distance)| {
            distance + 0.5 * (velocity + velocity_before) * (time - time_before)
        });
        self.time.push(time);
        self.velocity.push(velocity);
        self.distance.push(distance);
        self.ahead.push(ahead);
    }

    /// Adds the squared velocities of the axes at a row, mm²/s².
    fn add_squares(&mut self, velocity_squares: [f64; 3]) {
        self.velocity_squares.iter_mut().zip(velocity_squares).for_each(|(sum, square)| *sum += square);
    }

    /// Returns the misfit at this noise of positions (mm); `None` if the feedrate of the window does not change.
    fn misfit(&self, noise: f64) -> Option<RampWindow> {
        let change = squares_about_line(&self.time, &self.distance);
        let of_noise = noise * noise * (self.time.len() as f64 - 2.0);
        let left = (squares_about_line(&self.velocity, &self.ahead) - of_noise).max(0.0);
        let all = self.velocity_squares.iter().sum::<f64>();
        let of_axes = self.velocity_squares.map(|square| if 0.0 < all { square / all } else { 0.0 });
        (of_noise < change).then(|| RampWindow { misfit_square: left / change, change, of_axes })
    }
}

/// Returns the sum of the squared distances of `y` from its regression line over `x`.
fn squares_about_line(x: &[f64], y: &[f64]) -> f64 {
    let count = x.len().max(1) as f64;
    let [mean_x, mean_y] = [x, y].map(|values| values.iter().sum::<f64>() / count);
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for (x, y) in x.iter().zip(y) {
        let (x, y) = (x - mean_x, y - mean_y);
        xx += x * x;
        xy += x * y;
        yy += y * y;
    }
    if 0.0 < xx { (yy - xy * xy / xx).max(0.0) } else { yy }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Distance (mm) and velocity (mm/s) at a time (s) of a ramp from 0 to 50 mm/s around 0.
    type Ramp = fn(time: f64, duration: f64) -> (f64, f64);

    const FEEDRATE: f64 = 50.0;

    fn linear(time: f64, duration: f64) -> (f64, f64) {
        let part = (time / duration + 0.5).clamp(0.0, 1.0);
        let after = (time - 0.5 * duration).max(0.0);
        (FEEDRATE * (0.5 * part * part * duration + after), FEEDRATE * part)
    }

    /// A ramp whose acceleration rises and falls linearly: constant jerk.
    fn s_curve(time: f64, duration: f64) -> (f64, f64) {
        let part = (time / duration + 0.5).clamp(0.0, 1.0);
        let after = (time - 0.5 * duration).max(0.0);
        let (way, velocity) = if part < 0.5 {
            (2.0 / 3.0 * part.powi(3), 2.0 * part * part)
        } else {
            let left = 1.0 - part;
            (part - 0.5 + 2.0 / 3.0 * left.powi(3), 1.0 - 2.0 * left * left)
        };
        (FEEDRATE * (way * duration + after), FEEDRATE * velocity)
    }

    /// The misfit of simulated ramps to recorded ones, each with its duration (s), at the places that a window may have.
    fn misfit((recorded, lasts): (Ramp, f64), (simulated, simulated_lasts): (Ramp, f64)) -> f64 {
        let windows = (0..24).filter_map(|place| {
            let mut window = Window::default();
            let from = 0.02 * f64::from(place) - 0.25;
            for row in 0..=16 {
                let time = from + 0.004 * f64::from(row);
                let (distance, velocity) = simulated(time, simulated_lasts);
                window.push(time, velocity, recorded(time, lasts).0 - distance);
            }
            window.misfit(0.0)
        });
        RampMisfit::of(&windows.collect::<Vec<_>>()).of_path.expect("the feedrate changes")
    }

    #[test]
    fn trapezoids_are_told_from_ramps_of_constant_jerk() {
        for lasts in [0.1, 0.2, 0.4] {
            let trapezoids = (60..130).map(|percent| (linear as Ramp, 0.01 * f64::from(percent) * lasts));
            let nearest = trapezoids.map(|trapezoid| misfit((s_curve, lasts), trapezoid));
            let nearest = nearest.fold(f64::INFINITY, f64::min);
            assert!(MAX_RAMP_MISFIT < nearest, "{nearest} for {lasts} s");
        }
    }

    #[test]
    fn an_acceleration_may_be_off_by_a_twentieth() {
        for lasts in [0.05, 0.1, 0.2, 0.4] {
            let off = misfit((linear, lasts), (linear, 1.05 * lasts));
            assert!(off < MAX_RAMP_MISFIT, "{off} for {lasts} s");
            assert_eq!(misfit((linear, lasts), (linear, lasts)), 0.0);
        }
    }
}
