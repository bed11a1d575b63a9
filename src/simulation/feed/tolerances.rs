//! Which contour tolerance holds where: one for the whole program, or what the program itself sets.
//!
//! Along a segment the tolerance bounds how far inside an arc the motion may run; at a corner, how
//! far it may pass by. A corner between segments of different tolerances has the smaller one, and an
//! arc that ends there its own.
//!
//! A distance d along the path at which the rounding of a corner may begin (G641 ADIS) is no
//! deviation. A parabola that leaves one leg d before the corner and joins the other d after it
//! passes by the corner at
//!
//! ```text
//! ε = d/2 sin(φ/2) = d/4 ‖u2 − u1‖
//! ```
//!
//! (φ angle of the turn, u unit tangents). That is the path of one filter at full feedrate exactly;
//! a circle would pass at d tan(φ/4), the same for small φ. It is never more than d/2. Where the
//! turn is so shallow that ε is below the machine's own tolerance, this holds in its place, as no
//! control slows down for a turn that its axes do not feel; but never more than d/2.

use crate::machine::Machine;
use crate::simulation::gcode::LineNumber;
use crate::simulation::running_sum::running_sum;
use crate::simulation::toolpath::{Blending, Curve, Motion, PathMode, Segment, Toolpath};

/// What the contour tolerances are taken from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tolerances {
    /// One for the whole program, whatever it says, mm. Exact stops stay.
    One(f64),
    /// The program's own, and the machine's where it sets none.
    Programmed,
}

impl From<f64> for Tolerances {
    fn from(tolerance: f64) -> Tolerances {
        Tolerances::One(tolerance)
    }
}

/// What holds along one segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limit {
    /// Largest deviation along the segment and at turns that bend little, mm.
    along: f64,
    /// Distance before a corner at which its rounding may begin, mm; 0 where the deviation at a
    /// corner is that along the segment.
    distance: f64,
}

impl Limit {
    fn of(blending: Blending, machine: f64) -> Limit {
        match blending {
            Blending::ExactStop | Blending::Machine => Limit { along: machine, distance: 0.0 },
            Blending::Within(tolerance) => Limit { along: tolerance, distance: 0.0 },
            Blending::Distance(distance) => Limit { along: machine.min(0.5 * distance), distance },
        }
    }

    /// Largest deviation along the segment, mm.
    pub fn along(self) -> f64 {
        self.along
    }

    /// Largest deviation at a corner of the segment where its tangent changes by `change`
    /// (‖u2 − u1‖), mm.
    fn at_corner(self, change: f64) -> f64 {
        self.along.max(0.25 * self.distance * change)
    }

    /// Largest deviation at the corner to a segment with the limit `next`, mm.
    pub fn towards(self, next: Limit, change: f64) -> f64 {
        self.at_corner(change).min(next.at_corner(change))
    }

    /// Largest deviation at any corner, mm.
    fn largest(self) -> f64 {
        self.at_corner(2.0)
    }
}

/// What holds along a segment and at the corner that ends it, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bound {
    /// Along the segment.
    pub along: f64,
    /// At the corner that ends it.
    pub corner: f64,
    /// On arcs near that corner: what is theirs, or the corner's where it has more.
    pub near: f64,
}

