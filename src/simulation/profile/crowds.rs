//! Crowds: many pulses far shorter than a filter delay, seen as a whole.
//!
//! What pulses contribute to the filtered motion is ∫ v(a) V(a) da over their ages a. Where all of them lie between
//! two knots of the filter, V is a polynomial there, and with x = a − y, counted from the age y of their end,
//!
//! ```text
//! ∫ v V da = Σ c_k M_k,      M_k = ∫ v xᵏ dx,      V(y + x) = Σ c_k xᵏ,      k = 0 … 4
//! ```
//!
//! The moments M_k do not depend on the time, so they are found once: of [`SMALLEST`] pulses in a row, and of
//! [`RADIX`] crowds in a row from theirs,
//!
//! ```text
//! M_k = Σ_j C(k, j) o^(k−j) m_j        m_j of a crowd that ends o before the whole does, s
//! ```
//!
//! The state at one moment then costs the logarithm of the pulses in one filter delay instead of their number. The moments are
//! local, so that nothing is lost in differences of long sums. Only crowds far shorter than the delay are made:
//! programs of ordinary blocks have none. Units: mm, s.

use crate::simulation::feed::{FeedPlan, Pulse, Pulses};
use crate::simulation::filter::Expansion;
use crate::simulation::profile::slice::{InPlane, Slice, quadrature};
use crate::simulation::toolpath::{Curve, Segment, Segments, Vector};
use std::ops::Range;

/// Pulses in the smallest crowd.
const SMALLEST: usize = 16;

/// Crowds in the next larger one.
const RADIX: usize = 4;

/// The smallest crowds in one filter delay from which on there are any.
const IN_ONE_DELAY: f64 = 16.0;

/// The largest crowds in one filter delay, of which knots would divide most.
const LARGEST_IN_ONE_DELAY: f64 = 8.0;

/// Moments of so many powers: V has at most the fourth.
const POWERS: usize = 5;

/// Pulses in a row of one stretch.
#[derive(Clone, Debug)]
pub struct Crowd {
    /// Its first pulse in the plan.
    first: usize,
    /// How many pulses.
    pub count: usize,
    /// How long they last, s.
    pub duration: f64,
    /// Moments of the feedrate, mm sᵏ.
    along: [f64; POWERS],
    /// Moments of the velocity, mm sᵏ.
    travel: [Vector; POWERS],
}

/// The crowds of a plan.
#[derive(Default)]
pub struct Crowds {
    /// The smallest first.
    levels: Vec<Level>,
}

/// Crowds of the same number of pulses, in their order.
struct Level {
    /// How many pulses each has.
    count: usize,
    crowds: Vec<Crowd>,
    /// Where in that list each crowd is that begins at a multiple of the count; [`ABSENT`] where there is none.
    places: Vec<u32>,
}

/// No place.
const ABSENT: u32 = u32::MAX;

impl Crowds {
    /// The crowds of a plan for these segments.
    pub fn of(plan: &FeedPlan, segments: &Segments) -> Crowds {
        let mut smallest = Vec::new();
        for stretch in plan.stretches() {
            let delay = plan.filters[stretch.filter].delay();
            let begin = stretch.pulses.start.next_multiple_of(SMALLEST);
            for end in (begin + SMALLEST..=stretch.pulses.end).step_by(SMALLEST) {
                let range = end - SMALLEST..end;
                let duration: f64 = range.clone().map(|pulse| plan.pulses.duration(pulse)).sum();
                if IN_ONE_DELAY * duration < delay {
                    smallest.push(Crowd::of(&plan.pulses, range, segments));
                }
            }
        }
        let mut levels = Vec::new();
        let mut level = smallest;
        while !level.is_empty() {
            let next = plan.stretches().flat_map(|stretch| {
                let most = plan.filters[stretch.filter].delay() / LARGEST_IN_ONE_DELAY;
                let from = level.partition_point(|crowd| crowd.first < stretch.pulses.start);
                let to = level.partition_point(|crowd| crowd.first < stretch.pulses.end);
                joined(&level[from..to]).filter(move |crowd| crowd.duration < most)
            });
            let next = next.collect();
            levels.push(Level::of(std::mem::replace(&mut level, next)));
        }
        Crowds { levels }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.levels.is_empty()
    }

