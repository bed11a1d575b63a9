//! How fast a control with a law of junctions takes a corner, beside what the tolerance allows.
//!
//! Legs with unit directions u1, u2 meet at a corner and turn by φ; D = ‖u2 − u1‖ = 2 sin(φ/2),
//! C = ½‖u2 + u1‖ = cos(φ/2). The command at the corner is at most
//!
//! ```text
//! acceleration blend    √(aₙ R),  R = min(ε C/(1 − C), ½ L C / sin(φ/2)),  aₙ = √3/2 a
//! junction deviation    √(b δ C/(1 − C)),  b = min_k a_k / |d_k|,  d = (u2 − u1)/D
//! square-corner velocity   √min_l( V² (√2 − 1) (a_l/A) C/(1 − C),  ½ L_l a_l C / sin(φ/2) )
//! axis velocity step    V / max_k |u2 − u1|_k
//! ```
//!
//! Junction deviation takes the acceleration b along the bisector, the direction d in which the velocity changes, with each
//! axis at its own limit a_k: where X and Y may have a, it is √2 a at a right angle between them. The square-corner
//! velocity V (mm/s) is that at 90° whatever the acceleration A along the path is; a_l ≤ A is that of either leg l, and
//! the second term is a circle that touches the leg no further away than at its middle, L_l/2.
//!
//! Beside any of them corners may be slowed by their turn, down to an exact stop from the turn φ₀ on:
//!
//! ```text
//! F (1 − (max_k |u2 − u1|_k / φ₀)⁴)
//! ```
//!
//! An acceleration blend is a circle of radius R that touches both legs: it passes the corner at
//! ε (1/C − 1 = ε/R), and takes no more than half of the shorter leg, L. The acceleration a is the
//! largest vector that keeps every axis within its own limit, whatever its direction in the plane of
//! the corner, and within that of the path. √3/2 of it turn the motion and ½ is left along the path,
//! so that both together are a. The same holds for programmed arcs, whose ramps have
//! A √(1 − min(V²/(r A), √3/2)²), V the fastest that their axes allow. How a leg is run between its
//! circles is in the module of blends. Around the circle no axis is above its velocity limit; between
//! lines the larger of two bounds holds, of which the other is the altitude of the triangle whose sides
//! are the fastest velocities V1, V2 along both:
//!
//! ```text
//! V1 V2 sin φ / ‖V2 u2 − V1 u1‖
//! ```
//!
//! A turn so small that it takes less than a tenth of the acceleration when made within one servo
//! period h, κ = max_k |u2 − u1|_k (F/(h a_k) + 1) < 0.1, has no circle; its legs lose the part κ of
//! their acceleration. F is the slower of both feedrates, and κ counts double on an arc, of whose
//! acceleration ½ is left. Nor has a turn a circle that is faster without one, at 0.1 F/κ. Legs that
//! double back have a stop.
//!
//! Limits: the legs of an arc are its tangents; h is 1 ms; what slows a corner by its turn is read off helices and half
//! circles of short lines on a recorded mill at two feedrates, and not derived. Source: the laws of LinuxCNC (src/emc/tp,
//! blendmath.c and tp.c: ratios of acceleration, altitude, tangent kink), grbl, Klipper and Marlin, derived
//! from the geometry, and recordings of LinuxCNC 2.9.

use crate::machine::{Junction, Machine};
use crate::simulation::feed::blend::Blend;
use crate::simulation::feed::limits;
use crate::simulation::toolpath::{Curve, Segment, Vector};

/// Share of the acceleration that may turn the motion while a share of ½ remains along the path.
const NORMAL: f64 = 0.866_025_403_784_438_6;

/// Share of the acceleration that a turn without a circle may take.
const KINK: f64 = 0.1;

/// Time in which such a turn is made, s.
const SERVO_PERIOD: f64 = 1e-3;

/// The largest turn whose cosine cuts a velocity, rad.
const STEEPEST: f64 = 0.49 * std::f64::consts::PI;

/// ‖u1 + u2‖ below which legs double back, and the motion stops: the sine of 2°.
const REVERSAL: f64 = 0.034_9;

/// A corner as the law of junctions sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turn {
    before: Vector,
    after: Vector,
    /// D, twice the sine of half the turn.
    change: f64,
    /// C, the cosine of half the turn.
    half_cosine: f64,
    /// Lengths of both legs, mm.
    lengths: [f64; 2],
    /// Whether a leg is an arc.
    of_arc: bool,
}

impl Turn {
    /// The corner between two segments.
    pub fn between(before: &Segment, after: &Segment) -> Turn {
        let (u1, u2) = (before.tangent(before.length), after.tangent(0.0));
        Turn {
            before: u1,
            after: u2,
            change: (u2 - u1).norm(),
            half_cosine: 0.5 * (u2 + u1).norm(),
            lengths: [before.length, after.length],
            of_arc: [before, after].iter().any(|leg| matches!(leg.curve, Curve::Arc(_))),
        }
    }

