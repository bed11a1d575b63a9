//! A profile as a table, dense where the feedrate bends.
//!
//! Rows are laid at an eighth of the filter delay while anything changes, and nowhere else; then
//! each gap is halved until straight lines between the rows, over time and over distance, stay
//! within the resolution asked for. A filtered feedrate has no feature shorter than that first
//! spacing resolves, but for filters that let short pulses through: there rows are laid where it
//! may bend. So nothing is missed, and the cost is linear in the number of pulses.
//!
//! A small file whose loops run to their bound would make some eighty million rows, far more than a picture shows or a
//! computer holds. A table that has no room for them is laid anew at equal times, and says at which.

use crate::simulation::feed::Phase;
use crate::simulation::profile::{Moment, Profile, State, Steps};
use crate::simulation::sampled::{RowsAround, rows_around};
use crate::simulation::toolpath::{self, Curve, Vector};

/// A profile as columns of equal length, straight lines between the rows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Samples {
    /// Time since the start, s.
    pub time: Vec<f64>,
    /// Distance along the programmed path, mm.
    pub distance: Vec<f64>,
    /// Feedrate of the tool, mm/s.
    pub feedrate: Vec<f64>,
    /// Position of the tool, mm, one column an axis.
    pub position: [Vec<f64>; 3],
    /// Velocity of the tool, mm/s, one column an axis.
    pub velocity: [Vec<f64>; 3],
    /// Line of the program being run.
    pub line: Vec<u32>,
    /// Time between the rows where they are too few to follow the profile, s: what is shorter may be missing.
    pub spacing: Option<f64>,
}

/// Feedrate and time over distance as columns of equal length, straight lines between the rows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FeedCurve {
    /// Time since the start, s.
    pub time: Vec<f64>,
    /// Distance along the programmed path, mm.
    pub distance: Vec<f64>,
    /// Feedrate of the tool, mm/s.
    pub feedrate: Vec<f64>,
    /// Time between the rows where they are too few to follow the profile, s: what is shorter may be missing.
    pub spacing: Option<f64>,
}

impl FeedCurve {
    /// Feedrate at each of ascending distances along the path (mm), mm/s: a straight line over distance between rows.
    pub fn feedrates_at(&self, distances: impl Iterator<Item = f64>) -> Vec<f64> {
        let mut row = 0;
        let mut at =
            |distance: f64| Some(rows_around(&self.distance, distance, &mut row)?.between(&self.feedrate));
        distances.map(|distance| at(distance).unwrap_or(0.0)).collect()
    }
}

impl Samples {
    /// Position (mm) and velocity (mm/s) at a time (s), by the cubic between two rows that has their velocities; `row`
    /// is where the last time was found.
    pub fn motion_at(&self, time: f64, row: &mut usize) -> (Vector, Vector) {
        let Some(rows) = rows_around(&self.time, time, row) else { return Default::default() };
        let RowsAround { before, after, fraction: s } = rows;
        let span = self.time[after] - self.time[before];
        let (s2, s3) = (s * s, s * s * s);
        let position = |axis: usize| {
            let (position, velocity) = (&self.position[axis], &self.velocity[axis]);
            position[before] * (2.0 * s3 - 3.0 * s2 + 1.0)
                + span * velocity[before] * (s3 - 2.0 * s2 + s)
                + position[after] * (3.0 * s2 - 2.0 * s3)
                + span * velocity[after] * (s3 - s2)
        };
        let velocity = |axis: usize| rows.between(&self.velocity[axis]);
        (Vector::from_fn(|axis, _| position(axis)), Vector::from_fn(|axis, _| velocity(axis)))
    }
}

/// How closely straight lines between the rows follow the profile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Resolution {
    /// Of the feedrate, as a part of the commanded one.
    pub feedrate: f64,
    /// Of the position, mm.
    pub position: f64,
}

impl Resolution {
    /// For files: half of the 0.1 % promised, and a micrometre.
    pub const FINE: Resolution = Resolution { feedrate: 5e-4, position: 1e-3 };
    /// For charts of feedrate over distance: less than a pixel, position as it comes.
    pub const CHART: Resolution = Resolution { feedrate: 2e-3, position: f64::INFINITY };
}

