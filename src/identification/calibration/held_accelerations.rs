//! The accelerations that the ramps and the arcs of a recording hold.
//!
//! A planner that is limited in acceleration ramps at A (mm/s²), so that its velocity changes by A T from each of three
//! successive windows of T (s) to the next. If a distance may be off by e (mm), A may be off by 2 e / T². A ramp counts
//! if the path is straight, and if that error and the difference of the two changes are at most the part
//! [`MAX_DIFFERENCE_RATIO`] of A. If each axis has a limit, A is the limit of the axis that moves furthest. The median of all of them is a start for a fit, near enough to its minimum to distinguish the values of a junction
//! law: a start from a wrong acceleration ends in a minimum where fast corners make up for flat ramps.
//!
//! On an arc of radius r (mm) that is too tight for the programmed feedrate, Klipper keeps the velocity √(A r), because the
//! circle that touches two chords in their middles is the arc. The median of v² / r is a start, too: a fit from a larger
//! acceleration ends in a minimum where the law of corners limits the joints of chords.
//!
//! Limits: ramps shorter than three samples show no acceleration, nor does noise in fast sampling.

use crate::identification::alignment::{Track, median};
use crate::identification::calibration::rapid_moves::turns;
use crate::identification::calibration::rapids::largest_error;
use crate::identification::fit::Run;
use crate::identification::measured::centripetal_accelerations;
use crate::machine::{Machine, Planner};

/// Windows that are tried, samples.
const WINDOWS: [usize; 5] = [1, 2, 4, 8, 16];
/// Largest difference of the accelerations of a ramp, and their largest error, as a part of them.
const MAX_DIFFERENCE_RATIO: f64 = 0.05;
/// Least number of ramps, or of parts of them, or of arcs that show an acceleration.
const MIN_PLACES: usize = 10;

/// The accelerations that a recording holds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HeldAccelerations {
    /// `None` if too few ramps show them.
    ramps: Option<RampAccelerations>,
    /// Centripetal acceleration on arcs that are slower than programmed, mm/s²; `None` if there are too few.
    arcs: Option<f64>,
}

/// The accelerations that ramps hold, mm/s².
#[derive(Clone, Copy, Debug, PartialEq)]
struct RampAccelerations {
    /// Acceleration along the path where Z does not move furthest, or else where it does.
    along_path: f64,
    /// Acceleration of each axis where it moves furthest; `None` if too few ramps show it.
    axes: [Option<f64>; 3],
}

/// A part of a ramp.
#[derive(Clone, Copy, Debug, PartialEq)]
struct RampPart {
    /// Acceleration along the path, mm/s².
    along_path: f64,
    /// Axis that moves furthest.
    axis: usize,
    /// Its part of the velocity.
    share: f64,
}

impl HeldAccelerations {
    /// Returns the accelerations that runs hold.
    pub fn of(runs: &[Run]) -> HeldAccelerations {
        let tracks = runs.iter().filter_map(|run| run.alignment.track.as_ref());
        let ramps: Vec<RampPart> = tracks.flat_map(|track| ramps(track)).collect();
        let of_arcs = runs.iter().flat_map(centripetal_accelerations).collect();
        HeldAccelerations { ramps: RampAccelerations::of(&ramps), arcs: median_of_enough(of_arcs) }
    }

    /// Returns `true` if ramps hold an acceleration.
    pub fn shows_ramps(&self) -> bool {
        self.ramps.is_some()
    }

    /// Returns the machine as planners of a family with the accelerations that ramps hold and, in Klipper's family, that arcs
    /// hold, unless its limits are lower.
    pub fn of_planner(&self, planner: Planner, machine: &Machine) -> Vec<Machine> {
        let keeps_centripetal = planner == Planner::SquareCorner;
        let arcs = self.arcs.filter(|_| keeps_centripetal);
        let arcs = arcs.map(|along_path| RampAccelerations { along_path, axes: [None; 3] });
        self.ramps.into_iter().chain(arcs).map(|held| held.of_planner(planner, machine)).collect()
    }
}

impl RampAccelerations {
    fn of(ramps: &[RampPart]) -> Option<RampAccelerations> {
        let axes = [0, 1, 2].map(|axis| {
            let of_axis = ramps.iter().filter(|ramp| ramp.axis == axis);
            median_of_enough(of_axis.map(|ramp| ramp.along_path * ramp.share).collect())
        });
        let along = |is_of_z: bool| {
            let of_axes = ramps.iter().filter(|ramp| (ramp.axis == 2) == is_of_z);
            median_of_enough(of_axes.map(|ramp| ramp.along_path).collect())
        };
        let along_path = along(false).or_else(|| along(true))?;
        Some(RampAccelerations { along_path, axes })
    }

    /// Returns the machine as a planner of a family with these accelerations, unless its limits are lower.
    fn of_planner(&self, planner: Planner, machine: &Machine) -> Machine {
        let mut of = machine.clone();
        of.become_planner(planner, f64::INFINITY);
        let of_axes = self.axes.map(|held| held.unwrap_or(self.along_path));
        of.limit_accelerations(planner, self.along_path, of_axes);
        of
    }
}

/// Returns the median of accelerations; `None` if there are too few.
fn median_of_enough(mut accelerations: Vec<f64>) -> Option<f64> {
    (MIN_PLACES <= accelerations.len()).then(|| median(&mut accelerations))
}

/// Returns the accelerations of the ramps of a track.
fn ramps(track: &Track) -> Vec<RampPart> {
    let error = largest_error(track);
    let all = successive_windows(track, &WINDOWS, 3);
    all.filter_map(|(begin, window)| ramp(track, begin, window, error)).collect()
}

