//! Loads at raised feedrates → headroom: where the programmed feedrate could be higher.
//!
//! At each place the load is also computed at the programmed feedrate times 1.1, 1.2, … 3. The largest
//! of these up to which no limit of tool or spindle is exceeded is the room there; where nothing limits,
//! or the way is too steep for a load to be known, there is none. Operations in which it is nowhere
//! below the first step are told as a whole, by programmed feedrate, and otherwise the stretches of
//! them in which it is not.
//!
//! What it saves is counted at the programmed feedrate. Where the machine does not reach that, as the
//! predicted feedrate beside it shows, a higher one saves less or nothing.

use crate::cutting::engagement::{Engagement, Place};
use crate::cutting::limits::{CLOSE, FACTORS, Limit};

/// Way through material below which a stretch is not told of, mm.
const SHORT: f64 = 20.0;

/// Stretches told at most, those first that save most.
const MOST: usize = 50;

/// A stretch whose programmed feedrate could be higher.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Headroom {
    /// Index of its operation.
    pub operation: usize,
    /// Least and greatest line.
    pub lines: (u32, u32),
    /// Where it begins and ends along the path, mm.
    pub distance: (f64, f64),
    /// Way through material, mm.
    pub length: f64,
    /// Programmed feedrate, mm/s.
    pub feedrate: f64,
    /// Predicted feedrate on average over that way, mm/s.
    pub predicted: f64,
    /// By how much it could be higher, as a ratio.
    pub factor: f64,
    /// Which limit is met first beyond that; none up to the largest factor.
    pub limit: Option<Limit>,
}

impl Headroom {
    /// Time it would save where the machine reached both feedrates, s.
    pub fn saved(&self) -> f64 {
        self.length / self.feedrate * (1.0 - 1.0 / self.factor)
    }
}

/// The room at one place: how many of the factors fit, and which limit the next one exceeds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Room {
    pub operation: usize,
    pub steps: usize,
    pub limit: Option<Limit>,
}

/// Stretches that could be faster, by the time that saves.
pub(crate) fn headroom(
    engagement: &Engagement,
    rooms: &[Room],
    programmed: &[f64],
    predicted: &[f64],
) -> Vec<Headroom> {
    let mut found: Vec<Headroom> = Vec::new();
    let is_same = |a: usize, b: usize| {
        rooms[a].operation == rooms[b].operation && programmed[a].to_bits() == programmed[b].to_bits()
    };
    let all: Vec<usize> = (0..rooms.len()).collect();
    for group in all.chunk_by(|a, b| is_same(*a, *b)) {
        if group.iter().all(|place| 0 < rooms[*place].steps) {
            found.extend(stretch(group, engagement, rooms, programmed, predicted));
            continue;
        }
        let gap = |a: &Place, b: &Place| b.distance - a.distance - 0.5 * (a.length + b.length);
        let joins = |a: &usize, b: &usize| {
            let has_room = |place: usize| 0 < rooms[place].steps;
            has_room(*a) == has_room(*b) && gap(&engagement.places[*a], &engagement.places[*b]) <= CLOSE
        };
        let free = group.chunk_by(joins).filter(|part| 0 < rooms[part[0]].steps);
        found.extend(free.filter_map(|part| stretch(part, engagement, rooms, programmed, predicted)));
    }
    found.sort_by(|a, b| b.saved().total_cmp(&a.saved()));
    found.truncate(MOST);
    found
}

/// What consecutive places have in common; none where they are a short way.
fn stretch(
    places: &[usize],
    engagement: &Engagement,
    rooms: &[Room],
    programmed: &[f64],
    predicted: &[f64],
) -> Option<Headroom> {
    let of = |place: &usize| &engagement.places[*place];
    let (first, last) = (of(places.first()?), of(places.last()?));
    let length: f64 = places.iter().map(|place| of(place).length).sum();
    let time: f64 = places.iter().map(|place| of(place).length / predicted[*place]).sum();
    let least = rooms[places[0]..=*places.last()?].iter().min_by_key(|room| room.steps)?;
    let lines = places.iter().map(|place| of(place).line);
    Some(Headroom {
        operation: least.operation,
        lines: (lines.clone().min()?, lines.max()?),
        distance: (first.distance - 0.5 * first.length, last.distance + 0.5 * last.length),
        length,
        feedrate: programmed[places[0]],
        predicted: length / time,
        factor: FACTORS[least.steps.checked_sub(1)?],
        limit: least.limit,
    })
    .filter(|_| SHORT <= length)
}