impl Tolerances {
    /// The limits of the segments from `first` on.
    pub fn limits<'a>(
        self,
        toolpath: &'a Toolpath,
        machine: &Machine,
        first: usize,
    ) -> impl Iterator<Item = Limit> + 'a {
        let own = machine.interpolator.contour_tolerance;
        let instead = machine.path_modes.tolerance_override;
        let held = move |blending: Blending| match (blending, instead) {
            (Blending::Within(_), Some(other)) => Blending::Within(other),
            _ => blending,
        };
        let (modes, before): (&[PathMode], _) = match self {
            Tolerances::One(tolerance) => (&[], Limit::of(Blending::Within(tolerance), own)),
            Tolerances::Programmed => (&toolpath.path_modes, Limit::of(Blending::Machine, own)),
        };
        let mut next = modes.partition_point(|mode| mode.from <= first);
        let mut now = next.checked_sub(1).map_or(before, |index| Limit::of(held(modes[index].blending), own));
        (first..toolpath.segments.len()).map(move |segment| {
            while let Some(mode) = modes.get(next).filter(|mode| mode.from <= segment) {
                now = Limit::of(held(mode.blending), own);
                next += 1;
            }
            now
        })
    }

    /// What holds along each segment and at the corner that ends it.
    pub fn bounds<'a>(self, toolpath: &'a Toolpath, machine: &Machine) -> impl Iterator<Item = Bound> + 'a {
        let limits = self.limits(toolpath, machine, 0);
        let mut following = self.limits(toolpath, machine, 1);
        let segments = &toolpath.segments;
        limits.enumerate().map(move |(index, limit)| {
            let along = limit.along;
            let Some(next) = following.next() else { return Bound { along, corner: along, near: along } };
            let has_distance = limit.distance != 0.0 || next.distance != 0.0;
            let change =
                if has_distance { change(&segments.at(index), &segments.at(index + 1)) } else { 0.0 };
            let corner = limit.towards(next, change);
            let of_arc =
                |index: usize, along: f64| if *segments.curve(index) == Curve::Line { 0.0 } else { along };
            let near = corner.max(of_arc(index, along)).max(of_arc(index + 1, next.along));
            Bound { along, corner, near }
        })
    }

    /// Where each of the program's path modes holds, from its first move to its last; empty where
    /// one tolerance is laid over all of it, and where the program leaves all to the machine.
    pub fn held(self, toolpath: &Toolpath, machine: &Machine) -> Vec<Held> {
        match self {
            Tolerances::One(_) => Vec::new(),
            Tolerances::Programmed => held(toolpath, machine),
        }
    }

    /// One number for all of it, mm: the tolerance under which most of the way is cut, or moved
    /// where nothing is cut; `held` is what holds where.
    pub fn prevailing(self, held: &[Held], machine: &Machine) -> f64 {
        let own = match self {
            Tolerances::One(tolerance) => tolerance,
            Tolerances::Programmed => machine.interpolator.contour_tolerance,
        };
        let mut parts: Vec<&Held> = held.iter().collect();
        parts.sort_by(|a, b| a.tolerance.total_cmp(&b.tolerance));
        let sum = |parts: &[&Held], length: fn(&Held) -> f64| {
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

/// ‖u2 − u1‖ between two segments.
pub(super) fn change(before: &Segment, after: &Segment) -> f64 {
    (after.tangent(0.0) - before.tangent(before.length)).norm()
}

/// A part of the program with one path mode.
#[derive(Clone, Debug, PartialEq)]
pub struct Held {
    /// Lines of its first and last move.
    pub lines: (LineNumber, LineNumber),
    /// Distance along the path where it begins and ends, mm.
    pub distance: (f64, f64),
    /// Largest deviation that it allows, mm.
    pub tolerance: f64,
    /// What the program asks for.
    pub blending: Blending,
    /// The words that ask for it; empty where the program has not said anything yet.
    pub source: String,
    /// Length of its feed moves, mm.
    cut: f64,
    /// Length of all its moves, mm.
    moved: f64,
}

fn held(toolpath: &Toolpath, machine: &Machine) -> Vec<Held> {
    let own = machine.interpolator.contour_tolerance;
    let (modes, segments) = (&toolpath.path_modes, &toolpath.segments);
    let mut parts: Vec<Held> = Vec::new();
    let mut next = 0;
    let mut begin = 0.0;
    for (index, segment) in segments.iter().enumerate() {
        let mode = modes.get(next).filter(|mode| mode.from <= index);
        if parts.is_empty() || mode.is_some() {
            next += usize::from(mode.is_some());
            let blending = mode.map_or(Blending::Machine, |mode| mode.blending);
            parts.push(Held {
                lines: (segment.line, segment.line),
                distance: (begin, begin),
                tolerance: Limit::of(blending, own).largest(),
                blending,
                source: mode.map_or(String::new(), |mode| mode.source.clone()),
                cut: 0.0,
                moved: 0.0,
            });
        }
        begin += segment.length;
        let part = parts.last_mut().expect("the first segment begins a part");
        part.lines.1 = segment.line;
        part.distance.1 = begin;
        part.moved += segment.length;
        if segment.motion != Motion::Rapid {
            part.cut += segment.length;
        }
    }
    if parts.iter().all(|part| part.blending == Blending::Machine) { Vec::new() } else { parts }
}