    /// C/(1 − C): radius of the circle that passes the corner at 1 mm. 1 − C is taken from the sine
    /// of half the turn, which keeps its digits where the turn is small.
    fn radius_of_deviation(&self) -> f64 {
        let half_sine = 0.5 * self.change;
        self.half_cosine * (1.0 + self.half_cosine) / (half_sine * half_sine)
    }

    /// Radius of the blend, mm.
    fn blend_radius(&self, tolerance: f64) -> f64 {
        let by_length = self.lengths[0].min(self.lengths[1]) * self.half_cosine / self.change;
        (tolerance * self.radius_of_deviation()).min(by_length)
    }

    /// How far before the corner the blend begins, mm.
    fn blend_distance(&self, tolerance: f64) -> f64 {
        if self.half_cosine == 0.0 {
            return 0.0;
        }
        self.blend_radius(tolerance) * 0.5 * self.change / self.half_cosine
    }

    /// The circle in place of the corner between legs of which the slower runs at `feedrate`, mm/s.
    pub fn blend(&self, machine: &Machine, tolerance: f64, feedrate: f64) -> Blend {
        let kink = self.kink(machine, feedrate);
        if kink < KINK {
            return Blend { taken: kink, ..Blend::none(f64::INFINITY) };
        }
        if self.half_cosine < 0.5 * REVERSAL {
            return Blend::none(0.0);
        }
        let by_circle = self.circle_feedrate(machine, tolerance).min(self.axis_feedrate(machine));
        let by_kink = feedrate * KINK / kink;
        if by_circle <= by_kink {
            return Blend { taken: KINK, ..Blend::none(by_kink) };
        }
        let half = self.half_angle();
        Blend {
            feedrate: by_circle,
            fastest: by_circle,
            distance: self.blend_distance(tolerance),
            shortening: half / half.tan(),
            acceleration: 0.5 * self.acceleration(machine),
            taken: 0.0,
        }
    }

    /// The fastest command along the blend, mm/s.
    fn circle_feedrate(&self, machine: &Machine, tolerance: f64) -> f64 {
        let acceleration = (NORMAL * self.acceleration(machine)).min(machine.path.centripetal_acceleration);
        (acceleration * self.blend_radius(tolerance)).sqrt()
    }

    /// φ/2, rad.
    fn half_angle(&self) -> f64 {
        (0.5 * self.change).atan2(self.half_cosine)
    }

    /// The acceleration of the axis that a turn within one servo period takes most of, as a share of
    /// its limit; of the half that is left along it for an arc.
    fn kink(&self, machine: &Machine, feedrate: f64) -> f64 {
        let change = self.after - self.before;
        let axes = machine.axes.iter().enumerate();
        let share = axes.map(|(k, axis)| {
            let own = axis.acceleration.min(machine.path.acceleration);
            change[k].abs() * (feedrate / (SERVO_PERIOD * own) + 1.0)
        });
        share.fold(0.0, f64::max) * if self.of_arc { 2.0 } else { 1.0 }
    }

    /// The feedrate around the corner at which no axis is above its velocity limit, mm/s: that which is
    /// kept whatever its direction in the plane of the corner, or, between lines, the altitude of the
    /// triangle whose sides are the fastest velocities along them. The longer side is cut to where the
    /// altitude is the shorter one.
    fn axis_feedrate(&self, machine: &Machine) -> f64 {
        let in_plane = self.in_plane(machine.axes.map(|axis| axis.velocity));
        let fastest = |along: &Vector| {
            let limits = machine.axes.iter().zip(along.iter());
            limits.map(|(axis, share)| axis.velocity / share.abs()).fold(f64::INFINITY, f64::min)
        };
        let sides = [fastest(&self.before), fastest(&self.after)];
        if self.of_arc || in_plane == f64::INFINITY || sides.contains(&f64::INFINITY) {
            return in_plane;
        }
        let angle = 2.0 * self.half_angle();
        let longest = |other: f64| other / angle.min(STEEPEST).cos();
        let (v1, v2) = (sides[0].min(longest(sides[1])), sides[1].min(longest(sides[0])));
        in_plane.max(v1 * v2 * angle.sin() / (self.after * v2 - self.before * v1).norm())
    }

    /// Largest acceleration in any direction of the plane of the corner, mm/s².
    fn acceleration(&self, machine: &Machine) -> f64 {
        self.in_plane(machine.axes.map(|axis| axis.acceleration)).min(machine.path.acceleration)
    }

