//! The blend of LinuxCNC-like planners at a corner: a circle, a parabola, or none.
//!
//! Legs with unit directions u1, u2 turn by φ; D = ‖u2 − u1‖ = 2 sin(φ/2), C = cos(φ/2); h is the servo
//! period (s), s the largest feed override that is planned for, F the feedrate of the faster leg (mm/s).
//!
//! **Circle** of radius R that touches both legs, passed at v:
//!
//! ```text
//! ρ = min(ε C/(1 − C), ℓ C/(D/2))        ε = min(tolerance, L/4),  ℓ = least room on a leg,  aₙ = √3/2 a
//! v = min(√(aₙ ρ), s F, V)               V: no axis above its velocity limit
//! R = max(v²/aₙ, min(2 v min(√(a d), v)/(a φ), ρ))        d = ρ (D/2)/C
//! ```
//!
//! A circle takes at most half of a line, two thirds of an arc before it and a third of an arc behind it. If
//! the arc bends to the side of the turn, the circle touches the chord of the arc instead, and turns by a
//! larger angle. There is no circle if it would pass the corner of an arc at more than ε, or if it does not
//! lie in the plane of the arc. The acceleration a is the length of the largest vector that, in any direction
//! in the plane of the corner, keeps every axis within its limit and is within the limit of the path. √3/2 of
//! it turn the motion and ½ remains along the path, so that the resultant is a. V is found from the velocity
//! limits in the same way. Between lines V is the altitude of the triangle whose sides are the fastest
//! velocities V1, V2 along both legs, if that is more:
//!
//! ```text
//! V1 V2 sin φ / ‖V2 u2 − V1 u1‖
//! ```
//!
//! **Parabola**: the second leg starts while the first still brakes to a stop, both with half of their accelerations, a1 and
//! a2, from the velocity b1 on:
//!
//! ```text
//! b1 = min(F1, √(a1 L1), a1 t, 2 √(a1 ε₀/(D/2)))        t = min(L1/v1, L2/v2, max(v1/a1, v2/a2)),  ε₀ tolerance
//! ```
//!
//! where v is the minimum of the first two terms for each leg. It lasts T = b1/a1 and takes b1²/2a1 of the
//! first leg; the second speeds up by a2 to w = min(a2 T, F2). Along the parabola the speed changes from b1
//! to w with one acceleration, over the length that takes the time T. If the second leg is an arc of radius
//! r, D is the change from u1 to the direction of the acceleration, which is the sum of a2 u2 and (F2/2)²/r
//! towards the centre (`tcCircleStartAccelUnitVector`). Without circles a leg has half of its acceleration
//! only if a parabola follows it, and its whole acceleration if the parabola precedes it.
//!
//! **Stop**: between legs that are opposite to within about 2.8°, 1 + cos φ < (2°)², the motion stops; the
//! legs keep their whole acceleration.
//!
//! **Nothing**: a turn made within one servo period uses the part κ = max_k |u2 − u1|_k (sF/(h a_k) + 1) of
//! the acceleration of an axis, twice that on an arc, whose sF is at most the velocity for which √3/2 of its
//! acceleration suffices. If κ is below a tenth, the corner is not slowed at all, and its legs lose the part κ
//! of their acceleration, an arc also for its curvature. Otherwise the motion passes the corner at 0.1 sF/κ. Of
//! circle, parabola and nothing the fastest is taken; the speed of a parabola counts as C (b1 + b2)/4.
//!
//! **Exact path** (G61): no curve replaces the corner. If κ is a tenth or more the motion stops at the
//! corner, and its legs still lose a tenth of their acceleration. After G61.1 the motion stops at every
//! corner, and the legs keep their whole acceleration.
//!
//! **Last arc**: an arc between its corners has the part √(1 − (V²/(r a))²) of its acceleration a, but only ½ if a
//! function that waits or the end of the program follows it, since no further move is queued. Its feedrate is then
//! the one that its whole acceleration allows, whatever its corners take.
//!
//! **Helix**: it is planned as an arc with the radius r + h²/r, with the rise h of the whole arc, see
//! [`limits::planned_curvature`].
//!
//! Source: LinuxCNC 2.9, src/emc/tp
//! (blendmath.c: blendComputeParameters, blendParamKinematics; tp.c: tpSetupTangent, tpComputeBlendVelocity,
//! tpChooseBestBlend; tc.c: tcFinalizeLength), and recordings of it.

