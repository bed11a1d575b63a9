//! Chains of nearly straight lines run as one line, and corners that a curve passes.
//!
//! A chain of feed moves begins at B. The line to a further point E joins it while every point P that
//! was passed lies within Q of the segment BE,
//!
//! ```text
//! ‖P − B − t M‖ ≤ Q,   M = E − B,   t = (P − B)·M / ‖M‖², no less than 0 and no more than 1
//! ```
//!
//! and the chain has at most [`MAX_CHAIN_POINTS`] points, so that the work is linear. A chain ends before
//! anything but a line, before another feedrate or path mode, at a stop, before a move on which rotary axes
//! turn, and before a line that would return to B. An arc around Z whose middle lies within Q of its chord
//! becomes the two lines over that middle, which may join chains as well.
//!
//! A chain is planned as one segment along its chord, and the module `substitute` transfers the plan to the
//! program; a position on the program is within Q of the corresponding one on the chord.
//!
//! Q is the merge distance of the machine. If the machine leaves it to the program, which only the law of
//! LinuxCNC does, Q is the word Q of G64, or else P; without either, or with exact stops, no lines are
//! merged. A tolerance for the whole program counts as P.
//!
//! Other controls leave no point out, but run a curve past the corners (COMPCAD of Siemens, smoothing of
//! Fanuc). Truefeed takes a parabola that touches both lines at the same distance from the corner, which is the
//! length of the shorter line. The parabola passes the corner at a distance of
//!
//! ```text
//! L ‖u₂ − u₁‖ / 4          L length of the shorter line, u unit tangents
//! ```
//!
//! If that is less than the distance set for the machine, the corner does not slow the motion.
//!
//! Limits: with [`CornerMode::Guaranteed`](crate::machine::CornerMode) nothing is corrected inside a chain,
//! and corners that a curve passes are kept within the tolerance like all others. Length and curvature refer
//! to the program, not to the curve. Source: LinuxCNC, naive CAM detector (src/emc/task/emccanon.cc).

use crate::machine::{Junction, Machine};
use crate::simulation::feed::Tolerances;
use crate::simulation::feed::substitute::{Cover, Substitute};
use crate::simulation::feed::tolerances::change;
use crate::simulation::toolpath::{Blending, Curve, PathMode, Point, Segment, Toolpath, distance_from_chord};

/// Most points of a chain in addition to its beginning.
const MAX_CHAIN_POINTS: usize = 101;

/// Largest tilt of the plane of a circle at which it counts as the plane of X and Y.
const MAX_PLANE_TILT: f64 = 1e-9;

/// Returns the distance at which a curve between two lines passes their corner, mm; `None` if the segments
/// are not two lines that meet in a corner.
pub fn rounding(before: &Segment, after: &Segment) -> Option<f64> {
    let is_cut = |segment: &Segment| segment.curve == Curve::Line && !segment.motion.is_rapid();
    (is_cut(before) && is_cut(after)).then(|| 0.25 * before.length.min(after.length) * change(before, after))
}

/// Returns `true` if the machine passes the corner between two segments on a curve.
pub fn is_rounded(before: &Segment, after: &Segment, machine: &Machine) -> bool {
    // The law of LinuxCNC has its own curve at every corner.
    !machine.interpolator.junction.blends_in_time()
        && rounding(before, after).is_some_and(|rounding| rounding < machine.interpolator.corner_smoothing)
}

