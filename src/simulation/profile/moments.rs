//! Moments of clusters: many pulses far shorter than a filter delay, treated as one.
//!
//! Pulses contribute ∫ v(a) V(a) da over their ages a to the filtered motion. If all of them lie between two
//! knots of the filter, V is a polynomial there. With x = a − y, where y is the age of their end,
//!
//! ```text
//! ∫ v V da = Σ c_k M_k,      M_k = ∫ v xᵏ dx,      V(y + x) = Σ c_k xᵏ,      k = 0 … 4
//! ```
//!
//! The moments M_k do not depend on the time, so that they are computed once: for [`MIN_CLUSTER_PULSES`]
//! consecutive pulses, and for [`CLUSTERS_PER_LEVEL`] consecutive clusters from the moments of these
//! clusters:
//!
//! ```text
//! M_k = Σ_j C(k, j) o^(k−j) m_j        m_j of a cluster that ends o before the whole does, s
//! ```
//!
//! The cost of the state at one moment then grows with the logarithm of the number of pulses in one filter
//! delay instead of the number itself. The moments are local, so that no digits are lost in differences of
//! long sums. Only clusters far shorter than the delay are made: programs of ordinary blocks have none.
//! Units: mm, s.

use crate::simulation::feed::{FeedPlan, Pulse, Pulses};
use crate::simulation::filter::Expansion;
use crate::simulation::profile::slice::{ArcFrameVector, PulseSlice, quadrature};
use crate::simulation::toolpath::{Curve, Segment, Segments, Vector};
use std::ops::Range;

/// Pulses in the smallest cluster.
const MIN_CLUSTER_PULSES: usize = 16;

/// Clusters in a cluster of the next level.
const CLUSTERS_PER_LEVEL: usize = 4;

/// Least number of smallest clusters in one filter delay; with fewer, none are made.
const MIN_CLUSTERS_PER_DELAY: f64 = 16.0;

/// Number of the largest clusters in one filter delay; knots would divide most of larger ones.
const MIN_LARGEST_CLUSTERS_PER_DELAY: f64 = 8.0;

/// Number of moments: V has at most the fourth power.
const MOMENT_COUNT: usize = 5;

/// Consecutive pulses of one motion.
#[derive(Clone, Debug)]
pub struct PulseCluster {
    /// Index of the first pulse in the plan.
    first: usize,
    /// Number of pulses.
    pub count: usize,
    /// Duration, s.
    pub duration: f64,
    /// Moments of the feedrate, mm sᵏ.
    along: [f64; MOMENT_COUNT],
    /// Moments of the velocity, mm sᵏ.
    travel: [Vector; MOMENT_COUNT],
}

/// The clusters of a plan.
#[derive(Default)]
pub struct MomentTree {
    /// Levels, the smallest clusters first.
    levels: Vec<MomentLevel>,
}

/// Clusters of the same number of pulses, in order.
struct MomentLevel {
    /// Number of pulses in each.
    count: usize,
    clusters: Vec<PulseCluster>,
    /// Index of the cluster that begins at each multiple of `count`; [`NO_CLUSTER`] if there is none.
    places: Vec<u32>,
}

/// Marks a missing cluster.
const NO_CLUSTER: u32 = u32::MAX;

impl MomentTree {
    /// Returns the clusters of a plan for these segments.
    pub fn of(plan: &FeedPlan, segments: &Segments) -> MomentTree {
        let mut smallest = Vec::new();
        for rest_to_rest in plan.rest_to_rest_motions() {
            let delay = plan.filters[rest_to_rest.filter].delay();
            let begin = rest_to_rest.pulses.start.next_multiple_of(MIN_CLUSTER_PULSES);
            for end in (begin + MIN_CLUSTER_PULSES..=rest_to_rest.pulses.end).step_by(MIN_CLUSTER_PULSES) {
                let range = end - MIN_CLUSTER_PULSES..end;
                let duration: f64 = range.clone().map(|pulse| plan.pulses.duration(pulse)).sum();
                if MIN_CLUSTERS_PER_DELAY * duration < delay {
                    smallest.push(PulseCluster::of(&plan.pulses, range, segments));
                }
            }
        }
        let mut levels = Vec::new();
        let mut level = smallest;
        while !level.is_empty() {
            let next = plan.rest_to_rest_motions().flat_map(|rest_to_rest| {
                let most = plan.filters[rest_to_rest.filter].delay() / MIN_LARGEST_CLUSTERS_PER_DELAY;
                let from = level.partition_point(|cluster| cluster.first < rest_to_rest.pulses.start);
                let to = level.partition_point(|cluster| cluster.first < rest_to_rest.pulses.end);
                joined(&level[from..to]).filter(move |cluster| cluster.duration < most)
            });
            let next = next.collect();
            levels.push(MomentLevel::of(std::mem::replace(&mut level, next)));
        }
        MomentTree { levels }
    }

    /// Returns `true` if there are no clusters.
    pub fn is_empty(&self) -> bool {
        self.levels.is_empty()
    }

