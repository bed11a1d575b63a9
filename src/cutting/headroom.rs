//! Loads at raised feedrates → headroom: the parts of the path where the programmed feedrate could be higher.
//!
//! The load at each place is also computed at the programmed feedrate times 1.1, 1.2, … 3. The headroom is
//! the largest of these factors up to which no limit of tool or spindle is exceeded; there is no headroom if
//! tool and spindle have no limits, or if the path is too steep for a known load. An operation with headroom
//! everywhere is reported as a whole, by programmed feedrate; any other operation by its parts with headroom.
//!
//! The saved time refers to the programmed feedrate. If the machine does not reach it, as the predicted
//! feedrate shows, a higher programmed feedrate saves less or nothing.

use crate::cutting::engagement::{CutPlace, Engagement};
use crate::cutting::limits::{FEED_FACTORS, LimitKind, MAX_GAP_MM};
use crate::simulation::ordered::sort_by_number;

/// Least length through material that is reported, mm.
const MIN_PART_MM: f64 = 20.0;

/// Most parts that are reported, by the time they save.
const MAX_PARTS: usize = 50;

/// A part of the path whose programmed feedrate could be higher.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Headroom {
    /// Index of the operation.
    pub operation: usize,
    /// Least and greatest line.
    pub lines: (u32, u32),
    /// Distance along the path at which the part begins and ends, mm.
    pub distance: (f64, f64),
    /// Length of the path through material, mm.
    pub length: f64,
    /// Programmed feedrate, mm/s.
    pub feedrate: f64,
    /// Mean predicted feedrate over that path, mm/s.
    pub predicted: f64,
    /// Ratio by which the feedrate could be higher.
    pub factor: f64,
    /// The limit that the next factor would exceed; `None` at the largest factor.
    pub limit: Option<LimitKind>,
}

impl Headroom {
    /// Returns the time saved if the machine reached both feedrates, s.
    pub fn saved(&self) -> f64 {
        self.length / self.feedrate * (1.0 - 1.0 / self.factor)
    }
}

/// The headroom at one place: the number of factors within all limits, and the limit that the next factor
/// exceeds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PlaceHeadroom {
    pub operation: usize,
    pub steps: usize,
    pub limit: Option<LimitKind>,
}

/// Returns the parts that could be faster, by the time that saves.
pub(crate) fn headroom(
    engagement: &Engagement,
    rooms: &[PlaceHeadroom],
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
            found.extend(common_headroom(group, engagement, rooms, programmed, predicted));
            continue;
        }
        let gap = |a: &CutPlace, b: &CutPlace| b.distance - a.distance - 0.5 * (a.length + b.length);
        let joins = |a: &usize, b: &usize| {
            let has_room = |place: usize| 0 < rooms[place].steps;
            has_room(*a) == has_room(*b) && gap(&engagement.places[*a], &engagement.places[*b]) <= MAX_GAP_MM
        };
        let free = group.chunk_by(joins).filter(|part| 0 < rooms[part[0]].steps);
        found.extend(free.filter_map(|part| common_headroom(part, engagement, rooms, programmed, predicted)));
    }
    sort_by_number(&mut found, |one| -one.saved());
    found.truncate(MAX_PARTS);
    found
}

/// Returns the headroom common to consecutive places; `None` if they are a short path.
fn common_headroom(
    places: &[usize],
    engagement: &Engagement,
    rooms: &[PlaceHeadroom],
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
        factor: FEED_FACTORS[least.steps.checked_sub(1)?],
        limit: least.limit,
    })
    .filter(|_| MIN_PART_MM <= length)
}
