//! Rests: the recorded machine stands though the program goes on.
//!
//! Along the fixes of a recording a rest is a stretch of path of next to no length that took the recorded
//! machine at least [`LEAST`] s longer than the simulated one. What the rest cost is the lost time over
//! it and the ramps on both sides; where the tool stood is where the command was taken away, because
//! the filters had run empty.
//!
//! | the tool stood | hypothesis |
//! |---|---|
//! | at a dwell, longer than it asks for | a wait before its line |
//! | at a function or a tool change | none of this module: a wait of that |
//! | where a long block meets a long block | a wait before the line of the later one |
//! | anywhere else | a feed hold on the line |
//!
//! Rests of one visit of a line are one, where the longer one was. Before the first mark and behind the last nothing
//! is known of times: a recorder that runs before the machine does shows no rest.
//!
//! A hold that is hardly longer than the filter delay leaves a shorter rest, as its ramps take up the rest of what it
//! cost. Inside a block, where no control stops by itself, that counts instead; at the ends of blocks a machine may be
//! met standing for a moment by an exact stop.
//!
//! A machine that is polled may be met standing for a moment at a corner, at the bottom of a plunge or before a
//! block that is not read yet; and what is seen once was so for less than two polls. There a rest is a hold
//! only where feedrates were recorded that say nothing else for [`SAID`] polls, and it cost as much: one in
//! which it may have begun, one in which it may have ended, and one that is certain.
//!
//! Limits: a hold shorter than the filter delay leaves no rest, and is looked for as a dip; a line that is run
//! several times is taken to be held each time; more rests than [`MOST`], or than [`FEW`] of which most are
//! [`ALIKE`], are a property of the machine and not halts, but for those that are [`OUT`] times as long as usual.
//! Those at dwells are counted by themselves.

use std::ops::RangeInclusive;

use crate::identification::alignment::{Method, Visit, median, visits};
use crate::identification::diagnosis::evidence::{Candidate, Evidence, with_all};
use crate::identification::effects::{FEED_HOLD, Hypothesis, LINE, Reported, SECONDS, UNMODELLED_WAIT};
use crate::identification::fit::{FreeParameter, Run, VariationScale};
use crate::machine::{Handle, Machine};
use crate::simulation::profile::Profile;
use crate::simulation::toolpath::{Segments, Stop, Toolpath};

/// The shortest rest, s.
pub const LEAST: f64 = 0.1;
/// A rest is this short along the path, mm, or so many standard deviations of a position.
const SHORT: (f64, f64) = (0.02, 6.0);
/// From one sample to the next the machine stood if it lost this part of the time.
const STANDS: f64 = 0.8;
/// A rest inside a block that is shorter than the shortest lasts for so many samples.
const SEEN: usize = 3;
/// A block is long that is so many times as long as a rest.
const LONG: f64 = 10.0;
/// Rests of one run at most.
const MOST: usize = 20;
/// Rests that may be as long as each other by chance; more of them are the machine's.
const FEW: usize = 3;
/// Rests are alike whose times differ by this part.
const ALIKE: f64 = 0.25;
/// A rest that is so many times as long as usual is none of the machine's.
const OUT: f64 = 4.0;
/// What a machine that stands says its feedrate is, at most, mm/s.
const STILL: f64 = 0.2;
/// For how many polls it must say so.
const SAID: f64 = 3.0;
/// The first place on a line, as a part of its path, that lies behind the mark of the line whatever rounding does.
const BEHIND_MARK: f64 = 1e-6;
/// Longest halt, s.
const LONGEST: f64 = 3600.0;

/// A rest of the recorded machine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rest {
    /// Line of the program.
    pub line: u32,
    /// The part of the line's path before it; none where it is before the line.
    pub place: Option<f64>,
    /// Where the line's path begins, mm.
    pub begin: f64,
    /// What it cost, s.
    pub seconds: f64,
    /// It is at a dwell of the program.
    pub at_dwell: bool,
}