/// Rows of a table for pictures: a finishing program of a million blocks keeps all of its own.
const MOST_DRAWN: usize = 4_000_000;

/// Rows of a table for files, with all of which a computer of today has room for their text.
const MOST_WRITTEN: usize = 16_000_000;

/// Gaps are not halved more often than this.
const DEEPEST: u32 = 10;

/// Largest angle turned on an arc between two rows, rad, so that no turn is skipped.
const WIDEST_ANGLE: f64 = 1.0;

impl Profile<'_> {
    /// The profile as a table.
    pub fn samples(&self, resolution: Resolution) -> Samples {
        self.table(resolution, usize::MAX, None)
    }

    /// Its feedrate as a table.
    pub fn feed_curve(&self, resolution: Resolution) -> FeedCurve {
        self.table(resolution, usize::MAX, None)
    }

    /// Its feedrate as a table for pictures: as [`Resolution::CHART`] has it, or at equal times where that takes
    /// too many rows.
    pub fn drawn(&self) -> FeedCurve {
        self.bounded(Resolution::CHART, MOST_DRAWN)
    }

    /// The profile as a table for files, as [`Resolution::FINE`] has it, or at equal times.
    pub fn written(&self) -> Samples {
        self.bounded(Resolution::FINE, MOST_WRITTEN)
    }

    fn bounded<T: Table>(&self, resolution: Resolution, most: usize) -> T {
        let table: T = self.table(resolution, most, None);
        if table.rows() <= most {
            return table;
        }
        drop(table);
        let spacing = self.cycle_time() / (most / 2) as f64;
        self.table(resolution, usize::MAX, Some(spacing))
    }

    /// The table, cut off where it has more than `most` rows; with a `spacing` (s) its rows are laid at equal times.
    fn table<T: Table>(&self, resolution: Resolution, most: usize, spacing: Option<f64>) -> T {
        let mut table = T::with_spacing(spacing);
        let mut segments_before = 0;
        if 0.0 < self.plan.start {
            let line = self.toolpath.segments.first().map_or(0, |first| first.line.0);
            table.push(0.0, &self.standing(0), || line);
        }
        for (index, phase) in self.plan.phases.iter().enumerate() {
            let start = self.phase_starts[index];
            match phase {
                Phase::Wait(wait) if wait.duration == 0.0 => {}
                Phase::Wait(wait) => {
                    let state = self.standing(segments_before);
                    table.push(start, &state, || wait.line.0);
                    table.push(self.phase_starts[index + 1], &state, || wait.line.0);
                }
                Phase::Motion(stretch) => {
                    let segments = stretch.segments.clone();
                    segments_before = segments.end;
                    let commands =
                        self.plan.pulses.range(stretch.pulses.clone()).flat_map(|pulse| pulse.feedrate);
                    let mut sampler = Sampler {
                        steps: Steps::of(self.motion(stretch)),
                        resolution,
                        start,
                        fastest: commands.fold(0.0, f64::max),
                        segment: segments.start,
                        last_segment: segments.end - 1,
                        table: &mut table,
                    };
                    match spacing {
                        Some(spacing) => sampler.run_evenly(spacing),
                        None => sampler.run(most),
                    }
                }
            }
            if most < table.rows() {
                break;
            }
        }
        table
    }
}

/// What rows are laid in.
trait Table {
    /// One without rows; they will lie so far apart (s) where they are too few.
    fn with_spacing(spacing: Option<f64>) -> Self;

    /// How many rows there are.
    fn rows(&self) -> usize;

    /// Adds a row at a time (s since the start); `line` tells the line of the program.
    fn push(&mut self, time: f64, state: &State, line: impl FnOnce() -> u32);
}

/// Adds a row to the columns of time, distance and feedrate. Rounding may put it a last digit before the one before it; a
/// table must not go back.
fn push_row([times, distances, feedrates]: [&mut Vec<f64>; 3], time: f64, state: &State) {
    let not_before = |column: &[f64], value: f64| column.last().map_or(value, |last| last.max(value));
    times.push(not_before(times, time));
    distances.push(not_before(distances, state.distance));
    feedrates.push(state.velocity.norm());
}

