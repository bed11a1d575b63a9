//! Points of a probe: the recording of a machine on a snippet, and the separation of two causes by
//! recordings.

use std::sync::Arc;

use crate::identification::alignment::{Alignment, Method, ProgramPlace, Track, simulated_marks};
use crate::identification::effects::Hypothesis;
use crate::identification::fit::{Run, Whitening};
use crate::identification::probe::STAMP_DEVIATION_S;
use crate::machine::Machine;
use crate::simulation::drive::actual_motion;
use crate::simulation::feed::FeedPlan;
use crate::simulation::gcode::read;
use crate::simulation::interpreter::trace;
use crate::simulation::ordered::sort_by_number;
use crate::simulation::profile::{Profile, Resolution, Samples};
use crate::simulation::simulate;
use crate::simulation::toolpath::{Point, Toolpath, Vector};

/// Time between two marks, s.
const MARK_INTERVAL_S: f64 = 8e-3;
/// Most marks of a program.
const MAX_MARKS: f64 = 20_000.0;
/// Noise of a recorded coordinate, mm.
const POSITION_NOISE_MM: f64 = 2e-3;
/// Process noise, s/√s.
const PROCESS_NOISE: f64 = 1e-3;
/// Points of a curve between two trials.
const POINTS_BETWEEN_TRIALS: usize = 3;
/// Least distance by which a visible cause moves the point of all snippets together, in standard deviations.
const MIN_VISIBLE_SIGMAS: f64 = 3.0;

/// A snippet on the assumed machine, with the marks at which other machines are compared.
pub struct ProbeTrial {
    toolpath: Toolpath,
    alignment: Alignment,
    /// Assumed machine without its drives, and its command.
    undriven: Machine,
    commanded: Samples,
    whitening: Whitening,
    seconds: f64,
    /// Times at which positions are compared, s, with the velocities there, mm/s.
    instants: Vec<(f64, Vector)>,
}

impl ProbeTrial {
    /// Returns the trial of a program.
    pub fn new(machine: &Machine, program: &str) -> ProbeTrial {
        let toolpath = trace(&read(program.as_bytes()), machine);
        let plan = simulate(&toolpath, machine);
        let profile = Profile::new(&toolpath, &plan);
        let seconds = profile.cycle_time();
        let interval = MARK_INTERVAL_S.max(seconds / MAX_MARKS);
        let count = (seconds / interval) as usize;
        let states: Vec<_> =
            (1..count).map(|at| (interval * at as f64, profile.at_time(interval * at as f64))).collect();
        let length = profile.length();
        let mut places = vec![ProgramPlace::Start];
        let mut last = 0.0;
        let distances = toolpath.distances();
        let mut stop = 0;
        let mut pass = |until: f64, places: &mut Vec<ProgramPlace>| {
            while stop < toolpath.stops.len() && distances[toolpath.stops[stop].after] <= until {
                places.extend([ProgramPlace::Stop(stop), ProgramPlace::After(stop)]);
                stop += 1;
            }
        };
        for (_, state) in &states {
            pass(state.distance - 1e-6, &mut places);
            // The machine rests at a stop or turns a rotary axis.
            if last + 1e-4 < state.distance && state.distance < length - 1e-4 {
                places.push(ProgramPlace::Along(state.distance));
                last = state.distance;
            }
        }
        pass(f64::INFINITY, &mut places);
        let marks = simulated_marks(&toolpath, &plan, places, STAMP_DEVIATION_S);
        let track = Track {
            steps: [0.0; 3],
            time: states.iter().map(|(time, _)| *time).collect(),
            position: states.iter().map(|(_, state)| state.position).collect::<Vec<Point>>(),
            recorded: [true; 3],
            noise: POSITION_NOISE_MM,
            interval: 0.5 * STAMP_DEVIATION_S.max(4e-3),
        };
        let instants = states.iter().map(|(time, state)| (*time, state.velocity)).collect();
        let alignment = Alignment {
            track: Some(Arc::new(track)),
            ..Alignment::of_marks(Method::Positions, 0.0..seconds, marks, length)
        };
        let whitening = Whitening::new(&alignment, PROCESS_NOISE);
        let (undriven, commanded) = (without_drives(machine), commanded(&toolpath, &plan));
        ProbeTrial { toolpath, alignment, undriven, commanded, whitening, seconds, instants }
    }

