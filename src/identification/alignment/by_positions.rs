//! A recording with positions → its alignment.
//!
//! Positions may be in machine coordinates. If all of them are off the path, and their extent equals the
//! extent of the path, the difference is taken as the zero point and reported. Marks are evenly spaced in time while
//! the tool moves. Near a corner the tool cuts off a part of the path, and the projection of its position
//! jumps over that part: at most by 2 (1 − cos φ) times the deviation at the corner, where φ is the turn. The
//! jump is added to the uncertainty of the marks near the corner. The deviation is the distance at which the
//! recorded tool passed the corner, at most the tolerance or half of the shorter leg; a stop at a corner is
//! therefore known as well as one elsewhere. If a sample is so near to a stop of the program that noise
//! decides on which side it lies, there is no mark: its time could be off by the whole wait.

use std::ops::Range;
use std::sync::Arc;

use nalgebra::Matrix3;

use crate::identification::alignment::hints::{extents_differ_by, what_would_fit};
use crate::identification::alignment::map_matching::{
    COARSE_DISTANCE_FACTOR, MIN_DISPLACEMENT_SIGMAS, MatchedPass, Track, follow, scale,
};
use crate::identification::alignment::path::Path;
use crate::identification::alignment::place::ProgramPlace;
use crate::identification::alignment::registration::shifts;
use crate::identification::alignment::{Alignment, AlignmentError, Fix, Mark, Method, checked, is_of_units};
use crate::identification::recording::{ChannelUnit, Measure, Recording, check_unit_by};
use crate::machine::Machine;
use crate::simulation::feed::Tolerances;
use crate::simulation::toolpath::{Point, Toolpath, Vector, distance_from_chord};

/// Least part of the recording, or of the path, that a pass must make up.
const MIN_PASS_SHARE: f64 = 0.5;
/// Most shifts that are tried, and most improvements of each.
const MAX_SHIFTS: usize = 3;
const REFINEMENTS: usize = 3;
/// Largest ratio of the recorded length and the length along the path, or its inverse.
const MAX_LENGTH_RATIO: f64 = 1.25;
/// Deviation of a control that blends as widely as its speed requires, mm: a corner of 90° between two legs
/// at 3000 mm/min is rounded by this at about 500 mm/s².
const WIDE_BLEND_MM: f64 = 1.0;
/// Distance from a corner at which a blend begins, in its deviations: while the tool slows down along one leg by a
/// constant deceleration over the distance r, and speeds up along the other, it passes a corner of 90° at r/4 from both;
/// on a circle, at 0.29 r.
const BLEND_REACH_RATIO: f64 = 4.0;
/// Least number of samples on lines, out of reach of all blends.
const MIN_ON_LINES: usize = 20;
/// Least part of these samples that lie on their line.
const MIN_ON_LINES_RATIO: f64 = 0.95;
/// Most marks per run.
const MAX_MARKS: usize = 4000;

/// Aligns the positions of a recording with a program. If they are off the path by the stated tolerance, wide
/// blends are tried, which leave the path only at corners.
///
/// # Errors
///
/// Returns an error if the recording is at rest, or too little of it is on the path.
pub fn by_positions(
    recording: &Recording,
    run: Range<f64>,
    toolpath: &Toolpath,
    machine: &Machine,
) -> Result<Alignment, AlignmentError> {
    let stated = AllowedDeviation::of(toolpath, Tolerances::Programmed, machine);
    let tolerance = stated.widest;
    let placed = within(recording, run.clone(), toolpath, &stated);
    if !matches!(placed, Err(AlignmentError::OffPath { .. } | AlignmentError::NowhereNear)) {
        return placed;
    }
    let wide = within(
        recording,
        run,
        toolpath,
        &AllowedDeviation::of(toolpath, Tolerances::One(WIDE_BLEND_MM), machine),
    );
    match wide.ok().filter(|wide| keeps_to_lines(wide, toolpath, tolerance)) {
        Some(wide) => Ok(wide),
        None => placed.map_err(|error| with_hint(error, recording, toolpath, tolerance)),
    }
}

