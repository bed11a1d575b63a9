//! Rests: the recorded machine does not move although its program continues.
//!
//! Along the fixes of a recording, a rest is a stretch of path of next to no length that took the recorded machine at
//! least [`MIN_REST_S`] s longer than the simulated one. A rest costs the lost time over it and over the ramps on both
//! sides. The place of the rest is the place at which the command was taken away, because the filters had run empty.
//!
//! | the tool rested | hypothesis |
//! |---|---|
//! | at a dwell, longer than it asks for | a wait before its line |
//! | at a function or a tool change | none of this module: a wait of that |
//! | where a long block meets a long block | a wait before the line of the later one |
//! | the same, where the simulated machine has braked to next to nothing | that wait, or a feed hold on the line before |
//! | the same, where more than one feed hold in 100 rests as near to an end by chance | likewise |
//! | anywhere else | a feed hold on the line |
//!
//! An operator who holds the feed while the machine brakes for the end of a block brings it to rest v (v/a + D)/2 behind
//! that end, where v is the feedrate there (mm/s), a the acceleration (mm/s²) and D the delay of the filters (s). If that is
//! no farther than a rest is known, the hold leaves the rest of a wait.
//!
//! Rests on one visit of a line count as one, at the place of the longer one. Times before the first mark and after the
//! last one are unknown: a recorder that starts before the machine does shows no rest.
//!
//! A hold that is hardly longer than the machine needs to stop leaves a shorter rest, because its ramps take up the
//! remainder of its cost. Inside a block, where no control stops by itself, such a rest counts all the same; at the ends
//! of blocks an exact stop may bring a machine to rest for a moment.
//!
//! A poll may find a machine at rest for a moment at a corner, at the bottom of a plunge or before a block that the
//! control has not read yet; and a state that a single poll shows lasted less than two polls. If feedrates were
//! recorded, a rest in a polled log is therefore a hold only if they show nothing but standstill for
//! [`MIN_STANDSTILL_POLLS`] polls, and if it cost as much: one poll in which it may have begun, one in which it may
//! have ended, and one that is certain.
//!
//! Limits: a hold shorter than the machine needs to stop leaves no rest, and is searched as a dip; a line that runs
//! several times is assumed to be held each time. More rests than [`MAX_HALTS`], or more than [`MAX_CHANCE_RESTS`] of which
//! most differ from the usual one by less than [`MAX_ALIKE_PART`] of it, are a property of the machine and not halts,
//! except for those more than [`MIN_RATIO_TO_USUAL`] times as long as usual. Rests at dwells are counted separately.

use std::ops::RangeInclusive;

use crate::identification::alignment::{Mark, Method, Visit, median, visits};
use crate::identification::diagnosis::evidence::{Candidate, Evidence, with_all};
use crate::identification::effects::{FEED_HOLD, Hypothesis, LINE, Reported, SECONDS, UNMODELLED_WAIT};
use crate::identification::fit::{FreeParameter, Run, VariationScale};
use crate::machine::{Handle, Machine};
use crate::simulation::feed::FeedPlan;
use crate::simulation::feed::limits::{TANGENTIAL_ACCELERATION_SHARE, acceleration, requested_feedrate};
use crate::simulation::profile::Profile;
use crate::simulation::toolpath::{Segment, Segments, Stop, Toolpath};

/// Shortest rest, s.
pub const MIN_REST_S: f64 = 0.1;
/// Longest stretch of path of a rest, mm, unless [`MAX_REST_DEVIATIONS`] are longer.
const MAX_REST_LENGTH_MM: f64 = 0.02;
/// Longest stretch of path of a rest, in standard deviations of a position.
const MAX_REST_DEVIATIONS: f64 = 6.0;
/// Least part of the time from one sample to the next, without programmed dwells, that a machine at rest loses.
const MIN_LOST_PART: f64 = 0.8;
/// Fewest samples for which a rest inside a block lasts that costs less than [`MIN_REST_S`].
const MIN_BRIEF_SAMPLES: usize = 3;
/// Least ratio of the length of a long block to that of a rest.
const MIN_BLOCK_TO_REST_RATIO: f64 = 10.0;
/// Most rests of one run that count as halts.
const MAX_HALTS: usize = 20;
/// Most rests that may be equally long by chance; more of them are a property of the machine.
const MAX_CHANCE_RESTS: usize = 3;
/// Largest difference of a rest from the usual one at which the two are equally long, as a part of the usual one.
const MAX_ALIKE_PART: f64 = 0.25;
/// Least ratio of a rest to the usual one from which on it is no property of the machine.
const MIN_RATIO_TO_USUAL: f64 = 4.0;
/// Largest feedrate that a control shows of a machine at rest, mm/s.
const MAX_STANDSTILL_MM_S: f64 = 0.2;
/// Fewest polls for which the recorded feedrate must show standstill.
const MIN_STANDSTILL_POLLS: f64 = 3.0;
/// First place on a line, as a part of its path, that lies behind the mark of the line in spite of rounding.
const MIN_SHARE_BEHIND_MARK: f64 = 1e-6;
/// Largest probability that a feed hold rests near an end of a block by chance, at which a rest there is still a wait.
const MAX_CHANCE: f64 = 0.01;
/// Longest halt, s.
const MAX_HALT_S: f64 = 3600.0;