use crate::machine::{Junction, Machine};
use crate::simulation::feed::blend::{Blend, Leg};
use crate::simulation::feed::circle_contact::{ArcLeg, contact};
use crate::simulation::feed::junction;
use crate::simulation::feed::limits::{self, NORMAL_ACCELERATION_SHARE, TANGENTIAL_ACCELERATION_SHARE};
use crate::simulation::toolpath::{Arc, Curve, Segment, Vector};

/// Largest distance between circle and corner, as a part of the shorter leg.
const MAX_PART_OF_LEG: f64 = 0.25;
/// Part of a line that a circle may take.
const MAX_PART_OF_LINE: f64 = 0.5;
const MAX_PARTS_OF_ARCS: [f64; 2] = [2.0 / 3.0, 1.0 / 3.0];
/// Share of the acceleration that a turn without a circle may use.
const KINK_SHARE: f64 = 0.1;
/// Duration of a turn without a circle, s.
const SERVO_PERIOD_S: f64 = 1e-3;
/// Largest turn whose cosine lowers a velocity, rad.
const MAX_TURN_RAD: f64 = 0.49 * std::f64::consts::PI;
/// Turn below which there is no circle, rad.
const MIN_ANGLE_RAD: f64 = 1e-6;
/// Sine of the largest angle between the plane of an arc and the plane of the corner at which both count as
/// one plane.
const MAX_PLANE_TILT_SINE: f64 = 1e-4;
/// Legs are opposite below this value of 1 + cos φ: 2° squared.
const MAX_OPPOSITE_ONE_PLUS_COSINE: f64 =
    (2.0 * std::f64::consts::PI / 180.0) * (2.0 * std::f64::consts::PI / 180.0);
/// Part of the acceleration of each leg that a parabola uses.
pub const PARABOLA_SHARE: f64 = 0.5;

/// Least acceleration along a parabola, as a part of the legs' acceleration.
const MIN_ACCELERATION_RATIO: f64 = 1e-3;

/// A segment on one side of a corner.
#[derive(Clone, Copy)]
pub struct CornerSide<'a> {
    /// The segment.
    pub segment: &'a Segment,
    /// Requested feedrate along it, mm/s.
    pub feedrate: f64,
    /// Acceleration along the segment within a parabola, mm/s²; `None`: half the acceleration of the segment.
    pub whole_acceleration: Option<f64>,
}

/// Returns the blend at the corner between two segments with this tolerance (mm).
pub fn blend(sides: [CornerSide; 2], machine: &Machine, tolerance: f64) -> Blend {
    let corner = Corner::between(sides, machine);
    let parabola = || corner.parabola(tolerance, sides.map(|side| side.segment.length)).blend();
    if machine.interpolator.junction == Junction::ParabolicBlend {
        return parabola();
    }
    if 2.0 * corner.half_cosine.powi(2) < MAX_OPPOSITE_ONE_PLUS_COSINE {
        return Blend::none(0.0);
    }
    let kink = corner.kink();
    if kink < KINK_SHARE {
        return Blend { taken: kink, ..Blend::none(f64::INFINITY) };
    }
    if machine.interpolator.junction == Junction::ExactPath || sides[0].segment.exact_path {
        return Blend { taken: KINK_SHARE, ..Blend::none(0.0) };
    }
    let by_kink = corner.slower * KINK_SHARE / kink;
    let circle = corner.circle(tolerance);
    let by_circle = circle.map_or(0.0, |circle| circle.fastest);
    // The other ends of both segments are not planned yet, so that half of each length is assumed to be free.
    let halves = sides.map(|side| 0.5 * side.segment.length);
    let by_parabola = corner.parabola(tolerance, halves).performance(corner.half_cosine);
    match circle {
        Some(circle) if by_kink <= by_circle && by_parabola <= by_circle => circle,
        _ if by_parabola < by_kink => Blend { taken: KINK_SHARE, ..Blend::none(by_kink) },
        _ => parabola(),
    }
}