    /// Returns the clusters that end before the pulse `end`, the largest first.
    pub fn ending_at(&self, end: usize) -> impl Iterator<Item = &PulseCluster> {
        // If no cluster of the lowest level ends there, no cluster does.
        let levels = if end.is_multiple_of(MIN_CLUSTER_PULSES) { &self.levels[..] } else { &[] };
        levels.iter().rev().filter_map(move |level| {
            let number = if end.is_multiple_of(level.count) { end / level.count } else { 0 };
            let place = *level.places.get(number.checked_sub(1)?)?;
            level.clusters.get(place as usize)
        })
    }
}

impl MomentLevel {
    fn of(clusters: Vec<PulseCluster>) -> MomentLevel {
        let count = clusters[0].count;
        let last = clusters[clusters.len() - 1].first / count;
        let mut places = vec![NO_CLUSTER; last + 1];
        for (cluster, place) in clusters.iter().zip(0..) {
            places[cluster.first / count] = place;
        }
        MomentLevel { count, clusters, places }
    }
}

/// Returns the clusters of the next level: each joins [`CLUSTERS_PER_LEVEL`] consecutive clusters of `level`
/// and begins at a multiple of that number of pulses.
fn joined(level: &[PulseCluster]) -> impl Iterator<Item = PulseCluster> {
    level.windows(CLUSTERS_PER_LEVEL).filter_map(|parts| {
        let count = parts[0].count;
        let follow = parts.windows(2).all(|pair| pair[0].first + count == pair[1].first);
        (follow && parts[0].first.is_multiple_of(CLUSTERS_PER_LEVEL * count)).then(|| {
            let mut whole = PulseCluster::none(parts[0].first);
            parts.iter().rev().for_each(|part| whole.add_before(part));
            whole
        })
    })
}

impl PulseCluster {
    fn none(first: usize) -> PulseCluster {
        PulseCluster {
            first,
            count: 0,
            duration: 0.0,
            along: [0.0; MOMENT_COUNT],
            travel: [Vector::zeros(); MOMENT_COUNT],
        }
    }

    /// Returns the cluster of the pulses with these indices.
    fn of(pulses: &Pulses, range: Range<usize>, segments: &Segments) -> PulseCluster {
        let mut whole = PulseCluster::none(range.start);
        for index in range.rev() {
            let pulse = pulses.at(index);
            whole.add_before(&PulseCluster::of_one(&pulse, index, &segments.at(pulse.segment as usize)));
        }
        whole
    }

    fn of_one(pulse: &Pulse, first: usize, segment: &Segment) -> PulseCluster {
        let mut one = PulseCluster { count: 1, duration: pulse.duration, ..PulseCluster::none(first) };
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
                let mut moments = [ArcFrameVector::default(); MOMENT_COUNT];
                quadrature(&PulseSlice::of_whole(pulse), arc, segment.length, 0.0..pulse.duration, |node| {
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

    /// Adds a cluster that lies before this one.
    fn add_before(&mut self, part: &PulseCluster) {
        const BINOMIALS: [[f64; MOMENT_COUNT]; MOMENT_COUNT] = [
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

    /// Returns the distance of the cluster that has arrived (mm) and its rate (mm/s), with the filter
    /// expanded at the end of the cluster.
    pub fn progress(&self, filter: &Expansion) -> (f64, f64) {
        let sum = |coefficients: &[f64]| coefficients.iter().zip(&self.along).map(|(c, m)| c * m).sum();
        (sum(&filter.step), sum(&filter.impulse))
    }

    /// Returns the displacement of the cluster that has arrived (mm) and its rate (mm/s).
    pub fn travel(&self, filter: &Expansion) -> (Vector, Vector) {
        (self.sum(&filter.step), self.sum(&filter.impulse))
    }

    /// Returns the contribution of the cluster to the acceleration (mm/s²) and to the jerk (mm/s³).
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
    use crate::simulation::feed::{CornerPolicy, command};
    use crate::simulation::gcode::read;
    use crate::simulation::interpreter::trace;
    use crate::simulation::profile::Profile;
    use crate::simulation::toolpath::Toolpath;
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
            let plan = command(&toolpath, &machine, CornerPolicy::Isolated(0.01));
            let profile = Profile::new(&toolpath, &plan);
            assert!(!profile.clusters.is_empty());
            let mut alone = Profile::new(&toolpath, &plan);
            alone.clusters = MomentTree::default();
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
            let plan = command(&toolpath, &machine, CornerPolicy::Isolated(0.01));
            let profile = Profile::new(&toolpath, &plan);
            let motion = profile.motion(plan.rest_to_rest_motions().next().expect("it moves"));
            let counts = (0..100)
                .map(|i| motion.parts_in_window(motion.moment(motion.duration() * f64::from(i) / 100.0)));
            counts.max().expect("a hundred counts")
        };
        let counts = [2_000, 8_000, 32_000].map(parts);
        assert!(counts.into_iter().all(|count| count < 400), "{counts:?}");
    }
}
