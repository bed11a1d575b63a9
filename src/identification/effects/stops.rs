//! Effects at single places of the path: full stops and waits.

use std::collections::{BTreeMap, BTreeSet};

use crate::identification::alignment::ProgramPlace;
use crate::identification::effects::effect::{Context, Effect, Hypothesis, ratios};
use crate::identification::effects::parameters::{self, Adjustable};
use crate::identification::effects::report::{
    ANGLE, ANGLE_BOUNDS, AT, CODE, LINE, OR_CODE, RAMP, Reported, SECONDS,
};
use crate::identification::effects::waits::StopKind;
use crate::identification::fit::{FreeParameter, Run};
use crate::machine::{InPosition, Junction};
use crate::simulation::ordered::sort_by_number;
use crate::simulation::toolpath::{Segment, Stop, Toolpath, angle_between};

/// Least difference between the successive turn angles of corners for a stopping angle between them to be tried,
/// rad.
const SAME_ANGLE_RAD: f64 = 0.01;
/// Largest number of stopping angles tried besides 0; those in the widest gaps between the turn angles of corners
/// are kept.
const MOST_ANGLES: usize = 16;
/// Largest number of kinds of stops at one place that are compared with one another.
const MOST_BESIDE: usize = 8;
/// Largest number of rapids in the programs for which a wait at a rapid counts as one of its line. A machine that
/// waits for position waits at every rapid, and so few rapids do not show that.
const MAX_SINGLE_RAPIDS: usize = 4;
/// Times added to the assumed wait in the values tried first, s.
const LONGER_S: [f64; 6] = [0.0, 0.3, 1.0, 3.0, 8.0, 20.0];

pub fn exact_stops(effect: Effect, context: &Context) -> Vec<Hypothesis> {
    let gaps = gaps(context.runs);
    let trials = gaps.iter().map(|(low, high)| 0.5 * (low + high)).collect();
    let report = move |angle: f64| {
        let mut all = vec![ANGLE.number(angle.to_degrees())];
        if let Some((low, high)) = gaps.iter().find(|(low, high)| *low <= angle && angle <= *high) {
            all.push((ANGLE_BOUNDS, Reported::List(vec![low.to_degrees(), high.to_degrees()])));
        }
        all
    };
    let angle = parameters::EXACT_STOP_ANGLE.tried();
    let exact_path = exact_path(effect, context, angle.clone());
    let stops = Hypothesis::single(effect, angle, trials, report).at_trials_only();
    [stops].into_iter().chain(exact_path).collect()
}

/// Returns the hypothesis of LinuxCNC's G61, which stops at corners by another law than its G61.1; `None` if the
/// machine does not have LinuxCNC's junctions, or if the programs blend no feed moves. At which tangents it stops
/// depends on the largest override, which a calibration on blended corners does not show: each that a control may plan
/// for is tried.
fn exact_path(effect: Effect, context: &Context, angle: FreeParameter) -> Option<Hypothesis> {
    let interpolator = &context.machine.interpolator;
    let is_blended = |segment: Segment| !segment.motion.is_rapid() && !segment.exact_stop;
    let has_blends = context.runs.iter().any(|run| run.toolpath.segments.iter().any(is_blended));
    if !has_blends || !matches!(interpolator.junction, Junction::AccelerationBlend | Junction::ParabolicBlend)
    {
        return None;
    }
    let largest = angle.bounds.1;
    let freed = angle.also(|machine| machine.interpolator.junction = Junction::ExactPath);
    let planned =
        std::iter::once(interpolator.max_override).chain(parameters::MAX_OVERRIDE.guesses.iter().copied());
    let trials = planned.map(|planned| vec![largest, planned]).collect();
    let report = |_: &[f64]| vec![AT.word("corners")];
    let freed = vec![freed, parameters::MAX_OVERRIDE.tried()];
    Some(Hypothesis::new(effect, freed, trials, report).at_trials_only())
}

/// Returns the hypotheses of a wait for position at the ends of rapid moves, some of which become full stops by it,
/// and at the existing full stops.
pub fn in_position_waits(effect: Effect, context: &Context) -> Vec<Hypothesis> {
    let Context { machine, runs, .. } = context;
    let rapids =
        runs.iter().flat_map(|run| run.toolpath.segments.iter()).filter(|segment| segment.motion.is_rapid());
    let has_rapid = MAX_SINGLE_RAPIDS < rapids.count();
    let has_stops = machine.interpolator.stopping_angle() < std::f64::consts::PI
        || runs.iter().any(|run| run.toolpath.segments.iter().any(|segment| segment.exact_stop));
    let of = |at: InPosition| {
        let freed =
            parameters::IN_POSITION_WAIT.tried().also(move |machine| machine.halts.in_position_at = at);
        let (shortest, longest) = freed.bounds;
        let report = move |value| vec![SECONDS.number(value), AT.word(at.word())];
        Hypothesis::single(effect, freed, ratios(shortest, longest, 8), report).variant(at.word())
    };
    let kinds = [(InPosition::RapidEnds, has_rapid), (InPosition::ExactStops, has_stops)];
    kinds.into_iter().filter(|(_, is_offered)| *is_offered).map(|(at, _)| of(at)).collect()
}

