//! The contour tolerance of each segment: one for the whole program, or those that the program sets.
//!
//! Along a segment the tolerance limits the distance by which the motion runs inside an arc; at a corner, the
//! distance at which the motion passes the corner. A corner between segments of different tolerances has the
//! smaller one; an arc that ends there keeps its own.
//!
//! A distance d along the path at which the rounding of a corner may begin (G641 ADIS) is no deviation. A
//! parabola that leaves one leg d before the corner and joins the other d after it passes the corner at
//!
//! ```text
//! ε = d/2 sin(φ/2) = d/4 ‖u2 − u1‖
//! ```
//!
//! (φ angle of the turn, u unit tangents). This is exactly the path of one filter at full feedrate; a circle
//! would pass at d tan(φ/4), which is the same for small φ. If the turn is so shallow that ε is below the
//! machine's own tolerance, the machine's tolerance replaces ε, because no control slows down for a turn that
//! its axes hardly notice. The tolerance at a corner is never more than d/2.

use crate::machine::Machine;
use crate::simulation::gcode::LineNumber;
use crate::simulation::ordered::sort_by_number;
use crate::simulation::running_sum::running_sum;
use crate::simulation::toolpath::{Blending, Curve, PathMode, Segment, Toolpath};

/// The source of the contour tolerances.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tolerances {
    /// One for the whole program, whatever the program sets, mm. Exact stops remain.
    One(f64),
    /// The program's own, and the machine's where the program sets none.
    Programmed,
}

impl From<f64> for Tolerances {
    fn from(tolerance: f64) -> Tolerances {
        Tolerances::One(tolerance)
    }
}

/// The tolerances of one segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SegmentTolerance {
    /// Largest deviation along the segment and at turns that bend little, mm.
    along: f64,
    /// Distance before a corner at which its rounding may begin, mm; 0 if the deviation at a corner is
    /// limited as along the segment.
    distance: f64,
}

impl SegmentTolerance {
    fn of(blending: Blending, machine: f64) -> SegmentTolerance {
        match blending {
            Blending::ExactStop | Blending::ExactPath | Blending::Machine => {
                SegmentTolerance { along: machine, distance: 0.0 }
            }
            Blending::Within(tolerance) => SegmentTolerance { along: tolerance, distance: 0.0 },
            Blending::Distance(distance) => SegmentTolerance { along: machine.min(0.5 * distance), distance },
        }
    }

    /// Returns the largest deviation along the segment, mm.
    pub fn along(self) -> f64 {
        self.along
    }

    /// Returns the largest deviation at a corner of the segment where its tangent changes by `change` (‖u2 −
    /// u1‖), mm.
    fn at_corner(self, change: f64) -> f64 {
        self.along.max(0.25 * self.distance * change)
    }

    /// Returns the largest deviation at the corner to a segment with the tolerances `next`, mm.
    pub fn towards(self, next: SegmentTolerance, change: f64) -> f64 {
        self.at_corner(change).min(next.at_corner(change))
    }

    /// Returns the largest deviation at any corner, mm.
    fn largest(self) -> f64 {
        self.at_corner(2.0)
    }
}

/// The tolerances along a segment and at the corner that ends it, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToleranceBound {
    /// Along the segment.
    pub along: f64,
    /// At the corner that ends the segment.
    pub corner: f64,
    /// On arcs near that corner: the larger of the tolerances of arc and corner.
    pub near: f64,
}