    /// Borrows this trial as a [`Run`].
    pub fn run(&self) -> Run<'_> {
        Run { toolpath: &self.toolpath, alignment: &self.alignment, overrides: (None, None) }
    }

    /// Returns the duration, s.
    pub fn seconds(&self) -> f64 {
        self.seconds
    }

    /// Returns the times at places on a machine, in standard deviations.
    fn times(&self, machine: &Machine) -> Vec<f64> {
        self.whitening.apply(&self.run().residuals(machine))
    }

    /// Returns the positions at the compared times on a machine, in standard deviations, weighted less along
    /// the motion of the assumed machine than across it.
    fn positions(&self, machine: &Machine) -> Vec<f64> {
        // Drives do not change the command, and most parameters compared by positions belong to drives.
        let other = (without_drives(machine) != self.undriven)
            .then(|| commanded(&self.toolpath, &simulate(&self.toolpath, machine)));
        let commanded = other.as_ref().unwrap_or(&self.commanded);
        let actual = actual_motion(commanded, machine);
        let ratio = machine.recorder.clock_ratio;
        let mut seen = Vec::with_capacity(3 * self.instants.len());
        let mut slopes = Vec::with_capacity(3 * self.instants.len());
        let mut row = 0;
        for (time, velocity) in &self.instants {
            let (there, _) = actual.motion_at(time / ratio, &mut row);
            let speed = velocity.norm();
            let along = if 0.0 < speed { velocity / speed } else { Vector::zeros() };
            // A wrong stamp moves the position along the motion.
            let blurred = POSITION_NOISE_MM.hypot(speed * STAMP_DEVIATION_S);
            let split = |vector: Vector| {
                let part = along * along.dot(&vector);
                (vector - part) / POSITION_NOISE_MM + part / blurred
            };
            seen.extend(split(there).iter());
            slopes.extend(split(*velocity).iter());
        }
        // The common delay is unknown.
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let squares = dot(&slopes, &slopes);
        if 0.0 < squares {
            let delay = dot(&seen, &slopes) / squares;
            seen.iter_mut().zip(&slopes).for_each(|(seen, slope)| *seen -= delay * slope);
        }
        seen
    }
}

/// Returns the machine with axes that follow their command exactly.
fn without_drives(machine: &Machine) -> Machine {
    let mut machine = machine.clone();
    for axis in &mut machine.axes {
        *axis = axis.without_drive();
    }
    machine
}

/// Returns the command of a plan over time.
fn commanded(toolpath: &Toolpath, plan: &FeedPlan) -> Samples {
    Profile::new(toolpath, plan).samples(Resolution::MOTION)
}

/// One cause at one value against all values of another: for each chord of the other cause's curve, and each
/// snippet, |a|², a·b and |b|² of the differences a and b at the ends of the chord.
pub struct Separation {
    chords: Vec<Vec<[f64; 3]>>,
}

impl Separation {
    /// Returns the squared distance of the point from the curve on the `chosen` snippets together.
    pub fn squared(&self, chosen: &[usize]) -> f64 {
        let chord = |parts: &Vec<[f64; 3]>| {
            let [a, between, b] = chosen.iter().fold([0.0; 3], |sum, at| {
                let part = parts[*at];
                [sum[0] + part[0], sum[1] + part[1], sum[2] + part[2]]
            });
            let width = a - 2.0 * between + b;
            let share = if 0.0 < width { ((a - between) / width).clamp(0.0, 1.0) } else { 0.0 };
            let left = 1.0 - share;
            (left * left * a + 2.0 * left * share * between + share * share * b).max(0.0)
        };
        self.chords.iter().map(chord).fold(f64::INFINITY, f64::min)
    }
}

/// The separations of two causes, and the causes that have no visible effect.
pub struct CauseSeparations {
    /// All pairs of variants, in both directions.
    pub separations: Vec<Separation>,
    /// `true` for a cause without a visible variant.
    pub is_hidden: [bool; 2],
}

/// Returns all variants of each of two causes against the other.
pub fn separations(
    machine: &Machine,
    trials: &[ProbeTrial],
    sides: &[Vec<&Hypothesis>; 2],
    is_form: bool,
) -> CauseSeparations {
    let see = |machine: &Machine| -> Vec<Vec<f64>> {
        trials
            .iter()
            .map(|trial| if is_form { trial.positions(machine) } else { trial.times(machine) })
            .collect()
    };
    let base = see(machine);
    let curves = sides.each_ref().map(|side| {
        side.iter().map(|hypothesis| CauseCurve::of(machine, hypothesis, &see)).collect::<Vec<CauseCurve>>()
    });
    let typical = curves
        .each_ref()
        .map(|side| side.iter().filter_map(|curve| curve.typical(&base)).collect::<Vec<&Vec<Vec<f64>>>>());
    let mut separations = Vec::new();
    for side in 0..2 {
        for truth in &typical[side] {
            separations.extend(curves[1 - side].iter().map(|curve| curve.against(truth, &base)));
        }
    }
    CauseSeparations { separations, is_hidden: [typical[0].is_empty(), typical[1].is_empty()] }
}

/// The recordings of a cause at its values, in order, snippet by snippet.
struct CauseCurve {
    points: Vec<Vec<Vec<f64>>>,
    /// Indices of the trials.
    trials: Vec<usize>,
    is_continuous: bool,
}