/// Returns the parabola at a corner whose neighbouring blends leave these lengths (mm) of the legs.
pub fn parabola(sides: [CornerSide; 2], machine: &Machine, tolerance: f64, lengths: [f64; 2]) -> Blend {
    Corner::between(sides, machine).parabola(tolerance, lengths).blend()
}

/// Returns a leg of which a parabola takes a part: the leg has half of its acceleration throughout, and an
/// arc also the feedrate that this acceleration allows.
pub fn shared(segment: &Segment, leg: Leg, machine: &Machine) -> Leg {
    let (acceleration, feedrate) = halved(segment, machine);
    Leg { acceleration: leg.acceleration.min(acceleration), feedrate: leg.feedrate.min(feedrate), ..leg }
}

/// Returns the acceleration along an arc behind which no move is queued, mm/s²; half as much if a parabola takes a part.
pub fn unqueued_acceleration(segment: &Segment, has_parabola: bool, machine: &Machine) -> f64 {
    let part = if has_parabola { PARABOLA_SHARE } else { 1.0 };
    part * TANGENTIAL_ACCELERATION_SHARE * limits::blended_acceleration(segment, machine)
}

/// Returns half of the acceleration of a segment, mm/s², and the largest feedrate that this acceleration
/// allows, mm/s.
fn halved(segment: &Segment, machine: &Machine) -> (f64, f64) {
    let own = PARABOLA_SHARE * limits::blended_acceleration(segment, machine);
    (junction::acceleration(segment, own, machine), limits::blended_arc_feedrate(segment, own, machine))
}

/// Returns the feedrate along an arc for which this share of its acceleration suffices, mm/s; infinite along a line.
pub fn arc_feedrate(segment: &Segment, share: f64, machine: &Machine) -> f64 {
    let acceleration = share * limits::blended_acceleration(segment, machine);
    limits::blended_arc_feedrate(segment, acceleration, machine)
}

/// A corner between two legs.
struct Corner<'a> {
    sides: [CornerSide<'a>; 2],
    machine: &'a Machine,
    /// u1, u2.
    directions: [Vector; 2],
    /// u2 − u1.
    change: Vector,
    /// D/2 and C.
    half_sine: f64,
    half_cosine: f64,
    /// The slower and the faster of the largest feedrates of both legs, mm/s.
    slower: f64,
    faster: f64,
}

impl<'a> Corner<'a> {
    fn between(sides: [CornerSide<'a>; 2], machine: &'a Machine) -> Corner<'a> {
        let [before, after] = sides.map(|side| side.segment);
        let (u1, u2) = (before.tangent(before.length), after.tangent(0.0));
        let change = u2 - u1;
        let override_limit = machine.interpolator.max_override;
        // What limits the velocity on a leg whatever its feedrate is: its axes and, on an arc, its acceleration.
        let requested = sides.map(|side| {
            let of_axes = limits::axis_feedrate(side.segment, machine);
            (override_limit * side.feedrate).min(of_axes).min(arc_feedrate(side.segment, 1.0, machine))
        });
        Corner {
            sides,
            machine,
            directions: [u1, u2],
            change,
            half_sine: 0.5 * change.norm(),
            half_cosine: 0.5 * (u1 + u2).norm(),
            slower: requested[0].min(requested[1]),
            faster: sides[0].feedrate.max(sides[1].feedrate),
        }
    }

    fn arc(&self, side: usize) -> Option<&Arc> {
        match &self.sides[side].segment.curve {
            Curve::Line => None,
            Curve::Arc(arc) => Some(arc),
        }
    }

    /// Returns φ/2, rad.
    fn half_angle(&self) -> f64 {
        self.half_sine.atan2(self.half_cosine)
    }