    /// Acceleration in the direction in which the velocity changes, mm/s², with each axis at its own limit.
    fn acceleration_along_change(&self, machine: &Machine) -> f64 {
        let along = (self.after - self.before) / self.change;
        let axes = machine.axes.iter().zip(along.iter());
        axes.map(|(axis, share)| axis.acceleration / share.abs()).fold(machine.path.acceleration, f64::min)
    }

    /// The square of the fastest command at the corner by the velocity at 90°, mm²/s², for one leg of `length` (mm) and
    /// `acceleration` (mm/s²).
    fn square_by_leg(&self, velocity: f64, machine: &Machine, length: f64, acceleration: f64) -> f64 {
        let whole = machine.path.acceleration;
        let share = if whole.is_finite() { acceleration / whole } else { 1.0 };
        let by_deviation =
            velocity * velocity * (std::f64::consts::SQRT_2 - 1.0) * share * self.radius_of_deviation();
        by_deviation.min(length * acceleration * self.half_cosine / self.change)
    }

    /// The length of the longest vector in any direction of the plane of the corner whose components
    /// are all within `limits`.
    fn in_plane(&self, limits: [f64; 3]) -> f64 {
        let change = self.after - self.before;
        let sum = self.after + self.before;
        let (across, along) = (direction(change), direction(sum));
        let axes = limits.iter().enumerate();
        axes.map(|(k, limit)| limit / across[k].hypot(along[k])).fold(f64::INFINITY, f64::min)
    }

    /// The fastest command at the corner of legs with these accelerations (mm/s²), mm/s; infinite where the law does not
    /// bind.
    pub fn feedrate(&self, machine: &Machine, tolerance: f64, accelerations: [f64; 2]) -> f64 {
        if self.change == 0.0 {
            return f64::INFINITY;
        }
        match machine.interpolator.junction {
            Junction::Tolerance => f64::INFINITY,
            Junction::AccelerationBlend => self.circle_feedrate(machine, tolerance),
            Junction::Deviation(deviation) => {
                (self.acceleration_along_change(machine) * deviation * self.radius_of_deviation()).sqrt()
            }
            Junction::SquareCorner(velocity) => {
                let of =
                    |leg: usize| self.square_by_leg(velocity, machine, self.lengths[leg], accelerations[leg]);
                of(0).min(of(1)).sqrt()
            }
            Junction::AxisStep(velocity) => velocity / (self.after - self.before).amax(),
        }
    }
}

/// Whether the motion stands where a rapid and a feed move meet: LinuxCNC blends none with the other (tp.c,
/// `handleModeChange`).
pub fn stops_at_rapids(machine: &Machine) -> bool {
    machine.interpolator.junction == Junction::AccelerationBlend
}

/// The fastest command at a corner where the direction changes by `change`, of legs of which the slower runs at
/// `feedrate`, that is slowed by its turn alone, mm/s; infinite where none is.
pub fn slowed(change: &Vector, feedrate: f64, machine: &Machine) -> f64 {
    let stopping = machine.interpolator.slowing_angle;
    if stopping == f64::INFINITY {
        return f64::INFINITY;
    }
    feedrate * (1.0 - (change.amax() / stopping).powi(4)).max(0.0)
}

/// The unit vector along `vector`; zero where that has no direction.
fn direction(vector: Vector) -> Vector {
    let length = vector.norm();
    if length == 0.0 { vector } else { vector / length }
}

/// The acceleration along a segment between its corners, mm/s²: what an arc leaves at the fastest that
/// its axes allow.
pub fn acceleration(segment: &Segment, own: f64, machine: &Machine) -> f64 {
    let Curve::Arc(arc) = &segment.curve else { return own };
    let curvature = arc.mean_radius() * (arc.sweep / segment.length).powi(2);
    let fastest = limits::axis_feedrate(segment, machine);
    let normal = (fastest * fastest * curvature / own).min(NORMAL);
    own * (1.0 - normal * normal).sqrt()
}

