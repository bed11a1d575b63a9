//! How far feedrates differ: times between marks can be had by speeds that nobody saw.
//!
//! A cause is held against the recorded feedrates of all of a run, and of the visits of lines whose time it
//! changes by more than [`ACTS`] of what they take. They may differ [`WORSE`], all in all as a model that is a little
//! off elsewhere does, and where it acts as recorded speeds do by themselves: there the motion turns, and the foot on
//! the path of what cuts a corner has another speed than the tool. A filter that is longer by a hundredth changes
//! speeds by less than that. Below [`READ_MM_S`] a control shows none.

use std::borrow::Cow;
use std::ops::Range;

use crate::identification::alignment::Alignment;
use crate::identification::comparison::{FeedError, PooledFeedError, VisitTimes, compare, feed_error_during};
use crate::identification::fit::Run;
use crate::machine::Machine;
use crate::simulation::feed::FeedPlan;
use crate::simulation::toolpath::Toolpath;

/// By what ratio feedrates may differ more with a cause than without it, all in all and where it acts.
const WORSE: [f64; 2] = [1.03, 1.05];
/// The last digit of a feedrate that controls show, 1 mm/min, mm/s.
const READ_MM_S: f64 = 1.0 / 60.0;
/// A cause acts where it changes the time of a visit by this part.
const ACTS: f64 = 2e-3;

/// How far feedrates differ at the times, of the recorder's clock, for which `is_meant` holds.
pub fn error(machine: &Machine, run: &Run, is_meant: &dyn Fn(f64) -> bool) -> Option<FeedError> {
    Simulated::of(machine, run).error(is_meant)
}

/// How far feedrates differ without a cause.
pub struct Speeds<'a> {
    runs: &'a [Run<'a>],
    without: Vec<Simulated<'a>>,
}

impl<'a> Speeds<'a> {
    /// On a machine.
    pub fn of(machine: &Machine, runs: &'a [Run<'a>]) -> Speeds<'a> {
        Speeds { runs, without: runs.iter().map(|run| Simulated::of(machine, run)).collect() }
    }

    /// Whether they differ hardly more with a cause, all in all and where it acts.
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

/// A run on a machine.
struct Simulated<'a> {
    toolpath: &'a Toolpath,
    plan: FeedPlan,
    alignment: Cow<'a, Alignment>,
    lost: Vec<VisitTimes>,
    clock: f64,
}

impl<'a> Simulated<'a> {
    fn of(machine: &Machine, run: &'a Run) -> Simulated<'a> {
        let (plan, alignment) = (run.plan(machine), run.by_clock(machine));
        let lost = compare(run.toolpath, &plan, &alignment).lost;
        Simulated { toolpath: run.toolpath, plan, alignment, lost, clock: machine.recorder.clock_ratio }
    }

    fn error(&self, is_meant: &dyn Fn(f64) -> bool) -> Option<FeedError> {
        let is_meant = |time: f64| is_meant(self.clock * time);
        feed_error_during(self.toolpath, &self.plan, &self.alignment, &self.lost, &is_meant)
    }
}

/// When visits took place whose time differs between two machines, s of the recorder's clock.
fn acts(without: &Simulated, with: &Simulated) -> Vec<Range<f64>> {
    let takes = |during: &Range<f64>| during.end - during.start;
    let differs = |(before, after): &(&VisitTimes, &VisitTimes)| {
        let (before, after) = (takes(&before.simulated), takes(&after.simulated));
        ACTS * before.max(after) < (after - before).abs()
    };
    let acted = without.lost.iter().zip(&with.lost).filter(differs);
    let by_recorder = |time: f64| without.clock * time;
    acted.map(|(visit, _)| by_recorder(visit.recorded.start)..by_recorder(visit.recorded.end)).collect()
}