impl CauseCurve {
    fn of(machine: &Machine, hypothesis: &Hypothesis, see: &dyn Fn(&Machine) -> Vec<Vec<f64>>) -> CauseCurve {
        let at = |values: &[f64]| see(&hypothesis.machine(machine, values));
        let (mut points, mut trials) = (Vec::new(), Vec::new());
        for (index, values) in hypothesis.trials.iter().enumerate() {
            trials.push(points.len());
            points.push(at(values));
            let Some(next) = hypothesis.trials.get(index + 1) else { continue };
            if !hypothesis.is_continuous() {
                continue;
            }
            let freed = &hypothesis.freed[0];
            let (low, high) = (freed.to_internal(values[0]), freed.to_internal(next[0]));
            for part in 1..=POINTS_BETWEEN_TRIALS {
                let mut there = values.clone();
                there[0] = freed
                    .from_internal(low + (high - low) * part as f64 / (POINTS_BETWEEN_TRIALS + 1) as f64);
                points.push(at(&there));
            }
        }
        CauseCurve { points, trials, is_continuous: hypothesis.is_continuous() }
    }

    /// Returns the trial at one third of the visible ones in the order of their strength; `None` if no trial
    /// is visible.
    fn typical(&self, base: &[Vec<f64>]) -> Option<&Vec<Vec<f64>>> {
        let strength = |point: &Vec<Vec<f64>>| -> f64 {
            point.iter().zip(base).map(|(own, base)| product(own, base, own, base)).sum::<f64>().sqrt()
        };
        let mut seen: Vec<(f64, usize)> = self
            .trials
            .iter()
            .map(|at| (strength(&self.points[*at]), *at))
            .filter(|(strength, _)| MIN_VISIBLE_SIGMAS < *strength)
            .collect();
        sort_by_number(&mut seen, |one| one.0);
        seen.get(seen.len() / 3).map(|(_, at)| &self.points[*at])
    }

    /// Returns the separation of a point of another cause from this curve, which includes the machine without
    /// a cause.
    fn against(&self, truth: &[Vec<f64>], base: &[Vec<f64>]) -> Separation {
        let chord = |a: &[Vec<f64>], b: &[Vec<f64>]| -> Vec<[f64; 3]> {
            let each = truth.iter().zip(a.iter().zip(b));
            each.map(|(w, (a, b))| [product(w, a, w, a), product(w, a, w, b), product(w, b, w, b)]).collect()
        };
        let mut chords = vec![chord(base, base)];
        if self.is_continuous {
            chords.extend(self.points.windows(2).map(|pair| chord(&pair[0], &pair[1])));
        }
        chords.extend(self.points.iter().map(|point| chord(point, point)));
        Separation { chords }
    }
}

/// Returns (a − b)·(c − d).
fn product(a: &[f64], b: &[f64], c: &[f64], d: &[f64]) -> f64 {
    let each = a.iter().zip(b).zip(c.iter().zip(d));
    each.map(|((a, b), (c, d))| (a - b) * (c - d)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The separation of the point (1, 1) from the chord between two points, seen on two snippets: a coordinate each.
    fn separation(a: [f64; 2], b: [f64; 2]) -> Separation {
        let point = [vec![1.0], vec![1.0]];
        let chord = (0..2).map(|snippet| {
            let (w, a, b) = (&point[snippet], &[a[snippet]], &[b[snippet]]);
            [product(w, a, w, a), product(w, a, w, b), product(w, b, w, b)]
        });
        Separation { chords: vec![chord.collect()] }
    }

    #[test]
    fn the_separation_is_the_distance_from_the_chord() {
        // From the diagonal of the unit square, between its ends.
        assert!((separation([0.0, 1.0], [1.0, 0.0]).squared(&[0, 1]) - 0.5).abs() < 1e-12);
        // Beyond the end of a chord it is the distance from that end.
        assert!((separation([0.0, 0.0], [-5.0, 0.0]).squared(&[0, 1]) - 2.0).abs() < 1e-12);
        // A chord of no length is a point, and a chord through the point leaves nothing.
        assert!((separation([0.0, 0.0], [0.0, 0.0]).squared(&[0, 1]) - 2.0).abs() < 1e-12);
        assert_eq!(separation([0.0, 0.0], [2.0, 2.0]).squared(&[0, 1]), 0.0);
        // On one snippet only its coordinate counts.
        assert!((separation([0.0, 7.0], [0.0, 9.0]).squared(&[0]) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn of_several_chords_the_nearest_counts() {
        let mut curve = separation([0.0, 0.0], [0.0, 0.0]);
        curve.chords.extend(separation([1.0, 0.0], [1.0, 0.5]).chords);
        assert!((curve.squared(&[0, 1]) - 0.25).abs() < 1e-12);
    }
}
