//! Ramps between full stops and plateaus, and rapids from rest to rest.

use crate::identification::measured::events::{LawEvent, LawEvents};
use crate::identification::measured::run_course::RunCourse;
use crate::simulation::toolpath::Curve;

/// Part of the largest feedrate of a rapid below which a corner counts as a standstill.
const STANDSTILL_RATIO: f64 = 0.1;

/// Returns ramps up from a full stop, and down to one, on straight segments with a plateau.
pub fn ramps(course: &RunCourse) -> LawEvents {
    let mut found = LawEvents::default();
    let segments = &course.toolpath.segments;
    for segment in 0..segments.len() {
        let ends = [course.stops_before(segment), course.stops_before(segment + 1)];
        if *segments.curve(segment) != Curve::Line || ends == [false, false] {
            continue;
        }
        let speed = speed_of(course, segment);
        found.places += ends.iter().filter(|is_stop| **is_stop).count();
        let Some(plateau) = speed.and_then(|speed| course.plateau(segment, speed)) else { continue };
        let rapid = if segments.motion(segment).is_rapid() { " rapid" } else { "" };
        let variant = format!("{}{rapid}", course.along(segment));
        for (at, is_stop) in ends.into_iter().enumerate() {
            let rise = is_stop.then(|| course.ramp(&plateau, at == 0)).flatten();
            let event = rise.map(|rise| LawEvent::new(&*variant, plateau.feedrate, rise, 2 * segment + at));
            found.events.extend(event);
        }
    }
    found
}

/// Returns the durations of the rapids from standstill to standstill: each begins and ends at a full stop, or
/// at a corner that the tool passes nearly at rest.
pub fn rapids(course: &RunCourse) -> LawEvents {
    let mut found = LawEvents::default();
    let segments = &course.toolpath.segments;
    for segment in 0..segments.len() {
        if !segments.motion(segment).is_rapid() {
            continue;
        }
        found.places += 1;
        let Some(speed) = speed_of(course, segment) else { continue };
        let stands = |at: usize| {
            let slow = |before: usize| {
                course.at_end(before, speed).is_some_and(|end| end < STANDSTILL_RATIO * speed)
            };
            course.stops_before(at) || at.checked_sub(1).is_some_and(slow)
        };
        if !stands(segment) || !stands(segment + 1) {
            continue;
        }
        let (begin, end) = (course.distances[segment], course.distances[segment + 1]);
        let ends = course.left(begin).zip(course.came(end));
        let event =
            ends.map(|(left, came)| LawEvent::new(course.along(segment), end - begin, came - left, segment));
        found.events.extend(event.filter(|event| 0.0 < event.value));
    }
    found
}

/// Returns the largest feedrate of a segment, mm/s: the programmed one, or in rapid the feedrate of its
/// fastest window.
fn speed_of(course: &RunCourse, segment: usize) -> Option<f64> {
    let mean = || {
        let (begin, end) = (course.distances[segment], course.distances[segment + 1]);
        let lasts = course.came(end)? - course.left(begin)?;
        (0.0 < lasts).then(|| (end - begin) / lasts)
    };
    match course.commanded(segment) {
        Some(told) => Some(told),
        None => course.fastest(segment, mean()?),
    }
}
