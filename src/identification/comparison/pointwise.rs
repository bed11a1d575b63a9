//! Recorded and simulated motion at the same places: the columns for charts and errors.

use crate::identification::alignment::{Alignment, Method};
use crate::identification::recording::Channel;
use crate::simulation::feed::FeedPlan;
use crate::simulation::profile::Profile;
use crate::simulation::toolpath::{Motion, Toolpath};

/// Least number of samples over which a recorded speed is averaged.
const MIN_SPEED_SAMPLES: usize = 4;
/// Least travel over which a recorded speed is averaged, in standard deviations of the noise.
const MIN_SPEED_TRAVEL_SIGMAS: f64 = 60.0;

/// Columns of equal length, one row per place, ascending in distance.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pointwise {
    /// Distance along the path, mm.
    pub distance: Vec<f64>,
    /// Time of the recorded machine, s from the start of the recording.
    pub recorded_time: Vec<f64>,
    /// Time of the simulated machine, s.
    pub simulated_time: Vec<f64>,
    /// Recorded feedrate, mm/s.
    pub recorded: Vec<f64>,
    /// Simulated feedrate, mm/s.
    pub simulated: Vec<f64>,
    /// Programmed feedrate, mm/s; `None` on rapid moves.
    pub programmed: Vec<Option<f64>>,
    /// Line of the program.
    pub line: Vec<u32>,
}

/// Returns the recorded and the simulated motion at the places of the recording.
pub fn pointwise(toolpath: &Toolpath, plan: &FeedPlan, alignment: &Alignment) -> Pointwise {
    let mut rows = Pointwise::default();
    let profile = Profile::new(toolpath, plan);
    let stretches = match (alignment.method, &alignment.feed) {
        (Method::Lines | Method::Feed, Some(feed)) => from_feed(alignment, feed),
        _ => from_fixes(alignment),
    };
    // A polled state may be late by up to a poll, at either end.
    let blur = alignment.poll.unwrap_or(0.0);
    // The beginnings of pieces ascend, and so do their ends, so that two passes are enough.
    let ends = [0, 1].map(|end: usize| {
        let distances: Vec<f64> = stretches.iter().map(|stretch| stretch.distance[end]).collect();
        profile.crossing_times(&distances)
    });
    let mut segment = 0;
    for (row, stretch) in stretches.into_iter().enumerate() {
        let distance = 0.5 * (stretch.distance[0] + stretch.distance[1]);
        while segment + 1 < toolpath.segments.len() && profile.distance_before(segment + 1) <= distance {
            segment += 1;
        }
        let Some(on) = toolpath.segments.get(segment) else { break };
        let [begin, end] = [ends[0][row], ends[1][row]];
        let states = [begin, end].map(|time| profile.at_time(time));
        let simulated = match stretch.distance[0] < stretch.distance[1] && begin < end {
            true => (states[1].position - states[0].position).norm() / (end - begin),
            false => states[0].velocity.norm(),
        };
        rows.distance.push(distance);
        rows.recorded_time.push(0.5 * (stretch.time[0] + stretch.time[1]));
        rows.simulated_time.push(0.5 * (begin + end));
        rows.recorded.push(stretch.speed);
        rows.simulated.push(simulated);
        let around = if blur == 0.0 {
            states.map(|state| state.distance)
        } else {
            [begin - blur, end + blur].map(|time| profile.at_time(time).distance)
        };
        rows.programmed.push(programmed(toolpath, &profile, segment, around));
        rows.line.push(on.line.0);
    }
    rows
}

/// A piece of the recorded motion with one speed.
struct MotionPiece {
    /// Beginning and end, s.
    time: [f64; 2],
    /// Distance along the path, mm.
    distance: [f64; 2],
    /// Speed, mm/s: from positions the chord over the time, for the simulation as well.
    speed: f64,
}

/// Returns the programmed feedrate on a segment, mm/s; `None` if it, or any move between two distances (mm)
/// around it, is rapid.
fn programmed(toolpath: &Toolpath, profile: &Profile, segment: usize, around: [f64; 2]) -> Option<f64> {
    let is_rapid = |at: usize| toolpath.segments.at(at).motion.is_rapid();
    let before = (0..segment).rev().take_while(|at| around[0] < profile.distance_before(at + 1));
    let after =
        (segment + 1..toolpath.segments.len()).take_while(|at| profile.distance_before(*at) < around[1]);
    if before.chain(after).any(is_rapid) {
        return None;
    }
    match toolpath.segments.at(segment).motion {
        Motion::Feed { feedrate } => Some(feedrate),
        Motion::Rapid { .. } => None,
    }
}

/// Returns pieces of the recorded feed in which the machine moves.
fn from_feed(alignment: &Alignment, feed: &Channel<f64>) -> Vec<MotionPiece> {
    let mut rows: Vec<MotionPiece> = Vec::new();
    for fix in &alignment.fixes {
        let Some(speed) = feed.held(fix.time) else { continue };
        if rows.last().is_none_or(|last| last.distance[1] < fix.distance) {
            rows.push(MotionPiece { time: [fix.time; 2], distance: [fix.distance; 2], speed: *speed });
        }
    }
    rows
}

/// Returns pieces from positions, or from the fixes alone.
fn from_fixes(alignment: &Alignment) -> Vec<MotionPiece> {
    let fixes = &alignment.fixes;
    let noise = alignment.track.as_ref().map_or(0.0, |track| track.noise);
    let mut rows = Vec::new();
    let mut first = 0;
    for last in 1..fixes.len() {
        let way = match (&alignment.track, fixes[first].sample, fixes[last].sample) {
            (Some(track), Some(a), Some(b)) => (track.position[b] - track.position[a]).norm(),
            _ => fixes[last].distance - fixes[first].distance,
        };
        if last - first < MIN_SPEED_SAMPLES || way < MIN_SPEED_TRAVEL_SIGMAS * noise {
            continue;
        }
        let (a, b) = (&fixes[first], &fixes[last]);
        let (time, distance) = ([a.time, b.time], [a.distance, b.distance]);
        rows.push(MotionPiece { time, distance, speed: way / (b.time - a.time) });
        first = if last - first < 2 * MIN_SPEED_SAMPLES { first + 1 } else { last - MIN_SPEED_SAMPLES };
    }
    rows
}
