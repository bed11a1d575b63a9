//! A recording with nothing but the feed → its alignment.

use std::ops::Range;

use crate::identification::alignment::feed::{self, Stretch};
use crate::identification::alignment::place::Place;
use crate::identification::alignment::{Alignment, AlignmentError, Method, checked, end_of};
use crate::identification::recording::{Measure, Recording, closure_of};
use crate::machine::Machine;
use crate::simulation::feed::Phase;
use crate::simulation::simulate;
use crate::simulation::toolpath::{Toolpath, Vector};

pub fn by_feed(
    recording: &Recording,
    run: Range<f64>,
    toolpath: &Toolpath,
    machine: &Machine,
) -> Result<Alignment, AlignmentError> {
    let length: f64 = toolpath.segments.iter().map(|segment| segment.length).sum();
    let closed = closure_of(Measure::Feed, recording, length)?;
    let settled = recording.clone().settled(&closed);
    let feed = settled.feed.as_ref().ok_or(AlignmentError::NothingToFollow)?;
    let stretches = stretches(toolpath, machine);
    let integrated = feed::follow(feed, &stretches)?;
    let (Some(first), Some(last)) = (integrated.fixes.first(), integrated.fixes.last()) else {
        return Err(AlignmentError::StandsStill);
    };
    let alignment = Alignment {
        method: Method::Feed,
        poll: Some(integrated.interval),
        run,
        covered: first.distance..last.distance,
        marks: integrated.marks,
        fixes: integrated.fixes,
        length,
        fit: integrated.found,
        spread: None,
        track: None,
        feed: settled.feed.clone(),
        remarks: vec![format!(
            "only the feed was recorded: compared from stop to stop; its integral is {:.3} of the path",
            closed.ratio
        )],
        shift: Vector::zeros(),
        passes: 1,
    };
    checked(alignment)
}

/// The motion between full stops that wait, as the machine is believed to stop.
fn stretches(toolpath: &Toolpath, machine: &Machine) -> Vec<Stretch> {
    let plain = Machine { times: machine.times.clone(), ..Machine::default() };
    let plan = simulate(toolpath, &plain);
    let waits = plan.phases.iter().filter_map(|phase| match phase {
        Phase::Wait(wait) => Some(wait.duration),
        Phase::Motion(_) => None,
    });
    let waits: Vec<f64> = waits.collect();
    let distances = toolpath.distances();
    let mut stretches: Vec<Stretch> = Vec::new();
    let mut from = 0.0;
    let mut begin = Place::Along(0.0);
    for (index, stop) in toolpath.stops.iter().enumerate() {
        if waits.get(index).is_none_or(|seconds| *seconds <= 0.0) {
            continue;
        }
        let to = distances[stop.after];
        if from < to {
            stretches.push(Stretch { from, to, begin, end: Place::Stop(index) });
        }
        (from, begin) = (to, Place::After(index));
    }
    let to = distances[toolpath.segments.len()];
    if from < to {
        stretches.push(Stretch { from, to, begin, end: end_of(toolpath) });
    }
    stretches
}
