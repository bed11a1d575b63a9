//! A recording with positions → its alignment.
//!
//! Positions of a machine may be in its own coordinates; where they lie beside the path as a whole, and
//! both are of the same size, the difference is taken for the zero point and said. Marks are laid evenly
//! in time while the tool moves. Near a corner the tool cuts off a piece of the path, and the foot of the
//! tool's position jumps over it: by 2 (1 − cos φ) of the tolerance at most, which the marks there are less
//! certain by.

use std::ops::Range;
use std::sync::Arc;

use nalgebra::Matrix3;

use crate::identification::alignment::hints::{extents_differ_by, what_would_fit};
use crate::identification::alignment::path::Path;
use crate::identification::alignment::place::Place;
use crate::identification::alignment::positions::{FROM_AFAR, Matched, Track, follow, scale};
use crate::identification::alignment::registration::shifts;
use crate::identification::alignment::{Alignment, AlignmentError, Fix, Mark, Method, checked, is_of_units};
use crate::identification::recording::{Measure, Recording, Scale, closure_of};
use crate::machine::Machine;
use crate::simulation::toolpath::{Blending, Toolpath, Vector};

/// Of the recording, or of the path, a pass must be so much.
const LEAST_PART: f64 = 0.5;
/// Shifts that are tried, and how often each is improved.
const MAX_SHIFTS: usize = 3;
const REFINEMENTS: usize = 3;
/// The recorded way and the way along the path must agree within this ratio.
const SAME_WAY: f64 = 1.25;
/// How far a control leaves the path that blends as widely as its speed asks for, mm: a corner of 90° between two ways at
/// 3000 mm/min is rounded so far at some 500 mm/s².
const WIDE_BLEND: f64 = 1.0;
/// Away from the ends of a line is so many times as far. So many samples there are enough to tell, of which so many are on it.
const LONG_LINE: f64 = 4.0;
const MIN_ON_LINES: usize = 20;
const MOSTLY_KEPT: f64 = 0.95;
/// Marks of positions a run at most.
const MOST_MARKS: usize = 4000;

/// Lays the positions of a recording on a program. What is off the path by the stated tolerance is tried with wide blends,
/// which leave the path at its corners alone.
pub fn by_positions(
    recording: &Recording,
    run: Range<f64>,
    toolpath: &Toolpath,
    machine: &Machine,
) -> Result<Alignment, AlignmentError> {
    let tolerance = widest_tolerance(toolpath, machine);
    let laid = within(recording, run.clone(), toolpath, tolerance);
    if !matches!(laid, Err(AlignmentError::OffPath { .. } | AlignmentError::NowhereNear)) {
        return laid;
    }
    let wide = within(recording, run, toolpath, WIDE_BLEND);
    match wide.ok().filter(|wide| keeps_to_lines(wide, toolpath, tolerance)) {
        Some(wide) => Ok(wide),
        None => laid.map_err(|error| with_hint(error, recording, toolpath, tolerance)),
    }
}

/// A refusal with what would fit, where something would.
fn with_hint(
    refusal: AlignmentError,
    recording: &Recording,
    toolpath: &Toolpath,
    tolerance: f64,
) -> AlignmentError {
    let Some(track) = Track::new(recording.positions()) else { return refusal };
    let hint = what_would_fit(&track, toolpath, track.recorded, tolerance);
    match (refusal, hint) {
        (AlignmentError::OffPath { part, .. }, hint) => AlignmentError::OffPath { part, hint },
        (_, Some(hint)) => AlignmentError::OffPath { part: 100.0, hint: Some(hint) },
        (refusal, None) => refusal,
    }
}

/// The widest tolerance that machine or program state, mm.
fn widest_tolerance(toolpath: &Toolpath, machine: &Machine) -> f64 {
    let stated = toolpath.path_modes.iter().filter_map(|mode| match mode.blending {
        Blending::Within(tolerance) => Some(machine.path_modes.tolerance_override.unwrap_or(tolerance)),
        Blending::Distance(distance) => Some(0.5 * distance),
        Blending::ExactStop | Blending::Machine => None,
    });
    stated.fold(machine.interpolator.contour_tolerance, f64::max).min(WIDE_BLEND)
}

/// Whether the tool kept to long lines, away from their ends, as closely as a `tolerance` (mm) asks for.
fn keeps_to_lines(alignment: &Alignment, toolpath: &Toolpath, tolerance: f64) -> bool {
    let Some(track) = &alignment.track else { return false };
    let scale = scale(track, tolerance);
    let path = Path::new(toolpath, track.recorded);
    let distances = toolpath.distances();
    let (mut kept, mut seen) = (0, 0);
    for fix in &alignment.fixes {
        let index = distances.partition_point(|at| *at <= fix.distance).saturating_sub(1);
        let is_away = |from: f64| LONG_LINE * WIDE_BLEND < (fix.distance - from).abs();
        let is_inside =
            index + 1 < distances.len() && is_away(distances[index]) && is_away(distances[index + 1]);
        let Some(((foot, _), sample)) = path.at(fix.distance).zip(fix.sample).filter(|_| is_inside) else {
            continue;
        };
        let away = track.position[sample] - foot;
        let recorded = (0..3).filter(|axis| track.recorded[*axis]);
        seen += 1;
        kept += usize::from(recorded.map(|axis| away[axis].powi(2)).sum::<f64>().sqrt() <= scale);
    }
    MIN_ON_LINES <= seen && MOSTLY_KEPT * seen as f64 <= kept as f64
}