/// Rest of the recorded machine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rest {
    /// Line of the program.
    pub line: u32,
    /// Part of the path of the line that precedes the rest; `None` if the rest precedes the line.
    pub place: Option<f64>,
    /// Distance at which the path of the line begins, mm.
    pub begin: f64,
    /// Time that the rest cost, s.
    pub seconds: f64,
    /// `true` if the rest is at a dwell of the program.
    pub at_dwell: bool,
    /// Line before, if a hold while the machine brakes for its end would leave the same rest.
    pub held_on: Option<u32>,
}

/// Returns the rests of a run that the simulation of a machine does not show, in the order of the path; those at dwells
/// follow the others. Rests at functions are left out.
pub fn rests(machine: &Machine, run: &Run) -> Vec<Rest> {
    let fixes = &run.alignment.fixes;
    let segments = &run.toolpath.segments;
    if fixes.len() < 3 || segments.is_empty() {
        return Vec::new();
    }
    let machine = run.machine(machine);
    let plan = run.plan(&machine);
    let profile = Profile::new(run.toolpath, &plan);
    let lost = lost_between(run, &machine, &profile);
    let noise = run.alignment.track.as_ref().map_or(0.0, |track| track.noise);
    let short = MAX_REST_LENGTH_MM.max(MAX_REST_DEVIATIONS * noise);
    let poll = match run.alignment.method {
        Method::Positions => 0.0,
        Method::Lines | Method::Feed => run.alignment.poll.unwrap_or(0.0),
    };
    let least = MIN_REST_S.max(2.0 * poll);
    let ramp = stopping_time(run, &machine, &plan);
    let may_be_held = |at: f64| may_be_held(run, &machine, &plan, &profile, at, short);
    let visits = visits(run.toolpath);
    let time = |mark: Option<&Mark>| mark.map_or(0.0, |mark| mark.time);
    let known = time(run.alignment.marks.first())..time(run.alignment.marks.last());
    let mut found: Vec<Rest> = Vec::new();
    let (mut from, mut to) = (0, 0);
    while from + 1 < fixes.len() {
        to = to.max(from + 1);
        while to + 1 < fixes.len() && fixes[to + 1].distance - fixes[from].distance <= short {
            to += 1;
        }
        if fixes[to].time <= known.start || known.end <= fixes[from].time {
            from += 1;
            continue;
        }
        let stops = stops_within(run, &profile, fixes[from].distance..=fixes[to].distance);
        let dwelt: f64 = stops.iter().filter_map(|stop| stop.cause.dwell()).sum();
        let stands = MIN_LOST_PART * (fixes[to].time - fixes[from].time - dwelt) <= lost(from, to);
        // At a low rate the first sample after a rest may be far from it.
        if !(stands && to == from + 1 || fixes[to].distance - fixes[from].distance <= short) {
            from += 1;
            continue;
        }
        // What still begins or ends it is part of it.
        let first = fixes[..from].partition_point(|fix| fix.time < fixes[from].time - ramp);
        let last =
            to + fixes[to + 1..].partition_point(|fix| fix.time <= fixes[to].time + ramp.max(2.0 * poll));
        let at = 0.5 * (fixes[from].distance + fixes[to].distance);
        let is_brief = || {
            let samples = fixes[to].sample.zip(fixes[from].sample).map_or(0, |(to, from)| to - from);
            // Only positions tell where inside a block a machine stands.
            let is_placed = run.alignment.method == Method::Positions;
            let is_long = MIN_BRIEF_SAMPLES <= samples && least <= lost(first, last);
            is_placed && stands && is_long && is_inside(segments, &profile, at, 2.0 * short)
        };
        if lost(from, to) < least && !is_brief() {
            from += 1;
            continue;
        }
        // At a low rate two fixes may be far apart, and the tool may rest anywhere between them.
        let near = short.max(0.5 * (fixes[to].distance - fixes[from].distance));
        let rest = match run.alignment.method {
            Method::Positions => rest_at(run, &profile, at, near, lost(first, last))
                .map(|rest| Rest { held_on: rest.held_on.filter(|_| may_be_held(rest.begin)), ..rest }),
            // Where the recorder slept the machine went on: one that stands says so.
            Method::Lines | Method::Feed
                if stood(run, fixes[from].time, fixes[to].time + poll)
                    .is_some_and(|seconds| seconds.min(lost(first, last)) < MIN_STANDSTILL_POLLS * poll) =>
            {
                None
            }
            Method::Lines | Method::Feed => {
                let middle = 0.5 * (fixes[from].time + fixes[to].time);
                rest_during(run, &visits, &profile, at, middle, lost(first, last))
            }
        };
        rest.into_iter().for_each(|rest| add(&mut found, rest));
        (from, to) = (to, to + 1);
    }
    let (at_dwells, elsewhere): (Vec<Rest>, Vec<Rest>) = found.into_iter().partition(|rest| rest.at_dwell);
    [halts(elsewhere), halts(at_dwells)].concat()
}