/// Returns the toolpath with its chains merged; `None` if there is none to merge.
pub fn merged(toolpath: &Toolpath, machine: &Machine, tolerances: Tolerances) -> Option<Substitute> {
    let junction = machine.interpolator.junction;
    let leaves_it = junction.blends_in_time()
        && junction != Junction::ExactPath
        && std::f64::consts::PI <= machine.interpolator.stopping_angle();
    if !(machine.interpolator.path_smoothing.map_or(leaves_it, |within| 0.0 < within)) {
        return None;
    }
    let mut merging = Merging {
        toolpath,
        merged: Substitute::default(),
        points: Vec::new(),
        cover: Cover { first: 0, offset: 0.0, last: 0, length: 0.0 },
        has_merged: false,
    };
    let mut modes = toolpath.path_modes.iter().peekable();
    let mut spins = toolpath.spins.iter().peekable();
    let mut within = distance(None, machine, tolerances);
    for (number, segment) in toolpath.segments.iter().enumerate() {
        while let Some(mode) = modes.next_if(|mode| mode.from <= number) {
            merging.flush();
            within = distance(Some(mode), machine, tolerances);
            merging.merged.take_path_mode(mode);
        }
        while let Some((_, spin)) = spins.next_if(|(from, _)| *from <= number) {
            let times = &machine.times;
            if 0.0 < times.spindle_change.max(times.spindle_at_feed).max(times.spindle_ramp_at_feed) {
                merging.flush();
            }
            merging.merged.take_spin(*spin);
        }
        merging.take(number, &segment, within, machine);
    }
    merging.flush();
    merging.merged.take_stops(toolpath, usize::MAX);
    merging.has_merged.then_some(merging.merged)
}

/// Returns Q under a path mode, mm.
fn distance(mode: Option<&PathMode>, machine: &Machine, tolerances: Tolerances) -> f64 {
    let blending = mode.map_or(Blending::Machine, |mode| mode.blending);
    let by_program = || match (tolerances, blending) {
        (Tolerances::One(tolerance), _) => tolerance,
        (_, Blending::Within(tolerance)) => {
            let own = mode.and_then(|mode| mode.merging);
            own.unwrap_or(machine.path_modes.tolerance_override.unwrap_or(tolerance))
        }
        _ => mode.and_then(|mode| mode.merging).unwrap_or(0.0),
    };
    match blending {
        Blending::ExactStop | Blending::ExactPath => 0.0,
        _ => machine.interpolator.path_smoothing.unwrap_or_else(by_program),
    }
}

/// The chain under construction, and the chains before it.
struct Merging<'a> {
    toolpath: &'a Toolpath,
    merged: Substitute,
    /// Points of the chain after its beginning.
    points: Vec<Point>,
    /// The part of the program that the chain covers.
    cover: Cover,
    /// `true` if anything differs from the program.
    has_merged: bool,
}

