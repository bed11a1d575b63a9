//! Both motions at the same places: the columns from which charts are drawn and errors are taken.

use crate::identification::alignment::{Alignment, Method};
use crate::identification::recording::Channel;
use crate::simulation::feed::FeedPlan;
use crate::simulation::profile::Profile;
use crate::simulation::toolpath::{Motion, Toolpath};

/// Recorded speeds are means over at least so many samples, and so many standard deviations of noise.
const SPEED_OVER: (usize, f64) = (4, 60.0);

/// Columns of equal length, one row a place, ascending in distance.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pointwise {
    /// Distance along the path, mm.
    pub distance: Vec<f64>,
    /// When the recorded machine was there, s from the start of the recording.
    pub recorded_time: Vec<f64>,
    /// When the simulated machine is there, s.
    pub simulated_time: Vec<f64>,
    /// Feedrate recorded, mm/s.
    pub recorded: Vec<f64>,
    /// Feedrate simulated, mm/s.
    pub simulated: Vec<f64>,
    /// Feedrate programmed, mm/s; none on rapid moves.
    pub programmed: Vec<Option<f64>>,
    /// Line of the program.
    pub line: Vec<u32>,
}

/// Both motions at the places of the recording.
pub fn pointwise(toolpath: &Toolpath, plan: &FeedPlan, alignment: &Alignment) -> Pointwise {
    let mut rows = Pointwise::default();
    let profile = Profile::new(toolpath, plan);
    let stretches = match (alignment.method, &alignment.feed) {
        (Method::Lines | Method::Feed, Some(feed)) => from_feed(alignment, feed),
        _ => from_fixes(alignment),
    };
    // What a poll shows may be as late as the poll is long, on one side or the other.
    let blur = alignment.poll.unwrap_or(0.0);
    // Ends of stretches ascend, each on its own side, so that two passes do.
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
        let around = [begin - blur, end + blur].map(|time| profile.at_time(time).distance);
        rows.programmed.push(programmed(toolpath, &profile, segment, around));
        rows.line.push(on.line.0);
    }
    rows
}

/// A piece of the recorded motion with one speed.
struct Stretch {
    /// When it began and ended, s.
    time: [f64; 2],
    /// Where along the path, mm.
    distance: [f64; 2],
    /// How fast, mm/s: from positions the chord over the time, and the same is asked of the simulation.
    speed: f64,
}

/// The programmed feedrate on a segment, mm/s; none where it, or what lies between two distances (mm)
/// around it, is rapid.
fn programmed(toolpath: &Toolpath, profile: &Profile, segment: usize, around: [f64; 2]) -> Option<f64> {
    let is_rapid = |at: usize| toolpath.segments.at(at).motion == Motion::Rapid;
    let before = (0..segment).rev().take_while(|at| around[0] < profile.distance_before(at + 1));
    let after =
        (segment + 1..toolpath.segments.len()).take_while(|at| profile.distance_before(*at) < around[1]);
    if before.chain(after).any(is_rapid) {
        return None;
    }
    match toolpath.segments.at(segment).motion {
        Motion::Feed { feedrate } => Some(feedrate),
        Motion::Rapid => None,
    }
}

/// Pieces from the feed that was recorded, where the machine moves.
fn from_feed(alignment: &Alignment, feed: &Channel<f64>) -> Vec<Stretch> {
    let mut rows: Vec<Stretch> = Vec::new();
    for fix in &alignment.fixes {
        let Some(speed) = feed.held(fix.time) else { continue };
        if rows.last().is_none_or(|last| last.distance[1] < fix.distance) {
            rows.push(Stretch { time: [fix.time; 2], distance: [fix.distance; 2], speed: *speed });
        }
    }
    rows
}

/// Pieces from positions, or from the fixes alone.
fn from_fixes(alignment: &Alignment) -> Vec<Stretch> {
    let fixes = &alignment.fixes;
    let noise = alignment.track.as_ref().map_or(0.0, |track| track.noise);
    let mut rows = Vec::new();
    let mut first = 0;
    for last in 1..fixes.len() {
        let way = match (&alignment.track, fixes[first].sample, fixes[last].sample) {
            (Some(track), Some(a), Some(b)) => (track.position[b] - track.position[a]).norm(),
            _ => fixes[last].distance - fixes[first].distance,
        };
        if last - first < SPEED_OVER.0 || way < SPEED_OVER.1 * noise {
            continue;
        }
        let (a, b) = (&fixes[first], &fixes[last]);
        let (time, distance) = ([a.time, b.time], [a.distance, b.distance]);
        rows.push(Stretch { time, distance, speed: way / (b.time - a.time) });
        first = if last - first < 2 * SPEED_OVER.0 { first + 1 } else { last - SPEED_OVER.0 };
    }
    rows
}
