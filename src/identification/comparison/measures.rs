//! Differences between recorded and simulated motion, each as one number.

use std::ops::Range;

use crate::identification::alignment::{Alignment, Method};
use crate::identification::comparison::VisitTimes;
use crate::identification::comparison::pointwise::{Pointwise, pointwise};
use crate::simulation::feed::FeedPlan;
use crate::simulation::profile::Profile;
use crate::simulation::toolpath::{Motion, Toolpath};

/// Polls over which feedrates of a polled log are averaged.
const POLLS_PER_WINDOW: f64 = 10.0;

/// Time before and after a mark over which the residual is averaged, s.
const WINDOW_HALF_S: f64 = 0.25;

/// The difference of feedrates on feed moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FeedError {
    /// RMS of recorded less simulated feedrate over distance, mm/s.
    pub rms: f64,
    /// RMS of recorded less programmed feedrate over distance, mm/s: the error of length ÷ feed.
    pub programmed_rms: f64,
    /// Mean programmed feedrate over distance, mm/s.
    pub programmed: f64,
    /// Length over which the feedrates were compared, mm.
    pub way: f64,
}

/// The difference of feedrates over the whole length of several comparisons.
#[derive(Clone, Copy, Debug, Default)]
pub struct PooledFeedError {
    squares: f64,
    way: f64,
}

impl PooledFeedError {
    /// Adds a comparison.
    pub fn add(&mut self, error: Option<FeedError>) {
        if let Some(error) = error {
            self.squares += error.way * error.rms * error.rms;
            self.way += error.way;
        }
    }

    /// Returns the RMS over the whole length, mm/s; `None` if nothing was compared.
    pub fn rms(&self) -> Option<f64> {
        (0.0 < self.way).then(|| (self.squares / self.way).sqrt())
    }
}

/// The difference of positions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PositionError {
    /// RMS distance between recorded and simulated position at the same place, mm.
    pub rms: f64,
    /// Largest distance, mm.
    pub largest: f64,
}

impl FeedError {
    /// Returns the difference over the rows whose recorded time (s) satisfies `is_meant`.
    fn during(rows: &Pointwise, is_meant: &dyn Fn(f64) -> bool) -> Option<FeedError> {
        let mut error = SquareSums::default();
        for row in (1..rows.distance.len()).filter(|row| is_meant(rows.recorded_time[*row])) {
            if let Some(programmed) = rows.programmed[row] {
                let step = rows.distance[row] - rows.distance[row - 1];
                error.add(step, rows.recorded[row], rows.simulated[row], programmed);
            }
        }
        error.mean()
    }
}

/// Recorded and simulated feedrates of a run, from which the difference over any part of the run is computed.
pub enum Feedrates {
    /// Point by point, if the place of each sample is known.
    Points(Pointwise),
    /// Means over parts that are long against the time between polls.
    Polled {
        /// Time between polls, s.
        poll: f64,
        /// One for each visit to a line.
        visits: Vec<VisitMotion>,
    },
    /// Nothing shows the recorded feedrates.
    Unknown,
}

impl Feedrates {
    /// Returns the feedrates of a run whose times of visits are `lost`.
    pub fn of(toolpath: &Toolpath, plan: &FeedPlan, alignment: &Alignment, lost: &[VisitTimes]) -> Feedrates {
        if alignment.method == Method::Positions {
            return Feedrates::Points(pointwise(toolpath, plan, alignment));
        }
        let Some(poll) = alignment.poll else { return Feedrates::Unknown };
        let distances = toolpath.distances();
        let visits = lost.iter().map(|visit| VisitMotion::of(visit, toolpath, &distances));
        Feedrates::Polled { poll, visits: visits.collect() }
    }

    /// Returns the difference of feedrates at recorded times (s) that satisfy `is_meant`; `None` if no feed move is there.
    pub fn error(&self, is_meant: &dyn Fn(f64) -> bool) -> Option<FeedError> {
        match self {
            Feedrates::Points(rows) => FeedError::during(rows, is_meant),
            Feedrates::Polled { poll, visits } => error_of_visits(visits, POLLS_PER_WINDOW * poll, is_meant),
            Feedrates::Unknown => None,
        }
    }
}

