//! The parameters that a fit may free: how each varies, its bounds, and the values from which a calibration begins.
//!
//! Hypotheses, calibration and diagnosis take their free parameters from this table. Many of them have other bounds
//! in a calibration than in a hypothesis, on purpose:
//!
//! - A hypothesis adds one effect to a machine file that is otherwise right, and begins with trials. A value at a
//!   bound shows that another effect causes the lost time, so the bounds are wider than the values of machines.
//! - A calibration frees many parameters at once and begins with one guess, perhaps in the file of another machine.
//!   Its bounds are the values of machines, or ratios to a value of this machine, because one parameter must not
//!   compensate for another.
//!
//! A parameter without separate bounds for calibration has the same in both, or no calibration frees it.

use Bounds::{Ratios, Values};

use crate::identification::effects::waits::LONGEST_WAIT_S;
use crate::identification::fit::{Exactness, FreeParameter, VariationScale};
use crate::machine::{FREE_BLEND_MM, Handle, Machine, PLANNER_FILTER_S};

/// Least and largest value of a parameter.
#[derive(Clone, Copy, Debug)]
pub enum Bounds {
    /// In core units.
    Values(f64, f64),
    /// As ratios to a reference value.
    Ratios(f64, f64),
}

impl Bounds {
    fn around(self, reference: f64) -> (f64, f64) {
        match self {
            Values(least, largest) => (least, largest),
            Ratios(least, largest) => (least * reference, largest * reference),
        }
    }
}

/// A parameter that a fit may free.
#[derive(Clone, Copy, Debug)]
pub struct Adjustable {
    /// Key in the table of machine parameters.
    pub key: &'static str,
    /// Values from which a calibration begins, core units unless the row says otherwise.
    pub guesses: &'static [f64],
    scale: VariationScale,
    exactness: Exactness,
    /// Bounds in a hypothesis.
    tried: Bounds,
    /// Bounds in a calibration.
    calibrated: Bounds,
}

impl Adjustable {
    const fn in_calibration(self, calibrated: Bounds) -> Adjustable {
        Adjustable { calibrated, ..self }
    }

    const fn guessed(self, guesses: &'static [f64]) -> Adjustable {
        Adjustable { guesses, ..self }
    }

    const fn exactly(self, exactness: Exactness) -> Adjustable {
        Adjustable { exactness, ..self }
    }

    /// Returns the handle in the table of machine parameters.
    pub fn handle(&self) -> Handle {
        Handle::row(self.key)
    }

    /// Returns the free parameter of a hypothesis, which begins with its trials.
    pub fn tried(&self) -> FreeParameter {
        self.tried_around(1.0)
    }

    /// Returns the free parameter of a hypothesis whose bounds are ratios to `reference`, core units.
    pub fn tried_around(&self, reference: f64) -> FreeParameter {
        let bounds = self.tried.around(reference);
        self.free(bounds.0, bounds)
    }

    /// Returns the free parameter of a calibration that begins with `start`, core units, to which bounds may be
    /// ratios.
    pub fn calibrated(&self, start: f64) -> FreeParameter {
        self.calibrated_around(start, start)
    }

    /// Returns the free parameter of a calibration that begins with `start` and whose bounds are ratios to
    /// `reference`, core units.
    pub fn calibrated_around(&self, start: f64, reference: f64) -> FreeParameter {
        self.free(start, self.calibrated.around(reference))
    }

    /// Returns the free parameter that a diagnosis fits beside a cause, because a calibration had to assume its
    /// value `own`, core units. It stays above `least`, unless `own` is lower.
    pub fn assumed(&self, own: f64, least: f64) -> FreeParameter {
        let (low, high) = ASSUMED_RATIOS.around(own);
        self.free(own, (low.max(least.min(own)), high))
    }

    /// Returns the free parameter for a value that is known to differ from `own` (core units) by at most the factor `ratio`.
    pub fn near(&self, own: f64, ratio: f64) -> FreeParameter {
        self.free(own, (own / ratio, own * ratio))
    }