/// Returns the hypotheses of a wait for the spindle: of the feed at S words in blocks of motion, and of the first feed move
/// at a new speed, for a certain time or for the remainder of a ramp.
pub fn spindle_waits(effect: Effect, context: &Context) -> Vec<Hypothesis> {
    let runs = &context.runs;
    let of = |parameter: Adjustable, at: &'static str, plc_words: usize| {
        let report = move |value| vec![SECONDS.number(value), AT.word(at)];
        let freed = parameter.tried();
        Hypothesis::single(effect, freed, ratios(0.05, 10.0, 10), report).variant(at).answering(plc_words)
    };
    let has_words = runs.iter().any(|run| run.toolpath.speed_changes().next().is_some());
    let has_feeds = runs.iter().any(|run| run.toolpath.feeds_at_new_speed().next().is_some());
    let all = [
        (has_words, parameters::SPINDLE_CHANGE_WAIT, "S words", 1),
        (has_feeds, parameters::SPINDLE_AT_FEED_WAIT, "first feed moves", words_before_feeds(runs)),
    ];
    let offered = all.into_iter().filter(|(is_offered, ..)| *is_offered);
    let waits = offered.map(|(_, parameter, at, plc_words)| of(parameter, at, plc_words));
    waits.chain(ramp_at_feeds(effect, runs)).collect()
}

/// Returns the hypothesis that first feed moves wait for the remainder of the ramp of the spindle; `None` without two
/// of them, since a single wait shows no law.
fn ramp_at_feeds(effect: Effect, runs: &[Run]) -> Option<Hypothesis> {
    let changes: Vec<f64> =
        runs.iter().flat_map(|run| run.toolpath.feeds_at_new_speed()).map(|feed| feed.change).collect();
    if changes.len() < 2 {
        return None;
    }
    let largest = changes.iter().copied().fold(0.0, f64::max);
    let report = move |ramp: f64| {
        vec![SECONDS.number(ramp * largest), RAMP.number(1e3 * ramp), AT.word("first feed moves")]
    };
    let freed = parameters::SPINDLE_RAMP_AT_FEED.tried();
    let hypothesis = Hypothesis::single(effect, freed, ratios(2e-5, 5e-3, 12), report);
    Some(hypothesis.variant("ramp at first feed moves").answering(words_before_feeds(runs)))
}

/// Returns the largest number of words that the PLC answers directly before a first feed move at a new speed: at least
/// one, for the spindle. Nothing moves between them and the wait of the feed.
fn words_before_feeds(runs: &[Run]) -> usize {
    let words = |toolpath: &Toolpath, feed: usize| -> usize {
        let before = toolpath.stops_at(feed).iter();
        before.filter_map(|stop| StopKind::of(&stop.cause)).map(StopKind::plc_words).sum()
    };
    let of_run =
        |run: &Run| run.toolpath.feeds_at_new_speed().map(|feed| words(run.toolpath, feed.segment)).max();
    runs.iter().filter_map(of_run).fold(1, usize::max)
}

/// Returns the hypotheses of a longer or shorter wait at each kind of stop.
pub fn waits(effect: Effect, context: &Context) -> Vec<Hypothesis> {
    let Context { machine, runs, .. } = context;
    let mut lines: BTreeMap<StopKind, Vec<u32>> = BTreeMap::new();
    for stop in runs.iter().flat_map(|run| &run.toolpath.stops) {
        if let Some(kind) = StopKind::of(&stop.cause) {
            lines.entry(kind).or_default().push(stop.line.0);
        }
    }
    // Of words that are not told apart all explain the same: those come first of which the machine file says nothing.
    let mut waits: Vec<(StopKind, Vec<u32>)> = lines.into_iter().collect();
    sort_by_number(&mut waits, |(kind, _)| f64::from(0.0 < kind.value(machine)));
    let companions = companions(runs);
    let of = |(kind, lines): (StopKind, Vec<u32>)| {
        let others =
            companions[&kind].iter().filter(|other| **other != kind && companions[other].contains(&kind));
        wait(effect, kind, kind.value(machine), lines[0], others.copied().collect())
    };
    waits.into_iter().map(of).collect()
}