    /// Returns κ: the share of an axis's acceleration used by a turn within one servo period.
    fn kink(&self) -> f64 {
        let axes = self.machine.axes.iter().enumerate();
        let share = axes.map(|(k, axis)| {
            let own = axis.acceleration.min(self.machine.path.acceleration);
            self.change[k].abs() * (self.slower / (SERVO_PERIOD_S * own) + 1.0)
        });
        let of_arc = (0..2).any(|side| self.arc(side).is_some());
        share.fold(0.0, f64::max) * if of_arc { 2.0 } else { 1.0 }
    }

    /// Returns the circle at the corner; `None` if there is none.
    fn circle(&self, tolerance: f64) -> Option<Blend> {
        let bends = [self.bend(0)?, self.bend(1)?];
        let turned: f64 = bends.iter().map(|bend| bend.turns).sum();
        let half = self.half_angle() + turned;
        let inner = std::f64::consts::FRAC_PI_2 - half;
        if inner < MIN_ANGLE_RAD {
            return None;
        }
        let lengths = self.sides.map(|side| side.segment.length);
        let tolerance = tolerance.min(MAX_PART_OF_LEG * lengths[0].min(lengths[1]));
        // 1 − cos in a form that keeps its digits for small turns.
        let widest = tolerance * half.cos() / (2.0 * (0.5 * half).sin().powi(2));
        let geometric = widest.min(bends[0].room.min(bends[1].room) / half.tan());
        let whole = junction::in_plane(self.directions, self.machine.axes.map(|axis| axis.acceleration))
            .min(self.machine.path.acceleration);
        let normal = (NORMAL_ACCELERATION_SHARE * whole).min(self.machine.path.centripetal_acceleration);
        let goal = (self.machine.interpolator.max_override * self.faster).min(self.axis_feedrate(half));
        let fastest = (normal * geometric).sqrt().min(goal);
        let triangle = (whole * geometric * half.tan()).sqrt();
        let stretched = 2.0 * triangle.min(fastest) * fastest / (whole * 2.0 * half);
        let radius = (fastest * fastest / normal).max(stretched.min(geometric));
        let legs = [bends[0].arc, bends[1].arc];
        let contact = contact(radius, 2.0 * self.half_angle(), legs, tolerance)?;
        let legs: f64 = contact.distances.iter().sum();
        Some(Blend {
            feedrate: fastest.min(self.faster),
            ends: [fastest.min(self.faster); 2],
            fastest,
            distances: contact.distances,
            shortening: if 0.0 < legs { radius * contact.turn / legs } else { 1.0 },
            acceleration: TANGENTIAL_ACCELERATION_SHARE * whole,
            taken: 0.0,
            parabola_within: None,
        })
    }

    /// Returns the largest feedrate around a circle that turns by twice `half` (rad) at which all axes stay
    /// within their limits, mm/s.
    fn axis_feedrate(&self, half: f64) -> f64 {
        let in_plane = junction::in_plane(self.directions, self.machine.axes.map(|axis| axis.velocity));
        let has_arc = (0..2).any(|side| self.arc(side).is_some());
        let sides = self.sides.map(|side| limits::axis_feedrate(side.segment, self.machine));
        if has_arc || in_plane == f64::INFINITY || sides.contains(&f64::INFINITY) {
            return in_plane;
        }
        let angle = 2.0 * half;
        // The longer side is shortened until it is perpendicular to the altitude.
        let longest = |other: f64| other / angle.min(MAX_TURN_RAD).cos();
        let (v1, v2) = (sides[0].min(longest(sides[1])), sides[1].min(longest(sides[0])));
        let [u1, u2] = self.directions;
        in_plane.max(v1 * v2 * angle.sin() / (u2 * v2 - u1 * v1).norm())
    }