fn within(
    recording: &Recording,
    run: Range<f64>,
    toolpath: &Toolpath,
    tolerance: f64,
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
    let track = Track::new(settled.positions()).ok_or(AlignmentError::StandsStill)?;
    let Laid { track, shift, matched } = laid(track, &path, tolerance)?;
    if shift != Vector::zeros() {
        remarks.push(format!(
            "positions are shifted by X {:.3}, Y {:.3}, Z {:.3} mm against the program, as by a zero point",
            shift.x, shift.y, shift.z
        ));
    }
    let passes = matched.passes;
    let fixes = matched.fixes;
    let (Some(first), Some(last)) = (fixes.first(), fixes.last()) else {
        return Err(AlignmentError::NowhereNear);
    };
    let covered = first.distance..last.distance;
    let run = match passes {
        1 => run,
        _ => {
            let (from, to) = (first.time, last.time);
            let one = format!(
                "the program was run {passes} times; the run from {from:.1} s to {to:.1} s is compared"
            );
            remarks.push(one);
            from..to
        }
    };
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
        shift,
        passes,
    };
    checked(alignment)
}

/// A track in the program's coordinates, on the path.
struct Laid {
    track: Track,
    /// What was taken off its positions, mm.
    shift: Vector,
    matched: Matched,
}

impl Laid {
    fn new(track: &Track, shift: Vector, path: &Path, tolerance: f64) -> Result<Laid, AlignmentError> {
        let track = if shift == Vector::zeros() { track.clone() } else { track.shifted(shift) };
        let matched = follow(&track, path, tolerance)?;
        Ok(Laid { track, shift, matched })
    }

    /// Whether most of the recording, or of the path, is this, and most of what lies between is on the path.
    fn is_accepted(&self, path: &Path) -> bool {
        self.matched.is_on_path() && LEAST_PART <= self.matched.part(path.recorded_length())
    }

    /// By how much the track still lies beside the path, mm: of least squares across the path, where the tool is near.
    fn beside(&self, path: &Path, scale: f64) -> Vector {
        let (mut normal, mut sum) = (Matrix3::zeros(), Vector::zeros());
        for fix in &self.matched.fixes {
            let Some(((foot, tangent), sample)) = path.at(fix.distance).zip(fix.sample) else { continue };
            let away = self.track.position[sample] - foot;
            let away = Vector::from_fn(|axis, _| if self.track.recorded[axis] { away[axis] } else { 0.0 });
            if away.norm() < 3.0 * scale {
                let across = Matrix3::identity() - tangent * tangent.transpose();
                normal += across;
                sum += across * away;
            }
        }
        // An axis along which all of the path lies is not known, and stays.
        let stiffness = 1e-3 * self.matched.fixes.len().max(1) as f64;
        (normal + Matrix3::identity() * stiffness)
            .try_inverse()
            .map_or(Vector::zeros(), |inverse| inverse * sum)
    }
}

/// The track on the path as it is, or else shifted as by a zero point to where most of it fits.
fn laid(track: Track, path: &Path, tolerance: f64) -> Result<Laid, AlignmentError> {
    let as_is = match Laid::new(&track, Vector::zeros(), path, tolerance) {
        Ok(laid) if laid.is_accepted(path) => return Ok(laid),
        Err(AlignmentError::StandsStill) => return Err(AlignmentError::StandsStill),
        refused => refused,
    };
    let scale = scale(&track, tolerance);
    let mut candidates = shifts(&track, path, scale);
    candidates.truncate(MAX_SHIFTS);
    candidates.extend(extents_differ_by(&track, path));
    let mut best: Option<Laid> = None;
    for candidate in candidates {
        let Some(laid) = refined(&track, candidate, path, tolerance, scale) else { continue };
        let is_better = |best: &Laid| best.matched.on_path < 0.99 * laid.matched.on_path;
        if laid.is_accepted(path) && best.as_ref().is_none_or(is_better) {
            best = Some(laid);
        }
    }
    if let Some(best) = best {
        return Ok(best);
    }
    let laid = as_is?;
    let part = laid.matched.off_path.max(1.0 - laid.matched.part(path.recorded_length()));
    Err(AlignmentError::OffPath { part: 100.0 * part, hint: None })
}

/// The track shifted by about `shift` (mm), which is improved until it changes little.
fn refined(track: &Track, shift: Vector, path: &Path, tolerance: f64, scale: f64) -> Option<Laid> {
    let mut laid = Laid::new(track, shift, path, tolerance).ok()?;
    for _ in 0..REFINEMENTS {
        let change = laid.beside(path, FROM_AFAR * scale);
        if change.norm() < 0.1 * scale {
            break;
        }
        laid = Laid::new(track, laid.shift + change, path, tolerance).ok()?;
    }
    Some(laid)
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
