//! Junction laws: the largest command at a corner in addition to the limit of the tolerance.
//!
//! Legs with unit directions u1, u2 meet at a corner and turn by φ; D = ‖u2 − u1‖ = 2 sin(φ/2),
//! C = ½‖u2 + u1‖ = cos(φ/2). The command at the corner is at most
//!
//! ```text
//! junction deviation    √(b δ C/(1 − C)),  b = min_k a_k / |d_k|,  d = (u2 − u1)/D
//! square-corner velocity   √min_l( V² (√2 − 1) (a_l/A) C/(1 − C),  ½ L_l a_l C / sin(φ/2) )
//! axis velocity step    V / max_k |u2 − u1|_k
//! short blocks          √(b L2 / φ) in addition to the junction deviation, b ≤ a_2, if L2 < 1 mm and φ < 45°
//! ```
//!
//! A rest is a corner with u = 0 on one side to the axis velocity step of a planner without filters: motions begin and end
//! at V / max_k |u|_k. All other laws begin and end at 0.
//!
//! For the junction deviation δ, b is the acceleration along the bisector, which is the direction d in which
//! the velocity changes, with each axis at its own limit a_k: if X and Y have the limit a, b is √2 a at a
//! right angle between them. The square-corner velocity V (mm/s) is the command at 90°, whatever the
//! acceleration A along the path; a_l ≤ A is the acceleration of leg l, and the second term is a circle that
//! touches leg l no farther from the corner than at its middle, L_l/2. The blend of LinuxCNC at a corner is
//! in `corner_blend`.
//!
//! In addition to each of these laws a corner can be slowed by its turn, with an exact stop from the turn φ₀
//! on. The command of the slower leg, F, is lowered to
//!
//! ```text
//! F (1 − (max_k |u2 − u1|_k / φ₀)⁴)
//! ```
//!
//! Programmed arcs share the acceleration a between turn and ramps as blends do: √3/2 of it may turn the
//! motion, and ramps have a √(1 − min(V²/(r a), √3/2)²), where V is the largest feedrate that the axes allow
//! and r the radius.
//!
//! Limits: the slowing by the turn is not derived but read from recordings of one mill that ran helices and
//! half circles of short lines at two feedrates. Source: the laws of grbl, Klipper, Marlin and of LinuxCNC's
//! arcs, derived from the geometry.

use crate::machine::{Junction, Machine};
use crate::simulation::feed::{limits, positioning};
use crate::simulation::toolpath::{Curve, Segment, Vector};

/// Length from which on a block is no chord of an arc, mm (Marlin).
const LONGEST_CHORD_MM: f64 = 1.0;
/// Turn from which on a corner is no joint of chords, rad (Marlin).
const LARGEST_TURN_OF_CHORDS_RAD: f64 = std::f64::consts::FRAC_PI_4;

/// The geometry of a corner on which junction laws depend.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CornerTurn {
    before: Vector,
    after: Vector,
    /// D, twice the sine of half the turn.
    change: f64,
    /// C, the cosine of half the turn.
    half_cosine: f64,
    /// Lengths of both legs, mm.
    lengths: [f64; 2],
}

impl CornerTurn {
    /// Returns the corner between two segments.
    pub fn between(before: &Segment, after: &Segment) -> CornerTurn {
        let (u1, u2) = (before.tangent(before.length), after.tangent(0.0));
        CornerTurn {
            before: u1,
            after: u2,
            change: (u2 - u1).norm(),
            half_cosine: 0.5 * (u2 + u1).norm(),
            lengths: [before.length, after.length],
        }
    }

    /// Returns C/(1 − C): the radius (mm) of the circle that touches both legs and passes the corner at 1 mm.
    /// The value 1 − C is computed from the sine of half the turn, which is accurate for small turns.
    fn radius_of_deviation(&self) -> f64 {
        let half_sine = 0.5 * self.change;
        self.half_cosine * (1.0 + self.half_cosine) / (half_sine * half_sine)
    }

    /// Returns the radius of the arc whose chord the second leg is, mm; infinite if the leg is long or the turn large.
    fn radius_of_chord(&self) -> f64 {
        let (turn, length) = (2.0 * (0.5 * self.change).min(1.0).asin(), self.lengths[1]);
        if length < LONGEST_CHORD_MM && turn < LARGEST_TURN_OF_CHORDS_RAD {
            length / turn
        } else {
            f64::INFINITY
        }
    }