/// Returns the difference of mean feedrates over windows of successive visits that move at a programmed feedrate and whose
/// recorded beginnings satisfy `is_meant`; a window lasts at least `lasts`, s.
fn error_of_visits(visits: &[VisitMotion], lasts: f64, is_meant: &dyn Fn(f64) -> bool) -> Option<FeedError> {
    let mut error = SquareSums::default();
    let mut window = MotionWindow::default();
    for visit in visits {
        let Some(motion) = visit.motion.as_ref().filter(|_| is_meant(visit.begin)) else {
            window = MotionWindow::default();
            continue;
        };
        window.way += motion.way;
        window.recorded += motion.recorded;
        window.simulated += motion.simulated;
        window.programmed += motion.programmed;
        if lasts <= window.recorded && 0.0 < window.way {
            let of = |time: f64| window.way / time;
            error.add(window.way, of(window.recorded), of(window.simulated), of(window.programmed));
            window = MotionWindow::default();
        }
    }
    error.mean()
}

/// The motion of a visit to a line.
pub struct VisitMotion {
    /// Recorded beginning, s.
    begin: f64,
    /// `None` if the visit contains a wait or a rapid move.
    motion: Option<MotionWindow>,
}

impl VisitMotion {
    /// Returns the motion of a visit; `distances` holds the distance along the path before each segment, mm.
    fn of(visit: &VisitTimes, toolpath: &Toolpath, distances: &[f64]) -> VisitMotion {
        let at =
            |distance: f64| distances.partition_point(|end| *end < distance).min(toolpath.segments.len());
        let segments = toolpath.segments.range(at(visit.distance.start)..at(visit.distance.end));
        let programmed: Option<f64> = segments
            .map(|segment| match segment.motion {
                Motion::Feed { feedrate } => Some(segment.length / feedrate),
                Motion::Rapid { .. } => None,
            })
            .sum();
        let takes = |during: &Range<f64>| during.end - during.start;
        let motion = programmed.filter(|_| !visit.waits()).map(|programmed| MotionWindow {
            way: takes(&visit.distance),
            recorded: takes(&visit.recorded),
            simulated: takes(&visit.simulated),
            programmed,
        });
        VisitMotion { begin: visit.recorded.start, motion }
    }
}

/// The motion between two places: length (mm) and recorded, simulated and programmed duration (s).
#[derive(Default)]
struct MotionWindow {
    way: f64,
    recorded: f64,
    simulated: f64,
    programmed: f64,
}

/// Sums of squared differences, weighted by distance.
#[derive(Default)]
struct SquareSums {
    way: f64,
    squares: f64,
    programmed_squares: f64,
    programmed: f64,
}

impl SquareSums {
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

/// Returns the residual averaged around each mark, weighted by the certainty of the marks; jumps, as at a
/// stop, are kept.
fn smoothed(alignment: &Alignment, simulated: &[f64], residuals: &[f64]) -> Vec<f64> {
    let marks = &alignment.marks;
    let (mut from, mut to) = (0, 0);
    let (mut sum, mut weight) = (0.0, 0.0);
    let certainty = |at: usize| marks[at].deviation.powi(-2);
    let mut smooth = Vec::with_capacity(marks.len());
    for at in 0..marks.len() {
        while to < marks.len() && simulated[to] <= simulated[at] + WINDOW_HALF_S {
            sum += certainty(to) * residuals[to];
            weight += certainty(to);
            to += 1;
        }
        while simulated[from] < simulated[at] - WINDOW_HALF_S {
            sum -= certainty(from) * residuals[from];
            weight -= certainty(from);
            from += 1;
        }
        smooth.push(if 0.0 < weight { sum / weight } else { residuals[at] });
    }
    smooth
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn feed_errors_are_weighted_by_distance_and_skip_rapids() {
        // 1 mm at 1 mm/s off, 3 mm at 2 mm/s off, and a rapid that does not count.
        let rows = Pointwise {
            distance: vec![0.0, 1.0, 4.0, 100.0],
            recorded_time: vec![0.0, 1.0, 2.0, 3.0],
            recorded: vec![10.0, 11.0, 8.0, 500.0],
            simulated: vec![10.0, 10.0, 10.0, 0.0],
            programmed: vec![Some(12.0), Some(12.0), Some(12.0), None],
            ..Pointwise::default()
        };
        let error = FeedError::during(&rows, &|_| true).expect("two rows are on a feed move");
        assert_eq!(error.way, 4.0);
        assert_eq!(error.programmed, 12.0);
        assert!((error.rms - f64::sqrt((1.0 + 3.0 * 4.0) / 4.0)).abs() < 1e-12);
        assert!((error.programmed_rms - f64::sqrt((1.0 + 3.0 * 16.0) / 4.0)).abs() < 1e-12);
        let late = FeedError::during(&rows, &|time| 1.5 < time).expect("one row is late enough");
        assert_eq!((late.way, late.rms), (3.0, 2.0));
        assert_eq!(FeedError::during(&rows, &|time| 2.5 < time), None, "only the rapid remains");
    }
}