impl Table for FeedCurve {
    fn with_spacing(spacing: Option<f64>) -> FeedCurve {
        FeedCurve { spacing, ..FeedCurve::default() }
    }

    fn rows(&self) -> usize {
        self.time.len()
    }

    fn push(&mut self, time: f64, state: &State, _line: impl FnOnce() -> u32) {
        push_row([&mut self.time, &mut self.distance, &mut self.feedrate], time, state);
    }
}

impl Table for Samples {
    fn with_spacing(spacing: Option<f64>) -> Samples {
        Samples { spacing, ..Samples::default() }
    }

    fn rows(&self) -> usize {
        self.time.len()
    }

    fn push(&mut self, time: f64, state: &State, line: impl FnOnce() -> u32) {
        push_row([&mut self.time, &mut self.distance, &mut self.feedrate], time, state);
        for (column, value) in self.position.iter_mut().zip(state.position.iter()) {
            column.push(*value);
        }
        for (column, value) in self.velocity.iter_mut().zip(state.velocity.iter()) {
            column.push(*value);
        }
        self.line.push(line());
    }
}

/// A row to be: time since the beginning of the stretch, true and filtered (s), the moment of the latter, and state.
#[derive(Clone, Copy)]
struct Row {
    time: f64,
    filtered: f64,
    moment: Moment,
    state: State,
}

struct Sampler<'a, T> {
    steps: Steps<'a>,
    resolution: Resolution,
    /// When the stretch begins, s.
    start: f64,
    /// Largest command in the stretch, mm/s.
    fastest: f64,
    /// Segment of the last row.
    segment: usize,
    last_segment: usize,
    table: &'a mut T,
}