/// Returns every place of a track where `count` successive windows of one of these lengths (samples) begin, with the length.
pub fn successive_windows<'a>(
    track: &'a Track,
    windows: &'a [usize],
    count: usize,
) -> impl Iterator<Item = (usize, usize)> + 'a {
    windows.iter().flat_map(move |&window| {
        let end = track.time.len().saturating_sub(count * window);
        (0..end).step_by(window).map(move |begin| (begin, window))
    })
}

/// Returns the acceleration from the sample `begin` on, over three windows of `window` samples; `None` if it is not held, or if
/// distances that are off by `error` (mm) hide it.
fn ramp(track: &Track, begin: usize, window: usize, error: f64) -> Option<RampPart> {
    let velocities = track.successive_velocities(begin, window);
    let seconds = (track.time[begin + 3 * window] - track.time[begin]) / 3.0;
    let [first, second, third] = velocities.map(|velocity| velocity.norm());
    let [before, after] = [(second - first) / seconds, (third - second) / seconds];
    let held = 0.5 * (before + after).abs();
    let largest_difference = MAX_DIFFERENCE_RATIO * held;
    let is_held =
        (before - after).abs() <= largest_difference && 2.0 * error <= largest_difference * seconds.powi(2);
    let axis = velocities[1].iamax();
    let share = velocities[1][axis].abs() / second;
    (0.0 < held && is_held && !turns(&velocities)).then_some(RampPart { along_path: held, axis, share })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation::toolpath::{Point, Vector};

    const INTERVAL_S: f64 = 0.004;

    /// Returns a track of moves from rest to rest, each along an axis at an acceleration (mm/s²) for half of its time (s);
    /// positions are off by up to `error` (mm).
    fn track(moves: &[(usize, f64, f64)], error: f64) -> Track {
        let (mut time, mut position, mut at) = (Vec::new(), Vec::new(), Point::origin());
        for (axis, acceleration, seconds) in moves {
            for sample in 0..(seconds / INTERVAL_S) as usize {
                let elapsed = INTERVAL_S * sample as f64;
                let ramp = |seconds: f64| 0.5 * acceleration * seconds * seconds;
                let travel = match elapsed.min(seconds - elapsed) {
                    left if left == elapsed => ramp(elapsed),
                    left => 2.0 * ramp(0.5 * seconds) - ramp(left),
                };
                let noise = if time.len() % 2 == 0 { error } else { -error };
                time.push(INTERVAL_S * time.len() as f64);
                position.push(at + Vector::ith(*axis, travel + noise));
            }
            at[*axis] += 0.5 * acceleration * seconds * seconds / 2.0;
        }
        Track { time, position, recorded: [true; 3], noise: error, interval: INTERVAL_S, steps: [0.0; 3] }
    }

    /// Returns the accelerations of a track.
    fn held(track: &Track) -> Option<RampAccelerations> {
        RampAccelerations::of(&ramps(track))
    }

    #[test]
    fn ramps_hold_the_acceleration_of_each_axis() {
        let moves = [(0, 980.0, 0.2), (1, 980.0, 0.3), (2, 300.0, 0.3), (0, 980.0, 0.25), (2, 300.0, 0.2)];
        let found = held(&track(&moves, 1e-6)).expect("there are ramps");
        let near = |own: f64, truth: f64| (own / truth - 1.0).abs() < 0.01;
        assert!(near(found.along_path, 980.0), "{found:?}");
        for (own, truth) in found.axes.into_iter().zip([980.0, 980.0, 300.0]) {
            assert!(own.is_some_and(|own| near(own, truth)), "{found:?}");
        }
        // Without moves in X and Y the path has the acceleration of Z.
        let of_z = held(&track(&[moves[2], moves[4]], 1e-6)).expect("there are ramps");
        assert!(near(of_z.along_path, 300.0) && of_z.axes[..2] == [None; 2], "{of_z:?}");
    }

    #[test]
    fn noise_and_short_ramps_show_no_acceleration() {
        assert_eq!(held(&track(&[(0, 980.0, 0.2), (1, 980.0, 0.2)], 0.5)), None);
        assert_eq!(held(&track(&[(0, 980.0, 0.01), (1, 980.0, 0.01)], 1e-6)), None);
        assert_eq!(held(&track(&[], 0.0)), None);
    }

    #[test]
    fn a_family_has_them_unless_its_limits_are_lower() {
        let held = RampAccelerations { along_path: 980.0, axes: [Some(900.0), None, Some(300.0)] };
        let mut machine = Machine::default();
        machine.axes[0].acceleration = 500.0;
        let grbl = held.of_planner(Planner::JunctionDeviation, &machine);
        assert_eq!(grbl.axes.map(|axis| axis.acceleration), [500.0, 980.0, 300.0]);
        let klipper = held.of_planner(Planner::SquareCorner, &machine);
        assert_eq!((klipper.path.acceleration, klipper.axes[2].acceleration), (980.0, 300.0));
    }

    #[test]
    fn planners_with_square_corners_have_that_of_arcs_too() {
        let held = HeldAccelerations { ramps: None, arcs: Some(670.0) };
        assert!(!held.shows_ramps());
        let [start] = &held.of_planner(Planner::SquareCorner, &Machine::default())[..] else {
            panic!("{held:?}")
        };
        assert_eq!(start.path.acceleration, 670.0);
        assert!(held.of_planner(Planner::JunctionDeviation, &Machine::default()).is_empty());
    }
}
