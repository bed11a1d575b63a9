//! Simulated recordings: the times at which a recorder would see a simulated machine at places along the
//! path.
//!
//! Lag and vibration move the tool off the path, and so the projection of its position onto it. A recording
//! of such a machine is therefore compared with a simulated recording: the actual motion at the recorder's
//! interval, aligned in the same way.

use crate::identification::alignment::map_matching::{Track, follow};
use crate::identification::alignment::path::Path;
use crate::identification::alignment::place::{ProgramPlace, times};
use crate::identification::alignment::{Alignment, Mark, Method};
use crate::machine::{Axis, Machine};
use crate::simulation::drive::actual_motion;
use crate::simulation::feed::FeedPlan;
use crate::simulation::profile::{Profile, Resolution};
use crate::simulation::toolpath::{Point, Toolpath};

/// Most samples of a simulated recording.
const MAX_SAMPLES: f64 = 200_000.0;

/// Returns a mark at each of these places, at the time of the simulated motion; `deviation` is the standard deviation of
/// each time, s.
pub fn simulated_marks(
    toolpath: &Toolpath,
    plan: &FeedPlan,
    places: Vec<ProgramPlace>,
    deviation: f64,
) -> Vec<Mark> {
    let times = times(toolpath, plan, &places);
    places.into_iter().zip(times).map(|(place, time)| Mark { place, time, deviation }).collect()
}

/// Returns a program and the recording of a machine that runs it, with a mark at the end of each block; `deviation` is the
/// standard deviation of each time, s.
#[cfg(test)]
pub fn recorded(program: &str, machine: &Machine, deviation: f64) -> (Toolpath, Alignment) {
    use crate::simulation::gcode::read;
    use crate::simulation::interpreter::trace;
    use crate::simulation::simulate;

    let toolpath = trace(&read(program.as_bytes()), machine);
    let plan = simulate(&toolpath, machine);
    let ends = toolpath.ends().map(ProgramPlace::Along).collect();
    let marks = simulated_marks(&toolpath, &plan, ends, deviation);
    let alignment = Alignment::of_marks(Method::Positions, 0.0..plan.cycle_time(), marks, 400.0);
    (toolpath, alignment)
}

/// Time between the rows of [`recorded_positions`], s.
#[cfg(test)]
pub const RECORDED_ROW_S: f64 = 0.01;

/// Returns a program, and the positions of a machine that runs it as a CSV recording. `change` returns the recorded position,
/// given the part of the run that has passed and the simulated position.
#[cfg(test)]
pub fn recorded_positions(
    program: &str,
    machine: &Machine,
    mut change: impl FnMut(f64, Point) -> Point,
) -> (Toolpath, String) {
    use crate::simulation::gcode::read;
    use crate::simulation::interpreter::trace;
    use crate::simulation::simulate;

    let toolpath = trace(&read(program.as_bytes()), machine);
    let plan = simulate(&toolpath, machine);
    let profile = Profile::new(&toolpath, &plan);
    let rows = (0..=(profile.cycle_time() / RECORDED_ROW_S) as usize).map(|row| {
        let time = RECORDED_ROW_S * row as f64;
        let at = change(time / profile.cycle_time(), profile.at_time(time).position);
        format!("{time:.2},{:.4},{:.4},{:.4}\n", at.x, at.y, at.z)
    });
    let csv = "t_s,x_mm,y_mm,z_mm\n".to_string() + &rows.collect::<String>();
    (toolpath, csv)
}

/// Returns the time at which the simulated machine is at each mark, s: on its path, or as a recorder would
/// see its drives.
pub fn times_at_marks(
    toolpath: &Toolpath,
    machine: &Machine,
    plan: &FeedPlan,
    alignment: &Alignment,
) -> Vec<f64> {
    let places: Vec<ProgramPlace> = alignment.marks.iter().map(|mark| mark.place).collect();
    let ideal = times(toolpath, plan, &places);
    let track = match (&alignment.track, alignment.method) {
        (Some(track), Method::Positions) if machine.axes.iter().any(Axis::has_drive) => track,
        _ => return ideal,
    };
    let profile = Profile::new(toolpath, plan);
    let samples = profile.samples(Resolution::MOTION);
    let actual = actual_motion(&samples, machine);
    let interval = track.interval.max(profile.cycle_time() / MAX_SAMPLES);
    let mut simulated = Track { time: Vec::new(), position: Vec::new(), ..**track };
    let mut row = 0;
    let count = (profile.cycle_time() / interval).ceil() as usize + 1;
    for at in 0..count {
        let time = at as f64 * interval;
        let (position, _) = actual.motion_at(time, &mut row);
        simulated.time.push(time);
        let recorded = |axis: usize| if track.recorded[axis] { position[axis] } else { 0.0 };
        simulated.position.push(Point::new(recorded(0), recorded(1), recorded(2)));
    }
    let path = Path::new(toolpath, track.recorded);
    let Ok(matched) = follow(&simulated, &path, machine.interpolator.contour_tolerance) else { return ideal };
    let fixes = matched.fixes;
    let mut next = 0;
    let seen = places.iter().zip(ideal).map(|(place, ideal)| {
        let ProgramPlace::Along(distance) = *place else { return ideal };
        while next < fixes.len() && fixes[next].distance < distance {
            next += 1;
        }
        match (next.checked_sub(1).map(|before| fixes[before]), fixes.get(next)) {
            (Some(before), Some(after)) if before.distance < after.distance => {
                let share = (distance - before.distance) / (after.distance - before.distance);
                before.time + share * (after.time - before.time)
            }
            _ => ideal,
        }
    });
    seen.collect()
}