    /// Returns the bend of a leg away from its tangent near the circle; `None` if the leg bends out of the
    /// plane of the corner.
    fn bend(&self, side: usize) -> Option<LegBend> {
        let length = self.sides[side].segment.length;
        let Some(arc) = self.arc(side) else {
            return Some(LegBend { room: MAX_PART_OF_LINE * length, turns: 0.0, arc: None });
        };
        let [u1, u2] = self.directions;
        let binormal = u1.cross(&u2);
        let normal = arc.e1.cross(&arc.e2);
        if MAX_PLANE_TILT_SINE * binormal.norm() * normal.norm() < binormal.cross(&normal).norm() {
            return None;
        }
        let radius = arc.mean_radius();
        let at = if side == 0 { arc.sweep } else { 0.0 };
        let from_center = arc.e1 * at.cos() + arc.e2 * at.sin();
        let is_convex = from_center.dot(&self.change) < 0.0;
        let most = MAX_PARTS_OF_ARCS[side] * arc.sweep.abs();
        let inner = std::f64::consts::FRAC_PI_2 - self.half_angle();
        let angle = most.min(if is_convex { inner } else { std::f64::consts::FRAC_PI_2 });
        let (room, turns) = match is_convex {
            true => ((0.25 * angle).sin() * radius, 0.25 * angle),
            false => (angle * radius, 0.0),
        };
        Some(LegBend { room, turns, arc: Some(ArcLeg { radius, is_convex, most: angle }) })
    }

    /// Returns half the length of the change from the direction in which the first leg brakes to that in which the
    /// second speeds up.
    fn half_sine_of_accelerations(&self) -> f64 {
        let Some(arc) = self.arc(1) else { return self.half_sine };
        let CornerSide { segment, feedrate, .. } = self.sides[1];
        let [u1, u2] = self.directions;
        let along = PARABOLA_SHARE * limits::blended_acceleration(segment, self.machine);
        let towards_center = -arc.e1 * (0.5 * feedrate).powi(2) / arc.start_radius;
        0.5 * ((along * u2 + towards_center).normalize() - u1).norm()
    }

    /// Returns the parabola of legs of these lengths, mm.
    fn parabola(&self, tolerance: f64, lengths: [f64; 2]) -> Parabola {
        let leg = |side: usize| {
            let CornerSide { segment, feedrate, whole_acceleration } = self.sides[side];
            let (acceleration, most) =
                whole_acceleration.map_or_else(|| halved(segment, self.machine), |whole| (whole, feedrate));
            let requested = feedrate.min(most);
            let length = lengths[side];
            (acceleration, requested.min((acceleration * length).sqrt()), length)
        };
        let [(a1, v1, l1), (a2, v2, l2)] = [leg(0), leg(1)];
        let lasts = (l1 / v1).min(l2 / v2).min((v1 / a1).max(v2 / a2));
        let by_tolerance = 2.0 * (a1 * tolerance / self.half_sine_of_accelerations()).sqrt();
        let reached = |a: f64, v: f64| v.min(lasts * a).min(by_tolerance);
        let reached = [reached(a1, v1), reached(a2, v2)];
        Parabola { accelerations: [a1, a2], reached, requested: v2, tolerance }
    }
}

/// A leg where a circle touches it.
struct LegBend {
    /// Length of the leg that the circle may take, mm.
    room: f64,
    /// Turn from the tangent to the chord that the circle uses, as a part of half the turn, rad.
    turns: f64,
    arc: Option<ArcLeg>,
}

/// Two legs that run at once.
struct Parabola {
    /// a1, a2, mm/s².
    accelerations: [f64; 2],
    /// b1, b2, mm/s.
    reached: [f64; 2],
    /// Largest feedrate along the second leg, mm/s.
    requested: f64,
    /// Contour tolerance, mm.
    tolerance: f64,
}

impl Parabola {
    /// Returns the speed by which a parabola is compared with a circle, mm/s.
    fn performance(&self, half_cosine: f64) -> f64 {
        0.25 * half_cosine * (self.reached[0] + self.reached[1])
    }

