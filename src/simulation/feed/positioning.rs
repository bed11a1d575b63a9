//! Rapids from rest to rest: ramps of constant jerk that grow with the speed that a move reaches.
//!
//! A control that positions runs each rapid by itself, from rest to rest. The axis that moves farthest ramps
//! with the jerk J, so that a change of speed by v takes t = n T with T = √(v/J) for n filters (Eq. 8 with
//! the speed that the move reaches instead of the requested one). A move of length L reaches
//!
//! ```text
//! v = min( V,  (L √J / n)^(2/3) )
//! ```
//!
//! The second term is the speed at which both ramps meet: L = v n T. The move lasts L/v + n T. Below V that
//! is 2 n^(2/3) (L/J)^(1/3), which for n = 2 is the (32 L / J)^(1/3) of bang-bang jerk. Short moves therefore
//! cost much less than the ramp to the rapid feedrate would.
//!
//! Symbols: V rapid feedrate with override and axis limits (mm/s), J jerk along the path (mm/s³): the jerk of
//! an axis over the largest share that an axis has in the move. Source: time and peak speed of recorded
//! rapids from 0.6 to 170 mm, which follow the cube root of their length. Limits: no acceleration limit;
//! rotary axes that turn along with a move are ignored.

use crate::machine::Machine;
use crate::simulation::feed::limits;
use crate::simulation::toolpath::Segment;

/// Returns `true` if the segment is positioned from rest to rest.
pub fn applies(segment: &Segment, machine: &Machine) -> bool {
    segment.motion.is_rapid() && machine.rapid.positioning_jerk.is_finite()
}

/// Returns the jerk along the path, mm/s³.
fn jerk(segment: &Segment, machine: &Machine) -> f64 {
    machine.rapid.positioning_jerk / limits::largest_share(segment).max()
}

/// Returns the feedrate that a positioned segment reaches at the requested feedrate `requested`, mm/s; for
/// any other segment `requested` itself.
pub fn feedrate(segment: &Segment, requested: f64, machine: &Machine) -> f64 {
    if !applies(segment, machine) {
        return requested;
    }
    let order = machine.interpolator.filters as f64;
    requested.min((segment.length * jerk(segment, machine).sqrt() / order).powf(2.0 / 3.0))
}

/// Returns the acceleration limit of a segment, mm/s²; `own` is the limit of path and axes. A positioned
/// segment has its own ramps instead.
pub fn acceleration(segment: &Segment, own: f64, machine: &Machine) -> f64 {
    if applies(segment, machine) { f64::INFINITY } else { own }
}

/// Returns the time constant of the filters for a positioned segment that reaches `feedrate` (mm/s), s.
pub fn time_constant(segment: &Segment, feedrate: f64, machine: &Machine) -> f64 {
    (feedrate / jerk(segment, machine)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation::feed::{Tolerances, command};
    use crate::simulation::gcode::read;
    use crate::simulation::interpreter::trace;

    fn seconds(program: &str, machine: &Machine) -> f64 {
        let toolpath = trace(&read(program.as_bytes()), machine);
        command(&toolpath, machine, Tolerances::Programmed.into()).cycle_time()
    }

    fn machine(jerk: f64) -> Machine {
        let mut machine = Machine::default();
        machine.interpolator.filters = 2;
        machine.rapid.feedrate = 500.0;
        machine.rapid.positioning_jerk = jerk;
        machine
    }

    #[test]
    fn short_moves_take_the_cube_root_of_their_length() {
        let machine = machine(33000.0);
        for length in [0.01f64, 1.0, 20.0, 100.0] {
            let expected = (32.0 * length / 33000.0).powf(1.0 / 3.0);
            let time = seconds(&format!("G0 X{length}\n"), &machine);
            assert!((time / expected - 1.0).abs() < 1e-12, "{length}: {time}, {expected}");
        }
    }

    #[test]
    fn long_moves_ramp_to_the_rapid_feedrate() {
        let time = seconds("G0 X1000\n", &machine(33000.0));
        assert!((time - (2.0 + 2.0 * (500.0f64 / 33000.0).sqrt())).abs() < 1e-12, "{time}");
    }

    #[test]
    fn the_axis_that_moves_furthest_sets_the_time() {
        let machine = machine(33000.0);
        let (one, both) = (seconds("G0 X50\n", &machine), seconds("G0 X50 Y50\n", &machine));
        assert!((one / both - 1.0).abs() < 1e-12, "{one}, {both}");
    }

    #[test]
    fn each_move_stands_at_both_ends() {
        let machine = machine(33000.0);
        let apart = seconds("G0 X50\n", &machine) + seconds("G0 X30\n", &machine);
        let feed = seconds("G1 X10 F1000\n", &machine);
        let chain = seconds("G0 X50\nX80\nG1 X90 F1000\n", &machine);
        assert!((chain - apart - feed).abs() < 1e-9, "{chain}, {apart} + {feed}");
    }
}
