//! Recorded feed alone → marks at the stops of the program.
//!
//! The integral of the feed is the travelled length, except for an error that grows with the length. A
//! recorded stop is therefore expected near a stop of the program,
//!
//! ```text
//! |∫ v dt − (way from the last anchor)| ≤ 3 % of it + 1 mm
//! ```
//!
//! and becomes the next anchor, from which the integral continues. Between anchors the length is scaled to
//! match, never the time. A recorded stop where the program has none is a pause without length.

use crate::identification::alignment::place::ProgramPlace;
use crate::identification::alignment::{AlignmentError, Fix, Mark};
use crate::identification::recording::{Channel, Sampling};

/// Largest distance of a recorded stop from the program's, as a part of the length, in addition to
/// [`STOP_DISTANCE_MM`].
const STOP_DISTANCE_RATIO: f64 = 0.03;
/// Largest distance of a recorded stop from the program's, in addition to [`STOP_DISTANCE_RATIO`], mm.
const STOP_DISTANCE_MM: f64 = 1.0;
/// Part of the typical feed below which the machine is at rest.
const MAX_REST_FEED_RATIO: f64 = 0.02;
/// Least part of the program's full stops, within the recorded part, that must be found.
const MIN_PART_OF_STOPS: f64 = 0.7;

/// The alignment by the feed.
pub struct FeedMatch {
    /// Ends and beginnings of motion at stops of the program.
    pub marks: Vec<Mark>,
    /// Distances of the tool along the path over time.
    pub fixes: Vec<Fix>,
    /// Typical time between samples, s.
    pub interval: f64,
    /// Number of stops found, as a part of the program's stops.
    pub found: f64,
}

/// Recorded motion between two standstills.
struct RecordedMotion {
    from: f64,
    to: f64,
    way: f64,
}

/// Returns marks by the integral of the feed (mm/s). `stretches` are the rest-to-rest motions of the program,
/// in order.
///
/// # Errors
///
/// Returns an error if recorded stops are not where the program has them.
pub fn follow(feed: &Channel<f64>, stretches: &[ProgramMotion]) -> Result<FeedMatch, AlignmentError> {
    let moving = movements(feed);
    let recorded: f64 = moving.iter().map(|part| part.way).sum();
    let length = stretches.last().map_or(0.0, |stretch| stretch.to);
    if recorded <= 0.0 || length <= 0.0 {
        return Err(AlignmentError::StandsStill);
    }
    let interval = typical_interval(feed);
    let deviation = interval / 12.0f64.sqrt();
    let (mut marks, mut fixes) = (Vec::new(), Vec::new());
    let mut found = 0;
    // A pause splits a motion, whose parts are added up.
    let mut parts = moving.iter();
    for stretch in stretches {
        let wanted = stretch.to - stretch.from;
        let reach = STOP_DISTANCE_RATIO * wanted + STOP_DISTANCE_MM;
        let mut way = 0.0;
        let mut own: Vec<&RecordedMotion> = Vec::new();
        while way < wanted - reach {
            let Some(part) = parts.next() else { break };
            way += part.way;
            own.push(part);
        }
        let (Some(first), Some(last)) = (own.first(), own.last()) else { break };
        if wanted + reach < way {
            return Err(AlignmentError::StopsDoNotFit { at: stretch.to });
        }
        let whole = wanted - reach <= way;
        marks.push(Mark { place: stretch.begin, time: first.from, deviation });
        if whole {
            marks.push(Mark { place: stretch.end, time: last.to, deviation });
            found += 1;
        }
        let scale = if whole { wanted / way } else { 1.0 };
        let mut run = stretch.from;
        for part in own {
            let piece = feed.during(&(part.from..part.to));
            let mut before = (part.from, 0.0);
            fixes.push(Fix { time: part.from, distance: run, sample: None });
            for (time, value) in piece.time.iter().copied().zip(piece.values.iter().copied()) {
                let mean = mean(feed.sampling, before.1, value);
                run += scale * mean * (time - before.0);
                fixes.push(Fix { time, distance: run, sample: None });
                before = (time, value);
            }
        }
    }
    let found = f64::from(found) / stretches.len().max(1) as f64;
    let covered = recorded / length;
    if found < MIN_PART_OF_STOPS * covered.min(1.0) {
        return Err(AlignmentError::StopsDoNotFit { at: fixes.last().map_or(0.0, |fix| fix.distance) });
    }
    Ok(FeedMatch { marks, fixes, found, interval })
}

/// A motion between two full stops of the program.
pub struct ProgramMotion {
    /// Distance at which it begins, mm.
    pub from: f64,
    /// Distance at which it ends, mm.
    pub to: f64,
    /// The place where it begins.
    pub begin: ProgramPlace,
    /// The place where it ends.
    pub end: ProgramPlace,
}

fn mean(sampling: Sampling, before: f64, value: f64) -> f64 {
    if sampling == Sampling::Sampled { 0.5 * (before + value) } else { before }
}

fn typical_interval(feed: &Channel<f64>) -> f64 {
    let mut between: Vec<f64> = feed.time.windows(2).map(|pair| pair[1] - pair[0]).collect();
    crate::identification::alignment::map_matching::median(&mut between)
}

/// Returns the ranges of time in which the feed shows motion.
fn movements(feed: &Channel<f64>) -> Vec<RecordedMotion> {
    let mut moving: Vec<f64> = feed.values.iter().copied().filter(|value| 0.0 < *value).collect();
    let threshold = MAX_REST_FEED_RATIO * crate::identification::alignment::map_matching::median(&mut moving);
    let mut parts: Vec<RecordedMotion> = Vec::new();
    let mut open: Option<RecordedMotion> = None;
    for (index, (time, value)) in feed.time.iter().copied().zip(feed.values.iter().copied()).enumerate() {
        let before = index.checked_sub(1).map_or((time, 0.0), |at| (feed.time[at], feed.values[at]));
        let step = mean(feed.sampling, before.1, value) * (time - before.0);
        match &mut open {
            Some(part) => {
                part.way += step;
                part.to = time;
                if value <= threshold {
                    parts.extend(open.take());
                }
            }
            None if threshold < value => {
                let from = if feed.sampling == Sampling::Sampled { before.0 } else { time };
                open = Some(RecordedMotion { from, to: time, way: step });
            }
            None => {}
        }
    }
    parts.extend(open);
    parts
}
