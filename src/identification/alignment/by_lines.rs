//! A recording with line numbers → its alignment.

use std::collections::HashSet;
use std::ops::Range;

use crate::identification::alignment::length_check::check_lengths;
use crate::identification::alignment::line_matching;
use crate::identification::alignment::place::{ProgramPlace, Visit, times, visits};
use crate::identification::alignment::{
    Alignment, AlignmentError, Mark, Method, checked, end_of, is_of_units,
};
use crate::identification::recording::{Recording, check_unit_on_lines};
use crate::machine::Machine;
use crate::simulation::simulate;
use crate::simulation::toolpath::Toolpath;

/// Aligns a recording within `run` (s) by its line numbers; `has_start` and `has_end` are `true` if the
/// control's status marks the beginning and the end of the run.
///
/// # Errors
///
/// Returns an error if the line numbers are not those of the program in its order.
pub fn by_lines(
    recording: &Recording,
    run: Range<f64>,
    (has_start, has_end): (bool, bool),
    toolpath: &Toolpath,
    machine: &Machine,
) -> Result<Alignment, AlignmentError> {
    let visits = visits(toolpath);
    let durations = durations(toolpath, machine, &visits);
    let mut remarks = Vec::new();
    let followed = line_matching::follow(recording, &run, &visits, &durations)?;
    if followed.count != 0 {
        remarks.push(format!(
            "recorded line numbers are {} the lines of the program by {}",
            if followed.count < 0 { "after" } else { "before" },
            followed.count.abs()
        ));
    }
    let settled = settle_feed(recording, toolpath)?;
    let distances = toolpath.distances();
    let distance_of = |place: ProgramPlace| place.distance(toolpath, &distances);
    if let Some(feed) = &settled.feed {
        let (marks, visited) = (&followed.marks, &followed.visits);
        check_lengths(feed, followed.poll, marks, visited, &visits, toolpath, distance_of)?;
    }
    let mut marks = followed.marks;
    // The first recorded line counts as the line being run, wherever the file begins.
    if has_start && followed.first == 0 {
        let deviation = followed.poll / 12.0f64.sqrt();
        marks.insert(0, Mark { place: ProgramPlace::Start, time: run.start, deviation });
    }
    if has_end && followed.visits.last().is_some_and(|last| visits.len() <= last + 3) {
        let deviation = followed.poll / 12.0f64.sqrt();
        marks.push(Mark { place: end_of(toolpath), time: run.end, deviation });
    }
    let fixes = line_matching::fixes(&settled, &marks, distance_of);
    let covered = marks.first().map_or(0.0, |mark| distance_of(mark.place))
        ..marks.last().map_or(0.0, |mark| distance_of(mark.place));
    let length = distances.last().copied().unwrap_or(0.0);
    let alignment = Alignment {
        poll: Some(followed.poll),
        fixes,
        covered,
        fit: followed.in_order,
        feed: settled.feed,
        remarks,
        ..Alignment::of_marks(Method::Lines, run, marks, length)
    };
    checked(alignment)
}

/// Returns the duration of each visit on the assumed machine, s.
fn durations(toolpath: &Toolpath, machine: &Machine, visits: &[Visit]) -> Vec<f64> {
    let begins: Vec<ProgramPlace> = visits.iter().map(|visit| visit.begin).collect();
    let plan = simulate(toolpath, machine);
    let mut begins = times(toolpath, &plan, &begins);
    begins.push(plan.cycle_time());
    begins.windows(2).map(|pair| pair[1] - pair[0]).collect()
}

/// Returns the recording with the unit of its feed determined. Only lines that cut are compared: other motion
/// of the machine is not in the program.
fn settle_feed(recording: &Recording, toolpath: &Toolpath) -> Result<Recording, AlignmentError> {
    if recording.feed.is_none() {
        return Ok(recording.clone());
    }
    let mut cutting = HashSet::new();
    let mut mixed = HashSet::new();
    for segment in &toolpath.segments {
        let set = if segment.motion.is_rapid() { &mut mixed } else { &mut cutting };
        set.insert(segment.line.0);
    }
    mixed.extend(toolpath.stops.iter().map(|stop| stop.line.0));
    cutting.retain(|line| !mixed.contains(line));
    let path: f64 = toolpath
        .segments
        .iter()
        .filter(|segment| cutting.contains(&segment.line.0))
        .map(|segment| segment.length)
        .sum();
    match check_unit_on_lines(recording, path, |line| cutting.contains(&line)) {
        Ok(closure) => Ok(recording.clone().settled(&closure)),
        Err(error) if is_of_units(&error) => Err(error.into()),
        Err(_) => Ok(recording.clone()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation::gcode::read;
    use crate::simulation::interpreter::trace;

    /// A mark lies half a visit's duration before the stamp that names it, so that a duration without the
    /// acceleration limit of an axis would put it too late.
    #[test]
    fn visits_last_as_long_as_the_axes_need() {
        let mut machine = Machine::default();
        let toolpath = trace(&read(b"G1 X40 F6000\nY1\nX0\nY0\nM30\n"), &machine);
        let visits = visits(&toolpath);
        let free = durations(&toolpath, &machine, &visits);
        machine.axes[0].acceleration = 200.0;
        let limited = durations(&toolpath, &machine, &visits);
        assert!(1.3 * free[0] < limited[0], "{free:?} {limited:?}");
    }
}