/// Returns `true` if a feed hold may leave a rest within `near` (mm) of an end of a block: the operator holds the feed while
/// the machine brakes for that end, or the blocks there are so short that a hold rests near an end by chance; see the
/// front of the module.
fn may_be_held(run: &Run, machine: &Machine, plan: &FeedPlan, profile: &Profile, at: f64, near: f64) -> bool {
    let segments = &run.toolpath.segments;
    let feedrate = profile.at_time(profile.time_at_distance(at)).velocity.norm();
    let segment = segments.at(segment_at(segments, profile, at));
    let overrun = 0.5 * feedrate * (feedrate / acceleration(&segment, machine) + plan.longest_delay());
    let after = segment_at(segments, profile, at + near);
    let both = segments.length(after.saturating_sub(1)) + segments.length(after);
    overrun <= near || MAX_CHANCE * both < 4.0 * near
}

/// Adds a rest to those found before it; consecutive rests at one place are joined.
fn add(found: &mut Vec<Rest>, rest: Rest) {
    match found.last_mut() {
        Some(before) if (before.line, before.begin) == (rest.line, rest.begin) => {
            let place = if before.seconds < rest.seconds { rest.place } else { before.place };
            *before = Rest { place, seconds: before.seconds + rest.seconds, ..rest };
        }
        _ => found.push(rest),
    }
}

/// Returns the longest time in which a machine comes to rest from a feed move of a run, s: a ramp at the acceleration
/// limit, and the filter delay. On the arc that blends two blocks, LinuxCNC brakes with half of the acceleration of its
/// weakest axis.
pub fn stopping_time(run: &Run, machine: &Machine, plan: &FeedPlan) -> f64 {
    let feeds = run.toolpath.segments.iter().filter(|segment| !segment.motion.is_rapid());
    let weakest = machine.axes.iter().map(|axis| axis.acceleration).fold(f64::INFINITY, f64::min);
    let has_blends = machine.interpolator.junction.blends_in_time();
    let on_blend = if has_blends { TANGENTIAL_ACCELERATION_SHARE * weakest } else { f64::INFINITY };
    let braking = |segment: &Segment| acceleration(segment, machine).min(on_blend);
    let ramps = feeds.map(|segment| requested_feedrate(&segment, machine) / braking(&segment));
    plan.longest_delay() + ramps.fold(0.0, f64::max)
}

/// Returns a function of the indices of two fixes of a run: the time that the recorded machine lost from one to the
/// other, s.
pub fn lost_between(run: &Run, machine: &Machine, profile: &Profile) -> impl Fn(usize, usize) -> f64 {
    let fixes = &run.alignment.fixes;
    let distances: Vec<f64> = fixes.iter().map(|fix| fix.distance).collect();
    let simulated = profile.crossing_times(&distances);
    let clock = machine.recorder.clock_ratio;
    move |from, to| (fixes[to].time - fixes[from].time) - clock * (simulated[to] - simulated[from])
}

