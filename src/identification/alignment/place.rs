//! Places in a program, each with a time in the recording and one in the simulation.
//!
//! The first place is the start of the program, after which a control may need time until the first block. A
//! program is a sequence of segments and stops; a visit is a run of consecutive segments and stops of one
//! line, and a line in a loop has many visits. A place is a distance along the path, or one of the two ends
//! of a stop, between which only time passes:
//!
//! ```text
//! distance                    ┌──────────
//!               ┌─────────────┘ After(k)
//!      ─────────┘ Along(d)    ^ Stop(k) … After(k): the machine waits
//!                                                        time →
//! ```
//!
//! Places do not depend on the machine, so that one set of places serves every trial of a parameter.

use std::ops::Range;

use crate::simulation::feed::{FeedPlan, Phase};
use crate::simulation::gcode::LineNumber;
use crate::simulation::profile::Profile;
use crate::simulation::toolpath::Toolpath;

/// A place in a program.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ProgramPlace {
    /// The start of the program.
    Start,
    /// A distance along the programmed path, mm.
    Along(f64),
    /// The beginning of a stop of the toolpath, by index.
    Stop(usize),
    /// The end of that stop.
    After(usize),
}

impl ProgramPlace {
    /// Returns the distance along the path, mm, given the `distances` of the toolpath.
    pub fn distance(self, toolpath: &Toolpath, distances: &[f64]) -> f64 {
        match self {
            ProgramPlace::Start => 0.0,
            ProgramPlace::Along(distance) => distance,
            ProgramPlace::Stop(stop) | ProgramPlace::After(stop) => {
                distances[toolpath.stops[stop].after.min(toolpath.segments.len())]
            }
        }
    }
}

/// A run of segments and stops of one line of the program.
#[derive(Clone, Debug, PartialEq)]
pub struct Visit {
    /// Line.
    pub line: LineNumber,
    /// Indices of its segments in the toolpath.
    pub segments: Range<usize>,
    /// Indices of its stops in the toolpath.
    pub stops: Range<usize>,
    /// Beginning.
    pub begin: ProgramPlace,
}

/// Returns the visits of a program in the order they are run.
pub fn visits(toolpath: &Toolpath) -> Vec<Visit> {
    let mut visits: Vec<Visit> = Vec::new();
    let (mut segment, mut stop) = (0, 0);
    let distances = toolpath.distances();
    let mut last_was_stop = false;
    while segment < toolpath.segments.len() || stop < toolpath.stops.len() {
        let is_stop = toolpath
            .stops
            .get(stop)
            .is_some_and(|next| next.after <= segment || segment == toolpath.segments.len());
        let line = if is_stop { toolpath.stops[stop].line } else { toolpath.segments.at(segment).line };
        if visits.last().is_none_or(|visit| visit.line != line) {
            let begin = match (is_stop, last_was_stop) {
                (true, _) => ProgramPlace::Stop(stop),
                (false, true) => ProgramPlace::After(stop - 1),
                (false, false) => ProgramPlace::Along(distances[segment]),
            };
            visits.push(Visit { line, segments: segment..segment, stops: stop..stop, begin });
        }
        let visit = visits.last_mut().expect("one was pushed");
        if is_stop {
            stop += 1;
            visit.stops.end = stop;
        } else {
            segment += 1;
            visit.segments.end = segment;
        }
        last_was_stop = is_stop;
    }
    visits
}

/// Returns the times at which the simulated machine is at each of `places`, s; the places must be in program
/// order.
pub fn times(toolpath: &Toolpath, plan: &FeedPlan, places: &[ProgramPlace]) -> Vec<f64> {
    let profile = Profile::new(toolpath, plan);
    let waits = wait_times(plan, &profile);
    let along: Vec<f64> = (places.iter())
        .filter_map(|place| match place {
            ProgramPlace::Along(distance) => Some(*distance),
            ProgramPlace::Start | ProgramPlace::Stop(_) | ProgramPlace::After(_) => None,
        })
        .collect();
    let mut crossings = profile.crossing_times(&along).into_iter();
    let at = |stop: usize| waits.get(stop).cloned().unwrap_or(profile.cycle_time()..profile.cycle_time());
    let time = |place: &ProgramPlace| match *place {
        ProgramPlace::Start => 0.0,
        ProgramPlace::Along(_) => crossings.next().expect("one for each distance"),
        ProgramPlace::Stop(stop) => at(stop).start,
        ProgramPlace::After(stop) => at(stop).end,
    };
    places.iter().map(time).collect()
}

/// Returns the times at which each stop of the plan begins and ends, s.
fn wait_times(plan: &FeedPlan, profile: &Profile) -> Vec<Range<f64>> {
    let mut waits = Vec::new();
    for (index, phase) in plan.phases.iter().enumerate() {
        if let Phase::Wait(_) = phase {
            waits.push(profile.phase_time(index));
        }
    }
    waits
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::Machine;
    use crate::simulation::gcode::read;
    use crate::simulation::interpreter::trace;
    use crate::simulation::simulate;

    #[test]
    fn visits_hold_every_item_once_and_begin_in_order_of_time() {
        let program = b"M3 S100\nG1 X10 F600\nG4 P1\nM8\nX20 M9\nM98 P10 L2\nX0\nM30\nO10\nY5\nY0\nM99\n";
        let machine = Machine::default();
        let toolpath = trace(&read(program), &machine);
        let visits = visits(&toolpath);
        assert_eq!(visits.iter().map(|visit| visit.segments.len()).sum::<usize>(), toolpath.segments.len());
        assert_eq!(visits.iter().map(|visit| visit.stops.len()).sum::<usize>(), toolpath.stops.len());
        let plan = simulate(&toolpath, &machine);
        let places: Vec<ProgramPlace> = visits.iter().map(|visit| visit.begin).collect();
        let times = times(&toolpath, &plan, &places);
        assert!(times.windows(2).all(|pair| pair[0] <= pair[1]), "{visits:?}: {times:?}");
        let lines: Vec<u32> = visits.iter().map(|visit| visit.line.0).collect();
        assert_eq!(&lines[..5], [1, 2, 3, 4, 5], "{lines:?}");
    }
}
