//! A recording with only the feed → its alignment.

use std::ops::Range;

use crate::identification::alignment::feed::{self, ProgramMotion};
use crate::identification::alignment::place::ProgramPlace;
use crate::identification::alignment::{Alignment, AlignmentError, Method, checked, end_of};
use crate::identification::recording::{Measure, Recording, check_unit_by};
use crate::machine::Machine;
use crate::simulation::feed::Phase;
use crate::simulation::simulate;
use crate::simulation::toolpath::Toolpath;

/// Aligns a recording of the feed alone within `run` (s), by its integral from stop to stop.
///
/// # Errors
///
/// Returns an error if no feed was recorded, its integral is not the length of the path, or its stops are not
/// those of the program.
pub fn by_feed(
    recording: &Recording,
    run: Range<f64>,
    toolpath: &Toolpath,
    machine: &Machine,
) -> Result<Alignment, AlignmentError> {
    let length: f64 = toolpath.segments.iter().map(|segment| segment.length).sum();
    let closed = check_unit_by(Measure::Feed, recording, length)?;
    let settled = recording.clone().settled(&closed);
    let feed = settled.feed.as_ref().ok_or(AlignmentError::NothingToFollow)?;
    let stretches = stretches(toolpath, machine);
    let integrated = feed::follow(feed, &stretches)?;
    let (Some(first), Some(last)) = (integrated.fixes.first(), integrated.fixes.last()) else {
        return Err(AlignmentError::StandsStill);
    };
    let alignment = Alignment {
        poll: Some(integrated.interval),
        covered: first.distance..last.distance,
        fixes: integrated.fixes,
        fit: integrated.found,
        feed: settled.feed.clone(),
        remarks: vec![format!(
            "the recording has only the feed: Truefeed compares from stop to stop; the feed adds up to {:.3} of the path",
            closed.ratio
        )],
        ..Alignment::of_marks(Method::Feed, run, integrated.marks, length)
    };
    checked(alignment)
}

/// Returns the motions between full stops that wait, on the assumed machine.
fn stretches(toolpath: &Toolpath, machine: &Machine) -> Vec<ProgramMotion> {
    let plain = Machine { times: machine.times.clone(), ..Machine::default() };
    let plan = simulate(toolpath, &plain);
    let waits = plan.phases.iter().filter_map(|phase| match phase {
        Phase::Wait(wait) => Some(wait.duration),
        Phase::Motion(_) => None,
    });
    let waits: Vec<f64> = waits.collect();
    let distances = toolpath.distances();
    let mut stretches: Vec<ProgramMotion> = Vec::new();
    let mut from = 0.0;
    let mut begin = ProgramPlace::Along(0.0);
    for (index, stop) in toolpath.stops.iter().enumerate() {
        if waits.get(index).is_none_or(|seconds| *seconds <= 0.0) {
            continue;
        }
        let to = distances[stop.after];
        if from < to {
            stretches.push(ProgramMotion { from, to, begin, end: ProgramPlace::Stop(index) });
        }
        (from, begin) = (to, ProgramPlace::After(index));
    }
    let to = distances[toolpath.segments.len()];
    if from < to {
        stretches.push(ProgramMotion { from, to, begin, end: end_of(toolpath) });
    }
    stretches
}