    /// Returns the acceleration in the direction in which the velocity changes, mm/s², with each axis at its
    /// limit.
    fn acceleration_along_change(&self, machine: &Machine) -> f64 {
        let along = (self.after - self.before) / self.change;
        let axes = machine.axes.iter().zip(along.iter());
        axes.map(|(axis, share)| axis.acceleration / share.abs()).fold(machine.path.acceleration, f64::min)
    }

    /// Returns the square of the largest command at the corner for the square-corner velocity `velocity`
    /// (mm/s) and one leg of `length` (mm) and `acceleration` (mm/s²), mm²/s².
    fn square_by_leg(&self, velocity: f64, machine: &Machine, length: f64, acceleration: f64) -> f64 {
        let whole = machine.path.acceleration;
        let share = if whole.is_finite() { acceleration / whole } else { 1.0 };
        let by_deviation =
            velocity * velocity * (std::f64::consts::SQRT_2 - 1.0) * share * self.radius_of_deviation();
        by_deviation.min(length * acceleration * self.half_cosine / self.change)
    }

    /// Returns the largest command at the corner of legs with these accelerations (mm/s²), mm/s; infinite if
    /// the law sets no limit.
    pub fn feedrate(&self, machine: &Machine, accelerations: [f64; 2]) -> f64 {
        if self.change == 0.0 {
            return f64::INFINITY;
        }
        match machine.interpolator.junction {
            Junction::Tolerance
            | Junction::AccelerationBlend
            | Junction::ParabolicBlend
            | Junction::ExactPath => f64::INFINITY,
            Junction::Deviation(deviation) => {
                let along_change = self.acceleration_along_change(machine);
                if machine.interpolator.short_blocks_are_chords {
                    let radius = (deviation * self.radius_of_deviation()).min(self.radius_of_chord());
                    return (along_change.min(accelerations[1]) * radius).sqrt();
                }
                (along_change * deviation * self.radius_of_deviation()).sqrt()
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

/// Returns the step of velocity of any axis with which motions begin and end at a rest, mm/s; `None` if they
/// begin and end at 0.
pub fn step_at_rest(machine: &Machine) -> Option<f64> {
    match machine.interpolator.junction {
        Junction::AxisStep(velocity) if !machine.has_filters() => Some(velocity),
        _ => None,
    }
}

/// Returns `true` if the machine stops where a rapid and a feed move meet: LinuxCNC does not blend them
/// (tp.c, `handleModeChange`).
pub fn stops_at_rapids(machine: &Machine) -> bool {
    machine.interpolator.junction.blends_in_time()
}

/// Returns the largest command at a corner that is slowed by its turn alone, mm/s; infinite if turns do not
/// slow corners. `change` is u2 − u1, and `feedrate` (mm/s) the feedrate of the slower leg.
pub fn slowed(change: &Vector, feedrate: f64, machine: &Machine) -> f64 {
    let stopping = machine.interpolator.slowing_angle;
    if stopping == f64::INFINITY {
        return f64::INFINITY;
    }
    feedrate * (1.0 - (change.amax() / stopping).powi(4)).max(0.0)
}

/// Returns the length of the longest vector, in any direction of the plane of two unit vectors, whose
/// components are within `limits`.
pub fn in_plane([before, after]: [Vector; 2], limits: [f64; 3]) -> f64 {
    let (across, along) = (direction(after - before), direction(after + before));
    let axes = limits.iter().enumerate();
    axes.map(|(k, limit)| limit / across[k].hypot(along[k])).fold(f64::INFINITY, f64::min)
}

/// Returns the unit vector along `vector`; zero if it has no direction.
fn direction(vector: Vector) -> Vector {
    let length = vector.norm();
    if length == 0.0 { vector } else { vector / length }
}

/// Returns the acceleration limit along a segment, mm/s², before an arc leaves a part of it to the turn.
pub fn acceleration_before_turn(segment: &Segment, machine: &Machine) -> f64 {
    let own = match machine.interpolator.junction.blends_in_time() {
        true => limits::blended_acceleration(segment, machine),
        false => limits::acceleration(segment, machine),
    };
    positioning::acceleration(segment, own, machine)
}

/// Returns the acceleration of ramps on a segment between its corners, mm/s²; `own` is [`acceleration_before_turn`].
pub fn acceleration_of_ramps(segment: &Segment, own: f64, machine: &Machine) -> f64 {
    match machine.interpolator.junction.blends_in_time() {
        true => acceleration(segment, own, machine),
        false => own,
    }
}

/// Returns the acceleration along a segment between its corners, mm/s²: on an arc, the part that the turn
/// leaves at the largest feedrate that the axes allow.
pub fn acceleration(segment: &Segment, own: f64, machine: &Machine) -> f64 {
    let Curve::Arc(arc) = &segment.curve else { return own };
    let fastest = limits::axis_feedrate(segment, machine);
    let normal = (fastest * fastest * limits::planned_curvature(arc, segment.length) / own)
        .min(limits::NORMAL_ACCELERATION_SHARE);
    own * (1.0 - normal * normal).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::mm_per_min;

    fn turn(angle: f64) -> CornerTurn {
        let (before, after) = (Vector::x(), Vector::new(angle.cos(), angle.sin(), 0.0));
        CornerTurn {
            before,
            after,
            change: (after - before).norm(),
            half_cosine: 0.5 * (after + before).norm(),
            lengths: [10.0, 12.0],
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
            (Junction::Deviation(0.03), (std::f64::consts::SQRT_2 * 500.0 * 0.03 * radius).sqrt()),
            (Junction::SquareCorner(5.0), 5.0),
            (Junction::AxisStep(7.0), 7.0),
            (Junction::Tolerance, f64::INFINITY),
        ];
        for (junction, feedrate) in expected {
            let found = corner.feedrate(&machine(junction), [500.0; 2]);
            assert!(found == feedrate || (found / feedrate - 1.0).abs() < 1e-12, "{junction:?}: {found}");
        }
    }

    /// Marlin: an arc of radius L/φ, and no more acceleration than the block has that follows.
    #[test]
    fn short_blocks_are_chords_of_an_arc() {
        let mut corner = turn(0.1);
        let mut machine = machine(Junction::Deviation(0.01));
        let of_deviation = corner.feedrate(&machine, [500.0, 300.0]);
        machine.interpolator.short_blocks_are_chords = true;
        let feedrate = |corner: &CornerTurn| corner.feedrate(&machine, [500.0, 300.0]);
        assert!((feedrate(&corner) / of_deviation - (300.0f64 / 500.0).sqrt()).abs() < 0.02);
        corner.lengths = [10.0, 0.2];
        assert!((feedrate(&corner) - (300.0f64 * 0.2 / 0.1).sqrt()).abs() < 1e-9);
        // The block before the corner may have any length, and a large turn is a corner.
        let mut other = turn(1.0);
        let of_long_blocks = feedrate(&other);
        other.lengths = [0.2, 0.2];
        assert_eq!(feedrate(&other), of_long_blocks);
    }

    /// A recording of grbl 1.1: 248 mm/min at a right angle between X and Y, each with 500 mm/s².
    #[test]
    fn junction_deviation_takes_the_acceleration_along_the_bisector() {
        let corner = turn(std::f64::consts::FRAC_PI_2);
        let mut machine = machine(Junction::Deviation(0.010));
        let found = mm_per_min(corner.feedrate(&machine, [500.0; 2]));
        assert!((found - 247.9).abs() < 0.1, "{found} mm/min");
        machine.axes[0].acceleration = 200.0;
        let slower = mm_per_min(corner.feedrate(&machine, [500.0; 2]));
        assert!((slower / found - 0.4f64.sqrt()).abs() < 1e-12, "{slower} mm/min");
    }

    #[test]
    fn short_legs_and_slow_ones_limit_a_square_corner() {
        let mut corner = turn(std::f64::consts::FRAC_PI_2);
        let mut machine = machine(Junction::SquareCorner(5.0));
        machine.path.acceleration = 500.0;
        let feedrate = |corner: &CornerTurn, accelerations| corner.feedrate(&machine, accelerations);
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
}