impl<T: Table> Sampler<'_, T> {
    /// Lays rows where they are needed, until there are more than `most`.
    fn run(&mut self, most: usize) {
        let motion = self.steps.walk.motion;
        let duration = motion.duration();
        let mut last = self.row(motion.first_pulse, 0.0);
        self.push(last);
        while last.filtered < duration && self.table.rows() <= most {
            let time = self.next_time(last).min(duration);
            let next = self.row(last.moment.pulse, time);
            let middle = self.between(last, next);
            self.fill(last, middle, next, 0);
            last = next;
        }
    }

    /// Lays rows at equal times, and one between standing and standing at least.
    fn run_evenly(&mut self, spacing: f64) {
        let motion = self.steps.walk.motion;
        let duration = motion.duration();
        let parts = (duration / spacing).ceil().max(2.0);
        let mut pulse = motion.first_pulse;
        for part in 0..=parts as u64 {
            let row = self.row(pulse, duration * (part as f64 / parts));
            pulse = row.moment.pulse;
            self.push(row);
        }
    }

    /// The row at a filtered time (s), no earlier than the pulse `from` begins.
    fn row(&mut self, from: usize, filtered: f64) -> Row {
        let walk = &mut self.steps.walk;
        let moment = walk.moment_from(from, filtered);
        if walk.motion.knots.is_empty() {
            return Row { time: filtered, filtered, moment, state: self.steps.state(moment) };
        }
        let time = walk.motion.true_time(filtered);
        Row { time, filtered, moment, state: walk.state_at(time) }
    }

    /// Where the row of the first spacing after `last` goes: on by an eighth of the filter delay, or to
    /// the end of the time in which nothing changes.
    fn next_time(&mut self, last: Row) -> f64 {
        let time = last.filtered;
        let motion = self.steps.walk.motion;
        let delay = motion.filter.delay();
        let step = self.next_kink(time, time + delay / 8.0);
        // A ramp behind the filters may begin or end where nothing changes before them.
        let knots = motion.knots;
        let edge = knots.get(knots.partition_point(|knot| knot.filtered <= time));
        let edge = edge.map_or(f64::INFINITY, |knot| knot.filtered);
        let pulse = motion.pulses.at(last.moment.pulse);
        if last.moment.elapsed < delay || pulse.feedrate[0] != pulse.feedrate[1] {
            return step;
        }
        let segment = motion.segments.at(pulse.segment as usize);
        let widest = match &segment.curve {
            Curve::Line => f64::INFINITY,
            Curve::Arc(arc) => WIDEST_ANGLE * segment.length / (arc.sweep * pulse.feedrate[0]),
        };
        let end = self.steps.walk.pulse_start(last.moment.pulse) + pulse.duration;
        step.max(end.min(time + widest).min(edge))
    }

    /// The first time after `time` and up to `latest` at which the feedrate may bend within less
    /// than an eighth of the delay: with a single filter, or one much shorter than the others, a
    /// short pulse gives ramps of its own length, a knot of the filters after each of its ends.
    fn next_kink(&mut self, time: f64, latest: f64) -> f64 {
        let walk = &mut self.steps.walk;
        let motion = walk.motion;
        let (filter, delay) = (motion.filter, motion.filter.delay());
        let is_sharp = |constant: &f64| *constant < delay / 8.0;
        if 1 < filter.time_constants().len() && !filter.time_constants().iter().any(is_sharp) {
            return latest;
        }
        // Edges ascend, and with them the kinks that one knot makes of them.
        let end = motion.command_time();
        filter.knots().fold(latest, |next, knot| {
            let pulse = walk.starts.first_above(motion.first_pulse, knot, time);
            let edge = if pulse < motion.end_pulse { walk.pulse_start(pulse) } else { end };
            let kink = edge + knot;
            if time < kink { next.min(kink) } else { next }
        })
    }

    /// The row in the middle between two.
    fn between(&mut self, a: Row, b: Row) -> Row {
        self.row(a.moment.pulse, 0.5 * (a.filtered + b.filtered))
    }

    /// Adds the rows after `a` up to `b`; `middle` lies between them.
    fn fill(&mut self, a: Row, middle: Row, b: Row, depth: u32) {
        if depth == DEEPEST {
            return self.push(b);
        }
        let allowed = self.resolution.feedrate * self.commanded(a).min(self.commanded(b));
        let first = self.between(a, middle);
        let bends = self.bends(a, middle, b, allowed) || self.bends(a, first, b, allowed);
        let last = self.between(middle, b);
        if bends || self.bends(a, last, b, allowed) {
            self.fill(a, first, middle, depth + 1);
            self.fill(middle, last, b, depth + 1);
        } else {
            self.push(b);
        }
    }

    /// Whether the straight line from `a` to `b` misses `between`, by more than is `allowed` (mm/s) in feedrate.
    fn bends(&self, a: Row, between: Row, b: Row, allowed: f64) -> bool {
        let part_of = |begin: f64, value: f64, end: f64| {
            if begin < end { (value - begin) / (end - begin) } else { 0.5 }
        };
        let over_time = part_of(a.time, between.time, b.time);
        let over_distance = part_of(a.state.distance, between.state.distance, b.state.distance);
        let (v0, v, v1) = (a.state.velocity.norm(), between.state.velocity.norm(), b.state.velocity.norm());
        let miss = |part: f64| (v0 + part * (v1 - v0) - v).abs();
        if allowed < miss(over_time) || allowed < miss(over_distance) {
            return true;
        }
        let straight = a.state.position + over_time * (b.state.position - a.state.position);
        self.resolution.position < (straight - between.state.position).norm()
    }

    fn push(&mut self, row: Row) {
        self.segment = self.segment_at(row.state.distance);
        let line = || self.steps.walk.motion.segments.at(self.segment).line.0;
        self.table.push(self.start + row.time, &row.state, line);
    }

    /// The feedrate that the resolution refers to where a row lies, mm/s.
    fn commanded(&mut self, row: Row) -> f64 {
        let segment = self.segment_at(row.state.distance);
        match self.steps.walk.motion.segments.motion(segment) {
            toolpath::Motion::Feed { feedrate } => feedrate,
            toolpath::Motion::Rapid => self.fastest,
        }
    }

    /// The segment in which a distance lies that is not before the last row's.
    fn segment_at(&mut self, distance: f64) -> usize {
        let mut segment = self.segment;
        while segment < self.last_segment && self.steps.walk.distances.before(segment + 1) <= distance {
            segment += 1;
        }
        segment
    }
}
