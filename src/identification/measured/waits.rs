//! Waits: the time of the machine at each word that stops it.
//!
//! In a recording with positions the wait is the time between the last fix before the place and the first
//! behind it, which includes some milliseconds at the slow ends of the ramps; in a log of lines it is the
//! time from the line of the word to the next line.

use crate::identification::alignment::{Method, ProgramPlace, visits};
use crate::identification::effects;
use crate::identification::fit::Run;
use crate::identification::measured::events::{LawEvent, LawEvents};
use crate::identification::measured::run_course::RunCourse;
use crate::simulation::toolpath::StopCause;

/// Returns the waits of the words that are alone at their place.
pub fn waits(run: &Run) -> LawEvents {
    match run.alignment.method {
        Method::Lines => by_lines(run),
        _ => RunCourse::of(run).map_or_else(LawEvents::default, |course| by_positions(&course)),
    }
}

fn by_positions(course: &RunCourse) -> LawEvents {
    let mut found = LawEvents::default();
    let stops = &course.toolpath.stops;
    for (at, stop) in stops.iter().enumerate() {
        let beside = stops[at.saturating_sub(1)..(at + 2).min(stops.len())].iter();
        let is_alone = beside.filter(|other| other.after == stop.after).count() == 1;
        let Some((word, programmed)) = word_of(&stop.cause).filter(|_| is_alone) else { continue };
        found.places += 1;
        let place = course.distances[stop.after.min(course.toolpath.segments.len())];
        let both = course.came(place).zip(course.left(place));
        found.events.extend(both.map(|(came, left)| LawEvent::new(word, programmed, left - came, at)));
    }
    found
}

fn by_lines(run: &Run) -> LawEvents {
    let mut found = LawEvents::default();
    let visits = visits(run.toolpath);
    let mut starts: Vec<(f64, usize)> = Vec::new();
    for mark in run.alignment.marks.iter().filter(|mark| mark.place != ProgramPlace::Start) {
        let at = starts.last().map_or(0, |last| last.1);
        let found = visits[at..].iter().position(|visit| visit.begin == mark.place);
        starts.extend(found.map(|offset| (mark.time, at + offset)));
    }
    for pair in starts.windows(2) {
        let ((from, first), (to, last)) = (pair[0], pair[1]);
        let visit = &visits[first];
        let is_alone = last == first + 1 && visit.segments.is_empty() && visit.stops.len() == 1;
        let stop = is_alone.then(|| &run.toolpath.stops[visit.stops.start]);
        let Some((word, programmed)) = stop.and_then(|stop| word_of(&stop.cause)) else { continue };
        found.places += 1;
        found.events.push(LawEvent::new(word, programmed, to - from, visit.stops.start));
    }
    found
}

/// Returns the name of a stop, and the programmed wait there, s; `None` for a stop with motion.
fn word_of(cause: &StopCause) -> Option<(String, f64)> {
    match cause {
        StopCause::Dwell { seconds } => Some(("G4".to_string(), *seconds)),
        StopCause::Spindle { code: None, .. } => Some(("S".to_string(), 0.0)),
        StopCause::SameTool { .. } => Some(("M6, same tool".to_string(), 0.0)),
        StopCause::Rotary { .. } => None,
        other => effects::StopKind::of(other).map(|kind| (kind.word(), 0.0)),
    }
}