/// Returns the intervals of angles (rad) in which no turn angle of a corner lies: all stopping angles within one
/// interval stop at the same corners.
fn gaps(runs: &[Run]) -> Vec<(f64, f64)> {
    let mut turns = vec![0.0];
    for run in runs {
        turns.extend(
            run.toolpath
                .segments
                .pairs()
                .map(|(before, after)| angle_between(&before.tangent(before.length), &after.tangent(0.0))),
        );
    }
    turns.sort_by(f64::total_cmp);
    let mut gaps: Vec<(f64, f64)> = turns
        .windows(2)
        .map(|pair| (pair[0], pair[1]))
        .filter(|(low, high)| SAME_ANGLE_RAD < high - low)
        .collect();
    sort_by_number(&mut gaps, |gap| -(gap.1 - gap.0));
    gaps.truncate(MOST_ANGLES);
    sort_by_number(&mut gaps, |gap| gap.0);
    // At all ends of blocks, even where nothing turns.
    gaps.insert(0, (0.0, 0.0));
    gaps
}

/// Returns, for each kind of stop, the kinds that occur together with each of its stops, without motion or a mark
/// between them.
fn companions(runs: &[Run]) -> BTreeMap<StopKind, BTreeSet<StopKind>> {
    let mut all: BTreeMap<StopKind, BTreeSet<StopKind>> = BTreeMap::new();
    for run in runs {
        // The stops after which a mark tells them from the next one, in ascending order as the marks.
        let told: Vec<usize> = (run.alignment.marks.iter())
            .filter_map(|mark| match mark.place {
                ProgramPlace::After(stop) => Some(stop),
                ProgramPlace::Stop(stop) => stop.checked_sub(1),
                ProgramPlace::Start | ProgramPlace::Along(_) => None,
            })
            .collect();
        let stops: Vec<(usize, &Stop)> = run.toolpath.stops.iter().enumerate().collect();
        for group in stops.chunk_by(|a, b| a.1.after == b.1.after && told.binary_search(&a.0).is_err()) {
            let kinds: BTreeSet<StopKind> =
                group.iter().filter_map(|(_, stop)| StopKind::of(&stop.cause)).collect();
            for kind in &kinds {
                let beside = if kinds.len() <= MOST_BESIDE { kinds.clone() } else { [*kind].into() };
                all.entry(*kind).or_insert_with(|| beside.clone()).retain(|other| beside.contains(other));
            }
        }
    }
    all
}

/// Returns the hypothesis of a longer or shorter wait at one kind of stop. `believed` is the assumed wait, s;
/// `others` are the kinds that the recording cannot distinguish from it.
fn wait(effect: Effect, kind: StopKind, believed: f64, line: u32, others: Vec<StopKind>) -> Hypothesis {
    let plc_words = kind.plc_words() + others.iter().map(|other| other.plc_words()).sum::<usize>();
    let words: Vec<String> = others.into_iter().map(StopKind::word).collect();
    let report = move |value: f64| {
        let mut all =
            vec![LINE.number(f64::from(line)), CODE.word(kind.word()), SECONDS.number(value - believed)];
        if !words.is_empty() {
            all.push(OR_CODE.word(words.join(", ")));
        }
        all
    };
    let trials = LONGER_S.iter().map(|seconds| believed + seconds).collect();
    Hypothesis::single(effect, freed(kind, believed), trials, report)
        .variant(kind.word())
        .answering(plc_words)
}

/// Returns the wait at a kind of stop as a free parameter, which begins with `believed` (s). A longer tool change makes the first
/// one longer by as much.
fn freed(kind: StopKind, believed: f64) -> FreeParameter {
    let freed = kind.freed(believed);
    if kind != StopKind::ToolChange {
        return freed;
    }
    freed.with(|machine, seconds| {
        let times = &mut machine.times;
        let longer = seconds - times.tool_change;
        times.tool_change = seconds;
        times.first_tool_change = times.first_tool_change.map(|first| (first + longer).max(0.0));
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::Machine;

    #[test]
    fn longer_tool_changes_make_the_first_one_longer_by_as_much() {
        let mut machine = Machine::default();
        machine.times.tool_change = 4.0;
        machine.times.first_tool_change = Some(1.0);
        let longer = freed(StopKind::ToolChange, 4.0);
        longer.apply(&mut machine, 6.5);
        assert_eq!((machine.times.tool_change, machine.times.first_tool_change), (6.5, Some(3.5)));
        // The same value once more changes nothing.
        longer.apply(&mut machine, 6.5);
        assert_eq!(machine.times.first_tool_change, Some(3.5));
        machine.times.first_tool_change = None;
        longer.apply(&mut machine, 7.0);
        assert_eq!(machine.times.first_tool_change, None);
    }
}