/// The rests of a run that a machine does not have, by place, without those at functions.
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
    let short = SHORT.0.max(SHORT.1 * noise);
    let poll = match run.alignment.method {
        Method::Positions => 0.0,
        Method::Lines | Method::Feed => run.alignment.poll.unwrap_or(0.0),
    };
    let least = LEAST.max(2.0 * poll);
    let ramp = plan.longest_delay();
    let visits = visits(run.toolpath);
    let marks = &run.alignment.marks;
    let known = marks.first().map_or(0.0, |mark| mark.time)..marks.last().map_or(0.0, |mark| mark.time);
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
        let stands = STANDS * (fixes[to].time - fixes[from].time - dwelt) <= lost(from, to);
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
            let is_placed = matches!(run.alignment.method, Method::Positions);
            let is_one = stands && SEEN <= samples && least <= lost(first, last);
            is_one && is_placed && is_inside(segments, &profile, at, 2.0 * short)
        };
        if lost(from, to) < least && !is_brief() {
            from += 1;
            continue;
        }
        let rest = match run.alignment.method {
            Method::Positions => rest_at(run, &profile, at, short, lost(first, last)),
            // Where the recorder slept the machine went on: one that stands says so.
            Method::Lines | Method::Feed
                if stood(run, fixes[from].time, fixes[to].time + poll)
                    .is_some_and(|seconds| seconds.min(lost(first, last)) < SAID * poll) =>
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

/// Adds a rest to those before it; rests that follow one another at one place are one.
fn add(found: &mut Vec<Rest>, rest: Rest) {
    match found.last_mut() {
        Some(before) if (before.line, before.begin) == (rest.line, rest.begin) => {
            let place = if before.seconds < rest.seconds { rest.place } else { before.place };
            *before = Rest { place, seconds: before.seconds + rest.seconds, ..rest };
        }
        _ => found.push(rest),
    }
}

/// What the recorded machine lost from one fix of a run to another, by their indices, s.
pub fn lost_between(run: &Run, machine: &Machine, profile: &Profile) -> impl Fn(usize, usize) -> f64 {
    let fixes = &run.alignment.fixes;
    let distances: Vec<f64> = fixes.iter().map(|fix| fix.distance).collect();
    let simulated = profile.crossing_times(&distances);
    let clock = machine.recorder.clock_ratio;
    move |from, to| (fixes[to].time - fixes[from].time) - clock * (simulated[to] - simulated[from])
}

/// The rests that are no property of the machine.
fn halts(mut found: Vec<Rest>) -> Vec<Rest> {
    let mut seconds: Vec<f64> = found.iter().map(|rest| rest.seconds).collect();
    let usual = median(&mut seconds);
    let alike = seconds.iter().filter(|seconds| (*seconds - usual).abs() < ALIKE * usual).count();
    if MOST < found.len() || FEW < found.len() && found.len() < 2 * alike {
        found.retain(|rest| OUT * usual < rest.seconds);
    }
    if MOST < found.len() { Vec::new() } else { found }
}

/// The stops of the program within a part of the path, mm.
pub fn stops_within<'a>(run: &Run<'a>, profile: &Profile, part: RangeInclusive<f64>) -> &'a [Stop] {
    let Toolpath { segments, stops, .. } = run.toolpath;
    let at = |stop: &Stop| profile.distance_before(stop.after.min(segments.len()));
    let first = stops.partition_point(|stop| at(stop) < *part.start());
    let behind = &stops[first..];
    &behind[..behind.partition_point(|stop| at(stop) <= *part.end())]
}

/// The segment at a distance along the path, mm; the first or the last one beyond its ends.
fn segment_at(segments: &Segments, profile: &Profile, at: f64) -> usize {
    let mut low = 0;
    let mut high = segments.len();
    while low + 1 < high {
        let middle = low.midpoint(high);
        if profile.distance_before(middle) <= at { low = middle } else { high = middle }
    }
    low
}

