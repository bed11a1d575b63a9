//! Plateaus: readings of the feedrate while nothing but the programmed feed bounds it.
//!
//! On long blocks a machine runs at the programmed feed times the override, and the control shows that feedrate. The
//! ratio of a reading to the programmed feed is read off without a model of the motion:
//!
//! ```text
//! ρ = v / F,    readings while F was the same for two polls before and until the reading ends
//! ```
//!
//! Readings on ramps and at corners scatter below the override; those on plateaus pile up within the resolution of the
//! log. The ratio is the [`UPPER`] quantile of the densest window of ρ, [`WIDTH`] wide. Each reading is weighted with
//! its time and with F², because a reading of a fast move has more digits. The ratio counts if the pile holds a good
//! part of the readings and comes from the whole run. Errors of a model of the whole program do not affect it.
//!
//! Limits: only logs with line numbers and feed; an override that changes again and again leaves no pile.

use crate::identification::alignment::{ProgramPlace, visits};
use crate::identification::diagnosis::evidence::Candidate;
use crate::identification::effects::{FEED_OVERRIDE, Hypothesis};
use crate::identification::fit::Run;
use crate::machine::Machine;
use crate::simulation::ordered::sort_by_number;
use crate::simulation::toolpath::Motion;

/// Quantile of a pile that is taken as its ratio: readings with digits cut off, and readings before the machine reaches
/// the feedrate, are below it.
const UPPER: f64 = 0.7;
/// Width of the window, as a difference of ratios.
const WIDTH: f64 = 0.006;
/// Least time of a pile, as a part of the time of all readings.
const MIN_PILE_PART: f64 = 0.12;
/// Least ratio of the time of a pile to that of any other pile.
const MIN_RATIO_TO_OTHER_PILES: f64 = 1.5;
/// Fewest of the [`STRETCHES`] equal parts of the time of a run in which a pile has readings.
const SPREAD: usize = 5;
/// Equal parts of the time of a run.
const STRETCHES: f64 = 8.0;
/// Fewest readings of a pile.
const MIN_PILE_READINGS: usize = 12;
/// Longest time for which a reading counts, s.
const MAX_READING_S: f64 = 2.0;
/// Largest difference between ratios at which they count as one override.
const MAX_SAME_RATIO_DIFFERENCE: f64 = 4e-3;

/// Ratio of the recorded to the programmed feedrate on the plateaus of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plateau {
    /// Recorded feedrate, as a part of the programmed one.
    pub ratio: f64,
    /// Standard deviation of the ratio.
    pub deviation: f64,
}

/// Reading of the feedrate on a block with a programmed feed.
struct Reading {
    time: f64,
    seconds: f64,
    ratio: f64,
    feedrate: f64,
}

/// Returns the ratio at which a run moves where only the programmed feed bounds it. `None` if the readings show no
/// plateau.
pub fn plateau(run: &Run) -> Option<Plateau> {
    let mut readings = readings(run);
    sort_by_number(&mut readings, |reading| reading.ratio);
    let whole: f64 = readings.iter().map(|reading| reading.seconds).sum();
    let mut sums = vec![0.0];
    for reading in &readings {
        sums.push(sums[sums.len() - 1] + reading.seconds);
    }
    let pile = |from: usize| {
        let to = readings.partition_point(|reading| reading.ratio <= readings[from].ratio + WIDTH);
        (sums[to] - sums[from], from..to)
    };
    let piles: Vec<_> = (0..readings.len()).map(pile).collect();
    let (most, range) = piles.iter().max_by(|a, b| a.0.total_cmp(&b.0))?.clone();
    let (low, high) = (readings[range.start].ratio - WIDTH, readings[range.end - 1].ratio);
    let others = piles.iter().filter(|(_, other)| {
        let ratio = readings[other.start].ratio;
        ratio < low - 0.5 * WIDTH || high + 0.5 * WIDTH < ratio
    });
    let other = others.map(|(sum, _)| *sum).fold(0.0, f64::max);
    let marks = &run.alignment.marks;
    let (first, last) = (marks.first()?.time, marks.last()?.time);
    let stretch = |time: f64| ((time - first) / (last - first).max(1e-9) * STRETCHES) as usize;
    let has_reading = |at: &usize| readings[range.clone()].iter().any(|reading| stretch(reading.time) == *at);
    let stretches = (0..=STRETCHES as usize).filter(has_reading).count();
    if range.len() < MIN_PILE_READINGS
        || most < MIN_PILE_PART * whole
        || most < MIN_RATIO_TO_OTHER_PILES * other
        || stretches < SPREAD
    {
        return None;
    }
    let weight = |reading: &Reading| reading.seconds * reading.feedrate * reading.feedrate;
    let quantile = |part: f64, of: &dyn Fn(&Reading) -> f64| {
        let mut all: Vec<(f64, f64)> =
            readings[range.clone()].iter().map(|reading| (of(reading), weight(reading))).collect();
        sort_by_number(&mut all, |one| one.0);
        let reached: f64 = part * all.iter().map(|(_, weight)| weight).sum::<f64>();
        let mut sum = 0.0;
        all.iter()
            .find(|(_, weight)| {
                sum += weight;
                reached <= sum
            })
            .map(|(value, _)| *value)
    };
    let ratio = quantile(UPPER, &|reading| reading.ratio)?;
    let scatter = quantile(0.5, &|reading| (reading.ratio - ratio).abs())?;
    Some(Plateau { ratio, deviation: (1.5 * scatter).max(5e-4) })
}