    /// The crowds that end before the pulse `end`, the largest first.
    pub fn ending_at(&self, end: usize) -> impl Iterator<Item = &Crowd> {
        // Where none of the smallest ends, none does.
        let levels = if end.is_multiple_of(SMALLEST) { &self.levels[..] } else { &[] };
        levels.iter().rev().filter_map(move |level| {
            let number = if end.is_multiple_of(level.count) { end / level.count } else { 0 };
            let place = *level.places.get(number.checked_sub(1)?)?;
            level.crowds.get(place as usize)
        })
    }
}

impl Level {
    fn of(crowds: Vec<Crowd>) -> Level {
        let count = crowds[0].count;
        let last = crowds[crowds.len() - 1].first / count;
        let mut places = vec![ABSENT; last + 1];
        for (crowd, place) in crowds.iter().zip(0..) {
            places[crowd.first / count] = place;
        }
        Level { count, crowds, places }
    }
}

/// The crowds of [`RADIX`] of `level` each, where these follow one another from a multiple of their number on.
fn joined(level: &[Crowd]) -> impl Iterator<Item = Crowd> {
    level.windows(RADIX).filter_map(|parts| {
        let count = parts[0].count;
        let follow = parts.windows(2).all(|pair| pair[0].first + count == pair[1].first);
        (follow && parts[0].first.is_multiple_of(RADIX * count)).then(|| {
            let mut whole = Crowd::none(parts[0].first);
            parts.iter().rev().for_each(|part| whole.add_before(part));
            whole
        })
    })
}

impl Crowd {
    fn none(first: usize) -> Crowd {
        Crowd { first, count: 0, duration: 0.0, along: [0.0; POWERS], travel: [Vector::zeros(); POWERS] }
    }

    /// The pulses with these indices.
    fn of(pulses: &Pulses, range: Range<usize>, segments: &Segments) -> Crowd {
        let mut whole = Crowd::none(range.start);
        for index in range.rev() {
            let pulse = pulses.at(index);
            whole.add_before(&Crowd::of_one(&pulse, index, &segments.at(pulse.segment as usize)));
        }
        whole
    }

    fn of_one(pulse: &Pulse, first: usize, segment: &Segment) -> Crowd {
        let mut one = Crowd { count: 1, duration: pulse.duration, ..Crowd::none(first) };
        let [begin, end] = pulse.feedrate;
        let mut power = 1.0;
        for (k, moment) in one.along.iter_mut().enumerate() {
            power *= pulse.duration;
            *moment = power * (end / (k + 1) as f64 + (begin - end) / (k + 2) as f64);
        }
        match &segment.curve {
            Curve::Line => {
                let direction = segment.tangent(0.0);
                one.travel = one.along.map(|moment| moment * direction);
            }
            Curve::Arc(arc) => {
                let mut moments = [InPlane::default(); POWERS];
                quadrature(&Slice::of_whole(pulse), arc, segment.length, 0.0..pulse.duration, |node| {
                    let mut factor = node.weight;
                    for moment in &mut moments {
                        moment.add(factor, &node);
                        factor *= node.age;
                    }
                });
                one.travel = moments.map(|moment| moment.over(arc, segment.length));
            }
        }
        one
    }

    /// Adds what comes before.
    fn add_before(&mut self, part: &Crowd) {
        const BINOMIALS: [[f64; POWERS]; POWERS] = [
            [1.0, 0.0, 0.0, 0.0, 0.0],
            [1.0, 1.0, 0.0, 0.0, 0.0],
            [1.0, 2.0, 1.0, 0.0, 0.0],
            [1.0, 3.0, 3.0, 1.0, 0.0],
            [1.0, 4.0, 6.0, 4.0, 1.0],
        ];
        for (k, binomials) in BINOMIALS.iter().enumerate() {
            let mut power = 1.0;
            for j in (0..=k).rev() {
                let factor = binomials[j] * power;
                self.along[k] += factor * part.along[j];
                self.travel[k] += factor * part.travel[j];
                power *= self.duration;
            }
        }
        self.count += part.count;
        self.duration += part.duration;
    }

    /// What has arrived of its distance (mm) and how fast it arrives (mm/s), with the filter as seen from its end.
    pub fn progress(&self, filter: &Expansion) -> (f64, f64) {
        let sum = |coefficients: &[f64]| coefficients.iter().zip(&self.along).map(|(c, m)| c * m).sum();
        (sum(&filter.step), sum(&filter.impulse))
    }

    /// What has arrived of its way (mm) and how fast it arrives (mm/s).
    pub fn travel(&self, filter: &Expansion) -> (Vector, Vector) {
        (self.sum(&filter.step), self.sum(&filter.impulse))
    }

