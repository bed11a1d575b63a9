//! Random paths and machines, drawn from fixed seeds or, in the full suite, from one that `scripts/test --all` prints.
//!
//! Paths of 2 to 40 blocks of 0.01 to 100 mm, lines and arcs (full turns, helices) in all
//! directions of space, smooth and sharp transitions, feedrates of 100 to 20 000 mm/min, some
//! rapids, exact stops and dwells. Machines of one to four filters of 2 to 80 ms, equal or not.

pub use crate::shared::random::Random;
use crate::shared::seed_offset;
use truefeed::machine::{Junction, Machine, TimeConstants};
use truefeed::simulation::feed::{CornerPolicy, FeedPlan, Phase, RestToRest};
use truefeed::simulation::gcode::LineNumber;
use truefeed::simulation::simulate;
use truefeed::simulation::toolpath::{
    Arc, Curve, Motion, Point, Rotation, Segment, Stop, StopCause, Toolpath, Vector,
};

impl Random {
    /// A unit vector.
    pub fn direction(&mut self) -> Vector {
        loop {
            let vector = Vector::from_fn(|_, _| self.between(-1.0, 1.0));
            if (0.01..1.0).contains(&vector.norm()) {
                return vector.normalize();
            }
        }
    }

    /// A unit vector at right angles to another.
    pub fn across(&mut self, along: &Vector) -> Vector {
        along.cross(&self.direction()).try_normalize(1e-3).unwrap_or_else(|| self.across(along))
    }
}

/// A path and a machine to run it on, with its contour tolerance.
pub struct Case {
    /// For messages.
    pub number: usize,
    pub toolpath: Toolpath,
    pub machine: Machine,
}

impl Case {
    pub fn tolerance(&self) -> f64 {
        self.machine.interpolator.contour_tolerance
    }

    /// Feedrate asked for along a segment, mm/s.
    pub fn requested(&self, segment: &Segment) -> f64 {
        match segment.motion {
            Motion::Rapid { .. } => self.machine.rapid.feedrate,
            Motion::Feed { feedrate } => feedrate,
        }
    }

    pub fn plan(&self) -> FeedPlan {
        simulate::with_policy(&self.toolpath, &self.machine, CornerPolicy::Isolated(self.tolerance()))
    }

    pub fn time(&self) -> f64 {
        self.plan().cycle_time()
    }
}

/// `count` cases from a seed, each with what is left of the random numbers.
pub fn cases(seed: u64, count: usize) -> impl Iterator<Item = (Case, Random)> {
    let seed = seed + 1000 * seed_offset();
    // Steps of the golden ratio make good seeds of consecutive numbers.
    let seeds =
        (0..count).map(move |number| (number, (number as u64 + seed).wrapping_mul(0x9e37_79b9_7f4a_7c15)));
    seeds.map(|(number, seed)| {
        let mut random = Random(seed | 1);
        (0..8).for_each(|_| {
            random.unit();
        });
        let (toolpath, machine) = (path(&mut random), machine(&mut random));
        (Case { number, toolpath, machine }, random)
    })
}

/// When each stretch begins (s) and the stretch; exact to some 1e-15.
pub fn stretches(plan: &FeedPlan) -> Vec<(f64, &RestToRest)> {
    let mut time = 0.0;
    let mut stretches = Vec::new();
    for phase in &plan.phases {
        match phase {
            Phase::Wait(wait) => time += wait.duration,
            Phase::Motion(stretch) => {
                stretches.push((time, stretch));
                time += plan.command_time(stretch) + plan.filters[stretch.filter].delay();
            }
        }
    }
    stretches
}

/// A straight segment.
pub fn line(start: Point, end: Point, motion: Motion) -> Segment {
    Segment {
        start,
        end,
        curve: Curve::Line,
        length: (end - start).norm(),
        motion,
        rotation: Rotation::NONE,
        exact_stop: false,
        exact_path: false,
        line: LineNumber(1),
    }
}

fn path(random: &mut Random) -> Toolpath {
    let count = 2 + random.between(0.0, 39.0) as usize;
    let mut start = Point::from(random.between(0.0, 100.0) * random.direction());
    let mut heading = random.direction();
    let feed = |random: &mut Random| Motion::Feed { feedrate: random.log_between(100.0, 20_000.0) / 60.0 };
    let mut motion = feed(random);
    let longest = random.log_between(0.1, 100.0);
    let mut toolpath = Toolpath::default();
    for index in 0..count {
        if random.chance(0.2) {
            motion = if random.chance(0.2) { Motion::RAPID } else { feed(random) };
        }
        heading = match random.unit() {
            turn if turn < 0.2 => heading,
            turn if turn < 0.6 => (heading + 0.1 * random.direction()).normalize(),
            _ => random.direction(),
        };
        let length = random.log_between(0.01, longest);
        let mut segment = if random.chance(0.35) {
            arc(random, start, &heading, length, motion)
        } else {
            line(start, start + length * heading, motion)
        };
        segment.exact_stop = random.chance(0.03);
        segment.line = LineNumber(index as u32 + 1);
        heading = segment.tangent(segment.length).normalize();
        start = segment.end;
        toolpath.segments.push(segment);
        if random.chance(0.02) {
            let cause = StopCause::Dwell { seconds: random.between(0.0, 2.0) };
            toolpath.stops.push(Stop { after: index + 1, cause, line: LineNumber(index as u32 + 1) });
        }
    }
    toolpath
}

fn arc(random: &mut Random, start: Point, heading: &Vector, length: f64, motion: Motion) -> Segment {
    let radius = random.log_between(0.3, 50.0);
    let e1 = random.across(heading);
    let sweep = (length / radius).min(14.0);
    let rise = if random.chance(0.3) { length * random.between(-0.5, 0.5) } else { 0.0 };
    let arc = Arc {
        center: start - radius * e1,
        e1,
        e2: *heading,
        start_radius: radius,
        end_radius: radius,
        sweep,
        rise: rise * e1.cross(heading),
    };
    let end = arc.center + radius * (sweep.cos() * e1 + sweep.sin() * heading) + arc.rise;
    let length = arc.length();
    Segment { end, curve: Curve::Arc(arc.into()), length, ..line(start, end, motion) }
}

fn machine(random: &mut Random) -> Machine {
    let mut machine = Machine::default();
    let order = 1 + random.between(0.0, 4.0) as usize;
    machine.interpolator.filters = order;
    machine.interpolator.time_constants = if random.chance(0.3) {
        TimeConstants::Unequal((0..order).map(|_| random.log_between(0.002, 0.08)).collect())
    } else {
        TimeConstants::Equal(random.log_between(0.002, 0.08))
    };
    machine.interpolator.contour_tolerance = random.log_between(0.001, 0.1);
    machine.rapid.feedrate = random.log_between(1000.0, 40_000.0) / 60.0;
    machine.rapid.exact_stop = random.chance(0.2);
    if random.chance(0.25) {
        // Under a law of junctions that never binds, acceleration shapes the command itself.
        machine.path.acceleration = random.log_between(100.0, 20_000.0);
        machine.interpolator.junction = Junction::AxisStep(1e9);
    }
    if random.chance(0.1) {
        machine.rapid.time_constants = Some(TimeConstants::Equal(random.log_between(0.002, 0.08)));
    }
    if random.chance(0.1) {
        machine.interpolator.time_constants = TimeConstants::FromJerk(random.log_between(1e4, 1e6));
    }
    machine
}