/// Whether a distance along the path is farther from both ends of its segment than so much, mm.
fn is_inside(segments: &Segments, profile: &Profile, at: f64, away: f64) -> bool {
    let segment = segment_at(segments, profile, at);
    segment < segments.len()
        && away < at - profile.distance_before(segment)
        && away < profile.distance_before(segment + 1) - at
}

/// The rest at a distance along the path, known but for `near` (mm); none where a function is near that is no dwell.
pub fn rest_at(run: &Run, profile: &Profile, at: f64, near: f64, seconds: f64) -> Option<Rest> {
    let segments = &run.toolpath.segments;
    let end = |segment: usize| profile.distance_before(segment);
    let around = at - 2.0 * near..=at + 2.0 * near;
    let stops = stops_within(run, profile, around.clone());
    if let Some(first) = stops.first() {
        let are_dwells = stops.iter().all(|stop| stop.cause.dwell().is_some());
        let rest = Rest { line: first.line.0, place: None, begin: at, seconds, at_dwell: true };
        return are_dwells.then_some(rest);
    }
    if around.contains(&0.0) || around.contains(&profile.length()) {
        return None;
    }
    // There controls wait for the spindle, and an operator would hold the feed at just that place by chance alone.
    if run.toolpath.feeds_at_new_speed().any(|segment| around.contains(&end(segment))) {
        return None;
    }
    let low = segment_at(segments, profile, at);
    let is_long = |segment: usize| LONG * near < segments.length(segment);
    let boundary = [low, low + 1].into_iter().find(|segment| {
        (end(*segment) - at).abs() <= near
            && 0 < *segment
            && *segment < segments.len()
            && is_long(segment - 1)
            && is_long(*segment)
            && segments.at(segment - 1).line != segments.at(*segment).line
    });
    if let Some(boundary) = boundary {
        return Some(Rest {
            line: segments.at(boundary).line.0,
            place: None,
            begin: at,
            seconds,
            at_dwell: false,
        });
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
    })
}

/// For how long at most, s, the readings of the feed that begin between two times (s) say without a break that
/// the machine stands; none where no feed was recorded. A reading holds until the next one.
fn stood(run: &Run, from: f64, to: f64) -> Option<f64> {
    let feed = run.alignment.feed.as_ref()?;
    let first = feed.time.partition_point(|time| *time < from);
    let last = feed.time.partition_point(|time| *time <= to);
    let (mut longest, mut since): (f64, Option<f64>) = (0.0, None);
    for at in first..last {
        let end = feed.time.get(at + 1).copied().unwrap_or(to);
        if feed.values[at] <= STILL {
            longest = longest.max(end - *since.get_or_insert(feed.time[at]));
        } else {
            since = None;
        }
    }
    Some(longest)
}

/// The rest at a time of a recording that names lines but no positions: on the line that was named last, as a
/// rest is longer than the time between two looks. None where that line has a function.
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
    let place = ((at - begin) / length).clamp(BEHIND_MARK, 1.0);
    Some(Rest { line: visit.line.0, place: Some(place), begin, seconds, at_dwell: false })
}

impl Rest {
    /// The halt that would leave it.
    pub fn hypothesis(self) -> Hypothesis {
        let Rest { line, place, seconds, .. } = self;
        let report = move |seconds| {
            vec![(LINE, Reported::Number(f64::from(line))), (SECONDS, Reported::Number(seconds))]
        };
        let start = seconds.clamp(0.0, LONGEST);
        let freed = |table: &str| {
            let handle = Handle::entry(table, line);
            FreeParameter::new(handle, start, (0.0, LONGEST), VariationScale::Difference)
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

/// The feed holds that the runs show, all at once, each with what the cost falls by because of it: nothing else
/// leaves such a trace, and until they are known everything else is hard to see.
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
    each.filter(|(candidate, gain)| price < *gain && LEAST < candidate.values[0]).collect()
}
