//! Corners and arcs: the feedrate at which the tool passed them, and its limit: their law or the programmed
//! feedrate.

use crate::identification::fit::Run;
use crate::identification::measured::events::{LawEvent, LawEvents};
use crate::identification::measured::run_course::{MIN_REACHED_RATIO, RunCourse, SteadyPlateau};
use crate::simulation::toolpath::{Curve, Motion};

/// Least turn of a corner, rad: smaller ones belong to blocks of a curve.
const MIN_TURN_RAD: f64 = 2.0 * std::f64::consts::PI / 180.0;
/// Largest climb of an arc, as a part of its length: steeper arcs are helices, which are ignored.
const MAX_CLIMB_RATIO: f64 = 0.1;
/// Variant of corners whose blocks both reached the programmed feedrate.
pub const LONG_BLOCKS: &str = "long blocks";
/// Variant of all other corners.
pub const SHORT_BLOCKS: &str = "short blocks";

/// Returns the corners between feed moves of one feedrate without a stop.
pub fn corners(course: &RunCourse) -> LawEvents {
    let mut found = LawEvents::default();
    let segments = &course.toolpath.segments;
    for segment in 0..segments.len().saturating_sub(1) {
        let (Motion::Feed { feedrate }, Motion::Feed { feedrate: next }) =
            (segments.motion(segment), segments.motion(segment + 1))
        else {
            continue;
        };
        let turn = course.turn(segment);
        if feedrate != next || turn < MIN_TURN_RAD || course.stops_before(segment + 1) {
            continue;
        }
        found.places += 1;
        let told = course.ratio * feedrate;
        let Some(speed) = course.at_end(segment, told) else { continue };
        let is_long = course.reaches(segment) && course.reaches(segment + 1);
        let variant = if is_long { LONG_BLOCKS } else { SHORT_BLOCKS };
        found
            .events
            .push(LawEvent::new(variant, turn, speed, segment).at_feed(MIN_REACHED_RATIO * told <= speed));
    }
    found
}

/// Returns the arcs that are long enough for a steady feedrate.
pub fn arcs(course: &RunCourse) -> LawEvents {
    let mut found = LawEvents::default();
    let segments = &course.toolpath.segments;
    for segment in 0..segments.len() {
        let Curve::Arc(arc) = segments.curve(segment) else { continue };
        let Some(told) = course.commanded(segment) else { continue };
        if MAX_CLIMB_RATIO * segments.length(segment) < arc.rise.norm() {
            continue;
        }
        found.places += 1;
        let Some(plateau) = course.plateau(segment, told) else { continue };
        let radius = arc.mean_radius();
        let feedrate = along_arc(&plateau, radius);
        found
            .events
            .push(LawEvent::new("", radius, feedrate, segment).at_feed(MIN_REACHED_RATIO * told <= feedrate));
    }
    found
}

/// Returns the centripetal acceleration on each arc of a run that is slower than programmed, mm/s²; none without recorded
/// positions.
pub fn centripetal_accelerations(run: &Run) -> Vec<f64> {
    let events = RunCourse::of(run).map(|course| arcs(&course).events).unwrap_or_default();
    let slower = events.into_iter().filter(|arc| !arc.is_at_feed);
    slower.map(|arc| arc.value.powi(2) / arc.over).collect()
}

/// Returns the feedrate of a plateau along an arc of `radius` (mm), mm/s; windows measure it along chords.
fn along_arc(plateau: &SteadyPlateau, radius: f64) -> f64 {
    let chord = plateau.feedrate * plateau.window;
    2.0 * radius * (chord / (2.0 * radius)).min(1.0).asin() / plateau.window
}