/// Adds a hint to a refusal, if a change would make the recording fit.
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

/// Returns `true` if the tool followed long lines within a `tolerance` (mm), except where the widest of its blends would
/// reach from their ends.
fn keeps_to_lines(alignment: &Alignment, toolpath: &Toolpath, tolerance: f64) -> bool {
    let Some(track) = &alignment.track else { return false };
    let path = Path::new(toolpath, track.recorded);
    let deviation = |fix: &Fix| {
        let (foot, _) = path.at(fix.distance)?;
        Some((fix.distance, track.in_recorded_axes(track.position[fix.sample?] - foot).norm()))
    };
    let deviations: Vec<(f64, f64)> = alignment.fixes.iter().filter_map(deviation).collect();
    let widest = deviations.iter().map(|(_, away)| *away).fold(WIDE_BLEND_MM, f64::max);
    let scale = scale(track, tolerance);
    let distances = toolpath.distances();
    let is_inside = |at: f64| {
        let index = distances.partition_point(|end| *end <= at).saturating_sub(1);
        let is_away = |end: f64| BLEND_REACH_RATIO * widest < (at - end).abs();
        index + 1 < distances.len() && is_away(distances[index]) && is_away(distances[index + 1])
    };
    let inside: Vec<f64> =
        deviations.iter().filter(|(at, _)| is_inside(*at)).map(|(_, away)| *away).collect();
    let kept = inside.iter().filter(|away| **away <= scale).count();
    MIN_ON_LINES <= inside.len() && MIN_ON_LINES_RATIO * inside.len() as f64 <= kept as f64
}

