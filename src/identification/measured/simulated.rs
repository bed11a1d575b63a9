//! A machine and a run → the recording that this machine would leave: the motion of its drives at the
//! interval of the stamps, each sample with its place.

use std::sync::Arc;

use crate::identification::alignment::{Alignment, Fix, Mark, Method, Track, times_at_marks};
use crate::identification::fit::Run;
use crate::machine::Machine;
use crate::simulation::drive::actual_motion;
use crate::simulation::profile::{Profile, Resolution};
use crate::simulation::sampled::rows_around;
use crate::simulation::toolpath::Point;

/// Most samples; the rest of longer runs is not simulated.
const MAX_SAMPLES: usize = 1_000_000;

/// Returns the recording that a machine would leave.
pub fn simulated(machine: &Machine, run: &Run) -> Alignment {
    let machine = &run.machine(machine);
    let plan = run.plan(machine);
    let recorded = run.alignment;
    let times = times_at_marks(run.toolpath, machine, &plan, recorded);
    let marks = recorded.marks.iter().zip(times).map(|(mark, time)| Mark { time, ..*mark });
    let mut own = Alignment { marks: marks.collect(), ..recorded.clone() };
    let Some(track) = recorded.track.as_deref().filter(|_| recorded.method == Method::Positions) else {
        return own;
    };
    let profile = Profile::new(run.toolpath, &plan);
    let ideal = profile.samples(Resolution::MOTION);
    let actual = actual_motion(&ideal, machine);
    let count = ((profile.cycle_time() / track.interval).ceil() as usize + 1).min(MAX_SAMPLES);
    let (mut row, mut place) = (0, 0);
    let mut like = Track { time: Vec::new(), position: Vec::new(), ..*track };
    own.fixes.clear();
    let mut last: Option<Point> = None;
    for at in 0..count {
        let time = at as f64 * track.interval;
        let (position, _) = actual.motion_at(time, &mut row);
        let position = Point::from(position);
        // As in a recording, a position at rest occurs once.
        if last == Some(position) {
            continue;
        }
        last = Some(position);
        let distance =
            rows_around(&ideal.time, time, &mut place).map_or(0.0, |rows| rows.between(&ideal.distance));
        own.fixes.push(Fix { time, distance, sample: Some(like.time.len()) });
        like.time.push(time);
        like.position.push(position);
    }
    own.track = Some(Arc::new(like));
    own
}
