//! A profile as a table, dense where the feedrate bends.
//!
//! Rows are an eighth of the filter delay apart while anything changes, and nowhere else; then each gap above a least
//! spacing is halved until straight lines between the rows, over time and over distance, stay within the requested
//! resolution. A filtered feedrate has no feature shorter than that first spacing resolves, unless the
//! filters let short pulses through: then rows are added where the feedrate may bend.
//!
//! A small file whose loops run to their bound would make about eighty million rows, far more than a picture
//! shows or a computer holds. A table that would be too long is sampled again at equal times, and `spacing`
//! contains the time between its rows.

use crate::simulation::feed::Phase;
use crate::simulation::profile::{Moment, MotionState, Profile, RememberedSteps};
use crate::simulation::sampled::rows_around;
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
    /// Position of the tool, mm, one column per axis.
    pub position: [Vec<f64>; 3],
    /// Velocity of the tool, mm/s, one column per axis.
    pub velocity: [Vec<f64>; 3],
    /// Line of the program being run.
    pub line: Vec<u32>,
    /// Time between rows if they are too few to follow the profile, s: shorter features may be missing.
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
    /// Time between rows if they are too few to follow the profile, s: shorter features may be missing.
    pub spacing: Option<f64>,
}

impl FeedCurve {
    /// Returns the feedrate at each of ascending distances along the path (mm), mm/s, linear over distance
    /// between rows.
    pub fn feedrates_at(&self, distances: impl Iterator<Item = f64>) -> Vec<f64> {
        let mut row = 0;
        let mut at =
            |distance: f64| Some(rows_around(&self.distance, distance, &mut row)?.between(&self.feedrate));
        distances.map(|distance| at(distance).unwrap_or(0.0)).collect()
    }
}

impl Samples {
    /// Returns position (mm) and velocity (mm/s) at a time (s), by the cubic between two rows with their
    /// velocities; `row` holds the row of the last search.
    pub fn motion_at(&self, time: f64, row: &mut usize) -> (Vector, Vector) {
        let Some(rows) = rows_around(&self.time, time, row) else { return Default::default() };
        let motion = |axis: usize| rows.motion(&self.time, &self.position[axis], &self.velocity[axis]);
        let [x, y, z] = [0, 1, 2].map(motion);
        (Vector::new(x.0, y.0, z.0), Vector::new(x.1, y.1, z.1))
    }
}

/// The accuracy of straight lines between the rows of a table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Resolution {
    /// Accuracy of the feedrate, as a part of the commanded one.
    pub feedrate: f64,
    /// Accuracy of the position, mm.
    pub position: f64,
    /// Time between rows below which no row is added, s.
    pub spacing: f64,
}

impl Resolution {
    /// For files: half of the promised 0.1 % of the feedrate, and a micrometre.
    pub const FINE: Resolution = Resolution { feedrate: 5e-4, position: 1e-3, spacing: 0.0 };
    /// For charts of feedrate over distance: less than a pixel; positions are not refined.
    pub const CHART: Resolution = Resolution { feedrate: 2e-3, position: f64::INFINITY, spacing: 0.0 };
    /// For positions over time, by the cubics between the rows ([`Samples::motion_at`]). On a radius r straight lines that miss
    /// a position by p, mm, belong to cubics that miss it by p²/(6 r). Where the velocity changes by Δv within a few tenths of
    /// a millisecond, as in planners without filters, cubics over the spacing h miss it by Δv h/16.
    pub const MOTION: Resolution = Resolution { feedrate: f64::INFINITY, position: 2e-3, spacing: 2.5e-4 };
}

/// Most rows of a table for pictures: a finishing program of a million blocks keeps all of its rows.
const MAX_DRAWN_ROWS: usize = 4_000_000;

/// Most rows of a table for files: today's computers have memory for the text of them all.
const MAX_WRITTEN_ROWS: usize = 16_000_000;

/// Most halvings of a gap.
const MAX_HALVINGS: u32 = 10;

/// Largest angle turned on an arc between two rows, rad, so that no turn is skipped.
const MAX_ROW_ANGLE_RAD: f64 = 1.0;