fn within(
    recording: &Recording,
    run: Range<f64>,
    toolpath: &Toolpath,
    leeway: &AllowedDeviation,
) -> Result<Alignment, AlignmentError> {
    let tolerance = leeway.widest;
    let recorded = recording.positions().each_ref().map(Option::is_some);
    let path = Path::new(toolpath, recorded);
    let mut remarks = Vec::new();
    let mut settled = recording.clone();
    // A partial recording is shorter than the path, so that its length decides only a missing unit.
    match check_unit_by(Measure::Positions, recording, path.recorded_length()) {
        Ok(closure) => settled = settled.settled(&closure),
        Err(error) if is_of_units(&error) => return Err(error.into()),
        Err(_) => {}
    }
    let track = Track::new(settled.positions()).ok_or(AlignmentError::StandsStill)?;
    let PlacedTrack { track, shift, matched } = laid(track, &path, tolerance)?;
    if shift != Vector::zeros() {
        remarks.push(format!(
            "recorded positions are offset from the program by X {:.3}, Y {:.3}, Z {:.3} mm, as by a work offset",
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
                "the machine ran the program {passes} times; this is the run from {from:.1} s to {to:.1} s"
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
    if !(1.0 / MAX_LENGTH_RATIO / MAX_LENGTH_RATIO..MAX_LENGTH_RATIO).contains(&ratio) {
        return Err(AlignmentError::OtherWay { ratio });
    }
    let distances = toolpath.distances();
    let stops: Vec<f64> =
        toolpath.stops.iter().map(|stop| distances[stop.after.min(distances.len() - 1)]).collect();
    let marks = marks_of_fixes(&fixes, &track, &leeway.corners, &stops);
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
        feed: settled.feed.filter(|feed| matches!(feed.unit, ChannelUnit::Stated(_))),
        remarks,
        shift,
        passes,
        blends_widely: WIDE_BLEND_MM <= tolerance,
    };
    checked(alignment)
}

/// A track in the program's coordinates, matched with the path.
struct PlacedTrack {
    track: Track,
    /// Shift subtracted from its positions, mm.
    shift: Vector,
    matched: MatchedPass,
}

impl PlacedTrack {
    fn new(track: &Track, shift: Vector, path: &Path, tolerance: f64) -> Result<PlacedTrack, AlignmentError> {
        let track = if shift == Vector::zeros() { track.clone() } else { track.shifted(shift) };
        let matched = follow(&track, path, tolerance)?;
        Ok(PlacedTrack { track, shift, matched })
    }

    /// Returns `true` if the track makes up most of the recording, or of the path, and most of its samples
    /// are on the path.
    fn is_accepted(&self, path: &Path) -> bool {
        self.matched.is_on_path() && MIN_PASS_SHARE <= self.matched.part(path.recorded_length())
    }

    /// Returns the remaining offset of the track from the path, mm: by least squares across the path, where
    /// the tool is near.
    fn beside(&self, path: &Path, scale: f64) -> Vector {
        let (mut normal, mut sum) = (Matrix3::zeros(), Vector::zeros());
        for fix in &self.matched.fixes {
            let Some(((foot, tangent), sample)) = path.at(fix.distance).zip(fix.sample) else { continue };
            let away = self.track.in_recorded_axes(self.track.position[sample] - foot);
            if away.norm() < 3.0 * scale {
                let across = Matrix3::identity() - tangent * tangent.transpose();
                normal += across;
                sum += across * away;
            }
        }
        // Along an axis in whose direction the whole path runs, no offset is determined.
        let stiffness = 1e-3 * self.matched.fixes.len().max(1) as f64;
        (normal + Matrix3::identity() * stiffness)
            .try_inverse()
            .map_or(Vector::zeros(), |inverse| inverse * sum)
    }
}

/// Returns the track matched with the path without a shift, or else with the shift of the zero point at which
/// most of it fits.
fn laid(track: Track, path: &Path, tolerance: f64) -> Result<PlacedTrack, AlignmentError> {
    let as_is = match PlacedTrack::new(&track, Vector::zeros(), path, tolerance) {
        Ok(laid) if laid.is_accepted(path) => return Ok(laid),
        Err(AlignmentError::StandsStill) => return Err(AlignmentError::StandsStill),
        refused => refused,
    };
    let scale = scale(&track, tolerance);
    let mut candidates = shifts(&track, path, scale);
    candidates.truncate(MAX_SHIFTS);
    candidates.extend(extents_differ_by(&track, path));
    let mut best: Option<PlacedTrack> = None;
    for candidate in candidates {
        let Some(laid) = refined(&track, candidate, path, tolerance, scale) else { continue };
        let is_better = |best: &PlacedTrack| best.matched.on_path < 0.99 * laid.matched.on_path;
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

/// Returns the track shifted by about `shift` (mm); the shift is improved until it changes little.
fn refined(track: &Track, shift: Vector, path: &Path, tolerance: f64, scale: f64) -> Option<PlacedTrack> {
    let mut laid = PlacedTrack::new(track, shift, path, tolerance).ok()?;
    for _ in 0..REFINEMENTS {
        let change = laid.beside(path, COARSE_DISTANCE_FACTOR * scale);
        if change.norm() < 0.1 * scale {
            break;
        }
        laid = PlacedTrack::new(track, laid.shift + change, path, tolerance).ok()?;
    }
    Some(laid)
}

/// Returns marks from fixes: evenly spaced in time while the tool moves, none while it rests; `stops` are those of the
/// program along the path, mm.
fn marks_of_fixes(fixes: &[Fix], track: &Track, corners: &[CuttableCorner], stops: &[f64]) -> Vec<Mark> {
    let moving: f64 =
        fixes.windows(2).map(|pair| (pair[1].time - pair[0].time).min(4.0 * track.interval)).sum();
    let spacing = (moving / MAX_MARKS as f64).max(track.interval);
    let corners: Vec<CutCorner> = corners.iter().map(|corner| corner.as_passed(fixes, track)).collect();
    let widest = corners.iter().map(|corner| corner.zone).fold(0.0, f64::max);
    let mut marks: Vec<Mark> = Vec::new();
    for window in fixes.windows(3) {
        let [before, fix, after] = window else { continue };
        if marks.last().is_some_and(|mark| fix.time - mark.time < spacing) {
            continue;
        }
        // Next to a rest the tool moves on one side only.
        let between = |from: &Fix, to: &Fix| (to.distance - from.distance) / (to.time - from.time);
        let feedrate = between(before, fix).max(between(fix, after));
        let away = MIN_DISPLACEMENT_SIGMAS * track.noise;
        let next_stop = stops.partition_point(|stop| *stop < fix.distance - away);
        let is_at_stop = stops.get(next_stop).is_some_and(|stop| *stop <= fix.distance + away);
        if feedrate <= 0.0 || is_at_stop {
            continue;
        }
        // At a corner the projection onto the path jumps over the part that the tool cuts off.
        let next = corners.partition_point(|corner| corner.distance < fix.distance - widest);
        let near = corners[next..].iter().take_while(|corner| corner.distance < fix.distance + widest);
        let cut = near.filter(|corner| (corner.distance - fix.distance).abs() < corner.zone);
        let jump = cut.map(|corner| corner.jump).fold(0.0, f64::max);
        let along = (track.noise * track.noise + jump * jump).sqrt() / feedrate;
        let deviation = along.hypot(0.1 * track.interval).max(1e-4);
        marks.push(Mark { place: ProgramPlace::Along(fix.distance), time: fix.time, deviation });
    }
    marks
}

/// The allowed deviations from the path.
struct AllowedDeviation {
    /// Largest, mm.
    widest: f64,
    /// Corners that the tool may cut, along the path.
    corners: Vec<CuttableCorner>,
}

/// A corner that the tool may cut.
struct CuttableCorner {
    /// Distance along the path, mm.
    distance: f64,
    /// Place of the corner.
    point: Point,
    /// Jump of the projection onto the path there, as a multiple of the deviation.
    turn: f64,
    /// Largest deviation, mm.
    tolerance: f64,
}

/// A corner that the tool has cut.
struct CutCorner {
    /// Distance along the path, mm.
    distance: f64,
    /// Distance before and behind it within which the tool may be off the path, mm.
    zone: f64,
    /// Jump of the projection onto the path there, mm.
    jump: f64,
}

impl CuttableCorner {
    /// Returns the corner with the deviation at which the recorded tool passed it: between two fixes the tool
    /// may have been closer, but no farther away.
    fn as_passed(&self, fixes: &[Fix], track: &Track) -> CutCorner {
        let next = fixes.partition_point(|fix| fix.distance < self.distance);
        let seen = |fix: Option<&Fix>| fix.and_then(|fix| fix.sample).map(|sample| track.position[sample]);
        let beside = seen(next.checked_sub(1).map(|last| &fixes[last])).zip(seen(fixes.get(next)));
        let passed = beside.map_or(self.tolerance, |(from, to)| {
            distance_from_chord(track.in_recorded_axes(self.point - from), to - from)
        });
        let deviation = passed.min(self.tolerance);
        CutCorner { distance: self.distance, zone: 6.0 * deviation + 0.02, jump: self.turn * deviation }
    }
}

impl AllowedDeviation {
    fn of(toolpath: &Toolpath, tolerances: Tolerances, machine: &Machine) -> AllowedDeviation {
        let bounds = || tolerances.bounds(toolpath, machine);
        let widest = bounds().map(|bound| bound.near.max(bound.along)).fold(0.0, f64::max).min(WIDE_BLEND_MM);
        let mut corners = Vec::new();
        for (((before, after), bound), distance) in
            toolpath.segments.pairs().zip(bounds()).zip(toolpath.ends())
        {
            let cosine = before.tangent(before.length).dot(&after.tangent(0.0));
            let turn = 2.0 * (1.0 - cosine);
            if 0.01 < turn {
                let shortest = before.length.min(after.length);
                let tolerance = bound.corner.min(WIDE_BLEND_MM).min(0.5 * shortest);
                corners.push(CuttableCorner { distance, point: before.end, turn, tolerance });
            }
        }
        AllowedDeviation { widest, corners }
    }
}
