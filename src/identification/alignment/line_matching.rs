//! Recorded line numbers → marks at the visits of the program.
//!
//! Polling skips short blocks: the recorded lines are a subsequence of the visits. Each recorded line is
//! matched with the next visit of that line, so that loops and subprograms are followed in order. A recorded
//! visit began within the last poll, and no longer ago than it lasts:
//!
//! ```text
//! begin = stamp − w/2 ± w/√12,    w = min(p, d)      p: time between polls, d: of the visit, s
//! ```
//!
//! where p is the median time between all stamps of line and feed, which are polled together, and d the
//! duration on the assumed machine. With w = p for every visit, every long block after short ones would be
//! too short.
//!
//! Some controls count lines from 0, or record the line before the current one; the offset that fits most
//! visits is used.
//!
//! Between the marks the distance is the integral of the feed, scaled to match the next mark; only charts use
//! it.

use std::collections::HashMap;
use std::ops::Range;

use crate::identification::alignment::map_matching::median;
use crate::identification::alignment::place::{ProgramPlace, Visit};
use crate::identification::alignment::{AlignmentError, Fix, Mark};
use crate::identification::recording::{Channel, Recording, Sampling};

/// Possible offsets of a control's line numbers, the likeliest first.
const LINE_OFFSETS: [i64; 5] = [0, 1, -1, 2, -2];
/// Least uncertainty of a stamp, s: controls update their display in steps.
const MIN_STAMP_DEVIATION_S: f64 = 0.005;
/// Least part of the recorded lines with motion or a wait that must be in order.
const MIN_PART_IN_ORDER: f64 = 0.9;

/// Largest number of lines without effect after the last visit that still belong to the program.
const MAX_LINES_BEHIND_END: i64 = 10;

/// The alignment by line numbers.
pub struct LineMatch {
    /// Beginnings of visits.
    pub marks: Vec<Mark>,
    /// Visit of each mark.
    pub visits: Vec<usize>,
    /// Recorded lines in the order of the visits, as a part of all recorded lines that have visits.
    pub in_order: f64,
    /// Time between polls, s.
    pub poll: f64,
    /// Visit of the first recorded line.
    pub first: usize,
    /// Offset added to the recorded numbers.
    pub count: i64,
}

/// Returns the marks of a recording by its line numbers, within `run` (s); `durations` (s) are the durations
/// of the visits on the assumed machine.
///
/// # Errors
///
/// Returns an error if the line numbers are not those of the program in its order.
pub fn follow(
    recording: &Recording,
    run: &Range<f64>,
    visits: &[Visit],
    durations: &[f64],
) -> Result<LineMatch, AlignmentError> {
    let line = recording.line.as_ref().ok_or(AlignmentError::NothingToFollow)?.during(run);
    let poll = poll(recording, &line, run);
    let mut places: HashMap<i64, Vec<usize>> = HashMap::new();
    for (index, visit) in visits.iter().enumerate() {
        places.entry(i64::from(visit.line.0)).or_default().push(index);
    }
    let tried = LINE_OFFSETS.map(|count| in_order(&line, &places, count));
    // The first of the best offsets: offsets that fit equally well cannot be distinguished.
    let mut best = 0;
    for at in 1..tried.len() {
        if tried[best].len() < tried[at].len() {
            best = at;
        }
    }
    let count = LINE_OFFSETS[best];
    // Lines behind the end of the program do not belong to it; lines without effect between its blocks do.
    let end = visits.iter().map(|visit| i64::from(visit.line.0)).max().unwrap_or(0) + MAX_LINES_BEHIND_END;
    let known = line.values.iter().map(|value| i64::from(*value) + count);
    let known = known.filter(|value| places.contains_key(value) || end < *value);
    let in_order = tried[best].len() as f64 / known.count().max(1) as f64;
    if tried[best].len() < 3 || in_order < MIN_PART_IN_ORDER {
        return Err(AlignmentError::LinesDoNotFit { in_order });
    }
    let mut marks = Vec::new();
    let mut named = Vec::new();
    for &(event, visit) in &tried[best] {
        // The line that is current at the start of the run began at an unknown time.
        if event == 0 {
            continue;
        }
        let width = poll.min(durations[visit]);
        let deviation = (width / 12.0f64.sqrt()).hypot(MIN_STAMP_DEVIATION_S);
        marks.push(Mark { place: visits[visit].begin, time: line.time[event] - 0.5 * width, deviation });
        named.push(visit);
    }
    let first = tried[best].first().map_or(0, |(_, visit)| *visit);
    Ok(LineMatch { marks, visits: named, in_order, first, count, poll })
}

/// Returns the events whose line has a visit later than those before, each with that visit.
fn in_order(line: &Channel<u32>, places: &HashMap<i64, Vec<usize>>, count: i64) -> Vec<(usize, usize)> {
    let mut found = Vec::new();
    let mut next = 0;
    let mut last = None;
    for (event, value) in line.values.iter().enumerate() {
        if last == Some(*value) {
            continue;
        }
        last = Some(*value);
        let Some(all) = places.get(&(i64::from(*value) + count)) else { continue };
        if let Some(&visit) = all.get(all.partition_point(|visit| *visit < next)) {
            found.push((event, visit));
            next = visit + 1;
        }
    }
    found
}

/// Returns the median time between stamps, s.
fn poll(recording: &Recording, line: &Channel<u32>, run: &Range<f64>) -> f64 {
    let feed = recording.feed.as_ref().map(|feed| feed.during(run));
    let mut stamps: Vec<f64> = line.time.to_vec();
    stamps.extend(feed.iter().flat_map(|feed| feed.time.iter().copied()));
    stamps.sort_by(f64::total_cmp);
    // Stamps of one poll are closer together than polls are.
    let mut between: Vec<f64> =
        stamps.windows(2).map(|pair| pair[1] - pair[0]).filter(|between| 0.0 < *between).collect();
    let typical = median(&mut between);
    between.retain(|between| 0.5 * typical < *between);
    median(&mut between)
}

/// Returns the distances of the tool between the marks, by the feed.
pub fn fixes(recording: &Recording, marks: &[Mark], distance_of: impl Fn(ProgramPlace) -> f64) -> Vec<Fix> {
    let Some(feed) = &recording.feed else {
        return marks
            .iter()
            .map(|mark| Fix { time: mark.time, distance: distance_of(mark.place), sample: None })
            .collect();
    };
    let mut fixes = Vec::new();
    for pair in marks.windows(2) {
        let (from, to) = (distance_of(pair[0].place), distance_of(pair[1].place));
        let span = pair[0].time..pair[1].time;
        let part = feed.during(&span);
        let mut way = vec![(span.start, 0.0)];
        let mut sum = 0.0;
        let mut last = (span.start, part.values.first().copied().unwrap_or(0.0));
        for (time, value) in part.time.iter().copied().zip(part.values.iter().copied()) {
            let mean = if feed.sampling == Sampling::Sampled { 0.5 * (last.1 + value) } else { last.1 };
            sum += mean * (time - last.0);
            way.push((time, sum));
            last = (time, value);
        }
        sum += last.1 * (span.end - last.0);
        let scale = if 0.0 < sum { (to - from) / sum } else { 0.0 };
        fixes.extend(way.into_iter().map(|(time, run)| Fix {
            time,
            distance: from + scale * run,
            sample: None,
        }));
    }
    if let Some(last) = marks.last() {
        fixes.push(Fix { time: last.time, distance: distance_of(last.place), sample: None });
    }
    fixes
}