/// The feedrate along an arc that leaves half the acceleration for ramps, mm/s; infinite along a
/// line, and under another law.
pub fn arc_feedrate(segment: &Segment, acceleration: f64, machine: &Machine) -> f64 {
    match (&segment.curve, machine.interpolator.junction) {
        (Curve::Arc(arc), Junction::AccelerationBlend) => {
            let curvature = arc.mean_radius() * (arc.sweep / segment.length).powi(2);
            (NORMAL * acceleration / curvature).sqrt()
        }
        _ => f64::INFINITY,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::mm_per_min;

    fn turn(angle: f64) -> Turn {
        let (before, after) = (Vector::x(), Vector::new(angle.cos(), angle.sin(), 0.0));
        Turn {
            before,
            after,
            change: (after - before).norm(),
            half_cosine: 0.5 * (after + before).norm(),
            lengths: [10.0, 12.0],
            of_arc: false,
        }
    }

    fn machine(junction: Junction) -> Machine {
        let mut machine = Machine::default();
        machine.interpolator.junction = junction;
        machine.axes.iter_mut().for_each(|axis| axis.acceleration = 500.0);
        machine
    }

    #[test]
    fn laws_at_a_right_angle_are_their_closed_forms() {
        let corner = turn(std::f64::consts::FRAC_PI_2);
        let radius = 1.0 / (std::f64::consts::SQRT_2 - 1.0);
        let expected = [
            (Junction::AccelerationBlend, (NORMAL * 500.0 * 0.02 * radius).sqrt()),
            (Junction::Deviation(0.03), (std::f64::consts::SQRT_2 * 500.0 * 0.03 * radius).sqrt()),
            (Junction::SquareCorner(5.0), 5.0),
            (Junction::AxisStep(7.0), 7.0),
            (Junction::Tolerance, f64::INFINITY),
        ];
        for (junction, feedrate) in expected {
            let found = corner.feedrate(&machine(junction), 0.02, [500.0; 2]);
            assert!(found == feedrate || (found / feedrate - 1.0).abs() < 1e-12, "{junction:?}: {found}");
        }
    }

    /// What grbl 1.1 was recorded at: 248 mm/min where X and Y of 500 mm/s² meet at a right angle.
    #[test]
    fn junction_deviation_takes_the_acceleration_along_the_bisector() {
        let corner = turn(std::f64::consts::FRAC_PI_2);
        let mut machine = machine(Junction::Deviation(0.010));
        let found = mm_per_min(corner.feedrate(&machine, 0.02, [500.0; 2]));
        assert!((found - 247.9).abs() < 0.1, "{found} mm/min");
        machine.axes[0].acceleration = 200.0;
        let slower = mm_per_min(corner.feedrate(&machine, 0.02, [500.0; 2]));
        assert!((slower / found - 0.4f64.sqrt()).abs() < 1e-12, "{slower} mm/min");
    }

    #[test]
    fn short_legs_and_slow_ones_limit_a_square_corner() {
        let mut corner = turn(std::f64::consts::FRAC_PI_2);
        let mut machine = machine(Junction::SquareCorner(5.0));
        machine.path.acceleration = 500.0;
        let feedrate = |corner: &Turn, accelerations| corner.feedrate(&machine, 0.02, accelerations);
        assert!((feedrate(&corner, [500.0, 125.0]) - 2.5).abs() < 1e-12);
        // The circle that touches both legs at their middles has the radius of half a leg.
        corner.lengths = [0.04, 3.0];
        assert!((feedrate(&corner, [500.0; 2]) - (0.02f64 * 500.0).sqrt()).abs() < 1e-12);
    }

    #[test]
    fn corners_are_slowed_by_the_largest_step_of_an_axis() {
        let corner = turn(std::f64::consts::FRAC_PI_6);
        let change = corner.after - corner.before;
        let mut machine = Machine::default();
        assert_eq!(slowed(&change, 40.0, &machine), f64::INFINITY);
        machine.interpolator.slowing_angle = 1.0;
        // sin 30° is more than 1 − cos 30°.
        assert!((slowed(&change, 40.0, &machine) - 40.0 * (1.0 - 0.5f64.powi(4))).abs() < 1e-12);
        machine.interpolator.slowing_angle = 0.4;
        assert_eq!(slowed(&change, 40.0, &machine), 0.0);
    }

    /// Feedrates that LinuxCNC 2.9 was recorded at on its circles.
    #[test]
    fn blends_are_as_fast_as_recorded() {
        let machine = machine(Junction::AccelerationBlend);
        for (degrees, recorded) in [(90.0f64, 274.3), (135.0, 139.0)] {
            let found = mm_per_min(turn(degrees.to_radians()).circle_feedrate(&machine, 0.02));
            assert!((found - recorded).abs() < 0.1, "{degrees}°: {found} mm/min");
        }
    }

    #[test]
    fn turning_and_ramp_together_keep_the_acceleration() {
        for degrees in [0.1f64, 1.0, 20.0, 90.0, 150.0, 179.0] {
            let (corner, machine) = (turn(degrees.to_radians()), machine(Junction::AccelerationBlend));
            for tolerance in [1e-4, 0.02, 5.0] {
                let normal =
                    corner.circle_feedrate(&machine, tolerance).powi(2) / corner.blend_radius(tolerance);
                assert!(normal.hypot(0.5 * corner.acceleration(&machine)) <= 500.0 * (1.0 + 1e-12));
                assert!(corner.blend_distance(tolerance) <= 0.5 * 10.0 * (1.0 + 1e-12));
            }
        }
    }
}