impl Profile<'_> {
    /// Returns the profile as a table.
    pub fn samples(&self, resolution: Resolution) -> Samples {
        self.table(resolution, usize::MAX, None)
    }

    /// Returns the feedrate of the profile as a table.
    pub fn feed_curve(&self, resolution: Resolution) -> FeedCurve {
        self.table(resolution, usize::MAX, None)
    }

    /// Returns the feedrate as a table for pictures: at [`Resolution::CHART`], or at equal times if that
    /// takes too many rows.
    pub fn drawn(&self) -> FeedCurve {
        self.bounded(Resolution::CHART, MAX_DRAWN_ROWS)
    }

    /// Returns the profile as a table for files: at [`Resolution::FINE`], or at equal times if that takes too
    /// many rows.
    pub fn written(&self) -> Samples {
        self.bounded(Resolution::FINE, MAX_WRITTEN_ROWS)
    }

    fn bounded<T: SampledTable>(&self, resolution: Resolution, most: usize) -> T {
        let table: T = self.table(resolution, most, None);
        if table.rows() <= most {
            return table;
        }
        drop(table);
        let spacing = self.cycle_time() / (most / 2) as f64;
        self.table(resolution, usize::MAX, Some(spacing))
    }

    /// Returns the table, cut off after `most` rows; if `spacing` (s) is given, rows are at equal times.
    fn table<T: SampledTable>(&self, resolution: Resolution, most: usize, spacing: Option<f64>) -> T {
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
                Phase::Motion(rest_to_rest) => {
                    let segments = rest_to_rest.segments.clone();
                    segments_before = segments.end;
                    let commands =
                        self.plan.pulses.range(rest_to_rest.pulses.clone()).flat_map(|pulse| pulse.feedrate);
                    let mut sampler = Sampler {
                        steps: RememberedSteps::of(self.motion(rest_to_rest)),
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

/// A table under construction.
trait SampledTable {
    /// Returns a table without rows; `spacing` (s) is the spacing of rows that are too few.
    fn with_spacing(spacing: Option<f64>) -> Self;

    /// Returns the number of rows.
    fn rows(&self) -> usize;

    /// Adds a row at a time (s since the start); `line` returns the line of the program.
    fn push(&mut self, time: f64, state: &MotionState, line: impl FnOnce() -> u32);
}

/// Adds a row to the columns of time, distance and feedrate. Rounding may put the row a last digit before its
/// predecessor; it is moved forward, as a table must not go back.
fn push_row([times, distances, feedrates]: [&mut Vec<f64>; 3], time: f64, state: &MotionState) {
    let not_before = |column: &[f64], value: f64| column.last().map_or(value, |last| last.max(value));
    times.push(not_before(times, time));
    distances.push(not_before(distances, state.distance));
    feedrates.push(state.velocity.norm());
}

impl SampledTable for FeedCurve {
    fn with_spacing(spacing: Option<f64>) -> FeedCurve {
        FeedCurve { spacing, ..FeedCurve::default() }
    }

    fn rows(&self) -> usize {
        self.time.len()
    }

    fn push(&mut self, time: f64, state: &MotionState, _line: impl FnOnce() -> u32) {
        push_row([&mut self.time, &mut self.distance, &mut self.feedrate], time, state);
    }
}

impl SampledTable for Samples {
    fn with_spacing(spacing: Option<f64>) -> Samples {
        Samples { spacing, ..Samples::default() }
    }

    fn rows(&self) -> usize {
        self.time.len()
    }

    fn push(&mut self, time: f64, state: &MotionState, line: impl FnOnce() -> u32) {
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

/// A candidate row: true and filtered time since the beginning of the motion (s), the moment at the filtered
/// time, and the state.
#[derive(Clone, Copy)]
struct CandidateRow {
    time: f64,
    filtered: f64,
    moment: Moment,
    state: MotionState,
}

struct Sampler<'a, T> {
    steps: RememberedSteps<'a>,
    resolution: Resolution,
    /// Time at which the motion begins, s.
    start: f64,
    /// Largest command in the motion, mm/s.
    fastest: f64,
    /// Index of the segment of the last row.
    segment: usize,
    last_segment: usize,
    table: &'a mut T,
}

impl<T: SampledTable> Sampler<'_, T> {
    /// Adds the rows that are needed, until there are more than `most`.
    fn run(&mut self, most: usize) {
        let motion = self.steps.cursor.motion;
        let duration = motion.duration();
        let mut last = self.row(motion.first_pulse, 0.0);
        self.push(last);
        while last.filtered < duration && self.table.rows() <= most {
            let time = self.next_time(last).min(duration);
            let next = self.row(last.moment.pulse, time);
            if time - last.filtered <= self.resolution.spacing {
                self.push(next);
            } else {
                let middle = self.between(last, next);
                self.fill(last, middle, next, 0);
            }
            last = next;
        }
    }

    /// Adds rows at equal times, at least one in each motion.
    fn run_evenly(&mut self, spacing: f64) {
        let motion = self.steps.cursor.motion;
        let duration = motion.duration();
        let parts = (duration / spacing).ceil().max(2.0);
        let mut pulse = motion.first_pulse;
        for part in 0..=parts as u64 {
            let row = self.row(pulse, duration * (part as f64 / parts));
            pulse = row.moment.pulse;
            self.push(row);
        }
    }

    /// Returns the row at a filtered time (s), no earlier than the beginning of the pulse `from`.
    fn row(&mut self, from: usize, filtered: f64) -> CandidateRow {
        let cursor = &mut self.steps.cursor;
        let moment = cursor.moment_from(from, filtered);
        if cursor.motion.knots.is_empty() {
            return CandidateRow { time: filtered, filtered, moment, state: self.steps.state(moment) };
        }
        let time = cursor.motion.true_time(filtered);
        CandidateRow { time, filtered, moment, state: cursor.state_at(time) }
    }

    /// Returns the time of the row after `last`: later by an eighth of the filter delay or by the least spacing, or the end of
    /// the time in which the acceleration is constant.
    fn next_time(&mut self, last: CandidateRow) -> f64 {
        let time = last.filtered;
        let motion = self.steps.cursor.motion;
        let delay = motion.filter.delay();
        let step = self.next_kink(time, time + self.resolution.spacing.max(delay / 8.0));
        // A ramp behind the filters may begin or end where the command is even.
        let knots = motion.knots;
        let edge = knots.get(knots.partition_point(|knot| knot.filtered <= time));
        let edge = edge.map_or(f64::INFINITY, |knot| knot.filtered);
        let pulse = motion.pulses.at(last.moment.pulse);
        if last.moment.elapsed < delay {
            return step;
        }
        let fastest = pulse.feedrate[0].max(pulse.feedrate[1]);
        let segment = motion.segments.at(pulse.segment as usize);
        let widest = match &segment.curve {
            Curve::Line => f64::INFINITY,
            Curve::Arc(arc) => MAX_ROW_ANGLE_RAD * segment.length / (arc.sweep * fastest),
        };
        let end = self.steps.cursor.pulse_start(last.moment.pulse) + pulse.duration;
        step.max(end.min(time + widest).min(edge))
    }

    /// Returns the first time after `time` and up to `latest` at which the feedrate may bend within less than
    /// an eighth of the delay: with a single filter, or one much shorter than the others, a short pulse gives ramps of its duration, a knot of the filters after each of its ends.
    fn next_kink(&mut self, time: f64, latest: f64) -> f64 {
        let cursor = &mut self.steps.cursor;
        let motion = cursor.motion;
        let (filter, delay) = (motion.filter, motion.filter.delay());
        let is_sharp = |constant: &f64| *constant < delay / 8.0;
        if 1 < filter.time_constants().len() && !filter.time_constants().iter().any(is_sharp) {
            return latest;
        }
        // Edges ascend, and so do the kinks that each knot causes at them.
        let end = motion.command_time();
        filter.knots().fold(latest, |next, knot| {
            let pulse = cursor.starts.first_above(motion.first_pulse, knot, time);
            let edge = if pulse < motion.end_pulse { cursor.pulse_start(pulse) } else { end };
            let kink = edge + knot;
            if time < kink { next.min(kink) } else { next }
        })
    }

    /// Returns the row in the middle between two.
    fn between(&mut self, a: CandidateRow, b: CandidateRow) -> CandidateRow {
        self.row(a.moment.pulse, 0.5 * (a.filtered + b.filtered))
    }

    /// Adds the rows after `a` up to `b`; `middle` lies between them.
    fn fill(&mut self, a: CandidateRow, middle: CandidateRow, b: CandidateRow, depth: u32) {
        if depth == MAX_HALVINGS {
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

    /// Returns `true` if the straight line from `a` to `b` misses `between`, in feedrate by more than
    /// `allowed` (mm/s).
    fn bends(&self, a: CandidateRow, between: CandidateRow, b: CandidateRow, allowed: f64) -> bool {
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

    fn push(&mut self, row: CandidateRow) {
        self.segment = self.segment_at(row.state.distance);
        let line = || self.steps.cursor.motion.segments.at(self.segment).line.0;
        self.table.push(self.start + row.time, &row.state, line);
    }

    /// Returns the commanded feedrate at a row, mm/s, to which the resolution refers.
    fn commanded(&mut self, row: CandidateRow) -> f64 {
        let segment = self.segment_at(row.state.distance);
        match self.steps.cursor.motion.segments.motion(segment) {
            toolpath::Motion::Feed { feedrate } => feedrate,
            toolpath::Motion::Rapid { .. } => self.fastest,
        }
    }

    /// Returns the segment at a distance, which is not before that of the last row.
    fn segment_at(&mut self, distance: f64) -> usize {
        let mut segment = self.segment;
        while segment < self.last_segment && self.steps.cursor.distances.before(segment + 1) <= distance {
            segment += 1;
        }
        segment
    }
}
