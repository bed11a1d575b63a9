//! Planners: controls that ramp by an acceleration instead of filters.

use crate::machine::{ArcChords, Junction, Machine, TimeConstants};

/// Longest time constant of the filter that a planner retains, s: half the servo period of LinuxCNC.
pub const PLANNER_FILTER_S: f64 = 5e-4;
/// Time constant of the filter that a planner without a servo period retains, s: the shortest in a machine file. Each stop
/// takes this much longer, and a fit would make up for it by faster corners.
const STEPPER_FILTER_S: f64 = 1e-5;

/// Factor on a filter delay compared with [`PLANNER_FILTER_S`], as a machine file may round the constants up.
const MIN_ROUNDING_RATIO: f64 = 0.999;

/// A family of controls whose planner ramps in trapezoids, by its junction law.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Planner {
    /// Axes have acceleration limits, and corners are blended within these, as in LinuxCNC.
    AccelerationBlend,
    /// Axes have acceleration limits, and a junction deviation limits corners, as in grbl.
    JunctionDeviation,
    /// The path has an acceleration limit, and a square-corner velocity limits corners, as in Klipper.
    SquareCorner,
    /// Axes have acceleration limits, and a largest step of their velocity limits corners, as in Marlin with classic jerk.
    AxisStep,
    /// As [`Planner::JunctionDeviation`], but short blocks are chords of an arc, as in Marlin without classic jerk.
    ChordDeviation,
}

/// Contour tolerance of a LinuxCNC planner if the program sets none, mm: no blend reaches it.
pub const FREE_BLEND_MM: f64 = 10.0;
/// Lines and circles that LinuxCNC plans ahead by default (`ARC_BLEND_OPTIMIZATION_DEPTH`).
const LINUXCNC_LOOK_AHEAD: f64 = 50.0;
/// Default junction deviation of grbl, mm.
const GRBL_JUNCTION_DEVIATION_MM: f64 = 0.01;
/// Default distance between an arc and its chords in grbl, mm.
const GRBL_CHORD_ERROR_MM: f64 = 0.002;
/// Factors for the distance between arcs and their chords, tried where runs do not show it. The defaults of grbl and TinyG
/// differ by a factor of five.
pub const CHORD_ERROR_RATIOS: [f64; 2] = [0.2, 5.0];
/// Blocks that grbl and Marlin plan ahead by default: their ring of 16 blocks (`BLOCK_BUFFER_SIZE`) keeps one free.
const RING_LOOK_AHEAD: f64 = 15.0;
/// Time for which the step timer of grbl holds one feedrate, s (`DT_SEGMENT`).
pub const GRBL_STEP_SEGMENT_S: f64 = 0.01;
/// Frequency of the step timer of grbl on the boards that it was written for, Hz.
pub const GRBL_STEP_TIMER_HZ: f64 = 16e6;
/// Default square-corner velocity of Klipper, mm/s.
const KLIPPER_SQUARE_CORNER_MM_S: f64 = 5.0;
/// Default length of the chords of arcs in Klipper, mm.
const KLIPPER_CHORD_MM: f64 = 0.1;
/// Default minimum cruise ratio of Klipper.
pub const KLIPPER_MIN_CRUISE_RATIO: f64 = 0.5;
/// Default step of the velocity of X and Y of Marlin, mm/s (`DEFAULT_XJERK`).
const MARLIN_AXIS_STEP_MM_S: f64 = 10.0;
/// Default junction deviation of Marlin, mm (`JUNCTION_DEVIATION_MM`).
const MARLIN_JUNCTION_DEVIATION_MM: f64 = 0.013;
/// Default length of the chords of arcs in Marlin, mm (`MAX_ARC_SEGMENT_MM`).
const MARLIN_CHORD_MM: f64 = 1.0;

impl Planner {
    /// All families.
    pub const ALL: [Planner; 5] = [
        Planner::AccelerationBlend,
        Planner::JunctionDeviation,
        Planner::SquareCorner,
        Planner::AxisStep,
        Planner::ChordDeviation,
    ];

    /// Returns `true` if G0 of the family is G1, so rapids have a programmed feedrate.
    fn has_rapids_at_feedrate(self) -> bool {
        matches!(self, Planner::SquareCorner | Planner::AxisStep | Planner::ChordDeviation)
    }
}

impl Machine {
    /// Returns `true` if filters shape the ramps. The machine file of a planner contains a filter no longer
    /// than [`PLANNER_FILTER_S`], which counts as none.
    pub fn has_filters(&self) -> bool {
        let interpolator = &self.interpolator;
        match (interpolator.junction, &interpolator.time_constants) {
            (Junction::AccelerationBlend | Junction::ParabolicBlend | Junction::ExactPath, _) => false,
            (Junction::Tolerance, _) => true,
            (_, TimeConstants::Equal(constant)) => {
                PLANNER_FILTER_S < interpolator.filters as f64 * constant * MIN_ROUNDING_RATIO
            }
            _ => true,
        }
    }

