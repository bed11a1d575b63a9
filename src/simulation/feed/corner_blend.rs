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
//! **Parabola**: see `parabola`.
//!
//! **Stop**: between legs that are opposite to within about 2.8°, 1 + cos φ < (2°)², the motion stops; the
//! legs keep their whole acceleration.
//!
//! **Nothing**: a turn made within one servo period uses the part κ = max_k |u2 − u1|_k (sF/(h a_k) + 1) of
//! the acceleration of an axis, twice that on an arc, whose sF is at most the velocity for which √3/2 of its
//! acceleration suffices. If κ is below a tenth, the corner is not slowed at all, and its legs lose the part κ
//! of their acceleration, an arc also for its curvature. Otherwise the motion passes the corner at 0.1 sF/κ. Of
//! circle, parabola and nothing the fastest is taken.
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
//! (blendmath.c: blendComputeParameters, blendParamKinematics; tp.c: tpSetupTangent, tpChooseBestBlend; tc.c:
//! tcFinalizeLength), and recordings of it.

use crate::machine::{Junction, Machine};
use crate::simulation::feed::blend::Blend;
use crate::simulation::feed::circle_contact::{ArcLeg, contact};
use crate::simulation::feed::junction;
use crate::simulation::feed::limits::{self, NORMAL_ACCELERATION_SHARE, TANGENTIAL_ACCELERATION_SHARE};
use crate::simulation::feed::parabola::{self, CornerSide, LINUXCNC_SERVO_PERIOD_S};
use crate::simulation::toolpath::{Arc, Curve, Segment, Vector};

/// Largest distance between circle and corner, as a part of the shorter leg.
const MAX_PART_OF_LEG: f64 = 0.25;
/// Part of a line that a circle may take.
const MAX_PART_OF_LINE: f64 = 0.5;
const MAX_PARTS_OF_ARCS: [f64; 2] = [2.0 / 3.0, 1.0 / 3.0];
/// Share of the acceleration that a turn without a circle may use.
const KINK_SHARE: f64 = 0.1;
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
/// Returns the blend at the corner between two segments with this tolerance (mm).
pub fn blend(sides: [CornerSide; 2], machine: &Machine, tolerance: f64) -> Blend {
    let corner = Corner::between(sides, machine);
    let parabola = || parabola::blend(sides, machine, tolerance, sides.map(|side| side.segment.length), 0.0);
    let is_exact = machine.interpolator.junction == Junction::ExactPath || sides[0].segment.exact_path;
    if machine.interpolator.junction == Junction::ParabolicBlend {
        // Without arc blends LinuxCNC looks for no tangents, which alone take a share of the acceleration.
        return if is_exact { Blend::none(0.0) } else { parabola() };
    }
    if 2.0 * corner.half_cosine.powi(2) < MAX_OPPOSITE_ONE_PLUS_COSINE {
        return Blend::none(0.0);
    }
    let kink = corner.kink();
    if kink < KINK_SHARE {
        return Blend { taken: kink, ..Blend::none(f64::INFINITY) };
    }
    if is_exact {
        return Blend { taken: KINK_SHARE, ..Blend::none(0.0) };
    }
    let by_kink = corner.slower() * KINK_SHARE / kink;
    let circle = corner.circle(tolerance);
    let by_circle = circle.map_or(0.0, |circle| circle.fastest);
    let [b1, b2] = parabola::reached_at_override(sides, machine, tolerance, corner.overridden);
    let by_parabola = 0.25 * corner.half_cosine * (b1 + b2);
    match circle {
        Some(circle) if by_kink <= by_circle && by_parabola <= by_circle => circle,
        _ if by_parabola < by_kink => Blend { taken: KINK_SHARE, ..Blend::none(by_kink) },
        _ => parabola(),
    }
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
    /// Largest feedrates of both legs under the largest override, mm/s.
    overridden: [f64; 2],
    /// Faster of the requested feedrates of both legs, mm/s.
    faster: f64,
}

impl<'a> Corner<'a> {
    fn between(sides: [CornerSide<'a>; 2], machine: &'a Machine) -> Corner<'a> {
        let [before, after] = sides.map(|side| side.segment);
        let (u1, u2) = (before.tangent(before.length), after.tangent(0.0));
        let change = u2 - u1;
        let override_limit = machine.interpolator.max_override;
        // What limits the velocity on a leg whatever its feedrate is: its axes and, on an arc, its acceleration.
        let overridden = sides.map(|side| {
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
            overridden,
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

    /// Returns the lower of the largest feedrates of both legs, mm/s.
    fn slower(&self) -> f64 {
        self.overridden[0].min(self.overridden[1])
    }

    /// Returns κ: the share of an axis's acceleration used by a turn within one servo period.
    fn kink(&self) -> f64 {
        let axes = self.machine.axes.iter().enumerate();
        let share = axes.map(|(k, axis)| {
            let own = axis.acceleration.min(self.machine.path.acceleration);
            self.change[k].abs() * (self.slower() / (LINUXCNC_SERVO_PERIOD_S * own) + 1.0)
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
            parabola: None,
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
}

/// A leg where a circle touches it.
struct LegBend {
    /// Length of the leg that the circle may take, mm.
    room: f64,
    /// Turn from the tangent to the chord that the circle uses, as a part of half the turn, rad.
    turns: f64,
    arc: Option<ArcLeg>,
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
        assert!((found.distances[1] - 0.5 * found.ends[1] * time).abs() < 1e-9, "{found:?}");
        let both: f64 = found.distances.iter().sum();
        let mean = 0.5 * (found.ends[0] + found.ends[1]);
        assert!((found.shortening * both - mean * time).abs() < 1e-9, "{found:?}");
    }

    /// A corner of a rounded end mill path in a recording of LinuxCNC 2.9, off the tangent by a rounded last digit.
    #[test]
    fn a_parabola_is_compared_at_the_feedrates_under_the_largest_override() {
        let mut machine = machine();
        machine.axes.iter_mut().for_each(|axis| axis.acceleration = 560.0);
        let program = "G20 G1 X-1.2318 Y0.2384 F36.22\nG2 X-1.2013 Y0.269 I0.0306 J0\nG1 X1.2013";
        let toolpath = trace(&read(program.as_bytes()), &machine);
        let segments = [toolpath.segments.at(1), toolpath.segments.at(2)];
        let feedrate = 36.22 * 25.4 / 60.0;
        let sides =
            [0, 1].map(|at| CornerSide { segment: &segments[at], feedrate, whole_acceleration: None });
        for (max_override, is_parabola) in [(1.0, false), (2.0, true)] {
            machine.interpolator.max_override = max_override;
            let found = blend(sides, &machine, 0.0071);
            assert_eq!(found.is_parabola(), is_parabola, "{max_override}: {found:?}");
        }
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

    #[test]
    fn without_arc_blends_exact_path_stops_with_the_whole_acceleration() {
        let mut machine = machine();
        machine.interpolator.junction = Junction::ParabolicBlend;
        let exact = trace(&read(b"G61\nG1 F600 X10\nY10"), &machine);
        assert_eq!(blend_of(&exact, &machine, 0.02, 10.0), Blend::none(0.0));
    }
}