/// Returns the readings of a run on blocks with a known feed; none without a polled feedrate.
fn readings(run: &Run) -> Vec<Reading> {
    let alignment = run.alignment;
    let Some((poll, feed)) = alignment.poll.zip(alignment.feed.as_ref()) else { return Vec::new() };
    let mut readings = Vec::new();
    for (from, to, feedrate) in programmed(run) {
        let begin = from + 2.0 * poll;
        let first = feed.time.partition_point(|time| *time <= begin).saturating_sub(1);
        for at in first..feed.time.len() {
            if to <= feed.time[at] {
                break;
            }
            let end = feed.time.get(at + 1).copied().unwrap_or(to).min(to);
            let time = feed.time[at].max(begin);
            let seconds = (end - time).min(MAX_READING_S);
            if 0.0 < seconds && 0.0 < feed.values[at] {
                readings.push(Reading { time, seconds, ratio: feed.values[at] / feedrate, feedrate });
            }
        }
    }
    readings
}

/// Returns the spans of recorded time, from and to (s), in which a single feedrate (mm/s) is programmed, with that
/// feedrate.
fn programmed(run: &Run) -> Vec<(f64, f64, f64)> {
    let visits = visits(run.toolpath);
    let feed_of = |visit: usize| {
        let mut segments = run.toolpath.segments.range(visits[visit].segments.clone());
        let first = match segments.next()?.motion {
            Motion::Feed { feedrate } if visits[visit].stops.is_empty() => feedrate,
            _ => return None,
        };
        segments.all(|segment| segment.motion == Motion::Feed { feedrate: first }).then_some(first)
    };
    let mut at = 0;
    let mut starts: Vec<(f64, usize)> = Vec::new();
    for mark in run.alignment.marks.iter().filter(|mark| mark.place != ProgramPlace::Start) {
        if let Some(found) = (at..visits.len()).find(|visit| visits[*visit].begin == mark.place) {
            starts.push((mark.time, found));
            at = found;
        }
    }
    let mut spans: Vec<(f64, f64, f64)> = Vec::new();
    for pair in starts.windows(2) {
        let ((from, first), (to, last)) = (pair[0], pair[1]);
        let Some(feedrate) = feed_of(first) else { continue };
        if (first..last).any(|visit| feed_of(visit) != Some(feedrate)) {
            continue;
        }
        match spans.last_mut() {
            Some(span) if span.1 == from && span.2 == feedrate => span.1 = to,
            _ => spans.push((from, to, feedrate)),
        }
    }
    spans
}

/// Result of the plateaus of the runs for the feed override.
pub enum Said {
    /// The plateaus determine no override.
    Nothing,
    /// The override is the one of the machine believed in.
    Believed,
    /// The override is another one.
    Other(Candidate),
}

/// Reads the feed override off the plateaus. It counts as that of the machine only if every run shows it.
pub fn feed_override(machine: &Machine, runs: &[Run], library: &[Hypothesis]) -> Said {
    let all: Option<Vec<Plateau>> = runs.iter().map(plateau).collect();
    let Some(all) = all.filter(|all| !all.is_empty()) else { return Said::Nothing };
    let count = all.len() as f64;
    let ratio = all.iter().map(|plateau| plateau.ratio).sum::<f64>() / count;
    let deviation = all.iter().map(|plateau| plateau.deviation).fold(0.0, f64::max);
    let apart = all.iter().map(|plateau| (plateau.ratio - ratio).abs()).fold(0.0, f64::max);
    if MAX_SAME_RATIO_DIFFERENCE.max(3.0 * deviation) < apart {
        return Said::Nothing;
    }
    if (ratio / machine.overrides.feed - 1.0).abs() < MAX_SAME_RATIO_DIFFERENCE.max(3.0 * deviation) {
        return Said::Believed;
    }
    let found = library.iter().find(|own| own.effect == FEED_OVERRIDE && own.variant.is_empty());
    let Some(hypothesis) = found.cloned() else { return Said::Nothing };
    // It is read off and not fitted: what a model is off by must not move it.
    let hypothesis = hypothesis.at_trials_only();
    Said::Other(Candidate::read_off(hypothesis, ratio, deviation))
}