impl Merging<'_> {
    /// Adds the next segment of the program.
    fn take(&mut self, number: usize, segment: &Segment, within: f64, machine: &Machine) {
        let joins = |before: &Segment| {
            let of_feed = |segment: &Segment| machine.overrides.of_feed(segment.line.0);
            before.motion == segment.motion && !before.exact_stop && of_feed(before) == of_feed(segment)
        };
        if self.merged.stops_before(self.toolpath, number)
            || !number.checked_sub(1).is_some_and(|k| joins(&self.toolpath.segments.at(k)))
        {
            self.flush();
            self.merged.take_stops(self.toolpath, number);
        }
        let may_merge = within != 0.0 && !segment.motion.is_rapid() && segment.rotation.is_none();
        match &segment.curve {
            Curve::Line if may_merge => self.add(number, 0.0, segment.length, segment.end, within),
            Curve::Arc(arc) if may_merge => {
                let half = 0.5 * segment.length;
                let middle = segment.point(half);
                let chord = segment.start + 0.5 * (segment.end - segment.start);
                let is_level = arc.e1.z.abs().max(arc.e2.z.abs()) < MAX_PLANE_TILT;
                let stays_whole = machine.interpolator.stopping_angle() < std::f64::consts::PI;
                if is_level
                    && !stays_whole
                    && arc.sweep < std::f64::consts::PI
                    && (middle - chord).norm() < within
                {
                    self.add(number, 0.0, half, middle, within);
                    self.add(number, half, segment.length - half, segment.end, within);
                } else {
                    self.copy(number, segment);
                }
            }
            _ => self.copy(number, segment),
        }
    }

    /// Adds a line of `length` (mm) to `end`, which covers the segment `number` from `offset` (mm) on.
    fn add(&mut self, number: usize, offset: f64, length: f64, end: Point, within: f64) {
        if !self.points.is_empty() && !self.reaches(end, within) {
            self.flush();
        }
        if self.points.is_empty() {
            self.cover = Cover { first: number, offset, last: number, length: 0.0 };
        }
        self.points.push(end);
        self.cover.last = number;
        self.cover.length += length;
    }

    /// Returns `true` if the chain may continue to `end`.
    fn reaches(&self, end: Point, within: f64) -> bool {
        let begin = self.begin();
        let chord = end - begin;
        let is_near = |point: &Point| distance_from_chord(point - begin, chord) <= within;
        self.points.len() < MAX_CHAIN_POINTS && 0.0 < chord.norm_squared() && self.points.iter().all(is_near)
    }

    fn begin(&self) -> Point {
        let first = self.toolpath.segments.at(self.cover.first);
        // A computed start of an arc may differ in its last digit, and segments chain bit for bit.
        if self.cover.offset == 0.0 { first.start } else { first.point(self.cover.offset) }
    }

    /// Ends the chain.
    fn flush(&mut self) {
        let Some(&end) = self.points.last() else { return };
        let cover = self.cover;
        let last = self.toolpath.segments.at(cover.last);
        let is_alone = cover.first == cover.last && cover.length == last.length;
        let segment = if is_alone && last.curve == Curve::Line {
            last
        } else {
            self.has_merged = true;
            let start = self.begin();
            let length = (end - start).norm();
            // The first half of an arc does not stop at its end.
            let exact_stop = last.exact_stop && end == last.end;
            Segment { start, end, curve: Curve::Line, length, exact_stop, ..last }
        };
        self.points.clear();
        self.merged.push(segment, cover);
    }

    fn copy(&mut self, number: usize, segment: &Segment) {
        self.flush();
        let cover = Cover::whole(number, segment.length);
        self.merged.push(segment.clone(), cover);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::Junction;
    use crate::simulation::gcode::read;
    use crate::simulation::interpreter::trace;

    const WITHIN: f64 = 0.02;

    fn machine() -> Machine {
        let mut machine = Machine::default();
        machine.interpolator.path_smoothing = Some(WITHIN);
        machine
    }

    fn merged_of(program: &str, machine: &Machine) -> Option<(Toolpath, Substitute)> {
        let toolpath = trace(&read(program.as_bytes()), machine);
        merged(&toolpath, machine, Tolerances::Programmed).map(|merged| (toolpath, merged))
    }

    /// A wave through points of a given spacing, mm.
    fn wave(spacing: f64, height: f64) -> String {
        let points = (1..600).map(|k| {
            let x = spacing * f64::from(k);
            format!("X{x:.4} Y{:.4} Z{:.4}\n", height * (0.7 * x).sin(), height * (0.3 * x).cos())
        });
        "G21 G90 G1 F2000\n".to_string() + &points.collect::<String>()
    }

    #[test]
    fn chains_are_within_their_distance_and_as_long_as_they_can_be() {
        for (spacing, height) in [(0.1, 0.5), (0.3, 2.0), (0.05, 0.05), (1.0, 0.2)] {
            let (program, merged) = merged_of(&wave(spacing, height), &machine()).expect("some merge");
            let passed = |k: usize, cover: Cover, upto: usize| {
                let begin = merged.toolpath.segments.at(k).start;
                let chord = program.segments.at(upto).end - begin;
                let points = program.segments.range(cover.first..upto);
                let away = points.map(move |segment| {
                    let from = segment.end - begin;
                    let along = (from.dot(&chord) / chord.norm_squared()).clamp(0.0, 1.0);
                    (from - along * chord).norm()
                });
                away.fold(0.0, f64::max)
            };
            let mut next = 0;
            for (k, &cover) in merged.covers.iter().enumerate() {
                assert_eq!((cover.first, cover.offset), (next, 0.0), "the program is covered once");
                next = cover.last + 1;
                assert!(passed(k, cover, cover.last) <= WITHIN, "{cover:?}");
                assert!(next - cover.first <= MAX_CHAIN_POINTS);
                let could_go_on = next < program.segments.len() && next - cover.first < MAX_CHAIN_POINTS;
                assert!(!could_go_on || WITHIN < passed(k, cover, next), "{cover:?} ends early");
            }
            assert_eq!(next, program.segments.len());
        }
    }

    #[test]
    fn what_is_not_one_move_is_not_merged() {
        for between in ["F1500", "M8", "G4 P1", "G0 X2.5", "G64 P0.05", "G2 X3 Y0 I0.5"] {
            let program = format!("G1 F2000 X1\nX2\n{between}\nG1 X4\nX5");
            let (_, merged) = merged_of(&program, &machine()).expect("both ends merge");
            let lines: Vec<u32> = merged.toolpath.segments.iter().map(|segment| segment.line.0).collect();
            assert!(lines.contains(&2) && lines.last() == Some(&5), "{between}: {lines:?}");
        }
        let (_, merged) = merged_of("G1 F2000 X1\nG9 X2\nX3\nX4", &machine()).expect("both ends merge");
        let stops: Vec<bool> = merged.toolpath.segments.iter().map(|segment| segment.exact_stop).collect();
        assert_eq!(stops, [true, false]);
        assert!(merged_of("G1 F2000 X1\nX2 A5\nX3 A10\nG61 X4\nX5", &machine()).is_none());
    }

    #[test]
    fn q_is_the_programs_own_with_the_law_of_linuxcnc_alone() {
        let mut machine = Machine::default();
        let merges = |words: &str, machine: &Machine| {
            merged_of(&format!("{words}\nG1 F2000 X1\nX2 Y0.015\nX3 Y0"), machine).is_some()
        };
        assert!(!merges("G64 P0.02", &machine));
        machine.interpolator.junction = Junction::AccelerationBlend;
        for (words, expected) in [
            ("", false),
            ("G64", false),
            ("G64 P0.02", true),
            ("G64 P0.005", false),
            ("G64 P0.005 Q0.02", true),
            ("G64 P0.02 Q0", false),
            ("G64 P0 Q0.02", true),
            ("G20 G64 P0.001\nG21", true),
            ("G64 P0.02\nG64", false),
            ("G64 P0.02\nG61", false),
        ] {
            assert_eq!(merges(words, &machine), expected, "{words}");
        }
        machine.interpolator.exact_stop_angle = 0.1;
        assert!(!merges("G64 P0.02", &machine));
        machine.interpolator.exact_stop_angle = std::f64::consts::PI;
        machine.path_modes.tolerance_override = Some(0.001);
        assert!(!merges("G64 P0.02", &machine));
        machine.interpolator.path_smoothing = Some(0.02);
        assert!(merges("G64 P0.001", &machine));
    }

    #[test]
    fn a_small_arc_is_two_lines() {
        // Its middle lies 0.0125 mm from the chord.
        let program = "G1 F2000 X1\nG2 X2 Y0 I0.5 J-10\nG1 X3";
        let toolpath = trace(&read(program.as_bytes()), &machine());
        let merged = merged(&toolpath, &machine(), Tolerances::Programmed).expect("the arc is small");
        assert!(merged.toolpath.segments.iter().all(|segment| segment.curve == Curve::Line));
        let covered: f64 = merged.covers.iter().map(|cover| cover.length).sum();
        let length: f64 = toolpath.segments.iter().map(|segment| segment.length).sum();
        assert!((covered - length).abs() < 1e-12);
        assert!(merged_of("G1 F2000 X1\nG2 X3 Y0 I1 J-10\nG1 Y3", &machine()).is_none());
    }
}
