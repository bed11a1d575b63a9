//! How far apart two motions are, in one number each.

use std::ops::Range;

use crate::identification::alignment::{Alignment, Method};
use crate::identification::comparison::Lost;
use crate::identification::comparison::pointwise::{Pointwise, pointwise};
use crate::simulation::feed::FeedPlan;
use crate::simulation::profile::Profile;
use crate::simulation::toolpath::{Motion, Toolpath};

/// Feedrates of a log written by polls are means over so many of them.
const POLLS: f64 = 10.0;

/// Half the time around a mark over which the residual is a mean, s.
const AROUND: f64 = 0.25;

/// How far feedrates differ on feed moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FeedError {
    /// Root mean square of recorded less simulated feedrate over distance, mm/s.
    pub rms: f64,
    /// The same of recorded less programmed feedrate, mm/s: what length ÷ feed amounts to.
    pub programmed_rms: f64,
    /// Mean programmed feedrate over distance, mm/s.
    pub programmed: f64,
    /// The way over which they were compared, mm.
    pub way: f64,
}

/// How far positions differ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PositionError {
    /// Root mean square of the distance between recorded and simulated position at the same place, mm.
    pub rms: f64,
    /// Largest of it, mm.
    pub largest: f64,
}

impl FeedError {
    /// Of rows at the same places; none where none is on a feed move.
    pub fn of(rows: &Pointwise) -> Option<FeedError> {
        FeedError::during(rows, &|_| true)
    }

    /// The same of the rows for whose recorded time (s) `is_meant` holds.
    fn during(rows: &Pointwise, is_meant: &dyn Fn(f64) -> bool) -> Option<FeedError> {
        let mut error = Sum::default();
        for row in (1..rows.distance.len()).filter(|row| is_meant(rows.recorded_time[*row])) {
            if let Some(programmed) = rows.programmed[row] {
                let step = rows.distance[row] - rows.distance[row - 1];
                error.add(step, rows.recorded[row], rows.simulated[row], programmed);
            }
        }
        error.mean()
    }
}

/// Of a comparison: from point to point where places are known to the sample, else as means over
/// stretches that are long against the time between polls.
pub fn feed_error(
    toolpath: &Toolpath,
    plan: &FeedPlan,
    alignment: &Alignment,
    lost: &[Lost],
) -> Option<FeedError> {
    feed_error_during(toolpath, plan, alignment, lost, &|_| true)
}

/// The same at recorded times (s) for which `is_meant` holds.
pub fn feed_error_during(
    toolpath: &Toolpath,
    plan: &FeedPlan,
    alignment: &Alignment,
    lost: &[Lost],
    is_meant: &dyn Fn(f64) -> bool,
) -> Option<FeedError> {
    if alignment.method == Method::Positions {
        return FeedError::during(&pointwise(toolpath, plan, alignment), is_meant);
    }
    let poll = alignment.poll?;
    let distances = toolpath.distances();
    // No number where a rapid move is on the way.
    let programmed = |range: &Range<f64>| -> f64 {
        let at =
            |distance: f64| distances.partition_point(|end| *end < distance).min(toolpath.segments.len());
        let times =
            toolpath.segments.range(at(range.start)..at(range.end)).map(|segment| match segment.motion {
                Motion::Feed { feedrate } => segment.length / feedrate,
                Motion::Rapid => f64::NAN,
            });
        times.sum()
    };
    let mut error = Sum::default();
    let mut window = Window::default();
    for visit in lost {
        let time = programmed(&visit.distance);
        if visit.waits() || time.is_nan() || !is_meant(visit.recorded.start) {
            window = Window::default();
            continue;
        }
        window.way += visit.distance.end - visit.distance.start;
        window.recorded += visit.recorded.end - visit.recorded.start;
        window.simulated += visit.simulated.end - visit.simulated.start;
        window.programmed += time;
        if POLLS * poll <= window.recorded && 0.0 < window.way {
            let of = |time: f64| window.way / time;
            error.add(window.way, of(window.recorded), of(window.simulated), of(window.programmed));
            window = Window::default();
        }
    }
    error.mean()
}

/// What passes between two places.
#[derive(Default)]
struct Window {
    way: f64,
    recorded: f64,
    simulated: f64,
    programmed: f64,
}

/// Squares of differences, weighted by distance.
#[derive(Default)]
struct Sum {
    way: f64,
    squares: f64,
    programmed_squares: f64,
    programmed: f64,
}

impl Sum {
    fn add(&mut self, way: f64, recorded: f64, simulated: f64, programmed: f64) {
        self.way += way;
        self.squares += way * (recorded - simulated).powi(2);
        self.programmed_squares += way * (recorded - programmed).powi(2);
        self.programmed += way * programmed;
    }

    fn mean(&self) -> Option<FeedError> {
        (0.0 < self.way).then(|| FeedError {
            rms: (self.squares / self.way).sqrt(),
            programmed_rms: (self.programmed_squares / self.way).sqrt(),
            programmed: self.programmed / self.way,
            way: self.way,
        })
    }
}

pub fn position_error(
    toolpath: &Toolpath,
    plan: &FeedPlan,
    alignment: &Alignment,
    simulated: &[f64],
    residuals: &[f64],
) -> Option<PositionError> {
    let track = alignment.track.as_ref()?;
    let profile = Profile::new(toolpath, plan);
    let smooth = smoothed(alignment, simulated, residuals);
    let offset = alignment.marks.first()?.time - simulated.first()?;
    let (mut squares, mut largest, mut count) = (0.0, 0.0f64, 0.0);
    let mut mark = 0;
    for fix in &alignment.fixes {
        let Some(sample) = fix.sample else { continue };
        while mark + 1 < alignment.marks.len() && alignment.marks[mark + 1].time <= fix.time {
            mark += 1;
        }
        let state = profile.at_time(fix.time - offset - smooth[mark]);
        let apart = (0..3)
            .filter(|axis| track.recorded[*axis])
            .map(|axis| (track.position[sample][axis] - state.position[axis]).powi(2))
            .sum::<f64>();
        squares += apart;
        largest = largest.max(apart);
        count += 1.0;
    }
    (0.0 < count).then(|| PositionError { rms: f64::sqrt(squares / count), largest: largest.sqrt() })
}

/// The residual as its mean around each mark, by the certainty of the marks; a jump as at a stop stays.
fn smoothed(alignment: &Alignment, simulated: &[f64], residuals: &[f64]) -> Vec<f64> {
    let marks = &alignment.marks;
    let (mut from, mut to) = (0, 0);
    let (mut sum, mut weight) = (0.0, 0.0);
    let certainty = |at: usize| marks[at].deviation.powi(-2);
    let mut smooth = Vec::with_capacity(marks.len());
    for at in 0..marks.len() {
        while to < marks.len() && simulated[to] <= simulated[at] + AROUND {
            sum += certainty(to) * residuals[to];
            weight += certainty(to);
            to += 1;
        }
        while simulated[from] < simulated[at] - AROUND {
            sum -= certainty(from) * residuals[from];
            weight -= certainty(from);
            from += 1;
        }
        smooth.push(if 0.0 < weight { sum / weight } else { residuals[at] });
    }
    smooth
}