    /// Turns the machine into one of a family of planners with the default settings of the family.
    /// `acceleration` (mm/s²) becomes the limit of all axes, or of the path and Z for
    /// [`Planner::SquareCorner`], unless a limit is already lower.
    pub fn become_planner(&mut self, planner: Planner, acceleration: f64) {
        self.interpolator.filters = 1;
        self.interpolator.time_constants = TimeConstants::Equal(STEPPER_FILTER_S);
        // The planners of grbl and Klipper plan rapids and feed moves together; LinuxCNC stops between them.
        self.rapid.time_constants = None;
        self.rapid.at_feedrate |= planner.has_rapids_at_feedrate();
        self.limit_accelerations(planner, acceleration, [acceleration; 3]);
        match planner {
            Planner::AccelerationBlend => {
                self.interpolator.time_constants = TimeConstants::Equal(PLANNER_FILTER_S);
                self.rapid.time_constants = Some(TimeConstants::Equal(PLANNER_FILTER_S));
                self.interpolator.junction = Junction::AccelerationBlend;
                self.interpolator.contour_tolerance = FREE_BLEND_MM;
                self.interpolator.look_ahead = self.interpolator.look_ahead.min(LINUXCNC_LOOK_AHEAD);
            }
            Planner::JunctionDeviation => {
                self.interpolator.junction = Junction::Deviation(GRBL_JUNCTION_DEVIATION_MM);
                self.interpolator.arc_chords = ArcChords::Within(GRBL_CHORD_ERROR_MM);
                self.interpolator.look_ahead = self.interpolator.look_ahead.min(RING_LOOK_AHEAD);
                self.interpolator.step_segment = GRBL_STEP_SEGMENT_S;
                self.interpolator.step_timer = GRBL_STEP_TIMER_HZ;
            }
            Planner::SquareCorner => {
                self.interpolator.junction = Junction::SquareCorner(KLIPPER_SQUARE_CORNER_MM_S);
                self.interpolator.arc_chords = ArcChords::Long(KLIPPER_CHORD_MM);
                self.interpolator.minimum_cruise_ratio = KLIPPER_MIN_CRUISE_RATIO;
            }
            Planner::AxisStep => {
                self.interpolator.junction = Junction::AxisStep(MARLIN_AXIS_STEP_MM_S);
                self.interpolator.arc_chords = ArcChords::Long(MARLIN_CHORD_MM);
                self.interpolator.look_ahead = self.interpolator.look_ahead.min(RING_LOOK_AHEAD);
            }
            Planner::ChordDeviation => {
                self.interpolator.junction = Junction::Deviation(MARLIN_JUNCTION_DEVIATION_MM);
                self.interpolator.short_blocks_are_chords = true;
                self.interpolator.arc_chords = ArcChords::Long(MARLIN_CHORD_MM);
                self.interpolator.look_ahead = self.interpolator.look_ahead.min(RING_LOOK_AHEAD);
            }
        }
    }

    /// Lowers the accelerations that a family of planners limits: the path to `along_path` and Z to that of `of_axes` for
    /// [`Planner::SquareCorner`], each axis to that of `of_axes` for the others, mm/s².
    pub fn limit_accelerations(&mut self, planner: Planner, along_path: f64, of_axes: [f64; 3]) {
        let is_along_path = planner == Planner::SquareCorner;
        if is_along_path {
            self.path.acceleration = self.path.acceleration.min(along_path);
        }
        for (axis, limit) in self.axes.iter_mut().zip(of_axes).skip(if is_along_path { 2 } else { 0 }) {
            axis.acceleration = axis.acceleration.min(limit);
        }
    }

    /// Returns the machine with the acceleration limits of the path and of all axes multiplied by `ratio`.
    pub fn with_scaled_accelerations(&self, ratio: f64) -> Machine {
        let mut machine = self.clone();
        machine.path.acceleration *= ratio;
        machine.axes.iter_mut().for_each(|axis| axis.acceleration *= ratio);
        machine
    }

    /// Returns the machine with the distance between arcs and their chords multiplied by `ratio`, such as one of
    /// [`CHORD_ERROR_RATIOS`]; unchanged if arcs have no chords.
    pub fn with_scaled_chords(&self, ratio: f64) -> Machine {
        let mut machine = self.clone();
        match &mut machine.interpolator.arc_chords {
            ArcChords::Whole => {}
            ArcChords::Within(distance) => *distance *= ratio,
            // A chord within the distance e of an arc of radius r is √(8 r e) long.
            ArcChords::Long(length) => *length *= ratio.sqrt(),
        }
        machine
    }

    /// Returns the machine with the value of its junction law multiplied by `ratio`; for blends the value is
    /// the contour tolerance.
    pub fn with_scaled_junction(&self, ratio: f64) -> Machine {
        let mut machine = self.clone();
        match &mut machine.interpolator.junction {
            Junction::Deviation(value) | Junction::SquareCorner(value) | Junction::AxisStep(value) => {
                *value *= ratio
            }
            Junction::Tolerance
            | Junction::AccelerationBlend
            | Junction::ParabolicBlend
            | Junction::ExactPath => machine.interpolator.contour_tolerance *= ratio,
        }
        machine
    }
}
