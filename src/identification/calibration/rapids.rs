//! How fast rapids were: the recorded velocity where it is the same for a while.
//!
//! A rapid that shows a plateau was as fast as the machine lets it; one that speeds up and slows down without one says only
//! that the machine is no slower. The mean velocities over three windows of [`WINDOW_S`] one after another, on one rapid
//! segment, are the same to the part [`PLATEAU`] on a plateau; of two windows they are also where a ramp up meets a ramp
//! down in the middle. A ramp of the acceleration A changes them by A `WINDOW_S`, which is more wherever A matters.

use crate::identification::alignment::Fix;
use crate::identification::fit::Run;
use crate::machine::Machine;
use crate::simulation::toolpath::{Motion, Vector};

/// A window over which a velocity is taken, s, and samples in it at least.
const WINDOW_S: f64 = 0.02;
const MIN_SAMPLES: usize = 4;
/// Part by which the velocity may change on a plateau.
const PLATEAU: f64 = 0.005;

/// The rapid velocities of plateaus, mm/s; `None` where there is none.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RapidPlateaus {
    /// Along the path.
    pub path: Option<f64>,
    /// Of each axis.
    pub axes: [Option<f64>; 3],
}

impl RapidPlateaus {
    /// The fastest plateaus of the runs; `None` where no run has positions.
    pub fn of(runs: &[Run]) -> Option<RapidPlateaus> {
        let mut seen = RapidPlateaus::default();
        let with_positions = runs.iter().filter(|run| run.alignment.track.is_some());
        let count = with_positions.map(|run| seen.take(run)).count();
        (0 < count).then_some(seen)
    }

    fn take(&mut self, run: &Run) {
        let Some(track) = &run.alignment.track else { return };
        let window = ((WINDOW_S / track.interval).ceil() as usize).max(MIN_SAMPLES);
        let distances = run.toolpath.distances();
        let segment = |fix: &Fix| distances.partition_point(|at| *at <= fix.distance).saturating_sub(1);
        for fixes in run.alignment.fixes.windows(3 * window + 1).step_by(window.div_ceil(2)) {
            let (begin, end) = (&fixes[0], &fixes[3 * window]);
            let (Some(first), Some(last)) = (begin.sample, end.sample) else { continue };
            let index = segment(begin);
            let is_one = index == segment(end) && last - first == 3 * window;
            if !is_one
                || index >= run.toolpath.segments.len()
                || run.toolpath.segments.motion(index) != Motion::Rapid
            {
                continue;
            }
            let velocities = [0, 1, 2].map(|part| {
                let (from, to) = (first + part * window, first + (part + 1) * window);
                (track.position[to] - track.position[from]) / (track.time[to] - track.time[from])
            });
            self.add(velocities);
        }
    }

    /// The velocities of three windows one after another.
    fn add(&mut self, velocities: [Vector; 3]) {
        let plateau = |[before, within, after]: [f64; 3]| {
            let is_same = |other: f64| (other - within).abs() <= PLATEAU * within;
            (0.0 < within && is_same(before) && is_same(after)).then_some(within)
        };
        let faster = |own: &mut Option<f64>, found: Option<f64>| {
            *own = [*own, found].into_iter().flatten().reduce(f64::max);
        };
        faster(&mut self.path, plateau(velocities.map(|velocity| velocity.norm())));
        // Of a diagonal the axis that is faster may be at its limit; the others only keep up with it.
        let axis = velocities[1].iamax();
        faster(&mut self.axes[axis], plateau(velocities.map(|velocity| velocity[axis].abs())));
    }

    /// Machines whose rapids are limited so, by each axis and along the path. What showed no plateau is as fast as the
    /// fastest that did, or as the machine file says.
    pub fn given(&self, machine: &Machine, file: &Machine) -> [Machine; 2] {
        let fastest = self.axes.iter().flatten().copied().reduce(f64::max);
        let (mut by_axis, mut along_path) = (machine.clone(), machine.clone());
        by_axis.rapid.feedrate = f64::INFINITY;
        for (axis, seen) in by_axis.axes.iter_mut().zip(self.axes) {
            axis.rapid = seen.or(fastest).unwrap_or(axis.rapid.min(file.rapid.feedrate));
        }
        along_path.rapid.feedrate = self.path.unwrap_or(file.fastest_rapid());
        along_path.axes.iter_mut().for_each(|axis| axis.rapid = f64::INFINITY);
        [by_axis, along_path]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seen(velocities: [[f64; 3]; 3]) -> RapidPlateaus {
        let mut seen = RapidPlateaus::default();
        seen.add(velocities.map(|[x, y, z]| Vector::new(x, y, z)));
        seen
    }

    #[test]
    fn a_velocity_that_stays_is_that_of_the_path_and_of_its_fastest_axis() {
        let diagonal = seen([[-80.0, 60.0, 0.0], [-80.1, 60.0, 0.0], [-80.0, 60.1, 0.0]]);
        assert_eq!(diagonal.axes, [Some(80.1), None, None]);
        assert!(diagonal.path.is_some_and(|path| (path - 100.1).abs() < 0.1), "{diagonal:?}");
    }

    #[test]
    fn ramps_that_meet_are_no_plateau() {
        let peak = [[90.0, 0.0, 0.0], [95.0, 0.0, 0.0], [90.0, 0.0, 0.0]];
        let ramp = [[80.0, 0.0, 0.0], [90.0, 0.0, 0.0], [100.0, 0.0, 0.0]];
        let stand = [[0.0; 3]; 3];
        for velocities in [peak, ramp, stand] {
            assert_eq!(seen(velocities), RapidPlateaus::default());
        }
    }
}