impl Tolerances {
    /// Returns the tolerances of the segments from `first` on.
    pub fn limits<'a>(
        self,
        toolpath: &'a Toolpath,
        machine: &Machine,
        first: usize,
    ) -> impl Iterator<Item = SegmentTolerance> + 'a {
        let own = machine.interpolator.contour_tolerance;
        let instead = machine.path_modes.tolerance_override;
        let held = move |blending: Blending| match (blending, instead) {
            (Blending::Within(_), Some(other)) => Blending::Within(other),
            _ => blending,
        };
        let (modes, before): (&[PathMode], _) = match self {
            Tolerances::One(tolerance) => (&[], SegmentTolerance::of(Blending::Within(tolerance), own)),
            Tolerances::Programmed => (&toolpath.path_modes, SegmentTolerance::of(Blending::Machine, own)),
        };
        let mut next = modes.partition_point(|mode| mode.from <= first);
        let mut now = next
            .checked_sub(1)
            .map_or(before, |index| SegmentTolerance::of(held(modes[index].blending), own));
        (first..toolpath.segments.len()).map(move |segment| {
            while let Some(mode) = modes.get(next).filter(|mode| mode.from <= segment) {
                now = SegmentTolerance::of(held(mode.blending), own);
                next += 1;
            }
            now
        })
    }

    /// Returns the tolerances along each segment and at the corner that ends it.
    pub fn bounds<'a>(
        self,
        toolpath: &'a Toolpath,
        machine: &Machine,
    ) -> impl Iterator<Item = ToleranceBound> + 'a {
        let limits = self.limits(toolpath, machine, 0);
        let mut following = self.limits(toolpath, machine, 1);
        let segments = &toolpath.segments;
        limits.enumerate().map(move |(index, limit)| {
            let along = limit.along;
            let Some(next) = following.next() else {
                return ToleranceBound { along, corner: along, near: along };
            };
            let has_distance = limit.distance != 0.0 || next.distance != 0.0;
            let change =
                if has_distance { change(&segments.at(index), &segments.at(index + 1)) } else { 0.0 };
            let corner = limit.towards(next, change);
            let of_arc =
                |index: usize, along: f64| if *segments.curve(index) == Curve::Line { 0.0 } else { along };
            let near = corner.max(of_arc(index, along)).max(of_arc(index + 1, next.along));
            ToleranceBound { along, corner, near }
        })
    }

    /// Returns the range of each path mode of the program, from its first move to its last; empty if one
    /// tolerance replaces the modes, or if the program sets none.
    pub fn ranges(self, toolpath: &Toolpath, machine: &Machine) -> Vec<ToleranceRange> {
        match self {
            Tolerances::One(_) => Vec::new(),
            Tolerances::Programmed => held(toolpath, machine),
        }
    }

    /// Returns one tolerance for the whole program, mm: that along most of the cut length, or along most of
    /// the moved length if nothing is cut.
    pub fn prevailing(self, held: &[ToleranceRange], machine: &Machine) -> f64 {
        let own = match self {
            Tolerances::One(tolerance) => tolerance,
            Tolerances::Programmed => machine.interpolator.contour_tolerance,
        };
        let mut parts: Vec<&ToleranceRange> = held.iter().collect();
        sort_by_number(&mut parts, |part| part.tolerance);
        let sum = |parts: &[&ToleranceRange], length: fn(&ToleranceRange) -> f64| {
            running_sum(parts.iter().map(|part| length(part))).last().unwrap_or(0.0)
        };
        let alike = parts.chunk_by(|a, b| a.tolerance == b.tolerance);
        let lengths = alike
            .map(|parts| (sum(parts, |part| part.cut), sum(parts, |part| part.moved), parts[0].tolerance));
        lengths
            .reduce(|a, b| if (a.0, a.1) < (b.0, b.1) { b } else { a })
            .map_or(own, |(.., tolerance)| tolerance)
    }
}

/// Returns ‖u2 − u1‖ between two segments.
pub(super) fn change(before: &Segment, after: &Segment) -> f64 {
    (after.tangent(0.0) - before.tangent(before.length)).norm()
}

/// A part of the program with one path mode.
#[derive(Clone, Debug, PartialEq)]
pub struct ToleranceRange {
    /// Lines of the first and last move.
    pub lines: (LineNumber, LineNumber),
    /// Distance along the path at which the range begins and ends, mm.
    pub distance: (f64, f64),
    /// Largest allowed deviation, mm.
    pub tolerance: f64,
    /// The blending that the program requests.
    pub blending: Blending,
    /// The words that request it; empty before the first of them.
    pub source: String,
    /// Length of its feed moves, mm.
    cut: f64,
    /// Length of all its moves, mm.
    moved: f64,
}

fn held(toolpath: &Toolpath, machine: &Machine) -> Vec<ToleranceRange> {
    let own = machine.interpolator.contour_tolerance;
    let (modes, segments) = (&toolpath.path_modes, &toolpath.segments);
    let mut parts: Vec<ToleranceRange> = Vec::new();
    let mut next = 0;
    let mut begin = 0.0;
    for ((index, segment), end) in segments.iter().enumerate().zip(toolpath.ends()) {
        let mode = modes.get(next).filter(|mode| mode.from <= index);
        if parts.is_empty() || mode.is_some() {
            next += usize::from(mode.is_some());
            let blending = mode.map_or(Blending::Machine, |mode| mode.blending);
            parts.push(ToleranceRange {
                lines: (segment.line, segment.line),
                distance: (begin, begin),
                tolerance: SegmentTolerance::of(blending, own).largest(),
                blending,
                source: mode.map_or(String::new(), |mode| mode.source.clone()),
                cut: 0.0,
                moved: 0.0,
            });
        }
        begin = end;
        let part = parts.last_mut().expect("the first segment begins a part");
        part.lines.1 = segment.line;
        part.distance.1 = begin;
        part.moved += segment.length;
        if !segment.motion.is_rapid() {
            part.cut += segment.length;
        }
    }
    if parts.iter().all(|part| part.blending == Blending::Machine) { Vec::new() } else { parts }
}
