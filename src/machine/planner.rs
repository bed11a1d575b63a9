//! Machines without filters: planners that ramp by an acceleration.

use crate::machine::{Junction, Machine, TimeConstants};

/// The filter that is left to a planner, s: half a servo period, which rounds nothing.
pub const PLANNER_FILTER_S: f64 = 5e-4;

/// A machine file has a constant with few digits.
const FEW_DIGITS: f64 = 0.999;

impl Machine {
    /// Returns `true` if its ramps are those of filters. Planners have some that are shorter than their period.
    pub fn has_filters(&self) -> bool {
        let interpolator = &self.interpolator;
        match (interpolator.junction, &interpolator.time_constants) {
            (Junction::AccelerationBlend, _) => false,
            (Junction::AxisStep(_), TimeConstants::Equal(constant)) => {
                PLANNER_FILTER_S < interpolator.filters as f64 * constant * FEW_DIGITS
            }
            _ => true,
        }
    }

    /// Makes the machine one whose planner ramps in trapezoids and blends corners at the acceleration of its axes, all of
    /// them with this acceleration (mm/s²) or their own lower one. `by_axis` each axis is as fast as the rapid feed, or
    /// else the path is.
    pub fn become_planner(&mut self, acceleration: f64, by_axis: bool) {
        self.interpolator.junction = Junction::AccelerationBlend;
        self.interpolator.filters = 1;
        self.interpolator.time_constants = TimeConstants::Equal(PLANNER_FILTER_S);
        self.rapid.time_constants = Some(TimeConstants::Equal(PLANNER_FILTER_S));
        for axis in &mut self.axes {
            axis.acceleration = axis.acceleration.min(acceleration);
            if by_axis {
                axis.velocity = axis.velocity.min(self.rapid.feedrate);
            }
        }
        if by_axis {
            self.rapid.feedrate *= 3f64.sqrt();
        }
    }
}
