//! A minimum share of cruising: how Klipper keeps short moves from speeding up only to slow down.
//!
//! A move, or a run of moves that speeds up and slows down without cruising, gets no faster than it would
//! with the acceleration a' = A (1 − ρ) instead of its acceleration a, where ρ is the minimum cruise ratio
//! and A the acceleration along the path. With the limits j of corners and the lengths L of moves,
//!
//! ```text
//! forwards     m_0 = 0,    m_i = min( j_i²,  m_(i−1) + 2 a' L_(i−1) )       before move i
//! backwards    r_i = n + 2 a' L_i,    n ← min( m_i, r_i )                    n = 0 at the end
//! peak         p² = ( min(m_i, r_i) + r_i ) / 2                              where move i can speed up
//! ```
//!
//! A move that can speed up, min(m_i, r_i) < r_i, sets a peak p if it can also slow down or if moves that
//! only slow down come after it. The peak limits this move and the moves before it that set none. Moves that
//! only slow down are no faster than the move before them. Ramps keep the acceleration a, so that the machine
//! cruises along the rest of the length.
//!
//! Symbols: lengths in mm, speeds in mm/s, accelerations in mm/s², ρ without unit from 0 (no such limit) to 1.
//! Source: Klipper, klippy/toolhead.py, `LookAheadQueue.flush` and `Move.calc_junction`. Limits: the whole
//! rest-to-rest motion is known at once; Klipper knows 2 s of it, which ends at a peak.

/// The values of a move on which the limit depends.
#[derive(Clone, Copy, Debug)]
pub struct PlannedMove {
    /// Length, mm.
    pub length: f64,
    /// Acceleration of its ramps, mm/s².
    pub acceleration: f64,
    /// Acceleration that limits the peak speed, mm/s²; at most `acceleration`.
    pub peak_acceleration: f64,
}

impl PlannedMove {
    /// Returns the change of v² within the move at an acceleration, mm²/s².
    fn change(&self, acceleration: f64) -> f64 {
        2.0 * acceleration * self.length
    }
}

/// Lowers the feedrates of moves (mm/s) to those that leave the minimum share of cruising. `limits` are the
/// limits of the corner after each move (mm/s), `corners` the feedrates there that both neighbours can reach
/// (mm/s); both end with 0.
pub fn lower(moves: impl Fn(usize) -> PlannedMove, limits: &[f64], corners: &[f64], feedrates: &mut [f64]) {
    let square = |corner: f64| corner * corner;
    let mut most = vec![0.0; feedrates.len()];
    for i in 1..feedrates.len() {
        let before = moves(i - 1);
        most[i] = square(limits[i - 1]).min(most[i - 1] + before.change(before.peak_acceleration));
    }
    // Squares of the peak speeds; infinite for moves that only slow down.
    let mut peaks = vec![f64::INFINITY; feedrates.len()];
    let (mut next, mut peak, mut slowing) = (0.0, f64::INFINITY, 0);
    for i in (0..feedrates.len()).rev() {
        let run = moves(i);
        let reachable = next + run.change(run.peak_acceleration);
        let start = f64::min(most[i], reachable);
        slowing += 1;
        if start < reachable {
            if next < start + run.change(run.peak_acceleration) || 1 < slowing {
                peak = 0.5 * (start + reachable);
            }
            let first = if i == 0 { 0.0 } else { square(corners[i - 1]) };
            let by_ramps = 0.5 * (first + square(corners[i]) + run.change(run.acceleration));
            peaks[i] = by_ramps.min(peak);
            slowing = 0;
        }
        next = start;
    }
    let mut before = 0.0;
    for (i, feedrate) in feedrates.iter_mut().enumerate() {
        let first = if i == 0 { 0.0 } else { corners[i - 1] };
        *feedrate = if peaks[i].is_finite() {
            feedrate.min(peaks[i].sqrt())
        } else {
            feedrate.min(first).min(before)
        };
        before = *feedrate;
    }
}

#[cfg(test)]
mod tests {
    use crate::machine::{Junction, Machine, TimeConstants};
    use crate::simulation::feed::{Tolerances, command};
    use crate::simulation::gcode::read;
    use crate::simulation::interpreter::trace;

    const CONSTANT_S: f64 = 1e-4;

    fn machine(ratio: f64) -> Machine {
        let mut machine = Machine::default();
        machine.interpolator.filters = 1;
        machine.interpolator.time_constants = TimeConstants::Equal(CONSTANT_S);
        machine.interpolator.contour_tolerance = 10.0;
        machine.interpolator.junction = Junction::SquareCorner(5.0);
        machine.interpolator.minimum_cruise_ratio = ratio;
        machine.path.acceleration = 500.0;
        machine
    }

    fn seconds(program: &str, machine: &Machine) -> f64 {
        let toolpath = trace(&read(program.as_bytes()), machine);
        command(&toolpath, machine, Tolerances::Programmed.into()).cycle_time()
    }

    #[test]
    fn a_move_from_stop_to_stop_peaks_as_with_less_acceleration() {
        for (ratio, length) in [(0.5, 3.0f64), (0.2, 0.1), (0.9, 7.0)] {
            let peak = (500.0 * (1.0 - ratio) * length).sqrt();
            let expected = 2.0 * peak / 500.0 + (length - peak * peak / 500.0) / peak + CONSTANT_S;
            let found = seconds(&format!("G1 X{length} F9000\n"), &machine(ratio));
            assert!((found / expected - 1.0).abs() < 1e-12, "{ratio}: {found} s, {expected} s");
        }
    }

    #[test]
    fn a_long_move_reaches_its_feedrate_all_the_same() {
        let found = seconds("G1 X100 F3000\n", &machine(0.5));
        assert!((found - (2.0 + 0.1 + CONSTANT_S)).abs() < 1e-12, "{found} s");
    }

    /// Zigzags of all lengths: the more has to be cruised the longer they take, and ramps keep the acceleration.
    #[test]
    fn a_larger_ratio_never_saves_time() {
        let points = (1..300).map(|k| {
            let (k, step) = (f64::from(k), 0.2 + 3.0 * (0.37 * f64::from(k)).sin().abs());
            format!("G1 X{:.4} Y{:.4} Z{:.4}\n", 2.0 * k, step, step * (1.3 * k).cos())
        });
        let program = "G1 F6000\n".to_string() + &points.collect::<String>();
        let mut before = 0.0;
        for ratio in [0.0, 1e-12, 0.1, 0.3, 0.5, 0.7, 0.9] {
            let machine = machine(ratio);
            let toolpath = trace(&read(program.as_bytes()), &machine);
            let plan = command(&toolpath, &machine, Tolerances::Programmed.into());
            for pulse in plan.pulses.iter() {
                let acceleration = (pulse.feedrate[1] - pulse.feedrate[0]).abs() / pulse.duration;
                assert!(acceleration <= 500.0 * (1.0 + 1e-6), "{ratio}: {acceleration} mm/s²");
            }
            // The filter holds a corner for up to half of its 0.1 ms.
            assert!(before <= plan.cycle_time() * (1.0 + 1e-4), "{ratio}: {} s", plan.cycle_time());
            before = plan.cycle_time();
        }
    }

    #[test]
    fn a_control_of_filters_alone_is_as_it_was() {
        let plain = Machine::default();
        let mut cruising = plain.clone();
        cruising.interpolator.minimum_cruise_ratio = 0.5;
        assert_eq!(seconds("G1 X3 F9000\nY2\n", &cruising), seconds("G1 X3 F9000\nY2\n", &plain));
    }
}
