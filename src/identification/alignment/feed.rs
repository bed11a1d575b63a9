//! Recorded feed alone → marks at the stops of the program.
//!
//! The integral of the feed is the way that was run, but for an error that grows with it; a recorded
//! stop is therefore looked for near the way at which the program has one,
//!
//! ```text
//! |∫ v dt − (way from the last anchor)| ≤ 3 % of it + 1 mm
//! ```
//!
//! and what is found is an anchor for the next. Between anchors the way is stretched by what closes,
//! never the time. A stop recorded where the program has none is a pause: the way stands still there.

use crate::identification::alignment::place::Place;
use crate::identification::alignment::{AlignmentError, Fix, Mark};
use crate::identification::recording::{Channel, Sampling};

/// How far a stop may be from where the program has it: part of the way, and mm.
const REACH: (f64, f64) = (0.03, 1.0);
/// Below this part of the typical feed the machine stands.
const STANDING: f64 = 0.02;
/// Of the program's full stops within what was recorded so many must be found.
const ENOUGH: f64 = 0.7;

/// What the feed says.
pub struct Integrated {
    /// Ends and beginnings of motion at stops of the program.
    pub marks: Vec<Mark>,
    /// Where the tool was when.
    pub fixes: Vec<Fix>,
    /// Typical time between samples, s.
    pub interval: f64,
    /// Stops found, as a part of the program's.
    pub found: f64,
}

/// A stretch of recorded motion between two standstills.
struct Moving {
    from: f64,
    to: f64,
    way: f64,
}

/// Marks by the integral of the feed (mm/s). `stretches` are the distances (mm) at which motion between
/// full stops begins and ends in the program, in order, with the stops that begin and end there.
pub fn follow(feed: &Channel<f64>, stretches: &[Stretch]) -> Result<Integrated, AlignmentError> {
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
    // A pause splits a stretch: its parts are added until they make up the whole.
    let mut parts = moving.iter();
    for stretch in stretches {
        let wanted = stretch.to - stretch.from;
        let reach = REACH.0 * wanted + REACH.1;
        let mut way = 0.0;
        let mut own: Vec<&Moving> = Vec::new();
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
    if found < ENOUGH * covered.min(1.0) {
        return Err(AlignmentError::StopsDoNotFit { at: fixes.last().map_or(0.0, |fix| fix.distance) });
    }
    Ok(Integrated { marks, fixes, found, interval })
}

/// Motion between two full stops of the program.
pub struct Stretch {
    /// Distance at which it begins, mm.
    pub from: f64,
    /// Distance at which it ends, mm.
    pub to: f64,
    /// The place where it begins.
    pub begin: Place,
    /// The place where it ends.
    pub end: Place,
}

fn mean(sampling: Sampling, before: f64, value: f64) -> f64 {
    if sampling == Sampling::Sampled { 0.5 * (before + value) } else { before }
}

fn typical_interval(feed: &Channel<f64>) -> f64 {
    let mut between: Vec<f64> = feed.time.windows(2).map(|pair| pair[1] - pair[0]).collect();
    crate::identification::alignment::positions::median(&mut between)
}

/// The stretches of time in which the feed says that the machine moves.
fn movements(feed: &Channel<f64>) -> Vec<Moving> {
    let mut moving: Vec<f64> = feed.values.iter().copied().filter(|value| 0.0 < *value).collect();
    let threshold = STANDING * crate::identification::alignment::positions::median(&mut moving);
    let mut parts: Vec<Moving> = Vec::new();
    let mut open: Option<Moving> = None;
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
                open = Some(Moving { from, to: time, way: step });
            }
            None => {}
        }
    }
    parts.extend(open);
    parts
}