/// Returns the rests that are no property of the machine.
fn halts(mut found: Vec<Rest>) -> Vec<Rest> {
    let mut seconds: Vec<f64> = found.iter().map(|rest| rest.seconds).collect();
    let usual = median(&mut seconds);
    let alike = seconds.iter().filter(|seconds| (*seconds - usual).abs() < MAX_ALIKE_PART * usual).count();
    if MAX_HALTS < found.len() || MAX_CHANCE_RESTS < found.len() && found.len() < 2 * alike {
        found.retain(|rest| MIN_RATIO_TO_USUAL * usual < rest.seconds);
    }
    if MAX_HALTS < found.len() { Vec::new() } else { found }
}

/// Returns the stops of the program within a part of the path, mm.
pub fn stops_within<'a>(run: &Run<'a>, profile: &Profile, part: RangeInclusive<f64>) -> &'a [Stop] {
    let Toolpath { segments, stops, .. } = run.toolpath;
    let at = |stop: &Stop| profile.distance_before(stop.after.min(segments.len()));
    let first = stops.partition_point(|stop| at(stop) < *part.start());
    let behind = &stops[first..];
    &behind[..behind.partition_point(|stop| at(stop) <= *part.end())]
}

/// Returns the segment at a distance along the path, mm; beyond the ends of the path, the first or the last one.
fn segment_at(segments: &Segments, profile: &Profile, at: f64) -> usize {
    let mut low = 0;
    let mut high = segments.len();
    while low + 1 < high {
        let middle = low.midpoint(high);
        if profile.distance_before(middle) <= at { low = middle } else { high = middle }
    }
    low
}

/// Returns `true` if a distance along the path is farther than `away` from both ends of its segment, mm.
fn is_inside(segments: &Segments, profile: &Profile, at: f64, away: f64) -> bool {
    let segment = segment_at(segments, profile, at);
    segment < segments.len()
        && away < at - profile.distance_before(segment)
        && away < profile.distance_before(segment + 1) - at
}

/// Returns the rest at a distance along the path, known to within `near`, mm. `None` near a function other than a
/// dwell, near the ends of the path, and where the control waits for a new spindle speed.
pub fn rest_at(run: &Run, profile: &Profile, at: f64, near: f64, seconds: f64) -> Option<Rest> {
    let segments = &run.toolpath.segments;
    let end = |segment: usize| profile.distance_before(segment);
    let around = at - 2.0 * near..=at + 2.0 * near;
    let stops = stops_within(run, profile, around.clone());
    if let Some(first) = stops.first() {
        let are_dwells = stops.iter().all(|stop| stop.cause.dwell().is_some());
        let line = first.line.0;
        let rest = Rest { line, place: None, begin: at, seconds, at_dwell: true, held_on: None };
        return are_dwells.then_some(rest);
    }
    if around.contains(&0.0) || around.contains(&profile.length()) {
        return None;
    }
    // There controls wait for the spindle, and an operator would hold the feed at just that place by chance alone.
    if run.toolpath.feeds_at_new_speed().any(|feed| around.contains(&end(feed.segment))) {
        return None;
    }
    let low = segment_at(segments, profile, at);
    let is_long = |segment: usize| MIN_BLOCK_TO_REST_RATIO * near < segments.length(segment);
    let boundary = [low, low + 1].into_iter().find(|segment| {
        (end(*segment) - at).abs() <= near
            && 0 < *segment
            && *segment < segments.len()
            && is_long(segment - 1)
            && is_long(*segment)
            && segments.at(segment - 1).line != segments.at(*segment).line
    });
    if let Some(boundary) = boundary {
        let [before, line] = [boundary - 1, boundary].map(|segment| segments.at(segment).line.0);
        let begin = end(boundary);
        return Some(Rest { line, place: None, begin, seconds, at_dwell: false, held_on: Some(before) });
    }
    let line = segments.at(low).line;
    let first = (0..=low).rev().take_while(|segment| segments.at(*segment).line == line).last()?;
    let after = (low..segments.len()).take_while(|segment| segments.at(*segment).line == line).last()? + 1;
    let place = (at - end(first)) / (end(after) - end(first)).max(1e-9);
    Some(Rest {
        line: line.0,
        place: Some(place.clamp(0.0, 1.0)),
        begin: end(first),
        seconds,
        at_dwell: false,
        held_on: None,
    })
}