    /// What it adds to the acceleration (mm/s²) and to the jerk (mm/s³).
    pub fn dynamics(&self, filter: &Expansion) -> (Vector, Vector) {
        let [_, h1, h2, h3] = filter.impulse;
        (self.sum(&[h1, 2.0 * h2, 3.0 * h3]), self.sum(&[2.0 * h2, 6.0 * h3]))
    }

    fn sum(&self, coefficients: &[f64]) -> Vector {
        coefficients.iter().zip(&self.travel).map(|(c, m)| *c * m).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::Machine;
    use crate::simulation::feed::{Rule, command};
    use crate::simulation::gcode::read;
    use crate::simulation::profile::Profile;
    use crate::simulation::toolpath::{Toolpath, trace};
    use std::fmt::Write;

    /// Blocks of a nanometre between blocks of a millimetre, each `circle`th a full circle of a nanometre.
    fn toolpath(blocks: usize, circle: usize) -> Toolpath {
        let mut text = "G91 G1 F3000 X1\nX1 Y1\n".to_string();
        for block in 0..blocks {
            let next = match block % 2 {
                _ if block % circle == 7 => "G2 I0.000001",
                0 => "G1 X0.000001 Y-0.000001",
                _ => "G1 X0.000001 Y0.000001",
            };
            writeln!(text, "{next}").expect("text grows");
        }
        text += "G1 Y1\nX1\nG4 P1\nX2";
        trace(&read(text.as_bytes()), &Machine::default())
    }

    fn machines() -> Vec<Machine> {
        let filters = [&[0.02][..], &[0.02, 0.03], &[0.0255; 3], &[0.03, 0.001, 0.01, 0.02]];
        let machines = filters.map(|constants| {
            let mut machine = Machine::default();
            machine.interpolator.filters = constants.len();
            machine.interpolator.time_constants = crate::machine::TimeConstants::Unequal(constants.to_vec());
            machine
        });
        machines.to_vec()
    }

    #[test]
    fn a_crowd_moves_the_tool_as_its_pulses_do() {
        let toolpath = toolpath(2000, 8);
        for machine in machines() {
            let plan = command(&toolpath, &machine, Rule::Isolated(0.01));
            let profile = Profile::new(&toolpath, &plan);
            assert!(!profile.crowds.is_empty());
            let mut alone = Profile::new(&toolpath, &plan);
            alone.crowds = Crowds::default();
            let end = profile.cycle_time();
            for time in (0..=400).map(|i| end * f64::from(i) / 400.0) {
                let (state, other) = (profile.at_time(time), alone.at_time(time));
                assert!((state.distance - other.distance).abs() < 1e-12 * profile.length());
                assert!((state.position - other.position).norm() < 1e-12, "{time} s");
                assert!((state.velocity - other.velocity).norm() < 1e-10, "{time} s");
                let both = profile.dynamics_at_time(time).zip(alone.dynamics_at_time(time));
                if let Some((dynamics, other)) = both {
                    assert!((dynamics.acceleration - other.acceleration).norm() < 1e-7, "{time} s");
                    assert!((dynamics.jerk - other.jerk).norm() < 1e-3, "{time} s");
                }
            }
            let wanted: Vec<f64> = (1..50).map(|i| profile.length() * f64::from(i) / 50.0).collect();
            for (time, other) in profile.crossing_times(&wanted).iter().zip(alone.crossing_times(&wanted)) {
                assert!((time - other).abs() < 1e-8, "{time} s, {other} s");
            }
        }
    }

    /// The work for one state, counted: it grows with the logarithm of the pulses in one filter delay.
    #[test]
    fn a_state_costs_no_more_where_pulses_crowd() {
        let machine = Machine::default();
        let parts = |blocks: usize| {
            let toolpath = toolpath(blocks, usize::MAX);
            let plan = command(&toolpath, &machine, Rule::Isolated(0.01));
            let profile = Profile::new(&toolpath, &plan);
            let motion = profile.motion(plan.stretches().next().expect("it moves"));
            let counts = (0..100)
                .map(|i| motion.parts_in_window(motion.moment(motion.duration() * f64::from(i) / 100.0)));
            counts.max().expect("a hundred counts")
        };
        let counts = [2_000, 8_000, 32_000].map(parts);
        assert!(counts.into_iter().all(|count| count < 400), "{counts:?}");
    }
}
