//! Test of the feedrates: a wrong cause can fit the times between marks with speeds that the machine never had.
//!
//! A cause is compared with the recorded feedrates of a whole run, and with those of the visits whose time it changes
//! by more than [`MIN_TIME_CHANGE_RATIO`] of their duration. Its feedrates may differ by up to [`WORSE`] times the difference without
//! it: over the whole run as much as a model that is a little off elsewhere makes them differ, and where the cause acts
//! as much as recorded speeds do by themselves. There the motion turns, and where the tool cuts a corner, its
//! projection on the path has another speed than the tool. A filter that is longer by a hundredth changes speeds by
//! less than that. A control shows no difference below [`READ_MM_S`].

use std::ops::Range;

use crate::identification::comparison::{FeedError, Feedrates, PooledFeedError, VisitTimes, visit_times};
use crate::identification::fit::Run;
use crate::machine::Machine;

/// Largest ratios of the difference of feedrates with a cause to that without it: over whole runs, and where the cause
/// acts.
const WORSE: [f64; 2] = [1.03, 1.05];
/// Last digit of the feedrate that controls show, mm/s: 1 mm/min.
const READ_MM_S: f64 = 1.0 / 60.0;
/// Least change of the time of a visit on which a cause acts, as a part of that time.
const MIN_TIME_CHANGE_RATIO: f64 = 2e-3;

/// Returns the difference of feedrates at the times, by the recorder's clock, that satisfy `is_meant`.
pub fn error(machine: &Machine, run: &Run, is_meant: &dyn Fn(f64) -> bool) -> Option<FeedError> {
    Simulated::of(machine, run).error(is_meant)
}

/// Simulated feedrates without a cause.
pub struct Speeds<'a> {
    runs: &'a [Run<'a>],
    without: Vec<Simulated>,
}

impl<'a> Speeds<'a> {
    /// Simulates the runs on a machine without the cause.
    pub fn of(machine: &Machine, runs: &'a [Run<'a>]) -> Speeds<'a> {
        Speeds { runs, without: runs.iter().map(|run| Simulated::of(machine, run)).collect() }
    }

    /// Returns `true` if feedrates differ hardly more with a cause than without it, over whole runs and where it acts.
    pub fn are_kept(&self, with: &Machine) -> bool {
        let mut sums = [[PooledFeedError::default(); 2]; 2];
        for (run, without) in self.runs.iter().zip(&self.without) {
            let with = Simulated::of(with, run);
            let acts = acts(without, &with);
            let is_in = |time: f64| {
                let next = acts.partition_point(|during| during.end < time);
                acts.get(next).is_some_and(|during| during.start <= time)
            };
            for (side, simulated) in [without, &with].into_iter().enumerate() {
                sums[0][side].add(simulated.error(&|_| true));
                sums[1][side].add(simulated.error(&is_in));
            }
        }
        sums.into_iter().zip(WORSE).all(|(sides, worse)| {
            let [before, after] = sides.map(|sum| sum.rms());
            before.zip(after).is_none_or(|(before, after)| after <= (worse * before).max(READ_MM_S))
        })
    }
}

/// Times and feedrates of a run simulated on a machine.
struct Simulated {
    lost: Vec<VisitTimes>,
    feedrates: Feedrates,
    clock: f64,
}

impl Simulated {
    fn of(machine: &Machine, run: &Run) -> Simulated {
        let (plan, alignment) = (run.plan(machine), run.by_clock(machine));
        let lost = visit_times(run.toolpath, &plan, &alignment);
        let feedrates = Feedrates::of(run.toolpath, &plan, &alignment, &lost);
        Simulated { lost, feedrates, clock: machine.recorder.clock_ratio }
    }

    fn error(&self, is_meant: &dyn Fn(f64) -> bool) -> Option<FeedError> {
        self.feedrates.error(&|time| is_meant(self.clock * time))
    }
}

/// Returns the spans of time of the visits whose duration differs between two machines, s of the recorder's clock.
fn acts(without: &Simulated, with: &Simulated) -> Vec<Range<f64>> {
    let takes = |during: &Range<f64>| during.end - during.start;
    let differs = |(before, after): &(&VisitTimes, &VisitTimes)| {
        let (before, after) = (takes(&before.simulated), takes(&after.simulated));
        MIN_TIME_CHANGE_RATIO * before.max(after) < (after - before).abs()
    };
    let acted = without.lost.iter().zip(&with.lost).filter(differs);
    let by_recorder = |time: f64| without.clock * time;
    acted.map(|(visit, _)| by_recorder(visit.recorded.start)..by_recorder(visit.recorded.end)).collect()
}
