//! What a recorder sees of a machine on a program, and how far apart two causes are by it.

use std::sync::Arc;

use crate::identification::alignment::{Alignment, Mark, Method, Place, Track};
use crate::identification::effects::Hypothesis;
use crate::identification::fit::{Run, Whitening};
use crate::identification::probe::STAMP;
use crate::machine::{Axis, Machine};
use crate::simulation::drive::actual_motion;
use crate::simulation::feed::FeedPlan;
use crate::simulation::gcode::read;
use crate::simulation::profile::{Profile, Resolution, Samples};
use crate::simulation::simulate;
use crate::simulation::toolpath::{Point, Toolpath, Vector, trace};

/// Time between two marks, s.
const INTERVAL: f64 = 8e-3;
/// Marks of a program at most.
const MOST_MARKS: f64 = 20_000.0;
/// Noise of a recorded coordinate, mm.
const POSITION: f64 = 2e-3;
/// What no model knows, s/√s.
const WANDER: f64 = 1e-3;
/// Points of a curve between two trials.
const BETWEEN: usize = 3;
/// A cause that moves the point by less on the whole bank is hidden, in standard deviations.
const SEEN: f64 = 3.0;

/// A program on the machine believed in, with the marks at which others are compared.
pub struct Bench {
    toolpath: Toolpath,
    alignment: Alignment,
    /// The machine believed in without its drives, and what it commands.
    undriven: Machine,
    commanded: Samples,
    whitening: Whitening,
    seconds: f64,
    /// Times at which positions are compared, s, with the velocities there, mm/s.
    instants: Vec<(f64, Vector)>,
}

impl Bench {
    /// The bench of a program.
    pub fn new(machine: &Machine, program: &str) -> Bench {
        let toolpath = trace(&read(program.as_bytes()), machine);
        let plan = simulate(&toolpath, machine);
        let profile = Profile::new(&toolpath, &plan);
        let seconds = profile.cycle_time();
        let interval = INTERVAL.max(seconds / MOST_MARKS);
        let count = (seconds / interval) as usize;
        let states: Vec<_> =
            (1..count).map(|at| (interval * at as f64, profile.at_time(interval * at as f64))).collect();
        let length = profile.length();
        let mut places = vec![Place::Start];
        let mut last = 0.0;
        let distances = toolpath.distances();
        let mut stop = 0;
        let mut pass = |until: f64, places: &mut Vec<Place>| {
            while stop < toolpath.stops.len() && distances[toolpath.stops[stop].after] <= until {
                places.extend([Place::Stop(stop), Place::After(stop)]);
                stop += 1;
            }
        };
        for (_, state) in &states {
            pass(state.distance - 1e-6, &mut places);
            // Where it stands there is a stop, or it turns.
            if last + 1e-4 < state.distance && state.distance < length - 1e-4 {
                places.push(Place::Along(state.distance));
                last = state.distance;
            }
        }
        pass(f64::INFINITY, &mut places);
        let times = crate::identification::alignment::times(&toolpath, &plan, &places);
        let mark = |(place, time): (Place, f64)| Mark { place, time, deviation: STAMP };
        let marks: Vec<Mark> = places.into_iter().zip(times).map(mark).collect();
        let track = Track {
            time: states.iter().map(|(time, _)| *time).collect(),
            position: states.iter().map(|(_, state)| state.position).collect::<Vec<Point>>(),
            recorded: [true; 3],
            noise: POSITION,
            interval: 0.5 * STAMP.max(4e-3),
        };
        let instants = states.iter().map(|(time, state)| (*time, state.velocity)).collect();
        let alignment = Alignment {
            method: Method::Positions,
            run: 0.0..seconds,
            marks,
            fixes: Vec::new(),
            covered: 0.0..length,
            length,
            poll: None,
            fit: 1.0,
            spread: None,
            track: Some(Arc::new(track)),
            feed: None,
            remarks: Vec::new(),
            shift: Vector::zeros(),
            passes: 1,
        };
        let whitening = Whitening::new(&alignment, WANDER);
        let (undriven, commanded) = (without_drives(machine), commanded(&toolpath, &plan));
        Bench { toolpath, alignment, undriven, commanded, whitening, seconds, instants }
    }

    /// It as a run.
    pub fn run(&self) -> Run<'_> {
        Run { toolpath: &self.toolpath, alignment: &self.alignment, overrides: (None, None) }
    }

    /// How long it takes, s.
    pub fn seconds(&self) -> f64 {
        self.seconds
    }

    /// What is seen of a machine, in standard deviations: times at places.
    fn times(&self, machine: &Machine) -> Vec<f64> {
        self.whitening.apply(&self.run().residuals(machine))
    }

    /// What is seen of a machine, in standard deviations: positions at times, off the base's motion less than along it.
    fn positions(&self, machine: &Machine) -> Vec<f64> {
        // Drives change no command, and most that is compared here are drives.
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
            // A stamp that is off moves the position along the motion.
            let blurred = POSITION.hypot(speed * STAMP);
            let split = |vector: Vector| {
                let part = along * along.dot(&vector);
                (vector - part) / POSITION + part / blurred
            };
            seen.extend(split(there).iter());
            slopes.extend(split(*velocity).iter());
        }
        // The delay common to all is not known.
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let squares = dot(&slopes, &slopes);
        if 0.0 < squares {
            let delay = dot(&seen, &slopes) / squares;
            seen.iter_mut().zip(&slopes).for_each(|(seen, slope)| *seen -= delay * slope);
        }
        seen
    }
}

