//! A recording with positions → its alignment.
//!
//! Positions of a machine may be in its own coordinates; where they lie beside the path as a whole, and
//! both are of the same size, the difference is taken for the zero point and said. Marks are laid evenly
//! in time while the tool moves. Near a corner the tool cuts off a piece of the path, and the foot of the
//! tool's position jumps over it: by 2 (1 − cos φ) of the tolerance at most, which the marks there are less
//! certain by.

use std::ops::Range;
use std::sync::Arc;

use crate::identification::alignment::hints::{extents_differ_by, what_would_fit};
use crate::identification::alignment::path::Path;
use crate::identification::alignment::place::Place;
use crate::identification::alignment::positions::{Matched, Track, follow};
use crate::identification::alignment::{Alignment, AlignmentError, Fix, Mark, Method, checked, is_of_units};
use crate::identification::recording::{Measure, Recording, Scale, closure_of};
use crate::machine::Machine;
use crate::simulation::toolpath::Toolpath;

/// Of the recorded way, so much at most may be off the path.
pub const MOST_OFF_PATH: f64 = 0.3;
/// The recorded way and the way along the path must agree within this ratio.
const SAME_WAY: f64 = 1.25;
/// Marks of positions a run at most.
const MOST_MARKS: usize = 4000;

pub fn by_positions(
    recording: &Recording,
    run: Range<f64>,
    toolpath: &Toolpath,
    machine: &Machine,
) -> Result<Alignment, AlignmentError> {
    let recorded = recording.positions().each_ref().map(Option::is_some);
    let path = Path::new(toolpath, recorded);
    let mut remarks = Vec::new();
    let mut settled = recording.clone();
    // A recording of a part cannot close; only a unit that no file states must.
    match closure_of(Measure::Positions, recording, path.recorded_length()) {
        Ok(closure) => settled = settled.settled(&closure),
        Err(error) if is_of_units(&error) => return Err(error.into()),
        Err(_) => {}
    }
    let mut track = Track::new(settled.positions()).ok_or(AlignmentError::StandsStill)?;
    let tolerance = machine.interpolator.contour_tolerance;
    let accepted = |matched: &Matched| matched.off_path <= MOST_OFF_PATH;
    let mut matched = follow(&track, &path, tolerance);
    let stands = matches!(matched, Err(AlignmentError::StandsStill));
    if !matched.as_ref().is_ok_and(accepted) && !stands {
        // Machine coordinates differ from the program's by the zero point, seen in where both lie.
        let shift = extents_differ_by(&track, &path);
        let moved = shift.map(|shift| (shift, track.shifted(shift)));
        let again = moved.and_then(|(shift, moved)| {
            let found = follow(&moved, &path, tolerance).ok().filter(accepted)?;
            Some((shift, moved, found))
        });
        match again {
            Some((shift, moved, found)) => {
                remarks.push(format!(
                    "positions are shifted by X {:.3}, Y {:.3}, Z {:.3} mm against the program, as by a zero point",
                    shift.x, shift.y, shift.z
                ));
                (track, matched) = (moved, Ok(found));
            }
            None => {
                let off = matched.as_ref().map_or(1.0, |matched| matched.off_path);
                let hint = what_would_fit(&track, toolpath, recorded, tolerance);
                return match (matched, hint) {
                    (Err(error), None) => Err(error),
                    (_, hint) => Err(AlignmentError::OffPath { part: 100.0 * off, hint }),
                };
            }
        }
    }
    let matched = matched?;
    let fixes = matched.fixes;
    let (Some(first), Some(last)) = (fixes.first(), fixes.last()) else {
        return Err(AlignmentError::NowhereNear);
    };
    let covered = first.distance..last.distance;
    let way: f64 = fixes
        .windows(2)
        .map(|pair| match (pair[0].sample, pair[1].sample) {
            (Some(a), Some(b)) => (track.position[b] - track.position[a]).norm(),
            _ => 0.0,
        })
        .sum();
    let ratio = way / (covered.end - covered.start).max(1e-9);
    if !(1.0 / SAME_WAY / SAME_WAY..SAME_WAY).contains(&ratio) {
        return Err(AlignmentError::OtherWay { ratio });
    }
    let marks = marks_of_fixes(&fixes, &track, toolpath, tolerance);
    let alignment = Alignment {
        method: Method::Positions,
        poll: None,
        run,
        marks,
        fixes,
        covered,
        length: path.length(),
        fit: 1.0 - matched.off_path,
        spread: Some(matched.spread),
        track: Some(Arc::new(track)),
        feed: settled.feed.filter(|feed| matches!(feed.scale, Scale::Stated(_))),
        remarks,
    };
    checked(alignment)
}

/// Marks from fixes: evenly in time while the tool moves, none where it stands.
fn marks_of_fixes(fixes: &[Fix], track: &Track, toolpath: &Toolpath, tolerance: f64) -> Vec<Mark> {
    let moving: f64 =
        fixes.windows(2).map(|pair| (pair[1].time - pair[0].time).min(4.0 * track.interval)).sum();
    let spacing = (moving / MOST_MARKS as f64).max(track.interval);
    let corners = corners(toolpath);
    let zone = 6.0 * tolerance + 0.02;
    let mut marks: Vec<Mark> = Vec::new();
    for window in fixes.windows(3) {
        let [before, fix, after] = window else { continue };
        if marks.last().is_some_and(|mark| fix.time - mark.time < spacing) {
            continue;
        }
        let feedrate = (after.distance - before.distance) / (after.time - before.time);
        if feedrate <= 0.0 {
            continue;
        }
        // At a corner the foot on the path jumps over what the tool cuts off.
        let next = corners.partition_point(|corner| corner.0 < fix.distance - zone);
        let cut = corners[next..].iter().take_while(|corner| corner.0 < fix.distance + zone);
        let jump = cut.map(|corner| corner.1).fold(0.0, f64::max) * tolerance;
        let along = (track.noise * track.noise + jump * jump).sqrt() / feedrate;
        let deviation = along.hypot(0.1 * track.interval).max(1e-4);
        marks.push(Mark { place: Place::Along(fix.distance), time: fix.time, deviation });
    }
    marks
}

/// Distances of corners along the path (mm) and what of the tolerance a foot on the path jumps there.
fn corners(toolpath: &Toolpath) -> Vec<(f64, f64)> {
    let mut distance = 0.0;
    let mut corners = Vec::new();
    for (before, after) in toolpath.segments.pairs() {
        distance += before.length;
        let cosine = before.tangent(before.length).dot(&after.tangent(0.0));
        let jump = 2.0 * (1.0 - cosine);
        if 0.01 < jump {
            corners.push((distance, jump));
        }
    }
    corners
}
