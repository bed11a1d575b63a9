//! Machines without filters: planners that ramp by an acceleration.

use crate::machine::{ArcChords, Junction, Machine, TimeConstants};

/// The filter that is left to a planner, s: half a servo period, which rounds nothing.
pub const PLANNER_FILTER_S: f64 = 5e-4;

/// A machine file has a constant with few digits.
const FEW_DIGITS: f64 = 0.999;

/// A family of controls whose planner ramps in trapezoids, by its law of corners.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Planner {
    /// Axes are limited in acceleration, and corners are blended at it, as in LinuxCNC.
    AccelerationBlend,
    /// Axes are limited in acceleration, and corners passed by a junction deviation, as in grbl.
    JunctionDeviation,
    /// The path is limited in acceleration, and corners passed by a square-corner velocity, as in Klipper.
    SquareCorner,
}

/// Junction deviation, mm, distance of the chords of arcs, mm, and blocks planned ahead that grbl has unless it is told
/// otherwise.
const GRBL: (f64, f64, f64) = (0.01, 0.002, 15.0);
/// Square-corner velocity, mm/s, chords of arcs, mm, and minimum cruise ratio that Klipper has unless it is told otherwise.
const KLIPPER: (f64, f64, f64) = (5.0, 0.1, 0.5);

impl Planner {
    /// All families.
    pub const ALL: [Planner; 3] =
        [Planner::AccelerationBlend, Planner::JunctionDeviation, Planner::SquareCorner];
}

impl Machine {
    /// Returns `true` if its ramps are those of filters. Planners have some that are shorter than their period.
    pub fn has_filters(&self) -> bool {
        let interpolator = &self.interpolator;
        match (interpolator.junction, &interpolator.time_constants) {
            (Junction::AccelerationBlend, _) => false,
            (Junction::Tolerance, _) => true,
            (_, TimeConstants::Equal(constant)) => {
                PLANNER_FILTER_S < interpolator.filters as f64 * constant * FEW_DIGITS
            }
            _ => true,
        }
    }

    /// Makes the machine one of a family of planners, with this acceleration (mm/s²) of what the family limits, or the lower
    /// one that it has, and with what else controls of the family are delivered with.
    pub fn become_planner(&mut self, planner: Planner, acceleration: f64) {
        self.interpolator.filters = 1;
        self.interpolator.time_constants = TimeConstants::Equal(PLANNER_FILTER_S);
        // The planners of grbl and Klipper plan rapids and feed moves as one; the others stop between them.
        let stops = planner == Planner::AccelerationBlend;
        self.rapid.time_constants = stops.then_some(TimeConstants::Equal(PLANNER_FILTER_S));
        let limit = |own: &mut f64| *own = own.min(acceleration);
        match planner {
            Planner::AccelerationBlend => {
                self.interpolator.junction = Junction::AccelerationBlend;
                self.axes.iter_mut().for_each(|axis| limit(&mut axis.acceleration));
            }
            Planner::JunctionDeviation => {
                self.interpolator.junction = Junction::Deviation(GRBL.0);
                self.interpolator.arc_chords = ArcChords::Within(GRBL.1);
                self.interpolator.look_ahead = self.interpolator.look_ahead.min(GRBL.2);
                self.axes.iter_mut().for_each(|axis| limit(&mut axis.acceleration));
            }
            Planner::SquareCorner => {
                self.interpolator.junction = Junction::SquareCorner(KLIPPER.0);
                self.interpolator.arc_chords = ArcChords::Long(KLIPPER.1);
                self.interpolator.minimum_cruise_ratio = KLIPPER.2;
                limit(&mut self.path.acceleration);
                limit(&mut self.axes[2].acceleration);
            }
        }
    }

    /// Returns the machine with so many times the value of its law of corners; of blends that is the contour tolerance.
    pub fn with_scaled_junction(&self, ratio: f64) -> Machine {
        let mut machine = self.clone();
        match &mut machine.interpolator.junction {
            Junction::Deviation(value) | Junction::SquareCorner(value) | Junction::AxisStep(value) => {
                *value *= ratio
            }
            Junction::Tolerance | Junction::AccelerationBlend => {
                machine.interpolator.contour_tolerance *= ratio
            }
        }
        machine
    }
}