    fn free(&self, start: f64, bounds: (f64, f64)) -> FreeParameter {
        let mut freed = FreeParameter::new(self.handle(), start, bounds, self.scale);
        freed.exactness = self.exactness;
        freed
    }

    /// Returns the machine with each value from which a calibration begins.
    pub fn guesses_on(&self, machine: &Machine) -> Vec<Machine> {
        let guess = |value: &f64| {
            let mut machine = machine.clone();
            self.handle().set(&mut machine, *value);
            machine
        };
        self.guesses.iter().map(guess).collect()
    }
}

/// Returns a parameter that varies by ratios.
const fn ratio(key: &'static str, bounds: Bounds) -> Adjustable {
    let (scale, exactness) = (VariationScale::Ratio, Exactness::Law);
    Adjustable { key, guesses: &[], scale, exactness, tried: bounds, calibrated: bounds }
}

/// Returns a parameter that varies by differences.
const fn difference(key: &'static str, bounds: Bounds) -> Adjustable {
    Adjustable { scale: VariationScale::Difference, ..ratio(key, bounds) }
}

/// Declares parameters.
macro_rules! parameters {
    ($($(#[$doc:meta])* $name:ident = $row:expr;)*) => {
        $($(#[$doc])* pub const $name: Adjustable = $row;)*

        #[cfg(test)]
        const ROWS: &[Adjustable] = &[$($name,)*];
    };
}

/// Declares parameters of X, Y and Z: number in the table of the axis, bounds, and bounds in a calibration if they
/// are others.
macro_rules! parameters_of_axes {
    ($($(#[$doc:meta])* $name:ident = $number:literal, $tried:expr $(, $calibrated:expr)?;)*) => {
        $($(#[$doc])* pub const $name: [Adjustable; 3] = [
            ratio(concat!("axis.x.", $number), $tried)$(.in_calibration($calibrated))?,
            ratio(concat!("axis.y.", $number), $tried)$(.in_calibration($calibrated))?,
            ratio(concat!("axis.z.", $number), $tried)$(.in_calibration($calibrated))?,
        ];)*

        #[cfg(test)]
        const ROWS_OF_AXES: &[[Adjustable; 3]] = &[$($name,)*];
    };
}

/// Bounds of a value that a calibration assumed, as ratios to it.
const ASSUMED_RATIOS: Bounds = Ratios(0.1, 10.0);
/// Bounds of a limit of an axis in a calibration, as ratios to its value in the machine file or to its guess.
const AXIS_RATIOS: Bounds = Ratios(0.05, 20.0);
/// Bounds of the jerk of ramps in a calibration, mm/s³.
const CALIBRATED_JERKS_MM_S3: Bounds = Values(1e3, 1e6);
/// Bounds of a time constant in a calibration, s. Shorter filters count as none.
const CALIBRATED_CONSTANTS_S: Bounds = Values(PLANNER_FILTER_S, 0.5);
/// Bounds of a tolerance in a hypothesis, mm.
const TOLERANCES_MM: Bounds = Values(1e-5, 5.0);
/// Bounds of a tolerance in a calibration, mm. The widest is that of planners that blend freely.
const CALIBRATED_TOLERANCES_MM: Bounds = Values(2e-4, FREE_BLEND_MM);
/// Bounds of a wait for the spindle, s.
const SPINDLE_WAITS_S: Bounds = Values(1e-3, 60.0);
/// Largest distance of the joint of two lines from their chord at which a control smooths it, mm; a joint farther
/// away is a corner.
pub const WIDEST_JOINT_MM: f64 = 0.3;
/// Values of the junction law of a planner from which a calibration begins, as ratios to the usual one.
pub const JUNCTION_RATIOS: [f64; 7] = [0.05, 0.15, 0.4, 1.0, 2.5, 6.0, 20.0];
/// Centripetal acceleration from which a calibration of steps of velocity begins, mm/s²: between the guesses of
/// [`CENTRIPETAL_ACCELERATION`], because its grid of jerks and steps is too large to be tried with each of them.
pub const FIRST_CENTRIPETAL_MM_S2: f64 = 600.0;

parameters! {
    /// Acceleration of all axes, mm/s², of a control that a hypothesis or a calibration takes for a planner.
    PLANNER_ACCELERATION = ratio("interpolator.junction_rule", Values(10.0, 1e5))
        .guessed(&[50.0, 100.0, 200.0, 350.0, 500.0, 800.0, 1300.0, 2500.0, 5000.0, 10_000.0]);
    /// Number of filters; a calibration tries every one.
    FILTERS = difference("interpolator.filters", Values(1.0, 4.0)).guessed(&[1.0, 2.0, 3.0, 4.0]);
    /// Time constant of the filters, s.
    TIME_CONSTANT = ratio("interpolator.time_constant_s", Values(2e-4, 0.5)).in_calibration(CALIBRATED_CONSTANTS_S);
    /// Ratio by which all filters but one are shorter than their mean; that one is longer, so that the total delay stays.
    FILTER_SPREAD = difference("interpolator.time_constants_s", Values(0.02, 0.95));
    /// Jerk from which the time constants follow, mm/s³; as a ratio to the jerk of the constants in the machine file.
    FILTER_JERK = ratio("interpolator.max_jerk_mm_s3", Ratios(1e-3, 1e3));

    /// Contour tolerance of corners, mm.
    CONTOUR_TOLERANCE =
        ratio("interpolator.contour_tolerance_mm", TOLERANCES_MM).in_calibration(CALIBRATED_TOLERANCES_MM);
    /// Contour tolerance instead of those that a program sets, mm.
    TOLERANCE_OVERRIDE = ratio("path_modes.tolerance_override_mm", TOLERANCES_MM);
    /// Contour tolerance of arcs, mm. In a hypothesis as a ratio to that of corners, from which arcs are hardly
    /// slowed; the guesses of a calibration are ratios to it as well.
    ARC_TOLERANCE = ratio("interpolator.arc_tolerance_mm", Ratios(5.0, 1e5))
        .in_calibration(CALIBRATED_TOLERANCES_MM).guessed(&[0.3, 3.0, 30.0]);
    /// Junction deviation, mm. Below the least value of a hypothesis every corner is a full stop, which is another
    /// effect.
    JUNCTION_DEVIATION =
        ratio("interpolator.junction_deviation_mm", Values(5e-4, 1e5)).in_calibration(Values(1e-5, 5.0));
    /// Square-corner velocity, mm/s; its bounds differ as those of [`JUNCTION_DEVIATION`] do.
    SQUARE_CORNER_VELOCITY =
        ratio("interpolator.square_corner_velocity_mm_min", Values(0.15, 1e5)).in_calibration(Values(0.1, 1e3));
    /// Velocity step of axes at corners, mm/s; its bounds differ as those of [`JUNCTION_DEVIATION`] do.
    AXIS_VELOCITY_STEP = ratio("interpolator.axis_velocity_step_mm_min", Values(0.15, 1e5))
        .in_calibration(Values(0.1, 1e3)).guessed(&[1.0, 3.0, 8.0, 25.0]);
    /// Largest feed override for which LinuxCNC plans circles, as a ratio; its sample configurations have 1.2 and more.
    MAX_OVERRIDE = ratio("interpolator.max_override_percent", Values(1.0, 10.0)).guessed(&[1.2, 1.5, 2.0]);
    /// Turn from which on corners are stops, rad; less sharp ones are slowed.
    SLOWING_ANGLE = ratio("interpolator.slowing_angle_deg", Values(0.05, 3.0)).guessed(&[0.44]);
    /// Turn above which corners are full stops, rad.
    EXACT_STOP_ANGLE = difference("interpolator.exact_stop_angle_deg", Values(0.0, std::f64::consts::PI));
    /// Minimum cruise ratio of Klipper.
    MINIMUM_CRUISE_RATIO = difference("interpolator.minimum_cruise_ratio", Values(0.0, 0.95));
    /// Distance within which the control merges lines, mm.
    PATH_SMOOTHING = difference("interpolator.path_smoothing_mm", Values(0.0, 10.0));
    /// Distance within which the control rounds corners, mm.
    CORNER_SMOOTHING = ratio("interpolator.corner_smoothing_mm", Values(5e-5, 2.0 * WIDEST_JOINT_MM));

    /// Time for each block, s.
    BLOCK_TIME = ratio("interpolator.block_time_s", Values(1e-5, 1.0)).exactly(Exactness::Cycles);
    /// Number of blocks that the control sees ahead.
    LOOK_AHEAD = ratio("interpolator.look_ahead_blocks", Values(1.0, 1e6));

    /// Velocity limit along the path, mm/s; as a ratio to the highest programmed feedrate.
    PATH_VELOCITY = ratio("path.velocity_mm_min", Ratios(1e-3, 2.0));
    /// Acceleration limit along the path, mm/s². The guesses are one that limits the motion and one that hardly does:
    /// a fit may end at more than one place, because faster corners make up for time lost on ramps.
    PATH_ACCELERATION = ratio("path.acceleration_mm_s2", Values(10.0, 2e5))
        .in_calibration(Values(10.0, 1e5)).guessed(&[500.0, 5000.0]);
    /// Acceleration limit towards the centre of arcs, mm/s².
    CENTRIPETAL_ACCELERATION = ratio("path.centripetal_acceleration_mm_s2", Values(1.0, 1e6))
        .in_calibration(Values(10.0, 1e5)).guessed(&[100.0, 200.0, 400.0, 800.0, 1600.0, 3200.0]);
    /// Jerk limit along the path, mm/s³.
    /// With a jerk of 10 000 m/s³ an acceleration of 10 m/s² takes a millisecond, the cycle of a control, to build up.
    PATH_JERK = ratio("path.jerk_mm_s3", Values(1e3, 1e7)).in_calibration(CALIBRATED_JERKS_MM_S3).guessed(&[1e4, 3e4, 1e5, 3e5]);

    /// Rapid feedrate along the path, mm/s; as a ratio to the fastest rapid of the machine file.
    RAPID_FEEDRATE = ratio("rapid.feed_mm_min", Ratios(0.02, 10.0));
    /// Time constant of the filters of rapids, s; the guess is a ratio to that of feed moves.
    RAPID_TIME_CONSTANT = ratio("rapid.time_constant_s", CALIBRATED_CONSTANTS_S).guessed(&[2.0]);
    /// Jerk limit of rapids from standstill to standstill, mm/s³; a hypothesis begins with the same values as a
    /// calibration.
    POSITIONING_JERK = ratio("rapid.positioning_jerk_mm_s3", Values(5e3, 5e6)).guessed(&[2e4, 5e4, 1e5, 3e5]);

    /// Wait at full stops until the axes are in position, s. The longest of a hypothesis is that at which controls
    /// stop with an alarm (Siemens MD36020 POSITIONING_TIME, 1 s). The stiffest position loops (10 m/min for each mm
    /// of lag) come nearer by one part in e in 6 ms; less than a third of that, the shortest of a hypothesis, is the
    /// rounding of block ends to the cycles of the control.
    IN_POSITION_WAIT = ratio("halts.in_position_s", Values(2e-3, 1.0)).exactly(Exactness::Cycles)
        .in_calibration(Values(1e-4, 0.5)).guessed(&[0.03]);
    /// Wait of the feed at S words, s.
    SPINDLE_CHANGE_WAIT = ratio("times.spindle_change_s", SPINDLE_WAITS_S).exactly(Exactness::Cycles);
    /// Wait of the first feed move at a new speed of the spindle, s.
    SPINDLE_AT_FEED_WAIT = ratio("times.spindle_at_feed_s", SPINDLE_WAITS_S).exactly(Exactness::Cycles);
    /// Ramp of the spindle that the first feed move at a new speed waits for, s for each rpm.
    SPINDLE_RAMP_AT_FEED = ratio("times.spindle_at_feed_s_per_1000_rpm", Values(1e-5, 0.1)).exactly(Exactness::Cycles);
    /// Ramp of the spindle, s for each rpm.
    SPINDLE_RAMP = difference("times.spindle_s_per_1000_rpm", Values(0.0, 0.1)).exactly(Exactness::Wait);
    /// Time from the start of a program to its first block, s.
    PROGRAM_START = difference("times.start_s", Values(0.0, LONGEST_WAIT_S)).exactly(Exactness::Wait);
    /// Extra time of each dwell beyond the programmed time, s.
    DWELL_EXCESS = difference("times.dwell_excess_s", Values(0.0, 1.0)).exactly(Exactness::Wait);

    /// Feed override, as a ratio.
    FEED_OVERRIDE = ratio("override.feed", Values(0.01, 2.0)).exactly(Exactness::Exact);
    /// Rapid override, as a ratio; in a hypothesis as a ratio to the largest that the control has.
    RAPID_OVERRIDE = ratio("override.rapid", Ratios(0.01, 1.0)).exactly(Exactness::Exact);
    /// Rate of the recorder's clock, as a ratio to true time. Quartz is accurate to 2e-4. A row that counts ticks of
    /// a timer is off by the rounding of the tick, at worst 16 ms for the 15.625 ms of Windows.
    CLOCK_RATIO = ratio("recorder.clock_ratio", Values(0.97, 1.03)).exactly(Exactness::Exact)
        .in_calibration(Values(0.998, 1.002));
}

parameters_of_axes! {
    /// Acceleration limit of each axis, mm/s².
    AXIS_ACCELERATION = "acceleration_mm_s2", Values(10.0, 2e5), AXIS_RATIOS;
    /// Jerk limit of each axis on ramps, mm/s³.
    AXIS_JERK = "jerk_mm_s3", Values(1e3, 1e7), CALIBRATED_JERKS_MM_S3;
    /// Velocity limit of each axis, mm/s; in a hypothesis as a ratio to the highest programmed velocity.
    AXIS_VELOCITY = "velocity_mm_min", Ratios(1e-3, 2.0), AXIS_RATIOS;
    /// Rapid rate of each axis, mm/s.
    AXIS_RAPID = "rapid_mm_min", AXIS_RATIOS;
    /// Lag of each axis behind its command, s.
    SERVO_LAG = "servo_lag_s", Values(1e-5, 0.5);
    /// Backlash of each axis, mm.
    BACKLASH = "backlash_mm", Values(1e-4, 2.0);
    /// Compensation of the backlash of each axis, mm.
    BACKLASH_COMPENSATION = "backlash_compensation_mm", Values(1e-4, 2.0);
    /// Frequency of the structural mode of each axis, Hz. A faster vibration in a recording does not come from the
    /// structure.
    VIBRATION_FREQUENCY = "vibration_hz", Values(1.0, 1000.0);
    /// Damping ratio of the structural mode of each axis.
    VIBRATION_DAMPING = "vibration_damping", Values(1e-3, 0.7);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_is_of_a_machine_parameter_and_has_bounds_in_order() {
        for row in ROWS.iter().chain(ROWS_OF_AXES.as_flattened()) {
            assert_eq!(row.handle().key(), row.key);
            for (least, largest) in
                [row.tried().bounds, row.calibrated(1.0).bounds, row.assumed(1.0, 0.0).bounds]
            {
                assert!(least < largest, "{}", row.key);
            }
        }
    }
}