    fn blend(&self) -> Blend {
        let ([a1, a2], b1) = (self.accelerations, self.reached[0]);
        let lasts = b1 / a1;
        let end = (a2 * lasts).min(self.requested);
        let distances = [0.5 * b1 * lasts, 0.5 * end * (2.0 * lasts - end / a2)];
        let both = distances[0] + distances[1];
        if both == 0.0 {
            return Blend { parabola_within: Some(self.tolerance), ..Blend::none(0.0) };
        }
        let square = b1 * b1 + (end * end - b1 * b1) * distances[0] / both;
        // A second leg that comes to its feedrate while the first still brakes makes both together faster than either.
        let shortening = 0.5 * (b1 + end) * lasts / both;
        Blend {
            feedrate: square.sqrt(),
            ends: [b1, end],
            fastest: b1.max(end),
            distances,
            shortening,
            // An acceleration of 0 would leave no room for rounding.
            acceleration: (0.5 * (end * end - b1 * b1).abs() / (shortening * both))
                .max(MIN_ACCELERATION_RATIO * a1.min(a2)),
            taken: 0.0,
            parabola_within: Some(self.tolerance),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::Interpolator;
    use crate::simulation::gcode::read;
    use crate::simulation::interpreter::trace;
    use crate::simulation::toolpath::Toolpath;
    use crate::units::mm_per_min;

    fn machine() -> Machine {
        let mut machine = Machine::default();
        machine.interpolator.junction = Junction::AccelerationBlend;
        machine.axes.iter_mut().for_each(|axis| axis.acceleration = 500.0);
        machine
    }

    /// A leg of 10 mm along X and one of 12 mm that turns by so much, at 6,000 mm/min.
    fn turn(degrees: f64) -> Toolpath {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let program = format!("G1 F6000 X10\nX{:.9} Y{:.9}", 10.0 + 12.0 * cos, 12.0 * sin);
        trace(&read(program.as_bytes()), &machine())
    }

    fn blend_of(toolpath: &Toolpath, machine: &Machine, tolerance: f64, feedrate: f64) -> Blend {
        let segments = [toolpath.segments.at(0), toolpath.segments.at(1)];
        let sides =
            [0, 1].map(|at| CornerSide { segment: &segments[at], feedrate, whole_acceleration: None });
        blend(sides, machine, tolerance)
    }

    /// An arc of 100 m is as good as a line.
    #[test]
    fn between_arcs_the_circle_touches_both() {
        let machine = machine();
        let circle = |before: &str, after: &str| {
            let toolpath = trace(&read(format!("F1660\n{before}\n{after}").as_bytes()), &machine);
            let segments = [toolpath.segments.at(0), toolpath.segments.at(1)];
            let feedrate = mm_per_min(1660.0);
            let sides =
                [0, 1].map(|at| CornerSide { segment: &segments[at], feedrate, whole_acceleration: None });
            Corner::between(sides, &machine).circle(2.0).expect("there is room")
        };
        // The second leg bends to the side of the turn, and away from it.
        for after in ["G3 X0 Y0 I-20 J0", "G2 X80 Y0 I20 J0"] {
            let beside_line = circle("G1 X40", after);
            for nearly_line in ["G3 X40 R100000", "G2 X40 R100000"] {
                let between_arcs = circle(nearly_line, after);
                let both = [between_arcs, beside_line]
                    .map(|blend| [blend.feedrate, blend.distances[0], blend.distances[1], blend.shortening]);
                for (one, other) in both[0].iter().zip(both[1]) {
                    assert!((one / other - 1.0).abs() < 2e-3, "{nearly_line} {after}: {both:?}");
                }
            }
        }
    }

    /// Feedrates that LinuxCNC 2.9 was recorded at on its circles.
    #[test]
    fn circles_are_as_fast_as_recorded() {
        for (degrees, recorded) in [(90.0, 274.3), (135.0, 139.0)] {
            let found = blend_of(&turn(degrees), &machine(), 0.02, 100.0);
            assert!((mm_per_min(found.feedrate) - recorded).abs() < 0.1, "{degrees}°: {found:?}");
        }
    }

    #[test]
    fn turning_and_ramp_together_keep_the_acceleration_within_the_tolerance() {
        for degrees in [1.0f64, 20.0, 90.0, 150.0] {
            for tolerance in [1e-4, 0.02, 5.0] {
                for feedrate in [1.0, 20.0, 400.0] {
                    let found = blend_of(&turn(degrees), &machine(), tolerance, feedrate);
                    let [before, after] = found.distances;
                    if found.is_parabola() || before == 0.0 {
                        continue;
                    }
                    let half = 0.5 * degrees.to_radians();
                    let radius = before / half.tan();
                    let normal = found.feedrate * found.feedrate / radius;
                    assert!(
                        normal.hypot(found.acceleration) <= 500.0 * (1.0 + 1e-9),
                        "{degrees}°: {found:?}"
                    );
                    assert!((before - after).abs() < 1e-12 && before <= 5.0 + 1e-9);
                    assert!(
                        radius * (1.0 / half.cos() - 1.0) <= tolerance * (1.0 + 1e-6),
                        "{degrees}°: {found:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn a_slow_program_has_wider_circles_where_overrides_are_planned_for() {
        let mut machine = machine();
        let usual = blend_of(&turn(90.0), &machine, 5.0, 10.0);
        machine.interpolator.max_override = 2.0;
        let wider = blend_of(&turn(90.0), &machine, 5.0, 10.0);
        assert_eq!(usual.feedrate, wider.feedrate);
        assert!((wider.distances[0] / usual.distances[0] - 4.0).abs() < 1e-9, "{usual:?}, {wider:?}");
    }

    #[test]
    fn what_has_no_circle_is_a_parabola_that_shares_the_acceleration() {
        // A plunge and the arc behind it lie in no plane.
        let toolpath = trace(&read(b"G1 F1200 Z-10\nG3 X20 Y0 I10 J0"), &machine());
        let found = blend_of(&toolpath, &machine(), 0.1, 20.0);
        let (time, share) = (found.ends[0] / 250.0, found.distances[0]);
        assert!(found.is_parabola(), "{found:?}");
        assert!((share - 0.5 * found.ends[0] * time).abs() < 1e-12, "{found:?}");
        let both: f64 = found.distances.iter().sum();
        assert!((both - 0.5 * (found.ends[0] + found.ends[1]) * time).abs() < 1e-9, "{found:?}");
    }

    #[test]
    fn opposite_legs_end_in_a_stop_with_all_of_their_acceleration() {
        for (degrees, stops) in [(180.0, true), (178.0, true), (176.5, false), (150.0, false)] {
            let found = blend_of(&turn(degrees), &machine(), 0.02, 100.0);
            assert_eq!(found.feedrate == 0.0 && found.taken == 0.0, stops, "{degrees}°: {found:?}");
        }
    }

    /// At 10 mm/s a turn within one period takes 21 φ of 500 mm/s²: a tenth of it at 0.27°.
    #[test]
    fn exact_path_stops_where_the_acceleration_does_not_allow_the_corner() {
        let turned = |word: &str, degrees: f64| {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let program = format!("{word}\nG1 F600 X10\nX{:.9} Y{:.9}", 10.0 + 12.0 * cos, 12.0 * sin);
            trace(&read(program.as_bytes()), &machine())
        };
        let exact = Machine {
            interpolator: Interpolator { junction: Junction::ExactPath, ..machine().interpolator },
            ..machine()
        };
        for (toolpath, machine) in [("G61", machine()), ("G64", exact)]
            .map(|(word, machine)| ([turned(word, 0.2), turned(word, 1.0)], machine))
        {
            let [passed, stopped] = toolpath.map(|toolpath| blend_of(&toolpath, &machine, 0.02, 10.0));
            let taken = 21.0 * 0.2f64.to_radians();
            assert!(passed.feedrate == f64::INFINITY && (passed.taken - taken).abs() < 1e-4, "{passed:?}");
            assert_eq!((stopped.feedrate, stopped.taken), (0.0, 0.1));
        }
        assert!(0.0 < blend_of(&turned("G64", 1.0), &machine(), 0.02, 10.0).feedrate);
    }

    #[test]
    fn without_arc_blends_every_corner_is_a_parabola() {
        let mut machine = machine();
        machine.interpolator.junction = Junction::ParabolicBlend;
        let found = blend_of(&turn(90.0), &machine, 0.02, 100.0);
        let expected = 2.0 * (250.0 * 0.02 / std::f64::consts::FRAC_1_SQRT_2).sqrt();
        assert!(found.is_parabola() && (found.ends[0] - expected).abs() < 1e-9, "{found:?}");
    }
}