/// The machine whose axes follow their command exactly.
fn without_drives(machine: &Machine) -> Machine {
    let mut machine = machine.clone();
    for axis in &mut machine.axes {
        *axis = Axis { servo_lag: 0.0, backlash: 0.0, mode: None, ..*axis };
    }
    machine
}

/// What a plan commands over time.
fn commanded(toolpath: &Toolpath, plan: &FeedPlan) -> Samples {
    Profile::new(toolpath, plan).samples(Resolution { feedrate: 2e-3, position: 5e-4 })
}

/// One cause at one value against all values of another: for each chord of the other's curve, and each
/// snippet, |a|², a·b and |b|² of the differences a and b at its ends.
pub struct Rivalry {
    chords: Vec<Vec<[f64; 3]>>,
}

impl Rivalry {
    /// The squared distance of the point from the curve on these snippets together.
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

/// What there is to tell apart, and which side shows on nothing.
pub struct Found {
    /// All pairs of variants, either way round.
    pub rivalries: Vec<Rivalry>,
    /// Whether no variant of a side shows.
    pub is_hidden: [bool; 2],
}

/// All variants of each of two causes against the other.
pub fn rivalries(
    machine: &Machine,
    benches: &[Bench],
    sides: &[Vec<&Hypothesis>; 2],
    is_form: bool,
) -> Found {
    let see = |machine: &Machine| -> Vec<Vec<f64>> {
        benches
            .iter()
            .map(|bench| if is_form { bench.positions(machine) } else { bench.times(machine) })
            .collect()
    };
    let base = see(machine);
    let curves = sides.each_ref().map(|side| {
        side.iter().map(|hypothesis| Curve::of(machine, hypothesis, &see)).collect::<Vec<Curve>>()
    });
    let typical = curves
        .each_ref()
        .map(|side| side.iter().filter_map(|curve| curve.typical(&base)).collect::<Vec<&Vec<Vec<f64>>>>());
    let mut rivalries = Vec::new();
    for side in 0..2 {
        for truth in &typical[side] {
            rivalries.extend(curves[1 - side].iter().map(|curve| curve.against(truth, &base)));
        }
    }
    Found { rivalries, is_hidden: [typical[0].is_empty(), typical[1].is_empty()] }
}

/// What is seen of a cause at its values, in order, snippet by snippet.
struct Curve {
    points: Vec<Vec<Vec<f64>>>,
    /// Which of them are trials.
    trials: Vec<usize>,
    is_continuous: bool,
}

impl Curve {
    fn of(machine: &Machine, hypothesis: &Hypothesis, see: &dyn Fn(&Machine) -> Vec<Vec<f64>>) -> Curve {
        let at = |values: &[f64]| see(&hypothesis.machine(machine, values));
        let (mut points, mut trials) = (Vec::new(), Vec::new());
        for (index, values) in hypothesis.trials.iter().enumerate() {
            trials.push(points.len());
            points.push(at(values));
            let Some(next) = hypothesis.trials.get(index + 1) else { continue };
            if !hypothesis.is_continuous {
                continue;
            }
            let freed = &hypothesis.freed[0];
            let (low, high) = (freed.inward(values[0]), freed.inward(next[0]));
            for part in 1..=BETWEEN {
                let mut there = values.clone();
                there[0] = freed.outward(low + (high - low) * part as f64 / (BETWEEN + 1) as f64);
                points.push(at(&there));
            }
        }
        Curve { points, trials, is_continuous: hypothesis.is_continuous }
    }

    /// Of the trials that show, one a third of the way up from the weakest.
    fn typical(&self, base: &[Vec<f64>]) -> Option<&Vec<Vec<f64>>> {
        let strength = |point: &Vec<Vec<f64>>| -> f64 {
            point.iter().zip(base).map(|(own, base)| product(own, base, own, base)).sum::<f64>().sqrt()
        };
        let mut seen: Vec<(f64, usize)> = self
            .trials
            .iter()
            .map(|at| (strength(&self.points[*at]), *at))
            .filter(|(strength, _)| SEEN < *strength)
            .collect();
        seen.sort_by(|a, b| a.0.total_cmp(&b.0));
        seen.get(seen.len() / 3).map(|(_, at)| &self.points[*at])
    }

    /// A point of another cause against this curve and against no cause at all.
    fn against(&self, truth: &[Vec<f64>], base: &[Vec<f64>]) -> Rivalry {
        let chord = |a: &[Vec<f64>], b: &[Vec<f64>]| -> Vec<[f64; 3]> {
            let each = truth.iter().zip(a.iter().zip(b));
            each.map(|(w, (a, b))| [product(w, a, w, a), product(w, a, w, b), product(w, b, w, b)]).collect()
        };
        let mut chords = vec![chord(base, base)];
        if self.is_continuous {
            chords.extend(self.points.windows(2).map(|pair| chord(&pair[0], &pair[1])));
        }
        chords.extend(self.points.iter().map(|point| chord(point, point)));
        Rivalry { chords }
    }
}

/// (a − b)·(c − d).
fn product(a: &[f64], b: &[f64], c: &[f64], d: &[f64]) -> f64 {
    let each = a.iter().zip(b).zip(c.iter().zip(d));
    each.map(|((a, b), (c, d))| (a - b) * (c - d)).sum()
}
