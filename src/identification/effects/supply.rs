//! Effects of the block supply: late blocks, at controls that plan corners with regard to them and at controls that
//! do not.

use crate::identification::effects::effect::{Context, Effect, Hypothesis, ratios};
use crate::identification::effects::parameters;
use crate::identification::effects::report::{BLOCKS, CORNERS_PLANNED_BY, Quantity, Reported, SECONDS};
use crate::identification::fit::Run;
use crate::machine::CornerPlanning;
use crate::simulation::toolpath::Motion;

/// Parts of all blocks that are shorter than each of the block times tried.
const SHORTER: [f64; 12] = [0.002, 0.01, 0.03, 0.06, 0.1, 0.2, 0.3, 0.45, 0.6, 0.75, 0.9, 1.0];
/// Ratio of a block time tried to the programmed time of the longest block that is shorter.
const TRIAL_RATIO: f64 = 1.08;
/// Largest ratio of two successive block times tried. If all blocks are about equally long, further block times
/// between two are tried to keep this ratio.
const MAX_RATIO_OF_TRIALS: f64 = 1.5;

/// Returns the block times tried, s, in ascending order: each acts on more blocks, and no block is shorter than a
/// time below the least of them.
fn trials(runs: &[Run]) -> Vec<f64> {
    let segments = runs.iter().flat_map(|run| &run.toolpath.segments);
    let mut durations: Vec<f64> = segments
        .filter_map(|segment| match segment.motion {
            Motion::Feed { feedrate } => Some(segment.length / feedrate),
            Motion::Rapid { .. } => None,
        })
        .filter(|duration| 0.0 < *duration && duration.is_finite())
        .collect();
    durations.sort_by(f64::total_cmp);
    let at = |part: f64| {
        let place = (durations.len() as f64 * part) as usize;
        durations.get(place.min(durations.len().saturating_sub(1)))
    };
    let mut times: Vec<f64> = SHORTER
        .iter()
        .filter_map(|part| at(*part))
        .map(|time| (TRIAL_RATIO * time).clamp(1e-5, 1.0))
        .collect();
    times.dedup_by(|b, a| *b < 1.01 * *a);
    let between = times.windows(2).flat_map(|pair| {
        let count = ((pair[1] / pair[0]).ln() / MAX_RATIO_OF_TRIALS.ln()).ceil() as usize;
        ratios(pair[0], pair[1], count + 1).into_iter().take(count)
    });
    between.chain(times.last().copied()).collect()
}

pub fn block_times(effect: Effect, context: &Context) -> Vec<Hypothesis> {
    let trials = trials(context.runs);
    let of = |by: CornerPlanning| {
        let freed = parameters::BLOCK_TIME.tried().also(move |machine| machine.interpolator.planned_by = by);
        let report = move |value| reported(SECONDS.number(value), by);
        Hypothesis::single(effect, freed, trials.clone(), report).variant(variant(by))
    };
    CornerPlanning::WORDS.into_iter().map(|(_, by)| of(by)).collect()
}

pub fn look_aheads(effect: Effect, _: &Context) -> Vec<Hypothesis> {
    let of = |by: CornerPlanning| {
        let freed = parameters::LOOK_AHEAD.tried().with(move |machine, value| {
            (machine.interpolator.look_ahead, machine.interpolator.planned_by) = (value.round(), by);
        });
        let seen = [1.0, 2.0, 3.0, 4.0, 5.0, 7.0, 10.0, 15.0, 20.0, 30.0, 50.0, 80.0, 120.0];
        let report = move |value: f64| reported(BLOCKS.number(value.round()), by);
        Hypothesis::single(effect, freed, seen.to_vec(), report).variant(variant(by)).counted()
    };
    CornerPlanning::WORDS.into_iter().map(|(_, by)| of(by)).collect()
}

/// Returns a value and, unless it is the usual one, the feedrate by which corners are planned.
fn reported(value: (Quantity, Reported), by: CornerPlanning) -> Vec<(Quantity, Reported)> {
    let by = (by != CornerPlanning::default()).then(|| CORNERS_PLANNED_BY.word(by.word()));
    [Some(value), by].into_iter().flatten().collect()
}

fn variant(by: CornerPlanning) -> &'static str {
    if by == CornerPlanning::default() { "" } else { "planned as requested" }
}