/// Returns the longest time, s, for which the readings of the feed that begin between two times (s) show standstill
/// without a break; `None` if no feed was recorded. A reading holds until the next one.
fn stood(run: &Run, from: f64, to: f64) -> Option<f64> {
    let feed = run.alignment.feed.as_ref()?;
    let first = feed.time.partition_point(|time| *time < from);
    let last = feed.time.partition_point(|time| *time <= to);
    let (mut longest, mut since): (f64, Option<f64>) = (0.0, None);
    for at in first..last {
        let end = feed.time.get(at + 1).copied().unwrap_or(to);
        if feed.values[at] <= MAX_STANDSTILL_MM_S {
            longest = longest.max(end - *since.get_or_insert(feed.time[at]));
        } else {
            since = None;
        }
    }
    Some(longest)
}

/// Returns the rest at a time of a recording that has lines but no positions. The rest is on the line that was recorded
/// last, as a rest is longer than the time between two polls. `None` if that line has a function or no path.
fn rest_during(
    run: &Run,
    visits: &[Visit],
    profile: &Profile,
    at: f64,
    time: f64,
    seconds: f64,
) -> Option<Rest> {
    let marks = &run.alignment.marks;
    let named = marks.partition_point(|mark| mark.time <= time).checked_sub(1)?;
    let visit = visits.iter().find(|visit| visit.begin == marks[named].place)?;
    if !visit.stops.is_empty() || visit.segments.is_empty() {
        return None;
    }
    let begin = profile.distance_before(visit.segments.start);
    let length = profile.distance_before(visit.segments.end) - begin;
    let place = ((at - begin) / length).clamp(MIN_SHARE_BEHIND_MARK, 1.0);
    let line = visit.line.0;
    Some(Rest { line, place: Some(place), begin, seconds, at_dwell: false, held_on: None })
}

impl Rest {
    /// Returns the hypotheses of the halts that leave this rest.
    pub fn hypotheses(self) -> Vec<Hypothesis> {
        let held = self.held_on.map(|line| Rest { line, place: Some(1.0), held_on: None, ..self });
        [self].into_iter().chain(held).map(Rest::hypothesis).collect()
    }

    /// Returns the hypothesis of the halt that leaves this rest, a wait where both are possible.
    pub fn hypothesis(self) -> Hypothesis {
        let Rest { line, place, seconds, .. } = self;
        let report = move |seconds| {
            vec![(LINE, Reported::Number(f64::from(line))), (SECONDS, Reported::Number(seconds))]
        };
        let start = seconds.clamp(0.0, MAX_HALT_S);
        let freed = |table: &str| {
            let handle = Handle::entry(table, line);
            FreeParameter::new(handle, start, (0.0, MAX_HALT_S), VariationScale::Difference)
                .counted_in_cycles()
                .linear()
        };
        let (effect, freed) = match place {
            Some(place) => {
                let hold = freed("halts.feed_holds").also(move |machine| {
                    machine.halts.feed_hold_places.insert(line, place);
                });
                (FEED_HOLD, hold)
            }
            None => (UNMODELLED_WAIT, freed("halts.waits")),
        };
        let trials = [0.8, 1.0, 1.25].iter().map(|part| part * start).collect();
        Hypothesis::single(effect, freed, trials, report).variant(format!("line {line}"))
    }
}

/// Returns the feed holds that the runs show and whose gain exceeds `price`, each with its gain: by how much the cost
/// falls because of it. All are found at once, because no other cause leaves such a trace, and every other cause is
/// hard to see until they are known.
pub fn feed_holds(base: &Machine, runs: &[Run], price: f64) -> Vec<(Candidate, f64)> {
    let mut candidates: Vec<Candidate> = Vec::new();
    for run in runs {
        for rest in rests(base, run).into_iter().filter(|rest| rest.place.is_some()) {
            let hypothesis = rest.hypothesis();
            let known = |other: &Candidate| other.hypothesis.variant == hypothesis.variant;
            if !candidates.iter().any(known) {
                let (values, deviations) = (vec![rest.seconds], vec![f64::NAN]);
                candidates.push(Candidate {
                    hypothesis,
                    values,
                    deviations,
                    cost: f64::NAN,
                    beside: Vec::new(),
                });
            }
        }
    }
    let Some((first, rest)) = candidates.split_first() else { return Vec::new() };
    let evidence = Evidence::of(runs, &with_all(base, &candidates));
    let (first, rest) = evidence.refined(base, first, rest);
    let mut candidates = vec![first];
    candidates.extend(rest);
    let gains = evidence.gains(base, &candidates);
    let each = candidates.into_iter().zip(gains);
    each.filter(|(candidate, gain)| price < *gain && MIN_REST_S < candidate.values[0]).collect()
}
